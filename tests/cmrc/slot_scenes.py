"""Tasks of DSPs that are joined by links or nets: their words in shared memory, and runs that must be the same."""

import json
import random
from collections.abc import Callable
from typing import Any

import cmrc
from locations import ROOT


def area_of(task: int) -> int:
    """Offset of the area of the n-th [[tasks]] in shared memory."""
    symbols = cmrc.c40.assemble_file(ROOT / "c40_programs" / "dsp.asm", entry="_start").symbols
    return int(symbols["US_BASE"] + task * symbols["US_WORDS"])


def without_time(report: dict[str, Any]) -> str:
    return json.dumps({key: value for key, value in report.items() if key != "elapsed_s"}, sort_keys=True)


def check_cuts_orders_and_snapshots(
    scene: Callable[[int], cmrc.Simulation], rng: random.Random, seed: int, end_s: float, action_s: float, cuts: int
) -> dict[str, Any]:
    """`scene` makes a run from the order of turns; something happens in it at `action_s`. The report of the run in one
    piece, which is also that of a run that is cut, and of one that a snapshot continues; another order has its hash."""
    whole: dict[str, Any] = scene(0).run().report
    cut = scene(0)
    for time in sorted(rng.uniform(0, end_s) for _ in range(cuts)):
        cut.run_until(time)
    assert without_time(cut.run().report) == without_time(whole)
    assert scene(seed + 1).run().report["hash"] == whole["hash"]
    first, second = scene(0), scene(0)
    first.run_until(rng.choice([action_s + 0.0005, rng.uniform(0.02, end_s)]))
    second.restore(first.snapshot())
    assert first._core.difference(second._core) is None
    assert without_time(second.run().report) == without_time(whole)
    return whole
