"""Learning of N^_a over a run of several cycles. With two AGVs the crane is the slower (case A): an AGV waits some 70 s a cycle, and slows."""

import json
from typing import Any

import pytest
from cmrc import _core

cmrc = _core.cmrc


def cycles(learning: str, **settings: Any) -> list[dict[str, Any]]:
    simulation = cmrc.Simulation(cmrc.config(settings={"duration_s": 700, "dsps": 4, "agvs": 2, "learning": learning, **settings}))
    simulation.run()
    report = json.loads(simulation.report_json())
    assert report["audit"]["violations"] == []
    return list(report["cycles"])


def of_agv(run: list[dict[str, Any]], agv: int, name: str) -> list[float]:
    return [cycle[name] for cycle in run if cycle["agv"] == agv and cycle[name] is not None]


@pytest.mark.campaign
def test_the_proportional_rule_takes_the_waiting_away() -> None:
    off, learned = cycles("off"), cycles("proportional")
    for agv in (0, 1):
        before, after = of_agv(off, agv, "t_w_s"), of_agv(learned, agv, "t_w_s")
        assert len(after) >= 2 and min(before) > 20
        # At most 10 % of N^_a per cycle, so some 10 % of 68 s of driving less to wait from the second cycle on.
        assert all(later < earlier - 3 for earlier, later in zip(after, after[1:], strict=False))
    crane = [[cycle["T_g_s"] for cycle in run if cycle["T_g_s"] is not None] for run in (off, learned)]
    assert crane[1] == pytest.approx(crane[0][: len(crane[1])], rel=0.02)  # and the crane does not lose by it


@pytest.mark.campaign
def test_the_unit_rule_takes_a_step_of_one_per_cycle() -> None:
    run = cycles("unit")
    for agv in (0, 1):
        driving = [b + a for b, a in zip(of_agv(run, agv, "t_5_s"), of_agv(run, agv, "t_6_s"), strict=False)]
        # One refresh more per point of 160: some 68 s of driving take 1/160 longer, 0.42 s, from the cycle on after the first t_w is known.
        assert len(driving) >= 3
        assert driving[-1] - driving[-2] == pytest.approx(0.42, abs=0.15)
