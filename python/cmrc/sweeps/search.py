"""Looks for the best settings, or for the last value that passes, in batches of fixed size: the same runs on 1 worker
or 100."""

from __future__ import annotations

import math
import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

from cmrc import arguments
from cmrc.extras import needed
from cmrc.floats import shortest
from cmrc.simulation import Setting
from cmrc.sweeps import grid as grids
from cmrc.sweeps import metrics, ranges, store, work
from cmrc.sweeps.grid import SEED, Grid
from cmrc.sweeps.identity import Run
from cmrc.sweeps.metrics import Spread
from cmrc.sweeps.ranges import GridError
from cmrc.sweeps.runner import Status
from cmrc.sweeps.session import Place, Session
from cmrc.sweeps.study import GridLike, Sweep, grid_of

COMMON = ("metric", "batch", "check_seeds")
BISECT = ("bisect", "from", "to", "tolerance", "at_most", "neighbours")
OPTIMISE = ("goal", "trials", "seed", "space")


@dataclass
class Trial:
    """One tried place: the metric over the search's seeds."""

    place: dict[str, Setting]
    spread: Spread
    worst: float = math.nan
    """The largest value of all seeds."""
    seeds: int = 1
    """So many were asked for; ``spread.n`` of them were measured."""
    refused: int = 0
    failed: int = 0

    @property
    def counts(self) -> bool:
        """Every seed was measured: else its mean would be that of the easy seeds."""
        return self.spread.n == self.seeds

    @property
    def unmeasured(self) -> int:
        """Seeds that were run to their end, and have no value of the metric."""
        return self.seeds - self.spread.n - self.refused - self.failed

    def passes(self, at_most: float) -> bool:
        """No seed is above it, and each was measured: what was not run has not passed."""
        return self.counts and self.worst <= at_most


@dataclass
class Found:
    """The outcome of a search."""

    metric: str
    best: dict[str, Setting] | None
    """The best settings; None if no place passes, or none could be run."""
    value: float
    """The metric there: for a bisection the worst of the search's seeds, else their mean."""
    checked: Spread
    """The metric of the answer with seeds that the search has not used: n of ``check_seeds`` were measured."""
    check_passed: bool | None
    """For a bisection: the answer passes with those seeds, too. Else None."""
    trials: list[Trial]
    exceptions: list[float] = field(default_factory=list)
    """For a bisection: values that pass beyond the answer, or do not pass before it: there the metric is not
    monotone. Without an answer: the hard end, if it passes."""
    whole_range: bool = False
    """For a bisection: its two ends pass, so it has looked no further."""
    sweep: Sweep | None = None
    """All runs."""
    check_seeds: int = 0
    """So many seeds that the search has not used were run."""

    def text(self) -> str:
        """For a terminal."""
        lines = [
            f"{_place(trial.place)}: {self.metric} {trial.spread} (n = {trial.spread.n})"
            + (f", {trial.refused} refused" if trial.refused else "")
            + (f", {trial.failed} failed" if trial.failed else "")
            + (f", {trial.unmeasured} not measured" if trial.unmeasured else "")
            for trial in self.trials
        ]
        if self.best is None:
            lines += ["", "Nothing was found."]
            if self.exceptions:
                lines.append(
                    f"{shortest(self.exceptions[0])} passes, and the easy end does not: are from and to the wrong way "
                    "round?"
                )
            return "\n".join(lines) + "\n"
        lines += ["", f"Found: {_place(self.best)}, {self.metric} {self.value:.4g}"]
        if self.whole_range:
            lines.append("The end of the range passes, too: the last value may lie beyond it.")
        if self.check_seeds:
            word = "" if self.check_passed is None else " It passes." if self.check_passed else " IT DOES NOT PASS."
            missing = self.check_seeds - self.checked.n
            of = f"; not measured in {missing} of {self.check_seeds}" if missing else ""
            lines.append(f"With seeds that the search has not used: {self.checked} (n = {self.checked.n}){of}.{word}")
        if self.exceptions:
            values = ", ".join(map(shortest, self.exceptions))
            lines.append(f"Not monotone: {values} contradicts the answer. A grid (cmrc sweep) shows more.")
        return "\n".join(lines) + "\n"


def search(
    spec: GridLike,
    folder: str | os.PathLike[str],
    *,
    address: str | None = None,
    workers: int | None = None,
    security: Mapping[str, Any] | None = None,
    on_progress: Callable[[Status], object] | None = None,
) -> Found:
    """Looks for settings by the table ``[search]`` of a grid (docs/sweeps.md, Search). Arguments as for ``sweep``.

    A search continues from the contents of the folder: the same search runs nothing twice. The answer is run again with
    seeds that the search has not used. Raises GridError, SweepError, ImportError.
    """
    grid = grid_of(spec)
    asked = asked_of(grid)
    arguments.function("on_progress", on_progress, "a function of a Status or None")
    with Session(folder, Place(address, workers, security), work.execute, on_progress=on_progress) as session:
        trier = _Trier(session, grid, asked.metric)
        found = asked.find(trier)
        asked.check(found, trier)
    found.sweep = Sweep(session.folder.path, list(trier.runs.values()))
    return found


def asked_of(grid: Grid) -> _Search:
    """The search that the table [search] asks for. Raises GridError."""
    return _Bisection(grid) if "bisect" in grid.search else _Optimisation(grid)


class _Search(ABC):
    """The table [search], checked. Raises GridError."""

    keys: ClassVar[tuple[str, ...]]
    """The keys of this kind of search."""

    def __init__(self, grid: Grid) -> None:
        self.name, table = grid.name, grid.search
        if not table:
            raise GridError(f"{grid.name}: search: there is no table [search]")
        if grid.axes:
            raise GridError(f"{grid.name}: search: goes with fixed settings and repeats, not with axes")
        self.table, self.grid = {key: ranges.plain(value) for key, value in table.items()}, grid
        for key in table:
            if key not in COMMON + self.keys:
                raise self.error(key, f"unknown; {', '.join(COMMON + BISECT)}, or {', '.join(OPTIMISE)} are known")
        self.metric = str(table.get("metric", "misses"))
        try:
            metrics.check_place(self.metric)
        except ValueError as error:
            raise self.error("metric", str(error)) from None
        self.batch = self._whole("batch", 8, 1)
        self.check_seeds = self._whole("check_seeds", 5 if grid.seeds else 0, 0)
        if self.check_seeds and (last := self._unused_seeds()[-1]) > ranges.MOST_WHOLE:
            raise self.error(
                "check_seeds",
                f"the last of the {self.check_seeds} seeds after those of the search is {last}; all seeds up to "
                "2^63 - 1 are expected, those of the check included",
            )

    @abstractmethod
    def find(self, trier: _Trier) -> Found:
        """Runs the search."""

    def check(self, found: Found, trier: _Trier) -> None:
        """Runs the answer with the seeds after those of the search."""
        if found.best is None or self.check_seeds == 0:
            return
        [trial] = trier.values([found.best], self._unused_seeds())
        found.checked, found.check_passed, found.check_seeds = trial.spread, self.passes(trial), trial.seeds

    def _unused_seeds(self) -> range:
        """The seeds after those of the search. Where the fixed one is no number, every run is refused."""
        fixed = self.grid.fixed.get(SEED, 1)
        first = max(self.grid.seeds, default=1 if isinstance(fixed, str) else int(fixed)) + 1
        return range(first, first + self.check_seeds)

    def passes(self, trial: Trial) -> bool | None:
        """None where nothing is to be passed."""
        return None

    def error(self, key: str, says: str) -> GridError:
        return GridError(f"{self.name}: search.{key}: {says}")

    def _whole(self, key: str, default: int, least: int, most: int = ranges.MOST_RUNS) -> int:
        value = self.table.get(key, default)
        if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= most:
            raise self.error(key, f"a whole number from {least} to {most} is expected")
        return value

    def _number(self, key: str, default: float | None) -> float:
        return float(ranges.number(self.table.get(key, default), f"{self.name}: search.{key}"))

    def _is_whole(self, key: str, value: Any, where: str) -> None:
        if isinstance(value, bool) or not (isinstance(value, int) or (isinstance(value, float) and value.is_integer())):
            raise self.error(where, f"{value!r} cannot be used; {key} is a whole number")

    def _setting(self, key: Any, where: str) -> str:
        if not isinstance(key, str):
            raise self.error(where, "the name of a setting is expected")
        try:
            name = grids.full_name(key, key)
        except GridError as error:
            raise self.error(where, str(error)) from None
        if name in self.grid.fixed:
            raise self.error(where, f"{name} is fixed, too; one place is expected")
        return name


class _Bisection(_Search):
    """The last value that passes, on the way from the easy end to the hard one."""

    keys = BISECT

    def __init__(self, grid: Grid) -> None:
        super().__init__(grid)
        self.key = self._setting(self.table["bisect"], "bisect")
        self.whole = ranges.schema().get(self.key, {}).get("type") == "integer"
        self.begin, self.end = self._number("from", None), self._number("to", None)
        for end in ("from", "to") if self.whole else ():
            self._is_whole(self.key, self.table[end], end)
        if self.begin == self.end:
            raise self.error("to", f"{shortest(self.end)} is where it begins; from is the easy end, to the hard one")
        self.tolerance = self._number("tolerance", 1.0 if self.whole else abs(self.end - self.begin) / 100)
        if not self.tolerance > 0 or (self.whole and self.tolerance < 1):
            raise self.error("tolerance", f"a number {'from 1 on' if self.whole else 'above 0'} is expected")
        self.at_most = self._number("at_most", 0.0)
        self.neighbours = self._whole("neighbours", 2, 0)

    def passes(self, trial: Trial) -> bool:
        return trial.passes(self.at_most)

    def find(self, trier: _Trier) -> Found:
        """Divides an interval into ``batch`` + 1 parts at a time, between the last value that passes and the first that
        does not."""
        tried: dict[float, Trial] = {}

        def look(values: Sequence[float]) -> None:
            fresh = [value for value in dict.fromkeys(values) if value not in tried]
            tried.update(zip(fresh, trier.try_all([self._place(value) for value in fresh]), strict=True))

        def passes(value: float) -> bool:
            return self.passes(tried[value])

        look([self.begin, self.end])
        good, bad = (self.begin if passes(self.begin) else None), self.end
        whole_range = good is not None and passes(bad)
        if whole_range:
            good = bad
        elif good is not None:
            while abs(bad - good) > self.tolerance and (inner := self._between(good, bad)):
                look(inner)
                passing = next((n for n, value in enumerate(inner) if not passes(value)), len(inner))
                good, bad = [good, *inner][passing], [*inner, bad][passing]
            look(self._around(good, bad))
        sign = math.copysign(1.0, self.end - self.begin)
        exceptions = sorted(
            value for value in tried if passes(value) != (good is not None and sign * (value - good) <= 0)
        )
        return Found(
            self.metric,
            None if good is None else self._place(good),
            math.nan if good is None else tried[good].worst,
            metrics.spread([]),
            None,
            trier.trials,
            exceptions,
            whole_range,
        )

    def _between(self, good: float, bad: float) -> list[float]:
        values = [good + (bad - good) * n / (self.batch + 1) for n in range(1, self.batch + 1)]
        values = [float(round(value)) if self.whole else float(f"{value:.12g}") for value in values]
        return [value for value in dict.fromkeys(values) if value not in (good, bad)]

    def _around(self, good: float, bad: float) -> list[float]:
        """Values on both sides of the answer, in steps of the tolerance."""
        step = math.copysign(self.tolerance, self.end - self.begin)
        around = [at + n * step * way for n in range(1, self.neighbours + 1) for at, way in ((good, -1), (bad, 1))]
        low, high = sorted((self.begin, self.end))
        return [float(round(value)) if self.whole else value for value in around if low <= value <= high]

    def _place(self, value: float) -> dict[str, Setting]:
        return {self.key: round(value) if self.whole else value}


class _Optimisation(_Search):
    """The best place of a space, found by optuna."""

    keys = OPTIMISE

    def __init__(self, grid: Grid) -> None:
        super().__init__(grid)
        if self.table.get("goal", "minimise") not in ("minimise", "maximise"):
            raise self.error("goal", '"minimise" or "maximise" is expected')
        self.maximise = self.table.get("goal") == "maximise"
        self.trials = self._whole("trials", 40, 1)
        self.seed = self._whole("seed", 1, 0, 2**32 - 1)
        space = self.table.get("space")
        if not isinstance(space, Mapping) or not space:
            raise self.error("space", "the settings that may vary are expected, [search.space]")
        self.space: dict[str, Any] = {}
        for key, value, where in grids.flat(space, "space", ranges=True):
            name = self._setting(key, where)
            if name in self.space:
                raise self.error(where, f"{name} is given twice")
            self.space[name] = self._distribution(name, value, where)

    def _distribution(self, name: str, value: Any, where: str) -> Any:
        optuna = needed("optuna", "search", "cmrc.search")
        if isinstance(value, list):
            try:
                return optuna.distributions.CategoricalDistribution(ranges.values_of(name, value, where))
            except GridError as error:
                raise self.error(where, str(error)) from None
        if (
            not isinstance(value, Mapping)
            or not set(value) <= {"from", "to", "step", "scale"}
            or not {"from", "to"} <= set(value)
        ):
            raise self.error(where, "a list of values, or from and to (with step or scale), is expected")
        numbers = {
            part: ranges.number(value[part], f"{self.name}: search.{where}.{part}") for part in value if part != "scale"
        }
        log, step = ranges.check_steps(value, f"{self.name}: search.{where}"), numbers.get("step")
        whole = ranges.schema().get(name, {}).get("type") == "integer"
        try:
            if whole:
                for part, one in numbers.items():
                    self._is_whole(name, one, f"{where}.{part}")
                return optuna.distributions.IntDistribution(
                    numbers["from"], numbers["to"], log=log, step=1 if step is None else step
                )
            return optuna.distributions.FloatDistribution(
                float(numbers["from"]), float(numbers["to"]), log=log, step=step
            )
        except (ValueError, TypeError) as error:
            raise self.error(where, str(error)) from None

    def find(self, trier: _Trier) -> Found:
        optuna = needed("optuna", "search", "cmrc.search")
        optuna.logging.set_verbosity(optuna.logging.WARNING)
        study = optuna.create_study(
            direction="maximize" if self.maximise else "minimize", sampler=optuna.samplers.TPESampler(seed=self.seed)
        )
        known: dict[str, Trial] = {}
        for begun in range(0, self.trials, self.batch):
            batch = [study.ask(self.space) for _ in range(min(self.batch, self.trials - begun))]
            fresh = {repr(sorted(trial.params.items())): trial.params for trial in batch}
            fresh = {name: place for name, place in fresh.items() if name not in known}
            if fresh:
                known |= dict(zip(fresh, trier.try_all(list(fresh.values())), strict=True))
            for trial in batch:
                tried = known[repr(sorted(trial.params.items()))]
                if tried.counts:
                    study.tell(trial, tried.spread.mean)
                else:
                    study.tell(trial, state=optuna.trial.TrialState.FAIL)
        measured = [trial for trial in known.values() if trial.counts]
        sign = -1.0 if self.maximise else 1.0
        best = min(measured, key=lambda trial: sign * trial.spread.mean, default=None)
        return Found(
            self.metric,
            None if best is None else best.place,
            math.nan if best is None else best.spread.mean,
            metrics.spread([]),
            None,
            trier.trials,
        )


class _Trier:
    """Runs places with all seeds, one batch at a time."""

    def __init__(self, session: Session, grid: Grid, metric: str) -> None:
        self.session, self.grid, self.metric = session, grid, metric
        self.runs: dict[tuple[str, int | None], Run] = {}
        self.trials: list[Trial] = []

    def values(self, places: Sequence[Mapping[str, Setting]], seeds: Sequence[int]) -> list[Trial]:
        points = [[self.grid.point(place, seed) for seed in seeds or (None,)] for place in places]
        runs = self.session.run([point for of in points for point in of])
        self.runs |= {(run.key, run.point.seed): run for run in runs if (run.key, run.point.seed) not in self.runs}
        sweep = Sweep(self.session.folder.path, runs)
        values = sweep.values(self.metric)
        status = {run["key"]: run["status"] for run in sweep.runs}
        rest = iter(runs)
        trials = []
        for of in points:
            keys = [next(rest).key for _ in of]
            known = [values[key] for key in keys if key in values]
            worst = max((float(value) for value in known if not math.isnan(value)), default=math.nan)
            refused, failed = (sum(status[key] == state for key in keys) for state in (store.REFUSED, store.FAILED))
            trials.append(Trial(dict(of[0].place), metrics.spread(known), worst, len(of), refused, failed))
        return trials

    def try_all(self, places: Sequence[Mapping[str, Setting]]) -> list[Trial]:
        trials = self.values(places, self.grid.seeds)
        self.trials += trials
        return trials


def _place(place: Mapping[str, Setting]) -> str:
    return ", ".join(f"{name} = {shortest(value)}" for name, value in place.items())
