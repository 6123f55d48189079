"""Programs for chips whose pins are connected by nets."""

from __future__ import annotations

from typing import Any

from cmrc import c40

HEAD = """
        .text
start:  ldhi 2fh,ar1            ; the vector table
        or 0fa00h,ar1
        ldpe ar1,ivtp
        ldhi 2fh,sp
        or 0fb00h,sp
        ldhi 10h,ar0            ; the peripherals
"""
END = "done:   b done\n"
EDGE, LEVEL = 0x9, 0xB  # of a nibble of IIF: an enabled interrupt
COUNT = "isr:    addi 1,r2\n        reti\n"


def assembled(text: str) -> Any:
    return c40.assemble(HEAD + text)


def clock(period: int, timer: int = 0) -> str:
    """A timer in clock mode with its output on: the pin goes low at once, and changes every 2 * period cycles."""
    base = 0x20 + 0x10 * timer
    return f"        ldi {period},r0\n        sti r0,*+ar0({base + 8:x}h)\n        ldi 3c1h,r0\n        sti r0,*+ar0({base:x}h)\n"


def listener(vector: int, setting: str, service: str = COUNT) -> Any:
    """Sleeps, and counts the interrupts of one vector in R2."""
    text = f"{setting}        ldi 0,r2\n        ldhi hi16(isr),r0\n        or lo16(isr),r0\n        sti r0,*+ar1({vector:x}h)\n"
    return assembled(text + "        or 2000h,st\nwait:   idle\n        b wait\n" + service)


def iiof(pin: int, nibble: int = EDGE) -> str:
    return f"        ldi 0{nibble << 4 * pin:x}h,iif\n"
