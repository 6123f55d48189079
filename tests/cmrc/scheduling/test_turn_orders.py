"""Turn orders: the run is the same in every order in which the emulator advances the chips. test_random_docks.py has
random failures."""

import json
from pathlib import Path

from cmrc import _core

cmrc = _core.cmrc
TURN_ORDER_TOML = """
[machine]
dsps = 1
boot = "preloaded"
[run]
duration_s = 0.1
[[events]]
at_s = 0.03
action = "slow"
dsp = 0
factor = 0.001
[[events]]
at_s = 0.0724291
action = "hang"
dsp = 0
"""


def test_a_chip_that_is_slow_and_then_hangs(tmp_path: Path) -> None:
    """The chip had been run ahead past the last event before the slice's end, and the event behind it was taken out of
    turn."""
    file = tmp_path / "turn_order.toml"
    file.write_text(TURN_ORDER_TOML)
    reports = set()
    for order in range(10):
        simulation = cmrc.Simulation(
            cmrc.config(file=str(file), settings={"turn_order": order, "report.reference": "none"})
        )
        simulation.run()
        report = json.loads(simulation.report_json())
        reports.add((report["hash"], json.dumps(report["tasks"])))
    assert len(reports) == 1
