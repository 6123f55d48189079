"""Chips with ports and DMA at work, run with several turn orders: interrupts, DMA channels."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from cmrc import c40
from cmrc.network import Network
from network_programs import STOP, base

VECTORS, STACK = 0x2FFA00, 0x2FFB80
RUN, STOP_AT_END, TCC = 3 << 22, 1 << 2, 1 << 18  # fields of a channel's control word
AUX_RUN, AUX_STOP = 3 << 24, 1 << 4
SYNC, SPLIT = 3 << 6, 1 << 14
ICRDY, OCRDY = 1, 1  # codes of DIE
SEEDS = (0, 1, 7)


def stream_sender(count: int) -> Any:
    """Sends `count` words from 300000h on over port 0."""
    text = "        ldhi 30h,ar1\n        addi 2,ar0\n" + "        ldi *ar1++,r0\n        sti r0,*ar0\n" * count + STOP
    return c40.assemble("        .text\n" + base(0) + text, sections={".text": 0x310000})


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
