"""Processor cycles that a DMA costs, in random mixes of instructions and wait states (c40-hardware.md 3.4, 3.5, 7.4).

One bus slot a word: what the processor loses, and what is charged to the DMA as `dma_conflict`, is never more than the
bus cycles of the words that the DMA moved, and the turns from write to read that they cause. Bus cycles are counted
here from c40-hardware.md 3.5, words from the DMA's counter. Of turns there are two kinds: the DMA's read comes straight
after a write; and a store that the DMA delays comes directly before a read of the processor (7.4: one cycle
more), which needs a store to a bus that the DMA uses.

The processor can even gain, for a fetch may be made while a data access is held up: over many mixes it does not. Where
the code has a block of RAM for itself, no data access keeps a fetch waiting, and it never gains.

Rotating priority lets the DMA begin later than DMA-first does, and so it may meet another access, with less slack: the
first test by hand is such a case. So it can cost more in single mixes; over many it does not.
"""

from __future__ import annotations

import random
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from cmrc._core import c40, toolchain

BOARD = """
name = "mix"
gmicr = 0x1DEA4000
lmicr = 0x1DEA4000
[[region]]
name = "local"
base = 0x300000
words = 0x2000
bus = "local"
waits = {0}
[[region]]
name = "global"
base = 0x80000000
words = 0x1000
bus = "global"
waits = {1}
"""
PLACES = {"block 0": 0x2FF800, "block 1": 0x2FFC00, "local": 0x301000, "global": 0x80000400}
ON_CHIP, EXTERNAL = 0x2FFE00, 0x300000
INSTRUCTIONS = ["nop", "addi 1,r0", "ldi *ar0,r1", "ldi *ar1,r2", "sti r0,*ar0", "sti r0,*ar1", "ldi *ar0,r1\n     || ldi *ar2,r2", "addi3 *ar0,*ar2,r3", "sti r1,*ar2",
                "sti r0,*ar0\n     || sti r1,*ar2", "addi3 *ar1,*ar2,r3", "addi 0,ar0\n        ldi *ar0,r1", "mpyi3 r0,r1,r2"]  # fmt: skip
STOP_AT_END, RUN = 1 << 2, 3 << 22
PROCESSOR_FIRST, ROTATING, DMA_FIRST = 0, 1, 3
WORDS = 25


@dataclass(frozen=True)
class Transfer:
    source: str
    destination: str
    waits: dict[str, int]  # of the buses
    stores: frozenset[str]  # places to which the processor stores

    def bus_cycles(self) -> int:
        """Of one word, at most: a read that comes straight after a write, of whomever, takes a cycle more; a write on a
        bus takes two."""
        read = 1 + self.waits.get(self.source, 0) + (self.source in self.waits)
        write = (2 if self.destination in self.waits else 1) + self.waits.get(self.destination, 0)
        return read + write

    def turns_of_displaced_stores(self) -> int:
        """Of one word: each of the DMA's accesses to a bus may displace one store there."""
        return sum(place in self.waits and place in self.stores for place in (self.source, self.destination))


@dataclass(frozen=True)
class Outcome:
    cycles: int
    stalls: int
    words: int  # that the DMA has begun


@dataclass(frozen=True)
class Mix:
    what: tuple[Any, ...]
    code: int
    transfer: Transfer
    alone: Outcome
    beside: dict[int, Outcome]


def run(
    text: str, board: str, code: int, pointers: dict[str, int], dma: tuple[int, int, int] | None, words: int = WORDS
) -> Outcome:
    image = toolchain.assemble(text, "mix.asm", sections={".text": code})
    chip = c40.Processor(board)
    chip.load_image(image)
    for name, value in pointers.items():
        chip.set(name, value)
    if dma is not None:
        source, destination, priority = dma
        for register, value in enumerate((source, 1, words, destination, 1), start=1):
            chip.poke(0x1000A0 + register, value)
        chip.poke(0x1000A0, RUN | STOP_AT_END | priority)
    assert chip.run(100_000, until=image.symbols["end"])["reason"] == "breakpoint"
    assert sum(chip.causes.values()) == chip.cycle
    return Outcome(
        int(chip.cycle),
        int(chip.causes["dma_conflict"]),
        0 if dma is None else words - int(chip.peripherals()["DMA0.counter"]),
    )


def board_with(waits: dict[str, int], directory: Path) -> str:
    board = directory / f"{waits['local']}{waits['global']}.toml"
    board.write_text(BOARD.format(*waits.values()))
    return str(board)


def mix(seed: int, directory: Path) -> Mix:
    rng = random.Random(seed)
    waits = {"local": rng.choice([0, 0, 1, 3]), "global": rng.choice([0, 0, 2])}
    board = board_with(waits, directory)
    code = rng.choice([ON_CHIP, EXTERNAL])
    body = "".join(f"        {rng.choice(INSTRUCTIONS)}\n" for _ in range(150 if code == ON_CHIP else 300))
    text = f"        .text\n{body}        nop\n        nop\nend:    bu end\n"
    if rng.random() < 0.3:
        text = f"        .text\n        rpts 99\n        {rng.choice(INSTRUCTIONS[:6])}\n{body}        nop\n        nop\nend:    bu end\n"
    places = [rng.choice(list(PLACES)) for _ in range(3)]
    pointers = {f"AR{n}": PLACES[place] + 8 * n for n, place in enumerate(places)}
    source, destination = rng.choice(list(PLACES)), rng.choice(list(PLACES))
    beside = {
        p: run(text, board, code, pointers, (PLACES[source] + 0x80, PLACES[destination] + 0x100, p))
        for p in (PROCESSOR_FIRST, ROTATING, DMA_FIRST)
    }
    return Mix(
        (seed, waits, code, pointers, source, destination),
        code,
        Transfer(source, destination, waits, frozenset(places)),
        run(text, board, code, pointers, None),
        beside,
    )


def check(found: Mix) -> None:
    assert found.alone.stalls == 0
    transfer = found.transfer
    for priority, outcome in found.beside.items():
        what = (priority, found)
        taken = outcome.words * (transfer.bus_cycles() + transfer.turns_of_displaced_stores())
        assert outcome.cycles - found.alone.cycles <= taken, what
        assert outcome.stalls <= taken, what
        code_has_a_block_for_itself = found.code == ON_CHIP and "block 1" not in {
            transfer.source,
            transfer.destination,
            *transfer.stores,
        }
        assert not code_has_a_block_for_itself or outcome.cycles >= found.alone.cycles, what


def lost(mixes: list[Mix], priority: int) -> int:
    return sum(m.beside[priority].cycles - m.alone.cycles for m in mixes)


def check_all(seeds: range, directory: Path) -> None:
    mixes = [mix(seed, directory) for seed in seeds]
    for found in mixes:
        check(found)
    assert 0 <= lost(mixes, PROCESSOR_FIRST) <= lost(mixes, ROTATING) <= lost(mixes, DMA_FIRST)
    assert lost(mixes, DMA_FIRST) > 0


@pytest.mark.parametrize("first", range(0, 300, 50))
def test_the_processor_loses_no_more_than_the_dma_takes(first: int, tmp_path: Path) -> None:
    check_all(range(first, first + 50), tmp_path)


@pytest.mark.campaign
@pytest.mark.parametrize("first", range(300, 20_300, 500))
def test_the_processor_loses_no_more_than_the_dma_takes_by_the_thousand(first: int, tmp_path: Path) -> None:
    check_all(range(first, first + 500), tmp_path)


def by_hand(
    body: str, pointers: dict[str, int], waits: dict[str, int], transfer: tuple[str, str, int], directory: Path
) -> dict[int | None, int]:
    """Cycles alone and by priority; code on the local bus."""
    source, destination, words = transfer
    text = f"        .text\n{body}        nop\n        nop\nend:    bu end\n"
    board = board_with(waits, directory)
    cycles: dict[int | None, int] = {None: run(text, board, EXTERNAL, pointers, None).cycles}
    for priority in (PROCESSOR_FIRST, ROTATING, DMA_FIRST):
        cycles[priority] = run(
            text, board, EXTERNAL, pointers, (PLACES[source] + 0x80, PLACES[destination] + 0x100, priority), words
        ).cycles
    return cycles


def test_by_hand_rotating_priority_may_cost_what_dma_first_does_not(tmp_path: Path) -> None:
    """The load waits two cycles in D for AR0, so that its own fetch, in cycle 1, has slack; those of the NOPs behind
    it, in 4 and 5, have none.

    The DMA reads from cycle 1 on, every second cycle. DMA first: it wins cycle 1, and the fetch is made in 2; it reads
    again in 3, without a fetch. Rotating: the processor wins cycle 1, the DMA reads in 2. Its next read meets the
    fetch in 4, which is a first conflict, and goes to the processor; in 5 it is the DMA's turn, and that fetch is made
    in 6, a cycle late.
    """
    body = "        nop\n        nop\n        nop\n        addi 0,ar0\n        ldi *ar0,r1\n"
    cycles = by_hand(body, {"AR0": PLACES["block 0"]}, {"local": 0, "global": 0}, ("local", "block 0", 2), tmp_path)
    assert cycles == {None: 9, PROCESSOR_FIRST: 9, ROTATING: 10, DMA_FIRST: 9}


@pytest.mark.parametrize("place", ["local", "global"])
def test_by_hand_rotating_priority_takes_every_other_slot_and_dma_first_all(place: str, tmp_path: Path) -> None:
    """A load in every cycle from the DMA's source, repeated without fetches; the DMA's writes go to a block on the
    chip.

    DMA first: its reads, every second cycle, each take a cycle from the loads. Rotating: it loses its first cycle and
    has the next, so that a word takes it three cycles, and each costs one. Processor first: it has to wait for the
    loop's end.
    """
    loads, words = 100, 20
    text = f"        .text\n        rpts {loads - 1}\n        ldi *ar0,r1\n        nop\n        nop\n        nop\n        nop\nend:    bu end\n"
    board = board_with({"local": 0, "global": 0}, tmp_path)
    dma = (PLACES[place] + 0x80, PLACES["block 1"] + 0x100)
    pointers = {"AR0": PLACES[place]}
    alone = run(text, board, ON_CHIP, pointers, None)
    beside = {p: run(text, board, ON_CHIP, pointers, (*dma, p), words) for p in (PROCESSOR_FIRST, ROTATING, DMA_FIRST)}
    assert beside[PROCESSOR_FIRST].cycles == alone.cycles
    assert {beside[p].words for p in (ROTATING, DMA_FIRST)} == {words}
    # RPTS takes the cycles 0 to 3, and the first load reads in cycle 3 (c40-hardware.md 7.1, 7.2): of the DMA's reads
    # only the first, in cycle 1, meets no load.
    for priority in (ROTATING, DMA_FIRST):
        assert beside[priority].stalls == beside[priority].cycles - alone.cycles == words - 1


@pytest.mark.parametrize("priority", [ROTATING, DMA_FIRST])
@pytest.mark.parametrize("waits", [1, 2, 3])
def test_a_saturated_bus_with_wait_states_carries_one_access_at_a_time(
    waits: int, priority: int, tmp_path: Path
) -> None:
    """Stores one after the other, and a DMA that writes to the same bus: each takes 2 cycles and the wait states, and
    none goes beside another.

    The last store, and the last word, may be under way when the program ends.
    """
    stores, access = 20, 2 + waits
    text = "        .text\n" + "        sti r0,*ar0\n" * stores + "        nop\n        nop\nend:    bu end\n"
    board = board_with({"local": 0, "global": waits}, tmp_path)
    dma = (PLACES["block 0"] + 0x80, PLACES["global"] + 0x100)
    outcome = run(text, board, ON_CHIP, {"AR0": PLACES["global"]}, (*dma, priority))
    assert outcome.words >= stores - 1
    assert (stores + outcome.words - 2) * access <= outcome.cycles <= (stores + outcome.words) * access
