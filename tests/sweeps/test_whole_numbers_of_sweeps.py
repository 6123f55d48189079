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


@pytest.mark.parametrize(
    ("hertz", "written"), [("[1000.5, 999]", ["999.0", "1000.5"]), ("[1001, 999]", ["999.0", "1001.0"])]
)
def test_a_csv_is_the_same_after_the_runs_and_from_the_folder(hertz: str, written: list[str], tmp_path: Path) -> None:
    """A setting that may have a fraction is a float in each row, as in the table; the seed is whole."""
    grid = tmp_path / "g.toml"
    fixed = '[fixed]\nrun.duration_s = 0.03\ndsps = 1\nreport.reference = "none"\n'
    grid.write_text(f"{fixed}[axes]\nservo_frequency_hz = {hertz}\n[repeats]\nseeds = 1\n")
    for more in (["--workers", "1"], ["--show"]):
        assert main(["sweep", str(grid), "--metric", "misses", "--csv", str(tmp_path / "a.csv"), *more]) == 0
        rows = list(csv.DictReader((tmp_path / "a.csv").open(newline="", encoding="utf-8")))
        assert sorted((row["rates.servo_frequency_hz"] for row in rows), key=float) == written, more
        assert {row["seed"] for row in rows} == {"1"}


def test_whole_numbers_beside_floats_are_floats_in_a_csv(folder: Path, tmp_path: Path) -> None:
    with Folder(folder) as made:
        made.write([row(3, {"machine.dsps": 2.5}, BIG, 5)])
    assert main(["sweep", f"{folder}.toml", "--show", "--metric", "misses", "--csv", str(tmp_path / "a.csv")]) == 0
    rows = list(csv.DictReader((tmp_path / "a.csv").open(newline="", encoding="utf-8")))
    assert [row["machine.dsps"] for row in rows] == ["2.0", "2.5", "nan"]
    assert [row["seed"] for row in rows] == [str(BIG), str(BIG), "nan"]
