"""Decimal to TI floats, against exact rationals."""

import random
from fractions import Fraction

import pytest
from cmrc._core import isa, toolchain


def value_of(word: int, exponent_bits: int, fraction_bits: int) -> Fraction:
    """The value of a TI float word (c40-isa.md 2.2)."""
    exponent = word >> (fraction_bits + 1)
    if exponent >> (exponent_bits - 1):
        exponent -= 1 << exponent_bits
    if exponent == -(1 << (exponent_bits - 1)):
        return Fraction(0)
    sign = word >> fraction_bits & 1
    mantissa = (-2 if sign else 1) + Fraction(word & ((1 << fraction_bits) - 1), 1 << fraction_bits)
    return mantissa * Fraction(2) ** exponent


def single(text: str) -> int:
    return toolchain.assemble(f"\t.float {text}\n").sections[0].words[0]


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("1.0", 0x00000000), ("-1.0", 0xFF800000), ("0.5", 0xFF000000), ("2.0", 0x01000000), ("1.5", 0x00400000),
        ("-1.5", 0x00C00000), ("-2.0", 0x00800000), ("6", 0x02400000), ("3", 0x01400000), ("-3", 0x01C00000),
        ("0.046875", 0xFB400000), ("0.0", 0x80000000), ("-0.0", 0x80000000), ("3.4028234663852886e38", 0x7F7FFFFF),
        ("-3.402823669209385e38", 0x7F800000), ("5.877471754111438e-39", 0x81000000), ("1e-60", 0x80000000),
    ],
)  # fmt: skip
def test_the_references_constants(text: str, word: int) -> None:
    assert single(text) == word


def test_singles_are_nearest_to_the_decimal_as_written() -> None:
    """Random decimals of up to 40 digits: no 24-bit neighbour is nearer than the word chosen."""
    rng = random.Random(7)
    texts = []
    for _ in range(4000):
        digits = "".join(rng.choice("0123456789") for _ in range(rng.randint(1, 40)))
        point = rng.randint(0, len(digits))
        sign = rng.choice(["", "-"])
        texts.append(f"{sign}{digits[:point] or '0'}.{digits[point:]}e{rng.randint(-36, 30) - point}")
    words = toolchain.assemble("".join(f"\t.float {text}\n" for text in texts)).sections[0].words
    for text, word in zip(texts, words, strict=True):
        exact = Fraction(text)
        got = value_of(word, 8, 23)
        if exact == 0 or abs(exact) < Fraction(2) ** -126:
            continue
        assert got * exact > 0
        mantissa, exponent = abs(exact), 0
        while mantissa >= 2:
            mantissa, exponent = mantissa / 2, exponent + 1
        while mantissa < 1:
            mantissa, exponent = mantissa * 2, exponent - 1
        assert abs(got - exact) <= Fraction(2) ** (exponent - 24), text


def test_decimals_a_hair_beside_a_tie_go_to_their_own_side() -> None:
    """1 + 2^-24 lies halfway between two singles; its decimal with a last digit off by one must not round twice."""
    tie = "1.000000059604644775390625"
    assert single(tie) == 0x00000001  # away from zero
    assert single(tie + "0000000000000000000000000001") == 0x00000001
    assert single("1.000000059604644775390624999999999999999999999") == 0x00000000
    assert single("-" + tie) == 0x00FFFFFF
    assert single("-1.000000059604644775390624999999999999999999999") == 0xFF800000


def test_short_floats_round_to_nearest_and_refuse_what_they_cannot_hold() -> None:
    texts = ["2.7", "-27", "0.1", "-0.1", "255.9", "-256", "3.14159", "0.0078125", "100.03"]
    lines = "".join(f"\tldf {text},r0\n" for text in texts)
    words = toolchain.assemble(lines).sections[0].words
    assert words[0] & 0xFFFF == 0x12CD and words[1] & 0xFFFF == 0x4A80  # the reference's examples
    for text, word in zip(texts, words, strict=True):
        exact = Fraction(text)
        assert abs(value_of(word & 0xFFFF, 4, 11) - exact) <= abs(exact) / 2**12
    for text in ("256.0", "-257.0", "255.99"):
        with pytest.raises(toolchain.AssemblyError, match="16-bit float"):
            toolchain.assemble(f"\tldf {text},r0\n")


def test_floats_out_of_range_are_refused() -> None:
    for text in (
        "3.4028236e38",
        "-3.5e38",
        "1e39",
        "1e400",
        "-1e400",
        "1e99999999999999999999",
        "1" + 400 * "0" + ".0",
    ):
        with pytest.raises(toolchain.AssemblyError, match="out of the range of a 32-bit float"):
            toolchain.assemble(f"\t.float {text}\n")
    with pytest.raises(toolchain.AssemblyError, match="out of the range of a 16-bit float"):
        toolchain.assemble("\tldf 1e400,r0\n")


@pytest.mark.parametrize("text", ["1e-50", "1e-400", "-1e-400", "1e-99999999999999999999", "0." + 400 * "0" + "1"])
def test_a_number_nearer_to_0_than_to_the_least_float_is_0(text: str) -> None:
    zero = 0x80000000
    assert list(toolchain.assemble(f"\t.float {text}\n").sections[0].words) == [zero]
    assert list(toolchain.assemble(f"\t.ldouble {text}\n").sections[0].words) == [0x80000000, 0]
    assert list(toolchain.assemble(f"\tldf {text},r0\n").sections[0].words) == [0x07608000]
    assert toolchain.assemble(f"\t.ieee {text}\n").sections[0].words[0] & 0x7FFFFFFF == 0


def test_disassembly_shows_short_floats_exactly() -> None:
    for bits in range(0, 65536, 37):
        text = isa.disassemble(0x07600000 | bits).removeprefix("ldf ").removesuffix(",r0")
        if not text.startswith("="):
            assert Fraction(text) == value_of(bits, 4, 11)
