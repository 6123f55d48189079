"""cmrc limits, which emulator limits starts, and compare: answers that are known beforehand, and bad input."""

import json
import math
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import cmrc
import numpy as np
import pytest
from cmrc import _core, limit_worker
from cmrc.limit_scans import NOT_RUN, Scan, Scans
from cmrc.processes import Helpers, ended
from locations import AT_ONCE, BUILD

EMULATOR = BUILD / "bin" / "emulator"


def test_the_limit_is_where_all_passes_and_anomalies_lie_beyond() -> None:
    def outcome(points: list[tuple[float, bool | None]], more_is_harder: bool) -> tuple[float | None, list[float]]:
        scan = Scan("cycles", "key", "meaning", more_is_harder)
        scan.points = [
            {"value": value, "ran": passed is not None, "passed": bool(passed), "refused": None}
            for value, passed in points
        ]
        return scan.limit(), scan.beyond()

    assert outcome([(1, True), (2, True), (3, False), (4, True), (5, False)], True) == (2, [4])
    assert outcome([(1, True), (2, False), (3, True), (4, True)], False) == (3, [1])
    assert outcome([(1, False), (2, True)], True) == (None, [2])
    assert outcome([], True) == (None, [])
    # Interrupted: what has not been run says nothing, and the limit is not looked for beyond it.
    assert outcome([(1, True), (2, None), (3, True), (4, False), (5, True)], True) == (1, [5])
    assert outcome([(1, None), (2, True)], True) == (None, [])


@pytest.mark.parametrize(("more_is_harder", "refused", "line"), [
    (False, [17.0], "limit: 2; every allowed point from it on passes"),
    (False, [1.0], "limit: 2; every point from it on passes"),
    (True, [1.0], "limit: 2; every allowed point up to it passes"),
    (True, [17.0], "limit: 2; every point up to it passes"),
])  # fmt: skip
def test_a_limit_says_that_it_passes_over_points_that_are_not_allowed(
    more_is_harder: bool, refused: list[float], line: str
) -> None:
    scan = Scan("dsps", "key", "meaning", more_is_harder)
    scan.points = sorted(
        (
            {"value": value, "realised": value, **NOT_RUN, "ran": value == 2.0, "passed": value == 2.0,
             "refused": "out of range" if value in refused else None}
            for value in (2.0, *refused)
        ),
        key=lambda point: point["value"],
    )  # fmt: skip
    assert scan.limit() == 2.0 and scan.text().splitlines()[-1] == f"  {line}"


def test_the_text_of_a_scan() -> None:
    """docs/report.md, Limits. A rate that does not exist stands with the one that runs."""

    def point(value: float, realised: float | None = None, **more: Any) -> dict[str, Any]:
        return {
            "value": value,
            "realised": value if realised is None else realised,
            **NOT_RUN,
            "ran": True,
            "judged": True,
            **more,
        }

    scan = Scan("servo", "rates.servo_frequency_hz", "Servo frequency f_p in Hz", True)
    scan.points = [
        point(1000.0, passed=True),
        point(1001.0, 1000.0, first_miss="pid", first_miss_s=0.0221234567),
        point(1500.0, passed=True),
        point(1600.0, starved_intervals=1),
        point(2000.0, starved_intervals=2),
        point(4000.0, stop_reason="plant_fault"),
        point(4500.0, ran=False),
        point(5000.0, ran=False, refused="f_s >= 2 f_p is required"),
    ]
    assert scan.text().splitlines() == [
        "",
        "Servo frequency f_p in Hz (rates.servo_frequency_hz)",
        "       1000  no miss",
        "  1001 (runs at 1000)  pid missed at 0.022123 s",
        "       1500  no miss",
        "       1600  starved: 1 point interval without a new point",
        "       2000  starved: 2 point intervals without a new point",
        "       4000  plant_fault",
        "       4500  not run: interrupted",
        "       5000  not run: f_s >= 2 f_p is required",
        "  limit: 1000; every point up to it passes",
        "  anomalies, passing beyond a miss: 1500",
    ]
    for points, says in (
        ([], "no limit: the easiest point does not pass"),
        (scan.points[1:2], "no limit: the easiest point does not pass"),
        (scan.points[6:7], "no limit known: the easiest point has not been run"),
    ):
        scan.points = points
        assert scan.text().splitlines()[-1] == f"  {says}"


def test_a_point_passes_if_its_run_comes_to_an_end_without_a_miss() -> None:
    """Also where its job is done before its time."""

    def passed(**more: Any) -> bool:
        task = {"misses": 0, "on_time": 5}
        report = {
            "tasks": {"pid": task},
            "starved_intervals": {"crane": 0},
            "stop_reason": "completed",
            "misses": [],
            **more,
        }
        return limit_worker.outcome(report, to_its_end=False)["passed"] is True

    assert passed() and passed(stop_reason="job_done")
    assert not any(
        passed(stop_reason=reason) for reason in ("plant_fault", "no_dsp_left", "drives_stopped", "interrupted")
    )
    assert not passed(starved_intervals={"crane": 1}) and not passed(tasks={"pid": {"misses": 0, "on_time": 0}})


def test_the_standard_grids() -> None:
    """Of f_s = 8 kHz and f_p = 1 kHz: each servo frequency from half of it on."""
    scans = Scans(_core.cmrc.config_layers(), None, None, None, errors=False).scans
    values = {scan.name: [(point["value"], point["realised"]) for point in scan.points] for scan in scans}
    assert values["cycles"] == [(n / 4, n / 4) for n in range(4, 13)]
    assert values["dsps"] == [(n, n) for n in range(1, 9)]
    assert values["servo"] == [(8000 / n, pytest.approx(8000 / n)) for n in range(16, 1, -1)]


def test_two_dsps_are_the_least_for_the_base_rates() -> None:
    # plant-and-bus.md 2.4: one more than long jobs that can run at once; identify is the only one here.
    found = cmrc.limits(dsps=[3, 1, 2], duration_s=0.04)
    assert found.limit("dsps") == 2
    first = found.points.row(0)
    assert (first["value"], first["passed"], first["first_miss"]) == (1, False, "torque_compensation")


@pytest.mark.parametrize("errors", [False, True])
def test_a_machine_that_boots_to_the_end_does_not_pass(errors: bool) -> None:
    found = cmrc.limits(cycles=[20, 50], dsps=None, duration_s=0.06, errors=errors, settings={"machine.dsps": 1})
    scan = found.report["scans"]["cycles"]
    assert (scan["limit"], scan["passing_beyond"]) == (None, [])
    assert [(p["passed"], p["judged"], p["first_miss"]) for p in scan["points"]][1] == (False, False, None)
    assert "no job was finished, and none missed" in found.text


def test_a_strict_run_that_boots_to_the_end_fails() -> None:
    options = ["--dsps", "1", "--duration", "0.06", "--set", "machine.cycle_time_factor=50"]
    for strict, status in (([], 0), (["--strict"], 1)):
        run = subprocess.run([EMULATOR, *options, *strict], capture_output=True, text=True, check=False)
        assert run.returncode == status and "No job was finished, and none was missed." in run.stdout


def test_the_slack_of_the_servo_is_what_its_cycles_leave() -> None:
    """Where instructions take f times as long and the bus does not, PID needs W + B + f I; it has a millisecond."""
    pid = cmrc.run(duration_s=0.05, dsps=4, settings=AT_ONCE).report["tasks"]["pid"]
    cycles = pid["execution_cycles"]
    period_us = 1000.0
    instructions = (
        0.04
        * sum(cycles[cause] for cause in ("execute", "branch", "register_conflict", "memory_conflict"))
        / pid["execution_ps"]["count"]
    )
    instructions += (
        pid["execution_ps"]["worst"] - pid["execution_ps"]["mean"]
    ) * 1e-6  # its longest tick decides: some look for more errors than others
    rest = pid["response_ps"]["worst"] * 1e-6 - instructions
    predicted = (period_us - rest) / instructions
    assert 5 < predicted < 50
    found = cmrc.limits(
        cycles=[round(predicted * share, 2) for share in (0.5, 0.85, 1.15, 1.5)],
        duration_s=0.05,
        dsps=None,
        settings={"machine.dsps": 4, **AT_ONCE},
    )
    assert list(found.points["passed"]) == [True, True, False, False]
    assert found.limit("cycles") == round(predicted * 0.85, 2)


def test_a_point_that_is_not_allowed_is_refused_and_the_others_are_run() -> None:
    found = cmrc.limits(servo=[1000, 5000], dsps=[2, 2.5, 99], duration_s=0.022)
    servo, dsps = found.report["scans"]["servo"], found.report["scans"]["dsps"]
    assert servo["limit"] == 1000 and "f_s" in servo["points"][1]["refused"]
    assert dsps["limit"] == 2 and [point["refused"] is None for point in dsps["points"]] == [True, False, False]


def test_an_infinite_value_is_a_refused_point_of_each_scan() -> None:
    for scan, value in (("dsps", math.inf), ("dsps", -math.inf), ("cycles", math.inf), ("servo", math.inf)):
        [point] = cmrc.limits(duration_s=0.022, **{scan: [value]}).report["scans"][scan]["points"]
        assert point["value"] == value and f"{value} is out of range" in point["refused"]
        with pytest.raises(ValueError, match=rf"{scan}\[0\]: nan is no number"):
            cmrc.limits(duration_s=0.022, **{scan: [math.nan]})


def test_errors_of_points_have_no_column_beside_their_own_where_one_was_refused() -> None:
    points = cmrc.limits(dsps=[2, 99], errors=True, duration_s=0.022).points
    assert [name for name in points if name.startswith("errors")] == [
        f"errors_{name}"
        for name in (
            "f_p_realised_hz",
            "f_p_missed_share",
            "f_t_realised_hz",
            "f_t_missed_share",
            "load_rms_m",
            "lag_s",
        )
    ]
    assert list(np.isnan(points["errors_load_rms_m"])) == [False, True]


def test_a_rate_that_does_not_exist_is_shown_with_the_one_that_runs() -> None:
    found = cmrc.limits(servo=[3000, 4000], duration_s=0.025, dsps=[2, 99])
    asked, exact = found.report["scans"]["servo"]["points"]
    assert (asked["value"], asked["realised"], exact["realised"]) == (3000, 4000, 4000)
    assert "  3000 (runs at 4000)  no miss\n" in found.text and "limit: 4000;" in found.text
    two, refused = found.report["scans"]["dsps"]["points"]
    assert (two["realised"], refused["realised"]) == (2, None) and "\n          2  no miss" in found.text
    report = cmrc.run(duration_s=0.025, servo_frequency_hz=3000.0).report  # independently: what the run itself says
    assert report["rates"]["f_p"]["nominal_hz"] == asked["realised"]


def test_a_scan_gives_the_same_twice() -> None:
    once, twice = (cmrc.limits(cycles=[1, 8, 16, 32], duration_s=0.02, settings=AT_ONCE).report for _ in range(2))
    assert once == twice


@pytest.mark.parametrize(("grids", "message"), [({"cycles": []}, "empty"), ({"dsps": [2, 2]}, "twice")])
def test_grids_that_are_none(grids: dict[str, list[float]], message: str) -> None:
    with pytest.raises(cmrc.ConfigError, match=message):
        cmrc.limits(duration_s=0.03, **grids)


@pytest.mark.parametrize("grid", ["", "3:1:1", "1:2:0", "1:2:-1", "a", "1,,2", "1:2:3:4", "1:1000000:0.5"])
def test_grids_that_are_ill_typed(grid: str) -> None:
    run = subprocess.run(
        [EMULATOR, "limits", "--duration", "0.03", "--cycles", grid], capture_output=True, text=True, check=False
    )
    assert run.returncode == 2 and "--cycles" in run.stderr and run.stdout == ""


def test_the_command_and_python_agree(tmp_path: Path) -> None:
    file = tmp_path / "limits.json"
    command = [EMULATOR, "limits", "--dsps-grid", "1:2", "--duration", "0.03", "--json", file]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    found = cmrc.limits(dsps=[1, 2], duration_s=0.03)
    assert json.loads(file.read_text()) == found.report and run.stdout == found.text


def test_without_the_package_beside_it_the_program_says_how_to_get_it(tmp_path: Path) -> None:
    alone = tmp_path / "emulator"
    shutil.copy(EMULATOR, alone)
    run = subprocess.run([alone, "limits", "--dsps-grid", "1:2"], capture_output=True, text=True, check=False)
    assert run.returncode == 2 and run.stdout == ""
    assert f"{tmp_path}/cmrc cannot be started: No such file" in run.stderr and "pip install" in run.stderr


def test_the_program_hands_on_what_it_is_given(tmp_path: Path) -> None:
    shutil.copy(EMULATOR, tmp_path / "emulator")
    (tmp_path / "cmrc").write_text('#!/bin/sh\nfor word in "$@"; do echo "<$word>"; done\nexit 7\n')
    (tmp_path / "cmrc").chmod(0o755)
    given = ["limits", "--help", "--set", "a=b c", "--dsps-grid", "1:2", "-x", "--", "--duration", "*"]
    run = subprocess.run([tmp_path / "emulator", *given], capture_output=True, text=True, check=False)
    assert run.returncode == 7 and run.stdout.splitlines() == [f"<{word}>" for word in given]


def test_every_setting_of_the_emulator_can_be_given(tmp_path: Path) -> None:
    """What emulator limits took before it was cmrc's."""
    (tmp_path / "c.toml").write_text("[machine]\ndsps = 3\n")
    given = ["--config", "c.toml", "--preset", "saturated", "--duration", "0.022", "--seed", "2", "--turn-order", "3"]
    given += ["--topology", "single", "--idle-policy", "pause", "--eq7", "as_printed", "--set", "host.start_ms=0x0"]
    command = [EMULATOR, "limits", "--cycles", "1", "--json", "l.json", *given]
    run = subprocess.run(command, capture_output=True, text=True, check=True, cwd=tmp_path)
    settings = {"bus.topology": "single", "scheduling.equation": "as_printed", "host.start_ms": 0}
    found = cmrc.limits(
        cycles=[1],
        config=tmp_path / "c.toml",
        preset="saturated",
        duration_s=0.022,
        seed=2,
        turn_order=3,
        idle_policy="pause",
        settings=settings,
    )
    assert run.stdout == found.text and json.loads((tmp_path / "l.json").read_text()) == found.report
    for bad in (
        ["--json", "c.toml"],
        ["--json", "none/l.json"],
        ["--board", "none.toml"],
        ["--dsps", "99"],
        ["--idle-policy", "x"],
    ):
        run = subprocess.run(
            [EMULATOR, "limits", "--config", "c.toml", *bad], capture_output=True, text=True, check=False, cwd=tmp_path
        )
        assert run.returncode == 2 and run.stdout == "" and run.stderr.startswith("cmrc limits: "), run.stderr
    assert (tmp_path / "c.toml").read_text() == "[machine]\ndsps = 3\n"


def test_a_point_whose_process_is_killed_is_an_error_that_says_so(tmp_path: Path) -> None:
    script = (
        "import os, signal, cmrc.processes as p\n"
        "with p.Helpers('cmrc.limit_worker', 1) as helpers:\n"
        "    os.kill(helpers.processes[0].pid, signal.SIGKILL)\n"
        "    try: list(helpers.answers([{'toml': '', 'to_its_end': False}]))\n"
        "    except RuntimeError as error: print(error)\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(BUILD / "python")}
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, env=environment)
    assert run.stdout == "the process of a run ended by SIGKILL\n"


def test_the_end_of_a_process_in_words() -> None:
    said = [ended(status) for status in (3, -signal.SIGSEGV, -200)]
    assert said == ["ended with status 3", "ended by SIGSEGV", "ended by signal 200"]


def test_helpers_that_cannot_all_be_started_leave_none_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[subprocess.Popen[bytes]] = []
    start = subprocess.Popen

    def some(command: list[str], **how: Any) -> subprocess.Popen[bytes]:
        if started:
            raise OSError("no more processes")
        started.append(start([sys.executable, "-S", "-c", "input()"], **how))
        return started[0]

    monkeypatch.setattr("cmrc.processes.subprocess.Popen", some)
    with pytest.raises(OSError, match="no more processes"), Helpers("cmrc.limit_worker", 2):
        pass
    assert started[0].returncode == -signal.SIGKILL


def test_an_ideal_run_answers_within_a_latch_and_misses_nothing() -> None:
    result = cmrc.run(preset="saturated", dsps=1, duration_s=0.1, ideal=True)
    assert result.misses == 0
    for kind, task in result.report["tasks"].items():
        assert (task["response_ps"]["worst"] or 0) < 125_000_000 / 2, (
            kind
        )  # avoidance: 330 000 cycles of 40 ps, behind three others


def test_an_ideal_run_computes_what_the_real_one_does() -> None:
    # The drives take the same codes at the same latches, except for what the encoders see 80 us earlier.
    real, ideal = (cmrc.run(dsps=4, duration_s=0.5, ideal=ideal) for ideal in (False, True))
    for joint, error in real.report["pid_error"].items():
        assert ideal.report["pid_error"][joint]["rms"] == pytest.approx(error["rms"], rel=0.05, abs=2e-6)


def test_an_ideal_run_is_at_the_limit_of_instant_execution() -> None:
    # If time still counted, DSPs that take two thirds of it per cycle would control differently.
    slow, fast = (
        cmrc.run(dsps=2, duration_s=0.5, ideal=True, dsp_clock=clock).report for clock in ("C40-40", "C40-60")
    )
    assert slow["tasks"]["pid"]["response_ps"]["worst"] > 1.3 * fast["tasks"]["pid"]["response_ps"]["worst"]
    for joint, error in slow["pid_error"].items():
        assert fast["pid_error"][joint]["rms"] == pytest.approx(error["rms"], rel=1e-6), joint
    assert fast["control_cost"]["cost_m2s"] == pytest.approx(slow["control_cost"]["cost_m2s"], rel=1e-6)


def test_nothing_of_the_machine_fails_in_an_ideal_run_and_drives_do() -> None:
    events = [{"at_s": 0.01, "action": "fail", "dsp": 0}, {"at_s": 0.01, "action": "fail_drive", "joint": "hoist"}]
    result = cmrc.run(dsps=1, duration_s=0.04, ideal=True, events=events)
    [event] = result.report["timed_events"]
    assert "hoist" in event["what"]
    assert result.stop_reason == "completed" and result.report["dsps"][0]["state"] in ("idle", "running")


def test_the_host_of_an_ideal_run_stays_as_fast_when_the_operator_slows_the_host_down() -> None:
    slower = [{"at_s": 0.025, "action": "set", "key": "host.refresh_overhead_ns", "value": 50_000}]
    plain, slowed = (cmrc.run(dsps=1, duration_s=0.04, ideal=True, events=events) for events in ([], slower))
    assert slowed.hash == plain.hash
    assert cmrc.run(dsps=1, duration_s=0.04, events=slower).hash != cmrc.run(dsps=1, duration_s=0.04).hash


def test_a_comparison_is_the_difference_of_two_runs() -> None:
    real, ideal = (cmrc.run(dsps=1, duration_s=0.2, ideal=ideal).report for ideal in (False, True))
    found = cmrc.compare(dsps=1, duration_s=0.2)
    assert found["missed deadlines"] == {
        "unit": "",
        "measures": "quality",
        "run": sum(t["misses"] for t in real["tasks"].values()),
        "ideal": 0,
        "difference": 4,
    }
    for row, of in (
        ("load error", real["errors"]["load_m"]),
        ("error psi", real["errors"]["joints"]["psi"]),
        ("sway error beta", real["errors"]["sway"]["beta"]),
    ):
        assert found[f"{row} RMS"]["run"] == of["rms"] and found[f"{row} peak"]["run"] == of["peak"], row
        assert found[f"{row} RMS"]["ideal"] == 0
    cost = found["control cost"]
    assert (cost["run"], cost["ideal"]) == (real["control_cost"]["cost_m2s"], ideal["control_cost"]["cost_m2s"])
    assert {name for name, row in found.report["metrics"].items() if row["measures"] == "effort"} == {
        "drives, squared torque",
        *(f"drive {joint} at full torque" for joint in ("s", "psi", "phi", "l", "kappa")),
    }
    with pytest.raises(cmrc.ConfigError, match=r"run\.ideal"):
        cmrc.compare(duration_s=0.03, ideal=True)


@pytest.mark.parametrize("factor", [0.001, 101, 0])
def test_cycle_time_factors_have_bounds(factor: float) -> None:
    with pytest.raises(cmrc.ConfigError, match="cycle_time_factor"):
        cmrc.run(duration_s=0.01, cycle_time_factor=factor)


def test_longer_cycles_leave_the_buses_alone() -> None:
    slow = cmrc.run(dsps=2, duration_s=0.05, cycle_time_factor=1.37).report
    fast = cmrc.run(dsps=2, duration_s=0.05).report
    assert slow["dsps"][0]["clock_hz"] == pytest.approx(25e6 / 1.37, rel=1e-12)
    assert (
        slow["buses"]["A"]["clock_hz"] == fast["buses"]["A"]["clock_hz"]
        and slow["buses"]["A"]["clocks"] == fast["buses"]["A"]["clocks"]
    )
    for kind in ("pid", "torque_compensation"):
        own = [run["tasks"][kind]["execution_causes_ps"]["execute"] for run in (slow, fast)]
        assert own[0] / own[1] == pytest.approx(1.37, rel=0.02)


def test_the_first_miss_is_the_first_by_deadline() -> None:
    """Number 22 is dropped before number 21 ends late: it is found first."""
    found = cmrc.limits(cycles=[1], dsps=None, duration_s=0.1, settings={"machine.dsps": 1})
    [point] = found.report["scans"]["cycles"]["points"]
    single = cmrc.run(dsps=1, duration_s=0.1, settings={"report.reference": "none"}).report
    assert point["first_miss_s"] == min(miss["deadline_ps"] for miss in single["misses"]) / 1e12 == 0.022
