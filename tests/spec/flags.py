"""ST, and its new value from an operation's flags (c40-isa.md 1.4 and 5)."""

from __future__ import annotations

from typing import NamedTuple

C, V, Z, N, UF, LV, LUF, OVM, RM, PCF, CF, CE, CC, GIE, PGIE, SET_COND = (1 << n for n in range(16))
IMPLEMENTED = 0xFFFF & ~CC  # CC reads back 0


class Flags(NamedTuple):
    """None: the flag stays."""

    c: bool | None = None
    v: bool | None = None
    z: bool | None = None
    n: bool | None = None
    uf: bool | None = None


def applied(st: int, flags: Flags | None) -> int:
    if flags is None:
        return st
    for bit, flag in zip((C, V, Z, N, UF), flags, strict=True):
        if flag is not None:
            st = st | bit if flag else st & ~bit
    if flags.v:
        st |= LV
    if flags.uf:
        st |= LUF
    return st


# c40-isa.md 4, by code; None is reserved.
CONDITIONS = (
    lambda st: True,
    lambda st: st & C,
    lambda st: st & (C | Z),
    lambda st: not st & (C | Z),
    lambda st: not st & C,
    lambda st: st & Z,
    lambda st: not st & Z,
    lambda st: st & N,
    lambda st: st & (N | Z),
    lambda st: not st & (N | Z),
    lambda st: not st & N,
    None,
    lambda st: not st & V,
    lambda st: st & V,
    lambda st: not st & UF,
    lambda st: st & UF,
    lambda st: not st & LV,
    lambda st: st & LV,
    lambda st: not st & LUF,
    lambda st: st & LUF,
    lambda st: st & (Z | UF),
)
CONDITION_NAMES = [
    "u",
    "lo",
    "ls",
    "hi",
    "hs",
    "eq",
    "ne",
    "lt",
    "le",
    "gt",
    "ge",
    "-",
    "nv",
    "v",
    "nuf",
    "uf",
    "nlv",
    "lv",
    "nluf",
    "luf",
    "zuf",
]


def holds(condition: int, st: int) -> bool:
    test = CONDITIONS[condition]
    assert test is not None, "reserved condition"
    return bool(test(st))
