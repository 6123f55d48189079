"""No output of ``cmrc`` is one of its inputs, however it is named: by an option, in a configuration, in a grid."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest
from cmrc.__main__ import main
from locations import OVER_A_CONTAINER, ROOT
from test_scene_board import DEFAULT

GRID = """
[fixed]
config = "base.toml"
duration_s = 0.021
report.reference = "none"
[axes]
dock.layout = ["", "other.toml"]
"""
BASE = '[run]\nduration_s = 0.021\n[dock]\nlayout = "lay.toml"\n[machine]\nboard = "board.toml"\n'


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("lay.toml").write_text(OVER_A_CONTAINER)
    Path("other.toml").write_text(OVER_A_CONTAINER)
    Path("board.toml").write_text(DEFAULT)
    Path("base.toml").write_text(BASE)
    Path("grid.toml").write_text(GRID)
    shutil.copytree(ROOT / "c40_programs", "programs")
    os.link("programs/dsp.asm", "dsp.json")
    os.symlink("lay.toml", "lay.png")
    os.symlink("lay.toml", "lay.html")
    return tmp_path


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


SWEEP = ["sweep", "grid.toml", "--workers", "1", "--csv"]


@pytest.mark.parametrize("command", [
    ["page", "base.toml", "--out", "lay.toml"],
    ["page", "base.toml", "--out", "board.toml"],
    ["page", "base.toml", "--plots", "lay.png"],
    ["page", "base.toml", "--set", "dock.layout=other.toml", "--out", "other.toml"],
    ["events", "base.toml", "-o", "lay.toml"],
    ["events", "base.toml", "-o", "board.toml"],
    ["compare", "--config", "base.toml", "--json", "base.toml"],
    ["compare", "--config", "base.toml", "--json", "lay.toml"],
    ["compare", "--duration", "0.021", "--programs", "programs", "--json", "programs/lib/../dsp.asm"],
    ["compare", "--duration", "0.021", "--programs", "programs", "--json", "programs/include/task_block.inc"],
    ["limits", "--duration", "0.021", "--programs", "programs", "--json", "dsp.json"],
    [*SWEEP, "grid.toml"],
    [*SWEEP, "base.toml"],
    ["sweep", "grid.toml", "--show", "--csv", "base.toml"],
    [*SWEEP, "lay.toml"],
    [*SWEEP, "other.toml"],
    ["sweep", "grid.toml", "--plot", "lay.png"],
    ["sweep", "grid.toml", "--csv", "x.svg", "--plot", "x.svg"],
], ids=" ".join)  # fmt: skip
def test_an_output_that_is_an_input_is_refused(
    command: list[str], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = contents(folder)
    assert main(command) == 2
    said = capsys.readouterr().err
    assert "is the same file as" in said and "another name is expected" in said and said.count("\n") == 1
    assert contents(folder) == before


@pytest.mark.parametrize("command", [["sweep", "own_grid.toml", "--csv"], ["limits", "--config", "own.toml", "--json"]])
def test_what_a_program_includes_is_an_input(
    command: list[str], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("outside.inc").write_text("")
    dsp = Path("programs/dsp.asm")
    dsp.write_text('        .include "../outside.inc"\n' + dsp.read_text())
    Path("own.toml").write_text('[run]\nduration_s = 0.021\n[machine]\nprograms = "programs"\n')
    Path("own_grid.toml").write_text('[fixed]\nconfig = "own.toml"\n[axes]\ndsps = [1]\n')
    assert main([*command, "outside.inc"]) == 2
    assert "another name is expected" in capsys.readouterr().err


def test_no_output_lies_in_the_folder_of_the_programs(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("own.toml").write_text('[run]\nduration_s = 0.021\n[machine]\nprograms = "programs"\n')
    Path("link").symlink_to("programs")
    for command in (["limits", "--config", "own.toml", "--dsps-grid", "1", "--json"], ["page", "own.toml", "--out"]):
        for place in ("programs/new", "link/new"):
            assert main([*command, place]) == 2
            said = capsys.readouterr().err
            assert said.endswith(f"{place}: is in machine.programs programs; a place outside is expected\n")


@pytest.mark.parametrize("option", ["--csv", "--plot"])
@pytest.mark.parametrize("name", ["sweep.json", "lock", "part-000001.parquet", "new.svg", "../part"])
@pytest.mark.parametrize("show", [True, False])
def test_no_output_lies_in_the_folder_of_a_sweep(
    option: str, name: str, show: bool, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """``part`` is another name of a part."""
    Path("grid").mkdir()
    for own in ("sweep.json", "lock", "part-000001.parquet"):
        (folder / "grid" / own).write_text("kept")
    os.link("grid/part-000001.parquet", "part")
    before = contents(folder)
    assert main(["sweep", "grid.toml", option, f"grid/{name}", *(["--show"] if show else [])]) == 2
    said = capsys.readouterr().err
    assert f"{option}: grid/{name}" in said and "the sweep's folder" in said
    assert contents(folder) == before
