"""Random programs by the emulator against a model of the chip's time made from the documents (timing_model.py): the
cycles counted after every instruction, and its stages. Each program is also run whole."""

from __future__ import annotations

from pathlib import Path

import pytest
from cmrc import c40
from timed_programs import SETTINGS, Program, drawn
from timed_runs import drawn_stages, first_difference, loaded, steps_of

PROGRAMS_OF_A_KIND = 43
PROGRAMS_OF_A_CAMPAIGN = 100


def state(chip: c40.Processor) -> dict[str, int]:
    return {"pc": chip.pc, "cycles": chip.cycles, **chip.causes, **chip.registers}


def difference(program: Program, board: Path) -> str | None:
    stepped = loaded(program, board)
    steps = steps_of(program, stepped)
    if program.vector:  # interrupts come at steps
        return first_difference(program, steps, [])
    traced, whole = loaded(program, board), loaded(program, board)
    found = first_difference(program, steps, drawn_stages(traced, stepped.cycles))
    whole.run(stepped.cycles)
    if found is None and not state(whole) == state(traced) == state(stepped):
        found = f"run whole: {state(whole)}\nby steps: {state(stepped)}\ntraced: {state(traced)}"
    return found


def failures(kind: str, seeds: range, board: Path) -> list[str]:
    found = {seed: difference(drawn(SETTINGS[kind], seed), board) for seed in seeds}
    return [f"{kind}, seed {seed}: {one}" for seed, one in found.items() if one is not None]


@pytest.mark.parametrize("kind", SETTINGS)
def test_the_chip_counts_what_a_model_from_the_documents_counts(kind: str, tmp_path: Path) -> None:
    found = failures(kind, range(PROGRAMS_OF_A_KIND), tmp_path / "board.toml")
    assert not found, f"{len(found)} programs differ; the first: {found[0]}"


@pytest.mark.campaign
@pytest.mark.parametrize("block", range(20))
@pytest.mark.parametrize("kind", SETTINGS)
def test_the_chip_counts_what_the_model_counts_in_many_programs(kind: str, block: int, tmp_path: Path) -> None:
    first = 1000 + block * PROGRAMS_OF_A_CAMPAIGN
    found = failures(kind, range(first, first + PROGRAMS_OF_A_CAMPAIGN), tmp_path / "board.toml")
    assert not found, f"{len(found)} programs differ; the first: {found[0]}"
