"""Sub-process 2 of an AGV on an emulated DSP, alone and in the loop with sub-process 1 and a vehicle."""

import math
import random
from itertools import pairwise

import pytest
from agv_words import DT, UNIT, agv_dsp, measure, pushed, set_leg
from harness_agv import Dsp, from_ti, to_ti
from lanes import loop
from reference_agv import STEER_LIMIT, Point, inverse, wrap
from vehicle import Vehicle

ROUNDING = 0.5  # of the integer commands: mm/s, microradians
SPEED_BOUND, STEER_BOUND = 0.05, 2.0  # beyond that rounding, from singles (docs/kernels_job.md)


@pytest.fixture(scope="module")
def dsp() -> Dsp:
    return agv_dsp()


def test_set_points_agree_with_the_reference(dsp: Dsp) -> None:
    rng = random.Random(3)
    clamped = stood = 0
    for k in range(500):
        period = rng.choice([20000, 25000, 33333, 40000])
        dsp.put("AG_PERIOD_US", period)
        dsp.put("AG_PRODUCED", k)
        heading = rng.uniform(-math.pi, math.pi)
        at_end = rng.random() < 0.2
        words = [
            rng.uniform(-60, 60),
            rng.uniform(-60, 60),
            heading,
            0.0,
            rng.uniform(0, 6),
            rng.uniform(0.1, 80),
            rng.uniform(-0.1, 0.1),
        ]
        if at_end:
            words[4] = words[5] = 0.0
        elif rng.random() < 0.1:
            words[4] = 0.0  # stopped on the way
        words = [from_ti(to_ti(w)) for w in words]
        for i, value in enumerate(words):
            dsp.put("AG_POINT", value, (k & 1) * 8 + i)
        off = 0.03 if at_end else 0.5
        x, y = (round(1e3 * (words[i] + rng.uniform(-off, off))) for i in (0, 1))
        turned = round(1e6 * wrap(heading + rng.uniform(-0.3, 0.3)))
        speed, waiting, loaded = (0 if at_end else rng.randint(0, 6000)), rng.randint(0, 4), rng.random() < 0.5
        measure(dsp, x, y, turned, speed, waiting | 0x20 * loaded)
        want = inverse(Point(*words), x / 1e3, y / 1e3, turned / 1e6, speed / 1e3, waiting, loaded, DT, period / 1e6)

        result, notify, cycles = dsp.run("inverse_agv", k)
        assert (result, notify, dsp.word("AG_PRODUCED")) == (k + 1, 0, k + 1)
        assert cycles < 700
        got = pushed(dsp)
        assert got[0] == period and got[3] == -got[2]
        if not (at_end and abs(abs(want.along) - 0.01) < 1e-4):
            assert abs(got[1] - 1e3 * want.speed) <= ROUNDING + SPEED_BOUND
        assert abs(got[2] - 1e6 * want.front) <= ROUNDING + STEER_BOUND
        clamped += abs(want.front) == STEER_LIMIT
        stood += got[1] == 0
    assert clamped > 5 and stood > 5  # both branches were met


@pytest.mark.parametrize("point", [0, 5])  # the first of a leg, another
def test_a_block_that_was_pushed_before_is_not_pushed_again(dsp: Dsp, point: int) -> None:
    measure(dsp, 0, 0, 0, 0, 0)
    dsp.put("AG_PERIOD_US", 20000)
    dsp.put("AG_PRODUCED", point)
    dsp.run("inverse_agv", point)
    dsp.device(UNIT + dsp.symbols["AGV_REAR_COMMAND"], 12345678)
    assert dsp.run("inverse_agv", point)[:2] == (point + 1, 0)
    assert pushed(dsp)[3] == 12345678


@pytest.mark.parametrize("load", [0.0, 30e3])
@pytest.mark.parametrize("period_us", [20000, 32000])
@pytest.mark.parametrize("leg", [1, 2])
def test_the_loop_is_driven_to_within_centimetres(dsp: Dsp, load: float, period_us: int, leg: int) -> None:
    """Both sub-processes on the DSP, two set-points ahead of the vehicle, which starts 3 cm and 10 mrad off."""
    segments = loop()[leg - 1]
    set_leg(dsp, leg, segments)
    dsp.put("AG_PERIOD_US", period_us)
    vehicle = Vehicle(segments[0].x - 0.03, segments[0].y + 0.03, segments[0].heading + 0.01, load)
    end = segments[-1].x + segments[-1].length * math.cos(segments[-1].heading)
    k, done, across, steers = 0, False, 0.0, []
    while not (done and not vehicle.queue and vehicle.standing):
        if len(vehicle.queue) < 2 and not done:
            status = len(vehicle.queue) | 0x10 * vehicle.standing | 0x20 * vehicle.loaded
            measure(
                dsp,
                *(
                    math.floor(v)
                    for v in (vehicle.x * 1e3, vehicle.y * 1e3, wrap(vehicle.heading) * 1e6, vehicle.v * 1e3)
                ),
                status,
            )
            done = bool(dsp.run("trajectory_agv", k)[0])
            dsp.run("inverse_agv", k)
            point = dsp.floats("AG_POINT", 3, (k & 1) * 8)
            lateral = math.cos(point[2]) * (vehicle.y - point[1]) - math.sin(point[2]) * (vehicle.x - point[0])
            if abs(point[2] - segments[0].heading) < 1e-3 or abs(wrap(point[2] - segments[-1].heading)) < 1e-3:
                across = max(across, abs(lateral))
            _, speed, front, rear = pushed(dsp)
            vehicle.queue.append((speed / 1e3, front / 1e6, rear / 1e6))
            steers.append(front / 1e6)
            k += 1
        vehicle.step(period_us / 1e6)
        assert vehicle.time < 100
    assert abs(vehicle.x - end) < 0.03
    assert abs(vehicle.y - segments[-1].y) < 0.03
    assert abs(wrap(vehicle.heading - segments[-1].heading)) < 0.005
    assert across < 0.15
    assert vehicle.ran_dry == 0
    assert max(abs(b - a) for a, b in pairwise(steers)) < 0.03  # smooth: 1.5 rad/s at most
