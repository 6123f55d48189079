"""Sequences that c40-hardware.md 7.6 does not count, computed by hand from c40-hardware.md 7.1 to 7.5 and drawn.

Columns are cycles; the first row's fetch is cycle -3, so that an instruction that nothing holds up executes in the cycle of its number. F fetch, D decode,
R read (the first cycle of the access), E execute, `-` holds. A drawing may leave off the rest of a program; its count is that of the whole.
Code is in RAM block 1 unless the case says otherwise; B0 and B1 are data in blocks 0 and 1, WAIT is external memory of one wait state.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import pytest
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


CASES = [
    # ---- 7.3: registers that address generation waits for
    Case(
        "an index register is ready after E of cycle 0, like ARn",
        """
        FDRE            ldi 5,ir0
         F--DRE         ldf *+ar0(ir0),r0
        """,
        4,
        {"AR0": B0},
    ),
    Case(
        "so is BK",
        """
        FDRE            ldi 8,bk
         F--DRE         ldf *ar0++(1)%,r0
        """,
        4,
        {"AR0": B0},
    ),
    Case(
        "so is SP, for PUSH",
        """
        FDRE            ldi r0,sp
         F--DRE         push r1
        """,
        4,
        {"R0": B0},
    ),
    Case(
        "a word popped into ARn is an ordinary write",
        """
        FDRE            pop ar0
         F--DRE         ldi *ar0,r0
        """,
        4,
        {"SP": B0},
        {B0: B0 + 8},
    ),
    Case(
        "so is a word loaded into it",
        """
        FDRE            ldi *ar0++,ar1
         F--DRE         ldf *ar1,r0
        """,
        4,
        {"AR0": B0},
        {B0: B0 + 8},
    ),
    Case(
        "of two registers the later one counts",
        """
        FDRE            addi 1,ar0
         FDRE           addi 1,ar1
          F--DRE        ldf *ar0,r0 || ldf *ar1,r1
        """,
        5,
        {"AR0": B0, "AR1": B0 + 8},
    ),
    Case(
        "three writes, the newest is one of the two that are used",
        """
        FDRE            addi 1,ar0
         FDRE           addi 1,ar1
          FDRE          addi 1,ar2
           F--DRE       ldf *ar0,r0 || ldf *ar2,r1
        """,
        6,
        {"AR0": B0, "AR1": B0 + 8, "AR2": B0 + 16},
    ),
    Case(
        "one instruction between leaves one stall, and the instruction after finds none",
        """
        FDRE            subi 1,ar0
         FDRE           ldi 3,r0
          F-DRE         ldi *ar0,r1
            FDRE        ldi *ar0,r2
        """,
        5,
        {"AR0": B0},
    ),
    Case(
        "DP written in E, one instruction between",
        """
        FDRE            ldi 2fh,dp
         FDRE           nop
          F-DRE         ldi @0f900h,r0
        """,
        4,
    ),
    Case(
        "LDA is ready one cycle earlier, for an index register too",
        """
        FDRE            lda *ar3,ir1
         F-DRE          ldf *ar0++(ir1),r0
        """,
        3,
        {"AR3": B0, "AR0": B0 + 8},
        {B0: 2},
    ),
    Case(
        "LDA, then an ordinary load, each used at once: 1 and 2 stalls",
        """
        FDRE            lda *ar3,ar0
         F-DRE          ldi *ar0,ar1
           F--DRE       ldf *ar1,r0
        """,
        6,
        {"AR3": B0},
        {B0: B0 + 1, B0 + 1: B0 + 2},
    ),
    Case(
        "LDA from a wait state: the word is there when the longer R is over",
        """
        FDRRE           lda *ar3,ar0
         F--DRE         ldf *ar0,r0
        """,
        4,
        {"AR3": WAIT},
        {WAIT: B0},
    ),
    Case(
        "a register operand that is read, then addressed with",
        """
        FDRE            ldi ar1,ar0
         F-DRE          ldf *ar1,r0
        """,
        3,
        {"AR1": B0},
    ),
    Case(
        "the write of AR0 hides that AR1 was read",
        """
        FDRE            ldi ar1,ar0
         F--DRE         ldf *ar0,r0 || ldf *ar1,r1
        """,
        4,
        {"AR1": B0},
    ),
    Case(
        "read, one instruction between: no stall",
        """
        FDRE            addi ar0,r1
         FDRE           nop
          FDRE          ldf *ar0,r0
        """,
        3,
        {"AR0": B0},
    ),
    Case(
        "the register that a store writes out is an operand that is read",
        """
        FDRE            sti ar0,*ar1
         F-DRE          ldi *ar0,r0
        """,
        3,
        {"AR0": B0, "AR1": B0 + 8},
    ),
    Case(
        "so is the one that PUSH writes out",
        """
        FDRE            push ar0
         F-DRE          ldi *ar0,r0
        """,
        3,
        {"AR0": B0, "SP": B0 + 8},
    ),
    Case(
        "an update by addressing is over in D",
        """
        FDRE            nop *ar0++
         FDRE           ldi *ar0,r0
        """,
        2,
        {"AR0": B0},
    ),
    Case(
        "an index register used, written, used",
        """
        FDRE            ldi *ar0++(ir0),r0
         FDRE           ldi 3,ir0
          F--DRE        ldi *ar0++(ir0),r1
        """,
        5,
        {"AR0": B0, "IR0": 1},
    ),
    Case(
        "PUSH and POP move SP in D, and their write and read are two accesses of one block",
        """
        FDRE            push r0
         FDRE           pop r1
        """,
        2,
        {"SP": B0},
    ),
    Case(
        "DBcondD waits for its own ARn",
        """
        FDRE            ldi 3,ar0
         F--DRE         dbd ar0,go
            FDRE        nop
             FDRE       nop
              FDRE      nop
                        go:
        """,
        7,
    ),
    Case(
        "and what it counts down is an ordinary write",
        """
        FDRE            dbd ar0,go
         F--DRE         ldi *ar0,r1
            FDRE        nop
             FDRE       nop
                        go:
        """,
        6,
        {"AR0": B0 + 1},
    ),
    # ---- 7.2: a refill hides what waits behind it
    Case(
        "a standard branch hides a register conflict",
        """
        FDRE            addi 1,ar0
         FDRE           br go
                        nop
             FDRE       go: ldf *ar0,r0
        """,
        6,
        {"AR0": B0},
    ),
    Case(
        "so do the slots of a delayed one",
        """
        FDRE            addi 1,ar0
         FDRE           brd go
          FDRE          nop
           FDRE         nop
            FDRE        nop
             FDRE       go: ldf *ar0,r0
        """,
        6,
        {"AR0": B0},
    ),
    Case(
        "a stall in a slot lengthens the slots, not the branch",
        """
        FDRE            brd go
         FDRE           stf r0,*ar0 || stf r1,*ar1
          FD-RE         ldf *ar2,r2
           FD-RE        nop
                        go:
        """,
        5,
        {"AR0": B0, "AR1": B0 + 1, "AR2": B0 + 2},
    ),
    # ---- 7.4: ports of the RAM blocks
    Case(
        "an unrelated instruction between store and loads",
        """
        FDRE            stf r0,*ar0
         FDRE           nop
          FDRE          ldf *ar1,r1 || ldf *ar2,r2
        """,
        3,
        {"AR0": B0, "AR1": B0 + 1, "AR2": B0 + 2},
    ),
    Case(
        "a store and one of the two loads in its block are two accesses",
        """
        FDRE            stf r0,*ar0
         FDRE           ldf *ar1,r1 || ldf *ar2,r2
        """,
        2,
        {"AR0": B0, "AR1": B0 + 1, "AR2": B1},
    ),
    Case(
        "each block takes a store and a load",
        """
        FDRE            stf r0,*ar0 || stf r1,*ar1
         FDRE           ldf *ar2,r2 || ldf *ar3,r3
        """,
        2,
        {"AR0": B0, "AR1": B1, "AR2": B0 + 1, "AR3": B1 + 1},
        code=LOCAL,
    ),
    Case(
        "two stores, an unrelated instruction, a load",
        """
        FDRE            stf r0,*ar0 || stf r1,*ar1
         FDRE           nop
          FDRE          ldf *ar2,r2
        """,
        3,
        {"AR0": B0, "AR1": B0 + 1, "AR2": B0 + 2},
    ),
    Case(
        "the store of a multiplication, then two loads: the store wins",
        """
        FDRE            mpyf3 *ar0,r1,r0 || stf r2,*ar1
         FD-RE          ldf *ar2,r2 || ldf *ar3,r3
        """,
        3,
        {"AR0": B0, "AR1": B0 + 1, "AR2": B0 + 2, "AR3": B0 + 3},
    ),
    Case(
        "the store beside a load, then the two operands of an addition",
        """
        FDRE            ldf *ar0,r0 || stf r1,*ar1
         FD-RE          addf3 *ar2,*ar3,r2
        """,
        3,
        {"AR0": B0, "AR1": B0 + 1, "AR2": B0 + 2, "AR3": B0 + 3},
    ),
    Case(
        "a register conflict has let the stores pass",
        """
        FDRE            addi 1,ar0
         FDRE           stf r0,*ar1 || stf r1,*ar2
          F-DRE         ldf *ar0,r2
        """,
        4,
        {"AR0": B0, "AR1": B0 + 8, "AR2": B0 + 9},
    ),
    Case(
        "one datum and one fetch are what the code's block serves in a cycle",
        """
        FDRE            ldi *ar0,r0
         FDRE           nop
          FDRE          nop
           FDRE         nop
            FDRE        nop
        """,
        5,
        {"AR0": B1},
    ),
    Case(
        "two stores into the code's block in cycle 0: the fetch of that cycle comes in cycle 1",
        """
        FDRE            stf r0,*ar0 || stf r1,*ar1
         FDRE           nop
          FDRE          nop
            FDRE        nop
             FDRE       nop
        """,
        6,
        {"AR0": B1, "AR1": B1 + 1},
    ),
    Case(
        "reads in cycles -1 and 0 keep the third fetch away until cycle 1",
        """
        FDRE            addf3 *ar0,*ar1,r0
         FDRE           addf3 *ar0,*ar1,r1
            FDRE        nop
             FDRE       nop
              FDRE      nop
               FDRE     nop
        """,
        8,
        {"AR0": B1, "AR1": B1 + 1},
    ),
    Case(
        "loads held up by a store: while they hold the pipeline, nothing is fetched that they could hold up",
        """
        FDRE            stf r0,*ar0
         FD-RE          ldf *ar1,r1 || ldf *ar2,r2
          FD-RE         nop
           F-DRE        nop
             FDRE       nop
              FDRE      nop
        """,
        7,
        {"AR0": B1, "AR1": B1 + 1, "AR2": B1 + 2},
    ),
    # ---- 7.4: external buses
    Case(
        "read, write (cycles 1 and 2), read straight after it: 2 cycles",
        """
        FDRE            ldi *ar0,r0
         FDRE           sti r1,*ar1
          FD---RE       ldi *ar2,r2
        """,
        6,
        {"AR0": LOCAL, "AR1": LOCAL + 1, "AR2": LOCAL + 2},
    ),
    Case(
        "the write of cycles 0 and 1 and a read one instruction later",
        """
        FDRE            sti r0,*ar0
         FDRE           nop
          FD--RE        ldi *ar1,r1
        """,
        5,
        {"AR0": LOCAL, "AR1": LOCAL + 1},
    ),
    Case(
        "two instructions later it is still straight after the write",
        """
        FDRE            sti r0,*ar0
         FDRE           nop
          FDRE          nop
           FD-RE        ldi *ar1,r1
        """,
        5,
        {"AR0": LOCAL, "AR1": LOCAL + 1},
    ),
    Case(
        "three later it is not",
        """
        FDRE            sti r0,*ar0
         FDRE           nop
          FDRE          nop
           FDRE         nop
            FDRE        ldi *ar1,r1
        """,
        5,
        {"AR0": LOCAL, "AR1": LOCAL + 1},
    ),
    Case(
        "two stores at once, one to each bus",
        """
        FDRE            sti r0,*ar0 || sti r1,*ar1
         FDRE           nop
        """,
        2,
        {"AR0": LOCAL, "AR1": GLOBAL},
    ),
    Case(
        "stores that alternate between the buses find them free",
        """
        FDRE            sti r0,*ar0
         FDRE           sti r1,*ar1
          FDRE          sti r2,*ar2
        """,
        3,
        {"AR0": LOCAL, "AR1": GLOBAL, "AR2": LOCAL + 1},
    ),
    Case(
        "a wait state holds everything for a cycle",
        """
        FDRRE           ldi *ar0,r0
         FD-RE          nop
        """,
        3,
        {"AR0": WAIT},
    ),
    Case(
        "a slow read beside one on chip",
        """
        FDRRE           ldf *ar0,r0 || ldf *ar1,r1
        """,
        2,
        {"AR0": WAIT, "AR1": B0},
    ),
    Case(
        "two slow reads on one bus",
        """
        FDRRRRE         ldf *ar0,r0 || ldf *ar1,r1
        """,
        4,
        {"AR0": WAIT, "AR1": WAIT + 1},
    ),
    Case(
        "two slow reads, one of them on the other bus without a wait",
        """
        FDRRE           ldf *ar0,r0 || ldf *ar1,r1
        """,
        2,
        {"AR0": WAIT, "AR1": GLOBAL},
    ),
    Case(
        "a slow write is cycles 0 to 2, the next one 3 to 5: it waits in E",
        """
        FDRE            sti r0,*ar0
         FDR--E         sti r1,*ar1
        """,
        4,
        {"AR0": WAIT, "AR1": WAIT + 1},
    ),
    Case(
        "and a slow read straight after it is cycles 3 to 5, its own two the last",
        """
        FDRE            sti r0,*ar0
         FD----RRE      ldi *ar1,r1
        """,
        7,
        {"AR0": WAIT, "AR1": WAIT + 1},
    ),
    Case(
        "a refill hides the slow write, and a cycle lies between it and the read",
        """
        FDRE            sti r0,*ar0
         FDRE           br go
                        nop
             FDRRE      go: ldi *ar1,r1
        """,
        7,
        {"AR0": WAIT, "AR1": WAIT + 1},
    ),
    Case(
        "the return address through slow memory: its write is cycles 0 to 2, its read straight after it, 3 to 5",
        """
        FDRE            call f
                  FDRE  br go
            FD-RRE      f: rets
                        go:
        """,
        14,
        {"SP": WAIT},
    ),
    # ---- code and data on one external bus
    Case(
        "the read of cycle -1 keeps that cycle's fetch away",
        """
        FDRE            ldi *ar0,r0
         FDRE           nop
           FDRE         nop
            FDRE        nop
             FDRE       nop
        """,
        6,
        {"AR0": LOCAL + 0x100},
        code=LOCAL,
    ),
    Case(
        "the write of cycles 0 and 1 does, and the fetch straight after it takes 2 cycles",
        """
        FDRE            sti r0,*ar0
         FDRE           nop
          FDRE          nop
              FDRE      nop
               FDRE     nop
                FDRE    nop
        """,
        9,
        {"AR0": LOCAL + 0x100},
        code=LOCAL,
    ),
    # ---- repeats: 4 cycles, then what a pass costs
    Case("a pass of RPTS reads and writes one block: 1 + 4 + 10", "ldf *ar0++,r0 / rpts 9 / ldf *ar0++,r0 || stf r0,*ar1++", 15, {"AR0": B0, "AR1": B0 + 32}),
    Case("RPTS of a read without wait states: 4 + 4", "rpts 3 / ldi *ar0++,r0", 8, {"AR0": LOCAL}),
    Case("with one: 4 + 4 x 2", "rpts 3 / ldi *ar0++,r0", 12, {"AR0": WAIT}),
    Case("of a write: each waits for the one before, the last for nobody: 4 + 4 x 2 - 1", "rpts 3 / sti r0,*ar0++", 11, {"AR0": LOCAL}),
    Case(
        "a store and two loads of its block in a loop: 1 + 4 + 3 x 3",
        "ldi 2,rc / rptb l / stf r0,*ar0 / l: ldf *ar1,r1 || ldf *ar2,r2",
        14,
        {"AR0": B0, "AR1": B0 + 1, "AR2": B0 + 2},
    ),
    Case(
        "two stores at a loop's end, two loads at its begin: 1 + 4 + 3 x 3 and 2 between the passes",
        "ldi 2,rc / rptb l / ldf *ar1,r1 || ldf *ar2,r2 / nop / l: stf r0,*ar0 || stf r1,*ar3",
        16,
        {"AR0": B0, "AR1": B0 + 1, "AR2": B0 + 2, "AR3": B0 + 3},
    ),
]


def parse(case: Case) -> tuple[str, list[tuple[str, str]]]:
    """The program, and (cells, instruction) of the rows that are drawn, in the order of execution (that of the fetches)."""
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


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.why)
def test_count(case: Case, exact: bool) -> None:
    processor, stop = load(case, exact)
    result = processor.run(10000, until=stop)
    assert result["reason"] == "breakpoint", result
    assert processor.cycle == case.cycles
    assert small_programs.consistent(processor)


@pytest.mark.parametrize("case", [case for case in CASES if parse(case)[1]], ids=lambda case: case.why)
def test_stages_are_where_they_were_drawn(case: Case) -> None:
    processor, _ = load(case, True)
    records = processor.trace(case.cycles)
    for (cells, text), record in zip(parse(case)[1], records, strict=False):
        assert dict(zip("FDRE", record["stages"], strict=True)) == {letter: cells.index(letter) - 3 for letter in "FDRE"}, text


def test_what_is_drawn_ends_with_the_count() -> None:
    """Of drawings that show all: the last E is the last cycle, or a branch's, which takes 3 more."""
    for case in CASES:
        rows = parse(case)[1]
        if not rows:
            continue
        last, text = rows[-1]
        assert case.cycles == last.rindex("E") - 3 + (4 if text.startswith("br ") else 1), case.why
