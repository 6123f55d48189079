"""Single-step vectors in the emulator's line format: expected states come from this specification alone.

python -m spec.vectors --per-form 100 --seed 1 -o FILE.xz      (PYTHONPATH=tests)
"""

from __future__ import annotations

import argparse
import gzip
import lzma
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import IO

from . import operands
from .encodings import encodings
from .fields import Encoding, Program
from .flags import GIE, IMPLEMENTED, RM
from .machine import Machine
from .state import BK, DIE, DP, IIE, IIF, IR0, IR1, NAMES, RC, RE, RS, SP, ST, ReservedError, StopError, is_extended

START = 0x1000
CODE = range(START - 16, START + 64)
WORD = 0xFFFFFFFF
USE_TABLES = ("trap", "lat", "ldep", "ldpe")
AREAS = (0x2000, 0x2FF900, 0x300000, 0x40000000, 0x7FFFFFF0, 0x80000000, 0xC0010000, 0xFFFFFFF8)


class Registers(list):
    """Notes which registers are used."""

    def __init__(self, values: list[int]) -> None:
        super().__init__(values)
        self.seen: set[int] = set()

    def __getitem__(self, code):  # type: ignore[no-untyped-def]
        self.seen.add(code)
        return super().__getitem__(code)

    def __setitem__(self, code, value):  # type: ignore[no-untyped-def]
        self.seen.add(code)
        super().__setitem__(code, value)


class Memory(dict):
    """Words that the program has not put there are drawn when they are first read."""

    def __init__(self, rng: Random, words: dict[int, int]) -> None:
        super().__init__(words)
        self.rng = rng
        self.initial = dict(words)

    def get(self, address, default=0):  # type: ignore[no-untyped-def]
        if address not in self:
            self[address] = self.initial[address] = 0 if address in CODE else word_of_memory(self.rng)
        return self[address]


def word_of_memory(rng: Random) -> int:
    if rng.random() < 0.04:
        return 0x80000000 | rng.getrandbits(24)  # as a float a zero, not always the canonical one
    return operands.extended(rng) >> 8 if rng.random() < 0.5 else operands.word(rng)


def address(rng: Random) -> int:
    if rng.random() < 0.1:
        return rng.getrandbits(32)
    return rng.choice(AREAS) + rng.randrange(0x100) & WORD


def step_size(rng: Random) -> int:
    return rng.getrandbits(32) if rng.random() < 0.1 else rng.randrange(40)


def random_registers(rng: Random) -> list[int]:
    r = [0] * 32
    for code in range(32):
        if is_extended(code):
            r[code] = operands.extended(rng) if rng.random() < 0.6 else rng.getrandbits(8) << 32 | operands.word(rng)
        else:
            r[code] = operands.word(rng)
    for n in range(8):
        r[8 + n] = address(rng)
    a, b = rng.sample(range(8), 2)
    if rng.random() < 0.5:
        r[a] = operands.near(rng, r[b])
    r[IR0], r[IR1] = step_size(rng), step_size(rng)
    r[BK] = rng.getrandbits(32) | 1 if rng.random() < 0.1 else rng.randint(1, 64)
    r[DP] = rng.choice(AREAS) >> 16 | (rng.getrandbits(16) << 16 if rng.random() < 0.2 else 0)
    r[SP] = address(rng)
    r[ST] = rng.getrandbits(16) & IMPLEMENTED & ~RM
    if r[RE] in CODE:
        r[RE] = 0
    # Nothing is to be interrupted: a communication port may ask at any time.
    r[IIF] = 0
    if r[ST] & GIE:
        r[IIE] = 0
    return r


def shown(code: int, value: int) -> str:
    return f"{NAMES[code]}={value:010X}" if is_extended(code) else f"{NAMES[code]}={value:08X}"


class RejectedError(Exception):
    """The drawn state leads to something that another core need not do the same: a change of the program's own
    words."""


def run(machine: Machine, steps: int) -> None:
    for _ in range(steps):
        try:
            machine.step()
        except StopError:
            machine.pc = START
            return


def vector(rng: Random, name: str, program: Program) -> str:
    code = {START + n: word for n, word in enumerate(program.words)}
    before = random_registers(rng)
    for register, value in program.registers:
        before[register] = before[ST] | value if register == ST else value
    ivtp, tvtp = (address(rng) & ~0x1FF & WORD if name.startswith(USE_TABLES) else 0 for _ in range(2))
    registers, memory = Registers(before), Memory(rng, code)
    machine = Machine(r=registers, ivtp=ivtp, tvtp=tvtp, memory=memory)
    run(machine, program.steps)
    if any(place in CODE for _, place, _ in machine.bus):
        raise RejectedError
    bystanders = set(rng.sample([c for c in range(32) if c not in (ST, IIF, RC, RS, RE, DIE, IIE)], 2))
    kept = [c for c in range(32) if c in registers.seen or c in bystanders]
    left = [f"id={name}"]
    left += [shown(c, before[c]) for c in kept if before[c] or is_extended(c)]
    left += [f"{label}={value:08X}" for label, value in (("IVTP", ivtp), ("TVTP", tvtp)) if value]
    initial = {a: w for a, w in memory.initial.items() if a != START and w}
    left += [f"@{a:06X}={w:08X}" for a, w in sorted(initial.items())]
    left += [f"op={program.words[0]:08X}"]
    left += [f"steps={program.steps}"] if program.steps > 1 else []
    right = [f"PC={machine.pc:08X}"]
    right += [shown(c, after) for c in kept if (after := list.__getitem__(registers, c)) != before[c]]
    right += [
        f"{label}={new:08X}"
        for label, new, old in (("IVTP", machine.ivtp, ivtp), ("TVTP", machine.tvtp, tvtp))
        if new != old
    ]
    changed = {a: w for a, w in memory.items() if a not in CODE and memory.initial.get(a, 0) != w}
    right += [f"@{a:06X}={w:08X}" for a, w in sorted(changed.items())]
    right += [f"rd@{a:06X}" if kind == "rd" else f"wr@{a:06X}={w:08X}" for kind, a, w in machine.bus]
    return " ".join([*left, "->", *right])


def vectors_of(encoding: Encoding, count: int, seed: int) -> Iterator[str]:
    name = ".".join(part for part in (encoding.name, encoding.form) if part)
    rng = Random(f"{seed} {name}")
    made = 0
    while made < count:
        try:
            yield vector(rng, f"{name}.{made}", encoding.build(rng))
        except (RejectedError, ReservedError):
            continue
        made += 1


def counts(per_form: int, per_name: int) -> Iterator[tuple[Encoding, int]]:
    """per_form of each form, more where an instruction has few forms."""
    every = encodings()
    forms = {e.name: sum(other.name == e.name for other in every) for e in every}
    for encoding in every:
        yield encoding, max(per_form, -(-per_name // forms[encoding.name]))


def open_for_writing(path: Path) -> IO[str]:
    if path.suffix == ".xz":
        return lzma.open(path, "wt", preset=9 | lzma.PRESET_EXTREME)
    return gzip.open(path, "wt") if path.suffix == ".gz" else path.open("w")


def main() -> None:
    parser = argparse.ArgumentParser(
        description="Writes single-step vectors whose expected states come from the specification."
    )
    parser.add_argument("-o", "--output", type=Path, required=True, help="FILE, FILE.gz or FILE.xz")
    parser.add_argument("--per-form", type=int, default=100, help="of each operand form of an instruction")
    parser.add_argument("--per-instruction", type=int, default=100, help="at least so many of each instruction")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    total = 0
    with open_for_writing(arguments.output) as out:
        for encoding, count in counts(arguments.per_form, arguments.per_instruction):
            for line in vectors_of(encoding, count, arguments.seed):
                out.write(line + "\n")
                total += 1
    print(f"{total} vectors in {arguments.output}")


if __name__ == "__main__":
    main()
