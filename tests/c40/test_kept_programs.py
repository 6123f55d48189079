"""Random nasty programs and rings of them end as they once did: a change of the chip or of the assembler that all ways
to run a program share shows here, by seed. test_nasty_programs.py compares the ways with one another."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from cmrc import c40 as package
from digests import digest
from nasty_programs import generate
from nasty_rings import END_US, ring, ring_network
from nasty_runs import Bench, assembled, drive, made

PROGRAMS, RINGS, PER_LINE = 1000, 100, 10


def end_of(chip: Any) -> list[Any]:
    """Registers, cycles by cause, peripherals, and a hash of all RAM."""
    registers = {name: chip.get(name) for name in package.REGISTERS}
    return [chip.cycle, chip.pc, registers, chip.causes, chip.peripherals(), chip.digest()]


def program_ends(seed: int, bench: Bench) -> list[Any]:
    program = generate(seed)
    image = assembled(program)
    chip = made(program, bench.board(program), image)
    stop, _, events = drive(chip, program, lambda chip, cycle: chip.run(max(cycle - chip.cycle, 1)))  # type: ignore[no-any-return]
    return [image.symbols, stop, [list(event) for event in events], end_of(chip)]


def ring_ends(seed: int, bench: Bench) -> list[Any]:
    network = ring_network(ring(seed), bench)
    reason = network.run(until_us=END_US).reason
    return [reason, network.event_trace, [end_of(chip._core) for chip in network.chips]]


def table(ends: Callable[[int, Bench], list[Any]], count: int, bench: Bench) -> Iterator[str]:
    """A line for ten seeds: the first seed, and a short digest of each."""
    for first in range(0, count, PER_LINE):
        digests = [digest(ends(seed, bench), digits=8) for seed in range(first, first + PER_LINE)]
        yield f"{first}: {' '.join(digests)}\n"


@pytest.mark.golden
@pytest.mark.parametrize(("name", "ends", "count"), [("programs", program_ends, PROGRAMS), ("rings", ring_ends, RINGS)])
def test_nasty_programs_end_as_the_kept_ones(
    golden: Callable[[str, str], None], name: str, ends: Callable[[int, Bench], list[Any]], count: int, tmp_path: Path
) -> None:
    golden(f"nasty-{name}.digests", "".join(table(ends, count, Bench(tmp_path))))
