"""Process 8 and the synthetic load of sub-process 5 on an emulated DSP."""

import random

import pytest
from agv_words import UNIT, set_leg
from harness_agv import Dsp
from lanes import random_leg
from reference_agv import Segment, cut_leg, pose_at, wrap

BOUND = 1e-3  # m: the lane is looked at every micrometre by the reference, the pose comes in mm


@pytest.fixture(scope="module")
def dsp() -> Dsp:
    machine = Dsp()
    machine.agv(1)
    machine.put("AG_UNIT", UNIT)
    return machine


def leg_three(dsp: Dsp) -> list[Segment]:
    return [Segment(*dsp.floats("AG_SEGMENT", 6, 128 + 8 * i)) for i in range(dsp.word("AG_SEGMENT_COUNT", 3))]


def test_leg_three_begins_at_the_point_of_the_lane_nearest_to_the_vehicle(dsp: Dsp) -> None:
    rng = random.Random(4)
    for tick in range(20):
        segments = random_leg(rng)
        where = rng.choice(segments)
        x, y, _ = pose_at(where, rng.uniform(0, where.length))
        x, y = round(x + rng.uniform(-0.5, 0.5), 3), round(y + rng.uniform(-0.5, 0.5), 3)
        set_leg(dsp, 3, segments)
        dsp.device(UNIT + dsp.symbols["AGV_X"], round(1e3 * x))
        dsp.device(UNIT + dsp.symbols["AGV_Y"], round(1e3 * y))
        want = cut_leg(segments, x, y)
        result, notify, cycles = dsp.run("home_agv", tick=tick)
        assert (result, notify) == (len(want), 0)
        assert cycles < 5000
        got = leg_three(dsp)
        assert [g.length for g in got] == pytest.approx([w.length for w in want], abs=BOUND)
        for g, w in zip(got, want):
            assert (g.x, g.y) == pytest.approx((w.x, w.y), abs=BOUND)
            assert abs(wrap(g.heading - w.heading)) < 1e-4
            assert (g.curvature, g.speed) == pytest.approx((w.curvature, w.speed), rel=1e-6)
        dsp.run("home_agv", tick=tick)  # again, as after a failure
        assert leg_three(dsp) == got
        dsp.run("home_agv", tick=100 + tick)  # another homing
        assert [g.length for g in leg_three(dsp)] == pytest.approx([g.length for g in got], abs=1e-4)


def test_no_lane_home_is_no_segment(dsp: Dsp) -> None:
    dsp.put("AG_SEGMENT_COUNT", 0, 3)
    assert dsp.run("home_agv")[:2] == (0, 0)


@pytest.mark.parametrize("cycles", [40, 41, 100, 999, 20_000, 150_000])
def test_the_synthetic_load_takes_the_given_cycles(dsp: Dsp, cycles: int) -> None:
    result, notify, taken = dsp.run("avoidance", cycles)
    assert (result, notify) == (0, 0)
    assert abs(taken - cycles) <= 8
