"""The instruction set: from words to text, to operands, and the table of encodings."""

from __future__ import annotations

import numbers
from collections.abc import Sequence
from typing import Any, overload

from cmrc import _core, arguments
from cmrc.programs import A_CPU

A_WORD = "a 32-bit word (0 to FFFFFFFFh)"


@overload
def disassemble(words: int, pc: int = 0, *, cpu: str = "c40") -> str: ...
@overload
def disassemble(words: Sequence[int], pc: int = 0, *, cpu: str = "c40") -> list[str]: ...
def disassemble(words: int | Sequence[int], pc: int = 0, *, cpu: str = "c40") -> str | list[str]:
    """The instruction of a word, or of each word from address ``pc`` on, for the processor ``cpu`` (``c40``, ``c3x``).
    Reserved words give ``.word``."""
    processor = _processor(cpu)
    at = arguments.whole("pc", pc, "an address (0 to FFFFFFFFh)")
    if isinstance(words, numbers.Integral):
        return str(_core.isa.disassemble(arguments.whole("words", words, A_WORD), at, cpu=processor))
    all_words = arguments.items("words", words, "a word or a list of words")
    checked = [arguments.whole(f"words[{i}]", word, A_WORD) for i, word in enumerate(all_words)]
    return [str(_core.isa.disassemble(word, at + i & 0xFFFF_FFFF, cpu=processor)) for i, word in enumerate(checked)]


def decode(word: int, *, cpu: str = "c40") -> dict[str, Any] | None:
    """The instruction that a 32-bit word is, for the processor ``cpu`` (``c40``, ``c3x``); None for a reserved word.

    ``mnemonic``, ``operation``, ``condition``; ``mnemonic2`` and ``operation2`` of the second half of a parallel
    instruction. ``src1`` to ``src4``, ``dst``, ``dst2``: each operand as a dict with its ``kind``, ``register`` or
    ``value``, or None. ``hazards``: the registers that each stage of the pipeline reads and writes, and how often the
    instruction reads and writes memory. ``row``: place of its encoding in ``encodings()``.
    """
    return _core.isa.decode(arguments.whole("word", word, A_WORD), _processor(cpu))


def encodings(*, cpu: str = "c40") -> list[dict[str, Any]]:
    """The table of the instruction set, a row per encoding (docs/reference/c40-isa.md).

    ``picture``: 32 bits, most significant first; 0 and 1 are fixed, a letter is a field. ``mask`` and ``match``: word &
    mask = match holds for each word of the encoding; where it holds for two encodings, the one with more fixed bits is
    meant. ``mnemonic``, ``operation``; ``mnemonic2`` and ``operation2`` of the
    second half of a parallel instruction. ``flags``: class of the flags that it sets. ``cycles``: without stalls.
    ``conditional``, ``c4x_only``: True or False. ``section``: of docs/reference/c40-isa.md.
    """
    return _core.isa.rows(_processor(cpu))


def _processor(cpu: object) -> str:
    return arguments.text("cpu", cpu, A_CPU)
