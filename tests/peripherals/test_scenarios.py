"""Ports, DMA and interrupts together. Each scenario is counted by hand from c40-hardware.md 2 to 5, and run with
several turn orders."""

from __future__ import annotations

import random
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from typing import Any

import pytest
from cmrc import c40
from cmrc.network import Network
from locations import ROOT

CODE, DATA, VECTORS, STACK = 0x2FFC00, 0x2FF800, 0x2FFA00, 0x2FFB80
STOP = "end:    bu end\n"
IDLES = "wait:   idle\n        bu wait\n"
RUN, AUX_RUN, STOP_AT_END, AUX_STOP, TCC, AUX_TCC, SYNC, SPLIT = (
    3 << 22,
    3 << 24,
    1 << 2,
    1 << 4,
    1 << 18,
    1 << 19,
    3 << 6,
    1 << 14,
)
HALTED, AUX_HALTED = 2 << 22, 2 << 24
ICRDY, OCRDY = 1, 1  # codes of DIE
SEEDS = (0, 1, 7)


def program(text: str) -> Any:
    return c40.assemble("        .text\n" + text, sections={".text": CODE})


def port(number: int, register: str = "ar0") -> str:
    return f"        ldhi 10h,{register}\n        or {0x40 + 0x10 * number:x}h,{register}\n"


def interrupts(enabled: int, vector: int) -> str:
    """The stack, and one interrupt whose routine is at `isr`; IDLE sets GIE."""
    return f"""
        ldhi 2fh,ar6
        or 0{STACK & 0xFFFF:x}h,ar6
        ldi ar6,sp
        ldhi 2fh,ar6
        or 0{VECTORS & 0xFFFF:x}h,ar6
        ldpe ar6,ivtp
        addi {vector},ar6
        ldhi 2fh,r8
        or isr & 0ffffh,r8
        sti r8,*ar6
        ldhi 0{enabled >> 16:x}h,r8
        or 0{enabled & 0xFFFF:x}h,r8
        ldi r8,iie
"""


def die(channel: int, read: int, write: int) -> int:
    if channel < 2:
        return (read | write << 2) << 4 * channel
    return (read | write << 3) << 8 + 6 * (channel - 2)


def channel(chip: Any, n: int, control: int, **registers: int) -> None:
    names = (
        "source",
        "source_index",
        "counter",
        "destination",
        "destination_index",
        "link",
        "auxiliary_counter",
        "auxiliary_link",
    )
    for name, value in registers.items():
        chip.memory[0x1000A1 + 0x10 * n + names.index(name)] = value
    chip.memory[0x1000A0 + 0x10 * n] = control


def same_for_every_turn_order(made: Callable[[int], Network], **run: Any) -> Network:
    """The network after its run with seed 0. The runs with other seeds ended in the same state."""
    networks = [made(seed) for seed in SEEDS]
    ends = [network.run(**run) for network in networks]
    assert len({(end.reason, end.time_ps) for end in ends}) == 1
    for network in networks[1:]:
        assert network.event_trace == networks[0].event_trace
        assert [(chip.status, chip.cycles, chip.causes, chip.peripherals) for chip in network.chips] == [
            (chip.status, chip.cycles, chip.causes, chip.peripherals) for chip in networks[0].chips
        ]
    return networks[0]


def words_of(network: Network, place: int, side: int) -> list[int]:
    return [
        event.time_ps for event in network.events if event.kind == "word" and (event.place, event.side) == (place, side)
    ]


def balanced(network: Network) -> None:
    """Words written = words read + in FIFOs + under way + lost + discarded; each loss and each discard is an event."""
    for link in network.links:
        for (chip, number), (other, other_number), traffic in (
            (link.a, link.b, link.forth),
            (link.b, link.a, link.back),
        ):
            mine, theirs = network.chips[chip].port(number), network.chips[other].port(other_number)
            assert mine["written"] == len(mine["output"]) + mine["discarded_output"] + traffic.sent
            assert traffic.sent == traffic.arrived + traffic.under_way + traffic.lost
            assert traffic.arrived == theirs["read"] + len(theirs["input"]) + theirs["discarded_input"]
    lost = sum(traffic.lost for link in network.links for traffic in (link.forth, link.back))
    assert lost == sum(event.kind == "lost" for event in network.events)
    discarded = sum(
        chip.port(n)[f"discarded_{fifo}"] for chip in network.chips for n in range(6) for fifo in ("input", "output")
    )
    assert discarded == sum(event.kind == "discarded" for event in network.events)


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
    balanced(network)


@pytest.mark.parametrize("clocks", [(50, 33.333), (33.333, 60), (40, 50), (60, 30)])
def test_one_word_between_two_clocks(clocks: tuple[float, float]) -> None:
    """Written in the sender's cycle w: seen at w + 1, out of the FIFO at w + 6; readable one cycle of the receiver
    after its next edge."""

    def made(seed: int) -> Network:
        sends = port(0) + "        ldi 5,r0\n        nop\n" + "        sti r0,*+ar0(2)\n" + STOP
        reads = port(3) + "        nop\n        nop\n        ldi *+ar0(1),r1\n" + STOP
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
        sends = port(0) + "        ldi 1,r0\n        nop\n" + "        sti r0,*+ar0(2)\n" * 8 + STOP
        takes = (
            port(3)
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
    balanced(network)


def test_ocempty_interrupts_when_the_last_word_has_been_sent_completely() -> None:
    def made(seed: int) -> Network:
        sends = port(0) + interrupts(0, 0x0D + 3) + "        ldi 1,r0\n        nop\n" + "        sti r0,*+ar0(2)\n" * 3
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
            return program(port(number) + "        ldi 1,r0\n        nop\n" + "        sti r0,*+ar0(2)\n" * 3 + STOP)

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
    balanced(network)


def test_a_halted_input_channel_stops_the_sender_at_a_words_end() -> None:
    """ICH is set while a word is under way: that one arrives, the next waits until the halt ends (2.4)."""

    def made(seed: int) -> Network:
        sends = port(0) + "        ldi 1,r0\n        nop\n" + "        sti r0,*+ar0(2)\n" * 4 + STOP
        halts = (
            port(3)
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
    balanced(network)


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
        sends = (
            port(0)
            + "        ldhi 30h,ar1\n        addi 2,ar0\n"
            + "        ldi *ar1++,r0\n        sti r0,*ar0\n" * len(stream)
            + STOP
        )
        sender = c40.assemble("        .text\n" + sends, sections={".text": 0x310000})
        takes = interrupts(1 << 28, 0x28) + "        idle\n        nop\n" + STOP + "isr:    addi 1,r7\n        reti\n"
        network = Network(
            [sender, program(takes)], links=["0.0:1.3"], turn_order=seed, record_words=True, record_peripherals=True
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
    balanced(network)


def test_a_timer_lets_a_channel_send_a_word_each_period() -> None:
    """TIM0 releases one read of channel 2 each 120 cycles; its write to the port is not synchronised: a word on the
    link each 120 cycles."""

    def made(seed: int) -> Network:
        network = Network(
            [program(IDLES), program(port(4) + "loop:   ldi *+ar0(1),r0\n        bu loop\n")],
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
    balanced(network)


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
    balanced(network)


def test_sixty_four_chips_and_cuts_at_any_instant() -> None:
    """A relay round a torus of 4 x 4 x 4 by blocking reads and writes, links cut in mid-word and restored, chips reset
    and pulled out."""
    relay = (
        port(0)
        + port(3, "ar3")
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
    balanced(network)


@pytest.mark.parametrize("word", [(), (1,), (2, 3)])
def test_boot_streams_that_are_cut_short(word: tuple[int, ...]) -> None:
    stream = [0x3E39FFF0, 0x3E39FFF0, 8, 0x2FFC00, *word]

    def made(seed: int) -> Network:
        sends = (
            port(0)
            + "        ldhi 30h,ar1\n        addi 2,ar0\n"
            + "        ldi *ar1++,r0\n        sti r0,*ar0\n" * len(stream)
            + STOP
        )
        network = Network(
            [c40.assemble("        .text\n" + sends, sections={".text": 0x310000}), program(STOP)],
            links=["0.0:1.3"],
            boots=[1],
            turn_order=seed,
        )
        network.chips[0].memory[0x300000 : 0x300000 + len(stream)] = stream
        return network

    network = same_for_every_turn_order(made)
    chip = network.chips[1]
    assert chip.status == "waiting" and chip.waits_for == 0
    assert chip.message.startswith("waits for a word in input FIFO 3 from chip 0 port 0 since cycle ")
    assert f"(the boot loader, which has taken {len(stream)} words of its stream from port 3)" in chip.message


@pytest.mark.parametrize(("destination", "message"), [
    (0x200000, "write to 00200000h, which is reserved on board default"),
    (0x800, "write to 00000800h, which is in the boot ROM"),
    (0x100010, "analysis block"),
])  # fmt: skip
def test_boot_streams_that_name_memory_that_is_not_there(destination: int, message: str) -> None:
    stream = [0x3E39FFF0, 0x3E39FFF0, 1, destination, 7]
    sends = (
        port(0)
        + "        ldhi 30h,ar1\n        addi 2,ar0\n"
        + "        ldi *ar1++,r0\n        sti r0,*ar0\n" * len(stream)
        + STOP
    )
    network = Network(
        [c40.assemble("        .text\n" + sends, sections={".text": 0x310000}), program(STOP)],
        links=["0.0:1.3"],
        boots=[1],
    )
    network.chips[0].memory[0x300000 : 0x300000 + len(stream)] = stream
    assert network.run().reason == "ended"
    chip = network.chips[1]
    assert chip.status == "fault" and message in chip.message
    assert "(the boot loader, which has taken 5 words of its stream from port 3)" in chip.message
    assert "board default has RAM from 002FF800h, 00300000h, 40000000h, 80000000h on" in chip.message


@pytest.mark.parametrize(("destination", "status", "message"), [
    (0x200000, "fault", "DMA channel 4: write to 00200000h, which is reserved on board default"),
    (0x100010, "fault", "DMA channel 4: write to 00100010h, which is a register of the analysis block"),
    (0x70000000, "external_access", "DMA channel 4 writes 70000000h"),
])  # fmt: skip
def test_dma_into_nothing(destination: int, status: str, message: str) -> None:
    network = Network([program(IDLES), program(STOP)], links=["0.0:1.3"])
    channel(
        network.chips[0],
        4,
        RUN | STOP_AT_END,
        source=DATA,
        source_index=1,
        counter=3,
        destination=destination,
        destination_index=1,
    )
    assert network.run().reason == "ended"
    assert network.chips[0].status == status and message in network.chips[0].message


def test_names_of_registers_that_do_not_exist() -> None:
    chip = Network([program(STOP)]).chips[0]
    for ask in (chip.peripheral, chip.fields):
        with pytest.raises(IndexError, match=r"DMA7\.counter.*DMA\d\.counter"):
            ask("DMA7.counter")
    with pytest.raises(KeyError, match="no register is called R12"):
        chip.registers["R12"]
