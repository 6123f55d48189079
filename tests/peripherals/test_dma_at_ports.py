"""DMA channels at linked ports beside other channels: when they begin to use a port, and the order of two halves."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import pytest
from cmrc.network import Network
from dma_chips import BLOCK0, RUN, STOP_AT_END
from network_programs import program

CHANNELS, TIMER0 = 0x1000A0, 0x100020
INPUT0, OUTPUT3 = 0x100041, 0x100072
PLACE = BLOCK0 + 0x200
LISTS, READ_SYNC, SPLIT, AUX_RUN, AUX_STOP_AT_END = 2 << 2, 1 << 6, 1 << 14, 3 << 24, 1 << 4
PERIOD_US = 0.05
ASLEEP = {"branch": "e:      bu e\n", "idle": "        idle\n"}

Channel = tuple[int, int, int, int, int, int]
"""Control, source, its index, counter, destination, its index."""


def network(reader: str, writer: str, channels: dict[int, Channel], turn_order: int = 0) -> Network:
    """A link from port 3 of chip 1 to port 0 of chip 0, whose program starts channel n by storing Rn at ARn. In the
    writer, R1 is a word and AR0 the output FIFO."""
    made = Network(
        [program(reader), program(writer)], links=["0.0:1.3"], record_peripherals=True, turn_order=turn_order
    )
    chip, other = made.chips
    other.registers["AR0"], other.registers["R1"] = OUTPUT3, 5
    for n, registers in channels.items():
        chip.memory[CHANNELS + 0x10 * n + 1 : CHANNELS + 0x10 * n + 6] = registers[1:]
        chip.registers[f"R{n}"], chip.registers[f"AR{n}"] = registers[0], CHANNELS + 0x10 * n
    return made


def cycles(made: Network, kind: str, channel: int) -> list[int]:
    return [event.cycle for event in made.peripheral_events if event.kind == kind and event.channel == channel]


# ---- a channel comes to a port ----

COPY: Channel = (RUN | STOP_AT_END, BLOCK0, 1, 60, BLOCK0 + 0x100, 1)
FROM_PORT: Channel = (RUN | STOP_AT_END, INPUT0, 0, 3, PLACE, 1)
THREE_WORDS = "        nop\n" * 20 + "        sti r1,*ar0\n" * 3 + ASLEEP["branch"]


def by_its_start(asleep: str, turn_order: int) -> Network:
    text = "        sti r1,*ar1\n        nop\n        nop\n        sti r0,*ar0\n" + asleep
    return network(text, THREE_WORDS, {0: FROM_PORT, 1: COPY}, turn_order)


def by_an_event(asleep: str, turn_order: int) -> Network:
    """DIE makes the port an event of a channel that moves other words."""
    text = "        sti r1,*ar1\n        sti r0,*ar0\n        nop\n        nop\n        ldi 1,die\n" + asleep
    channel = (RUN | STOP_AT_END | READ_SYNC, BLOCK0, 0, 3, PLACE, 1)
    return network(text, THREE_WORDS, {0: channel, 1: COPY}, turn_order)


def by_its_list(asleep: str, turn_order: int) -> Network:
    text = "        sti r1,*ar1\n        sti r0,*ar0\n" + asleep
    made = network(text, THREE_WORDS, {0: (RUN | LISTS, BLOCK0, 1, 2, PLACE + 0x80, 1), 1: COPY}, turn_order)
    made.chips[0].memory[CHANNELS + 6] = PLACE + 0x40
    made.chips[0].memory[PLACE + 0x40 : PLACE + 0x47] = [*FROM_PORT, 0]
    return made


def by_another_channel(asleep: str, turn_order: int) -> Network:
    """Channel 2 writes the control register of channel 0."""
    text = "        sti r1,*ar1\n        sti r2,*ar2\n" + asleep
    starter = (RUN | STOP_AT_END, PLACE + 0x40, 0, 1, CHANNELS, 0)
    made = network(text, THREE_WORDS, {0: FROM_PORT, 1: COPY, 2: starter}, turn_order)
    made.chips[0].memory[PLACE + 0x40] = FROM_PORT[0]
    return made


def by_its_index(asleep: str, turn_order: int) -> Network:
    """The first word comes from memory, the second from the port."""
    text = "        sti r1,*ar1\n        sti r0,*ar0\n" + asleep
    channel = (RUN | STOP_AT_END, BLOCK0, INPUT0 - BLOCK0 & 0xFFFFFFFF, 2, PLACE, 1)
    return network(text, THREE_WORDS, {0: channel, 1: COPY}, turn_order)


WAYS = [by_its_start, by_an_event, by_its_list, by_another_channel, by_its_index]


@pytest.mark.parametrize("asleep", ASLEEP)
@pytest.mark.parametrize("way", WAYS, ids=[way.__name__ for way in WAYS])
def test_a_channel_that_comes_to_a_port_takes_its_turn_beside_another_one(way: Any, asleep: str) -> None:
    outcomes = []
    for turn_order, pause in [(0, 0.0), (1, 0.0), (0, PERIOD_US)]:
        made = way(ASLEEP[asleep], turn_order)
        for n in range(1, 200 if pause else 1):
            made.run(until_us=n * pause)
        stop = made.run(until_us=100)
        events = [(e.time_ps, e.chip, e.kind, e.number, e.value) for e in made.peripheral_events]
        outcomes.append((stop.reason, stop.time_ps, events, made.chips[0].memory[PLACE : PLACE + 3]))
    assert all(outcome == outcomes[0] for outcome in outcomes)
    ends = {e.number: e.cycle for e in made.peripheral_events if e.kind == "dma_end"}
    assert ends[0] < 60 < ends[1]  # the words are there after 30 cycles, the copy takes 120


@pytest.mark.parametrize("watched", ["--trace", "--profile", "--check"])
def test_what_is_watched_changes_nothing(emulator: Path, tmp_path: Path, watched: str) -> None:
    """Registers that a program has to set: channel 1 copies 60 words, channel 0 takes three from port 0."""
    stores = ""
    for n, registers in enumerate((FROM_PORT, COPY)):
        for offset, value in enumerate(registers[1:], 1):
            stores += f"        ldhi 0{value >> 16:x}h,r0\n        or 0{value & 0xFFFF:x}h,r0\n"
            stores += f"        sti r0,*+ar0({0x10 * n + offset})\n"
    start = f"        ldhi 0{RUN >> 16:x}h,r0\n        or {STOP_AT_END},r0\n"
    start += "        sti r0,*+ar0(10h)\n        nop\n        nop\n        sti r0,*ar0\n"
    base = "        .text\n        ldhi 10h,ar0\n        or 0{:x}h,ar0\n"
    (tmp_path / "a.asm").write_text(base.format(CHANNELS & 0xFFFF) + stores + start + ASLEEP["branch"])
    (tmp_path / "b.asm").write_text(base.format(OUTPUT3 & 0xFFFF) + "        nop\n" * 30 + THREE_WORDS)
    said = []
    for more in ([], [watched, tmp_path / "trace"] if watched == "--trace" else [watched]):
        command = [emulator, "exec", tmp_path / "a.asm", tmp_path / "b.asm", "--link", "0.0:1.3"]
        subprocess.run([*command, "--events", tmp_path / "events", *more], check=True, capture_output=True, timeout=60)
        said.append((tmp_path / "events").read_text())
    assert said[0] == said[1]


# ---- two halves of a channel ----


@pytest.mark.parametrize("others", range(4))
def test_halves_take_turns_whatever_is_served_in_between(others: int) -> None:
    """Eight words wait in the input FIFO, and the primary half has words to send."""
    text = "        rpts 200\n        nop\n" + "".join(f"        sti r{n},*ar{n}\n" for n in range(others + 1))
    split = RUN | AUX_RUN | STOP_AT_END | AUX_STOP_AT_END | SPLIT
    channels: dict[int, Channel] = {0: (split, BLOCK0, 1, 8, PLACE, 1)}
    channels |= {n: (RUN | STOP_AT_END, BLOCK0, 0, 1000, PLACE + 0x40 + n, 0) for n in range(1, others + 1)}
    made = network(text + ASLEEP["branch"], "        sti r1,*ar0\n" * 8 + ASLEEP["branch"], channels)
    made.chips[0].memory[CHANNELS + 7] = 8
    made.run(until_us=200)
    sent, taken = cycles(made, "port_write", 0), cycles(made, "port_read", 0)
    assert len(sent) == len(taken) == 8
    assert sorted([*sent, *taken]) == [cycle for pair in zip(sent, taken, strict=True) for cycle in pair]


S = STOP_AT_END | AUX_STOP_AT_END | READ_SYNC | SPLIT
HALT = 2 << 22


@pytest.mark.parametrize(
    ("writes", "latched"),
    [
        ({3: S | AUX_RUN, 150: S | AUX_RUN}, True),  # the primary half is in reset all the time
        ({3: S | AUX_RUN | HALT, 150: S | AUX_RUN}, True),  # the primary half is reset
        ({3: S | AUX_RUN | HALT, 150: S | HALT, 160: S | AUX_RUN | HALT}, False),  # the auxiliary half is reset
        ({3: S | HALT, 150: S | AUX_RUN | HALT}, False),  # it is in reset when the event comes
    ],
)
def test_a_reset_of_a_half_clears_the_event_that_is_latched_for_it(writes: dict[int, int], latched: bool) -> None:
    """The auxiliary half waits for timer 0, whose events come in cycles 121 and 241, and for a word, which comes in
    between: it is read then, if the first event is still latched."""
    text, at = "", 0
    for n, cycle in enumerate(writes):
        text += "        nop\n" * (cycle - at) + f"        sti r{n},*ar0\n"
        at = cycle + 1
    timer = "        sti r6,*+ar2(8)\n        sti r7,*ar2\n"
    writer = "        nop\n" * 180 + "        sti r1,*ar0\n" + ASLEEP["branch"]
    made = network(timer + text + ASLEEP["branch"], writer, {0: (0, BLOCK0, 1, 5, PLACE, 1)})
    chip = made.chips[0]
    for n, control in enumerate(writes.values()):
        chip.registers[f"R{n}"] = control
    chip.memory[CHANNELS + 7] = 3
    chip.registers["AR2"], chip.registers["R6"], chip.registers["R7"] = TIMER0, 60, 0x2C0
    chip.registers["DIE"] = 3
    made.run(until_us=60)
    assert (cycles(made, "port_read", 0)[0] < 241) is latched
