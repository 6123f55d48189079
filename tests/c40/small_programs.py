"""Small programs for the tests: assembled text in, a processor out."""

from __future__ import annotations

from typing import Any

from cmrc._core import c40, toolchain

CODE = 0x2FFC00  # on-chip block 1
DATA = 0x2FF800  # on-chip block 0


def load(text: str, board: str = "default", at: int = CODE, sections: dict[str, int] | None = None) -> tuple[Any, Any]:
    """`sections`: where other sections than .text are."""
    image = toolchain.assemble("        .text\n" + text, "test.asm", sections={".text": at, **(sections or {})})
    processor = c40.Processor(board)
    processor.load_image(image)
    processor.pc = at
    processor.set("SP", 0x2FFB00)
    return processor, image


def consistent(processor: Any) -> bool:
    return sum(processor.causes.values()) == processor.cycle
