"""PID as plant-and-bus.md 2.1 prints it (kernels.pid = "measurement_derivative"): derivative on the measurement,
first-order hold between points."""

from __future__ import annotations

import random

import pytest
import reference as ref
from test_pid import MASS, POINT_TICKS, POSE, SERVO_TICKS, H, Servo, single


class Printed(Servo):
    """The same inputs, the other build."""

    def run(self) -> int:
        result, notify, _ = self.dsp.run("pid_document", tick=self.tick)
        self.errors, self.rests = notify & 0x7FFFFF, notify >> 23
        self.tick += SERVO_TICKS
        return result


def test_ticks_are_the_printed_law() -> None:
    for seed in range(6):
        r = random.Random(seed)
        servo = Printed(POSE)
        servo.start()
        dsp = servo.dsp
        a = [single(x + r.uniform(-0.01, 0.01)) for x in POSE]
        b = [single(x + r.uniform(-0.001, 0.001)) for x in a]
        servo.put_point(6, a, [0.05] * 5, [0.0, 0.0, -0.04, 0.05])
        servo.put_point(7, b, [-0.05] * 5, [0.0, 0.0, -0.04, 0.05])  # rates do not enter
        dsp.put("CR_CONSUMED", 8)
        start = servo.tick
        dsp.put("CR_SEGMENT_START", start)
        for offset in (24, 29, 34):  # from nothing
            dsp.put("CR_CONSUMED", *[0.0] * 5, offset=offset)
        for offset in (5, 13):
            dsp.put("CR_CONSUMED", 0.0, 0.0, offset=offset)
        feed = [single(r.uniform(-0.3, 0.3) * u) for u in ref.U_MAX]
        dsp.put("CR_FEED_FORWARD", *feed)
        old = [c / u for c, u in zip(servo.total, ref.COUNTS, strict=True)]
        derivative, integral = [0.0] * 5, [0.0] * 5
        counts = list(servo.total)
        last = [0.0] * 5
        for tick in range(4):
            counts = [c + r.randrange(-100, 100) for c in counts]
            servo.encoders(counts)
            y = [c / u for c, u in zip(counts, ref.COUNTS, strict=True)]
            phase = tick * SERVO_TICKS / POINT_TICKS
            want = []
            k_p = ref.stiffness(y[2], MASS)
            for j in range(5):
                e = a[j] + phase * (b[j] - a[j]) - y[j]
                c = ref.T_D[j] / (ref.T_D[j] + ref.N_D * H)
                derivative[j] = c * (derivative[j] - k_p[j] * ref.N_D * (y[j] - old[j]))
                integral[j] += k_p[j] * (e - last[j])  # with K e in it
                v = integral[j] + derivative[j] + feed[j]
                last[j] = e
                u = min(max(v, -ref.U_MAX[j]), ref.U_MAX[j])
                integral[j] += k_p[j] * H / ref.T_I[j] * e + H / ref.T_T[j] * (
                    u - v
                )  # back calculation: what saturates is taken off
                want.append(u)
            servo.run()
            for j in range(5):
                # As in test_pid: the measurement's and the set-point's roundings through K (1 + N), once per tick gone,
                # and one code.
                place = 4 * (2**-20 if j == 3 else 2**-25)
                bound = 1 + (1 + tick) * k_p[j] * (1 + ref.N_D) * place * ref.CODE[j]
                assert servo.codes()[j] == pytest.approx(want[j] * ref.CODE[j], abs=bound), (seed, tick, j)
            old = y


def test_a_step_of_the_set_point_does_not_kick() -> None:
    """The derivative sees the measurement only: a step of the set-point adds K times the step, where the error's
    derivative would add K N more."""
    kicks = []
    for kind in (Printed, Servo):
        servo = kind(POSE)
        servo.start()
        servo.put_point(0, POSE, [0.0] * 5, [0.0, 0.0, -0.04, 0.05])
        servo.dsp.put("CR_FEED_FORWARD", *[0.0] * 5)
        for _ in range(3):
            servo.run()
        before = servo.codes()[1]
        servo.put_point(0, [POSE[0], POSE[1] + 1e-5, *POSE[2:]], [0.0] * 5, [0.0, 0.0, -0.04, 0.05])
        servo.run()
        kicks.append(servo.codes()[1] - before)
    # The fourth tick is at 3/8 of the way from the pose to point 0.
    proportional = ref.stiffness(POSE[2], MASS)[1] * 1e-5 * 3 / 8 * ref.CODE[1]
    assert kicks[0] == pytest.approx(proportional, abs=3)
    assert kicks[1] > 4 * proportional
