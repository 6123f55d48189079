"""The grid of a sweep: fixed settings, axes, repeats, events; from a TOML file or a dictionary (docs/sweeps.md)."""

from __future__ import annotations

import itertools
import math
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

from cmrc import _core, files
from cmrc.errors import Error
from cmrc.extras import needed
from cmrc.simulation import Setting

TABLES = ("fixed", "axes", "together", "repeats", "events", "futures", "fork", "search")
RANGE = ("from", "to", "step", "count", "scale")
REPEATS = ("seeds", "first", "phases")
APART = ("preset", "config")
"""Names that are not settings but may be fixed; a preset may also be an axis."""
FUTURE, EVENTS = "future", "events"
"""The axis of [[futures]]; the axis of the runs of one folder that differ by their events."""
MOST_RUNS = 10_000_000
MOST_WHOLE = 2**63 - 1
MOST_BYTES = 1 << 24
SEED, PHASES = "run.seed", "run.phase_jitter"


class GridError(Error, ValueError):
    """A grid that cannot be run. The message says where, and what would be right."""


@dataclass(frozen=True)
class Point:
    """One run of the grid."""

    place: Mapping[str, Setting]
    """Its value on every axis, by the setting's full name; the seed is separate."""
    seed: int | None
    """None: the seed is not varied."""
    settings: Mapping[str, Setting]
    preset: str | None
    config: str | None
    events: Sequence[Mapping[str, Setting]]


@dataclass(frozen=True)
class Grid:
    """A checked grid. ``points()`` are its runs, the last axis and the seed fastest."""

    fixed: Mapping[str, Setting] = field(default_factory=dict)
    preset: str | None = None
    config: str | None = None
    axes: Sequence[Sequence[Mapping[str, Setting]]] = ()
    """Each axis: its values, a dictionary per value; several settings go together in one axis."""
    seeds: Sequence[int] = ()
    events: Sequence[Mapping[str, Setting]] = ()
    futures: Mapping[str, Sequence[Mapping[str, Setting]]] = field(default_factory=dict)
    """By name, the events of each value of the axis FUTURE."""
    fork_at_s: float | None = None
    """Runs that are alike until then share what they have run."""
    search: Mapping[str, Any] = field(default_factory=dict)
    """The table [search], which ``cmrc.search`` checks."""
    name: str = "grid"

    def __len__(self) -> int:
        return math.prod(len(axis) for axis in self.axes) * max(1, len(self.seeds))

    @property
    def names(self) -> list[str]:
        """The settings that vary, in order."""
        return [key for axis in self.axes for key in axis[0]]

    def point(self, place: Mapping[str, Setting], seed: int | None) -> Point:
        settings = {**self.fixed, **place}
        preset = settings.pop("preset", self.preset)
        if seed is not None:
            settings[SEED] = seed
        events = [*self.events, *self.futures.get(str(settings.pop(FUTURE, "")), ())]
        return Point(dict(place), seed, settings, None if preset is None else str(preset), self.config, events)

    def points(self) -> Iterator[Point]:
        for values in itertools.product(*self.axes):
            place = {key: value for part in values for key, value in part.items()}
            for seed in self.seeds or (None,):
                yield self.point(place, seed)


def read(path: str | os.PathLike[str]) -> Grid:
    """A grid from a TOML file. Raises GridError, which names the file and the place; OSError."""
    toml = needed("tomllib" if sys.version_info >= (3, 11) else "tomli", "sweep", "a grid in TOML")
    name = os.fspath(path)
    try:
        content = files.read(path, MOST_BYTES)
    except ValueError as error:
        raise GridError(str(error)) from None
    try:
        tables = toml.loads(content.decode())
    except (ValueError, RecursionError) as error:
        raise GridError(f"{name}: no TOML: {error}") from None
    return made(tables, name=str(name), folder=Path(path).parent)


def made(tables: Mapping[str, Any], name: str = "grid", folder: Path | None = None) -> Grid:
    """A grid from a dictionary in the form of TOML. A relative ``config`` is looked for in ``folder``. Raises
    GridError."""
    try:
        return _Reader(tables, name, folder).grid()
    except GridError as error:
        raise GridError(files.printable(f"{name}: {error}")) from None


@cache
def schema() -> dict[str, dict[str, Any]]:
    """The configuration's keys by full name."""
    return {key["name"]: key for key in _core.cmrc.config_keys()}


@cache
def _shorts() -> dict[str, list[str]]:
    names: dict[str, list[str]] = {}
    for name in schema():
        names.setdefault(name.rpartition(".")[2], []).append(name)
    return names


def full_name(key: str, where: str) -> str:
    """The setting with that name, or with that last part. Raises GridError with the nearest one."""
    if key in schema() or key == "preset":
        return key
    found = _shorts().get(key, [])
    if len(found) == 1:
        return found[0]
    if found:
        raise GridError(f"{where}: several settings have this name; one of {', '.join(found)} is expected")
    right = _core.io.did_you_mean(key, [name for name in APART if name != key]) or f"; {_core.cmrc.right_key(key)}"
    raise GridError(f"{where}: no such key{right}")


def axis_name(key: str, where: str) -> str:
    """The axis with that name, or of the setting with that last part. Raises GridError with the nearest one."""
    return key if key in (FUTURE, EVENTS, *APART) else full_name(key, where)


class _Reader:
    def __init__(self, tables: Mapping[str, Any], name: str, folder: Path | None) -> None:
        self.tables, self.name, self.folder = tables, name, folder
        self.taken: dict[str, str] = {}  # by setting, its place in the file

    def grid(self) -> Grid:
        if not self.tables:
            raise GridError(f"the grid is empty; at least one of {', '.join(TABLES)} is expected")
        for table in self.tables:
            if table not in TABLES:
                right = _core.io.did_you_mean(table, [*TABLES]) or f"; {', '.join(TABLES)} are known"
                raise GridError(f"{table}: no such table{right}")
        fixed = self._fixed()
        axes = [*self._axes(), *self._together()]
        events, futures = self._events("events", self.tables.get("events", [])), self._futures()
        if futures:
            axes.append([{FUTURE: name} for name in futures])
        seeds, phases = self._repeats()
        if phases is not None:
            self._take(PHASES, "repeats.phases")
            fixed[PHASES] = phases
        preset, config = fixed.pop("preset", None), fixed.pop("config", None)
        grid = Grid(
            fixed,
            _text(preset, "fixed.preset"),
            self._file(config),
            axes,
            seeds,
            events,
            futures,
            self._fork(futures),
            self._table("search"),
            self.name,
        )
        if len(grid) > MOST_RUNS:
            raise GridError(f"{len(grid)} runs; at most {MOST_RUNS} are expected")
        return grid

    def _table(self, name: str) -> Mapping[str, Any]:
        table = self.tables.get(name, {})
        if not isinstance(table, Mapping):
            raise GridError(f"{name}: a table is expected, [{name}]")
        return table

    def _take(self, key: str, where: str) -> None:
        if key in self.taken:
            raise GridError(f"{where}: {key} is also given at {self.taken[key]}; one place is expected")
        self.taken[key] = where

    def _fixed(self) -> dict[str, Any]:
        fixed: dict[str, Any] = {}
        for key, value, where in flat(self._table("fixed"), "fixed", ranges=False):
            name = key if key in APART else full_name(key, where)
            self._take(name, where)
            fixed[name] = _scalar(value, where)
        return fixed

    def _axes(self) -> Iterator[list[dict[str, Setting]]]:
        for key, value, where in flat(self._table("axes"), "axes", ranges=True):
            name = full_name(key, where)
            self._take(name, where)
            yield [{name: one} for one in values_of(name, value, where)]

    def _together(self) -> Iterator[list[dict[str, Setting]]]:
        rows = self.tables.get("together", [])
        if not isinstance(rows, list):
            raise GridError("together: a list of tables is expected, [[together]]")
        for n, row in enumerate(rows):
            columns: dict[str, list[Setting]] = {}
            where = f"together[{n}]"
            if not isinstance(row, Mapping) or not row:
                raise GridError(f"{where}: settings with lists of equal length are expected")
            for key, value, place in flat(row, where, ranges=True):
                name = full_name(key, place)
                self._take(name, place)
                columns[name] = values_of(name, value, place, unique=False)
            lengths = {name: len(values) for name, values in columns.items()}
            if len(set(lengths.values())) > 1:
                counts = ", ".join(f"{name} {length}" for name, length in lengths.items())
                raise GridError(f"{where}: settings that go together have equally many values, not {counts}")
            together = [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)]
            if any(one in together[:i] for i, one in enumerate(together)):
                raise GridError(f"{where}: a combination is given twice; each is run once")
            yield together

    def _repeats(self) -> tuple[list[int], bool | None]:
        table = self._table("repeats")
        for key in table:
            if key not in REPEATS:
                raise GridError(f"repeats.{key}: unknown; {', '.join(REPEATS)} are known")
        if "seeds" not in table:
            if "first" in table:
                raise GridError("repeats.first: needs repeats.seeds, how many seeds there are")
            seeds: list[int] = []
        else:
            self._take(SEED, "repeats.seeds")
            seeds = _seeds(table["seeds"], table.get("first", 1), "first" in table)
        phases = table.get("phases")
        if phases is not None and not isinstance(phases, bool):
            raise GridError("repeats.phases: true or false is expected")
        return seeds, phases

    def _file(self, config: Any) -> str | None:
        text = _text(config, "fixed.config")
        return None if text is None else str((self.folder or Path()).joinpath(text).absolute())

    def _events(self, where: str, events: Any) -> list[dict[str, Setting]]:
        if not isinstance(events, list) or any(not isinstance(event, Mapping) for event in events):
            raise GridError(f"{where}: a list of tables is expected" + (", [[events]]" if where == "events" else ""))
        return [
            {key: _scalar(value, f"{where}[{n}].{key}") for key, value in event.items()}
            for n, event in enumerate(events)
        ]

    def _futures(self) -> dict[str, list[dict[str, Setting]]]:
        rows = self.tables.get("futures", [])
        if not isinstance(rows, list) or any(not isinstance(row, Mapping) for row in rows):
            raise GridError("futures: a list of tables is expected, [[futures]]")
        found: dict[str, list[dict[str, Setting]]] = {}
        for n, row in enumerate(rows):
            where = f"futures[{n}]"
            for key in row:
                if key not in ("name", "events"):
                    raise GridError(f"{where}.{key}: unknown; name and events are known")
            name = _text(row.get("name"), f"{where}.name")
            if not name:
                raise GridError(f"{where}.name: a name for this future is expected")
            if name in found:
                raise GridError(f"{where}.name: {name!r} is given twice; each is run once")
            found[name] = self._events(f"{where}.events", row.get("events", []))
        return found

    def _fork(self, futures: Mapping[str, Sequence[Mapping[str, Setting]]]) -> float | None:
        table = self._table("fork")
        if "fork" not in self.tables:
            return None
        for key in table:
            if key != "at_s":
                raise GridError(f"fork.{key}: unknown; at_s is known")
        at_s = table.get("at_s")
        if not isinstance(at_s, (int, float)) or isinstance(at_s, bool) or not 0 < at_s < math.inf:
            raise GridError("fork.at_s: an instant of the runs in s, above 0, is expected")
        if len(futures) < 2:
            raise GridError(
                "fork: only runs that differ by [[futures]] can share their beginnings; at least two futures are expected"
            )
        for n, events in enumerate(futures.values()):
            for i, event in enumerate(events):
                begins = event.get("at_s")
                if isinstance(begins, (int, float)) and begins < at_s:
                    raise GridError(
                        f"futures[{n}].events[{i}].at_s: {begins:g} s is before fork.at_s, {at_s:g} s; until then runs "
                        "that share a beginning have to be alike"
                    )
        return float(at_s)


def flat(table: Mapping[str, Any], where: str, ranges: bool, prefix: str = "") -> Iterator[tuple[str, Any, str]]:
    """Keys with dots; TOML reads them as tables in tables."""
    for key, value in table.items():
        if not isinstance(key, str):
            raise GridError(f"{where}: {key!r} is not the name of a setting")
        name = f"{prefix}{key}"
        if isinstance(value, Mapping) and not (ranges and "from" in value):
            if not value:
                raise GridError(f"{where}.{name}: an empty table; a value is expected")
            yield from flat(value, where, ranges, f"{name}.")
        else:
            yield name, value, f"{where}.{name}"


def plain(value: Any) -> Any:
    """A number of NumPy as Python's."""
    single = hasattr(value, "item") and not isinstance(value, (str, bytes)) and getattr(value, "ndim", 1) == 0
    return value.item() if single else value


def as_typed(name: str, value: Any) -> Any:
    """1 is 1.0 where a setting may have a fraction."""
    whole = schema().get(name, {}).get("type", "integer") == "integer"
    return value if whole or isinstance(value, bool) or not isinstance(value, int) else float(value)


def _scalar(value: Any, where: str) -> Setting:
    value = plain(value)
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    if not isinstance(value, (bool, int, float, str)):
        raise GridError(f"{where}: {type(value).__name__} cannot be used; true, false, a number or a text is expected")
    if isinstance(value, int) and not -MOST_WHOLE <= value <= MOST_WHOLE:
        raise GridError(f"{where}: {value} is beyond 64 bits")
    if isinstance(value, float) and not math.isfinite(value):
        raise GridError(f"{where}: {value} is not a number that a setting can have")
    return value


def _text(value: Any, where: str) -> str | None:
    if value is not None and not isinstance(value, str):
        raise GridError(f"{where}: a text is expected")
    return value


def values_of(key: str, value: Any, where: str, unique: bool = True) -> list[Setting]:
    if isinstance(value, Mapping):
        return _range(key, value, where)
    if hasattr(value, "tolist"):
        value = value.tolist()
    if not isinstance(value, (list, tuple, range)):
        raise GridError(f"{where}: a list of values, or from and to with step or count, is expected")
    if not value:
        raise GridError(f"{where}: the list is empty; at least one value is expected")
    values = [_scalar(one, f"{where}[{n}]") for n, one in enumerate(value)]
    seen = set()
    for n, one in enumerate(values):
        typed = isinstance(one, bool), as_typed(key, one)  # True is not 1, and 1 is 1.0
        if unique and typed in seen:
            raise GridError(f"{where}[{n}]: {one!r} is given twice; each is run once")
        seen.add(typed)
    return values


def _range(key: str, value: Mapping[str, Any], where: str) -> list[Setting]:
    for part in value:
        if part not in RANGE:
            raise GridError(f"{where}.{part}: unknown; {', '.join(RANGE)} are known")
    numbers = {}
    for part in ("from", "to", "step", "count"):
        if part in value:
            number = _scalar(value[part], f"{where}.{part}")
            if isinstance(number, (bool, str)):
                raise GridError(f"{where}.{part}: a number is expected")
            numbers[part] = number
    if "to" not in numbers or ("step" in numbers) == ("count" in numbers):
        raise GridError(f"{where}: from and to, and either step or count, are expected")
    begin, end = numbers["from"], numbers["to"]
    if not begin < end:
        raise GridError(f"{where}: from {begin} to {end}; from < to is expected")
    if value.get("scale", "linear") not in ("linear", "log"):
        raise GridError(f'{where}.scale: "linear" or "log" is expected')
    if "step" in numbers:
        found = _by_step(begin, end, numbers["step"], value, where)
    else:
        found = _by_count(begin, end, numbers["count"], value.get("scale") == "log", where)
    if schema().get(key, {}).get("type") != "integer":
        found = [float(one) for one in found]
    else:
        for one in found:
            if not isinstance(one, int):
                raise GridError(f"{where}: {one:g} is among its values; {key} is a whole number")
    if len(set(found)) < len(found):
        raise GridError(f"{where}: neighbours are one number ({found[0]!r} and so on); each is run once")
    return list(found)


def _by_step(begin: float, end: float, step: float, value: Mapping[str, Any], where: str) -> list[int | float]:
    if not step > 0:
        raise GridError(f"{where}.step: {step}; a step above 0 is expected")
    if value.get("scale") == "log":
        raise GridError(f'{where}.scale: "log" goes with count, not with step')
    steps = (_exact(end) - _exact(begin)) / _exact(step)
    count = math.floor(steps * (1 + Fraction(1, 10**12))) + 1
    if count > MOST_RUNS:
        raise GridError(f"{where}.step: {count} values; at most {MOST_RUNS} are expected")
    return _evenly(_exact(begin), _exact(end), _exact(step), count)


def _by_count(begin: float, end: float, count: float, log: bool, where: str) -> list[int | float]:
    if count != int(count) or not 2 <= count <= MOST_RUNS:
        raise GridError(f"{where}.count: {count}; a whole number from 2 to {MOST_RUNS} is expected")
    parts = int(count) - 1
    if not log:
        return _evenly(_exact(begin), _exact(end), (_exact(end) - _exact(begin)) / parts, parts + 1)
    if not begin > 0:
        raise GridError(f"{where}.from: {begin}; a logarithmic range begins above 0")
    inner = [_whole_if_near(begin ** (1 - n / parts) * end ** (n / parts)) for n in range(1, parts)]
    return [int(begin) if begin == int(begin) else begin, *inner, int(end) if end == int(end) else end]


def _exact(number: float) -> Fraction:
    """The number as it is written: 0.1 is a tenth."""
    return Fraction(repr(number))


def _evenly(begin: Fraction, end: Fraction, step: Fraction, count: int) -> list[int | float]:
    """Each value is exact if it is whole, else the nearest number; none is beyond the end."""
    whole = math.lcm(begin.denominator, end.denominator, step.denominator)
    first, last, each = (int(one * whole) for one in (begin, end, step))
    values = (min(first + n * each, last) for n in range(count))
    return [one // whole if one % whole == 0 else one / whole for one in values]


def _whole_if_near(number: float) -> int | float:
    """To 12 digits, which is more than a power is worth."""
    return round(number) if abs(number - round(number)) <= 1e-12 * number else float(f"{number:.12g}")


def _seeds(seeds: Any, first: Any, has_first: bool) -> list[int]:
    where = "repeats.seeds"
    if isinstance(seeds, (list, tuple)):
        if has_first:
            raise GridError("repeats.first: goes with a number of seeds, not with a list of them")
        if not seeds or any(
            not isinstance(one, int) or isinstance(one, bool) or not 0 <= one <= MOST_WHOLE for one in seeds
        ):
            raise GridError(f"{where}: whole numbers from 0 to 2^63 - 1 are expected, at least one")
        if len(set(seeds)) < len(seeds):
            raise GridError(f"{where}: a seed is given twice; each is run once")
        return list(seeds)
    for place, number, least in ((where, seeds, 1), ("repeats.first", first, 0)):
        if not isinstance(number, int) or isinstance(number, bool) or not least <= number <= MOST_RUNS:
            raise GridError(f"{place}: a whole number from {least} to {MOST_RUNS} is expected")
    return list(range(first, first + seeds))
