"""Files and lines go through objects, archives, executables and the linker (c40-hardware.md 10.1: six bytes a line)."""

from __future__ import annotations

import struct
import subprocess
from pathlib import Path
from typing import Any

import cmrc
import pytest
from cmrc import c40
from cmrc._core import toolchain

MAIN = """\
        .global fir, start
        .include "three.inc"
        .text
start:  ldi three,r0
        call fir
        .data
table:  .word 1,2
        .text
done:   b done
"""
FIR = """\
        .global fir
        .text

fir:    addi 1,r0
     || sti r1,*ar1
        rets
"""
INCLUDED = "three   .set 3\n        .text\nhelper: nop\n"


@pytest.fixture
def sources(tmp_path: Path) -> Path:
    (tmp_path / "main.asm").write_text(MAIN)
    (tmp_path / "fir.asm").write_text(FIR.replace("addi 1,r0\n     ||", "ldi *ar0,r0\n     ||"))
    (tmp_path / "three.inc").write_text(INCLUDED)
    return tmp_path


def run(emulator: Path, folder: Path, *arguments: str) -> str:
    done = subprocess.run([emulator, *arguments], cwd=folder, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def linked(emulator: Path, folder: Path, version: str = "2") -> Path:
    for name in ("main", "fir"):
        run(emulator, folder, "asm", "--object", f"{name}.asm", "-o", f"{name}.obj", "--coff-version", version)
    run(
        emulator,
        folder,
        "link",
        "main.obj",
        "fir.obj",
        "-o",
        "program.out",
        "--entry",
        "start",
        "--coff-version",
        version,
    )
    return folder / "program.out"


def lines_of(image: Any) -> list[tuple[int, str, int, str]]:
    return sorted((line.address, image.files[line.file], line.line, line.text) for line in image.lines)


@pytest.mark.parametrize("version", ["0", "1", "2"])
def test_a_linked_program_knows_where_each_word_comes_from(emulator: Path, sources: Path, version: str) -> None:
    image = c40.read_coff(linked(emulator, sources, version))
    at = image.symbols
    expected = {
        (at["helper"], "three.inc", 3, "helper: nop"),
        (at["start"], "main.asm", 4, "start:  ldi three,r0"),
        (at["start"] + 1, "main.asm", 5, "        call fir"),
        (at["table"], "main.asm", 7, "table:  .word 1,2"),
        (at["done"], "main.asm", 9, "done:   b done"),
        (at["fir"], "fir.asm", 4, "fir:    ldi *ar0,r0"),
        (at["fir"] + 1, "fir.asm", 6, "        rets"),
    }
    assert {(address, Path(file).name, line, text) for address, file, line, text in lines_of(image)} == expected


def test_profile_and_diagram_of_a_linked_program_show_its_source(emulator: Path, sources: Path) -> None:
    linked(emulator, sources)
    out = run(emulator, sources, "exec", "program.out", "--board", "flat", "--profile", "--pipeline", "0:20")
    assert "start:  ldi three,r0" in out and "main.asm" in out and "fir.asm" in out
    diagram = out[out.index("pipeline, cycles") :]
    assert "call fir" in diagram
    for name in ("main.asm", "fir.asm", "three.inc"):
        (sources / name).unlink()
    out = run(emulator, sources, "exec", "program.out", "--board", "flat", "--profile", "--pipeline", "0:20")
    assert "start:  ldi three,r0" not in out and "main.asm" in out
    assert "call fir" in out[out.index("pipeline, cycles") :]  # by its symbol


def test_sources_are_found_beside_the_program(
    emulator: Path, sources: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    program = linked(emulator, sources)
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    out = run(emulator, elsewhere, "exec", str(program), "--board", "flat", "--profile")
    assert "start:  ldi three,r0" in out


def test_an_executable_of_the_assembler_has_its_lines(emulator: Path, sources: Path) -> None:
    run(emulator, sources, "asm", "fir.asm", "-o", "fir.out")
    image = c40.read_coff(sources / "fir.out")
    assert [(line.line, line.text) for line in image.lines] == [(4, "fir:    ldi *ar0,r0"), (6, "        rets")]


# ---- the format, read by an independent reader ----


def entries(data: bytes) -> dict[str, list[tuple[int, int]]]:
    """The line entries of a version-2 file, by section."""
    sections, options = struct.unpack_from("<H", data, 2)[0], struct.unpack_from("<H", data, 16)[0]
    found = {}
    for n in range(sections):
        header = 22 + options + 48 * n
        where, count = struct.unpack_from("<I", data, header + 28)[0], struct.unpack_from("<I", data, header + 36)[0]
        name = data[header : header + 8].rstrip(b"\0").decode()
        found[name] = [struct.unpack_from("<IH", data, where + 6 * k) for k in range(count)]
    return found


def test_the_entries_as_the_format_has_them(emulator: Path, sources: Path) -> None:
    run(emulator, sources, "asm", "--object", "main.asm", "-o", "main.obj")
    data = (sources / "main.obj").read_bytes()
    found = entries(data)
    symbols = struct.unpack_from("<I", data, 8)[0]
    assert data[symbols : symbols + 5] == b".file" and data[symbols + 16] == 103
    # An entry with line 0 has the index of a file's symbol. The files are in the order of their first word, two entries
    # each.
    assert found[".text"] == [(0, 0), (0, 3), (2, 0), (1, 4), (2, 5), (3, 9)] and found[".data"] == [(2, 0), (0, 7)]
    assert struct.unpack_from("<H", data, 18)[0] & 4 == 0  # there are line numbers


def of_a_compiler(lines: list[tuple[int, int]], where: int | None = None) -> bytes:
    """An executable of version 2 with one section of four words, as compilers describe it: file, function, .bf and line
    entries."""
    text = struct.pack("<4I", 0x08600003, 0x0C800000, 0x0C800000, 0x6A00FFFF)
    body = 22 + 28 + 48
    at_lines, packed = body + 16, b"".join(struct.pack("<IH", *line) for line in lines)
    at_symbols = at_lines + len(packed)

    def symbol(name: bytes, value: int, section: int, storage: int, auxiliary: bytes = b"") -> bytes:
        return struct.pack("<8sIhHBB", name, value, section, 0, storage, 1 if auxiliary else 0) + auxiliary

    symbols = symbol(b".file", 0, -2, 103, b"filter.c".ljust(18, b"\0"))  # 0, 1
    symbols += symbol(b"_main", 0x300000, 1, 2, bytes(18))  # 2, 3
    symbols += symbol(b".bf", 0x300000, 1, 101, struct.pack("<4sH12s", b"", 20, b""))  # 4, 5
    symbols += symbol(b"_next", 0x300002, 1, 2, bytes(18))  # 6, 7
    symbols += symbol(b".bf", 0x300002, 1, 101, struct.pack("<4sH12s", b"", 31, b""))  # 8, 9
    header = struct.pack("<HHIIIHHH", 0xC2, 1, 0, at_symbols, 10, 28, 0x0113, 0x93)
    optional = struct.pack("<HHIIIIII", 0x108, 0, 4, 0, 0, 0x300000, 0x300000, 0)
    place = at_lines if where is None else where
    section = struct.pack("<8sIIIIIIIIIHH", b".text", 0x300000, 0x300000, 4, body, 0, place, 0, len(lines), 0x20, 0, 0)
    return header + optional + section + text + packed + symbols + struct.pack("<I", 4)


COMPILED = [(2, 0), (0x300000, 1), (0x300001, 3), (6, 0), (0x300002, 2), (0x300003, 5)]


def test_lines_of_a_compiler_count_from_their_function(tmp_path: Path) -> None:
    (tmp_path / "filter.c").write_text("".join(f"line {n}\n" for n in range(1, 40)))
    (tmp_path / "filter.out").write_bytes(of_a_compiler(COMPILED))
    image = c40.read_coff(tmp_path / "filter.out")
    assert lines_of(image) == [
        (0x300000 + n, "filter.c", line, f"line {line}") for n, line in enumerate([20, 22, 32, 35])
    ]


@pytest.mark.parametrize("lines", [
    [(99, 0), (0x300000, 1)],  # no such symbol: the file is that of the symbols before
    [(0x300000, 1)],  # of no file
    [(2, 0), (0x400000, 1)],  # nowhere in the section
])  # fmt: skip
def test_lines_without_a_place_are_ignored(lines: list[tuple[int, int]]) -> None:
    image = toolchain.read_coff_bytes(of_a_compiler(lines))
    assert len(image.sections) == 1 and all(line.address == 0x300000 for line in image.lines)


def test_a_table_behind_the_end_is_ignored() -> None:
    assert toolchain.read_coff_bytes(of_a_compiler(COMPILED, where=10**6)).lines == []


# ---- the dock ----


def test_symbols_and_lines_of_the_docks_program() -> None:
    dsp = cmrc.Simulation(dsps=1, duration_s=0.03, settings={"report.reference": "none"}).dsp(0)
    address = dsp.address("kernel_pid")
    assert dsp.program is not None and dsp.program.symbols["kernel_pid"] == address
    (line,) = [line for line in dsp.program.lines if line.address == address]
    assert dsp.program.files[line.file] == "kernels/pid.asm" and line.line > 1
    with pytest.raises(KeyError, match="the program has no symbol kernel_nothing"):
        dsp.address("kernel_nothing")
