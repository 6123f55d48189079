"""Claim 6: more AGVs cure case B."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from cmrc.results.judgement import Row, Verdict, markdown
from cmrc.results.learning import CALM
from cmrc.results.runs import Reports, Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NUMBER, NAME = 6, "fleet"
TITLE = "More AGVs cure case B, in which the crane waits (t_v > 0)"


@dataclass(frozen=True)
class Parameters:
    """What a user may change."""

    agvs: tuple[int, ...] = (1, 2, 3)
    agv_speed_m_s: float = 3.0
    dsps: int = 1
    duration_s: float = 330.0


QUICK = Parameters(agvs=(1, 2), duration_s=1.0)


def runs(p: Parameters) -> list[Run]:
    return [
        Run(
            {"agvs": agvs},
            {**CALM, "machine.dsps": p.dsps, "dock.agvs": agvs, "dock.agv_speed_m_s": p.agv_speed_m_s},
            p.duration_s,
        )
        for agvs in p.agvs
    ]


def rows(p: Parameters, done: Sequence[tuple[Run, Reports]]) -> list[Row]:
    """One row per number of AGVs; the first cycle, for which all AGVs stand ready, is left out of the means."""
    table = []
    for run, reports in done:
        cycles = [c for c in reports[-1]["cycles"] if c["T_g_s"] is not None][1:]
        waited = [c["t_w_s"] for c in cycles if c["t_w_s"] is not None]
        delivered = [c["delivered_s"] for c in reports[-1]["cycles"] if c["delivered_s"] is not None]
        rate = (len(delivered) - 1) / (delivered[-1] - delivered[0]) * 3600 if len(delivered) > 1 else None
        table.append(
            {
                **run.label,
                "cycles": len(cycles),
                "t_v_s": float(np.mean([c["t_v_s"] for c in cycles])) if cycles else None,
                "t_w_s": float(np.mean(waited)) if waited else None,
                "T_g_s": float(np.mean([c["T_g_s"] for c in cycles])) if cycles else None,
                "per_hour": rate,
                "misses": sum(task["misses"] for task in reports[-1]["tasks"].values()),
            }
        )
    return table


def verdict(p: Parameters, all_rows: Sequence[Row]) -> Verdict:
    known = [row for row in all_rows if row["t_v_s"] is not None]
    if len(known) < 2:
        return Verdict("not tested", "No second work cycle was loaded.", "")
    first = known[0]
    share = first["t_v_s"] / first["T_g_s"]
    if share < 0.02:
        return Verdict("not tested", f"With {first['agvs']} AGV the crane waits {share:.1%} of its cycle: this is not case B.", "")
    why = f"With {first['agvs']} AGV the crane waits {first['t_v_s']:.0f} s of each cycle of {first['T_g_s']:.0f} s."
    cured = next((row for row in known if row["t_v_s"] < 0.02 * row["T_g_s"]), None)
    if cured is None:
        least = min(known, key=lambda row: float(row["t_v_s"]))
        word = "holds in part" if least["t_v_s"] < 0.7 * first["t_v_s"] else "fails"
        return Verdict(word, why, f"The least was {least['t_v_s']:.0f} s, with {least['agvs']} AGVs.")
    limit = f"{cured['agvs']} are enough (t_v {cured['t_v_s']:.1f} s)."
    beyond = [row for row in known if row["agvs"] > cured["agvs"]]
    if beyond and cured["per_hour"] and beyond[-1]["per_hour"]:
        limit += (
            f" From there on the crane is the limit: {beyond[-1]['agvs']} AGVs deliver {beyond[-1]['per_hour']:.0f} containers per hour,"
            f" {cured['agvs']} deliver {cured['per_hour']:.0f}."
        )
    return Verdict("holds", why, limit)


def section(p: Parameters, all_rows: Sequence[Row]) -> str:
    columns = {"agvs": "AGVs", "cycles": "cycles", "t_v_s": "t_v, s", "t_w_s": "t_w, s", "T_g_s": "T_g, s", "per_hour": "containers per hour", "misses": "missed deadlines"}
    return (
        f"AGVs of at most {p.agv_speed_m_s:g} m/s, {p.dsps} DSP, {p.duration_s:g} s, f_s 4 kHz, f_p 500 Hz. Means over the work cycles after the first:\n\n"
        + markdown(columns, all_rows)
    )


def draw(p: Parameters, all_rows: Sequence[Row], figure: Figure) -> None:
    left = figure.subplots()
    agvs = [row["agvs"] for row in all_rows]
    left.plot(agvs, [row["t_v_s"] for row in all_rows], "o-", label="t_v: the crane waits")
    left.plot(agvs, [row["t_w_s"] for row in all_rows], "s--", label="t_w: an AGV waits")
    left.set(xlabel="AGVs", ylabel="s per cycle", xticks=agvs, ylim=(0, None))
    right = left.twinx()
    right.plot(agvs, [row["per_hour"] or np.nan for row in all_rows], "^:", color="0.4", label="containers per hour")
    right.set_ylabel("containers per hour")
    right.set_ylim(0, None)
    left.legend(fontsize=8, loc="upper center")
