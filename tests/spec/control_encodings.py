"""Encodings of program control (c40-isa.md 6.6), with the instructions behind them that they need."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from random import Random

from .fields import CONDITION_CODES, FORMS, INTEGER_CODES, NOP, Encoding, Program, general
from .flags import RM
from .state import RC, RE, RS, ST


def harmless(rng: Random) -> int:
    """An instruction for a delay slot or a repeated block: registers R0 to R7 only."""
    a, b, c = (rng.randrange(8) for _ in range(3))
    return rng.choice((
        NOP,
        0x08600000 | a << 16 | rng.getrandbits(16),  # LDI
        0x02000000 | a << 16 | b,  # ADDI
        0x20800000 | a << 16 | b << 8 | c,  # ADDF3
        0x26000000 | a << 16 | b << 8 | c,  # SUBB3
        0x09600000 | a << 16 | rng.getrandbits(16),  # LDM
    ))  # fmt: skip


def slots(rng: Random) -> tuple[int, ...]:
    return tuple(harmless(rng) for _ in range(3))


def branch(base: int, relative: bool, delayed: bool, conditional: bool = True) -> Callable[[Random], Program]:
    def build(rng: Random) -> Program:
        word = base | (rng.choice(CONDITION_CODES) << 16 if conditional else 0)
        word |= rng.getrandbits(16) if relative else rng.choice(INTEGER_CODES[:31])
        return Program((word, *slots(rng)), 4) if delayed else Program((word,))

    return build


def branch_24(base: int, delayed: bool) -> Callable[[Random], Program]:
    def build(rng: Random) -> Program:
        word = base | rng.getrandbits(24)
        return Program((word, *slots(rng)), 4) if delayed else Program((word,))

    return build


def counted(base: int, relative: bool, delayed: bool) -> Callable[[Random], Program]:
    plain = branch(base, relative, delayed)

    def build(rng: Random) -> Program:
        n = rng.randrange(8)
        program = plain(rng)
        count = rng.choice((0, 1, 2, 0xFFFFFFFF, 0x80000000, 0x7FFFFFFF, rng.getrandbits(32)))
        return Program((program.words[0] | n << 22, *program.words[1:]), program.steps, ((8 + n, count),))

    return build


def trap(base: int, late: bool) -> Callable[[Random], Program]:
    def build(rng: Random) -> Program:
        word = base | rng.choice(CONDITION_CODES) << 16 | rng.getrandbits(9)
        return Program((word, *slots(rng)), 4) if late else Program((word,))

    return build


def returning(base: int, delayed: bool) -> Callable[[Random], Program]:
    def build(rng: Random) -> Program:
        word = base | rng.choice(CONDITION_CODES) << 16
        return Program((word, *slots(rng)), 4) if delayed else Program((word,))

    return build


def repeated_block(in_register: bool, delayed: bool) -> Callable[[Random], Program]:
    def build(rng: Random) -> Program:
        before = slots(rng) if delayed else ()
        block = tuple(harmless(rng) for _ in range(rng.randint(1, 3)))
        count = rng.choice((0, 1, 2, 3, 0xFFFFFFFF))
        last = 0x1000 + len(before) + len(block)
        register = rng.choice([*range(8, 21), 28, 29, 30, 31])
        if in_register:
            word = (0x79800000 if delayed else 0x79000000) | register
        else:
            word = (0x65000000 if delayed else 0x64000000) | last - 0x1000 - (3 if delayed else 1)
        passes = count + 1 if count < 4 else 1
        steps = 1 + len(before) + passes * len(block) + rng.randint(0, 1)
        registers = ((RC, count), *(((register, last),) if in_register else ()))
        return Program((word, *before, *block, NOP), steps, registers)

    return build


def last_of_a_block(rng: Random) -> Program:
    """Any harmless instruction where RE is, with RM set."""
    count = rng.choice((0, 1, 2, 0xFFFFFFFF, 0x80000000, 0x7FFFFFFF, rng.getrandbits(32)))
    return Program((harmless(rng),), 1, ((RC, count), (RS, rng.getrandbits(32)), (RE, 0x1000), (ST, RM)))


def repeat_single(mode: int) -> Callable[[Random], Program]:
    operand = general(39, mode, "n", "n")

    def build(rng: Random) -> Program:
        word = operand(rng) & ~(31 << 16) | RC << 16
        if mode == 3 and rng.random() < 0.5:
            count = rng.randrange(5)
            return Program((word & ~0xFFFF | count, harmless(rng), NOP), count + 2 + rng.randint(0, 1))
        return Program((word, NOP))

    return build


def control_encodings() -> Iterator[Encoding]:
    for name, base, delayed in (
        ("br", 0x60000000, False),
        ("brd", 0x61000000, True),
        ("call", 0x62000000, False),
        ("laj", 0x63000000, True),
    ):
        yield Encoding(name, "displacement", branch_24(base, delayed))
    kinds = (("b", 0x68000000, False), ("bd", 0x68200000, True), ("bat", 0x68600000, True), ("baf", 0x68A00000, True),
             ("callcond", 0x70000000, False), ("lajcond", 0x70200000, True))  # fmt: skip
    for name, base, delayed in kinds:
        yield Encoding(name, "register", branch(base, False, delayed))
        yield Encoding(name, "displacement", branch(base | 0x02000000, True, delayed))
    for name, base, delayed in (("db", 0x6C000000, False), ("dbd", 0x6C200000, True)):
        yield Encoding(name, "register", counted(base, False, delayed))
        yield Encoding(name, "displacement", counted(base | 0x02000000, True, delayed))
    yield Encoding("trap", "", trap(0x74000000, False))
    yield Encoding("lat", "", trap(0x74800000, True))
    yield Encoding("reti", "", returning(0x78000000, False))
    yield Encoding("retid", "", returning(0x78200000, True))
    yield Encoding("rets", "", returning(0x78800000, False))
    for delayed in (False, True):
        name = "rptbd" if delayed else "rptb"
        yield Encoding(name, "displacement", repeated_block(False, delayed))
        yield Encoding(name, "register", repeated_block(True, delayed))
    yield Encoding("repeat", "last_instruction", last_of_a_block)
    for mode, letter in enumerate("rdim"):
        yield Encoding("rpts", FORMS[letter], repeat_single(mode))
