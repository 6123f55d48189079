"""A signal while a command of the package is still importing its modules: it has done nothing yet, and ends at once
with the status of cmrc.signals, without a traceback. That module takes over when the command begins."""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType
from typing import Any


def is_command() -> bool:
    """This process is ``cmrc``, ``python -m cmrc`` or ``python -m cmrc.results``; not a program that imports the
    package."""
    given: list[str] = getattr(sys, "argv", [])
    if not given:
        return False
    if given[0] == "-m":  # Python is still looking for the module that it shall run
        return sys.orig_argv[: -len(given) + 1 or None][-2:] in (["-m", "cmrc"], ["-m", "cmrc.results"])
    return os.path.basename(given[0]) == "cmrc"


def _end(number: int, _: FrameType | None) -> None:
    try:
        os.write(2, b"cmrc: interrupted\n")
    except OSError:
        pass
    os._exit(128 + number)


def handle() -> dict[signal.Signals, Any]:
    """A signal that is ignored stays ignored, as under ``nohup``. Returns the handlers before."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    before = {number: handler for number, handler in before.items() if handler is not signal.SIG_IGN}
    for number in before:
        signal.signal(number, _end)
    return before


def restore(before: dict[signal.Signals, Any]) -> None:
    """What ``handle`` has changed."""
    for number, handler in before.items():
        signal.signal(number, handler)
