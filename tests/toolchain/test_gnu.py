"""Against GNU as, ld and objdump for tic4x-coff, which `make oracles` builds; without them these tests are skipped."""

import re
import subprocess
from fractions import Fraction
from pathlib import Path

import corpus
import gnu_sources
import pytest
import tomllib
from cmrc._core import isa, toolchain
from cmrc_test import forms
from gnu_sources import GNU
from locations import BUILD, ROOT

pytestmark = [
    pytest.mark.oracle,
    pytest.mark.skipif(not (GNU / "tic4x-as").exists(), reason="build-oracles/bin is not there: make oracles"),
]


def label(address: int) -> str:
    """GNU takes numbers as branch targets for displacements, so targets are labels."""
    return f"L0+{address}" if address < 1 << 31 else f"L0-{(1 << 32) - address}"


def gnu_words(source: str, tmp_path: Path) -> list[int]:
    (tmp_path / "gnu.s").write_text(source)
    command = [GNU / "tic4x-as", "-m40", "-midle2", tmp_path / "gnu.s", "-o", tmp_path / "gnu.o"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]
    return list(forms.read_object((tmp_path / "gnu.o").read_bytes()).sections[0].words)


def short_float(bits: int) -> Fraction:
    """The value of a 16-bit float (c40-isa.md 2.2)."""
    exponent = (bits >> 12) - (16 if bits >> 15 else 0)
    mantissa = Fraction(bits & 0x7FF, 2048) + (-2 if bits & 0x800 else 1)
    return Fraction(0) if exponent == -8 else mantissa * Fraction(2) ** exponent


def test_both_assemblers_make_the_same_words_of_the_corpus(tmp_path: Path) -> None:
    """118,000 lines. Two differences are known (gnu_differences.toml): displacements of 0, and GNU's rounding of
    decimals."""
    words, lines = [], []
    for word in corpus.every_form():
        text = isa.disassemble(word, len(words), label)
        if "=" not in text:  # "exactly this field" is ours alone.
            words.append(word)
            lines.append(f"\t{text}\n")
    source = "\t.text\nL0:\n" + "".join(lines)
    ours = list(toolchain.assemble(source, sections={".text": 0}, dialect="gnu").sections[0].words)
    assert ours == words and len(words) > 110_000
    zero = re.compile(r"\*(\+\+|--|-)?(ar\d)(\+\+|--)?\(0\)%?")
    counts = {"zero": 0, "float": 0}
    for line, our, gnu in zip(map(str.strip, lines), ours, gnu_words(source, tmp_path), strict=True):
        if our == gnu:
            continue
        decimal = re.search(r" (-?\d+\.\d+)", line)
        if zero.search(line):
            counts["zero"] += 1
            assert isa.disassemble(gnu) == zero.sub(r"*\2", line)
        else:
            counts["float"] += 1
            assert decimal and abs(our - gnu) == 1, line
            assert short_float(our & 0xFFFF) == Fraction(decimal[1]), line
    assert counts == {"zero": 1721, "float": 8}


def test_both_assemblers_make_the_same_words_of_optional_forms(tmp_path: Path) -> None:
    lines = [
        "addi r1,r2,r3", "addi3 r1,r2", "cmpi *ar0,*ar1", "absi r1", "negf f3", "addi3 r1,5,r0", "addi 5,*+ar1(3),r0", "cmpi 8,*+ar3(1)",
        "addi3 r1,*+ar2(9),r0", "addf3 r4,*ar1,r5 || stf r6,*ar2", "stf r6,*ar2 || mpyf3 *ar1,r4,r5", "sti1 r6,*ar2 || sti2 r5,*ar1",
        "ldf1 *ar2,r3 || ldf2 *ar1,r5", "ldi *+ar0,r0", "ldi *ar0--%,r0", "ldi *+ar0(0),r0", "LDI *AR0++(IR0)B,R0", "rets", "reti",
        "trap 5", "b r11", "bd r11", "db ar0,r1", "bz r1", "bnzd r1", "ldip r1,r2", "ldfc r1,r2", "sti -5,@6", "ldp 30h", "ldf 1,r0",
        "ldi 0FFh,r0", "ldi 17q,r0", "ldi 'A',r0", "ldi (2+3)*4-1,r0", "mpyf *ar0++,*ar1++,r0 || addf r0,r2,r2",
        "subf r3,*+ar0,r5", "lsh -2,r1,r2", "ash3 r1,*ar0,r2", "xor *ar0,*ar1,r2", "ldf 2.7,r0", "ldf -27,r1", "mpyf 0.3333,r2", "ldf 7.8125e-3,r0",
    ]  # fmt: skip
    source = "".join(f"\t{line}\n" for line in lines)
    assert list(toolchain.assemble(source, dialect="gnu").sections[0].words) == gnu_words(source, tmp_path)


def test_both_assemblers_make_the_same_data(tmp_path: Path) -> None:
    source = """
\t.text
a:\t.word 1,-1,0FFFFFFFFh,'A'
\t.byte 10,-1,"abc",'a'
\t.hword 10,-1,"abc",'a'
\t.int 10,-1,"abc",'a'
\t.long 0FFFFABCDH,'A'+100h
\t.string "ABCD", 51h, 52h, 53h, 54h, "Houston", 36+12
\t.float 0,1.0,-1.5,3,3.141592654,-1.0e25,5.8774717e-39,123
\t.single 2.5e-3
\t.ieee 0,1.0,-1.5,3,3.141592654,-1.0e25,123
\t.ldouble 0,1.0,-1.5,3,3.141592654,-1.0e25,123
\t.space 4
\t.block 2
\tldi r0,r0
\t.align
\tldi r0,r0
"""
    ours, theirs = (
        list(toolchain.assemble(source, sections={".text": 0}, dialect="gnu").sections[0].words),
        gnu_words(source, tmp_path),
    )
    assert ours == theirs[: len(ours)] and set(theirs[len(ours) :]) <= {0, 0x0C800000}


def test_gnus_own_test_sources_give_the_same_words(tmp_path: Path) -> None:
    """All opcodes, addressing forms and registers; lines that we refuse are left out, and each has its reason."""
    refused = {
        "takes 2 operands": r"\w+ +A?R0$|.*\bsigi$", "is needed here, not the register": "nop +AR0", "macro 'mh": "mh[23] ",
        "cannot hold a float": "rcpf +AR1", "is not a number": ".*0e", "a register is needed": ".*\\b(IE|IF|IOF)$",
    }  # fmt: skip
    counts = {}
    symbols = ("TEST_C4X", "TEST_C3X", "TEST_IDLE2")
    for name in gnu_sources.SOURCES:
        # No label without @ as an address, no number as a branch target, no C3x forms.
        lines = gnu_sources.lines_of(name, r"ldi +start,|\bbr +-?\d|call\w* +\d|laj\w* +\d")
        lines, ours = gnu_sources.without_refused(lines, symbols, refused)
        (tmp_path / "gnu.s").write_text("\n".join(lines) + "\n")
        subprocess.run(
            [GNU / "tic4x-as", "-m40", "-midle2", *gnu_sources.defined(symbols), "gnu.s", "-o", "gnu.o"],
            cwd=tmp_path,
            check=True,
            capture_output=True,
        )
        theirs = forms.read_object((tmp_path / "gnu.o").read_bytes())
        assert list(ours.sections[0].words) == gnu_sources.as_ours(theirs.sections[0].words)
        counts[name] = len(ours.sections[0].words)
    assert counts == {"opcodes": 1396, "addressing": 198, "registers": 13}


def test_gnu_ld_links_our_objects_and_we_link_gnus(tmp_path: Path) -> None:
    here = Path(__file__).parent / "linking"
    emulator = BUILD / "bin" / "emulator"
    for name in "ab":
        subprocess.run([GNU / "tic4x-as", "-m40", here / f"{name}.s", "-o", tmp_path / f"{name}.gnu.o"], check=True)
        subprocess.run(
            [emulator, "asm", here / f"{name}.s", "--dialect", "gnu", "-c", "-o", tmp_path / f"{name}.our.o"],
            check=True,
            capture_output=True,
        )
    (tmp_path / "l.ld").write_text(
        'OUTPUT_FORMAT("coff2-tic4x")\nENTRY(_start)\nSECTIONS { .text 0x300000 : { *(.text) } .data 0x300100 : { *(.data) }'
        " more 0x300200 : { *(more) } .bss 0x300300 : { *(.bss) } }\n"
    )
    expected = [(s.name, s.address, list(s.words)) for s in toolchain.read_coff(here / "gnu.out").sections]
    for first in ("gnu", "our"):
        for second in ("gnu", "our"):
            command = [GNU / "tic4x-ld", "-T", "l.ld", f"a.{first}.o", f"b.{second}.o", "-o", "p.out"]
            subprocess.run(command, cwd=tmp_path, check=True)
            image = toolchain.read_coff(tmp_path / "p.out")
            assert [(s.name, s.address, list(s.words)) for s in image.sections] == expected


def test_disassembly_of_random_words_differs_only_as_explained() -> None:
    """The sample of the campaign scripts/compare_with_gnu (docs/oracles.md)."""
    done = subprocess.run(
        [ROOT / "scripts/compare_with_gnu", "--words", "1e6", "--seed", "11", "--build", BUILD],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    counts = {
        name.split("   e.g.")[0]: int(number.replace(",", ""))
        for number, name in re.findall(r"^ *([\d,]+)  (.*)$", done.stdout, re.MULTILINE)
    }
    assert (
        counts["words"] == 1_000_000
        and counts["equal instructions"] > 300_000
        and counts["reserved for both"] > 300_000
    )


def test_every_explanation_is_of_something_that_occurs() -> None:
    table = tomllib.loads((Path(__file__).parent / "gnu_differences.toml").read_text())
    done = subprocess.run(
        [ROOT / "scripts/compare_with_gnu", "--words", "4e6", "--seed", "3", "--build", BUILD],
        capture_output=True,
        text=True,
        check=True,
    )
    classes = [
        line.split("  ", 1)[1].split("   e.g.")[0]
        for line in map(str.strip, done.stdout.splitlines())
        if "   e.g." in line
    ]
    for entry in table["difference"]:
        if entry.get("rare"):
            continue
        assert any(re.fullmatch(entry["class"], name) for name in classes), entry["class"]
