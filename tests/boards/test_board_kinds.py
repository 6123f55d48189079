"""FIFO, mailbox, timer, VIC068A and VME space: their registers, their interrupts, and one outcome however a run is
driven."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from board_parts import END, START, assembled, board, device, enabled, low, vector
from cmrc.c40 import Processor, assemble_file
from cmrc.network import Network
from command_line import emulator

# Takes a word by interrupt, adds one, sends it back.
ECHO = (
    vector(4)
    + "        ldi 1,r0\n        sti r0,*+ar2(4)\n"
    + enabled(1, 0xB)
    + "wait:   idle\n        cmpi 5,r2\n        blt wait\n"
    + END
)
SERVICE = "isr:    ldi *ar2,r3\n        addi 1,r3\n        sti r3,*ar2\n        addi 1,r2\n        reti\n"


def finished(program: Any, path: Path, **how: Any) -> Processor:
    processor = Processor(program, board=path, **how)
    stop = processor.run(1_000_000, until="done")
    assert stop.reason == "until", stop
    return processor


def test_a_fifo_brings_and_takes_words_by_interrupts(tmp_path: Path) -> None:
    path = board(tmp_path, device("fifo", pin="IIOF1", depth=4, input="in.txt", input_cycles=200))
    (tmp_path / "in.txt").write_text("10 20\n30\n40 50\n")
    processor = finished(assembled(ECHO + SERVICE), path)
    assert processor.sent("D") == [0x11, 0x21, 0x31, 0x41, 0x51] and low(processor, "R2") == 5
    assert processor.cycles > 4 * 200


STATUS = """
        ldi *+ar2(1),r4         ; a word has come, room, nothing for the host
        ldi *+ar2(2),r5
        ldi *ar2,r6
        ldi *ar2,r7
        ldi *ar2,r8             ; there is none
        ldi *+ar2(1),r9
        sti r9,*+ar2(1)
        ldi *+ar2(1),r10
        sti r6,*ar2
        sti r6,*ar2
        sti r7,*ar2             ; lost
        ldi *+ar2(1),r11
        ldi *+ar2(3),r2
"""


def test_a_program_that_sleeps_ends_with_its_devices_wherever_the_run_is_cut(tmp_path: Path) -> None:
    """A FIFO that has sent its word after 50 cycles is the last to do something, and wakes nobody."""
    path = board(tmp_path, device("fifo", pin="IIOF1", output_cycles=50))
    text = START + "        ldi 1,r0\n        sti r0,*+ar2(4)\n        ldi 90h,iif\n        sti r0,*ar2\n"
    (tmp_path / "p.asm").write_text(text + "wait:   idle\n        b wait\n")
    program = assemble_file(str(tmp_path / "p.asm"))
    whole = Network([program], boards=path)
    end = whole.run()
    cycle = whole.chips[0].cycles
    assert end.reason == "ended" and 50 < cycle < 100
    for shift_ps in range(-50_000, 100_000, 10_000):
        cut = Network([program], boards=path)
        cut.run(until_us=(end.time_ps + shift_ps) / 1e6)
        before = cut.now_ps
        assert cut.run() == end and (shift_ps > 0 or cut.now_ps >= before)
        assert cut.snapshot().to_bytes() == whole.snapshot().to_bytes()
    for options in ([], ["--until", "2FFFFFh==7"]):  # a word that is looked at after each cycle, and stays 0
        done = emulator("exec", "p.asm", "--board", path, "--json", *options, folder=tmp_path)
        assert json.loads(done.stdout)["cycles"] == cycle
    processor = Processor(program, board=path)
    assert processor.debug().go().reason == "over" and processor.cycles == cycle


def test_the_flags_of_a_fifo(tmp_path: Path) -> None:
    path = board(tmp_path, device("fifo", depth=2, output_cycles=1_000_000))
    processor = Processor(assembled(STATUS + END), board=path)
    processor.send("D", [5, 6])
    assert processor.run(until="done").reason == "until"
    read = {n: low(processor, f"R{n}") for n in (2, 4, 5, 6, 7, 8, 9, 10, 11)}
    full_input, empty = 1 | 2 | 4 | 8 | 16, 2 | 8
    assert (read[4], read[5], read[6], read[7], read[8]) == (full_input, 2, 5, 6, 0)
    assert (read[9], read[10]) == (empty | 0x80, empty)
    assert (read[11], read[2]) == (8 & 0 | 32 | 0x40, 2)
    assert processor.sent("D") == []


def test_a_host_that_waited_for_room_continues_when_there_is_some(tmp_path: Path) -> None:
    """Two words fit. The third comes at once when one is read, the fourth 100 cycles later, however long the host has
    waited."""
    path = board(tmp_path, device("fifo", depth=2, input="in.txt", input_cycles=100))
    (tmp_path / "in.txt").write_text("1 2 3 4\n")
    text = "        rpts 999\n        nop\n        ldi *ar2,r3\n        ldi *+ar2(2),r4\n        ldi *ar2,r5\n        ldi *+ar2(2),r6\n"
    text += "        rpts 99\n        nop\n        ldi *+ar2(2),r7\n"
    processor = finished(assembled(text + END), path)
    assert [low(processor, f"R{n}") for n in (3, 4, 5, 6, 7)] == [1, 2, 2, 1, 2]


def test_a_mailbox_holds_one_word_each_way(tmp_path: Path) -> None:
    path = board(tmp_path, device("mailbox", script="host.txt"))
    (tmp_path / "host.txt").write_text("on 7 1\non 8 2 3\n")
    text = "        ldi 7,r0\n        sti r0,*ar2\n        ldi *ar2,r3\n        ldi 8,r0\n        sti r0,*ar2\n        ldi *+ar2(2),r4\n        ldi *ar2,r5\n        ldi *ar2,r6\n"
    processor = finished(assembled(text + END), path)
    assert [low(processor, f"R{n}") for n in (3, 4, 5, 6)] == [1, 1, 2, 3] and processor.sent("D") == [7, 8]


TICKS = (
    vector(4)
    + "        ldi 20,r0\n        sti r0,*+ar2(1)\n        ldi 3,r0\n        sti r0,*+ar2(2)\n"
    + enabled(1)
    + "wait:   idle\n        cmpi 6,r2\n        blt wait\n"
    + END
)
TICK = "isr:    ldi 1,r0\n        sti r0,*+ar2(3)\n        addi 1,r2\n        reti\n"


@pytest.mark.parametrize("count_cycles", [1, 10])
def test_a_timer_interrupts_at_its_rate(tmp_path: Path, count_cycles: int) -> None:
    path = board(tmp_path, device("timer", pin="IIOF1", count_cycles=count_cycles))
    program = assembled(TICKS + TICK)
    processor = Processor(program, board=path)
    processor._core.record_events()
    assert processor.run(100_000, until="done").reason == "until"
    cycles = [cycle for kind, cycle, *_ in processor._core.events if kind == "interrupt"]
    # Each is taken at the end of an instruction, and no delay adds up.
    assert len(cycles) >= 6 and all(
        abs(cycle - cycles[0] - 20 * count_cycles * n) <= 2 for n, cycle in enumerate(cycles)
    ), cycles


def test_a_timer_says_what_is_left_and_that_it_overran(tmp_path: Path) -> None:
    path = board(tmp_path, device("timer", count_cycles=100))
    text = "        ldi 50,r0\n        sti r0,*ar2\n        ldi 5,r0\n        sti r0,*+ar2(2)\n        rpts 999\n        nop\n        ldi *ar2,r3\n        ldi *+ar2(3),r4\n"
    text += "        rpts 9999\n        nop\n        ldi *+ar2(3),r5\n        ldi *+ar2(2),r6\n        ldi 9,r0\n        sti r0,*+ar2(1)\n        ldi 1,r0\n        sti r0,*+ar2(2)\n        rpts 9999\n        nop\n        ldi *+ar2(3),r7\n"
    processor = finished(assembled(text + END), path)
    assert [low(processor, f"R{n}") for n in (3, 4, 5, 6, 7)] == [40, 0, 1, 4, 3]


def test_a_timer_that_runs_counts_on_from_what_is_written(tmp_path: Path) -> None:
    path = board(tmp_path, device("timer", count_cycles=100))
    text = "        ldi 50,r0\n        sti r0,*ar2\n        ldi 1,r1\n        sti r1,*+ar2(2)\n        rpts 999\n        nop\n"
    text += "        ldi *ar2,r3\n        sti r0,*ar2\n        ldi *ar2,r4\n        rpts 999\n        nop\n        ldi *ar2,r5\n"
    processor = finished(assembled(text + END), path)
    assert [low(processor, f"R{n}") for n in (3, 4, 5)] == [40, 50, 40]


COUNT, RELOAD, CONTROL = 0, 1, 2
# What is written to a timer of 10 cycles a count; the count, control and status 95 cycles behind the last write.
WRITTEN_TO_TIMERS: dict[str, tuple[list[tuple[int, int]], list[int]]] = {
    "0 while it runs": ([(RELOAD, 100), (CONTROL, 1), (COUNT, 0)], [91, 1, 0]),
    "0 while it runs, once": ([(RELOAD, 100), (CONTROL, 5), (COUNT, 0)], [91, 5, 0]),
    "0 while it runs, without a reload": ([(COUNT, 50), (CONTROL, 3), (COUNT, 0)], [0, 2, 0]),
    "0 while it stands": ([(RELOAD, 100), (COUNT, 0)], [0, 0, 0]),
    "0, then a start": ([(COUNT, 0), (RELOAD, 100), (CONTROL, 1)], [91, 1, 0]),
    "0, then a start without a reload": ([(COUNT, 0), (CONTROL, 1)], [0, 0, 0]),
    "a reload while it runs": ([(RELOAD, 4), (CONTROL, 1), (RELOAD, 100)], [95, 1, 1]),
}


@pytest.mark.parametrize(("writes", "expected"), WRITTEN_TO_TIMERS.values(), ids=WRITTEN_TO_TIMERS)
def test_a_timer_at_0_begins_at_its_reload_or_stops(
    tmp_path: Path, writes: list[tuple[int, int]], expected: list[int]
) -> None:
    path = board(tmp_path, device("timer", count_cycles=10))
    text = "".join(f"        ldi {value},r0\n        sti r0,*+ar2({offset})\n" for offset, value in writes)
    text += "        rpts 90\n        nop\n        ldi *ar2,r3\n        ldi *+ar2(2),r4\n        ldi *+ar2(3),r5\n"
    processor = finished(assembled(text + END), path)
    assert [low(processor, f"R{n}") for n in (3, 4, 5)] == expected


@pytest.mark.parametrize("count_cycles", [1, 7, 8])
def test_a_control_word_that_is_written_again_delays_no_count(tmp_path: Path, count_cycles: int) -> None:
    path = board(tmp_path, device("timer", count_cycles=count_cycles))
    start = "        ldi 5000,r0\n        sti r0,*+ar2(1)\n        ldi 1,r1\n        sti r1,*+ar2(2)\n"
    ends = "        rptb e\n        {}\n        nop\n        nop\ne:      nop\n        ldi *ar2,r4\n" + END
    counts = [
        low(finished(assembled(start + "        ldi 199,rc\n" + ends.format(what)), path), "R4")
        for what in ("sti r1,*+ar2(2)", "sti r1,*+ar2(3)")  # the status, which nothing counts on
    ]
    assert counts[0] == counts[1] < 5000 - 800 // count_cycles + 2


def test_a_timer_that_expires_often_between_two_looks_has_overrun(tmp_path: Path) -> None:
    path = board(tmp_path, device("timer", count_cycles=10))
    text = (
        "        ldi 50,r0\n        sti r0,*ar2\n        sti r0,*+ar2(1)\n        ldi 1,r1\n        sti r1,*+ar2(2)\n"
    )
    text += "        rpts 1999\n        nop\n        ldi *+ar2(3),r3\n"
    processor = finished(assembled(text + END), path)
    assert low(processor, "R3") == 3


BRIDGE = """
        ldi 0ffh,r0
        sti r0,*+ar2(1)         ; VICR1
        ldi *+ar2(1),r3
        sti r0,*+ar2(17h)       ; ICSR: bits 7 to 4 cannot be written
        ldi *+ar2(17h),r4
        sti r0,*+ar2(1dh)       ; ICR5: the revision
        ldi *+ar2(1dh),r5
"""
VME = """
        ldhi 0a000h,ar3
        or 8000h,ar3
        ldi *ar3,r6
        ldi *+ar2(2eh),r7       ; BESR
        nop
        nop
        nop
        nop
        ldi *+ar2(2eh),r8
"""
BERR = "isr:    addi 1,r2\n        ldi 0,r0\n        sti r0,*+ar2(2eh)\n        reti\n"


@pytest.mark.parametrize(("answer", "status", "interrupts"), [("bus error", 0x30, 1), ("ignored", 0, 0)])
def test_a_bridge_keeps_registers_and_notes_accesses_without_a_target(
    tmp_path: Path, answer: str, status: int, interrupts: int
) -> None:
    path = board(
        tmp_path,
        device("vic068a", name="VIC", pin="NMI", value=0xF5),
        device("vme", 0xA0008000, name="VME", words=0x8000, answer=answer, vic="VIC", waits=640),
    )
    processor = finished(assembled(vector(1) + BRIDGE + VME + END + BERR), path)
    assert [low(processor, f"R{n}") for n in (3, 4, 5, 6)] == [0xFF, 0x0F, 0xF5, 0xFFFFFFFF]
    assert (low(processor, "R7") | low(processor, "R8"), low(processor, "R2")) in {
        (status, interrupts),
        (0, interrupts),
    } and processor.cycles > 640
    if not interrupts:
        assert low(processor, "R7") == 0


REQUESTS = [
    # register, value, what the report says that it asks for
    (0x02, 0x83, None),  # disabled
    (0x02, 0x03, "interrupts, of which it hands none on"),
    (0x12, 0x00, "interrupts, of which it hands none on"),
    (0x13, 0x00, None),  # a vector, not a control register
    (0x20, 0x20, None),  # without bit 0 a request is taken back
    (0x20, 0x21, "an interrupt on the VMEbus"),
    (0x30, 0x3F, None),
    (0x30, 0x80, "the timer of SS0CR0"),
    (0x35, 0x1F, None),
    (0x35, 0x40, "a block transfer"),
    (0x38, 0xF0, "a system reset"),
]


@pytest.mark.parametrize(("register", "value", "what"), REQUESTS)
def test_requests_that_a_bridge_does_not_model_are_reported(
    tmp_path: Path, register: int, value: int, what: str | None
) -> None:
    path = board(tmp_path, device("vic068a", name="VIC", pin="NMI"))
    (tmp_path / "p.asm").write_text(
        START
        + f"        ldi 0{value:x}h,r0\n        sti r0,*+ar2(0{register:x}h)\n        sti r0,*+ar2(0{register:x}h)\n"
        + END
    )
    printed = emulator("exec", tmp_path / "p.asm", "--board", path).stdout
    found = json.loads(emulator("exec", tmp_path / "p.asm", "--board", path, "--json").stdout).get("not_modelled", [])
    processor = finished(assemble_file(tmp_path / "p.asm"), path)
    network = Network([tmp_path / "p.asm"], boards=str(path), until="done")
    network.run()
    if what is None:
        assert (
            "not modelled" not in printed
            and found == []
            and processor.not_modelled == network.chips[0].not_modelled == []
        )
    else:
        assert (
            printed.count("not modelled") == 1
            and f"vic068a VIC: asked for and not modelled: {what} (first at cycle {found[0]['cycle']})" in printed
        )
        assert (
            [(one["name"], one["cycle"], one["what"]) for one in found]
            == processor.not_modelled
            == network.chips[0].not_modelled
        )
        assert processor.fork().not_modelled == processor.not_modelled


def test_one_run_however_it_is_driven(tmp_path: Path) -> None:
    """exec, a processor in pieces and by snapshots, a network of one in other orders, and the debugger there and
    back."""
    path = board(
        tmp_path,
        device("fifo", pin="IIOF1", depth=4, input="in.txt", input_cycles=137),
        device("timer", 0xA0000100, name="T", pin="IIOF0", count_cycles=7),
    )
    (tmp_path / "in.txt").write_text("1 2 3 4 5\n")
    ticks = "        ldi 13,r0\n        sti r0,*+ar3(1)\n        ldi 3,r0\n        sti r0,*+ar3(2)\n"
    text = "        ldhi 0a000h,ar3\n        or 100h,ar3\n        ldi 0,r4\n" + vector(3, "tick") + ticks
    text += (
        ECHO.replace("        ldi 0b0h,iif\n", "        ldi 0b9h,iif\n")
        + SERVICE
        + "tick:   addi 1,r4\n        push r0\n        ldi 1,r0\n        sti r0,*+ar3(3)\n        pop r0\n        reti\n"
    )
    program = assembled(text)
    whole = finished(program, path)
    expected = (whole.cycles, low(whole, "R4"), whole.sent("D"))
    assert expected[1] > 3 and expected[2] == [2, 3, 4, 5, 6]

    cut = Processor(program, board=path)
    while (stop := cut.run(61, until="done")).reason == "limit":
        other = cut.fork()
        cut = other
    assert stop.reason == "until" and (cut.cycles, low(cut, "R4"), cut.sent("D")) == expected

    for order in (0, 5):
        network = Network([program], boards=[str(path)], until="done", turn_order=order)
        for _ in range(5):
            network.run(max_cycles=(whole.cycles * 3) // 5 // 5 * 5)
        network.run()
        chip = network.chips[0]
        assert chip.status == "until" and (chip.cycles, low(chip, "R4"), chip.sent("D")) == expected

    (tmp_path / "p.asm").write_text(START + text)
    report = json.loads(emulator("exec", tmp_path / "p.asm", "--board", path, "--until", "done", "--json").stdout)
    assert (report["cycles"], report["registers"]["R4"] & 0xFFFFFFFF, report["sent"][0]["words"]) == expected


def test_two_devices_may_pull_one_pin(tmp_path: Path) -> None:
    path = board(tmp_path, device("mailbox", pin="IIOF1"), device("mailbox", 0xA0000100, name="E", pin="IIOF1"))
    text = (
        vector(4)
        + "        ldi 1,r0\n        sti r0,*+ar2(4)\n        ldhi 0a000h,ar3\n        or 100h,ar3\n        sti r0,*+ar3(4)\n"
        + enabled(1)
        + "wait:   idle\n        b wait\n"
        + END
    )
    processor = Processor(assembled(text + "isr:    addi 1,r2\n        reti\n"), board=path)
    processor.run(500)
    assert low(processor, "R2") == 0
    processor.send("D", [1])
    processor.run(500)
    processor.send("E", [1])  # the pin is low already: no edge
    processor.run(500)
    assert low(processor, "R2") == 1


DMA = """
        ldhi 30h,ar5
        or 800h,ar5
        ldi 0,r0
        sti r0,*+ar5(3)
        ldhi 10h,ar4
        or 0a0h,ar4
        sti ar2,*+ar4(1)        ; from the FIFO
        ldi 0,r0
        sti r0,*+ar4(2)
        ldi 4,r0
        sti r0,*+ar4(3)
        sti ar5,*+ar4(4)
        ldi 1,r0
        sti r0,*+ar4(5)
        ldhi 0c0h,r0
        or 4,r0
        sti r0,*ar4
wait:   ldi *+ar5(3),r0
        bz wait
"""


def test_the_dma_reads_a_fifo(tmp_path: Path) -> None:
    path = board(tmp_path, device("fifo", waits=5, input="in.txt"))
    (tmp_path / "in.txt").write_text("11 22 33 44 55")
    program = assembled(DMA + END)
    processor = finished(program, path)
    network = Network([program], boards=[str(path)], until="done")
    network.run()
    for chip in (processor, network.chips[0]):
        assert chip.memory[0x300800:0x300804] == [0x11, 0x22, 0x33, 0x44]
    assert network.chips[0].cycles == processor.cycles
