"""Runs of nasty programs (nasty_programs.py): `disagreement` runs a program in every way and says where two runs
differ; `shrink` makes a program that fails smaller.

Nothing here knows how the chip is emulated. The only oracle: a run does not depend on how it is cut or observed.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from cmrc import c40 as package
from cmrc._core import c40, toolchain
from cmrc.network import Network
from nasty_programs import BOARD, CODE, CYCLES, DATA, STACK, TRAPS, VECTORS, Program


class Bench:
    """Boards as files in a directory."""

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self._boards: dict[str, str] = {}

    def board(self, program: Program) -> str:
        text = BOARD.format(**program.waits)
        if text not in self._boards:
            path = self.directory / f"board{len(self._boards)}.toml"
            path.write_text(text)
            self._boards[text] = str(path)
        return self._boards[text]


def assembled(program: Program) -> Any:
    return toolchain.assemble(
        program.text, f"nasty{program.seed}.asm", sections={".text": CODE[program.places["code"]]}
    )


def prepare(chip: Any, program: Program, symbols: dict[str, int]) -> None:
    places = program.places
    vectors, traps = VECTORS[places["vectors"]], TRAPS[places["traps"]]
    for n in (2, 3, 4, 5, 6, *range(0x25, 0x2C)):
        chip.poke(vectors + n, symbols["isr"])
    chip.poke(vectors + 1, symbols["nmi"])
    chip.poke(traps + 3, symbols["trap3"])
    chip.poke(traps + 4, symbols["trap4"])
    values = program.registers | {"AR3": program.rounds, "AR4": DATA[places["ar4"]] & ~15, "AR5": DATA[places["ar5"]] + 0x30 & ~15, "BK": 16, "SP": STACK[places["stack"]],
                                  "IVTP": vectors, "TVTP": traps, "R0": 5, "R1": 3, "R2": 9, "R3": 0, "R7": 0, "AR6": 0x100000}  # fmt: skip
    for name, value in values.items():
        chip.set(name, value)
    for n, registers in program.channels.items():
        for register, (symbol, offset) in registers.items():
            chip.poke(0x1000A0 + 16 * n + register, (symbols[symbol] if symbol else 0) + offset)


def made(program: Program, board: str, image: Any, checks: bool = False) -> Any:
    chip = c40.Processor(board, checks)
    chip.load_image(image)
    prepare(chip, program, image.symbols)
    chip.record_events()
    return chip


def state(chip: Any) -> tuple[bytes, int]:
    return chip.snapshot(), chip.digest()


Outcome = tuple[dict[str, Any], tuple[bytes, int], list[Any]]


class Pins:
    """Pins that are raised between two instructions, in the first such cycle at or after the time of each."""

    def __init__(self, program: Program) -> None:
        self._left = list(program.pins)

    def next(self) -> int:
        return self._left[0][0] if self._left else CYCLES

    def raise_due(self, chip: Any) -> None:
        while self._left and self._left[0][0] <= chip.cycle:
            pin = self._left.pop(0)[1]
            if pin == 4:
                chip.raise_nmi()
            else:
                chip.raise_iiof(pin)


def drive(
    chip: Any,
    program: Program,
    advance: Callable[[Any, int], dict[str, Any]],
    seen: Callable[[Any], None] | None = None,
) -> Outcome:
    """Drives a chip. `advance(chip, cycle)` runs to that cycle at most; only the last instruction may end after it."""
    pins = Pins(program)
    stop: dict[str, Any] = {}
    while chip.cycle < CYCLES:
        pins.raise_due(chip)
        stop = advance(chip, min(pins.next(), CYCLES))
        if stop["reason"] != "limit":
            break
        if seen is not None:
            seen(chip)
    return stop, state(chip), list(chip.events)


def difference(program: Program, way: str, chip: Any, other: Any) -> str:
    """The differences between two chips that should be equal."""
    lines = [f"seed {program.seed}, {way}, cycles {chip.cycle} and {other.cycle}"]
    for name in package.REGISTERS:
        if chip.get(name) != other.get(name):
            lines.append(f"  {name}: {chip.get(name):X} {other.get(name):X}")
    lines.append(f"  pc: {chip.pc:08X} {other.pc:08X}")
    for what, first, second in (
        ("cause", chip.causes, other.causes),
        ("peripheral", chip.peripherals(), other.peripherals()),
    ):
        lines += [f"  {what} {name}: {first[name]:X} {second[name]:X}" for name in first if first[name] != second[name]]
    return "\n".join(lines)


def disagreement(program: Program, bench: Bench) -> str | None:
    """Runs the program by single steps; in one piece by blocks, and with every instruction timed; cut at random cycles
    in both ways; with the self-checks; in a network."""
    board, image = bench.board(program), assembled(program)
    rng = random.Random(program.seed)
    instants: dict[int, tuple[bytes, int]] = {}

    def note(chip: Any) -> None:
        instants[chip.cycle] = state(chip)

    reference = made(program, board, image)
    note(reference)
    expected = drive(reference, program, lambda chip, cycle: chip.step(), note)  # type: ignore[no-any-return]
    note(reference)

    def difference_from_steps(way: str, chip: Any, outcome: Outcome) -> str | None:
        stop, last, events = outcome
        if expected[0] != stop:
            return f"seed {program.seed}, {way}: stops {expected[0]} {stop}\n" + difference(
                program, way, reference, chip
            )
        if expected[1] != last:
            return difference(program, way, reference, chip)
        if expected[2] != events:
            at = next(
                i
                for i, pair in enumerate(zip([*expected[2], None], [*events, None], strict=False))
                if pair[0] != pair[1]
            )
            return f"seed {program.seed}, {way}: event {at} of {len(expected[2])}: {expected[2][at : at + 3]} {events[at : at + 3]}"
        return None

    def whole(chip: Any, cycle: int) -> dict[str, Any]:
        return chip.run(max(cycle - chip.cycle, 1))  # type: ignore[no-any-return]

    def cut(chip: Any, cycle: int) -> dict[str, Any]:
        return chip.run(min(rng.choice([1, 1, 2, 3, 7, 20, 64, 150]), max(cycle - chip.cycle, 1)))  # type: ignore[no-any-return]

    for way, advance, exact, checks in (("whole", whole, False, False), ("exact", whole, True, False), ("cut", cut, False, False), ("cut exact", cut, True, False),
                                        ("checked", whole, False, True), ("checked and cut", cut, False, True)):  # fmt: skip
        chip = made(program, board, image, checks)
        chip.set_exact(exact)
        wrong: list[str] = []

        def compare(chip: Any, way: str = way, wrong: list[str] = wrong) -> None:
            if not wrong and chip.cycle in instants and instants[chip.cycle] != state(chip):
                again = made(program, board, image)
                drive(
                    again,
                    replace(program, pins=tuple(p for p in program.pins if p[0] < chip.cycle)),
                    lambda c, _: c.step() if c.cycle < chip.cycle else {"reason": "there"},
                )
                wrong.append(difference(program, f"{way}, in between", again, chip))
            if not wrong and chip.cycle not in instants:
                wrong.append(f"seed {program.seed}, {way}: no instruction ended in cycle {chip.cycle} by single steps")

        found = difference_from_steps(way, chip, drive(chip, program, advance, compare))
        if wrong or found:
            return wrong[0] if wrong else found
    return None if program.pins else in_network(program, board, image, instants)


def in_network(program: Program, board: str, image: Any, instants: dict[int, tuple[bytes, int]]) -> str | None:
    """In a network with a neighbour that does not affect the chip, in one piece and in slices: always as the chip
    alone."""
    rng = random.Random(program.seed)
    neighbour = package.assemble("        .text\nstart:  bu start\n")
    for slices in (False, True):
        network = Network([image, neighbour], links=["0.3:1.0"], boards=board, clocks_mhz=list(program.clocks))
        chip = network.chips[0]._core
        prepare(chip, program, image.symbols)
        end = CYCLES * 2 / program.clocks[0]
        now = 0.0
        while now < end:
            now = min(end, now + rng.uniform(0.05, 8)) if slices else end
            stop = network.run(until_us=now)
            settled = network.chips[0].status not in ("waiting", "external_access")
            if settled and chip.cycle in instants and instants[chip.cycle] != (chip.snapshot(), chip.digest()):
                again = made(program, board, image)
                there = chip.cycle
                drive(again, program, lambda c, _, there=there: c.step() if c.cycle < there else {"reason": "there"})  # type: ignore[misc]
                return difference(program, f"network, {'slices' if slices else 'whole'}", again, chip)
            if settled and chip.cycle not in instants and chip.cycle < CYCLES:
                return f"seed {program.seed}: in the network, an instruction ended in cycle {chip.cycle}"
            if stop.reason != "limit":
                break
    return None


def shrink(program: Program, fails: Callable[[Program], bool]) -> Program:
    """Removes fragments, pins, channels and rounds as long as the program still fails."""
    changed = True
    while changed:
        changed = False
        smaller = [
            replace(program, fragments=program.fragments[:i] + program.fragments[i + size :])
            for size in (8, 4, 2, 1)
            for i in range(0, len(program.fragments), size)
        ]
        smaller += [replace(program, pins=program.pins[:i] + program.pins[i + 1 :]) for i in range(len(program.pins))]
        smaller += [replace(program, rounds=0)] if program.rounds else []
        smaller += [
            replace(program, registers=program.registers | {name: 0})
            for name, value in program.registers.items()
            if value
        ]
        smaller += [
            replace(program, waits=program.waits | {name: 0})
            for name, value in program.waits.items()
            if value and name in ("local", "fast", "page")
        ]
        for i, fragment in enumerate(program.fragments):
            lines = fragment.splitlines(keepends=True)
            for j in range(len(lines)):
                cut = "".join(lines[:j] + lines[j + 1 :])
                smaller.append(replace(program, fragments=(*program.fragments[:i], cut, *program.fragments[i + 1 :])))
        for candidate in smaller:
            try:
                failing = fails(candidate)
            except ValueError:
                continue  # a removed fragment had a label that another one needs
            if failing:
                program, changed = candidate, True
                break
    return program
