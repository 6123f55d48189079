"""Random nasty programs (nasty_programs.py) run the same under every way to run and observe them."""

from __future__ import annotations

from pathlib import Path

import pytest
from nasty_programs import Program, generate
from nasty_rings import ring, ring_disagreement
from nasty_runs import Bench, disagreement, shrink


def check(seeds: range, directory: Path) -> None:
    bench = Bench(directory)
    for seed in seeds:
        program = generate(seed)
        found = disagreement(program, bench)
        if found is None:
            continue

        def fails(candidate: Program) -> bool:
            return disagreement(candidate, bench) is not None

        least = shrink(program, fails)
        pytest.fail(
            f"{found}\nthe least program that still fails, {disagreement(least, bench)}:\n{least}\n{least.text}"
        )


@pytest.mark.parametrize("first", range(0, 300, 25))
def test_nasty_programs_run_alike_however_they_are_observed(first: int, tmp_path: Path) -> None:
    check(range(first, first + 25), tmp_path)


@pytest.mark.campaign
@pytest.mark.parametrize("first", range(0, 100_000, 1000))
def test_nasty_programs_by_the_hundred_thousand(first: int, tmp_path: Path) -> None:
    check(range(first, first + 1000), tmp_path)


def check_rings(seeds: range, directory: Path) -> None:
    bench = Bench(directory)
    for seed in seeds:
        found = ring_disagreement(ring(seed), bench)
        assert found is None, found


@pytest.mark.parametrize("first", range(0, 60, 20))
def test_rings_of_nasty_programs_run_alike_however_they_are_cut(first: int, tmp_path: Path) -> None:
    check_rings(range(first, first + 20), tmp_path)


@pytest.mark.parametrize("seed", [74, 93, 122, 184, 193, 258, 262, 145, 304, 412, 436, 515, 713, 1172, 1781, 2243, 2627,
                                  3050, 3247, 3287, 3521, 4085, 4408, 4609, 5202, 7798, 9232, 300057])  # fmt: skip
def test_rings_that_once_depended_on_how_they_were_cut(seed: int, tmp_path: Path) -> None:
    """Breakpoints in loops of blocks; what a link, a DMA, a timer and a processor do in one cycle; when a processor, or
    the DMA of one that waits, came to rest; a DMA that faults while its processor waits; timers that drive a DMA beside
    a processor that sleeps."""
    check_rings(range(seed, seed + 1), tmp_path)


@pytest.mark.parametrize("seed", [57946, 58028, 84837])
def test_programs_that_once_depended_on_how_they_were_cut(seed: int, tmp_path: Path) -> None:
    """Control of the cache while the processor idles beside a DMA; a network's end; a DMA that never lets the processor
    to its bus."""
    check(range(seed, seed + 1), tmp_path)


@pytest.mark.campaign
@pytest.mark.parametrize("first", range(0, 10_000, 500))
def test_rings_of_nasty_programs_by_the_ten_thousand(first: int, tmp_path: Path) -> None:
    check_rings(range(first, first + 500), tmp_path)
