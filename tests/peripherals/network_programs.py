"""Programs for networks of chips, and what can be read of a network."""

from __future__ import annotations

import random
from typing import Any

from cmrc import c40
from cmrc.network import Network

CODE, DATA, STACK = 0x2FFC00, 0x2FF800, 0x2FFB00
PERIOD_PS = 50_000  # of H1 at 40 MHz
STOP = "end:    bu end\n"
IDLES = "wait:   idle\n        bu wait\n"


def program(text: str) -> Any:
    return c40.assemble("        .text\n" + text, sections={".text": CODE})


def base(port: int, register: str = "ar0") -> str:
    return f"        ldhi 10h,{register}\n        or {0x40 + 0x10 * port:x}h,{register}\n"


def sender(port: int, count: int, first: int = 1) -> str:
    """Writes first, first + 1, ... with stores that follow one another."""
    return base(port) + f"        ldi {first},r0\n" + "        sti r0,*+ar0(2)\n        addi 1,r0\n" * count + STOP


def receiver(port: int, count: int) -> str:
    """Blocking reads, to 2FF800h on."""
    return (
        base(port)
        + "        ldhi 2fh,ar1\n        or 0f800h,ar1\n"
        + "        ldi *+ar0(1),r0\n        sti r0,*ar1++\n" * count
        + STOP
    )


RELAY = """
        ldi 100,r0
        bu FIRST
loop:   ldi *+ar2(1),r0
        addi 1,r0
seed:   sti r0,*+ar0(2)
        bu loop
"""


def state(network: Network) -> tuple[Any, ...]:
    """Everything that can be read of a network, except the order in which its chips were advanced."""
    registers = [{name: chip.registers[name] for name in c40.REGISTERS} for chip in network.chips]
    ports = [chip.port(n) for chip in network.chips for n in range(6)]
    chips = [
        (chip.status, chip.message, chip.pc, chip.cycles, chip.instructions, chip.causes) for chip in network.chips
    ]
    return network.now_ps, registers, ports, chips, network.links, network.events


def check_balance(network: Network) -> None:
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


WORDS = list(range(1000, 1060))


def stream_by_dma(sender_core: Any, receiver_core: Any) -> None:
    """60 words from 2FF800h of one chip through channel 0 and port 0 to 2FF800h of the other, through port 3 and
    channel 3."""
    for n, word in enumerate(WORDS):
        sender_core.poke(DATA + n, word)
    run, stop_at_end = 3 << 22, 1 << 2
    for core, base_address, source, source_index, destination, destination_index, control, die in (
        (sender_core, 0x1000A0, DATA, 1, 0x100042, 0, run | stop_at_end | 1 << 7, 1 << 2),
        (receiver_core, 0x1000D0, 0x100071, 0, DATA, 1, run | stop_at_end | 1 << 18 | 1 << 6, 1 << 14),
    ):
        for offset, value in enumerate((source, source_index, len(WORDS), destination, destination_index), start=1):
            core.poke(base_address + offset, value)
        core.poke(base_address, control)
        core.set("DIE", die)


def interrupt_program(port: int, work: str) -> str:
    """ICRDY of `port` takes a word to 2FFA00h on; the main program is `work`. The vectors are at 2FF800h."""
    vector = 0x0D + 4 * port + 1
    return f"""
        ldhi 2fh,ar7
        or 0fb00h,ar7
        ldi ar7,sp
        ldhi 2fh,ar6
        or 0f800h,ar6
        ldpe ar6,ivtp
        addi {vector},ar6
        ldhi 2fh,r8
        or take & 0ffffh,r8
        sti r8,*ar6
        ldhi 2fh,ar5
        or 0fa00h,ar5
{base(port, "ar2")}        ldi 0,r9
        ldhi {(1 << (2 + 4 * port)) >> 16:x}h,r10
        or {(1 << (2 + 4 * port)) & 0xFFFF:x}h,r10
        ldi r10,iie
        or 2000h,st
{work}
take:   ldi *+ar2(1),r11
        sti r11,*ar5++
        reti
"""


def mixed_network(seed: int) -> Network:
    """A sender with gaps, a chip that is interrupted while it computes, one that idles until interrupted and passes
    words on, and a reader."""
    rng = random.Random(5)
    gaps = "".join(
        "        sti r0,*+ar0(2)\n        addi 1,r0\n" + "        nop\n" * rng.randrange(30) for _ in range(30)
    )
    first = (
        base(0)
        + base(1, "ar1")
        + "        ldi 1,r0\n"
        + gaps.replace("addi 1,r0", "addi 1,r0\n        sti r0,*+ar1(2)")
        + STOP
    )
    busy = interrupt_program(3, "spin:   addi 1,r9\n        mpyi r9,r9\n        bu spin\n")
    idle = interrupt_program(
        4, base(0, "ar4") + "wait:   idle\n        ldi *-ar5(1),r7\n        sti r7,*+ar4(2)\n        bu wait\n"
    )
    last = base(3) + "loop:   ldi *+ar0(1),r0\n        addi r0,r9\n        bu loop\n"
    return Network(
        [program(first), program(busy), program(idle), program(last)],
        links=["0.0:1.3", "0.1:2.4", "2.0:3.3"], clocks_mhz=[40, 50, 60, 33.333], turn_order=seed, record_words=True,
    )  # fmt: skip
