"""A chip whose DMA, or whose processor beside it, is at a window: how a run is cut, the order of turns and the way in
which a program is run change nothing, and every run ends."""

from __future__ import annotations

from typing import Any

import pytest
from cmrc import c40
from cmrc.network import Network, SharedMemory
from hang_guard import within

SHARED, OTHER = 0x70000000, 0xC0000000

BOARD = """
name = "two devices"
[[region]]
name = "local"
base = 0x300000
words = 0x1000
bus = "local"
[[region]]
name = "w1"
kind = "window"
base = 0x70000000
words = 0x10000
bus = "local"
[[region]]
name = "global"
base = 0x80000000
words = 0x1000
bus = "global"
[[region]]
name = "w2"
kind = "window"
base = 0xC0000000
words = 0x10000
bus = "global"
[[device]]
name = "R1"
kind = "registers"
base = 0x70000000
words = 16
waits = 1
[[device]]
name = "R2"
kind = "registers"
base = 0xC0000000
words = 16
waits = 2
"""


def copy(source: int, destination: int, words: int, priority: int, channel: int = 5) -> str:
    """Starts a DMA channel; the addresses stay, but for memory."""
    base = 0xA0 + 16 * channel
    control = 0x00C40004 | priority
    values = ((1, source), (4, destination), (3, words), (0, control))
    return "".join(
        f"        ldhi 0{value >> 16:x}h,r9\n        or 0{value & 0xFFFF:x}h,r9\n        sti r9,*+ar6(0{base + at:x}h)\n"
        for at, value in values
    )


def program(text: str) -> Any:
    head = "        .text\nstart:  ldhi 10h,ar6\n        ldhi 7000h,ar4\n        ldhi 0c000h,ar5\n"
    return c40.assemble(head + text + "end:    bu end\n")


def shared(chips: int) -> list[SharedMemory]:
    return [SharedMemory("s", 16, dict.fromkeys(range(chips), SHARED), waits=1)]


@pytest.mark.parametrize("priority", [0, 1, 3])
def test_a_dma_that_finds_a_shared_memory_busy_waits(priority: int) -> None:
    """Whatever the phase in which the other chip reads: every word is copied, and the run ends."""

    def run(nops: int, order: int) -> tuple[Any, ...]:
        reader = program("        nop\n" * nops + "        ldi *ar4,r1\n")
        mover = program(copy(SHARED, 0x80000000, 20, priority))
        network = Network([reader, mover], memories=shared(2), turn_order=order)
        stop = network.run()
        return stop.reason, stop.time_ps, network.chips[1].peripherals["DMA5.counter"], network.event_trace

    for nops in range(4, 16):
        results = within(20, lambda nops=nops: [run(nops, order) for order in (0, 1, 2)])
        assert results[0][0] == "ended" and results[0][2] == 0
        assert results[1:] == results[:1] * 2


ARMED = """
        ldhi 4000h,r10
        ldi r10,die
        ldi 10,r9
        sti r9,*+ar6(0d3h)
        ldhi 30h,r9
        or 800h,r9
        sti r9,*+ar6(0d4h)
        ldhi 10h,r9
        or 71h,r9
        sti r9,*+ar6(0d1h)
        ldhi 0c4h,r9
        or 44h,r9
        sti r9,*+ar6(0d0h)
loop:   nop
        addi 1,r0
        addi 1,r1
        bu loop
"""


@pytest.mark.parametrize("net", ["0.IIOF0>1.NMI", "0.TCLK0>1.IIOF1"])
def test_a_chip_that_drives_a_net_beside_its_dma_reaches_every_limit(net: str) -> None:
    """The DMA waits for a word that does not come; or it copies endlessly."""
    busy = copy(0x80000000, 0x80000100, 0, 0) + "loop:   nop\n        addi 1,r0\n        bu loop\n"
    for text in (ARMED, busy):

        def run(cycle: int, text: str = text) -> list[int]:
            network = Network([program(text), program("loop:   nop\n        bu loop\n")], nets=[net])
            network.run(until_us=cycle / 20)
            return [chip.cycles for chip in network.chips]

        for cycle in range(298, 310):
            assert min(within(20, lambda run=run, cycle=cycle: run(cycle))) >= cycle
