"""Output files: each appears whole or not at all, and none replaces an input."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import BinaryIO

from cmrc import _core, arguments

FileRoles = _core.io.FileRoles
SameFile = _core.io.SameFile


def printable(text: str) -> str:
    """Text that a terminal shows but does not obey: control characters become ``\\xNN``."""
    return _core.io.printable(text.encode("utf-8", "surrogateescape"))


def printable_lines(text: str) -> str:
    """The same line by line: line feeds stay."""
    return "\n".join(map(printable, text.split("\n")))


def read(path: str | os.PathLike[str], most: int) -> bytes:
    """A whole file with at most this number of bytes; a file without an end (a device, a pipe) is an error. Raises
    OSError, ValueError."""
    with open(path, "rb") as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise ValueError(f"{os.fspath(path)}: more than {most} bytes; a smaller file is expected")
    return content


def write(path: str | os.PathLike[str], content: str | bytes) -> None:
    """Writes a file; text in UTF-8. Until the new file is complete, the old one stays. A device, a pipe or a terminal
    is written directly. Raises OSError."""
    place = arguments.path("path", path, "the path of a file")
    _core.io.write(place, content.encode() if isinstance(content, str) else content)


@contextmanager
def writing(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """The same for writers of an open file. After an exception in the block, the old file stays."""
    content = io.BytesIO()
    yield content
    write(path, content.getvalue())
