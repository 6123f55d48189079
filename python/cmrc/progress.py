"""Progress of long work on standard error: one changing line on a terminal, else a line from time to time."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from typing_extensions import Self

SILENT_S = 1.0
"""Shorter work shows nothing."""
TERMINAL_S = 0.2
LOG_S = 15.0
BEAT_S = 0.5


class ProgressLine:
    """``with ProgressLine("sweep") as line: line.show("3 of 8 runs")``. At the end of the work the line is erased."""

    def __init__(self, what: str, stream: TextIO | None = None) -> None:
        self.what, self.stream = what, sys.stderr if stream is None else stream
        self.terminal = self.stream.isatty()
        self.began = time.monotonic()
        self.last = self.began - (TERMINAL_S if self.terminal else LOG_S) + SILENT_S
        self.width = 0

    def show(self, text: str, now: bool = False) -> None:
        """May be called often; with ``now`` the text is shown in any case."""
        time_s = time.monotonic()
        if not now and time_s - self.last < (TERMINAL_S if self.terminal else LOG_S):
            return
        self.last = time_s
        line = f"{self.what}: {text}"
        if self.terminal:
            self.stream.write("\r" + line.ljust(self.width))
            self.width = len(line)
        else:
            self.stream.write(line + "\n")
        self.stream.flush()

    def of(self, done: float, whole: float, unit: str = "s simulated", now: bool = False) -> None:
        """The finished share, and the estimated remaining time."""
        spent = time.monotonic() - self.began
        left = f", about {spent / done * (whole - done):.0f} s left" if 0 < done < whole else ""
        self.show(f"{done:.4g} of {whole:.4g} {unit}{left}", now)

    @contextmanager
    def beating(self, text: str = "running") -> Iterator[None]:
        """For work without progress reports: shows how long it has run."""
        over = threading.Event()

        def beat() -> None:
            while not over.wait(BEAT_S):
                self.show(f"{text}, {time.monotonic() - self.began:.0f} s")

        thread = threading.Thread(target=beat, daemon=True)
        thread.start()
        try:
            yield
        finally:
            over.set()
            thread.join()

    def clear(self) -> None:
        """Erases the line, for other output."""
        if self.width:
            self.stream.write("\r" + " " * self.width + "\r")
            self.stream.flush()
            self.width = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.clear()
