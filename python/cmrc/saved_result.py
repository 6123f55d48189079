"""Results in files: a ZIP archive with the report as JSON, the texts, and the signals as NumPy arrays."""

from __future__ import annotations

import io
import json
import os
import zipfile
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from cmrc import _core, arguments, files
from cmrc.errors import Error
from cmrc.table import Table

if TYPE_CHECKING:
    from cmrc.result import Result

FORMAT = 1
SCHEMA_VERSIONS = (4,)
"""The schema versions that this version reads (docs/report.md)."""
_DATE = (1980, 1, 1, 0, 0, 0)  # equal results give equal files
_LARGEST = 1 << 32  # limit of one unpacked member: a damaged file cannot request more memory
_LARGEST_REPORT = 1 << 29
_LONGEST_NAME = 1000


_TABLE, _NUMBER, _NOTHING = Mapping, (int, float), type(None)
_READ: dict[str, tuple[Any, Any]] = {
    "hash": (str, object),
    "emulator_version": (str, object),
    "stop_reason": (str, object),
    "simulated_s": (_NUMBER, object),
    "containers_delivered": (_NUMBER, object),
    "configuration": (_TABLE, object),
    "tasks": (_TABLE, _TABLE),
    "buses": (_TABLE, _TABLE),
    "misses": (list, _TABLE),
    "dsps": (list, _TABLE),
    "cycles": (list, _TABLE),
    "rates": ((_TABLE, _NOTHING), object),
    "errors": ((_TABLE, _NOTHING), object),
}
"""What a Result reads of its report: the kind of each member, and of what is in it."""


class ResultError(Error, ValueError):
    """A file that is neither a saved result nor a report."""


class SchemaError(ResultError):
    """A report of another schema: its keys have other meanings."""


def save(result: Result, path: str | os.PathLike[str]) -> None:
    """Writes a result, whole or not at all. Raises OSError; ResultError for a column of signals that no file has."""
    head = {"format": FORMAT, "profile": result.profile is not None, "events": result.events is not None}
    members: dict[str, bytes] = {
        "result.json": json.dumps(head).encode(),
        "report.json": json.dumps(result.report).encode(),
        "report.txt": result.text.encode(),
        "signals.npz": _packed(result.signals),
    }
    if result.profile is not None:
        members["profile.json"] = json.dumps(result.profile.data).encode()
        members["profile.txt"] = result.profile.text.encode()
    if result.events is not None:
        members["events.txt"] = result.events.encode()
    with files.writing(path) as out, zipfile.ZipFile(out, "w") as archive:
        for name, content in members.items():
            entry = zipfile.ZipInfo(name, _DATE)
            entry.compress_type = zipfile.ZIP_STORED if name.endswith(".npz") else zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)


def is_archive(path: str | os.PathLike[str]) -> bool:
    """A saved result, by its form. A device or a pipe is none: it cannot be read from its end."""
    return os.path.isfile(path) and zipfile.is_zipfile(path)


def load(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The parts of a ``Result``. Raises OSError; ResultError for a file that is not a result."""
    name = arguments.path("path", path, "the path of a result that Result.save wrote")
    with files.open_anywhere(name) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                return _unpacked(archive)
        except SchemaError as error:
            raise SchemaError(f"{name}: {error}") from None
        except Exception as error:  # zipfile and its decompressors raise errors of many kinds for a damaged file
            raise ResultError(f"{name}: no saved result ({files.reason(error)}); Result.save writes one") from error


def _unpacked(archive: zipfile.ZipFile) -> dict[str, Any]:
    from cmrc.result import Profile

    def read(member: str) -> bytes:
        if archive.getinfo(member).file_size > _LARGEST:
            raise ValueError(f"{member} is larger than {_LARGEST} bytes")
        return archive.read(member)

    head = json.loads(read("result.json"))
    if head["format"] != FORMAT:
        raise ValueError(f"format {head['format']}; this version of cmrc reads format {FORMAT}")
    report = checked_report(json.loads(read("report.json")))
    profile = None
    if head["profile"]:
        data = json.loads(read("profile.json"))
        if not isinstance(data.get("groups"), list) or not isinstance(data.get("cycles"), int):
            raise ValueError("profile.json has no groups or no cycles")
        profile = Profile(data, read("profile.txt").decode())
    with zipfile.ZipFile(io.BytesIO(read("signals.npz"))) as arrays:
        if sum(entry.file_size for entry in arrays.infolist()) > _LARGEST:
            raise ValueError(f"signals.npz is larger than {_LARGEST} bytes")
        # Not by np.load, for which the columns "a" and "a.npy" are one.
        signals = Table({entry.filename.removesuffix(".npy"): _array(arrays, entry) for entry in arrays.infolist()})
    if len({len(column) for column in signals.values()}) > 1:
        raise ValueError("signals of different lengths")
    events = read("events.txt").decode() if head["events"] else None
    return {
        "report": report,
        "text": read("report.txt").decode(),
        "signals": signals,
        "profile": profile,
        "events": events,
    }


def check_schema(report: Mapping[str, Any]) -> None:
    """Raises SchemaError that says what to do."""
    found = report.get("schema_version")
    if found in SCHEMA_VERSIONS:
        return
    known = ", ".join(map(str, SCHEMA_VERSIONS))
    by = f", written by emulator {report['emulator_version']}" if "emulator_version" in report else ""
    if isinstance(found, int) and found > max(SCHEMA_VERSIONS):
        what = "a cmrc as new as its writer reads it"
    elif "configuration_toml" in report:
        what = "the run is to be made again: cmrc.run(config=report), with the report as a dictionary"
    else:
        what = (
            'the run is to be made again: cmrc.run(settings=report["configuration"]), with its events, tasks and '
            "processes, which are not in the report"
        )
    raise SchemaError(
        f"the report has schema version {found}{by}; cmrc {_core.cmrc.emulator_version} reads {known}: {what}"
    )


def checked_report(report: Any) -> dict[str, Any]:
    """A report with a schema that this version reads. Raises ValueError."""
    if not isinstance(report, Mapping) or "schema_version" not in report:
        raise ValueError("there is no report with a schema_version in it")
    check_schema(report)
    for key, (kind, kind_within) in _READ.items():
        value = report.get(key, ...)
        within = value.values() if isinstance(value, Mapping) else value if isinstance(value, list) else ()
        if not isinstance(value, kind) or not all(isinstance(one, kind_within) for one in within):
            raise ValueError(f"the report has no {key!r}, or one of a wrong kind")
    if not all(isinstance(task.get("misses"), int) for task in report["tasks"].values()):
        raise ValueError("the report has a task without its number of misses")
    return dict(report)


def load_report(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The report of a saved result, or of a JSON report (``emulator --report``). Raises OSError, ResultError."""
    name = arguments.path("path", path, "the path of a saved result or a JSON report")
    if is_archive(name):
        report: dict[str, Any] = load(name)["report"]
        return report
    try:
        return checked_report(json.loads(files.read(name, _LARGEST_REPORT)))
    except SchemaError as error:
        raise SchemaError(f"{name}: {error}") from None
    except (ValueError, RecursionError) as error:
        raise ResultError(
            f"{name}: neither a saved result nor a JSON report ({files.reason(error)}); what Result.save or emulator "
            "--report writes is expected"
        ) from error


def _packed(table: Mapping[str, Any]) -> bytes:
    """As numpy.savez_compressed does, for names that are keywords of that function, too."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        rows = None
        for name, column in table.items():
            entry = zipfile.ZipInfo(f"{_column_name(name)}.npy", _DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            values = np.asarray(column)
            rows = rows or values.shape[:1]
            if values.dtype.hasobject or values.ndim != 1 or values.shape != rows or np.ma.is_masked(column):
                masked = "masked " if np.ma.is_masked(column) else ""
                raise ResultError(
                    f"signals: the column {name!r} has {masked}{values.dtype} of shape {values.shape}; a number, text "
                    "or time in each row, and as many rows as in the other columns, are expected"
                )
            with archive.open(entry, "w", force_zip64=True) as member:
                np.lib.format.write_array(member, values, allow_pickle=False)
    return out.getvalue()


def _array(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> Any:
    with archive.open(entry) as member:
        return np.lib.format.read_array(member, allow_pickle=False)


def _column_name(name: object) -> str:
    if not isinstance(name, str) or not name or not name.isprintable() or len(name) > _LONGEST_NAME:
        shown = arguments.shown(name)
        raise ResultError(
            f"signals: {shown} cannot be the name of a column in a file; printable text of at most {_LONGEST_NAME} "
            "characters is expected"
        )
    return name
