"""The single-step vector format (README of the outside evidence; rulings.md 30): read a line, run it, say what differs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

EXTENDED = {f"R{n}" for n in range(12)}
START = 0x1000


@dataclass
class Vector:
    name: str = ""
    st_mask: int = 0xFFFFFFFF
    before: dict[str, int] = field(default_factory=dict)
    memory: dict[int, int] = field(default_factory=dict)
    words: list[int] = field(default_factory=list)
    steps: int = 1
    after: dict[str, int] = field(default_factory=dict)
    memory_after: dict[int, int] = field(default_factory=dict)


def parse(line: str) -> Vector:
    """Unknown tokens are errors."""
    vector = Vector()
    left, right = line.split("->")
    for token in left.split():
        key, text = token.split("=")
        if key == "id":
            vector.name = text
        elif key == "m":
            vector.st_mask = int(text, 16)
        elif key == "op":
            vector.words.append(int(text, 16))
        elif key == "steps":
            vector.steps = int(text)
        elif key.startswith("@"):
            vector.memory[int(key[1:], 16)] = int(text, 16)
        elif len(text) == (10 if key in EXTENDED else 8):
            vector.before[key] = int(text, 16)
        else:
            raise ValueError(f"unknown token {token}")
    for token in right.split():
        key, text = token.split("=")
        if key.startswith("@"):
            vector.memory_after[int(key[1:], 16)] = int(text, 16)
        else:
            vector.after[key] = int(text, 16)
    return vector


def differences(processor: Any, vector: Vector) -> list[str]:
    """Runs the vector on a flat-board processor whose memory is all zero, and leaves it so."""
    for index, word in enumerate(vector.words):
        processor.poke(START + index, word)
    for address, value in vector.memory.items():
        processor.poke(address, value)
    # ST comes last: RM depends on RC.
    for name, value in sorted(vector.before.items(), key=lambda item: item[0] == "ST"):
        processor.set(name, value)
    processor.pc = START
    found = []
    for _ in range(vector.steps):
        stop = processor.step()
        if stop["reason"] != "limit":
            found.append(f"stopped: {stop}")
    expected = vector.before | vector.after
    for name, value in expected.items():
        if name == "PC":
            actual = processor.pc
        else:
            actual = processor.get(name)
        mask = vector.st_mask if name == "ST" else 0xFFFFFFFFFF
        if (actual ^ value) & mask:
            found.append(f"{name}: {actual:X}, expected {value:X}")
    memory = vector.memory | vector.memory_after
    for address, value in memory.items():
        actual = processor.peek(address)
        if actual != value:
            found.append(f"@{address:06X}: {actual:08X}, expected {value:08X}")
        processor.poke(address, 0)
    return found
