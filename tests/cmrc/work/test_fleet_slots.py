"""Slots of the queue before the loading spot: no two vehicles have the same slot (docs/processes.md, `queue`)."""

import json
import math
from pathlib import Path

import pytest
from cmrc import _core
from low_rates import AT_ONCE_AND_LOW

cmrc = _core.cmrc
RADIUS = 12.0
HALF_TURN = math.pi * RADIUS
# A short loop from the spot at (22, 8) m: 20 m ahead, a half turn to the warehouse at (42, -16), 62 m back, a half turn
# behind the portal, 42 m to the spot.
LAYOUT = f"""
containers = []
[warehouse]
x_m = 42.0
y_m = -16.0
heading_deg = 180.0
[lanes]
to_warehouse = [[20, 0, 5], [{HALF_TURN}, {-1 / RADIUS}, 3]]
to_spot = [[62, 0, 5], [{HALF_TURN}, {-1 / RADIUS}, 3], [42, 0, 5]]
"""
# The crane sends off the vehicle that stands in the spot, once; then the crane rests, and nothing else begins.
PROCESSES = """
[[processes]]
number = 1
name = "begin"
robot = "none"
steps = ["task identify"]
must = [4]
may = [2]
loaded = true
[[processes]]
number = 3
name = "rest"
robot = "crane"
steps = ["hold 1000"]
may = [4, 7, 8]
[[processes]]
number = 4
name = "send"
robot = "crane"
steps = ["hold 0.5"]
must = [5]
may = [3]
[[processes]]
number = 5
name = "out"
robot = "agv"
subprocesses = [1, 2]
steps = ["leg 1"]
must = [6]
[[processes]]
number = 6
name = "in"
robot = "agv"
subprocesses = [1, 2]
steps = ["queue"]
may = [4]
[[processes]]
number = 7
name = "crane rests"
robot = "crane"
steps = ["hold 1"]
[[processes]]
number = 8
name = "AGV rests"
robot = "agv"
steps = ["hold 1"]
"""


def test_one_that_comes_back_queues_behind_the_one_that_has_moved_up(tmp_path: Path) -> None:
    layout = tmp_path / "loop.toml"
    layout.write_text(LAYOUT, encoding="utf-8")
    settings = {
        **AT_ONCE_AND_LOW,
        "dock.agvs": 2,
        "duration_s": 80,
        "dock.layout": str(layout),
        "signal_decimation": 800,
    }
    simulation = cmrc.Simulation(cmrc.config(toml=PROCESSES, settings=settings))
    simulation.run()
    assert json.loads(simulation.report_json())["audit"]["violations"] == []
    assert [event for event in simulation.dock_events() if event[1] == "collision"] == []
    signals = simulation.signals()
    place = [(float(signals[f"agv{agv}_x_m"][-1]), float(signals[f"agv{agv}_y_m"][-1])) for agv in (0, 1)]
    assert place[1] == pytest.approx((22.0, 8.0), abs=0.3)  # it had been in slot 1, and is in the spot
    assert place[0] == pytest.approx((4.0, 8.0), abs=0.3)  # slot 1, 18 m before the spot
    assert all(abs(float(signals[f"agv{agv}_speed_m_per_s"][-1])) < 0.02 for agv in (0, 1))
