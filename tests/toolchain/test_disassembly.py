"""A program as a source: it assembles to the same words, for every program of the tree."""

import re
import shlex
import subprocess
from collections import Counter
from pathlib import Path

import pytest
from cmrc._core import isa, toolchain
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
        "00300004  60000000  .word 0x60000000", "; section .bss, 3 words at 00300005h, reserved", "x:",
    ]  # fmt: skip
    done = subprocess.run(
        [emulator, "disasm", "--source", tmp_path / "p.asm"], capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[1:] == [
        '\t.sect\t".text"', "start:", "\tldi 1,r0", "again:", "\tbu again", "\tbr start", "\t.word 0xffffffff",
        '\t.sect\t".data"', "d:", "\t.word\t0x60000000", 'x\t.usect\t".bss",3',
    ]  # fmt: skip


@pytest.mark.parametrize("form", [(), ("--object",)])
def test_labels_behind_the_last_word_of_a_section_are_shown(
    form: tuple[str, ...], tmp_path: Path, emulator: Path
) -> None:
    source = tmp_path / "p.asm"
    source.write_text('\t.text\nstart:\tnop\n\t.data\n\t.word 1\nlast:\n\t.sect "more"\n')
    subprocess.run([emulator, "asm", source, "-o", tmp_path / "p.out", *form], check=True)
    shown = subprocess.run([emulator, "disasm", tmp_path / "p.out"], capture_output=True, text=True, check=True).stdout
    assert re.search(r"  \.word 0x00000001\nlast:\n(?!0)", shown)
    # Reserved words follow: the label is theirs, too.
    source.write_text("\t.text\nstart:\tnop\nlast:\n\t.bss x,2\n\t.bss y,2\n")
    subprocess.run([emulator, "asm", source, "-o", tmp_path / "p.out"], check=True)
    shown = subprocess.run([emulator, "disasm", tmp_path / "p.out"], capture_output=True, text=True, check=True).stdout
    assert re.search(r"reserved\n(last|x):\n", shown)


def reassembled(emulator: Path, program: Path, folder: Path) -> toolchain.Image:
    """The program that the source makes, by the options that its head names."""
    source = subprocess.run(
        [emulator, "disasm", "--source", program], capture_output=True, text=True, check=True
    ).stdout
    (folder / "again.asm").write_text(source)
    options = shlex.split(source.splitlines()[0].partition(" OUT ")[2])
    done = subprocess.run(
        [emulator, "asm", folder / "again.asm", "-o", folder / "again.out", *options],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return toolchain.read_coff(folder / "again.out")


def memory(image: toolchain.Image) -> dict[int, int]:
    return {s.address + i: word for s in image.sections for i, word in enumerate(s.words)}


RAM_MODEL = """
        .global start,ahead
        .text
start:  ldp     e
        ldi     @e,r0
        b       $
        .bss    before,3
        .bss    e,1
        .bss    between,4
        .bss    e2,2
        .bss    behind,5
FIVE    .set    5                       ; lies in .cinit's own words, which are in no memory
        .sect   ".cinit"
        .word   1,e,55
        .word   2,e2,66,77
ahead   .set    start+1
"""


def test_the_source_of_a_program_of_the_ram_model_holds_what_the_loader_sets(tmp_path: Path, emulator: Path) -> None:
    objects = [toolchain.assemble_object(RAM_MODEL, name="a.o")]
    image, _ = toolchain.link(
        objects, map='c_model = "ram"\nentry = "ahead"\n[memory]\nm = { origin = 0x300000, length = 256 }\n'
    )
    toolchain.write_coff(image, tmp_path / "p.out")
    plain = subprocess.run([emulator, "disasm", tmp_path / "p.out"], capture_output=True, text=True, check=True).stdout
    assert "; section .cinit, 8 words at 00000000h, for the loader, which sets the initial values:" in plain
    assert "FIVE" not in plain
    again = reassembled(emulator, tmp_path / "p.out", tmp_path)
    read = toolchain.read_coff(tmp_path / "p.out")
    assert memory(again) == memory(read) and 55 in memory(again).values()
    assert again.entry == read.entry == image.symbols["start"] + 1
    for name in ("before", "e", "between", "e2", "behind"):
        assert again.symbols[name] == image.symbols[name], name


def test_the_source_begins_where_the_program_does(tmp_path: Path, emulator: Path) -> None:
    source = '\t.text\nstart:\tnop\nL300001\t.set 7\nfoo:\tnop\n\tb $\n\t.sect "a b"\n\t.word 1\n\t.sect "it\'s $HOME"\n\t.word 2\n\t.sect "a=b"\n\t.word 3\n'
    for name, entry in (("foo", 0x300001), ("start", 0x300000), ("L300001", 7)):
        image = toolchain.assemble(source, entry=name)
        toolchain.write_coff(image, tmp_path / "p.out")
        again = reassembled(emulator, tmp_path / "p.out", tmp_path)
        assert again.entry == image.entry == entry and contents(again) == contents(image)
    unnamed = toolchain.assemble("\tnop\nL300000\t.set 7\n")  # the name that the source would give is taken
    toolchain.write_coff(unnamed, tmp_path / "p.out")
    assert reassembled(emulator, tmp_path / "p.out", tmp_path).entry == 0x300000


def test_a_type_2_word_whose_displacements_fit_type_1_is_that_word_again() -> None:
    """ADDI3 *+ARn(i),*+ARm(j),R0: in type 1 a displacement is 0 or 1, in type 2 up to 31."""
    for i in range(4):
        for j in range(4):
            word = 0x31600900 & ~0xFFFF | (j << 3 | 1) << 8 | i << 3
            image = toolchain.assemble(f"        .text\n        {isa.disassemble(word)}\n", "word.asm")
            assert [section.words for section in image.sections] == [[word]], isa.disassemble(word)
