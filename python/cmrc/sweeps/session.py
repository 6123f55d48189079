"""A folder that is locked and, from the first due run on, a cluster."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Any

from cmrc.extras import installed
from cmrc.sweeps import store
from cmrc.sweeps.cluster import Workers
from cmrc.sweeps.cluster import workers as cluster_of
from cmrc.sweeps.grid import Point
from cmrc.sweeps.identity import Keys, Run, build, run_of
from cmrc.sweeps.runner import Runner, Status, place_of, refusal, row_of
from cmrc.sweeps.store import LIGHT, Folder, Row, SweepError
from cmrc.sweeps.work import Execute

if TYPE_CHECKING:
    from typing_extensions import Self


TELL_EVERY = 200
"""Points between two calls of ``on_progress`` before the first run: 0.4 s."""


@dataclass(frozen=True)
class Place:
    """Where runs are made: ``workers`` processes of this machine, or the cluster at ``address``."""

    address: str | None = None
    workers: int | None = None
    security: Mapping[str, Any] | None = None


class Session:
    """``with Session(...) as session: session.run(points)``, as often as needed. At the end the folder is compacted."""

    def __init__(
        self,
        folder: str | os.PathLike[str],
        place: Place,
        execute: Execute,
        again_failed: bool = False,
        on_progress: Callable[[Status], object] | None = None,
    ) -> None:
        for module in ("pyarrow", "dask", "distributed"):
            installed(module, "sweep", "cmrc.sweep")
        self.folder, self.place, self.execute = Folder(folder), place, execute
        self.again_failed, self.on_progress = again_failed, on_progress
        self._open = ExitStack()
        self._workers: Workers | None = None

    def __enter__(self) -> Self:
        self._open.enter_context(self.folder)
        try:
            self._same_build()
            if self.again_failed:
                self.folder.drop(lambda row: row["status"] == store.FAILED)
        except BaseException:
            self._open.close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._open:
            if kind is None:
                self.folder.compact()

    def run(self, points: Iterable[Point], fork_at_s: float | None = None) -> list[Run]:
        """Runs what is not in the folder yet, and what was refused; a Run for each point, also where two points make
        one run. Runs that share their beginning until ``fork_at_s`` come one after the other. Raises SweepError."""
        planned = self._planned(list(points), fork_at_s)
        once: dict[str, Run] = {}
        for run in planned:
            once.setdefault(run.key, run)
        runs = list(once.values())
        there = self._there(planned)
        due = [run for run in runs if run.key not in there]
        refused = [run for run in due if run.refused]
        if refused:
            self.folder.write([row_of(run, refusal(run.refused)) for run in refused])
        status = Status(
            len(runs),
            len(runs) - len(due) + len(refused),
            len(runs) - len(due),
            len(refused),
            sum(there.get(run.key) == store.FAILED for run in runs),
            planned=len(runs),
        )
        due = sorted((run for run in due if not run.refused), key=lambda run: run.group)
        if due:
            Runner(self._crew(), self.folder, self.execute, status, self.on_progress).run(due)
        self._write_twins(planned)
        return planned

    def _there(self, planned: Sequence[Run]) -> dict[str, str]:
        """The status of each run in the folder, by key. A refusal is the answer to files that may have changed: these
        points are made again. What this process has just refused in the same words stays."""
        there: dict[str, str] = {}
        refused = []
        for row in self.folder.rows(("status", "message", "settings")):
            there[row["key"]] = row["status"]
            if row["status"] == store.REFUSED:
                refused.append(row)
        asked = {_point(json.loads(place_of(run.point)["settings"])): run for run in planned} if refused else {}
        old = set()
        for row in refused:
            run = asked.get(_point(self.folder.settings(row)))
            if run is not None and (run.key, run.refused) != (row["key"], row["message"]):
                old.add(row["key"])
        if old:
            self.folder.drop(lambda row: row["status"] == store.REFUSED and row["key"] in old)
        return {key: status for key, status in there.items() if key not in old}

    def _write_twins(self, planned: Sequence[Run]) -> None:
        """Points that make one run: each has a row, so that the folder alone says which points there are."""
        times = Counter(run.key for run in planned)
        twins = {(run.key, place_of(run.point)["place"]): run for run in planned if times[run.key] > 1}
        first: dict[str, Row] = {}
        for row in self.folder.rows(LIGHT) if twins else ():
            twins.pop((row["key"], row["place"]), None)
            first.setdefault(row["key"], row)
        rows = [{**first[run.key], **place_of(run.point), "report": None} for run in twins.values()]
        if rows:
            self.folder.write(rows)

    def _planned(self, points: Sequence[Point], fork_at_s: float | None) -> list[Run]:
        """The points with their keys."""
        runs, keys = [], Keys()
        for n, point in enumerate(points):
            if self.on_progress is not None and n % TELL_EVERY == TELL_EVERY - 1:
                self.on_progress(Status(len(points), 0, 0, planned=n))
            runs.append(run_of(point, keys, fork_at_s))
        return runs

    def _crew(self) -> Workers:
        if self._workers is None:
            place = self.place
            self._workers = self._open.enter_context(cluster_of(place.address, place.workers, place.security))
        return self._workers

    def _same_build(self) -> None:
        """Raises SweepError for a folder with runs of another build, whose numbers may differ."""
        for row in self.folder.rows(("build", "emulator_version")):
            if row["build"] != build():
                raise SweepError(
                    f"{self.folder.path}: holds runs of emulator {row['emulator_version']}, build "
                    f"{row['build'][:12]}; this is build {build()[:12]}. Another folder is expected"
                )


def _point(settings: Mapping[str, Any]) -> str:
    """The settings of a row, whichever grid has written them: a setting may be fixed in one and an axis in another."""
    return json.dumps(settings, sort_keys=True)
