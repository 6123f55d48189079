"""What a sweep asks of its workers, and what it does with their answers: without workers."""

import io
import logging
import os
import subprocess
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import sweep_helpers
from cmrc.sweeps import Status, cluster, grid, identity, runner, session, sweep, work

pytest.importorskip("distributed")
pytest.importorskip("pyarrow")

FIXED = {"duration_s": 0.03, "report.reference": "none"}


def test_a_run_that_is_alone_gives_its_answer_or_says_how_its_process_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    import cloudpickle

    ended = subprocess.CompletedProcess([], 0, cloudpickle.dumps({"key": "k"}))
    monkeypatch.setattr("cmrc.sweeps.work.subprocess.run", lambda *_, **__: ended)
    alone = work.Alone(work.execute)
    assert alone("k", "") == {"key": "k"}
    for ended.returncode, says in ((1, "ended with status 1"), (-9, "ended by SIGKILL")):
        with pytest.raises(work.RunDied, match=says):
            alone("k", "")


def test_a_worker_that_dies_is_replaced_and_so_is_the_process_that_forks_them(monkeypatch: pytest.MonkeyPatch) -> None:
    class Forker:
        """Notes what it is asked for, and says what it is told to."""

        status: int | None = None

        def __init__(self, *_: object, **__: object) -> None:
            self.stdin = io.BytesIO()
            reads, self.says = os.pipe()
            self.stdout = os.fdopen(reads, "rb")
            started.append(self)

        def poll(self) -> int | None:
            return self.status

        def workers(self) -> list[str]:
            return [line.split()[1] for line in self.stdin.getvalue().decode().splitlines()]

    started: list[Forker] = []
    monkeypatch.setattr("cmrc.sweeps.cluster.subprocess.Popen", Forker)
    processes = cluster._Processes(2, "scratch")
    processes.join("tcp://here:1")
    processes.mend()
    assert [forker.workers() for forker in started] == [["local-1", "local-2"]]
    os.write(started[0].says, b"local-1 died\n")
    processes.mend()
    assert [forker.workers() for forker in started] == [["local-1", "local-2", "local-3"]]
    started[0].status = 1
    monkeypatch.setattr(cluster, "START_AGAIN_S", 1e9)
    processes.mend()  # not at once: it would be started again and again where it cannot live
    assert len(started) == 1
    monkeypatch.setattr(cluster, "START_AGAIN_S", -1.0)
    processes.mend()
    assert [forker.workers() for forker in started[1:]] == [["local-4", "local-5"]]
    for forker in started:
        os.close(forker.says)
        forker.stdout.close()


def overlapping(shared: cluster._Shared, read: Callable[[], Any]) -> list[Any]:
    """What is read after each step of two sweeps, and of a third one that begins before the second one ends."""
    steps = (shared.__enter__, shared.__enter__, shared.__exit__, shared.__enter__, shared.__exit__, shared.__exit__)
    found = []
    for step in steps:
        step()
        found.append(read())
    return found


def test_the_messages_of_dask_return_with_the_end_of_the_last_sweep() -> None:
    """Sweeps of several threads share its loggers."""
    handler = logging.StreamHandler()
    handler.setLevel(logging.INFO)
    logger = logging.getLogger("distributed")
    logger.addHandler(handler)
    try:
        levels = overlapping(cluster._Shared(cluster._no_messages), lambda: handler.level)
        assert levels == [logging.CRITICAL] * 5 + [logging.INFO]
    finally:
        logger.removeHandler(handler)


def test_the_settings_of_dask_return_with_the_end_of_the_last_sweep() -> None:
    """Sweeps of several threads share its settings. One that ended first left the settings of the other behind."""
    dask = pytest.importorskip("dask")
    before = dict(dask.config.config)
    key = "distributed.scheduler.allowed-failures"
    outside = dask.config.get(key, None)
    assert outside != 0
    found = overlapping(cluster._settings, lambda: dask.config.get(key, None))
    assert found == [0] * 5 + [outside]
    assert dask.config.config == before


class OneAtATime:
    """Stands for workers that do each run at once."""

    def __init__(self) -> None:
        self.client = self

    def threads(self) -> float:
        return -1.5  # two for each thread, and four: one

    def mend(self) -> None:
        pass

    def submit(self, function: Any, run: str, toml: str, /, **_: object) -> Future[Any]:
        done: Future[Any] = Future()
        done.set_result(function(run, toml))
        return done


def test_answers_are_written_a_hundred_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """docs/sweeps.md: what a sweep whose process is killed may lose."""
    written: list[int] = []
    monkeypatch.setattr("cmrc.sweeps.runner.BATCH_S", 1e9)
    monkeypatch.setattr("cmrc.sweeps.identity.Run.toml", lambda run: "")
    [point] = grid.made({"fixed": FIXED}).points()
    due = [identity.Run(str(n), point) for n in range(250)]
    folder: Any = SimpleNamespace(write=lambda rows: written.append(len(rows)))
    workers: Any = OneAtATime()
    runner.Runner(workers, folder, lambda key, toml: sweep_helpers.answer(key), Status(250, 0, 0), None).run(due)
    assert written == [100, 100, 50]


def test_points_are_counted_while_they_are_looked_at(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A grid of a million points has no run for minutes."""
    monkeypatch.setattr(session, "TELL_EVERY", 3)
    seen: list[tuple[int, int]] = []
    many: dict[str, Any] = {"fixed": {**FIXED, "dsps": 17}, "repeats": {"seeds": 8}}  # each is refused, and none is run
    found = sweep(many, tmp_path / "s", on_progress=lambda status: seen.append((status.planned, status.runs)))
    assert seen == [(2, 8), (5, 8)] and found.counts()["refused"] == 8
    assert len(sweep(many, tmp_path / "s")) == 8
