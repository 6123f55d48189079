"""Plots. Needs matplotlib.

For a result: ``sheet``, ``gantt``, ``histogram``, ``cdf``, ``misses``, ``load_error``. For a sweep: ``grid``, ``cost``.
For a recorded run (``cmrc.page.Recording``): ``plan`` and ``side`` view, ``joints`` and their ``tracking``, ``sway``,
``deadlines``, and ``overview`` with all of them.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from cmrc.arguments import drawn_from
from cmrc.page import Recording
from cmrc.result_plots import cdf, gantt, histogram, legend, load_error, misses, name_rows, sheet, style
from cmrc.sweep_plots import cost, grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "cdf",
    "cost",
    "deadlines",
    "gantt",
    "grid",
    "histogram",
    "joints",
    "load_error",
    "misses",
    "overview",
    "plan",
    "sheet",
    "side",
    "sway",
    "tracking",
]

JOINTS = {
    "s_m": "gantry, m",
    "psi_rad": "slew, rad",
    "phi_rad": "luff, rad",
    "trolley_m": "trolley, m",
    "l_m": "rope, m",
    "kappa_rad": "rotator, rad",
}


MET_MISSED = {"all met": "#a9cfe0", "one missed": "#a03000"}
"""Light and dark, so that they differ in grey, too."""


_of_recording = drawn_from("recording", lambda: Recording, "a cmrc.page.Recording")


def _edges(recording: Recording) -> list[float]:
    """Edges of the intervals over which jobs and errors are summed: at most 360."""
    begin, end = float(recording.header["from_s"]), float(recording.header["to_s"])
    slices = max(1, min(360, math.ceil((end - begin) / 0.05)))
    return [begin + (end - begin) * i / slices for i in range(slices + 1)]


@_of_recording
def plan(recording: Recording, axes: Axes) -> None:
    """From above: ship, fixed boxes, the crane's legs, containers, lanes, the load's path, the AGVs' paths with their
    outlines at the end."""
    from matplotlib.patches import Circle, Polygon
    from matplotlib.transforms import ScaledTranslation

    layout, signals = recording.header["layout"], recording.signals

    def outline(x: float, y: float, yaw: float, length: float, width: float, **style: Any) -> None:
        corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * [length / 2, width / 2]
        turned = corners @ np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]]) + [x, y]
        axes.add_patch(Polygon(turned, closed=True, **style))

    for box in [layout["ship"], *layout["boxes"]]:
        outline(
            (box[0] + box[1]) / 2, (box[2] + box[3]) / 2, 0.0, box[1] - box[0], box[3] - box[2], fc="0.85", ec="0.5"
        )
    for x, y, _, yaw in layout["containers"]:
        outline(x, y, yaw, *layout["size"][:2], fc="tab:orange", ec="k", alpha=0.5)
    for x, y, heading, length, curvature in layout["lanes"]:
        d = np.linspace(0.0, length, 40)
        h = heading + curvature * d
        if curvature:
            axes.plot(
                x + (np.sin(h) - np.sin(heading)) / curvature,
                y - (np.cos(h) - np.cos(heading)) / curvature,
                "0.8",
                lw=4,
            )
        else:
            axes.plot(x + d * np.cos(heading), y + d * np.sin(heading), "0.8", lw=4)
    axes.plot(signals["payload_x_m"], signals["payload_y_m"], lw=1, label="load", **style(0))
    for i in range(layout["agv"]["count"]):
        x, y = signals[f"agv{i}_x_m"], signals[f"agv{i}_y_m"]
        (path,) = axes.plot(x, y, lw=1.2, label=f"AGV {i}", **style(1 + i))
        outline(
            x[-1],
            y[-1],
            signals[f"agv{i}_heading_rad"][-1],
            layout["agv"]["length"],
            layout["agv"]["width"],
            fill=False,
            ec=path.get_color(),
        )
    portal = layout["crane"]["portal"]
    for rail in portal["rails"]:
        for along in (portal["along"], -portal["along"]):
            outline(signals["s_m"][-1] + along, rail, 0.0, portal["leg"], portal["leg"], fc="0.3", ec="k")
    for i, (radius, _) in enumerate(layout["movers"]):
        x, y = signals[f"mover{i}_x_m"], signals[f"mover{i}_y_m"]
        axes.plot(x, y, "tab:red", lw=0.8, ls=":", label="obstacles" if i == 0 else None)
        axes.add_patch(Circle((x[-1], y[-1]), radius, fc="tab:red", ec="k", alpha=0.6))
    axes.set(aspect="equal", xlabel="x, m", ylabel="y, m", title="plan")
    below = (
        axes.transAxes + ScaledTranslation(0.0, -0.45, figure.dpi_scale_trans)
        if (figure := axes.get_figure())
        else axes.transAxes
    )
    axes.legend(fontsize=7, ncols=5, loc="upper center", bbox_to_anchor=(0.5, 0.0), bbox_transform=below, frameon=False)


@_of_recording
def side(recording: Recording, axes: Axes) -> None:
    """Across the quay: the paths of the jib's tip or the trolley and of the load over y and z."""
    signals, layout = recording.signals, recording.header["layout"]
    ship = layout["ship"]
    axes.fill([ship[2], ship[3], ship[3], ship[2]], [0, 0, ship[5], ship[5]], color="0.85")
    axes.plot(
        signals["tip_y_m"], signals["tip_z_m"], "0.5", lw=1, label="trolley" if "trolley_m" in signals else "jib tip"
    )
    axes.plot(signals["payload_y_m"], signals["payload_z_m"], lw=1, label="load", **style(1))
    for every in range(0, len(signals["time_s"]), max(1, len(signals["time_s"]) // 12)):
        axes.plot(
            [signals[f"{p}_y_m"][every] for p in ("tip", "payload")],
            [signals[f"{p}_z_m"][every] for p in ("tip", "payload")],
            "k",
            lw=0.4,
        )
    axes.set(aspect="equal", xlabel="y, m", ylabel="z, m", title="side view, ropes at twelve instants")
    legend(axes)


@_of_recording
def joints(recording: Recording, axes: Axes) -> None:
    """The joints over time, each scaled to its own range."""
    signals = recording.signals
    for n, (name, label) in enumerate(JOINTS.items()):
        if name not in signals or (name == "psi_rad" and "trolley_m" in signals):
            continue  # a joint of the other crane, or a gantry's slewing, which does not move
        values = np.array(signals[name])
        span = max(float(np.ptp(values)), 0.02)  # a joint that is held is a flat line
        axes.plot(
            signals["time_s"],
            (values - values.min()) / span,
            lw=1,
            label=f"{label}: {values.min():.2f} to {values.max():.2f}",
            **style(n),
        )
    axes.set(xlabel="time, s", ylabel="share of its range", title="joints")
    legend(axes)


@_of_recording
def tracking(recording: Recording, axes: Axes) -> None:
    """Each joint's error against the ideal run, root mean square in each interval of the deadlines."""
    edges, time = _edges(recording), recording.signals["time_s"]
    for column, error in recording.signals.items():
        name, found, _ = column.partition("_error_")
        if not found or name == "load":
            continue
        slices = [error[(time > begin) & (time <= end)] for begin, end in pairwise(edges)]
        rms = np.array([np.sqrt(np.mean(part**2)) if part.size else 0.0 for part in slices])
        if rms.any():  # a gantry does not slew
            label = next((label for key, label in JOINTS.items() if key.rsplit("_", 1)[0] == name), name)
            axes.stairs(rms * 1e3, edges, baseline=None, label=label.replace(", ", ", m"), **style(len(axes.patches)))
    axes.set(xlabel="time, s", ylabel="RMS error, mm or mrad", title="joint errors against the ideal run")
    if axes.patches:
        axes.set_yscale("log")
        legend(axes)


@_of_recording
def sway(recording: Recording, axes: Axes) -> None:
    """Both sway angles in degrees; contact in grey."""
    signals = recording.signals
    time = np.array(signals["time_s"])
    for n, (name, label) in enumerate((("sway_alpha_rad", "radial"), ("sway_beta_rad", "tangential"))):
        axes.plot(time, np.degrees(signals[name]), lw=1, label=label, **style(n))
    low, high = axes.get_ylim()
    axes.fill_between(
        time, low, high, where=(np.array(signals["contact"]) > 0.5).tolist(), color="0.85", label="contact"
    )
    axes.set(xlabel="time, s", ylabel="sway, degrees", title="sway")
    legend(axes)


@_of_recording
def deadlines(recording: Recording, axes: Axes) -> None:
    """Jobs per kind over time: light where all were on time, dark where one was missed."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    edges, jobs, last = _edges(recording), recording.jobs, recording.last_runs()
    due = np.where(np.isnan(jobs["deadline_s"]), jobs["ended_s"], jobs["deadline_s"])
    kinds, rows = [], []
    for number, kind in enumerate(recording.header["kinds"]):
        own = last[jobs["kind"][last] == number]
        if own.size:
            counts = [np.histogram(due[own[jobs["missed"][own] == missed]], edges)[0] for missed in (False, True)]
            kinds.append(kind)
            rows.append(np.where(counts[1] > 0, 2, counts[0] > 0))
    if kinds:
        table = np.array(rows)
        axes.pcolormesh(
            edges,
            np.arange(len(kinds) + 1),
            table,
            cmap=ListedColormap(["white", *MET_MISSED.values()]),
            vmin=0,
            vmax=2,
        )
        name_rows(axes, kinds, 0.5)
    axes.set(xlabel="time, s", title="deadlines")
    legend(
        axes,
        handles=[Patch(facecolor=colour, edgecolor="k", lw=0.4, label=name) for name, colour in MET_MISSED.items()],
    )


@_of_recording
def overview(recording: Recording) -> Figure:
    """All of them on one sheet."""
    from cmrc.figures import ShownFigure

    figure = ShownFigure(figsize=(14, 15), layout="constrained")
    grid = figure.add_gridspec(4, 2, height_ratios=(2, 1, 1, 1))
    plan(recording, figure.add_subplot(grid[0, 0]))
    side(recording, figure.add_subplot(grid[0, 1]))
    joints(recording, figure.add_subplot(grid[1, 0]))
    tracking(recording, figure.add_subplot(grid[1, 1]))
    sway(recording, figure.add_subplot(grid[2, :]))
    deadlines(recording, figure.add_subplot(grid[3, :]))
    return figure
