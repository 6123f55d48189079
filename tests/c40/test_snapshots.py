"""Snapshots of processors and networks: going on from one is the same as never having stopped (docs/snapshots.md)."""

from __future__ import annotations

import random
import re
from pathlib import Path
from typing import Any

import cmrc
import pytest
from cmrc import c40 as package
from cmrc._core import c40
from cmrc.network import Network
from leaves import check_that_every_value_is_loaded
from nasty_programs import CYCLES, Bench, Pins, Program, assembled, generate, made, prepare, ring


def advance(chip: Any, pins: Pins, end: int) -> str:
    while chip.cycle < end:
        pins.raise_due(chip)
        stop = chip.run(min(pins.next(), end) - chip.cycle)
        if stop["reason"] != "limit":
            return str(stop["reason"])
    return "limit"


def same(program: Program, pins: Pins) -> Pins:
    """Those that are still to be raised."""
    other = Pins(program)
    other._left = list(pins._left)
    return other


@pytest.mark.parametrize("first", range(0, 300, 50))
def test_a_nasty_program_goes_on_from_any_cycle(first: int, tmp_path: Path) -> None:
    """In the middle of blocks, RPTS, delayed branches, DMA transfers: wherever the cut falls."""
    bench = Bench(tmp_path)
    for seed in range(first, first + 50):
        program = generate(seed)
        board, image, rng = bench.board(program), assembled(program), random.Random(seed)
        chip = made(program, board, image)
        pins = Pins(program)
        advance(chip, pins, rng.randrange(1, CYCLES))
        snapshot = chip.save()
        other = c40.Processor(board)
        other.record_events()
        other.load(snapshot)
        assert other.save() == snapshot and chip._state_difference(other) is None, seed
        told, again = len(chip.events), same(program, pins)
        for end in (min(chip.cycle + rng.randrange(1, 50), CYCLES), CYCLES):
            assert advance(chip, pins, end) == advance(other, again, end), seed
            assert chip._state_difference(other) is None, seed
            assert list(chip.events)[told:] == list(other.events), seed


def test_every_value_of_a_processor_is_loaded(tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    paths = 0
    for seed in (3, 57):
        program = generate(seed)
        board = bench.board(program)
        chip = made(program, board, assembled(program))
        advance(chip, Pins(program), 400)

        def a_place_of_memory(path: str) -> bool:
            # Where a stretch of memory stands: it has to be on the board.
            return re.fullmatch(r"memory\.contents\.\d+\.0", path) is not None

        paths += check_that_every_value_is_loaded(lambda board=board: c40.Processor(board), chip, a_place_of_memory)  # type: ignore[misc]
    assert paths > 2000


def networks(seed: int, bench: Bench, order: int) -> Network:
    programs = ring(seed)
    images = [assembled(program) for program in programs]
    network = Network(images, links=[f"{n}.0:{(n + 1) % len(images)}.3" for n in range(len(images))], boards=[bench.board(program) for program in programs],
                      clocks_mhz=[program.clocks[0] for program in programs], turn_order=order, record_words=True, record_peripherals=True)  # fmt: skip
    for program, chip, image in zip(programs, network.chips, images, strict=True):
        prepare(chip._core, program, image.symbols)
    return network


@pytest.mark.parametrize("first", range(0, 80, 20))
def test_a_ring_of_nasty_programs_goes_on_from_any_instant(first: int, tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    end = CYCLES * 2 / 33
    for seed in range(first, first + 20):
        rng = random.Random(seed)
        whole = networks(seed, bench, 0)
        expected = (whole.run(until_us=end), whole.event_trace, [chip._core.snapshot() for chip in whole.chips])
        first_part = networks(seed, bench, 0)
        if first_part.run(until_us=rng.uniform(0.05, end)).reason != "limit":
            continue
        snapshot = first_part.snapshot()
        resumed = networks(seed, bench, rng.randrange(1, 1000))
        resumed.restore(snapshot)
        assert resumed.snapshot() == snapshot, seed
        found = (resumed.run(until_us=end), resumed.event_trace, [chip._core.snapshot() for chip in resumed.chips])
        assert found == expected, seed


def test_a_network_that_deadlocks_after_a_snapshot_does_so_at_the_same_instant() -> None:
    """The look for loops that poll is in the state: when it began, and what it has seen."""
    program = package.assemble("        .text\nstart:  ldhi 10h,ar6\npoll:   ldi *+ar6(70h),r0\n        and 1E00h,r0\n        bz poll\nend:    bu end\n", sections={".text": 0x2FF800})
    whole = Network([program, program], links=["0.3:1.0"])
    stop = whole.run()
    assert stop.reason == "deadlock"
    for share in (0.01, 0.3, 0.55, 0.93, 0.97, 0.999):
        part = Network([program, program], links=["0.3:1.0"])
        part.run(until_us=stop.time_ps * share / 1e6)
        resumed = Network([program, program], links=["0.3:1.0"], turn_order=5)
        resumed.restore(part.snapshot())
        assert resumed.run() == stop
        assert [chip.status for chip in resumed.chips] == [chip.status for chip in whole.chips]
        assert resumed.chips[0].cycles == whole.chips[0].cycles


def test_refused_by_name_and_nothing_has_changed() -> None:
    program = package.assemble("        .text\nstart:  addi 1,r0\n        bu start\n", sections={".text": 0x2FF800})
    processor, flat = package.Processor(program), package.Processor(program, board="flat")
    processor.run(100)
    flat.run(50)
    snapshot, before = processor.snapshot(), flat.snapshot()
    with pytest.raises(cmrc.SnapshotError, match="of a chip on board default; this one is on board flat, which differs"):
        flat.restore(snapshot)
    assert flat.snapshot() == before
    with pytest.raises(cmrc.SnapshotError, match="damaged or cut short"):
        processor.restore(snapshot[:-3])
    with pytest.raises(cmrc.SnapshotError, match="this is no snapshot"):
        processor.restore(b"hello")
    with pytest.raises(TypeError, match="snapshot: "):
        processor.restore("hello")  # type: ignore[arg-type]
    network = Network([program, program], links=["0.3:1.0"])
    with pytest.raises(cmrc.SnapshotError, match="the snapshot is of a processor; one of a network is expected"):
        network.restore(snapshot)
    other = Network([program, program], links=["0.4:1.1"])
    with pytest.raises(cmrc.SnapshotError, match="of another network"):
        other.restore(network.snapshot())
    assert processor.snapshot() == snapshot
