"""The DMA coprocessor: sequences counted by hand, and the statements of c40-hardware.md 3 and 11.5."""

from __future__ import annotations

import itertools
import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
from cmrc._core import c40, toolchain
from linked_processors import HERTZ, Network, processor

PERIOD = 10**12 // HERTZ
BLOCK0, BLOCK1 = 0x2FF800, 0x2FFC00
CODE = 0x2FFD00
TABLE = 0x2FFA00
CONTROL, SOURCE, SOURCE_INDEX, COUNTER, DESTINATION, DESTINATION_INDEX, LINK, AUX_COUNTER, AUX_LINK = range(9)

RUN, STOP_AT_END, TCC = 3 << 22, 1 << 2, 1 << 18
IDLE = "wait:   idle\n        bu wait\nisr:    addi 1,r2\n        reti\n"


def chip_with(text: str, board: str = "default", at: int = CODE) -> tuple[Any, Any]:
    image = toolchain.assemble("        .text\n" + text, "dma.asm", sections={".text": at})
    chip = c40.Processor(board)
    chip.load_image(image)
    chip.pc = at
    chip.set("SP", 0x2FFB00)
    chip.set("IVTP", TABLE)
    return chip, image


def channel(chip: Any, n: int, control: int, **registers: int) -> None:
    base = 0x1000A0 + 0x10 * n
    names = {
        "source": 1,
        "source_index": 2,
        "counter": 3,
        "destination": 4,
        "destination_index": 5,
        "link": 6,
        "auxiliary_counter": 7,
        "auxiliary_link": 8,
    }
    for name, value in registers.items():
        chip.poke(base + names[name], value & 0xFFFFFFFF)
    chip.poke(base, control)


def copy(
    chip: Any, n: int, source: int, destination: int, count: int, control: int = RUN | STOP_AT_END | TCC, **more: int
) -> None:
    settings = {
        "source_index": 1,
        "destination_index": 1,
        "source": source,
        "destination": destination,
        "counter": count,
    } | more
    channel(chip, n, control, **settings)


def low(chip: Any, name: str) -> int:
    return int(chip.get(name)) & 0xFFFFFFFF


def idle_chip(at: int = CODE) -> tuple[Any, Any]:
    chip, image = chip_with(IDLE, at=at)
    for n in range(6):
        chip.poke(TABLE + 0x25 + n, image.symbols["isr"])
    return chip, image


@pytest.mark.parametrize("count", [1, 2, 10, 100])
@pytest.mark.parametrize("number", range(6))
def test_on_chip_copy_takes_two_cycles_a_word(number: int, count: int) -> None:
    chip, _ = idle_chip()
    chip.run(20)
    words = [0x1000 + 3 * i for i in range(count)]
    chip.load_words(BLOCK0, words)
    chip.set("IIE", 1 << 25 + number)
    start = chip.cycle
    copy(chip, number, BLOCK0, BLOCK1, count)
    name = f"DMA{number}."
    assert chip.dma_active
    chip.run(1 + 2 * count - 1)
    assert chip.idle and chip.peripheral(name + "counter") == (1 if count == 0 else 0)
    assert chip.peripheral(name + "control") >> 22 & 3 == 3
    assert chip.peripheral(name + "control") >> 26 & 3 == 3  # STATUS: busy
    chip.run(1)
    assert not chip.idle and chip.cycle == start + 1 + 2 * count
    control = chip.peripheral(name + "control")
    assert (control >> 22 & 3, control >> 20 & 1, control >> 26 & 3) == (2, 1, 0)
    assert [chip.peek(BLOCK1 + i) for i in range(count)] == words
    assert chip.get("IIF") == 1 << 25 + number
    assert not chip.dma_active
    chip.set("ST", 0x2000)
    chip.run(30)
    assert low(chip, "R2") == 1 and chip.get("IIF") == 0
    assert sum(chip.causes.values()) == chip.cycle


def test_without_tcc_the_flag_is_set_and_nobody_is_told() -> None:
    chip, _ = idle_chip()
    copy(chip, 3, BLOCK0, BLOCK1, 4, RUN | STOP_AT_END)
    chip.run(50)
    assert chip.peripheral("DMA3.control") >> 20 & 1 and chip.get("IIF") == 0


def test_indices_step_both_ways_and_by_reversed_carry() -> None:
    chip, _ = idle_chip()
    chip.load_words(BLOCK0, list(range(100, 116)))
    copy(chip, 0, BLOCK0 + 15, BLOCK1, 8, source_index=-2, destination_index=3)
    chip.run(60)
    assert [chip.peek(BLOCK1 + 3 * i) for i in range(8)] == [115 - 2 * i for i in range(8)]
    copy(chip, 0, BLOCK0, BLOCK1 + 0x40, 16, RUN | STOP_AT_END | 1 << 12, source_index=8)
    chip.run(60)
    assert [chip.peek(BLOCK1 + 0x40 + i) for i in range(16)] == [100 + int(f"{i:04b}"[::-1], 2) for i in range(16)]


@pytest.mark.parametrize(
    ("source", "destination", "first", "each"),
    [
        (0x300000, BLOCK0, 2, 2),  # external, no waits, to on chip
        (0x40000000, BLOCK0, 3, 3),  # one wait state
        (BLOCK0, 0x300000, 3, 3),
        (BLOCK0, 0x40000000, 4, 4),
        (0x300000, 0x80000000, 3, 3),  # two buses
        (0x300000, 0x300100, 3, 4),  # one bus: the read comes right after a write
    ],
)
def test_cost_of_a_word_by_place(source: int, destination: int, first: int, each: int) -> None:
    for count in (1, 7):
        chip, _ = idle_chip()
        chip.run(20)
        chip.set("IIE", 1 << 25)
        start = chip.cycle
        copy(chip, 0, source, destination, count)
        while chip.idle:
            chip.run(1)
        assert chip.cycle - start == 1 + first + (count - 1) * each


def test_channels_take_turns_or_go_by_number() -> None:
    for fixed in (False, True):
        chip, _ = idle_chip()
        chip.run(20)
        for n in (2, 4, 0):
            channel(
                chip,
                n,
                RUN | STOP_AT_END | (fixed << 30 if n == 0 else 0),
                source=BLOCK0,
                counter=3,
                destination=BLOCK1 + 8 * n,
                destination_index=1,
            )
        order: list[int] = []
        for _ in range(40):
            before = [chip.peripheral(f"DMA{n}.counter") for n in range(6)]
            chip.run(1)
            after = [chip.peripheral(f"DMA{n}.counter") for n in range(6)]
            order += [n for n in range(6) if before[n] != after[n]]
        assert order == ([0, 0, 0, 2, 2, 2, 4, 4, 4] if fixed else [0, 2, 4] * 3)


def served(chip: Any, cycles: int) -> list[int]:
    """The channels in the order in which their words were read."""
    order: list[int] = []
    for _ in range(cycles):
        before = [chip.peripheral(f"DMA{n}.counter") for n in range(6)]
        chip.run(1)
        after = [chip.peripheral(f"DMA{n}.counter") for n in range(6)]
        order += [n for n in range(6) if before[n] > after[n]]
    return order


@pytest.mark.parametrize("channels", [(0, 2, 5), (1, 4), (5, 0), (3,), (0, 1, 2, 3, 4, 5)])
def test_the_channel_served_last_comes_last_over_gaps_too(channels: tuple[int, ...]) -> None:
    """Rotating priority is cyclic in the order 0, 1, ... 5, also with some channels left out (c40-hardware.md 3.4)."""
    chip, _ = idle_chip()
    chip.run(20)
    for n in channels:
        channel(chip, n, RUN | STOP_AT_END, source=BLOCK0, counter=4, destination=BLOCK1 + 8 * n, destination_index=1)
    assert served(chip, 80) == sorted(channels) * 4


@pytest.mark.parametrize(
    ("first", "then"), [(2, [2, 5, 0, 2, 5, 0, 2]), (0, [0, 2, 5, 0, 2, 5, 0]), (5, [5, 0, 2, 5, 0, 2, 5])]
)
def test_who_comes_in_behind_the_channel_at_work(first: int, then: list[int]) -> None:
    """Channel `first` moves its first word when the two others start. The next higher channel follows; after 5 comes
    0."""
    chip, _ = idle_chip()
    chip.run(20)
    settings = {"source": BLOCK0, "destination_index": 1}
    channel(chip, first, RUN | STOP_AT_END, counter=3, destination=BLOCK1 + 8 * first, **settings)
    chip.run(2)
    assert chip.peripheral(f"DMA{first}.counter") == 2
    for n in {0, 2, 5} - {first}:
        channel(chip, n, RUN | STOP_AT_END, counter=2, destination=BLOCK1 + 8 * n, **settings)
    assert [first, *served(chip, 60)] == then


def test_autoinitialisation_chain_in_memory() -> None:
    chip, _ = idle_chip()
    chip.load_words(BLOCK0, list(range(1, 31)))
    lists = 0x300000
    more, last = RUN | 2 << 2, RUN | STOP_AT_END | TCC
    chip.load_words(lists, [more, BLOCK0, 1, 10, BLOCK1, 1, lists + 7])
    chip.load_words(lists + 7, [more, BLOCK0 + 10, 1, 5, BLOCK1 + 0x20, 1, lists + 14])
    chip.load_words(lists + 14, [last, BLOCK0 + 15, 1, 3, BLOCK1 + 0x40, 1, 0x1234])
    chip.run(20)
    chip.set("IIE", 1 << 27)
    start = chip.cycle
    channel(chip, 2, more, counter=0, link=lists)
    while chip.idle:
        chip.run(1)
    assert chip.cycle - start == 1 + 3 * 14 + 2 * (10 + 5 + 3)
    assert [chip.peek(BLOCK1 + i) for i in range(11)] == [*range(1, 11), 0]
    assert [chip.peek(BLOCK1 + 0x20 + i) for i in range(6)] == [*range(11, 16), 0]
    assert [chip.peek(BLOCK1 + 0x40 + i) for i in range(4)] == [16, 17, 18, 0]
    assert chip.peripheral("DMA2.link") == 0x1234


def test_autoinitialisation_on_restart_waits_for_the_processor() -> None:
    chip, _ = idle_chip()
    lists = 0x300000
    chip.load_words(lists, [RUN | STOP_AT_END, BLOCK0, 1, 4, BLOCK1 + 8, 1, 0])
    chip.load_words(BLOCK0, [7, 8, 9, 10])
    copy(chip, 1, BLOCK0, BLOCK1, 2, RUN | 3 << 2, link=lists)
    chip.run(100)
    assert chip.peripheral("DMA1.control") >> 22 & 3 == 2
    assert [chip.peek(BLOCK1 + i) for i in (0, 1, 8)] == [7, 8, 0]
    chip.poke(0x1000B0, RUN | 3 << 2)
    chip.run(100)
    assert [chip.peek(BLOCK1 + 8 + i) for i in range(4)] == [7, 8, 9, 10]


def test_the_guides_example_a_channel_fed_from_its_port() -> None:
    chip, _ = idle_chip()
    chip.run(20)
    chip.poke(0x1000A6, 0x100041)
    chip.poke(0x1000A0, 0x0004054B)
    chip.poke(0x1000A3, 0)
    chip.set("DIE", 1)
    chip.set("IIE", 1 << 25)
    chip.poke(0x1000A0, 0x00C4054B)
    stream = [0x00C4054B, 0x100041, 0, 4, 0x2FF800, 1, 0x100041, 11, 12, 13, 14]
    stream += [0x00C40047, 0x100041, 0, 32, 0x2FF810, 1, 0x100041, *range(100, 132)]
    for word in stream:
        assert chip.run(9)["reason"] == "limit"
        chip.deliver(0, word)
    chip.run(10)
    assert [chip.peek(0x2FF800 + i) for i in range(5)] == [11, 12, 13, 14, 0]
    assert [chip.peek(0x2FF810 + i) for i in range(33)] == [*range(100, 132), 0]
    assert chip.peripheral("DMA0.control") >> 22 & 3 == 2


def test_split_mode_serves_both_directions() -> None:
    chip, _ = idle_chip()
    chip.run(20)
    chip.load_words(BLOCK0, list(range(50, 60)))
    split = 1 << 14 | 4 << 15 | 3 << 22 | 3 << 24 | 1 << 2 | 1 << 4 | 1 << 19
    chip.set("IIE", 1 << 25 + 1)
    channel(
        chip,
        1,
        split,
        source=BLOCK0,
        source_index=1,
        counter=10,
        destination=BLOCK1,
        destination_index=1,
        auxiliary_counter=5,
    )
    got = []
    for i in range(5):
        chip.run(10)
        while chip.port(4)["output"]:
            got.append(chip.collect(4))
        chip.deliver(4, 900 + i)
    chip.run(40)
    while chip.port(4)["output"]:
        got.append(chip.collect(4))
    assert got == list(range(50, 60))
    assert [chip.peek(BLOCK1 + i) for i in range(6)] == [900, 901, 902, 903, 904, 0]
    control = chip.peripheral("DMA1.control")
    assert (control >> 22 & 3, control >> 24 & 3, control >> 20 & 3) == (2, 2, 3)
    assert low(chip, "R2") == 1  # AUX TCC


def test_an_auxiliary_half_works_while_the_primary_one_is_in_reset() -> None:
    chip, _ = idle_chip()
    chip.run(20)
    auxiliary_alone = 1 << 14 | 4 << 15 | 3 << 24 | 1 << 4
    channel(
        chip,
        1,
        auxiliary_alone,
        source=BLOCK0,
        source_index=1,
        counter=10,
        destination=BLOCK1,
        destination_index=1,
        auxiliary_counter=2,
    )
    for word in (900, 901):
        chip.run(10)
        chip.deliver(4, word)
    chip.run(40)
    assert [chip.peek(BLOCK1 + i) for i in range(3)] == [900, 901, 0]
    assert not chip.port(4)["output"]


def test_a_full_output_fifo_holds_the_channel_and_lets_others_pass() -> None:
    chip, _ = idle_chip()
    copy(chip, 0, BLOCK0, 0x100042, 20, RUN | STOP_AT_END, destination_index=0)
    chip.run(100)
    assert (
        len(chip.port(0)["output"]) == 8 and chip.peripheral("DMA0.counter") == 11
    )  # the ninth word is in the channel
    chip.load_words(BLOCK0, [1, 2, 3])
    copy(chip, 5, BLOCK0, BLOCK1, 3)
    chip.run(20)
    assert [chip.peek(BLOCK1 + i) for i in range(3)] == [1, 2, 3]


def test_halt_and_resume() -> None:
    chip, _ = idle_chip()
    chip.run(20)
    chip.load_words(BLOCK0, list(range(1, 21)))
    copy(chip, 0, BLOCK0, BLOCK1, 20, RUN | STOP_AT_END)
    chip.run(8)  # three words written, the fourth read
    assert chip.peripheral("DMA0.counter") == 16
    chip.poke(0x1000A0, 1 << 22 | STOP_AT_END)
    chip.run(20)
    assert chip.peripheral("DMA0.control") >> 26 & 3 == 1  # held within a word
    assert [chip.peek(BLOCK1 + i) for i in range(4)] == [1, 2, 3, 0]
    chip.poke(0x1000A0, 2 << 22 | STOP_AT_END)
    chip.run(20)
    assert chip.peripheral("DMA0.control") >> 26 & 3 == 0
    assert [chip.peek(BLOCK1 + i) for i in range(5)] == [1, 2, 3, 4, 0]
    chip.poke(0x1000A0, RUN | STOP_AT_END)
    chip.run(60)
    assert [chip.peek(BLOCK1 + i) for i in range(21)] == [*range(1, 21), 0]


def test_reset_of_the_chip_ends_a_block_that_is_under_way() -> None:
    chip, _ = idle_chip()
    chip.run(20)
    chip.load_words(BLOCK0, list(range(1, 101)))
    copy(chip, 0, BLOCK0, BLOCK1, 100)
    chip.run(1 + 2 * 30)
    assert chip.dma_active and [chip.peek(BLOCK1 + i) for i in (28, 40)] == [29, 0]
    chip.reset()
    assert not chip.dma_active
    chip.pc = CODE
    chip.run(500)
    assert not chip.dma_active and chip.idle and chip.peek(BLOCK1 + 40) == 0


def test_reset_of_a_channel_discards_the_word_that_it_holds() -> None:
    chip, _ = idle_chip()
    chip.run(20)
    chip.load_words(BLOCK0, list(range(1, 21)))
    copy(chip, 0, BLOCK0, BLOCK1, 20, RUN | STOP_AT_END)
    chip.run(8)
    chip.poke(0x1000A0, STOP_AT_END)
    chip.run(20)
    assert (chip.peripheral("DMA0.control") >> 22, chip.peripheral("DMA0.counter"), chip.peek(BLOCK1 + 3)) == (0, 0, 0)


def test_a_timer_paces_a_channel() -> None:
    chip, _ = idle_chip()
    chip.load_words(BLOCK0, list(range(1, 9)))
    copy(chip, 2, BLOCK0, BLOCK1, 8, RUN | STOP_AT_END | 1 << 6)
    chip.set("DIE", 6 << 8)
    chip.poke(0x100028, 50)
    chip.poke(0x100020, 0x2C0)
    start = chip.cycle
    for n in range(1, 5):
        chip.run(start + 100 * n - chip.cycle)
        assert chip.peripheral("DMA2.counter") == 8 - (n - 1)
        chip.run(3)
        assert chip.peripheral("DMA2.counter") == 8 - n
    assert chip.get("IIF") & 1 << 24 == 0  # the DMA latched it


def test_an_iiof_edge_releases_one_read_and_one_write() -> None:
    chip, _ = idle_chip()
    chip.set("IIF", 1 << 8)  # IIOF2: interrupt pin, edge
    copy(chip, 3, BLOCK0, BLOCK1, 8, RUN | STOP_AT_END | 1 << 6 | 1 << 7)
    chip.set("DIE", 4 << 14 | 4 << 17)
    chip.run(30)
    assert chip.peripheral("DMA3.counter") == 8
    for n in range(1, 4):
        chip.raise_iiof(2)
        chip.run(10)
        assert chip.peripheral("DMA3.counter") == 8 - n
        assert chip.peripheral("DMA3.control") >> 26 & 3 == 3


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
