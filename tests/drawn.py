"""What a figure shows, as text: for golden files that do not depend on the version of Matplotlib."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection, LineCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch


def number(value: float) -> str:
    """What is next to nothing depends on the last bits."""
    return "0" if abs(value) < 1e-9 else f"{value:.4g}"


def values(of: Any, most: int = 12) -> str:
    """All numbers if they are few, else how many there are, their ends and their mean."""
    found = np.ma.filled(np.ma.asarray(of, dtype=float), np.nan).ravel()
    if found.size <= most:
        return " ".join(map(number, found))
    return f"{found.size} from {number(found[0])} to {number(found[-1])}, mean {number(float(np.nanmean(found)))}"


def label(one: Artist) -> str:
    """Names that Matplotlib gives begin with a line."""
    given = str(one.get_label())
    return "" if given.startswith("_") else given


def line(one: Line2D) -> str:
    x, y = one.get_data()
    if not np.size(x):
        return ""
    look = f"{one.get_linestyle()} {one.get_marker()} {number(one.get_markersize())} {to_hex(one.get_color())}"
    return f"line {label(one)!r} {look} x {values(x)} y {values(y)}"


def patch(one: Patch) -> str:
    corners = one.get_transform().transform_path(one.get_path()).vertices
    own = one.axes.transData.inverted().transform(corners) if one.axes else corners
    look = f"{to_hex(one.get_facecolor())} {to_hex(one.get_edgecolor())} {one.get_hatch() or ''}"
    return f"{type(one).__name__} {label(one)!r} {look} {values(own[0])} {values(own.mean(axis=0))}"


def collection(one: Collection) -> str:
    data = one.get_array()
    kind = "Bars" if "Poly" in type(one).__name__ else type(one).__name__  # whose name depends on the version
    if data is not None:
        return f"{kind} {label(one)!r} {data.shape} {values(data, 60)}"
    paths = one.get_segments() if isinstance(one, LineCollection) else [path.vertices for path in one.get_paths()]
    places = " | ".join(f"{values(path[0])} to {values(path.mean(axis=0))}" for path in paths[:12] if len(path))
    colours = " ".join(dict.fromkeys(map(to_hex, [*one.get_facecolor(), *one.get_edgecolor()])))
    return f"{kind} {label(one)!r} {colours} {one.get_hatch() or ''} {places}"


def of_axes(axes: Axes) -> Iterator[str]:
    yield f"axes {axes.get_title()!r} x {axes.get_xlabel()!r} {axes.get_xscale()} y {axes.get_ylabel()!r} {axes.get_yscale()}"
    for name, axis in (("x", axes.xaxis), ("y", axes.yaxis)):
        if type(axis.get_major_formatter()).__name__ in ("FixedFormatter", "FuncFormatter", "EngFormatter"):
            places = axis.get_majorticklocs() if type(axis.get_major_locator()).__name__ == "FixedLocator" else []
            yield f"ticks {name} {type(axis.get_major_formatter()).__name__} {values(places)} {[label.get_text() for label in axis.get_ticklabels()] if len(places) else ''}"
    yield from filter(None, map(line, axes.lines))
    yield from map(patch, axes.patches)
    yield from map(collection, axes.collections)
    yield from (f"text {one.get_text()!r} at {values(one.get_position())}" for one in axes.texts if one.get_text())
    if (legend := axes.get_legend()) is not None:
        yield f"legend {[text.get_text() for text in legend.get_texts()]}"


def described(figure: Figure) -> str:
    """Titles, labels, scales, lines, bars, texts, legends of each of its axes."""
    lines = [f"figure {len(figure.axes)} axes"]
    if figure.get_suptitle():
        lines.append(f"title {figure.get_suptitle()!r}")
    return "\n".join([*lines, *(line for axes in figure.axes for line in of_axes(axes))]) + "\n"
