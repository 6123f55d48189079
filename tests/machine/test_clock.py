"""Clocks against exact rationals (ruling 1)."""

import random
from fractions import Fraction

import pytest
from cmrc._core import machine

FREQUENCIES = [
    (20_000_000, 1),
    (25_000_000, 1),
    (30_000_000, 1),
    (100_000_000, 3),
    (33_333_333, 1),
    (8_000, 1),
    (1, 1),
    (7, 3),
    (999_999_999_999, 1),
]


@pytest.mark.parametrize("num, den", FREQUENCIES)
def test_ticks_stand_at_the_floor_of_their_exact_instant(num: int, den: int) -> None:
    draw = random.Random(num)
    for phase in (0, 12_345):
        clock = machine.Clock(num, den, phase)
        period = Fraction(10**12 * den, num)
        for _ in range(300):
            tick = draw.randrange(-1000, int(4 * 10**14 / period) + 2)
            instant = phase + (tick * period.numerator) // period.denominator
            assert clock.at(tick) == instant
            at = draw.choice([instant, instant - 1, instant + 1, instant + draw.randrange(int(period) + 1)])
            before, after = clock.tick_at_or_before(at), clock.tick_at_or_after(at)
            assert clock.at(before) <= at < clock.at(before + 1)
            assert clock.at(after) >= at > clock.at(after - 1)


def test_impossible_clocks_are_refused() -> None:
    for num, den in ((0, 1), (-5, 1), (5, 0), (10**13, 1)):
        with pytest.raises(ValueError):
            machine.Clock(num, den)
