"""A path in a configuration is relative to its file, one on the command line to the current folder."""

import json
import os
import shutil
from pathlib import Path

import cmrc
import pytest
from command_line import emulator
from locations import OVER_A_CONTAINER, ROOT

SLOW_BOARD = (
    "gmicr = 0x1DEA4000\nlmicr = 0x1DEA4000\n"
    '[[region]]\nname = "local"\nbase = 0x300000\nwords = 0x100000\nbus = "local"\nwaits = 2\n'
    '[[region]]\nname = "B"\nkind = "window"\nbase = 0x70000000\nwords = 0x10000000\nbus = "local"\n'
    '[[region]]\nname = "global"\nbase = 0x80000000\nwords = 0x100000\nbus = "global"\n'
    '[[region]]\nname = "A"\nkind = "window"\nbase = 0xC0000000\nwords = 0x40000000\nbus = "global"\n'
)
KEYS = '[machine]\nprograms = "my_programs"\nboard = "b.toml"\n[dock]\nlayout = "l.toml"\n[run]\nduration_s = 0.03\n'
QUIET = ("--quiet", "--set", "report.reference=none", "--report", "r.json")


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """A folder with a configuration and its files, beside another folder."""
    folder = tmp_path / "scene"
    shutil.copytree(ROOT / "c40_programs", folder / "my_programs")
    (folder / "b.toml").write_text(SLOW_BOARD)
    (folder / "l.toml").write_text(OVER_A_CONTAINER)
    (folder / "c.toml").write_text(KEYS)
    (tmp_path / "other").mkdir()
    return folder


def hash_of(folder: Path, *arguments: object) -> str:
    done = emulator(*arguments, *QUIET, folder=folder)
    assert done.returncode == 0, done.stderr
    return str(json.loads((folder / "r.json").read_text())["hash"])


def test_the_files_of_a_configuration_are_beside_it(scene: Path) -> None:
    other = scene.parent / "other"
    beside = hash_of(scene, "--config", "c.toml")
    assert beside != hash_of(scene, "--duration", "0.03")
    for folder, config in ((scene.parent, "scene/c.toml"), (other, "../scene/c.toml"), (other, scene / "c.toml")):
        assert hash_of(folder, "--config", config) == beside, config
    os.symlink(scene, other / "link")
    assert hash_of(other, "--config", "link/c.toml") == beside
    assert cmrc.run(config=scene / "c.toml", settings={"report.reference": "none"}).hash == beside


def test_a_printed_configuration_can_stand_in_any_folder(scene: Path) -> None:
    other = scene.parent / "other"
    printed = emulator("config", "--config", "../scene/c.toml", folder=other).stdout
    (scene.parent / "printed.toml").write_text(printed)
    assert hash_of(other, "--config", "../printed.toml") == hash_of(scene, "--config", "c.toml")
    unchanged = emulator("config", folder=other).stdout
    assert 'programs = ""' in unchanged and 'board = "default"' in unchanged and 'layout = ""' in unchanged


def test_a_path_of_the_command_line_or_of_a_pipe_is_from_here(scene: Path) -> None:
    beside = hash_of(scene, "--config", "c.toml")
    here = ("--programs", "scene/my_programs", "--board", "scene/b.toml", "--set", "dock.layout=scene/l.toml")
    assert hash_of(scene.parent, *here, "--duration", "0.03") == beside
    piped = emulator("--config", "/dev/stdin", *QUIET, folder=scene, stdin=KEYS)
    assert piped.returncode == 0, piped.stderr
    assert json.loads((scene / "r.json").read_text())["hash"] == beside


def test_what_is_not_there_is_named_with_its_place(scene: Path) -> None:
    shutil.rmtree(scene / "my_programs")
    (scene / "b.toml").unlink()
    missing = emulator("--config", "scene/c.toml", folder=scene.parent)
    assert missing.returncode == 2
    assert "scene/b.toml" in missing.stderr or f"{scene}/my_programs/dsp.asm is not there" in missing.stderr
    from_here = emulator("--programs", "my_programs", folder=scene.parent)
    assert f"machine.programs: {scene.parent}/my_programs/dsp.asm is not there" in from_here.stderr


def test_no_output_replaces_a_file_that_a_configuration_names(scene: Path) -> None:
    done = emulator("--config", "scene/c.toml", "--report", "scene/l.toml", folder=scene.parent)
    assert done.returncode == 2 and "--report" in done.stderr and (scene / "l.toml").read_text() == OVER_A_CONTAINER
