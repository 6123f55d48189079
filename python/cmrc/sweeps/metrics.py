"""Numbers of a report by name, and their spread over repeats."""

from __future__ import annotations

import json
import marshal
import math
import numbers
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np

from cmrc import _core, arguments
from cmrc.results.judgement import mean_interval, share_interval

Metric = str | Callable[[Mapping[str, Any]], float | int | bool | None]

NAMED: dict[str, tuple[str, Callable[[Mapping[str, Any]], Any]]] = {
    "misses": ("jobs", lambda report: _misses(report)),
    "any_miss": ("runs", lambda report: None if (misses := _misses(report)) is None else misses > 0),
    "f_p_missed": ("share", lambda report: _at(report, "rates.f_p.missed_share")),
    "f_t_missed": ("share", lambda report: _at(report, "rates.f_t.missed_share")),
    "f_a_missed": ("share", lambda report: _at(report, "rates.f_a.missed_share")),
    "load_rms": ("m", lambda report: _at(report, "errors.load_m.rms")),
    "load_peak": ("m", lambda report: _at(report, "errors.load_m.peak")),
    "lag": ("s", lambda report: _at(report, "errors.lag.crane.end_s")),
    "worst_response_us": ("us", lambda report: _worst(report)),
}
"""Short names: unit and meaning. ``any_miss`` is yes or no, so that its mean is a share of the runs."""
UNITS = {unit: unit for unit in ("s", "ms", "us", "ns", "ps", "m", "rad", "mrad", "deg", "kg", "ppm")} | {
    "hz": "Hz", "m_s": "m/s", "rad_s": "rad/s", "m2": "m2", "m2s": "m2 s",
    "share": "share", "cycles": "cycles", "refreshes": "refreshes",
}  # fmt: skip
"""By the ending of a name. Another ending made of BASES is a unit without an entry here."""
BASES = {*UNITS, "n", "s2", "1"}
HISTOGRAM = "log2_histogram"
BINS = 64
"""Of every histogram of a report, which leaves out those after the last used one (docs/report.md)."""
COUNTED = ("count", HISTOGRAM)
"""Parts of a summary that count what was measured."""
USUAL = ("misses", "f_p_missed", "load_rms", "lag")


NO_NUMBERS = {"object", "array", "string", "null"}


@cache
def _schema() -> dict[str, Any]:
    """docs/report.schema.json."""
    found: dict[str, Any] = json.loads((files("cmrc") / "report.schema.json").read_text(encoding="utf-8"))
    return found


def check_kind(metric: Metric, where: str = "metric") -> None:
    """Raises TypeError for neither a name nor a function."""
    if not isinstance(metric, str) and not callable(metric):
        arguments.refuse(where, metric, "the name of a metric, or a function of a report,")


def check_place(metric: str) -> None:
    """What is known of a name before any run. Raises ValueError for a place that no report has."""
    if metric not in NAMED:
        problem = "an empty name; the name of a metric is expected"
        if metric:
            problem = _no_bin(metric) or _problem(_schema(), metric, metric)
        if problem:
            raise ValueError(problem)


def _problem(node: Mapping[str, Any], rest: str, place: str) -> str:
    """What is wrong with a place, by the schema of a report; empty if a report may have it."""
    if not rest:
        kinds = node.get("type", "number")
        kinds = {kinds} if isinstance(kinds, str) else {*kinds}
        return f"{place}: is no number" if kinds - {"null"} and kinds <= NO_NUMBERS else ""
    index = re.match(r"\[\d+\]\.?", rest)
    if index and "items" in node:
        return _problem(node["items"], rest[index.end() :], place)
    own, others = node.get("properties", {}), node.get("additionalProperties", True)
    name = _step(own, rest)
    if name is not None:
        return _problem(own[name], _behind(rest, name), place)
    if isinstance(others, Mapping):  # names that a run gives, which may have dots
        problems = [_problem(others, _behind(rest, rest[:end]), place) for end in _ends(rest)]
        return "" if "" in problems else problems[0]
    return "" if others and "items" not in node else _none(place, rest, own)


def _ends(rest: str) -> list[int]:
    """Where a name may end that a run gives, and that may have dots."""
    return [end.start() for end in re.finditer(r"[.\[]|$", rest) if end.start()]


def _none(place: str, rest: str, known: Iterable[str]) -> str:
    """There is no such place; the nearest name of those that are there."""
    name = re.match(r"[^.\[]*", rest)
    word = name[0] if name else rest
    names = [*known, *(NAMED if rest == place else ())]
    return f"{place}: the report has no such place{_core.io.did_you_mean(word, names)}"


def value(report: Mapping[str, Any], metric: Metric) -> float | bool:
    """A metric of a report: a short name, a dotted place (``tasks.pid.response_ps.p99``, ``dsps[0].cycles``), or a
    function of the report. NaN if nothing was measured. Raises KeyError for a place that the report does not have,
    TypeError for a function that gives no number."""
    found = metric(report) if callable(metric) else NAMED[metric][1](report) if metric in NAMED else _at(report, metric)
    if found is None:
        return math.nan
    if isinstance(found, (bool, int, float)):
        return found
    if isinstance(found, np.bool_):
        return bool(found)
    if isinstance(found, numbers.Real):  # of NumPy, or a fraction
        return int(found) if isinstance(found, numbers.Integral) else float(found)
    raise (TypeError if callable(metric) else KeyError)(f"{name_of(metric)}: {type(found).__name__} is no number")


def values(report: Mapping[str, Any], of: Sequence[Metric]) -> list[float | bool]:
    """The metrics of a report. A function gets a copy, so that it cannot change what the others measure."""
    return [value(marshal.loads(marshal.dumps(dict(report))) if callable(metric) else report, metric) for metric in of]


def of_reports(reports: Iterable[tuple[str, Mapping[str, Any]]], of: Sequence[Metric]) -> dict[str, list[float | bool]]:
    """The metrics of reports, by key. NaN where a report does not have a place that another one has, as a run with two
    DSPs has no ``dsps[3]``. Raises KeyError for a place that none has."""
    found: dict[str, list[float | bool]] = {}
    missing: dict[int, KeyError] = {}
    there: set[int] = set()
    for key, report in reports:
        found[key] = []
        for n, metric in enumerate(of):
            try:
                found[key] += values(report, [metric])
                there.add(n)
            except KeyError as error:
                if callable(metric):
                    raise
                missing.setdefault(n, error)
                found[key].append(math.nan)
    for n in sorted(missing.keys() - there):
        raise missing[n]
    return found


def names_of(of: Sequence[Metric], taken: Collection[str]) -> list[str]:
    """Names of columns. A text that is given twice is one column; any other name that is taken gets a number."""
    names: list[str] = []
    for n, metric in enumerate(of):
        if isinstance(metric, str) and metric in of[:n]:
            names.append(names[list(of).index(metric)])
            continue
        name = first = name_of(metric)
        number = 1
        while name in taken or name in names:
            number += 1
            name = f"{first} {number}"
        names.append(name)
    return names


def name_of(metric: Metric) -> str:
    return metric if isinstance(metric, str) else getattr(metric, "__name__", "metric")


def unit_of(metric: Metric) -> str:
    """The unit of a short name, or from the ending of the last name of a place that has one; empty if unknown. The
    names of tasks and other names that the run gives have no units."""
    if not isinstance(metric, str):
        return ""
    if metric in NAMED:
        return NAMED[metric][0]
    if metric.startswith("configuration."):
        return unit_of_name(metric.rpartition(".")[2]) or ""
    for name in reversed(_own_names(_schema(), metric) or []):
        if name in COUNTED:
            return "jobs" if metric.startswith("tasks.") else ""
        if (unit := unit_of_name(name)) is not None:
            return unit
    return ""


def _own_names(node: Mapping[str, Any], rest: str) -> list[str] | None:
    """The names along a place without those that a run gives; None for a place that no report has."""
    if not rest:
        return []
    index = re.match(r"\[\d+\]\.?", rest)
    if index and "items" in node:
        return _own_names(node["items"], rest[index.end() :])
    own, others = node.get("properties", {}), node.get("additionalProperties")
    if (name := _step(own, rest)) is not None:
        below = _own_names(own[name], _behind(rest, name))
        return None if below is None else [name, *below]
    if not isinstance(others, Mapping):
        return None
    found = (_own_names(others, _behind(rest, rest[:end])) for end in _ends(rest))
    return next((below for below in found if below is not None), None)


def unit_of_name(name: str) -> str | None:
    """The unit at the end of a name; empty for one that this table does not have, None for a name without a unit."""
    words = name.split("_")
    ending: list[str] = []
    while len(ending) < len(words) - 1 and words[-len(ending) - 1] in BASES:
        ending.insert(0, words[-len(ending) - 1])
    return UNITS.get("_".join(ending), "") if ending else None


def _misses(report: Mapping[str, Any]) -> int | None:
    """None if no job was finished on time either: a controller that still boots releases none."""
    tasks = report["tasks"].values()
    misses = sum(task["misses"] for task in tasks)
    return misses if misses or any(task["on_time"] for task in tasks) else None


def _at(report: Mapping[str, Any], place: str) -> Any:
    """The value at a dotted place; names that contain a dot (task kinds) are found too. None below a null."""
    node: Any = report
    rest = place
    while rest:
        if node is None:
            return None
        index = re.match(r"\[(\d+)\]\.?", rest)
        if index and isinstance(node, list):
            node, rest = _entry(node, int(index[1]), place, rest), rest[index.end() :]
            continue
        own = node if isinstance(node, Mapping) else {}
        name = _step(own, rest)
        if name is None:
            raise KeyError(_none(place, rest, own))
        node, rest = own[name], _behind(rest, name)
    return node


def _entry(entries: Sequence[Any], number: int, place: str, rest: str) -> Any:
    """An entry of a list; 0 for a bin that a histogram leaves out."""
    if number < len(entries):
        return entries[number]
    if not place.endswith(f".{HISTOGRAM}{rest}"):
        raise KeyError(f"{place}: there is no {rest}")
    if problem := _no_bin(place):
        raise KeyError(problem)
    return 0


def _no_bin(place: str) -> str:
    """What is wrong with a bin that no histogram has; empty for any other place."""
    found = re.search(rf"\.{HISTOGRAM}\[(\d+)\]$", place)
    if found is None or int(found[1]) < BINS:
        return ""
    return f"{place}: a histogram has no such bin; 0 to {BINS - 1} is expected"


def _step(names: Iterable[str], rest: str) -> str | None:
    """The longest of the names with which the rest of a place may begin."""
    return max(
        (name for name in names if rest == name or rest.startswith((name + ".", name + "["))), key=len, default=None
    )


def _behind(rest: str, name: str) -> str:
    return rest[len(name) :].removeprefix(".")


def _worst(report: Mapping[str, Any]) -> float | None:
    worst = [task["response_ps"]["worst"] for task in report["tasks"].values() if task["response_ps"]["count"]]
    return max(worst) / 1e6 if worst else None


@dataclass(frozen=True)
class Spread:
    """A metric over the repeats of one point."""

    n: int
    """Number of measured repeats."""
    mean: float
    low: float
    high: float
    """95 % interval of the mean: Wilson's for a share of runs, else by bootstrap with a fixed seed. NaN if nothing
    varies, because then there is no information on an interval."""
    varies: bool

    def __str__(self) -> str:
        if self.n == 0:
            return "–"
        return f"{self.mean:.4g} [{self.low:.4g}, {self.high:.4g}]" if self.varies else f"{self.mean:.4g}"


def spread(values: Sequence[float | bool]) -> Spread:
    """The spread of the values (NaN is left out)."""
    known = [one for one in values if isinstance(one, bool) or not math.isnan(one)]
    if not known:
        return Spread(0, math.nan, math.nan, math.nan, False)
    if len({float(one) for one in known}) == 1:
        return Spread(len(known), float(known[0]), math.nan, math.nan, False)
    if all(isinstance(one, bool) for one in known):
        low, high = share_interval(sum(map(bool, known)), len(known))
        return Spread(len(known), sum(map(bool, known)) / len(known), low, high, True)
    mean, low, high = mean_interval([float(one) for one in known])
    return Spread(len(known), mean, low, high, True)
