"""Which of the 2^32 words are instructions (sections 3, 4, 6 and 12); every other word is reserved."""

from __future__ import annotations

from .encodings import GENERAL, THREE_OPERAND_PAIRS
from .machine import is_extended

MODES: dict[int, tuple[str, str, str]] = {}
for _entry in GENERAL.replace("|", "\n").split("\n"):
    if _entry.strip():
        _op, _name, _modes, _source, _destination = _entry.split()
        MODES[int(_op)] = (_modes, _source, _destination)

NO_DESTINATION = {54}  # IACK: the field is 0
WHOLE_WORDS = {0x06000000, 0x06000001, 0x0C800000, 0x66000000}


def may_be(kind: str, code: int) -> bool:
    """f: R0 to R11; n: any; a: what LDA loads."""
    return kind == "n" or (is_extended(code) if kind == "f" else 8 <= code <= 20)


def is_condition(code: int) -> bool:
    return code <= 20 and code != 11


def indirect_16(src: int) -> bool:
    modn = src >> 11
    return modn <= 25 and (modn < 8 or src & 0xFF == 0)


def indirect_8(byte: int) -> bool:
    return byte >> 3 <= 25


def source(kind: str, modes: str, g: int, src: int) -> bool:
    if "rdim"[g] not in modes:
        return False
    if g == 0:
        return src < 32 and may_be(kind, src)
    return g != 2 or indirect_16(src)


def general(w: int) -> bool:
    op, g, dst, src = w >> 23 & 63, w >> 21 & 3, w >> 16 & 31, w & 0xFFFF
    if w in WHOLE_WORDS:
        return True
    if op == 25:  # NOP *ind
        return g == 2 and dst == 0 and indirect_16(src)
    if op in (28, 29, 30, 31):
        return g == 1 and src == 0 and (op in (28, 30) or is_extended(dst))
    if op in (35, 36, 37, 38):
        return g == 3 and src == (1 if op < 37 else 0xFFFF)
    if op == 39:
        return dst == 27 and source("n", "rdim", g, src)
    if op == 42:  # STI, STIK
        return g in (0, 1) or indirect_16(src)
    if op == 54:
        return dst == 0 and source("n", "di", g, src)
    if op == 61 and g == 0 and src == dst:
        return False
    if op == 62:
        return g == 3 and dst == 16
    if op == 63:
        return g == 3
    if op not in MODES:
        return False
    modes, kind, destination = MODES[op]
    return source(kind, modes, g, src) and may_be(destination, dst)


def part_word(w: int) -> bool:
    return w >> 23 & 31 < 26 and source("n", "rdim", w >> 21 & 3, w & 0xFFFF)


def three_operands(w: int) -> bool:
    type2, op, t, dst, j, i = w >> 28 & 1, w >> 23 & 31, w >> 21 & 3, w >> 16 & 31, w >> 8 & 0xFF, w & 0xFF
    if op > 18 or (op in (6, 7, 15) and dst):
        return False
    kind = "f" if op in (1, 6, 9, 13) else "n"
    if op not in (6, 7, 15) and not may_be(kind, dst):
        return False

    def register(byte: int) -> bool:
        return byte < 32 and may_be(kind, byte)

    if type2:
        return (bool(t & 2) or register(j)) and (bool(t & 1) or kind == "n")
    return (indirect_8(j) if t & 1 else register(j)) and (indirect_8(i) if t & 2 else register(i))


def control(w: int) -> bool:
    op, relative, condition, field = w >> 24 & 31, w >> 25 & 1, w >> 16 & 31, w & 0xFFFF
    if op < 6:
        return True
    if op in (8, 10):
        return w >> 21 & 7 in (0, 1, 3, 5) and is_condition(condition) and (bool(relative) or field < 32)
    if 12 <= op < 16:
        return is_condition(condition) and (bool(relative) or field < 32)
    if op in (16, 18):
        return w >> 22 & 7 == 0 and is_condition(condition) and (bool(relative) or field < 32)
    if op == 20:
        return w >> 21 & 3 == 0 and is_condition(condition) and field < 512
    if op == 22:
        dst = w >> 16 & 31
        return w >> 21 & 3 == 0 and field < 32 and (dst < 2 if w >> 23 & 1 else field < 2)
    if op == 24:
        return w >> 22 & 1 == 0 and not (w >> 23 & 1 and w >> 21 & 1) and is_condition(condition) and field == 0
    return op == 25 and w & 0x7FFFE0 == 0


def parallel(w: int) -> bool:
    op, b, c = w >> 25 & 31, w >> 19 & 7, w >> 16 & 7
    if op > 25 or not (indirect_8(w >> 8 & 0xFF) and indirect_8(w & 0xFF)):
        return False
    if op in (2, 3):
        return c == 0
    return op in THREE_OPERAND_PAIRS or b == 0


def is_instruction(w: int) -> bool:
    top = w >> 28
    if top < 2:
        return general(w)
    if top < 4:
        return three_operands(w)
    if top < 6:
        kind = "fn"[top & 1]
        return (
            is_condition(w >> 23 & 31) and source(kind, "rdim", w >> 21 & 3, w & 0xFFFF) and may_be(kind, w >> 16 & 31)
        )
    if top < 8:
        return w in WHOLE_WORDS or control(w)
    if top == 8:
        return indirect_8(w >> 8 & 0xFF) and indirect_8(w & 0xFF)
    if top == 11:
        return part_word(w)
    return top >= 12 and parallel(w)
