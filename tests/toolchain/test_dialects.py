"""Ruling 33: `ldp` as TI's assembler and as GNU as read it, and what decides which it is. Words from the ruling's
table, which TI-built objects and GNU as confirm."""

import re
import subprocess
from pathlib import Path

import pytest
from cmrc import _core, c40
from cmrc._core import toolchain
from locations import BUILD


def words(source: str, dialect: str | None = None) -> list[int]:
    return list(
        toolchain.assemble(source, sections={".text": 0x301000, ".data": 0x80123456}, dialect=dialect).sections[0].words
    )


LDP = [
    # operands, in ti, in gnu (None: refused)
    ("0002FFC00h", 0x1F70002F, None),
    ("30h", 0x1F700000, 0x50700030),
    ("@30h", 0x1F700000, 0x50700000),
    ("0", 0x1F700000, 0x50700000),
    ("small", 0x1F700000, 0x50700030),
    ("large", 0x1F70002F, None),
    ("small,dp", 0x1F700000, 0x50700030),
    ("table", 0x1F708012, 0x50708012),
    ("@table", 0x1F708012, 0x50708012),
    ("table,DP", 0x1F708012, 0x50708012),
    ("@table + 10000h,DP", 0x1F708013, 0x50708013),
    ("0FFFFFFFFh", 0x1F70FFFF, None),
    ("table,ar3", 0x506B8012, None),
    ("@table,ar7", 0x506F8012, None),
    ("0002FFC00h,ar0", 0x5068002F, None),
]


@pytest.mark.parametrize(("operands", "ti", "gnu"), LDP)
def test_ldp(operands: str, ti: int, gnu: int | None) -> None:
    source = f"small .set 30h\nlarge .set 2FFC00h\n ldp {operands}\n .data\ntable: .word 0\n"
    assert words(source)[0] == words(source, "ti")[0] == ti
    if gnu is None:
        with pytest.raises(toolchain.AssemblyError):
            words(source, "gnu")
    else:
        assert words(source, "gnu")[0] == gnu


def test_ldpk_is_the_same_in_both() -> None:
    source = " ldpk 30h\n ldpk @30h\n ldpk table\n .data\ntable: .word 0\n"
    assert words(source, "ti") == words(source, "gnu") == [0x1F700030, 0x1F700000, 0x1F708012]


def test_a_number_that_was_a_page_is_warned_of() -> None:
    image = toolchain.assemble(" ldp 30h\n ldp 0\n ldp @30h\n ldp 2FFC00h\n ldp $\n")
    assert len(image.warnings) == 1
    assert "<text>:1:" in image.warnings[0]
    for part in ("30h is in page 0", "Earlier versions took it as page 30h", "ldpk", "--dialect gnu"):
        assert part in image.warnings[0]
    assert toolchain.assemble(" ldp 30h\n", dialect="gnu").warnings == []
    for cpu in ("c40", "c3x"):
        (warning,) = toolchain.assemble(" ldp 30h,ar3\n", cpu=cpu).warnings
        assert "30h is in page 0. 'ldiu 48,ar3' loads ar3 with 30h\n" in warning


@pytest.mark.parametrize(
    ("line", "dialect", "message"),
    [
        ("ldp", "ti", "takes an address, and DP, AR0 to AR7"),
        ("ldp x,r0", "ti", "loads DP or AR0 to AR7, not r0"),
        ("ldp @x+1,r6", "ti", "'ldp x' loads DP, 'ldiu hi16(x),r6' loads r6"),
        ("ldp x,r6", "gnu", "and DP or nothing after it"),
        ("ldp x,ar0,dp", "ti", "takes an address, and DP, AR0 to AR7"),
        ("ldp r0", "ti", "an address is needed here"),
        ("ldp 1.5", "ti", "an integer is needed here"),
        ("ldp -1", "ti", "an address is 0 to 0FFFFFFFFh"),
        ("ldp 100000000h", "ti", "an address is 0 to 0FFFFFFFFh"),
        ("ldp nowhere", "ti", "nowhere"),
        ("ldp x,ar0", "gnu", "--dialect ti"),
        ("ldp 2FFC00h", "gnu", "a page is 0 to 65535"),
    ],
)
def test_what_ldp_refuses(line: str, dialect: str, message: str) -> None:
    with pytest.raises(toolchain.AssemblyError, match=re.escape(message)):
        words(f"x: {line}\n", dialect)


def test_objects_have_the_same_words_when_linked() -> None:
    source = "\tldp @table\n\tldp table\n\tldp far,ar2\n\tldp far\n\t.global far\n\t.data\ntable:\t.word 0\n"
    other = '\t.global far\n\t.sect "more"\nfar:\t.word 0\n'
    image, _ = toolchain.link([toolchain.assemble_object(source), toolchain.assemble_object(other)])
    table, far = (next(s.address for s in image.sections if s.name == name) >> 16 for name in (".data", "more"))
    text = next(s for s in image.sections if s.name == ".text")
    assert list(text.words) == [0x1F700000 | table, 0x1F700000 | table, 0x506A0000 | far, 0x1F700000 | far]


DECIDED = [
    # the file's head, the option, the dialect that decides, and what the listing says of it
    ("", None, "ti", "the default"),
    ("", "gnu", "gnu", "asked for"),
    (" .dialect gnu\n", None, "gnu", ".dialect in line 1"),
    (" .dialect ti\n", "gnu", "ti", ".dialect in line 1"),
    (' .dialect "GNU"\n', "ti", "gnu", ".dialect in line 1"),
    ("; by GCC\ngcc2_compiled.:\n", None, "gnu", "GCC's mark gcc2_compiled. in line 2"),
    ("gcc2_compiled.:\n", "ti", "ti", "asked for"),
    ("gcc2_compiled.:\n .dialect ti\n", None, "ti", ".dialect in line 2"),
    (" .dialect ti\ngcc2_compiled.:\n", None, "ti", ".dialect in line 1"),
]


@pytest.mark.parametrize(("head", "option", "dialect", "why"), DECIDED)
def test_what_decides(head: str, option: str | None, dialect: str, why: str) -> None:
    image = toolchain.assemble(head + " ldp 30h\n", dialect=option)
    assert image.sections[0].words[0] == {"ti": 0x1F700000, "gnu": 0x50700030}[dialect]
    assert image.dialects == [f"{dialect}: {why}"]
    assert image.listing().splitlines()[0] == f"dialect {dialect}: {why}"


def test_a_source_that_says_gnu_leaves_undefined_symbols_to_other_objects() -> None:
    source = " .dialect {}\n br elsewhere\n"
    symbols = toolchain.assemble_object(source.format("gnu")).symbols
    assert "elsewhere" in {symbol.name for symbol in symbols}
    with pytest.raises(toolchain.AssemblyError, match="undefined symbol 'elsewhere'"):
        toolchain.assemble_object(source.format("ti"))


def test_a_dialect_holds_for_a_file_and_what_it_includes(tmp_path: Path) -> None:
    (tmp_path / "own.inc").write_text(" .dialect ti\n ldp 30h\n")
    (tmp_path / "none.inc").write_text(" ldp 30h\n")
    main = tmp_path / "main.asm"
    main.write_text(' .include "own.inc"\n ldp 30h\n .include "none.inc"\n')
    image = toolchain.assemble_file(main, dialect="gnu")
    assert list(image.sections[0].words) == [0x1F700000, 0x50700030, 0x50700030]
    assert image.dialects == ["gnu: asked for", f"ti in {tmp_path / 'own.inc'}: .dialect in line 1"]


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (" .dialect foo\n", "there is no dialect 'foo'; ti and gnu are possible"),
        (" .dialect\n", "ti or gnu"),
        (" .dialect ti,gnu\n", "<text>:1:"),
        (" .dialect ti\n .dialect gnu\n", "has a '.dialect' already"),
        (" nop\n .dialect gnu\n", "before the file's first instruction"),
    ],
)
def test_directives_that_are_refused(source: str, message: str) -> None:
    with pytest.raises(toolchain.AssemblyError) as refused:
        toolchain.assemble(source)
    assert message in str(refused.value)


def test_gccs_mark_behind_instructions_is_warned_of() -> None:
    image = toolchain.assemble(" ldp 30h\ngcc2_compiled.:\n ldp 30h\n")
    assert list(image.sections[0].words) == [0x1F700000, 0x1F700000]
    assert any("GCC's mark" in warning for warning in image.warnings)


def test_python_and_the_commands_take_it(tmp_path: Path) -> None:
    assert c40.assemble(" ldp 30h\n", dialect="gnu").sections[0].words[0] == 0x50700030
    with pytest.raises(ValueError, match='"GNU" is unknown; "ti" or "gnu" is expected'):
        c40.assemble(" nop\n", dialect="GNU")
    source = tmp_path / "p.asm"
    source.write_text("start: ldp 30h\nhalt: b halt\n")
    (tmp_path / "p.hex").write_text("6A00FFFF\n")

    def run(tool: str, *arguments: object) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [BUILD / "bin" / tool, *map(str, arguments)], capture_output=True, text=True, cwd=tmp_path, check=False
        )

    for tool, first in (("emulator", ["asm"]), ("c40_asm", [])):
        made = run(tool, *first, source, "-o", "p.out", "--dialect", "gnu")
        assert (made.returncode, made.stderr) == (0, "")
        assert toolchain.read_coff(tmp_path / "p.out").sections[0].words[0] == 0x50700030
        refused = run(tool, *first, source, "-o", "q.out", "--dialect", "as")
        assert refused.returncode == 2 and "--dialect" in refused.stderr and not (tmp_path / "q.out").exists()
    assert "ldiu 48,dp" in run("emulator", "disasm", source, "--dialect", "gnu").stdout
    assert "ldpk" in run("emulator", "disasm", source).stdout
    assert "DP  00000030" in run("emulator", "exec", source, "--dialect", "gnu").stdout
    assert "DP  00000000" in run("emulator", "exec", source).stdout
    for program in ("p.hex", "p.out"):
        refused = run("emulator", "exec", program, "--dialect", "gnu")
        assert refused.returncode == 2 and f"--dialect: {program} is not a source file" in refused.stderr


def test_two_cycles_less_before_a_direct_access() -> None:
    """LDPK writes DP in decode; LDIU in execute, for which the address of the access waits (c40-isa.md 8.1)."""

    def cycles(dialect: str) -> int:
        processor = _core.c40.Processor("flat")
        image = toolchain.assemble("start: ldp there\n ldi @there,r0\nhalt: b halt\nthere: .word 5\n", dialect=dialect)
        processor.load_image(image)
        processor.run(100, image.symbols["halt"])
        assert processor.get("R0") & 0xFFFFFFFF == 5
        return int(processor.cycle)

    assert (cycles("ti"), cycles("gnu")) == (2, 4)


TABLE = """
far:    .word 0
near:   .set 12h
"""

# Source in .text at 301000h, with a table at 80123456h: its words in ti and in gnu; None: refused.
BARE = [
    ("ldi near,ar0", 0x08680012, 0x08680012),  # a number in both
    ("ldi far,ar0", None, 0x08283456),  # 32 bits do not fit; GNU as reads the word at it
    ("or far,ar0", 0x10683456, 0x10283456),  # after an LSH 16
    ("and far,ar0", 0x02E83456, 0x02A83456),
    ("andn far,ar0", 0x03683456, 0x03283456),
    ("xor far,ar0", 0x1AE83456, 0x1AA83456),
    ("tstb far,ar0", 0x1A683456, 0x1A283456),
    ("addi far,r1", None, 0x02213456),
    ("cmpi far,ar0", None, 0x04A83456),  # not logical
    ("ldpk 12h", 0x1F700012, 0x1F700012),
    ("ldpk near", 0x1F700012, 0x1F700012),  # a constant symbol is a number
    ("ldpk far", 0x1F708012, 0x1F708012),
    ("ldpk 10000h", None, None),
    ("call far", None, None),  # out of reach: a branch target is an address in both
    ("ldi ^far,ar0", None, 0x08688012),
    ("or #far,ar0", None, 0x10683456),
    ("ldi #near,ar0", None, 0x08680012),
    ("ldi ^near,ar0", None, 0x08680012),
    ("ldi near ^ 2,r0", 0x08600010, 0x08600010),  # the operator stays
    ("ldi %r3,r0", None, 0x08000003),
    ("ldi *+%ar0(1),%r0", None, 0x08400001),
    ("ldi *ar0++(%ir0),r0", None, 0x08406000),
    ("ldi *ar0++(1)%,r0", 0x08403001, 0x08403001),  # circular
    ("ldi 010,r0", 0x0860000A, 0x0860000A),  # decimal in both
]


@pytest.mark.parametrize(("line", "ti", "gnu"), BARE)
def test_bare_symbols_halves_and_register_marks(line: str, ti: int | None, gnu: int | None) -> None:
    source = f" {line}\n .data\n{TABLE}"
    for dialect, expected in (("ti", ti), ("gnu", gnu)):
        if expected is None:
            with pytest.raises(toolchain.AssemblyError):
                words(source, dialect)
        else:
            assert words(source, dialect)[0] == expected, dialect


MARKS = [
    ("ldi ^x,r0", "the upper half of an address: --dialect gnu, or hi16"),
    ("ldi #x,r0", "the lower half"),
    ("ldi %r1,r0", "--dialect gnu"),
]


@pytest.mark.parametrize(("line", "message"), MARKS)
def test_gnus_marks_are_reported_with_the_switch_that_takes_them(line: str, message: str) -> None:
    with pytest.raises(toolchain.AssemblyError, match=message):
        words(f"x: {line}\n")


def test_an_undefined_symbol_is_external_in_an_object_of_gnu_or_if_requested(tmp_path: Path) -> None:
    source = tmp_path / "a.asm"
    source.write_text(" call elsewhere\n")
    assert toolchain.assemble_object(source.read_text(), dialect="gnu")
    with pytest.raises(toolchain.AssemblyError, match="undefined symbol 'elsewhere'"):
        toolchain.assemble_object(source.read_text())
    run = [BUILD / "bin" / "emulator", "asm", source, "-o", tmp_path / "a.o"]
    assert subprocess.run([*run, "-c", "--undefined-external"], check=False).returncode == 0
    assert subprocess.run([*run, "-c"], capture_output=True, check=False).returncode == 2
    alone = subprocess.run([*run, "--undefined-external"], capture_output=True, text=True, check=False)
    assert alone.returncode == 2 and "--object" in alone.stderr


def test_a_leading_zero_means_nothing_and_is_warned_of_where_it_was_octal() -> None:
    image = toolchain.assemble(" ldi 010,r0\n .word 08,00,07,0017,017q,0x10,0b1\n")
    assert [word & 0xFFFF for word in image.sections[0].words] == [10, 8, 0, 7, 17, 15, 16, 1]
    assert len(image.warnings) == 2
    assert "010 is decimal here. The octal number is 010q" in image.warnings[0] and "0017q" in image.warnings[1]


def test_lines_of_a_preprocessor_are_comments_for_gnu_as_alone() -> None:
    source = '# 1 "foo.c" 2\n#note\n\tldi 1,r0\n  # indented\n#\n\tldi 2,r0\n'
    assert words(source, "gnu") == [0x08600001, 0x08600002]
    with pytest.raises(c40.AssemblyError) as caught:
        words(source, "ti")
    assert [(found["line"], found["column"]) for found in caught.value.diagnostics] == [(1, 1), (2, 1), (4, 3), (5, 1)]
    with pytest.raises(c40.AssemblyError):
        words("\tnop # behind an instruction\n", "gnu")
