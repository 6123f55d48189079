"""The DMA coprocessor: sequences counted by hand, and the statements of c40-hardware.md 3 and 11.5."""

from __future__ import annotations

from typing import Any

import pytest
from dma_chips import BLOCK0, BLOCK1, CODE, RUN, STOP_AT_END, TCC, channel, copy, idle_chip, low


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


def test_without_tcc_the_flag_is_set_and_nothing_is_interrupted() -> None:
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
def test_which_channel_follows_the_one_at_work(first: int, then: list[int]) -> None:
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
