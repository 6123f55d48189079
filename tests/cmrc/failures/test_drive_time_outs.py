"""Drives that time out, and the second after it: what continues by itself, and what waits for the operator."""

import cmrc
import pytest
from error_scenes import EVERY_RATE, EVERYTHING, LEG, LOWERING, SERVO, at, clear, only, rates, run
from locations import AT_ONCE


@pytest.mark.parametrize(("fails_s", "runs", "noticed"), [(0.0036, 2, []), (0.0042, 3, ["drive time-out"])])
def test_drives_wait_for_codes_after_the_third_run_of_pid(fails_s: float, runs: int, noticed: list[str]) -> None:
    """Its first runs only enable them."""
    settings = {**AT_ONCE, "machine.dsps": 1, "dock.drive_timeout_ms": 20, "report.reference": "none"}
    simulation = cmrc.Simulation(duration_s=0.1, settings=settings)
    simulation.at(fails_s, "fail", dsp=0)
    report = simulation.run().report
    pid = report["tasks"]["pid"]
    assert pid["on_time"] + pid["late"] == runs
    assert [error["origin"] for error in report["errors_handled"]] == noticed


def test_drives_that_have_timed_out_come_back_by_themselves_so_often() -> None:
    pause = at(LEG, "pause_host", lasts_ms=200)
    report, simulation = run(7, pause, **{"errors.go_on_s": 1.0})
    error = only(report)
    assert (error["origin"], error["of"], error["response"], error["because"]) == (
        "drive time-out",
        EVERYTHING,
        "retry",
        "drive_stopped",
    )
    assert (
        LEG + 0.1 - 2 * SERVO <= error["happened_s"] < LEG + 0.1 + 2 * SERVO
        and LEG + 0.2 < error["noticed_s"] < LEG + 0.2 + 2 * SERVO
    )
    assert not error["stands"] and simulation.exit_status == 0
    assert rates(simulation, LEG + 0.9)["l"] < 0.02 and rates(simulation, 6.9)["l"] > 0.1
    report, simulation = run(9, pause, clear(6), **{"errors.timeout_retries_max": 0, "errors.go_on_s": 1.0})
    error = only(report)
    assert error["response"] == "hold" and error["cleared_s"] is not None and simulation.exit_status == 0
    assert all(rates(simulation, 5.9)[joint] == 0 for joint in EVERY_RATE)  # every brake is closed
    assert rates(simulation, 8.9)["l"] > 0.1


@pytest.mark.parametrize("lasts_ms", [101.0, 130.0, 200.0, 1000.0])
def test_the_crane_recovers_from_any_gap_in_motion(lasts_ms: float) -> None:
    """At 8 s it slews with 59 mrad/s. After a short gap the brakes have not stopped it yet."""
    report, simulation = run(16, at(8, "pause_host", lasts_ms=lasts_ms), **{"errors.go_on_s": 4.0})
    error = only(report)
    assert (error["origin"], error["response"], error["stands"]) == ("drive time-out", "retry", False)
    assert error["done_s"] == pytest.approx(error["decided_s"] + 1.0, abs=2 * SERVO)
    assert all(rates(simulation, error["done_s"] - 0.01)[joint] == 0 for joint in EVERY_RATE)  # every brake holds
    assert rates(simulation, 15.9)["psi"] > 0.02 and simulation.exit_status == 0


def test_after_a_retry_at_speed_the_swing_trips_the_luff_drive() -> None:
    """docs/controller.md: at 100 s the crane slews with 119 of its 126 mrad/s. 15 s after gaps of 0.11, 0.15 and 0.3 s
    the luff drive trips."""
    settings = {"machine.dsps": 3, "run.duration_s": 116, "report.reference": "none", "report.signal_decimation": 8}
    before = cmrc.Simulation(settings=settings)
    before.run_until(99.999)
    assert round(1e3 * abs(before.result().signals["psi_rate_rad_per_s"][-1])) == 119
    config = before.result().report["configuration"]
    assert round(1e3 * config["slewing.slew.rated_speed_rad_s"] / config["slewing.slew.gear"]) == 126
    for gap_s in (0.11, 0.15, 0.3):
        after = before.fork()
        after.at(100, "pause_host", lasts_ms=1e3 * gap_s)
        retry, trip = after.run().report["errors_handled"]
        assert (retry["origin"], retry["response"], retry["stands"]) == ("drive time-out", "retry", False), gap_s
        assert (trip["origin"], trip["of"], trip["response"]) == ("drive overspeed", ["luff"], "stop"), gap_s
        assert round(trip["noticed_s"] - 100) == 15, gap_s


STOPPED_AND_TIMED_OUT = {
    "long after": [at(LEG, "fail_drive", joint="luff"), at(LEG + 1.5, "pause_host", lasts_ms=200)],
    "in its second": [at(LEG, "fail_drive", joint="luff"), at(LEG + 0.3, "pause_host", lasts_ms=200)],
    "no DSP for a while": [
        at(LEG, "fail_drive", joint="luff"),
        at(LEG + 1.5, "unplug", dsp=0),
        at(LEG + 1.8, "plug", dsp=0),
    ],
}


@pytest.mark.parametrize("order", STOPPED_AND_TIMED_OUT)
def test_a_retry_does_not_move_a_crane_that_another_error_has_stopped(order: str) -> None:
    events = [*STOPPED_AND_TIMED_OUT[order], at(8, "repair_drive", joint="luff"), clear(9)]
    report, simulation = run(13, *events, **{"errors.go_on_s": 1.0})
    errors = {error["origin"]: error for error in report["errors_handled"]}
    assert set(errors) == {"drive fault", "drive time-out"} == {error["origin"] for error in report["errors_handled"]}
    stop, retry = errors["drive fault"], errors["drive time-out"]
    assert (stop["response"], retry["response"]) == ("stop", "retry")
    assert stop["done_s"] < LEG + 1.1
    # It only ended the time-out: no other try began before the operator came.
    assert (retry["done_s"], retry["moved_until_done_m"]) == (None, None)
    assert retry["moved_most_m"] >= retry["moved_until_noticed_m"]
    for at_s in (6.5, 7.5, 8.9):
        assert rates(simulation, at_s)["l"] < 0.012, at_s  # it still returns to the place at which its path has stopped
    assert retry["cleared_s"] == stop["cleared_s"] == pytest.approx(9, abs=0.001)
    assert rates(simulation, 12.9)["l"] > 0.1 and simulation.exit_status == 0


def test_a_drive_that_fails_while_a_retry_waits_stops_the_crane_before_it_has_moved() -> None:
    events = [at(LEG, "pause_host", lasts_ms=200), at(LEG + 0.8, "fail_drive", joint="luff")]
    report, simulation = run(8, *events)
    late, fault = report["errors_handled"]
    assert (late["response"], fault["response"], fault["stands"]) == ("retry", "stop", True)
    # All drives are off: PID finds the fault when they are on again.
    assert late["done_s"] < fault["noticed_s"] < late["done_s"] + 3 * SERVO
    for at_s in (4.5, 5.5, 7.9):
        assert rates(simulation, at_s)["l"] < 0.012, at_s
    assert simulation.exit_status == 1


def test_a_load_that_is_being_set_down_reaches_its_place_after_a_time_out() -> None:
    events = [at(LOWERING, "fail_drive", joint="luff"), at(LOWERING + 0.2, "pause_host", lasts_ms=200)]
    report, simulation = run(29, *events, **{"errors.go_on_s": 1.0})
    fault, late = report["errors_handled"]
    assert (fault["response"], late["response"]) == ("set down", "retry")
    assert late["done_s"] < fault["done_s"] and not late["stands"] and fault["stands"]
    assert "landed" in {kind for _, kind, *_ in simulation.dock_events()}
