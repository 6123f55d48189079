"""Blocks that are left again and again, since an access reaches other memory than at the recording."""

import random

import small_programs
from small_programs import state

CACHE_ENABLE = 0x800


def test_a_subroutine_that_copies_between_all_kinds_of_memory() -> None:
    """Source and destination of each call are drawn: both blocks of the chip's RAM, local and global memory with other
    wait states each, and cached code beside it all. So each block is left again and again for an access."""
    text = """
main:   ldi 1,r1
next:   mpyi @factor,r1         ; a linear congruential generator
        addi 1,r1
        lsh3 -29,r1,ir0
        lsh3 -26,r1,ir1
        and 7,ir1
        ldi @places_at,ar2
        ldi *+ar2(ir0),ar0
        ldi *+ar2(ir1),ar1
        call copy
        addf3 *ar0,*ar1,r4      ; two accesses in one instruction
        ldf *ar0--,r5 || ldf *ar1,r6
        mpyf3 *ar0,*ar1,r0 || addf3 r4,r5,r2
        sti r1,*ar0
        bu next
copy:   ldi 7,rc
        rptb last
        ldi *ar0++,r0
last:   sti r0,*ar1++
        ldi *-ar1(1),r3
        rets
factor: .word 69069
places_at: .word places
places: .word 2FF820h, 2FFC20h, 303000h, 40001000h, 2FF860h, 80000400h, 2FFC60h, 40002000h
"""
    fast, exact = (small_programs.load(text)[0] for _ in range(2))
    for processor in (fast, exact):
        processor.set("DP", small_programs.CODE >> 16)
        processor.set("SP", 0x304000)
    exact.set_exact(True)
    rng = random.Random(3)
    for status in (0, CACHE_ENABLE):
        for processor in (fast, exact):
            processor.set("ST", status)
        for _ in range(60):
            cycles = rng.choice([1, 7, 30, 400, 1500, 6000])
            assert fast.run(cycles) == exact.run(cycles)
            assert state(fast) == state(exact)
            assert small_programs.consistent(fast)
    assert fast.instructions > 50_000
