"""Golden traces in little room: full text where it matters, hashes of the text elsewhere (docs/trace.md)."""

import hashlib
from collections.abc import Callable, Iterable
from itertools import groupby

CYCLES_PER_HASH = 2500  # 0.1 ms of a C40-50


def cycle_of(line: str) -> int:
    return int(line.split(" ", 1)[0])


def condensed(lines: Iterable[str], slot: int, keep: Callable[[int], bool]) -> list[str]:
    """Instruction lines whose cycle is kept, and before each stretch of cycles the hash of all of its lines."""
    out = []
    for stretch, group in groupby(lines, key=lambda line: cycle_of(line) // CYCLES_PER_HASH):
        text = list(group)
        digest = hashlib.sha256("".join(line + "\n" for line in text).encode()).hexdigest()[:16]
        out.append(
            f"{stretch * CYCLES_PER_HASH} [dsp {slot}] -------- --------  instructions  ; count={len(text)} sha256={digest}"
        )
        out += [line for line in text if keep(cycle_of(line))]
    return out
