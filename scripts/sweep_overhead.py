"""What a sweep costs beside its runs (docs/sweeps.md, Speed). Wants a quiet machine with two processors.

`PYTHONPATH=build/python python scripts/sweep_overhead.py [RUNS]`: so many runs (default 200) of 1 s simulated, in two plain
processes and as a sweep on two workers, one after the other. Prints both times and the share of the workers' time that went
into runs.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cmrc

PLAIN = """
import sys, cmrc
for seed in map(int, sys.argv[1:]):
    cmrc.Simulation(duration_s=1.0, seed=seed)._core.run()
"""


def plain(runs: int) -> float:
    """Wall-clock time of two processes that share the seeds."""
    began = time.monotonic()
    halves = [range(first, runs + 1, 2) for first in (1, 2)]
    processes = [subprocess.Popen([sys.executable, "-c", PLAIN, *map(str, half)]) for half in halves]
    if any(list(map(subprocess.Popen.wait, processes))):
        sys.exit("a plain run has failed")
    return time.monotonic() - began


def swept(runs: int) -> tuple[float, float]:
    """Wall-clock time of the same runs as a sweep, and what the runs took by themselves."""
    with tempfile.TemporaryDirectory() as folder:
        began = time.monotonic()
        found = cmrc.sweep({"fixed": {"duration_s": 1.0}, "repeats": {"seeds": runs}}, Path(folder) / "s", workers=2)
        spent = time.monotonic() - began
        if found.counts()["done"] != runs:
            sys.exit("a run of the sweep has failed")
        return spent, sum(run["elapsed_s"] for run in found.runs)


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    alone = plain(count)
    together, in_runs = swept(count)
    print(f"{count} runs: {alone:.1f} s in two plain processes, {together:.1f} s as a sweep ({together / alone:.3f} of it); "
          f"{100 * in_runs / (2 * together):.1f} % of the workers' time was spent in runs")
