"""Random docks end as they once did (kept_docks.py): a change of the emulator that all ways to run a dock share shows
here, by dock and part of its report. test_random_docks.py compares the ways with one another."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import kept_docks
import pytest

DOCKS = kept_docks.kept()
PER_FILE = 12


@pytest.mark.golden
@pytest.mark.parametrize("first", range(0, len(DOCKS), PER_FILE))
def test_random_docks_end_as_the_kept_ones(golden: Callable[[str, str], None], first: int, programs: Path) -> None:
    docks = enumerate(DOCKS[first : first + PER_FILE], start=first)
    lines = [f"{number}: {kept_docks.digests_of(dock, programs)}\n" for number, dock in docks]
    golden(f"docks/random-{first}.digests", "".join(lines))
