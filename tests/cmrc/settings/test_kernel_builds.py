"""The configuration chooses which build of a program the DSPs run."""

import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from cmrc import _core
from locations import ROOT

cmrc = _core.cmrc


def run(**settings: Any) -> dict[str, Any]:
    simulation = cmrc.Simulation(cmrc.config(settings={"report.reference": "none", **settings}))
    simulation.run()
    report: dict[str, Any] = json.loads(simulation.report_json())
    return report


def execution_us(report: dict[str, Any], task: str) -> float:
    return float(report["tasks"][task]["execution_ps"]["mean"]) / 1e6


def test_newton_euler_takes_the_place_of_the_closed_form() -> None:
    closed = run(duration_s=0.3)
    general = run(duration_s=0.3, **{"kernels.torque": "newton_euler"})
    assert execution_us(closed, "torque_compensation") < 60
    assert 150 < execution_us(general, "torque_compensation") < 220  # 4 400 cycles of 40 ns and the bus
    assert execution_us(general, "pid") == pytest.approx(execution_us(closed, "pid"), rel=0.05)
    assert sum(task["misses"] for task in general["tasks"].values()) == 0


@pytest.mark.parametrize(
    ("build", "least_us", "most_us"),
    [("potential_field", 150, 800), ("vfh", 300, 1500), ("dynamic_window", 8000, 10000)],
)
def test_avoidance_runs_once_per_agv_and_point(build: str, least_us: float, most_us: float) -> None:
    """Two AGVs that drive, the second 3.2 m behind the first: 20 ms per point; each block reads 180 rays over bus B."""
    report = run(duration_s=0.5, agvs=2, **{"kernels.avoidance": build, "load.driving": True})
    task = report["tasks"]["obstacle_avoidance"]
    assert 2 * 23 <= task["released"] <= 2 * 25
    assert least_us < execution_us(report, "obstacle_avoidance") < most_us
    assert sum(t["misses"] for t in report["tasks"].values()) == 0


def test_no_avoidance_means_none() -> None:
    report = run(duration_s=0.2, **{"kernels.avoidance": "none", "load.avoidance_cycles": 1000})
    assert report["tasks"]["obstacle_avoidance"]["released"] == 0


def test_the_quintic_build_plans_the_crane() -> None:
    blend = run(duration_s=0.3)
    quintic = run(duration_s=0.3, **{"kernels.trajectory": "quintic_shaper"})
    task = "trajectory_planning.crane"
    assert quintic["tasks"][task]["on_time"] == quintic["tasks"][task]["released"] > 30
    assert execution_us(quintic, task) > execution_us(blend, task)


def test_a_leg_begins_without_what_avoidance_said_on_the_one_before(tmp_path: Path) -> None:
    """DSPs whose start, 17 ms before the host's, leaves words there; avoidance itself does not run."""
    shutil.copytree(ROOT / "c40_programs", tmp_path / "programs")
    executive = tmp_path / "programs" / "executive.asm"
    start = "        sti     r0, @EXEC_PAUSE\n"
    words = ["AG_AVOID_LIMIT", "AG_AVOID_SHIFT", "AG_AVOID_HOLD", "AG_AVOID_WAIT", "AG_AVOID_PLACE", "AG_AVOID_BESIDE"]
    leave = "        ldhi    hi16(WINDOW_A + AG_BASE), ar4\n        or      lo16(WINDOW_A + AG_BASE), ar4\n        ldi     77, r1\n"
    leave += "".join(f"        sti     r1, *+ar4({word})\n" for word in words)
    text = executive.read_text()
    assert text.count(start) == 1
    executive.write_text(text.replace(start, start + leave))
    drive = """
[[processes]]
number = 2
name = "plan the grab"
robot = "none"
steps = ["task grab_path"]
may = [3, 9]
[[processes]]
number = 9
name = "drive at once"
robot = "agv"
subprocesses = [1, 2]
steps = ["leg 1"]
initial = [2]
"""
    settings = {
        "programs": str(tmp_path / "programs"),
        "dsps": 1,
        "machine.guard": False,
        "kernels.avoidance": "none",
        "duration_s": 0.03,
    }
    simulation = cmrc.Simulation(cmrc.config(toml=drive, settings=settings))

    def kept() -> list[int]:
        return [simulation.peek(simulation.symbol("AG_BASE") + simulation.symbol(word)) for word in words]

    simulation.run_until(0.019)
    assert kept() == [77] * len(words)
    simulation.run_until(0.03)
    assert simulation.peek(simulation.symbol("AG_BASE") + simulation.symbol("AG_LEG")) != 0
    assert kept() == [0] * len(words)
