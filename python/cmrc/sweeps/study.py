"""A sweep: its request, and its results."""

from __future__ import annotations

import html
import json
import math
import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from cmrc import arguments, files, saved_result, simulation
from cmrc.floats import shortest
from cmrc.sweeps import grid as grids
from cmrc.sweeps import metrics, ranges, store, work
from cmrc.sweeps.grid import Grid
from cmrc.sweeps.identity import Keys, Run
from cmrc.sweeps.metrics import Metric, Spread
from cmrc.sweeps.runner import Status, place_of
from cmrc.sweeps.session import Place, Session
from cmrc.sweeps.store import Folder, SweepError
from cmrc.table import Table

if TYPE_CHECKING:
    import pandas

    from cmrc.result import Result

BESIDE = ("seed", "status", "message")
"""Columns of a table beside the axes and the metrics."""
APART = (*grids.APART, grids.EVENTS)
"""What a run is made of besides its settings."""
OF_NO_RUN = frozenset({"profile", "keep_events", "reference", "on_progress"})
"""Arguments of ``cmrc.run`` with which it is the same run."""


class Sweep:
    """The runs in a folder. Reports are read when they are needed.

    ``sweep.table("misses", "tasks.pid.response_ps.p99")`` has one row per run, ``sweep.summary("misses")`` one per
    point of the grid, over its repeats.
    """

    def __init__(self, folder: str | os.PathLike[str], of: Sequence[Run] | None = None) -> None:
        """``of``: the points of one grid. None: every point of the folder, whichever grids it was filled from."""
        self.folder = Folder(folder)
        self.folder.check()
        if self.folder.head() is None:
            raise SweepError(f"{folder}: not a folder of a sweep")
        if of is None:
            self._runs = self._completed([self.folder.opened(row) for row in self.folder.rows(store.LIGHT)])
        else:
            rows = {row["key"]: row for row in self.folder.rows(store.LIGHT)}
            self._runs = [self.folder.opened({**rows[run.key], **place_of(run.point)}) for run in of if run.key in rows]
            for one in self._runs:
                one["place"] = {name: ranges.as_typed(name, value) for name, value in one["place"].items()}

    def _completed(self, runs: list[dict[str, Any]]) -> list[dict[str, Any]]:
        """In the order of their places. What differs between two runs is an axis of all runs, because a repeat differs
        in its seed only. What is an axis of one grid and fixed in another has its value in the runs of both."""
        axes = _axes(runs)
        named = dict.fromkeys(name for run in runs for name in run["settings"] if name not in (grids.SEED, *APART))
        seeds = {run["settings"].get(grids.SEED) for run in runs}
        seeded = any(run["seed"] is not None for run in runs) or (grids.SEED not in axes and len(seeds - {None}) > 1)
        given = [{**run["settings"], **run["place"]} for run in runs]
        from_files = any("config" in run["settings"] for run in runs)
        open_ = {
            run["key"]
            for run, own in zip(runs, given, strict=True)
            if from_files or any(name not in own for name in (*axes, *named)) or (seeded and grids.SEED not in own)
        }
        known = self._configurations(open_)
        values = [{"preset": "base", **known.get(run["key"], {}), **own} for run, own in zip(runs, given, strict=True)]
        fixed = dict.fromkeys((*named, *(name for one in known.values() for name in one))) if from_files else named
        axes += [name for name in fixed if name not in (*axes, grids.SEED) and _differs(values, name)]
        for run, of in zip(runs, values, strict=True):
            run["place"] = {name: ranges.as_typed(name, of.get(name)) for name in axes}
            if seeded and run["seed"] is None:
                run["seed"] = of.get(grids.SEED)
        for name in APART:
            texts = [_text(name, of.get(name)) for of in values]
            if name not in axes and _apart(runs, texts):
                axes.append(name)
                for run, text in zip(runs, texts, strict=True):
                    run["place"][name] = text
        once = {(run["key"], json.dumps(run["place"]), run["seed"]): run for run in runs}  # a point of several grids
        return sorted(once.values(), key=lambda run: _order(run, axes))

    def _configurations(self, keys: Collection[str]) -> dict[str, Mapping[str, Any]]:
        """Every setting of these runs, as far as they have reports."""
        known: dict[str, Mapping[str, Any]] = {}
        if keys:
            for row in self.folder.rows(("report",)):
                if row["key"] in keys and row["report"] is not None:
                    configuration = self.folder.report(row).get("configuration")
                    known[row["key"]] = configuration if isinstance(configuration, dict) else {}
        return known

    @property
    def runs(self) -> list[dict[str, Any]]:
        """What is known of each run without its report: ``place`` (its value on every axis), ``seed``, ``status``
        (done, refused, failed), ``message``, ``settings`` (with preset, config and events), ``hash``, ``build``,
        ``emulator_version``, ``elapsed_s``, ``host``, ``key``."""
        return [{**run, "place": dict(run["place"]), "settings": _copied(run["settings"])} for run in self._runs]

    @property
    def axes(self) -> list[str]:
        """The settings that vary."""
        return _axes(self._runs)

    def counts(self) -> dict[str, int]:
        """Runs by status."""
        states = [run["status"] for run in self._runs]
        return {state: states.count(state) for state in (store.DONE, store.REFUSED, store.FAILED)}

    def reports(self) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
        """Every run that was done, with its report (docs/report.md). Raises SweepError for reports of another schema,
        and where the folder has lost runs."""
        wanted: dict[str, list[dict[str, Any]]] = {}
        for run in self.runs:
            if run["status"] == store.DONE:
                wanted.setdefault(run["key"], []).append(run)
        empty: dict[str, dict[str, Any]] = {}
        for row in self.folder.rows(("report",)):
            if row["key"] not in wanted:
                continue
            if row["report"] is None:  # another point that is the same run has it
                empty[row["key"]] = row
                continue
            report = self._report(row)
            for run in wanted.pop(row["key"]):
                yield run, report
        for key, row in empty.items():
            if key in wanted:  # the run itself has none: it is damaged
                self._report(row)
        if wanted:
            raise SweepError(
                f"{self.folder.path}: {len(wanted)} of its runs are not there any more; the folder as it was when this "
                "Sweep was made is expected"
            )

    def _report(self, row: Mapping[str, Any]) -> dict[str, Any]:
        report = self.folder.report(row)
        try:
            return saved_result.checked_report(report)
        except ValueError as error:
            raise SweepError(f"{self.folder.path}: {error}") from None

    def report(self, seed: int | None = None, **place: Any) -> dict[str, Any]:
        """The report of one run, by its place (``dsps=2``) and seed. Raises KeyError unless exactly one run fits."""
        asked = {grids.axis_name(name, name): value for name, value in place.items()}
        found = [
            run
            for run in self.runs
            if run["status"] == store.DONE
            and (seed is None or run["seed"] == seed)
            and all(run["place"].get(name) == value for name, value in asked.items())
        ]
        if len(found) != 1:
            raise KeyError(f"{len(found)} runs are at {asked}, seed {seed}; one is expected")
        return next(report for run, report in self.reports() if run["key"] == found[0]["key"])

    def rerun(self, run: Mapping[str, Any], **more: Any) -> Result:
        """Runs one of ``runs`` again, for its signals: the same bit for bit, with the same ``hash``. ``more`` is passed
        on to ``cmrc.run``: ``keep_events=True``, ``profile=True``, ``on_progress=...``; with settings among them it is
        another run. Raises SweepError where it would not be the same run: a file that its settings name has been
        changed, or is another one from this working folder."""
        of = arguments.mapping("run", run, "one of Sweep.runs")
        settings = dict(of["settings"])
        apart = {name: settings.pop(name) for name in ("preset", "config", "events") if name in settings}
        if of.get("status", store.DONE) == store.DONE and "key" in of and more.keys() <= OF_NO_RUN:
            config = simulation.configured(
                apart.get("config"), apart.get("preset"), settings, apart.get("events", ()), {}
            )
            if Keys().of(config, of.get("build")) != of["key"]:
                raise SweepError(
                    f"{self.folder.path}: the run {of['key'][:12]} would not be the same again: a file that its "
                    "settings name has been changed since, or is another one from this working folder, or this is "
                    "another version of cmrc"
                )
        return simulation.run(settings=settings, **apart, **more)

    def values(self, metric: Metric) -> dict[str, float | bool]:
        """A metric of every finished run, by key. Runs nothing. Raises KeyError for a place that no report has."""
        return {key: values[0] for key, values in self._measured([metric]).items()}

    def _measured(self, of: Sequence[Metric]) -> dict[str, list[float | bool]]:
        """All of them with one reading of the reports."""
        for metric in of:
            metrics.check_kind(metric)
        return metrics.of_reports(((run["key"], report) for run, report in self.reports()), of)

    def table(self, *of: Metric) -> Table:
        """One row per run: its axes, ``seed``, ``status``, ``message``, and the metrics; NaN if nothing was measured.
        A metric whose name another column has gets a number (``<lambda> 2``)."""
        return Table.from_rows(self._rows(of))

    def _rows(self, of: Sequence[Metric]) -> list[dict[str, Any]]:
        """Those of the table, with numbers as they are: whole ones are whole beside missing ones, too."""
        asked = of or metrics.USUAL
        found, axes = self._measured(asked), dict.fromkeys(self.axes)
        names = metrics.names_of(asked, {*axes, *BESIDE})
        nothing = [math.nan] * len(names)
        return [
            {
                **axes,
                **run["place"],
                "seed": run["seed"],
                "status": run["status"],
                "message": run["message"],
                **dict(zip(names, found.get(run["key"], nothing), strict=True)),
            }
            for run in self.runs
        ]

    def to_frame(self, *of: Metric) -> pandas.DataFrame:
        """The same as a pandas frame. A column of whole numbers of which some are missing has the type Int64, with NA.
        Raises ImportError without pandas."""
        rows = self._rows(of)
        frame = Table.from_rows(rows).to_pandas()
        from pandas import array

        for name in frame:
            if _whole_with_gaps(values := [row[name] for row in rows]):
                frame[name] = array([value if isinstance(value, int) else None for value in values], dtype="Int64")
        return frame

    def _cells(self, of: Sequence[Metric]) -> Iterator[list[Any]]:
        """The table as plain values, its heads first. A whole number beside missing ones is no float here; beside
        floats it is one."""
        rows = self._rows(of)
        table = Table.from_rows(rows)
        yield list(table)
        columns = []
        for name, column in table.items():
            cells, values = column.tolist(), [row[name] for row in rows]
            if not any(isinstance(value, float) and not math.isnan(value) for value in values):
                cells = [own if isinstance(own, int) else cell for own, cell in zip(values, cells, strict=True)]
            columns.append(cells)
        yield from map(list, zip(*columns, strict=True))

    def summary(self, metric: Metric = "misses") -> list[tuple[dict[str, Any], Spread]]:
        """Each point of the grid, and the metric over its repeats. Raises SweepError where two runs have the same
        settings and seed, and are not the same."""
        return self._summaries([metric])[0]

    def _summaries(self, of: Sequence[Metric]) -> list[list[tuple[dict[str, Any], Spread]]]:
        measured = self._measured(of)
        points: dict[str, tuple[dict[str, Any], list[list[float | bool]]]] = {}
        once: dict[tuple[str, int | None], str] = {}
        for run in self.runs:
            point = json.dumps(run["place"])
            _, known = points.setdefault(point, (run["place"], []))
            if run["key"] in measured:
                if once.setdefault((point, run["seed"]), run["key"]) != run["key"]:
                    raise SweepError(
                        f"{self.folder.path}: two runs are at {run['place']}, seed {run['seed']}, and are no repeats: "
                        "a file that their configurations name was changed between them. One folder for each is "
                        "expected"
                    )
                known.append(measured[run["key"]])
        return [
            [(place, metrics.spread([values[n] for values in known])) for place, known in points.values()]
            for n in range(len(of))
        ]

    def text(self, *of: Metric) -> str:
        """A table for a terminal: one row per point, the metrics with their intervals and n."""
        asked = of or metrics.USUAL
        summaries = self._summaries(asked)
        axes = self.axes
        heads = [*ranges.short_names(axes), "n"]
        heads += [
            " ".join(filter(None, (name, _bracket(metrics.unit_of(metric)))))
            for name, metric in zip(metrics.names_of(asked, {*axes, "n"}), asked, strict=True)
        ]
        lines = [
            [
                *(_cell(place.get(name)) for name in axes),
                str(most),
                *(_with_n(summary[n][1], most) for summary in summaries),
            ]
            for n, (place, _) in enumerate(summaries[0])
            for most in (max(summary[n][1].n for summary in summaries),)
        ]
        return _columns([heads, *lines]) + self._notes(summaries)

    def _notes(self, summaries: Sequence[Sequence[tuple[dict[str, Any], Spread]]]) -> str:
        counts = self.counts()
        text = f"\n{counts[store.DONE]} runs done, {counts[store.REFUSED]} refused, {counts[store.FAILED]} failed.\n"
        spreads = [one for summary in summaries for _, one in summary if one.n > 1]
        if spreads and not any(one.varies for one in spreads):
            text += "All repeats of every point agree: these numbers have no randomness, and no intervals.\n"
        elif any(one.varies for one in spreads):
            text += "Intervals of 95 %: Wilson's of shares of runs, else bootstrap of the mean; "
            text += "none where all repeats agree.\n"
        lines: dict[str, int] = {}
        for run in self.runs:
            if run["status"] != store.DONE:
                line = f"{run['status']}: {run['message'].splitlines()[0] if run['message'] else ''}"
                lines[line] = lines.get(line, 0) + 1
        return text + "".join(f"  {count} {line}\n" for line, count in list(lines.items())[:10])

    def __len__(self) -> int:
        return len(self._runs)

    def __repr__(self) -> str:
        return f"<cmrc.Sweep: {len(self)} runs over {', '.join(self.axes) or 'nothing'} in {self.folder.path}>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self.text())}</pre>"


GridLike = Grid | Mapping[str, Any] | str | os.PathLike[str]


def sweep(
    grid: GridLike,
    folder: str | os.PathLike[str],
    *,
    address: str | None = None,
    workers: int | None = None,
    security: Mapping[str, Any] | None = None,
    again_failed: bool = False,
    on_progress: Callable[[Status], object] | None = None,
) -> Sweep:
    """Runs every point of a grid that is not in the folder yet, and keeps the reports there (docs/sweeps.md).

    ``grid`` is a TOML file or a dictionary of the same form. Runs go to ``workers`` processes of this machine (default:
    one per processor) or to the Dask cluster at ``address``; ``security`` has the fields of ``distributed.Security``.
    Who can reach a cluster can run code on it. ``again_failed`` runs again what failed. ``on_progress(status)`` is
    called several times a second.

    A sweep that was interrupted continues; one whose grid has grown runs what is new. Raises GridError for a grid that
    cannot be run; SweepError for a folder that is in use or of another version, a full disk, a cluster that does not
    answer: what was written stays. Raises ImportError that says what to install."""
    made = grid_of(grid)
    arguments.function("on_progress", on_progress, "a function of a Status or None")
    if workers is not None:
        arguments.whole("workers", workers, "a number of processes, 1 to 1024,", 1, 1024)
    arguments.flag("again_failed", again_failed)
    return run_grid(made, folder, Place(address, workers, security), again_failed=again_failed, on_progress=on_progress)


def grid_of(grid: GridLike) -> Grid:
    if isinstance(grid, Grid):
        return grid
    if isinstance(grid, Mapping):
        return grids.made(grid)
    return grids.read(arguments.path("grid", grid, "the path of a TOML file, or a dictionary,"))


def run_grid(
    grid: Grid,
    folder: str | os.PathLike[str],
    place: Place,
    execute: work.Execute | None = None,
    again_failed: bool = False,
    on_progress: Callable[[Status], object] | None = None,
) -> Sweep:
    """The same with the function that does a run."""
    if execute is None:
        execute = work.execute if grid.fork_at_s is None else work.Forked(grid.fork_at_s)
    with Session(folder, place, execute, again_failed, on_progress) as session:
        runs = session.run(grid.points(), grid.fork_at_s)
    return Sweep(session.folder.path, runs)


def _whole_with_gaps(values: Sequence[Any]) -> bool:
    """Whole numbers of 64 bits, of which some are missing."""
    there = [value for value in values if type(value) is int]
    others = [value for value in values if type(value) is not int]
    missing = all(value is None or (isinstance(value, float) and math.isnan(value)) for value in others)
    return bool(there and others) and missing and all(abs(value) < 2**63 for value in there)


def _copied(settings: Mapping[str, Any]) -> dict[str, Any]:
    copy = dict(settings)
    if grids.EVENTS in copy:
        copy[grids.EVENTS] = [dict(event) for event in copy[grids.EVENTS]]
    return copy


def _axes(runs: Sequence[Mapping[str, Any]]) -> list[str]:
    places = sorted((run["place"] for run in runs), key=len, reverse=True)  # the order of the grid that varies most
    return list(dict.fromkeys(name for place in places for name in place))


def _differs(runs: Iterable[Mapping[str, Any]], name: str) -> bool:
    """Two runs have different values; a run that was not made may have none."""
    return len({value for run in runs if (value := run.get(name)) is not None}) > 1


def _apart(runs: Sequence[Mapping[str, Any]], texts: Sequence[str | None]) -> bool:
    """Two runs of one place have different ones."""
    of_place: dict[str, str | None] = {}
    return any(
        of_place.setdefault(json.dumps(run["place"]), text) != text for run, text in zip(runs, texts, strict=True)
    )


def _text(name: str, value: Any) -> str | None:
    """The value on an axis: of events all their fields."""
    if name != grids.EVENTS or value is None:
        return value if value is None else str(value)
    return "; ".join(" ".join(f"{field}={one}" for field, one in event.items()) for event in value)


def _order(run: Mapping[str, Any], axes: Sequence[str]) -> tuple[Any, ...]:
    """By place, then by seed: numbers by size, words by the alphabet, what has no value last."""
    values = [run["place"].get(name) for name in axes]
    order = [
        (
            2 if value is None else int(isinstance(value, str)),
            value if isinstance(value, (int, float)) else 0,
            str(value),
        )
        for value in values
    ]
    return (order, -1 if run["seed"] is None else run["seed"])


def _with_n(spread: Spread, most: int) -> str:
    """A metric with its own n where not every repeat has measured it."""
    return f"{spread} (n = {spread.n})" if 0 < spread.n < most else str(spread)


def _bracket(unit: str) -> str:
    return f"({unit})" if unit else ""


def _cell(value: Any) -> str:
    """In one line, also a name with a line feed."""
    return "–" if value is None else files.printable(shortest(value)).replace("\n", "\\x0A")


def _columns(lines: Sequence[Sequence[str]]) -> str:
    widths = [max(len(line[n]) for line in lines) for n in range(len(lines[0]))]
    return "".join(
        "  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True)).rstrip() + "\n" for line in lines
    )
