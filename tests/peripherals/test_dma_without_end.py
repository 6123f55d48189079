"""A DMA that leaves its processor no bus, and one that faults while its processor waits: when a call, and a network,
come back.

Counts are from c40-hardware.md 3.4 (priority 11 always wins) and 3.5 (cycles of an access; a counter of 0 is 2^32
words).
"""

from __future__ import annotations

import random
import subprocess
from pathlib import Path
from typing import Any

import pytest
from cmrc import c40 as package
from cmrc._core import c40, toolchain
from cmrc.network import Network
from dma_chips import low

BOARD = """
name = "one bus"
gmicr = 0x1DEA4000
lmicr = 0x1DEA4000
[[region]]
name = "local"
base = 0x300000
words = 0x2000
bus = "local"
waits = 0
"""
WORKER = """
        .text
start:  ldp @control
        ldhi 10h,ar6
        ldi @control,r0
        sti r0,*+ar6(0a0h)
        nop
        nop
        nop
        nop
        sti r0,@result          ; a fetch fits where the DMA turns round from write to read; a store does not
        addi 1,r1
        addi 2,r1
end:    bu end
control: .word 0C00007h          ; START 11, MODE 01, PRI 11
result: .word 0
"""
CYCLES_OF_A_WORD = 4
"""On one bus without wait states: a read after a write, 2, and a write, 2."""


def starved(tmp_path: Path, words: int) -> tuple[Any, Any]:
    """Code, source and destination on one bus; `words` of 0 are 2^32."""
    board = tmp_path / "board.toml"
    board.write_text(BOARD)
    image = toolchain.assemble(WORKER, "worker.asm", sections={".text": 0x300000})
    chip = c40.Processor(str(board))
    chip.load_image(image)
    for register, value in ((1, 0x301000), (2, 0), (3, words), (4, 0x301100), (5, 0)):
        chip.poke(0x1000A0 + register, value)
    return chip, image


def test_a_processor_that_never_gets_its_bus_does_not_hang_a_call(tmp_path: Path) -> None:
    chip, _ = starved(tmp_path, 0)
    before = -1
    for _ in range(20):  # by steps and by runs: each call returns, and time advances
        assert chip.step()["reason"] == "limit"
        assert chip.run(100)["reason"] == "limit"
        assert before < chip.cycle < before + 50_000
        before = chip.cycle
    assert low(chip, "R1") < 3  # at most the instruction directly behind the store
    moved = (1 << 32) - chip.peripherals()["DMA0.counter"]
    assert abs(moved * CYCLES_OF_A_WORD - chip.cycle) < 50
    assert sum(chip.causes.values()) == chip.cycle


@pytest.mark.parametrize("words", [1000, 9000])
def test_a_processor_continues_as_soon_as_it_gets_its_bus_however_it_is_run(tmp_path: Path, words: int) -> None:
    outcomes = []
    for way in ("whole", "cut", "stepped"):
        chip, image = starved(tmp_path, words)
        rng = random.Random(words)
        while chip.pc != image.symbols["end"]:
            stop = (
                chip.step()
                if way == "stepped"
                else chip.run(
                    1_000_000 if way == "whole" else rng.choice([1, 7, 3000, 20_000]), until=image.symbols["end"]
                )
            )
            assert stop["reason"] in ("limit", "breakpoint")
        assert low(chip, "R1") == 3
        outcomes.append((chip.cycle, chip.snapshot(), chip.digest(), chip.causes))
    assert outcomes[0] == outcomes[1] == outcomes[2]
    assert words * CYCLES_OF_A_WORD <= outcomes[0][0] <= words * CYCLES_OF_A_WORD + 50


def test_exec_comes_to_its_limit_beside_it(emulator: Path, tmp_path: Path) -> None:
    starved(tmp_path, 0)
    source = tmp_path / "worker.asm"
    source.write_text(
        WORKER.replace(
            "sti r0,", "ldi @from,r2\n        sti r2,*+ar6(0a1h)\n        sti r2,*+ar6(0a4h)\n        sti r0,"
        )
        + "from:   .word 00301000h\n"
    )
    command = [str(emulator), "exec", str(source), "--board", str(tmp_path / "board.toml"), "--max-cycles", "100000"]
    result = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)
    assert result.returncode == 1 and "--max-cycles 100000 reached at 0030" in result.stdout + result.stderr


WAITS_BESIDE_A_DMA = """
        .text
start:  ldp @control
        ldhi 10h,ar6
        ldi @control,r0
        sti r0,*+ar6(0a0h)
        ldi *+ar6(71h),r1       ; no word ever comes
end:    bu end
control: .word 0C00007h
"""


@pytest.mark.parametrize("cuts", [[], [0.7], [0.9, 1.0, 1.05], [5.0]])
def test_a_network_ends_when_the_dma_of_a_chip_that_waits_faults(cuts: list[float]) -> None:
    """Four words from block 0 downwards, two cycles each: the fifth read meets a reserved address."""
    quiet = package.assemble("        .text\nend:    bu end\n", sections={".text": 0x2FFC00})
    network = Network(
        [package.assemble(WAITS_BESIDE_A_DMA, sections={".text": 0x2FFC00}), quiet],
        links=["0.3:1.0"],
        record_peripherals=True,
    )
    chip = network.chips[0]
    for register, value in ((1, 0x2FF803), (2, 0xFFFFFFFF), (3, 100), (4, 0x2FFD00), (5, 1)):
        chip._core.poke(0x1000A0 + register, value)
    for cut in cuts:
        network.run(until_us=cut)
    stop = network.run()
    started = next(int(line.split()[0]) for line in network.event_trace if "dma_start" in line) // 50_000
    fault = started + 1 + 4 * 2
    assert stop.reason == "ended" and stop.time_ps == fault * 50_000
    assert chip.status == "fault" and "002FF7FFh" in chip.message and f"cycle {fault}" in chip.message
