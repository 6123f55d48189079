"""The differences between two results."""

from __future__ import annotations

import html
import math
import os
from collections.abc import Iterator, Mapping
from typing import Any

from cmrc import _core, saved_result
from cmrc.floats import shortest
from cmrc.result import Result
from cmrc.table import Table

NO_METRIC = (
    "configuration",
    "configuration_toml",
    "elapsed_s",
    "reference_elapsed_s",
    "schema_version",
    "emulator_version",
)
"""Keys of the report that are compared separately, or differ between two runs of the same configuration."""
MISSING = "–"
LONGEST = 70
CONTEXT = 20
"""Characters of a value that are shown; of those before the first difference."""


class Difference:
    """The differences between two results, named left and right."""

    def __init__(
        self, left: Mapping[str, Any], right: Mapping[str, Any], event: Mapping[str, Any] | None, events_compared: bool
    ) -> None:
        self.configuration: dict[str, tuple[Any, Any]] = dict(_unlike(left["configuration"], right["configuration"]))
        """By setting: its value left and right."""
        versions = left.get("emulator_version"), right.get("emulator_version")
        self.versions: tuple[Any, Any] | None = versions if versions[0] != versions[1] else None
        """Versions of the emulator, if they differ."""
        self.event: dict[str, Any] | None = None if event is None else dict(event)
        """The first event that differs: ``when`` (s), ``component``, ``field``, ``left``, ``right``, and both lines of
        the traces; None if no event differs, or one of the results has no events."""
        self.events_compared = events_compared
        """Both results have their events (``keep_events=True``)."""
        self.metrics: list[tuple[str, Any, Any]] = sorted(
            ((name, one, other) for name, (one, other) in _unlike(dict(_leaves(left)), dict(_leaves(right)))),
            key=lambda row: row[0].startswith("misses["),
        )
        """Every metric of the report that differs, in the report's order: name, left, right; missed jobs one by one
        come last."""
        self.same_hash = left["hash"] == right["hash"]
        """Both made the same events."""

    def __bool__(self) -> bool:
        """There is a difference."""
        return bool(self.configuration or self.versions or self.event or self.metrics)

    @property
    def first(self) -> str:
        """The first difference, in a sentence."""
        if self.event is not None:
            return (
                f"They differ from {self.event['when']} s on: {self.event['component']}, {self.event['field']} "
                f"{self.event['left']} and {self.event['right']}."
            )
        if self.same_hash:
            return "Both runs made the same events." + ("" if not self.metrics else " The reports differ.")
        if self.events_compared:
            return "No event differs; the final states of the machines do."
        told = "(Runs with keep_events=True tell the first event, too.)"
        measured = next((row for row in self.metrics if row[0] != "hash"), None)
        if measured is None:
            return (
                f"No metric differs; the events or the final states of the machines do: the hashes are unlike. {told}"
            )
        name, *values = measured
        one, other = _shown(*values)
        return f"The first metric that differs is {name}: {one} and {other}. {told}"

    @property
    def table(self) -> Table:
        """One row per metric: ``metric``, ``left``, ``right``, ``difference``; NaN if it is not a number."""
        return Table.from_rows(
            {"metric": name, "left": _number(one), "right": _number(other), "difference": _number(other) - _number(one)}
            for name, one, other in self.metrics
        )

    def text(self, most: int = 40) -> str:
        """For a terminal, with at most this number of metrics."""
        if not self:
            return "The two results are the same.\n"
        lines = [self.first]
        if self.versions:
            lines += ["", f"Emulator version {self.versions[0]} and {self.versions[1]}"]
        if self.configuration:
            lines += ["", "Configuration"]
            lines += [f"  {key}: {' -> '.join(_shown(*pair))}" for key, pair in self.configuration.items()]
        if self.metrics:
            lines += ["", f"Metrics ({len(self.metrics)} differ)"]
            lines += [
                f"  {name}: {' -> '.join(_shown(one, other))}{_change(one, other)}"
                for name, one, other in self.metrics[:most]
            ]
            if len(self.metrics) > most:
                lines.append(f"  and {len(self.metrics) - most} more")
        return "\n".join(lines) + "\n"

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "same": not self,
            "first": self.first if self else None,
            "versions": self.versions,
            "configuration": {key: list(pair) for key, pair in self.configuration.items()},
            "event": self.event,
            "metrics": [{"metric": name, "left": one, "right": other} for name, one, other in self.metrics],
        }

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        return f"<cmrc.Difference: {len(self.configuration)} settings, {len(self.metrics)} metrics>"

    def _repr_html_(self) -> str:
        rows = [("setting", key, *_shown(*pair)) for key, pair in self.configuration.items()]
        rows += [("metric", name, *_shown(one, other)) for name, one, other in self.metrics[:200]]
        cells = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
        return (
            f"<p>{html.escape(self.first if self else 'The two results are the same.')}</p>"
            f"<table><tr><th></th><th>name</th><th>left</th><th>right</th></tr>{cells}</table>"
        )


Comparable = Result | Mapping[str, Any] | str | os.PathLike[str]


def diff(left: Comparable, right: Comparable) -> Difference:
    """The differences between two results: each a ``Result``, a report (a dictionary), or a file of either.

    Raises OSError; ResultError for a file that is neither a saved result nor a JSON report, and for a report of another
    schema version.
    """
    (one, events), (other, beside) = _taken("left", left), _taken("right", right)
    compared = events is not None and beside is not None
    event = _core.trace.difference(events, beside) if events is not None and beside is not None else None
    return Difference(one, other, event, compared)


def _taken(name: str, of: Comparable) -> tuple[dict[str, Any], str | None]:
    if isinstance(of, Result):
        return of.report, of.events
    if isinstance(of, Mapping):
        try:
            return saved_result.checked_report(of), None
        except ValueError as error:
            raise saved_result.ResultError(f"{name}: {error}") from None
    if not isinstance(of, (str, os.PathLike)):
        raise TypeError(
            f"{name}: {type(of).__name__} cannot be used; a Result, a report or the path of a file is expected"
        )
    if saved_result.is_archive(of):
        parts = saved_result.load(of)
        return parts["report"], parts["events"]
    return saved_result.load_report(of), None


def _leaves(node: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """All values that are not tables or lists of tables, by their dotted places; a list of numbers is one value."""
    if isinstance(node, Mapping):
        for key, below in node.items():
            if path or key not in NO_METRIC:
                yield from _leaves(below, f"{path}.{key}" if path else key)
    elif isinstance(node, list) and any(isinstance(below, (Mapping, list)) for below in node):
        for n, below in enumerate(node):
            yield from _leaves(below, f"{path}[{n}]")
    else:
        yield path, node


def _unlike(left: Mapping[str, Any], right: Mapping[str, Any]) -> Iterator[tuple[str, tuple[Any, Any]]]:
    """Names with their values where these differ. What is not there is null: beside a table it has no value either."""
    for name in dict.fromkeys([*left, *right]):
        one, other = left.get(name), right.get(name)
        if one != other:
            yield name, (one, other)


def _number(value: Any) -> float:
    """NaN for what is no number, or an integer that no report has: beyond every double."""
    if not isinstance(value, (int, float)) or isinstance(value, bool):
        return math.nan
    try:
        return float(value)
    except OverflowError:
        return math.nan


def _shown(one: Any, other: Any) -> tuple[str, str]:
    """Two values that differ, as texts that differ: of long ones the part from the first difference on."""
    left, right = _text(one), _text(other)
    if max(len(left), len(right)) > LONGEST:
        alike = len(os.path.commonprefix([left, right]))
        if isinstance(one, list) and isinstance(other, list):
            left, right = _rest_of_lists(one, other)
        elif alike > CONTEXT:
            left, right = (f"...{text[alike - CONTEXT :]}" for text in (left, right))
    return _cut(left), _cut(right)


def _rest_of_lists(one: list[Any], other: list[Any]) -> tuple[str, str]:
    """Both without the elements at their beginnings that are alike, of which the number is shown."""
    alike = next((n for n, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), min(len(one), len(other)))
    beginning = [f"{alike} alike"] if alike else []
    ends = one[alike:], other[alike:]
    if not all(ends):
        texts = [list(map(repr, end)) for end in ends]
    else:
        first = _shown(ends[0][0], ends[1][0])
        texts = [[text, *map(repr, end[1:])] for text, end in zip(first, ends, strict=True)]
    left, right = (f"[{', '.join([*beginning, *text])}]" for text in texts)
    return left, right


def _text(value: Any) -> str:
    return MISSING if value is None else shortest(value)


def _cut(text: str) -> str:
    return text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."


def _change(one: Any, other: Any) -> str:
    change = _number(other) - _number(one)
    return "" if math.isnan(change) else f" ({change:+.6g})"
