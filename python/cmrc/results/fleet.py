"""Claim 6: more AGVs cure case B."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from cmrc.results.claim import Claim, parameter
from cmrc.results.judgement import Row, Verdict, counted, markdown, with_interval
from cmrc.results.learning import SLOW, longer_lane, slow_rates
from cmrc.results.runs import Report, Reports, Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Fleet(Claim):
    """More and more AGVs, so slow that one is too few."""

    NUMBER, NAME = 6, "fleet"
    TITLE = "More AGVs cure case B, in which the crane waits (t_v > 0)"

    LABELS: ClassVar = {"agvs": "{} AGVs", "lane_m": "lane {} m longer"}

    agvs: tuple[int, ...] = parameter((1, 2, 3), "numbers of AGVs", quick=(1, 2))
    agv_speed_m_s: float = parameter(1.5, "dock.agv_speed_m_s: so slow that one AGV is too few")
    dsps: int = parameter(1, "DSPs")
    duration_s: float = parameter(520.0, "length of a run, s", quick=1.0)
    lanes_m: tuple[float, ...] = parameter(
        (0.0,), "layouts: the lane's turn is so many m farther east of the loading spot", quick=(0.0,), least=-math.inf
    )

    def runs(self) -> list[Run]:
        return [
            Run(
                {"agvs": agvs, "lane_m": lane},
                {**SLOW, "machine.dsps": self.dsps, "dock.agvs": agvs, "dock.agv_speed_m_s": self.agv_speed_m_s},
                self.duration_s,
                layout=longer_lane(lane, max(self.agvs)),
            )
            for agvs in self.agvs
            for lane in self.lanes_m
        ]

    def rows(self, done: Sequence[tuple[Run, Reports]]) -> list[Row]:
        """One row per number of AGVs, over all layouts; the means leave out the first round of all AGVs, for which they
        wait at the spot."""
        table = []
        for agvs in self.agvs:
            reports = [of[-1] for run, of in done if run.label["agvs"] == agvs]
            cycles = [c for report in reports for c in report["cycles"][agvs:] if c["T_g_s"] is not None]
            waited = [c["t_w_s"] for c in cycles if c["t_w_s"] is not None]
            rates = [rate for report in reports if (rate := per_hour(report)) is not None]
            table.append(
                {
                    "agvs": agvs,
                    "cycles": len(cycles),
                    "t_v_s": float(np.mean([c["t_v_s"] for c in cycles])) if cycles else None,
                    "t_v": with_interval([c["t_v_s"] for c in cycles], 1),
                    "t_w_s": float(np.mean(waited)) if waited else None,
                    "t_w": with_interval(waited, 1),
                    "T_g_s": float(np.mean([c["T_g_s"] for c in cycles])) if cycles else None,
                    "T_g": with_interval([c["T_g_s"] for c in cycles], 1),
                    "per_hour": float(np.mean(rates)) if rates else None,
                    "misses": sum(counted(report) for report in reports),
                }
            )
        return table

    def verdict(self, all_rows: Sequence[Row]) -> Verdict:
        known = [row for row in all_rows if row["t_v_s"] is not None]
        if len(known) < 2:
            return Verdict("not tested", "No second work cycle was loaded.", "")
        first = known[0]
        share = first["t_v_s"] / first["T_g_s"]
        if share < 0.02:
            return Verdict(
                "not tested",
                f"With {first['agvs']} AGV the crane waits {share:.1%} of its cycle: this is not case B.",
                "",
            )
        why = f"With {first['agvs']} AGV the crane waits {first['t_v']} s of each cycle of {first['T_g_s']:.0f} s."
        cured = next((row for row in known if row["t_v_s"] < 0.02 * row["T_g_s"]), None)
        if cured is None:
            least = min(known, key=lambda row: float(row["t_v_s"]))
            word = "holds in part" if least["t_v_s"] < 0.7 * first["t_v_s"] else "fails"
            return Verdict(word, why, f"The least was {least['t_v_s']:.0f} s, with {least['agvs']} AGVs.")
        limit = f"{cured['agvs']} are enough (t_v {cured['t_v']} s)."
        beyond = [row for row in known if row["agvs"] > cured["agvs"]]
        if beyond and cured["per_hour"] and beyond[-1]["per_hour"]:
            limit += (
                f" From there on the crane is the limit: {beyond[-1]['agvs']} AGVs deliver "
                f"{beyond[-1]['per_hour']:.0f} containers per hour, {cured['agvs']} deliver {cured['per_hour']:.0f}."
            )
        return Verdict("holds", why, limit)

    def section(self, all_rows: Sequence[Row]) -> str:
        columns = {
            "agvs": "AGVs",
            "cycles": "cycles",
            "t_v": "t_v, s",
            "t_w": "t_w, s",
            "T_g": "T_g, s",
            "per_hour": "containers per hour",
            "misses": "missed deadlines",
        }
        return (
            f"AGVs of at most {self.agv_speed_m_s:g} m/s, {self.dsps} DSP, {SLOW['dock.containers']} containers, "
            f"{self.duration_s:g} s each. {slow_rates()}. The lane turns "
            f"{', '.join(f'{lane:g}' for lane in self.lanes_m)} m farther east than in the default layout, and in all "
            f"runs its straight before the spot has room for {max(self.agvs)} AGVs; no seed is varied. Means, with 95 % intervals (bootstrap) where the cycles differ, over "
            "the work cycles after the first round of all AGVs, which stand ready for it; containers per hour over the "
            "whole of a run, from its first delivery to its last:\n\n" + markdown(columns, all_rows)
        )

    def draw(self, all_rows: Sequence[Row], figure: Figure) -> None:
        left = figure.subplots()
        agvs = [row["agvs"] for row in all_rows]
        left.plot(agvs, [row["t_v_s"] for row in all_rows], "o-", label="t_v: the crane waits")
        left.plot(agvs, [row["t_w_s"] for row in all_rows], "s--", label="t_w: an AGV waits")
        left.set(xlabel="AGVs", ylabel="s per cycle", xticks=agvs)
        left.margins(y=0.1)
        right = left.twinx()
        right.plot(
            agvs, [row["per_hour"] or np.nan for row in all_rows], "^:", color="0.4", label="containers per hour"
        )
        right.set_ylabel("containers per hour")
        right.set_ylim(0, 1.15 * max(row["per_hour"] or 1.0 for row in all_rows))
        lines = [*left.get_lines(), *right.get_lines()]
        left.legend(lines, [str(line.get_label()) for line in lines], fontsize=8, loc="center right")


def per_hour(report: Report) -> float | None:
    """Containers delivered per hour, from the first delivery to the last."""
    delivered = [c["delivered_s"] for c in report["cycles"] if c["delivered_s"] is not None]
    return (len(delivered) - 1) / (delivered[-1] - delivered[0]) * 3600 if len(delivered) > 1 else None
