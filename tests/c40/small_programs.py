"""Small programs for the tests: assembled text in, a processor out."""

from __future__ import annotations

import random
from typing import Any

from cmrc._core import c40, toolchain

CODE = 0x2FFC00  # on-chip block 1
DATA = 0x2FF800  # on-chip block 0
REGISTERS = [f"R{n}" for n in range(12)] + [f"AR{n}" for n in range(8)]
REGISTERS += ["DP", "IR0", "IR1", "BK", "SP", "ST", "DIE", "IIE", "IIF", "RS", "RE", "RC"]
RAM = (DATA, 0x800)
NESTED_BLOCKS = """
 ldi 2,rc
 rptb outer
 push st
 push rs
 push re
 push rc
 ldi 4,rc
 rptb inner
inner: addi 1,r0
 pop rc
 pop re
 pop rs
 pop st
 nop
outer: addi 1,r1"""
"""R0 counts 15 passes of the inner block, R1 3 of the outer one; it saves ST, RS, RE and RC."""


def load(text: str, board: str = "default", at: int = CODE, sections: dict[str, int] | None = None) -> tuple[Any, Any]:
    """`sections`: where other sections than .text are."""
    image = toolchain.assemble("        .text\n" + text, "test.asm", sections={".text": at, **(sections or {})})
    processor = c40.Processor(board)
    processor.load_image(image)
    processor.pc = at
    processor.set("SP", 0x2FFB00)
    return processor, image


def consistent(processor: Any) -> bool:
    return sum(processor.causes.values()) == processor.cycle


def state(processor: Any) -> dict[str, Any]:
    """All that a program can see: registers, time, instructions, causes, and the chip's RAM."""
    out: dict[str, Any] = {name: processor.get(name) for name in REGISTERS}
    out |= {"pc": processor.pc, "cycle": processor.cycle, "instructions": processor.instructions}
    out |= processor.causes
    out["ram"] = processor.read(*RAM)
    return out


def agree(fast: Any, exact: Any, seed: int) -> None:
    """Runs both, the second one by the exact engine, in pieces that `seed` draws: the same at the end of each."""
    exact.set_exact(True)
    rng = random.Random(seed)
    for _ in range(60):
        cycles = rng.choice([1, 5, 30, 100, 400, 1500])
        stops = fast.run(cycles), exact.run(cycles)
        assert stops[0] == stops[1]
        assert state(fast) == state(exact)
        assert consistent(fast)
    assert fast.instructions > 500
