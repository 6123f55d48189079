"""AGVs in traffic on the plant's own dock, driven by the kernels: no collision that their sensors could have prevented (the long form: traffic_campaign.py)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from cmrc import _core
from dock_traffic import Course, Mover, Waypoint, preventable
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
        ("who stood beside the lane and steps out", lambda t: 3.0, [(0, 0.0, 4.0), (9.7, 0.0, 4.0), (10.7, 0.0, 0.0)], 10.7, False),
        ("who comes from behind", lambda t: 1.0, [(0, -60.0, 0.0), (20, 0.0, 0.0)], 7.0, False),
    ],
)
def test_who_could_have_prevented_it(what: str, speed: Callable[[float], float], path: list[tuple[float, float, float]], contact: float, guilty: bool) -> None:
    mover = Mover(0.3, 1.8, [Waypoint(*p) for p in path])
    assert bool(preventable([(contact, 0, -1)], [straight(speed)], [mover])) == guilty, what


def test_the_vehicle_that_moves_is_the_one_that_could_prevent_it() -> None:
    stands = Course(np.array([0.0, 20.0]), np.array([[0.0, 0.0, 0.0, 0.0]] * 2))
    assert preventable([(8.4, 0, 1)], [straight(lambda t: 3.0), stands], [])


@pytest.mark.parametrize(("kernel", "off"), [("avoidance_vfh", -20.0), ("avoidance_vfh", 32.0), ("avoidance_potential", 12.0), ("avoidance_dwa", -8.0)])
def test_a_truck_that_rolls_slowly_through_the_lane_before_the_warehouse(kernel: str, off: float) -> None:
    """14 m before the leg's end, where no shift can be given back in time; at 0.1 to 1 m/s from the side."""
    config = _core.plant.default_dock(1)
    stations = [(-60, -30.0), (-20, -30.0), (0, -16.0), (12, -14.2), (24, -13.3), (36, -13.3), (48, -14.3), (60, -16.0), (75, -30.0)]
    config.layout.movers = [Mover(1.5, 3.0, [Waypoint(t + off, 24.0, y) for t, y in stations])]
    fleet = Fleet(config, kernel)
    fleet.run(40.0)
    assert not fleet.collisions()
    assert fleet.dock.agv_x(0, fleet.t) / 1e3 < 45 and fleet.dock.agv_y(0, fleet.t) < 0  # round the bend at least


def test_eight_vehicles_in_traffic_hit_nothing_that_they_could_have_seen() -> None:
    out = by_kernels("vfh", 5, 8, 20.0)
    assert out.preventable == [] and out.driven_m > 150


def test_without_avoidance_they_do() -> None:
    out = by_kernels("none", 5, 8, 20.0)
    assert out.preventable
