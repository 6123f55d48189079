"""Integer arithmetic, logic, shifts and part-words (c40-isa.md 5, 6.1 to 6.3, 7.8, 7.9, 7.11) in unlimited integers.

Every function takes 32-bit words (a the minuend or the value shifted, b the other source) and ST, and gives (word,
flags).
"""

from __future__ import annotations

from .flags import OVM, C, Flags
from .formats import signed

Result = tuple[int, Flags]
WORD = 0xFFFFFFFF
LOWEST, HIGHEST = -(1 << 31), (1 << 31) - 1


def fits(i: int) -> bool:
    return LOWEST <= i <= HIGHEST


def arithmetic(true: int, carry: bool | None, st: int, saturates: bool = True) -> Result:
    """Classes A and B: V and N from the true result, Z from what is written."""
    overflow = not fits(true)
    out = true
    if overflow and st & OVM and saturates:
        out = LOWEST if true < 0 else HIGHEST
    out &= WORD
    return out, Flags(c=carry, v=overflow, z=out == 0, n=true < 0, uf=False)


def sum_of(a: int, b: int, carry: int, st: int) -> Result:
    return arithmetic(signed(a, 32) + signed(b, 32) + carry, a + b + carry > WORD, st)


def difference_of(a: int, b: int, borrow: int, st: int, saturates: bool = True) -> Result:
    return arithmetic(signed(a, 32) - signed(b, 32) - borrow, a - b - borrow < 0, st, saturates)


def addi(a: int, b: int, st: int) -> Result:
    return sum_of(a, b, 0, st)


def addc(a: int, b: int, st: int) -> Result:
    return sum_of(a, b, st & C, st)


def subi(a: int, b: int, st: int) -> Result:
    return difference_of(a, b, 0, st)


def subb(a: int, b: int, st: int) -> Result:
    return difference_of(a, b, st & C, st)


def cmpi(a: int, b: int, st: int) -> Result:
    return difference_of(a, b, 0, st, saturates=False)


def negi(a: int, st: int) -> Result:
    return difference_of(0, a, 0, st)


def negb(a: int, st: int) -> Result:
    return difference_of(0, a, st & C, st)


def absi(a: int, st: int) -> Result:
    return arithmetic(abs(signed(a, 32)), None, st)


def mpyi(a: int, b: int, st: int) -> Result:
    return arithmetic(signed(a, 32) * signed(b, 32), None, st)


def output_only(word: int) -> Result:
    """Class L, and the high products, which cannot overflow."""
    word &= WORD
    return word, Flags(v=False, z=word == 0, n=word >> 31 == 1, uf=False)


def mpyshi(a: int, b: int, st: int) -> Result:
    return output_only(signed(a, 32) * signed(b, 32) >> 32)


def mpyuhi(a: int, b: int, st: int) -> Result:
    return output_only(a * b >> 32)


def and_(a: int, b: int, st: int) -> Result:
    return output_only(a & b)


def andn(a: int, b: int, st: int) -> Result:
    return output_only(a & ~b)


def or_(a: int, b: int, st: int) -> Result:
    return output_only(a | b)


def xor(a: int, b: int, st: int) -> Result:
    return output_only(a ^ b)


def not_(a: int, st: int) -> Result:
    return output_only(~a)


def ldi(a: int, st: int) -> Result:
    return output_only(a)


def shifted(word: int, carry: bool, overflow: bool = False) -> Result:
    word, flags = output_only(word)
    return word, flags._replace(c=carry, v=overflow)


def count_of(b: int) -> int:
    return signed(b, 7)


def left(a: int, n: int) -> tuple[int, bool]:
    """The last bit shifted out is C; beyond 32 places it is the lowest bit."""
    if n == 0:
        return a, False
    return a << n, bool(a >> max(32 - n, 0) & 1)


def lsh(a: int, b: int, st: int) -> Result:
    n = count_of(b)
    if n >= 0:
        return shifted(*left(a, n))
    return shifted(a >> -n, bool(a >> (-n - 1) & 1))


def ash(a: int, b: int, st: int) -> Result:
    n = count_of(b)
    i = signed(a, 32)
    if n >= 0:
        return shifted(*left(a, n), overflow=not fits(i << n))
    return shifted(i >> -n, bool(i >> (-n - 1) & 1))


def rol(a: int, st: int) -> Result:
    return shifted(a << 1 | a >> 31, bool(a >> 31))


def rolc(a: int, st: int) -> Result:
    return shifted(a << 1 | st & C, bool(a >> 31))


def ror(a: int, st: int) -> Result:
    return shifted(a >> 1 | a << 31, bool(a & 1))


def rorc(a: int, st: int) -> Result:
    return shifted(a >> 1 | (st & C) << 31, bool(a & 1))


def subc(a: int, b: int) -> int:
    """7.9: one step of unsigned division, no flags."""
    return (((a - b) << 1 | 1) if a >= b else a << 1) & WORD


# Part-words (c40-isa.md 6.2): `old` is dst before.


def lb(a: int, old: int, byte: int) -> Result:
    return output_only(signed(a >> 8 * byte, 8))


def lbu(a: int, old: int, byte: int) -> Result:
    return output_only(a >> 8 * byte & 0xFF)


def lh(a: int, old: int, half: int) -> Result:
    return output_only(signed(a >> 16 * half, 16))


def lhu(a: int, old: int, half: int) -> Result:
    return output_only(a >> 16 * half & 0xFFFF)


def lwl(a: int, old: int, count: int) -> Result:
    return output_only(a << 8 * count | old & (1 << 8 * count) - 1)


def lwr(a: int, old: int, count: int) -> Result:
    return output_only(a >> 8 * count | old & ~(WORD >> 8 * count))


def replaced(a: int, old: int, at: int, width: int) -> Result:
    field = (1 << width) - 1
    return output_only(old & ~(field << at) | (a & field) << at)


def mb(a: int, old: int, byte: int) -> Result:
    return replaced(a, old, 8 * byte, 8)


def mh(a: int, old: int, half: int) -> Result:
    return replaced(a, old, 16 * half, 16)
