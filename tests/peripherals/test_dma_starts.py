"""What START, AUX START and STATUS do to a DMA channel in the middle of its work (c40-hardware.md 3.3, 3.7, 3.8)."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import pytest
from cmrc import c40
from dma_chips import BLOCK0, BLOCK1, RUN, STOP_AT_END, TCC, channel, copy, idle_chip

SLOW = 0x40000000  # a wait state: a write takes three cycles
CONTROL = 0x1000A0
RESET, HALT_WITHIN, HALT = 0, 1 << 22, 2 << 22
SPLIT, PORT4, AUX_RUN, AUX_STOP_AT_END, AUX_LISTS = 1 << 14, 4 << 15, 3 << 24, 1 << 4, 2 << 4
LISTS, LISTS_WHEN_RESTARTED, SYNC_READ, SYNC_WRITE, STATIC, LIST_SYNC = 2 << 2, 3 << 2, 1 << 6, 1 << 7, 1 << 8, 1 << 10
FIFO4 = 0x100081
TINT0 = 1 << 24


def settled(chip: Any, cycles: int = 60) -> Any:
    chip.run(cycles)
    return chip


def words(chip: Any, address: int, count: int) -> list[int]:
    return [chip.peek(address + i) for i in range(count)]


def field(chip: Any, n: int, bit: int) -> int:
    return int(chip.peripheral(f"DMA{n}.control")) >> bit & 3


def status(chip: Any, n: int = 0) -> int:
    return field(chip, n, 26)


# ---- the end of a block, and a reset or a halt in its last write ----


@pytest.mark.parametrize("cycles", range(9))
def test_a_reset_in_the_last_write_does_not_end_the_block_that_is_started_next(cycles: int) -> None:
    chip, _ = idle_chip()
    chip.load_words(BLOCK0, [7, 8, 9])
    copy(chip, 0, BLOCK0, SLOW, 1)
    chip.run(cycles)
    chip.poke(CONTROL, RESET)
    ended = chip.get("IIF")
    chip.set("IIF", 0)
    copy(chip, 0, BLOCK0, BLOCK1, 3)
    settled(chip)
    assert words(chip, BLOCK1, 4) == [7, 8, 9, 0]
    assert chip.peek(SLOW) == (7 if cycles > 2 else 0)  # the write under way is completed
    assert (chip.peripheral("DMA0.counter"), chip.get("IIF"), ended != 0) == (0, 1 << 25, cycles >= 5)


@pytest.mark.parametrize("cycles", range(9))
@pytest.mark.parametrize("halt", [HALT_WITHIN, HALT])
def test_a_halt_in_the_last_write_leaves_the_end_of_the_block(halt: int, cycles: int) -> None:
    chip, _ = idle_chip()
    chip.load_words(BLOCK0, [7])
    copy(chip, 0, BLOCK0, SLOW, 1)
    chip.run(cycles)
    chip.poke(CONTROL, halt | STOP_AT_END | TCC)
    settled(chip)
    if chip.peek(SLOW) == 7:
        assert (chip.peripheral("DMA0.counter"), chip.get("IIF")) == (0, 1 << 25)
    else:
        assert chip.get("IIF") == 0
        chip.poke(CONTROL, RUN | STOP_AT_END | TCC)
        settled(chip)
        assert (chip.peek(SLOW), chip.peripheral("DMA0.counter"), chip.get("IIF")) == (7, 0, 1 << 25)


# ---- a halt in the middle ----


@pytest.mark.parametrize("halted_after", range(8))
@pytest.mark.parametrize("halt", [HALT_WITHIN, HALT])
def test_a_list_that_was_halted_goes_on_where_it_was(halt: int, halted_after: int) -> None:
    chip, _ = idle_chip()
    chip.set("DIE", 1 << 20)  # channel 4 reads when its port has a word
    more = LISTS | STATIC | LIST_SYNC
    channel(chip, 4, RUN | more, counter=0, link=FIFO4)
    stream = [RUN | STOP_AT_END | SYNC_READ, FIFO4, 0, 2, BLOCK1, 1, FIFO4, 0xAAA, 0xBBB]
    for n, word in enumerate(stream):
        if n == halted_after:
            chip.poke(CONTROL + 0x40, halt | (more if n < 7 else STOP_AT_END | SYNC_READ))
            settled(chip)
            chip.poke(CONTROL + 0x40, RUN | (more if n < 7 else STOP_AT_END | SYNC_READ))
        chip.deliver(4, word)
        settled(chip)
    assert words(chip, BLOCK1, 3) == [0xAAA, 0xBBB, 0]


def test_a_list_that_is_longer_than_that_of_split_mode_ends_when_split_mode_comes() -> None:
    chip, _ = idle_chip()
    lists, control = 0x300000, RUN | LISTS | LIST_SYNC
    chip.load_words(lists, [HALT, BLOCK0, 1, 4, 0x300100, 5, 6, 7, 8, 9, 10])
    channel(chip, 4, control, counter=0, link=lists)
    chip.set("DIE", 2 << 20)  # IIOF0 paces the list
    chip.set("IIF", 1)
    for n in range(10):
        if n == 6:  # beyond the five words of a list of split mode
            chip.poke(CONTROL + 0x40, control | SPLIT | PORT4)
        chip.raise_iiof(0)
        settled(chip, 20)
    assert field(chip, 4, 22) == 2
    assert [chip.peripheral(f"DMA4.{name}") for name in ("source", "counter", "link")] == [BLOCK0, 4, 0x300100]


def test_status_is_busy_until_the_word_that_a_halt_leaves_is_written() -> None:
    chip, _ = idle_chip()
    chip.load_words(BLOCK0, [7])
    copy(chip, 0, BLOCK0, BLOCK1, 4, RUN | STOP_AT_END | SYNC_WRITE)
    chip.set("DIE", 2 << 2)  # a write waits for IIOF1
    chip.set("IIF", 1 << 4)
    assert status(settled(chip)) == 3
    chip.poke(CONTROL, HALT | STOP_AT_END | SYNC_WRITE)
    assert status(settled(chip)) == 3 and chip.peek(BLOCK1) == 0
    chip.poke(CONTROL, HALT_WITHIN | STOP_AT_END | SYNC_WRITE)
    assert status(settled(chip)) == 1
    chip.poke(CONTROL, HALT | STOP_AT_END | SYNC_WRITE)
    assert status(chip) == 3
    chip.raise_iiof(1)
    assert status(settled(chip)) == 0 and chip.peek(BLOCK1) == 7


# ---- events of a channel that is halted ----


@pytest.mark.parametrize("beside", [False, True])
@pytest.mark.parametrize("source", ["IIOF0", "TINT0"])
def test_a_halted_channel_keeps_an_event_whatever_other_channels_do(source: str, beside: bool) -> None:
    chip, _ = idle_chip()
    control = STOP_AT_END | SYNC_READ
    copy(chip, 0, BLOCK0, BLOCK1, 4, RUN | control)
    if beside:
        copy(chip, 1, BLOCK0, BLOCK1 + 0x40, 4, RUN | control)
    chip.set("DIE", 2 if source == "IIOF0" else 3)
    chip.set("IIF", 1)
    chip.poke(CONTROL, HALT | control)
    if source == "IIOF0":
        chip.raise_iiof(0)
    else:
        chip.poke(0x100028, 20)
        chip.poke(0x100020, 0x2C0)
        chip.run(50)
        chip.poke(0x100020, 0)  # after one event
    assert chip.get("IIF") == 1 and chip.peripheral("DMA0.counter") == 4
    chip.poke(CONTROL, RUN | control)
    settled(chip)
    assert (chip.peripheral("DMA0.counter"), chip.get("IIF")) == (3, 1)


def test_a_channel_in_reset_leaves_the_event_to_the_processor() -> None:
    chip, _ = idle_chip()
    copy(chip, 0, BLOCK0, BLOCK1, 4, RESET | STOP_AT_END | SYNC_READ)
    chip.set("DIE", 2)
    chip.set("IIF", 1)
    chip.raise_iiof(0)
    assert chip.get("IIF") == 1 | 4


@pytest.mark.parametrize("timer", [0, 1])
@pytest.mark.parametrize("n", range(6))
def test_a_raised_timer_interrupt_goes_where_the_timers_event_would(n: int, timer: int) -> None:
    if n < 2 and timer == 1:
        return  # no code of these channels selects it
    chip = c40.Processor(c40.assemble("        .text\nstart:  b start\n"))
    for offset, value in enumerate([BLOCK0, 1, 4, BLOCK1, 1]):
        chip.memory[CONTROL + 0x10 * n + 1 + offset] = value
    chip.memory[CONTROL + 0x10 * n] = RUN | STOP_AT_END | SYNC_READ
    chip.registers["DIE"] = 3 << 4 * n if n < 2 else 6 + timer << 8 + 6 * (n - 2)
    chip.raise_interrupt(f"TINT{timer}")
    chip.run(50)
    assert (chip.peripheral(f"DMA{n}.counter"), chip.registers["IIF"]) == (3, 0)
    chip.registers["DIE"] = 0
    chip.raise_interrupt(f"TINT{timer}")
    assert chip.registers["IIF"] & 0xFFFFFFFF == (TINT0 if timer == 0 else 1 << 31)


# ---- the auxiliary half ----


@pytest.mark.parametrize("reset", [0, SPLIT | PORT4, SPLIT | PORT4 | RUN, LISTS])
def test_aux_start_00_resets_the_auxiliary_half_with_split_mode_and_without(reset: int) -> None:
    chip, _ = idle_chip()
    split = SPLIT | PORT4 | AUX_RUN
    channel(chip, 1, split | AUX_LISTS | 1 << 9, auxiliary_counter=0, auxiliary_link=FIFO4)
    settled(chip)
    chip.deliver(4, split | AUX_STOP_AT_END)  # the list's first word
    settled(chip)
    chip.poke(CONTROL + 0x17, 5)
    chip.poke(CONTROL + 0x10, reset)
    assert chip.peripheral("DMA1.auxiliary_counter") == 0
    channel(chip, 1, split | AUX_STOP_AT_END, destination=BLOCK1, destination_index=1, auxiliary_counter=2)
    for word in (0xAAA, 0xBBB):
        chip.deliver(4, word)
        settled(chip)
    assert words(chip, BLOCK1, 3) == [0xAAA, 0xBBB, 0]


def split_from_a_list(aux: int) -> Any:
    """A unified channel whose list turns split mode on, with the auxiliary half started."""
    chip, _ = idle_chip()
    unified, auxiliary = 0x300000, 0x300010
    word = SPLIT | PORT4 | HALT | STOP_AT_END | AUX_RUN | aux
    chip.load_words(unified, [word, 0, 0, 0, 0, 0, 0])
    chip.load_words(auxiliary, [AUX_RUN | AUX_STOP_AT_END, BLOCK1, 1, 2, 0])
    channel(chip, 1, RUN | LISTS, counter=0, auxiliary_counter=0, link=unified, auxiliary_link=auxiliary)
    settled(chip)
    return chip


@pytest.mark.parametrize("aux", [AUX_LISTS, 3 << 4])
def test_an_auxiliary_half_that_a_list_starts_begins_with_its_own_list(aux: int) -> None:
    chip = split_from_a_list(aux)
    for word in (0xAAA, 0xBBB):
        chip.deliver(4, word)
        settled(chip)
    assert words(chip, BLOCK1, 3) == [0xAAA, 0xBBB, 0]


def test_a_list_that_ends_split_mode_ends_the_auxiliary_half() -> None:
    chip, _ = idle_chip()
    primary = 0x300000
    chip.load_words(primary, [HALT, 0, 0, 0, 0])
    control = SPLIT | PORT4 | AUX_RUN | AUX_LISTS | 1 << 9
    channel(chip, 1, control, auxiliary_counter=0, auxiliary_link=FIFO4, link=primary, counter=0)
    settled(chip)
    chip.deliver(4, AUX_RUN | AUX_STOP_AT_END)  # its list's first word
    settled(chip)
    chip.poke(CONTROL + 0x10, control | RUN | LISTS)
    settled(chip)
    assert chip.peripheral("DMA1.control") & SPLIT == 0
    channel(
        chip, 1, SPLIT | PORT4 | AUX_RUN | AUX_STOP_AT_END, destination=BLOCK1, destination_index=1, auxiliary_counter=1
    )
    chip.poke(CONTROL + 0x17, 1)
    chip.deliver(4, 0xAAA)
    settled(chip)
    assert words(chip, BLOCK1, 2) == [0xAAA, 0]


# ---- a channel that writes its own control register ----


@pytest.mark.parametrize("last", [STOP_AT_END, HALT | STOP_AT_END])
def test_a_channel_that_stops_itself_has_written_its_word(last: int) -> None:
    chip, _ = idle_chip()
    chip.load_words(BLOCK0, [RUN | STOP_AT_END, last, RUN | STOP_AT_END])
    copy(chip, 0, BLOCK0, CONTROL, 5, RUN | STOP_AT_END, destination_index=0)
    settled(chip)
    assert chip.peripheral("DMA0.control") == last and chip.peripheral("DMA0.source") == BLOCK0 + 2
    assert chip.peripheral("DMA0.counter") == (0 if last == STOP_AT_END else 3)
    copy(chip, 0, BLOCK0 + 1, BLOCK1, 1, RUN | STOP_AT_END)
    settled(chip)
    assert words(chip, BLOCK1, 2) == [last, 0]


# ---- what is told ----


def test_each_start_of_a_half_is_told_once(emulator: Path, tmp_path: Path) -> None:
    source = tmp_path / "starts.asm"
    source.write_text(
        """
        .text
        ldhi 10h,ar0
        or 0b0h,ar0       ; channel 1
        ldhi 2fh,r4
        or 0f800h,r4      ; a word is read between START and the next write of it
        sti r4,*+ar0(1)
        ldhi 02h,r0
        or 0c000h,r0      ; split, port 5
        ldhi 0302h,r1
        or 0c000h,r1      ; AUX START 11
        ldhi 0342h,r2
        or 0c000h,r2      ; START 01
        ldhi 03c2h,r3
        or 0c000h,r3      ; START 11
        sti r0,*ar0
        sti r1,*ar0
        sti r1,*ar0
        sti r2,*ar0
        sti r3,*ar0
        sti r3,*ar0
        sti r0,*ar0
        sti r3,*ar0
        sti r0,*ar0
done:   b done
"""
    )
    events = tmp_path / "events"
    subprocess.run([str(emulator), "exec", str(source), "--events", str(events)], check=True, capture_output=True)
    told = [line.split(maxsplit=1)[1] for line in events.read_text().splitlines() if "dma_start" in line]
    assert told == [f"dma_start 1 = {word}" for word in ("0302C000", "03C2C000", "03C2C000")]
