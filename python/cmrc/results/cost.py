"""Claim 7: what missed deadlines cost. Not the paper's: it takes for granted that they cost something."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import cycle
from typing import TYPE_CHECKING, Any

from cmrc.loops.model import JOINTS, Loop, margins
from cmrc.results.claim import Claim, parameter
from cmrc.results.dsps import RELEASES
from cmrc.results.judgement import Row, Verdict, markdown, missed_share, of
from cmrc.results.learning import SLOW
from cmrc.results.runs import Report, Reports, Run
from cmrc.simulation import Setting

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CAPTURE_MM = 150.0  # what the guides catch of a load that is beside its place (dock.capture_window_m)
LATE_S = 0.1  # a lag above it is time lost
SCATTERED, RUNS = "scattered misses", "misses in runs of {}"
HALF, SINGLE, UNTIMED = "gaps of half the time", "single samples between gaps", "the same, no time-out of drives"
JOB = "whole job"
ONE_DSP: dict[str, Setting] = {"report.misses_max": 1000000, "machine.dsps": 1}
# By how much one unit of each joint moves the spreader at the jib's full reach, m (docs/report.md, Control cost).
LEVERS = {"s": 1.0, "psi": 34.5, "phi": 32.0, "l": 1.0, "kappa": 6.1}


@dataclass(frozen=True)
class Cost(Claim):
    """Left-out and late samples in many ways, each against the ideal run; and whole jobs with gaps."""

    NUMBER, NAME = 7, "cost"
    TITLE = "Missed deadlines cost the robot accuracy and time"

    PART = "family"

    duration_s: float = parameter(
        5.0, "length of every run but those of a whole job, s; the crane moves from 0.03 s on", quick=0.06
    )
    few_dsps: tuple[int, ...] = parameter(
        (1, 2, 3, 4, 5),
        "few DSPs: numbers of DSPs under the load of preset saturated, released together and staggered",
        quick=(1,),
    )
    cycle_factors: tuple[float, ...] = parameter(
        (1.0, 8.0, 10.0, 11.0, 12.0, 13.5, 15.0, 18.0, 22.0),
        "slow clocks: values of machine.cycle_time_factor, 1 DSP at base load",
        quick=(1.0, 30.0),
    )
    half_gaps_ms: tuple[int, ...] = parameter(
        (1, 3, 10, 20, 40, 60, 80, 95),
        "gaps of half the time: the host pauses for so many samples, and works as long",
        quick=(10,),
        least=1,
    )
    single_gaps_ms: tuple[int, ...] = parameter(
        (3, 9, 19, 49, 95),
        "single samples: the host pauses for so many samples, and works for one",
        quick=(3,),
        least=1,
    )
    untimed_gaps_ms: tuple[int, ...] = parameter(
        (120, 200, 400),
        "gaps of half the time that are longer, with dock.drive_timeout_ms = 0, so that no drive brakes within one",
        quick=(),
        least=1,
    )
    presets: tuple[str, ...] = parameter(("base", "tight"), "left-out ticks: presets, whose loops differ")
    left_out: tuple[float, ...] = parameter(
        (0.1, 0.3, 0.5, 0.7, 0.8),
        "left-out ticks: shares of the servo's ticks that are not served",
        quick=(0.3,),
        least=0,
    )
    left_out_runs: tuple[int, ...] = parameter((1, 5), "left-out ticks: so many in a row; 1 scatters them", quick=(1,))
    failures: int = parameter(4, "failures: the only DSP hangs so many times at random instants", quick=1)
    seed: int = parameter(1, "draws those instants")
    job_gaps: tuple[int, ...] = parameter(
        (2, 8), "whole job: the host pauses for so many samples (of 8 ms), and works as long", quick=(1,), least=1
    )
    job_limit_s: float = parameter(400.0, "whole job: latest end, s; 0 leaves the whole job out", quick=0.1, least=0)

    def runs(self) -> list[Run]:
        return [
            *self.few_dsps_loaded(),
            *(self.run("slow clocks", f"cycles × {f:g}", {"machine.cycle_time_factor": f}) for f in self.cycle_factors),
            *self.host_paused(),
            *self.ticks_left_out(),
            *self.dsps_failing(),
            *(self.whole_jobs() if self.job_limit_s else ()),
        ]

    def run(
        self, family: str, name: str, settings: Mapping[str, Setting] | None = None, group: str = "base", **more: Any
    ) -> Run:
        """Where the settings say no more, 1 DSP at base load."""
        fields = {"duration_s": self.duration_s, **more}
        return Run({"family": family, "name": name}, {**ONE_DSP, **(settings or {})}, group=f"cost {group}", **fields)

    def few_dsps_loaded(self) -> list[Run]:
        return [
            self.run(
                f"few DSPs, {release}",
                f"{n} DSP{'s' if n > 1 else ''}",
                {"machine.dsps": n, **RELEASES[release]},
                release,
                preset="saturated",
            )
            for release in ("together", "staggered")
            for n in self.few_dsps
        ]

    def host_paused(self) -> list[Run]:
        s, untimed = self.duration_s, {"dock.drive_timeout_ms": 0.0}
        return [
            *(self.run(HALF, f"{n} ms", events=pauses(n, n, s)) for n in self.half_gaps_ms),
            *(self.run(SINGLE, f"{n} ms", events=pauses(n, 1, s)) for n in self.single_gaps_ms),
            *(self.run(UNTIMED, f"{n} ms", untimed, "untimed", events=pauses(n, n, s)) for n in self.untimed_gaps_ms),
        ]

    def ticks_left_out(self) -> list[Run]:
        return [
            Run(
                {
                    "family": f"{SCATTERED if length == 1 else RUNS.format(length)}, {preset}",
                    "name": f"{100 * share:g} %",
                    "preset": preset,
                },
                {**ONE_DSP, "scheduling.servo_loss_share": share, "scheduling.servo_loss_run": length},
                self.duration_s,
                preset=preset,
                group=f"cost {preset}",
            )
            for preset in self.presets
            for length in self.left_out_runs
            for share in self.left_out
        ]

    def dsps_failing(self) -> list[Run]:
        draw = random.Random(self.seed)
        begin, end, middle = self.duration_s / 6, self.duration_s * 0.9, self.duration_s / 2
        instants = sorted(round(draw.uniform(begin, end), 9) for _ in range(self.failures))
        hangs: list[dict[str, Setting]] = [{"at_s": at, "action": "hang", "dsp": 0} for at in instants]
        fails: list[dict[str, Setting]] = [{"at_s": middle, "action": "fail", "dsp": 0}]
        return [
            self.run("failures", f"the only DSP hangs {self.failures} times", events=hangs),
            self.run("failures", "1 of 2 DSPs fails", {"machine.dsps": 2}, events=fails),
            self.run("failures", "the only DSP fails", events=fails),
        ]

    def whole_jobs(self) -> list[Run]:
        return [
            self.run(
                JOB,
                f"gaps of {8 * n} ms" if n else "no gaps",
                {**SLOW, "dock.containers": 1, "run.until": "job_done"},
                "job",
                events=pauses(n, n, self.job_limit_s, 8e-3) if n else [],
                duration_s=self.job_limit_s,
            )
            for n in (0, *self.job_gaps)
        ]

    def rows(self, done: Sequence[tuple[Run, Reports]]) -> list[Row]:
        table = []
        for run, reports in done:
            report = reports[-1]
            errors = report["errors"]
            period_ms = 1e3 / report["configuration"]["rates.servo_frequency_hz"]
            joints = errors["joints"]
            table.append(
                {
                    **run.label,
                    "f_p": missed_share(report, "f_p"),
                    "f_t": missed_share(report, "f_t"),
                    "gap_ms": longest_gap(report) * period_ms,
                    "load_mm": 1e3 * errors["load_m"]["rms"],
                    "peak_mm": 1e3 * errors["load_m"]["peak"],
                    "path_mm": 1e3
                    * math.sqrt(sum((LEVERS[joint] * joints[joint]["path"]["rms"]) ** 2 for joint in joints)),
                    "lag_s": errors["lag"].get("crane", {}).get("end_s"),
                    "sway_mrad": 1e3 * max(errors["sway"][angle]["peak"] for angle in errors["sway"]),
                    "makespan_s": report["makespan_s"],
                    "landings_missed": sum(c["landings_missed"] for c in report["cycles"]),
                    "margins": margins_ms(report["configuration"]),
                    "unstable": unstable(report),
                    "errors": handled(report),
                    "stop": report["stop_reason"],
                }
            )
        return table

    def verdict(self, all_rows: Sequence[Row]) -> Verdict:
        moving = [row for row in all_rows if row["family"] != JOB and row["stop"] == "completed"]
        losing = [row for row in moving if (row["f_p"] or 0) > 5]
        if not losing:
            return Verdict("not tested", "In no run more than 5 % of the samples were missed.", "")
        # Gaps far below every delay margin, and planning that keeps up.
        of_base = usual_loops(losing)
        short = [row for row in of_base if row["gap_ms"] <= 20 and (row["f_t"] or 0) < 1]
        late = max(losing, key=lambda row: float(row["lag_s"] or 0))
        costly = behind(late)
        inaccurate = any(row["path_mm"] > CAPTURE_MM for row in losing)
        return Verdict(
            "holds" if costly and inaccurate else "holds in part" if costly or inaccurate else "fails",
            accuracy(short) + self.time(late) + tight_loops(losing),
            f"{shares(short, moving)} {self.job_times(all_rows)}".strip(),
        )

    def time(self, late: Row) -> str:
        if not behind(late):
            lag = "not measured" if late["lag_s"] is None else f"{late['lag_s']:.3g} s"
            return (
                f"Time: no. No crane is more than {LATE_S:g} s late after {self.duration_s:g} s; the longest lag "
                f"({late['family']}, {late['name']}) is {lag}."
            )
        return (
            "Time: yes. Where planning starves too, the crane is late: at worst "
            f"({late['family']}, {late['name']}) {late['f_t'] or 0:.0f} % of f_t are missed, the crane lags by "
            f"{late['lag_s']:.2f} s after {self.duration_s:g} s and its load is {late['load_mm']:.0f} mm (RMS) from "
            "where it should be."
        )

    def job_times(self, all_rows: Sequence[Row]) -> str:
        jobs = of(all_rows, family=JOB)
        if len(jobs) < 2 or not any(row["makespan_s"] for row in jobs):
            return ""
        texts = []
        for row in jobs:
            time = f"{row['makespan_s']:.0f} s" if row["makespan_s"] else f"not done by {self.job_limit_s:g} s"
            landings = f"{row['landings_missed']} missed landing{'' if row['landings_missed'] == 1 else 's'}"
            texts.append(f"{time} and {landings} ({row['name']}{'' if row['errors'] == '–' else '; ' + row['errors']})")
        return f"Whole job, makespan and missed landings: {', '.join(texts)}."

    def section(self, all_rows: Sequence[Row]) -> str:
        columns = {
            "family": "how", "name": "", "f_p": "f_p missed, %", "f_t": "f_t missed, %", "gap_ms": "longest gap, ms",
            "load_mm": "load error RMS, mm", "peak_mm": "peak, mm",
            "path_mm": "joints off their path, mm", "lag_s": "lag at the end, s", "sway_mrad": "sway error peak, mrad",
            "errors": "errors handled", "stop": "run ended",
        }  # fmt: skip
        moving = [row for row in all_rows if row["family"] != JOB]
        tight = of(moving, preset="tight")
        also = f"; with preset `tight` {margins_of(tight)['other joints']:.1f} ms" if tight else ""
        text = (
            f"{self.duration_s:g} s of the crane's first leg, from power-on; nothing is left out. Everything is "
            "measured against the ideal run ([report.md](report.md), Errors). *Longest gap*: most samples of PID in a "
            "row that never came (where all come late, as with slow clocks, it stays short). *Load error*: distance "
            "from the ideal run's load at the same instant. *Joints off their path*: the same of the joints with the "
            "lag taken out, RMS, each joint by how far it moves the load. Delay margins by the loop's formula "
            f"([control.md](control.md)): {margins_said(usual_loops(moving))}{also}. A "
            "gap of the host holds up planning, too; so these rows miss f_t. Left-out ticks "
            "(`scheduling.servo_loss_share`) are the servo's alone. A slower clock can do better than a faster one: "
            "scheduling without preemption has such anomalies. Where the crane hardly moves, the lag is all of its "
            "error, and the joints are near their path. Runs of one seed: only the instants of failures are drawn.\n\n"
        )
        text += markdown(columns, moving)
        if jobs := of(all_rows, family=JOB):
            refresh_hz, servo_hz = SLOW["refresh_frequency_hz"], SLOW["servo_frequency_hz"]
            columns = {
                "name": JOB, "f_p": "f_p missed, %", "f_t": "f_t missed, %", "gap_ms": "longest gap, ms",
                "makespan_s": "makespan, s", "landings_missed": "landings missed", "errors": "errors handled",
                "lag_s": "lag, s", "load_mm": "load error RMS, mm", "stop": "run ended",
            }  # fmt: skip
            text += (
                f"\n**Whole job.** One container, from the first refresh to home, at slow rates (f_s {refresh_hz:g} Hz, "
                f"f_p {servo_hz:g} Hz) and with loops for such rates (delay margins: {margins_said(jobs)}). The "
                "host pauses again and again, so that as many samples are lost as can be served between two pauses.\n\n"
                + markdown(columns, jobs)
            )
        return text

    def draw(self, all_rows: Sequence[Row], figure: Figure) -> None:
        figure.set_size_inches(8, 6.8)
        grid = figure.subplots(2, 2, sharex="col")
        families = [family for family in dict.fromkeys(row["family"] for row in all_rows) if family != JOB]
        for family, mark in zip(families, cycle(("o", "s", "^", "v", "D", "P", "*"))):
            own = [row for row in of(all_rows, family=family) if row["f_p"] is not None]
            for line, key in enumerate(("load_mm", "path_mm")):
                error = [row[key] for row in own]
                label = family if line == 0 else None
                grid[line][0].plot([row["f_p"] for row in own], error, mark, label=label, markersize=5, alpha=0.8)
                grid[line][1].plot([max(row["gap_ms"], 0.5) for row in own], error, mark, markersize=5, alpha=0.8)
        for line, name in enumerate(("load error RMS, mm", "joints off their path, mm")):
            grid[line][0].set(ylabel=name, yscale="log")
            grid[line][1].set(yscale="log", xscale="log")
            own = usual_loops([row for row in all_rows if row["family"] != JOB])
            for (joint, ms), style in zip(margins_of(own).items(), cycle((":", "--"))):
                label = f"delay margin, {joint}" if line == 0 else None
                grid[line][1].axvline(ms, color="0.5", linestyle=style, linewidth=1, label=label)
        grid[1][0].set(xlabel="f_p missed, %")
        grid[1][1].set(xlabel="longest run of lost samples, ms (0 at 0.5)")
        figure.legend(loc="outside upper center", ncols=4, fontsize=7)


def pauses(gap: int, served: int, duration_s: float, period_s: float = 1e-3) -> list[dict[str, Setting]]:
    """The host pauses again and again, from the third tick of the servo on: each time ``gap`` samples are lost and
    ``served`` are not. A pause begins between two ticks and ends so late that the sample before its end cannot be in
    time."""
    first, every = 0.02 + 2.4 * period_s, (gap + served) * period_s
    return [
        {
            "at_s": round(first + n * every, 9),
            "action": "pause_host",
            "lasts_ms": round(1e3 * period_s * (gap + 0.55), 6),
        }
        for n in range(max(0, int((duration_s - first - gap * period_s) / every)))
    ]


def behind(row: Row) -> bool:
    """Whether the missed deadlines of a run have cost time."""
    return row["lag_s"] is not None and row["lag_s"] > LATE_S


def usual_loops(rows: Sequence[Row]) -> list[Row]:
    """Rows of runs with the default gains."""
    return [row for row in rows if row.get("preset", "base") == "base"]


def accuracy(short: Sequence[Row]) -> str:
    if not short:
        return ""
    own = ", ".join(f"{ms:.0f} ms ({joint})" for joint, ms in margins_of(short).items())
    return (
        f"Accuracy: the default gains hardly feel it. In {len(short)} runs {min(row['f_p'] for row in short):.0f} to "
        f"{max(row['f_p'] for row in short):.0f} % of the samples come late or never and up to "
        f"{max(row['gap_ms'] for row in short):.0f} ms of them in a row are lost, but planning keeps up (f_t missed: "
        f"less than 1 %): the load is at most {max(row['load_mm'] for row in short):.1f} mm (RMS) from the ideal "
        f"run's. The loops' delay margins are {own}. "
    )


def tight_loops(losing: Sequence[Row]) -> str:
    tight = of(losing, preset="tight")
    text = ""
    for family in dict.fromkeys(row["family"] for row in tight):
        texts = [
            f"{row['f_p']:.0f} % missed {row['path_mm']:.3g} mm"
            + (f" (unstable: {row['unstable']})" if row["unstable"] != "–" else "")
            for row in of(tight, family=family)
        ]
        text += (
            f" With preset `tight` ({margins_of(tight)['other joints']:.1f} ms of delay margin) and "
            f"{family.removesuffix(', tight')} the joints are so far off their path: {', '.join(texts)}."
        )
    return text


def shares(short: Sequence[Row], moving: Sequence[Row]) -> str:
    bursts = [row for row in moving if row["gap_ms"] > 40 and 1 < (row["f_p"] or 0) < 60]
    if not short or not bursts:
        return ""
    many, few = max(short, key=lambda row: float(row["f_p"])), min(bursts, key=lambda row: float(row["f_p"]))
    return (
        f"The share of misses alone says little: {many['f_p']:.0f} % missed with gaps of {many['gap_ms']:.0f} ms leave "
        f"the joints {many['path_mm']:.2g} mm off their path, {few['f_p']:.0f} % with gaps of {few['gap_ms']:.0f} ms "
        f"{few['path_mm']:.2g} mm."
    )


def longest_gap(report: Report) -> int:
    """Most samples of PID in a row that never came (a late one came): dropped ticks, and what was lost or never
    started."""
    lost = sorted(m["number"] for m in report["misses"] if m["kind"] == "pid" and m["outcome"] != "late")
    longest = length = 0
    for number, before in zip(lost, [None, *lost], strict=False):
        length = length + 1 if before is not None and number == before + 1 else 1
        longest = max(longest, length)
    return longest


def handled(report: Report) -> str:
    """What the controller noticed as an error, and what it did: ``2 × drive time-out: retry``."""
    said = [f"{error['origin']}: {error['response'] or 'no decision'}" for error in report["errors_handled"]]
    return ", ".join(f"{said.count(one)} × {one}" for one in dict.fromkeys(said)) or "–"


def unstable(report: Report) -> str:
    """The joints whose loops the report calls unstable."""
    said = [f["message"] for f in report["failures"] if f["kind"] == "unstable"]
    return ", ".join(dict.fromkeys(message.split()[4] for message in said)) or "–"


def margins_ms(configuration: Mapping[str, Any]) -> dict[str, float]:
    """Delay margins of a run's loops, ms: joints whose loops differ from the most by their names, then "other
    joints"."""
    by_joint = {joint: _margin_ms(loop_of(configuration, joint)) for joint in JOINTS}
    common = max(by_joint.values(), key=list(by_joint.values()).count)
    return {**{joint: ms for joint, ms in by_joint.items() if ms != common}, "other joints": common}


def loop_of(configuration: Mapping[str, Any], joint: str) -> Loop:
    """A joint's loop in a run with the slewing crane."""

    def of(setting: str) -> float:
        return float(configuration[f"control.{joint}_{setting}"])

    lag = configuration[f"slewing.{'rotate' if joint == 'rotator' else joint}.torque_lag_s"]
    return Loop(
        of("bandwidth_rad_s"),
        of("damping"),
        of("integral_time_s"),
        of("derivative_filter"),
        1 / configuration["rates.servo_frequency_hz"],
        float(lag),
    )


@cache
def _margin_ms(loop: Loop) -> float:
    return margins(loop).delay_ms


def margins_of(rows: Sequence[Row]) -> dict[str, float]:
    """Those of runs that share their loops."""
    first: dict[str, float] = rows[0]["margins"] if rows else {}
    return first


def margins_said(rows: Sequence[Row]) -> str:
    """``travel 105.2 ms, other joints 10.0 ms``"""
    return ", ".join(f"{joint} {ms:.1f} ms" for joint, ms in margins_of(rows).items())
