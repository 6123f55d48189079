"""1 to 16 DSPs by 1 to 8 AGVs: every run ends as it should, and its accounts hold."""

import json
from typing import Any

import pytest
from cmrc import _core

cmrc = _core.cmrc
OUTCOMES = ("on_time", "late", "unfinished", "never_started", "lost", "dropped")
ALL = [(dsps, agvs) for dsps in range(1, 17) for agvs in range(1, 9)]


def check(dsps: int, agvs: int, duration_s: float, preset: str = "base", **settings: Any) -> dict[str, Any]:
    simulation = cmrc.Simulation(
        cmrc.config(
            preset=preset,
            settings={"dsps": dsps, "agvs": agvs, "duration_s": duration_s, "report.reference": "none", **settings},
        )
    )
    simulation.run()
    report: dict[str, Any] = json.loads(simulation.report_json())
    assert report["stop_reason"] == "completed"
    assert report["audit"]["violations"] == [] and report["audit"]["checks"] > 0
    for task in report["tasks"].values():
        assert task["released"] == sum(task[name] for name in OUTCOMES)
    assert len(report["dsps"]) == dsps
    for dsp in report["dsps"]:
        assert sum(dsp["causes"].values()) == dsp["cycles"]
        assert dsp["resets"] == dsp["faults"] == 0
    for bus in report["buses"].values():
        assert sum(bus["clocks_by_use"].values()) == bus["clocks"]
    assert [failure for failure in report["failures"] if failure["kind"] != "plant"] == []
    return report


@pytest.mark.parametrize(("dsps", "agvs"), [(1, 1), (1, 8), (2, 5), (3, 3), (5, 8), (8, 1), (11, 6), (16, 1), (16, 8)])
def test_accounts_hold_for_any_number_of_dsps_and_agvs(dsps: int, agvs: int) -> None:
    report = check(dsps, agvs, 0.1)
    if dsps > 1:
        assert sum(task["misses"] for task in report["tasks"].values()) == 0


@pytest.mark.campaign
@pytest.mark.parametrize("preset", ["base", "heavy", "saturated"])
@pytest.mark.parametrize(("dsps", "agvs"), ALL)
def test_the_whole_matrix(preset: str, dsps: int, agvs: int) -> None:
    check(dsps, agvs, 0.3, preset)


@pytest.mark.campaign
@pytest.mark.parametrize("options", [
    {"pid_after_torque": True, "slice_cycles": 10_000},
    {"long_blocks_max": 1, "idle_policy": "spin"},
    {"servo_reload": "inherited", "gamma_refreshes": 1, "equation": "as_printed", "idle_policy": "pause"},
    {"work_mode": "slowed_crane", "agv_buffer_points": 4, "time_after_delay": "one"},
])  # fmt: skip
@pytest.mark.parametrize(("dsps", "agvs"), [(1, 1), (2, 2), (4, 4), (16, 8)])
def test_options_together(options: dict[str, Any], dsps: int, agvs: int) -> None:
    check(dsps, agvs, 1.0, **options)
