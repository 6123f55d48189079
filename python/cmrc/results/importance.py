"""Claim 4: the importance rule keeps 3 and 4 at f_p while 1 and 2 fill the gaps; a keeps the AGV's planning from
starving."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from cmrc.keywords import settings
from cmrc.results.claim import Claim, parameter
from cmrc.results.dsps import rates, whole_refreshes
from cmrc.results.ends import behind_identify
from cmrc.results.judgement import PLANNING, SERVO, Row, Verdict, counted, markdown, measured, missed_share, of
from cmrc.results.runs import Reports, Run
from cmrc.simulation import Setting

if TYPE_CHECKING:
    from matplotlib.figure import Figure

AGV = PLANNING[2:]
Q = 0x3C00
CROWDED_RATIO = 4


@dataclass(frozen=True)
class Importance(Claim):
    """One crowded DSP: the gaps that f_s leaves at f_p, and the crane's planning at f_p against the AGVs'."""

    NUMBER, NAME = 4, "importance"
    TITLE = (
        "The importance rule keeps 3 and 4 at f_p while 1 and 2 fill the gaps; a keeps the AGV's planning from starving"
    )

    PART = "part"
    PARTS: ClassVar = {"gaps": "f_s", "starving": "The crane's planning at f_p"}
    LABELS: ClassVar = {
        "equation": "equation (7) {}", "ratio": "f_s = {} f_p", "servo_hz": "f_p = f_t = {} Hz", "a": "a = {}",
    }  # fmt: skip

    equations: tuple[str, ...] = parameter(("restored", "as_printed"), "values of scheduling.equation")
    servo_hz: float = parameter(4000.0, "f_p of the test of the gaps, Hz")
    point_hz: float = parameter(1000.0, "f_t of that test, Hz")
    ratios: tuple[int, ...] = parameter((2, 4, 8, 16), "f_s / f_p of that test", quick=(4,), least=1)
    a: tuple[int, ...] = parameter((1, 5, 15), "values of scheduling.a, the ageing of the AGVs' blocks", quick=(1, 15))
    crowded_hz: tuple[float, ...] = parameter(
        (4000.0, 5000.0, 5500.0, 6000.0),
        "f_p = f_t of the test of starving, Hz: the crane wants ever more of the one DSP",
        quick=(5000.0,),
    )
    agvs: int = parameter(4, "AGVs, which drive from the start")
    dsps: int = parameter(1, "DSPs")
    duration_s: float = parameter(0.5, "length of a run, s", quick=0.1)

    def settings(self, servo_hz: float, point_hz: float, ratio: int) -> dict[str, Setting]:
        interval = whole_refreshes(servo_hz * ratio / point_hz)  # N_t
        return {
            "machine.dsps": self.dsps,
            "dock.agvs": self.agvs,
            "load.driving": True,
            **rates(servo_hz, ratio),
            "rates.crane_point_frequency_hz": float(point_hz),
            "scheduling.alpha_refreshes": max(1, interval // 4),
            "scheduling.beta_refreshes": max(1, interval // 4) // 2,
        }

    def runs(self) -> list[Run]:
        gaps = [
            Run(
                {"part": "gaps", "equation": equation, "ratio": ratio},
                {**self.settings(self.servo_hz, self.point_hz, ratio), "scheduling.equation": equation},
                self.duration_s,
                group=f"gaps {equation} {ratio}",
            )
            for equation in self.equations
            for ratio in self.ratios
        ]
        starving = [
            Run(
                {"part": "starving", "servo_hz": servo_hz, "a": a},
                {
                    **self.settings(servo_hz, servo_hz, CROWDED_RATIO),
                    "scheduling.q": Q,
                    "scheduling.a": a,
                },
                self.duration_s,
                group=f"starving {servo_hz} {a}",
            )
            for servo_hz in self.crowded_hz
            for a in self.a
        ]
        return gaps + starving

    def rows(self, done: Sequence[tuple[Run, Reports]]) -> list[Row]:
        table = []
        for run, reports in done:
            report = reports[-1]
            tasks = report["tasks"]
            table.append(
                {
                    **run.label,
                    "servo": missed_share(report, "f_p") or 0.0,
                    "servo_misses": counted(report, SERVO),
                    "identify": behind_identify(report),
                    "crane": missed_share(report, "f_t") or 0.0,
                    "agv": missed_share(report, "f_a") or 0.0,
                    "jitter_us": max(measured(tasks[kind]["start_jitter_ps"]["rms"], 1e6) for kind in SERVO),
                    "agv_wait_ms": max(measured(tasks[kind]["waiting_ps"]["worst"], 1e9) for kind in AGV),
                    "agv_mean_ms": measured(tasks["trajectory_planning.agv"]["waiting_ps"]["mean"], 1e9),
                    "idle": 100
                    * sum(d["causes"]["idle"] for d in report["dsps"])
                    / max(1, sum(d["cycles"] for d in report["dsps"])),
                }
            )
        return table

    def verdict(self, all_rows: Sequence[Row]) -> Verdict:
        gaps, starving = of(all_rows, part="gaps", equation="restored"), of(all_rows, part="starving")
        if not gaps or not starving:
            return Verdict("not tested", "A part of the experiment is missing.", "")
        best = min(gaps, key=lambda row: float(row["servo"]))
        kept = kept_up(best)
        why = (
            f"With f_s = {best['ratio']} f_p the servo misses {best['servo']:.2g} %, planning "
            f"{max(best['crane'], best['agv']):.2g} %, while the DSP is {100 - best['idle']:.0f} % busy "
            f"({best['identify']} of the {best['servo_misses']} samples that it misses wait for the identify block, "
            "which nothing can interrupt)."
            if kept
            else f"At best (f_s = {best['ratio']} f_p) the servo misses {best['servo']:.2g} %, the crane's planning "
            f"{best['crane']:.2g} %, the AGVs' {best['agv']:.2g} %."
        )
        saved, limit = self.ageing(starving)
        coarse = [row for row in gaps if not kept_up(row)]
        if kept and coarse:
            limit += f" With f_s = {', '.join(str(row['ratio']) for row in coarse)} f_p it misses more than 1 %."
        elif kept and len(gaps) > 1:
            ratios = [row["ratio"] for row in gaps]
            limit += f" f_s from {min(ratios)} to {max(ratios)} f_p makes no difference to the misses."
        return Verdict("holds" if kept and saved else "holds in part" if kept or saved else "fails", why, limit)

    def ageing(self, starving: Sequence[Row]) -> tuple[bool, str]:
        """Whether a saves the AGVs' planning wherever it would starve, and what is to be said of that."""
        by_load = [sorted(of(starving, servo_hz=f), key=lambda row: int(row["a"])) for f in self.crowded_hz]
        crowded = [own for own in by_load if len(own) > 1 and own[0]["agv"] > 1.0]
        if not crowded:
            return False, (
                f"The AGVs' planning misses at most {max(row['agv'] for row in starving):.2g} % whatever a, even where "
                f"the crane's planning misses {max(row['crane'] for row in starving):.0f} %: no load tried needs a > "
                f"{min(row['a'] for row in starving)}. The crane's planning cannot crowd it out, because the next "
                "point is loaded only when the last one is done, and a block of the AGVs that has become due ranks "
                "above the crane's that has not."
            )
        return all(own[-1]["agv"] < 0.5 * own[0]["agv"] for own in crowded), " ".join(
            f"At f_p = f_t = {least['servo_hz'] / 1000:g} kHz the AGVs' planning misses {least['agv']:.0f} % with a = "
            f"{least['a']} and {most['agv']:.0f} % with a = {most['a']} (the servo {most['servo']:.0f} %, the crane's "
            f"planning {most['crane']:.0f} %)."
            for least, *_, most in crowded
        )

    def section(self, all_rows: Sequence[Row]) -> str:
        columns = {
            "equation": "equation (7)",
            "ratio": "f_s / f_p",
            "servo": "servo missed, %",
            "servo_misses": "jobs",
            "identify": "behind identify",
            "crane": "crane's planning, %",
            "agv": "AGVs' planning, %",
            "jitter_us": "start jitter of the servo, RMS µs",
            "idle": "DSP idle, %",
        }
        text = (
            f"{self.dsps} DSP, f_p {self.servo_hz:g} Hz, f_t {self.point_hz:g} Hz, {self.agvs} AGVs that drive from "
            f"the start, {self.duration_s:g} s from power-on; nothing is left out, identify is in it. Missed: of what "
            "the ideal run demands.\n\n" + markdown(columns, of(all_rows, part="gaps"))
        )
        columns = {
            "servo_hz": "f_p = f_t, Hz",
            "a": "a",
            "servo": "servo missed, %",
            "crane": "crane's planning, %",
            "agv": "AGVs' planning, %",
            "agv_mean_ms": "AGVs' planning waits, ms",
            "agv_wait_ms": "at worst, ms",
            "idle": "DSP idle, %",
        }
        p = int(settings()["p"]["default"])
        return (
            text
            + f"\nThe crane's planning at f_p, so that it wants the rest of the DSP; f_s = {CROWDED_RATIO} f_p, p − q = "
            f"{p - Q:X}h:\n\n" + markdown(columns, of(all_rows, part="starving"))
        )

    def draw(self, all_rows: Sequence[Row], figure: Figure) -> None:
        left, right = figure.subplots(1, 2)
        for equation in self.equations:
            own = of(all_rows, part="gaps", equation=equation)
            left.plot([row["ratio"] for row in own], [row["servo"] for row in own], "o-", label=f"servo, {equation}")
            left.plot(
                [row["ratio"] for row in own],
                [row["crane"] for row in own],
                "s--",
                label=f"crane's planning, {equation}",
            )
        left.set(xlabel="f_s / f_p", ylabel="missed, %", ylim=(0, None))
        left.legend(fontsize=7)
        for a in self.a:
            own = of(all_rows, part="starving", a=a)
            right.plot(
                [row["servo_hz"] / 1000 for row in own], [row["agv_mean_ms"] for row in own], "o-", label=f"a = {a}"
            )
        right.set(xlabel="f_p = f_t, kHz", ylabel="AGVs' planning waits, ms (mean)", ylim=(0, None))
        right.legend(fontsize=8)


def kept_up(row: Row) -> bool:
    """Less than 1 % of each is missed."""
    return bool(row["servo"] < 1.0 and row["crane"] < 1.0 and row["agv"] < 1.0)
