"""GMICR and LMICR, strobes, pages, LOCK, the peripheral bus (c40-hardware.md 1.4, 7.4, 8.2, 8.3). Code is on chip, so
that only data uses the buses."""

from pathlib import Path
from typing import Any

import pytest
import small_programs

GMICR, LMICR = 0x100000, 0x100004
LOCAL, SLOW, GLOBAL = 0x300000, 0x40000000, 0x80000000
ON_CHIP = 0x2FF900


def fields(**values: int) -> int:
    """A control word by the layout of 1.4."""
    places = {"sww0": 4, "sww1": 6, "wtcnt0": 8, "wtcnt1": 11, "page0": 14, "page1": 19, "active": 24, "switch": 29}
    return sum(value << places[name] for name, value in values.items())


def run(
    text: str, registers: dict[str, int], pokes: dict[int, int], board: str = "default", exact: bool = False
) -> Any:
    processor, image = small_programs.load(text + "\nstop:   nop\n        nop\n", board)
    processor.set_exact(exact)
    for address, value in pokes.items():
        processor.poke(address, value)
    for name, value in registers.items():
        processor.set(name, value)
    assert processor.run(1000, until=image.symbols["stop"])["reason"] == "breakpoint"
    assert small_programs.consistent(processor)
    return processor


def test_the_known_control_words_are_made_of_the_fields() -> None:
    """The decoded values of 1.4, encoded again: these tests rest on that layout."""
    assert fields(sww0=3, sww1=3, wtcnt0=7, wtcnt1=7, page0=7, page1=7, active=30, switch=1) == 0x3E39FFF0
    assert fields(page0=9, page1=29, active=29) == 0x1DEA4000
    assert fields(sww0=1, wtcnt0=7, page0=17, page1=25, active=25) == 0x19CC4710


# Ready of the pin alone, of the counter alone, of whichever is first, of whichever is last.
@pytest.mark.parametrize(("sww", "fast", "slow"), [(0, 0, 1), (1, 3, 3), (2, 0, 1), (3, 3, 3)])
@pytest.mark.parametrize("exact", [True, False])
def test_software_wait_states(sww: int, fast: int, slow: int, exact: bool) -> None:
    control = fields(sww0=sww, sww1=sww, wtcnt0=3, wtcnt1=3, page0=9, page1=9, active=29)
    for address, waits in ((LOCAL, fast), (SLOW, slow)):
        processor = run("        ldi *ar0,r0\n" * 3, {"AR0": address}, {LMICR: control}, exact=exact)
        assert (processor.cycle, processor.causes["wait_state"]) == (3 * (1 + waits), 3 * waits)
    assert run("        ldi *ar0,r0\n" * 3, {"AR0": GLOBAL}, {LMICR: control}, exact=exact).cycle == 3


def test_either_and_both_with_a_longer_pin() -> None:
    """One wait state by the pin, none or two by the counter."""
    for sww, count, waits in ((2, 0, 0), (3, 0, 1), (2, 2, 1), (3, 2, 2)):
        control = fields(sww0=sww, sww1=sww, wtcnt0=count, wtcnt1=count, active=29)
        assert run("        ldi *ar0,r0", {"AR0": SLOW}, {LMICR: control}).cycle == 1 + waits


def test_after_the_reset_value_everything_waits_seven_times() -> None:
    processor = run(
        "        ldi *ar0,r0\n        ldi *ar1,r0",
        {"AR0": LOCAL, "AR1": GLOBAL},
        {LMICR: 0x3E39FFF0, GMICR: 0x3E39FFF0},
    )
    assert (processor.cycle, processor.causes["wait_state"]) == (16, 14)


@pytest.mark.parametrize("exact", [True, False])
def test_a_program_that_writes_the_register_waits_from_then_on(exact: bool) -> None:
    """Two reads, the store of the new value (its write is over in its cycle), two reads with four wait states each; and
    round again in the blocks that were recorded before."""
    control = fields(sww0=1, wtcnt0=4, active=29)
    text = """
        ldi 1,rc
        rptb e
        ldi *ar0,r0
        ldi *ar0,r0
        sti r1,*ar1
        nop
        nop
        ldi *ar0,r0
e:      ldi *ar0,r0"""
    processor = run(text, {"AR0": LOCAL, "AR1": LMICR, "R1": control}, {}, exact=exact)
    assert processor.causes["wait_state"] == (2 + 4) * 4
    assert processor.cycle == 1 + 4 + 2 * 7 + 6 * 4
    assert processor.peek(LMICR) == control


def test_pins_and_reserved_bits_are_not_written() -> None:
    before = run("        nop", {}, {}).peek(GMICR)
    assert (
        run("        sti r0,*ar0\n        nop\n        nop", {"R0": 0xFFFFFFFF, "AR0": GMICR}, {}).peek(GMICR)
        == 0x3FFFFFF0 | before & 0xF
    )


@pytest.mark.parametrize("exact", [True, False])
def test_each_strobe_has_its_wait_states_and_active_says_where_it_begins(exact: bool) -> None:
    """ACTIVE = 18: STRB0 is the first 2^19 words of the global bus, in the middle of the board's SRAM."""
    control = fields(sww0=1, sww1=1, wtcnt0=2, wtcnt1=5, active=18)
    for offset, waits in ((0, 2), (0x7FFFF, 2), (0x80000, 5), (0xFFFFF, 5)):
        assert run("        ldi *ar0,r0", {"AR0": GLOBAL + offset}, {GMICR: control}, exact=exact).cycle == 1 + waits
    both = run("        ldi *ar0++(1),r0\n" * 2, {"AR0": GLOBAL + 0x7FFFF}, {GMICR: control}, exact=exact)
    assert both.cycle == (1 + 2) + (1 + 5)
    assert (
        run("        ldi *ar0,r0", {"AR0": GLOBAL + 0xFFFFF}, {GMICR: control & ~(31 << 24) | 30 << 24}).cycle == 1 + 2
    )


# Reads follow each other without a gap: a change of strobe costs a cycle if STRB SWITCH says so.
@pytest.mark.parametrize(
    ("text", "cycles"),
    [
        ("ldi *ar0,r0 / ldi *ar1,r1", 3),
        ("ldi *ar0,r0 / ldi *ar0,r1", 2),
        ("ldi *ar1,r0 / ldi *ar1,r1", 2),
        ("ldi *ar0,r0 / ldi *ar1,r1 / ldi *ar0,r1", 5),
        ("ldi *ar0,r0 / nop / ldi *ar1,r1", 3),
        ("ldi *ar0,r0 || ldi *ar1,r1", 3),
        ("ldi *ar0,r0 || ldi *ar0,r1", 2),
    ],
)
@pytest.mark.parametrize("switch", [0, 1])
def test_strobe_switch(text: str, cycles: int, switch: int) -> None:
    lines = text.replace(" || ", "\n||      ").replace(" / ", "\n        ")
    control = fields(active=18, switch=switch)
    changes = cycles - text.count("ldi") - text.count("nop")
    processor = run("        " + lines, {"AR0": GLOBAL, "AR1": GLOBAL + 0x80000}, {GMICR: control})
    assert processor.cycle == cycles - (0 if switch else changes)


PAGED = """
name = "DRAM"
gmicr = 0x{gmicr:X}
[[region]]
name = "DRAM"
base = 0x80000000
words = 0x10000
bus = "global"
waits = 1
page_waits = 4
"""


@pytest.mark.parametrize("exact", [True, False])
def test_another_page_waits_longer(tmp_path: Path, exact: bool) -> None:
    """Pages of 256 words: RDY asks for one wait state, and for four more in another page than before."""
    board = tmp_path / "b.toml"
    board.write_text(PAGED.format(gmicr=fields(page0=7, page1=7, active=30)))
    offsets = [0, 1, 255, 256, 257, 0, 600]
    words = "\n".join(
        f"        ldi *+ar0(ir0),r0\n        addi {b - a},ir0\n        nop\n        nop"
        for a, b in zip(offsets, offsets[1:] + [0])
    )
    processor = run(words, {"AR0": GLOBAL}, {}, str(board), exact)
    opened = [True, False, False, True, False, True, True]
    assert processor.causes["wait_state"] == sum(1 + 4 * new for new in opened)
    assert processor.cycle == 4 * len(offsets) + processor.causes["wait_state"]
    board.write_text(PAGED.format(gmicr=fields(page0=8, page1=7, active=30)))  # pages of 512 words
    processor = run(words, {"AR0": GLOBAL}, {}, str(board), exact)
    assert processor.causes["wait_state"] == len(offsets) + 4 * 2


def test_the_counter_alone_knows_no_pages(tmp_path: Path) -> None:
    board = tmp_path / "b.toml"
    board.write_text(PAGED.format(gmicr=fields(sww0=1, wtcnt0=2, page0=7, active=30)))
    assert (
        run("        ldi *ar0,r0\n        ldi *ar1,r0", {"AR0": GLOBAL, "AR1": GLOBAL + 0x1000}, {}, str(board)).cycle
        == 6
    )


def test_code_in_paged_memory(tmp_path: Path) -> None:
    """A fetch waits 1 and, at the first word of a page, 4 more: by the exact engine and by blocks, with the cache and
    without."""
    board = tmp_path / "b.toml"
    board.write_text(PAGED.format(gmicr=fields(page0=3, page1=7, active=30)))  # 16 words
    for status, first, later in ((0, 32 * 2 + 2 * 4, 32 * 2 + 2 * 4), (0x800, 32 * 2 + 2 * 4, 32)):
        for exact in (True, False):
            processor, _ = small_programs.load("        nop\n" * 33, str(board), at=GLOBAL)
            processor.set_exact(exact)
            processor.set("ST", status)
            for cycles in (first, later):
                before = processor.cycle
                processor.pc = GLOBAL
                processor.run(10_000, until=GLOBAL + 32)
                assert processor.cycle - before == cycles


def test_lock_is_low_from_the_interlocked_load_to_the_interlocked_store() -> None:
    states = []
    processor, _ = small_programs.load("        ldii *ar0,r0\n        ldi *ar0,r1\n        stii r0,*ar0\n        nop\n")
    processor.set("AR0", GLOBAL)
    for _ in range(4):
        processor.step()
        states.append((processor.locked(True), processor.locked(False)))
    assert states == [(True, False), (True, False), (False, False), (False, False)]


@pytest.mark.parametrize(("mnemonic", "address", "locked"), [
    ("ldii", GLOBAL, (True, False)), ("ldfi", LOCAL, (False, True)), ("sigi", GLOBAL, (False, False)),
    ("ldii", ON_CHIP, (False, False)), ("ldi", GLOBAL, (False, False)),
])  # fmt: skip
@pytest.mark.parametrize("exact", [True, False])
def test_which_loads_lock_which_bus(mnemonic: str, address: int, locked: tuple[bool, bool], exact: bool) -> None:
    processor = run(f"        {mnemonic} *ar0,r0\n        nop", {"AR0": address}, {}, exact=exact)
    assert (processor.locked(True), processor.locked(False)) == locked
    processor.reset()
    assert (processor.locked(True), processor.locked(False)) == (False, False)


def test_the_peripheral_bus_takes_one_access_a_cycle() -> None:
    """7.4: two reads of one instruction take two cycles; a store is over when the next instruction's read begins."""
    registers = {"AR0": GMICR, "AR1": LMICR, "AR2": ON_CHIP}
    assert run("        ldi *ar0,r0\n||      ldi *ar1,r1", registers, {}).cycle == 2
    assert run("        ldi *ar0,r0\n||      ldi *ar2,r1", registers, {}).cycle == 1
    assert run("        ldi *ar0,r0\n        ldi *ar1,r1", registers, {}).cycle == 2
    assert run("        sti r0,*ar2\n        ldi *ar1,r1", registers, {}).cycle == 2
