"""``cmrc`` with standard streams that are closed or full: the work is done, and what is lost is said."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import cmrc
import pytest
from locations import BUILD

BASE = '[run]\nduration_s = 0.021\n[report]\nreference = "none"\n'
GRID = '[fixed]\nconfig = "base.toml"\n[axes]\ndsps = [1, 2]\n'
WORK = {
    "compare": ["compare", "--duration", "0.021", "--json", "out"],
    "limits": ["limits", "--duration", "0.021", "--dsps-grid", "1:1", "--json", "out"],
    "sweep": ["sweep", "grid.toml", "--workers", "1", "--metric", "misses", "--csv", "out"],
    "diff": ["diff", "one.json", "two.json", "--json", "out"],
    "events": ["events", "base.toml", "-o", "out"],
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    pytest.importorskip("distributed")
    pytest.importorskip("pyarrow")
    (tmp_path / "base.toml").write_text(BASE)
    (tmp_path / "grid.toml").write_text(GRID)
    for name, dsps in (("one.json", 1), ("two.json", 2)):
        cmrc.run(dsps=dsps, duration_s=0.021).save(tmp_path / name)
    return tmp_path


def ended(folder: Path, arguments: list[str], streams: str, **more: str) -> subprocess.CompletedProcess[bytes]:
    """``streams``: how a shell redirects."""
    environment = {**os.environ, "PYTHONPATH": str(BUILD / "python"), **more}
    command = ["sh", "-c", f'exec "$0" -m cmrc "$@" {streams}', sys.executable, *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, check=False, timeout=100)


@pytest.mark.parametrize("name", WORK)
@pytest.mark.parametrize(("streams", "says"), [
    (">/dev/full", "standard output: No space left on device"),
    (">&-", "standard output: Bad file descriptor"),
])  # fmt: skip
def test_standard_output_that_is_full_or_closed_loses_no_file_and_is_an_error(
    name: str, streams: str, says: str, folder: Path
) -> None:
    done = ended(folder, WORK[name], streams)
    *progress, said = done.stderr.decode().splitlines()
    assert (done.returncode, said) == (1, f"cmrc {name}: {says}")
    assert all(line.startswith(f"cmrc {name}: ") for line in progress)
    assert (folder / "out").stat().st_size > 0


@pytest.mark.parametrize("name", WORK)
@pytest.mark.parametrize("streams", ["2>&-", "2>/dev/full", "<&- 2>&-"])
def test_standard_error_that_is_closed_or_full_changes_nothing(name: str, streams: str, folder: Path) -> None:
    done = ended(folder, WORK[name], streams)
    assert done.returncode == (1 if name == "diff" else 0)
    assert done.stdout and (folder / "out").stat().st_size > 0


def test_an_error_that_cannot_be_shown_has_its_status(folder: Path) -> None:
    for streams in ("2>&-", "2>/dev/full"):
        for wrong in (["diff", "nothing", "one.json"], ["dif"]):
            done = ended(folder, wrong, streams)
            assert (done.returncode, done.stdout) == (2, b"")


@pytest.mark.parametrize("option", ["--version", "--help"])
def test_a_text_of_the_command_line_that_cannot_be_shown_is_an_error(option: str, folder: Path) -> None:
    for more in ({}, {"PYTHONUNBUFFERED": "1"}):
        done = ended(folder, [option], ">/dev/full", **more)
        assert (done.returncode, done.stderr) == (1, b"cmrc: standard output: No space left on device\n")


def test_letters_that_the_terminal_does_not_have_lose_nothing(folder: Path) -> None:
    one = cmrc.run(dsps=1, duration_s=0.021)
    report = {**one.report, "extra": 1}
    (folder / "more.json").write_text(json.dumps(report))
    done = ended(folder, ["diff", "one.json", "more.json", "--json", "out"], "", PYTHONIOENCODING="latin-1")
    assert (done.returncode, done.stderr) == (1, b"") and b"extra: ? -> 1" in done.stdout
    assert (folder / "out").exists()
