"""Ruling 40: with run.phase_jitter every clock except the drives' latch gets a phase and whole ppm, from run.seed."""

import json
import subprocess
from fractions import Fraction
from math import ceil, floor
from pathlib import Path
from typing import Any

import pytest
from cmrc import _core
from cmrc_test import run_setup, scheduling
from locations import BUILD

cmrc, plant = _core.cmrc, _core.plant
LATCH_PS = 125_000_000
MS = 1_000_000_000


def config(seed: int = 1, jitter: bool = True, **settings: Any) -> Any:
    return cmrc.config(
        settings={"seed": seed, "phase_jitter": jitter, "dsps": 3, "report.reference": "none", **settings}
    )


def clocks(seed: int = 1, jitter: bool = True, **settings: Any) -> dict[str, dict[str, Any]]:
    return {one["name"]: one for one in scheduling.oscillators(config(seed, jitter, **settings))}


def run(seed: int = 1, jitter: bool = True, **settings: Any) -> dict[str, Any]:
    simulation = cmrc.Simulation(config(seed, jitter, **{"duration_s": 0.06, **settings}))
    simulation.run()
    report: dict[str, Any] = json.loads(simulation.report_json())
    assert report["audit"]["violations"] == []
    return report


# ---- what is drawn


def test_every_clock_but_the_latch_is_drawn() -> None:
    nominal = clocks(jitter=False, agvs=2)
    assert {name: one["nominal_hz"] for name, one in nominal.items()} == pytest.approx({
        "host timer": 8000, "PCI A": 1e8 / 3, "PCI B": 1e8 / 3, "DSP 0": 25e6, "DSP 1": 25e6, "DSP 2": 25e6, "sway sensor": 100, "AGV unit 0": 100, "AGV unit 1": 100,
    })  # fmt: skip
    assert all(one["ppm"] == one["phase_ps"] == 0 for one in nominal.values())
    drawn = clocks(agvs=2)
    assert drawn.keys() == nominal.keys()
    assert len({one["ppm"] for one in drawn.values()}) > 5 and len({one["phase_ps"] for one in drawn.values()}) == len(
        drawn
    )


def test_phases_stay_within_a_period_and_ppm_within_100_and_both_fill_their_range() -> None:
    ppm: list[int] = []
    parts: list[float] = []
    for seed in range(300):
        for one in clocks(seed, agvs=8).values():
            ppm.append(one["ppm"])
            assert one["period_ps"] == pytest.approx(1e12 / one["nominal_hz"] / (1 + one["ppm"] * 1e-6), abs=1)
            assert 0 <= one["phase_ps"] < one["period_ps"]
            parts.append(one["phase_ps"] / one["period_ps"])
    assert set(ppm) == set(range(-100, 101))
    assert (
        abs(sum(ppm)) / len(ppm) < 5
        and abs(sum(parts) / len(parts) - 0.5) < 0.03
        and min(parts) < 0.01
        and max(parts) > 0.99
    )


def test_a_clock_is_its_own_whatever_stands_beside_it() -> None:
    few, many = clocks(dsps=1, agvs=1), clocks(dsps=16, agvs=8)
    assert all(many[name] == one for name, one in few.items())


def test_the_range_sensor_has_a_clock_where_it_has_a_rate(tmp_path: Path) -> None:
    layout = tmp_path / "layout.toml"
    layout.write_text("[sensors]\nrange_rate_hz = 20\n")
    assert "range sensor 0" not in clocks()
    sensor = clocks(**{"dock.layout": str(layout)})["range sensor 0"]
    assert sensor["nominal_hz"] == 20 and 0 <= sensor["phase_ps"] < sensor["period_ps"]
    dock = plant.Dock(run_setup.dock_of(config(**{"dock.layout": str(layout)})))
    changes, shown = [], dock.range_scan(0, 0)
    for at in range(1, 400):  # ms
        if (number := dock.range_scan(0, at * MS)) != shown:
            changes.append(at)
            assert number == (shown + 1) % 2**32  # -1 before the first
            shown = number
    period = Fraction(50 * MS * 1_000_000, 1_000_000 + sensor["ppm"])
    assert changes == [ceil((sensor["phase_ps"] + n * period) / MS) for n in range(8)][: len(changes)] and len(
        changes
    ) in (7, 8)


# ---- what a run makes of it


def test_the_seed_decides_the_run_with_jitter_and_nothing_else_does() -> None:
    first = run(1)["hash"]
    assert run(1)["hash"] == first  # bit for bit
    assert len({run(seed)["hash"] for seed in (1, 2, 3)}) == 3
    assert run(1, jitter=False)["hash"] != first


def test_without_jitter_the_seed_changes_nothing_while_nothing_else_is_random(tmp_path: Path) -> None:
    """What the sway sensors show has noise by the seed: it is in the final state, but no program reads it in the first
    refreshes."""

    def events(seed: int, jitter: bool) -> str:
        trace = tmp_path / "trace"
        options = [
            "--dsps",
            "3",
            "--seed",
            str(seed),
            "--duration",
            "0.0209",
            "--set",
            "report.reference=none",
            "--set",
            f"run.phase_jitter={str(jitter).lower()}",
        ]
        subprocess.run([BUILD / "bin" / "emulator", "--quiet", "--trace", trace, *options], check=True)
        return trace.read_text()

    assert len({events(seed, False) for seed in (1, 2, 3)}) == 1
    assert len({events(seed, True) for seed in (1, 2, 3)}) == 3


def test_turn_orders_change_nothing_with_jitter_on() -> None:
    for settings in (
        {"preset": "saturated"},
        {"bus.topology": "host_on_both"},
        {"topology.bridges": "A-B", "topology.boards": "A"},
    ):
        settings = dict(settings)
        preset = settings.pop("preset", "base")
        hashes = set()
        for order in (0, 1, 2, 3):
            simulation = cmrc.Simulation(
                cmrc.config(
                    preset=preset,
                    settings={
                        "phase_jitter": True,
                        "dsps": 3,
                        "duration_s": 0.05,
                        "report.reference": "none",
                        "turn_order": order,
                        **settings,
                    },
                )
            )
            simulation.run()
            hashes.add(json.loads(simulation.report_json())["hash"])
        assert len(hashes) == 1, settings


def test_chips_and_buses_count_by_their_own_clocks() -> None:
    duration = 0.25
    for seed in (1, 2):
        drawn, report = clocks(seed), run(seed, duration_s=duration)
        for slot, dsp in enumerate(report["dsps"]):
            own = drawn[f"DSP {slot}"]
            cycles = (Fraction(duration) * 10**12 - own["phase_ps"]) * 25 * (1_000_000 + own["ppm"]) / 10**12
            assert abs(dsp["cycles"] - cycles) < 2, slot
        for name in ("A", "B"):
            own = drawn[f"PCI {name}"]
            clock = (
                (Fraction(duration) * 10**12 - own["phase_ps"]) * Fraction(100, 3) * (1_000_000 + own["ppm"]) / 10**12
            )
            assert abs(report["buses"][name]["clocks"] - clock) < 3, name
    assert len({dsp["cycles"] for dsp in report["dsps"]}) == 3


def test_releases_stand_on_the_hosts_own_timer() -> None:
    for seed in (1, 4):
        timer = clocks(seed)["host timer"]
        simulation = cmrc.Simulation(
            cmrc.config(
                preset="saturated",
                settings={"seed": seed, "phase_jitter": True, "dsps": 1, "duration_s": 0.1, "report.reference": "none"},
            )
        )
        simulation.run()
        missed = [miss for miss in json.loads(simulation.report_json())["misses"] if miss["kind"] == "pid"]
        assert len(missed) > 10
        for miss in missed:
            assert (
                sum(miss["parts_ps"].values()) == miss["lateness_ps"]
            )  # to the picosecond, chips off their nominal clocks
            tick = Fraction(10**12 * 1_000_000, 8000 * (1_000_000 + timer["ppm"]))
            assert miss["release_ps"] == timer["phase_ps"] + floor(8 * miss["number"] * tick)


def test_buses_that_a_bridge_joins_run_on_one_clock() -> None:
    joined = run(duration_s=0.03, **{"topology.bridges": "A-B", "topology.boards": "A"})["buses"]
    apart = run(duration_s=0.25)["buses"]
    assert joined["A"]["clocks"] == joined["B"]["clocks"] and apart["A"]["clocks"] != apart["B"]["clocks"]
    assert joined["A"]["clock_ppm"] == joined["B"]["clock_ppm"] != 0


@pytest.mark.parametrize("settings", [{}, {"cycle_time_factor": 1.25}, {"ideal": True}], ids=str)
@pytest.mark.parametrize("jitter", [False, True])
def test_the_report_has_the_clocks_that_ran(jitter: bool, settings: dict[str, Any]) -> None:
    """Counted cycles and clocks are those of the nominal clock and its ppm. Those of the ideal run have none."""
    report = run(jitter=jitter, duration_s=1.0, **settings)
    drawn = clocks(jitter=jitter, **settings)
    of_chips = {f"DSP {dsp['slot']}": (dsp["clock_hz"], dsp["clock_ppm"], dsp["cycles"]) for dsp in report["dsps"]}
    of_buses = {
        f"PCI {name}": (bus["clock_hz"], bus["clock_ppm"], bus["clocks"]) for name, bus in report["buses"].items()
    }
    for name, (nominal_hz, ppm, counted) in {**of_chips, **of_buses}.items():
        assert (nominal_hz, ppm) == (pytest.approx(drawn[name]["nominal_hz"], rel=1e-12), drawn[name]["ppm"])
        assert abs(counted - nominal_hz * (1 + ppm * 1e-6)) < 100, name
    assert any(ppm for _, ppm, _ in {**of_chips, **of_buses}.values()) == (jitter and "ideal" not in settings)


def test_an_event_slow_is_no_other_clock() -> None:
    slow = {"at_s": 0.02, "action": "slow", "dsp": 1, "factor": 0.5}
    simulation = cmrc.Simulation(
        cmrc.config(settings={"dsps": 2, "duration_s": 0.06, "report.reference": "none"}, events=[slow])
    )
    simulation.run()
    whole, half = json.loads(simulation.report_json())["dsps"]
    assert whole["clock_hz"] == half["clock_hz"] and whole["clock_ppm"] == half["clock_ppm"] == 0
    assert half["cycles"] == pytest.approx(whole["cycles"] * (0.02 + 0.5 * 0.04) / 0.06, rel=1e-3)


# ---- the plant's clocks


def test_the_sway_sensor_samples_at_the_first_latch_after_its_ticks() -> None:
    for seed in (1, 2, 3):
        sensor = clocks(seed)["sway sensor"]
        dock = plant.Dock(run_setup.dock_of(config(seed)))
        shown, changes = (dock.sway(0, 0), dock.sway(1, 0)), []
        for latch in range(1, 8000):
            now = (dock.sway(0, latch * LATCH_PS), dock.sway(1, latch * LATCH_PS))
            if now != shown:
                changes.append(latch)
                shown = now
        period = Fraction(10_000_000_000 * 1_000_000, 1_000_000 + sensor["ppm"])
        ticks = {ceil((sensor["phase_ps"] + n * period) / LATCH_PS) for n in range(101)}
        assert len(changes) > 60 and set(changes) <= ticks, seed  # noise: most samples differ from the one before


def test_an_agv_units_drive_ticks_by_its_own_clock() -> None:
    for seed in (1, 2, 3):
        unit = clocks(seed)["AGV unit 0"]
        dock = plant.Dock(run_setup.dock_of(config(seed)))
        dock.agv_push(0, 1000, 0, 0, 0)
        moved = next(
            ms for ms in range(1, 60) if dock.agv_status(0, ms * MS) & 0x10 == 0
        )  # no longer standing: its first tick with a set-point
        period = Fraction(10 * MS * 1_000_000, 1_000_000 + unit["ppm"])
        assert moved == next(tick for n in range(3) if (tick := ceil((unit["phase_ps"] + n * period) / MS)) >= 1), seed


def test_an_agv_unit_holds_set_points_by_its_own_clock() -> None:
    """Each is taken at the unit's first step of 1 ms after the one before has been held: with a slow clock a step later
    than with an exact one."""
    slow = next(seed for seed in range(1, 100) if clocks(seed)["AGV unit 0"]["ppm"] < -50)
    for seed, jitter in ((slow, True), (slow, False)):
        ppm = clocks(seed, jitter)["AGV unit 0"]["ppm"]
        dock = plant.Dock(run_setup.dock_of(config(seed, jitter)))
        dock.agv_period(0, 20_000, 0)
        dock.agv_push(0, 1000, 0, 0, 0)
        taken = []
        for ms in range(1, 2000):
            if dock.agv_status(0, ms * MS) & 0xF == 0:
                taken.append(ms)
                dock.agv_push(0, 1000, 0, 0, ms * MS)
        held = Fraction(20 * MS * 1_000_000, 1_000_000 + ppm)
        assert taken == [ceil((MS + n * held) / MS) for n in range(100)]
    assert ppm == 0 and taken[1] == 21


def test_the_drives_latch_stays_on_its_grid() -> None:
    simulation = cmrc.Simulation(config(3, duration_s=0.05))
    simulation.run()
    instants = simulation.signals()["time_s"]
    assert all(abs(t / 125e-6 - round(t / 125e-6)) < 1e-6 for t in instants)


# ---- the ideal run; where it does not apply


def test_the_ideal_run_keeps_the_clocks_of_what_is_released_and_sampled() -> None:
    """Chips and buses have no clocks of their own there: their work takes no time."""
    drawn, ideal = clocks(5, agvs=2), clocks(5, agvs=2, ideal=True)
    for name, one in ideal.items():
        if name.startswith(("DSP", "PCI")):
            assert one["ppm"] == one["phase_ps"] == 0, name
        else:
            assert one == drawn[name], name


def test_a_perfect_run_misses_nothing_against_its_ideal_run_whatever_the_phases() -> None:
    for seed in range(6):
        simulation = cmrc.Simulation(
            cmrc.config(preset="base", settings={"seed": seed, "phase_jitter": True, "dsps": 4, "duration_s": 0.3})
        )
        simulation.run()
        for name, rate in json.loads(simulation.report_json())["rates"].items():
            assert rate["missed_share"] in (0, None), (seed, name, rate)


def test_a_clock_that_cannot_be_kept_exactly_is_refused() -> None:
    with pytest.raises(
        cmrc.ConfigError,
        match=r"run.phase_jitter: host timer at 8000001/1000 Hz and -?\d+ ppm cannot be represented exactly",
    ):
        cmrc.Simulation(config(refresh_frequency_hz=8000.001))
    cmrc.Simulation(config(jitter=False, refresh_frequency_hz=8000.001))
