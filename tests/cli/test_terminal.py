"""No input speaks to the terminal: control characters of files, names and arguments are shown as \\xNN in messages and
listings."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from cmrc import _core, files
from cmrc_test import forms
from locations import BUILD

EMULATOR = BUILD / "bin" / "emulator"
EVIL = "\x1b]0;owned\x07\x1b[2J\x9b31m\x7f\x08"
SHOWN = r"\x1B]0;owned\x07\x1B[2J\xC2\x9B31m\x7F\x08"
toolchain = _core.toolchain


def emulator(folder: Path, *arguments: str) -> "subprocess.CompletedProcess[bytes]":
    return subprocess.run([EMULATOR, *arguments], check=False, cwd=folder, capture_output=True, timeout=60)


def harmless(text: bytes) -> str:
    """It is UTF-8, and no character of it is a control (Unicode category Cc) but newline and tab."""
    decoded = text.decode("utf-8")
    assert not [c for c in decoded if (ord(c) < 0x20 and c not in "\n\t") or 0x7F <= ord(c) < 0xA0], decoded
    return decoded


@pytest.mark.parametrize(
    ("given", "shown"),
    [
        ("plain text\n\tand more", "plain text\n\tand more"),
        (EVIL, SHOWN),
        ("a\rb\0c\x0bd", r"a\x0Db\x00c\x0Bd"),
        ("µ°²ä€😀\u00a0", "µ°²ä€😀\u00a0"),
        ("\x80\x9f", r"\xC2\x80\xC2\x9F"),
        (b"caf\xe9 \x9b31m \xc3", r"caf\xE9 \x9B31m \xC3"),
        (
            b"\xc0\x9b \xe0\x80\x9b \xed\xa0\x80 \xf5\x80\x80\x80",
            r"\xC0\x9B \xE0\x80\x9B \xED\xA0\x80 \xF5\x80\x80\x80",
        ),  # overlong, surrogate, too large
        # The last character before the surrogates, the last surrogate, the first character behind them; the largest.
        (b"\xed\x9f\xbf \xed\xbf\xbf \xee\x80\x80 \xf4\x8f\xbf\xbf", "\ud7ff \\xED\\xBF\\xBF \ue000 \U0010ffff"),
    ],
)
def test_printable(given: str | bytes, shown: str) -> None:
    raw = given.encode() if isinstance(given, str) else given
    assert _core.io.printable(raw) == shown
    assert files.printable(os.fsdecode(raw)) == shown


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Of each kind of input one with a text that a terminal would obey."""
    (tmp_path / "error.asm").write_text(f"_start: bogus r0 ; {EVIL}\n")
    (tmp_path / "fine.asm").write_text(f"_start: ldi 1,r0 ; {EVIL}\n        idle\n")
    (tmp_path / "latin.asm").write_bytes(b"_start: bogus r0 ; caf\xe9\n")
    (tmp_path / "warning.asm").write_text(f"_start: ldi 010,r0 ; {EVIL}\n        idle\n")
    (tmp_path / "message.asm").write_text(f'        .emsg "{EVIL}"\n')
    (tmp_path / "c.toml").write_text('[machine]\n"x\\u001b[2J" = 1\n')
    (tmp_path / "board.toml").write_text('name = "\\u001b[2J"\n"x\\u001b[2J" = 1\n')
    (tmp_path / "v.txt").write_text(f"id={EVIL.replace(' ', '')} op=0C800000 -> PC=00000000\n")
    (tmp_path / "t").write_text(f"{EVIL}\n")
    (tmp_path / f"{EVIL}.asm").write_text("_start: bogus r0\n")
    file = bytearray(
        forms.object_bytes(toolchain.assemble_object("        .global label\nlabel:  .word 1\n        b label\n"))
    )
    at = file.index(b"label\0\0\0")
    file[at : at + 8] = b"\x1b[2Jx\0\0\0"
    (tmp_path / "s.obj").write_bytes(file)
    (tmp_path / "mine.obj").write_bytes(file.replace(b".text\0\0\0", b"\x1b[2Jx\0\0\0"))
    return tmp_path


@pytest.mark.parametrize(
    "command",
    [
        ["asm", "error.asm", "-o", "o"],
        ["asm", "message.asm", "-o", "o"],
        ["asm", f"{EVIL}.asm", "-o", "o"],
        ["asm", f"{EVIL}.none", "-o", "o"],
        ["asm", "fine.asm", "-o", f"{EVIL}/o"],
        ["asm", "latin.asm", "-o", "o"],
        ["exec", "error.asm"],
        ["exec", "s.obj", "--until", EVIL],
        ["exec", "fine.asm", "--board", "board.toml"],
        ["exec", "fine.asm", "--board", EVIL],
        ["exec", "fine.asm", "--pipeline", "0:10"],
        ["disasm", "s.obj"],
        ["disasm", "mine.obj"],
        ["disasm", "fine.asm"],
        ["disasm", "s.obj", "--source"],
        ["link", "s.obj", "s.obj", "-o", "o"],
        ["vectors", "v.txt"],
        ["vectors", "v.txt", "--json"],
        ["trace-diff", "t", "t"],
        ["--config", "c.toml", "--quiet"],
        ["--set", f"{EVIL}=1"],
        ["--set", f"machine.idle_policy={EVIL}"],
        [EVIL],
        [f"--{EVIL}"],
    ],
    ids=ascii,
)
def test_nothing_that_is_printed_is_obeyed(folder: Path, command: list[str]) -> None:
    result = emulator(folder, *command)
    assert result.returncode in (0, 1, 2)
    assert harmless(result.stdout) + harmless(result.stderr) != ""


@pytest.mark.parametrize(
    ("command", "shown"),
    [
        (["asm", "error.asm", "-o", "o"], SHOWN),
        (["asm", "latin.asm", "-o", "o"], r"caf\xE9"),
        (["--set", f"{EVIL}=1"], SHOWN),
    ],
)
def test_what_was_there_is_still_reported(folder: Path, command: list[str], shown: str) -> None:
    result = emulator(folder, *command)
    assert shown in (result.stdout + result.stderr).decode()


def test_listings_and_maps_are_harmless_and_the_words_are_the_same(folder: Path) -> None:
    assert emulator(folder, "asm", "fine.asm", "-o", "fine.out", "--listing", "fine.lst").returncode == 0
    assert SHOWN in harmless((folder / "fine.lst").read_bytes())
    assert emulator(folder, "link", "mine.obj", "-o", "o.out", "--map-output", "o.map").returncode == 0
    assert r"\x1B[2Jx" in harmless((folder / "o.map").read_bytes())
    assert (
        toolchain.read_coff(folder / "fine.out").sections[0].words
        == toolchain.assemble(" ldi 1,r0\n idle\n").sections[0].words
    )


def test_json_is_still_json_and_has_the_characters_themselves(folder: Path) -> None:
    found = json.loads(emulator(folder, "vectors", "v.txt", "--json").stdout)
    assert found["failures"][0]["id"] == EVIL


def test_a_printed_configuration_reads_back(folder: Path) -> None:
    printed = emulator(folder, "config", "--set", f"machine.programs={EVIL}")
    (folder / "printed.toml").write_text(harmless(printed.stdout))
    read = _core.cmrc.config(file=str(folder / "printed.toml")).to_dict()["machine.programs"]
    assert read == str(folder / EVIL)  # a printed path is a whole one


def test_the_page_command_prints_nothing_that_is_obeyed(folder: Path) -> None:
    command = [sys.executable, "-m", "cmrc", "page", f"{EVIL}.html", "--plots", "x.png"]
    result = subprocess.run(
        command, check=False, cwd=folder, capture_output=True, env={**os.environ, "PYTHONPATH": str(BUILD / "python")}
    )
    assert result.returncode == 2 and "x1B" in harmless(result.stderr).replace("x1b", "x1B")


def test_a_page_has_a_title_in_utf_8(tmp_path: Path) -> None:
    folder = os.fsencode(tmp_path)
    Path(os.fsdecode(folder + b"/gr\xfc\xdfe.toml")).write_text("[run]\nduration_s = 0.03\n")
    assert emulator(tmp_path, "--config", os.fsdecode(b"gr\xfc\xdfe.toml"), "--page", "page.html").returncode == 0
    assert r"<title>gr\xFC\xDFe: 4 DSPs, 0.03 s</title>" in (tmp_path / "page.html").read_bytes().decode("utf-8")
