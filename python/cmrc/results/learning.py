"""Claim 5: learning N̂_a drives t_w to 0."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from cmrc.results.judgement import Row, Verdict, markdown
from cmrc.results.runs import Reports, Run
from cmrc.simulation import Setting

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NUMBER, NAME = 5, "learning"
TITLE = "Learning N̂_a drives t_w to 0: the AGV slows until it no longer waits"
# Half the base rates: the plan of the motion is the same, and a run takes half the time.
CALM: dict[str, Setting] = {
    "refresh_frequency_hz": 4000.0,
    "servo_frequency_hz": 500.0,
    "scheduling.alpha_refreshes": 12,
    "scheduling.beta_refreshes": 6,
    "scheduling.agv_interval_max_refreshes": 320,
}


@dataclass(frozen=True)
class Parameters:
    """What a user may change."""

    rules: tuple[str, ...] = ("off", "proportional")
    agvs: tuple[int, ...] = (2,)
    """The first is run with every rule, the others with the proportional one only."""
    dsps: int = 1
    duration_s: float = 600.0
    rate: float = 1.0
    step_max: float = 1.0
    """scheduling.learning_rate and learning_step_max: as fast as it goes, since a job has few cycles."""
    dead_band: float = 0.02


QUICK = Parameters(rules=("off", "proportional"), agvs=(2,), duration_s=1.0)


def runs(p: Parameters) -> list[Run]:
    cases = [(rule, p.agvs[0]) for rule in p.rules] + [("proportional", agvs) for agvs in p.agvs[1:]]
    return [
        Run(
            {"rule": rule, "agvs": agvs},
            {**CALM, "machine.dsps": p.dsps, "dock.agvs": agvs, "scheduling.learning": rule, "scheduling.learning_dead_band": p.dead_band, "scheduling.learning_rate": p.rate, "scheduling.learning_step_max": p.step_max},
            p.duration_s,
        )
        for rule, agvs in cases
    ]


def rows(p: Parameters, done: Sequence[tuple[Run, Reports]]) -> list[Row]:
    """One row per work cycle that has closed."""
    return [
        {
            **run.label,
            "cycle": cycle["number"],
            "driving_s": cycle["t_5_s"] + cycle["t_6_s"],
            "t_w_s": cycle["t_w_s"],
            "t_v_s": cycle["t_v_s"],
            "T_g_s": cycle["T_g_s"],
            "waiting": cycle["t_w_s"] / cycle["T_g_s"],
        }
        for run, reports in done
        for cycle in reports[-1]["cycles"]
        if cycle["t_w_s"] is not None and cycle["T_g_s"] is not None
    ]


def settled(all_rows: Sequence[Row], rule: str, agvs: int) -> float | None:
    """Mean share of T_g that the AGVs waited in the last two cycles."""
    own = [row["waiting"] for row in all_rows if row["rule"] == rule and row["agvs"] == agvs]
    return float(np.mean(own[-2:])) if len(own) >= 3 else None


def verdict(p: Parameters, all_rows: Sequence[Row]) -> Verdict:
    agvs = p.agvs[0]
    untaught, taught = settled(all_rows, "off", agvs), settled(all_rows, "proportional", agvs)
    if untaught is None or taught is None:
        return Verdict("not tested", "Fewer than three work cycles have closed.", "")
    if untaught <= p.dead_band:
        return Verdict("not tested", f"Without learning the AGVs wait {untaught:.1%} of T_g: there is nothing to learn.", "")
    # Within the dead band of one step of N̂_a; a tenth of what it was is near enough for noise of the settling crane.
    good = taught <= max(2 * p.dead_band, 0.1 * untaught)
    why = f"With {agvs} AGVs they wait {untaught:.1%} of T_g without learning, {taught:.1%} in the last two cycles with it."
    step = settled(all_rows, "unit", agvs)
    limits = [] if step is None else [f"Changing N̂_a by 1 per cycle, as printed, leaves {step:.1%}: too slow for a job of eight containers."]
    for more in p.agvs[1:]:
        left = settled(all_rows, "proportional", more)
        if left is None:
            continue
        if left > 2 * p.dead_band:
            limits.append(f"With {more} AGVs {left:.1%} is left: N̂_a,max or the number of cycles ends the learning before the waiting.")
        else:
            limits.append(f"With {more} AGVs {left:.1%} is left.")
    own = [row for row in all_rows if row["rule"] == "proportional" and row["agvs"] == agvs]
    if not good:
        lengths = [row["T_g_s"] for row in own]
        limits.insert(
            0,
            f"{len(own)} closed cycles are not enough: T_g goes from {min(lengths):.0f} to {max(lengths):.0f} s from container to container, so that an interval learnt"
            f" from one cycle is not right for the next, and an AGV learns only when it is loaded again.",
        )
    partly = taught < 0.75 * untaught
    return Verdict("holds" if good else "holds in part" if partly else "fails", why, " ".join(limits))


def section(p: Parameters, all_rows: Sequence[Row]) -> str:
    columns = {"rule": "learning", "agvs": "AGVs", "cycle": "cycle", "driving_s": "t_5 + t_6, s", "t_w_s": "t_w, s", "t_v_s": "t_v, s", "T_g_s": "T_g, s"}
    return (
        f"{p.dsps} DSP, {p.duration_s:g} s, f_s 4 kHz, f_p 500 Hz, N̂_a from 80 to at most 320, learning rate {p.rate:g}, largest step {p.step_max:g}. Of each work cycle that has closed:\n\n"
        + markdown(columns, all_rows)
    )


def draw(p: Parameters, all_rows: Sequence[Row], figure: Figure) -> None:
    axes = figure.subplots()
    for rule, agvs in dict.fromkeys((row["rule"], row["agvs"]) for row in all_rows):
        own = [row for row in all_rows if (row["rule"], row["agvs"]) == (rule, agvs)]
        axes.plot([row["cycle"] for row in own], [row["t_w_s"] for row in own], "o-", label=f"{rule}, {agvs} AGVs")
    axes.set(xlabel="work cycle", ylabel="t_w, s", ylim=(0, None))
    axes.legend(fontsize=8)
