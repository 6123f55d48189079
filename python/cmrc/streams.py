"""The standard streams of a command, each of which may be closed or full."""

from __future__ import annotations

import io
import os
import sys


def prepare() -> None:
    """Gives a closed stream its number again: else the first file that is opened would have it, and would get what is
    printed. What the encoding of standard output does not have is shown as ``?``."""
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:  # the lowest free number is this one
            os.set_inheritable(os.open(os.devnull, os.O_WRONLY if number == 2 else os.O_RDONLY), True)
    if sys.stdout is None:
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115 (for as long as the process lives)
    if sys.stderr is None:
        sys.stderr = open(2, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")


def show(text: str) -> None:
    """Prints the outcome of a command. Raises RuntimeError if standard output is closed or full."""
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except OSError as error:
        _discard()
        raise RuntimeError(f"standard output: {error.strerror or error}") from None


def say(text: str) -> None:
    """A line on standard error. One that cannot be shown changes nothing."""
    try:
        print(text, file=sys.stderr, flush=True)
    except OSError:
        pass


def _discard() -> None:
    """What is still in the buffer: Python would try again at its end."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)
