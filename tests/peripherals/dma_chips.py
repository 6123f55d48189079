"""A chip that sleeps beside its DMA channels, and the words that start a channel."""

from __future__ import annotations

from typing import Any

from cmrc._core import c40, toolchain

BLOCK0, BLOCK1 = 0x2FF800, 0x2FFC00
CODE = 0x2FFD00
TABLE = 0x2FFA00
RUN, STOP_AT_END, TCC = 3 << 22, 1 << 2, 1 << 18
IDLE = "wait:   idle\n        bu wait\nisr:    addi 1,r2\n        reti\n"


def chip_with(text: str, board: str = "default", at: int = CODE) -> tuple[Any, Any]:
    image = toolchain.assemble("        .text\n" + text, "dma.asm", sections={".text": at})
    chip = c40.Processor(board)
    chip.load_image(image)
    chip.pc = at
    chip.set("SP", 0x2FFB00)
    chip.set("IVTP", TABLE)
    return chip, image


def channel(chip: Any, n: int, control: int, **registers: int) -> None:
    base = 0x1000A0 + 0x10 * n
    names = {
        "source": 1,
        "source_index": 2,
        "counter": 3,
        "destination": 4,
        "destination_index": 5,
        "link": 6,
        "auxiliary_counter": 7,
        "auxiliary_link": 8,
    }
    for name, value in registers.items():
        chip.poke(base + names[name], value & 0xFFFFFFFF)
    chip.poke(base, control)


def copy(
    chip: Any, n: int, source: int, destination: int, count: int, control: int = RUN | STOP_AT_END | TCC, **more: int
) -> None:
    settings = {
        "source_index": 1,
        "destination_index": 1,
        "source": source,
        "destination": destination,
        "counter": count,
    } | more
    channel(chip, n, control, **settings)


def low(chip: Any, name: str) -> int:
    """The integer in an extended-precision register."""
    return int(chip.get(name)) & 0xFFFFFFFF


def idle_chip(at: int = CODE) -> tuple[Any, Any]:
    chip, image = chip_with(IDLE, at=at)
    for n in range(6):
        chip.poke(TABLE + 0x25 + n, image.symbols["isr"])
    return chip, image
