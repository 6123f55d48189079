"""Runs in which the controller has much to do, handed on from simulation to simulation at many instants
(docs/snapshots.md)."""

from __future__ import annotations

import random
from typing import Any

import dock_checks
import pytest
from cmrc import _core
from locations import AT_ONCE
from low_rates import AT_ONCE_AND_LOW

cmrc = _core.cmrc
REFRESH_HZ = 8000
ERRORS: list[dict[str, Any]] = [
    # Joints at rest take the changes at once, and once more later.
    *({"at_s": at_s, "action": "set", "key": f"control.{joint}_damping", "value": damping}
      for at_s, damping in ((0.2, 1.2), (0.5, 1.1)) for joint in ("travel", "slew", "luff", "hoist", "rotator")),
    {"at_s": 0.4, "action": "set", "key": "control.hoist_bandwidth_rad_s", "value": 30.0},
    {"at_s": 0.6, "action": "stick_sway", "axis": "beta"},
    {"at_s": 0.9, "action": "stick_encoder", "joint": "slew"},
    {"at_s": 1.0, "action": "set", "key": "scheduling.agv_interval_refreshes", "value": 200},
    {"at_s": 1.9, "action": "repair_encoder", "joint": "slew"},
    {"at_s": 2.1, "action": "set", "key": "errors.clear", "value": True},
    {"at_s": 2.3, "action": "set", "key": "control.luff_damping", "value": 1.2},
    {"at_s": 2.35, "action": "set", "key": "scheduling.alpha_refreshes", "value": 20},
    {"at_s": 2.6, "action": "fail_drive", "joint": "hoist"},
]  # fmt: skip


def outcome(simulation: Any) -> dict[str, Any]:
    report = dock_checks.without_the_clock(dock_checks.finite(simulation.report_json()))
    signals = {name: column.tobytes() for name, column in simulation.signals().items()}
    return {**report, "dock": simulation.dock_events(), "signals": signals}


def instants(draw: random.Random, count: int, duration_s: float) -> list[float]:
    """Half of the instants lie within the host's work on a refresh, which takes a few microseconds of each 125."""
    at = [draw.uniform(0, duration_s) for _ in range(count)]
    return sorted(t if n % 2 else int(t * REFRESH_HZ) / REFRESH_HZ + draw.uniform(0, 12e-6) for n, t in enumerate(at))


def handed_on(config: Any, cuts: list[float]) -> Any:
    simulation = cmrc.Simulation(config)
    for cut in cuts:
        simulation.run_until(cut)
        snapshot = simulation.snapshot()
        simulation = cmrc.Simulation(config)
        simulation.restore(snapshot)
        assert simulation.snapshot().state == snapshot.state, cut
    simulation.run()
    return simulation


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.campaign) for seed in range(1, 6))])
def test_errors_are_handled_as_in_one_run(seed: int) -> None:
    config = cmrc.config(
        settings={"dsps": 2, "duration_s": 3.0, "report.reference": "none", "agvs": 2, **AT_ONCE}, events=ERRORS
    )
    whole = cmrc.Simulation(config)
    whole.run()
    expected = outcome(whole)
    assert len(expected["errors_handled"]) >= 3 and any(
        error["cleared_s"] is not None for error in expected["errors_handled"]
    )
    draw = random.Random(seed)
    anywhere, per_event = (60, 3) if seed else (20, 2)
    after = [
        event["at_s"] + draw.choice([2e-4, 3e-3, 0.1]) * draw.random() for event in ERRORS for _ in range(per_event)
    ]  # while it takes effect
    parts = handed_on(config, sorted([*instants(draw, anywhere, 3.0), *after]))
    assert dock_checks.differences(expected, outcome(parts)) == []


def test_changes_of_the_loops_wait_for_rest_in_whatever_simulation() -> None:
    """The first leg lasts from 0.05 to 18 s. Changes that are requested on the way take effect at its end; later
    requests build on them."""
    settings = {**AT_ONCE_AND_LOW, "report.signal_decimation": 32, "duration_s": 25.0}
    events = [{"at_s": at_s, "action": "set", "key": f"control.{key}", "value": value} for at_s, key, value in
              [(3.0, "slew_bandwidth_rad_s", 20.0), (3.5, "hoist_bandwidth_rad_s", 30.0), (21.5, "slew_damping", 1.2), (23.0, "hoist_damping", 1.1)]]  # fmt: skip
    config = cmrc.config(settings=settings, events=events)
    whole = cmrc.Simulation(config)
    whole.run()
    draw = random.Random(1)
    cuts = sorted(
        [
            2.0,
            4.0,
            12.0,
            22.0,
            24.0,
            *(draw.uniform(15.0, 25.0) for _ in range(12)),
            *(at + 3e-3 * draw.random() for at in (21.5, 23.0) for _ in range(4)),
        ]
    )
    assert dock_checks.differences(outcome(whole), outcome(handed_on(config, cuts))) == []


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.campaign) for seed in range(1, 4))])
def test_a_busy_host_is_handed_on_in_the_middle_of_its_refreshes(seed: int) -> None:
    """Boards fail and hang, so the host puts blocks back and gives blocks up, while the semaphore, the doorbells and
    the boot are under way."""
    events = [
        {"at_s": 0.03 + 0.011 * n, "action": action, "dsp": n % 3}
        for n, action in enumerate(["hang", "fail", "reset", "hang", "reset", "hang"])
    ]
    config = cmrc.config(
        preset="heavy", settings={"dsps": 3, "duration_s": 0.12, "report.reference": "none", "agvs": 3}, events=events
    )
    whole = cmrc.Simulation(config)
    whole.run()
    expected, draw = outcome(whole), random.Random(seed)
    # The host works on a failure for a few microseconds before it reports the failure.
    before = [failure["time_s"] - draw.uniform(0, 8e-6) for failure in expected["failures"] for _ in range(4)]
    assert {failure["kind"] for failure in expected["failures"]} >= {"dropped block", "watchdog"}
    cuts = sorted([*instants(draw, 80 if seed else 40, 0.12), *before])
    assert dock_checks.differences(expected, outcome(handed_on(config, cuts))) == []


@pytest.mark.campaign
def test_a_container_is_delivered_as_in_one_run() -> None:
    """130 s, against its ideal run: landings, locks, cycles and what is learned from them."""
    config = cmrc.config(
        settings={"dsps": 4, "duration_s": 130.0, "scheduling.learning": "proportional", "wind_mean_m_s": 5.0}
    )
    whole = cmrc.Simulation(config)
    whole.run()
    expected = outcome(whole)
    assert expected["containers_delivered"] >= 1
    cuts = [*instants(random.Random(1), 20, 60.0), *(60 + t for t in instants(random.Random(2), 40, 68.0))]
    found = outcome(handed_on(config, cuts))
    for report in (expected, found):
        report["errors"].pop("reference_elapsed_s", None)
    assert dock_checks.differences(expected, found) == []
