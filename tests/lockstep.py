"""Two processors behind the interface of one: one program timed in two ways, run in many pieces, compared after each.

It replaces `cmrc._core.c40.Processor`, so any code that runs a program can use it. A further way of timing is one
more line of WAYS.
"""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from cmrc._core import c40

WAYS: dict[str, Callable[[Any], None]] = {
    "exact": lambda core: core.set_exact(True),  # one instruction at a time; blocks are what it is compared with
}
REGISTERS = [f"R{n}" for n in range(12)] + [f"AR{n}" for n in range(8)]
REGISTERS += ["DP", "IR0", "IR1", "BK", "SP", "ST", "DIE", "IIE", "IIF", "RS", "RE", "RC", "IVTP", "TVTP"]
RAM = (0x2FF800, 0x800)
PIECES = [1, 2, 3, 7, 20, 64, 150, 1000, 7000, 30000]


def state(core: Any) -> dict[str, Any]:
    out: dict[str, Any] = {name: core.get(name) for name in REGISTERS}
    out |= {
        "pc": core.pc,
        "cycle": core.cycle,
        "instructions": core.instructions,
        "idle": core.idle,
        "halted": core.halted,
    }
    return out | core.causes | {"ram": core.read(*RAM)}


class Processor:
    """Passes each call to both processors; both answers must be equal."""

    points = 0  # at which any of them was compared
    cycles = 0  # that any of them ran

    def __init__(self, way: str, *arguments: Any) -> None:
        self._cores = [_Core(*arguments), _Core(*arguments)]
        WAYS[way](self._cores[1])
        self._rng = random.Random(40)
        self._compared_memory = 0

    def _both(self, ask: Callable[[Any], Any], what: str) -> Any:
        first, second = (ask(core) for core in self._cores)
        assert first == second, (what, self._cores[0].pc, self._cores[0].cycle)
        return first

    def _compare(self) -> None:
        Processor.points += 1
        first, second = (state(core) for core in self._cores)
        differing = {name: (first[name], second[name]) for name in first if first[name] != second[name]}
        assert not differing, differing
        assert sum(self._cores[0].causes.values()) == first["cycle"]
        if first["cycle"] - self._compared_memory > 100_000:
            self.compare_memory()

    def compare_memory(self) -> None:
        self._compared_memory = self._both(lambda core: core.cycle, "cycle")
        self._both(lambda core: core.digest(), "memory")

    def run(self, max_cycles: int, until: int | None = None) -> dict[str, Any]:
        began = self._cores[0].cycle
        end = began + max_cycles
        if until is not None:
            self._both(lambda core: core.add_breakpoint(until), "breakpoint")
        for number in itertools.count():
            growing = self._rng.choice(PIECES) << number // 100  # a limit may be far away
            piece = min(growing, end - self._cores[0].cycle)
            stop: dict[str, Any] = self._both(lambda core, piece=piece: core.run(piece), "stop")  # type: ignore[misc]
            self._compare()
            if stop["reason"] != "limit" or self._cores[0].cycle >= end:
                break
        if until is not None:
            self._both(lambda core: core.remove_breakpoint(until), "breakpoint")
        Processor.cycles += self._cores[0].cycle - began
        return stop

    def __getattr__(self, name: str) -> Any:
        if callable(getattr(self._cores[0], name)):
            return lambda *arguments, **keywords: self._both(
                lambda core: getattr(core, name)(*arguments, **keywords), name
            )
        return self._both(lambda core: getattr(core, name), name)

    @property
    def pc(self) -> int:
        return int(self._both(lambda core: core.pc, "pc"))

    @pc.setter
    def pc(self, address: int) -> None:
        for core in self._cores:
            core.pc = address


_Core = c40.Processor


@contextmanager
def processors(way: str, keep: bool = True) -> Iterator[list[Processor]]:
    """Inside, every new processor is one of these; those that are kept have their memories compared at the end."""
    made: list[Processor] = []

    def make(*arguments: Any) -> Processor:
        processor = Processor(way, *arguments)
        if keep:
            made.append(processor)
        return processor

    c40.Processor = make  # type: ignore[assignment, misc]
    try:
        yield made
        for processor in made:
            processor.compare_memory()
    finally:
        c40.Processor = _Core  # type: ignore[misc]
