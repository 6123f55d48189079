"""Studies of several runs of one configuration: how far it is from its first missed deadline, and what delays cost."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from cmrc import _core, arguments
from cmrc.keywords import listed
from cmrc.limit_scans import Scans
from cmrc.simulation import Given, Progress, Source, configured, layered
from cmrc.table import Table

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from cmrc._settings import LimitsSettings, Settings


class Limits:
    """The outcome of ``limits`` (docs/report.md, Limits)."""

    def __init__(self, text: str, found: Mapping[str, Any]) -> None:
        self.text = text
        """The text on the terminal."""
        self.report: dict[str, Any] = dict(found)
        """The JSON of ``cmrc limits --json``."""

    def limit(self, scan: str) -> float | None:
        """The limit of ``"cycles"``, ``"dsps"`` or ``"servo"``; None if the easiest allowed point misses. KeyError if
        it was not scanned."""
        scans = self.report["scans"]
        if not isinstance(scan, str) or scan not in scans:
            raise KeyError(f"scan: {scan!r} was not scanned; one of {', '.join(scans)} is expected")
        value = scans[scan]["limit"]
        return None if value is None else float(value)

    @property
    def points(self) -> Table:
        """One row per run: its scan, value, whether it passed, and its first miss."""
        return Table.from_rows(
            {"scan": name, **point} for name, scan in self.report["scans"].items() for point in scan["points"]
        )

    def __repr__(self) -> str:
        return f"<cmrc.Limits: {', '.join(f'{name} {self.limit(name)}' for name in self.report['scans'])}>"


class Comparison:
    """The outcome of ``compare``: a run and the same run with instant execution (docs/report.md, Ideal)."""

    def __init__(self, text: str, found: Mapping[str, Any]) -> None:
        self.text = text
        """The text on the terminal."""
        self.report: dict[str, Any] = dict(found)
        """The JSON of ``emulator compare --json``."""

    @property
    def metrics(self) -> Table:
        """One row per metric: ``unit``, ``run``, ``ideal``, ``difference``."""
        return Table.from_rows({"metric": name, **row} for name, row in self.report["metrics"].items())

    def __getitem__(self, metric: str) -> dict[str, Any]:
        return dict(self.report["metrics"][metric])

    def __contains__(self, metric: object) -> bool:
        return metric in self.report["metrics"]

    def __iter__(self) -> Iterator[str]:
        """The metrics' names."""
        return iter(self.report["metrics"])

    def __repr__(self) -> str:
        return f"<cmrc.Comparison: {len(self.report['metrics'])} metrics over {self.report['duration_s']} s>"


def _grid(name: str, values: Iterable[float] | None) -> list[float] | None:
    if values is None:
        return None
    return [
        arguments.number(f"{name}[{n}]", value, least=-math.inf)
        for n, value in enumerate(arguments.items(name, values, "a list of numbers"))
    ]


@listed
def limits(
    *,
    cycles: Iterable[float] | None = None,
    dsps: Iterable[float] | None = None,
    servo: Iterable[float] | None = None,
    errors: bool = False,
    config: Source | None = None,
    preset: str | None = None,
    settings: Mapping[str, Given] | None = None,
    events: Sequence[Mapping[str, Given]] = (),
    on_progress: Callable[[int, int], object] | None = None,
    **keywords: Unpack[LimitsSettings],
) -> Limits:
    """Scans for the first missed deadline. Each point is a run; as many run at a time as there are processors.

    ``cycles`` are factors on the time of an instruction cycle (the buses' clocks do not change), ``dsps`` numbers of
    DSPs, ``servo`` frequencies f_p in Hz. A scan that is None is not made; if all three are None, each has its standard
    grid. With ``errors`` every point runs to its end and gives its errors against the ideal run (realised f_p and f_t,
    load error, lag); without, a point stops at its first miss. The other arguments are those of ``run``;
    ``settings={"machine.dsps": 2}`` is the configuration's own number of DSPs. ``on_progress(done, points)`` is called
    at the start and after every run. Raises ConfigError for an empty grid or a value given twice; a point with an
    invalid configuration is reported as refused, not raised.
    """
    arguments.function("on_progress", on_progress, "a function of (done, points) or None")
    made = layered(config, preset, settings, events, keywords)
    scans = scans_of(made, cycles, dsps, servo, errors)
    scans.run(on_progress)
    return Limits(scans.text(), scans.report())


def scans_of(
    layers: _core.cmrc.ConfigLayers,
    cycles: Iterable[float] | None,
    dsps: Iterable[float] | None,
    servo: Iterable[float] | None,
    errors: bool,
) -> Scans:
    """The scans that ``limits`` makes."""
    grids = _grid("cycles", cycles), _grid("dsps", dsps), _grid("servo", servo)
    return Scans(layers, *grids, errors=arguments.flag("errors", errors))


@listed
def compare(
    *,
    config: Source | None = None,
    preset: str | None = None,
    settings: Mapping[str, Given] | None = None,
    events: Sequence[Mapping[str, Given]] = (),
    on_progress: Progress | None = None,
    **keywords: Unpack[Settings],
) -> Comparison:
    """The run beside the same run with instant execution (``run.ideal``), both at the same time. Arguments as of
    ``run``."""
    return compared(configured(config, preset, settings, events, keywords), on_progress)


def compared(config: _core.cmrc.Config, on_progress: Progress | None = None) -> Comparison:
    text, found = _core.why_late.compare(config, on_progress)
    return Comparison(text, json.loads(found))
