"""Ruling 39: when sub-process 5 runs, and at which refreshes it is released: by interval, and by what an AGV's range
sensor sees."""

import itertools
import json
import re
import subprocess
from pathlib import Path
from typing import Any

import chain_replay
import pytest
from cmrc import _core
from cmrc_test import run_setup, scheduling
from locations import BUILD
from traced_run import events_of

cmrc, plant = _core.cmrc, _core.plant
EMULATOR = BUILD / "bin" / "emulator"
AVOIDANCE = 11
REFRESH_HZ = 8000
N_A = 160  # refreshes: 8000 Hz / 50 Hz


def rows(release: str, more: str = "on_legs = true") -> str:
    return f'[[subprocesses]]\nnumber = 5\nname = "obstacle avoidance"\nagv = "obstacle_avoidance"\nrelease = "{release}"\n{more}\n'


def run(
    tmp_path: Path, toml: str = "", **settings: Any
) -> tuple[dict[int, list[int]], list[tuple[int, int]], dict[str, Any]]:
    """By AGV: the refreshes at which avoidance was loaded, and those at which a release was dropped, with the block in
    its way. And the report."""
    options = [part for key, value in settings.items() for part in ("--set", f"{key}={value}")]
    events, report = events_of(tmp_path, *options, toml=toml)
    loads: dict[int, list[int]] = {}
    drops = []
    areas = sorted({n["area"] for _, _, name, n in events if name == "load" and n["kind"] == AVOIDANCE})
    for _, _, name, n in events:
        if name == "load" and n["kind"] == AVOIDANCE:
            loads.setdefault(areas.index(n["area"]), []).append(n["tick"])
        elif name == "miss" and n["kind"] == AVOIDANCE and n["class"] == chain_replay.DROPPED:
            drops.append((n["tick"], n["block"]))
    return loads, drops, report


# ---- which processes run it


def test_a_parked_vehicle_has_no_avoidance_but_under_the_parked_load(tmp_path: Path) -> None:
    short = {"dock.agvs": 3, "load.avoidance_cycles": 1000, "run.duration_s": 0.101}
    loads, _, report = run(tmp_path, **short)
    assert loads == {} and report["tasks"]["obstacle_avoidance"]["released"] == 0
    # ... as it was before ruling 39: each AGV once per interval, the first time one interval after the start, all at
    # once.
    loads, _, _ = run(tmp_path, **short, **{"load.parked": "true", "scheduling.agv_phase": "together"})
    assert loads == {agv: [320, 480, 640, 800] for agv in range(3)}


def test_it_runs_in_the_processes_that_list_it_only(tmp_path: Path) -> None:
    without = '[[processes]]\nnumber = 6\nname = "to the dock"\nrobot = "agv"\nsubprocesses = [1, 2]\nsteps = ["queue"]\nmay = [4]\n'
    driving = {"load.driving": "true", "load.avoidance_cycles": 1000, "run.duration_s": 0.101}
    assert run(tmp_path, without, **driving)[0] == {}
    assert run(tmp_path, "", **driving)[0] != {}


# ---- at which refreshes


@pytest.mark.parametrize(
    ("agvs", "phases"), [(1, [0]), (2, [0, 80]), (3, [0, 53, 106]), (8, [0, 20, 40, 60, 80, 100, 120, 140])]
)
def test_releases_by_interval_fall_on_refreshes_of_their_own(tmp_path: Path, agvs: int, phases: list[int]) -> None:
    options = {"load.driving": "true", "load.avoidance_cycles": 1000, "dock.agvs": agvs, "run.duration_s": 0.101}
    loads, drops, _ = run(tmp_path, **options)
    assert drops == []
    for agv, phase in enumerate(phases):
        assert loads[agv] == [tick for tick in range(N_A + 1, 802) if tick % N_A == phase], agv
    loads, _, _ = run(tmp_path, **options, **{"scheduling.agv_phase": "together"})
    assert all(loads[agv] == [320, 480, 640, 800] for agv in range(agvs))


def test_the_demand_does_not_fall_when_the_dsps_cannot_follow(tmp_path: Path) -> None:
    """Late blocks do not postpone a release. A release that is not possible is dropped, and counts as missed."""
    counted = []
    for dsps in (1, 6):
        options = {
            "machine.dsps": dsps,
            "dock.agvs": 4,
            "load.driving": "true",
            "load.avoidance_cycles": 330000,
            "run.duration_s": 0.3,
        }
        loads, drops, report = run(tmp_path, **options)
        task = report["tasks"]["obstacle_avoidance"]
        assert task["dropped"] == len(drops) and task["released"] == len(drops) + sum(map(len, loads.values()))
        assert all(tick % N_A in (0, 40, 80, 120) for ticks in loads.values() for tick in ticks)
        counted.append((task["released"], task["dropped"], task["misses"]))
    assert counted[0][0] == counted[1][0] == sum(tick % N_A in (0, 40, 80, 120) for tick in range(N_A + 1, 2400))
    assert counted[0][1] > 20 and counted[1][1:] == (0, 0)


def steps(
    release: str,
    ticks: list[tuple[int, int]],
    number: int = 1,
    count: int = 4,
    ends: set[int] | None = None,
    objects: set[int] | None = None,
    rests: set[int] | None = None,
) -> list[tuple[bool, list[int]]]:
    """Steps by `ticks`, pairs of refresh and interval. Blocks end at the refreshes of `ends` (without: before the next
    refresh)."""
    table = [
        (tick, interval, tick not in (rests or set()), tick in (objects or set()), ends is None or tick in ends)
        for tick, interval in ticks
    ]
    return list(scheduling.release_steps(release, number, count, True, table))


def loaded(found: list[tuple[bool, list[int]]], ticks: list[tuple[int, int]]) -> list[int]:
    return [tick for (load, _), (tick, _) in zip(found, ticks, strict=True) if load]


def test_a_new_interval_is_followed_from_the_refresh_at_which_it_comes() -> None:
    """AGV 1 of 4: 40 modulo 160, then 50 modulo 200. The gap between the last release of the old and the first of the
    new is that of the two grids."""
    ticks = [(tick, 160 if tick <= 500 else 200) for tick in range(1, 1000)]
    assert loaded(steps("interval", ticks), ticks) == [40, 200, 360, 650, 850]
    ticks = [(tick, 160 if tick <= 648 else 200) for tick in range(1, 1000)]
    assert loaded(steps("interval", ticks), ticks) == [
        40,
        200,
        360,
        520,
        650,
        850,
    ]  # never twice at one refresh, but 130 apart


def test_a_late_host_drops_what_it_has_passed_and_releases_the_last() -> None:
    ticks = [(1, 100), (30, 100), (290, 100), (291, 100), (325, 100)]  # 25 modulo 100: 25; 125, 225; none; 325
    assert steps("interval", ticks) == [(False, []), (True, []), (True, [125]), (False, []), (True, [])]


def test_a_block_that_is_out_past_its_deadline_drops_the_release() -> None:
    ticks = [(tick, 100) for tick in range(1, 430)]
    found = steps("interval", ticks, ends={300})
    assert loaded(found, ticks) == [25, 325]
    assert [dropped for _, dropped in found if dropped] == [[125], [225], [425]]


def test_what_did_not_run_owes_nothing() -> None:
    ticks = [(tick, 100) for tick in range(1, 430)]
    found = steps("interval", ticks, rests=set(range(100, 300)))
    assert loaded(found, ticks) == [25, 325, 425] and not any(dropped for _, dropped in found)


# ---- by event


def test_an_object_enters_where_nothing_was_or_nearer_by_a_jump() -> None:
    readings_mm = {
        "nothing": [(30000, False)],
        "enters": [(14000, True)],
        "closer": [(13990, False), (13400, False)],
        "700 nearer: another": [(12700, True)],
        "closer again": [(12690, False)],
        "gone": [(30000, False)],
        "at the field's end": [(15000, False)],
        "enters again": [(14999, True)],
        "stays": [(14999, False)],
        "another again": [(3000, True)],
    }
    readings, entered = zip(*(row for rows in readings_mm.values() for row in rows), strict=True)
    assert scheduling.objects_entered(list(readings), 15000) == list(entered)
    assert scheduling.objects_entered([4000], 15000) == [True]  # there when the first reading is made
    assert scheduling.objects_entered([4000], 3000) == [False]


def test_an_event_releases_at_once_and_waits_for_a_block_that_is_out() -> None:
    ticks = [(tick, 100) for tick in range(1, 200)]
    assert loaded(steps("event", ticks, objects={7}), ticks) == [7]
    assert loaded(steps("event", ticks, objects={7, 9}, ends={20}), ticks) == [7, 20]
    assert loaded(steps("interval", ticks, objects={7}), ticks) == [25, 125]
    both = steps("interval_and_event", ticks, objects={110})
    assert loaded(both, ticks) == [25, 110, 125]
    # The block that the event has released replaces the one at 125: its deadline is 210.
    both = steps("interval_and_event", ticks, objects={110}, ends={50})
    assert loaded(both, ticks) == [25, 110] and not any(dropped for _, dropped in both)


SUDDEN = """
[[movers]]
radius_m = 0.3
path = [[0.0, 36.0, 14.0], [0.06, 36.0, 14.0], [0.07, 36.0, 8.0]]
"""


@pytest.mark.parametrize("topology", ["host_on_both", "sensors_with_host", "single"])
def test_what_comes_into_the_field_releases_avoidance(tmp_path: Path, topology: str) -> None:
    """A post appears in the lane 6.6 m before the vehicle, between 60 and 70 ms. The vehicle starts at 20 ms, and its
    way reaches 1.8 m to either side."""
    layout = tmp_path / "layout.toml"
    layout.write_text(SUDDEN)
    options = {
        "bus.topology": topology,
        "dock.layout": str(layout),
        "load.driving": "true",
        "load.avoidance_cycles": 1000,
        "run.duration_s": 0.101,
    }
    loads, _, report = run(tmp_path, rows("event"), **options)
    (tick,) = loads[0]
    # It enters at y = 8 + 1.8 + 0.3, after two thirds of its way; the host reads each ms, and releases in that refresh.
    assert 0.065 <= tick / REFRESH_HZ <= 0.065 + 0.004
    bus = "B" if topology == "host_on_both" else "A"
    host = report["buses"][bus]["masters"]["host"]
    assert host["words_read"] >= 79 if bus == "B" else host["words_read"] > 0
    loads, _, _ = run(tmp_path, rows("interval_and_event"), **options)
    assert loads[0] == sorted([tick, 320, 480, 640, 800])
    every_200 = run(tmp_path, rows("event"), **options, **{"scheduling.event_read_refreshes": 200})[0]
    assert every_200[0] == [600]  # readings at refreshes 200, 400, 600
    assert run(tmp_path, rows("event"), **options, **{"scheduling.event_field_m": 6})[0] == {}


def test_the_register_is_the_nearest_echo_in_the_vehicles_way() -> None:
    config = run_setup.dock_of(cmrc.config(settings={"agvs": 2}))
    dock = plant.Dock(config)
    # AGV 1 stands 18 m behind AGV 0, both 14.8 m long: 3.2 m between them. Before AGV 0 nothing is within 30 m.
    assert dock.range_way(0, 0) == 30000
    assert dock.range_way(1, 0) == pytest.approx(3200, abs=8)


# ---- what is refused


@pytest.mark.parametrize(("toml", "settings", "says"), [
    (rows("event"), {}, r"own.toml:1:1: subprocesses.release: sub-process 5 is released by event, but the host cannot reach the range sensors on bus B; .*host_on_both"),
    (rows("event"), {"bus.topology": "host_on_both", "topology.sensors": "B", "topology.host": "A"}, "the host cannot reach the range sensors on bus B"),
    (rows("interval_and_event"), {"bus.topology": "single", "scheduling.event_read_refreshes": 401}, "a range sensor is read every 50.125 ms; at most 50 ms"),
    (rows("interval", "on_legs = true\nbetween_processes = true"), {}, "between processes no leg is under way; on_legs or between_processes is expected, not both"),
    (rows("tick"), {}, '"interval", "event" or "interval_and_event" is expected'),
    ('[[tasks]]\nname = "y"\nprogram = "y.asm"\nkind = 30\nimportance = 0xF000\n[[subprocesses]]\nnumber = 6\nname = "x"\ncrane = "user.y"\nrelease = "event"\n', {"bus.topology": "single"},
     "the crane has no range sensor"),
    ('[[subprocesses]]\nnumber = 3\nname = "t"\ncrane = "torque_compensation"\nrelease = "tick"\non_legs = true\n', {}, "sub-process 3: only the name"),
    ("", {"load.driving": True, "load.parked": True}, "load.driving: AGVs cannot both drive and stand; load.driving or load.parked is expected, not both"),
    ("", {"agv_phase": "apart"}, '"staggered" or "together" is expected'),
    ("", {"event_field_m": 0}, "0 is out of range"),
])  # fmt: skip
def test_contradictions_are_named(toml: str, settings: dict[str, Any], says: str) -> None:
    with pytest.raises(cmrc.ConfigError) as error:
        cmrc.config(toml=toml, name="own.toml", settings=settings)
    assert re.search(says, str(error.value)), str(error.value)


def test_a_way_over_a_bridge_lets_the_host_see_the_sensors() -> None:
    cmrc.config(toml=rows("event"), settings={"topology.bridges": "A-B", "topology.boards": "A"})


# ---- the presets' vehicles


def test_the_parked_load_comes_before_a_presets_driving() -> None:
    for preset in ("heavy", "saturated"):
        assert cmrc.config(preset=preset).to_dict()["load.driving"] is True
        parked = cmrc.config(preset=preset, settings={"load.parked": True})
        assert parked.to_dict()["load.driving"] is False
        assert cmrc.config(toml=parked.to_toml()).to_dict() == parked.to_dict()
    with pytest.raises(cmrc.ConfigError, match=r"cannot both drive and stand"):
        cmrc.config(preset="heavy", settings={"load.parked": True, "load.driving": True})


def test_a_round_of_too_many_lanes_is_refused(tmp_path: Path) -> None:
    layout = tmp_path / "layout.toml"
    layout.write_text(
        "[lanes]\nto_warehouse = [[5, 0, 5], [5, 0, 5], [5, 0, 5], [5, 0, 5], [37.699, -0.08333333, 3], [32, 0, 5]]\n"
        "to_spot = [[18, 0, 5], [37.699, -0.08333333, 3], [30, 0, 5]]\n"
    )
    config = tmp_path / "run.toml"
    config.write_text(f'[dock]\nlayout = "{layout}"\n[load]\ndriving = true\n')
    finished = subprocess.run(
        [EMULATOR, "--config", config, "--duration", "0.05"], capture_output=True, text=True, check=False
    )
    assert finished.returncode == 2
    assert (
        "load.driving: the round from slot 0 past the warehouse and back has 9 pieces of lane; at most 8 are expected"
        in finished.stderr
    )


def test_vehicles_drive_their_round_at_their_distances_and_deliver_nothing() -> None:
    simulation = cmrc.Simulation(
        cmrc.config(preset="saturated", settings={"dsps": 6, "duration_s": 4.0, "report.reference": "none"})
    )
    simulation.run()
    report = json.loads(simulation.report_json())
    assert report["cycles_completed"] == 0 and report["containers_delivered"] == 0
    assert sum(task["misses"] for task in report["tasks"].values()) == 0
    signals = simulation.signals()
    places = [signals[f"agv{i}_x_m"][-1] for i in range(4)]
    assert all(signals[f"agv{i}_speed_m_per_s"][-1] > 1.5 for i in range(4)) and places[0] > 22 + 2.5
    assert [a - b for a, b in itertools.pairwise(places)] == pytest.approx([18, 18, 18], abs=0.1)


@pytest.mark.campaign
def test_after_the_round_the_job_continues_as_before() -> None:
    settings = {"agvs": 4, "dsps": 2, "load.driving": True, "report.reference": "none", "duration_s": 200.0}
    simulation = cmrc.Simulation(cmrc.config(settings=settings))
    simulation.run()
    report = json.loads(simulation.report_json())
    assert report["failures"] == []
    assert report["containers_delivered"] == 1 and report["cycles_completed"] == 0
    first = report["cycles"][0]
    assert first["agv"] == 0
    # Without a round: 69.92, 9.82 and 44.90 s (docs/first-run.md). The crane waited meanwhile, and that is t_v and no
    # vehicle's t_w. A vehicle that has driven stands some millimetres beside the spot: the load is aligned with it.
    assert (first["t_3_s"], first["t_5_s"]) == pytest.approx((69.92, 44.90), abs=0.1)
    assert 9.9 < first["t_4_s"] < 15
    assert first["t_v_s"] > 20 and first["t_w_s"] is None
