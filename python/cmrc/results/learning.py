"""Claim 5: learning N̂_a drives t_w to 0."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from cmrc.results.claim import Claim, parameter
from cmrc.results.judgement import Row, Verdict, markdown, mean, of
from cmrc.results.runs import Reports, Run
from cmrc.simulation import Setting

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Slow rates, at which a second of a run costs a fifth of the time that it costs at base rates. The default loops of
# 40 rad/s do not bear PID's period of 8 ms; those of 5 and 8 rad/s do not feel it (docs/control.md). One planning
# interval of an AGV at full speed is 40 ms, 40 refreshes.
SLOW: dict[str, Setting] = {
    "refresh_frequency_hz": 1000.0,
    "servo_frequency_hz": 125.0,
    "scheduling.alpha_refreshes": 3,
    "scheduling.beta_refreshes": 1,
    "rates.agv_point_frequency_hz": 25.0,
    "scheduling.agv_interval_max_refreshes": 160,
    "dock.containers": 24,
    "control.slew_bandwidth_rad_s": 5.0,
    "control.luff_bandwidth_rad_s": 5.0,
    "control.hoist_bandwidth_rad_s": 8.0,
    "control.rotator_bandwidth_rad_s": 5.0,
}


def slow_rates() -> str:
    """What a section says of these settings."""
    rates = ("f_s", "refresh_frequency_hz"), ("f_p", "servo_frequency_hz"), ("f_a", "rates.agv_point_frequency_hz")
    return f"Slow rates ({', '.join(f'{name} {SLOW[key]:g} Hz' for name, key in rates)}), loops for such rates"


def longer_lane(east_m: float, agvs: int) -> str:
    """The default layout with the turn east of the loading spot so much farther east: the way to the warehouse is
    twice as much longer. The straight before the spot has room for the queue of all AGVs."""
    straight_m = max(30.0, 18.0 * (agvs - 1))
    return (
        f"[lanes]\nto_warehouse = [[{20 + east_m}, 0, 5], [37.699, -0.08333333, 3], [{32 + east_m}, 0, "
        f"5]]\nto_spot = [[{straight_m - 12}, 0, 5], [37.699, -0.08333333, 3], [{straight_m}, 0, 5]]\n"
    )


@dataclass(frozen=True)
class Learning(Claim):
    """AGVs that wait, without learning and with it."""

    NUMBER, NAME = 5, "learning"
    TITLE = "Learning N̂_a drives t_w to 0: the AGV slows until it no longer waits"

    LABELS: ClassVar = {"rule": "learning {}", "lane_m": "lane {} m longer"}

    rules: tuple[str, ...] = parameter(
        ("off", "proportional"),
        "off, unit, proportional: values of scheduling.learning that are compared",
        quick=("off", "proportional"),
    )
    agvs: int = parameter(2, "AGVs: so many that they wait")
    dsps: int = parameter(1, "DSPs")
    duration_s: float = parameter(1300.0, "length of the runs with proportional learning, s", quick=1.0)
    short_s: float = parameter(430.0, "length of the runs with the other rules, s", quick=1.0)
    rate: float = parameter(0.8, "scheduling.learning_rate", least=0)
    step_max: float = parameter(0.4, "scheduling.learning_step_max", least=0)
    dead_band: float = parameter(0.02, "scheduling.learning_dead_band", least=0)
    lanes_m: tuple[float, ...] = parameter(
        (0.0, 20.0),
        "layouts: the lane's turn is so many m farther east of the loading spot",
        quick=(0.0,),
        least=-math.inf,
    )
    last: int = parameter(2, "cycles at the end of each run over which is judged", least=1)

    def runs(self) -> list[Run]:
        return [
            Run(
                {"rule": rule, "lane_m": lane},
                {
                    **SLOW,
                    "machine.dsps": self.dsps,
                    "dock.agvs": self.agvs,
                    "scheduling.learning": rule,
                    "scheduling.learning_dead_band": self.dead_band,
                    "scheduling.learning_rate": self.rate,
                    "scheduling.learning_step_max": self.step_max,
                },
                self.duration_s if rule == "proportional" else self.short_s,
                layout=longer_lane(lane, self.agvs),
            )
            for rule in self.rules
            for lane in (self.lanes_m[:1] if rule == "unit" else self.lanes_m)
        ]

    def rows(self, done: Sequence[tuple[Run, Reports]]) -> list[Row]:
        """One row per work cycle that has closed."""
        return [
            {
                **run.label,
                "cycle": cycle["number"],
                "interval": cycle["agv_interval_refreshes"],
                "driving_s": cycle["t_5_s"] + cycle["t_6_s"],
                "t_w_s": cycle["t_w_s"],
                "t_v_s": cycle["t_v_s"],
                "T_g_s": cycle["T_g_s"],
            }
            for run, reports in done
            for cycle in reports[-1]["cycles"]
            if cycle["t_w_s"] is not None and cycle["T_g_s"] is not None
        ]

    def last_cycles(self, all_rows: Sequence[Row], rule: str) -> list[Row]:
        """The last cycles of every run with this rule."""
        own = of(all_rows, rule=rule)
        runs = [of(own, lane_m=lane) for lane in dict.fromkeys(row["lane_m"] for row in own)]
        return [row for run in runs if len(run) > self.last for row in run[-self.last :]]

    def verdict(self, all_rows: Sequence[Row]) -> Verdict:
        untaught, taught = of(all_rows, rule="off"), self.last_cycles(all_rows, "proportional")
        if not untaught or not taught:
            return Verdict(
                "not tested", f"Not more than {self.last} work cycle{'s have' if self.last > 1 else ' has'} closed.", ""
            )
        before, wait, crane = mean(untaught, "t_w_s"), mean(taught, "t_w_s"), mean(taught, "t_v_s")
        period, step_s = mean(taught, "T_g_s"), mean(taught, "driving_s") / mean(taught, "interval")
        if before <= self.dead_band * period:
            return Verdict(
                "not tested",
                f"Without learning the AGVs wait {before:.1f} s of T_g = {period:.0f} s: there is nothing to learn.",
                "",
            )
        # What the rule cannot do better: within its dead band and within half a step of rounding it changes
        # nothing; and it knows the last cycle only.
        rest = max(self.dead_band * period, 0.5 * step_s / self.rate)
        # An AGV's round takes one T_g of each AGV.
        spread = float(np.std([row["T_g_s"] for row in all_rows]))
        of_round = spread * self.agvs**0.5
        good, partly = max(wait, crane) <= 2 * rest, wait < 0.75 * before
        least, most = min(row["t_w_s"] for row in taught), max(row["t_w_s"] for row in taught)
        why = (
            f"With {self.agvs} AGV{'s' if self.agvs > 1 else ''} t_w is {before:.1f} s without learning, and "
            f"{wait:.1f} s ({least:.1f} to {most:.1f} s) in the last "
            f"{'cycle' if self.last == 1 else f'{self.last} cycles'} of each run with it (T_g {period:.0f} s; "
            f"{len(self.lanes_m)} layout{'s' if len(self.lanes_m) > 1 else ''}). The crane then waits t_v = "
            f"{crane:.1f} s for it."
        )
        limit = (
            "Three things keep it from settling at 0. Below "
            f"{100 * self.dead_band:g} % of T_g ({self.dead_band * period:.1f} s) the rule changes nothing (dead "
            "band). A change of less than half a refresh is rounded away: of waits below "
            f"{0.5 * step_s / self.rate:.1f} s, for one refresh of N̂_a is {step_s:.1f} s of driving. And the rule "
            "knows only the cycle before, while T_g differs from container to container by "
            f"{spread:.1f} s (standard deviation), and so an AGV's round by {of_round:.1f} s: what it has learnt from one "
            "container is too slow for a nearer one."
        )
        if wait > rest + of_round:
            limit += " What is left is more than all that: the run ends before the learning, or the rule is too slow."
        first, interval = mean(untaught, "interval"), mean(taught, "interval")
        limit += (
            f" While an AGV drives its planning is due every {interval:.0f} refreshes instead of every {first:.0f}: "
            f"{100 * (1 - first / interval):.0f} % less often. {self.by_one(all_rows, before, step_s)}"
        )
        return Verdict("holds" if good else "holds in part" if partly else "fails", why, limit)

    def by_one(self, all_rows: Sequence[Row], before: float, step_s: float) -> str:
        """The rule as it is printed."""
        if last := self.last_cycles(all_rows, "unit"):
            return (
                f"Changing N̂_a by 1 per cycle, as printed, leaves {mean(last, 't_w_s'):.0f} s after "
                f"{len(of(all_rows, rule='unit'))} cycles: each takes {step_s:.1f} s off."
            )
        return (
            f"Changing N̂_a by 1 per cycle, as printed (`--rules unit`), would take some {before / step_s:.0f} cycles."
        )

    def section(self, all_rows: Sequence[Row]) -> str:
        columns = {
            "rule": "learning", "lane_m": "lane longer, m", "cycle": "cycle", "interval": "N̂_a",
            "driving_s": "t_5 + t_6, s", "t_w_s": "t_w, s", "t_v_s": "t_v, s", "T_g_s": "T_g, s",
        }  # fmt: skip
        refresh_hz, agv_hz = float(SLOW["refresh_frequency_hz"]), float(SLOW["rates.agv_point_frequency_hz"])
        return (
            f"{self.dsps} DSP, {self.agvs} AGV{'s' if self.agvs > 1 else ''}, {SLOW['dock.containers']} containers, "
            f"{self.duration_s:g} s (without proportional learning {self.short_s:g} s). {slow_rates()}, and N̂_a from "
            f"{refresh_hz / agv_hz:g} to at most {SLOW['scheduling.agv_interval_max_refreshes']}. Learning rate {self.rate:g}, largest step {100 * self.step_max:g} %. t_w is the paper's: from "
            "where the AGV leaves the lane to where the crane begins to load it ([report.md](report.md), `cycles`). "
            "Layouts differ in the length of the lane; no seed is varied. Each work cycle that has closed:\n\n"
            + markdown(columns, all_rows)
        )

    def draw(self, all_rows: Sequence[Row], figure: Figure) -> None:
        waiting, interval = figure.subplots(1, 2)
        marks: dict[str, Any] = {"off": "o", "unit": "^", "proportional": "s"}
        for number, rule in enumerate(dict.fromkeys(row["rule"] for row in all_rows)):
            for place, (lane, line) in enumerate(zip(self.lanes_m, cycle(("-", "--", ":", "-.")))):
                own = of(all_rows, rule=rule, lane_m=lane)
                if own:
                    for axes, key in ((waiting, "t_w_s"), (interval, "interval")):
                        axes.plot(
                            [row["cycle"] for row in own],
                            [row[key] for row in own],
                            marks[rule] + line,
                            color=f"C{number}",
                            label=f"{rule}, {lane:g} m",
                            linewidth=1.5 * (1 + place // 4),  # a style that is used again is thicker
                            markersize=4,
                            alpha=0.8,
                        )
        waiting.set(xlabel="work cycle", ylabel="t_w, s", ylim=(0, None))
        interval.set(xlabel="work cycle", ylabel="N̂_a, refreshes", ylim=(0, None))
        if all_rows:
            interval.legend(fontsize=7)
