"""Errors that PID finds, joints that it ignores, the path's clock shared with torque compensation
(docs/controller.md)."""

from __future__ import annotations

import math

import pytest
import reference as ref
from harness import Dsp, from_ti
from test_pid import PERIOD, POINT_TICKS, POSE, REFRESH, SERVO_TICKS, H, Servo

FAULT, LATE, ENCODER, FOLLOWING, SWAY = 1, 6, 11, 16, 21
LIMITS = [0.1, 0.005, 0.005, 0.1, 0.02]
BACK = 0.7
"""rad/s: how fast a joint comes back."""


def bits(place: int, *joints: int) -> int:
    return sum(1 << (place + j) for j in joints)


def servo() -> Servo:
    one = Servo(POSE)
    one.start()
    return one


def off_by(one: Servo, errors: dict[int, float]) -> None:
    """The encoders as if the joints were so far from their set-point."""
    one.encoders([c - round(errors.get(j, 0.0) * ref.COUNTS[j]) for j, c in enumerate(one.total)])


def ticks_until(one: Servo, mask: int, most: int = 2000) -> int:
    for n in range(most):
        one.run()
        if one.errors & mask:
            return n
    return most


@pytest.mark.parametrize("joint", range(5))
def test_a_following_error_counts_after_50_ms_beyond_its_limit(joint: int) -> None:
    one = servo()
    off_by(one, {joint: 0.98 * LIMITS[joint]})
    assert ticks_until(one, bits(FOLLOWING, joint), 100) == 100
    off_by(one, {joint: -1.02 * LIMITS[joint]})
    assert ticks_until(one, bits(FOLLOWING, joint)) * H == pytest.approx(0.050)
    assert one.errors == bits(FOLLOWING, joint)
    off_by(one, {})
    one.run()
    assert one.errors == 0


def test_each_joint_has_its_own_50_ms() -> None:
    one = servo()
    off_by(one, {1: 0.01})
    for _ in range(30):
        one.run()
    off_by(one, {1: 0.01, 4: 0.03})
    assert ticks_until(one, bits(FOLLOWING, 1)) == 20 and one.errors == bits(FOLLOWING, 1)
    off_by(one, {4: 0.03})
    assert ticks_until(one, bits(FOLLOWING, 4)) == 29 and one.errors == bits(FOLLOWING, 4)


def test_a_break_restarts_the_50_ms() -> None:
    one = servo()
    for _ in range(4):
        off_by(one, {2: 0.006})
        assert ticks_until(one, bits(FOLLOWING, 2), 49) == 49
        off_by(one, {})
        one.run()
    assert one.errors == 0


@pytest.mark.parametrize("joint", range(5))
def test_an_encoder_that_stands_still_while_its_drive_turns_is_found_after_20_ms(joint: int) -> None:
    one = servo()
    for j in range(5):
        one.dsp.device("DRIVE_SPEED", 200, offset=j)  # 2 % of rated speed is not above it
    assert ticks_until(one, bits(ENCODER, *range(5)), 60) == 60
    one.dsp.device("DRIVE_SPEED", -201, offset=joint)
    assert ticks_until(one, bits(ENCODER, *range(5))) * H == pytest.approx(0.020)
    assert one.errors == bits(ENCODER, joint)


def test_an_encoder_that_moves_at_all_follows() -> None:
    one = servo()
    one.dsp.device("DRIVE_SPEED", 9000, offset=3)
    for n in range(100):
        one.encoders([c + (n // 15) * (j == 3) for j, c in enumerate(one.total)])  # a count each 15 ms
        one.run()
        assert one.errors == 0


def test_a_sway_sensor_sticks_when_64_samples_are_equal() -> None:
    for axis in range(2):
        one = servo()
        for n in range(50):
            one.dsp.device("SWAY_ALPHA", 20 + n // 10 % 2, offset=axis)
            one.dsp.device("SWAY_ALPHA", -30 - n // 10 % 2, offset=1 - axis)
            one.run()
        waited = 0
        while not one.errors:
            one.dsp.device("SWAY_ALPHA", -30 - waited // 10 % 2, offset=1 - axis)
            one.run()
            waited += 1
        assert waited * H == pytest.approx(0.64, abs=0.011)
        assert one.errors == bits(SWAY, axis)


def test_dither_and_the_ends_of_the_range_are_no_stuck_sensor() -> None:
    one = servo()
    for n in range(2000):
        one.dsp.device("SWAY_ALPHA", 5 + (n // 600) % 2)  # one other sample within 0.64 s
        one.dsp.device("SWAY_ALPHA", 0x7FF if n < 1000 else -2048, offset=1)
        one.run()
        assert one.errors & bits(SWAY, 0, 1) == 0


def test_the_second_sensor_is_read_when_the_host_says_so_and_counts_from_there() -> None:
    one = servo()
    assert ticks_until(one, bits(SWAY, 0, 1)) == pytest.approx(640, abs=12)
    one.dsp.device("SWAY2_ALPHA", 0)  # shows the same code
    one.dsp.put("CR_SWAY_SENSOR", 1)
    assert ticks_until(one, bits(SWAY, 0, 1)) == pytest.approx(650, abs=10)
    one.dsp.device("SWAY2_ALPHA", 100)
    one.run()
    assert from_ti(one.dsp.chip.peek(one.dsp.symbols["PD_SWAY"])) > 0


@pytest.mark.parametrize(("place", "status"), [(FAULT, 8), (LATE, 16)])
def test_a_joint_whose_drive_is_not_ready_is_left_alone(place: int, status: int) -> None:
    one = servo()
    off_by(one, {1: 0.004, 2: 0.004})
    for _ in range(40):
        one.run()
    integral = one.dsp.floats("CR_CONSUMED", 5, offset=24)
    assert integral[1] != 0 and integral[2] != 0
    one.dsp.device("DRIVE_STATUS", 1 << (status + 2))
    one.run()
    assert one.errors == bits(place, 2)
    assert one.dsp.floats("CR_CONSUMED", 5, offset=34)[2] == pytest.approx(0, abs=1e-7)  # no error is left
    assert one.dsp.floats("CR_CONSUMED", 5, offset=24)[2] == pytest.approx(0, abs=1)  # nor what has been integrated
    assert one.codes()[2] == pytest.approx(100.0 * ref.CODE[2], abs=1)  # the feed-forward
    assert abs(one.dsp.floats("CR_CONSUMED", 5, offset=24)[1]) > abs(integral[1])  # the other joints continue


def test_a_joint_comes_back_to_its_path_without_a_kick() -> None:
    one = servo()
    off_by(one, {1: 0.05})
    one.dsp.device("DRIVE_STATUS", 1 << (8 + 1))
    one.run()
    one.dsp.device("DRIVE_STATUS", 0)
    r = one.dsp.symbols["PD_R"] + 1
    start = POSE[1] - 0.05
    for n in range(1, 6001):
        one.run()
        t = n * H
        left = 0.05 * (1 + BACK * t) * math.exp(-BACK * t)
        if n % 500 == 0 or n == 1:
            assert from_ti(one.dsp.chip.peek(r)) == pytest.approx(start + 0.05 - left, abs=2e-5), n
            # The joint follows, so that no following error grows.
        one.encoders([c - round(left * ref.COUNTS[1]) * (j == 1) for j, c in enumerate(one.total)])


@pytest.mark.parametrize("pause_s", [0.2, 1.0, 3.0])
def test_the_time_of_a_time_out_is_no_sample_of_the_law(pause_s: float) -> None:
    """The tick after a pause of the host comes long after the last one, in which all drives had timed out. The way back
    to the path is that of a tick that comes 20 ms later, and no code is larger (the derivative's filter is slower)."""

    def after(pause: float) -> tuple[list[float], list[int]]:
        one = servo()
        off_by(one, {j: 0.5 * limit for j, limit in enumerate(LIMITS)})
        one.dsp.device("DRIVE_STATUS", 0x1F << 8)
        one.run()
        one.dsp.device("DRIVE_STATUS", 0)
        one.tick += round(pause * REFRESH) - SERVO_TICKS
        points, codes = [], []
        for _ in range(3):
            one.run()
            points += one.dsp.floats("CR_REJOIN", 10)
            codes += one.codes()
        return points, codes

    (points, codes), (usual, usual_codes) = after(pause_s), after(0.02)
    assert points == pytest.approx(usual, rel=1e-5, abs=1e-9)
    assert all(abs(code) <= abs(most) + 1 for code, most in zip(codes, usual_codes, strict=True))


def path(t: int, begin: int, ticks: int, start: float, end: float) -> float:
    """The path's clock by its definition: the integral of a rate that goes straight from `start` to `end`."""
    steps = 20000
    if t <= begin:
        return float(begin)
    x = min(t - begin, ticks)
    mean = sum(start + (end - start) * (k + 0.5) / steps * x / ticks for k in range(steps)) / steps
    return begin + mean * x + end * max(0, t - begin - ticks)


def stop(dsp: Dsp, begin: int, ticks: int, start: float, end: float) -> None:
    dsp.put("CR_STOPPED", 1)
    dsp.put("CR_PATH", begin, ticks, start, end, (end - start) / ticks, begin, 0.0, 0x1F)


@pytest.mark.parametrize(("start", "end"), [(1.0, 0.0), (0.0, 1.0)])
def test_the_set_point_stops_and_continues_along_the_path(start: float, end: float) -> None:
    one = servo()
    dsp = one.dsp
    a, b = list(POSE), [x + 0.01 for x in POSE]
    ad, bd = [0.05] * 5, [0.04] * 5
    begin = one.tick
    # Points so far apart in time that the stop lies between two of them.
    dsp.put("CR_POINT_TICKS", 16000)
    dsp.put("CR_POINT_PERIOD", 2.0)
    one.put_point(6, a, ad, [0.0, 0.0, -0.04, 0.05])
    one.put_point(7, b, bd, [0.0, 0.0, -0.04, 0.05])
    dsp.put("CR_CONSUMED", 8)
    dsp.put("CR_SEGMENT_START", begin)
    stop(dsp, begin, REFRESH, start, end)
    shift = dsp.symbols["PD_SHIFT"]
    for n in range(1200):
        tick = one.tick
        one.run()
        if n % 100 == 0:
            phase = (path(tick, begin, REFRESH, start, end) - begin) / 16000
            want = [ref.hermite(*v, phase, 2.0) for v in zip(a, ad, b, bd, strict=True)]
            want[2] -= -0.04 * from_ti(dsp.chip.peek(shift))
            want[1] -= 0.05 * from_ti(dsp.chip.peek(shift + 1))
            got = [from_ti(w) for w in dsp.chip.read(dsp.symbols["PD_R"], 5)]
            assert got == pytest.approx(want, abs=1e-5), n
    assert dsp.device_word("DRIVE_ENABLE") == 0x1F


def test_points_are_consumed_by_the_path_clock() -> None:
    one = servo()
    for k in range(4):
        one.put_point(k, POSE, [0.0] * 5, [0.0] * 4)
    one.run()
    stop(one.dsp, one.tick, 4 * POINT_TICKS, 1.0, 0.0)  # two segments' worth
    consumed = [one.run() & 0xFFFF for _ in range(100)]
    assert consumed[-1] == 3 and consumed[60:] == [3] * 40


def test_torque_compensation_knows_the_path_clock() -> None:
    """Its speeds and accelerations are the derivatives of its own set-point by the clock of refreshes."""
    dsp = Dsp()
    dsp.put("CR_POINT_PERIOD", PERIOD)
    dsp.put("CR_SERVO_PERIOD", H)
    dsp.put("CR_POINT_TICKS", POINT_TICKS)
    dsp.put("CR_SERVO_TICKS", SERVO_TICKS)
    dsp.hang(20_000)
    dsp.put("CR_PID_STAGE", 2)
    begin, acceleration = 8000, [0.02, 0.03, -0.02, 0.1, 0.04]
    speed = [0.3, 0.1, -0.05, 0.5, 0.1]
    for k, slot in ((0, 2), (1, 3)):  # two points of a parabola, 8 ms apart
        t = k * PERIOD
        dsp.put("CR_RING", *[x + v * t + 0.5 * w * t * t for x, v, w in zip(POSE, speed, acceleration, strict=True)], *[v + w * t for v, w in zip(speed, acceleration, strict=True)],
                *acceleration, offset=slot * 16)  # fmt: skip
    dsp.put("CR_CONSUMED", 4)
    dsp.put("CR_SEGMENT_START", begin)
    stop(dsp, begin, REFRESH, 1.0, 0.0)
    symbols = dsp.symbols
    at = begin + 40
    dsp.run("torque", tick=at)
    got_qd = [from_ti(w) for w in dsp.chip.read(symbols["TQ_QD"], 5)]
    got_qdd = [from_ti(w) for w in dsp.chip.read(symbols["TQ_QDD"], 5)]
    rate = 1 - 40 / REFRESH
    theta = (path(at, begin, REFRESH, 1.0, 0.0) - begin) / REFRESH  # s along the path
    for j in range(5):
        along = speed[j] + acceleration[j] * theta
        assert got_qd[j] == pytest.approx(along * rate, rel=1e-4)
        assert got_qdd[j] == pytest.approx(
            acceleration[j] * rate**2 - along * 1.0, rel=1e-3
        )  # the rate falls by 1 per second
