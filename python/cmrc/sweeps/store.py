"""The folder of a sweep: Parquet parts that appear whole or not at all, a lock, and a description of their writer."""

from __future__ import annotations

import errno
import fcntl
import hashlib
import json
import os
import re
import socket
import stat
import uuid
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from cmrc import _core, arguments, files
from cmrc.errors import Error
from cmrc.extras import needed
from cmrc.sweeps.grid import APART, EVENTS
from cmrc.sweeps.identity import build
from cmrc.sweeps.ranges import GridError, scalar

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
LIGHT = tuple(name for name, _ in COLUMNS if name != "report")
NEVER_NULL = ("key", "status", "message", "place", "settings", "build", "emulator_version")
BATCH_ROWS = 1000
BATCH_BYTES = 1 << 26
"""Rows that are in memory at a time. A column of Parquet takes at most 2 GiB."""
LARGEST_HEAD = 1 << 20
LARGEST_REPORT = 1 << 29
PART = re.compile(r"part-(\d+)(?:-([0-9a-f]{16}))?\.parquet")
"""The name of a part: its number, and the beginning of the SHA-256 of its content (earlier versions wrote none)."""
Row = dict[str, Any]


class SweepError(Error, RuntimeError):
    """A sweep that cannot continue. Everything written stays, and the next call continues from there."""


class Folder:
    """One user at a time may write (``with Folder(path) as folder``); any number may read."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(arguments.path("folder", path, "the folder of a sweep")).absolute()  # whatever chdir follows
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
        place = self.path / LOCK
        try:
            opened = os.open(place, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o666)
        except OSError as error:
            why = "is a link; a file is expected" if error.errno == errno.ELOOP else error.strerror
            raise SweepError(f"{place}: {why}") from None
        file = open(opened, "r+", encoding="utf-8", errors="replace")  # noqa: SIM115 (open as long as it is locked)
        if not stat.S_ISREG(os.fstat(opened).st_mode):
            file.close()
            raise SweepError(f"{place}: is a device or a pipe; a file is expected")
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            file.seek(0)
            who = file.read(200).strip() or "another process"
            file.close()
            raise SweepError(
                f"{self.path}: {files.printable(who)} sweeps into this folder; one sweep at a time may"
            ) from None
        try:
            file.truncate(0)
            file.write(f"process {os.getpid()} on {socket.gethostname()}")
            file.flush()
        except OSError as error:
            place.unlink()
            with suppress(OSError):
                file.close()
            raise SweepError(f"{place}: cannot be written: {error.strerror}") from None
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
        except (OSError, ValueError, RecursionError) as error:
            raise SweepError(f"{self.path / HEAD}: cannot be read: {files.reason(error)}") from None
        if not isinstance(found, dict):
            raise SweepError(f"{self.path / HEAD}: no head of a sweep")
        return found

    def parts(self) -> list[Path]:
        """In the order of their numbers. Raises SweepError for another name."""
        return sorted(self.path.glob("part-*.parquet"), key=lambda part: (_number(part), part.name))

    def rows(self, columns: Sequence[str] | None = None) -> Iterator[Row]:
        """Every point once, in the order of writing; ``columns`` None: all. Of points of one grid that are the same run
        only one has the report. Raises SweepError, which names a part that is damaged."""
        parquet = needed("pyarrow.parquet", "sweep", "cmrc.sweep")
        names = [name for name, _ in COLUMNS if columns is None or name in ("key", "place") or name in columns]
        seen: set[tuple[str, str]] = set()
        parts = self.parts()
        while parts:
            part = parts.pop(0)
            try:
                for row in _read(parquet, part, names):
                    point = row["key"], row["place"]
                    if point not in seen:
                        seen.add(point)
                        yield row
            except FileNotFoundError as error:
                parts = self.parts()  # compacted meanwhile: its rows are in a later part
                if part in parts:
                    raise SweepError(f"{part}: cannot be read: {error.strerror}") from None
            except Exception as error:  # noqa: BLE001 (pyarrow raises errors of many kinds for a damaged file)
                raise SweepError(f"{part}: cannot be read: {files.reason(error)}") from None

    def opened(self, row: Mapping[str, Any]) -> Row:
        """A row with its JSON, ``place`` and ``settings``, as dictionaries. Raises SweepError."""
        return {**row, **{name: self._settings(row, name) for name in ("place", "settings")}}

    def settings(self, row: Mapping[str, Any]) -> dict[str, Any]:
        """The settings of a row. Raises SweepError."""
        return self._settings(row, "settings")

    def report(self, row: Mapping[str, Any]) -> dict[str, Any]:
        """The report of a row. Raises SweepError."""
        try:
            text = _inflated(row["report"])
        except (zlib.error, ValueError, TypeError) as error:
            raise self._damaged(row, "report", error) from None
        return self._object(row, "report", text)

    def _settings(self, row: Mapping[str, Any], name: str) -> dict[str, Any]:
        found = self._object(row, name, row[name])
        try:
            if name == "place":
                _check_settings({axis: value for axis, value in found.items() if value is not None})
            else:
                _check_settings({key: value for key, value in found.items() if key != EVENTS})
                _check_events(found.get(EVENTS, []))
        except GridError as error:
            raise self._damaged(row, name, files.printable(str(error))) from None
        return found

    def _object(self, row: Mapping[str, Any], name: str, text: str | bytes) -> dict[str, Any]:
        try:
            found = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise self._damaged(row, name, error) from None
        if not isinstance(found, dict):
            raise self._damaged(row, name, "no table")
        return found

    def _damaged(self, row: Mapping[str, Any], name: str, error: object) -> SweepError:
        return SweepError(f"{self.path}: the {name} of the run {row['key'][:12]} is damaged: {error}")

    def write(self, rows: Sequence[Row]) -> None:
        """Writes a new part. Raises SweepError; then the old parts stay, and nothing of the new one."""
        with self._named():
            self._put(rows)

    def compact(self) -> None:
        """Joins all parts into one. If it is killed at any instant, no row is lost: a row in two parts counts once.
        Without room for the whole, the parts stay as they are."""
        parts = self.parts()
        if len(parts) > 1:
            with suppress(OSError):
                self._put(self.rows())
                for part in parts:
                    part.unlink()

    def drop(self, unwanted: Callable[[Row], bool]) -> None:
        """Joins all parts into one, without these rows. Raises SweepError; then the rows stay."""
        parts = self.parts()
        if not parts:
            return
        with self._named():
            self._put(row for row in self.rows() if not unwanted(row))
            for part in parts:
                part.unlink()

    @contextmanager
    def _named(self) -> Iterator[None]:
        """A part that cannot be written is a SweepError with its name."""
        name = self._next()
        try:
            yield
        except OSError as error:
            raise SweepError(
                f"{self.path / name}.parquet: cannot be written: {error.strerror or error}. The parts that are there "
                "are whole; the same command continues from them"
            ) from None

    def _next(self) -> str:
        return f"part-{max(map(_number, self.parts()), default=0) + 1:06}"

    def _put(self, rows: Iterable[Row]) -> None:
        """Raises OSError."""
        arrow, parquet = (needed(name, "sweep", "cmrc.sweep") for name in ("pyarrow", "pyarrow.parquet"))
        schema = arrow.schema(
            [(name, getattr(arrow, kind)()) for name, kind in COLUMNS], metadata={"cmrc_sweep_format": str(FORMAT)}
        )
        name = self._next()
        fresh = self.path / f".part-{uuid.uuid4().hex}"
        try:
            with open(fresh, "w+b") as file:
                with parquet.ParquetWriter(file, schema, compression="zstd") as writer:
                    for batch in _batches(rows):
                        columns = [_array(arrow, kind, [row[name] for row in batch]) for name, kind in COLUMNS]
                        writer.write_table(arrow.Table.from_arrays(columns, schema=schema))
                file.flush()
                os.fsync(file.fileno())
                digest = _digest(file)
            os.rename(fresh, self.path / f"{name}-{digest}.parquet")
            _sync(self.path)
        finally:
            fresh.unlink(missing_ok=True)


def _number(part: Path) -> int:
    found = PART.fullmatch(part.name)
    if found is None:
        raise SweepError(f"{part}: is not the name of a part; part-NUMBER.parquet is expected")
    return int(found[1])


def _digest(file: IO[bytes]) -> str:
    """Of the whole file, for the name of a part."""
    sha = hashlib.sha256()
    file.seek(0)
    while block := file.read(1 << 20):
        sha.update(block)
    return sha.hexdigest()[:16]


def _read(parquet: Any, part: Path, names: Sequence[str]) -> Iterator[Row]:
    """The rows of a part. Raises ValueError for one that was changed after it was written, among others."""
    found = PART.fullmatch(part.name)
    written = None if found is None else found[2]
    # A file, not its name: pyarrow takes no name with a byte that is no UTF-8.
    with files.open_anywhere(part) as file:
        if written is not None and _digest(file) != written:
            raise ValueError("it was changed after it was written: its content does not have the checksum of its name")
        with parquet.ParquetFile(file) as opened:
            kinds = {field.name: str(field.type) for field in opened.schema_arrow}
            for name, kind in COLUMNS:
                if name in names and kinds.get(name) != {"float64": "double"}.get(kind, kind):
                    raise ValueError(f"there is no column {name} of {kind}")
            for group in range(opened.num_row_groups):
                for batch in opened.iter_batches(batch_size=BATCH_ROWS, row_groups=[group], columns=list(names)):
                    for row in batch.to_pylist():
                        _check(row)
                        yield row


def _check(row: Row) -> None:
    """Raises ValueError for a row that no sweep writes."""
    for name, value in row.items():
        if value is None and name in NEVER_NULL:
            raise ValueError(f"a run has no {name}")
    if row.get("status", DONE) not in (DONE, REFUSED, FAILED):
        raise ValueError(f"a run has the status {files.printable(row['status'])}")


def _check_settings(settings: Mapping[str, Any], where: str = "") -> None:
    """Raises GridError for a value that no setting has."""
    for key, value in settings.items():
        scalar(value, where + key)
        if key in APART and not isinstance(value, str):
            raise GridError(f"{key}: {value!r} cannot be used; a text is expected")


def _check_events(events: object) -> None:
    """Raises GridError."""
    if not isinstance(events, list) or not all(isinstance(event, dict) for event in events):
        raise GridError(f"{EVENTS}: a list of tables is expected")
    for n, event in enumerate(events):
        _check_settings(event, f"{EVENTS}[{n}].")


def _batches(rows: Iterable[Row]) -> Iterator[list[Row]]:
    batch: list[Row] = []
    size = 0
    for row in rows:
        batch.append(row)
        size += sum(len(value) for value in row.values() if isinstance(value, (str, bytes)))
        if len(batch) >= BATCH_ROWS or size >= BATCH_BYTES:
            yield batch
            batch, size = [], 0
    if batch:
        yield batch


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
    report: dict[str, Any] = json.loads(_inflated(content))
    return report


def _inflated(content: bytes) -> bytes:
    inflater = zlib.decompressobj()
    text = inflater.decompress(content, LARGEST_REPORT)
    if not inflater.eof:
        raise ValueError(f"it is cut short, or larger than {LARGEST_REPORT >> 20} MiB")
    return text
