"""The folder of a sweep: Parquet parts that appear whole or not at all, a lock, and a description of their writer."""

from __future__ import annotations

import fcntl
import json
import os
import socket
import uuid
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from cmrc import _core, arguments, files
from cmrc.errors import Error
from cmrc.extras import needed
from cmrc.sweeps.identity import build

if TYPE_CHECKING:
    from typing_extensions import Self

FORMAT = 1
HEAD = "sweep.json"
LOCK = "lock"
DONE, REFUSED, FAILED = "done", "refused", "failed"
COLUMNS = (
    ("key", "string"),
    ("status", "string"),
    ("message", "string"),
    ("place", "string"),
    ("seed", "int64"),
    ("settings", "string"),
    ("hash", "string"),
    ("build", "string"),
    ("emulator_version", "string"),
    ("elapsed_s", "float64"),
    ("host", "string"),
    ("report", "binary"),
)
"""Columns of a part (docs/sweeps.md)."""
COMPACT_BATCH = 1000
LARGEST_HEAD = 1 << 20
Row = dict[str, Any]


class SweepError(Error, RuntimeError):
    """A sweep that cannot continue. Everything written stays, and the next call continues from there."""


class Folder:
    """One user at a time may write (``with Folder(path) as folder``); any number may read."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(arguments.path("folder", path, "the folder of a sweep"))
        self._lock: IO[str] | None = None

    def __enter__(self) -> Self:
        if self.path.exists() and not self.path.is_dir():
            raise SweepError(f"{self.path}: is a file; a folder, or a name that is free, is expected")
        if self.path.is_dir() and not (self.path / HEAD).exists() and any(p.name != LOCK for p in self.path.iterdir()):
            raise SweepError(
                f"{self.path}: contains files, and is not a folder of a sweep; an empty or a new one is expected"
            )
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise SweepError(f"{self.path}: cannot be made: {error.strerror or error}") from None
        self._lock = self._locked()
        try:
            self.check()
            if not (self.path / HEAD).exists():
                files.write(
                    self.path / HEAD,
                    json.dumps({"format": FORMAT, "cmrc": _core.cmrc.emulator_version, "build": build()}) + "\n",
                )
            for left in self.path.glob(".part-*"):
                left.unlink()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def _locked(self) -> IO[str]:
        file = open(self.path / LOCK, "a+", encoding="utf-8")  # noqa: SIM115 (open as long as the folder is locked)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            file.seek(0)
            who = file.read(200).strip() or "another process"
            file.close()
            raise SweepError(
                f"{self.path}: {files.printable(who)} sweeps into this folder; one sweep at a time may"
            ) from None
        file.truncate(0)
        file.write(f"process {os.getpid()} on {socket.gethostname()}")
        file.flush()
        return file

    def check(self) -> None:
        """Raises SweepError for a folder of another format."""
        head = self.head()
        if head is not None and head.get("format") != FORMAT:
            raise SweepError(
                f"{self.path}: written by cmrc {head.get('cmrc', 'of an unknown version')} in format "
                f"{head.get('format')}; cmrc {_core.cmrc.emulator_version} reads format {FORMAT}. "
                "Another folder is expected"
            )

    def head(self) -> dict[str, Any] | None:
        """The description of the folder's writer; None for a new folder. Raises SweepError."""
        try:
            found = json.loads(files.read(self.path / HEAD, LARGEST_HEAD))
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as error:
            raise SweepError(f"{self.path / HEAD}: cannot be read: {error}") from None
        if not isinstance(found, dict):
            raise SweepError(f"{self.path / HEAD}: no head of a sweep")
        return found

    def parts(self) -> list[Path]:
        return sorted(self.path.glob("part-*.parquet"))

    def rows(self, columns: Sequence[str] | None = None) -> Iterator[Row]:
        """Every run once, in the order of writing; ``columns`` None: all. Raises SweepError."""
        parquet = needed("pyarrow.parquet", "sweep", "cmrc.sweep")
        names = None if columns is None else list(dict.fromkeys(["key", *columns]))
        seen: set[str] = set()
        parts = self.parts()
        while parts:
            part = parts.pop(0)
            try:
                # A file, not its name: pyarrow takes no name with a byte that is no UTF-8.
                with files.open_anywhere(part) as file, parquet.ParquetFile(file) as opened:
                    for batch in opened.iter_batches(batch_size=COMPACT_BATCH, columns=names):
                        for row in batch.to_pylist():
                            if row["key"] not in seen:
                                seen.add(row["key"])
                                yield row
            except FileNotFoundError:
                parts = self.parts()  # compacted meanwhile: its rows are in a later part
            except (OSError, ValueError, KeyError) as error:
                raise SweepError(f"{part}: cannot be read: {error}") from None

    def write(self, rows: Sequence[Row]) -> None:
        """Writes a new part. Raises SweepError; then the old parts stay, and nothing of the new one."""
        self._put(self._next(), [rows])

    def compact(self, without: str | None = None) -> None:
        """Joins all parts into one, without the rows with the status ``without``. If it is killed at any instant, no
        row is lost: a row in two parts counts once."""
        parts = self.parts()
        if len(parts) < (2 if without is None else 1):
            return
        self._put(self._next(), self._batches(without))
        for part in parts:
            part.unlink()

    def _batches(self, without: str | None) -> Iterator[list[Row]]:
        batch: list[Row] = []
        for row in self.rows():
            if row["status"] == without:
                continue
            batch.append(row)
            if len(batch) == COMPACT_BATCH:
                yield batch
                batch = []
        if batch:
            yield batch

    def _next(self) -> Path:
        last = max((int(part.name.split("-")[1].split(".")[0]) for part in self.parts()), default=0)
        return self.path / f"part-{last + 1:06}.parquet"

    def _put(self, path: Path, batches: Iterable[Sequence[Row]]) -> None:
        arrow, parquet = (needed(name, "sweep", "cmrc.sweep") for name in ("pyarrow", "pyarrow.parquet"))
        schema = arrow.schema(
            [(name, getattr(arrow, kind)()) for name, kind in COLUMNS], metadata={"cmrc_sweep_format": str(FORMAT)}
        )
        fresh = self.path / f".part-{uuid.uuid4().hex}"
        try:
            with open(fresh, "wb") as file:
                with parquet.ParquetWriter(file, schema, compression="zstd") as writer:
                    for rows in batches:
                        columns = [_array(arrow, kind, [row[name] for row in rows]) for name, kind in COLUMNS]
                        writer.write_table(arrow.Table.from_arrays(columns, schema=schema))
                file.flush()
                os.fsync(file.fileno())
            os.rename(fresh, path)
            _sync(self.path)
        except OSError as error:
            fresh.unlink(missing_ok=True)
            raise SweepError(
                f"{path}: cannot be written: {error.strerror or error}. The parts that are there are whole; "
                "the same command continues from them"
            ) from None


def _array(arrow: Any, kind: str, values: Sequence[Any]) -> Any:
    """A column; None is null. ``pyarrow.array`` would import pandas, which takes half a second, to inspect the list."""
    there = np.packbits([value is not None for value in values], bitorder="little")
    if kind in ("string", "binary"):
        texts = [_bytes(value) for value in values]
        buffers = [there, np.cumsum([0, *map(len, texts)], dtype=np.int32), b"".join(texts)]
    else:
        buffers = [there, np.array([0 if value is None else value for value in values], dtype=kind)]
    return arrow.Array.from_buffers(getattr(arrow, kind)(), len(values), [arrow.py_buffer(one) for one in buffers])


def _bytes(value: str | bytes | None) -> bytes:
    """A path in a message may contain bytes that are not UTF-8."""
    return value.encode(errors="backslashreplace") if isinstance(value, str) else value or b""


def _sync(folder: Path) -> None:
    opened = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)


def packed(report: Mapping[str, Any] | str) -> bytes:
    """A report in the form of a part."""
    text = report if isinstance(report, str) else json.dumps(report)
    return zlib.compress(text.encode(), 6)


def unpacked(content: bytes) -> dict[str, Any]:
    report: dict[str, Any] = json.loads(zlib.decompress(content))
    return report
