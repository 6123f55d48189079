"""Draws a picture of docs/ from runs. Needs Matplotlib.

PYTHONPATH=build/python .venv/bin/python scripts/documents/pictures.py dock docs/pictures/dock.png
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from cmrc import Simulation, files, plot
from cmrc.page import Recording

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def dock() -> Figure:
    """110 s with two DSPs and two AGVs. From second 40 to second 42 both DSPs have a sixteenth of their clock."""
    from matplotlib.figure import Figure

    events = [
        {"at_s": at_s, "action": "slow", "dsp": dsp, "factor": factor}
        for at_s, factor in ((40.0, 1 / 16), (42.0, 1.0))
        for dsp in (0, 1)
    ]
    simulation = Simulation(dsps=2, duration_s=110.0, events=events, settings={"dock.agvs": 2})
    simulation.record()
    simulation.run()
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "dock.html"
        simulation.write_page(page)
        recording = Recording.read(page)
    figure = Figure(figsize=(11, 7.4), layout="constrained")
    grid = figure.add_gridspec(3, 2, height_ratios=(2.2, 1, 1), width_ratios=(1.35, 1))
    plot.plan(recording, figure.add_subplot(grid[0, 0]))
    plot.side(recording, figure.add_subplot(grid[0, 1]))
    plot.tracking(recording, figure.add_subplot(grid[1, :]))
    plot.deadlines(recording, figure.add_subplot(grid[2, :]))
    return figure


PICTURES: dict[str, Callable[[], Figure]] = {"dock": dock}


def main(arguments: list[str]) -> int:
    if len(arguments) != 2 or arguments[0] not in PICTURES:
        print(f"{__doc__}\nPictures: {', '.join(PICTURES)}", file=sys.stderr)
        return 2
    name, path = arguments
    figure = PICTURES[name]()
    with files.writing(Path(path)) as out:
        figure.savefig(out, dpi=90, format="png", metadata={"Software": None})
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
