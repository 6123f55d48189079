"""Simulation testing: random docks in which everything may go wrong, run in several ways (docs/trust.md).

One that fails is printed as small as it still fails. The suite runs 200 docks, 60 ms each: in 60 ms the host starts,
the servo ticks for 40 ms or more, and every failure and every watchdog can come. A quarter of the first 40 run by the
command, too. `scripts/campaign docks` runs ten thousand of up to 1 s.
"""

from __future__ import annotations

import copy
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import dock_checks
import pytest
import random_docks
from random_docks import Dock, Generator

SEEDS, BY_COMMAND, PER_TEST = 200, 40, 10


@pytest.mark.parametrize("first", range(0, SEEDS, PER_TEST))
def test_whatever_happens_in_a_dock_its_accounts_hold_and_it_is_one_run(
    first: int, programs: Path, tmp_path: Path
) -> None:
    for seed in range(first, first + PER_TEST):
        dock = Generator(seed, programs, longest_s=0.06).dock()
        by_command = seed < BY_COMMAND and seed % 4 == 0
        faults = partial(dock_checks.faults_of, seed=seed, scratch=tmp_path, by_command=by_command)
        if found := faults(dock):
            small = random_docks.shrink(dock, lambda one, faults=faults: bool(faults(one)))  # type: ignore[misc]
            pytest.fail(f"seed {seed}: {found[:3]}\n{small}")


def test_an_ideal_run_is_one_run_too(programs: Path, tmp_path: Path) -> None:
    """Where accesses take no time, with the boards, buses and tasks of any dock. Events would mostly not happen."""
    for seed in range(500, 504):
        dock = Generator(seed, programs, longest_s=0.06).dock()
        ideal = replace(dock, settings={**dock.settings, "run.ideal": True}, events=())
        assert random_docks.holds(ideal)
        assert dock_checks.faults_of(ideal, seed, tmp_path) == []


DOCK = Dock(
    None,
    {
        "machine.dsps": 2,
        "run.duration_s": 0.05,
        "report.reference": "none",
        "machine.boot": "preloaded",
        "host.start_ms": 0,
    },
)


@pytest.fixture(scope="module")
def sound() -> dict[str, Any]:
    report = dock_checks.finite(dock_checks.uncut(DOCK.config()).report_json())
    assert dock_checks.broken(report, DOCK, DOCK.config()) == []
    return report


@pytest.mark.parametrize(
    ("place", "by"),
    [
        (("tasks", "pid", "on_time"), 1),
        (("tasks", "pid", "released"), -1),
        (("tasks", "pid", "late"), 1),
        (("tasks", "pid", "misses"), 1),
        (("tasks", "pid", "response_ps", "count"), -1),
        (("tasks", "pid", "response_ps", "p99"), 10**9),
        (("tasks", "torque_compensation", "why_late", "lateness_ps"), 1),
        (("dsps", 0, "cycles"), 1),
        (("dsps", 1, "causes", "idle"), -1),
        (("buses", "A", "clocks"), 1),
        (("buses", "A", "targets", "shared memory", "words_read"), 1),
        (("buses", "B", "masters", "DSP 0", "words_written"), -1),
        (("simulated_s",), 0.01),
        (("account_end_s",), 1.0),
    ],
)
def test_the_checks_notice_an_account_that_is_wrong_by_one(
    sound: dict[str, Any], place: tuple[str | int, ...], by: float
) -> None:
    report: Any = copy.deepcopy(sound)
    node = report
    for step in place[:-1]:
        node = node[step]
    node[place[-1]] += by
    assert dock_checks.broken(report, DOCK, DOCK.config()) != []
    assert dock_checks.differences(sound, report) != []


def test_a_dock_is_drawn_by_its_seed_alone(programs: Path) -> None:
    assert [Generator(seed, programs).dock() for seed in range(5)] == [
        Generator(seed, programs).dock() for seed in range(5)
    ]


def test_what_is_drawn_reaches_every_failure_and_most_keys(programs: Path) -> None:
    """The draw itself: without asking the emulator what it takes, which would cost a minute."""
    drawn = Generator(0, programs)
    dock = replace(DOCK, settings={**DOCK.settings, "machine.slots": 4})
    assert {drawn.event(dock)["action"] for _ in range(2000)} == {action["name"] for action in random_docks.ACTIONS}
    keys = {name for _ in range(5000) for name in drawn.setting(dock).settings}
    drawable = [
        name
        for name, key in random_docks.KEYS.items()
        if key["type"] != "string" and not name.startswith(random_docks.APART)
    ]
    assert keys >= set(drawable) and len(drawable) > 400


def test_a_failing_dock_is_made_small(programs: Path) -> None:
    dock = Generator(28, programs).dock()
    assert len(dock.events) > 3 and len(dock.settings) > 8
    action = dock.events[1]["action"]
    small = random_docks.shrink(dock, lambda one: any(event["action"] == action for event in one.events))
    assert len(small.events) == 1 and small.tables == () and small.preset is None and len(small.settings) <= 4
