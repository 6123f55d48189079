"""The dock with a ship-to-shore gantry, driven by the DSPs (dock.crane = "gantry")."""

from pathlib import Path
from typing import Any

import cmrc
import numpy as np
import pytest
from low_rates import QUARTER_RATES


def simulate(duration_s: float, tmp_path: Path, layout: str = "", **settings: Any) -> cmrc.Simulation:
    settings["dock.crane"] = "gantry"
    if layout:
        file = tmp_path / "layout.toml"
        file.write_text(layout, encoding="utf-8")
        settings["dock.layout"] = str(file)
    simulation = cmrc.Simulation(duration_s=duration_s, settings={"report.reference": "none", **settings})
    simulation.run()
    return simulation


def check(report: dict[str, Any], peak: float = 2e-3) -> None:
    assert sum(task["misses"] for task in report["tasks"].values()) == 0
    assert report["failures"] == [] and report["audit"]["violations"] == []
    assert set(report["pid_error"]) == {"s", "trolley", "l", "kappa"}
    assert max(report["pid_error"][joint]["peak"] for joint in ("s", "trolley", "kappa")) < peak


def test_travel_and_trolley_go_for_a_container_of_the_next_bay(tmp_path: Path) -> None:
    result = simulate(14.0, tmp_path, "[[containers]]\nx_m = 3.0\ny_m = 10.0\n", **QUARTER_RATES).result()
    signals = result.signals
    check(result.report)
    assert signals["trolley_m"][0] == pytest.approx(-8.0, abs=1e-9) and 0.0 < signals["trolley_m"][-1] < 10.0
    assert signals["s_m"][0] == pytest.approx(0.0, abs=1e-9) and 0.8 < signals["s_m"][-1] < 3.0
    assert np.ptp(signals["psi_rad"]) == 0.0  # it does not slew
    # A planner of the load's own path causes little sway besides the reference -p''/g (at most 0.4 m/s2).
    assert np.abs(signals["sway_alpha_rad"]).max() < 0.05 and np.abs(signals["sway_beta_rad"]).max() < 0.02
    place = np.stack([signals[f"payload_{axis}_m"] for axis in "xyz"])
    straight = np.stack([signals["s_m"], signals["trolley_m"]])
    assert np.abs(place[:2] - straight).max() < 1.0 and np.abs(place[2] + signals["l_m"] - 34.0).max() < 0.05


def test_it_takes_a_container(tmp_path: Path) -> None:
    simulation = simulate(
        15.5,
        tmp_path,
        "[home]\nx_m = 0.1\ny_m = 9.8\nz_m = 7.2\n[[containers]]\nx_m = 0.0\ny_m = 10.0\n",
        **QUARTER_RATES,
    )
    check(simulation.result().report, 5e-3)  # a short leg and a container's guides shake the trolley most
    events = [event[1] for event in simulation._core.dock_events()]
    assert events.index("landed") < events.index("locked") < events.index("lifted")
    assert "hard_landing" not in events and "missed" not in events


# A derivative of the measurement lags by T_d = 0.4 s times a part of the speed; the shaper's load hangs otherwise than
# the rigid feed-forward thinks.
@pytest.mark.parametrize(
    ("key", "build", "peak"),
    [
        ("kernels.torque", "newton_euler", 2e-3),
        ("kernels.pid", "measurement_derivative", 0.2),
        ("kernels.trajectory", "quintic_shaper", 5e-3),
    ],
)
def test_every_build_drives_it(tmp_path: Path, key: str, build: str, peak: float) -> None:
    result = simulate(6.0, tmp_path, **{**QUARTER_RATES, key: build}).result()
    check(result.report, peak)
    assert result.signals["trolley_m"][-1] > -7.0


def test_a_rigid_gantry_does_not_sway(tmp_path: Path) -> None:
    signals = simulate(4.0, tmp_path, **{"dock.crane_model": "rigid"}).result().signals
    assert np.abs(signals["sway_alpha_rad"]).max() == 0.0
    assert signals["payload_y_m"] == pytest.approx(signals["trolley_m"], abs=1e-9)


def test_a_failed_trolley_drive_brakes_it_and_a_gantry_has_no_luff() -> None:
    def made(joint: str, crane: str = "gantry") -> cmrc.Simulation:
        settings = {"dock.crane": crane, "duration_s": 3, "report.reference": "none"}
        return cmrc.Simulation(settings=settings, events=[{"at_s": 2, "action": "fail_drive", "joint": joint}])

    simulation = made("trolley")
    assert 'joint = "trolley"' in simulation.config.to_toml()
    simulation.run()
    signals = simulation.result().signals
    last = signals["time_s"] > 2.9
    assert np.abs(signals["trolley_rate_m_per_s"][~last]).max() > 0.1
    assert (
        np.abs(signals["trolley_rate_m_per_s"][last]).max() < 1e-6
        and np.abs(signals["l_rate_m_per_s"][last]).max() > 1e-4
    )
    with pytest.raises(
        cmrc.ConfigError, match=r'a gantry has no luff; "travel", "trolley", "hoist", "rotate" is expected'
    ):
        made("luff")
    with pytest.raises(cmrc.ConfigError, match="a slewing crane has no trolley"):
        made("trolley", "slewing")


@pytest.mark.parametrize(
    ("layout", "what"),
    [
        (
            "[[containers]]\nx_m = 0\ny_m = 39\n",
            "trolley = 39, outside its limits -33 to 38.5; so the crane cannot reach container 0",
        ),
        (
            "[[containers]]\nx_m = 205\ny_m = 10\n",
            "gantry = 205, outside its limits -200 to 200; so the crane cannot reach container 0",
        ),
        ("[home]\nz_m = 32\n", "hoist = 2, outside its limits 3 to 49; so the crane cannot reach its home"),
    ],
)
def test_what_it_cannot_reach_is_an_error(tmp_path: Path, layout: str, what: str) -> None:
    with pytest.raises(cmrc.ConfigError, match=rf"dock\.layout: .*{what}"):
        simulate(0.1, tmp_path, layout)


@pytest.mark.campaign
def test_the_last_container_and_home(tmp_path: Path) -> None:
    result = simulate(240.0, tmp_path, "[[containers]]\nx_m = 5.0\ny_m = 17.8\n").result()
    check(result.report)
    assert result.report["containers_delivered"] == 1 and result.report["tasks"]["home.crane"]["on_time"] == 1
    assert [result.signals[f"payload_{axis}_m"][-1] for axis in "xyz"] == pytest.approx([0.0, -8.0, 14.0], abs=0.05)


@pytest.mark.campaign
@pytest.mark.parametrize("agvs", [1, 3])
def test_whole_cycles(tmp_path: Path, agvs: int) -> None:
    """Processes 1 to 6 with a delivery; with more AGVs and time the whole ship, the neighbouring bays too."""
    report = simulate(180.0 if agvs == 1 else 900.0, tmp_path, **{"dock.agvs": agvs}).result().report
    check(report, 5e-3)
    assert report["containers_delivered"] == (1 if agvs == 1 else 8)
