"""Output files: each appears whole or not at all, and none replaces an input."""

from __future__ import annotations

import errno
import io
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from typing import BinaryIO

from cmrc import _core, arguments
from cmrc.errors import Error


class WriteFailed(Error, OSError):
    """A file could be opened, and then not be written: the disk is full, or the reader of a pipe has gone."""


FileRoles = _core.io.FileRoles
SameFile = _core.io.SameFile


def printable(text: str) -> str:
    """Text that a terminal shows but does not obey: control characters become ``\\xNN``."""
    return _core.io.printable(text.encode("utf-8", "surrogateescape"))


def printable_lines(text: str) -> str:
    """The same line by line: line feeds stay."""
    return "\n".join(map(printable, text.split("\n")))


LARGEST_STREAM = 64 << 20
"""Bytes that are read of a device or a pipe, which may have no end; as emulator/io/input_file.hpp has it."""


def read(path: str | os.PathLike[str], most: int) -> bytes:
    """A whole file with at most this number of bytes, of a device or a pipe at most 64 MiB. Raises OSError,
    ValueError."""
    with open(path, "rb") as file:
        there = os.fstat(file.fileno())
        regular = stat.S_ISREG(there.st_mode)
        most = most if regular else min(most, LARGEST_STREAM)
        # read() takes memory for all that it may read
        content = b"" if regular and there.st_size > most else file.read(min(most, there.st_size or LARGEST_STREAM) + 1)
    if len(content) > most or (regular and there.st_size > most):
        raise ValueError(f"{os.fspath(path)}: is larger than {most >> 20} MiB; a smaller file is expected")
    return content


def open_anywhere(path: str | os.PathLike[str]) -> BinaryIO:
    """A file that can be read at every place. Raises OSError; ValueError for a device or a pipe."""
    found = os.stat(path).st_mode
    if not stat.S_ISREG(found) and not stat.S_ISDIR(found):  # a folder has an error of its own
        raise ValueError(f"{os.fspath(path)}: is a device or a pipe; a file is expected")
    return open(path, "rb")


def write(path: str | os.PathLike[str], content: str | bytes) -> None:
    """Writes a file; text in UTF-8. Until the new file is complete, the old one stays. A device, a pipe or a terminal
    is written directly. Raises OSError: CannotOpen, or WriteFailed."""
    place = arguments.path("path", path, "the path of a file")
    try:
        _core.io.write(place, content.encode() if isinstance(content, str) else content)
    except _core.io.CannotOpen:
        raise
    except OSError as error:
        raise WriteFailed(str(error)) from None


NO_ROOM = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EPIPE})


def writing_failed(error: BaseException | None) -> bool:
    """Whether the error is a failed write, or says it in other words (``raise ... from``)."""
    while error is not None:
        if isinstance(error, WriteFailed) or (isinstance(error, OSError) and error.errno in NO_ROOM):
            return True
        error = error.__cause__ or error.__context__
    return False


def reason(error: BaseException) -> str:
    """What a reader of a file is told, without the words of Python."""
    if isinstance(error, KeyError) and error.args:
        return f"no {error.args[0]!r} in it"
    if isinstance(error, UnicodeDecodeError):
        return f"byte {error.start} is no UTF-8"
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return str(error)


@contextmanager
def writing(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """The same for writers of an open file. After an exception in the block, the old file stays."""
    content = io.BytesIO()
    yield content
    write(path, content.getvalue())
