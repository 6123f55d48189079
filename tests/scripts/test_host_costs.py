"""Emulation costs no more host instructions than its history says (docs/speed.md, Counted)."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from locations import ROOT
from script_modules import script

COSTS = [sys.executable, ROOT / "scripts" / "host_costs"]
ROWS = script("host_costs").ROWS
SAME_RUNS = {"event of the dock": "dock, 4 DSPs", "window access, spin": "dock, 4 DSPs, spin"}
"""Rows that divide another row's host instructions by something else: counted with it."""


@pytest.mark.campaign
@pytest.mark.parametrize("row", [row.name for row in ROWS if row.name not in SAME_RUNS])
def test_it_costs_no_more_than_before(row: str) -> None:
    rows = [row, *(other for other, same in SAME_RUNS.items() if same == row)]
    done = subprocess.run([*COSTS, *rows, "--check"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(("now", "status"), [(103.1, 1), (102.9, 0), (50.0, 0)])
def test_a_cost_that_has_risen_by_more_than_3_percent_fails(
    now: float, status: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Against the last column that has the row."""
    costs = script("host_costs")
    columns = [{"name": "a", "costs": {"it": 1.0}}, {"name": "b", "costs": {"it": 100.0}}, {"name": "c", "costs": {}}]
    (tmp_path / "history.json").write_text(json.dumps(columns))
    monkeypatch.setattr(costs, "HISTORY", tmp_path / "history.json")
    monkeypatch.setattr(costs, "ROWS", [costs.Row("it", "per thing", lambda: now)])
    monkeypatch.setattr(costs.shutil, "which", lambda name: name)
    monkeypatch.setattr(sys, "argv", ["host_costs", "--check"])
    assert costs.main() == status
    assert ("risen by more than 3 %: it" in capsys.readouterr().err) == bool(status)


def test_a_name_of_no_row_is_an_error_that_lists_the_rows() -> None:
    done = subprocess.run([*COSTS, "no such row"], capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "no row has no such row in its name" in done.stderr and "fft1024" in done.stderr
