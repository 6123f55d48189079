"""SIGINT, SIGTERM and SIGHUP end a command with status 130, 143 and 129, like ``emulator`` (docs/cli.md, Signals)."""

from __future__ import annotations

import multiprocessing
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from cmrc import _core, processes

NUMBERS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Ended(KeyboardInterrupt):
    """A signal has ended the command."""

    def __init__(self, number: int) -> None:
        super().__init__(signal.Signals(number).name)
        self.number = number


def status(stop: KeyboardInterrupt) -> int:
    """The exit status of a command that this signal has ended."""
    return 128 + (stop.number if isinstance(stop, Ended) else signal.SIGINT)


def end_quietly() -> None:
    """The ``initializer`` of a pool's workers: a worker ends when its pool or its parent does, without a traceback.
    Otherwise it would inherit the handlers of ``raised``; but signals that reach each process of the terminal are
    handled by the parent."""
    processes.leave_signals_to_parent()
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # a pool ends its workers by it
    if (parent := multiprocessing.parent_process()) is not None and parent.pid is not None:
        processes.die_with_parent(parent.pid)


@contextmanager
def raised() -> Iterator[None]:
    """The first signal raises Ended in this block; the second ends the process at once. A signal that is ignored stays
    ignored, as under ``nohup``."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def end(number: int, _: FrameType | None) -> None:
        raise Ended(number)

    before = {number: signal.getsignal(number) for number in NUMBERS}
    before = {number: handler for number, handler in before.items() if handler is not signal.SIG_IGN}
    for number in before:
        signal.signal(number, end)
    _core.io.second_signal_ends(list(before))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
