"""Drawings of sequences in the pipeline, which test_counted_by_hand.py holds against the emulator.

Columns are cycles. The first row is fetched in cycle -3, so an instruction without any wait executes in the cycle of
its number. F fetch, D decode, R read (the first cycle of the access), E execute, `-` holds. A drawing may leave off the
rest of a program; its count is that of the whole. Code is in RAM block 1 unless the case says otherwise; B0 and B1 are
data in blocks 0 and 1, WAIT is external memory of one wait state.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import small_programs

B0, B1 = 0x2FF900, 0x2FFE00
LOCAL, WAIT, GLOBAL = 0x310000, 0x40000000, 0x80000000


@dataclass
class Case:
    why: str
    drawing: str
    cycles: int
    registers: dict[str, int] = field(default_factory=dict)
    words: dict[int, int] = field(default_factory=dict)
    code: int = small_programs.CODE


def parse(case: Case) -> tuple[str, list[tuple[str, str]]]:
    """The program, and (cells, instruction) of the rows that are drawn, in the order of execution (that of the
    fetches)."""
    if "\n" not in case.drawing:
        return case.drawing, []
    lines = [line[8:] for line in case.drawing.splitlines()[1:-1]]
    rows = [(line[:16].rstrip(), line[16:].strip()) for line in lines]
    drawn = [row for row in rows if row[0]]
    return " / ".join(text for _, text in rows), sorted(drawn, key=lambda row: row[0].index("F"))


def load(case: Case, exact: bool) -> tuple[Any, int]:
    lines = []
    for part in parse(case)[0].split(" / "):
        label, colon, rest = part.partition(":")
        lines.append(f"{label}: {rest.strip()}" if colon else f"        {part}")
    # `stop` begins where the sequence is over.
    text = "\n".join([*lines, "stop:   nop", "        nop", ""]).replace(" || ", "\n||      ")
    processor, image = small_programs.load(text, at=case.code)
    processor.set_exact(exact)
    for name, value in case.registers.items():
        processor.set(name, value)
    for address, word in case.words.items():
        processor.poke(address, word)
    return processor, image.symbols["stop"]
