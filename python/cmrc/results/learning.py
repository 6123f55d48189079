"""Claim 5: learning N̂_a drives t_w to 0."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cmrc.results.judgement import Row, Verdict, markdown, parameter
from cmrc.results.runs import Reports, Run
from cmrc.simulation import Setting

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NUMBER, NAME = 5, "learning"
TITLE = "Learning N̂_a drives t_w to 0: the AGV slows until it no longer waits"
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


def longer_lane(east_m: float, agvs: int) -> str:
    """The default layout with the turn east of the loading spot so much farther east: the way to the warehouse is
    twice as much longer. The straight before the spot has room for the queue of all AGVs."""
    straight_m = max(30.0, 18.0 * (agvs - 1))
    return (
        f"[lanes]\nto_warehouse = [[{20 + east_m}, 0, 5], [37.699, -0.08333333, 3], [{32 + east_m}, 0, "
        f"5]]\nto_spot = [[{straight_m - 12}, 0, 5], [37.699, -0.08333333, 3], [{straight_m}, 0, 5]]\n"
    )


@dataclass(frozen=True)
class Parameters:
    """What a user may change."""

    rules: tuple[str, ...] = parameter(
        ("off", "proportional"), "off, unit, proportional: values of scheduling.learning that are compared"
    )
    agvs: int = parameter(2, "AGVs: so many that they wait")
    dsps: int = parameter(1, "DSPs")
    duration_s: float = parameter(1300.0, "length of the runs with proportional learning, s")
    short_s: float = parameter(430.0, "length of the runs with the other rules, s")
    rate: float = parameter(0.8, "scheduling.learning_rate")
    step_max: float = parameter(0.4, "scheduling.learning_step_max")
    dead_band: float = parameter(0.02, "scheduling.learning_dead_band")
    lanes_m: tuple[float, ...] = parameter(
        (0.0, 20.0), "layouts: the lane's turn is so many m farther east of the loading spot"
    )
    last: int = parameter(2, "cycles at the end of each run over which is judged")


QUICK = Parameters(rules=("off", "proportional"), lanes_m=(0.0,), duration_s=1.0, short_s=1.0)


def runs(p: Parameters) -> list[Run]:
    return [
        Run(
            {"rule": rule, "lane_m": lane},
            {
                **SLOW,
                "machine.dsps": p.dsps,
                "dock.agvs": p.agvs,
                "scheduling.learning": rule,
                "scheduling.learning_dead_band": p.dead_band,
                "scheduling.learning_rate": p.rate,
                "scheduling.learning_step_max": p.step_max,
            },
            p.duration_s if rule == "proportional" else p.short_s,
            layout=longer_lane(lane, p.agvs),
        )
        for rule in p.rules
        for lane in (p.lanes_m[:1] if rule == "unit" else p.lanes_m)
    ]


def rows(p: Parameters, done: Sequence[tuple[Run, Reports]]) -> list[Row]:
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


def at_the_end(p: Parameters, all_rows: Sequence[Row], rule: str, of: str) -> list[float]:
    """A quantity of the last cycles of every run with this rule."""
    values: list[float] = []
    for lane in dict.fromkeys(row["lane_m"] for row in all_rows):
        own = [row[of] for row in all_rows if row["rule"] == rule and row["lane_m"] == lane]
        values += own[-p.last :] if len(own) > p.last else []
    return values


def verdict(p: Parameters, all_rows: Sequence[Row]) -> Verdict:
    untaught, taught = (
        [row["t_w_s"] for row in all_rows if row["rule"] == "off"],
        at_the_end(p, all_rows, "proportional", "t_w_s"),
    )
    if not untaught or not taught:
        return Verdict(
            "not tested", f"Not more than {p.last} work cycle{'s have' if p.last > 1 else ' has'} closed.", ""
        )
    period = float(np.mean(at_the_end(p, all_rows, "proportional", "T_g_s")))
    if np.mean(untaught) <= p.dead_band * period:
        return Verdict(
            "not tested",
            f"Without learning the AGVs wait {np.mean(untaught):.1f} s of T_g = {period:.0f} s: there is nothing to "
            "learn.",
            "",
        )
    # What the rule cannot do better: within its dead band and within half a step of rounding it changes
    # nothing; and it knows the last cycle only.
    step_s = float(
        np.mean(at_the_end(p, all_rows, "proportional", "driving_s"))
        / np.mean(at_the_end(p, all_rows, "proportional", "interval"))
    )
    rest = max(p.dead_band * period, 0.5 * step_s / p.rate)
    spread = float(np.std([row["T_g_s"] for row in all_rows])) * p.agvs**0.5
    mean = float(np.mean(taught))
    crane = float(np.mean(at_the_end(p, all_rows, "proportional", "t_v_s")))
    good = mean <= 2 * rest and crane <= 2 * rest
    taught_in = "cycle" if p.last == 1 else f"{p.last} cycles"
    why = (
        f"With {p.agvs} AGV{'s' if p.agvs > 1 else ''} t_w is {np.mean(untaught):.1f} s without learning, and "
        f"{mean:.1f} s "
        f"({min(taught):.1f} to {max(taught):.1f} s) in the last {taught_in} of each run with it (T_g {period:.0f} s; "
        f"{len(p.lanes_m)} layout{'s' if len(p.lanes_m) > 1 else ''}). The crane then waits t_v = {crane:.1f} s for it."
    )
    limits = [
        (
            "Three things keep it from settling at 0. Below "
            f"{100 * p.dead_band:g} % of T_g ({p.dead_band * period:.1f} s) the rule changes nothing (dead band). A "
            "change "
            "of less than half a refresh is rounded away: of waits below "
            f"{0.5 * step_s / p.rate:.1f} s, for one refresh of N̂_a is {step_s:.1f} s of driving. And the rule knows "
            "only "
            f"the cycle before, while T_g differs from container to container by {spread:.1f} s (standard deviation): "
            "what it has learnt from one container is too slow for a nearer one."
        )
    ]
    if mean > rest + spread:
        limits.append("What is left is more than all that: the run ends before the learning, or the rule is too slow.")
    interval = float(np.mean(at_the_end(p, all_rows, "proportional", "interval")))
    first = float(np.mean([row["interval"] for row in all_rows if row["rule"] == "off"]))
    limits.append(
        f"While an AGV drives its planning is due every {interval:.0f} refreshes instead of every {first:.0f}: "
        f"{100 * (1 - first / interval):.0f} % less often."
    )
    step = at_the_end(p, all_rows, "unit", "t_w_s")
    if step:
        count = len([row for row in all_rows if row["rule"] == "unit"])
        limits.append(
            f"Changing N̂_a by 1 per cycle, as printed, leaves {np.mean(step):.0f} s after {count} cycles: each takes "
            f"{step_s:.1f} s off."
        )
    else:
        limits.append(
            "Changing N̂_a by 1 per cycle, as printed (`--rules unit`), would take some "
            f"{np.mean(untaught) / step_s:.0f} cycles."
        )
    partly = mean < 0.75 * float(np.mean(untaught))
    return Verdict("holds" if good else "holds in part" if partly else "fails", why, " ".join(limits))


def section(p: Parameters, all_rows: Sequence[Row]) -> str:
    columns = {
        "rule": "learning", "lane_m": "lane longer, m", "cycle": "cycle", "interval": "N̂_a",
        "driving_s": "t_5 + t_6, s", "t_w_s": "t_w, s", "t_v_s": "t_v, s", "T_g_s": "T_g, s",
    }  # fmt: skip
    return (
        f"{p.dsps} DSP, {p.agvs} AGV{'s' if p.agvs > 1 else ''}, 24 containers, {p.duration_s:g} s (without "
        f"proportional learning {p.short_s:g} s), f_s 1 kHz, f_p 125 Hz, f_a 25 Hz: N̂_a from 40 to at most 160. "
        f"Learning rate {p.rate:g}, largest step"
        f" {100 * p.step_max:g} %. t_w is the paper's: from where the AGV leaves the lane to where the crane begins to "
        "load it ([report.md](report.md), `cycles`). Layouts differ in the length of the lane; no seed is varied. "
        "Each work cycle"
        " that has closed:\n\n" + markdown(columns, all_rows)
    )


def draw(p: Parameters, all_rows: Sequence[Row], figure: Figure) -> None:
    waiting, interval = figure.subplots(1, 2)
    marks: dict[str, Any] = {"off": "o", "unit": "^", "proportional": "s"}
    for number, rule in enumerate(dict.fromkeys(row["rule"] for row in all_rows)):
        for lane, line in zip(p.lanes_m, ("-", "--", ":", "-."), strict=False):
            own = [row for row in all_rows if (row["rule"], row["lane_m"]) == (rule, lane)]
            if own:
                for axes, of in ((waiting, "t_w_s"), (interval, "interval")):
                    axes.plot(
                        [row["cycle"] for row in own],
                        [row[of] for row in own],
                        marks[rule] + line,
                        color=f"C{number}",
                        label=f"{rule}, {lane:g} m",
                        markersize=4,
                        alpha=0.8,
                    )
    waiting.set(xlabel="work cycle", ylabel="t_w, s", ylim=(0, None))
    interval.set(xlabel="work cycle", ylabel="N̂_a, refreshes", ylim=(0, None))
    if all_rows:
        interval.legend(fontsize=7)
