"""AGVs in traffic on the plant's own dock, driven by the kernels: no collision that their sensors could have prevented
(the long form: traffic_campaign.py)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from cmrc import _core
from dock_traffic import Course, Mover, Waypoint, on_lane, preventable
from fleet_loop import Fleet
from traffic_campaign import by_kernels

STILL = [[10.0, -20.0, 0.0]]


def straight(speed: Callable[[float], float]) -> Course:
    """Along x from -40 m, on y = 0."""
    time = np.arange(0.0, 20.0, 0.02)
    v = np.array([speed(t) for t in time])
    x = -40.0 + np.concatenate([[0.0], np.cumsum(v[:-1] * 0.02)])
    return Course(time, np.stack([x, 0 * x, 0 * x, v], axis=1))


@pytest.mark.parametrize(
    ("what", "speed", "path", "contact", "guilty"),
    [
        ("a post in the way", lambda t: 3.0, [(0, 0.0, 0.0)], 10.7, True),
        ("who walks on in front of it", lambda t: 3.0, [(0, 0.0, 10.7), (30, 0.0, -19.3)], 10.7, True),
        ("who walks into a vehicle that stands", lambda t: 0.0, [(0, -40.0, 10.7), (30, -40.0, -19.3)], 9.0, False),
        (
            "who stood beside the lane and steps out",
            lambda t: 3.0,
            [(0, 0.0, 4.0), (9.7, 0.0, 4.0), (10.7, 0.0, 0.0)],
            10.7,
            False,
        ),
        ("who comes from behind", lambda t: 1.0, [(0, -60.0, 0.0), (20, 0.0, 0.0)], 7.9, False),
    ],
)
def test_which_collisions_could_have_been_prevented(
    what: str, speed: Callable[[float], float], path: list[tuple[float, float, float]], contact: float, guilty: bool
) -> None:
    mover = Mover(0.3, 1.8, [Waypoint(*p) for p in path])
    assert bool(preventable([(contact, 0, -1)], [straight(speed)], [mover])) == guilty, what


def test_the_vehicle_that_moves_is_the_one_that_could_prevent_it() -> None:
    stands = Course(np.array([0.0, 20.0]), np.array([[0.0, 0.0, 0.0, 0.0]] * 2))
    assert preventable([(8.4, 0, 1)], [straight(lambda t: 3.0), stands], [])


@pytest.mark.parametrize(
    ("kernel", "off"),
    [("avoidance_vfh", -20.0), ("avoidance_vfh", 32.0), ("avoidance_potential", 12.0), ("avoidance_dwa", -8.0)],
)
def test_a_truck_that_rolls_slowly_through_the_lane_before_the_warehouse(kernel: str, off: float) -> None:
    """14 m before the leg's end, where no shift can be given back in time; at 0.1 to 1 m/s from the side."""
    config = _core.plant.default_dock(1)
    stations = [
        (-60, -30.0),
        (-20, -30.0),
        (0, -16.0),
        (12, -14.2),
        (24, -13.3),
        (36, -13.3),
        (48, -14.3),
        (60, -16.0),
        (75, -30.0),
    ]
    config.layout.movers = [Mover(1.5, 3.0, [Waypoint(t + off, 24.0, y) for t, y in stations])]
    fleet = Fleet(config, kernel)
    fleet.run(40.0)
    assert not fleet.collisions()
    assert fleet.dock.agv_x(0, fleet.t) / 1e3 < 45 and fleet.dock.agv_y(0, fleet.t) < 0  # round the bend at least


def among(kernel: str, *movers: Mover) -> Fleet:
    config = _core.plant.default_dock(1)
    config.layout.movers = movers
    return Fleet(config, kernel)


def stands(s: float, lateral: float, radius: float = 0.3) -> Mover:
    return Mover(radius, 1.8, [Waypoint(0.0, *on_lane(s, lateral, 1))])


@pytest.mark.parametrize(
    ("kernel", "s"), [("avoidance_vfh", 30.0), ("avoidance_vfh", 36.0), ("avoidance_potential", 36.0)]
)
def test_a_person_from_the_inner_side_of_a_bend_is_remembered(kernel: str, s: float) -> None:
    """A person walks at 1.2 m/s from 11 m beside the lane. The sensor sees the person for 3 s; the person reaches the
    flank 5 s later."""
    fleet = among(
        kernel, Mover(0.4, 1.8, [Waypoint(5.0, *on_lane(s, -11, 1)), Waypoint(5.0 + 22 / 1.2, *on_lane(s, 11, 1))])
    )
    fleet.run(25.0)
    assert not fleet.collisions()


def test_a_person_who_walks_along_the_lane_past_the_vehicle_is_let_pass() -> None:
    """Against the traffic through a bend, too near to be driven past: the vehicle stands from before he is beside it
    until he has reached its rear, seen or not."""
    start, stations = -25.0, np.linspace(55.0, 15.0, 9)
    walker = Mover(0.5, 1.8, [Waypoint(start + (55.0 - s) / 0.7, *on_lane(float(s), -0.45, 1)) for s in stations])
    fleet, beside = among("avoidance_vfh", walker), []
    while fleet.t < 36e12:
        fleet.run(0.1)
        d, t = fleet.dock, fleet.t
        x, y = _core.plant.mover_place(walker, t * 1e-12)[:2]
        heading = d.agv_heading(0, t) / 1e6
        ahead = np.cos(heading) * (x - d.agv_x(0, t) / 1e3) + np.sin(heading) * (y - d.agv_y(0, t) / 1e3)
        if -6.0 < ahead < 5.0 and t > 8e12:
            beside.append(d.agv_speed(0, t) / 1e3)
    assert len(beside) > 100 and max(beside) < 0.2


def test_a_post_that_leaves_no_room_before_the_legs_end_is_waited_for_in_view() -> None:
    """On the inner side of the last bend, where no shift could be given back in time: the vehicle stands while it still
    sees the post."""
    fleet = among("avoidance_vfh", Mover(0.4, 2.0, [Waypoint(0.0, 42.8, -14.3)]))
    fleet.run(35.0)
    assert not fleet.collisions() and fleet.dock.agv_speed(0, fleet.t) == 0


def test_a_person_where_the_shift_must_be_given_back_is_not_passed() -> None:
    """A post asks for a shift to the left; 18 m behind it, so near the leg's end that nothing is passed, somebody
    stands in the lane until 30 s."""
    at, off = on_lane(66.0, -0.3, 1), on_lane(66.0, 12.0, 1)
    fleet = among(
        "avoidance_vfh",
        stands(48.0, -0.9),
        Mover(0.3, 1.8, [Waypoint(0.0, *at), Waypoint(30.0, *at), Waypoint(40.0, *off)]),
    )
    fleet.run(29.0)
    assert not fleet.collisions() and fleet.dock.agv_speed(0, fleet.t) == 0
    x = fleet.dock.agv_x(0, fleet.t)
    fleet.run(20.0)
    assert (
        not fleet.collisions() and fleet.dock.agv_x(0, fleet.t) < x - 10_000
    )  # on the way to the warehouse, at x = 10 m


def test_a_post_outside_in_a_bend_is_passed_on_the_side_that_has_room() -> None:
    fleet = among("avoidance_vfh", Mover(0.4, 2.0, [Waypoint(0.0, 57.2, -0.9)]))
    fleet.run(45.0)
    assert not fleet.collisions() and fleet.dock.agv_x(0, fleet.t) / 1e3 < 35 and fleet.dock.agv_y(0, fleet.t) < 0


def test_eight_vehicles_in_traffic_hit_nothing_that_they_could_have_seen() -> None:
    out = by_kernels("vfh", 5, 8, 20.0)
    assert out.preventable == [] and out.driven_m > 150


def test_without_avoidance_they_do() -> None:
    out = by_kernels("none", 5, 8, 20.0)
    assert out.preventable
