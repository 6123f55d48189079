"""Recordings of a run, and their replay as one page that works offline.

A recording is what can be written as JSON: the dock's layout, its signals each ``step_s``, its events, and for each interval and task kind how many jobs were on
time and how many missed.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping
from importlib import resources
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from cmrc import _core, files
from cmrc.plant import Box, DockConfig
from cmrc.simulation import Setting, Simulation
from cmrc.table import Table

Recording = dict[str, Any]
FORMAT = 4


def record(simulation: Simulation, step_s: float = 0.1, on_progress: Callable[[float, float], object] | None = None) -> Recording:
    """Runs a fresh simulation to its end and keeps what a replay needs. ``simulation.result()`` holds the rest as ever.

    ``on_progress(simulated_s, duration_s)`` is told of every slice of the time line.
    """
    settings, dock = simulation.config.to_dict(), _core.cmrc.dock_of(simulation.config)
    duration = float(settings["run.duration_s"])
    slices = max(1, min(360, math.ceil(duration / 0.05)))
    edges = [duration * i / slices for i in range(slices + 1)]
    counts: list[dict[str, tuple[int, int]]] = []
    for edge in edges[1:]:
        simulation.run_until(edge)
        counts.append({kind: (int(task["on_time"]), int(task["misses"])) for kind, task in simulation.tasks().items()})
        if on_progress is not None:
            on_progress(edge, duration)
        if simulation.ended:
            break
    result = simulation.result()
    signals, report = result.signals, result.report
    every = max(1, round(step_s / max(1e-9, float(signals["time_s"][1] - signals["time_s"][0])))) if signals.rows > 1 else 1
    kept = {name: np.round(np.asarray(column[::every], dtype=float), 5).tolist() for name, column in signals.items()}
    for i, mover in enumerate(dock.layout.movers):
        places = [_core.plant.mover_place(mover, t) for t in kept["time_s"]]
        kept |= {f"mover{i}_{axis}_m": [round(p[k], 5) for p in places] for k, axis in enumerate("xy")}
    return {
        "format": FORMAT,
        "settings": settings,
        "duration_s": edges[len(counts)],
        "signals": kept,
        "events": [list(event) for event in simulation._core.dock_events()],
        "deadlines": {"edges_s": edges[: len(counts) + 1], "kinds": _per_slice(counts)},
        "tracking": _tracking(signals, edges[: len(counts) + 1], report),
        "layout": _layout(dock),
    }


def record_file(
    config: str | os.PathLike[str],
    settings: Mapping[str, Setting] | None = None,
    on_progress: Callable[[float, float], object] | None = None,
) -> Recording:
    """Runs a TOML configuration and records it; ``on_progress`` as of ``record``. Raises ConfigError, OSError."""
    return record(Simulation(config=config, settings=settings), on_progress=on_progress)


def save(recording: Recording, path: str | os.PathLike[str]) -> None:
    """Writes a recording as JSON, whole or not at all. Raises OSError."""
    files.write(path, json.dumps(recording))


def load(path: str | os.PathLike[str]) -> Recording:
    """Reads a recording. Raises OSError, ValueError for a file that is none."""
    try:
        recording = json.loads(Path(path).read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{os.fspath(path)} is no recording: {error}") from None
    if not isinstance(recording, dict) or recording.get("format") != FORMAT:
        raise ValueError(f"{os.fspath(path)} is no recording of format {FORMAT} (cmrc replay CONFIG.toml --save FILE.json writes one)")
    return recording


def page(recording: Recording) -> str:
    """The page: 3-D view, time slider, deadline timeline. Nothing in it is fetched from anywhere."""
    template = resources.files("cmrc").joinpath("replay.html").read_text(encoding="utf-8")
    data = {**recording, "containers": containers(recording)}
    # Inside a script element "<" alone may end it, or, with "!--", keep it from ending; in JSON it stands in texts only.
    return template.replace("/*RECORDING*/null", json.dumps(data).replace("<", "\\u003c"))


def containers(recording: Recording) -> list[list[list[Any]]]:
    """Per container its story: [time, "ship" | "carried" | "agv" | "set" | "gone", AGV or pose]."""
    stories: list[list[list[Any]]] = [[[0.0, "ship", place[:4]]] for place in recording["layout"]["containers"]]
    signals = recording["signals"]
    for time, kind, index, first, _ in recording["events"]:
        if not 0 <= index < len(stories):
            continue
        if kind == "locked":
            stories[index].append([time, "carried", None])
        elif kind == "opened":
            row = min(int(np.searchsorted(signals["time_s"], time)), len(signals["time_s"]) - 1)
            height = recording["layout"]["size"][2]
            at = [signals[f"payload_{axis}_m"][row] for axis in "xyz"]
            stories[index].append([time, "set", [at[0], at[1], at[2] - height, signals["payload_yaw_rad"][row]]])
        elif kind == "set_on_agv":
            stories[index].append([time, "agv", round(first)])
        elif kind == "delivered":
            stories[index].append([time, "gone", None])
    return stories


def _per_slice(counts: list[dict[str, tuple[int, int]]]) -> dict[str, list[tuple[int, int]]]:
    rows: dict[str, list[tuple[int, int]]] = {}
    for kind in counts[-1] if counts else ():
        before = (0, 0)
        rows[kind] = []
        for count in counts:
            now = count.get(kind, before)
            rows[kind].append((now[0] - before[0], now[1] - before[1]))
            before = now
    return {kind: row for kind, row in rows.items() if any(on_time or missed for on_time, missed in row)}


def _tracking(signals: Table, edges: list[float], report: Mapping[str, Any]) -> dict[str, Any]:
    """Root mean square of each joint's error against the ideal run in each slice; empty where the run has no reference."""
    time = np.asarray(signals["time_s"])
    tracking = {}
    for joint, of in (report["errors"] or {"joints": {}})["joints"].items():
        error = np.asarray(signals[f"{joint}_error_{of['unit']}"])
        slices = [error[(time > begin) & (time <= end)] for begin, end in pairwise(edges)]
        tracking[joint] = {"unit": of["unit"], "rms": [float(np.sqrt(np.mean(part**2))) if part.size else 0.0 for part in slices]}
    return tracking


def _layout(config: DockConfig) -> dict[str, Any]:
    layout, crane, agv = config.layout, config.crane, config.agv

    def box(b: Box) -> list[float]:
        return [b.x_min, b.x_max, b.y_min, b.y_max, b.z_min, b.z_max]

    return {
        "size": [12.192, 2.438, 2.591],
        "containers": [[c.x, c.y, c.z, c.yaw] for c in layout.containers],
        "ship": box(layout.ship),
        "boxes": [box(b) for b in layout.no_go],
        "movers": [[m.radius, m.height] for m in layout.movers],
        "lanes": [[s.x, s.y, s.heading, s.length, s.curvature] for leg in layout.legs for s in leg],
        "crane": {
            "machine": crane.machine.name, "a0": crane.a0, "pivot": crane.pivot_height, "cw": crane.counterweight_radius,
            "reach": [crane.lower[2], crane.upper[2]],
            "portal": {
                "along": crane.portal.along, "rails": [crane.portal.waterside, crane.portal.landside],
                "leg": crane.portal.leg, "height": crane.portal.height,
            },
        },
        "agv": {"count": config.agv_count, "length": agv.length, "width": agv.width, "deck": agv.deck_height},
        "spot": [layout.spot.x, layout.spot.y],
        "warehouse": [layout.warehouse.x, layout.warehouse.y, layout.warehouse_radius],
    }
