"""Inputs of users, by every front end: ROMs, words before the start, conditions of the end, sources of any form.
Correct input runs alike; each front end refuses wrong input, and names the place."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from board_parts import HEAD, device
from cmrc.c40 import Processor, assemble_file
from cmrc.network import Network
from command_line import emulator
from dap import events, responses
from dap.base import ErrorResponse
from debugger.editor import Editor

# R5 is the word at 300200h, R6 at A0000000h.
TEXT = "start:  ldi 42,r5\n        ldhi 30h,ar0\n        or 200h,ar0\n        ldi *ar0,r6\nend:    b end\n"
EPROM = '\n[[region]]\nname = "EPROM"\nbase = 0x80000000\nwords = 0x100\nbus = "global"\n'
PINS = '\n[pins]\nromen = true\niiof = "0111"\n'

Given = dict[str, Any]
"""Arguments by the names of `launch` in docs/dap.md."""
OPTIONS = {"romWidth": "--rom-width"}


class Refused(Exception):
    pass


def options(folder: Path, given: Given) -> list[str]:
    out = []
    for name, value in given.items():
        for one in value if isinstance(value, list) else [value]:
            out += [] if name == "program" else [OPTIONS.get(name, f"--{name}")]
            out.append(in_folder(folder, one))
    return out


def in_folder(folder: Path, value: object) -> str:
    """The folder has the files."""
    text = str(value)
    name = re.split(r"[@=]", text)[0]
    return str(folder / text) if (folder / name).exists() else text


def by_exec(folder: Path, given: Given) -> tuple[int, int]:
    done = emulator("exec", *options(folder, given), "--json")
    if done.returncode == 2:
        raise Refused(done.stderr)
    registers = json.loads(done.stdout)["registers"]
    return registers["R5"] & 0xFFFFFFFF, registers["R6"] & 0xFFFFFFFF


def by_debug(folder: Path, given: Given) -> tuple[int, int]:
    done = emulator("debug", *options(folder, given), stdin="continue\nprint r5\nprint r6\n")
    if done.returncode == 2:
        raise Refused(done.stderr)
    found = [int(text, 16) & 0xFFFFFFFF for text in re.findall(r"([0-9A-F]{8,10})h", done.stdout)[-2:]]
    return found[0], found[1]


def by_dap(folder: Path, given: Given) -> tuple[int, int]:
    keys = {
        name: [in_folder(folder, one) for one in value]
        if isinstance(value, list)
        else value
        if name == "romWidth"
        else in_folder(folder, value)
        for name, value in given.items()
    }
    with Editor() as editor:
        editor.wait(responses.Initialized)
        editor.client.send_request("launch", {**keys, "stopAtEnd": True})
        answer = editor.wait(lambda message: isinstance(message, ErrorResponse | events.InitializedEvent))
        if isinstance(answer, ErrorResponse):
            raise Refused(str(answer.message))
        editor.configured()
        editor.stopped()
        return tuple(int(editor.value(name).split()[0]) & 0xFFFFFFFF for name in ("r5", "r6"))  # type: ignore[return-value]


FRONTS: dict[str, Callable[[Path, Given], tuple[int, int]]] = {"exec": by_exec, "debug": by_debug, "dap": by_dap}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A program as source, as EPROMs, and boards; and the same with something wrong."""
    path = tmp_path_factory.mktemp("front")
    (path / "p.asm").write_text(TEXT)
    assert emulator("asm", path / "p.asm", "-o", path / "p.out", "--section", ".text=2FFC00h").returncode == 0
    for name, form, width in (("rom.hex", "intel-hex", 8), ("rom.bin", "binary", 32), ("rom.s", "srec", 16)):
        assert emulator("image", path / "p.out", "--format", form, "--width", width, "-o", path / name).returncode == 0
    (path / "cut.hex").write_text("\n".join((path / "rom.hex").read_text().splitlines()[:1]) + "\n")
    (path / "odd.bin").write_bytes((path / "rom.bin").read_bytes()[:-1])
    (path / "data").write_bytes((77).to_bytes(4, "little") * 3)
    (path / "three").write_bytes(b"\1\2\3")
    (path / "no.width").write_bytes(b"\7\0\0\0" * 4)
    for name, contents, width in (
        ("b", "rom.hex", ""), ("bcut", "cut.hex", ""), ("bodd", "odd.bin", ""), ("bwide", "no.width", ""), ("bseven", "no.width", "width = 7\n"), ("bgone", "gone", ""), ("bthree", "three", "width = 16\n"),
    ):  # fmt: skip
        (path / f"{name}.toml").write_text(HEAD + EPROM + f'file = "{contents}"\n' + width + PINS)
    (path / "bsmall.toml").write_text(HEAD + EPROM.replace("0x100", "4") + 'file = "rom.hex"\n' + PINS)
    (path / "bfifo.toml").write_text(HEAD + device("fifo", input="words16"))
    wide = lambda text: b"\xff\xfe" + text.encode("utf-16-le")
    (path / "words16").write_bytes(wide("7 8\n"))
    (path / "b16.toml").write_bytes(wide((path / "b.toml").read_text()))
    (path / "bdos.toml").write_bytes((path / "b.toml").read_text().replace("\n", "\r\n").encode() + b"\x1a")
    (path / "blatin.toml").write_bytes("# Gr\xf6\xdfe\n".encode("latin-1") + (path / "b.toml").read_bytes())
    sources = {
        "dos.asm": TEXT.replace("\n", "\r\n").encode() + b"\x1a\x1a",
        "latin.asm": TEXT.replace("42,r5", "42,r5 ; gr\xfc\xdfe").encode("latin-1"),
        "doubled.asm": TEXT.replace("\n", "\r\r\n").encode(),
        "behind.asm": TEXT.encode() + b"\x1a\0\0 left over",
        "no.end.asm": TEXT.rstrip("\n").encode(),
        "utf16.asm": wide(TEXT),
        "utf16be.asm": b"\xfe\xff" + TEXT.encode("utf-16-be"),
        "unmarked.asm": TEXT.encode("utf-16-le"),
        "utf32.asm": TEXT.encode("utf-32"),
        "mac.asm": TEXT.replace("\n", "\r").encode(),
        "zeros.asm": TEXT.encode() + b"\0" * 40,
        "utf16.hex": wide("08650000\n6A00FFFF\n"),
    }
    for name, contents in sources.items():
        (path / name).write_bytes(contents)
    return path


RIGHT: list[tuple[Given, tuple[int, int]]] = [
    ({"rom": "rom.hex@80000000h", "boot": "80000000h"}, (42, 0)),
    ({"rom": "rom.s@80000000h", "boot": "80000000h"}, (42, 0)),
    ({"program": "p.out", "rom": "rom.bin@80000000h", "boot": "80000000h"}, (42, 0)),
    ({"rom": "rom.bin@80000000h", "romWidth": 32, "boot": "80000000h", "poke": "300200h=9"}, (42, 9)),
    ({"board": "b.toml", "boot": "reset"}, (42, 0)),
    ({"board": "bdos.toml", "boot": "reset"}, (42, 0)),
    ({"program": "p.out", "board": "b.toml", "boot": "reset", "load": "data@300200h"}, (42, 77)),
    ({"program": "p.out", "boot": "80000000h"}, (42, 0)),
    ({"program": "p.out", "load": "data@300200h", "poke": ["300201h=1", "300200h=8"]}, (42, 8)),
    ({"program": "p.out", "load": ["data@300200h", "rom.bin@300210h"]}, (42, 77)),
    ({"program": "p.asm", "poke": "300200h=5", "until": "end"}, (42, 5)),
    ({"program": "p.asm", "poke": "300200h=5", "until": ["300001h"]}, (42, 0)),
    *(
        ({"program": name, "poke": "300200h=5"}, (42, 5))
        for name in ("dos.asm", "latin.asm", "doubled.asm", "behind.asm", "no.end.asm")
    ),
]


@pytest.mark.parametrize("front", FRONTS)
@pytest.mark.parametrize(
    ("given", "expected"), RIGHT, ids=[" ".join(f"{k}={v}" for k, v in given.items()) for given, _ in RIGHT]
)
def test_what_is_right_runs_alike_by_every_front_end(
    folder: Path, front: str, given: Given, expected: tuple[int, int]
) -> None:
    assert FRONTS[front](folder, given) == expected


WRONG: list[tuple[Given, str]] = [
    (
        {"rom": "cut.hex@80000000h", "boot": "80000000h"},
        "cut.hex:1: the file ends without its last record: it is cut short",
    ),
    (
        {"rom": "odd.bin@80000000h", "boot": "80000000h"},
        "odd.bin: its 55 bytes are no whole number of words of 32 bits: the last has 3 of 4 bytes",
    ),
    ({"rom": "no.width@80000000h", "boot": "80000000h"}, "does not say how wide it is"),
    ({"rom": "rom.hex@80000000h", "romWidth": 7, "boot": "80000000h"}, "idth"),
    ({"rom": "rom.hex@400000h", "boot": "80000000h"}, "do not lie in memory"),
    (
        {"rom": ["rom.hex@80000000h", "rom.bin@80000020h"], "boot": "80000000h"},
        "its words 80000020h to 8000002Dh overlap those of",
    ),
    ({"rom": "rom.hex@80000000h"}, "--rom: needs --boot"),
    ({"rom": "rom.hex@80000000h", "boot": "310000h"}, "the pins choose"),
    ({"rom": "rom.hex@80000000h", "boot": "reset"}, "has no [pins]"),
    ({"rom": "gone@80000000h", "boot": "80000000h"}, "gone"),
    ({"rom": "rom.hex", "boot": "80000000h"}, "is not FILE@ADDRESS"),
    ({"board": "bcut.toml", "boot": "reset"}, "bcut.toml:22: region.file of EPROM: "),
    ({"board": "bodd.toml", "boot": "reset"}, "no whole number of words of 32 bits"),
    ({"board": "bthree.toml", "boot": "reset"}, "no whole number of words of 16 bits"),
    ({"board": "bwide.toml", "boot": "reset"}, "region.width is expected"),
    ({"board": "bseven.toml", "boot": "reset"}, "bseven.toml:23: region.width of EPROM: 8, 16 or 32 is expected"),
    ({"board": "bgone.toml", "boot": "reset"}, "cannot be read"),
    ({"board": "bsmall.toml", "boot": "reset"}, "words do not go into 4"),
    (
        {"board": "b16.toml", "boot": "reset"},
        "b16.toml:1: the text is in UTF-16; a text in ASCII, Latin-1 or UTF-8 is expected",
    ),
    ({"board": "blatin.toml", "boot": "reset"}, "blatin.toml:1: "),
    ({"program": "p.asm", "board": "bfifo.toml"}, "words16:1: the text is in UTF-16"),
    (
        {"program": "p.asm", "load": "three@300200h"},
        "three: its 3 bytes are no whole number of words of 32 bits: the last has 3 of 4 bytes",
    ),
    ({"program": "p.asm", "load": "data@0A0000000h"}, "do not lie in memory"),
    ({"program": "p.asm", "load": "data"}, "is not FILE@"),
    ({"program": "p.asm", "load": "gone@300200h"}, "gone"),
    ({"program": "p.asm", "poke": "300200h"}, "is not ADDRESS=WORD"),
    ({"program": "p.asm", "poke": "nowhere=1"}, '"nowhere"'),
    ({"program": "p.asm", "until": "nowhere"}, '"nowhere"'),
    *(
        ({"program": name}, f"{name}:1:1: error: the text is in UTF-16; a text in ASCII, Latin-1 or UTF-8 is expected")
        for name in ("utf16.asm", "utf16be.asm", "unmarked.asm")
    ),
    ({"program": "utf32.asm"}, "utf32.asm:1:1: error: the text is in UTF-32"),
    ({"program": "mac.asm"}, "mac.asm:1:1: error: the lines end in a carriage return alone"),
    ({"program": "zeros.asm"}, "zeros.asm:6:1: error: a byte 0 is here"),
    ({"program": "utf16.hex"}, "utf16.hex:1: the text is in UTF-16"),
]


@pytest.mark.parametrize("front", FRONTS)
@pytest.mark.parametrize(
    ("given", "message"), WRONG, ids=[" ".join(f"{k}={v}" for k, v in given.items()) for given, _ in WRONG]
)
def test_what_is_wrong_is_refused_by_every_front_end(folder: Path, front: str, given: Given, message: str) -> None:
    with pytest.raises(Refused) as refused:
        FRONTS[front](folder, given)
    assert message in str(refused.value)


BOARDS = [(given["board"], message) for given, message in WRONG if "board" in given and "program" not in given]


@pytest.mark.parametrize(("name", "message"), BOARDS)
def test_a_board_that_cannot_be_is_refused_by_python_and_in_networks(folder: Path, name: str, message: str) -> None:
    program = assemble_file(folder / "p.asm")
    (folder / "n.toml").write_text(f'[[chip]]\nboard = "{name}"\nboot = true\n')
    for make in (
        lambda: Processor(program, board=folder / name),
        lambda: Network([program], boards=str(folder / name)),
        lambda: Network.from_file(folder / "n.toml"),
    ):
        with pytest.raises(ValueError, match=re.escape(message)):
            make()
    done = emulator("exec", "--network", folder / "n.toml")
    assert done.returncode == 2 and message in done.stderr


@pytest.mark.parametrize(
    ("name", "width", "message"),
    [
        ("cut.hex", None, "it is cut short"),
        ("odd.bin", None, "no whole number of words of 32 bits"),
        ("no.width", None, "so it does not say how wide it is; width is expected"),
        ("no.width", 7, "width 7: 8, 16 or 32 is expected"),
        ("three", 16, "no whole number of words of 16 bits"),
    ],
)
def test_a_rom_that_cannot_be_is_refused_by_a_processor(
    folder: Path, name: str, width: int | None, message: str
) -> None:
    processor = Processor(board="default", boots_from=0x80000000)
    with pytest.raises(ValueError, match=re.escape(message)):
        processor.load_rom(folder / name, 0x80000000, width=width)
    with pytest.raises(IndexError):
        processor.load_rom(folder / "rom.hex", 0xFFFFFFF0)
    processor.load_rom(folder / "rom.hex", 0x80000000)
    processor.boot()
    processor.run(max_cycles=20_000)
    assert processor.registers["R5"] & 0xFFFFFFFF == 42


@pytest.mark.parametrize("name", ["utf16.asm", "utf16be.asm", "unmarked.asm", "utf32.asm", "mac.asm", "zeros.asm"])
def test_every_reader_of_sources_names_a_form_that_it_does_not_read(folder: Path, tmp_path: Path, name: str) -> None:
    place = f"{name}:"
    for arguments in (
        ("asm", folder / name, "-o", tmp_path / "o"),
        ("asm", folder / name, "-c", "-o", tmp_path / "o"),
        ("disasm", folder / name),
        ("image", folder / name, "--format", "binary", "-o", tmp_path / "o"),
    ):
        done = emulator(*arguments)
        assert (
            done.returncode == 2
            and place in done.stderr
            and ("the text is in" in done.stderr or "carriage return" in done.stderr or "byte 0" in done.stderr)
        ), done.stderr
        assert not (tmp_path / "o").exists()
    with pytest.raises(ValueError, match="the text is in|carriage return|byte 0"):
        assemble_file(folder / name)


def test_a_port_brings_no_program_to_a_debugger(folder: Path) -> None:
    for front in ("debug", "dap"):
        with pytest.raises(Refused, match="nobody sends the program here; --boot ADDRESS or reset is expected"):
            FRONTS[front](folder, {"program": "p.out", "boot": "3"})
    assert by_exec(folder, {"program": "p.out", "boot": "3"}) == (42, 0)


def test_what_stands_in_memory_at_the_start_is_of_programs_and_not_of_the_dock(folder: Path) -> None:
    for option in (["--poke", "300200h=1"], ["--load", folder / "data"], ["--until", "end"]):
        done = emulator("debug", *option, stdin="")
        assert done.returncode == 2 and "are for programs and networks" in done.stderr
