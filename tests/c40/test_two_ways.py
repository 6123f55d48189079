"""Blocks against the exact engine, and runs cut into pieces against whole ones: every register, word, cycle and
cause."""

import random
from pathlib import Path
from typing import Any

import pytest
import small_programs
from cmrc._core import c40
from small_programs import RAM, agree, state

DATA = Path(__file__).parent / "data"


def kernel(name: str) -> Any:
    processor = c40.Processor("flat")
    words = [int(line, 16) for line in (DATA / f"{name}.hex").read_text().split()]
    processor.load_words(0x1000, words)
    processor.load_words(RAM[0], [(n * 0x9E3779B1) & 0x03FFFFFF for n in range(RAM[1])])
    processor.pc = 0x1000
    return processor


@pytest.mark.parametrize("name", ["fir", "branch", "controller"])
def test_blocks_and_exact_engine_agree_at_many_points(name: str) -> None:
    fast, exact = kernel(name), kernel(name)
    exact.set_exact(True)
    rng = random.Random(1)
    for _ in range(150):
        cycles = rng.choice([1, 2, 3, 7, 20, 64, 150, 1000])
        fast.run(cycles)
        exact.run(cycles)
        assert state(fast) == state(exact)
        assert small_programs.consistent(fast)


# Straight pieces from which random programs are made; AR4..AR7 point into RAM and move by at most one a piece.
PIECES = [
    "ldi *ar4++(1)%,r0",
    "addi *ar5,r1",
    "sti r1,*ar5++(1)%",
    "addi3 r0,r1,r2",
    "subi 7,r2",
    "mpyi3 r2,r1,r3",
    "float r2,r4",
    "mpyf3 r4,r5,r6",
    "addf3 r4,r6,r5",
    "rnd r5",
    "stf r5,*+ar4(1)",
    "ldf *ar4,r6",
    "cmpi r0,r1",
    "ldigt r0,r2",
    "cmpf r5,r6",
    "ldflt r5,r6",
    "fix r5,r7",
    "lsh -3,r2",
    "ash 2,r3",
    "xor r3,r2",
    "push r2\n        pop r3",
    "pushf r5\n        popf r6",
    "ldi r2,r8",
    "addc r8,r1",
    "addf3 *ar4,r4,r5\n||      stf r6,*ar5",
    "mpyf3 *ar4,*ar5,r0\n||      addf3 r4,r6,r2",
    "mpyf3 *ar4++(1),*ar5++(1),r1\n||      subf3 r4,r6,r3\n        nop *ar4--(1)\n        nop *ar5--(1)",
    "mpyf3 *ar4++(1)%,*ar5++(1)%,r1\n||      addf3 r4,r6,r3",
    "ldf *ar4,r1\n||      ldf *ar5,r3",
    "sti r1,*ar4\n||      sti r2,*ar5",
    "lda ar4,ar6\n        ldi *ar6,r1",
    "ldi ar5,ar7\n        ldi *ar7,r2",
    "or 80h,st",
    "andn 80h,st",
    "ldi st,r9",
    "sti r3,*ar2",
    "ldi *ar2,r0",
    "sti r0,*ar3\n        ldi *ar3,r2",
    "rpts 5\n        addi 3,r1",
    "ldi 4,rc\n        rptb e{n}\n        addi 1,r2\n        sti r2,*ar4\ne{n}:   addi r2,r3",
    "ldi 3,rc\n        rptbd e{n}\n        nop\n        addi 1,r0\n        nop\n        addi 1,r2\ne{n}:   addi r2,r3",
    "cmpi r2,r3\n        bgt e{n}\n        addi 5,r1\n        addi 6,r2\ne{n}:   nop",
    "cmpi r1,r3\n        bltd e{n}\n        addi 5,r1\n        nop\n        addi 6,r2\n        addi 1,r3\ne{n}:   nop",
    "cmpi r1,r3\n        bltaf e{n}\n        addi 5,r1\n        nop\n        addi 6,r2\n        addi 1,r3\ne{n}:   nop",
    "call sub",
    "laj sub2\n        nop\n        addi 1,r0\n        nop",
    "cmpi r1,r2\n        callgt sub",
]


# The cache on and off, frozen and not, cleared.
CACHE_PIECES = ["xor 800h,st", "xor 400h,st", "or 1000h,st"]

CACHE_ENABLE, GIE = 0x800, 0x2000
VECTORS, TIMER0 = 0x80002000, 0x100020


def random_program(
    seed: int, status: int = 0, pieces: int = 40, board: str = "default", timer: int = 0, apart: bool = False
) -> Any:
    """`timer`: ticks between the interrupts of timer 0; 0: none. `apart`: the program changes the cache, and of main
    program and subroutines one is in the chip's RAM, which is not cached."""
    rng = random.Random(seed)
    kinds = PIECES + (3 * CACHE_PIECES + 6 * ["call sub"] if apart else [])
    body = "\n".join("        " + rng.choice(kinds).replace("{n}", str(n)) for n in range(pieces))
    text = f"""
loop:
{body}
        dbu ar1,loop
stop:   bu stop
{'        .sect "apart"' if apart else ""}
sub:    addi 1,r7
        retsge
        subi 3,r7
        rets
sub2:   addi 2,r7
        bu r11
service: addi 1,ar0
        push r1
        ldi ar0,r1
        sti r1,*ar7
        pop r1
        reti
"""
    here, there = (0x300000, 0x2FFC00) if seed % 2 else (0x2FFC00, 0x300000)
    processor, image = small_programs.load(text, board, at=here, sections={"apart": there} if apart else None)
    processor.set("AR1", 20)
    processor.set("AR4", 0x2FF800)
    processor.set("AR5", 0x2FF840)
    processor.set("AR2", 0x80000000)
    processor.set("AR3", 0x40000000)
    processor.set("BK", 32)
    processor.set("SP", 0x2FFA00)
    processor.set("ST", status)
    if timer:
        processor.poke(VECTORS + 2, image.symbols["service"])
        processor.poke(TIMER0 + 8, timer)
        processor.poke(TIMER0, 0x3C0)  # go, internal clock, clock mode
        for name, value in {"IVTP": VECTORS, "AR7": 0x80003000, "IIE": 1, "ST": status | GIE}.items():
            processor.set(name, value)
    for n, value in enumerate([0x0012345678, 0x0023456789, 0x05400001, 0x0300000007]):
        processor.set(f"R{n + 4}", value)
    return processor


# With the cache on, 40 pieces fit into its 128 words and 100 do not.
CASES = [(seed, 0, 40) for seed in range(40)] + [
    (seed, CACHE_ENABLE, pieces) for seed in range(1, 30, 2) for pieces in (40, 70, 100)
]


@pytest.mark.parametrize(("seed", "status", "pieces"), CASES)
def test_random_programs_agree_cycle_by_cycle(seed: int, status: int, pieces: int) -> None:
    agree(random_program(seed, status, pieces), random_program(seed, status, pieces), seed)


@pytest.mark.parametrize("timer", [0, 61])
@pytest.mark.parametrize("seed", range(30))
def test_programs_that_change_the_cache_agree(seed: int, timer: int) -> None:
    agree(*(random_program(seed, CACHE_ENABLE, 60, timer=timer, apart=True) for _ in range(2)), seed)


# Pages of 1 K words; of 16, with a cycle for a change of strobe.
PAGED = """
name = "paged"
lmicr = 0x{lmicr:X}
[[region]]
name = "local"
base = 0x300000
words = 0x10000
bus = "local"
waits = 1
page_waits = 2
[[region]]
name = "slow"
base = 0x40000000
words = 0x10000
bus = "local"
waits = 1
[[region]]
name = "global"
base = 0x80000000
words = 0x10000
bus = "global"
"""


@pytest.mark.parametrize("lmicr", [None, 0x1DEA4000, 0x3D18C000])
@pytest.mark.parametrize("status", [0, CACHE_ENABLE])
@pytest.mark.parametrize("seed", range(1, 26, 2))
def test_interrupted_programs_agree(seed: int, status: int, lmicr: int | None, tmp_path: Path) -> None:
    """An interrupt freezes the cache until RETI; on the paged boards the wait states of a fetch depend on what was
    accessed before."""
    board = "default"
    if lmicr is not None:
        board = str(tmp_path / "b.toml")
        Path(board).write_text(PAGED.format(lmicr=lmicr))
    for timer in (37, 61):
        fast, exact = (random_program(seed, status, 100, board, timer) for _ in range(2))
        agree(fast, exact, seed)
        assert fast.causes["interrupt"] > 0


def test_tracing_changes_nothing() -> None:
    traced, plain = random_program(3), random_program(3)
    records = traced.trace(3000)
    plain.run(3000)
    assert state(traced) == state(plain)
    assert len(records) == plain.instructions
    assert all(sum(record["causes"].values()) == record["cycles"] for record in records)


def test_a_program_that_changes_its_code_runs_the_new_code() -> None:
    text = """
        ldi 20,rc
loop:   ldi @count,r1
        addi 1,r1
        sti r1,@count
        cmpi 10,r1
        bne same
        ldi @other,r2
        sti r2,@place
same:
place:  addi 1,r0
        cmpi 20,r1
        bne loop
stop:   bu stop
        .data
count:  .word 0
other:  addi 100,r0
"""
    results = []
    for exact in (False, True):
        processor, image = small_programs.load(text.replace(".data", ""))
        processor.set("DP", 0x2F)
        processor.set_exact(exact)
        processor.run(100000, until=image.symbols["stop"])
        results.append(state(processor))
    assert results[0] == results[1]
    assert results[0]["R0"] & 0xFFFFFFFF == 9 * 1 + 11 * 100


def test_repeated_nop_is_advanced_in_closed_form() -> None:
    processor, image = small_programs.load("        rpts r0\n        nop\nstop:   bu stop\n")
    processor.set("R0", 999_999_999)
    processor.run(10**10, until=image.symbols["stop"])
    assert processor.cycle == 4 + 10**9
    assert processor.get("RC") == 0xFFFFFFFF


def test_the_boot_loader_looking_for_a_word_takes_as_long_however_its_run_is_cut() -> None:
    """Blocks that end before a read of a peripheral register: the next instruction meets the same pipeline as before
    that read."""
    whole, pieces, exact = (c40.Processor.bootable() for _ in range(3))
    exact.set_exact(True)
    for processor in (whole, pieces, exact):
        processor.boot()
    rng = random.Random(4)
    while pieces.cycle < 3000:
        pieces.run(min(rng.choice([1, 2, 3, 5, 8, 40]), 3000 - pieces.cycle))
    whole.run(3000)
    exact.run(3000)
    assert state(whole) == state(pieces) == state(exact)


SLOW = 0x40000000


@pytest.mark.parametrize(("pause", "cycles"), [(0, 150_000), (260, 800_000)])
def test_contents_of_the_cache_that_hardly_ever_come_again(pause: int, cycles: int) -> None:
    """Sixteen subroutines in a segment each, called in random order: 43,680 contents, of which the engine knows a part
    at a time."""
    subroutines = "\n".join(f"        addi {n},r3\n        rets\n        .space 30" for n in range(16))
    text = f"""
main:   ldi 1,r1
next:   mpyi @factor,r1         ; a linear congruential generator
        addi 1,r1
        lsh3 -28,r1,r2
        lsh 5,r2
        addi @first,r2
        callu r2
        rpts {pause}
        nop
        bu next
factor: .word 69069
first:  .word {SLOW:#x}
        .sect "far"
{subroutines}
"""
    fast, exact = (small_programs.load(text, sections={"far": SLOW})[0] for _ in range(2))
    for processor in (fast, exact):
        processor.set("DP", small_programs.CODE >> 16)
        processor.set("ST", CACHE_ENABLE)
    exact.set_exact(True)
    for part in (0.3, 0.01, 0.001, 0.689):
        fast.run(round(part * cycles))
        exact.run(round(part * cycles))
        assert state(fast) == state(exact)
    assert fast.causes["cache_miss"] > 1000


def test_code_that_changes_while_the_cache_has_it() -> None:
    """The old code runs until CC clears the cache. Then the same words come into an empty cache as before, but one of
    them is another one."""
    text = """
main:   ldi @far_is,r10
        ldi @place_is,ar1
        ldi 11,ar0
again:  ldi 3,ar2
calls:  callu r10
        addi r0,r4
        dbu ar2,calls
        ldi *ar1,r2             ; addi 1,r0 becomes addi 64,r0, and the other way round
        xor 65,r2
        sti r2,*ar1
        callu r10
        tstb 1,ar0
        bz again1               ; each second time the old code stays
        or 1000h,st
again1: dbu ar0,again
stop:   bu stop
far_is: .word far
place_is: .word place
        .sect "far"
far:    addi 2,r1
place:  addi 1,r0
        rets
"""
    fast, exact = (small_programs.load(text, sections={"far": SLOW})[0] for _ in range(2))
    for processor in (fast, exact):
        processor.set("DP", small_programs.CODE >> 16)
        processor.set("ST", CACHE_ENABLE)
    exact.set_exact(True)
    rng = random.Random(1)
    for _ in range(300):
        fast.set_exact(rng.random() < 0.3)  # then the words that the cache holds are executed, not blocks made of them
        cycles = rng.choice([1, 5, 30])
        fast.run(cycles)
        exact.run(cycles)
        assert state(fast) == state(exact)
    adds, in_cache, in_memory = 0, 1, 1
    for left in range(11, -1, -1):
        adds += 4 * in_cache
        in_memory ^= 65
        adds += in_cache
        in_cache = in_memory if left % 2 else in_cache
    assert fast.get("R0") & 0xFFFFFFFF == adds


def test_code_that_changes_while_neither_cache_nor_blocks_have_it() -> None:
    """Then the chip does not see the write: nothing that it keeps of earlier fetches may hold the old word."""
    text = """
main:   ldi @far_is,r10
        ldi 3,ar2
calls:  callu r10
        dbu ar2,calls
        or 1000h,st
stop:   bu stop
far_is: .word far
        .sect "far"
far:    addi 1,r0
        rets
"""
    processor, image = small_programs.load(text, sections={"far": SLOW})
    processor.set("DP", small_programs.CODE >> 16)
    processor.set("ST", CACHE_ENABLE)
    processor.run(10_000, until=image.symbols["stop"])
    processor.add_breakpoint(image.symbols["stop"])  # an end of all blocks
    processor.poke(SLOW, 0x02600040)  # addi 64,r0
    processor.remove_breakpoint(image.symbols["stop"])
    for exact in (False, True):
        processor.set_exact(exact)
        processor.pc = small_programs.CODE
        processor.run(10_000, until=image.symbols["stop"])
    assert processor.get("R0") & 0xFFFFFFFF == 4 + 2 * 4 * 64


@pytest.mark.parametrize("exact", [False, True])
def test_an_instruction_that_overwrites_itself_while_it_comes_into_the_cache(exact: bool) -> None:
    """The cache has the word that was fetched, until it is cleared; then it gets the word that was written."""
    text = """
main:   ldi @far_is,ar1
        ldi ar1,r10
        ldi @store,r3
        ldi @add,r2
        ldi 9,ar0
again:  sti r3,*ar1
        callu r10               ; sti r2,*ar1: the next time it is addi 1,r0
        or 1000h,st
        callu r10
        callu r10
        or 1000h,st
        dbu ar0,again
stop:   bu stop
far_is: .word far
store:  sti r2,*ar1
add:    addi 1,r0
        .sect "far"
far:    nop
        rets
"""
    processor, image = small_programs.load(text, sections={"far": SLOW})
    processor.set_exact(exact)
    processor.set("DP", small_programs.CODE >> 16)
    processor.set("ST", CACHE_ENABLE)
    processor.run(10_000, until=image.symbols["stop"])
    assert processor.get("R0") & 0xFFFFFFFF == 20
