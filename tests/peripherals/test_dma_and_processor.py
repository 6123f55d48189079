"""The DMA coprocessor beside the processor: priority at a memory port, windows, faults, links, the end of a program
(c40-hardware.md 3 and 11.5)."""

from __future__ import annotations

import itertools
import json
import subprocess
from pathlib import Path

import pytest
from dma_chips import BLOCK0, BLOCK1, IDLE, RUN, STOP_AT_END, TCC, chip_with, copy, idle_chip, low
from linked_processors import HERTZ, Network, processor

PERIOD = 10**12 // HERTZ


READS = "        ldf *ar0,r0\n     || ldf *ar1,r1\n" * 200 + "end:    bu end\n"


def test_priority_against_the_processor_at_a_full_block() -> None:
    """200 pairs of loads use both ports of block 0 in each cycle; the code is elsewhere. The DMA reads 40 words from
    block 0."""
    cycles = {}
    for priority in (0, 1, 3):
        chip, image = chip_with(READS, at=0x300000)
        chip.set("AR0", BLOCK0)
        chip.set("AR1", BLOCK0 + 1)
        copy(chip, 0, BLOCK0 + 0x100, 0x80000000, 40, RUN | STOP_AT_END | priority)
        chip.run(2000, until=image.symbols["end"])
        cycles[priority] = (chip.cycle, 40 - chip.peripheral("DMA0.counter"))
        assert sum(chip.causes.values()) == chip.cycle
    alone, _ = chip_with(READS, at=0x300000)
    alone.set("AR0", BLOCK0)
    alone.set("AR1", BLOCK0 + 1)
    alone.run(2000, until=0x300000 + 200)
    assert cycles[0][0] == alone.cycle and cycles[0][1] <= 2  # the processor always wins
    assert cycles[3] == (alone.cycle + 40, 40)  # each word costs it one cycle
    assert alone.cycle < cycles[1][0] <= alone.cycle + 40 and cycles[1][1] > 20


def test_no_conflict_costs_nothing() -> None:
    chip, image = chip_with(READS, at=0x300000)
    chip.set("AR0", BLOCK0)
    chip.set("AR1", BLOCK1)
    copy(chip, 0, BLOCK0 + 0x100, BLOCK1 + 0x100, 60, RUN | STOP_AT_END | 3)
    chip.run(2000, until=image.symbols["end"])
    assert chip.peripheral("DMA0.counter") == 0 and chip.causes["memory_conflict"] == 0


def test_dma_into_nothing_is_a_fault_that_names_channel_and_address() -> None:
    for source, destination, words in (
        (0x200000, BLOCK0, "read of 00200000h"),
        (BLOCK0, 0x200100, "write to 00200100h"),
        (0x100010, BLOCK0, "analysis"),
    ):
        chip, _ = idle_chip()
        copy(chip, 4, source, destination, 2)
        stop = chip.run(50)
        assert stop["reason"] == "fault"
        assert "DMA channel 4" in stop["message"] and words in stop["message"]


def test_dma_through_a_window_is_reported_with_its_channel() -> None:
    chip, _ = idle_chip()
    chip.run(20)
    copy(chip, 5, 0xC0000000, BLOCK0, 3, RUN | STOP_AT_END | TCC)
    chip.set("IIE", 1 << 30)
    for i in range(3):
        stop = chip.run(100)
        assert (stop["reason"], stop["channel"], stop["write"], stop["address"]) == (
            "external_access",
            5,
            False,
            0xC0000000 + i,
        )
        chip.complete_read(70 + i, arbitration=4, transfer=6)
    chip.run(40)
    assert low(chip, "R2") == 1
    assert [chip.peek(BLOCK0 + i) for i in range(3)] == [70, 71, 72]
    assert sum(chip.causes.values()) == chip.cycle


def test_two_chips_stream_by_dma_at_the_links_rate() -> None:
    words = list(range(1000, 1100))
    a, b = processor("wait:   idle\n        bu wait\n"), processor("wait:   idle\n        bu wait\n")
    network = Network([a, b])
    link = network.join(0, 0, 1, 3)
    a.load_words(BLOCK0, words)
    copy(a, 0, BLOCK0, 0x100042, 100, RUN | STOP_AT_END | 1 << 7, destination_index=0)
    a.set("DIE", 1 << 2)
    copy(b, 3, 0x100071, BLOCK0, 100, RUN | STOP_AT_END | TCC | 1 << 6, source_index=0)
    b.set("DIE", 1 << 14)
    network.run(700 * PERIOD)
    assert [b.peek(BLOCK0 + i) for i in range(100)] == words
    ends = [event["time"] // PERIOD for event in link.events if event["kind"] == "word"]
    assert {y - x for x, y in itertools.pairwise(ends)} == {5}
    network.balance()
    assert b.get("IIF") == 1 << 28


def test_the_processor_works_while_the_dma_waits_for_a_window() -> None:
    chip, _image = chip_with("        rpts 99\n        addi 1,r0\nend:    bu end\n")
    copy(chip, 0, 0xC0000000, BLOCK0, 1)
    stop = chip.run(1000)
    assert stop["reason"] == "external_access"
    begun = stop["access_cycle"]
    chip.complete_read(5, transfer=500)
    chip.run(104 - chip.cycle + 20)
    assert low(chip, "R0") == 100 and chip.peek(BLOCK0) == 0
    chip.run(begun + 503 - chip.cycle + 3)
    assert chip.peek(BLOCK0) == 5


def test_both_ways_of_execution_agree_with_the_dma_beside() -> None:
    found = []
    for exact in (False, True):
        chip, _image = chip_with(READS.replace("end:    bu end", "        ldi *ar2,r5\n") + IDLE, at=0x300000)
        chip.set_exact(exact)
        chip.set("AR0", BLOCK0)
        chip.set("AR1", BLOCK0 + 1)
        chip.set("AR2", 0x80000003)
        copy(chip, 0, BLOCK0 + 0x100, 0x80000000, 40, RUN | STOP_AT_END | 1)
        chip.run(3000)
        found.append((chip.cycle, chip.causes, chip.instructions))
    assert found[0] == found[1]


@pytest.mark.parametrize("ends", ["end:    bu end\n", "wait:   idle\n        bu wait\n"])
@pytest.mark.parametrize(("count", "interrupts"), [(8, False), (20, False), (20, True)])
def test_a_program_ends_beside_a_dma_that_is_done_or_armed_unless_it_waits_for_its_interrupt(
    emulator: Path, tmp_path: Path, ends: str, count: int, interrupts: bool
) -> None:
    """Channel 0 into an output FIFO to which nothing is linked: it holds eight words."""
    registers = {1: BLOCK0, 2: 1, 3: count, 4: 0x100042, 5: 0, 0: RUN | STOP_AT_END | TCC}
    writes = "".join(
        f"        ldhi 0{v >> 16:x}h,r0\n        or 0{v & 0xFFFF:x}h,r0\n        sti r0,*+ar0({n})\n"
        for n, v in registers.items()
    )
    listens = "        ldhi 200h,iie\n        or 2000h,st\n" if interrupts else ""
    (tmp_path / "dma.asm").write_text(
        "        .text\nstart:  ldhi 10h,ar0\n        or 0a0h,ar0\n" + writes + listens + ends
    )
    result = subprocess.run(
        [emulator, "exec", "dma.asm", "--json"], capture_output=True, text=True, check=False, cwd=tmp_path, timeout=60
    )
    stop = json.loads(result.stdout)["stop"]
    assert (
        stop["reason"] == ("dma_wait" if interrupts else "idle" if "idle" in ends else "halt")
        and result.returncode == interrupts
    )
    armed = "DMA channel 0 waits for room in output FIFO 0 (write to 00100042h)"
    assert (armed in stop["message"]) == (count == 20)
    assert stop["message"].startswith(armed + " forever since cycle ") == interrupts
