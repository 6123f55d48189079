"""Emulation costs no more host instructions than its history says (docs/speed.md, Counted)."""

import shutil
import subprocess
import sys

import pytest
from locations import ROOT
from script_modules import script

COSTS = [sys.executable, ROOT / "scripts" / "host_costs"]
ROWS = script("host_costs").ROWS
SAME_RUNS = {"event of the dock": "dock, 4 DSPs", "window access, spin": "dock, 4 DSPs, spin"}
"""Rows that divide another row's host instructions by something else: counted with it."""
needs_valgrind = pytest.mark.skipif(
    shutil.which("valgrind") is None, reason="valgrind is missing (apt-get install valgrind)"
)


@needs_valgrind
@pytest.mark.campaign
@pytest.mark.parametrize("row", [row.name for row in ROWS if row.name not in SAME_RUNS])
def test_it_costs_no_more_than_before(row: str) -> None:
    rows = [row, *(other for other, same in SAME_RUNS.items() if same == row)]
    done = subprocess.run([*COSTS, *rows, "--check"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_name_of_no_row_is_an_error_that_lists_the_rows() -> None:
    done = subprocess.run([*COSTS, "no such row"], capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "no row has no such row in its name" in done.stderr and "fft1024" in done.stderr
