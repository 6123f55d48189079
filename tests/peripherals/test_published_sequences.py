"""Sequences 35 to 37 of c40-hardware.md 7.6, each counted there by hand, and the rate of the boot loader (9.6)."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import pytest
from cmrc import c40
from cmrc._core import c40 as core
from cmrc.network import Network
from cmrc_test import forms

CODE, VECTORS, STACK = 0x2FFC00, 0x2FF800, 0x2FFA00
PERIOD_PS = 50_000
STOP = "end:    bu end\n"


def program(text: str, **symbols: int) -> Any:
    return c40.assemble("        .text\n" + text, sections={".text": CODE}, symbols=symbols)


def port(number: int, register: str) -> str:
    return f"        ldhi 10h,{register}\n        or {0x40 + 0x10 * number:x}h,{register}\n"


@pytest.mark.parametrize("late", [0, 1, 2, 5, 40])
def test_35_read_of_an_empty_input_fifo_with_the_word_t_cycles_late(late: int) -> None:
    """1 + t: the read would take place `late` cycles before the word can be read."""

    def run(nops: int) -> tuple[int, int, int]:
        """When the word can be read, when the reader's next instruction begins, and what it waited."""
        reads = port(3, "ar0") + "        nop\n" * nops + "        ldi *+ar0(1),r0\n" + STOP
        sends = port(0, "ar0") + "        nop\n" * 60 + "        ldi 9,r0\n        sti r0,*+ar0(2)\n" + STOP
        network = Network([program(sends), program(reads)], links=["0.0:1.3"], record_words=True)
        assert network.run().reason == "ended"
        readable = network.events[0].time_ps // PERIOD_PS + 1
        begins = 2 + nops
        waited = network.chips[1].causes["comm_port"]
        assert network.chips[1].cycles == begins + 1 + waited
        return readable, begins, waited

    readable, _, _ = run(2)
    nops = readable - late - 2
    _, begins, waited = run(nops)
    assert begins == readable - late
    assert waited == late  # so the read takes 1 + t


def test_36_sixteen_writes_to_one_output_fifo_and_a_seventeenth() -> None:
    """Writes 1 to 9 at t = 0 to 8, write 10 at t = 11, then one per 5, write 16 at t = 41; 17 waits for the peer to
    read."""
    writes = port(0, "ar0") + "        ldi 1,r0\n" + "        sti r0,*+ar0(2)\n" * 17 + STOP
    network = Network([program(writes), program(STOP)], links=["0.0:1.3"], record_peripherals=True)
    assert network.run().reason == "deadlock"
    cycles = [event.cycle for event in network.peripheral_events if event.kind == "port_write"]
    assert [cycle - cycles[0] for cycle in cycles] == [*range(9), *range(11, 42, 5)]
    assert network.chips[0].message.startswith("waits for room in output FIFO 0 towards chip 1 port 3 since cycle ")
    assert (len(network.chips[0].port(0)["output"]), len(network.chips[1].port(3)["input"])) == (8, 8)


def test_36_alone_takes_forty_two_cycles() -> None:
    writes = port(0, "ar0") + "        ldi 1,r0\n        nop\n" + "        sti r0,*+ar0(2)\n" * 16 + STOP
    network = Network([program(writes), program(STOP)], links=["0.0:1.3"])
    assert network.run().reason == "ended"
    assert network.chips[0].cycles == 4 + 42


@pytest.mark.parametrize("source", ["timer", "iiof", "port"])
def test_37_interrupt_entry_on_a_stream_of_one_instruction(source: str) -> None:
    """8 cycles from the instruction that would have been next to the first of the interrupt's routine."""
    vector = {"timer": 2, "iiof": 3, "port": 0x0D + 1}[source]
    stream = "        addi 1,r0\n" * 60
    chip = core.Processor("default")
    image = program(stream + "        bu $\n" + "isr:    addi 1,r7\n        reti\n")
    chip.load_image(image)
    chip.pc = CODE
    chip.set("SP", STACK)
    chip.set("IVTP", VECTORS)
    chip.poke(VECTORS + vector, image.symbols["isr"])
    chip.set("IIE", {"timer": 1, "iiof": 0, "port": 1 << 2}[source])
    chip.set("IIF", 9 if source == "iiof" else 0)
    chip.set("ST", 0x2000)
    chip.run(20)
    assert chip.cycle == 20 and chip.get("R0") & 0xFF == 20
    if source == "timer":
        chip.set("IIF", 1 << 24)
    elif source == "iiof":
        chip.raise_iiof(0)
    else:
        chip.deliver(0, 5)
    chip.step()
    assert chip.pc == image.symbols["isr"] and chip.cycle == 28 and chip.causes["interrupt"] == 8
    assert chip.peek(STACK + 1) == CODE + 20  # what would have been next
    if source == "port":
        chip.set("IIE", 0)  # a level: it would come again
    chip.step()
    chip.step()
    assert chip.pc == CODE + 20 and chip.get("R7") & 0xFF == 1


def test_the_boot_loader_stores_a_word_in_eight_to_ten_cycles() -> None:
    booted = program("        addi 1,r0\n" * 100 + STOP)
    stream = forms.boot_stream(booted)
    sends = (
        port(0, "ar0")
        + "        addi 2,ar0\n        ldhi 30h,ar1\n"
        + "        ldi *ar1++,r0\n        sti r0,*ar0\n" * len(stream)
        + STOP
    )
    sender = c40.assemble(
        "        .text\n" + sends + "        .data\n" + "".join(f"        .word 0{word:x}h\n" for word in stream),
        sections={".text": 0x310000, ".data": 0x300000},
    )
    network = Network([sender, booted], links=["0.0:1.3"], boots=[1], record_peripherals=True)
    assert network.run().reason == "ended"
    assert network.chips[1].memory[CODE : CODE + 101] == list(booted.sections[0].words)
    reads = [event.cycle for event in network.peripheral_events if event.chip == 1 and event.kind == "port_read"]
    assert len(reads) == len(stream)
    assert {b - a for a, b in pairwise(reads[4 : 4 + 101])} <= {8, 9, 10}
