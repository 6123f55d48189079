"""Registers, memory, and what every instruction does to them (sections 3, 6 and 8).

One instruction: effective addresses from the old registers, then the updates of address registers, then reads (registers
see the updates), then writes. Of two accesses of one kind, the one of the byte in bits 15..8 comes first; reads come before writes.

What is written here is one instruction's meaning. There are no interrupts and no time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from . import floats, integers
from .addressing import BIT_REVERSED, indirect, modifies
from .flags import CF, GIE, IMPLEMENTED, PCF, PGIE, RM, SET_COND, Flags, applied, holds
from .formats import canonical, from_short, from_single, from_single_raw, signed, to_single

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

# Section 6.1 by op6: what is computed from dst and src. Sources are integers or floats as the table's column says.
INTEGER_BINARY: dict[int, Callable[[int, int, int], integers.Result]] = {
    2: integers.addc,
    4: integers.addi,
    5: integers.and_,
    6: integers.andn,
    7: integers.ash,
    19: integers.lsh,
    21: integers.mpyi,
    32: integers.or_,
    45: integers.subb,
    48: integers.subi,
    49: lambda dst, src, st: integers.subb(src, dst, st),
    51: lambda dst, src, st: integers.subi(src, dst, st),
    53: integers.xor,
    59: integers.mpyshi,
    60: integers.mpyuhi,
}
INTEGER_UNARY: dict[int, Callable[[int, int], integers.Result]] = {
    1: integers.absi,
    16: integers.ldi,
    17: integers.ldi,
    22: integers.negb,
    24: integers.negi,
    27: integers.not_,
    44: integers.ldi,
}
INTEGER_COMPARE = {9: integers.cmpi, 52: integers.and_}
FLOAT_BINARY: dict[int, Callable[[int, int], floats.Result]] = {
    3: floats.addf,
    20: floats.mpyf,
    47: floats.subf,
    50: lambda dst, src: floats.subf(src, dst),
}
FLOAT_UNARY: dict[int, Callable[[int], floats.Result]] = {
    0: floats.absf,
    14: floats.ldf,
    15: floats.ldf,
    23: floats.negf,
    34: floats.rnd,
    55: floats.toieee,
    57: floats.rsqrf,
    58: floats.rcpf,
}
ROTATES = {
    (35, 0x0001): integers.rol,
    (36, 0x0001): integers.rolc,
    (37, 0xFFFF): integers.ror,
    (38, 0xFFFF): integers.rorc,
}
UNSIGNED_IMMEDIATE = {5, 6, 27, 32, 39, 46, 52, 53, 60}
MEMORY_ONLY = {15, 17, 44, 54, 56}

# Section 6.3 by op5.
THREE_INTEGER: dict[int, Callable[[int, int, int], integers.Result]] = {
    0: integers.addc,
    2: integers.addi,
    3: integers.and_,
    4: integers.andn,
    5: integers.ash,
    8: integers.lsh,
    10: integers.mpyi,
    11: integers.or_,
    12: integers.subb,
    14: integers.subi,
    16: integers.xor,
    17: integers.mpyshi,
    18: integers.mpyuhi,
}
THREE_INTEGER_COMPARE = {7: integers.cmpi, 15: integers.and_}
THREE_FLOAT = {1: floats.addf, 9: floats.mpyf, 13: floats.subf}
THREE_FLOAT_COMPARE = {6: floats.subf}

# Section 6.5 by op5: f(M[I], b, ST) for the integer pairs, f(M[I] as a float, b) for the float pairs.
PARALLEL_INTEGER: dict[int, Callable[[int, int, int], integers.Result]] = {
    5: lambda m, b, st: integers.absi(m, st),
    7: lambda m, b, st: integers.addi(b, m, st),
    8: lambda m, b, st: integers.and_(b, m, st),
    9: lambda m, b, st: integers.ash(m, b, st),
    14: lambda m, b, st: integers.lsh(m, b, st),
    16: lambda m, b, st: integers.mpyi(b, m, st),
    18: lambda m, b, st: integers.negi(m, st),
    19: lambda m, b, st: integers.not_(m, st),
    20: lambda m, b, st: integers.or_(b, m, st),
    22: lambda m, b, st: integers.subi(m, b, st),
    23: lambda m, b, st: integers.xor(b, m, st),
}
PARALLEL_FLOAT: dict[int, Callable[[int, int], floats.Result]] = {
    4: lambda m, b: floats.absf(m),
    6: lambda m, b: floats.addf(b, m),
    15: lambda m, b: floats.mpyf(b, m),
    17: lambda m, b: floats.negf(m),
    21: lambda m, b: floats.subf(m, b),
    24: lambda m, b: floats.toieee(m),
}
TWO_OPERAND_PAIRS = {4, 5, 10, 11, 12, 13, 17, 18, 19, 24, 25}


@dataclass
class Pending:
    """A delayed branch whose slots are being executed."""

    target: int | None  # None: straight on
    slots: int = 3
    annulled: bool = False
    repeats: bool = False  # RPTBD


@dataclass
class Machine:
    r: list[int] = field(default_factory=lambda: [0] * 32)
    ivtp: int = 0
    tvtp: int = 0
    pc: int = 0x1000
    memory: dict[int, int] = field(default_factory=dict)
    bus: list[tuple[str, int, int]] = field(default_factory=list)
    pending: Pending | None = None
    updates: list[tuple[int, int]] = field(default_factory=list)
    started_repeat: bool = False

    # ---- one instruction ----

    def step(self) -> None:
        pc, pending = self.pc, self.pending
        self.pc = (pc + 1) & WORD
        self.updates = []
        if pending is None or not pending.annulled:
            self.execute(pc, self.memory.get(pc, 0))
        if pending is not None:
            pending.slots -= 1
            if pending.slots == 0:
                self.pending = None
                if pending.target is not None:
                    self.pc = pending.target
                if pending.repeats:
                    self.r[ST] |= RM
                return
        self.repeat(pc)

    def repeat(self, pc: int) -> None:
        """8.3 and 8.4; RPTS differs from RPTB in fetching and in interrupts only."""
        if not self.r[ST] & RM or pc != self.r[RE] or self.started_repeat:
            return
        self.r[RC] = (self.r[RC] - 1) & WORD
        if signed(self.r[RC], 32) >= 0:
            self.pc = self.r[RS]
        else:
            self.r[ST] &= ~RM

    def execute(self, pc: int, w: int) -> None:
        self.started_repeat = False
        top = w >> 28
        if top < 2:
            self.general(pc, w)
        elif top < 4:
            self.three_operands(w)
        elif top < 6:
            self.conditional_load(w)
        elif top < 8:
            self.control(pc, w)
        elif top == 8:
            self.multiply_add(w)
        elif top == 11:
            self.part_word(w)
        elif top >= 12:
            self.parallel(w)
        else:
            raise ReservedError(hex(w))

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

    # ---- section 6.1 ----

    def general(self, pc: int, w: int) -> None:
        op, g, dst, src = w >> 23 & 63, w >> 21 & 3, w >> 16 & 31, w & 0xFFFF
        st = self.r[ST]
        if (op, src) in ROTATES and g == 3:
            return self.put_integer(dst, ROTATES[op, src](self.r[dst] & WORD, st))
        if op in (12, 25, 28, 29, 30, 31, 61, 62, 63):
            return self.general_special(op, g, dst, src, pc)
        if 40 <= op <= 43:
            return self.store(op, g, dst, src)
        if op in MEMORY_ONLY and g not in (1, 2):
            raise ReservedError(hex(w))
        operand = self.operand(g, src, src if op in UNSIGNED_IMMEDIATE else signed(src, 16))
        self.settle()
        st = self.r[ST]
        if op in INTEGER_BINARY:
            b = self.integer(operand)
            self.put_integer(dst, INTEGER_BINARY[op](self.r[dst] & WORD, b, st))
        elif op in INTEGER_UNARY:
            self.put_integer(dst, INTEGER_UNARY[op](self.integer(operand), st))
        elif op in INTEGER_COMPARE:
            b = self.integer(operand)
            self.set_flags(INTEGER_COMPARE[op](self.r[dst] & WORD, b, st)[1])
        elif op in FLOAT_BINARY:
            b = self.float_constant(operand, g, src)
            self.put_float(dst, FLOAT_BINARY[op](self.floating(("register", dst)), b))
        elif op in FLOAT_UNARY:
            self.put_float(dst, FLOAT_UNARY[op](self.float_constant(operand, g, src)))
        elif op == 8:
            b = self.float_constant(operand, g, src)
            self.set_flags(floats.subf(self.floating(("register", dst)), b)[1])
        elif op == 10:
            self.put_integer(dst, floats.fix(self.float_constant(operand, g, src)))
        elif op == 11:
            self.put_float(dst, floats.float_(self.integer(operand)))
        elif op == 13:
            self.r[dst] = floats.lde(self.float_constant(operand, g, src), self.r[dst])
        elif op == 18:
            m = (src & 0xFFF) << 20 if g == 3 else self.integer(operand)
            self.put(dst, m)
        elif op == 26:
            raw = (
                from_single_raw(self.integer(operand))
                if operand[0] == "memory"
                else self.float_constant(operand, g, src)
            )
            self.put_float(dst, floats.norm(raw))
        elif op == 39:
            if dst != RC:
                raise ReservedError("RPTS names RC")
            self.start_repeat(self.integer(operand), pc)
        elif op == 46:
            b = self.integer(operand)
            self.put(dst, integers.subc(self.r[dst] & WORD, b))
        elif op == 54:
            self.integer(operand)
        elif op == 56:
            self.put_float(dst, floats.frieee(self.integer(operand)))
        else:
            raise ReservedError(hex(w))

    def float_constant(self, operand: Operand, g: int, src: int) -> int:
        return from_short(src) if g == 3 else self.floating(operand)

    def start_repeat(self, count: int, pc: int) -> None:
        self.r[RC] = count
        self.r[RS] = self.r[RE] = (pc + 1) & WORD
        self.r[ST] |= RM
        self.started_repeat = True

    def general_special(self, op: int, g: int, dst: int, src: int, pc: int) -> None:
        if op == 12:  # IDLE, IDLE2
            self.r[ST] |= GIE
        elif op == 25:  # NOP
            if g == 2:
                self.operand(g, src, 0)
                self.settle()
        elif op in (28, 29):
            word = self.read(self.r[SP])
            self.r[SP] = (self.r[SP] - 1) & WORD
            if op == 28:
                self.put_integer(dst, integers.ldi(word, self.r[ST]))
            else:
                self.set_flags(floats.ldf(from_single_raw(word))[1])
                self.r[dst] = from_single_raw(word)
        elif op in (30, 31):
            self.r[SP] = (self.r[SP] + 1) & WORD
            self.write(self.r[SP], self.r[dst] & WORD if op == 30 else to_single(self.r[dst]))
        elif op == 61:  # LDA
            operand = self.operand(g, src, signed(src, 16))
            self.settle()
            self.r[dst] = self.integer(operand)
        elif op == 62:  # LDPK
            self.r[DP] = src
        else:  # LDHI
            self.put(dst, src << 16)

    def store(self, op: int, g: int, source: int, dst: int) -> None:
        constant = op == 42 and g in (0, 3)  # STIK
        if not constant and g not in (1, 2):
            raise ReservedError("store")
        direct = g == 0 if constant else g == 1
        _, address = self.operand(1 if direct else 2, dst, 0)
        self.settle()
        if constant:
            word = signed(source, 5) & WORD
        else:
            word = to_single(self.r[source]) if op < 42 else self.r[source] & WORD
        self.write(address, word)

    # ---- sections 6.2, 6.3, 6.4 ----

    def part_word(self, w: int) -> None:
        sub, g, dst, src = w >> 23 & 31, w >> 21 & 3, w >> 16 & 31, w & 0xFFFF
        signed_immediate = sub < 4 or 20 <= sub < 22
        operand = self.operand(g, src, signed(src, 16) if signed_immediate else src)
        self.settle()
        a, old = self.integer(operand), self.r[dst] & WORD
        if sub < 20:
            operation = (integers.lb, integers.lbu, integers.lwl, integers.lwr, integers.mb)[sub >> 2]
            self.put_integer(dst, operation(a, old, sub & 3))
        elif sub < 26:
            half = (integers.lh, integers.lhu, integers.mh)[(sub - 20) >> 1]
            self.put_integer(dst, half(a, old, sub & 1))
        else:
            raise ReservedError(hex(w))

    def three_operands(self, w: int) -> None:
        type2, op, t, dst = w >> 28 & 1, w >> 23 & 31, w >> 21 & 3, w >> 16 & 31
        j, i = w >> 8 & 0xFF, w & 0xFF
        is_float = op in THREE_FLOAT or op in THREE_FLOAT_COMPARE
        if type2:
            b: Operand = self.at_offset_byte(i) if t & 1 else ("constant", signed(i, 8))
            a: Operand = self.at_offset_byte(j) if t & 2 else ("register", j)
            if is_float and not t & 1:
                raise ReservedError("no float immediate")
        else:
            # The update of the byte in bits 15..8 is noted last and stays.
            b = self.at_byte(i) if t & 2 else ("register", i)
            a = self.at_byte(j) if t & 1 else ("register", j)
        self.settle()
        if is_float:
            x = self.floating(a)
            y = self.floating(b)
            if op in THREE_FLOAT:
                self.put_float(dst, THREE_FLOAT[op](x, y))
            else:
                self.set_flags(THREE_FLOAT_COMPARE[op](x, y)[1])
            return
        m = self.integer(a)
        n = self.integer(b)
        if op in THREE_INTEGER:
            self.put_integer(dst, THREE_INTEGER[op](m, n, self.r[ST]))
        elif op in THREE_INTEGER_COMPARE:
            self.set_flags(THREE_INTEGER_COMPARE[op](m, n, self.r[ST])[1])
        else:
            raise ReservedError(hex(w))

    def conditional_load(self, w: int) -> None:
        is_float, condition = not w >> 28 & 1, w >> 23 & 31
        g, dst, src = w >> 21 & 3, w >> 16 & 31, w & 0xFFFF
        operand = self.operand(g, src, signed(src, 16))
        self.settle()
        if is_float:
            x = canonical(self.float_constant(operand, g, src))
            if holds(condition, self.r[ST]):
                self.r[dst] = x
        else:
            word = self.integer(operand)
            if holds(condition, self.r[ST]):
                self.put(dst, word)

    # ---- section 6.5 ----

    def parallel(self, w: int) -> None:
        op, a, b, c = w >> 25 & 31, w >> 22 & 7, w >> 19 & 7, w >> 16 & 7
        at_i, at_j = self.at_byte(w & 0xFF), self.at_byte(w >> 8 & 0xFF)
        self.settle()
        if op in (0, 1):
            words = [to_single(self.r[n]) if op == 0 else self.r[n] & WORD for n in (c, a)]
            self.write(at_j[1], words[0])
            self.write(at_i[1], words[1])
            return
        if op in (2, 3):
            if op == 2:
                y, x = self.floating(at_j), self.floating(at_i)
                self.r[b] = y
                self.r[a] = x
            else:
                y, x = self.integer(at_j), self.integer(at_i)
                self.put(b, y)
                self.put(a, x)
            return
        stores_float = op in PARALLEL_FLOAT or op in (11, 12, 25)
        stored = to_single(self.r[c]) if stores_float else self.r[c] & WORD
        self.operate(op, a, b, at_i)
        self.write(at_j[1], stored)

    def operate(self, op: int, a: int, b: int, at_i: Operand) -> None:
        if op in PARALLEL_INTEGER:
            self.put_integer(a, PARALLEL_INTEGER[op](self.integer(at_i), self.r[b] & WORD, self.r[ST]))
        elif op in PARALLEL_FLOAT:
            self.put_float(a, PARALLEL_FLOAT[op](self.floating(at_i), self.r[b]))
        elif op == 10:
            self.put_integer(a, floats.fix(self.floating(at_i)))
        elif op == 11:
            self.put_float(a, floats.float_(self.integer(at_i)))
        elif op == 12:
            self.r[a] = self.floating(at_i)
        elif op == 13:
            self.put(a, self.integer(at_i))
        elif op == 25:
            self.put_float(a, floats.frieee(self.integer(at_i)))
        else:
            raise ReservedError(f"parallel {op}")

    def multiply_add(self, w: int) -> None:
        op, p, product, total = w >> 26 & 3, w >> 24 & 3, w >> 23 & 1, 2 + (w >> 22 & 1)
        k, h = w >> 19 & 7, w >> 16 & 7
        at_i, at_j = self.at_byte(w & 0xFF), self.at_byte(w >> 8 & 0xFF)
        self.settle()
        is_float, subtracts = op < 2, op & 1
        fetch = self.floating if is_float else self.integer
        j, i = fetch(at_j), fetch(at_i)
        kk, hh = (self.r[k], self.r[h]) if is_float else (self.r[k] & WORD, self.r[h] & WORD)
        x, y = ((j, i), (j, kk), (kk, hh), (j, kk))[p]
        u, v = ((kk, hh), (i, hh), (j, i), (hh, i))[p]
        if is_float:
            first = floats.mpyf(x, y)
            second = (floats.subf if subtracts else floats.addf)(u, v)
            self.r[product], self.r[total] = first[0], second[0]
        else:
            st = self.r[ST]
            first = integers.mpyi(x, y, st)
            second = (integers.subi if subtracts else integers.addi)(u, v, st)
            self.put(product, first[0])
            self.put(total, second[0])
        overflow, underflow = first[1].v or second[1].v, first[1].uf or second[1].uf
        self.set_flags(Flags(v=overflow, z=False, n=False, uf=underflow))

    # ---- section 6.6 ----

    def target(self, w: int, pc: int, relative: bool, delayed: bool) -> int:
        if relative:
            return (pc + signed(w, 16) + (3 if delayed else 1)) & WORD
        if w & 0xFFE0:
            raise ReservedError("register field")
        return self.r[w & 31] & WORD

    def go(self, target: int, taken: bool, delayed: bool, annuls: bool = False) -> None:
        if delayed:
            self.pending = Pending(target if taken else None, annulled=annuls)
        elif taken:
            self.pc = target

    def push(self, word: int) -> None:
        self.r[SP] = (self.r[SP] + 1) & WORD
        self.write(self.r[SP], word)

    def enter_handler(self) -> None:
        st = self.r[ST]
        saved = (PGIE if st & GIE else 0) | (PCF if st & CF else 0)
        self.r[ST] = st & ~(GIE | PGIE | PCF) | CF | saved

    def control(self, pc: int, w: int) -> None:
        op = w >> 24 & 31
        relative, condition = bool(w >> 25 & 1), w >> 16 & 31
        if op < 8:
            self.branch_24(pc, w, op)
        elif op in (8, 10):
            kind = w >> 21 & 7
            if kind not in (0, 1, 3, 5):
                raise ReservedError(hex(w))
            taken = holds(condition, self.r[ST])
            self.go(
                self.target(w, pc, relative, kind != 0),
                taken,
                kind != 0,
                kind == 3 and taken or kind == 5 and not taken,
            )
        elif 12 <= op < 16:
            delayed, counter = bool(w >> 21 & 1), AR0 + (w >> 22 & 7)
            target = self.target(w, pc, relative, delayed)
            self.r[counter] = (self.r[counter] - 1) & WORD
            self.go(target, signed(self.r[counter], 32) >= 0 and holds(condition, self.r[ST]), delayed)
        elif op in (16, 18):
            linked = bool(w >> 21 & 1)
            taken = holds(condition, self.r[ST])
            target = self.target(w, pc, relative, linked)
            if linked:
                self.link(pc, target, taken)
            elif taken:
                self.push(pc + 1)
                self.pc = target
        elif op == 20:
            self.trap(pc, w & 0x1FF, bool(w >> 23 & 1), holds(condition, self.r[ST]))
        elif op == 22:
            self.expansion(w)
        elif op == 24:
            self.come_back(w, holds(condition, self.r[ST]))
        elif op == 25:
            self.repeat_block(pc, self.r[w & 31] & WORD, bool(w >> 23 & 1))
        else:
            raise ReservedError(hex(w))

    def link(self, pc: int, target: int, taken: bool) -> None:
        if taken:
            self.put(R11, pc + 4)
        self.go(target, taken, True)

    def branch_24(self, pc: int, w: int, op: int) -> None:
        target = (pc + signed(w, 24) + (3 if op & 1 else 1)) & WORD
        if op < 2:
            self.go(target, True, op == 1)
        elif op == 2:
            self.push(pc + 1)
            self.pc = target
        elif op == 3:
            self.link(pc, target, True)
        elif op < 6:
            self.repeat_block(pc, target, op == 5)
        elif w == 0x66000000:
            raise StopError
        else:
            raise ReservedError(hex(w))

    def repeat_block(self, pc: int, end: int, delayed: bool) -> None:
        self.r[RS] = (pc + (4 if delayed else 1)) & WORD
        self.r[RE] = end
        if delayed:
            self.pending = Pending(None, repeats=True)
        else:
            self.r[ST] |= RM
            self.started_repeat = True

    def trap(self, pc: int, number: int, late: bool, taken: bool) -> None:
        vector = (self.tvtp & TABLE_BASE) + number & WORD
        if not taken:
            return self.go(0, False, late)
        if late:
            target = self.read(vector)
            self.put(R11, pc + 4)
            self.go(target, True, True)
        else:
            self.push(pc + 1)
            self.pc = self.read(vector)
        self.enter_handler()

    def expansion(self, w: int) -> None:
        to_expansion, dst, src = w >> 23 & 1, w >> 16 & 31, w & 31
        if to_expansion:
            word = self.r[src] & TABLE_BASE
            if dst == 0:
                self.ivtp = word
            else:
                self.tvtp = word
        else:
            self.put(dst, self.ivtp if src == 0 else self.tvtp)

    def come_back(self, w: int, taken: bool) -> None:
        from_subroutine, delayed = w >> 23 & 1, bool(w >> 21 & 1)
        if not taken:
            return self.go(0, False, delayed)
        target = self.read(self.r[SP])
        self.r[SP] = (self.r[SP] - 1) & WORD
        if not from_subroutine:
            st = self.r[ST] & ~(GIE | CF)
            self.r[ST] = st | (GIE if st & PGIE else 0) | (CF if st & PCF else 0)
        self.go(target, True, delayed)
