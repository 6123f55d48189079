"""Claim 3: a DSP can be plugged in while the system runs and starts working by itself."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from cmrc.results.claim import Claim, parameter
from cmrc.results.dsps import rates
from cmrc.results.judgement import Row, Verdict, counted, markdown, mean, of, with_interval
from cmrc.results.runs import FirstClaim, Reports, Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Hotplug(Claim):
    """A DSP is plugged in where deadlines are being missed."""

    NUMBER, NAME = 3, "hotplug"
    TITLE = "A DSP can be plugged in while the system runs and starts working by itself"
    DRAWN = ("at_s",)
    LABELS: ClassVar = {"dsps": "{} + 1 DSPs"}

    dsps: tuple[int, ...] = parameter((1, 2, 4), "DSPs before the plug", quick=(1,))
    servo_hz: float = parameter(8000.0, "f_p, Hz: so high that one DSP is too few")
    refreshes_per_servo: int = parameter(4, "f_s / f_p", least=1)
    trials: int = parameter(8, "trials of each number of DSPs", quick=1)
    seed: int = parameter(
        1,
        "draws the instant of the plug, and a run.seed for each trial (run.phase_jitter: phases and ppm of all clocks)",
    )
    before_s: float = parameter(0.06, "from the start to the plug, s, give or take a servo period")
    window_s: float = parameter(
        0.03, "windows in which misses are counted, s: before the plug, and from settle_s after it"
    )
    settle_s: float = parameter(0.01, "from the plug to the second window, s")

    def runs(self) -> list[Run]:
        draw = random.Random(self.seed)
        table = []
        for n in self.dsps:
            for _ in range(self.trials):
                at = round(self.before_s + draw.uniform(0, 1 / self.servo_hz), 9)
                table.append(
                    Run(
                        {"dsps": n, "at_s": at},
                        {
                            "machine.dsps": n,
                            "machine.slots": n + 1,
                            "run.phase_jitter": True,
                            "run.seed": draw.randrange(1, 10000),
                            **rates(self.servo_hz, self.refreshes_per_servo),
                        },
                        round(at + self.settle_s + self.window_s, 9),
                        events=[{"at_s": at, "action": "plug", "dsp": n}],
                        stops_s=(round(at - self.window_s, 9), at, round(at + self.settle_s, 9)),
                        first_claim=FirstClaim(n, at, limit_s=self.settle_s * 0.9),
                    )
                )
        return table

    def rows(self, done: Sequence[tuple[Run, Reports]]) -> list[Row]:
        """One row per trial: shares of the released jobs that were missed before and after, and when the new DSP took
        its first block."""
        table = []
        for run, reports in done:
            begin, plug, settled, end = reports

            def missed(first: dict[str, object], last: dict[str, object]) -> float:
                released = counted(last, of="released") - counted(first, of="released")
                return 100 * (counted(last) - counted(first)) / released if released else 0.0

            table.append(
                {
                    **run.label,
                    "before": missed(begin, plug),
                    "after": missed(settled, end),
                    "first_claim_ms": None if end["first_claim_s"] is None else 1e3 * end["first_claim_s"],
                    "claims": end["dsps"][-1]["claims"],
                    "violations": len(end["audit"]["violations"]),
                }
            )
        return table

    def verdict(self, all_rows: Sequence[Row]) -> Verdict:
        if not all_rows:
            return Verdict("not tested", "No trial was run.", "")
        relevant = [row for row in all_rows if row["before"] > 0]
        if not relevant:
            return Verdict("not tested", "Nothing was missed before the plug: the new DSP was not needed.", "")
        working = [row for row in relevant if row["claims"] and not row["violations"]]
        least = min(row["dsps"] for row in relevant)
        own = of(relevant, dsps=least)
        before, after = mean(own, "before"), mean(own, "after")
        first = [row["first_claim_ms"] for row in own if row["first_claim_ms"] is not None]
        latency = f", the first {with_interval(first)} ms after the plug (reset and boot)" if first else ""
        why = (
            f"In {len(working)} of {len(relevant)} trials in which deadlines were being missed the new DSP took blocks "
            f"by itself{latency}. With {least} + 1 DSPs the "
            f"share of missed jobs went from {before:.0f} % to {after:.1f} %."
        )
        limit = ""
        for n in sorted({row["dsps"] for row in all_rows if not row["claims"] and not row["before"]}):
            trials = of(all_rows, dsps=n)
            idle = sum(1 for row in trials if not row["claims"])
            limit = (
                f"Where {n} DSPs already do, it took no block in {idle} of {len(trials)} trials: it is the last that "
                "is rung, and there is hardly any work left."
            )
        if len(working) < len(relevant):
            return Verdict("fails", why, limit)
        return Verdict("holds" if after < 0.5 * before else "holds in part", why, limit)

    def section(self, all_rows: Sequence[Row]) -> str:
        columns = {
            "dsps": "DSPs",
            "trials": "trials",
            "working": "new one at work",
            "first": "its first block after, ms",
            "before": "missed before, %",
            "after": "missed after, %",
        }
        return (
            f"Base load, f_p {self.servo_hz:g} Hz, f_s {self.servo_hz * self.refreshes_per_servo:g} Hz; plugged after "
            f"about {self.before_s:g} s. Misses are counted in a window of {self.window_s:g} s before the plug "
            "(identify was earlier: what is looked for is how the plug changes a load that lasts) and from "
            f"{self.settle_s:g} s after it. Instants and phases of all clocks but the drives' are drawn (seed {self.seed}). Means, "
            "with 95 % intervals (bootstrap) where the trials differ.\n\n"
            + markdown(columns, [group(all_rows, n) for n in self.dsps])
        )

    def draw(self, all_rows: Sequence[Row], figure: Figure) -> None:
        axes = figure.subplots()
        places = np.arange(len(self.dsps))
        for shift, key, label in ((-0.2, "before", "before"), (0.2, "after", "after")):
            means = [mean(of(all_rows, dsps=n), key) for n in self.dsps]
            axes.bar_label(axes.bar(places + shift, means, 0.4, label=label), fmt="%.1f")
        axes.set_xticks(places, [f"{n} + 1 DSPs" for n in self.dsps])
        axes.set_ylabel("missed jobs, %")
        axes.margins(y=0.1)
        axes.legend(fontsize=8)


def group(all_rows: Sequence[Row], dsps: int) -> Row:
    own = of(all_rows, dsps=dsps)
    first = [row["first_claim_ms"] for row in own if row["first_claim_ms"] is not None]
    return {
        "dsps": f"{dsps} + 1",
        "trials": len(own),
        "working": sum(1 for row in own if row["claims"]),
        "first": with_interval(first),
        "before": with_interval([row["before"] for row in own], 1),
        "after": with_interval([row["after"] for row in own], 1),
    }
