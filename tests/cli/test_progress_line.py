"""The progress line: never longer than its terminal, and never the end of the work (docs/cli.md)."""

import fcntl
import json
import os
import pty
import struct
import subprocess
import termios
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from locations import BUILD

EMULATOR = BUILD / "bin" / "emulator"
PATIENCE = 120
ENDLESS = ["--duration", "80000", "--set", "report.signal_decimation=80000"]


class Terminal:
    """A pseudo-terminal: the test holds its screen, and may close the window."""

    def __init__(self, columns: int = 80) -> None:
        try:
            self.screen, self.side = pty.openpty()
        except OSError:
            pytest.skip("no pseudo-terminals here (a chroot without /dev/pts)")
        fcntl.ioctl(self.side, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        self.shown = b""
        self.open = True

    def start(
        self, folder: Path, command: list[str], program: tuple[str, ...] = (str(EMULATOR),), **streams: Any
    ) -> "subprocess.Popen[bytes]":
        """The program; all its streams are this terminal, but those that are given."""
        of = {"stdin": self.side, "stdout": self.side, "stderr": self.side, **streams}
        self.process = subprocess.Popen([*program, *command], cwd=folder, **of)
        os.close(self.side)
        return self.process

    def until(self, ready: Callable[[], bool]) -> None:
        """Reads what is shown until then."""
        while not ready():
            part = os.read(self.screen, 1000)
            assert part, self.shown
            self.shown += part

    def rest(self) -> None:
        try:
            while part := os.read(self.screen, 1000):
                self.shown += part
        except OSError:  # the program has ended
            pass

    def close(self) -> None:
        if self.open:
            os.close(self.screen)
        self.open = False


@pytest.fixture
def terminal() -> Iterator[Terminal]:
    made = Terminal()
    yield made
    made.close()
    if made.process.poll() is None:
        made.process.kill()
        made.process.wait()


def controls() -> None:
    """In the new process: this terminal is the session's, so that its end is a SIGHUP."""
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)


def complete(path: Path) -> dict:  # type: ignore[type-arg]
    return json.loads(path.read_text())  # type: ignore[no-any-return]


@pytest.mark.parametrize(
    ("command", "output"),
    [(["--report", "o.json"], "o.json"), (["compare", "--json", "o.json"], "o.json")],
    ids=["run", "compare"],
)
def test_work_goes_on_where_the_line_cannot_be_shown_any_more(
    terminal: Terminal, tmp_path: Path, command: list[str], output: str
) -> None:
    """Only standard error was the terminal, and no signal comes: the run ends as it would have."""
    with (tmp_path / "stdout").open("wb") as out:
        process = terminal.start(
            tmp_path, [*command, "--dsps", "1", "--duration", "3"], stdin=subprocess.DEVNULL, stdout=out
        )
        terminal.until(lambda: b"x real time" in terminal.shown)
        terminal.close()
        assert process.wait(PATIENCE) == 0
    assert complete(tmp_path / output) and (tmp_path / "stdout").stat().st_size > 300


@pytest.mark.parametrize("command", [[], ["compare"]], ids=["run", "compare"])
def test_a_window_that_is_closed_loses_no_output(terminal: Terminal, tmp_path: Path, command: list[str]) -> None:
    """A SIGHUP, and nothing can be printed any more."""
    asked = ["--json", "o.json"] if command else ["--report", "o.json", "--page", "p.html", "--trace", "t"]
    process = terminal.start(
        tmp_path, [*command, *ENDLESS, "--dsps", "2", *asked], start_new_session=True, preexec_fn=controls
    )
    terminal.until(lambda: b"x real time" in terminal.shown)
    terminal.close()
    assert process.wait(PATIENCE) == 129
    assert complete(tmp_path / "o.json")["stop_reason"] == "interrupted"
    assert command or all((tmp_path / name).stat().st_size > 1000 for name in ("p.html", "t"))


def test_the_status_of_limits_is_the_signals_too_where_its_table_cannot_be_printed(
    terminal: Terminal, tmp_path: Path
) -> None:
    grid = ["--duration", "1000", "--set", "machine.boot=preloaded", "--set", "host.start_ms=0", "--dsps-grid", "1:4"]
    process = terminal.start(
        tmp_path, ["limits", *grid, "--json", "o.json"], start_new_session=True, preexec_fn=controls
    )
    terminal.until(lambda: b"1 of 4" in terminal.shown)
    terminal.close()
    assert process.wait(PATIENCE) == 129
    assert complete(tmp_path / "o.json")["stop_reason"] == "interrupted"


def test_a_run_under_nohup_outlives_its_window(terminal: Terminal, tmp_path: Path) -> None:
    shell = f"trap '' HUP; exec {EMULATOR} --dsps 1 --duration 3 --report o.json > stdout"
    terminal.start(tmp_path, [shell], ("bash", "-c"), start_new_session=True, preexec_fn=controls)
    terminal.until(lambda: b"x real time" in terminal.shown)
    terminal.close()
    assert terminal.process.wait(PATIENCE) == 0
    assert complete(tmp_path / "o.json")["stop_reason"] == "completed"


@pytest.mark.parametrize("columns", [20, 40, 80])
def test_a_line_is_never_longer_than_its_terminal(tmp_path: Path, columns: int) -> None:
    """Else it would be two, and each update would leave one behind."""
    terminal = Terminal(columns)
    work = ["--dsps", "1", "--duration", "20", "--set", "report.reference=none"]
    process = terminal.start(tmp_path, work, stdout=subprocess.DEVNULL)
    reader = threading.Thread(target=terminal.rest)
    reader.start()
    assert process.wait(PATIENCE) == 0
    reader.join(PATIENCE)
    terminal.close()
    lines = terminal.shown.decode().split("\r")
    assert any(" of 20.0 s" in line for line in lines) and "\n" not in terminal.shown.decode()
    assert max(map(len, lines)) <= columns - 1
    assert columns < 60 or any("missed" in line for line in lines)


@pytest.mark.parametrize("columns", [20, 40])
def test_a_line_of_the_package_is_never_longer_than_its_terminal_either(columns: int) -> None:
    from cmrc.progress import ProgressLine

    terminal = Terminal(columns)
    with open(terminal.side, "w", encoding="utf-8") as stream, ProgressLine("work", stream) as line:
        line.show("x" * 100, now=True)
        line.show("short", now=True)
    terminal.rest()
    terminal.close()
    lines = terminal.shown.decode().split("\r")
    assert lines[1] == "work: " + (columns - 7) * "x" and max(map(len, lines)) == columns - 1
