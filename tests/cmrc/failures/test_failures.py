"""A DSP that hangs in its code, one that fails while idle, a block that stops every DSP that runs it: each is found,
and the run survives it."""

import json
import shutil
from pathlib import Path
from typing import Any

import cmrc as package
import numpy as np
import pytest
from audited_run import programs_with, run
from cmrc import _core
from locations import ROOT
from traced_run import events_of

cmrc = _core.cmrc
KIND_PID = 6
REFRESH, MILLISECOND = 125_000_000, 10**9  # ps


def failures(report: dict[str, Any], kind: str) -> list[dict[str, Any]]:
    return [failure for failure in report["failures"] if failure["kind"] == kind]


def test_a_dsp_that_hangs_runs_on_in_a_loop() -> None:
    # Hung while idle at 50 ms, never reset: it executes instead of idling. BR takes 4 cycles.
    report = run([{"at_s": 0.0505, "action": "hang", "dsp": 3}], duration_s=0.1, dsps=4)
    hung = report["dsps"][3]
    assert hung["state"] == "running"
    assert hung["causes"]["idle"] < 0.51 * hung["cycles"]
    assert hung["instructions"] > 0.0494 * 25e6 / 4
    frozen = run([{"at_s": 0.0505, "action": "freeze", "dsp": 3}], duration_s=0.1, dsps=4)["dsps"][3]
    assert frozen["causes"]["halted"] > 0.49 * frozen["cycles"]
    assert frozen["state"].startswith("halted")


@pytest.mark.parametrize(("action", "works_again"), [("hang", True), ("freeze", True), ("fail", False)])
def test_a_dsp_that_dies_idle_is_found_by_its_silence(action: str, works_again: bool) -> None:
    report = run([{"at_s": 0.1006, "action": action, "dsp": 0}], duration_s=0.3, dsps=2)
    [silent, *more] = failures(report, "silent")
    # The ring at 101 ms has no effect. The DSP's last sign was at 100 ms (or at 101 ms, when the ring found its idle
    # bit).
    assert silent["dsp"] == 0 and 0.150 < silent["time_s"] < 0.153
    assert len(more) == (0 if works_again else 1)
    if not works_again:
        assert 0.200 < more[0]["time_s"] < 0.204 and "considered dead" in more[0]["message"]
    assert (report["dsps"][0]["claims"] > 250) == works_again
    assert report["tasks"]["pid"]["misses"] <= 1
    assert not failures(run([], duration_s=0.2, dsps=1), "silent")


@pytest.mark.parametrize(("silence_ms", "refreshes"), [(5, 40), (5.01, 41), (5.125, 41), (5.126, 42)])
def test_a_dsp_is_silent_when_its_time_is_over_and_not_at_its_last_refresh(silence_ms: float, refreshes: int) -> None:
    """Refreshes of 125 us. The ring of 51 ms, refresh 408, finds the idle bit for the last time."""
    events = [{"at_s": 0.0502, "action": "fail", "dsp": 0}]
    settings = {"boot": "preloaded", "watchdog.silence_ms": silence_ms, "watchdog.long_run_us": 1e6}
    report = run(events, duration_s=0.065, dsps=1, **settings)
    found = [int(failure["time_s"] / 125e-6) for failure in failures(report, "silent")]
    assert found == [408 + refreshes + 1, 408 + 2 * (refreshes + 1)]


def test_no_dsp_is_silent_when_there_is_nothing_to_do(tmp_path: Path) -> None:
    """An empty ship: homing, then the servo ends and no block is loaded any more."""
    layout = tmp_path / "layout.toml"
    layout.write_text("containers = []\n", encoding="utf-8")
    simulation = cmrc.Simulation(
        cmrc.config(settings={"duration_s": 2.5, "dock.layout": str(layout), "report.reference": "none"})
    )
    simulation.run()
    report = json.loads(simulation.report_json())
    assert failures(report, "silent") == [] and all(dsp["resets"] == 0 for dsp in report["dsps"])
    assert report["tasks"]["home.crane"]["on_time"] == 1 and report["tasks"]["pid"]["released"] < 2000


def test_no_healthy_dsp_is_silent_however_busy() -> None:
    for preset, dsps in (("saturated", 2), ("heavy", 3)):
        simulation = cmrc.Simulation(
            cmrc.config(
                preset=preset,
                settings={"duration_s": 0.5, "dsps": dsps, "watchdog.silence_ms": 5, "report.reference": "none"},
            )
        )
        simulation.run()
        report = json.loads(simulation.report_json())
        assert failures(report, "silent") == []
        assert all(dsp["resets"] == 0 for dsp in report["dsps"])


def test_work_that_kills_every_dsp_is_asked_for_so_often_and_no_more(tmp_path: Path) -> None:
    programs = programs_with(tmp_path, "grab_path.asm", "kernel_grab_path")
    settings = {
        "machine.programs": programs,
        "duration_s": 1.0,
        "dsps": 3,
        "watchdog.long_run_us": 3000,
        "watchdog.recomputations_max": 1,
        "report.reference": "none",
    }
    for retries in (0, 1, 2):
        report = run([], **settings, **{"watchdog.retries_max": retries})
        path = report["tasks"]["grab_path"]
        assert (path["released"], path["dropped"]) == (1 + retries, 1 + retries)
        assert report["host"]["recomputed"] == 1 + retries
        [stopped] = failures(report, "stopped")
        assert (
            f"grab_path was given up {1 + retries} times in a row" in stopped["message"]
            and "process 2 (plan the grab)" in stopped["message"]
        )
        assert report["tasks"]["error"]["on_time"] == 1 + retries
        # The servo still holds the crane.
        assert report["tasks"]["pid"]["on_time"] > 960
        assert report["stop_reason"] == "completed"


def test_a_pid_that_never_returns_ends_with_the_drives_braked(tmp_path: Path) -> None:
    programs = programs_with(tmp_path, "pid.asm", "kernel_pid")
    report = run([], **{"machine.programs": programs, "duration_s": 0.5, "dsps": 3, "watchdog.retries_max": 1})
    [stopped] = failures(report, "stopped")
    assert "sub-process 4 (PID); the drives brake" in stopped["message"]
    assert report["braked"]
    assert report["tasks"]["pid"]["on_time"] == 0
    assert report["tasks"]["torque_compensation"]["on_time"] > 400


def test_a_task_that_hangs_once_in_a_while_is_not_stopped() -> None:
    # Drops are counted in a row: here every recomputation succeeds.
    events = [{"at_s": 0.10004 + 0.05 * k, "action": "hang", "dsp": 1} for k in range(4)]
    report = run(events, duration_s=0.4, dsps=2, retries_max=0)
    assert not failures(report, "stopped")
    assert report["host"]["recomputed"] == 4


@pytest.mark.parametrize(
    ("events", "stop_at_s", "reason", "status"),
    [
        ([], 1.0, "completed", 0),
        ([], 0.06, "interrupted", 0),  # the user has interrupted it
        (
            [{"at_s": 0.05, "action": "fail", "dsp": 0}, {"at_s": 0.05, "action": "fail", "dsp": 1}],
            1.0,
            "completed",
            1,
        ),  # no DSP is left
    ],
)
def test_the_status_of_a_run_that_ends_or_is_ended(
    events: list[dict[str, object]], stop_at_s: float, reason: str, status: int
) -> None:
    simulation = cmrc.Simulation(
        cmrc.config(settings={"machine.dsps": 2, "run.duration_s": 0.4, "report.reference": "none"}, events=events)
    )
    simulation.run(lambda simulated_s, _: simulated_s < stop_at_s)
    assert (json.loads(simulation.report_json())["stop_reason"], simulation.exit_status) == (reason, status)


def test_a_servo_block_that_runs_again_is_of_the_refresh_that_offers_it(tmp_path: Path) -> None:
    """PID takes its set-point at TB_TICK, and reads the encoders when it runs. One DSP dies in PID, and boots again
    while the block waits: TB_TICK follows the refreshes, but the job keeps its deadline."""
    freeze = '[[events]]\nat_s = 0.0501\naction = "freeze"\ndsp = 0\n'
    found, report = events_of(tmp_path, "--dsps", 1, "--duration", 0.07, toml=freeze)
    pid = [(time, name, what) for time, _, name, what in found
           if name in ("claim", "requeue") and what["kind"] == KIND_PID]  # fmt: skip
    again = [name for _, name, _ in pid].index("requeue") + 1
    (_, _, first), (put_back_at, _, put_back), (claimed_at, _, second), (_, _, after) = pid[again - 2 : again + 2]
    assert first["tick"] == 400 and second["generation"] == put_back["generation"]
    assert claimed_at - put_back_at > 2 * MILLISECOND  # it waits for the only DSP
    assert second["tick"] == claimed_at // REFRESH
    assert after["tick"] % 8 == 0 and after["tick"] > second["tick"]
    assert report["tasks"]["pid"]["late"] >= 1 and report["host"]["recomputed"] == 1


@pytest.mark.parametrize("dsps", [2, 1])
def test_a_dsp_that_dies_in_pid_does_not_jerk_the_crane(dsps: int) -> None:
    """In motion the set-point of two ticks before would give full torque, by slew, hoist and rotator."""
    settings = {"report.reference": "none", "report.signal_decimation": 1}
    at = 3.9511
    quiet, disturbed = (
        package.run(dsps=dsps, duration_s=3.98, settings=settings, events=events)
        for events in ([], [{"at_s": at, "action": "freeze", "dsp": dsp} for dsp in range(dsps)])
    )
    assert "of kind pid" in "".join(f["message"] for f in failures(disturbed.report, "watchdog"))
    for joint in ("psi", "phi", "l", "kappa"):
        name = f"{joint}_code"
        after = disturbed.signals["time_s"] > at
        difference = np.abs(disturbed.signals[name] - quiet.signals[name])[after]
        assert difference.max() < 1000, joint


def test_a_pid_that_was_given_up_is_still_demanded(tmp_path: Path) -> None:
    """Its ticks are dropped until the operator clears the error, and the drives that wait for it end the account."""
    shutil.copytree(ROOT / "c40_programs", tmp_path / "programs")
    source = tmp_path / "programs/kernels/pid.asm"
    stuck = "        ldi     @TASK + TB_TICK, r0\n        subi    4000, r0\n        cmpi    400, r0\npid_stuck:\n"
    source.write_text(
        source.read_text().replace("\nkernel_pid:\n", f"\nkernel_pid:\n{stuck}        blo     pid_stuck\n")
    )
    settings = {"machine.programs": str(tmp_path / "programs"), "dsps": 4, "duration_s": 2.0, "run.after_stop_s": 0.6}
    report = run([], **settings)
    pid = report["tasks"]["pid"]
    # On from the tick at 20 ms on. PID hangs at the tick at 500 ms; the drives wait 100 ms for its codes.
    assert report["stop_reason"] == "drives_stopped"
    assert 1.19 < report["account_end_s"] < 1.21
    assert pid["on_time"] == 480 and pid["released"] == 480 + pid["dropped"]
    assert pid["released"] == pytest.approx(1000 * report["account_end_s"] - 20, abs=1)

    clear = {"at_s": 0.9, "action": "set", "key": "errors.clear", "value": True}
    # The drives have timed out: they are switched on a second later.
    report = run([clear], **{**settings, "run.after_stop_s": 1.5})
    pid = report["tasks"]["pid"]
    assert report["stop_reason"] == "completed"
    assert pid["released"] == 1980 and pid["dropped"] == pytest.approx(400, abs=2)


@pytest.mark.parametrize("crane", ["slewing", "gantry"])
def test_without_torque_compensation_pid_gets_no_work(crane: str) -> None:
    """Torque compensation hangs at the tick at 300 ms, and is not tried again. The drives wait 100 ms for codes."""
    settings = {
        "dock.crane": crane,
        "dsps": 3,
        "watchdog.recomputations_max": 0,
        "watchdog.retries_max": 0,
        "run.after_stop_s": 0.5,
        "report.reference": "none",
    }
    hang = {"at_s": 0.30005, "action": "hang", "dsp": 0}
    result = package.run(duration_s=1.5, settings=settings, events=[hang])
    report = result.report
    [stopped] = failures(report, "stopped")
    assert "sub-process 3 (torque compensation); the drives brake" in stopped["message"]
    assert report["braked"] and report["stop_reason"] == "drives_stopped"
    assert report["account_end_s"] == pytest.approx(stopped["time_s"] + 0.1 + 0.5, abs=0.003)

    # What is dropped is dropped because of the error, also before it was decided; no host was late.
    stop = stopped["time_s"] * 1000
    for kind, last in (("pid", stop), ("torque_compensation", 300)):
        task = report["tasks"][kind]
        why = task["why_late"]
        assert task["on_time"] == pytest.approx(last - 20, abs=2), kind
        assert task["released"] == pytest.approx(report["account_end_s"] * 1000 - 20, abs=1), kind
        assert why["dropped_stopped_by_error"] > 570 and why["dropped_host_late"] == why["dropped_left_out"] == 0, kind
        assert task["dropped"] - why["dropped_stopped_by_error"] - why["dropped_previous_out"] in (0, 1), kind
    assert report["host"]["skipped_refreshes"] == 0
    assert "dropped: an error had stopped the servo" in result.text and "host skipped" not in result.text
    last = len(result.missed) - 1
    assert next(iter(result.missed[last]["parts_ps"])) == "stopped_by_error"
    assert "an error had stopped the servo, or was not decided yet" in result.explain(last)

    clear = {"at_s": 0.8, "action": "set", "key": "errors.clear", "value": True}
    cleared = run([hang, clear], **{**settings, "run.after_stop_s": 1.5}, duration_s=2.2)
    assert cleared["stop_reason"] == "completed" and not cleared["braked"]
    for kind in ("pid", "torque_compensation"):
        assert cleared["tasks"][kind]["on_time"] == pytest.approx(2180 - (800 - stop), abs=4), kind


def test_ticks_that_pass_while_a_host_is_paused_are_the_hosts(tmp_path: Path) -> None:
    """Also if an error has stopped the servo; only the tick at which the host is back is the error's."""
    programs = programs_with(tmp_path, "pid.asm", "kernel_pid")
    settings = {"machine.programs": programs, "duration_s": 0.4, "dsps": 3, "watchdog.retries_max": 0}
    quiet = run([], **settings)["tasks"]["pid"]
    paused = run([{"at_s": 0.3, "action": "pause_host", "lasts_ms": 50}], **settings)["tasks"]["pid"]
    assert quiet["dropped"] == paused["dropped"] > 300
    assert quiet["why_late"]["dropped_host_late"] == 0
    assert paused["why_late"]["dropped_host_late"] in (49, 50)
    assert (
        paused["why_late"]["dropped_host_late"] + paused["why_late"]["dropped_stopped_by_error"]
        == quiet["why_late"]["dropped_stopped_by_error"]
    )


def test_a_drive_that_is_off_does_no_work() -> None:
    """Both DSPs fail; the codes stay, also that of the hoist with its load. The drives time out 100 ms later."""
    events = [{"at_s": 0.5, "action": "fail", "dsp": dsp} for dsp in range(2)]
    efforts = []
    for after_stop in (0.5, 1.5):
        result = package.run(
            dsps=2,
            duration_s=3.0,
            events=events,
            settings={"run.after_stop_s": after_stop, "report.signal_decimation": 1, "report.reference": "none"},
        )
        efforts.append(result.report["control_cost"]["drive_s"])
    assert efforts[0] == efforts[1]
    times = result.signals["time_s"]
    codes = [result.signals[f"{joint}_code"] for joint in ("s", "psi", "phi", "l", "kappa")]
    assert max(abs(code[-1]) for code in codes) > 100
    [on_until] = {f["time_s"] for f in result.report["failures"] if "drive_stopped" in f["message"]}
    on = times < on_until
    assert efforts[0] == pytest.approx(125e-6 * sum(np.sum((code[on] / 2047) ** 2) for code in codes), rel=1e-3)
