"""A DSP that is reset in the middle of an access to the plant, at the very instant of a latch.

The broken access ends at the next bus clock, a few nanoseconds after the latch's turn. Seed 7483 of the random docks
found it.
"""

import json
from pathlib import Path

import pytest
from cmrc import _core
from files_of_docks import files_of_users
from random_docks import Dock

EVENTS = (
    {"at_s": 0.000875, "action": "freeze", "dsp": 7},
    {"at_s": 0.0065, "action": "freeze", "dsp": 0},
    {"at_s": 0.048625, "action": "reset", "dsp": 6},
)
TASK = '\n[[tasks]]\nname = "t1"\nprogram = "kernel_user_counts"\nkind = 17\nimportance = 65530\nperiod_ms = 20\ndeadline_ms = 20\ndsp = 3\n'


@pytest.mark.parametrize(
    "and_then", [(), ({"at_s": 0.048625, "action": "stick_load_cell"},)], ids=["reset", "reset and a sensor"]
)
def test_the_plant_may_be_a_bus_clock_past_its_turn(tmp_path: Path, and_then: tuple[dict[str, object], ...]) -> None:
    settings = {
        "machine.dsps": 8, "run.seed": 219335236, "run.duration_s": 0.049, "report.reference": "none", "dock.agvs": 7, "machine.boot": "preloaded",
        "kernels.avoidance": "dynamic_window", "machine.idle_policy": "spin", "machine.programs": str(files_of_users(tmp_path / "programs")),
    }  # fmt: skip
    simulation = _core.cmrc.Simulation(Dock("saturated", settings, (TASK,), (*EVENTS, *and_then)).config())
    simulation.run()
    assert json.loads(simulation.report_json())["simulated_ps"] == 49 * 10**9
