"""Malformed files: every front end that reads such a file refuses it with a message that names the place."""

import struct
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from cmrc import _core
from cmrc_test import forms
from command_line import emulator

toolchain = _core.toolchain
REGION = '[[region]]\nname = "r"\nbase = 0x300000\nwords = 1\nbus = "local"\n'
PROGRAM = "        .text\n_start: ldi 1,r0\n        idle\n"


def refused(result: "subprocess.CompletedProcess[str]", *words: str) -> None:
    assert result.returncode == 2 and result.stdout == "", (result.returncode, result.stdout, result.stderr)
    assert result.stderr.startswith("emulator: ") and result.stderr.count("\n") == 1
    for word in words:
        assert word in result.stderr


def header(version: int, executable: bool = False) -> bytes:
    """A COFF file that ends behind its file header: no section, no symbol (docs of TI's COFF, 0093h is the C3x/C4x)."""
    flags = 0x0100 | (2 if executable else 0)
    if version == 0:
        return struct.pack("<HHIIIHH", 0x93, 0, 0, 20, 0, 0, flags)
    return struct.pack("<HHIIIHHH", {1: 0xC1, 2: 0xC2}[version], 0, 0, 22, 0, 0, flags, 0x93)


# ---- objects and programs without a word


@pytest.fixture(params=["v0", "v1", "v2", "assembled", "empty section"])
def wordless(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    if request.param.startswith("v"):
        (tmp_path / "o.obj").write_bytes(header(int(request.param[1])))
    else:
        (tmp_path / "o.asm").write_text("" if request.param == "assembled" else '        .sect "mine"\nlabel:\n')
        assert emulator("asm", "-c", "o.asm", "-o", "o.obj", folder=tmp_path).returncode == 0
    return "o.obj"


@pytest.mark.parametrize(
    "command",
    [["link", "o.obj", "-o", "x.out"], ["exec", "o.obj"], ["exec", "o.obj", "o.obj", "--link", "0.0:1.3"]],
    ids=" ".join,
)
def test_an_object_without_a_word_is_no_program(tmp_path: Path, wordless: str, command: list[str]) -> None:
    refused(emulator(*command, folder=tmp_path), wordless, "no section contains a word", "at least one")
    assert not (tmp_path / "x.out").exists()


def test_an_object_without_a_word_may_be_linked_to_others(tmp_path: Path, wordless: str) -> None:
    (tmp_path / "s.asm").write_text(PROGRAM)
    assert emulator("asm", "-c", "s.asm", "-o", "s.obj", folder=tmp_path).returncode == 0
    assert emulator("link", wordless, "s.obj", "-o", "x.out", folder=tmp_path).returncode == 0
    assert "stop: idle" in emulator("exec", "x.out", folder=tmp_path).stdout
    with pytest.raises(toolchain.LinkError, match="no section contains a word"):
        toolchain.link([forms.read_object((tmp_path / wordless).read_bytes())])


def test_an_empty_source_makes_no_program(tmp_path: Path) -> None:
    """What is written can be read: exec refuses a file without sections, so asm does not write one."""
    (tmp_path / "empty.asm").write_text("; nothing\n")
    (tmp_path / "old.out").write_text("old")
    refused(emulator("asm", "empty.asm", "-o", "old.out", folder=tmp_path), "no word", "at least one")
    refused(emulator("exec", "empty.asm", folder=tmp_path), "empty.asm", "no word")
    assert (tmp_path / "old.out").read_text() == "old"
    with pytest.raises(toolchain.CoffError, match="no word"):
        toolchain.write_coff(toolchain.assemble(""), tmp_path / "old.out")
    assert {path.name for path in tmp_path.iterdir()} == {"empty.asm", "old.out"}


# ---- symbols


@pytest.mark.parametrize("version", [0, 1, 2])
@pytest.mark.parametrize("through_the_table", [False, True], ids=["zeros", "string table"])
def test_an_empty_symbol_name_can_be_read_and_written(tmp_path: Path, version: int, through_the_table: bool) -> None:
    file = bytearray(forms.object_bytes(toolchain.assemble_object("        .global x\nx:      .word 1\n"), version))
    symbols, count = struct.unpack_from("<II", file, 8)
    entry = next(at for at in range(symbols, symbols + 18 * count, 18) if file[at : at + 8] == b"x\0\0\0\0\0\0\0")
    file[entry : entry + 8] = bytes(8)
    if through_the_table:
        strings = symbols + 18 * count
        [size] = struct.unpack_from("<I", file, strings)
        struct.pack_into("<II", file, entry, 0, size)
        struct.pack_into("<I", file, strings, size + 1)
        file += b"\0"
    read = forms.read_object(bytes(file))
    assert "" in [symbol.name for symbol in read.symbols]
    again = forms.read_object(forms.object_bytes(read, version))
    assert [(s.name, s.value, s.section) for s in again.symbols] == [(s.name, s.value, s.section) for s in read.symbols]
    image, _ = toolchain.link([read])
    toolchain.write_coff(image, tmp_path / "x.out")
    assert toolchain.read_coff(tmp_path / "x.out").sections[0].words == [1]


ONE_REGION = 'name = "b"\n[[region]]\nname = "a"\nbase = 0x300000\nwords = 16\nbus = "local"\n'


@pytest.mark.parametrize(
    ("command", "text", "message"),
    [
        ("exec p.asm --load F@300100h", ":02\0000\n", r"F:1: '\x00' is no hexadecimal digit"),
        ("exec --network F", '[[chip]]\nprogram = "t\\u0000.asm"\n', r"F:2: program: there is no file t\x00.asm"),
        (
            "exec p.asm --board F.toml",
            ONE_REGION + 'file = "t\\u0000"\n',
            r"F.toml:7: region.file of a: t\x00: cannot be read",
        ),
        ("--config F", '[machine]\nprograms = "t\\u0000"\n', r"t\x00/dsp.asm is not there"),
        ("--config F", '[dock]\nlayout = "t\\u0000"\n', r"dock.layout: t\x00: cannot be read"),
    ],
)
def test_a_byte_0_does_not_cut_a_message(tmp_path: Path, command: str, text: str, message: str) -> None:
    (tmp_path / "p.asm").write_text("start: b start\n")
    for name in ("F", "F.toml"):
        (tmp_path / name).write_text(text)
    done = emulator(*command.split(), folder=tmp_path)
    assert done.returncode == 2 and message in done.stderr


# ---- TOML that is nested without end

DEEP = 100_000
NESTED = {
    "arrays": lambda n: "a = " + "[" * n + "]" * n + "\n",
    "inline tables": lambda n: "a = " + "{a = " * n + "1" + "}" * n + "\n",
    "a header": lambda n: "[" + ".".join(["a"] * n) + "]\n",
    "a header of a list": lambda n: "[[" + ".".join(["a"] * n) + "]]\n",
    "a dotted key": lambda n: ".".join(["a"] * n) + " = 1\n",
    "a quoted dotted key": lambda n: ".".join(['"a"'] * n) + " = 1\n",
    "behind a string with quotes": lambda n: 'b = [{x = """a"""", ' + ".".join(["a"] * n) + " = 1}]\n",
    "behind an escaped quote": lambda n: 'b = [{x = "\\"", ' + ".".join(["a"] * n) + " = 1}]\n",
    "behind a literal string": lambda n: "b = [{x = '\\', " + ".".join(["a"] * n) + " = 1}]\n",
    "both": lambda n: "a = " + ("{" + ".".join(["a"] * 300) + " = ") * (n // 300) + "1" + "}" * (n // 300) + "\n",
    "unfinished": lambda n: "a = " + "[" * n,
}
READERS: dict[str, list[str]] = {
    "--config": ["--duration", "0.1", "--quiet", "--config", "deep.toml"],
    "dock.layout": ["--duration", "0.1", "--quiet", "--set", "dock.layout=deep.toml"],
    "emulator --board": ["--duration", "0.1", "--quiet", "--board", "deep.toml"],
    "exec --board": ["exec", "s.asm", "--board", "deep.toml"],
    "exec --network": ["exec", "--network", "deep.toml"],
    "link --map": ["link", "s.obj", "-o", "x.out", "--map", "deep.toml"],
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("deep")
    (path / "s.asm").write_text(PROGRAM)
    assert emulator("asm", "-c", "s.asm", "-o", "s.obj", folder=path).returncode == 0
    return path


@pytest.mark.parametrize("reader", READERS.values(), ids=list(READERS))
@pytest.mark.parametrize("text", NESTED.values(), ids=list(NESTED))
def test_toml_that_is_nested_deep_is_refused(folder: Path, reader: list[str], text: Callable[[int], str]) -> None:
    (folder / "deep.toml").write_text("# one\n" + text(DEEP))
    refused(emulator(*reader, folder=folder), "deep.toml:2", "more than 32 ", "a flatter file is expected")


@pytest.mark.parametrize("text", [NESTED["arrays"], NESTED["a header"], NESTED["a dotted key"]])
def test_toml_at_the_limit_is_not_refused_for_its_depth(folder: Path, text: Callable[[int], str]) -> None:
    (folder / "deep.toml").write_text(text(32))
    refused(emulator(*READERS["--config"], folder=folder), "no such ")


def test_dots_and_brackets_in_texts_and_comments_are_no_nesting(folder: Path) -> None:
    many = "[" * 100 + "." * 100
    (folder / "deep.toml").write_text(
        f'# {many}\nname = "{many}" # {many}\n{REGION}[pins]\n"{many}" = """\n{many}\n"{many}"""\n'
    )
    refused(emulator(*READERS["exec --board"], folder=folder), "no such key pins.")


# ---- names that no file system takes

TOO_LONG = "a" * 300
NAMING = {
    "chip.program": ("exec --network file.toml", f'[[chip]]\nprogram = "{TOO_LONG}"\n'),
    "chip.board": ("exec --network file.toml", f'[[chip]]\nprogram = "s.asm"\nboard = "{TOO_LONG}.toml"\n'),
    "region.file": ("exec s.asm --board file.toml", f'{REGION}file = "{TOO_LONG}"\n'),
    "machine.programs": ("--config file.toml", f'[machine]\nprograms = "{TOO_LONG}"\n'),
    "machine.board": ("--config file.toml", f'[machine]\nboard = "{TOO_LONG}.toml"\n'),
    "dock.layout": ("--config file.toml", f'[dock]\nlayout = "{TOO_LONG}"\n'),
}


@pytest.mark.parametrize(("command", "text"), NAMING.values(), ids=list(NAMING))
def test_a_file_with_a_name_that_is_too_long_is_not_there(tmp_path: Path, command: str, text: str) -> None:
    """The file system's own words, without the place in the file, came through."""
    (tmp_path / "s.asm").write_text(PROGRAM)
    (tmp_path / "file.toml").write_text(text)
    refused(emulator(*command.split(), folder=tmp_path), TOO_LONG)


# ---- layouts


def test_a_bay_without_rows_is_refused(tmp_path: Path) -> None:
    (tmp_path / "lay.toml").write_text("rows_m = []\n[[containers]]\nx_m = 0.0\ny_m = 24.0\n")
    refused(
        emulator("--duration", "0.1", "--quiet", "--set", "dock.layout=lay.toml", folder=tmp_path),
        "lay.toml:1",
        "rows_m",
        "at least one row",
    )
