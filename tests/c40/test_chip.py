"""Interrupts, IDLE, external windows, faults, and two programs compiled by other tools."""

import struct
from pathlib import Path
from typing import Any

import pytest
import small_programs
from cmrc._core import c40, toolchain

DATA = Path(__file__).parent / "data"
WINDOW_A, WINDOW_B = 0xC0000000, 0x70000000


def single_to_float(word: int) -> float:
    e = struct.unpack("b", bytes([word >> 24]))[0]
    s, f = word >> 23 & 1, word & 0x7FFFFF
    return 0.0 if e == -128 else ((-2 if s else 1) + f / 2**23) * 2.0**e


@pytest.mark.parametrize("name", ["p_crc", "p_sort"])
def test_compiled_program_gives_the_results_of_the_hosts_own_build(name: str) -> None:
    image = toolchain.read_coff(DATA / "coff" / f"{name}.O2.out")
    processor = c40.Processor("default")
    processor.load_image(image)
    stop = processor.run(50_000_000, until=image.symbols["_halt"])
    assert stop["reason"] == "breakpoint", stop
    for line in (DATA / "coff" / f"{name}.expect").read_text().splitlines():
        index, kind, text = line.split()
        word = processor.peek(0x330000 + int(index))
        if kind == "I":
            assert word == int(text, 16)
        else:
            assert single_to_float(word) == pytest.approx(float(text), rel=2e-5)
    assert small_programs.consistent(processor)


INTERRUPTED = """
        ldhi 2fh,ar0
        or 0fa00h,ar0          ; the vector table, on a 512-word boundary
        ldpe ar0,ivtp
        ldi 0bh,iif            ; IIOF0: interrupt pin, edge, enabled
again:  idle
after:  addi 1,r1
        bu again
isr:    addi 1,r0
        reti
"""


def interrupted() -> tuple[Any, Any]:
    processor, image = small_programs.load(INTERRUPTED.replace("0bh,iif", "9,iif"))
    processor.poke(0x2FFA00 + 3, image.symbols["isr"])
    processor.set("SP", 0x2FF800)
    return processor, image


def test_an_edge_wakes_the_chip_from_idle_in_eight_cycles() -> None:
    processor, image = interrupted()
    processor.run(1000)
    assert processor.idle and processor.cycle == 1000
    idle = processor.causes["idle"]
    processor.raise_iiof(0)
    assert not processor.idle
    processor.step()
    assert processor.pc == image.symbols["isr"]
    assert processor.cycle == 1008
    assert processor.causes["interrupt"] == 8
    assert processor.causes["idle"] == idle
    assert processor.peek(0x2FF801) == image.symbols["after"]
    assert processor.get("ST") & 0x6000 == 0x4000  # PGIE set, GIE clear
    assert processor.get("IIF") == 9  # the flag went with the acknowledge
    processor.run(1000)
    assert processor.idle
    assert (processor.get("R0") & 0xFFFFFFFF, processor.get("R1") & 0xFFFFFFFF) == (1, 1)
    assert small_programs.consistent(processor)


def test_an_interrupt_waits_for_delay_slots_and_rpts() -> None:
    text = """
        ldi 9,iif
        or 2000h,st
        brd on
        addi 1,r1
        addi 1,r1
        addi 1,r1
        nop
on:     rpts 9
        addi 1,r2
        nop
stop:   bu stop
isr:    ldi r1,r5
        ldi r2,r6
        reti
"""
    for cycles, seen in [(3, (3, 0)), (5, (3, 0)), (14, (3, 10))]:
        processor, image = small_programs.load(text)
        processor.set("IVTP", 0x2FFA00)
        processor.poke(0x2FFA03, image.symbols["isr"])
        processor.set("SP", 0x2FF800)
        processor.run(cycles)
        processor.raise_iiof(0)
        processor.run(200)
        assert (processor.get("R5") & 0xFFFFFFFF, processor.get("R6") & 0xFFFFFFFF) == seen
        assert processor.get("R2") & 0xFFFFFFFF == 10


def test_a_masked_edge_is_kept_and_a_general_purpose_pin_ignores_it() -> None:
    processor, _ = small_programs.load("stop:   bu stop\n")
    processor.raise_iiof(1)
    assert processor.get("IIF") == 0
    processor.set("IIF", 0x90)
    processor.raise_iiof(1)
    assert processor.get("IIF") == 0xD0
    processor.run(100)
    assert processor.causes["interrupt"] == 0


def test_a_window_read_stops_before_and_takes_the_answer() -> None:
    processor, image = small_programs.load(
        "        addi 1,r1\n        ldi *ar0++,r0\n        addi r0,r1\nstop:   bu stop\n"
    )
    processor.set("AR0", WINDOW_A)
    stop = processor.run(100)
    assert (stop["reason"], stop["address"], stop["write"]) == ("external_access", WINDOW_A, False)
    assert stop["access_cycle"] >= processor.cycle == 1
    assert processor.get("AR0") == WINDOW_A  # nothing is committed
    again = processor.run(100)
    assert again == stop
    processor.complete_read(41, 7, 5)
    processor.run(100, until=image.symbols["stop"])
    assert processor.get("R1") & 0xFFFFFFFF == 42
    assert processor.get("AR0") == WINDOW_A + 1
    assert (processor.causes["bus_arbitration"], processor.causes["bus_transfer"]) == (7, 5)
    assert processor.cycle == 3 + 12
    assert small_programs.consistent(processor)


def test_two_window_accesses_of_one_instruction_stop_twice() -> None:
    processor, image = small_programs.load("        addi3 *ar0,*ar1,r0\nstop:   bu stop\n")
    processor.set("AR0", WINDOW_A + 4)
    processor.set("AR1", WINDOW_B + 8)
    addresses = []
    while (stop := processor.run(100, until=image.symbols["stop"]))["reason"] == "external_access":
        addresses.append(stop["address"])
        processor.complete_read(stop["address"] & 0xFF, 3, 0)
    assert sorted(addresses) == [WINDOW_B + 8, WINDOW_A + 4]
    assert processor.get("R0") & 0xFFFFFFFF == 12
    assert processor.causes["bus_arbitration"] == 6
    assert small_programs.consistent(processor)


def test_a_window_write_shows_its_value() -> None:
    processor, image = small_programs.load(
        "        ldi 77,r0\n        stii r0,*ar0++(1)\n        sti r0,*ar0\n||      sti r1,*ar1\nstop:   bu stop\n"
    )
    processor.set("AR0", WINDOW_A)
    processor.set("AR1", 0x2FF800)
    processor.set("R1", 5)
    seen = []
    while (stop := processor.run(100, until=image.symbols["stop"]))["reason"] == "external_access":
        seen.append((stop["address"], stop["write"], stop["value"], stop["interlocked"]))
        processor.complete_write()
    assert seen == [(WINDOW_A, True, 77, True), (WINDOW_A + 1, True, 77, False)]
    assert processor.peek(0x2FF800) == 5


@pytest.mark.parametrize(
    ("text", "kind", "word"),
    [
        ("        .word 67000000h\n", "reserved_instruction", "no instruction"),
        ("        ldi *ar0,r0\n", "reserved_address", "00200000h"),
        ("        ldi *ar1,r0\n", "not_modelled", "analysis block"),
        ("        sti r0,*ar2\n", "not_modelled", "communication port 1"),
        ("        sti r0,*ar3\n", "not_modelled", "DMA channel 2"),
        ("        brd x\n        br x\nx:      nop\n        nop\n", "illegal_sequence", "br"),
    ],
)
def test_what_is_not_modelled_is_a_fault_that_names_it(text: str, kind: str, word: str) -> None:
    processor, _ = small_programs.load(text)
    for n, address in enumerate([0x200000, 0x100010, 0x100053, 0x1000C9]):
        processor.set(f"AR{n}", address)
    stop = processor.run(100)
    assert (stop["reason"], stop["kind"]) == ("fault", kind)
    assert word in stop["message"]
    assert processor.halted
    cycle = processor.cycle
    processor.run(50)
    assert (processor.cycle, processor.causes["halted"]) == (cycle + 50, 50)
    processor.reset()
    assert not processor.halted


def test_interface_control_registers_can_be_read_and_written() -> None:
    processor, image = small_programs.load(
        "        ldi *ar0,r0\n        sti r1,*ar0\n        ldi *ar0,r2\nstop:   bu stop\n"
    )
    processor.set("AR0", 0x100000)
    processor.set("R1", 0x1E4A4000)
    processor.run(100, until=image.symbols["stop"])
    assert processor.get("R0") & 0xFFFFFFFF == 0x1DEA4000
    assert processor.get("R2") & 0xFFFFFFFF == 0x1E4A4000


def test_a_held_chip_only_counts() -> None:
    processor, _ = small_programs.load("stop:   bu stop\n")
    processor.hold(True)
    processor.step()
    assert (processor.cycle, processor.instructions) == (1, 0)
    processor.run(10**12 - 1)
    assert (processor.cycle, processor.instructions, processor.causes["halted"]) == (10**12, 0, 10**12)


def test_a_window_access_begins_when_its_address_is_ready() -> None:
    # Written in execute, used as an address by the next instruction: its read stage is two cycles later than without
    # (c40-hardware.md 7.3). The read stage is one cycle before execute, which is at cycle(); no access begins
    # before that.
    begins = {}
    for first in ("addi 1,r5", "addi 1,ar0"):
        processor, _ = small_programs.load(f"        nop\n        {first}\n        ldi *ar0,r0\nstop:   bu stop\n")
        processor.set("AR0", WINDOW_A)
        stop = processor.run(100)
        assert stop["reason"] == "external_access"
        begins[first] = stop["access_cycle"] - processor.cycle
        processor.complete_read(5, 0, 10)
        processor.step()
        assert processor.cycle == 3 + 10 + processor.causes["register_conflict"]
    assert begins == {"addi 1,r5": max(-1, 0), "addi 1,ar0": -1 + 2}


@pytest.mark.parametrize(
    ("before", "begins"),
    [("        nop\n", 0), ("        addi 0,ar0\n", 1)],
    ids=["nothing holds it up", "its address register does"],
)
def test_a_read_through_a_bus_window_begins_in_its_read_stage_where_that_is_held_up(before: str, begins: int) -> None:
    """c40-hardware.md 7.1, 7.3: ADDI to AR0 holds up the read stage by two cycles, so that R is in the second cycle
    that LDI adds. Else R was before the first one, and the read begins there (docs/fidelity.md)."""
    text = f"        .text\nstart:  ldhi {WINDOW_A >> 16:#x},ar0\n        nop\n        nop\n        nop\n{before}read:   ldi *ar0,r1\nend:    bu end\n"
    image = toolchain.assemble(text.replace("0xc000", "0c000h"), "window.asm", sections={".text": 0x2FFC00})
    processor = c40.Processor("default")
    processor.load_image(image)
    stop = processor.run(100)
    assert (stop["reason"], stop["pc"]) == ("external_access", image.symbols["read"])
    assert stop["access_cycle"] - stop["cycle"] == begins
