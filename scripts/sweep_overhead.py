"""What a sweep costs beside its runs (docs/sweeps.md, Speed).

`PYTHONPATH=build/python python scripts/sweep_overhead.py [RUNS]`: so many runs (default 200) of 1 s simulated, in two
plain processes and as a sweep on two workers, one after the other. Both make the same runs and keep the same reports,
packed, in files. Prints wall-clock time, and processor time of all processes from their start to their end, and the
share of the plain processes in the sweep's. Wall-clock times want a quiet machine with two processors."""

from __future__ import annotations

import ctypes
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

PLAIN = """
import sys, cmrc
from cmrc.sweeps.store import packed
with open(sys.argv[1], "wb") as out:
    for seed in map(int, sys.argv[2:]):
        simulation = cmrc.Simulation(duration_s=1.0, seed=seed)._core
        simulation.run()
        out.write(packed(simulation.report_json()))
"""
SWEEP = """
import sys, cmrc
grid = {"fixed": {"duration_s": 1.0}, "repeats": {"seeds": int(sys.argv[2])}}
if cmrc.sweep(grid, sys.argv[1], workers=2).counts()["done"] != int(sys.argv[2]):
    sys.exit("a run of the sweep has failed")
"""
PR_SET_CHILD_SUBREAPER = 36


def measured(commands: Sequence[Sequence[str]]) -> tuple[float, float]:
    """Wall-clock and processor time of commands side by side, with all processes that they start."""
    began, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    processes = [subprocess.Popen([sys.executable, "-c", *command]) for command in commands]
    if sum(process.wait() != 0 for process in processes):
        sys.exit("a command has failed")
    wall = time.monotonic() - began
    while True:  # workers whose parent has ended are this process's now
        try:
            os.wait()
        except ChildProcessError:
            break
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    with tempfile.TemporaryDirectory() as folder:
        halves = [[PLAIN, str(Path(folder) / f"{n}"), *map(str, range(n, runs + 1, 2))] for n in (1, 2)]
        plain = measured(halves)
        sweep = measured([[SWEEP, str(Path(folder) / "sweep"), str(runs)]])
    for name, (wall, used) in (("two plain processes", plain), ("a sweep on two workers", sweep)):
        print(f"{runs} runs, {name}: {wall:.1f} s, {used:.1f} s of processors")
    print(f"plain / sweep: {plain[0] / sweep[0]:.3f} of the time, {plain[1] / sweep[1]:.3f} of the processors' time")


if __name__ == "__main__":
    main()
