"""Sub-process 1 of an AGV on an emulated DSP: against the double-precision reference, and against what a drive along a
lane must obey."""

import math
import random

import pytest
from agv_words import DT, UNIT, agv_dsp, set_leg
from harness_agv import Dsp
from lanes import loop, random_leg
from reference_agv import ACCELERATE, BRAKE, Segment, Trajectory, wrap

# docs/kernels_job.md: singles of inputs and outputs at 128 m, 40-bit state
BOUNDS = {
    "x": 2e-5,
    "y": 2e-5,
    "heading": 2e-6,
    "curvature": 1e-8,
    "speed": 1e-5,
    "left": 2e-5,
    "curvature_ahead": 2e-6,
}


@pytest.fixture(scope="module")
def dsp() -> Dsp:
    return agv_dsp()


def stand_at(dsp: Dsp, x: float, y: float, status: int = 0x10) -> None:
    for name, value in (("AGV_X", round(x * 1e3)), ("AGV_Y", round(y * 1e3)), ("AGV_STATUS", status)):
        dsp.device(UNIT + dsp.symbols[name], value)


def drive(dsp: Dsp, limit: int = 8000) -> list[list[float]]:
    """Points until the leg has been run through (or has ended)."""
    points = []
    for k in range(limit):
        result, _, cycles = dsp.run("trajectory_agv", k)
        assert cycles < 1500
        points.append(dsp.floats("AG_POINT", 7, (k & 1) * 8))
        if points[-1][5] == 0.0 or result:
            return points
    raise AssertionError("the leg never ends")


@pytest.mark.parametrize("slow", [1.0, 2.0])
def test_points_agree_with_the_reference(dsp: Dsp, slow: float) -> None:
    rng = random.Random(7)
    dsp.put("AG_PERIOD_US", round(20000 * slow))
    for leg, segments in enumerate([loop()[0], *(random_leg(rng) for _ in range(3))]):
        set_leg(dsp, 1 + leg % 3, segments)
        stand_at(dsp, 1e3, 1e3)
        reference = Trajectory(segments, DT, slow)
        for point in drive(dsp):
            want = reference.advance()
            for value, (name, bound) in zip(point, BOUNDS.items(), strict=True):
                error = value - getattr(want, name)
                assert abs(wrap(error) if name == "heading" else error) < bound, name


def test_speed_obeys_limits_brake_and_drive(dsp: Dsp) -> None:
    rng = random.Random(8)
    for _ in range(4):
        segments = random_leg(rng)
        set_leg(dsp, 2, segments)
        points = drive(dsp)
        total = sum(s.length for s in segments)
        before = 0.0
        for point in points[:-1]:
            speed, s = point[4], total - point[5]
            start, limits = 0.0, []
            for segment in segments:  # at a joint either limit may hold
                if start - 0.2 <= s <= start + segment.length + 1e-3:
                    limits.append(segment.speed)
                start += segment.length
            assert speed <= max(limits) * (1 + 1e-6)
            assert -BRAKE * DT - 2e-5 <= speed - before <= ACCELERATE * DT + 2e-5
            before = speed
        assert before < 0.06  # it crept to the last millimetre
        fastest = max(s.speed for s in segments)
        assert (
            total / fastest / DT
            <= len(points)
            <= (sum(s.length / s.speed for s in segments) + 2 * len(segments) * fastest / BRAKE) / DT
        )


def test_pose_is_the_integral_of_heading_along_the_way(dsp: Dsp) -> None:
    segments = random_leg(random.Random(9))
    set_leg(dsp, 1, segments)
    x, y, heading, s = segments[0].x, segments[0].y, segments[0].heading, 0.0
    total = sum(g.length for g in segments)
    bounds = [sum(g.length for g in segments[: i + 1]) for i in range(len(segments))]
    for point in drive(dsp):
        target = total - point[5]
        while s < target - 1e-12:
            index = next((i for i, b in enumerate(bounds) if s < b - 1e-12), len(segments) - 1)
            step = min(0.01, target - s, bounds[index] - s if bounds[index] - s > 1e-12 else 0.01)
            middle = heading + segments[index].curvature * step / 2
            x, y, heading, s = (
                x + step * math.cos(middle),
                y + step * math.sin(middle),
                heading + segments[index].curvature * step,
                s + step,
            )
        assert math.hypot(point[0] - x, point[1] - y) < 1e-4
        assert abs(wrap(point[2] - heading)) < 1e-5


def test_leg_ends_when_the_vehicle_stands_at_its_end(dsp: Dsp) -> None:
    s = dsp.symbols
    set_leg(dsp, 1, [Segment(1.0, 2.0, math.pi / 2, 1.0, 0.0, 3.0)])
    stand_at(dsp, 1.0, 2.9)
    last = len(drive(dsp)) - 1
    more = (0, s["MUST_TRAJECTORY"] | s["MUST_INVERSE"])
    assert dsp.run("trajectory_agv", last)[:2] == more  # a decimetre short
    stand_at(dsp, 1.2, 3.0, 0)
    assert dsp.run("trajectory_agv", last + 1)[:2] == more  # there, but rolling
    stand_at(dsp, 1.2, 3.008)  # what lies across does not matter
    assert dsp.run("trajectory_agv", last + 2)[:2] == (s["RESULT_END_OF_LEG"], s["MUST_INVERSE"])
    assert dsp.floats("AG_POINT", 7, ((last + 2) & 1) * 8) == pytest.approx(
        [1.0, 3.0, math.pi / 2, 0.0, 0.0, 0.0, 0.0], abs=1e-6
    )


def test_leg_ends_after_five_seconds_wherever_the_vehicle_stands(dsp: Dsp) -> None:
    set_leg(dsp, 1, [Segment(0.0, 0.0, 0.0, 0.5, 0.0, 3.0)])
    stand_at(dsp, -5.0, 0.0)
    last = len(drive(dsp)) - 1
    results = [dsp.run("trajectory_agv", last + 1 + i)[0] for i in range(249)]
    assert results == [0] * 248 + [dsp.symbols["RESULT_END_OF_LEG"]]


def test_running_a_block_again_gives_the_same_point(dsp: Dsp) -> None:
    set_leg(dsp, 1, loop()[0])
    for k in range(100):
        dsp.run("trajectory_agv", k)
        once = dsp.chip.read(dsp.area, dsp.symbols["AG_WORDS"])
        dsp.run("trajectory_agv", k)
        assert dsp.chip.read(dsp.area, dsp.symbols["AG_WORDS"]) == once


def test_a_leg_without_segments_ends_at_once(dsp: Dsp) -> None:
    dsp.put("AG_LEG", 3)
    dsp.put("AG_SEGMENT_COUNT", 0, 3)
    assert dsp.run("trajectory_agv", 0)[:2] == (dsp.symbols["RESULT_END_OF_LEG"], 0)
