"""Random fields of instruction words, and the encoding's data type."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from random import Random

from .operands import EDGE_WORDS
from .state import IIF

R_CODES = [0, 1, 2, 3, 4, 5, 6, 7, 28, 29, 30, 31]
# IIF is left out: what it reads back depends on pins.
INTEGER_CODES = [code for code in range(32) if code != IIF]
LDA_CODES = list(range(8, 21))
CONDITION_CODES = [code for code in range(21) if code != 11]
NOP = 0x0C800000


@dataclass(frozen=True)
class Program:
    """The instruction at 1000h, what stands behind it, the registers it needs, and how many instructions are
    executed."""

    words: tuple[int, ...]
    steps: int = 1
    registers: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True)
class Encoding:
    name: str
    form: str
    build: Callable[[Random], Program]


def one(build: Callable[[Random], int]) -> Callable[[Random], Program]:
    return lambda rng: Program((build(rng),))


# ---- operands ----


def indirect_16(rng: Random) -> int:
    modn, n = rng.randrange(26), rng.randrange(8)
    displacement = rng.choice((0, 1, 1, 2, rng.randrange(256), 255)) if modn < 8 else 0
    return modn << 11 | n << 8 | displacement


def indirect_8(rng: Random) -> int:
    return rng.randrange(26) << 3 | rng.randrange(8)


def offset_8(rng: Random) -> int:
    return rng.getrandbits(8)


def register_of(kind: str) -> list[int]:
    return {"f": R_CODES, "n": INTEGER_CODES, "a": LDA_CODES}[kind]


# Of shifts: around nothing, the word's width, and the ends of the seven bits.
COUNTS = [0, 1, 2, 30, 31, 32, 33, 34, 62, 63, 64, 65, -1, -2, -30, -31, -32, -33, -34, -63, -64, -65]


def shift_count(rng: Random, width: int) -> int:
    return rng.choice((rng.getrandbits(width), rng.choice(COUNTS) & (1 << width) - 1))


def immediate_16(rng: Random) -> int:
    return rng.choice((rng.getrandbits(16), rng.choice(EDGE_WORDS) & 0xFFFF, 0x8000, 0x7FFF))


def perhaps_the_pointer(rng: Random, register: int, n: int, codes: list[int]) -> int:
    """Now and then the ARn of an indirect operand instead, whose update comes before the register is read or
    written."""
    return 8 + n if 8 + n in codes and rng.random() < 0.15 else register


SHIFTS = (7, 19)  # op6 of ASH and LSH


def general(op: int, mode: int, source: str, destination: str) -> Callable[[Random], int]:
    def build(rng: Random) -> int:
        dst = rng.choice(register_of(destination))
        src = (
            lambda: rng.choice(register_of(source)),
            lambda: rng.getrandbits(16),
            lambda: indirect_16(rng),
            lambda: shift_count(rng, 16) if op in SHIFTS else immediate_16(rng),
        )[mode]()
        while destination == "a" and mode == 0 and src == dst:
            src = rng.choice(register_of(source))
        if mode == 2:
            dst = perhaps_the_pointer(rng, dst, src >> 8 & 7, register_of(destination))
        return op << 23 | mode << 21 | dst << 16 | src

    return build


def part_word(sub: int, mode: int) -> Callable[[Random], int]:
    build = general(0, mode, "n", "n")
    return lambda rng: 0xB0000000 | sub << 23 | build(rng)


FORMS = {"r": "register", "d": "direct", "i": "indirect", "m": "immediate"}
