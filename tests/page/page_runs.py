"""The runs of these tests, and how their pages are written."""

from pathlib import Path
from typing import Any

import cmrc
from cmrc.page import Recording

HOSTILE = '<!--<script>alert("x")</script>--> \u0007\u2028 "\'&<b>'

KILLED_AT_S = 0.2
BUSY: dict[str, Any] = {
    "machine.dsps": 3,
    "dock.agvs": 4,
    "load.driving": True,
    "kernels.avoidance": "dynamic_window",
    "scheduling.agv_phase": "together",
    "duration_s": 0.4,
    "report.misses_max": 200,
}
"""Three DSPs behind four vehicles that look for obstacles at once: the servo misses; then a DSP dies."""
KILLED = [{"at_s": KILLED_AT_S, "action": "fail", "dsp": 1}]


def recorded(
    settings: dict[str, Any], events: list[dict[str, Any]], path: Path, title: str | None = None
) -> tuple[cmrc.Simulation, Recording]:
    """A run to its end, its page in ``path``."""
    simulation = cmrc.Simulation(settings=settings, events=events)
    simulation.record()
    simulation.run()
    simulation.write_page(path, title)
    return simulation, Recording.read(path)
