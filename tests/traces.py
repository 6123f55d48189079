"""Compact golden traces: text where it matters, hashes elsewhere (docs/trace.md, Golden traces)."""

import hashlib
from collections.abc import Callable, Iterable
from itertools import groupby

CYCLES_PER_HASH = 2500  # 0.1 ms of a C40-50


def cycle_of(line: str) -> int:
    return int(line.split(" ", 1)[0])


def without_operands(line: str) -> str:
    """A line of a labelled trace as it is hashed: the instruction's mnemonics alone, so that no displacement, no
    immediate value and no spelling of an operand enters; what the operands did stands in the registers and words that
    changed."""
    start, dash, rest = line.partition(" -  ")
    instruction, semicolon, changes = rest.partition("  ;")
    mnemonics = [half.split(None, 1)[0] for half in instruction.split("||") if half.strip()]
    return start + dash + "||".join(mnemonics) + semicolon + changes


def condensed(
    lines: Iterable[str], slot: int, keep: Callable[[int], bool], cycles_per_hash: int = CYCLES_PER_HASH
) -> list[str]:
    """Labelled instruction lines whose cycle is kept, and before each stretch of cycles the hash of all of its
    lines."""
    out = []
    for stretch, group in groupby(lines, key=lambda line: cycle_of(line) // cycles_per_hash):
        text = list(group)
        digest = hashlib.sha256("".join(without_operands(line) + "\n" for line in text).encode()).hexdigest()[:16]
        out.append(f"{stretch * cycles_per_hash} [dsp {slot}] - -  instructions  ; count={len(text)} sha256={digest}")
        out += [line for line in text if keep(cycle_of(line))]
    return out
