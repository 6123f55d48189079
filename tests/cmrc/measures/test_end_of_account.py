"""Where the account of jobs ends: the instants at which a run ends early, and which releases belong to the account."""

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from cmrc import _core
from cmrc import run as run_dock
from locations import ROOT

cmrc = _core.cmrc
MS = 1_000_000_000  # ps


def event(at_s: float, action: str, **more: Any) -> dict[str, Any]:
    return {"at_s": at_s, "action": action, **more}


def simulation_of(events: list[dict[str, Any]], **settings: Any) -> Any:
    toml = settings.pop("toml", "")
    return cmrc.Simulation(
        cmrc.config(toml=toml, settings={"machine.dsps": 1, "report.reference": "none", **settings}, events=events)
    )


def report_of(events: list[dict[str, Any]], **settings: Any) -> dict[str, Any]:
    simulation = simulation_of(events, **settings)
    simulation.run()
    report: dict[str, Any] = json.loads(simulation.report_json())
    assert report["audit"]["violations"] == []
    return report


def end_of(report: dict[str, Any]) -> Any:
    return report["stop_reason"], report["account_end_s"]


@pytest.mark.parametrize("at_s", [0.1, 0.1001, 0.1099, 0.1099999])
@pytest.mark.parametrize("action", ["fail", "unplug"])
def test_no_dsp_is_left_half_a_second_after_the_last_one(action: str, at_s: float) -> None:
    report = report_of([event(at_s, action, dsp=0)], duration_s=0.7)
    assert end_of(report) == ("no_dsp_left", pytest.approx(at_s + 0.5, abs=1e-12))


def test_a_dsp_that_is_back_for_a_moment_has_worked() -> None:
    """The new board works from 592.4 to 599.9 ms, between two whole multiples of 10 ms."""
    events = [
        event(at, action, dsp=0)
        for at, action in ((0.1001, "unplug"), (0.5901, "plug"), (0.5999, "unplug"), (0.6001, "plug"))
    ]
    report = report_of(events, duration_s=0.7)
    assert end_of(report)[0] == "completed"
    assert report["tasks"]["pid"]["on_time"] > 150


def test_a_boot_that_is_given_up_is_the_end_of_the_last_dsp() -> None:
    report = report_of([event(0.1, "break_link", dsp=0), event(0.1001, "reset", dsp=0)], duration_s=0.7)
    [given_up] = [failure["time_s"] for failure in report["failures"] if failure["kind"] == "boot"]
    assert end_of(report) == ("no_dsp_left", pytest.approx(given_up + 0.5, abs=1e-12))


@pytest.mark.parametrize("after_stop_s", [0.5, 0.6])
def test_the_drives_have_stopped_for_the_whole_time(after_stop_s: float) -> None:
    report = report_of([event(0.1, "pause_host", lasts_ms=1000)], duration_s=1.0, **{"run.after_stop_s": after_stop_s})
    stopped = max(f["time_s"] for f in report["failures"] if "drive_stopped" in f["message"])
    assert end_of(report) == ("drives_stopped", pytest.approx(stopped + after_stop_s, abs=1e-12))


def test_the_end_does_not_depend_on_how_the_run_is_divided() -> None:
    events = [event(0.1099, "fail", dsp=0)]
    whole = simulation_of(events, duration_s=0.7)
    whole.run()
    parts = simulation_of(events, duration_s=0.7)
    for at in (0.05, 0.1099, 0.60985, 0.6099, 0.60995, 0.65, 0.7):
        parts.run_until(at)
    reports = [json.loads(simulation.report_json()) for simulation in (whole, parts)]
    for report in reports:
        del report["elapsed_s"]
    assert reports[0] == reports[1] and end_of(reports[0]) == ("no_dsp_left", 0.6099)


# ---- which releases belong to the account ----

SCRIPTS: dict[str, list[dict[str, Any]]] = {
    "all works": [],
    "the host is paused": [event(0.15, "pause_host", lasts_ms=100)],
    "the bus is stalled": [event(0.15, "stall_bus", bus="A", lasts_ms=100)],
    "no DSP works": [event(0.1501, "fail", dsp=dsp) for dsp in range(4)],
}


@pytest.mark.parametrize("duration_s", [0.19899, 0.199, 0.19901, 0.19999, 0.2, 0.20001])
@pytest.mark.parametrize("script", SCRIPTS)
def test_each_tick_before_the_end_is_counted_and_no_other(script: str, duration_s: float) -> None:
    ticks = sum(1 for k in range(20, 400) if k * MS < round(duration_s * 1e12))
    report = report_of(SCRIPTS[script], duration_s=duration_s, **{"machine.dsps": 4})
    for kind in ("pid", "torque_compensation"):
        row = report["tasks"][kind]
        assert row["released"] == ticks
        if script in ("the host is paused", "the bus is stalled"):
            assert (row["never_started"], row["dropped"]) == (1, ticks - 131)  # the job of 150 ms is in the way


@pytest.mark.parametrize("dsps", [1, 4])
@pytest.mark.parametrize(("duration_s", "ticks"), [(0.022, 2), (0.022001, 3), (0.023, 3)])
def test_the_last_tick_does_not_depend_on_what_is_late(dsps: int, duration_s: float, ticks: int) -> None:
    report = report_of([], duration_s=duration_s, **{"machine.dsps": dsps})
    assert [report["tasks"][kind]["released"] for kind in ("pid", "torque_compensation")] == [ticks, ticks]


def test_a_tick_that_the_host_has_not_come_to_was_never_started() -> None:
    """The host is out from 150.3 ms on: the job of 151 ms is in the list, those of 152 to 154 ms are not."""
    report = report_of([event(0.1503, "pause_host", lasts_ms=50)], duration_s=0.1545, **{"machine.dsps": 4})
    row = report["tasks"]["pid"]
    assert row["released"] == 135
    assert row["on_time"] + row["never_started"] + row["dropped"] == 135 and row["dropped"] == row["misses"] - 1


def test_no_more_is_demanded_than_the_rate() -> None:
    rates = run_dock(dsps=4, duration_s=0.05).report["rates"]["f_p"]
    assert rates["demanded_hz"] == rates["realised_hz"] == rates["nominal_hz"] == pytest.approx(1000, rel=1e-12)


def test_a_dropped_tick_was_released_gamma_before_its_tick() -> None:
    report = report_of([], duration_s=0.1, **{"scheduling.gamma_refreshes": 4})
    missed = {(miss["kind"], miss["outcome"]): miss for miss in report["misses"]}
    assert {outcome for _, outcome in missed} == {"late", "dropped"}
    for miss in missed.values():
        assert miss["release_ps"] == miss["number"] * MS - MS // 2


# ---- how long a DSP was occupied ----


def test_a_dsp_that_was_reset_is_not_occupied_by_its_old_block() -> None:
    """The only DSP is reset in identify, and runs nine ticks before the watchdog takes identify away."""
    report = report_of(
        [event(0.0203, "reset", dsp=0)],
        duration_s=0.03,
        **{"machine.boot": "preloaded", "watchdog.minimum_refreshes": 60},
    )
    dsp = report["dsps"][0]
    awake_ps = (dsp["cycles"] - dsp["causes"]["idle"] - dsp["causes"]["halted"]) * 40_000
    assert 0.5 * awake_ps < sum(dsp["tasks_ps"].values()) <= awake_ps


# ---- a user's task ----


def task(tmp_path: Path, period_ms: float, deadline_ms: float = 0.0, **more: Any) -> dict[str, Any]:
    """A task that runs for some 6 us."""
    shutil.copytree(ROOT / "c40_programs", tmp_path / "programs")
    source = "kernel_short:\n        ldi     50, rc\n        rpts    rc\n        nop\n        retsu\n"
    (tmp_path / "programs" / "kernels" / "user.asm").write_text(source)
    row = f'[[tasks]]\nname = "a"\nprogram = "kernel_short"\nkind = 14\nimportance = 62463\nperiod_ms = {period_ms}\n'
    return {"toml": row + f"deadline_ms = {deadline_ms}\n", "machine.programs": str(tmp_path / "programs"), **more}


@pytest.mark.parametrize("refreshes", [7, 8, 87, 159, 161])
def test_a_task_is_released_at_the_multiples_of_its_period_from_the_first_refresh_on(
    tmp_path: Path, refreshes: int
) -> None:
    """The first refresh is number 160, and the last before the end number 799."""
    simulation = simulation_of([], **task(tmp_path, refreshes / 8), duration_s=0.1, **{"machine.dsps": 4})
    simulation.keep_text_of_events()
    simulation.run()
    loads = [line for line in simulation.events_text().splitlines() if re.search(r" load .*kind=12 ", line)]
    ticks = [int(re.search(r" tick=(\d+)", line)[1]) for line in loads]  # type: ignore[index]
    assert ticks == [tick for tick in range(160, 800) if tick % refreshes == 0]


@pytest.mark.parametrize("deadline_ms", [0.0, 0.5])
def test_periods_for_which_the_host_is_late_are_dropped(tmp_path: Path, deadline_ms: float) -> None:
    """The host is out from 49.7 to 59.7 ms: the periods of 50 to 58 ms are dropped, that of 59 ms is released then."""
    report = report_of(
        [event(0.0497, "pause_host", lasts_ms=10)],
        **task(tmp_path, 1, deadline_ms),
        duration_s=0.08,
        **{"machine.dsps": 4},
    )
    row = report["tasks"]["user.a"]
    assert (row["released"], row["on_time"], row["dropped"], row["misses"]) == (60, 51, 9, 9)
    cut = report_of(
        [event(0.0497, "pause_host", lasts_ms=10)],
        **{**task(tmp_path / "again", 1, deadline_ms), "duration_s": 0.0562, "machine.dsps": 4},
    )["tasks"]["user.a"]
    assert (cut["released"], cut["on_time"], cut["dropped"], cut["never_started"]) == (37, 30, 6, 1)


def test_a_block_that_is_given_up_is_a_miss_in_the_trace(tmp_path: Path) -> None:
    programs = task(tmp_path, 10)
    source = tmp_path / "programs" / "kernels" / "user.asm"
    source.write_text("kernel_short:\n        br      kernel_short\n")
    once = {"watchdog.long_run_us": 1000, "watchdog.recomputations_max": 0, "watchdog.retries_max": 0}
    simulation = simulation_of([], **programs, duration_s=0.05, **once, **{"machine.dsps": 2})
    simulation.keep_text_of_events()
    simulation.run()
    report = json.loads(simulation.report_json())
    found = [line for line in simulation.events_text().splitlines() if re.search(r" miss .*kind=12 .*class=5", line)]
    assert len(found) == report["tasks"]["user.a"]["dropped"] == 1
