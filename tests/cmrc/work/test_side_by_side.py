"""Crane and vehicles work side by side (ruling 38, equations (2) to (4)): the report's times against the plant's
signals."""

import json
from typing import Any

import numpy as np
import pytest
from cmrc import _core
from low_rates import LOW_RATES

cmrc = _core.cmrc
SPOT = (22.0, 8.0)
DECK, BOX, CLEARANCE = 1.6, 2.591, 0.5


def run(duration_s: float, **settings: Any) -> tuple[dict[str, Any], dict[str, np.ndarray], list[Any]]:
    simulation = cmrc.Simulation(cmrc.config(settings={**LOW_RATES, "dsps": 2, "duration_s": duration_s, **settings}))
    simulation.run()
    report = json.loads(simulation.report_json())
    assert report["failures"] == [] and report["audit"]["violations"] == []
    return report, simulation.signals(), simulation.dock_events()


@pytest.mark.campaign
def test_the_crane_waits_above_the_spot_and_aligns_with_the_vehicle_that_comes() -> None:
    # At half its speed the vehicle needs 150 s for its way, the crane 114 s for process 3.
    report, signals, events = run(250, agv_interval_refreshes=80)
    first, second = report["cycles"][:2]
    assert first["t_v_s"] == 0 and first["t_w_s"] == 0 and 10 < second["t_v_s"] < 60
    assert first["T_g_s"] == pytest.approx(first["t_3_s"] + first["t_4_s"], abs=1e-9)
    assert second["T_g_s"] == pytest.approx(second["t_3_s"] + second["t_4_s"] + second["t_v_s"], abs=1e-9)
    assert first["t_wait_s"] == pytest.approx(second["t_4_s"], abs=1e-9)
    assert first["T_a_s"] == pytest.approx(
        second["T_g_s"], abs=1e-9
    )  # one crane, one vehicle: they meet once per cycle
    # The load hangs at rest above the nominal spot from the end of process 3 until the vehicle stands there; then it is
    # moved over it.
    time, load = signals["time_s"], np.stack([signals["payload_x_m"], signals["payload_y_m"]])
    opened = [at for at, kind, *_ in events if kind == "opened"]
    above = (np.hypot(load[0] - SPOT[0], load[1] - SPOT[1]) < 0.01) & (time > first["T_g_s"] + 20)
    begun = time[above][0]
    came = time[
        (time > begun)
        & (np.hypot(signals["agv0_x_m"] - SPOT[0], signals["agv0_y_m"] - SPOT[1]) < 0.2)
        & (np.abs(signals["agv0_speed_m_per_s"]) < 1e-3)
    ][0]
    assert came - begun == pytest.approx(
        second["t_v_s"], abs=6
    )  # the last centimetre takes the load some seconds, and settling one
    waiting = (time > begun + 4) & (time < came)
    assert np.hypot(load[0] - SPOT[0], load[1] - SPOT[1])[waiting].max() < 0.03
    assert signals["payload_z_m"][waiting].min() > DECK + BOX + CLEARANCE - 0.03
    at_handover = time.searchsorted(opened[-1])
    assert opened[-1] > came
    offset = [load[k][at_handover] - signals[f"agv0_{axis}_m"][at_handover] for k, axis in enumerate("xy")]
    assert np.hypot(*offset) < 0.02


@pytest.mark.campaign
@pytest.mark.parametrize("agvs", [2, 4])
def test_with_more_vehicles_they_wait_and_the_crane_does_not(agvs: int) -> None:
    report, _, _ = run(330 + 60 * agvs, agvs=agvs)
    closed = [cycle for cycle in report["cycles"] if cycle["T_a_s"] is not None]
    loaded = [cycle for cycle in report["cycles"] if cycle["T_g_s"] is not None]
    assert closed and all(cycle["t_v_s"] == 0 and cycle["t_w_s"] > 0 for cycle in closed)
    for cycle in closed:
        assert cycle["T_a_s"] == pytest.approx(cycle["t_5_s"] + cycle["t_6_s"] + cycle["t_wait_s"], abs=1e-9)
        again = next(later for later in loaded if later["number"] > cycle["number"] and later["agv"] == cycle["agv"])
        between = [later["T_g_s"] for later in loaded if cycle["number"] < later["number"] <= again["number"]]
        assert cycle["T_a_s"] == pytest.approx(
            sum(between), abs=1e-9
        )  # from one loading to the next, while the crane works through
        assert cycle["t_wait_s"] - cycle["t_w_s"] == pytest.approx(again["t_4_s"], abs=1e-9)
