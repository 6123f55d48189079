"""Sequences with slow memory, counted by hand from c40-hardware.md 7.4, 7.5 and 8.2. Numbers of cycles are of the drawn
pipeline: the instruction that is fetched in cycle -3 executes in cycle 0 if it waits for nothing."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest
from cmrc import c40

ON_CHIP, STACK, VECTORS = 0x2FFC00, 0x2FF900, 0x2FFA00
SRAM, SLOW, SLOW_WRITES, FIRST_STROBE, GLOBAL = 0x300000, 0x310000, 0x320000, 0x330000, 0x80000000
SECOND_STROBE = 0x40000000
TIMER = 0x100020
STRB_SWITCH = 1 << 29


def region(base: int, **waits: int) -> str:
    bus = "local" if base < GLOBAL else "global"
    return f'[[region]]\nname = "at {base:X}h"\nbase = {base}\nwords = 0x8000\nbus = "{bus}"\n' + "".join(
        f"{name} = {value}\n" for name, value in waits.items()
    )


BOARD = "".join(
    [
        f"gmicr = 0x1DEA4000\nlmicr = {0x1DEA4000 | STRB_SWITCH}\n",
        region(SRAM),
        region(SLOW, waits=7),
        region(SLOW_WRITES, write_waits=2),
        region(FIRST_STROBE),
        region(SECOND_STROBE),
        region(GLOBAL, waits=3),
    ]
)
VERY_SLOW_WRITES = region(SLOW, write_waits=15)
SLOW_PAGES = region(SLOW, page_waits=4)


def chip(
    lines: list[str], at: int, board: Path, text: str, registers: Mapping[str, int], words: Mapping[int, int]
) -> c40.Processor:
    board.write_text(text)
    source = "\n".join(['        .sect "code"', "start:", *lines, "done:   br done", ""])
    made = c40.Processor(c40.assemble(source, sections={"code": at}), board=board)
    for name, value in registers.items():
        made.registers[name] = value
    for address, word in words.items():
        made.memory[address] = word
    return made


def counted(processor: c40.Processor) -> list[int]:
    """The cycles counted after each instruction."""
    cycles = []
    while processor.pc != processor.address("done"):
        processor.step()
        cycles.append(processor.cycles)
    return cycles


def test_a_fetch_that_was_made_long_ago_is_not_made_again(tmp_path: Path) -> None:
    lines = [" nop", " nop", " nop"]
    lines += [" stf r0,*ar0 || stf r1,*ar1"]  # local bus 3 to 11, then 12 to 20: executes in 12
    lines += [" ldf *ar2,r2 || ldf *ar3,r3"]  # from 21 on, a turn and 2 x 8 cycles: executes in 38
    lines += [" addf r4,r5"]  # fetched in 2, before the first store has the bus: executes in 39
    lines += [" addf r4,r6"]  # fetched when the bus is free again, in 38: executes in 41
    registers = {f"AR{n}": SLOW + 8 * n for n in range(4)}
    processor = chip(lines, SRAM, tmp_path / "board.toml", BOARD, registers, {})
    assert counted(processor) == [1, 2, 3, 13, 39, 40, 42]


def test_an_address_register_that_is_not_ready_delays_the_next_fetch_behind_a_held_store(tmp_path: Path) -> None:
    lines = [" nop", " nop", " nop"]
    lines += [" ldi *ar7,ar1"]  # executes in 3: AR1 makes addresses from 4 on
    lines += [" sti r0,*ar2 || sti r1,*ar4"]  # 4 cycles each, 4 to 7 and 8 to 11: executes in 8
    lines += [" stf r4,*ar0 || stf r5,*ar1"]  # in decode in 4, for AR1; 12 to 15 and 16 to 19: executes in 16
    lines += [" stf r6,*ar2"]  # fetched in 4 at the earliest, so in 20 and 21, behind four writes: executes in 24
    lines += [" nop"]  # fetched in 22
    registers = {"AR0": SLOW_WRITES, "AR2": SLOW_WRITES + 32, "AR4": SLOW_WRITES + 64, "AR7": STACK}
    processor = chip(lines, SRAM, tmp_path / "board.toml", BOARD, registers, {STACK: SLOW_WRITES + 1})
    assert counted(processor) == [1, 2, 3, 4, 9, 17, 25, 26]


def test_the_cycle_between_write_and_read_does_not_delay_the_other_bus(tmp_path: Path) -> None:
    lines = [" nop", " nop"]
    lines += [" sti r0,*ar0"]  # local 2 and 3
    lines += [" ldi *ar0,r1 || ldi *ar1,r2"]  # both from 4 on: local 2 cycles, global 4
    lines += [" nop"]
    processor = chip(lines, ON_CHIP, tmp_path / "board.toml", BOARD, {"AR0": FIRST_STROBE, "AR1": GLOBAL}, {})
    assert counted(processor) == [1, 2, 3, 9, 10]


def test_a_fetch_straight_after_a_write_has_to_fit_with_the_cycle_between(tmp_path: Path) -> None:
    lines = [" nop", " nop", " nop"]
    lines += [" sti r0,*ar1"]  # 3 and 4
    lines += [" ldi ar3,ar0"]  # executes in 4
    lines += [" ldi *ar0,r1"]  # in decode in 5, for AR0; reads in 6
    lines += [" nop"]  # fetched in 7: between write and read is one cycle, and two are needed. Executes in 10
    registers = {"AR0": FIRST_STROBE, "AR1": FIRST_STROBE, "AR3": FIRST_STROBE + 1}
    processor = chip(lines, SRAM, tmp_path / "board.toml", BOARD, registers, {})
    assert counted(processor) == [1, 2, 3, 4, 5, 8, 11]


def test_the_cycle_between_two_strobes_is_taken(tmp_path: Path) -> None:
    lines = [" nop", " nop", " nop"]
    lines += [" ldi *ar0,r1"]  # 2
    lines += [" ldi *ar1,r2"]  # fetched in 1; 3 and 4: executes in 5
    lines += [" nop"]  # fetched in 5, not in the cycle between: executes in 8
    registers = {"AR0": SECOND_STROBE, "AR1": FIRST_STROBE}
    processor = chip(lines, SRAM, tmp_path / "board.toml", BOARD, registers, {})
    assert counted(processor) == [1, 2, 3, 4, 6, 9]


TIMER_THAT_INTERRUPTS = [" nop", " ldi 1,iie", " sti r1,*+ar1(8)", " sti r2,*ar1"]
STORE_AND_IDLE = [" sti r0,*ar0", " idle", " nop"]  # executes in 4, and has the bus to 20
STORE_AND_NOPS = [" sti r0,*ar0", " or 2000h,st", *[" nop"] * 20]


@pytest.mark.parametrize("period", range(2, 9))
@pytest.mark.parametrize("waits", [STORE_AND_IDLE, STORE_AND_NOPS], ids=["in IDLE", "in NOPs"])
def test_a_posted_write_takes_its_time_while_the_chip_waits(waits: list[str], period: int, tmp_path: Path) -> None:
    """An interrupt's routine begins in 15 or later and reads on that bus: in 21 and 22 if it comes before 22."""
    lines = [*TIMER_THAT_INTERRUPTS, *waits, " br done", "isr: ldi *ar0,r1", "after: reti"]
    registers = {"SP": STACK, "IVTP": VECTORS, "AR0": SLOW, "AR1": TIMER, "R1": period, "R2": 0x3C1}
    processor = chip(lines, ON_CHIP, tmp_path / "board.toml", VERY_SLOW_WRITES, registers, {})
    processor.memory[VECTORS + 2] = processor.address("isr")
    processor.run(1000, until="isr")
    begun = processor.cycles
    assert 15 <= begun <= 40
    processor.step()
    assert processor.cycles == max(23, begun) + 1


@pytest.mark.parametrize("entry", ["trapu 3", "nop"], ids=["trap", "interrupt"])
def test_the_vector_is_read_behind_the_push(entry: str, tmp_path: Path) -> None:
    """Stack and vectors are in two pages of one strobe. The vector's is the open one in the routine, so that RETI
    pays for the stack's (5.5)."""
    lines = [" or 2000h,st", f" {entry}", " nop", " nop", " br done", "isr: nop", " nop", " nop", "back: reti"]
    registers = {"SP": SLOW + 0x2000, "IVTP": SLOW + 0x1000, "TVTP": SLOW + 0x1000, "IIF": 9}
    processor = chip(lines, ON_CHIP, tmp_path / "board.toml", SLOW_PAGES, registers, {})
    processor.memory[SLOW + 0x1003] = processor.address("isr")
    processor.step()
    if entry == "nop":
        processor.raise_interrupt("IIOF0")
    processor.run(1000, until="back")
    before = processor.cycles, processor.causes["wait_state"]
    processor.step()
    assert (processor.cycles - before[0], processor.causes["wait_state"] - before[1]) == (8, 4)
