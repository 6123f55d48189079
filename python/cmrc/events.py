"""The events of a run as a Parquet table, for DuckDB and similar tools.

A row is an event of docs/trace.md, in their order: ``time_ps`` (int64, picoseconds), ``component`` and ``event``
(text), ``task`` (text: the kind of the event's block, as in the report, else null), and a column of int64 for each name
of an argument, null if the event has none.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cmrc import _core, files
from cmrc.simulation import Given, configured

if TYPE_CHECKING:
    import pyarrow as pa

HEADER = "# cmrc event trace 1"
BATCH = 1 << 17
LONGEST_LINE = 1 << 16
RECORD = np.dtype([("time", "<i8"), ("component", "<u2"), ("event", "<u2"), ("arguments", "<u4", 5)])
"""An event in the layout of the run's hash (docs/trace.md)."""
SIGNED = {"latch", "push"}
OF_TASKS = {"load", "claim", "start", "finish", "remove", "requeue", "miss"}

Columns = dict[str, Any]


def needed() -> Any:
    """pyarrow. Raises ImportError with the name of the extra if it is missing."""
    try:
        import pyarrow
    except ImportError as error:
        raise ImportError("Parquet needs pyarrow: pip install 'cmrc[events]'") from error
    return pyarrow


def argument_columns() -> list[str]:
    """The names of all events' arguments, each once."""
    kinds: Mapping[int, tuple[str, list[str]]] = _core.report.event_names()
    return list(dict.fromkeys(name for _, names in kinds.values() for name in names))


@functools.cache
def built_in_tasks() -> tuple[str, ...]:
    """The names of the built-in kinds of tasks, by the numbers KIND_* of c40_programs/include/task_block.inc."""
    names = _core.cmrc.Simulation(configured(None, None, {"report.reference": "none"}, (), {})).task_names()
    return tuple(names[number] for number in sorted(names))


def of_configuration(
    config: str | os.PathLike[str],
    settings: Mapping[str, Given] | None = None,
    on_progress: Callable[[float, float], object] | None = None,
) -> Iterator[pa.RecordBatch]:
    """Runs a configuration and yields its events in batches of 0.1 s. ``on_progress(simulated_s, duration_s)`` is
    called for each. Raises ConfigError, ImportError."""
    pa = needed()
    made = configured(config, None, {"report.reference": "none", **(settings or {})}, (), {})
    duration_s = float(made.to_dict()["run.duration_s"])
    core = _core.cmrc.Simulation(made)
    core.keep_events()
    tasks = core.task_names()
    while not core.ended:
        core.run_until(core.time_s + 0.1)
        if on_progress is not None:
            on_progress(core.time_s, duration_s)
        yield _batch(pa, np.frombuffer(core.take_events(), RECORD), tasks)
    core.report_so_far_json()  # the events settled last
    yield _batch(pa, np.frombuffer(core.take_events(), RECORD), tasks)


def of_trace(path: str | os.PathLike[str]) -> Iterator[pa.RecordBatch]:
    """The events of a trace that ``--trace`` wrote, in batches. Raises ValueError with the line, ImportError,
    OSError."""
    pa = needed()
    known = {name: set(arguments) for name, arguments in _core.report.event_names().values()}
    with open(path, encoding="utf-8", errors="replace") as lines:
        if lines.readline(LONGEST_LINE).rstrip("\n") != HEADER:
            raise ValueError(f'{path}: line 1: not an event trace; one begins with "{HEADER}"')
        rows: list[tuple[int, str, str, dict[str, int]]] = []
        for number, line in enumerate(iter(lambda: lines.readline(LONGEST_LINE), ""), 2):
            if len(line) == LONGEST_LINE:
                raise ValueError(f"{path}: line {number}: not a line of an event trace: it is too long")
            if line.startswith("#") or not line.strip():
                continue
            try:
                rows.append(_row(line, known))
            except (ValueError, IndexError) as error:
                raise ValueError(
                    f"{path}: line {number}: not a line of an event trace: {line.rstrip()[:80]!r}"
                ) from error
            if len(rows) == BATCH:
                yield _batch_of_rows(pa, rows)
                rows = []
        yield _batch_of_rows(pa, rows)


def _row(line: str, known: Mapping[str, set[str]]) -> tuple[int, str, str, dict[str, int]]:
    when, _, rest = line.partition(" [")
    component, _, said = rest.partition("] ")
    event, *pairs = said.split()
    seconds, _, fraction = when.partition(".")
    arguments = {}
    for pair in pairs:
        name, _, value = pair.partition("=")
        arguments[name] = int(value, 0)
    if (
        arguments.keys() != known.get(event)
        or not all((-(1 << 31) if event in SIGNED else 0) <= value < 1 << 32 for value in arguments.values())
        or not 0 < len(seconds) < 7
        or len(fraction) != 12
    ):
        raise ValueError(event)
    return int(seconds) * 10**12 + int(fraction), component, event, arguments


def _name_in_a_trace(kind: int) -> str:
    """A trace has no names of [[tasks]]: "user 0" is the first of its configuration."""
    built_in = built_in_tasks()
    return built_in[kind] if kind < len(built_in) else f"user {kind - len(built_in)}"


def _batch_of_rows(pa: Any, rows: list[tuple[int, str, str, dict[str, int]]]) -> pa.RecordBatch:
    columns: Columns = {
        "time_ps": [row[0] for row in rows],
        "component": [row[1] for row in rows],
        "event": [row[2] for row in rows],
    }
    columns["task"] = [
        _name_in_a_trace(arguments["kind"]) if event in OF_TASKS else None for _, _, event, arguments in rows
    ]
    for name in argument_columns():
        columns[name] = [row[3].get(name) for row in rows]
    return _of_columns(pa, columns)


def _batch(pa: Any, events: NDArray[Any], tasks: Mapping[int, str]) -> pa.RecordBatch:
    kinds = _core.report.event_names()
    columns: Columns = {"time_ps": events["time"]}
    columns["component"] = _named(
        pa, events["component"], {int(c): _core.report.component_name(int(c)) for c in np.unique(events["component"])}
    )
    columns["event"] = _named(pa, events["event"], {number: name for number, (name, _) in kinds.items()})
    values = {name: np.zeros(len(events), np.int64) for name in argument_columns()}
    there = {name: np.zeros(len(events), bool) for name in values}
    of_task = np.zeros(len(events), bool)
    for number in np.unique(events["event"]):
        event, names = kinds[int(number)]
        rows = events["event"] == number
        for i, name in enumerate(names):
            given = events["arguments"][rows, i]
            values[name][rows] = given.astype(np.int32) if event in SIGNED else given
            there[name][rows] = True
        if event in OF_TASKS:
            of_task |= rows
    task = pa.array(np.where(of_task, values["kind"], -1))
    columns["task"] = _named(pa, task.to_numpy(), tasks)
    columns |= {name: pa.array(values[name], mask=~there[name]) for name in values}
    return _of_columns(pa, columns)


def _named(pa: Any, numbers: NDArray[Any], names: Mapping[int, str]) -> Any:
    """A column of texts, by number; null for a number without a name."""
    known = list(names)
    place = {number: i for i, number in enumerate(known)}
    index = np.array([place.get(int(n), -1) for n in range(-1, 1 << 16)], np.int32)[numbers.astype(np.int64) + 1]
    return pa.DictionaryArray.from_arrays(
        pa.array(index, mask=index < 0), pa.array([names[n] for n in known], pa.string())
    )


def _of_columns(pa: Any, columns: Columns) -> pa.RecordBatch:
    text = ("component", "event", "task")
    arrays = [
        pa.array(column, pa.string())
        if name in text and isinstance(column, list)
        else pa.array(column, None if name in text else pa.int64())
        for name, column in columns.items()
    ]
    arrays = [array.cast(pa.string()) if name in text else array for name, array in zip(columns, arrays, strict=True)]
    order = ["time_ps", *text, *argument_columns()]
    batch = pa.RecordBatch.from_arrays(arrays, names=list(columns))
    return batch.select(order)


def write(batches: Iterable[pa.RecordBatch], path: str | os.PathLike[str]) -> int:
    """Writes a Parquet file, whole or not at all; returns the number of rows. Raises OSError."""
    needed()
    from pyarrow import parquet

    rows = 0
    with files.writing(path) as out:
        writer = None
        for batch in batches:
            writer = writer or parquet.ParquetWriter(out, batch.schema, compression="zstd")
            writer.write_batch(batch)
            rows += batch.num_rows
        if writer is not None:
            writer.close()
    return rows
