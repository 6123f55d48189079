"""Claim 5: learning N̂_a drives t_w to 0."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cmrc.results.judgement import Row, Verdict, markdown, mean_interval, with_interval
from cmrc.results.runs import Reports, Run
from cmrc.simulation import Setting

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NUMBER, NAME = 5, "learning"
TITLE = "Learning N̂_a drives t_w to 0: the AGV slows until it no longer waits"
# A quarter of the base rates: the plan of the motion is the same, and a run takes half the time.
CALM: dict[str, Setting] = {
    "refresh_frequency_hz": 2000.0,
    "servo_frequency_hz": 250.0,
    "scheduling.alpha_refreshes": 6,
    "scheduling.beta_refreshes": 3,
    "scheduling.agv_interval_max_refreshes": 160,
    "dock.containers": 24,
}
AGV_PLANNING = ("trajectory_planning.agv", "inverse_kinematics.agv")


@dataclass(frozen=True)
class Parameters:
    """What a user may change."""

    rules: tuple[str, ...] = ("off", "unit", "proportional")
    agvs: int = 2
    dsps: int = 1
    duration_s: float = 1100.0
    rate: float = 0.5
    step_max: float = 0.3
    """scheduling.learning_rate and learning_step_max: at 1 and 1 a vehicle at the old rate runs into one that has slowed to half."""
    dead_band: float = 0.02
    seeds: tuple[int, ...] = (1, 2)
    wind_gust_m_s: float = 2.0
    """What differs between the seeds, besides the sway sensor's noise."""
    last: int = 3
    """Cycles at the end of each run over which is judged."""


QUICK = Parameters(rules=("off", "proportional"), seeds=(1,), duration_s=1.0)


def runs(p: Parameters) -> list[Run]:
    return [
        Run(
            {"rule": rule, "seed": seed},
            {
                **CALM,
                "machine.dsps": p.dsps,
                "dock.agvs": p.agvs,
                "run.seed": seed,
                "dock.wind_gust_m_s": p.wind_gust_m_s,
                "scheduling.learning": rule,
                "scheduling.learning_dead_band": p.dead_band,
                "scheduling.learning_rate": p.rate,
                "scheduling.learning_step_max": p.step_max,
            },
            p.duration_s,
        )
        for rule in p.rules
        for seed in (p.seeds if rule == "proportional" else p.seeds[:1])
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
            "waiting": cycle["t_w_s"] / cycle["T_g_s"],
            "planning_per_s": sum(reports[-1]["tasks"][kind]["released"] for kind in AGV_PLANNING) / p.duration_s,
        }
        for run, reports in done
        for cycle in reports[-1]["cycles"]
        if cycle["t_w_s"] is not None and cycle["T_g_s"] is not None
    ]


def at_the_end(p: Parameters, all_rows: Sequence[Row], rule: str, of: str) -> list[float]:
    """A quantity of the last cycles of every run with this rule."""
    values: list[float] = []
    for seed in dict.fromkeys(row["seed"] for row in all_rows):
        own = [row[of] for row in all_rows if row["rule"] == rule and row["seed"] == seed]
        values += own[-p.last :] if len(own) > p.last else []
    return values


def verdict(p: Parameters, all_rows: Sequence[Row]) -> Verdict:
    untaught, taught = at_the_end(p, all_rows, "off", "t_w_s"), at_the_end(p, all_rows, "proportional", "t_w_s")
    if not untaught or not taught:
        return Verdict("not tested", f"Not more than {p.last} work cycles have closed.", "")
    cycles = at_the_end(p, all_rows, "proportional", "T_g_s")
    period = float(np.mean(cycles))
    if np.mean(untaught) <= p.dead_band * period:
        return Verdict("not tested", f"Without learning the AGVs wait {np.mean(untaught):.1f} s of T_g = {period:.0f} s: there is nothing to learn.", "")
    # An interval that is learnt cannot foresee how long the next containers take: over the cycles of a round of all AGVs that is so much.
    spread = float(np.std([row["T_g_s"] for row in all_rows])) * p.agvs**0.5
    mean, low, high = mean_interval(taught)
    crane = float(np.mean(at_the_end(p, all_rows, "proportional", "t_v_s")))
    good = mean <= max(2 * p.dead_band * period, spread) and crane <= p.dead_band * period
    why = (
        f"With {p.agvs} AGVs they wait {with_interval(untaught, 1)} s of a cycle without learning and {mean:.1f} [{low:.1f}, {high:.1f}] s in the last {p.last} cycles of each run with it"
        f" (T_g {period:.0f} s; means, 95 % intervals over cycles and seeds); the crane waits {crane:.1f} s for it."
    )
    limits = []
    if mean > max(2 * p.dead_band * period, spread):
        limits.append(f"That is more than what T_g varies by (over a round of {p.agvs} containers {spread:.0f} s, standard deviation), which no rule could foresee: the run ends before the learning, or the rule is too slow.")
    elif mean > 2 * p.dead_band * period:
        limits.append(f"t_w comes down to what the rule cannot foresee and not to 0: T_g varies from container to container, over a round of {p.agvs} by {spread:.0f} s (standard deviation).")
    before, after = (max((row["planning_per_s"] for row in all_rows if row["rule"] == rule), default=0.0) for rule in ("off", "proportional"))
    limits.append(f"The AGVs' planning takes {before:.0f} blocks a second without learning, {after:.0f} with it on the mean of the whole run.")
    step = at_the_end(p, all_rows, "unit", "t_w_s")
    if step:
        limits.append(f"Changing N̂_a by 1 per cycle, as printed, leaves {np.mean(step):.0f} s: it would take some hundred cycles.")
    partly = mean < 0.75 * float(np.mean(untaught))
    return Verdict("holds" if good else "holds in part" if partly else "fails", why, " ".join(limits))


def section(p: Parameters, all_rows: Sequence[Row]) -> str:
    columns = {
        "rule": "learning", "seed": "seed", "cycle": "cycle", "interval": "N̂_a", "driving_s": "t_5 + t_6, s", "t_w_s": "t_w, s", "t_v_s": "t_v, s", "T_g_s": "T_g, s",
    }  # fmt: skip
    return (
        f"{p.dsps} DSP, {p.agvs} AGVs, 24 containers, {p.duration_s:g} s, f_s 2 kHz, f_p 250 Hz, N̂_a from 40 to at most 160, learning rate {p.rate:g}, largest step {p.step_max:g}, gusts of"
        f" {p.wind_gust_m_s:g} m/s by the seed. t_w is what an AGV waits from leaving the lane until it begins to be loaded"
        f" ([report.md](report.md), `cycles`). Of each work cycle that has closed (of seed {p.seeds[0]}):\n\n"
        + markdown(columns, [row for row in all_rows if row["seed"] == p.seeds[0]])
    )


def draw(p: Parameters, all_rows: Sequence[Row], figure: Figure) -> None:
    waiting, interval = figure.subplots(1, 2)
    marks: dict[str, Any] = {"off": "o-", "unit": "^-", "proportional": "s-"}
    for number, rule in enumerate(dict.fromkeys(row["rule"] for row in all_rows)):
        for seed in p.seeds:
            own = [row for row in all_rows if (row["rule"], row["seed"]) == (rule, seed)]
            label = rule if seed == p.seeds[0] else None
            for axes, of in ((waiting, "t_w_s"), (interval, "interval")):
                axes.plot([row["cycle"] for row in own], [row[of] for row in own], marks[rule], color=f"C{number}", label=label, markersize=4, alpha=0.8)
    waiting.set(xlabel="work cycle", ylabel="t_w, s", ylim=(0, None))
    interval.set(xlabel="work cycle", ylabel="N̂_a, refreshes", ylim=(0, None))
    waiting.legend(fontsize=8)
