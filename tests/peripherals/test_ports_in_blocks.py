"""Blocks that read and write linked ports, against the exact engine and against cut runs."""

from __future__ import annotations

from typing import Any

import pytest
from cmrc import c40
from cmrc.network import Network
from linked_processors import Network as PlainNetwork
from linked_processors import processor
from network_programs import CODE, base, state

VECTORS, STACK = 0x2FF800, 0x2FFB00
TIMER0, GO, GIE = 0x100020, 0x3C0, 0x2000

# A word after a pause; and between two words, instructions by which the instant of an interrupt can be told.
SENDER = (
    base(0)
    + """
again:  addi 1,r0
        sti r0,*+ar0(2)
        rpts {pause}
        nop
        bu again
"""
)
RECEIVER = (
    base(3)
    + """
again:  ldi *+ar0(1),r1
        {work}
        sti r6,*+ar0(2)
        bu again
service: addi r6,r9
        mpyi 3,r9
        reti
"""
)


# The wait is in a delay slot, so that the recording of the loop comes to nothing unless a word is there.
IN_DELAY_SLOT = (
    base(3)
    + """
again:  bud again
        addi 1,r6
        ldi *+ar0(1),r1
        sti r6,*+ar0(2)
service: addi r6,r9
        mpyi 3,r9
        reti
"""
)


def texts(pause: int, in_delay_slot: bool = False) -> list[str]:
    work = "\n        ".join(["addi 1,r6"] * 40)
    return [SENDER.format(pause=pause), IN_DELAY_SLOT if in_delay_slot else RECEIVER.format(work=work)]


def prepare(core: Any, period: int, service: int) -> None:
    """The timer of the chip that receives interrupts it every so many ticks."""
    core.poke(VECTORS + 2, service)
    core.poke(TIMER0 + 8, period)
    core.poke(TIMER0, GO)
    for name, value in {"IVTP": VECTORS, "IIE": 1, "ST": GIE}.items():
        core.set(name, value)


def assembled(text: str) -> Any:
    return c40.assemble("        .text\n" + text, sections={".text": CODE})


def network(programs: list[str], period: int) -> Network:
    images = [assembled(text) for text in programs]
    made = Network(images, links=["0.0:1.3"], record_words=True)
    for chip in made.chips:
        chip._core.set("SP", STACK)
        for n in range(4):
            chip._core.set(f"R{n}", 0x8000000000)  # as after a start without a network
    prepare(made.chips[1]._core, period, images[1].symbols["service"])
    return made


def plainly(programs: list[str], period: int, until: int) -> Any:
    """The plainest driver, and the exact engine."""
    plain = PlainNetwork([processor(text) for text in programs])
    for chip in plain.chips:
        chip.set_exact(True)
        chip.set("SP", STACK)
    plain.join(0, 0, 1, 3)
    prepare(plain.chips[1], period, assembled(programs[1]).symbols["service"])
    plain.run(until)
    return [(chip.cycle, chip.causes, chip.get("R6"), chip.get("R9"), chip.get("R1")) for chip in plain.chips]


@pytest.mark.parametrize("in_delay_slot", [False, True])
@pytest.mark.parametrize(("pause", "period"), [(150, 37), (150, 101), (5, 37), (90, 7)])
def test_an_interrupt_comes_where_it_comes_by_the_exact_engine(pause: int, period: int, in_delay_slot: bool) -> None:
    """The block after the wait for a port ends before the event of a timer."""
    programs = texts(pause, in_delay_slot)
    whole, cut = network(programs, period), network(programs, period)
    whole.run(until_us=250)
    for n in range(1, 5001):
        cut.run(until_us=n * 0.05)
    assert state(cut) == state(whole)
    assert [
        (core.cycle, core.causes, core.get("R6"), core.get("R9"), core.get("R1"))
        for core in (chip._core for chip in whole.chips)
    ] == plainly(programs, period, 250_000_000)
    causes = whole.chips[1].causes
    # A chip that waits in a delay slot takes no interrupt.
    assert causes["comm_port"] > 0 and causes["interrupt"] > (10 if in_delay_slot else 40)
