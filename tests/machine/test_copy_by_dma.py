"""A kernel's parameters from shared memory into on-chip RAM, by the processor and by the DMA: why the kernels copy
themselves."""

import pytest
from cmrc_test import machine
from programs import ON_CHIP, US, assemble, config

FROM, TO = 16, 0x2FF900

TIMED = """
        ldhi    0010h, ar6
        or      0020h, ar6              ; timer 0, in steps of two cycles
        ldi     -1, r0
        sti     r0, *+ar6(8)
        ldi     3c1h, r0
        sti     r0, *ar6
        ldhi    0010h, ar5
        or      00A0h, ar5              ; channel 0
        ldi     1, r0
        sti     r0, *+ar5(2)
        sti     r0, *+ar5(5)
        addi3   16, ar0, ar4
        ldhi    002Fh, ar7
        or      0F900h, ar7
        ldhi    0010h, r2               ; TCINT FLAG
        ldi     *+ar6(4), r10
{copy}
        ldi     *+ar6(4), r11
        subi    r10, r11
        sti     r11, *ar3
"""
BY_PROCESSOR = """
        ldi     {last}, rc
        rptb    copied
        ldi     *ar4++, r0
copied: sti     r0, *ar7++
"""
BY_DMA = """
        sti     ar4, *+ar5(1)
        ldi     {words}, r0
        sti     r0, *+ar5(3)
        sti     ar7, *+ar5(4)
        ldhi    00C0h, r0
        or      5, r0                   ; stop at the end, start; the index registers are 1
        sti     r0, *ar5
moving: ldi     *ar5, r0
        tstb    r2, r0
        beq     moving
"""


def cycles(copy: str, words: int) -> int:
    m = machine.Machine(assemble(TIMED.format(copy=copy.format(words=words, last=words - 1))), config(dsps=1))
    for i in range(words):
        m.poke(FROM + i, 7 * i + 1)
    m.run_until(200 * US)
    assert [m.chip_word(0, TO + i) for i in range(words)] == [7 * i + 1 for i in range(words)]
    return 2 * int(m.chip_word(0, ON_CHIP))


@pytest.mark.parametrize("words", [16, 48, 128, 256])
def test_the_dma_moves_the_same_words_and_is_not_faster(words: int) -> None:
    """Both read lines of 8 words through the bridge, which is what takes the time; the DMA has five registers to be
    written and its end to be seen."""
    assert cycles(BY_PROCESSOR, words) < cycles(BY_DMA, words)
