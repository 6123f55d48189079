"""What a DMA costs the processor, over random mixes of instructions, places and wait states (c40-hardware.md 3.4, 3.5, 7.4).

One bus slot a word: what the processor loses is never more than the cycles in which the DMA had a bus or a memory port. Rotating priority costs no more than
DMA-first but for the luck of the alignment: which access meets which is another one, and that is worth a few cycles either way (2 mixes of 100, 1 to 6 cycles).
Bus cycles are counted here from section 3.5, not from the emulator.
"""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest
from cmrc._core import c40, toolchain

BOARD = """
name = "mix"
gmicr = 0x1DEA4000
lmicr = 0x1DEA4000
[[region]]
name = "local"
base = 0x300000
words = 0x2000
bus = "local"
waits = {0}
[[region]]
name = "global"
base = 0x80000000
words = 0x1000
bus = "global"
waits = {1}
"""
PLACES = {"block 0": 0x2FF800, "block 1": 0x2FFC00, "local": 0x301000, "global": 0x80000400}
INSTRUCTIONS = ["nop", "addi 1,r0", "ldi *ar0,r1", "ldi *ar1,r2", "sti r0,*ar0", "sti r0,*ar1", "ldi *ar0,r1\n     || ldi *ar2,r2", "addi3 *ar0,*ar2,r3", "sti r1,*ar2",
                "sti r0,*ar0\n     || sti r1,*ar2", "addi3 *ar1,*ar2,r3", "addi 0,ar0\n        ldi *ar0,r1", "mpyi3 r0,r1,r2"]  # fmt: skip
STOP_AT_END, RUN = 1 << 2, 3 << 22
WORDS = 25
LUCK, REGAINED, TURN = 8, 3, 1


def bus_cycles(source: str, destination: str, waits: dict[str, int]) -> int:
    """Of one word: what the DMA takes of buses and ports, its own turn from write to read on one bus included."""
    read = 1 + waits.get(source, 0) + (source == destination and source in waits)
    write = (2 if destination in waits else 1) + waits.get(destination, 0)
    return read + write


def run(text: str, board: str, code: int, pointers: dict[str, int], dma: tuple[int, int, int] | None) -> tuple[int, int]:
    image = toolchain.assemble(text, "mix.asm", sections={".text": code})
    chip = c40.Processor(board)
    chip.load_image(image)
    for name, value in pointers.items():
        chip.set(name, value)
    if dma is not None:
        source, destination, priority = dma
        for register, value in enumerate((source, 1, WORDS, destination, 1), start=1):
            chip.poke(0x1000A0 + register, value)
        chip.poke(0x1000A0, RUN | STOP_AT_END | priority)
    assert chip.run(100_000, until=image.symbols["end"])["reason"] == "breakpoint"
    assert sum(chip.causes.values()) == chip.cycle
    return int(chip.cycle), int(chip.causes["dma_conflict"])


def mix(seed: int, directory: Path) -> dict[str, Any]:
    rng = random.Random(seed)
    waits = {"local": rng.choice([0, 0, 1, 3]), "global": rng.choice([0, 0, 2])}
    board = directory / f"{waits['local']}{waits['global']}.toml"
    board.write_text(BOARD.format(*waits.values()))
    code = rng.choice([0x2FFE00, 0x300000])
    body = "".join(f"        {rng.choice(INSTRUCTIONS)}\n" for _ in range(150 if code == 0x2FFE00 else 300))
    text = f"        .text\n{body}        nop\n        nop\nend:    bu end\n"
    if rng.random() < 0.3:
        text = f"        .text\n        rpts 99\n        {rng.choice(INSTRUCTIONS[:6])}\n{body}        nop\n        nop\nend:    bu end\n"
    pointers = {f"AR{n}": PLACES[rng.choice(list(PLACES))] + 8 * n for n in range(3)}
    source, destination = rng.choice(list(PLACES)), rng.choice(list(PLACES))
    alone = run(text, str(board), code, pointers, None)
    costs = {p: run(text, str(board), code, pointers, (PLACES[source] + 0x80, PLACES[destination] + 0x100, p)) for p in (0, 1, 3)}
    return {"alone": alone, "costs": costs, "bound": WORDS * bus_cycles(source, destination, waits), "what": (seed, waits, code, pointers, source, destination)}


def check(found: dict[str, Any]) -> None:
    alone, causes_alone = found["alone"]
    assert causes_alone == 0
    for priority, (cycles, stalls) in found["costs"].items():
        assert cycles <= alone + found["bound"] + TURN, (priority, found)
        # What an instruction regains later counts against its memory conflicts, once it has been charged to the DMA.
        assert stalls <= found["bound"] + REGAINED, (priority, found)
        assert cycles >= alone - REGAINED, (priority, found)  # a read is no longer straight after a write
    assert found["costs"][1][0] <= found["costs"][3][0] + LUCK, found


@pytest.mark.parametrize("seed", range(150))
def test_the_processor_loses_no_more_than_the_dma_takes(seed: int, tmp_path: Path) -> None:
    check(mix(seed, tmp_path))


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(150, 5000))
def test_the_processor_loses_no_more_than_the_dma_takes_by_the_thousand(seed: int, tmp_path: Path) -> None:
    check(mix(seed, tmp_path))
