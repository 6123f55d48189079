"""The parameters of PID's law: read by generation and kept on chip, scheduled by luff angle and load, changed without a
bump."""

from __future__ import annotations

import itertools
import math

import pytest
import reference as ref
from test_pid import MASS, POSE, Servo, counts

ROW = 11
FILTER, SHARE, SHARE_BEFORE = 5, 9, 10


def resting(load: float = MASS, pose: list[float] = POSE) -> Servo:
    """On, at the pose, with a feed-forward of 100 N m on each joint; what the start has left of derivative and error is
    gone."""
    servo = Servo(pose)
    servo.dsp.put("CR_LOAD", load)
    servo.start()
    for offset in (24, 29, 34):
        servo.dsp.put("CR_CONSUMED", *[0.0] * 5, offset=offset)
    servo.dsp.put("CR_FEED_FORWARD", *[40.0] * 5)
    return servo


@pytest.mark.parametrize(("luff_deg", "mass"), list(itertools.product((21, 50, 79), (10e3, 34e3, 50e3))))
def test_gains_follow_the_luff_angle_and_the_load(luff_deg: float, mass: float) -> None:
    """A jump of the encoders by a few counts asks for K (1 + N T_d / (T_d + N h)) times it."""
    pose = [0.0, 0.9, math.radians(luff_deg), 30.0, -0.9]
    servo = resting(mass, pose)
    servo.run()
    before = servo.codes()
    steps = [3, 3, 3, 3, 3]
    servo.encoders([c - n for c, n in zip(servo.total, steps, strict=True)])
    servo.run()
    k_p = ref.stiffness(pose[2], mass)
    for j, (now, old) in enumerate(zip(servo.codes(), before, strict=True)):
        filtered = ref.T_D[j] / (ref.T_D[j] + ref.N_D * 1e-3)
        want = k_p[j] * (1 + ref.N_D * filtered) * steps[j] / ref.COUNTS[j] * ref.CODE[j]
        # Rounding of the encoders' places to single, as in test_pid, and the code's own.
        place = 4 * (2**-20 if j == 3 else 2**-25)
        assert now - old == pytest.approx(want, abs=2 + k_p[j] * (1 + ref.N_D) * place * ref.CODE[j]), j


def test_parameters_are_kept_on_chip_until_their_generation_changes() -> None:
    servo = resting()
    servo.run()
    before = servo.codes()
    other = [2 * word if i % ROW < FILTER and i < 5 * ROW else word for i, word in enumerate(ref.control_block())]
    servo.dsp.put("CR_CONTROL_BLOCK", *other)  # the host has not yet said that they count
    for _ in range(3):
        servo.run()
    moved = [c - 3 for c in servo.total]
    servo.encoders(moved)
    servo.run()
    once = [b - a for a, b in zip(before, servo.codes(), strict=True)]
    servo.encoders(servo.total)
    servo.dsp.put("CR_CONTROL", 2)
    for _ in range(200):
        servo.run()
    before = servo.codes()
    servo.encoders(moved)
    servo.run()
    twice = [b - a for a, b in zip(before, servo.codes(), strict=True)]
    for j in range(1, 5):
        assert twice[j] == pytest.approx(2 * once[j], rel=0.1, abs=6), j


def test_a_change_moves_no_drive() -> None:
    """The gains change by a factor of four, the feed-forward to a quarter. With a constant error, the torque continues
    without a jump."""
    servo = resting()
    servo.encoders([c - 2 for c in servo.total])
    for _ in range(300):  # the derivative has died away, the integral continues
        servo.run()
    codes = []
    for _ in range(2):
        servo.run()
        codes.append(servo.codes())
    assert all(abs(code) < 2000 for code in codes[-1])  # none says nothing because it is at its limit
    ordinary = [abs(b - a) for a, b in zip(*codes, strict=True)]
    block = ref.control_block()
    for j in range(5):
        for term in range(FILTER):
            block[j * ROW + term] *= 4
        block[j * ROW + SHARE], block[j * ROW + SHARE_BEFORE] = 0.25, 1.0
    servo.dsp.control(block, generation=2)
    servo.run()
    for j, (old, now) in enumerate(zip(codes[-1], servo.codes(), strict=True)):
        assert abs(now - old) <= 2 + 4 * ordinary[j], j
    # The gain counts all the same: a quarter of the next change of the feed-forward comes through.
    before = servo.codes()
    servo.dsp.put("CR_FEED_FORWARD", *[-40.0] * 5)
    servo.run()
    for j, (old, now) in enumerate(zip(before, servo.codes(), strict=True)):
        assert now - old == pytest.approx(-80 * 0.25 * ref.CODE[j], abs=2 + 8 * ordinary[j]), j


def test_another_dsp_takes_the_change_over_without_a_bump() -> None:
    """The tick after a change runs on a chip that has never read the block: the state says which generation it was
    computed with."""
    servo = resting()
    for _ in range(5):
        servo.run()
    block = ref.control_block()
    for j in range(5):
        block[j * ROW + SHARE], block[j * ROW + SHARE_BEFORE] = 0.5, 1.0
    servo.dsp.control(block, generation=2)
    before = servo.codes()
    servo.dsp.chip.poke(servo.dsp.symbols["K_PC_GENERATION"], 0xFFFFFFFF)  # as a chip that has just booted
    servo.run()
    assert servo.codes() == pytest.approx(before, abs=2)
    servo.dsp.chip.poke(servo.dsp.symbols["K_PC_GENERATION"], 0xFFFFFFFF)
    servo.run()
    assert servo.codes() == pytest.approx(before, abs=2)  # and only once


def test_a_joint_rests_when_its_set_point_does_and_its_error_is_small() -> None:
    servo = resting()
    servo.run()
    assert servo.rests == 0x1F
    slew = servo.total[1] + math.ceil(0.002 * ref.COUNTS[1])  # more than 1.5 mrad
    servo.encoders([slew if j == 1 else c for j, c in enumerate(servo.total)])
    servo.run()
    assert servo.rests == 0x1D
    servo.encoders(servo.total)
    for k in range(2):
        servo.put_point(k, POSE, [0.0, 0.01, 0.0, 0.0, 0.0], [0.0] * 4)
    servo.run()
    assert servo.rests == 0
    assert counts(POSE) == servo.total
