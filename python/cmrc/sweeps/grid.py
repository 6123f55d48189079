"""The grid of a sweep: fixed settings, axes, repeats, events; from a TOML file or a dictionary (docs/sweeps.md)."""

from __future__ import annotations

import itertools
import math
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from cmrc import _core, files
from cmrc.extras import needed
from cmrc.floats import shortest
from cmrc.simulation import Setting
from cmrc.sweeps.ranges import MOST_RUNS, MOST_WHOLE, GridError, scalar, schema, seeds_of, values_of

TABLES = ("fixed", "axes", "together", "repeats", "events", "futures", "fork", "search")
REPEATS = ("seeds", "first", "phases")
APART = ("preset", "config")
"""Names that are not settings but may be fixed; a preset may also be an axis."""
FUTURE, EVENTS = "future", "events"
"""The axis of [[futures]]; the axis of the runs of one folder that differ by their events."""
MOST_BYTES = 1 << 24
SEED, PHASES = "run.seed", "run.phase_jitter"


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
            fixed[name] = scalar(value, where)
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
            seeds = seeds_of(table["seeds"], table.get("first", 1), "first" in table)
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
            {key: scalar(value, f"{where}[{n}].{key}") for key, value in event.items()}
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
        if not isinstance(at_s, (int, float)) or isinstance(at_s, bool) or not 0 < at_s <= MOST_WHOLE:
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
                        f"futures[{n}].events[{i}].at_s: {shortest(begins)} s is before fork.at_s, {shortest(at_s)} s; "
                        "until then runs that share a beginning have to be alike"
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


def _text(value: Any, where: str) -> str | None:
    if value is not None and not isinstance(value, str):
        raise GridError(f"{where}: a text is expected")
    return value
