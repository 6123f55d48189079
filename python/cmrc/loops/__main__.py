"""``python -m cmrc.loops``: the tables and plots of docs/control.md."""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cmrc import _core
from cmrc.extras import needed
from cmrc.loops import measured
from cmrc.loops.model import (
    FREQUENCIES,
    JOINTS,
    PRESETS,
    TRAVEL_RAD_S,
    Loop,
    assumed_inertias,
    margins,
    moved_inertias,
    poses,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BLOCKS = ("margins", "poses", "found")


def margins_table() -> str:
    """Margins by bandwidth, where the gain fits the inertia."""
    lines = [
        "| bandwidth, rad/s | crossover, Hz | phase margin | delay margin, ms | Ms |",
        "|---|---|---|---|---|",
    ]
    for bandwidth in (TRAVEL_RAD_S, 25.0, 40.0, 60.0, 80.0, 100.0):
        m = margins(Loop(bandwidth))
        lines.append(f"| {bandwidth:g} | {m.crossover_hz:.1f} | {m.phase_deg:.0f}° | {m.delay_ms:.2f} | {m.peak:.2f} |")
    return "\n".join(lines)


def poses_table() -> str:
    """The range over all poses and loads: the inertia moved, how well the gain fits it, and the delay margin of both
    presets."""
    crane = _core.plant.CraneParameters()
    lines = [
        "| joint | inertia moved | assumed / moved | delay margin `base`, ms | delay margin `tight`, ms |",
        "|---|---|---|---|---|",
    ]
    every = list(poses())
    for j, joint in enumerate(JOINTS):
        moved = [moved_inertias(pose, crane)[j] for pose in every]
        ratios = [assumed_inertias(pose, crane)[j] / m for pose, m in zip(every, moved, strict=True)]
        unit = "kg" if joint in ("travel", "hoist") else "kg m²"
        cells = [f"{min(moved):.3g} … {max(moved):.3g} {unit}", f"{min(ratios):.3f} … {max(ratios):.3f}"]
        for bandwidth in PRESETS.values():
            loop = Loop(TRAVEL_RAD_S if joint == "travel" else bandwidth)
            delays = [margins(loop, ratio).delay_ms for ratio in (min(ratios), max(ratios))]
            cells.append(f"{min(delays):.2f} … {max(delays):.2f}")
        lines.append(f"| {joint} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def found() -> list[tuple[str, str, float, float, float]]:
    """Preset, joint, predicted margin, longest stable and shortest unstable added delay, ms."""
    rows = []
    for preset, bandwidth in PRESETS.items():
        predicted = margins(Loop(bandwidth)).delay_ms
        for joint in measured.TESTED:
            rows.append((preset, joint, predicted, *measured.found_ms(joint, bandwidth, predicted)))
    return rows


def found_table(rows: list[tuple[str, str, float, float, float]]) -> str:
    """Predicted margins and those found in runs."""
    lines = ["| preset | joint | predicted, ms | stable with, ms | unstable with, ms |", "|---|---|---|---|---|"]
    lines += [f"| `{preset}` | {joint} | {p:.2f} | {a:.3f} | {b:.3f} |" for preset, joint, p, a, b in rows]
    return "\n".join(lines)


def _figures() -> Any:
    """matplotlib.figure. Raises ImportError."""
    return needed("matplotlib.figure", "plot", "--page")


def bode() -> Figure:
    """The open loops of both presets, and the sensitivity at each frequency."""
    figure: Figure = _figures().Figure(figsize=(8, 7), layout="constrained")
    size, phase, sensitivity = figure.subplots(3, 1, sharex=True)
    hertz = FREQUENCIES / (2 * math.pi)
    for (preset, bandwidth), colour in zip(PRESETS.items(), ("C0", "C3"), strict=True):
        loop = Loop(bandwidth)
        response, m = loop.open(FREQUENCIES), margins(loop)
        size.loglog(hertz, np.abs(response), colour, label=f"{preset}: {bandwidth:g} rad/s")
        phase.semilogx(hertz, np.degrees(np.unwrap(np.angle(response))) - 360, colour)
        sensitivity.loglog(hertz, np.abs(1 / (1 + response)), colour, label=f"Ms = {m.peak:.2f}")
        for axis in (size, phase):
            axis.axvline(m.crossover_hz, color=colour, linestyle=":", linewidth=1)
    size.axhline(1, color="0.5", linewidth=1)
    phase.axhline(-180, color="0.5", linewidth=1)
    size.set(ylabel="|L|", ylim=(1e-3, 1e4))
    phase.set(ylabel="phase of L, degrees", ylim=(-360, -90))
    sensitivity.set(ylabel="|1 / (1 + L)|", xlabel="Hz", ylim=(1e-3, 5))
    for axis in (size, phase, sensitivity):
        axis.grid(visible=True, which="both", alpha=0.2)
    size.legend()
    sensitivity.legend()
    return figure


def by_delay(rows: list[tuple[str, str, float, float, float]]) -> Figure:
    """The delay margin over the bandwidth, and the results of runs."""
    figure: Figure = _figures().Figure(figsize=(7, 4), layout="constrained")
    axis = figure.subplots()
    bandwidths = np.linspace(15, 110, 60)
    for ratio, style in ((1.0, "-"), (0.9, ":"), (1.1, "--")):
        delays = [margins(Loop(float(b)), ratio).delay_ms for b in bandwidths]
        axis.semilogy(
            bandwidths,
            delays,
            f"k{style}",
            linewidth=1,
            label=f"predicted, gain {ratio:g} of what the inertia asks for",
        )
    marks = dict(zip(measured.TESTED, "os^v", strict=True))
    for preset, joint, _, stable, unstable in rows:
        label = joint if preset == "base" else None
        axis.plot(PRESETS[preset], (stable + unstable) / 2, marks[joint], markersize=5, label=label)
    axis.set(xlabel="bandwidth, rad/s", ylabel="delay margin, ms")
    axis.grid(visible=True, which="both", alpha=0.2)
    axis.legend(fontsize=8)
    return figure


def marks(block: str) -> tuple[str, str]:
    """The marks before and after a table of the page."""
    return f"<!-- loops {block}: python -m cmrc.loops --page docs/control.md -->", f"<!-- end of {block} -->"


def replaced(page: str, block: str, table: str) -> str:
    """The page with this table."""
    first, last = marks(block)
    begin, end = page.index(first) + len(first), page.index(last)
    return f"{page[:begin]}\n\n{table}\n\n{page[end:]}"


def main() -> int:
    """Prints the tables, or puts them into the page and the plots beside it."""
    parser = argparse.ArgumentParser(
        prog="cmrc.loops", description="Margins of the crane's servo loops, predicted and found."
    )
    parser.add_argument(
        "--page", type=Path, help="put the tables into this page, and the plots into a folder of its name"
    )
    arguments = parser.parse_args()
    page = arguments.page
    if page is not None and not page.is_file():
        print(f"cmrc.loops: {page} is not a file; the page docs/control.md is expected", file=sys.stderr)
        return 2
    text = "" if page is None else page.read_text()
    missing = [mark for block in BLOCKS for mark in marks(block) if page is not None and mark not in text]
    if missing:
        print(
            f"cmrc.loops: {page} has no line {missing[0]}; a page with the marks of docs/control.md is expected",
            file=sys.stderr,
        )
        return 2
    if page is not None:
        try:
            _figures()
        except ImportError as error:
            print(f"cmrc.loops: {error}", file=sys.stderr)
            return 2
    rows = found()
    tables = dict(zip(BLOCKS, (margins_table(), poses_table(), found_table(rows)), strict=True))
    if page is None:
        print("\n\n".join(tables.values()))
        return 0
    for block, table in tables.items():
        text = replaced(text, block, table)
    folder = page.with_suffix("")
    folder.mkdir(exist_ok=True)
    with needed("matplotlib", "plot", "--page").rc_context({"svg.hashsalt": "cmrc", "svg.fonttype": "none"}):
        for name, figure in (("bode", bode()), ("delay", by_delay(rows))):
            figure.savefig(folder / f"{name}.svg", metadata={"Date": None, "Creator": None})
    page.write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
