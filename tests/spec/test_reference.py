"""A sample of the campaigns: the emulator against the C++ reference, the reference against the specification."""

import subprocess
from pathlib import Path

import pytest
from locations import BUILD

from spec import campaign

PROGRAM = BUILD / "bin" / "arithmetic_campaign"


def test_the_emulator_agrees_with_the_reference_on_a_sample() -> None:
    result = subprocess.run([PROGRAM, "--cases", "30000", "--jobs", "2"], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout
    assert f"{len(campaign.OPERATIONS)} operations, 30000 cases each: 0 differ\n" in result.stdout


@pytest.mark.parametrize("operation", campaign.OPERATIONS)
def test_the_reference_agrees_with_the_specification_on_a_sample(operation: str) -> None:
    result = campaign.check(PROGRAM, operation, 3000, seed=2)
    assert (result.cases, result.differing) == (3000, 0), result.first


def test_the_comparison_sees_a_wrong_specification(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(campaign.OPERATIONS, "addf", campaign.OPERATIONS["subf"])
    result = campaign.check(PROGRAM, "addf", 1000, seed=2)
    assert result.differing > 100 and "specification" in result.first


def test_unknown_operations_are_refused() -> None:
    result = subprocess.run([Path(PROGRAM), "addq"], capture_output=True, text=True, check=False)
    assert result.returncode == 2 and "operations: addf" in result.stderr


def test_decoder_and_reference_call_the_same_words_instructions() -> None:
    """A sample of the sweep over all words; the step is prime, so every field takes every value."""
    result = subprocess.run([BUILD / "bin" / "word_sweep", "211"], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout
    words, instructions = (int(part.split()[0]) for part in result.stdout.split(", ")[:2])
    assert words > 20_000_000 and abs(instructions / words - 1109112715 / 2**32) < 1e-4
