"""Order inside parallel instructions, delay slots, repeats, traps. Expected values by hand from c40-isa.md 3.9, 3.10
and 8."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest
import small_programs
from on_chip_code import CODE, DATA, STACK, TRAPS, processor


@dataclass
class Case:
    """A program up to `stop`, with memory from DATA on (AR0 points there) and registers before it and after it."""

    name: str
    text: str
    after: dict[str, int]
    before: dict[str, int] = field(default_factory=dict)
    memory: list[int] = field(default_factory=list)
    memory_after: list[int] | None = None


def case_id(case: Case) -> str:
    return case.name


ST_Z, ST_N, ST_GIE, ST_PGIE = 4, 8, 0x2000, 0x4000

PARALLEL = [
    Case(
        "a load sees the word before the store beside it",
        "ldi *ar0,r1\n|| sti r2,*ar0",
        {"R1": 11, "R2": 22},
        {"R2": 22},
        [11],
        [22],
    ),
    Case(
        "a store takes the register before the operation beside it",
        "addi3 *ar0,r1,r2\n|| sti r2,*ar1",
        {"R2": 31},
        {"R1": 20, "R2": 5, "AR1": DATA + 1},
        [11, 0],
        [11, 5],
    ),
    Case(
        "multiply and add both see the registers from before",
        "mpyi3 *ar0,*ar1,r0\n|| addi3 r0,r2,r2",
        {"R0": 12, "R2": 107},
        {"R0": 7, "R2": 100, "AR1": DATA + 1},
        [3, 4],
    ),
    Case(
        "of two stores to one word that of the I half stays",
        "sti2 r1,*ar0\n|| sti1 r2,*ar1",
        {},
        {"R1": 1, "R2": 2, "AR1": DATA},
        [0],
        [1],
    ),
    Case(
        "of two loads to one register that of the I half stays",
        "ldi2 *ar0,r1\n|| ldi1 *ar1,r1",
        {"R1": 11},
        {"AR1": DATA + 1},
        [11, 22],
    ),
    Case(
        "of two steps of one address register that of the J half stays",
        "ldi2 *ar0++(ir0),r1\n|| ldi1 *ar0--(ir1),r2",
        {"AR0": DATA - 3, "R1": 11, "R2": 11},
        {"IR0": 2, "IR1": 3},
        [11],
    ),
    Case(
        "the same of operation and store",
        "ldi *ar0++(ir0),r1\n|| sti r2,*ar0++(1)",
        {"AR0": DATA + 1, "R1": 11},
        {"IR0": 2, "R2": 22},
        [11],
        [22],
    ),
    Case(
        "the same of three operands: src1",
        "addi3 *ar0++(ir0),*ar0--(1),r1",
        {"AR0": DATA - 1, "R1": 22},
        {"IR0": 4},
        [11],
    ),
    Case(
        "a store of the register that its own address steps stores the new value",
        "sti ar0,*ar0++(1)",
        {"AR0": DATA + 1},
        {},
        [0],
        [DATA + 1],
    ),
    Case(
        "a load into the register that its address steps ends with the word", "ldi *ar0++(1),ar0", {"AR0": 77}, {}, [77]
    ),
    Case(
        "both addresses come from the registers before",
        "ldi2 *++ar0(1),r1\n|| ldi1 *ar0,r2",
        {"R1": 22, "R2": 11},
        {},
        [11, 22],
    ),
    Case(
        "a parallel pair of multiply leaves N and Z 0",
        "mpyi3 *ar0,*ar1,r0\n|| subi3 r2,r2,r2",
        {"R0": 12, "R2": 0, "ST": 0},
        {"R2": 5, "AR1": DATA + 1, "ST": ST_Z | ST_N},
        [3, 4],
    ),
]

BRANCHES = [
    Case(
        "three slots run before a delayed branch is gone",
        "brd there\n addi 1,r0\n addi 2,r0\n addi 4,r0\n addi 8,r0\nthere: addi 16,r0",
        {"R0": 23},
    ),
    Case(
        "of a delayed branch that is not taken they run too",
        "cmpi 1,r1\n beqd there\n addi 1,r0\n addi 2,r0\n addi 4,r0\n addi 8,r0\nthere: addi 16,r0",
        {"R0": 31},
    ),
    Case(
        "slots do not change the condition",
        "cmpi 0,r1\n beqd there\n ldi 1,r1\n ldi 1,r1\n ldi 1,r1\n addi 8,r0\nthere: addi 16,r0",
        {"R0": 16, "R1": 1},
    ),
    Case(
        "slots do not change the target",
        "ldhi 2fh,r1\n or lo16(there),r1\n bud r1\n ldi 0,r1\n nop\n nop\n addi 8,r0\nthere: addi 16,r0",
        {"R0": 16, "R1": 0},
    ),
    Case(
        "BcondAT runs the slots when it is not taken",
        "cmpi 1,r1\n beqat there\n addi 1,r0\n addi 2,r0\n addi 4,r0\n addi 8,r0\nthere: addi 16,r0",
        {"R0": 31},
    ),
    Case(
        "BcondAT annuls them when it is taken",
        "cmpi 0,r1\n beqat there\n addi 1,r0\n addi 2,r0\n addi 4,r0\n addi 8,r0\nthere: addi 16,r0",
        {"R0": 16},
    ),
    Case(
        "BcondAF runs them when it is taken",
        "cmpi 0,r1\n beqaf there\n addi 1,r0\n addi 2,r0\n addi 4,r0\n addi 8,r0\nthere: addi 16,r0",
        {"R0": 23},
    ),
    Case(
        "BcondAF annuls them when it is not",
        "cmpi 1,r1\n beqaf there\n addi 1,r0\n addi 2,r0\n addi 4,r0\n addi 8,r0\nthere: addi 16,r0",
        {"R0": 24},
    ),
    Case(
        "an annulled store stores nothing",
        "cmpi 0,r1\n beqat there\n sti r2,*ar0\n sti r2,*ar0\n sti r2,*ar0\nthere: nop",
        {},
        {"R2": 9},
        [5],
        [5],
    ),
    Case(
        "annulled slots 1 and 2 have stepped their address registers, slot 3 has not (choice)",
        "cmpi 0,r1\n beqat there\n sti r2,*ar0++(1)\n sti r2,*ar1++(1)\n sti r2,*ar2++(1)\nthere: nop",
        {"AR0": DATA + 1, "AR1": DATA + 1, "AR2": DATA},
        {"AR1": DATA, "AR2": DATA},
        [5],
        [5],
    ),
    Case("DBcond ends the loop below 0", "ldi 4,ar5\nagain: addi 1,r0\n db ar5,again", {"R0": 5, "AR5": 0xFFFFFFFF}),
    Case(
        "DBcondD runs its slots every time",
        "ldi 2,ar5\nagain: dbd ar5,again\n addi 1,r0\n nop\n nop",
        {"R0": 3, "AR5": 0xFFFFFFFF},
    ),
    Case(
        "DBcond stops when its condition is false, and counts (choice)",
        "ldi 9,ar5\n cmpi 1,r1\nagain: addi 1,r0\n dbz ar5,again",
        {"R0": 1, "AR5": 8},
    ),
    Case(
        "LAJ leaves the address behind its slots in R11",
        "laj there\n nop\n nop\n nop\nback: addi 8,r0\n b stop\nthere: addi 16,r0\n bu r11",
        {"R0": 24, "R11": CODE + 4},
    ),
    Case("R11 is there for slot 1", "laj there\n ldi r11,r1\n nop\n nop\nthere: nop", {"R1": CODE + 4}),
    Case(
        "LAJcond that is not taken leaves R11 alone",
        "cmpi 1,r1\n lajz there\n nop\n nop\n nop\n addi 8,r0\nthere: nop",
        {"R0": 8, "R11": 99},
        {"R11": 99},
    ),
    Case(
        "CALLcond and RETScond",
        "cmpi 0,r1\n callz there\n addi 8,r0\n b stop\nthere: addi 1,r0\n cmpi 1,r1\n retsz\n addi 2,r0\n retsnz",
        {"R0": 11, "SP": STACK},
        {},
        [0],
    ),
    Case(
        "CALL pushes the address behind it",
        "call there\n b stop\nthere: pop r1\n push r1\n rets",
        {"R1": CODE + 1, "SP": STACK},
    ),
    Case(
        "a call through a register",
        "ldhi 2fh,r1\n or lo16(there),r1\n callu r1\n b stop\nthere: addi 1,r0\n rets",
        {"R0": 1},
    ),
]

# Of slots 1 and 2 that are annulled the address updates happen (8.2); of two of one ARn the J byte's counts (3.9).
BRANCHES += [
    Case(
        f"two updates of one ARn, annulled: {name}",
        f"buat x\n {text}\n nop\n nop\nx: nop",
        {"AR4": DATA + moved},
        {"AR4": DATA},
    )
    for name, text, moved in (
        ("two stores", "sti r5,*ar4--(1)\n|| sti r2,*ar4++(1)", 1),
        ("two loads", "ldi *ar4--(1),r1\n|| ldi *ar4++(1),r2", 1),
        ("operation and store", "absi *ar4--(1),r1\n|| sti r2,*ar4++(1)", 1),
        ("multiply and add", "mpyi3 *ar4--,*ar4++,r0\n|| addi3 r0,r1,r2", 1),
        ("three operands", "addi3 *ar4++,*ar4--,r1", -1),
    )
]

REPEATS = [
    Case(
        "RPTB with RC = 0 runs once",
        "ldi 0,rc\n rptb last\n addi 1,r0\nlast: addi 1,r1",
        {"R0": 1, "R1": 1, "RC": 0xFFFFFFFF},
    ),
    Case(
        "RPTB with RC = 1 runs twice",
        "ldi 1,rc\n rptb last\n addi 1,r0\nlast: addi 1,r1",
        {"R0": 2, "R1": 2, "RC": 0xFFFFFFFF},
    ),
    Case(
        "RPTB with RC = -1 runs once",
        "ldi -1,rc\n rptb last\n addi 1,r0\nlast: addi 1,r1",
        {"R0": 1, "R1": 1, "RC": 0xFFFFFFFE},
    ),
    Case("a block of one instruction", "ldi 4,rc\n rptb last\nlast: addi 1,r1", {"R1": 5, "RC": 0xFFFFFFFF}),
    Case(
        "RPTBD runs its slots once, before",
        "ldi 2,rc\n rptbd last\n addi 1,r2\n addi 1,r2\n addi 1,r2\n addi 1,r0\nlast: addi 1,r1",
        {"R2": 3, "R0": 3, "R1": 3, "RC": 0xFFFFFFFF},
    ),
    Case(
        "RPTB to the address in a register",
        "ldhi 2fh,r7\n or lo16(last),r7\n ldi 2,rc\n rptb r7\n addi 1,r0\nlast: addi 1,r1",
        {"R0": 3, "R1": 3},
    ),
    Case(
        "RS and RE after a block",
        "ldi 1,rc\n rptb last\n nop\nlast: nop",
        {"RS": CODE + 2, "RE": CODE + 3, "RC": 0xFFFFFFFF},
    ),
    Case(
        "what the last instruction writes to ST comes after the decision at its fetch: RC ends at -1",
        "ldi 3,rc\n rptb x\n addi 1,r0\nx: or 400h,st",
        {"R0": 4, "RC": 0xFFFFFFFF},
    ),
    Case("ST written under RPTS: RC ends at -1", "rpts 20\n xor 80h,st", {"RC": 0xFFFFFFFF}),
    Case(
        "RM cleared at RE: the pass that is fetched already is the last",
        "ldi 3,rc\n rptb x\n addi 1,r0\nx: andn 100h,st",
        {"R0": 2, "RC": 2},
    ),
    Case(
        "RM set at RE acts from the next instruction on",
        f"ldi 3,rc\n ldhi {CODE >> 16:#x},ar1\n or {CODE + 6 & 0xFFFF:#x},ar1\n ldi ar1,re\n ldi ar1,rs\n addi 1,r0\n"
        " or 100h,st\n nop",
        {"R0": 1, "RC": 3},
    ),
    Case("RPTS 0 runs once", "rpts 0\n addi 1,r0", {"R0": 1, "RC": 0xFFFFFFFF, "RS": CODE + 1, "RE": CODE + 1}),
    Case("RPTS n runs n + 1 times", "rpts 6\n addi 1,r0", {"R0": 7, "RC": 0xFFFFFFFF}),
    Case("RPTS takes its count from a register", "ldi 3,r1\n rpts r1\n addi 1,r0", {"R0": 4, "RC": 0xFFFFFFFF}),
    Case("RPTS of -1 runs once", "ldi -1,r1\n rpts r1\n addi 1,r0", {"R0": 1, "RC": 0xFFFFFFFE}),
    Case("RPTS with the count in RC already", "ldi 2,rc\n rpts rc\n addi 1,r0", {"R0": 3}),
    Case(
        "RPTS of a parallel pair counts it as one",
        "rpts 3\n ldi *ar0++(1),r1\n|| sti r2,*ar1++(1)",
        {"R1": 4, "AR0": DATA + 4, "AR1": DATA + 8},
        {"AR1": DATA + 4, "R2": 9},
        [1, 2, 3, 4, 0, 0, 0, 0],
        [1, 2, 3, 4, 9, 9, 9, 9],
    ),
    Case("a loop around a block", "ldi 2,ar5\nouter: ldi 3,rc\n rptb last\nlast: addi 1,r0\n db ar5,outer", {"R0": 12}),
    Case(
        "blocks nested with ST, RS, RE and RC saved",
        small_programs.NESTED_BLOCKS,
        {"R0": 15, "R1": 3, "SP": STACK},
    ),
    Case(
        "a branch out of a block leaves repeat mode on, and harms nothing elsewhere",
        "ldi 9,rc\n rptb last\n addi 1,r0\n cmpi 3,r0\n beq out\nlast: nop\nout: addi 16,r1",
        {"R0": 3, "R1": 16, "RC": 7},
    ),
    Case("writing ST with RM while RC is 0 leaves it off", "ldi 0,rc\n ldi 100h,st\n ldi st,r1", {"R1": 0}),
    Case(
        "the same with RC = 1 turns it on",
        "ldi 1,rc\n ldhi 7fffh,re\n ldi 100h,st\n ldi st,r1\n ldi 0,st",
        {"R1": 0x100},
    ),
]

TRAP_TABLE = {TRAPS + 5: "handler", TRAPS + 6: "late"}
TRAPPED = """
 b stop
handler: ldi st,r7
 addi 1,r1
 reti
late: ldi st,r7
 addi 2,r1
 bu r11
"""
TRAPS_AND_RETURNS = [
    Case(
        "TRAPU goes and RETI returns behind it; GIE and CF were saved",
        "ldi 2000h,st\n trapu 5\n addi 8,r0" + TRAPPED,
        {"R0": 8, "R1": 1, "SP": STACK, "ST": 0x6000, "R7": 0x4000 | 0x400},
    ),
    Case(
        "with GIE = 0 it returns with GIE = 0", "ldi 0,st\n trapu 5\n addi 8,r0" + TRAPPED, {"R0": 8, "R1": 1, "ST": 0}
    ),
    Case(
        "TRAPcond that is false does nothing",
        "cmpi 1,r1\n trapz 5\n addi 8,r0" + TRAPPED,
        {"R0": 8, "R1": 0, "SP": STACK},
    ),
    Case(
        "RETIcond that is false continues behind it",
        "trapu 5\n addi 8,r0\n b stop\nhandler: cmpi 1,r2\n retiz\n addi 4,r1\n retinz",
        {"R0": 8, "R1": 4, "SP": STACK},
    ),
    Case(
        "RETIcondD runs its slots, then returns",
        "trapu 5\n addi 8,r0\n b stop\nhandler: retiud\n addi 1,r1\n addi 1,r1\n addi 1,r1\n addi 1,r1",
        {"R0": 8, "R1": 3, "SP": STACK},
    ),
    Case(
        "LATU runs its slots, keeps the way back in R11, pushes nothing",
        "latu 6\n addi 1,r0\n addi 1,r0\n addi 1,r0\n addi 8,r0" + TRAPPED,
        {"R0": 11, "R1": 2, "SP": STACK, "R11": CODE + 4},
    ),
    Case(
        "LATcond that is false runs them as plain code",
        "cmpi 1,r2\n latz 6\n addi 1,r0\n addi 1,r0\n addi 1,r0\n addi 8,r0",
        {"R0": 11, "R1": 0},
    ),
]


@pytest.mark.parametrize("case", [*PARALLEL, *BRANCHES, *REPEATS, *TRAPS_AND_RETURNS], ids=case_id)
def test_case(case: Case) -> None:
    chip = processor(f" {case.text.strip()}\nstop: b stop\n")
    symbols = chip.program.symbols if chip.program else {}
    for address, label in TRAP_TABLE.items():
        if label in symbols:
            chip.memory[address] = symbols[label]
    chip.memory[DATA : DATA + len(case.memory)] = case.memory
    for name, value in {"AR0": DATA, **case.before}.items():
        chip.registers[name] = value
    stop = chip.run(2000, until="stop")
    assert stop.reason == "until", stop
    masks = {"ST": ST_GIE | ST_PGIE | ST_N | ST_Z}
    assert {name: chip.registers[name] & masks.get(name, 0xFFFFFFFF) for name in case.after} == case.after
    if case.memory_after is not None:
        assert chip.memory[DATA : DATA + len(case.memory_after)] == case.memory_after
    assert sum(chip.causes.values()) == chip.cycles
