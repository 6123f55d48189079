"""A DMA channel that waits for a timer that runs is at work until its transfer ends: nothing ends before."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
from cmrc import c40
from cmrc.network import Network
from dma_chips import BLOCK0, BLOCK1, RUN, STOP_AT_END
from network_programs import base, program

CHANNEL, TIMER0 = 0x1000A0, 0x100020
PERIOD, GO, READ_SYNC, BY_TIMER0 = 60, 0x2C0, 1 << 6, 3
WORDS = 10
ENDS = {"branch": "e:      bu e\n", "idle": "        idle\n        nop\n"}
STARTS = "        sti r6,*+ar2(8)\n        sti r7,*ar2\n        sti r0,*ar0\n"
WITHOUT_END = {"endless": 0, "lists": 2 << 2}


def source(control: int, ends: str) -> str:
    """Moves WORDS words from BLOCK0 to BLOCK1, one at each event of timer 0."""
    values = {1: BLOCK0, 2: 1, 3: WORDS, 4: BLOCK1, 5: 1}
    text = "        .text\n        ldhi 10h,ar0\n        or 0a0h,ar0\n        ldhi 10h,ar2\n        or 20h,ar2\n"
    for offset, value in values.items():
        text += (
            f"        ldhi 0{value >> 16:x}h,r0\n        or 0{value & 0xFFFF:x}h,r0\n        sti r0,*+ar0({offset})\n"
        )
    text += f"        ldi {PERIOD},r6\n        ldi 0{GO:x}h,r7\n        ldi {BY_TIMER0},die\n"
    return text + f"        ldhi 0{control >> 16:x}h,r0\n        or 0{control & 0xFFFF:x}h,r0\n" + STARTS + ENDS[ends]


def ran(emulator: Path, tmp_path: Path, text: str, *options: str) -> tuple[int, Any, str]:
    """Exit status, the report, and what the peripherals did."""
    file, events = tmp_path / "paced.asm", tmp_path / "events"
    file.write_text(text)
    command = [emulator, "exec", file, "--json", "--events", events, *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    return done.returncode, json.loads(done.stdout), events.read_text()


@pytest.mark.parametrize("ends", ENDS)
@pytest.mark.parametrize("mode", [STOP_AT_END, 3 << 2], ids=["stop", "restart"])
def test_exec_ends_after_the_block(emulator: Path, tmp_path: Path, ends: str, mode: int) -> None:
    status, report, events = ran(emulator, tmp_path, source(RUN | READ_SYNC | mode, ends))
    assert status == 0
    assert report["stop"]["reason"] == {"branch": "halt", "idle": "idle"}[ends]
    assert "DMA" not in report["stop"]["message"]
    assert "dma_end 0" in events
    assert report["cycles"] > WORDS * 2 * PERIOD


@pytest.mark.parametrize("ends", ENDS)
@pytest.mark.parametrize("mode", WITHOUT_END)
def test_a_transfer_without_end_is_only_armed(emulator: Path, tmp_path: Path, ends: str, mode: str) -> None:
    status, report, _ = ran(emulator, tmp_path, source(RUN | READ_SYNC | WITHOUT_END[mode], ends))
    assert status == 0
    assert "DMA channel 0 waits for timer 0" in report["stop"]["message"]
    assert report["cycles"] < 2 * PERIOD


def test_the_limit_of_cycles_ends_it(emulator: Path, tmp_path: Path) -> None:
    text = source(RUN | READ_SYNC | STOP_AT_END, "branch")
    status, report, _ = ran(emulator, tmp_path, text, "--max-cycles", "300")
    assert (status, report["stop"]["reason"]) == (1, "limit")
    status, report, _ = ran(emulator, tmp_path, text, "--cycles", "300")
    assert (status, report["stop"]["reason"]) == (0, "limit")


@pytest.mark.parametrize("ends", ENDS)
@pytest.mark.parametrize("reads", [0, 3, 10, 12])
def test_a_network_sends_what_its_timer_paces_whatever_the_receiver_does(ends: str, reads: int) -> None:
    receiver = base(3) + "        ldi *+ar0(1),r0\n" * reads + ENDS["branch"]
    made = Network([program(STARTS + ENDS[ends]), program(receiver)], links=["0.0:1.3"], record_peripherals=True)
    chip = made.chips[0]
    chip.registers["AR0"], chip.registers["R0"] = CHANNEL, RUN | READ_SYNC | STOP_AT_END
    chip.registers["AR2"], chip.registers["R6"], chip.registers["R7"] = TIMER0, PERIOD, GO
    chip.registers["DIE"] = BY_TIMER0
    chip.memory[CHANNEL + 1 : CHANNEL + 6] = [BLOCK0, 1, WORDS, 0x100042, 0]
    stop = made.run(until_us=1000)
    assert stop.reason == ("deadlock" if reads > WORDS else "ended")
    assert sum(event.kind == "port_write" for event in made.peripheral_events) == WORDS
    assert chip.status == {"branch": "halt", "idle": "idle"}[ends]
    assert "DMA" not in chip.message


def test_the_debugger_ends_after_the_block() -> None:
    text = source(RUN | READ_SYNC | STOP_AT_END, "branch")
    debugger = c40.Processor(c40.assemble(text)).debug()
    debugger.go()
    assert debugger.value("cycle") > WORDS * 2 * PERIOD
