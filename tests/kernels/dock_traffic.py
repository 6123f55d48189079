"""Docks full of traffic, and which side could have prevented a collision: judged from the true courses of vehicles and
obstacles alone.

A vehicle could have prevented a collision if it moved at the contact, and if its sensor had the obstacle within reach
in time. In time: at the last instant from which its brakes could still stop it; or earlier, if the obstacle then kept
its course. It could not prevent a collision with something that runs into the standing vehicle, comes from behind the
sensor, or turns at the last moment.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from cmrc import _core
from reference_agv import Segment, pose_at

Waypoint, Mover = _core.plant.Waypoint, _core.plant.Mover
REACTION, BRAKE, REACH, MOUNT, MEMORY = 0.6, 1.0, 30.0, 7.4, 8.0  # s, m/s2, m, m, s


def on_lane(s: float, lateral: float, agvs: int) -> tuple[float, float]:
    """A point of the default loop for so many AGVs, `s` m from the loading spot, `lateral` m to its left."""
    segments = [
        Segment(g.x, g.y, g.heading, g.length, g.curvature, g.speed)
        for leg in _core.plant.default_dock(agvs).layout.legs[:2]
        for g in leg
    ]
    for g in segments:
        if s <= g.length or g is segments[-1]:
            x, y, heading = pose_at(g, s)
            return x - lateral * math.sin(heading), y + lateral * math.cos(heading)
        s -= g.length
    raise AssertionError


def _walk(r: random.Random, s: float, speed: float, start: float, agvs: int) -> list[Any]:
    """Across the lane, perhaps with a halt on it."""
    side, far = r.choice([-1, 1]), r.uniform(7, 12)
    stay = r.choice([0.0, 0.0, r.uniform(3, 20)])
    middle = r.uniform(-1.5, 1.5)
    times = [start, start + abs(side * far - middle) / speed]
    times += [times[-1] + stay + 1e-3, times[-1] + stay + 1e-3 + abs(-side * far - middle) / speed]
    places = [on_lane(s, lateral, agvs) for lateral in (side * far, middle, middle, -side * far)]
    if not stay:
        times, places = [times[0], times[3]], [places[0], places[3]]
    return [Waypoint(t, x, y) for t, (x, y) in zip(times, places)]


def random_movers(seed: int, agvs: int, moving: bool = True) -> list[Any]:
    """Posts beside and in the lane, and with `moving` people and trucks that cross it, halt on it, or go along it."""
    r = random.Random(seed)
    round_trip = sum(g.length for leg in _core.plant.default_dock(agvs).layout.legs[:2] for g in leg)
    free = (9.0, round_trip - 18.0 * agvs - 10.0)  # where no vehicle stands at the start

    def place() -> float:
        return r.uniform(free[0] + 14.0, free[1] - 4.0)

    movers = []
    for _ in range(r.randint(1, 4)):
        radius = r.choice([0.2, 0.4])
        x, y = on_lane(place(), r.choice([-1, 1]) * r.choice([r.uniform(2.2, 5.0), r.uniform(1.2, 1.9)]), agvs)
        movers.append(Mover(radius, 2.0, [Waypoint(0.0, x, y)]))
    if not moving:
        return _apart(movers)
    for _ in range(r.randint(2, 5)):
        movers.append(Mover(0.4, 1.8, _walk(r, place(), r.uniform(0.7, 1.6), r.uniform(0, 60), agvs)))
    for _ in range(r.randint(1, 3)):
        movers.append(Mover(r.uniform(1.0, 1.8), 3.0, _walk(r, place(), r.uniform(0.5, 2.0), r.uniform(0, 60), agvs)))
    if r.random() < 0.7:
        # Along the lane, with the traffic or against it, and off it again.
        s, way, speed, start = place(), r.choice([-15.0, 15.0]), r.uniform(0.6, 1.5), r.uniform(0, 40)
        stations = np.linspace(s, s + way, 6)
        path = [(s, 8.0), *((float(u), r.uniform(-0.5, 0.5)) for u in stations), (s + way, -8.0)]
        times = [
            start,
            start + 8 / speed,
            *(start + 8 / speed + abs(float(u) - s) / speed for u in stations[1:]),
            start + (16 + abs(way)) / speed,
        ]
        movers.append(Mover(0.5, 1.8, [Waypoint(t, *on_lane(*p, agvs)) for t, p in zip(times, path)]))
    return _apart(movers)


def _apart(movers: list[Any]) -> list[Any]:
    """Without those that would begin inside another."""
    kept: list[Any] = []
    for m in movers:
        if all(
            math.hypot(m.path[0].x - k.path[0].x, m.path[0].y - k.path[0].y) > m.radius + k.radius + 0.8 for k in kept
        ):
            kept.append(m)
    return kept


@dataclass
class Course:
    """Where a vehicle was: times in s, rows of x, y, heading, speed."""

    time: np.ndarray
    rows: np.ndarray

    def __post_init__(self) -> None:
        self.rows = np.array(self.rows, dtype=float)
        self.rows[:, 2] = np.unwrap(self.rows[:, 2])  # interpolated between

    def at(self, t: float) -> np.ndarray:
        return np.array([np.interp(t, self.time, self.rows[:, k]) for k in range(4)])


def outline(x: float, y: float, heading: float, length: float = 14.8, width: float = 3.0) -> np.ndarray:
    u, v = np.meshgrid(np.linspace(-length / 2, length / 2, 13), np.linspace(-width / 2, width / 2, 5))
    c, s = math.cos(heading), math.sin(heading)
    return np.stack([x + c * u.ravel() - s * v.ravel(), y + s * u.ravel() + c * v.ravel()], axis=1)


def could_prevent(course: Course, contact: float, other: Callable[[float], np.ndarray], vehicle: bool) -> bool:
    """`other`: points of what was hit, at a time. Another vehicle may turn or brake."""
    if course.at(contact - 0.02)[3] < 0.05:  # it stood, or rolled back to its set-point
        return False
    times = course.time[course.time <= contact]
    in_time = [t for t in times if t + REACTION + abs(course.at(t)[3]) / BRAKE <= contact]
    if not in_time:
        return False
    t = float(in_time[-1])
    points = other(t)
    for back in np.arange(0.0, MEMORY, 0.2):  # seen then, or before and not forgotten
        x, y, heading, _ = course.at(t - back)
        before = other(t - back)
        c, s = math.cos(heading), math.sin(heading)
        ahead = c * (before[:, 0] - x) + s * (before[:, 1] - y) - MOUNT
        aside = c * (before[:, 1] - y) - s * (before[:, 0] - x)
        if ((ahead > 0) & (np.hypot(ahead, aside) < REACH)).any() and (
            vehicle
            and back == 0.0
            or float(np.abs(before + (points - other(t - 0.1)) / 0.1 * back - points).max()) < 0.3
        ):
            break
    else:
        return False
    if vehicle:
        return True
    rate = (points - other(t - 0.1)) / 0.1
    foreseen = points + rate * (contact - t)
    return float(np.abs(foreseen - other(contact)).max()) < 0.75


def preventable(
    collisions: Sequence[tuple[float, int, int]], courses: Sequence[Course], movers: Sequence[Any]
) -> list[tuple[float, int, int]]:
    """Of (time, AGV, other AGV or -1) those that a vehicle could have prevented."""

    def disc(mover: Any) -> Callable[[float], np.ndarray]:
        angles = np.arange(8) * math.pi / 4
        rim = mover.radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        return lambda t: np.array(_core.plant.mover_place(mover, max(0.0, t))[:2]) + rim

    found = []
    for time, agv, other in collisions:
        if other >= 0:
            pairs = [
                (agv, lambda t, k=other: outline(*courses[k].at(t)[:3])),
                (other, lambda t, k=agv: outline(*courses[k].at(t)[:3])),
            ]
        else:
            x, y, heading, _ = courses[agv].at(time)
            body = outline(x, y, heading)
            gaps = [
                float(np.linalg.norm(body - np.array(_core.plant.mover_place(m, time)[:2]), axis=1).min()) - m.radius
                for m in movers
            ]
            if min(gaps, default=math.inf) > 1.0:  # part of the dock: it stood there, whatever the vehicle did
                found += [(time, agv, other)] * bool(courses[agv].at(time - 0.02)[3] >= 0.05)
                continue
            pairs = [(agv, disc(movers[int(np.argmin(gaps))]))]
        if any(could_prevent(courses[k], time, points, other >= 0) for k, points in pairs):
            found.append((time, agv, other))
    return found
