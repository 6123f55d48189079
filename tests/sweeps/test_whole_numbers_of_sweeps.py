"""Whole numbers of a sweep that some of its runs lack: in the table, the frame and the CSV."""

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cmrc.commands import main
from cmrc.sweeps import Sweep
from cmrc.sweeps.store import Folder
from sweep_rows import row

pytest.importorskip("pyarrow")

BIG = 2**53 + 1


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Of two runs one has no seed, one no DSPs, and one no misses."""
    with Folder(tmp_path / "s") as made:
        made.write([row(1, {"machine.dsps": 2}, BIG, 4), row(2, {"run.strict": True}, None, None)])
    return tmp_path / "s"


def any_miss(report: Any) -> bool:
    return bool(report["tasks"]["pid"]["misses"])


def test_a_table_has_floats_that_hold_them_or_objects(folder: Path) -> None:
    table = Sweep(folder).table("misses")
    assert table["seed"].dtype == object and table["seed"][0] == BIG and math.isnan(table["seed"][1])
    assert table["misses"].dtype == np.float64 and table["misses"][0] == 4


def test_a_frame_has_whole_numbers_and_na(folder: Path) -> None:
    pandas = pytest.importorskip("pandas")
    frame = Sweep(folder).to_frame("misses", lambda report: 0.5, any_miss)
    assert [str(frame[name].dtype) for name in ("machine.dsps", "seed", "misses")] == ["Int64"] * 3
    assert frame["seed"][0] == BIG and frame["seed"][1] is pandas.NA
    assert frame["<lambda>"].dtype == frame["any_miss"].dtype == np.float64


def test_a_csv_has_no_fraction_behind_them(folder: Path, tmp_path: Path) -> None:
    assert main(["sweep", f"{folder}.toml", "--show", "--metric", "misses", "--csv", str(tmp_path / "a.csv")]) == 0
    first, second = csv.DictReader((tmp_path / "a.csv").open(newline="", encoding="utf-8"))
    assert (first["machine.dsps"], first["seed"], first["misses"]) == ("2", str(BIG), "4")
    assert (second["machine.dsps"], second["seed"], second["misses"]) == ("nan", "nan", "nan")
    assert second["run.strict"] == "True"
