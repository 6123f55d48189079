"""The assembly's mathematics against Python's, at random arguments and at the borders of its range reductions."""

from __future__ import annotations

import math
import random

import pytest
from harness import Dsp, single
from reference import blend, quintic


@pytest.fixture(scope="module")
def dsp() -> Dsp:
    return Dsp()


def magnitudes(seed: int, count: int = 150) -> list[float]:
    r = random.Random(seed)
    return [single(r.uniform(1, 2) * 2.0 ** r.randint(-40, 40)) for _ in range(count)] + [
        1.0,
        2.0,
        0.5,
        4.0,
        3.0,
        1 - 2**-24,
        2.0**-126,  # the ends of the page's range
        (2 - 2**-22) * 2.0**125,
    ]


def test_reciprocal_is_good_to_29_bits(dsp: Dsp) -> None:
    for x in magnitudes(1):
        for s in (x, -x):
            assert dsp.function("m_reciprocal", s)[0] == pytest.approx(1 / s, rel=2**-29)


def test_roots_are_good_to_28_bits(dsp: Dsp) -> None:
    for x in magnitudes(2):
        assert dsp.function("m_sqrt", x)[0] == pytest.approx(math.sqrt(x), rel=2**-28)
        assert dsp.function("m_rsqrt", x)[0] == pytest.approx(1 / math.sqrt(x), rel=2**-28)
    assert dsp.function("m_sqrt", 0.0)[0] == 0
    assert dsp.function("m_sqrt", -1.0)[0] == 0


def test_sine_and_cosine(dsp: Dsp) -> None:
    r = random.Random(3)
    seams = [k * math.pi / 4 + d for k in range(-8, 9) for d in (-1e-6, 0, 1e-6)]
    for x in seams + [r.uniform(-7, 7) for _ in range(300)] + [r.uniform(-1e4, 1e4) for _ in range(100)]:
        x = single(x)
        s, c = dsp.function("m_sincos", x)[:2]
        bound = 2e-8 + abs(x) * 2**-31
        assert s == pytest.approx(math.sin(x), abs=bound)
        assert c == pytest.approx(math.cos(x), abs=bound)


def test_arc_tangent_in_every_octant(dsp: Dsp) -> None:
    r = random.Random(4)
    pairs = [(r.uniform(-50, 50), r.uniform(-50, 50)) for _ in range(300)]
    pairs += [
        (y * a, x * b) for y in (1, -1) for x in (1, -1) for a, b in ((1, 1), (1, 1e-4), (1e-4, 1), (0.41421356, 1))
    ]
    pairs += [(0.0, 3.0), (3.0, 0.0), (-3.0, 0.0), (0.0, -3.0), (0.0, 0.0)]
    for y, x in pairs:
        y, x = single(y), single(x)
        assert dsp.function("m_atan2", y, x)[0] == pytest.approx(math.atan2(y, x), abs=1e-8), (y, x)
    for t in [r.uniform(-5, 5) for _ in range(100)]:
        assert dsp.function("m_atan", t)[0] == pytest.approx(math.atan(single(t)), abs=1e-8)


def test_wrapped_angle_stays_within_a_half_turn(dsp: Dsp) -> None:
    r = random.Random(5)
    seams = [
        (2 * r.randint(-1590, 1590) + 1) * math.pi + r.choice((-1, 1)) * 10 ** r.uniform(-7, -3) for _ in range(200)
    ]
    for x in map(single, seams + [r.uniform(-1e4, 1e4) for _ in range(200)]):
        out = dsp.function("m_wrap", x)[0]
        assert abs(out) <= math.pi + 1e-8 + abs(x) * 2**-24
        assert math.remainder(out - x, 2 * math.pi) == pytest.approx(0, abs=1e-8 + abs(x) * 2**-31)


def test_hyperbolic_tangent(dsp: Dsp) -> None:
    r = random.Random(6)
    for x in [r.uniform(-12, 12) for _ in range(200)] + [0.0, 1e-5, -1e-5, 9.0, -9.0]:
        assert dsp.function("m_tanh", x)[0] == pytest.approx(math.tanh(single(x)), abs=1e-7)


def test_blends_and_their_derivatives(dsp: Dsp) -> None:
    r = random.Random(7)
    # 2^-31 rounding of sums whose terms reach 16 (S), 2520/64 (derivatives), four to ten operations each
    for u in [0.0, 0.5, 1.0] + [single(r.random()) for _ in range(200)]:
        out = dsp.function("m_blend9", u)
        for got, want, scale in zip(out, blend(u), (16, 3, 40, 160, 1600), strict=True):
            assert got == pytest.approx(want, abs=10 * scale * 2**-31)
        for got, want, scale in zip(dsp.function("m_quintic", u), quintic(u), (20, 2, 15), strict=False):
            assert got == pytest.approx(want, abs=10 * scale * 2**-31)
