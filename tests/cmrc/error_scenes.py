"""The crane in a scene with errors: events, the report, and how fast the joints move."""

import json
from typing import Any

import numpy as np
from cmrc import _core
from low_rates import AT_ONCE_AND_LOW

cmrc = _core.cmrc
Report = dict[str, Any]
SERVO = 1 / 250
LEG = 3.0
"""s: the crane is under way in its first leg, from 0.05 to 18 s."""
LOWERING = 22.0
"""s: it lowers the spreader onto the container, from 21 to 24 s."""
EVERYTHING = ["travel", "slew", "luff", "hoist", "rotate"]
EVERY_RATE = ("s", "psi", "phi", "l", "kappa")


def at(at_s: float, action: str, **what: Any) -> dict[str, Any]:
    return {"at_s": at_s, "action": action, **what}


def clear(at_s: float) -> dict[str, Any]:
    return at(at_s, "set", key="errors.clear", value=True)


# m/s of the hoist after the path has stopped: damping the swing pays out rope at this speed. On the path it is 0.1 and
# more.
STILL = 5e-3


def run(duration_s: float, *events: dict[str, Any], **settings: Any) -> tuple[Report, Any]:
    simulation = cmrc.Simulation(
        cmrc.config(settings={**AT_ONCE_AND_LOW, "duration_s": duration_s, **settings}, events=list(events))
    )
    simulation.run()
    report = json.loads(simulation.report_json())
    assert report["audit"]["violations"] == []
    return report, simulation


def only(report: Report) -> dict[str, Any]:
    [error] = report["errors_handled"]
    return dict(error)


def rates(simulation: Any, at_s: float) -> dict[str, float]:
    signals = simulation.signals()
    row = signals["time_s"].searchsorted(at_s)
    return {name.split("_rate")[0]: abs(float(signals[name][row])) for name in signals if "_rate_" in name}


def load(simulation: Any) -> tuple[np.ndarray, np.ndarray]:
    signals = simulation.signals()
    return signals["time_s"], np.column_stack([signals[f"payload_{axis}_m"] for axis in "xyz"])
