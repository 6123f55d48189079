"""Program control (c40-isa.md 6.6 and 8)."""

from __future__ import annotations

from .flags import CF, GIE, PCF, PGIE, RM, holds
from .formats import signed
from .state import AR0, R11, RC, RE, RS, SP, ST, TABLE_BASE, WORD, Pending, ReservedError, State, StopError


class Flow(State):
    def repeat(self, pc: int) -> None:
        """8.3 and 8.4; RPTS differs from RPTB in fetching and in interrupts only."""
        if not self.r[ST] & RM or pc != self.r[RE] or self.started_repeat:
            return
        self.r[RC] = (self.r[RC] - 1) & WORD
        if signed(self.r[RC], 32) >= 0:
            self.pc = self.r[RS]
        else:
            self.r[ST] &= ~RM

    def start_repeat(self, count: int, pc: int) -> None:
        self.r[RC] = count
        self.r[RS] = self.r[RE] = (pc + 1) & WORD
        self.r[ST] |= RM
        self.started_repeat = True

    # ---- c40-isa.md 6.6 ----

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
