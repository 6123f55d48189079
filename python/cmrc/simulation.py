"""Runs of the dock."""

from __future__ import annotations

import json
import operator
import os
from collections.abc import Callable, Mapping, Sequence
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from cmrc import _core, arguments, files
from cmrc.chip_state import ChipState
from cmrc.core_errors import class_in_our_words
from cmrc.debug import Debugger
from cmrc.keywords import listed
from cmrc.keywords import settings as settings_by_keyword
from cmrc.one_state import OneState
from cmrc.programs import Program
from cmrc.result import Profile, Result
from cmrc.snapshots import SnapshotError
from cmrc.table import Table

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from cmrc._settings import MoreSettings, Settings

ConfigError = _core.cmrc.ConfigError
ConfigError.__doc__ = """Raised for an unknown or ill-typed setting, or rates that break an invariant. The message
says where, and what would be right."""

Reference = _core.cmrc.Reference
"""An ideal run (docs/report.md, Errors). Opaque."""

Snapshot = _core.cmrc.Snapshot
"""The state of a run at an instant. Opaque; it can be pickled, and written by ``write_snapshot``."""
class_in_our_words(Snapshot, "Snapshot")

_LARGEST_SNAPSHOT = 1 << 32
_NO_WAY_BACK = "what is collected beside the run cannot be taken back"
Setting = bool | int | float | str
Source = str | os.PathLike[str] | Mapping[str, Any]
"""Of a configuration: a TOML file, or the report of a run, which is made again."""
Given = Setting | os.PathLike[str] | np.bool_ | np.number[Any]
"""What may be given as a setting."""
Progress = Callable[[float, float], bool | None]


def configured(
    config: Source | None,
    preset: str | None,
    settings: Mapping[str, Given] | None,
    events: Sequence[Mapping[str, Given]],
    keywords: Mapping[str, object],
) -> _core.cmrc.Config:
    """A configuration from the arguments common to all runs. Raises ConfigError; TypeError with the argument's name."""
    return layered(config, preset, settings, events, keywords).config()


def layered(
    config: Source | None,
    preset: str | None,
    settings: Mapping[str, Given] | None,
    events: Sequence[Mapping[str, Given]],
    keywords: Mapping[str, object],
) -> _core.cmrc.ConfigLayers:
    """The same for several configurations that differ in few settings: a file is read once, and errors in it have its
    places."""
    is_report = isinstance(config, Mapping)
    toml = _configuration_of(config) if isinstance(config, Mapping) else None
    file = None if config is None or is_report else arguments.path("config", config, "the path of a TOML file")
    name = None if preset is None else arguments.text("preset", preset, "the name of a preset")
    given = arguments.mapping("settings", settings, 'a dictionary of keys and values, {"machine.dsps": 2},')
    given |= keywords
    given = {key: _plain(key, value) for key, value in given.items()}
    rows = [
        arguments.mapping(f"events[{n}]", event, "a dictionary with the fields of [[events]]")
        for n, event in enumerate(arguments.items("events", events, "a list of dictionaries"))
    ]
    rows = [{key: _plain(f"events[{n}].{key}", value) for key, value in row.items()} for n, row in enumerate(rows)]
    return _core.cmrc.config_layers(file=file, toml=toml, name="config", preset=name, settings=given, events=rows)


def _configuration_of(report: Mapping[str, Any]) -> str:
    """The configuration of a report as TOML. Raises ConfigError."""
    toml = report.get("configuration_toml")
    if isinstance(toml, str):
        return toml
    raise ConfigError(
        'config: a dictionary without "configuration_toml"; the path of a TOML file is expected, or a report of this '
        "version of cmrc or a later one"
    )


def _plain(key: str, value: object) -> object:
    """The value as the extension module takes it. An array has ``__index__``, as an integer has, but is none; a
    dictionary is for the settings of a table. Raises ConfigError."""
    if isinstance(value, Mapping) and key not in _names_of_settings():
        return {inner: _plain(f"{key}.{inner}", one) for inner, one in value.items()}
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, np.bool_):
        return bool(value)
    try:
        if hasattr(value, "__index__"):
            operator.index(value)
        usable = not isinstance(value, Mapping)
    except TypeError:
        usable = False
    if not usable:
        raise ConfigError(f"{key}: {type(value)} cannot be used; a bool, int, float or str is expected")
    return value


@cache
def _names_of_settings() -> frozenset[str]:
    """All names of settings, whole and short."""
    return frozenset({*settings_by_keyword(), *(key["name"] for key in _core.cmrc.config_keys())})


def write_snapshot(path: str | os.PathLike[str], snapshot: Snapshot) -> None:
    """Writes a snapshot in the format of ``emulator --resume``. Raises OSError."""
    files.write(path, arguments.instance("snapshot", snapshot, Snapshot, "what Simulation.snapshot() gives").to_bytes())


def read_snapshot(path: str | os.PathLike[str]) -> Snapshot:
    """Reads a snapshot from its file. Raises SnapshotError, or ValueError for a file without an end, with the file's
    name; OSError."""
    name = arguments.path("path", path, "the path of a snapshot")
    content = files.read(name, _LARGEST_SNAPSHOT)
    try:
        return Snapshot.from_bytes(content)
    except SnapshotError as error:
        raise SnapshotError(f"{name}: {error}") from None


class Dsp(ChipState):
    """A DSP of the dock as a debugger sees it: registers, memory, ports, peripherals, counters. A change by hand
    changes the run and its hash."""

    @property
    def pc(self) -> int:
        """Address of the next instruction."""
        return int(self._core.pc)

    @property
    def plugged(self) -> bool:
        """A board is in the slot."""
        return bool(self._core.plugged)

    @property
    def booted(self) -> bool:
        """Its program has run since its last reset."""
        return bool(self._core.booted)


class Simulation(OneState):
    """One run that can be stopped, inspected, and continued.

    Every setting of docs/configuration.md may be given: in ``settings`` with its dotted name, or as a keyword with its
    last part if only one table has it (``dsps``, ``duration_s``, ``seed``, ``idle_policy``, ...). ``config`` is a TOML
    file, or the report of a run, whose configuration it has (``result.report``, or the JSON that ``emulator --report``
    wrote). ``preset`` is one of those of docs/configuration.md. Later ones win: defaults, preset, file, ``settings``,
    keywords. ``events`` are dictionaries with the fields of ``[[events]]``. With ``profile`` the result has the DSPs'
    cycles by place; the run is slower and otherwise the same. With ``keep_events`` the result has the event trace,
    about 25 MB per simulated second. ``reference`` is the ideal run for the errors, from an earlier run
    (``Simulation.reference``) that differs only in the number of DSPs, their speed and failures; without it, the ideal
    run is made at the same time.

    One thread at a time may use a run. Inside a callback it may be read (``result``, ``tasks``, ``dsp``), but neither
    changed nor run; everything else is a RuntimeError at once. Raises ConfigError; c40.AssemblyError if ``programs``
    names sources that do not assemble.
    """

    @listed
    def __init__(
        self,
        *,
        config: Source | None = None,
        preset: str | None = None,
        settings: Mapping[str, Given] | None = None,
        events: Sequence[Mapping[str, Given]] = (),
        profile: bool = False,
        keep_events: bool = False,
        reference: Reference | None = None,
        **keywords: Unpack[Settings],
    ) -> None:
        self.config = configured(config, preset, settings, events, keywords)
        """Every setting of this run; ``config.to_dict()``, ``config.to_toml()``."""
        arguments.flag("profile", profile)
        if reference is None:
            self._core = _core.cmrc.Simulation(self.config)
        else:
            self._core = _core.cmrc.Simulation(
                self.config,
                arguments.instance("reference", reference, Reference, "what Simulation.reference() gives, or None,"),
            )
        self._profiled = profile
        if profile:
            self._core.profile()
        self._keeps_events = arguments.flag("keep_events", keep_events)
        if keep_events:
            self._core.keep_text_of_events()
        self._recorded = False
        self._debugger: Debugger | None = None

    def at(self, at_s: float, action: str, **fields: Given) -> None:
        """Adds an event at ``at_s``, not before the present time, with the fields of docs/configuration.md,
        ``[[events]]``.

        ``at(0.5, "fail", dsp=1)``, ``at(1, "stall_bus", bus="A", lasts_ms=0.2)``, ``at(2, "set", key="scheduling.p",
        value=0x5000)``. Raises ConfigError.
        """
        event = {"at_s": at_s, "action": action, **fields}
        self._core.at({key: _plain(key, value) for key, value in event.items()})

    def run(self, on_progress: Progress | None = None) -> Result:
        """Runs to the end of the duration, without holding the GIL.

        ``on_progress(simulated_s, duration_s)`` is called every 20 ms of simulated time and may return False to stop.
        Ctrl-C stops the run and raises KeyboardInterrupt; then ``result()`` is the result so far, and ``run``
        continues.
        """
        result: Result = self._core.run(on_progress, at_end=self.result)
        return result

    def run_until(self, time_s: float) -> None:
        """Runs until that instant of virtual time, or the end of the duration. Raises ValueError for an instant in the
        past."""
        self._core.run_until(arguments.number("time_s", time_s, "an instant of the run in s, at least 0,", 0.0))

    def record(self) -> None:
        """Records from now on what a page shows (docs/page.md). Changes nothing in the run. Raises RuntimeError if it
        is already recorded, or has ended, or has a debugger, which can go back."""
        if self._debugger is not None and self._debugger.open:
            raise RuntimeError(f"record: {_NO_WAY_BACK}; the debugger is to be closed first")
        self._core.record()
        self._recorded = True

    def write_page(self, path: str | os.PathLike[str], title: str | None = None) -> None:
        """Writes the page of a run that has ended and was recorded (``record``): one HTML file. Raises RuntimeError,
        OSError."""
        content = self.page(title)
        files.write(arguments.path("path", path, "the path of the page"), content)

    def page(self, title: str | None = None) -> bytes:
        """The content of that page. Raises RuntimeError."""
        name = f"CMRC: {self.title}" if title is None else arguments.text("title", title, "the title of the page")
        return self._core.page(name)

    @property
    def title(self) -> str:
        """The title of the run: its DSPs and duration."""
        settings = self.config.to_dict()
        dsps = int(settings["machine.dsps"])
        return f"{dsps} DSP{'' if dsps == 1 else 's'}, {settings['run.duration_s']:g} s"

    def snapshot(self) -> Snapshot:
        """The state of the run between two calls of ``run_until``: everything before ``time_s`` has happened
        (docs/snapshots.md).

        Raises RuntimeError inside a callback, and with ``profile``.
        """
        return self._core.snapshot()

    def restore(self, snapshot: Snapshot) -> None:
        """Sets the run to the state of ``snapshot``, from this run or another with the same configuration.

        Raises SnapshotError for a snapshot of another configuration, program or version; then nothing has changed.
        Raises RuntimeError with ``profile``, with ``keep_events``, and after ``record``: what they collect cannot be
        taken back.
        """
        self._require_way_back("restore")
        self._core.restore(arguments.instance("snapshot", snapshot, Snapshot, "what Simulation.snapshot() gives"))

    def debug(self) -> Debugger:
        """A debugger over all DSPs, forwards and backwards from here on (docs/debugger.md). Raises RuntimeError where
        ``restore`` does: also a stop that is ahead goes back."""
        self._require_way_back("debug")
        self._debugger = Debugger(self._core.debug())
        return self._debugger

    def _require_way_back(self, call: str) -> None:
        """Raises RuntimeError if something outside the state is collected."""
        collects = {
            "with profile=True": self._profiled,
            "with keep_events=True": self._keeps_events,
            "after record()": self._recorded,
        }
        for how, on in collects.items():
            if on:
                raise RuntimeError(f"{call}: not {how}: {_NO_WAY_BACK}")

    def fork(self) -> Simulation:
        """Another run with the same past. Later changes of one (``at``, ``dsp``) do not affect the other. It is neither
        recorded, nor does it keep events; raises RuntimeError with ``profile``. The files of its configuration are read
        again: from the same working folder, if their paths are relative."""
        return self._around(self._core.fork(), self.config)

    @classmethod
    def resume(cls, snapshot: Snapshot | str | os.PathLike[str]) -> Simulation:
        """A run that continues from a snapshot or its file, with the snapshot's configuration. Raises SnapshotError,
        OSError."""
        if not isinstance(snapshot, Snapshot):
            snapshot = read_snapshot(snapshot)
        config = _core.cmrc.config(toml=snapshot.configuration, name="snapshot")
        resumed = cls._around(_core.cmrc.Simulation(config), config)
        resumed.restore(snapshot)
        return resumed

    @classmethod
    def _around(cls, core: _core.cmrc.Simulation, config: _core.cmrc.Config) -> Simulation:
        made = cls.__new__(cls)
        made._core, made.config, made._profiled, made._keeps_events = core, config, False, False
        made._recorded, made._debugger = False, None
        return made

    def result(self) -> Result:
        """The report and the signals so far; ``under_way`` if the run has not ended."""
        profile = Profile(json.loads(self._core.profile_json()), self._core.profile_text()) if self._profiled else None
        report, text = self._core.report_json_and_text()
        return Result(json.loads(report), text, Table(self._core.signals()), profile, self._core.events_text())

    def tasks(self) -> dict[str, Any]:
        """The jobs so far, as in the report's ``tasks``: cheaper than ``result``."""
        tasks: dict[str, Any] = json.loads(self._core.tasks_json())
        return tasks

    def reference(self) -> Reference | None:
        """The ideal run against which this run was measured; None until the run has ended, and if ``report.reference``
        is "none"."""
        return self._core.reference()

    def dsp(self, slot: int) -> Dsp:
        """The DSP in a slot, between two calls of ``run_until``. Raises IndexError if there is no such slot."""
        return Dsp(
            self._core.dsp(arguments.whole("slot", slot, "the number of a slot", -(2**63), 2**63 - 1)), self.program
        )

    @cached_property
    def program(self) -> Program:
        """The program of every DSP, with its symbols and source lines."""
        return self._core.program

    def peek(self, offset: int) -> int:
        """The word at an offset of shared memory (``c40_programs/include/areas.inc``), between two calls of
        ``run_until``. Takes no time."""
        return int(
            self._core.peek(arguments.whole("offset", offset, "an offset in shared memory, 0 to FFFFh,", 0, 0xFFFF))
        )

    @property
    def time_s(self) -> float:
        """Virtual time, in s."""
        return float(self._core.time_s)

    @property
    def ended(self) -> bool:
        """The run has ended: its duration has passed, its job is done, or no drive of the crane works any more
        (docs/report.md, When a run ends early)."""
        return bool(self._core.ended)


@listed
def run(
    dsps: int | None = None,
    duration_s: float | None = None,
    *,
    config: Source | None = None,
    preset: str | None = None,
    settings: Mapping[str, Given] | None = None,
    events: Sequence[Mapping[str, Given]] = (),
    profile: bool = False,
    keep_events: bool = False,
    reference: Reference | None = None,
    on_progress: Progress | None = None,
    **keywords: Unpack[MoreSettings],
) -> Result:
    """Simulates the dock on ``dsps`` DSPs (default 4) for ``duration_s`` seconds (default 180). See ``Simulation``.

    ``**keywords``: each key of docs/configuration.md by the last part of its name, as ``idle_policy="spin"``; all of
    them with their values: ``cmrc.Simulation().config.to_dict()``."""
    given: dict[str, Any] = {"dsps": dsps, "duration_s": duration_s}
    all_keywords: Any = {**{name: value for name, value in given.items() if value is not None}, **keywords}
    return Simulation(
        config=config,
        preset=preset,
        settings=settings,
        events=events,
        profile=profile,
        keep_events=keep_events,
        reference=reference,
        **all_keywords,
    ).run(on_progress)
