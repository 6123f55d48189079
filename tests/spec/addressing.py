"""Indirect addressing (c40-isa.md 3.9): the address, and the new value of ARn."""

from __future__ import annotations

WORD = 0xFFFFFFFF
PLAIN, BIT_REVERSED = 24, 25


def circular(ar: int, step: int, bk: int) -> int:
    """step may be negative. One correction, and the sum is not masked again."""
    mask = (1 << bk.bit_length()) - 1
    index = (ar & mask) + step
    if index >= bk:
        index -= bk
    elif index < 0:
        index += bk
    return ((ar & ~mask) + index) & WORD


def reversed_bits(word: int) -> int:
    return int(f"{word:032b}"[::-1], 2)


def bit_reversed(ar: int, step: int) -> int:
    return reversed_bits((reversed_bits(ar) + reversed_bits(step)) & WORD)


def modifies(modn: int) -> bool:
    return modn == BIT_REVERSED or (modn < PLAIN and modn & 7 >= 2)


def indirect(modn: int, ar: int, displacement: int, ir0: int, ir1: int, bk: int) -> tuple[int, int]:
    """(address, new ARn)."""
    if modn == PLAIN:
        return ar, ar
    if modn == BIT_REVERSED:
        return ar, bit_reversed(ar, ir0)
    size = (displacement, ir0, ir1)[modn >> 3]
    action = modn & 7
    step = -size if action & 1 else size
    moved = (ar + step) & WORD
    if action < 2:
        return moved, ar
    if action < 4:
        return moved, moved
    return ar, moved if action < 6 else circular(ar, step, bk)
