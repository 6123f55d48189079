"""Small C40 programs for the machine's tests, assembled when a test asks for them."""

from functools import cache
from pathlib import Path

from cmrc._core import toolchain
from cmrc_test import machine

INCLUDE = Path(__file__).resolve().parents[2] / "c40_programs" / "include"

MS = 10**9  # picoseconds
US = 10**6
ON_CHIP = 0x2FF800

HEAD = """
        .include "task_block.inc"
        .include "devices.inc"
        .text
_start: ldhi    0C000h, ar0             ; window A
        ldhi    0C001h, ar1             ; its registers, semaphore 0 first
        ldhi    07000h, ar2             ; window B
        ldhi    002Fh, ar3
        or      0F800h, ar3             ; on-chip RAM
        ldhi    0030h, ar4
        or      0F000h, ar4             ; parameters
        ldi     *ar4, r7                ; the slot
        ldhi    002Fh, sp
        or      0FC00h, sp
"""

TAIL = """
halt:   b       halt
        .sect   ".parameters"
dsp_slot:    .word 0
idle_policy: .word 0
pause_count: .word 0
"""


# IIOF0 interrupts: the vectors are in on-chip RAM, and the handler, section .handlers, is at 30F010h.
DOORBELL = """
        ldhi    002Fh, ar5
        or      0FA00h, ar5
        ldpe    ar5, ivtp
        ldhi    0030h, ar6
        or      0F010h, ar6
        sti     ar6, *+ar5(3)
        ldi     9, iif
"""


@cache
def assemble(body: str) -> toolchain.Image:
    """A program whose registers are set up as HEAD says and that ends in an endless loop."""
    return toolchain.assemble(
        HEAD + body + TAIL,
        "test.asm",
        include_dirs=[INCLUDE],
        sections={".text": 0x300000, ".parameters": 0x30F000},
        entry="_start",
    )


def with_devices(devices: str) -> toolchain.Image:
    """A program that does nothing, with this text for devices.inc."""
    source = '        .include "task_block.inc"\n' + devices + "\n        .text\n_start: nop\n"
    source += "dsp_slot: .word 0\nidle_policy: .word 0\npause_count: .word 0\n"
    return toolchain.assemble(source, "other.asm", include_dirs=[INCLUDE], sections={".text": 0x300000}, entry="_start")


def config(**values: object) -> machine.Config:
    """A configuration with some fields set."""
    result = machine.Config()
    for name, value in values.items():
        setattr(result, name, value)
    return result
