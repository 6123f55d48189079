"""Layouts in which the controller cannot do its job are refused, with the place and what would be right
(docs/layout.md)."""

import math
import re
from pathlib import Path
from typing import Any

import cmrc
import numpy as np
import pytest
from cmrc import _core
from cmrc_test import run_setup
from locations import ROOT

core = _core.cmrc
ONE = "[[containers]]\nx_m = 3.0\ny_m = 24.0\n"


def dock(tmp_path: Path, layout: str, **settings: Any) -> Any:
    file = tmp_path / "layout.toml"
    file.write_text(layout, encoding="utf-8")
    return run_setup.dock_of(core.config(settings={"dock.layout": str(file), **settings}))


LENGTH, HEIGHT = 12.192, 2.591  # m, of a container


def end_to_end(gap: float, y: float = 24.0, tier: int = 0) -> str:
    """Two containers on a row; in a higher tier on two that are far enough apart."""

    def pair(gap: float, tier: int) -> str:
        places = (-LENGTH / 2 - gap / 2, LENGTH / 2 + gap / 2)
        return "".join(f"[[containers]]\nx_m = {x}\ny_m = {y}\ntier = {tier}\n" for x in places)

    return (pair(0.2, 0) if tier else "") + pair(gap, tier)


REFUSED = [
    # What would make the set-point of psi or kappa jump by a whole turn.
    ("slewing", "[home]\nx_m = -16\ny_m = -6\nz_m = 16\n", "from home to .* slew through 180 degrees.*expected"),
    ("slewing", "[home]\nyaw_deg = -130\n" + ONE, "from home .* rotator would turn through 180 degrees.*yaw_deg"),
    ("slewing", "[home]\nyaw_deg = 300\n" + ONE, "rotator would turn through 180 degrees"),
    ("slewing", "[home]\nx_m = -16\ny_m = 0.01\n" + ONE, "home at .* needs psi = 180.0 degrees"),
    ("gantry", "[home]\nyaw_deg = -95\n", "from home .* rotator would turn through 180 degrees"),
    # The travel.
    ("slewing", "[home]\ngantry_m = 0.05\n", r"\[home\] gantry_m is 0.05 m.*expected is gantry_m = 0"),
    ("gantry", "[home]\ngantry_m = 3\n", r"layout.toml:2:12: gantry_m of home is 3 m.*x_m of its load, 0 m"),
    # What the bay scanner cannot see.
    ("slewing", "[[containers]]\nx_m = 0\ny_m = 25.3\n", r"container 0 at \(0, 25.3\) m is out of the bay scanner's"),
    ("slewing", "[[containers]]\nx_m = 20\ny_m = 24\n", r"x_m from -19.70 to 19.30"),
    (
        "slewing",
        "[[boxes]]\nx_m = [-40, -39]\ny_m = [-60, -58]\nz_m = [0, 1]\n[[containers]]\nx_m = -20\ny_m = 24\n",
        r"x_m from -19.70 to",
    ),
    ("slewing", "[[containers]]\nx_m = 0\ny_m = 24\nyaw_deg = 30\n", "yaw_deg near 0"),
    # What the bay scanner cannot tell apart.
    (
        "slewing",
        end_to_end(0.02),
        r"containers 0 and 1 stand end to end on the row y = 24 m, 20 mm apart.*expected is .* at least 78 mm",
    ),
    ("gantry", end_to_end(0.07, y=12.6), "containers 0 and 1 .* y = 12.6 m, 70 mm apart"),
    ("slewing", end_to_end(0.07, tier=1), "containers 2 and 3 .* 70 mm apart"),
    # Ways that pass too near to the column.
    (
        "slewing",
        "[home]\nx_m = 14\ny_m = -8\nz_m = 11\n[portal]\nleg_m = 0\n",
        "way from home to container 2 passes .* out of the jib's reach",
    ),
    (
        "slewing",
        "[spot]\nx_m = -22\ny_m = -10\n[warehouse]\nx_m = -34\ny_m = -34\n[[containers]]\nx_m = 0\ny_m = 24\n",
        r"the loading spot",
    ),
]


@pytest.mark.parametrize(("crane", "layout", "what"), REFUSED)
def test_a_layout_in_which_the_job_cannot_be_done_is_refused(
    tmp_path: Path, crane: str, layout: str, what: str
) -> None:
    with pytest.raises(cmrc.ConfigError, match=rf"(?s)dock\.layout: .*{what}"):
        dock(tmp_path, layout, **{"dock.crane": crane})


TAKEN = [
    ("slewing", "[home]\nyaw_deg = 20\n"),
    ("slewing", "[home]\nx_m = -5\ny_m = 22\nz_m = 16\n" + ONE),
    ("slewing", "[[containers]]\nx_m = 19.2\ny_m = 24.3\nyaw_deg = 2\n"),
    ("slewing", end_to_end(0.078)),
    ("gantry", end_to_end(0.078, y=12.6)),
    ("gantry", "[home]\nyaw_deg = -80\n"),
    ("gantry", "[home]\nx_m = 4\n"),
    ("gantry", "[home]\nx_m = 4\ngantry_m = 4\n"),
]


@pytest.mark.parametrize(("crane", "layout"), TAKEN)
def test_a_layout_in_which_the_job_can_be_done_is_taken(tmp_path: Path, crane: str, layout: str) -> None:
    made = dock(tmp_path, layout, **{"dock.crane": crane})
    assert crane == "slewing" or made.home.s == made.home.x


ROUND = """[lanes]
to_warehouse = [[20, 0, 5], [37.69911184, -0.08333333333, 3], [32, 0, 5]]
to_spot = [[18, 0, 5], [37.69911184, -0.08333333333, 3], [30, 0, 5]]
"""


def in_pieces(leg: str, pieces: int) -> str:
    """The same lanes, the first piece of a leg in several."""
    first = {"to_warehouse": 20, "to_spot": 18}[leg]
    parts = pieces - 2
    return ROUND.replace(f"{leg} = [[{first}, 0, 5]", f"{leg} = [" + ", ".join([f"[{first / parts}, 0, 5]"] * parts))


@pytest.mark.parametrize("leg", ["to_warehouse", "to_spot"])
def test_a_leg_of_more_pieces_than_its_area_holds_is_refused(tmp_path: Path, leg: str) -> None:
    dock(tmp_path, in_pieces(leg, 8))
    with pytest.raises(cmrc.ConfigError, match=rf"layout.toml: \[lanes\] {leg} has 9 pieces, .* at most 8; expected"):
        dock(tmp_path, in_pieces(leg, 9))


def test_more_boxes_than_the_grab_path_knows_are_refused(tmp_path: Path) -> None:
    boxes = [f"[[boxes]]\nx_m = [{-40 + 3 * i}, {-39 + 3 * i}]\ny_m = [-60, -58]\nz_m = [0, 1]\n" for i in range(9)]
    dock(tmp_path, "".join(boxes[:8]))
    with pytest.raises(cmrc.ConfigError, match=r"layout.toml: there are 9 \[\[boxes\]\], .* at most 8; expected"):
        dock(tmp_path, "".join(boxes))


@pytest.mark.parametrize("driving", [False, True])
def test_a_queue_that_does_not_lie_on_its_lane_is_refused(tmp_path: Path, driving: bool) -> None:
    """The straight end of to_spot is 30 m long."""
    dock(tmp_path, ROUND, **{"dock.agvs": 2, "load.driving": driving})
    dock(tmp_path, "slot_spacing_m = 15\n" + ROUND, **{"dock.agvs": 3, "load.driving": driving})
    with pytest.raises(
        cmrc.ConfigError,
        match=r"dock.agvs = 3 needs a queue of 36 m .*slot_spacing_m = 18.*last 30 m only; .* 36 m or more, at most 2 "
        r"AGVs, or a slot_spacing_m of at most 15",
    ):
        dock(tmp_path, ROUND, **{"dock.agvs": 3, "load.driving": driving})


def tight(radius: float) -> str:
    """A round of half turns with this radius."""
    turn = f"[{np.pi * radius}, {-1 / radius}, 3]"
    return (
        f"[portal]\nleg_m = 0\n[warehouse]\nx_m = 14\ny_m = {8 - 2 * radius}\n[lanes]\n"
        f"to_warehouse = [[20, 0, 5], {turn}, [28, 0, 5]]\nto_spot = [[36, 0, 5], {turn}, [44, 0, 5]]\n"
    )


def test_a_lane_that_no_vehicle_can_steer_is_refused(tmp_path: Path) -> None:
    """With 30 degrees on both axles, 9 m apart, the least radius is 4.5 m / tan 30 degrees = 7.79 m; a tenth more is
    needed."""
    dock(tmp_path, tight(8.6))
    for radius in (6, 7.8, 8.5):
        what = (
            rf"layout.toml: \[lanes\] to_warehouse: piece 1, from \(42.00, 8.00\) m, has a curvature of "
            rf"{-1 / radius:.4g} 1/m .*agv.steer_limit_deg = 30 and 9 m between its axles .*at most 0.1166 1/m "
            rf"\(8.57 m; .*expected are a wider bend, or an agv.steer_limit_deg of "
            rf"{np.ceil(10 * np.degrees(np.arctan(4.5 * 1.1 / radius))) / 10:.1f} or more"
        )
        with pytest.raises(cmrc.ConfigError, match=what):
            dock(tmp_path, tight(radius))
    dock(tmp_path, tight(6), **{"agv.steer_limit_deg": 45})
    dock(tmp_path, "[agv]\ndrive = 'differential'\n" + tight(6))  # it can turn on the spot


@pytest.mark.parametrize("crane", ["slewing", "gantry"])
def test_default_lanes_need_vehicles_that_can_steer_them(crane: str) -> None:
    settings = {"dock.crane": crane, "dock.agvs": 4}
    run_setup.dock_of(core.config(settings={**settings, "agv.steer_limit_deg": 22.5}))
    what = r"to_warehouse: piece 1, .* agv.steer_limit_deg = 15 .* expected are .* agv.steer_limit_deg of 22.5 or more"
    with pytest.raises(cmrc.ConfigError, match=what):
        run_setup.dock_of(core.config(settings={**settings, "agv.steer_limit_deg": 15}))


@pytest.mark.parametrize("radius", [0.0005, 0.149, 0.15])
def test_a_warehouse_that_an_agv_may_miss_is_refused(tmp_path: Path, radius: float) -> None:
    if radius >= 0.15:
        dock(tmp_path, f"[warehouse]\nradius_m = {radius}\n")
        return
    with pytest.raises(cmrc.ConfigError, match=rf"\[warehouse\] radius_m is {radius} m, .* expected is 0.15 m or"):
        dock(tmp_path, f"[warehouse]\nradius_m = {radius}\n")


@pytest.mark.parametrize("heading", [90, 2, 0.2])
def test_a_lane_that_ends_across_its_place_is_refused(tmp_path: Path, heading: float) -> None:
    layout = f"[spot]\nheading_deg = {heading}\n" + ROUND
    if heading < 1:
        dock(tmp_path, layout)
        return
    what = rf"layout.toml:5:11: to_spot ends with a heading of -?0.0 degrees, not of {heading:.1f}: that of the spot"
    with pytest.raises(cmrc.ConfigError, match=what):
        dock(tmp_path, layout)


@pytest.mark.parametrize(("take", "right"), [(1e7, False), (86401, False), (86400, True), (0, True)])
def test_the_warehouse_takes_a_container_within_a_day(tmp_path: Path, take: float, right: bool) -> None:
    layout = f"[warehouse]\ntake_s = {take}\n"
    if right:
        assert dock(tmp_path, layout).layout.warehouse_take == take
        return
    with pytest.raises(cmrc.ConfigError, match=f"take_s must be 0 to 86400 s .got {take:.0f}"):
        dock(tmp_path, layout)


# ---- drives that trip

NARROW = {"slewing.slew.overspeed": 1.001, "slewing.rotate.overspeed": 1.001}  # above 0.1257 rad/s
LEFT = "[[containers]]\nx_m = -12.7\ny_m = 24.0\n"  # the default ship's: its way to the spot passes at 16.5 m


def test_a_dock_is_judged_alike_whether_a_file_names_it_or_not(tmp_path: Path) -> None:
    for layout in ({}, {"dock.layout": str(tmp_path / "empty.toml")}):
        (tmp_path / "empty.toml").write_text("# the default layout\n", encoding="utf-8")
        with pytest.raises(cmrc.ConfigError, match=r"slewing needs 0.126[0-9]* rad/s, .* above 0.1257 rad/s"):
            run_setup.dock_of(core.config(settings={**NARROW, **layout}))
        run_setup.dock_of(core.config(settings={**NARROW, **layout, "control.slew_speed_limit_rad_s": 0.118}))
        run_setup.dock_of(core.config(settings={**{name: 1.02 for name in NARROW}, **layout}))
        run_setup.dock_of(core.config(settings={**NARROW, **layout, "kernels.trajectory": "quintic_shaper"}))


def overspeed_for(seconds: float) -> dict[str, float]:
    return {f"slewing.{drive}.overspeed_time_s": seconds for drive in ("slew", "rotate")}


def test_a_drive_trips_only_if_it_is_too_fast_for_long_enough() -> None:
    """At the top of a way of 42 s the slewing comes to 0.1266 rad/s. Of X = p + (l/g) p'' with a rope of 12 m it is
    above 0.1257 rad/s for 1.0 s."""
    for seconds in (0.0001, 0.9):
        with pytest.raises(cmrc.ConfigError, match=rf"above 0.1257 rad/s, .* after {seconds} s .slewing.*time_s"):
            run_setup.dock_of(core.config(settings={**NARROW, **overspeed_for(seconds)}))
    for seconds in (1.2, 10000):
        run_setup.dock_of(core.config(settings={**NARROW, **overspeed_for(seconds)}))


SLOWED = {"scheduling.work_mode": "slowed_crane", "scheduling.slow_factor": 2.0}


def test_a_slowed_crane_is_judged_by_its_own_speeds() -> None:
    run_setup.dock_of(core.config(settings={**NARROW, **SLOWED}))
    for other in ({"scheduling.work_mode": "slowed_agv"}, {"scheduling.slow_factor": 1.0}):
        with pytest.raises(cmrc.ConfigError, match="slewing needs 0.126"):
            run_setup.dock_of(core.config(settings={**NARROW, **SLOWED, **other}))


@pytest.mark.parametrize(
    ("key", "bad", "good"),
    [("scheduling.work_mode", "full_load", "slowed_crane"), ("scheduling.slow_factor", 1.0, 1.5)],
)
def test_a_slowed_crane_is_not_made_too_fast_during_a_run(key: str, bad: Any, good: Any) -> None:
    settings = {**NARROW, **SLOWED, "report.reference": "none", "run.duration_s": 0.05}
    what = rf"{key}: on the straight way .* slewing needs .* a crane as slow as before is expected"
    change = {"at_s": 0.02, "action": "set", "key": key}
    with pytest.raises(cmrc.ConfigError, match=what):
        cmrc.Simulation(settings=settings, events=[{**change, "value": bad}])
    simulation = cmrc.Simulation(settings=settings)
    with pytest.raises(cmrc.ConfigError, match=what):
        simulation.at(0.02, "set", key=key, value=bad)
    simulation.at(0.02, "set", key=key, value=good)
    simulation.run()


NEAR = "[home]\nx_m = 14\ny_m = -4\nz_m = 11\n[portal]\nleg_m = 0\n" + ONE
FASTER = {"at_s": 0.02, "action": "set", "key": "control.slew_speed_limit_rad_s", "value": 0.12}


def test_a_limit_with_which_a_drive_would_trip_is_not_set_during_a_run(tmp_path: Path) -> None:
    file = tmp_path / "layout.toml"
    file.write_text(NEAR, encoding="utf-8")
    settings = {"dock.layout": str(file), "control.slew_speed_limit_rad_s": 0.08, "report.reference": "none"}
    what = r"control.slew_speed_limit_rad_s: on the straight way .* slewing needs .* a lower value is expected"
    with pytest.raises(cmrc.ConfigError, match=what):
        cmrc.Simulation(settings={**settings, "run.duration_s": 0.05}, events=[FASTER])
    simulation = cmrc.Simulation(settings={**settings, "run.duration_s": 0.05})
    with pytest.raises(cmrc.ConfigError, match=what):
        simulation.at(FASTER["at_s"], "set", key=FASTER["key"], value=FASTER["value"])
    simulation.at(FASTER["at_s"], "set", key=FASTER["key"], value=0.085)
    simulation.run()


def test_a_way_near_the_column_is_taken_by_a_trajectory_that_is_slow_enough(tmp_path: Path) -> None:
    near = "[home]\nx_m = 14\ny_m = -4\nz_m = 11\n[portal]\nleg_m = 0\n" + ONE
    with pytest.raises(cmrc.ConfigError, match="slewing needs 0.15[0-9]* rad/s.*trips above 0.1444 rad/s"):
        dock(tmp_path, near)
    dock(tmp_path, near, **{"control.slew_speed_limit_rad_s": 0.08})
    dock(tmp_path, near, **{"kernels.trajectory": "quintic_shaper"})


def test_the_scanner_sees_a_container_at_the_end_of_its_row(tmp_path: Path) -> None:
    """The first container is looked for and planned: the crane leaves home."""
    file = tmp_path / "layout.toml"
    file.write_text("[[containers]]\nx_m = 19.2\ny_m = 24.0\n", encoding="utf-8")
    settings = {"dock.layout": str(file), "report.reference": "none"}
    result = cmrc.run(dsps=2, duration_s=3.0, settings=settings)
    assert result.report["tasks"]["grab_path"]["released"] == 1
    assert np.ptp(result.signals["psi_rad"]) > 1e-4


def test_the_gap_that_is_needed_follows_from_the_tolerance_of_identify(tmp_path: Path) -> None:
    """The kernel searches where a cell is within its tolerance of the tier. A cell that holds half of the least gap is
    lower by this tolerance."""
    source = (ROOT / "c40_programs" / "kernels" / "identify_constants.asm").read_text(encoding="utf-8")
    inverse_square = re.search(r"^K_ID_TOLERANCE .*\n *\.float ([0-9.]+)", source, re.MULTILINE)
    assert inverse_square
    least = 2 * float(inverse_square[1]) ** -0.5 / HEIGHT * _core.plant.Layout().scan_dx
    dock(tmp_path, end_to_end(least + 1e-4))
    with pytest.raises(cmrc.ConfigError, match=f"expected is a gap of at least {math.ceil(1e3 * least)} mm"):
        dock(tmp_path, end_to_end(least - 1e-4))


def test_an_ideal_run_has_one_dsp() -> None:
    """With two, PID lacks the torque compensation of its own tick: claimed at the same time."""
    settings = {"report.reference": "none"}
    alone, four = (cmrc.run(dsps=dsps, duration_s=0.3, ideal=True, settings=settings) for dsps in (1, 4))
    assert alone.hash == four.hash and len(four.report["dsps"]) == 1
