"""What long work shows on standard error: one line that changes on a terminal, else a line now and then."""

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
"""Work that is done sooner shows nothing."""
TERMINAL_S = 0.2
LOG_S = 15.0
BEAT_S = 0.5


class ProgressLine:
    """``with ProgressLine("sweep") as line: line.show("3 of 8 runs")``. What is shown in between is gone at the end of
    the work."""

    def __init__(self, what: str, stream: TextIO | None = None) -> None:
        self.what, self.stream = what, sys.stderr if stream is None else stream
        self.terminal = self.stream.isatty()
        self.began = time.monotonic()
        self.last = self.began - (TERMINAL_S if self.terminal else LOG_S) + SILENT_S
        self.width = 0

    def show(self, text: str, now: bool = False) -> None:
        """As often as is convenient; with ``now`` each is shown."""
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
        """So much of it is done, and how much time it may still take."""
        spent = time.monotonic() - self.began
        left = f", about {spent / done * (whole - done):.0f} s left" if 0 < done < whole else ""
        self.show(f"{done:.4g} of {whole:.4g} {unit}{left}", now)

    @contextmanager
    def beating(self, text: str = "running") -> Iterator[None]:
        """For work that tells nothing of itself: how long it has been going on."""
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
        """Takes the line off the terminal, for other output."""
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
