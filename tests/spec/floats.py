"""Floating-point arithmetic (c40-isa.md 7.1 to 7.7, 7.10, 2.3): operands and results are 40-bit registers.

Every function gives (result, flags). The result of an operation is its exact value, or the exact value of what
alignment leaves, taken to 32 bits of mantissa towards minus infinity.
"""

from __future__ import annotations

from fractions import Fraction
from math import floor, isqrt

from .flags import Flags
from .formats import (
    MOST_NEGATIVE,
    MOST_POSITIVE,
    POWERS,
    ZERO,
    ZERO_EXPONENT,
    binary_exponent,
    canonical,
    encode,
    exponent,
    floor_to,
    from_single_raw,
    mantissa,
    pack,
    signed,
    value,
)

Result = tuple[int, Flags]
FRACTION_BITS = 31
SINGLE_FRACTION_BITS = 23


def finish(x: Fraction) -> Result:
    """7.1: flags from the exact value, the value floored to a register."""
    if x == 0:
        return ZERO, Flags(v=False, z=True, n=False, uf=False)
    e = binary_exponent(x)
    negative = x < 0
    if e > 127:
        return (MOST_NEGATIVE if negative else MOST_POSITIVE), Flags(v=True, z=False, n=negative, uf=False)
    if e < -127:
        return ZERO, Flags(v=False, z=False, n=negative, uf=True)
    return encode(floor_to(x, POWERS[e - FRACTION_BITS]), e), Flags(v=False, z=False, n=negative, uf=False)


def aligned(a: int, b: int) -> tuple[Fraction, Fraction]:
    """7.2: both on the grid of the one with the greater exponent."""
    unit = POWERS[max(exponent(a), exponent(b)) - FRACTION_BITS]
    return floor_to(value(a), unit), floor_to(value(b), unit)


def addf(a: int, b: int) -> Result:
    x, y = aligned(a, b)
    return finish(x + y)


def subf(a: int, b: int) -> Result:
    x, y = aligned(a, b)
    return finish(x - y)


def mpyf(a: int, b: int) -> Result:
    return finish(value(a) * value(b))


def negf(a: int) -> Result:
    return finish(-value(a))


def absf(a: int) -> Result:
    return finish(abs(value(a)))


def rnd(a: int) -> Result:
    """7.4: to the nearest single, a half goes up; Z is always cleared, and zero sets UF."""
    x = value(a)
    if x == 0:
        return ZERO, Flags(v=False, z=False, n=False, uf=True)
    x += POWERS[exponent(a) - SINGLE_FRACTION_BITS - 1]
    e = binary_exponent(x)
    result, flags = finish(floor_to(x, POWERS[e - SINGLE_FRACTION_BITS]))
    return (result & ~0xFF if flags.v else result), flags


def ldf(a: int) -> Result:
    a = canonical(a)
    return a, Flags(v=False, z=a == ZERO, n=value(a) < 0, uf=False)


def fix(a: int) -> tuple[int, Flags]:
    """7.5: the floor as a 32-bit integer, saturated."""
    i = floor(value(a))
    limited = min(max(i, -(1 << 31)), (1 << 31) - 1)
    return limited & 0xFFFFFFFF, Flags(v=limited != i, z=i == 0, n=i < 0, uf=False)


def float_(word: int) -> Result:
    return finish(Fraction(signed(word, 32)))


def norm(a: int) -> Result:
    """7.7: the mantissa has no implied bit."""
    m = signed(mantissa(a), 32)
    if m == 0:
        return ZERO, Flags(v=False, z=True, n=False, uf=False)
    if exponent(a) == ZERO_EXPONENT:
        return ZERO, Flags(v=False, z=False, n=m < 0, uf=True)
    return finish(m * POWERS[exponent(a) - FRACTION_BITS])


def lde(a: int, old: int) -> int:
    return canonical(pack(exponent(a), mantissa(old)))


def toieee(a: int) -> Result:
    """2.3, unverified parts as the text recommends. The IEEE word stands in bits 39..8."""
    x = value(a)
    if x == 0:
        return 0, Flags(v=False, z=True, n=False, uf=False)
    e = exponent(a)
    if e == -127:
        return 0, Flags(v=False, z=True, n=x < 0, uf=True)
    x = floor_to(x, POWERS[e - SINGLE_FRACTION_BITS])
    magnitude = abs(x)
    power = binary_exponent(magnitude)
    infinite = power > 127
    fraction = 0 if infinite else int((magnitude / POWERS[power] - 1) * (1 << SINGLE_FRACTION_BITS))
    word = (x < 0) << 31 | (255 if infinite else power + 127) << 23 | fraction
    return from_single_raw(word), Flags(v=infinite, z=False, n=x < 0, uf=False)


def frieee(word: int) -> Result:
    """2.3: the value of an IEEE single; zero for denormals; saturated for infinities and NaNs."""
    negative, biased, fraction = word >> 31 == 1, word >> 23 & 0xFF, word & 0x7FFFFF
    if biased == 255:
        return (MOST_NEGATIVE if negative else MOST_POSITIVE & ~0xFF), Flags(v=True, z=False, n=negative, uf=False)
    if biased == 0:
        return ZERO, Flags(v=False, z=True, n=False, uf=fraction != 0)
    magnitude = (1 + Fraction(fraction, 1 << SINGLE_FRACTION_BITS)) * POWERS[biased - 127]
    return finish(-magnitude if negative else magnitude)


# The seeds (c40-isa.md 7.10) are the text's recommended model: eight fraction bits, of the middle of the operand's
# interval.


def nearest(x: Fraction) -> int:
    return floor(x + Fraction(1, 2))


def seed(eighths: int, e: int) -> Fraction:
    """1.ffffffff * 2^e, the eight bits limited to what they hold."""
    return (1 + Fraction(min(eighths, 255), 256)) * POWERS[e]


def split(magnitude: Fraction) -> tuple[int, Fraction, Fraction]:
    """Exponent, fraction, and the middle of the interval given by the fraction's top eight bits."""
    e = binary_exponent(magnitude)
    fraction = magnitude / POWERS[e] - 1
    return e, fraction, 1 + (floor(fraction * 256) + Fraction(1, 2)) / 256


def rcpf(a: int) -> Result:
    x = value(a)
    if x == 0:
        return MOST_POSITIVE, Flags(v=True, z=False, n=False, uf=False)
    e, fraction, middle = split(abs(x))
    result = POWERS[-e] if fraction == 0 else seed(nearest((2 / middle - 1) * 256), -e - 1)
    return finish(-result if x < 0 else result)


def rsqrf(a: int) -> Result:
    x = value(a)
    if x == 0:
        return MOST_POSITIVE, Flags(v=True, z=False, n=False, uf=False)
    e, fraction, middle = split(abs(x))
    q, p = e // 2, e % 2
    if p == 0 and fraction == 0:
        return finish(POWERS[-q])
    # nearest(256 * (2 / sqrt(y) - 1)) = nearest(sqrt(512^2 / y)) - 256
    square = Fraction(512 * 512) / (middle * 2**p)
    rounded = (isqrt(floor(4 * square)) + 1) // 2
    return finish(seed(rounded - 256, -q - 1))
