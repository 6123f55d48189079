"""Plots of a sweep: a metric over its grid, and the cost of misses. Needs matplotlib."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cmrc.arguments import drawn_from, text
from cmrc.floats import shortest
from cmrc.result_plots import MARKS, as_they_are, legend, style

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
    interval. Without names: the axis with the most values, and the next one that does not go together with it.

    Points that were refused or failed are gaps. Raises ValueError for a sweep without axes, and if further axes vary,
    because one point would have several values.
    """
    for name, axis in (("x", x), ("lines", lines)):
        if axis is not None:
            text(name, axis, "the name of an axis of the sweep")
    from cmrc.sweeps import metrics

    summary = _placed(sweep, metric)
    x, lines = _axes_of(sweep, summary, x, lines)
    groups: dict[Any, list[tuple[Any, Spread]]] = {}
    for place, spread in summary:
        groups.setdefault(place.get(lines) if lines else None, []).append((place[x], spread))
    names = list(dict.fromkeys(place[x] for place, _ in summary))
    words = not all(isinstance(name, (int, float)) and not isinstance(name, bool) for name in names)
    values = sorted(groups, key=_order)
    labels = [None] * len(values) if lines is None else _labels(sweep, lines, values)
    for n, (value, label) in enumerate(zip(values, labels, strict=True)):
        points = groups[value] if words else sorted(groups[value], key=lambda point: float(point[0]))
        at = [names.index(place) if words else place for place, _ in points]
        means = np.array([spread.mean if spread.n else math.nan for _, spread in points])
        low = np.array([spread.mean - spread.low if spread.varies else 0.0 for _, spread in points])
        high = np.array([spread.high - spread.mean if spread.varies else 0.0 for _, spread in points])
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
    as_they_are(axes.yaxis.label)
    axes.margins(x=0.04)
    legend(axes)


def _placed(sweep: Sweep, metric: Metric) -> list[tuple[dict[str, Any], Spread]]:
    """The points that have a place. A run that was not made may have no value on an axis of another grid's runs."""
    return [
        (place, spread)
        for place, spread in sweep.summary(metric)
        if spread.n or all(place.get(name) is not None for name in sweep.axes)
    ]


Together = Sequence[Mapping[str, Any]]
"""Places over axes whose values may depend on each other; the axes of a grid have one each, settings that go together
too."""


def _axes_of(
    sweep: Sweep, summary: Sequence[tuple[dict[str, Any], Spread]], x: str | None, lines: str | None
) -> tuple[str, str | None]:
    if not summary:
        raise ValueError("grid: the sweep has no runs with a value on each axis")
    places = [{name: place.get(name) for name in sweep.axes} for place, _ in summary]
    x, lines = _chosen([places], x, lines)
    _one_point_each([places], x, lines)
    return x, lines


def check_grid(grid: Grid) -> None:
    """Raises ValueError where ``grid`` without names cannot draw a sweep over this grid."""
    x, lines = _chosen(grid.axes, None, None)
    _one_point_each(grid.axes, x, lines)


def _counts(parts: Sequence[Together]) -> dict[str, int]:
    """The number of values of each axis."""
    return {name: _values_at(part, name) for part in parts for name in part[0]}


def _values_at(part: Together, *names: str | None) -> int:
    """How many different values the places have on these axes, taken together."""
    own = [name for name in names if name is not None and name in part[0]]
    return len({tuple(repr(place[name]) for name in own) for place in part})


def _varied(parts: Sequence[Together]) -> list[str]:
    """The axes with the most values first."""
    counts = _counts(parts)
    return sorted((name for name in counts if counts[name] > 1), key=lambda name: -counts[name])


def _follows(parts: Sequence[Together], name: str, other: str | None) -> bool:
    """There is one value of ``name`` for each of the other axis."""
    return any(
        name in part[0] and other in part[0] and _values_at(part, name, other) == _values_at(part, other)
        for part in parts
    )


def _chosen(parts: Sequence[Together], x: str | None, lines: str | None) -> tuple[str, str | None]:
    from cmrc.sweeps.grid import axis_name

    counts, varied = _counts(parts), _varied(parts)
    if not counts:
        raise ValueError("grid: the sweep has no axes; at least one is expected")
    x, lines = axis_name(x, "x") if x is not None else None, axis_name(lines, "lines") if lines is not None else None
    for name in (x, lines):
        if name is not None and name not in counts:
            raise ValueError(f"grid: {name} is not an axis of the sweep; {', '.join(counts)} are")
    if x is None:
        others = [name for name in (*varied, *counts) if name != lines] or [*counts]
        x = next((name for name in others if not _follows(parts, name, lines)), others[0])
    if lines is None:
        lines = next((name for name in varied if not _follows(parts, name, x)), None)
    return x, lines


def _one_point_each(parts: Sequence[Together], x: str, lines: str | None) -> None:
    if all(_values_at(part, x, lines) == _values_at(part, *part[0]) for part in parts):
        return
    others = [name for name in _varied(parts) if not any(_follows(parts, name, of) for of in (x, lines))]
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
    values = sorted(groups, key=_order)
    names = [None] * len(values) if first is None else _labels(sweep, first, values)
    for n, (value, name) in enumerate(zip(values, names, strict=True)):
        look = {
            "color": style(n)["color"],
            "marker": MARKS[n % len(MARKS)],
            "linestyle": "none",
            "ms": 6,
            "mfc": "none" if n % 2 else None,
        }
        keys = groups[value]
        axes.plot([float(shares[key]) for key in keys], [float(prices[key]) for key in keys], label=name, **look)
    labels = [
        metrics.name_of(of) + (f", {metrics.unit_of(of)}" if metrics.unit_of(of) else "") for of in (missed, price)
    ]
    _engineering(axes, metrics.unit_of(missed), metrics.unit_of(price))
    axes.set(xlabel=labels[0], ylabel=labels[1], title="what misses cost")
    as_they_are(axes.xaxis.label, axes.yaxis.label)
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


def _labels(sweep: Sweep, axis: str, values: Sequence[Any]) -> list[str]:
    """The names in a legend of these values of an axis."""
    from cmrc.sweeps.ranges import short_names

    short = dict(zip(sweep.axes, short_names(sweep.axes), strict=True))[axis]
    return [f"{short} = {value}" for value in _cut([_value(value) for value in values])]


def _labelled(name: str) -> str:
    from cmrc.sweeps.metrics import unit_of_name

    unit = unit_of_name(name.rpartition(".")[2])
    return f"{name}, {unit}" if unit else name


def _value(value: Any) -> str:
    return "–" if value is None else shortest(value)


MOST_OF_A_NAME = 28
"""Characters of a name in a plot."""
TICKS_IN_A_ROW = 60
"""Characters that have room below an axis, side by side."""


def _cut(names: Sequence[str]) -> list[str]:
    """What distinguishes names is often at their ends: one that is too long loses its middle, if they stay distinct."""
    half = (MOST_OF_A_NAME - 1) // 2
    cut = [
        name if len(name) <= MOST_OF_A_NAME else f"{name[: MOST_OF_A_NAME - 1 - half]}…{name[-half:]}" for name in names
    ]
    return cut if len(set(cut)) == len(set(names)) else list(names)


def _name_ticks(axes: Axes, names: Sequence[str]) -> None:
    """One tick for each name; slanted where they would lie on each other."""
    shown = _cut(names)
    slanted: dict[str, Any] = {"rotation": 25, "ha": "right", "rotation_mode": "anchor"}
    crowded = len(names) * (max(map(len, shown)) + 2) > TICKS_IN_A_ROW
    axes.set_xticks(range(len(names)), shown, parse_math=False, **(slanted if crowded else {}))


__all__ = ["cost", "grid"]
