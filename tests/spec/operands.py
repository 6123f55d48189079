"""Operands worth trying: every edge, and random values near edges, near each other, and anywhere."""

from __future__ import annotations

from random import Random

from .formats import pack

WORD = 0xFFFFFFFF

EDGE_WORDS = sorted(
    {
        *(n & WORD for n in range(-3, 4)),
        *((0x80000000 + n) & WORD for n in range(-2, 3)),
        *(1 << n for n in range(32)),
        *(WORD ^ (1 << n) for n in range(0, 32, 5)),
        0x0000FFFF, 0xFFFF0000, 0x00FF00FF, 0x7FFF8000, 0x46340000, 0xB504F334, 0x0000B505, 0x55555555, 0xAAAAAAAA,
        0x7F800000, 0xFF800000, 0x7F7FFFFF, 0xFF7FFFFF, 0x00800000, 0x80800000, 0x007FFFFF, 0x807FFFFF, 0x7FC00000,
        31, 32, 33, 63, 64, 65, WORD - 31, WORD - 32, WORD - 62, WORD - 63, WORD - 64, 127, 128, 255, 256,
    }
)  # fmt: skip

EDGE_EXPONENTS = [-128, -127, -126, -125, -33, -32, -31, -2, -1, 0, 1, 22, 23, 24, 29, 30, 31, 32, 125, 126, 127]
EDGE_MANTISSAS = [
    0, 1, 0x7F, 0x80, 0x81, 0xFF, 0x100, 0x3FFFFFFF, 0x40000000, 0x7FFFFF00, 0x7FFFFF7F, 0x7FFFFF80, 0x7FFFFFFF,
    0x80000000, 0x80000001, 0x8000007F, 0x80000080, 0x80000100, 0xC0000000, 0xFFFFFF00, 0xFFFFFF7F, 0xFFFFFF80, 0xFFFFFFFF,
]  # fmt: skip
# Where results leave the range or change their kind, more often than the rest.
CORNERS = [
    pack(e, m)
    for e in (-128, -127, -126, 30, 31, 126, 127)
    for m in (0, 0x7FFFFF7F, 0x7FFFFFFF, 0x80000000, 0x8000007F, 0xFFFFFF80, 0xFFFFFFFF)
]
EDGE_FLOATS = [pack(e, m) for e in EDGE_EXPONENTS for m in EDGE_MANTISSAS]


def word(rng: Random) -> int:
    kind = rng.random()
    if kind < 0.4:
        return rng.choice(EDGE_WORDS)
    if kind < 0.5:
        return rng.getrandbits(rng.randint(1, 32))
    if kind < 0.6:
        return -rng.getrandbits(rng.randint(1, 31)) & WORD
    return rng.getrandbits(32)


def mantissa(rng: Random) -> int:
    kind = rng.random()
    if kind < 0.3:
        return rng.choice(EDGE_MANTISSAS)
    if kind < 0.45:
        return rng.choice(EDGE_MANTISSAS) + rng.randint(-4, 4) & WORD
    if kind < 0.55:
        return (rng.getrandbits(1) << 31) ^ rng.getrandbits(rng.randint(1, 31))
    return rng.getrandbits(32)


def extended(rng: Random) -> int:
    """A register as a float."""
    kind = rng.random()
    if kind < 0.15:
        return rng.choice(CORNERS)
    if kind < 0.3:
        return rng.choice(EDGE_FLOATS)
    if kind < 0.6:
        return pack(rng.choice(EDGE_EXPONENTS) + rng.randint(-1, 1), mantissa(rng))
    if kind < 0.85:
        return pack(rng.randint(-36, 36), mantissa(rng))
    return pack(rng.randint(-128, 127), mantissa(rng))


def near(rng: Random, other: int) -> int:
    """A float that cancels against the other, or stands a few places away from it."""
    exponent = (other >> 32) + rng.choice((0, 0, 0, 1, -1, 2, 30, 31, 32, 33, 34, -31, -32, -33))
    m = other & WORD
    m = rng.choice((m, m ^ 0x80000000, -m & WORD, (-m & WORD) ^ 0x80000000, mantissa(rng))) + rng.choice((0, 0, 1, -1))
    return pack(exponent, m)
