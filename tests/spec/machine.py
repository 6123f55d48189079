"""What every instruction does (c40-isa.md 6 and 8). There are no interrupts and no time."""

from __future__ import annotations

from collections.abc import Callable

from . import floats, integers
from .flags import GIE, RM, Flags, holds
from .flow import Flow
from .formats import canonical, from_short, from_single_raw, signed, to_single
from .state import DP, RC, SP, ST, WORD, Operand, ReservedError

# c40-isa.md 6.1 by op6: what is computed from dst and src. Sources are integers or floats as the table's column says.
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

# c40-isa.md 6.3 by op5.
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

# c40-isa.md 6.5 by op5: f(M[I], b, ST) for the integer pairs, f(M[I] as a float, b) for the float pairs.
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


class Machine(Flow):
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

    # ---- c40-isa.md 6.1 ----

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

    # ---- c40-isa.md 6.2, 6.3, 6.4 ----

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

    # ---- c40-isa.md 6.5 ----

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
