"""Errors in the scene: each origin with each response that docs/controller.md lists for it, what the report says, and
the exit status (ruling 36)."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from audited_run import programs_with
from error_scenes import LEG, LOWERING, SERVO, STILL, at, clear, cmrc, load, only, rates, run
from low_rates import AT_ONCE_AND_LOW

# ---- stop along the path


def test_a_dead_luff_drive_stops_the_crane_along_its_path() -> None:
    report, simulation = run(8, at(LEG, "fail_drive", joint="luff"))
    error = only(report)
    assert (error["origin"], error["robot"], error["of"], error["response"]) == (
        "drive fault",
        "crane",
        ["luff"],
        "stop",
    )
    assert (error["happened_s"], error["because"]) == (LEG, "fail_drive luff")
    # PID sees the fault at its next tick, the host at the refresh after that. The error block takes one refresh more.
    assert LEG < error["noticed_s"] < LEG + 2 * SERVO
    assert error["noticed_s"] < error["decided_s"] < error["noticed_s"] + 2 * SERVO
    assert error["done_s"] == pytest.approx(error["decided_s"] + 1.0, abs=2 * SERVO)
    assert error["stands"] and error["cleared_s"] is None and simulation.exit_status == 1
    before, half, after = (rates(simulation, LEG + dt) for dt in (-0.05, 0.55, 1.3))
    assert after["phi"] == 0  # braked
    assert (
        0.3 * before["l"] < half["l"] < 0.8 * before["l"]
    )  # the hoist, which no sway damping moves; without the fault it would gain speed
    assert after["l"] < 0.02 * before["l"]
    assert not report["braked"]  # the others are held by the servo
    assert report["tasks"]["error"]["on_time"] == 1


def test_how_far_the_load_moved_is_the_plants_word() -> None:
    report, simulation = run(8, at(LEG, "fail_drive", joint="slew"))
    error = only(report)
    time, place = load(simulation)

    def where(t: float) -> np.ndarray:
        return np.array([np.interp(t, time, place[:, k]) for k in range(3)])

    start = where(error["happened_s"])
    assert error["moved_until_noticed_m"] == pytest.approx(np.linalg.norm(where(error["noticed_s"]) - start), abs=1e-9)
    assert error["moved_until_done_m"] == pytest.approx(np.linalg.norm(where(error["done_s"]) - start), abs=1e-9)
    most = max(np.linalg.norm(p - start) for t, p in zip(time, place, strict=True) if t >= error["happened_s"])
    assert error["moved_most_m"] == pytest.approx(most, rel=1e-3)
    assert error["moved_most_m"] > error["moved_until_done_m"] > 0.1


def test_a_load_that_swings_on_after_the_stop_has_moved_most_then() -> None:
    """What stands moves the load until the end of the run, not until the crane has stopped."""
    report, simulation = run(8, at(LEG, "fail_drive", joint="luff"), **{"errors.stop_s": 0.1})
    error = only(report)
    time, place = load(simulation)
    start = np.array([np.interp(error["happened_s"], time, place[:, k]) for k in range(3)])
    moved = np.linalg.norm(place - start, axis=1)
    most = moved[time >= error["happened_s"]].max()
    assert error["stands"] and error["moved_most_m"] == pytest.approx(most, rel=1e-3)
    assert most > 1.05 * moved[(time >= error["happened_s"]) & (time <= error["done_s"])].max()


def test_a_load_that_swings_on_without_any_dsp_has_moved_most_then() -> None:
    """The account ends 0.5 s after the last DSP has failed; the run continues for the plant alone."""
    events = [at(LEG, "fail", dsp=0), at(LEG + 0.5, "fail", dsp=1)]
    report, simulation = run(LEG + 4, *events, **{"dsps": 2, "report.signal_decimation": 1, "run.after_stop_s": 3.0})
    error = only(report)
    time, place = load(simulation)
    moved = np.linalg.norm(place - place[np.searchsorted(time, error["happened_s"])], axis=1)
    of_account = moved[(time >= error["happened_s"]) & (time <= report["account_end_s"])].max()
    assert report["stop_reason"] == "no_dsp_left" and error["stands"] and error["cleared_s"] is None
    assert error["moved_most_m"] == pytest.approx(moved[time >= error["happened_s"]].max(), rel=1e-3)
    assert error["moved_most_m"] > 2 * of_account


def test_a_repaired_and_cleared_drive_continues_and_the_status_is_0_but_not_with_strict() -> None:
    events = [at(LEG, "fail_drive", joint="luff"), at(6, "repair_drive", joint="luff"), clear(8)]
    report, simulation = run(14, *events)
    error = only(report)
    assert error["cleared_s"] == pytest.approx(8, abs=0.001) and not error["stands"] and simulation.exit_status == 0
    assert rates(simulation, 7.9)["phi"] == 0  # repaired, and off until the operator says so
    assert rates(simulation, 13.5)["phi"] > 2e-4 and rates(simulation, 13.5)["l"] > 0.02
    text = simulation.report_json_and_text()[1]
    assert "Errors: 1" in text and "cleared by the operator at 8.0" in text
    # The joint comes back smoothly: the drive never needs its full torque.
    assert np.abs(simulation.signals()["phi_code"][simulation.signals()["time_s"] > 8]).max() < 2047
    _, strict = run(
        8, at(LEG, "fail_drive", joint="luff"), at(3.5, "repair_drive", joint="luff"), clear(7), **{"run.strict": True}
    )
    assert strict.exit_status == 1


def test_an_error_that_is_cleared_before_it_is_decided_is_cleared_with_the_decision() -> None:
    fails = at(LEG, "fail_drive", joint="slew")
    first = only(run(LEG + 0.1, fails)[0])
    noticed, decided = first["noticed_s"], first["decided_s"]
    repaired = at(noticed, "repair_drive", joint="slew")
    report, simulation = run(LEG + 14, fails, repaired, clear((noticed + decided) / 2))
    error = only(report)
    assert (error["noticed_s"], error["decided_s"]) == (noticed, decided)
    assert error["cleared_s"] == decided and not error["stands"] and simulation.exit_status == 0
    assert rates(simulation, LEG + 13)["psi"] > 1e-3


def test_what_is_still_broken_stops_the_crane_again() -> None:
    report, simulation = run(8, at(LEG, "fail_drive", joint="luff"), clear(6))
    first, second = report["errors_handled"]
    assert first["cleared_s"] is not None and not first["stands"]
    assert (second["origin"], second["of"], second["response"], second["stands"]) == (
        "drive fault",
        ["luff"],
        "stop",
        True,
    )
    assert 6 < second["noticed_s"] < 6 + 3 * SERVO and simulation.exit_status == 1
    assert rates(simulation, 7.9)["l"] < 1e-3


@pytest.mark.parametrize(
    ("crane", "pid", "joint"),
    [
        ("gantry", "error_derivative", "trolley"),
        ("slewing", "measurement_derivative", "hoist"),
        ("gantry", "measurement_derivative", "hoist"),
    ],
)
def test_both_cranes_and_both_laws_do_it(crane: str, pid: str, joint: str) -> None:
    settings = {"dock.crane": crane, "kernels.pid": pid}
    report, simulation = run(5, at(LEG, "fail_drive", joint=joint), **settings)
    error = only(report)
    assert (error["origin"], error["of"], error["response"]) == ("drive fault", [joint], "stop")
    assert all(rate < 0.05 for name, rate in rates(simulation, 4.5).items() if name in ("l", "trolley"))
    encoder, _ = run(5, at(LEG, "stick_encoder", joint=joint), **settings)
    assert (only(encoder)["origin"], only(encoder)["of"]) == ("encoder", [joint])


def test_a_stuck_encoder_is_found_while_its_drive_turns_and_only_then() -> None:
    report, _ = run(4, at(1.0, "stick_encoder", joint="travel"))  # which does not move
    assert report["errors_handled"] == []
    report, simulation = run(6, at(LEG, "stick_encoder", joint="slew"))
    error = only(report)
    assert (error["origin"], error["of"], error["response"], error["because"]) == (
        "encoder",
        ["slew"],
        "stop",
        "stick_encoder slew",
    )
    assert LEG + 0.020 <= error["noticed_s"] < LEG + 0.020 + 3 * SERVO
    assert rates(simulation, 5.9)["psi"] == 0 and simulation.exit_status == 1  # its brake holds it


def test_a_lying_status_leaves_the_following_error_which_is_cleared() -> None:
    broken = [at(2.9, "stick_drive_status", joint="slew"), at(LEG, "fail_drive", joint="slew")]
    repaired = [at(5, "repair_drive", joint="slew"), at(5, "repair_drive_status", joint="slew"), clear(6)]
    report, simulation = run(9, *broken, *repaired, **{"errors.go_on_s": 2.0})
    error, trip = report["errors_handled"]
    assert (error["origin"], error["of"], error["response"], error["because"]) == (
        "following error",
        ["slew"],
        "stop",
        "fail_drive slew",
    )
    assert LEG + 0.05 < error["noticed_s"] < LEG + 0.5
    assert rates(simulation, error["done_s"] + 0.3)["l"] < STILL
    # After the repair the drive returns with full torque to the place at which the path has stopped, and trips after
    # half a second.
    assert (trip["origin"], trip["of"], trip["cleared_s"]) == ("drive saturated", ["slew"], error["cleared_s"])
    assert 5.5 < trip["noticed_s"] < 6
    assert error["cleared_s"] is not None and simulation.exit_status == 0 and rates(simulation, 8.9)["l"] > 0.05


def test_a_limit_of_ones_own_counts() -> None:
    broken = [at(2.9, "stick_drive_status", joint="slew"), at(LEG, "fail_drive", joint="slew")]
    noticed = [only(run(3.6, *broken, **{"errors.following_slew_mrad": mrad})[0])["noticed_s"] for mrad in (1.0, 5.0)]
    assert noticed[0] < noticed[1] - 0.02


def test_a_failure_that_was_repaired_before_an_error_began_is_not_its_cause() -> None:
    """The second error comes from a DSP that is too slow for the loop, long after the drive was repaired and its error
    cleared."""
    failed = [at(0.1, "fail_drive", joint="slew"), at(0.15, "repair_drive", joint="slew"), clear(0.4)]
    limits = {
        "errors.following_slew_mrad": 0.06,
        "errors.following_ms": 20,
        "errors.stop_s": 0.1,
        "errors.go_on_s": 0.2,
    }
    report, _ = run(2.6, *failed, at(1.5, "slow", dsp=0, factor=0.04), **limits)
    first, second = report["errors_handled"]
    assert (first["origin"], first["happened_s"], first["because"]) == ("drive fault", 0.1, "fail_drive slew")
    assert second["origin"] == "following error" and second["of"] == ["slew"] and second["noticed_s"] > 1.5
    assert (second["happened_s"], second["because"], second["moved_until_noticed_m"]) == (None, None, 0)


def test_a_drive_that_was_repaired_at_the_instant_of_its_failure_causes_nothing() -> None:
    failed = [at(0.1, "fail_drive", joint="slew"), at(0.1, "repair_drive", joint="slew")]
    limits = {"errors.following_slew_mrad": 0.01, "errors.following_ms": 20}
    report, _ = run(1.6, *failed, at(1.5, "slow", dsp=0, factor=0.04), **limits)
    error = only(report)
    assert (error["origin"], error["of"]) == ("following error", ["slew"]) and error["noticed_s"] > 1.5
    assert (error["happened_s"], error["because"]) == (None, None)


@pytest.mark.parametrize("joints", [("luff", "slew"), ("slew", "luff")])
def test_of_two_causes_at_one_instant_the_later_line_is_named(joints: tuple[str, str]) -> None:
    report, _ = run(0.2, *(at(0.1, "fail_drive", joint=joint) for joint in joints))
    error = only(report)
    assert (error["of"], error["happened_s"], error["because"]) == (["slew", "luff"], 0.1, f"fail_drive {joints[1]}")


def test_a_repair_of_another_drive_undoes_nothing() -> None:
    lying = [at(2.9, "stick_drive_status", joint="slew"), at(LEG, "fail_drive", joint="slew")]
    report, _ = run(LEG + 0.5, *lying, at(LEG + 0.001, "repair_drive", joint="luff"))
    error = report["errors_handled"][0]
    assert (error["origin"], error["happened_s"], error["because"]) == ("following error", LEG, "fail_drive slew")


def test_a_failure_repaired_while_its_error_lasts_is_its_cause() -> None:
    lying = [at(2.9, "stick_drive_status", joint="slew"), at(LEG, "fail_drive", joint="slew")]
    report, _ = run(LEG + 1, *lying)
    noticed = only(report)["noticed_s"]
    assert noticed > LEG + 0.05
    report, _ = run(LEG + 1, *lying, at(noticed - 0.03, "repair_drive", joint="slew"))
    error = report["errors_handled"][0]
    assert (error["origin"], error["happened_s"], error["because"]) == ("following error", LEG, "fail_drive slew")


# ---- what is not done


def test_what_the_operator_clears_before_it_is_done_has_no_distance_of_a_response() -> None:
    drive = [at(LEG, "fail_drive", joint="luff"), at(LEG + 0.1, "repair_drive", joint="luff"), clear(LEG + 0.4)]
    pause = [at(LEG, "pause_host", lasts_ms=200), clear(LEG + 0.6)]
    for events, cleared in ((drive, LEG + 0.4), (pause, LEG + 0.6)):
        report, simulation = run(6, *events)
        error = only(report)
        assert error["cleared_s"] == pytest.approx(cleared, abs=0.001) and not error["stands"]
        assert (error["done_s"], error["moved_until_done_m"]) == (None, None)
        assert error["moved_most_m"] >= error["moved_until_noticed_m"]
        text = simulation.report_json_and_text()[1]
        assert "not done before it was cleared" in text and "until the response was done" not in text


def test_a_pid_that_does_not_come_any_more_leaves_an_error_that_stands() -> None:
    # The avoidance of four vehicles keeps the only DSP from the servo: the worst run of today.
    settings = {
        "dsps": 1,
        "boot": "preloaded",
        "duration_s": 1.5,
        "load.avoidance_cycles": 330_000,
        "agvs": 4,
        "load.parked": True,
        "scheduling.agv_phase": "together",
        "report.reference": "none",
    }
    simulation = cmrc.Simulation(cmrc.config(settings=settings))
    simulation.run()
    report = json.loads(simulation.report_json())
    assert report["braked"]
    assert report["errors_handled"][0]["origin"] == "drive time-out" and simulation.exit_status == 1


# ---- the second sensor


def test_a_stuck_sway_sensor_is_replaced_and_the_run_is_a_success() -> None:
    report, simulation = run(6, at(LEG, "stick_sway", axis="beta"))
    error = only(report)
    # 64 samples; PID checks them in every third run.
    assert (error["origin"], error["of"], error["response"], error["because"]) == (
        "sway sensor",
        ["beta"],
        "second sensor",
        "stick_sway beta",
    )
    assert LEG + 0.63 < error["noticed_s"] < LEG + 0.79 and not error["stands"] and simulation.exit_status == 0
    assert rates(simulation, 5.9)["l"] > 0.1  # the leg continues


@pytest.mark.parametrize("sensors", [1, 2])
def test_without_another_sensor_the_crane_stops(sensors: int) -> None:
    second = [at(4.5, "stick_second_sway", axis="alpha")] if sensors == 2 else []
    report, simulation = run(20, at(LEG, "stick_sway", axis="alpha"), *second, **{"dock.sway_sensors": sensors})
    assert [error["response"] for error in report["errors_handled"]] == ["second sensor", "stop"][2 - sensors :]
    assert report["errors_handled"][-1]["stands"] and simulation.exit_status == 1
    # The path stops within a second. The observer took the stuck angle for wind; that estimate fades with a time
    # constant of some 5 s.
    assert rates(simulation, 19.9)["l"] < STILL


# ---- while the load is lowered


@pytest.mark.parametrize(("event", "settings", "origin", "response"), [
    (at(LOWERING, "fail_drive", joint="luff"), {}, "drive fault", "set down"),
    (at(LOWERING, "fail_drive", joint="hoist"), {}, "drive fault", "stop"),
    pytest.param(at(LOWERING, "stick_sway", axis="alpha"), {"dock.sway_sensors": 1}, "sway sensor", "set down", marks=pytest.mark.campaign),
    # The luff's error is 1.8 urad at most, and 4.5 urad where the load cell's word is wrong.
    pytest.param(at(LOWERING, "stick_load_cell"), {"errors.following_luff_mrad": 0.003}, "following error", "set down", marks=pytest.mark.campaign),
    pytest.param(at(LOWERING, "stick_encoder", joint="hoist"), {}, "encoder", "stop", marks=pytest.mark.campaign),
])  # fmt: skip
def test_a_load_that_is_being_lowered_is_set_down(
    event: dict[str, Any], settings: dict[str, Any], origin: str, response: str
) -> None:
    report, simulation = run(25, event, **settings)
    error = only(report)
    assert (error["origin"], error["response"], error["stands"]) == (
        origin,
        response,
        True,
    ) and simulation.exit_status == 1
    events = [kind for _, kind, *_ in simulation.dock_events()]
    assert ("landed" in events) == (response == "set down")
    assert "locked" not in events  # the next step waits for the operator


# ---- landings and blocks


@pytest.mark.campaign
def test_a_landing_is_tried_again_until_it_is_given_up_and_again_when_that_is_cleared() -> None:
    report, _simulation = run(66, clear(50), strict_landing=True, ramp_speed_m_s=1.0, landing_retries_max=1)
    responses = [
        (error["origin"], error["response"], error["cleared_s"] is not None) for error in report["errors_handled"]
    ]
    assert responses[:3] == [("landing", "retry", False), ("landing", "hold", True), ("landing", "retry", False)]


def test_work_of_a_block_that_was_given_up_is_retried_then_stopped(tmp_path: Path) -> None:
    programs = programs_with(tmp_path, "grab_path.asm", "kernel_grab_path")
    settings = {
        "machine.programs": programs,
        "watchdog.long_run_us": 3000,
        "watchdog.recomputations_max": 0,
        "watchdog.retries_max": 1,
    }
    report, simulation = run(0.6, clear(0.4), **settings)
    handled = [(error["origin"], error["of"], error["response"], error["stands"]) for error in report["errors_handled"]]
    given_up = ("block given up", ["grab_path"])
    # After the error is cleared, the work is tried again as often.
    assert handled[:4] == [
        (*given_up, "retry", False),
        (*given_up, "stop", False),
        (*given_up, "retry", False),
        (*given_up, "stop", True),
    ]
    assert simulation.exit_status == 1


def test_where_no_dsp_can_run_the_error_block_the_drives_brake(tmp_path: Path) -> None:
    programs = programs_with(tmp_path, "error.asm", "kernel_error")
    settings = {"machine.programs": programs, "watchdog.long_run_us": 3000, "dsps": 2}
    report, simulation = run(5, at(LEG, "fail_drive", joint="luff"), **settings)
    error = report["errors_handled"][0]
    assert (error["origin"], error["decided_s"], error["response"], error["stands"]) == (
        "drive fault",
        None,
        None,
        True,
    )
    assert report["braked"] and simulation.exit_status == 1
    assert all(rates(simulation, 4.9)[joint] == 0 for joint in ("psi", "phi", "l"))


def test_work_that_stopped_without_a_decision_is_resumed_when_that_is_cleared(tmp_path: Path) -> None:
    programs = Path(programs_with(tmp_path, "grab_path.asm", "kernel_grab_path"))
    error_task = programs / "kernels" / "error.asm"
    stuck = "\nkernel_error:\n        br      kernel_error\n"
    error_task.write_text(error_task.read_text().replace("\nkernel_error:\n", stuck))
    settings = {"machine.programs": str(programs), "watchdog.long_run_us": 3000, "watchdog.recomputations_max": 0}
    report, _simulation = run(0.6, clear(0.4), **settings)
    first, again = report["errors_handled"]
    assert (first["of"], first["decided_s"], first["stands"]) == (["grab_path"], None, False)
    assert first["cleared_s"] == pytest.approx(0.4, abs=0.001)
    assert (again["of"], again["decided_s"], again["stands"]) == (["grab_path"], None, True)
    assert again["noticed_s"] > 0.4


def test_the_order_of_the_chips_changes_nothing() -> None:
    events = [at(LEG, "stick_encoder", joint="luff"), at(LEG, "stick_sway", axis="alpha")]
    hashes = {run(3.8, *events, dsps=2, turn_order=order)[0]["hash"] for order in (0, 77)}
    assert len(hashes) == 1


# ---- bad input


@pytest.mark.parametrize(("settings", "events", "message"), [
    ({"errors.following_luff_mrad": 0}, [], "errors.following_luff_mrad: a limit of 0 makes an error of every tick; a limit above 0 is required"),
    ({"errors.following_ms": 2}, [], "errors.following_ms: 2 ms is shorter than a servo period, 4 ms; PID sees an error once per servo period"),
    ({"errors.encoder_ms": 3.9}, [], "errors.encoder_ms: 3.9 ms is shorter than a servo period"),
    ({"errors.clear": True}, [], 'errors.clear: there are no errors before the run; an event "set" of this key is expected'),
    ({"dock.sway_sensors": 1}, [at(1, "stick_second_sway", axis="alpha")], "stick_second_sway, but the crane has one sway sensor; dock.sway_sensors = 2 is expected"),
    ({}, [at(1, "stick_drive_speed", joint="trolley")], "a slewing crane has no trolley"),
    ({"dock.crane": "gantry"}, [at(1, "stick_drive_status", joint="luff")], "a gantry has no luff"),
    ({}, [at(1, "set", key="errors.stop_s", value=2.0)], "errors.stop_s: cannot be changed during a run"),
    ({}, [at(1, "stick_load_cell", joint="luff")], '"stick_load_cell" has no such field'),
])  # fmt: skip
def test_nonsense_is_refused_before_anything_runs(
    settings: dict[str, Any], events: list[dict[str, Any]], message: str
) -> None:
    with pytest.raises(cmrc.ConfigError) as info:
        cmrc.config(settings={**AT_ONCE_AND_LOW, **settings}, events=events)
    assert message in str(info.value)


def test_a_file_that_clears_errors_before_the_run_is_named_with_the_place(tmp_path: Path) -> None:
    (tmp_path / "cleared.toml").write_text("[errors]\nclear = true\n")
    with pytest.raises(cmrc.ConfigError, match=r"cleared\.toml:2:1: errors\.clear: there are no errors before the run"):
        cmrc.config(file=tmp_path / "cleared.toml")
