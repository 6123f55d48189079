"""Runs the due points on a cluster, and writes every answer into the folder exactly once, whichever process dies."""

from __future__ import annotations

import json
import queue
import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from cmrc import _core
from cmrc.sweeps import store
from cmrc.sweeps.cluster import Workers
from cmrc.sweeps.grid import Point
from cmrc.sweeps.identity import Run, build
from cmrc.sweeps.store import Folder, Row, SweepError
from cmrc.sweeps.work import Alone, Answer, Execute, RunDied

BATCH_ROWS = 100
BATCH_S = 5.0
SUSPECTED = 2
"""After this number of deaths of its workers a run gets a process of its own."""
STRIKES = 3
"""How often a run may end the process in which it is alone."""
LOST_ANSWERS = 100
"""How often an answer may be lost without a dead worker, before the cluster counts as broken."""
LOOK_S = 0.2


@dataclass
class Status:
    """The progress of a sweep, for ``on_progress``."""

    runs: int
    """All of the grid."""
    done: int
    """Those in the folder or to be written with the next batch; including earlier ones."""
    known: int
    """Those that were there before."""
    refused: int = 0
    failed: int = 0
    begun_again: int = 0
    """Runs that were started again because their worker died."""
    workers: int = 0
    elapsed_s: float = 0.0
    planned: int = 0
    """Points whose keys are known: less than ``runs`` until the first run begins."""


@dataclass
class _Due:
    run: Run
    deaths: int = 0
    """Number of workers that have died while they may have run this."""
    strikes: int = 0
    lost: int = 0


class Runner:
    """Runs each of ``due`` and writes the answers in batches of 5 s or 100 runs.

    If a worker dies, its runs are started again. A run that has lost two workers gets a process of its own, to
    distinguish a run that kills its process from one whose worker was killed. After three such deaths of one run it
    counts as failed.
    """

    def __init__(
        self,
        workers: Workers,
        folder: Folder,
        execute: Execute,
        status: Status,
        on_progress: Callable[[Status], object] | None,
    ) -> None:
        self.workers, self.folder, self.execute, self.status = workers, folder, execute, status
        self.on_progress = on_progress
        self.batch: list[Row] = []
        self.written_at = self.began = time.monotonic()
        self.answers: queue.SimpleQueue[tuple[_Due, Answer | BaseException]] = queue.SimpleQueue()
        self.number = 0

    def run(self, due: Sequence[Run]) -> None:
        """Raises SweepError; the answers until then are written, also after an interruption."""
        waiting = deque(_Due(run) for run in due)
        out: dict[int, Any] = {}  # futures, so that the cluster keeps them
        fetchers = ThreadPoolExecutor(8, "cmrc-sweep")
        try:
            while waiting or out:
                while waiting and len(out) < 2 * self.workers.threads() + 4:
                    one = waiting.popleft()
                    out[id(one)] = self._submit(one, fetchers)
                self._hear(out, waiting)
                self.workers.mend()
                self._write(whole=False)
                self._tell()
        finally:
            self._write(whole=True)
            fetchers.shutdown(wait=False, cancel_futures=True)
        self._tell()

    def _submit(self, due: _Due, fetchers: ThreadPoolExecutor) -> Any:
        self.number += 1
        function = Alone(self.execute) if due.deaths >= SUSPECTED else self.execute
        future = self.workers.client.submit(
            function,
            due.run.key,
            due.run.toml(),
            pure=False,
            retries=0,
            key=f"cmrc-{due.run.key[:16]}-{self.number}-{time.monotonic_ns()}",
        )

        def fetch() -> None:
            try:
                self.answers.put((due, future.result()))
            except BaseException as error:  # noqa: BLE001 (handled where the answers are)
                self.answers.put((due, error))

        def ended(_: Any) -> None:
            try:
                fetchers.submit(fetch)
            except RuntimeError:
                pass  # the sweep is over

        future.add_done_callback(ended)
        return future

    def _hear(self, out: dict[int, Any], waiting: deque[_Due]) -> None:
        """One answer, and all others that have arrived."""
        try:
            heard = [self.answers.get(timeout=LOOK_S)]
        except queue.Empty:
            return
        while not self.answers.empty():
            heard.append(self.answers.get())
        for due, answer in heard:
            out.pop(id(due), None)
            if isinstance(answer, BaseException):
                self._lost(due, answer, waiting)
            else:
                self._keep(due.run, answer)

    def _lost(self, due: _Due, error: BaseException, waiting: deque[_Due]) -> None:
        if isinstance(error, RunDied):
            due.strikes += 1
            if due.strikes >= STRIKES:
                self._keep(due.run, failure(f"the run has ended its process {STRIKES} times, alone in it: {error}"))
                return
        elif _died(error):
            due.deaths += 1
        elif _gone(error):
            due.lost += 1
            if due.lost > LOST_ANSWERS:
                raise SweepError(f"the cluster has lost the answer of a run {due.lost} times: {error}") from error
        else:
            raise SweepError(f"a worker cannot run this: {type(error).__name__}: {error}") from error
        self.status.begun_again += 1
        waiting.append(due)

    def _keep(self, run: Run, answer: Answer) -> None:
        self.batch.append(row_of(run, answer))
        self.status.done += 1
        self.status.failed += answer["status"] == store.FAILED
        self.status.refused += answer["status"] == store.REFUSED

    def _write(self, whole: bool) -> None:
        now = time.monotonic()
        if self.batch and (whole or len(self.batch) >= BATCH_ROWS or now - self.written_at >= BATCH_S):
            self.folder.write(self.batch)
            self.batch = []
            self.written_at = now
        elif not self.batch:
            self.written_at = now

    def _tell(self) -> None:
        if self.on_progress is not None:
            self.status.elapsed_s = time.monotonic() - self.began
            self.status.workers = self.workers.threads()
            self.on_progress(self.status)


def place_of(point: Point) -> Row:
    """The columns that say which point of its grid a run is: the same run may be in several grids."""
    settings = {
        **dict(point.settings),
        **({"preset": point.preset} if point.preset else {}),
        **({"config": point.config} if point.config else {}),
        **({"events": [dict(event) for event in point.events]} if point.events else {}),
    }
    return {"place": json.dumps(dict(point.place)), "seed": point.seed, "settings": json.dumps(settings)}


def row_of(run: Run, answer: Answer) -> Row:
    """A row of a part."""
    return {
        "key": run.key,
        "status": answer["status"],
        "message": answer["message"],
        **place_of(run.point),
        "hash": answer["hash"],
        "build": build(),
        "emulator_version": _core.cmrc.emulator_version,
        "elapsed_s": answer["elapsed_s"],
        "host": answer["host"],
        "report": answer["report"],
    }


def failure(message: str) -> Answer:
    return {"status": store.FAILED, "message": message, "hash": None, "report": None, "elapsed_s": None, "host": None}


def refusal(message: str) -> Answer:
    return {**failure(message), "status": store.REFUSED}


def _died(error: BaseException) -> bool:
    from distributed.scheduler import KilledWorker

    return isinstance(error, KilledWorker)


def _gone(error: BaseException) -> bool:
    """An answer that was lost on its way."""
    import asyncio
    from concurrent.futures import CancelledError

    from distributed.client import FutureCancelledError
    from distributed.comm.core import CommClosedError

    return isinstance(
        error, (CancelledError, asyncio.CancelledError, FutureCancelledError, CommClosedError, TimeoutError)
    )
