"""Objects of the C3x against GNU as and ld for tic4x with -m30, which `make oracles` builds; without them these tests
are skipped."""

import re
import subprocess
from pathlib import Path

import corpus
import gnu_sources
import pytest
from cmrc._core import isa, toolchain
from cmrc_test import forms
from gnu_sources import GNU

pytestmark = [
    pytest.mark.oracle,
    pytest.mark.skipif(not (GNU / "tic4x-as").exists(), reason="build-oracles/bin is not there: make oracles"),
]
LINKED = """
OUTPUT_FORMAT("coff2-tic4x")
OUTPUT_ARCH("tic3x")
ENTRY(start)
SECTIONS { .text 0x809800 : { *(.text) } .data 0x809900 : { *(.data) } .bss 0x809A00 : { *(.bss) } }
"""
MAP = '[memory]\nm = { origin = 0x809800, length = 0x800 }\n[sections]\n".text" = "m"\n".data" = { address = 0x809900 }\n".bss" = { address = 0x809A00 }\n'
A = """
        .text
        .global start,far,there
start:  ldp     there
        ldi     @there,ar0
        ldi     ie,r0
        call    far
        br      far+2
near:   brd     near
        nop
        nop
        nop
        rptb    ends
        addi    1,r0
ends:   nop
        bz      near
        callnz  far
        .data
        .word   far,near,there
"""
B = """
        .text
        .global far,there,start
        nop
far:    br      start
        rptb    far+3
        sti     r0,@there+1
        push    iof
        rets
        .data
there:  .word   5,far
        .bss    room,4
"""


def gnu_object(source: str, folder: Path, name: str, *options: str) -> toolchain.Object:
    (folder / f"{name}.s").write_text(source)
    command = [
        GNU / "tic4x-as",
        "-m30",
        "-midle2",
        "-mlowpower",
        *options,
        folder / f"{name}.s",
        "-o",
        folder / f"{name}.o",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]
    return forms.read_object((folder / f"{name}.o").read_bytes(), name)


def test_both_assemblers_make_the_same_words_of_the_corpus(tmp_path: Path) -> None:
    """69,000 lines: every row, condition, addressing form and register. The differences are those of the C40
    (test_gnu.py)."""
    words, lines = [], []
    for word in corpus.every_form(cpu="c3x"):
        text = isa.disassemble(
            word,
            len(words),
            lambda address: f"L0+{address}" if address < 1 << 24 else f"L0-{(1 << 32) - address}",
            cpu="c3x",
        )
        if "=" not in text:
            words.append(word)
            lines.append(f"\t{text}\n")
    source = "\t.text\nL0:\n" + "".join(lines)
    ours = list(toolchain.assemble(source, sections={".text": 0}, dialect="gnu", cpu="c3x").sections[0].words)
    assert ours == words and len(words) > 65_000
    gnu = gnu_object(source, tmp_path, "gnu")
    assert gnu.cpu == "c3x"
    zero = re.compile(r"\*(\+\+|--|-)?(ar\d)(\+\+|--)?\(0\)%?")
    counts = {"zero": 0, "float": 0}
    for line, our, their in zip(lines, ours, gnu.sections[0].words, strict=True):
        if our == their:
            continue
        decimal = re.search(r" (-?\d+\.\d+)", line)
        counts["zero" if zero.search(line) else "float"] += 1
        assert (
            isa.disassemble(their, cpu="c3x") == zero.sub(r"*\2", line.strip())
            if zero.search(line)
            else decimal and abs(our - their) == 1
        ), line
    assert 0 < counts["zero"] < 2000 and counts["float"] < 20


def test_gnus_own_test_sources_give_the_same_words(tmp_path: Path) -> None:
    """Lines of -m30 that we refuse are left out; each has its reason."""
    refused = {
        "is needed here, not the register": "nop +AR0",
        "is not a number": ".*0e",
        "takes 2 operands": r"\w+ +A?R0$",
    }
    counts = {}
    symbols = ("TEST_ALL", "TEST_C3X", "TEST_IDLE2", "TEST_LPWR")
    for name in gnu_sources.SOURCES:
        # A label without @ is an address, a number as the target of a relative branch a displacement for GNU.
        lines = gnu_sources.lines_of(name, r"ldi +start,|\bcall\w+ +\d")
        lines, ours = gnu_sources.without_refused(lines, symbols, refused, cpu="c3x")
        theirs = gnu_object("\n".join(lines) + "\n", tmp_path, name, *gnu_sources.defined(symbols))
        assert list(ours.sections[0].words) == gnu_sources.as_ours(theirs.sections[0].words)
        counts[name] = len(ours.sections[0].words)
    assert counts == {"opcodes": 959, "addressing": 178, "registers": 36}


@pytest.mark.parametrize("version", [0, 1, 2])
def test_objects_of_either_link_to_the_same_with_either_linker(tmp_path: Path, version: int) -> None:
    (tmp_path / "l.ld").write_text(LINKED)
    sources = {"a": A, "b": B}
    for name, source in sources.items():
        gnu = gnu_object(source, tmp_path, f"{name}.gnu")
        our = toolchain.assemble_object(source, name=name, dialect="gnu", cpu="c3x")
        (tmp_path / f"{name}.our.o").write_bytes(forms.object_bytes(our, version))
        assert list(our.sections[0].words) == list(gnu.sections[0].words)
        assert [(r.offset, r.type) for r in our.sections[0].relocations if r.type == "R_REL24"] == [
            (r.offset, r.type) for r in gnu.sections[0].relocations if r.type == "R_REL24"
        ]
    results = []
    for first in ("gnu", "our"):
        for second in ("gnu", "our"):
            files = [f"a.{first}.o", f"b.{second}.o"]
            subprocess.run([GNU / "tic4x-ld", "-T", "l.ld", *files, "-o", "p.out"], cwd=tmp_path, check=True)
            theirs = toolchain.read_coff(tmp_path / "p.out")
            ours, _ = toolchain.link(
                [forms.read_object((tmp_path / file).read_bytes(), file) for file in files], map=MAP
            )
            assert theirs.cpu == ours.cpu == "c3x"
            results += [
                {s.name: (s.address, list(s.words)) for s in image.sections if s.words} for image in (theirs, ours)
            ]
    assert all(result == results[0] for result in results) and len(results[0][".text"][1]) > 15
