"""Numbers and their formats (c40-isa.md 2.2), as exact rationals."""

from __future__ import annotations

from fractions import Fraction
from math import floor

ZERO = 0x80_0000_0000
MOST_POSITIVE = 0x7F_7FFF_FFFF
MOST_NEGATIVE = 0x7F_8000_0000
ZERO_EXPONENT = -128
TWO = Fraction(2)
POWERS = {e: TWO**e for e in range(-320, 321)}


def signed(value: int, width: int) -> int:
    value &= (1 << width) - 1
    return value - (1 << width) if value >> (width - 1) else value


def exponent(register: int) -> int:
    return signed(register >> 32, 8)


def mantissa(register: int) -> int:
    return register & 0xFFFFFFFF


def pack(e: int, m: int) -> int:
    return (e & 0xFF) << 32 | m & 0xFFFFFFFF


def value(register: int) -> Fraction:
    """x = ((s ? -2 : 1) + f) * 2^e, and 0 for the most negative exponent."""
    e = exponent(register)
    if e == ZERO_EXPONENT:
        return Fraction(0)
    sign, fraction = register >> 31 & 1, register & 0x7FFFFFFF
    return Fraction(((-2 if sign else 1) << 31) + fraction) * POWERS[e - 31]


def canonical(register: int) -> int:
    return ZERO if exponent(register) == ZERO_EXPONENT else register


def from_single(word: int) -> int:
    """A memory word as an operand."""
    return canonical(from_single_raw(word))


def from_single_raw(word: int) -> int:
    """The word's bits at their places in a register, for every exponent."""
    return word << 8


def to_single(register: int) -> int:
    """What STF stores: truncation of the low eight bits."""
    return register >> 8


def from_short(half: int) -> int:
    e = signed(half >> 12, 4)
    return ZERO if e == -8 else pack(e, (half & 0xFFF) << 20)


def binary_exponent(x: Fraction) -> int:
    """The e for which x / 2^e lies in [1, 2) or in [-2, -1)."""
    n, d = x.numerator, x.denominator
    # A negative number's interval is closed at the other end.
    magnitude = n if n > 0 else -n
    e = magnitude.bit_length() - d.bit_length()
    at_least = magnitude << -e >= d if e < 0 else magnitude >= d << e
    if not at_least:
        e -= 1
    if n < 0 and magnitude * (1 << max(-e, 0)) == d * (1 << max(e, 0)):
        e -= 1
    return e


def floor_to(x: Fraction, unit: Fraction) -> Fraction:
    """The greatest multiple of unit that is not above x."""
    return floor(x / unit) * unit


def encode(x: Fraction, e: int) -> int:
    """The register that holds x, which must be representable with exponent e."""
    scaled = x / POWERS[e] - (1 if x > 0 else -2)
    fraction = scaled * (1 << 31)
    assert fraction.denominator == 1 and 0 <= fraction < 1 << 31, (x, e)
    return pack(e, (x < 0) << 31 | int(fraction))
