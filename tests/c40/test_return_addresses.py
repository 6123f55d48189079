"""Blocks at return addresses: the engine continues with them without looking for them (BlockStore::recent)."""

from pathlib import Path

import small_programs
from small_programs import agree, state

SLOW = 0x40000000


def test_a_subroutine_returns_to_code_that_is_cached_now_and_was_not_before() -> None:
    """The subroutine and one of its callers are in the chip's RAM, which is never cached; the other caller is not."""
    text = """
main:   ldi 5,ar0
        ldi @far_is,r10
again:  callu r10
        call sub
        addi 3,r1
        dbu ar0,again
        xor 800h,st             ; the cache on, and off again
        bu main
sub:    addi 1,r0
        rets
far_is: .word far
sub_is: .word sub
        .sect "far"
far:    ldi @sub_is,r9
        callu r9
        addi 2,r1
        addi r0,r1
        rets
"""
    fast, exact = (small_programs.load(text, sections={"far": SLOW})[0] for _ in range(2))
    for processor in (fast, exact):
        processor.set("DP", small_programs.CODE >> 16)
    agree(fast, exact, 1)
    assert fast.causes["cache_miss"] > 0


def test_two_subroutines_return_to_one_place_and_only_one_has_kept_a_bus_busy(tmp_path: Path) -> None:
    """The one writes to slow memory before its end, and the read at the return address waits for the bus. The other
    does not; it also returns to another place in between, so that the block after its end is looked for again."""
    text = """
main:   ldi @slow_at,ar0
        ldi @busy_is,r10
        ldi @busy_is,r11
        xor @idle_is,r11
again:  callu r10
        ldi *ar0,r2
        call idle
        addi 3,r1
        xor r11,r10
        bu again
busy:   addi 2,r1
        sti r1,*ar0
        rets
idle:   addi 1,r0
        rets
slow_at: .word 40000000h
busy_is: .word busy
idle_is: .word idle
"""
    board = tmp_path / "board.toml"
    board.write_text('[[region]]\nname = "slow"\nbase = 0x40000000\nwords = 0x100\nbus = "local"\nwaits = 12\n')
    fast, exact = (small_programs.load(text, str(board))[0] for _ in range(2))
    for processor in (fast, exact):
        processor.set("DP", small_programs.CODE >> 16)
    agree(fast, exact, 1)
    assert fast.get("R0") > 1000


def test_a_subroutine_returns_to_places_whose_code_was_changed_from_outside() -> None:
    """A write to code deletes all blocks, those at return addresses too. Afterwards the subroutine's block is known
    again before the blocks at its two return addresses are. `make trust` sees a block that is used and is gone."""
    text = """
again:  call sub
first:  addi 3,r1
        call sub
second: addi 5,r2
        bu again
sub:    addi 1,r0
        rets
"""
    (fast, image), (exact, _) = (small_programs.load(text) for _ in range(2))
    exact.set_exact(True)
    for n in range(40):
        place = image.symbols[("first", "second", "sub")[n % 3]]
        for processor in (fast, exact):
            processor.run(200 + 7 * n)
            processor.poke(place, processor.peek(place) ^ 1)
        assert state(fast) == state(exact)
    assert fast.get("R0") > 500
