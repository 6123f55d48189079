"""Conversions between the C40's float formats and Python's floats, exact whenever the target can represent the value;
and a number as text."""

from __future__ import annotations

import math

from cmrc import arguments

_EXTENDED_FRACTION = 31
_SINGLE_FRACTION = 23


def extended_to_float(register: int) -> float:
    """The value of a 40-bit register R0 to R11: exponent in bits 39 to 32, mantissa in 31 to 0.

    Every register value is a double, so the conversion is exact. Raises ValueError outside 0 .. 2**40 - 1.
    """
    register = arguments.whole("register", register, "a 40-bit register value", 0, 2**40 - 1)
    return _value(register >> 32, register & 0xFFFF_FFFF, _EXTENDED_FRACTION)


def single_to_float(word: int) -> float:
    """The value of a memory word in the C40's 32-bit single format: exponent in bits 31 to 24. Exact.

    Raises ValueError outside 0 .. 2**32 - 1.
    """
    word = arguments.whole("word", word, "a 32-bit word", 0, 2**32 - 1)
    return _value(word >> 24, word & 0x00FF_FFFF, _SINGLE_FRACTION)


def float_to_extended(value: float) -> int:
    """The 40-bit register value nearest to a float, ties away from zero; 0 for a value that is too small.

    Raises OverflowError for a value that is too large, ValueError for NaN and infinities.
    """
    exponent, mantissa = _parts(value, _EXTENDED_FRACTION)
    return (exponent & 0xFF) << 32 | mantissa


def float_to_single(value: float) -> int:
    """The 32-bit single-format word nearest to a float, ties away from zero; 0 for a value that is too small.

    Raises OverflowError for a value that is too large, ValueError for NaN and infinities.
    """
    exponent, mantissa = _parts(value, _SINGLE_FRACTION)
    return (exponent & 0xFF) << 24 | mantissa


def shortest(value: bool | float | str) -> str:
    """A value as it is written in a message, a table or a plot: a number with the digits that give it back."""
    if not isinstance(value, float):
        return str(value)
    few = f"{value:g}"
    return few if float(few) == value else repr(value)


def _value(exponent: int, mantissa: int, fraction: int) -> float:
    if exponent == 0x80:  # zero for any mantissa
        return 0.0
    sign = mantissa >> fraction
    scaled = mantissa - (1 << (fraction + 1)) - (1 << fraction) if sign else mantissa + (1 << fraction)
    return math.ldexp(scaled, (exponent - 0x100 if exponent & 0x80 else exponent) - fraction)


def _parts(value: float, fraction: int) -> tuple[int, int]:
    """Exponent and mantissa field. The implied bit is the sign's complement: 1.f or -2 + 0.f."""
    value = arguments.number("value", value) if not isinstance(value, float) else value
    if not math.isfinite(value):
        raise ValueError(f"value: {value} has no counterpart on the C40; a finite number is expected")
    if value == 0:
        return -128, 0
    significand, exponent = math.frexp(abs(value))
    scaled = _round_away(math.ldexp(significand, fraction + 1))
    exponent -= 1
    one = 1 << fraction
    if scaled == 2 * one and value > 0:
        scaled, exponent = one, exponent + 1
    if scaled == one and value < 0:  # -1.0 is -2.0 of the next lower exponent
        scaled, exponent = 2 * one, exponent - 1
    if exponent > 127:
        greatest = math.ldexp(2 * one - 1, 127 - fraction)
        raise OverflowError(f"value: {value} is beyond the C40's range; -2^128 to {greatest!r} is expected")
    if exponent < -127:
        return -128, 0
    mantissa = scaled - one if value > 0 else 3 * one - scaled
    return exponent, mantissa & (2 * one - 1) if value > 0 else mantissa


def _round_away(positive: float) -> int:
    whole = math.floor(positive)
    return whole + (positive - whole >= 0.5)
