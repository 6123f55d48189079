"""A program as a source: it assembles to the same words, for every program of the tree."""

import re
import subprocess
from collections import Counter
from pathlib import Path

import pytest
from cmrc._core import toolchain
from locations import ROOT

HERE = Path(__file__).parent
INCLUDES = [ROOT / "c40_programs/include", ROOT / "c40_programs", ROOT / "c40_programs/lib"]


def programs() -> list[Path]:
    found = [
        *(HERE / "bench").glob("*.s"),
        *(HERE / "coff").glob("*.out"),
        HERE / "linking/gnu.out",
        ROOT / "c40_programs/dsp.asm",
    ]
    found += [*(ROOT / "c40_programs/examples").glob("*.asm"), *(ROOT / "tests").rglob("*.asm")]
    return sorted(found)


def contents(image: toolchain.Image) -> list[tuple[str, int, int, list[int]]]:
    return sorted((s.name, s.address, s.size, list(s.words)) for s in image.sections)


def read(path: Path) -> toolchain.Image | None:
    """None for what is only meant to be included."""
    if path.suffix == ".out":
        return toolchain.read_coff(path)
    try:
        return toolchain.assemble_file(path, include_dirs=[*INCLUDES, path.parent])
    except toolchain.AssemblyError:
        return None


@pytest.mark.parametrize("path", programs(), ids=lambda path: str(path.relative_to(ROOT)))
def test_the_source_of_a_program_assembles_to_its_words(path: Path, tmp_path: Path, emulator: Path) -> None:
    image = read(path)
    if image is None:
        pytest.skip("is included by another file, not assembled by itself")
    program = tmp_path / "program.out"
    toolchain.write_coff(image, program)
    source = subprocess.run(
        [emulator, "disasm", "--source", program], capture_output=True, text=True, check=True
    ).stdout
    places = dict(re.findall(r"--section (\S+)=(\S+)", source.splitlines()[0]))
    assert places
    again = toolchain.assemble(source, sections={name: int(address, 16) for name, address in places.items()})
    assert contents(again) == contents(toolchain.read_coff(program))
    # Labels are those of the program, where one address has one name.
    symbols, kept = image.symbols, again.symbols
    code = [(s.address, s.address + len(s.words)) for s in image.sections if s.name == ".text"]
    names = Counter(symbols.values())
    for name, value in symbols.items():
        if (
            names[value] == 1
            and re.fullmatch(r"[A-Za-z_]\w*", name)
            and any(first <= value < end for first, end in code)
        ):
            assert kept.get(name) == value, name


def test_a_disassembly_names_sections_labels_and_targets(tmp_path: Path, emulator: Path) -> None:
    (tmp_path / "p.asm").write_text(
        "start:\tldi 1,r0\nagain:\tb again\n\tbr start\n\t.word 0FFFFFFFFh\n\t.data\nd:\t.word 60000000h\n\t.bss x,3\n"
    )
    done = subprocess.run([emulator, "disasm", tmp_path / "p.asm"], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [
        "; section .text, 4 words at 00300000h", "start:", "00300000  08600001  ldi 1,r0", "again:", "00300001  6A00FFFF  bu again",
        "00300002  60FFFFFD  br start", "00300003  FFFFFFFF  .word 0xffffffff", "; section .data, 1 words at 00300004h", "d:",
        "00300004  60000000  .word 0x60000000", "; section .bss, 3 words at 00300005h, reserved",
    ]  # fmt: skip
    done = subprocess.run(
        [emulator, "disasm", "--source", tmp_path / "p.asm"], capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[1:] == [
        '\t.sect\t".text"', "start:", "\tldi 1,r0", "again:", "\tbu again", "\tbr start", "\t.word 0xffffffff",
        '\t.sect\t".data"', "d:", "\t.word\t0x60000000", 'x\t.usect\t".bss",3',
    ]  # fmt: skip
