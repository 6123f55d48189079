"""Ports, DMA and interrupts together. Each scenario is counted by hand from c40-hardware.md 2 to 5, and run with
several turn orders."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import pairwise
from typing import Any

import pytest
from cmrc import c40
from cmrc.network import Network
from locations import ROOT
from network_programs import DATA, IDLES, STOP, base, check_balance, program
from scenarios import (
    AUX_RUN,
    AUX_STOP,
    ICRDY,
    OCRDY,
    RUN,
    SPLIT,
    STOP_AT_END,
    SYNC,
    TCC,
    channel,
    die,
    interrupts,
    same_for_every_turn_order,
    stream_sender,
    words_of,
)


def test_split_channels_at_both_ends_saturate_a_link_both_ways() -> None:
    """After each word the token changes sides: each direction moves one word per 2 (5 + 6) = 22 cycles (2.6)."""

    def made(seed: int) -> Network:
        network = Network(
            [program(IDLES)] * 2, links=["0.0:1.3"], turn_order=seed, record_words=True, record_peripherals=True
        )
        for chip, number in ((network.chips[0], 0), (network.chips[1], 3)):
            chip.memory[DATA : DATA + 40] = [1000 * number + i for i in range(40)]
            chip.registers["DIE"] = die(number, ICRDY, OCRDY)
            control = RUN | AUX_RUN | STOP_AT_END | AUX_STOP | SYNC | SPLIT | number << 15
            channel(
                chip,
                number,
                control,
                source=DATA,
                source_index=1,
                counter=40,
                destination=DATA + 0x100,
                destination_index=1,
                auxiliary_counter=40,
            )
        return network

    network = same_for_every_turn_order(made)
    for side in (0, 1):
        assert {b - a for a, b in pairwise(words_of(network, 0, side))} == {22 * 50_000}
    assert network.chips[0].memory[DATA + 0x100 : DATA + 0x128] == [3000 + i for i in range(40)]
    assert network.chips[1].memory[DATA + 0x100 : DATA + 0x128] == list(range(40))
    assert [
        chip.fields(f"DMA{n}.control")["AUX TCINT FLAG"] for chip, n in zip(network.chips, (0, 3), strict=True)
    ] == [1, 1]
    check_balance(network)


@pytest.mark.parametrize("clocks", [(50, 33.333), (33.333, 60), (40, 50), (60, 30)])
def test_one_word_between_two_clocks(clocks: tuple[float, float]) -> None:
    """Written in the sender's cycle w: seen at w + 1, out of the FIFO at w + 6; readable one cycle of the receiver
    after its next edge."""

    def made(seed: int) -> Network:
        sends = base(0) + "        ldi 5,r0\n        nop\n" + "        sti r0,*+ar0(2)\n" + STOP
        reads = base(3) + "        nop\n        nop\n        ldi *+ar0(1),r1\n" + STOP
        return Network(
            [program(sends), program(reads)],
            links=["0.0:1.3"],
            clocks_mhz=clocks,
            turn_order=seed,
            record_words=True,
            record_peripherals=True,
        )

    network = same_for_every_turn_order(made)
    hertz = [Fraction(round(mhz * 1e6), 2) for mhz in clocks]
    write, read = network.peripheral_events
    assert (write.kind, write.cycle, read.kind) == ("port_write", 4, "port_read")
    out = (write.cycle + 6) * 10**12 / hertz[0]
    assert words_of(network, 0, 0) == [int(out)]
    edge = -(-out * hertz[1] // 10**12)  # the first of the receiver's cycles that begins then or later
    assert read.cycle == edge + 1
    assert network.chips[1].causes["comm_port"] == read.cycle - 4  # it began to wait in cycle 4
    assert network.chips[1].registers["R1"] & 0xFF == 5


def test_icfull_interrupts_when_the_eighth_word_has_come() -> None:
    """The writes come each cycle, so word n is out 5 n + 1 cycles after the first write and readable one later; the
    entry takes 8 (5.5)."""

    def made(seed: int) -> Network:
        sends = base(0) + "        ldi 1,r0\n        nop\n" + "        sti r0,*+ar0(2)\n" * 8 + STOP
        takes = (
            base(3)
            + interrupts(1 << 1 + 4 * 3, 0x0D + 4 * 3)
            + "        idle\n        nop\n"
            + STOP
            + "isr:    ldi *ar0,r1\n        ldi 0,iie\n        reti\n"
        )
        return Network(
            [program(sends), program(takes)],
            links=["0.0:1.3"],
            turn_order=seed,
            record_words=True,
            record_peripherals=True,
        )

    network = same_for_every_turn_order(made)
    first = next(event.cycle for event in network.peripheral_events if event.kind == "port_write")
    taken = [event for event in network.peripheral_events if event.kind == "interrupt"]
    assert [(event.number, event.cycle) for event in taken] == [(0x19, first + 1 + 5 * 8 + 1)]
    assert network.chips[1].registers["R1"] & 0x1E00 == 0x1E00
    assert network.chips[1].causes["interrupt"] == 8
    check_balance(network)


def test_ocempty_interrupts_when_the_last_word_has_been_sent_completely() -> None:
    def made(seed: int) -> Network:
        sends = base(0) + interrupts(0, 0x0D + 3) + "        ldi 1,r0\n        nop\n" + "        sti r0,*+ar0(2)\n" * 3
        sends += "        ldi 10h,iie\n        idle\n        nop\n" + STOP + "isr:    ldi 0,iie\n        reti\n"
        return Network(
            [program(sends), program(STOP)],
            links=["0.0:1.3"],
            turn_order=seed,
            record_words=True,
            record_peripherals=True,
        )

    network = same_for_every_turn_order(made)
    first = next(event.cycle for event in network.peripheral_events if event.kind == "port_write")
    (taken,) = [event for event in network.peripheral_events if event.kind == "interrupt"]
    assert (taken.number, taken.cycle) == (0x10, first + 1 + 5 * 3)
    assert words_of(network, 0, 0)[-1] == taken.time_ps


def test_both_sides_queue_three_words_and_take_turns() -> None:
    """The token is at port 0. Words of both sides alternate: out after 5, then 6 for the token, and 5 again (2.4)."""

    def made(seed: int) -> Network:
        def sends(number: int) -> Any:
            return program(base(number) + "        ldi 1,r0\n        nop\n" + "        sti r0,*+ar0(2)\n" * 3 + STOP)

        return Network(
            [sends(0), sends(3)], links=["0.0:1.3"], turn_order=seed, record_words=True, record_peripherals=True
        )

    network = same_for_every_turn_order(made)
    first = network.peripheral_events[0].cycle
    trace = [(event.kind, event.side, event.time_ps // 50_000 - first - 1) for event in network.events]
    expected, at = [], 0
    for turn in range(6):
        at += 5
        expected.append(("word", turn % 2, at))
        at += 6
        expected.append(("token", 1 - turn % 2, at))
    assert trace == expected[:-1]  # neither side asks for the token after the last word
    check_balance(network)


def test_a_halted_input_channel_stops_the_sender_at_a_words_end() -> None:
    """ICH is set while a word is under way: that one arrives, the next waits until the halt ends (2.4)."""

    def made(seed: int) -> Network:
        sends = base(0) + "        ldi 1,r0\n        nop\n" + "        sti r0,*+ar0(2)\n" * 4 + STOP
        halts = (
            base(3)
            + "        ldi 8,r0\n        ldi 0,r1\n"
            + "        nop\n" * 11
            + "        sti r0,*ar0\n"
            + "        nop\n" * 100
            + "        sti r1,*ar0\n"
            + STOP
        )
        return Network([program(sends), program(halts)], links=["0.0:1.3"], turn_order=seed, record_words=True)

    network = same_for_every_turn_order(made)
    written, halted, resumed = 4, 4 + 11, 4 + 11 + 1 + 100
    cycles = [time // 50_000 for time in words_of(network, 0, 0)]
    # Words are begun 1, 6, 11 cycles after the first write; the halt is seen at its cycle + 1: within the third.
    assert written + 11 < halted + 1 < written + 16
    assert cycles == [written + 6, written + 11, written + 16, resumed + 1 + 5]
    check_balance(network)


def test_a_channel_fed_with_lists_over_a_link_programs_itself() -> None:
    """The guide's example (3.7) with a chip at the other end: list, data, list, data; the last list stops and
    interrupts."""
    goes_on, stops = RUN | 2 << 2 | 1 << 6 | 1 << 8 | 1 << 10, RUN | STOP_AT_END | 1 << 6 | TCC
    stream = [
        goes_on,
        0x100071,
        0,
        5,
        DATA,
        1,
        0x100071,
        *range(5),
        stops,
        0x100071,
        0,
        3,
        DATA + 0x40,
        2,
        0x100071,
        *range(100, 103),
    ]

    def made(seed: int) -> Network:
        takes = interrupts(1 << 28, 0x28) + "        idle\n        nop\n" + STOP + "isr:    addi 1,r7\n        reti\n"
        network = Network(
            [stream_sender(len(stream)), program(takes)],
            links=["0.0:1.3"],
            turn_order=seed,
            record_words=True,
            record_peripherals=True,
        )
        network.chips[0].memory[0x300000 : 0x300000 + len(stream)] = stream
        network.chips[1].registers["DIE"] = die(3, ICRDY, 0)
        channel(network.chips[1], 3, goes_on, counter=0, link=0x100071)
        return network

    network = same_for_every_turn_order(made)
    taker = network.chips[1]
    assert taker.memory[DATA : DATA + 5] == [0, 1, 2, 3, 4] and taker.memory[DATA + 0x40 : DATA + 0x46 : 2] == [
        100,
        101,
        102,
    ]
    assert taker.registers["R7"] & 0xFF == 1 and taker.fields("DMA3.control")["START"] == 2
    reads = [event for event in network.peripheral_events if event.kind == "port_read"]
    assert len(reads) == len(stream) and {event.channel for event in reads} == {3}
    words = words_of(network, 0, 0)
    assert {b - a for a, b in pairwise(words)} == {5 * 50_000}  # lists of 2 cycles a word keep up with the link
    # The last word is readable a cycle after it is out; read, write, and the interrupt is there.
    (taken,) = [event for event in network.peripheral_events if event.kind == "interrupt"]
    assert taken.time_ps == words[-1] + 3 * 50_000
    check_balance(network)


def test_a_timer_lets_a_channel_send_a_word_each_period() -> None:
    """TIM0 releases one read of channel 2 each 120 cycles; its write to the port is not synchronised: a word on the
    link each 120 cycles."""

    def made(seed: int) -> Network:
        network = Network(
            [program(IDLES), program(base(4) + "loop:   ldi *+ar0(1),r0\n        bu loop\n")],
            links=["0.1:1.4"],
            turn_order=seed,
            record_words=True,
        )
        chip = network.chips[0]
        chip.memory[DATA : DATA + 9] = list(range(9))
        chip.registers["DIE"] = die(2, 6, 0)
        channel(
            chip,
            2,
            RUN | STOP_AT_END | 1 << 6,
            source=DATA,
            source_index=1,
            counter=9,
            destination=0x100052,
            destination_index=0,
        )
        chip.memory[0x100028] = 60
        chip.memory[0x100020] = 0x2C0
        return network

    network = same_for_every_turn_order(made, until_us=100)
    words = words_of(network, 0, 0)
    assert len(words) == 9 and {b - a for a, b in pairwise(words)} == {120 * 50_000}
    check_balance(network)


def test_sixty_four_chips_at_their_own_clocks_boot_one_another() -> None:
    """The worm over a grid of 8 x 8 at 40, 50 and 60 MHz: each chip counts itself and the chips that it booted."""
    source = c40.assemble_file(ROOT / "c40_programs" / "examples" / "networks" / "worm.asm", entry="start")

    def made(seed: int) -> Network:
        return Network(
            source,
            topology="grid:8x8",
            boots=range(1, 64),
            clocks_mhz=[(40, 50, 60, 33.333)[(7 * n) % 4] for n in range(64)],
            turn_order=seed,
            record_words=True,
        )

    network = same_for_every_turn_order(made, max_cycles=1_000_000)
    assert all(chip.status == "halt" for chip in network.chips)
    assert network.chips[0].memory[network.chips[0].address("count")] == 64
    check_balance(network)


def test_sixty_four_chips_and_cuts_at_any_instant() -> None:
    """A relay round a torus of 4 x 4 x 4 by blocking reads and writes, links cut in mid-word and restored, chips reset
    and pulled out."""
    relay = (
        base(0)
        + base(3, "ar3")
        + "        ldi 3,rc\n        ldi r0,r4\n        rptb more\n        nop\nmore:   sti r4,*+ar0(2)\nloop:   ldi *+ar3(1),r5\n        sti r5,*+ar0(2)\n        bu loop\n"
    )

    def made(seed: int) -> Network:
        network = Network(program(relay), topology="torus:4x4x4", turn_order=seed, record_words=True)
        rng = random.Random(11)
        for _ in range(60):
            link, at = 3 * rng.randrange(64), rng.uniform(1, 60)
            network.cut(link, at)
            network.restore(link, at + rng.uniform(0.01, 5))
        for n in rng.sample(range(64), 6):
            network.reset(n, rng.uniform(5, 60))
        network.pull_out(17, 50)
        return network

    network = same_for_every_turn_order(made, until_us=80)
    kinds = [event.kind for event in network.events]
    assert kinds.count("lost") > 5 and kinds.count("cut") > 60 and kinds.count("discarded") > 0
    assert {event.count for event in network.events if event.kind == "lost"} >= {0, 1, 2, 3}  # bytes that had crossed
    check_balance(network)
