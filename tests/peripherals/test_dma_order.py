"""What happens to the DMA in a cycle comes after what it has begun before: writes of its registers and of DIE, and
events (c40-hardware.md 3.4, 3.8; fidelity.md). Nothing here shares memory, bus or port with the processor, so the
outcome does not depend on what the processor does meanwhile, nor on how the run is cut."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import pytest
from cmrc._core import c40
from dma_chips import BLOCK0, RUN, STOP_AT_END, chip_with

CONTROL, OUTPUT = 0x1000A0, 0x100042
FIXED, SYNC_READ, SYNC_WRITE, SPLIT = 1 << 30, 1 << 6, 1 << 7, 1 << 14
RESET, HALT_WITHIN, HALT = 0, 1 << 22, 2 << 22
SOURCE, DESTINATION = BLOCK0 + 0x100, BLOCK0 + 0x200
TIMER0 = 0x100020


Event = tuple[Any, ...]


def whole(chip: Any, cycles: int) -> None:
    chip.run(cycles)


def in_pieces(chip: Any, cycles: int) -> None:
    for length in itertools.cycle((1, 2, 3, 7)):
        if chip.cycle >= cycles:
            return
        chip.run(min(length, cycles - chip.cycle))


def step_by_step(chip: Any, cycles: int) -> None:
    while chip.cycle < cycles:
        chip.step()


def looked_at(chip: Any, cycles: int) -> None:
    while chip.cycle < cycles:
        chip.run(1)
        chip.peripherals()


def traced(chip: Any, cycles: int) -> None:
    chip.trace(cycles)


WAYS: dict[str, Callable[[Any, int], None]] = {
    function.__name__: function for function in (whole, in_pieces, step_by_step, looked_at, traced)
}


def run(chip: Any, way: str, cycles: int) -> tuple[Any, list[Event]]:
    """The chip at the end, and what its peripherals did. `forked`: each cycle is another chip's, which was given the
    state."""
    chip.record_events()
    if way != "forked":
        WAYS[way](chip, cycles)
        return chip, list(chip.events)
    events: list[Event] = []
    while chip.cycle < cycles:
        before, chip = chip, c40.Processor("default")
        chip.load_state(before.save_state())
        chip.record_events()
        chip.run(1)
        events += chip.events
    return chip, events


EACH_WAY = pytest.mark.parametrize("way", [*WAYS, "forked"])


def describe(chip: Any, n: int, **registers: int) -> None:
    """Sets a channel's registers, all but the control register."""
    for name, value in registers.items():
        offset = ("source", "source_index", "counter", "destination", "destination_index").index(name) + 1
        chip.poke(CONTROL + 0x10 * n + offset, value)


# A fork for each cycle takes time, so it is done beside one of the tails.
WAY_AND_TAIL = pytest.mark.parametrize(
    ("way", "tail"), [*itertools.product(WAYS, ("nops", "rpts", "idle", "loop")), ("forked", "nops")]
)


def started_chip(writes: dict[int, int], tail: str, channels: dict[int, dict[str, int]]) -> Any:
    """A program that stores R0 at AR0 and R1 at AR1, in the cycles that `writes` gives. The channels are described, and
    not started."""
    text, cycle = "", 0
    for at, register in sorted(writes.items()):
        text += "        nop\n" * (at - cycle) + f"        sti r{register},*ar{register}\n"
        cycle = at + 1
    chip, _ = chip_with(text + tail)
    for n, registers in channels.items():
        describe(chip, n, **registers)
    return chip


NOPS, REPEATED, ASLEEP, LOOP = (
    "        nop\n" * 300,
    "        rpts 600\n        nop\n",
    "        idle\n",
    "wait:   bu wait\n",
)
TAILS = {"nops": NOPS, "rpts": REPEATED, "idle": ASLEEP, "loop": LOOP}


def port_writes(events: list[Event]) -> list[tuple[int, int]]:
    """The port, and the cycle."""
    return [(event[2], event[1]) for event in events if event[0] == "port_write"]


# ---- registers ----


def two_channels(k: int, way: str, tail: str) -> list[tuple[int, int]]:
    chip = started_chip(
        {0: 0, k: 1},
        tail,
        {
            5: {"source": SOURCE, "source_index": 1, "counter": 2, "destination": OUTPUT},
            3: {"source": SOURCE + 8, "source_index": 1, "counter": 2, "destination": OUTPUT + 0x10},
        },
    )
    chip.set("AR0", CONTROL + 0x50)
    chip.set("AR1", CONTROL + 0x30)
    chip.set("R0", RUN | STOP_AT_END)
    chip.set("R1", RUN | STOP_AT_END)
    return port_writes(run(chip, way, 60)[1])


@WAY_AND_TAIL
@pytest.mark.parametrize(
    ("k", "expected"),
    [
        # Channel 5, port 0, reads in 1 and writes in 2; channel 3, port 1, is started in cycle k, and it is its turn.
        (1, [(0, 2), (1, 4), (0, 6), (1, 8)]),
        (2, [(0, 3), (1, 5), (0, 7), (1, 9)]),  # the write of START takes the peripheral bus in 2
        (3, [(0, 2), (0, 4), (1, 6), (1, 8)]),  # channel 3 may begin in 4, so channel 5 continues in 3
        (5, [(0, 2), (0, 4), (1, 7), (1, 9)]),
    ],
)
def test_a_channel_that_is_started_beside_another_comes_after_what_that_has_begun(
    k: int, expected: list[tuple[int, int]], way: str, tail: str
) -> None:
    assert two_channels(k, way, TAILS[tail]) == expected


COPY = {"source": SOURCE, "source_index": 1, "counter": 9, "destination": DESTINATION, "destination_index": 1}
WORDS = list(range(100, 109))


@EACH_WAY
@pytest.mark.parametrize("control", [RESET, HALT_WITHIN, HALT])
@pytest.mark.parametrize("k", range(1, 9))
def test_a_halt_comes_after_the_access_of_the_cycle_before(k: int, control: int, way: str) -> None:
    """Started in cycle 0, the channel reads in odd cycles and writes in even ones."""
    chip = started_chip({0: 0, k: 1}, NOPS, {0: COPY})
    chip.load_words(SOURCE, WORDS)
    chip.set("AR0", CONTROL)
    chip.set("AR1", CONTROL)
    chip.set("R0", RUN | STOP_AT_END)
    chip.set("R1", control | STOP_AT_END)
    chip, _ = run(chip, way, 60)
    read = k // 2  # in cycles before k
    written = max(k - 1, 0) // 2 if control != HALT else read  # HALT: a word that was read is still written
    assert chip.peripheral("DMA0.source") == SOURCE + read
    assert chip.read(DESTINATION, 10) == WORDS[:written] + [0] * (10 - written)
    assert chip.peripheral("DMA0.counter") == (0 if control == RESET else 9 - read)


# ---- events and DIE ----


def synchronised(phase: int, tail: str) -> Any:
    """Channel 2 reads a word for each event of timer 0, each 20 cycles; channel 0, which comes first, is busy
    with 18 words from cycle `phase` on. The timer is started in cycle 0."""
    chip = started_chip(
        {0: 0, phase: 1},
        tail,
        {
            0: {**COPY, "counter": 18},
            2: {"source": SOURCE, "counter": 100, "destination": BLOCK0 + 0x300, "destination_index": 1},
        },
    )
    chip.set("AR0", TIMER0)
    chip.set("R0", 0x2C0)
    chip.poke(TIMER0 + 8, 10)
    chip.set("AR1", CONTROL)
    chip.set("R1", RUN | STOP_AT_END | FIXED)
    chip.set("DIE", 6 << 8)  # TIM0 for reads of channel 2
    chip.poke(CONTROL + 0x20, RUN | STOP_AT_END | SYNC_READ)
    return chip


@WAY_AND_TAIL
def test_an_event_is_lost_only_if_it_comes_before_the_read_for_the_one_before(way: str, tail: str) -> None:
    """Events in 20, 40, ... 200. Channel 0 has its last write in cycle phase + 36, and then channel 2 reads."""
    for phase in range(2, 24) if way != "forked" else (2, 3, 19, 20, 22, 23):
        chip, _ = run(synchronised(phase, TAILS[tail]), way, 205)
        lost = 3 <= phase < 20 or phase == 23  # the read in cycle 39, or 59, is soon enough
        assert 100 - chip.peripheral("DMA2.counter") == 10 - lost, f"channel 0 is started in cycle {phase}"


def two_that_wait(k: int, tail: str) -> Any:
    """Fixed order. Channel 0, which waits for timer 0 with its read, is started before; channel 4, which has its word
    at once and waits for timer 0 with its write, in cycle k. The event is in cycle 40."""
    to_ports = {"source": SOURCE, "source_index": 1, "counter": 1}
    chip = started_chip(
        {0: 0, k: 1},
        tail,
        {0: {**to_ports, "destination": OUTPUT}, 4: {**to_ports, "destination": OUTPUT + 0x10}},
    )
    chip.set("AR0", TIMER0)
    chip.set("R0", 0x2C0)
    chip.poke(TIMER0 + 8, 20)
    chip.set("AR1", CONTROL + 0x40)
    chip.set("R1", RUN | STOP_AT_END | SYNC_WRITE)
    chip.set("DIE", 3 | 6 << 23)
    chip.poke(CONTROL, RUN | STOP_AT_END | FIXED | SYNC_READ)
    return chip


@WAY_AND_TAIL
@pytest.mark.parametrize(
    ("k", "expected"),
    [
        (30, [(0, 41), (1, 42)]),
        (37, [(0, 41), (1, 42)]),  # channel 4 reads in 38, and waits a cycle
        (38, [(1, 40), (0, 42)]),  # it reads in 39, and the event comes at once: the read's own write
        (39, [(0, 41), (1, 43)]),  # in 40 it is the turn of channel 0; channel 4's event was latched by then
    ],
)
def test_channels_that_have_waited_for_an_event_begin_by_their_order(
    k: int, expected: list[tuple[int, int]], way: str, tail: str
) -> None:
    assert port_writes(run(two_that_wait(k, TAILS[tail]), way, 100)[1]) == expected


@EACH_WAY
def test_die_chooses_from_the_cycle_of_its_write_on(way: str) -> None:
    """Channel 2 waits for timer 0, whose events are in cycles 20, 40, ...; a write of DIE in cycle k takes it away."""
    for k in range(10, 70) if way != "forked" else (38, 39, 40, 41):
        chip, _ = chip_with("        sti r0,*ar0\n" + "        nop\n" * (k - 1) + "        ldi 0,die\n" + NOPS)
        describe(chip, 0, **{**COPY, "counter": 30})
        describe(chip, 2, source=SOURCE, counter=100, destination=BLOCK0 + 0x300, destination_index=1)
        chip.set("AR0", TIMER0)
        chip.set("R0", 0x2C0)
        chip.poke(TIMER0 + 8, 10)
        chip.set("DIE", 6 << 8)
        chip.poke(CONTROL, RUN | STOP_AT_END)
        chip.poke(CONTROL + 0x20, RUN | STOP_AT_END | SYNC_READ)
        chip, _ = run(chip, way, 150)
        events_before = k // 20  # the event of its own cycle comes first
        taken = 100 - chip.peripheral("DMA2.counter")
        # An event in the last two cycles is latched, but its read had not begun.
        assert events_before - 1 <= taken <= events_before, k
        assert k % 20 < 2 or taken == events_before, k
        assert (chip.get("IIF") & 1 << 24 != 0) == (150 // 20 > events_before), k
