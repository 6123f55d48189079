"""Progress of long work on standard error: one line that changes on a terminal and in a notebook, elsewhere a new line
every 15 s."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import TYPE_CHECKING, Any, TextIO

if TYPE_CHECKING:
    from typing_extensions import Self

    from cmrc.sweeps import Status

SILENT_S = 1.0
"""Shorter work shows nothing."""
TERMINAL_S = 0.2
LOG_S = 15.0
BEAT_S = 0.5


def _can_change(stream: TextIO | None) -> bool:
    """A line that was shown can be written over: on a terminal, and below the cell of a notebook."""
    return stream is not None and (stream.isatty() or type(stream).__module__.startswith("ipykernel"))


def _room(stream: TextIO | None) -> int | None:
    """How long a line may be: one character less than the terminal is wide now, so that it stays one line. None: the
    stream has no width."""
    try:
        columns = os.get_terminal_size(stream.fileno()).columns if stream is not None else 0
    except (OSError, ValueError):  # no terminal; no descriptor
        return None
    return columns - 1 if columns > 0 else None


class ProgressLine:
    """``with ProgressLine("sweep") as line: line.show("3 of 8 runs")``. At the end of the work the line is erased."""

    def __init__(self, what: str, stream: TextIO | None = None) -> None:
        self.what, self.stream = what, sys.stderr if stream is None else stream
        self.every_s = TERMINAL_S if _can_change(self.stream) else LOG_S
        self.began = time.monotonic()
        self.last = self.began - self.every_s + SILENT_S
        self.reported = ""
        """The progress that the work has reported."""
        self.width = 0
        self._lock = threading.RLock()

    def show(self, text: str, now: bool = False) -> None:
        """May be called often; with ``now`` the text is shown in any case."""
        self.reported = text
        self._put(text, now)

    def _put(self, text: str, now: bool = False) -> None:
        with self._lock:
            time_s = time.monotonic()
            if not now and time_s - self.last < self.every_s:
                return
            self.last = time_s
            line = f"{self.what}: {text}"
            if self.every_s == TERMINAL_S:
                room = _room(self.stream)
                line = line[:room]
                self._write("\r" + line.ljust(self.width)[:room])
                self.width = len(line)
            else:
                self._write(line + "\n")

    def _write(self, text: str) -> None:
        """Standard error that is closed or full is no reason to end the work."""
        if self.stream is None:
            return
        try:
            self.stream.write(text)
            self.stream.flush()
        except (OSError, ValueError):
            self.stream = None

    def of(self, done: float, whole: float, unit: str = "s simulated", now: bool = False) -> None:
        """The finished share, and the estimated remaining time."""
        spent = time.monotonic() - self.began
        left = f", about {spent / done * (whole - done):.0f} s left" if 0 < done < whole else ""
        self.show(f"{done:.4g} of {whole:.4g} {unit}{left}", now)

    @contextmanager
    def beating(self, text: str = "running") -> Iterator[None]:
        """For work that reports little or nothing: its last report, at first ``text``, and how long the work
        has taken."""
        self.reported = self.reported or text
        over = threading.Event()

        def beat() -> None:
            while not over.wait(BEAT_S):
                if time.monotonic() - self.last > BEAT_S:
                    self._put(f"{self.reported}; {time.monotonic() - self.began:.0f} s so far")

        thread = threading.Thread(target=beat, daemon=True)
        thread.start()
        try:
            yield
        finally:
            over.set()
            thread.join()

    def clear(self) -> None:
        """Erases the line, for other output."""
        with self._lock:
            if self.width:
                self._write("\r" + (" " * self.width)[: _room(self.stream)] + "\r")
                self.width = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.clear()


def shown(line: ProgressLine) -> Callable[[Status], None]:
    """``on_progress`` of a sweep that a line shows."""
    return lambda status: line.show(of_sweep(status))


def of_sweep(status: Status) -> str:
    """How far a sweep is, in words."""
    if status.planned < status.runs:
        return f"{status.planned} of {status.runs} points looked at"
    ran = status.done - status.known - status.refused
    left = status.runs - status.done
    rest = f", about {status.elapsed_s / ran * left:.0f} s left" if ran > 0 and left else ""
    again = f", {status.begun_again} begun again" if status.begun_again else ""
    many = "" if status.workers == 1 else "s"
    on = f"on {status.workers} worker{many}" if status.workers else "done, waiting for a worker"
    return f"{status.done} of {status.runs} runs {on}{again}{rest}"


def show_progress(what: str = "cmrc") -> Callable[..., None]:
    """An ``on_progress`` that shows a line on standard error, in a notebook below its cell: for ``run``, ``compare``,
    ``limits``, ``sweep``, ``search`` and ``Simulation.run``. The line is erased when the work is done.

    ``cmrc.sweep("misses.toml", "misses", on_progress=cmrc.show_progress())``"""
    line: ProgressLine | None = None
    before: tuple[float, float] = (0.0, 0.0)

    def show(*status_or_counts: Any) -> None:
        nonlocal line, before
        status = status_or_counts[0] if len(status_or_counts) == 1 else None
        done, whole = (status.done, status.runs) if status else status_or_counts
        if line is None or whole != before[1] or done < before[0]:  # other work
            line = ProgressLine(what)
        before = (done, whole)
        if status:
            line.show(of_sweep(status))
        else:
            points = isinstance(whole, int)
            line.of(done, whole, "runs" if points else "s simulated", now=points)
        if done >= whole:
            line.clear()
            line = None

    return show
