"""The debugger at a terminal: Ctrl-C, errors, letters of all kinds, progress."""

import contextlib
import os
import pty
import select
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from locations import BUILD
from sums import write_program

CTRL_C = b"\x03"
ENDLESS = "        .text\n_start: ldi 0,r0\nround:  addi 1,r0\n        b round\n"


class Terminal:
    """`emulator debug` under a terminal of its own."""

    def __init__(self, folder: Path, *arguments: str, **variables: str) -> None:
        self.pid, self.fd = pty.fork()
        if self.pid == 0:
            os.chdir(folder)
            environment = os.environ | {"TERM": "xterm"} | variables
            os.execvpe(BUILD / "bin" / "emulator", ["emulator", "debug", *arguments], environment)
        self.seen = b""

    def write(self, text: bytes) -> None:
        os.write(self.fd, text)

    def read_to(self, expected: bytes, again: bytes = b"") -> bytes:
        """Reads up to `expected`; sends `again` whenever nothing has come for a while."""
        for _ in range(600):
            if expected in self.seen:
                before, _, self.seen = self.seen.partition(expected)
                return before
            if select.select([self.fd], [], [], 0.2)[0]:
                try:
                    self.seen += os.read(self.fd, 4096)
                except OSError:
                    break
            elif again:
                self.write(again)
        raise AssertionError(f"{expected!r} does not come: {self.seen!r}")

    def status(self) -> int:
        with contextlib.suppress(OSError):  # the terminal ends with the program
            while os.read(self.fd, 4096):
                pass
        return os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    write_program(tmp_path)
    (tmp_path / "endless.asm").write_text(ENDLESS)
    yield tmp_path


@pytest.mark.parametrize("typed", [b"", b"print 12"])
def test_at_the_prompt_it_drops_the_line(folder: Path, typed: bytes) -> None:
    terminal = Terminal(folder, "endless.asm")
    terminal.read_to(b"> ")
    terminal.write(typed)
    if typed:
        terminal.read_to(typed[-1:])
    terminal.write(CTRL_C)
    terminal.read_to(b"> ", again=CTRL_C)  # one that comes before the editing of the line begins has no effect
    terminal.write(b"print 40 + 2\r")
    terminal.read_to(b"42")
    terminal.write(b"quit\r")
    assert terminal.status() == 0


def test_a_running_command_and_its_script_end(folder: Path) -> None:
    (folder / "script.txt").write_text("print 1000 + 7\ncontinue\nprint 2000 + 7\n")
    terminal = Terminal(folder, "endless.asm")
    terminal.read_to(b"> ")
    terminal.write(b"source script.txt\r")
    terminal.read_to(b"1007")
    terminal.read_to(b"paused", again=CTRL_C)
    terminal.write(b"print 3000 + 7\r")
    assert b"2007" not in terminal.read_to(b"3007")
    terminal.write(b"quit\r")
    assert terminal.status() == 0


def test_a_script_of_the_command_line_ends_the_program(folder: Path) -> None:
    (folder / "script.txt").write_text("print 1000 + 7\ncontinue\nprint 2000 + 7\n")
    terminal = Terminal(folder, "endless.asm", "-x", "script.txt")
    terminal.read_to(b"1007")
    terminal.write(CTRL_C)
    assert terminal.status() == 128 + signal.SIGINT


def test_a_pipe_of_commands_ends_as_a_script_does(folder: Path) -> None:
    with subprocess.Popen(
        [BUILD / "bin" / "emulator", "debug", "endless.asm"],
        cwd=folder,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    ) as done:
        assert done.stdin is not None and done.stdout is not None
        done.stdin.write(b"print 1000 + 7\ncontinue\nprint 2000 + 7\n")
        done.stdin.close()
        for _ in range(3):  # until the program is there, and has been told where it stands
            done.stdout.readline()
        done.send_signal(signal.SIGINT)
        assert b"2007" not in done.stdout.read()
    assert done.returncode == 128 + signal.SIGINT


def test_a_command_of_the_command_line_ends_and_the_prompt_comes(folder: Path) -> None:
    terminal = Terminal(folder, "endless.asm", "-e", "print 1000 + 7", "-e", "continue", "-e", "print 2000 + 7")
    terminal.read_to(b"1007")
    assert b"2007" not in terminal.read_to(b"> ", again=CTRL_C)
    terminal.write(b"nonsense\r")
    terminal.read_to(b"is not a command")
    terminal.write(b"print 3000 + 7\r")
    terminal.read_to(b"3007")
    terminal.write(b"quit\r")
    assert terminal.status() == 0


@pytest.mark.parametrize("locale", ["C", "C.UTF-8"])
def test_letters_of_all_kinds_can_be_typed(folder: Path, locale: str) -> None:
    terminal = Terminal(folder, "endless.asm", LC_ALL=locale)
    terminal.read_to(b"> ")
    terminal.write("print «ü漢»\r".encode())
    terminal.read_to('error: expression "«ü漢»"'.encode())
    terminal.write(b"quit\r")
    assert terminal.status() == 0


def test_a_long_command_shows_where_it_is_and_clears_that(folder: Path) -> None:
    terminal = Terminal(folder, "endless.asm")
    terminal.read_to(b"> ")
    terminal.write(b"continue\r")
    terminal.read_to(b" s \r")
    terminal.write(CTRL_C)
    assert terminal.read_to(b"paused").endswith(b" " * 24 + b"\r")
    terminal.write(b"quit\r")
    assert terminal.status() == 0
