"""What a sweep costs beside its runs (docs/sweeps.md, Speed). Wall-clock times want a quiet machine with two
processors.

`PYTHONPATH=build/python python scripts/sweep_overhead.py [RUNS]`: so many runs (default 200) of 1 s simulated, in two
plain processes and as a sweep on two workers, one after the other. Prints wall-clock and processor times of both."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cmrc
import psutil
from cmrc.sweeps import Status

PLAIN = """
import sys, cmrc
for seed in map(int, sys.argv[1:]):
    cmrc.Simulation(duration_s=1.0, seed=seed)._core.run()
"""


def plain(runs: int) -> tuple[float, float]:
    """Wall-clock and processor time of two processes that share the seeds."""
    began = time.monotonic()
    halves = [range(first, runs + 1, 2) for first in (1, 2)]
    processes = [subprocess.Popen([sys.executable, "-c", PLAIN, *map(str, half)]) for half in halves]
    if any(list(map(subprocess.Popen.wait, processes))):
        sys.exit("a plain run has failed")
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.monotonic() - began, used.ru_utime + used.ru_stime


def swept(runs: int) -> tuple[float, float]:
    """The same of the sweep: of this process and of all that it has started, just before they end."""
    used = 0.0

    def look(status: Status) -> None:
        nonlocal used
        if status.done < status.runs:
            return
        me = psutil.Process(os.getpid())
        own = me.cpu_times()
        used = own.user + own.system - before
        for child in me.children(recursive=True):
            times = child.cpu_times()
            used += times.user + times.system + times.children_user + times.children_system

    with tempfile.TemporaryDirectory() as folder:
        began, own = time.monotonic(), psutil.Process(os.getpid()).cpu_times()
        before = own.user + own.system
        grid = {"fixed": {"duration_s": 1.0}, "repeats": {"seeds": runs}}
        found = cmrc.sweep(grid, Path(folder) / "s", workers=2, on_progress=look)
        if found.counts()["done"] != runs:
            sys.exit("a run of the sweep has failed")
        return time.monotonic() - began, used


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    for name, (wall, used) in (("two plain processes", plain(count)), ("a sweep on two workers", swept(count))):
        print(f"{count} runs, {name}: {wall:.1f} s, {used:.1f} s of processors", flush=True)
