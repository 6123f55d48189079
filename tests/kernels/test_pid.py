"""PID: one tick against the double-precision reference, and the rules about points, stages and status bits."""

from __future__ import annotations

import math
import random

import pytest
import reference as ref
from harness import Dsp, from_ti, single

LANDED, LOCKED, OPEN, STARVED, SETTLED, RAMP_DONE, BEGAN, STEADY, WINDY = (0x10000 << i for i in range(9))
POINT_TICKS, SERVO_TICKS, REFRESH = 64, 8, 8000
MASS = 24000.0
PERIOD, H = POINT_TICKS / REFRESH, SERVO_TICKS / REFRESH


def counts(q: list[float]) -> list[int]:
    return [math.floor(x * c) for x, c in zip(q, ref.COUNTS, strict=True)]


class Servo:
    """PID with its inputs in place; the encoders show `pose`."""

    def __init__(self, pose: list[float], tick: int = 1000) -> None:
        self.dsp = Dsp()
        self.dsp.put("CR_POINT_PERIOD", PERIOD)
        self.dsp.put("CR_SERVO_PERIOD", H)
        self.dsp.put("CR_POINT_TICKS", POINT_TICKS)
        self.dsp.put("CR_SERVO_TICKS", SERVO_TICKS)
        self.dsp.put("CR_LOAD", MASS)
        self.total = counts(pose)
        self.dsp.put("CR_ENCODER_TOTAL", *self.total)
        self.dsp.put("CR_ENCODER_LAST", *(c & 0xFFFFFF for c in self.total))
        self.encoders(self.total)
        self.tick = tick

    def encoders(self, total: list[int]) -> None:
        for j, c in enumerate(total):
            self.dsp.device("ENCODER", c & 0xFFFFFF, offset=j)

    def run(self) -> int:
        result, notify, _ = self.dsp.run("pid", tick=self.tick)
        self.errors, self.rests = notify & 0x7FFFFF, notify >> 23
        self.tick += SERVO_TICKS
        return result

    def start(self) -> None:
        """To stage 2: drives enabled."""
        self.run()
        self.dsp.put("CR_FEED_FORWARD", 0.0, 0.0, 100.0, 0.0, 0.0)
        self.run()

    def put_point(self, k: int, q: list[float], qd: list[float], sway: list[float]) -> None:
        self.dsp.put("CR_RING", *q, *qd, offset=(k & 3) * 16)
        self.dsp.put("CR_SWAY", *sway, offset=(k & 3) * 4)
        self.dsp.put("CR_PRODUCED", k + 1)

    def codes(self) -> list[int]:
        return [self.dsp.device_word("DRIVE_TORQUE", offset=j) for j in range(5)]


POSE = [0.0, 0.9, 0.97, 30.0, -0.9]


def test_stages_from_the_brakes_to_the_servo() -> None:
    servo = Servo(POSE)
    servo.dsp.device("SPREADER_STATUS", 0x20)
    assert servo.run() == OPEN
    assert servo.dsp.word("CR_PID_STAGE") == 1
    assert servo.dsp.floats("CR_RING", 15, offset=48) == pytest.approx(POSE + [0.0] * 10, abs=5e-6)
    factors = [0, 0, -1 / (ref.JIB * math.sin(POSE[2])), 1 / (ref.A0 + ref.JIB * math.cos(POSE[2]))]
    assert servo.dsp.floats("CR_SWAY", 4, offset=12) == pytest.approx(factors, rel=2**-22)
    assert servo.run() == OPEN and servo.dsp.device_word("DRIVE_ENABLE") == 0  # no feed-forward yet
    feed = [0.0, 100.0, 3000.0, -900.0, 1.0]
    servo.dsp.put("CR_FEED_FORWARD", *feed)
    servo.run()
    assert servo.dsp.device_word("DRIVE_ENABLE") == 0x1F
    want = [round(f * 2047 / u) for f, u in zip(feed, ref.U_MAX, strict=True)]
    assert servo.codes() == pytest.approx(want, abs=2)  # within half a count of the pose: the error is < one count


def test_one_tick_is_the_reference(seeds: range = range(12)) -> None:
    for seed in seeds:
        r = random.Random(seed)
        servo = Servo(POSE)
        servo.start()
        dsp = servo.dsp
        a = [single(x + r.uniform(-0.01, 0.01)) for x in POSE]
        b = [single(x + r.uniform(-0.001, 0.001)) for x in a]
        ad, bd = ([single(r.uniform(-0.05, 0.05)) for _ in range(5)] for _ in range(2))
        sway_a, sway_b = (
            [*(single(r.uniform(-0.02, 0.02)) for _ in range(2)), single(-0.04), single(0.05)] for _ in range(2)
        )
        servo.put_point(6, a, ad, sway_a)
        servo.put_point(7, b, bd, sway_b)
        dsp.put("CR_CONSUMED", 8)
        phase = r.randrange(0, 8)
        dsp.put("CR_SEGMENT_START", servo.tick - 8 * phase)
        state = ref.PidState(
            *(
                [single(r.uniform(-s, s)) for _ in range(n)]
                for s, n in ((50.0, 5), (50.0, 5), (0.01, 5), (0.2, 2), (0.01, 2), (0.3, 2), (0.3, 2))
            )
        )
        if seed % 4 == 1:  # no wind is known while the path moves
            state.wind, state.speed = [single(0.03 * w) for w in state.wind], [single(0.1 * v) for v in state.speed]
        base = dsp.symbols["CR_PID"]
        loops = ((24, state.integral), (29, state.derivative), (34, state.error))
        for offset, values in (*loops, (5, state.beside), (13, state.sway), (45, state.speed), (47, state.wind)):
            dsp.put("CR_CONSUMED", *values, offset=offset)
        assert dsp.symbols["CR_CONSUMED"] == base
        feed = [single(r.uniform(-0.9, 0.9) * u) for u in ref.U_MAX]
        dsp.put("CR_FEED_FORWARD", *feed)
        moved = [c + r.randrange(-200, 200) for c in servo.total]
        servo.encoders(moved)
        codes = [r.randrange(-400, 400) for _ in range(2)]
        for i, c in enumerate(codes):
            dsp.device("SWAY_ALPHA", c if seed % 2 else c & 0xFFF, offset=i)
        ramp = seed % 3 == 0
        reference = [ref.hermite(*v, phase / 8, PERIOD) for v in zip(a, ad, b, bd, strict=True)]
        if ramp:
            dsp.put("CR_RAMP_TICKS", 16000)
            dsp.put("CR_RAMP_START", servo.tick - 4000)
            dsp.put("CR_RAMP_BASE", -0.5)
            dsp.put("CR_RAMP_DELTA", 1.5)
            reference[3] += -0.5 + 1.5 * ref.quintic(0.25)[0]
        sway = [x + phase / 8 * (y - x) for x, y in zip(sway_a, sway_b, strict=True)]
        stands = seed % 4 == 3
        dsp.device("SPREADER_STATUS", 0x04 if stands and seed % 8 == 3 else 0)
        if stands and seed % 8 == 7:
            dsp.put("CR_LOAD", 0.75 * ref.M_SPREADER)
        measured = [m / c for m, c in zip(moved, ref.COUNTS, strict=True)]
        shift = ref.sway_update(
            state, [c * math.radians(10) / 2048 for c in codes], sway[:2], H, measured[3], stands=stands, moves=True
        )
        # The load keeps its height and its direction while luff and slew move.
        reference[3] += ref.JIB * math.cos(measured[2]) * sway[2] * shift[0]
        reference[2] += sway[2] * shift[0]
        reference[1] += sway[3] * shift[1]
        reference[4] -= sway[3] * shift[1]
        k_p = ref.stiffness(measured[2], ref.M_SPREADER if stands and seed % 8 == 7 else MASS)
        want = ref.pid(state, reference, measured, feed, H, k_p)

        servo.run()
        # The set-point is rounded to single twice, the measurement once, the unit of a count to 2^-25: four halves of
        # the last place of l (2^-20 m) or of an angle below 1 (2^-25). K (1 + N) multiplies that, in codes of u_max /
        # 2047; one code for the rounding to codes.
        for j in range(5):
            e = 4 * (2**-20 if j == 3 else 2**-25)
            codes_of_error = k_p[j] * (1 + ref.N_D) * e * ref.CODE[j]
            assert servo.codes()[j] == pytest.approx(want[j] * ref.CODE[j], abs=1 + codes_of_error), (seed, j)
            assert dsp.floats("CR_CONSUMED", 5, offset=34)[j] == pytest.approx(state.error[j], abs=e)
            k_i = k_p[j] * (1 + H / ref.T_I[j] + H / ref.T_T[j] * (1 + ref.N_D))
            assert dsp.floats("CR_CONSUMED", 5, offset=24)[j] == pytest.approx(
                state.integral[j], abs=1e-5 + k_i * e, rel=1e-6
            )
        assert dsp.floats("CR_CONSUMED", 2, offset=5) == pytest.approx(state.beside, abs=1e-7)
        assert dsp.floats("CR_CONSUMED", 2, offset=45) == pytest.approx(state.speed, abs=1e-7)
        assert dsp.floats("CR_CONSUMED", 2, offset=47) == pytest.approx(state.wind, abs=1e-7)
        assert dsp.floats("CR_CONSUMED", 2, offset=13) == pytest.approx(state.sway, abs=1e-8)


def test_torque_codes_are_clamped_and_the_integrator_does_not_run_away() -> None:
    servo = Servo(POSE)
    servo.start()
    for n in range(1, 400):
        servo.encoders([c + 20000 * n // 400 for c in servo.total])
        servo.run()
        assert all(-2047 <= c <= 2047 for c in servo.codes())
    integral = servo.dsp.floats("CR_CONSUMED", 5, offset=24)
    for j in range(5):  # back calculation: without it the error would have gone on integrating
        assert abs(integral[j]) < 1.5 * ref.U_MAX[j] + 2 * ref.stiffness(POSE[2], MASS)[j] * 20000 / ref.COUNTS[j]


def test_encoder_wraps_are_followed_both_ways() -> None:
    pose = [0.0, 0.9, 0.97, (2**24 - 300) / ref.COUNTS[3], -0.9]
    servo = Servo(pose)
    servo.start()
    total = list(servo.total)
    for step in (150, 300, 450, -200, -500, -700, 900):
        total[3] += step
        total[4] -= step
        servo.encoders(total)
        servo.run()
        assert [servo.dsp.word("CR_ENCODER_TOTAL", offset=j) for j in range(5)] == total


def test_points_are_consumed_each_segment_and_starving_is_said() -> None:
    servo = Servo(POSE)
    servo.start()
    moving = [0.0, 0.01, 0.0, 0.0, 0.0]
    for k in range(3):
        servo.put_point(k, POSE, moving if k == 2 else [0.0] * 5, [0.0] * 4)
    first = servo.tick
    consumed = [servo.run() & 0xFFFF for _ in range(8 * 2 + 1)]
    assert consumed == [1] * 8 + [2] * 8 + [3]
    assert servo.dsp.word("CR_SEGMENT_START") == first + 2 * POINT_TICKS
    results = [servo.run() for _ in range(9)]
    assert [bool(x & STARVED) for x in results] == [False] * 7 + [True] * 2  # at speed with no next point
    servo.put_point(3, POSE, [0.0] * 5, [0.0] * 4)
    late = servo.tick
    assert servo.run() == 4 | BEGAN | STEADY
    assert servo.dsp.word("CR_SEGMENT_START") == late


def test_the_same_tick_again_consumes_nothing_more() -> None:
    servo = Servo(POSE)
    servo.start()
    for k in range(4):
        servo.put_point(k, POSE, [0.0] * 5, [0.0] * 4)
    for _ in range(8):
        servo.run()
    assert servo.run() == 2 | STEADY
    servo.tick -= SERVO_TICKS
    assert servo.run() == 2 | STEADY


def test_settled_needs_rest_tolerance_and_time() -> None:
    servo = Servo(POSE)
    servo.start()
    first = next(n for n in range(4000) if servo.run() & SETTLED)
    assert first * H == pytest.approx(ref.SETTLE_TIME, abs=0.003)
    servo.dsp.device("SWAY_ALPHA", 60)  # 5 mrad; it takes a part of the filter's 0.15 s to count
    assert not all(servo.run() & SETTLED for _ in range(100))
    servo.dsp.device("SWAY_ALPHA", 0)
    assert not any(servo.run() & SETTLED for _ in range(1400))
    assert any(servo.run() & SETTLED for _ in range(500))
    servo.dsp.put("CR_RAMP_TICKS", 800)
    servo.dsp.put("CR_RAMP_BASE", 0.0, 0.0)
    servo.dsp.put("CR_RAMP_START", servo.tick)
    ramp = [servo.run() for _ in range(102)]
    assert not ramp[5] & SETTLED
    assert [bool(x & RAMP_DONE) for x in ramp] == [False] * 100 + [True] * 2


def test_a_leg_that_is_over_rests_however_fast_its_last_segment_was() -> None:
    """A short alignment's last two points are far apart in speed; the load still rests at the second."""
    servo = Servo(POSE)
    servo.start()
    speed = [0.0, 0.0, 2e-3, 0.0, 0.0]
    for k, rate in enumerate(([0.0] * 5, speed, [0.0] * 5)):
        servo.put_point(k, POSE, rate, [0.0] * 4)
    begin = servo.tick
    while (
        servo.tick < begin + 3 * POINT_TICKS
    ):  # three points are consumed, the last at once; two segments later it is over
        assert not servo.run() & SETTLED
    settled = next(n for n in range(4000) if servo.run() & SETTLED)
    assert settled * H == pytest.approx(ref.SETTLE_TIME, abs=0.01)


def test_it_says_whether_the_load_is_over_its_place_and_displaced_by_wind() -> None:
    servo = Servo(POSE)
    servo.start()
    for beside, speed, wind, bits in (
        (0.09, 0.14, 0.029, STEADY), (-0.11, 0.0, 0.0, 0), (0.0, -0.16, 0.0, 0),
        (0.0, 0.0, -0.031, STEADY | WINDY), (0.11, 0.0, 0.04, WINDY),
    ):  # fmt: skip
        for axis in range(2):
            code = round((wind / ref.GRAVITY) / (math.radians(10) / 2048))
            servo.dsp.device("SWAY_ALPHA", code if axis == 0 else 0, offset=axis)
        servo.dsp.device("SPREADER_STATUS", 1)  # the load stands on something: the observer keeps its state
        for offset, value in ((5, beside), (45, speed), (47, wind)):
            servo.dsp.put("CR_CONSUMED", value, 0.0, offset=offset)
        assert servo.run() & (STEADY | WINDY) == bits, (beside, speed, wind)


def test_a_steady_wind_is_observed_and_the_suspension_goes_upwind() -> None:
    """A pendulum of its own, pushed by a constant wind, hangs from where PID shifts the suspension: it comes back to
    its place."""
    servo = Servo(POSE)
    servo.start()
    length, wind, y, v, step = POSE[3], 0.2, 0.0, 0.0, 10 * H  # ten times fewer ticks, and the test as much shorter
    for _ in range(3000):
        shift = -from_ti(servo.dsp.chip.peek(servo.dsp.symbols["PD_SHIFT"]))
        angle = (y - shift) / length
        servo.dsp.device("SWAY_ALPHA", round(angle / (math.radians(10) / 2048)))
        v += step * (wind - ref.GRAVITY * angle)
        y += step * v
        servo.run()
        servo.tick += 9 * SERVO_TICKS
    assert y == pytest.approx(0.0, abs=0.02) and v == pytest.approx(0.0, abs=0.01)
    assert shift == pytest.approx(-length * wind / ref.GRAVITY, abs=0.03)  # upwind, by force over weight times the rope


def test_spreader_bits_and_command() -> None:
    servo = Servo(POSE)
    for status, bits in ((0x0F, LANDED), (0x07, 0), (0x1F, LANDED | LOCKED), (0x20, OPEN), (0x10, LOCKED)):
        servo.dsp.device("SPREADER_STATUS", status)
        assert servo.run() & (LANDED | LOCKED | OPEN) == bits
    servo.start()
    servo.dsp.put("CR_SPREADER", 1)
    servo.run()
    assert servo.dsp.device_word("SPREADER_COMMAND") == 1
