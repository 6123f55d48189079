"""Registers, memory and operands (c40-isa.md 1 and 3): the parts of instructions.

Of one instruction: effective addresses come from the old registers, then the updates of address registers happen, then
reads (registers see the updates), then writes. Of two accesses of one kind, the one of the byte in bits 15..8 comes
first.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from . import floats, integers
from .addressing import BIT_REVERSED, indirect, modifies
from .flags import IMPLEMENTED, RM, SET_COND, Flags, applied
from .formats import from_short, from_single

WORD = 0xFFFFFFFF
AR0, DP, IR0, IR1, BK, SP, ST, DIE, IIE, IIF, RS, RE, RC, R11 = 8, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 31
NAMES = [f"R{n}" for n in range(8)] + [f"AR{n}" for n in range(8)]
NAMES += ["DP", "IR0", "IR1", "BK", "SP", "ST", "DIE", "IIE", "IIF", "RS", "RE", "RC", "R8", "R9", "R10", "R11"]
TABLE_BASE = WORD & ~0x1FF


class ReservedError(Exception):
    """The word is no instruction."""


class StopError(Exception):
    """SWI: the emulator's own breakpoint. Nothing has happened."""


def is_extended(code: int) -> bool:
    return code < 8 or code >= 28


Operand = tuple[str, int]  # ("register", code), ("memory", address), ("constant", value)


@dataclass
class Pending:
    """A delayed branch whose slots are being executed."""

    target: int | None  # None: straight on
    slots: int = 3
    annulled: bool = False
    repeats: bool = False  # RPTBD


@dataclass
class State:
    r: list[int] = field(default_factory=lambda: [0] * 32)
    ivtp: int = 0
    tvtp: int = 0
    pc: int = 0x1000
    memory: dict[int, int] = field(default_factory=dict)
    bus: list[tuple[str, int, int]] = field(default_factory=list)
    pending: Pending | None = None
    updates: list[tuple[int, int]] = field(default_factory=list)
    started_repeat: bool = False

    # ---- operands ----

    def read(self, address: int) -> int:
        self.bus.append(("rd", address, 0))
        return self.memory.get(address, 0)

    def write(self, address: int, word: int) -> None:
        self.bus.append(("wr", address, word))
        self.memory[address] = word

    def at_direct(self, offset: int) -> Operand:
        return "memory", (self.r[DP] << 16 | offset) & WORD

    def at_indirect(self, modn: int, n: int, displacement: int) -> Operand:
        if modn > BIT_REVERSED or (modn >= 8 and displacement not in (0, 1)):
            raise ReservedError(f"modn {modn}, displacement {displacement}")
        code = AR0 + n
        address, after = indirect(modn, self.r[code], displacement, self.r[IR0], self.r[IR1], self.r[BK])
        if modifies(modn):
            self.updates.append((code, after))
        return "memory", address

    def at_byte(self, byte: int) -> Operand:
        """The 8-bit indirect operand: an implied displacement of 1."""
        return self.at_indirect(byte >> 3, byte & 7, 1)

    def at_offset_byte(self, byte: int) -> Operand:
        """Type 2: *+ARn(0 to 31)."""
        return "memory", (self.r[AR0 + (byte & 7)] + (byte >> 3)) & WORD

    def operand(self, g: int, src: int, constant: int) -> Operand:
        if g == 0:
            if src > 31:
                raise ReservedError("register field")
            return "register", src
        if g == 1:
            return self.at_direct(src)
        if g == 2:
            if src >> 11 >= 8 and src & 0xFF:
                raise ReservedError("displacement beside an index register")
            return self.at_indirect(src >> 11, src >> 8 & 7, src & 0xFF)
        return "constant", constant

    def settle(self) -> None:
        """The updates of address registers; the last one noted stays."""
        for code, after in self.updates:
            self.r[code] = after
        self.updates = []

    def integer(self, operand: Operand) -> int:
        kind, where = operand
        if kind == "register":
            return self.r[where] & WORD
        return self.read(where) if kind == "memory" else where & WORD

    def floating(self, operand: Operand) -> int:
        kind, where = operand
        if kind == "register":
            if not is_extended(where):
                raise ReservedError("float operand")
            return self.r[where]
        return from_single(self.read(where)) if kind == "memory" else from_short(where)

    # ---- results ----

    def set_flags(self, flags: Flags | None) -> None:
        self.r[ST] = applied(self.r[ST], flags)

    def gated(self, code: int, flags: Flags | None) -> None:
        if is_extended(code) or (self.r[ST] & SET_COND and code != ST):
            self.set_flags(flags)

    def write_status(self, word: int) -> None:
        if self.r[RC] in (0, WORD):
            word &= ~RM
        self.r[ST] = word & IMPLEMENTED

    def put(self, code: int, word: int) -> None:
        """An integer result: the exponent byte of R0 to R11 stays."""
        word &= WORD
        if code == ST:
            self.write_status(word)
        elif is_extended(code):
            self.r[code] = self.r[code] & ~WORD | word
        else:
            self.r[code] = word

    def put_integer(self, code: int, result: integers.Result) -> None:
        self.gated(code, result[1])
        self.put(code, result[0])

    def put_float(self, code: int, result: floats.Result) -> None:
        if not is_extended(code):
            raise ReservedError("float destination")
        self.set_flags(result[1])
        self.r[code] = result[0]
