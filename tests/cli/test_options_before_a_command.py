"""An option of the dock's run before a command is refused: no command would obey it."""

import re
from pathlib import Path

import pytest
from command_line import emulator


def help_of(*command: str) -> str:
    return emulator(*command, "--help").stdout


COMMANDS = re.findall(r"^  ([a-z][a-z-]+) ", help_of().partition("Subcommands:")[2], re.MULTILINE)
OPTIONS = [
    (name, value)
    for name, value in re.findall(r"^  (?:-\w,)?(--[a-z][\w-]*)(?: (\S+))?", help_of(), re.MULTILINE)
    if name not in ("--help", "--version")
]
VALUES = {"--trace-instructions": "0", "--debug": "0"}


def test_the_help_lists_them() -> None:
    assert len(COMMANDS) > 12 and len(OPTIONS) > 25
    assert ("--strict", "") in OPTIONS and ("--dsps", "INT") in OPTIONS


@pytest.mark.parametrize("command", COMMANDS)
def test_each_is_refused_by_name_with_its_place(command: str, tmp_path: Path) -> None:
    settings = "compare" if command == "limits" else command  # of the package: its options are those of compare
    own = set(re.findall(r"--[a-z][\w-]*", help_of(settings)))
    for name, value in OPTIONS:
        given = [] if not value else [VALUES.get(name, "1")]
        done = emulator(name, *given, command, "x", folder=tmp_path)
        place = f"emulator {command} {name}" if name in own else f"emulator {command} without it"
        assert done.returncode == 2 and done.stdout == "", (name, done)
        assert done.stderr.startswith(f"emulator: {name}: before a command it has no effect; {place} is expected"), done
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("command", COMMANDS)
def test_two_dashes_before_a_command_are_refused(command: str) -> None:
    for before in ([], ["--dsps", "2"]):
        done = emulator(*before, "--", command, "--help")
        said = f"emulator: --: before a command it has no effect; emulator {command} is expected\n"
        assert (done.returncode, done.stdout, done.stderr) == (2, "", said)


def test_an_option_of_the_command_belongs_behind_it() -> None:
    done = emulator("--until", "done", "exec", "t.asm")
    assert done.stderr.startswith(
        "emulator: --until: before a command it has no effect; emulator exec --until is expected"
    )
