"""Plots of a sweep: a metric over its grid, and the cost of misses. Needs matplotlib."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cmrc.arguments import drawn_from, text
from cmrc.result_plots import MARKS, legend, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from cmrc.sweeps import Grid, Sweep
    from cmrc.sweeps.metrics import Metric, Spread


def _sweep() -> type:
    from cmrc.sweeps import Sweep

    return Sweep


_of_sweep = drawn_from("sweep", _sweep, "a cmrc.sweeps.Sweep")


@_of_sweep
def grid(sweep: Sweep, axes: Axes, x: str | None = None, lines: str | None = None, metric: Metric = "misses") -> None:
    """A metric over the setting ``x``, one line per value of the setting ``lines``; if repeats vary, with a 95 %
    interval. Without names: the axis with the most values, and the next one.

    Points that were refused or failed are gaps. Raises ValueError if further axes vary, because one point would have
    several values.
    """
    for name, axis in (("x", x), ("lines", lines)):
        if axis is not None:
            text(name, axis, "the name of an axis of the sweep")
    from cmrc.sweeps import metrics

    summary = sweep.summary(metric)
    x, lines = _axes_of(sweep, summary, x, lines)
    groups: dict[Any, list[tuple[Any, Spread]]] = {}
    for place, spread in summary:
        groups.setdefault(place.get(lines) if lines else None, []).append((place[x], spread))
    names = list(dict.fromkeys(place[x] for place, _ in summary))
    words = any(isinstance(name, (str, bool)) for name in names)
    for n, (value, points) in enumerate(sorted(groups.items(), key=lambda group: _order(group[0]))):
        points = points if words else sorted(points, key=lambda point: float(point[0]))
        at = [names.index(place) if words else place for place, _ in points]
        means = np.array([spread.mean if spread.n else math.nan for _, spread in points])
        low = np.array([spread.mean - spread.low if spread.varies else 0.0 for _, spread in points])
        high = np.array([spread.high - spread.mean if spread.varies else 0.0 for _, spread in points])
        label = None if lines is None else f"{_short(lines)} = {_cut(_value(value))}"
        axes.errorbar(
            at, means, yerr=[low, high], label=label, marker=MARKS[n % len(MARKS)], ms=5, lw=1.3, capsize=3, **style(n)
        )
    if words:
        _name_ticks(axes, [_value(name) for name in names])
    elif all(isinstance(name, int) for name in names):
        axes.locator_params(axis="x", integer=True)
    unit = metrics.unit_of(metric)
    _engineering(axes, y=unit)
    axes.set(xlabel=_labelled(x), ylabel=metrics.name_of(metric) + (f", {unit}" if unit else ""), title=_title(summary))
    axes.margins(x=0.04)
    legend(axes)


def _axes_of(
    sweep: Sweep, summary: Sequence[tuple[dict[str, Any], Spread]], x: str | None, lines: str | None
) -> tuple[str, str | None]:
    if not summary:
        raise ValueError("grid: the sweep has no runs")
    counts = {name: len({repr(place.get(name)) for place, _ in summary}) for name in sweep.axes}
    x, lines = _chosen(counts, x, lines)
    _one_point_each(counts, x, lines, len({_at(place, x, lines) for place, _ in summary}), len(summary))
    return x, lines


def check_grid(grid: Grid) -> None:
    """Raises ValueError where ``grid`` without names cannot draw a sweep over this grid."""
    counts = {name: len({repr(value[name]) for value in axis}) for axis in grid.axes for name in axis[0]}
    x, lines = _chosen(counts, None, None)
    drawn = math.prod(len({_at(value, x, lines) for value in axis}) for axis in grid.axes)
    _one_point_each(counts, x, lines, drawn, math.prod(map(len, grid.axes)))


def _at(place: Mapping[str, Any], x: str, lines: str | None) -> tuple[str, str]:
    return repr(place.get(x)), repr(place.get(lines)) if lines else ""


def _varied(counts: Mapping[str, int]) -> list[str]:
    """The axes with the most values first."""
    return sorted((name for name in counts if counts[name] > 1), key=lambda name: -counts[name])


def _chosen(counts: Mapping[str, int], x: str | None, lines: str | None) -> tuple[str, str | None]:
    from cmrc.sweeps.grid import axis_name

    varied = _varied(counts)
    lines = lines if lines is None else axis_name(lines, "lines")
    x = axis_name(x, "x") if x is not None else next((name for name in varied if name != lines), next(iter(counts), ""))
    lines = lines if lines is not None else next((name for name in varied if name != x), None)
    for name in (x, lines):
        if name is not None and name not in counts:
            raise ValueError(
                f"grid: {name or 'nothing'} is not an axis of the sweep; {', '.join(counts) or 'none'} are"
            )
    return x, lines


def _one_point_each(counts: Mapping[str, int], x: str, lines: str | None, drawn: int, points: int) -> None:
    if drawn < points:
        others = [name for name in _varied(counts) if name not in (x, lines)]
        raise ValueError(
            f"grid: besides {x} and {lines}, {', '.join(others)} {'varies' if len(others) == 1 else 'vary'}; "
            "a sweep over two axes is expected"
        )


@_of_sweep
def cost(sweep: Sweep, axes: Axes, missed: Metric = "f_p_missed", price: Metric = "load_rms") -> None:
    """The cost of misses: a point per run, the share of missed deadlines against the load's true error. Runs with one
    value of the first axis have the same mark."""
    from cmrc.sweeps import metrics

    shares, prices = sweep.values(missed), sweep.values(price)
    first = next(iter(sweep.axes), None)
    groups: dict[Any, list[str]] = {}
    for run in sweep.runs:
        if run["key"] in shares:
            groups.setdefault(run["place"].get(first), []).append(run["key"])
    for n, (value, keys) in enumerate(sorted(groups.items(), key=lambda group: _order(group[0]))):
        look = {
            "color": style(n)["color"],
            "marker": MARKS[n % len(MARKS)],
            "linestyle": "none",
            "ms": 6,
            "mfc": "none" if n % 2 else None,
        }
        label = None if first is None else f"{_short(first)} = {_value(value)}"
        axes.plot([float(shares[key]) for key in keys], [float(prices[key]) for key in keys], label=label, **look)
    labels = [
        metrics.name_of(of) + (f", {metrics.unit_of(of)}" if metrics.unit_of(of) else "") for of in (missed, price)
    ]
    _engineering(axes, metrics.unit_of(missed), metrics.unit_of(price))
    axes.set(xlabel=labels[0], ylabel=labels[1], title="what misses cost")
    legend(axes)


def _engineering(axes: Axes, x: str = "", y: str = "") -> None:
    """Ticks in um or ms where the numbers are small."""
    from matplotlib.ticker import EngFormatter

    for axis, unit in ((axes.xaxis, x), (axes.yaxis, y)):
        if unit in ("s", "m"):
            axis.set_major_formatter(EngFormatter(unit))


def _order(value: Any) -> tuple[bool, float, str]:
    number = isinstance(value, (int, float))
    return not number, float(value) if number else 0.0, str(value)


def _title(summary: Sequence[tuple[dict[str, Any], Spread]]) -> str:
    repeats = {spread.n for _, spread in summary if spread.n}
    if not repeats or max(repeats) == 1:
        return "one run per point"
    count = f"n = {min(repeats)}" if len(repeats) == 1 else f"n = {min(repeats)} to {max(repeats)}"
    return f"mean of {count}" + (
        ", 95 % intervals" if any(spread.varies for _, spread in summary) else ": all repeats agree"
    )


def _short(name: str) -> str:
    return name.rpartition(".")[2]


def _labelled(name: str) -> str:
    from cmrc.sweeps.metrics import unit_of_name

    unit = unit_of_name(_short(name))
    return f"{name}, {unit}" if unit else name


def _value(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


MOST_OF_A_NAME = 28
"""Characters of a name in a plot."""
TICKS_IN_A_ROW = 60
"""Characters that have room below an axis, side by side."""


def _cut(name: str) -> str:
    """What distinguishes names is often at their ends: one that is too long loses its middle."""
    if len(name) <= MOST_OF_A_NAME:
        return name
    half = (MOST_OF_A_NAME - 1) // 2
    return f"{name[: MOST_OF_A_NAME - 1 - half]}…{name[-half:]}"


def _name_ticks(axes: Axes, names: Sequence[str]) -> None:
    """One tick for each name; slanted where they would lie on each other."""
    cut = [_cut(name) for name in names]
    shown = cut if len(set(cut)) == len(set(names)) else list(names)
    slanted: dict[str, Any] = {"rotation": 25, "ha": "right", "rotation_mode": "anchor"}
    crowded = len(names) * (max(map(len, shown)) + 2) > TICKS_IN_A_ROW
    axes.set_xticks(range(len(names)), shown, **(slanted if crowded else {}))


__all__ = ["cost", "grid"]
