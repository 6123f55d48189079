"""The page that shows a run in a browser (docs/page.md), and the recording inside.

``Simulation.record`` records during the run what the page needs, ``Simulation.write_page`` writes the page;
``Recording.read`` reads the recording of a page.
"""

from __future__ import annotations

import base64
import binascii
import json
import math
import os
import re
import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cmrc import arguments, files
from cmrc.errors import Error

FORMAT = 1
_LARGEST = 1 << 32
_LARGEST_COLUMN = 1 << 30
FIRST_KIND = 4
"""In a lane, ``what`` from this value on means a job of kind ``what - FIRST_KIND``; below: off, failed, asleep,
executive."""

_SIGNALS = (
    *("time_s", "s_m", "tip_y_m", "tip_z_m", "payload_x_m", "payload_y_m", "payload_z_m"),
    *("sway_alpha_rad", "sway_beta_rad", "contact"),
)

Column = NDArray[np.float64]


class PageError(Error, ValueError):
    """A file that is not a page of this emulator, or is damaged."""


def _number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 1 << 63


def _few(value: object) -> bool:
    return isinstance(value, int) and _whole(value) and value < 256


def _text(value: object) -> bool:
    return isinstance(value, str)


_HEADER: dict[str, Any] = {
    "tick_ps": lambda value: _whole(value) and value > 0,
    "from_s": _number,
    "to_s": _number,
    "slots": _few,
    "kinds": [_text],
    "columns": [{"name": _text, "at": _whole, "size": _whole}],
    "layout": {
        "ship": (_number,) * 6,
        "boxes": [(_number,) * 6],
        "containers": [(_number,) * 4],
        "size": (_number,) * 3,
        "lanes": [(_number,) * 5],
        "agv": {"count": _few, "length": _number, "width": _number},
        "crane": {"portal": {"along": _number, "leg": _number, "rails": [_number]}},
        "movers": [(_number,) * 2],
    },
}
"""What is read of a header: a tuple has so many elements, a list any number of the same."""


def _fits(value: object, right: Any) -> bool:
    if isinstance(right, dict):
        return isinstance(value, dict) and all(_fits(value.get(key), one) for key, one in right.items())
    if isinstance(right, tuple):
        return isinstance(value, list) and len(value) == len(right) and all(map(_fits, value, right))
    if isinstance(right, list):
        return isinstance(value, list) and all(_fits(one, right[0]) for one in value)
    return bool(right(value))


def _inflated(data: bytes) -> bytes:
    inflater = zlib.decompressobj(-15)
    try:
        out = inflater.decompress(data, _LARGEST_COLUMN)
    except zlib.error as error:
        raise PageError(f"the recording is damaged: {error}") from None
    if not inflater.eof:
        raise PageError(f"the recording is damaged: a column ends too early, or has more than {_LARGEST_COLUMN} bytes")
    return out


def _numbers(data: bytes, count: int, order: int) -> NDArray[np.int64]:
    """Zigzag varints, each minus a prediction from the numbers before (emulator/page/columns.hpp)."""
    if order not in (0, 1, 2):
        raise PageError(f"the recording is damaged: a column has the order {order}; 0, 1 or 2 is expected")
    octets = np.frombuffer(data, dtype=np.uint8)
    ends = np.flatnonzero(octets < 0x80)
    if ends.size != count or (octets.size and octets[-1] >= 0x80):
        raise PageError("the recording is damaged: a column has another length than its header says")
    begins = np.concatenate(([0], ends[:-1] + 1)) if count else ends
    bits = np.zeros(count, dtype=np.uint64)
    for place in range(int((ends - begins).max()) + 1 if count else 0):
        there = begins + place <= ends
        bits[there] |= (octets[begins[there] + place] & 0x7F).astype(np.uint64) << np.uint64(7 * place)
    values: NDArray[np.int64] = (bits >> np.uint64(1)).astype(np.int64) ^ -(bits & np.uint64(1)).astype(np.int64)
    for _ in range(order):
        values = np.cumsum(values)
    return values


@dataclass
class Lane:
    """The intervals of one DSP in order: ``from_s`` and ``to_s`` in s, ``what`` as at FIRST_KIND, ``run`` the job's row
    in ``Recording.jobs`` or -1."""

    from_s: Column
    to_s: Column
    what: NDArray[np.int64]
    run: NDArray[np.int64]


class Recording:
    """The recording of a page: ``header``, ``report`` (docs/report.md), the dock's ``signals``, the DSPs' ``lanes``,
    ``jobs``."""

    def __init__(self, data: bytes) -> None:
        if not isinstance(data, (bytes, bytearray)):
            arguments.refuse("data", data, "the bytes of a recording")
        self._name = ""
        if data[:8] != b"CMRCpage":
            raise PageError("the page holds no recording")
        with self._reading():
            (size,) = struct.unpack("<I", data[8:12])
            self.header: dict[str, Any] = json.loads(data[12 : 12 + size].decode("utf-8"))
            if self.header.get("format") != FORMAT:
                raise PageError(f"a recording of format {self.header.get('format')} is not known; {FORMAT} is expected")
            for key, right in _HEADER.items():
                if not _fits(self.header.get(key), right):
                    raise ValueError(f"its header has no {key}, or a wrong one")
            begin, end = self.header["from_s"], self.header["to_s"]
            if not begin <= end:
                raise ValueError(f"its header has from_s {begin} and to_s {end}; from_s <= to_s is expected")
        self._data = data[12 + size :]
        self._entries: dict[str, dict[str, Any]] = {entry["name"]: entry for entry in self.header["columns"]}

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Recording:
        """Reads the recording of a page. Raises OSError; PageError for a file that is not a page."""
        name = arguments.path("path", path, "the path of a page")
        return cls.of(files.read(name, _LARGEST), name)

    @classmethod
    def of(cls, page: bytes, name: str) -> Recording:
        """The recording of a page with this content; ``name`` is for messages. Raises PageError."""
        text = page.decode("utf-8", errors="replace")
        found = re.search(r'<script type="text/plain" id="recording">([A-Za-z0-9+/=\s]*)</script>', text)
        if found is None:
            raise PageError(f"{name} is not a page of this emulator (cmrc page CONFIG.toml writes one)")
        try:
            recording = cls(base64.b64decode(found[1], validate=True))
        except (PageError, binascii.Error) as error:
            raise PageError(f"{name}: {error}") from None
        recording._name = f"{name}: "
        return recording

    @contextmanager
    def _reading(self) -> Iterator[None]:
        """Whatever does not fit together is damage."""
        try:
            yield
        except PageError as error:
            text = str(error)
            raise PageError(text if text.startswith(self._name) else self._name + text) from None
        except (
            ArithmeticError,
            AttributeError,
            LookupError,
            RecursionError,
            TypeError,
            ValueError,
            struct.error,
        ) as error:
            raise PageError(f"{self._name}the recording is damaged: {files.reason(error)}") from None

    def names(self) -> list[str]:
        """The names of all columns."""
        return list(self._entries)

    def whole(self, name: str) -> NDArray[np.int64]:
        """A column in its own units."""
        with self._reading():
            return self._column(name)

    def _column(self, name: str) -> NDArray[np.int64]:
        entry = self._entries[name]
        return _numbers(self._bytes(entry), entry["count"], entry["order"])

    def _bytes(self, entry: dict[str, Any]) -> bytes:
        return _inflated(self._data[entry["at"] : entry["at"] + entry["size"]])

    @cached_property
    def report(self) -> dict[str, Any]:
        """The run's report."""
        with self._reading():
            report: dict[str, Any] = json.loads(self._bytes(self._entries["report"]))
            return report

    @cached_property
    def signals(self) -> dict[str, Column]:
        """The dock at equal intervals, units in the names; ``time_s`` is one of them. NaN: not planned yet."""
        with self._reading():
            signals = {
                name: (self._column(name) * float(entry["unit"])).astype(np.float64)
                for name, entry in self._entries.items()
                if "count" in entry and not re.match(r"(lane|run|job|bus)\.", name)
            }
            for name in _promised(self.header["layout"]):
                if name not in signals:
                    raise ValueError(f"there is no column {name}, which its header promises")
            for prefix, rows in self.header.get("planned_rows", {}).items():
                for name, values in signals.items():
                    if name.startswith(prefix):
                        values[:rows] = math.nan
            return signals

    @cached_property
    def lanes(self) -> list[Lane]:
        """The lane of each slot."""
        with self._reading():
            slot, what, took = (self._column(f"lane.{name}") for name in ("slot", "what", "took"))
            run = np.where(what >= FIRST_KIND, np.cumsum(what >= FIRST_KIND) - 1, -1)
            second, lanes = self.header["tick_ps"] * 1e-12, []
            begin = math.floor(self.header["from_s"] / second + 1e-6)
            for number in range(self.header["slots"]):
                own = slot == number
                ends = begin + np.cumsum(took[own])
                lanes.append(Lane((ends - took[own]) * second, ends * second, what[own], run[own]))
            return lanes

    @cached_property
    def jobs(self) -> dict[str, NDArray[Any]]:
        """Every run of a job, then the jobs that never ran (``dsp`` -1): kind, robot, number, dsp, times in s (NaN: no
        deadline), outcome, missed, end."""
        with self._reading():
            second = self.header["tick_ps"] * 1e-12
            slot, what = self._column("lane.slot"), self._column("lane.what")
            busy = what >= FIRST_KIND
            claimed, ended = np.zeros(busy.size), np.zeros(busy.size)
            for number, lane in enumerate(self.lanes):
                claimed[slot == number], ended[slot == number] = lane.from_s, lane.to_s
            runs = {
                name: self._column(f"run.{name}")
                for name in ("number", "robot", "end", "waited", "allowed", "outcome", "missed")
            }
            never = {
                name: self._column(f"job.{name}")
                for name in ("number", "kind", "robot", "released", "took", "allowed", "outcome", "missed")
            }
            kind = what[busy] - FIRST_KIND
            released = np.round(claimed[busy] / second).astype(np.int64) - runs["waited"]
            since = np.concatenate((released, never["released"]))
            allowed = np.concatenate((runs["allowed"], never["allowed"]))
            return {
                "kind": np.concatenate((kind, never["kind"])),
                "robot": np.concatenate((runs["robot"], never["robot"])),
                "number": np.concatenate(
                    (
                        _absolute(runs["number"], kind, runs["robot"]),
                        _absolute(never["number"], never["kind"], never["robot"]),
                    )
                ),
                "dsp": np.concatenate((slot[busy], np.full(never["kind"].size, -1))),
                "claimed_s": np.concatenate((claimed[busy], never["released"] * second)),
                "ended_s": np.concatenate((ended[busy], (never["released"] + never["took"]) * second)),
                "released_s": since * second,
                "deadline_s": np.where(allowed == 0, np.nan, (since + allowed - 1) * second),
                "outcome": np.concatenate((runs["outcome"], never["outcome"])),
                "missed": np.concatenate((runs["missed"], never["missed"])).astype(bool),
                "end": np.concatenate((runs["end"], np.zeros(never["kind"].size, dtype=np.int64))),
            }

    def last_runs(self) -> NDArray[np.int64]:
        """For each job its last row in ``jobs``: the run that finished, else the last one."""
        jobs = self.jobs
        last: dict[tuple[int, int, int], int] = {}
        for row, key in enumerate(
            zip(jobs["kind"].tolist(), jobs["robot"].tolist(), jobs["number"].tolist(), strict=True)
        ):
            last[key] = row
        return np.array(sorted(last.values()), dtype=np.int64)


def _promised(layout: dict[str, Any]) -> Iterator[str]:
    """The columns of a dock that ``cmrc.plot`` draws, whichever crane it has."""
    yield from _SIGNALS
    for n in range(layout["agv"]["count"]):
        yield from (f"agv{n}_x_m", f"agv{n}_y_m", f"agv{n}_heading_rad")
    for n in range(len(layout["movers"])):
        yield from (f"mover{n}_x_m", f"mover{n}_y_m")


def _absolute(number: NDArray[np.int64], kind: NDArray[np.int64], robot: NDArray[np.int64]) -> NDArray[np.int64]:
    """Numbers that are stored minus the number of the job before of the same kind and robot."""
    out = np.zeros_like(number)
    for of in np.unique(kind * 256 + robot):
        own = kind * 256 + robot == of
        out[own] = np.cumsum(number[own])
    return out
