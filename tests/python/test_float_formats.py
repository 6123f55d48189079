"""The C40's float formats in Python: against exact rationals and the patterns of the data sheets."""

import math
from fractions import Fraction

import pytest
from cmrc import floats
from hypothesis import given
from hypothesis import strategies as st

# c40-isa.md 2.2: value, single-format word.
KNOWN = [
    (0.0, 0x80000000),
    (1.0, 0x00000000),
    (-1.0, 0xFF800000),
    (1.5, 0x00400000),
    (-1.5, 0x00C00000),
    (2.0, 0x01000000),
    (-2.0, 0x00800000),
    (0.5, 0xFF000000),
    (2.0**127 * (2 - 2.0**-23), 0x7F7FFFFF),
    (-(2.0**128), 0x7F800000),
    (2.0**-127, 0x81000000),
]


def exact(exponent_byte: int, mantissa: int, fraction_bits: int) -> Fraction:
    """By the words of the manual: s=0 means 01.f, s=1 means 10.f in two's complement; exponent -128 means zero."""
    exponent = exponent_byte - 256 if exponent_byte > 127 else exponent_byte
    if exponent == -128:
        return Fraction(0)
    sign, f = divmod(mantissa, 1 << fraction_bits)
    return ((-2 if sign else 1) + Fraction(f, 1 << fraction_bits)) * Fraction(2) ** exponent


@pytest.mark.parametrize(("value", "word"), KNOWN)
def test_known_singles(value: float, word: int) -> None:
    assert floats.float_to_single(value) == word
    assert floats.single_to_float(word) == value


@given(st.integers(0, (1 << 32) - 1))
def test_every_single_word_has_its_exact_value(word: int) -> None:
    assert Fraction(floats.single_to_float(word)) == exact(word >> 24, word & 0xFFFFFF, 23)


@given(st.integers(0, (1 << 40) - 1))
def test_every_register_has_its_exact_value_and_comes_back(register: int) -> None:
    value = floats.extended_to_float(register)
    assert Fraction(value) == exact(register >> 32, register & 0xFFFFFFFF, 31)
    if register >> 32 != 0x80:
        assert floats.float_to_extended(value) == register
    else:
        assert floats.float_to_extended(value) == 0x80 << 32


@given(st.floats(min_value=1e-30, max_value=1e30) | st.floats(min_value=-1e30, max_value=-1e-30))
def test_rounding_is_to_the_nearest(value: float) -> None:
    word = floats.float_to_single(value)
    error = abs(Fraction(floats.single_to_float(word)) - Fraction(value))
    exponent = math.frexp(abs(value))[1] - 1
    assert error <= Fraction(2) ** (exponent - 24)


@pytest.mark.parametrize("value", [math.inf, -math.inf, math.nan])
def test_no_counterpart(value: float) -> None:
    with pytest.raises(ValueError, match="no counterpart"):
        floats.float_to_extended(value)


def test_out_of_range() -> None:
    with pytest.raises(OverflowError, match="range"):
        floats.float_to_single(2.0**128)
    with pytest.raises(ValueError, match="40-bit"):
        floats.extended_to_float(1 << 40)
    with pytest.raises(ValueError, match="32-bit"):
        floats.single_to_float(-1)
    assert floats.float_to_single(1e-60) == 0x80000000
