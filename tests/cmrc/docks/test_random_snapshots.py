"""Random docks that stop at random picoseconds and continue elsewhere: in a new simulation, and in another process
(docs/snapshots.md).

The suite runs the first 4 docks, 60 ms each; `pytest -m campaign` runs 36 more.
"""

from __future__ import annotations

import os
import random
import subprocess
import sys
from pathlib import Path
from typing import Any

import dock_checks
import pytest
import random_docks
from cmrc import _core
from locations import BUILD
from random_docks import Dock, Generator

cmrc = _core.cmrc
SEEDS, IN_SUITE, PER_TEST = 40, 4, 4
Report = dict[str, Any]


def outcome(simulation: Any) -> Report:
    report = dock_checks.without_the_clock(dock_checks.finite(simulation.report_json()))
    report["dock"] = simulation.dock_events()
    return report


def cut_until(simulation: Any, instant: float, draw: random.Random) -> None:
    for earlier in sorted(draw.uniform(simulation.time_s, instant) for _ in range(draw.randrange(8))):
        simulation.run_until(earlier)
    simulation.run_until(instant)


def faults_of(dock: Dock, seed: int) -> list[str]:
    """Where a run in four parts, each in a new simulation after another turn order and other cuts, differs from the
    whole."""
    draw = random.Random(seed)
    whole = cmrc.Simulation(dock.config())
    try:
        whole.run()
    except (
        RuntimeError
    ):  # a plant that cannot be integrated (docs/plant.md); test_random_docks.py looks at what it says
        return []
    straight, part = (
        cmrc.Simulation(dock.config()),
        cmrc.Simulation(dock.config(**{"run.turn_order": draw.randrange(1 << 30)})),
    )
    for instant in sorted(draw.randrange(int(dock.duration_s * 1e12)) * 1e-12 for _ in range(3)):
        straight.run_until(instant)
        cut_until(part, instant, draw)
        if (difference := part.difference(straight)) is not None:
            return [f"at {instant} s, after other cuts and in another turn order: {difference}"]
        snapshot = cmrc.Snapshot.from_bytes(part.snapshot().to_bytes())
        part = cmrc.Simulation(dock.config(**{"run.turn_order": draw.randrange(1 << 30)}))
        part.restore(snapshot)
        if (difference := part.difference(straight)) is not None:
            return [f"at {instant} s, loaded: {difference}"]
        if part.snapshot().state != snapshot.state:
            return [f"at {instant} s, loaded: another state without a difference"]
    last = cmrc.Simulation(dock.config())
    last.restore(part.snapshot())
    last.run(), straight.run()
    found = [f"resumed: {one}" for one in dock_checks.differences(outcome(whole), outcome(last))]
    return found + [f"looked at: {one}" for one in dock_checks.differences(outcome(whole), outcome(straight))]


@pytest.mark.parametrize(
    "first",
    [
        pytest.param(first, marks=[] if first < IN_SUITE else [pytest.mark.campaign])
        for first in range(0, SEEDS, PER_TEST)
    ],
)
def test_a_random_dock_continues_from_any_instant(first: int, programs: Path) -> None:
    for seed in range(first, first + PER_TEST):
        dock = Generator(seed, programs, longest_s=0.06).dock()
        found = faults_of(dock, seed)
        if found:
            small = random_docks.shrink(dock, lambda one, seed=seed: bool(faults_of(one, seed)))  # type: ignore[misc]
            pytest.fail(f"seed {seed}: {found[:3]}\n{small}")


ELSEWHERE = """
import sys
from cmrc import _core
run = _core.cmrc.Simulation(_core.cmrc.config(toml=open(sys.argv[1]).read()))
run.restore(_core.cmrc.Snapshot.from_bytes(open(sys.argv[2], "rb").read()))
run.run()
print(run.report_json())
"""


@pytest.mark.parametrize("seed", range(1000, 1002))
def test_a_random_dock_continues_in_another_process(seed: int, programs: Path, tmp_path: Path) -> None:
    draw = random.Random(seed)
    dock = Generator(seed, programs, longest_s=0.06).dock()
    whole, first = cmrc.Simulation(dock.config()), cmrc.Simulation(dock.config())
    whole.run()
    first.run_until(draw.randrange(int(dock.duration_s * 1e12)) * 1e-12)
    snapshot = first.snapshot()
    (tmp_path / "toml").write_text(snapshot.configuration)
    (tmp_path / "snap").write_bytes(snapshot.to_bytes())
    done = subprocess.run(
        [sys.executable, "-c", ELSEWHERE, "toml", "snap"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(BUILD / "python")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    resumed = dock_checks.without_the_clock(dock_checks.finite(done.stdout))
    assert (
        dock_checks.differences(dock_checks.without_the_clock(dock_checks.finite(whole.report_json())), resumed) == []
    )
