"""The servo's loops in the scene: the value of deadlines with tight loops, changes during a run, and settings that
cannot work."""

from __future__ import annotations

import math
from typing import Any

import cmrc
import numpy as np
import pytest
from cmrc import _core
from low_rates import AT_ONCE_AND_LOW

SECONDS = 5.0
EXPERIMENT = {"report.misses_max": 0, "report.reference": "none"}


def tight(**settings: Any) -> cmrc.Result:
    given = {**EXPERIMENT, **{key.replace("__", "."): value for key, value in settings.items()}}
    return cmrc.run(dsps=2, preset="tight", duration_s=SECONDS, settings=given)


def unstable(result: cmrc.Result) -> set[str]:
    """Joints whose loops the report calls unstable."""
    said = [f["message"] for f in result.report["failures"] if f["kind"] == "unstable"]
    return {message.removeprefix("the loop of joint ").split()[0] for message in said}


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"dock__drive_delay_us": 2000.0},
        {"scheduling__servo_served_every": 2},
        {"scheduling__servo_loss_share": 0.3},
    ],
    ids=["in time", "two periods of delay", "every second sample", "30 % missed"],
)
def test_tight_loops_bear(settings: dict[str, Any]) -> None:
    assert unstable(tight(**settings)) == set()


@pytest.mark.parametrize(
    ("settings", "joint"),
    [
        ({"dock__drive_delay_us": 4000.0}, "l"),
        ({"scheduling__servo_served_every": 5}, "kappa"),
        ({"scheduling__servo_loss_share": 0.8}, "phi"),
    ],
    ids=["four periods of delay", "every fifth sample", "80 % missed"],
)
def test_tight_loops_do_not_bear(settings: dict[str, Any], joint: str) -> None:
    result = tight(**settings)
    assert joint in unstable(result)
    # What the report says is what the drive did: its codes were at both ends of their range. Its own protection ends
    # that.
    codes = result.signals[f"{joint}_code"]
    assert codes.max() >= 1638 and codes.min() <= -1638
    assert any(f["kind"] == "plant" and "trip" in f["message"] for f in result.report["failures"])


def test_of_two_loops_that_become_unstable_in_one_latch_both_are_reported() -> None:
    settings = {
        **EXPERIMENT,
        "report.signal_decimation": 1,
        "scheduling.servo_loss_share": 0.8,
        "control.slew_bandwidth_rad_s": 80.0,
        "control.hoist_bandwidth_rad_s": 80.0,
    }
    result = cmrc.run(dsps=2, duration_s=0.35, settings=settings)

    def sixth_swing(joint: str) -> float:
        codes, time = result.signals[f"{joint}_code"], result.signals["time_s"]
        far = np.abs(codes) >= 1638
        sides = np.sign(codes[far])
        return float(time[far][1:][np.diff(sides) != 0][5])

    assert sixth_swing("psi") == sixth_swing("l")
    assert unstable(result) == {"psi", "l"}


def test_the_default_loops_bear_what_tight_ones_do_not() -> None:
    result = cmrc.run(dsps=2, duration_s=SECONDS, settings={**EXPERIMENT, "dock.drive_delay_us": 4000.0})
    assert unstable(result) == set()


def test_a_hoist_with_70_percent_misses_is_three_times_as_far_off_as_with_30() -> None:
    off, reference = [], None
    for share in (0.3, 0.7):
        simulation = cmrc.Simulation(
            dsps=2,
            preset="tight",
            duration_s=6.0,
            settings={"report.misses_max": 0, "scheduling.servo_loss_share": share},
            reference=reference,
        )
        off.append(simulation.run().errors["joints"]["l"]["path"]["rms"])
        reference = simulation.reference()
    assert off[1] >= 3 * off[0] > 0


@pytest.mark.parametrize(
    ("settings", "share", "run"),
    [
        ({"scheduling__servo_served_every": 4}, 0.75, 3),
        ({"scheduling__servo_loss_share": 0.5}, 0.5, 0),
        ({"scheduling__servo_loss_share": 0.5, "scheduling__servo_loss_run": 7}, 0.5, 7),
    ],
)
def test_left_out_ticks_are_dropped_ones(settings: dict[str, Any], share: float, run: int) -> None:
    given = {**{k.replace("__", "."): v for k, v in settings.items()}, "report.reference": "none"}
    results = [cmrc.run(dsps=dsps, duration_s=2.0, settings=given) for dsps in (2, 3)]
    lost = [sorted(m["number"] for m in result.report["misses"] if m["kind"] == "pid") for result in results]
    assert lost[0] == lost[1]  # the same ticks on every machine
    task = results[0].report["tasks"]["pid"]
    assert task["why_late"]["dropped_left_out"] == task["dropped"]
    assert task["dropped"] == task["misses"] and task["dropped"] / task["released"] == pytest.approx(share, abs=0.05)
    if run:
        breaks = np.flatnonzero(np.diff(lost[0]) != 1)
        lengths = np.diff(breaks)[:-1]
        assert np.all(lengths % run == 0)


def test_a_delay_shifts_what_the_drives_take() -> None:
    """The codes at the latches, compared with the same run without delay: the first codes are equal, later by the
    delay."""
    codes = []
    for delay in (0.0, 1000.0):
        settings = {"report.reference": "none", "report.signal_decimation": 1, "dock.drive_delay_us": delay}
        signals = cmrc.run(dsps=1, duration_s=0.1, settings=settings).signals
        codes.append(signals["phi_code"])
    first = [int(np.flatnonzero(c)[0]) for c in codes]
    assert first[1] - first[0] == 8
    assert codes[1][first[1] : first[1] + 8].tolist() == codes[0][first[0] : first[0] + 8].tolist()


# ---- changes while a run is on


def change(at_s: float, key: str, value: float) -> dict[str, Any]:
    return {"at_s": at_s, "action": "set", "key": key, "value": value}


RATES: dict[str, Any] = {**AT_ONCE_AND_LOW, "report.signal_decimation": 32}


def test_a_change_waits_for_rest_and_moves_nothing() -> None:
    """During the first leg (0.05 to 18 s), lower bandwidths of slew and hoist are set. The change takes effect when the
    joints rest."""
    events = [
        change(3.0, "control.slew_bandwidth_rad_s", 20.0),
        change(3.0, "control.hoist_bandwidth_rad_s", 30.0),
        change(3.5, "control.hoist_feed_forward", 0.6),
    ]
    simulation = _core.cmrc.Simulation(_core.cmrc.config(settings={**RATES, "duration_s": 24.0}, events=events))
    symbol = simulation.symbol
    area = symbol("CR_BASE")

    def words() -> tuple[int, list[int]]:
        block = area + symbol("CR_CONTROL_BLOCK")
        return simulation.peek(area + symbol("CR_CONTROL")), [
            simulation.peek(block + k) for k in range(symbol("CR_CONTROL_WORDS"))
        ]

    simulation.run_until(2.9)
    before = words()
    assert before[0] == 1
    simulation.run_until(15.0)
    assert words() == before  # both joints still move
    time = 15.0
    while words()[0] == 1:
        time += 0.004
        simulation.run_until(time)
        assert time < 21.0
    row = symbol("PC_ROW")
    changed = {k // row for k, (a, b) in enumerate(zip(before[1], words()[1], strict=True)) if a != b and k < 5 * row}
    assert changed and changed <= {1, 3}
    simulation.run_until(24.0)
    after = words()[1]
    for joint, factor in ((1, (20 / 40) ** 2), (3, (30 / 40) ** 2)):
        old, new = (
            float(_core.c40.float40.value(_core.c40.float40.from_single(w[joint * row]))) for w in (before[1], after)
        )
        assert new == pytest.approx(factor * old, rel=1e-6)
    # No drive jumps: from 15 s until the ramp begins no code of a tick differs from the one before by more than it does
    # without the change.
    signals = simulation.signals()
    plain = _core.cmrc.Simulation(_core.cmrc.config(settings={**RATES, "duration_s": 24.0}))
    plain.run()
    window = (signals["time_s"] > 15.0) & (signals["time_s"] < time + 0.5)
    for joint in ("psi", "l"):
        jumps = [np.abs(np.diff(each[f"{joint}_code"][window])).max() for each in (signals, plain.signals())]
        assert jumps[0] <= jumps[1] + 10, joint
    # 40 % less of a hoist's feed-forward that holds the spreader would be 40 % of its holding torque.
    assert 0.4 * np.abs(signals["l_code"][window]).mean() > 50


def test_unknown_or_wild_values_are_refused_before_a_run() -> None:
    cases: list[tuple[dict[str, Any], str]] = [
        ({"control.hoist_bandwidth_rad_s": math.nan}, "control.hoist_bandwidth_rad_s: nan"),
        ({"control.hoist_bandwidth_rad_s": 1e9}, "from 0.5 to 200"),
        ({"control.travel_bandwidth_rad_s": 20.0}, "from 0.5 to 6"),
        (
            {"control.slew_bandwidth_rad_s": 80.0, "rates.servo_frequency_hz": 125.0},
            r"control.slew_bandwidth_rad_s: the slew's loop is unstable without any delay",
        ),
        ({"control.luff_integral_time_s": 0.01}, r"the luff's loop is unstable without any delay"),
        ({"control.hoist_speed_limit_m_s": 3.0}, r"control.hoist_speed_limit_m_s: 3 is above the drive's rated speed"),
        ({"control.hoist_speed_limit_m_s": 0.2}, "dock.ramp_speed_m_s"),
        ({"dock.drive_delay_us": 100.0}, "a multiple of 125 us is expected"),
        ({"scheduling.servo_loss_share": 1.5}, "from 0 to 1"),
        ({"control.hoist_bandwidth": 40.0}, 'did you mean "control.hoist_bandwidth_rad_s"'),
    ]
    for settings, message in cases:
        with pytest.raises(_core.cmrc.ConfigError, match=message):
            cmrc.Simulation(dsps=1, duration_s=1.0, settings=settings)
    with pytest.raises(_core.cmrc.ConfigError, match="the hoist's loop is unstable"):
        cmrc.Simulation(dsps=1, duration_s=2.0, events=[change(1.0, "control.hoist_integral_time_s", 0.01)])
    with pytest.raises(_core.cmrc.ConfigError, match="<toml>:2:1: control.slew_damping: the slew's loop is unstable"):
        _core.cmrc.config(toml="[control]\nslew_damping = 5\n")


def test_the_bandwidth_that_a_message_names_would_do() -> None:
    with pytest.raises(_core.cmrc.ConfigError, match=r"below [0-9.]+ rad/s") as refused:
        cmrc.Simulation(
            dsps=1, duration_s=1.0, settings={"rates.servo_frequency_hz": 125.0, "control.hoist_bandwidth_rad_s": 150.0}
        )
    limit = float(str(refused.value).split("below ")[1].split(" ")[0])
    others = {f"control.{joint}_bandwidth_rad_s": 10.0 for joint in ("slew", "luff", "rotator")}
    for factor, right in ((0.99, True), (1.01, False)):
        settings = {"rates.servo_frequency_hz": 125.0, **others, "control.hoist_bandwidth_rad_s": limit * factor}
        if right:
            cmrc.Simulation(dsps=1, duration_s=1.0, settings=settings)
        else:
            with pytest.raises(_core.cmrc.ConfigError, match="unstable"):
                cmrc.Simulation(dsps=1, duration_s=1.0, settings=settings)
