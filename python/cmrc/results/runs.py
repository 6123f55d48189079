"""Many runs of the emulator, on all cores, with progress; results of earlier ones are kept and used again."""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from cmrc import files, signals
from cmrc.saved_result import checked_report
from cmrc.simulation import Reference, Setting, Simulation

LARGEST = 1 << 30
"""Bytes of the reports of one run that are kept."""
Report = dict[str, Any]
Reports = Sequence[Report]


@dataclass(frozen=True)
class FirstClaim:
    """Looks every ``step_s`` from ``from_s`` on whether the DSP has taken a block since; ``limit_s`` later it gives
    up."""

    dsp: int
    from_s: float
    step_s: float = 25e-6
    limit_s: float = 10e-3


@dataclass(frozen=True)
class Run:
    """One run: ``label`` says which row it makes, the rest is the configuration.

    Runs of one ``group`` (not empty) are measured against one ideal run, which they share: they may differ in DSPs,
    the speed of
    their cycles and events of the machine only. A run without a group has no ideal run, so its report has no errors
    and no rates.
    """

    label: Mapping[str, Setting]
    settings: Mapping[str, Setting]
    duration_s: float
    preset: str | None = None
    events: Sequence[Mapping[str, Setting]] = ()
    layout: str = ""
    """A layout file's text (dock.layout)."""
    stops_s: Sequence[float] = ()
    """Instants at which a report is made besides the end's."""
    first_claim: FirstClaim | None = None
    group: str = ""

    def key(self) -> str:
        """Names the run: the same configuration on the same emulator has the same key."""
        from cmrc.sweeps.identity import build

        return hashlib.sha256(json.dumps([asdict(self), build()], sort_keys=True).encode()).hexdigest()[:24]

    def all_settings(self, layout: str = "") -> dict[str, Setting]:
        """What is set beyond the preset, with the layout from a file at this path."""
        return {
            **self.settings,
            **({"dock.layout": layout} if layout else {}),
            "duration_s": self.duration_s,
            "report.reference": "ideal" if self.group else "none",
        }

    def cost(self) -> float:
        """Grows with the time that the run will take."""
        return self.duration_s * float(self.settings.get("servo_frequency_hz", 1000.0))


def execute(run: Run, reference: Reference | None) -> tuple[list[Report], Reference | None]:
    """The reports at the stops and at the end, that of the end with ``first_claim_s`` where asked for; and the run's
    ideal run, if it has one."""
    with tempfile.NamedTemporaryFile("w", suffix=".toml", encoding="utf-8") as layout:
        layout.write(run.layout)
        layout.flush()
        simulation = Simulation(
            preset=run.preset,
            settings=run.all_settings(layout.name if run.layout else ""),
            events=run.events,
            reference=reference,
        )
    reports: list[Report] = []
    claimed: float | None = None
    watch = run.first_claim
    for stop in sorted({*run.stops_s, *([watch.from_s] if watch else [])}):
        simulation.run_until(stop)
        if stop in run.stops_s:
            reports.append(simulation.result().report)
        if watch is not None and stop == watch.from_s:
            claimed = _first_claim(simulation, watch)
    report = simulation.run().report
    report["first_claim_s"] = claimed
    return [*reports, report], simulation.reference()


def _first_claim(simulation: Simulation, watch: FirstClaim) -> float | None:
    def claims() -> int:
        # Without the text and the signals of a Result: this is asked some hundred times.
        return int(json.loads(simulation._core.report_json())["dsps"][watch.dsp]["claims"])

    before = claims()
    for step in range(1, round(watch.limit_s / watch.step_s) + 1):
        simulation.run_until(watch.from_s + step * watch.step_s)
        if claims() > before:
            return step * watch.step_s
    return None


@dataclass
class Laboratory:
    """Runs what the claims ask for."""

    jobs: int = 2
    cache: Path | None = None
    progress: Callable[[str], None] = field(default=lambda text: print(text, end="", file=sys.stderr, flush=True))

    def all(self, runs: Sequence[Run], what: str) -> list[list[Report]]:
        """The reports of every run, in order; long ones are begun first. Raises ValueError for a cache that cannot be
        used."""
        if self.cache is not None:
            try:
                self.cache.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise ValueError(f"{self.cache}: no folder for a cache ({files.reason(error)})") from None
        results: dict[int, list[Report]] = {}
        for index, run in enumerate(runs):
            if (known := self._known(run)) is not None:
                results[index] = known
        due: dict[str, list[tuple[int, Run]]] = {}
        for index, run in enumerate(runs):
            if index not in results:
                due.setdefault(run.group or f"alone {index}", []).append((index, run))
        batches = sorted(due.values(), key=lambda batch: -sum(run.cost() for _, run in batch))
        count, started = sum(map(len, batches)), time.monotonic()
        for batch in self._execute(batches):
            for index, reports in batch:
                results[index] = reports
                self._keep(runs[index], reports)
            done = count - sum(1 for i in range(len(runs)) if i not in results)
            self.progress(f"\r{what}: {done} of {count} runs, {time.monotonic() - started:.0f} s ")
        if batches:
            self.progress("\n")
        return [results[i] for i in range(len(runs))]

    def _execute(self, batches: Sequence[Sequence[tuple[int, Run]]]) -> Iterable[list[tuple[int, list[Report]]]]:
        if self.jobs == 1 or len(batches) < 2:
            yield from map(_batch, batches)
            return
        with multiprocessing.Pool(min(self.jobs, len(batches)), signals.end_quietly) as pool:
            yield from pool.imap_unordered(_batch, batches)

    def _known(self, run: Run) -> list[Report] | None:
        file = None if self.cache is None else self.cache / f"{run.key()}.json"
        if file is None or not file.exists():
            return None
        try:
            reports = json.loads(files.read(file, LARGEST))
            if not isinstance(reports, list) or not reports:
                raise ValueError("there is no list of reports in it")
            return [checked_report(report) for report in reports]
        except (OSError, ValueError, RecursionError) as error:
            raise ValueError(
                f"{file}: cannot be used ({files.reason(error)}); what an earlier --cache wrote is expected, or no file"
            ) from None

    def _keep(self, run: Run, reports: list[Report]) -> None:
        if self.cache is not None:
            files.write(self.cache / f"{run.key()}.json", json.dumps(reports))


def _batch(batch: Sequence[tuple[int, Run]]) -> list[tuple[int, list[Report]]]:
    """Runs of one group, one after the other, so that they share their ideal run."""
    reference: Reference | None = None
    done = []
    for index, run in batch:
        reports, its = execute(run, reference)
        reference = reference or its
        done.append((index, reports))
    return done
