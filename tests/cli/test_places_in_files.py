"""What a file says wrong has its place in that file, whichever way the run is asked for."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cmrc
import pytest
from command_line import emulator

# Files that only a run with two DSPs refuses, the line and column, and what is said of them.
CASES = {
    "event": ('# a scene\n[run]\nseed = 1\n[[events]]\nat_s = 0.04\naction = "fail"\ndsp = 2\n', "4:1: events.dsp: "),
    "setting": ('[run]\nseed = 1\n[machine]\nlinks = "0.0:2.4"\n', "4:1: machine.links: link 0.0:2.4: "),
}
SHORT = ("--duration", 0.05)


def raised(call: Callable[[], object]) -> str:
    with pytest.raises(cmrc.ConfigError) as refused:
        call()
    return str(refused.value)


def refused_point(found: cmrc.Limits) -> str:
    two, three = found.report["scans"]["dsps"]["points"]
    assert three["ran"] and not two["ran"]
    return str(two["refused"])


def swept(file: Path) -> str:
    grid = file.with_name("grid.toml")
    grid.write_text(f'[fixed]\nconfig = "{file.name}"\nduration_s = 0.05\n[axes]\ndsps = [2]\n')
    [row] = cmrc.sweep(grid, file.with_name("out"), workers=1).runs
    return str(row["message"])


SETTINGS = {"machine.dsps": 2, "run.duration_s": 0.05}
FRONT_ENDS: dict[str, Callable[[Path], str]] = {
    "run": lambda file: emulator("--config", file, "--dsps", 2, *SHORT).stderr,
    "page": lambda file: emulator("--config", file, "--dsps", 2, *SHORT, "--page", file.with_name("p.html")).stderr,
    "compare": lambda file: emulator("compare", "--config", file, "--dsps", 2, *SHORT).stderr,
    "debug": lambda file: emulator("debug", "--config", file, "--dsps", 2, *SHORT).stderr,
    "config": lambda file: emulator("config", "--config", file, "--set", "machine.dsps=2").stderr,
    "limits": lambda file: emulator("limits", "--config", file, *SHORT, "--dsps-grid", "2:3").stdout,
    "Python's run": lambda file: raised(lambda: cmrc.run(config=file, settings=SETTINGS)),
    "Python's Simulation": lambda file: raised(lambda: cmrc.Simulation(config=file, settings=SETTINGS)),
    "Python's compare": lambda file: raised(lambda: cmrc.compare(config=file, settings=SETTINGS)),
    "Python's limits": lambda file: refused_point(cmrc.limits(config=file, dsps=[2, 3], duration_s=0.05)),
    "sweep": swept,
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("front_end", FRONT_ENDS)
def test_a_refusal_has_the_place_in_the_users_file(front_end: str, case: str, tmp_path: Path) -> None:
    text, says = CASES[case]
    file = tmp_path / "bad.toml"
    file.write_text(text)
    said = FRONT_ENDS[front_end](file)
    assert f"bad.toml:{says}" in said and said.count("there is no slot 2") == 1


def test_limits_read_a_file_once(tmp_path: Path) -> None:
    """So that the file may be a pipe, and is the same for every point."""
    found = emulator("limits", "--config", "/dev/stdin", *SHORT, "--dsps-grid", "2:3", stdin=CASES["event"][0]).stdout
    assert "not run: /dev/stdin:4:1: events.dsp: " in found
