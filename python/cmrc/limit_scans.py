"""Scans for the first missed deadline (docs/report.md, Limits): how much longer instructions could take, how few DSPs
would be enough, how fast the servo could be."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from cmrc import _core
from cmrc.floats import shortest
from cmrc.processes import Helpers, processors

CYCLES, DSPS, SERVO = "cycles", "dsps", "servo"
NOT_RUN: Mapping[str, Any] = {
    "ran": False,
    "passed": False,
    "refused": None,
    "judged": False,
    "stop_reason": None,
    "first_miss": None,
    "first_miss_s": None,
    "starved_intervals": 0,
    "errors": None,
}
"""Of a point beside its ``value`` and the ``realised`` value."""
Point = dict[str, Any]


@dataclass
class Scan:
    """One scanned quantity; the others are as configured."""

    name: str
    key: str
    meaning: str
    more_is_harder: bool
    """The limit is the largest value below which all points pass; else the smallest value above which all pass."""
    points: list[Point] = field(default_factory=list)
    """By rising value."""

    def limit(self) -> float | None:
        """The last value such that it and every allowed point on its easy side pass."""
        found = None
        for point in self._by_ease():
            if not (point["ran"] and point["passed"]):
                break
            found = point["value"]
        return found

    def beyond(self) -> list[float]:
        """Points that pass beyond one that does not: scheduling without preemption has anomalies."""
        values, failed = [], False
        for point in self._by_ease():
            if not point["ran"]:
                continue
            if not point["passed"]:
                failed = True
            elif failed:
                values.append(point["value"])
        return values

    def text(self) -> str:
        lines = [f"\n{self.meaning} ({self.key})"]
        width = max((9, *(len(shortest(point["value"])) for point in self.points)))
        lines += [f"  {_value(point):>{width}}  {_outcome(point)}{_cost(point)}" for point in self.points]
        limit, points = self.limit(), self._by_ease()
        if limit is not None:
            at = next(point for point in points if point["value"] == limit)
            which = "every allowed point" if self._refused_before(limit) else "every point"
            lines.append(f"  limit: {_value(at)}; {which} {'up to it' if self.more_is_harder else 'from it on'} passes")
        elif not points or points[0]["ran"]:
            lines.append("  no limit: the easiest point does not pass")
        else:
            lines.append("  no limit known: the easiest point has not been run")
        if beyond := self.beyond():
            lines.append(f"  anomalies, passing beyond a miss: {', '.join(map(shortest, beyond))}")
        return "\n".join(lines) + "\n"

    def report(self) -> dict[str, Any]:
        return {
            "key": self.key,
            "meaning": self.meaning,
            "limit": self.limit(),
            "passing_beyond": self.beyond(),
            "points": [dict(point) for point in self.points],
        }

    def _refused_before(self, limit: float) -> bool:
        """A point on the easy side of the limit was not allowed."""
        values = [point["value"] for point in self.points if point["refused"] is not None]
        return any(value < limit if self.more_is_harder else value > limit for value in values)

    def _by_ease(self) -> list[Point]:
        """The allowed points, the easiest first."""
        points = [point for point in self.points if point["refused"] is None]
        return points if self.more_is_harder else points[::-1]


@dataclass
class _Job:
    point: Point
    toml: str
    group: str
    """Points of one group may share one ideal run."""


class Scans:
    """Scans of one configuration. A grid that is None is not scanned; if all are None, each has its standard grid.

    Raises ConfigError for an empty grid or a value given twice. A point without a valid configuration is refused.
    """

    def __init__(
        self,
        layers: _core.cmrc.ConfigLayers,
        cycles: Sequence[float] | None,
        dsps: Sequence[float] | None,
        servo: Sequence[float] | None,
        errors: bool,
    ) -> None:
        config = layers.config()
        self.errors = errors
        self.duration_s = float(config.to_dict()["run.duration_s"])
        self.interrupted = False
        self._layers = layers
        self._jobs: list[_Job] = []
        if cycles is None and dsps is None and servo is None:
            cycles, dsps, servo = standard(config)
        self.scans = [
            self._scan(Scan(name, key, meaning, harder), grid)
            for name, key, meaning, harder, grid in (
                (
                    CYCLES,
                    "machine.cycle_time_factor",
                    "Time of an instruction cycle, the buses as they are",
                    True,
                    cycles,
                ),
                (DSPS, "machine.dsps", "Number of DSPs", False, dsps),
                (SERVO, "rates.servo_frequency_hz", "Servo frequency f_p in Hz", True, servo),
            )
            if grid
        ]
        if not self.scans:
            raise _core.cmrc.ConfigError(
                "limits: every grid is empty; at least one value of cycles, dsps or servo is expected"
            )

    def _scan(self, scan: Scan, grid: Iterable[float]) -> Scan:
        values = sorted(grid)
        if len(set(values)) < len(values):
            raise _core.cmrc.ConfigError(f"limits: the grid of {scan.name} has a value twice; each is run once")
        for value in values:
            point: Point = {"value": value, "realised": None, **NOT_RUN}
            scan.points.append(point)
            whole = scan.name == DSPS and float(value).is_integer()
            try:
                config = self._layers.config({scan.key: int(value) if whole else value})
            except _core.cmrc.ConfigError as error:
                point["refused"] = str(error)
                continue
            point["realised"] = _realised(scan.name, value, config)
            group = _core.cmrc.reference_key(config) if self.errors else ""
            self._jobs.append(_Job(point, config.to_toml(), group))
        return scan

    def run(self, on_progress: Callable[[int, int], object] | None = None) -> None:
        """Runs every point to its first miss, with ``errors`` to its end, as many at a time as there are processors.
        ``on_progress(done, points)`` is called at the start, and after every run. An early end (Ctrl-C) keeps the
        finished points. Raises RuntimeError if a run fails."""
        jobs = sorted(self._jobs, key=lambda job: job.group)
        self.interrupted = bool(jobs)
        if on_progress is not None:
            on_progress(0, len(jobs))
        with Helpers("cmrc.limit_worker", min(len(jobs), processors())) as helpers:
            asked = [{"toml": job.toml, "to_its_end": self.errors} for job in jobs]
            for done, (number, answer) in enumerate(helpers.answers(asked), 1):
                if "failed" in answer:
                    raise RuntimeError(answer["failed"])
                jobs[number].point.update(answer)
                if on_progress is not None:
                    on_progress(done, len(jobs))
        self.interrupted = False

    def text(self) -> str:
        """As the terminal shows it."""
        head = f"Limits, {self.duration_s:g} s simulated for each point{'; interrupted' if self.interrupted else ''}\n"
        return head + "".join(scan.text() for scan in self.scans)

    def report(self) -> dict[str, Any]:
        """As the JSON has it."""
        return {
            "duration_s": self.duration_s,
            "stop_reason": "interrupted" if self.interrupted else "completed",
            "scans": {scan.name: scan.report() for scan in self.scans},
        }


def standard(config: _core.cmrc.Config) -> tuple[list[float], list[float], list[float]]:
    """Factors 1 to 3 in quarters, 1 DSP to 8, and every possible servo frequency from half the configured one on: f_s /
    N for integers N of at least 2."""
    refreshes = float(config.to_dict()["rates.refresh_frequency_hz"])
    servo = config.intervals()["N_p"]
    return (
        [quarters / 4 for quarters in range(4, 13)],
        [float(dsps) for dsps in range(1, 9)],
        [refreshes / interval for interval in range(2 * servo, 1, -1)],
    )


def _realised(scan: str, value: float, config: _core.cmrc.Config) -> float:
    """The value that runs: a rate is the refresh rate divided by a whole number."""
    if scan != SERVO:
        return value
    return float(config.to_dict()["rates.refresh_frequency_hz"]) / config.intervals()["N_p"]


def _value(point: Point) -> str:
    value, realised = point["value"], point["realised"]
    same = realised is None or math.isclose(value, realised, rel_tol=1e-12)
    return shortest(value) if same else f"{shortest(value)} (runs at {shortest(realised)})"


def _outcome(point: Point) -> str:
    if point["refused"] is not None:
        return f"not run: {point['refused']}"
    if not point["ran"]:
        return "not run: interrupted"
    if point["passed"]:
        return "no miss"
    if point["first_miss"] is not None:
        return f"{point['first_miss']} missed at {point['first_miss_s']:.6f} s"
    if not point["judged"]:
        return "no job was finished, and none missed"
    if starved := point["starved_intervals"]:
        return f"starved: {starved} point interval{'' if starved == 1 else 's'} without a new point"
    return str(point["stop_reason"])


def _cost(point: Point) -> str:
    cost = point["errors"]
    if cost is None:
        return ""
    text = ""
    for rate in ("f_p", "f_t"):
        hertz, missed = cost[f"{rate}_realised_hz"], cost[f"{rate}_missed_share"]
        if hertz is not None:
            text += f"; {rate} {hertz:.4g} Hz, {_percent(missed or 0.0)} % missed"
    lag = "" if cost["lag_s"] is None else f", lag {cost['lag_s']:.3g} s"
    return text + f"; load error {cost['load_rms_m']:.4g} m RMS{lag}"


def _percent(share: float) -> str:
    return "0" if share <= 0 else "<0.1" if 100 * share < 0.05 else f"{100 * share:.1f}"
