"""The emulator against the specification, one instruction at a time; Hypothesis searches for differences."""

from __future__ import annotations

from typing import Any

import pytest
from cmrc._core import c40
from hypothesis import given, settings
from hypothesis import strategies as some

from spec import addressing, floats, formats, integers
from spec.flags import CONDITION_NAMES, GIE, IMPLEMENTED, OVM, RM, SET_COND
from spec.machine import Machine
from spec.operands import EDGE_EXPONENTS, EDGE_FLOATS, EDGE_MANTISSAS, EDGE_WORDS
from spec.state import BK, DP, IIE, IR0, IR1, NAMES, RC, ST

WORD = 0xFFFFFFFF
DATA = 0x2000
words = some.sampled_from(EDGE_WORDS) | some.integers(0, WORD)
mantissas = some.sampled_from(EDGE_MANTISSAS) | some.integers(0, WORD)
exponents = some.sampled_from(EDGE_EXPONENTS) | some.integers(-128, 127)
registers = some.sampled_from(EDGE_FLOATS) | some.builds(formats.pack, exponents, mantissas)
statuses = some.integers(0, 0xFFFF).map(lambda st: st & IMPLEMENTED & ~RM)


@pytest.fixture(scope="module")
def processor() -> Any:
    return c40.Processor("flat")


def compare(processor: Any, word: int, values: dict[int, int], memory: dict[int, int] | None = None) -> None:
    """One step of both from the same state; every register and word must agree."""
    values = {code: 0 for code in range(32)} | values
    model = Machine(r=[values[code] for code in range(32)], memory={0x1000: word} | (memory or {}))
    processor.reset()
    for address, content in model.memory.items():
        processor.poke(address, content)
    for code, value in sorted(values.items(), key=lambda item: item[0] == ST):
        processor.set(NAMES[code], value)
    processor.pc = 0x1000
    assert processor.step()["reason"] == "limit"
    model.step()
    actual = {name: f"{processor.get(name):X}" for name in NAMES} | {"PC": f"{processor.pc:X}"}
    expected = {name: f"{model.r[code]:X}" for code, name in enumerate(NAMES)} | {"PC": f"{model.pc:X}"}
    assert actual == expected
    for address, content in model.memory.items():
        assert processor.peek(address) == content


# ---- registers to registers ----

FLOAT_THREE = {"addf3": 1, "cmpf3": 6, "mpyf3": 9, "subf3": 13}
INTEGER_THREE = {name: op for op, name in enumerate(
    ["addc", "-", "addi", "and", "andn", "ash", "-", "cmpi", "lsh", "-", "mpyi", "or", "subb", "-", "subi", "tstb", "xor", "mpyshi", "mpyuhi"]) if name != "-"}  # fmt: skip
FLOAT_TWO = {"absf": 0, "fix": 10, "lde": 13, "ldf": 14, "ldm": 18, "negf": 23, "norm": 26, "rnd": 34, "subrf": 50,
             "toieee": 55, "rsqrf": 57, "rcpf": 58}  # fmt: skip
INTEGER_TWO = {
    "absi": 1,
    "float": 11,
    "ldi": 16,
    "negb": 22,
    "negi": 24,
    "not": 27,
    "subc": 46,
    "subrb": 49,
    "subri": 51,
}
ROTATES = {"rol": 0x11E00000 + 1, "rolc": 0x12600000 + 1, "ror": 0x12E0FFFF, "rorc": 0x1360FFFF}


@pytest.mark.parametrize("op", FLOAT_THREE.values(), ids=FLOAT_THREE)
@settings(max_examples=150, deadline=None)
@given(a=registers, b=registers, st=statuses)
def test_float_operations_on_two_registers(processor: Any, op: int, a: int, b: int, st: int) -> None:
    compare(processor, 0x20000102 | op << 23, {1: a, 2: b, ST: st})


@pytest.mark.parametrize("op", FLOAT_THREE.values(), ids=FLOAT_THREE)
@settings(max_examples=100, deadline=None)
@given(a=registers, distance=some.sampled_from([0, 1, 2, 30, 31, 32, 33, 34]), m=mantissas, flip=some.booleans())
def test_float_operations_that_cancel(processor: Any, op: int, a: int, distance: int, m: int, flip: bool) -> None:
    near = formats.pack(formats.exponent(a) - distance, (a ^ 0x80000000 if flip else -a & WORD) if m & 1 else m)
    compare(processor, 0x20000102 | op << 23, {1: a, 2: near})
    compare(processor, 0x20000102 | op << 23, {1: near, 2: a})


@pytest.mark.parametrize("op", INTEGER_THREE.values(), ids=INTEGER_THREE)
@settings(max_examples=100, deadline=None)
@given(a=words, b=words, st=statuses)
def test_integer_operations_on_two_registers(processor: Any, op: int, a: int, b: int, st: int) -> None:
    compare(processor, 0x20000102 | op << 23, {0: 0x5A << 32, 1: a, 2: 0x7F << 32 | b, ST: st})


@pytest.mark.parametrize("op", FLOAT_TWO.values(), ids=FLOAT_TWO)
@settings(max_examples=120, deadline=None)
@given(a=registers, old=registers, st=statuses)
def test_float_operations_on_one_register(processor: Any, op: int, a: int, old: int, st: int) -> None:
    compare(processor, op << 23 | 1, {0: old, 1: a, ST: st})


@pytest.mark.parametrize("op", INTEGER_TWO.values(), ids=INTEGER_TWO)
@settings(max_examples=100, deadline=None)
@given(a=words, old=registers, st=statuses)
def test_integer_operations_on_one_register(processor: Any, op: int, a: int, old: int, st: int) -> None:
    compare(processor, op << 23 | 1, {0: old, 1: a, ST: st})


@pytest.mark.parametrize("word", ROTATES.values(), ids=ROTATES)
@settings(max_examples=50, deadline=None)
@given(a=words, st=statuses)
def test_rotates(processor: Any, word: int, a: int, st: int) -> None:
    compare(processor, word, {0: 0x33 << 32 | a, ST: st})


@pytest.mark.parametrize("sub", range(26))
@settings(max_examples=25, deadline=None)
@given(a=words, old=words, st=statuses)
def test_part_words(processor: Any, sub: int, a: int, old: int, st: int) -> None:
    compare(processor, 0xB0000001 | sub << 23, {0: 0x44 << 32 | old, 1: a, ST: st})


@settings(max_examples=150, deadline=None)
@given(a=words, st=statuses)
def test_ieee_singles_from_memory(processor: Any, a: int, st: int) -> None:
    compare(processor, 0x1C200000 | DATA, {ST: st}, {DATA: a})


@settings(max_examples=100, deadline=None)
@given(
    product=some.tuples(registers, registers),
    total=some.tuples(registers, registers),
    op=some.integers(0, 3),
    st=statuses,
)
def test_multiply_and_add_in_parallel(
    processor: Any, product: tuple[int, int], total: tuple[int, int], op: int, st: int
) -> None:
    """P = 2: K x H and J +- I, so that the product has full registers."""
    memory = {DATA: total[0] >> 8, DATA + 1: total[1] >> 8}
    word = 0x82000000 | op << 26 | 5 << 19 | 6 << 16 | 0xC000 | 0xC1
    compare(processor, word, {5: product[0], 6: product[1], 8: DATA, 9: DATA + 1, ST: st}, memory)


# ---- SET COND, OVM, conditions, addresses ----


@settings(max_examples=300, deadline=None)
@given(op=some.sampled_from([2, 4, 5, 7, 16, 19, 21, 22, 24, 27, 32, 45, 48, 53, 1, 59]), dst=some.integers(8, 27).filter(lambda c: c != 24),
       a=words, old=words, st=statuses, set_cond=some.booleans(), ovm=some.booleans())  # fmt: skip
def test_destinations_outside_the_extended_registers(
    processor: Any, op: int, dst: int, a: int, old: int, st: int, set_cond: bool, ovm: bool
) -> None:
    """Flags follow with SET COND only, and never an ST that is the destination; saturation follows OVM alone."""
    st = st & ~(SET_COND | OVM) | SET_COND * set_cond | OVM * ovm
    if dst == IIE:
        st &= ~GIE  # the empty output FIFOs would ask at once
    compare(processor, op << 23 | dst << 16 | 1, {1: a, ST: st} | ({dst: old} if dst != ST else {}))


@pytest.mark.parametrize("name", [name for name in CONDITION_NAMES if name != "-"])
def test_conditions_on_every_combination_of_flags(processor: Any, name: str) -> None:
    code = CONDITION_NAMES.index(name)
    for flags in range(128):
        compare(processor, 0x50000001 | code << 23, {0: 0x1100000022, 1: 0x3300000044, ST: flags})


@settings(max_examples=300, deadline=None)
@given(
    modn=some.integers(0, 25),
    ar=words,
    ir=some.tuples(words, words) | some.tuples(some.integers(0, 64), some.integers(0, 64)),
    bk=some.integers(1, 70) | words.filter(bool),
    displacement=some.sampled_from([0, 1, 2, 255]) | some.integers(0, 255),
)
def test_address_updates(processor: Any, modn: int, ar: int, ir: tuple[int, int], bk: int, displacement: int) -> None:
    """Any address, index and block size, steps beyond the block included."""
    word = 0x0CC00300 | modn << 11 | (displacement if modn < 8 else 0)
    compare(processor, word, {11: ar, IR0: ir[0], IR1: ir[1], BK: bk})


@settings(max_examples=100, deadline=None)
@given(dp=words, offset=some.integers(0, 0xFFFF), value=words)
def test_direct_addresses_take_sixteen_bits_of_the_page(processor: Any, dp: int, offset: int, value: int) -> None:
    address = (dp << 16 | offset) & WORD
    if (
        not 0x0FF0 < address < 0x1010 and not 0x100000 <= address < 0x100100
    ):  # the program; peripheral registers (ruling 34)
        compare(processor, 0x08200000 | offset, {DP: dp}, {address: value})
        processor.poke(address, 0)


@settings(max_examples=100, deadline=None)
@given(rc=some.sampled_from([0, 1, WORD, 0x80000000]) | words, value=words)
def test_writing_the_status_cannot_set_rm_without_a_count(processor: Any, rc: int, value: int) -> None:
    compare(processor, 0x08150001, {1: value, RC: rc, 26: 0x5000})


# ---- the specification's own sense: known values of the text ----


def test_the_specification_knows_the_constants_of_the_text() -> None:
    values = {0x00000000: 1, 0xFF800000: -1, 0xFF000000: 0.5, 0x01000000: 2, 0x00400000: 1.5, 0x00C00000: -1.5,
              0x00800000: -2, 0x02400000: 6, 0x01400000: 3, 0x01C00000: -3, 0xFB400000: 0.046875}  # fmt: skip
    for word, number in values.items():
        assert formats.value(formats.from_single(word)) == number
        assert floats.finish(formats.value(formats.from_single(word)))[0] == word << 8
    shorts = {0x0000: 1, 0xF800: -1, 0xF000: 0.5, 0xE800: -0.5, 0x0400: 1.5, 0x0C00: -1.5, 0x4A80: -27, 0x77FF: 255.9375,
              0x9000: 2**-7, 0x7800: -256}  # fmt: skip
    for half, number in shorts.items():
        assert formats.value(formats.from_short(half)) == number
    assert formats.value(formats.MOST_NEGATIVE) == -(2**128)
    assert formats.value(formats.MOST_POSITIVE) == (2 - formats.POWERS[-31]) * 2**127


def test_the_specification_gives_the_examples_of_the_text() -> None:
    add = integers.addi(0x7FFFFFFF, 1, 0)
    assert add[0] == 0x80000000 and (add[1].z, add[1].v, add[1].n, add[1].c) == (False, True, False, False)
    subtract = integers.subi(0x80000000, 0x7FFFFFFF, 0)
    assert subtract[0] == 1 and (subtract[1].v, subtract[1].n, subtract[1].c) == (True, True, False)
    assert floats.norm(0x00001001)[0] == formats.pack(-19, 0x00080000)
    shift = integers.ash(0x000AE000, 16, 0)
    assert shift[0] == 0xE0000000 and (shift[1].n, shift[1].v, shift[1].c) == (True, True, False)
    assert [floats.fix(floats.finish(formats.Fraction(x))[0])[0] for x in ("-1", "-0.5", "0.99", "-1.5")] == [
        WORD,
        WORD,
        0,
        WORD - 1,
    ]
    assert formats.binary_exponent(formats.value(floats.addf(0x7F7FFFFFFF, 0x7F80000000)[0])) == 95
    ar, seen = 0x60, []
    for _ in range(9):
        seen.append(ar)
        ar = addressing.bit_reversed(ar, 8)
    assert seen == [0x60, 0x68, 0x64, 0x6C, 0x62, 0x6A, 0x66, 0x6E, 0x61]
    assert NAMES[31] == "R11"
