"""Boards and programs that several tests of devices use."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from bench_board import HEAD
from cmrc import c40

# AR1 the vector table, AR2 the devices; R2 counts interrupts.
START = """
        .text
start:  ldhi 2fh,ar1
        or 0fa00h,ar1
        ldpe ar1,ivtp
        ldhi 2fh,sp
        or 0fb00h,sp
        ldhi 0a000h,ar2
        ldi 0,r2
"""
END = "done:   b done\n"


def device(kind: str, base: int = 0xA0000000, name: str = "D", **keys: object) -> str:
    text = f'\n[[device]]\nname = "{name}"\nkind = "{kind}"\nbase = 0x{base:X}\n'
    return text + "".join(f"{key} = {json.dumps(value)}\n" for key, value in keys.items())


def board(folder: Path, *devices: str) -> Path:
    path = folder / "board.toml"
    path.write_text(HEAD + "".join(devices))
    return path


def vector(number: int, label: str = "isr") -> str:
    return f"        ldhi hi16({label}),r0\n        or lo16({label}),r0\n        sti r0,*+ar1({number:x}h)\n"


def enabled(pin: int, nibble: int = 9) -> str:
    """9: an edge, 0Bh: a level."""
    return f"        ldi 0{nibble << 4 * pin:x}h,iif\n        or 2000h,st\n"


def assembled(text: str) -> Any:
    return c40.assemble(START + text)


def low(chip: Any, register: str) -> int:
    """The integer in an extended-precision register."""
    return int(chip.registers[register]) & 0xFFFFFFFF
