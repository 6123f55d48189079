"""What the assembler says of mistakes and of code that does not work."""

from pathlib import Path

import pytest
from assembling import errors
from cmrc._core import toolchain


def test_a_line_of_ten_megabytes_is_an_error_at_its_place() -> None:
    (found,) = errors("\tnop\n\t.word " + "1," * 5_000_000 + "1\n\tnop\n")
    assert found[0] == 2 and "are the most" in found[2]


def test_endless_includes_and_macros_are_caught(tmp_path: Path) -> None:
    (tmp_path / "a.asm").write_text('\t.include "b.asm"\n')
    (tmp_path / "b.asm").write_text('\n\t.include "a.asm"\n')
    with pytest.raises(toolchain.AssemblyError, match="b.asm:2:11: error: the file .* includes itself"):
        toolchain.assemble_file(tmp_path / "a.asm")
    for depth in range(70):
        (tmp_path / f"d{depth}.asm").write_text(f'\t.include "d{depth + 1}.asm"\n')
    with pytest.raises(toolchain.AssemblyError, match="nested deeper than 64"):
        toolchain.assemble_file(tmp_path / "d0.asm")
    assert "nested deeper" in errors("m .macro\n m\n m\n .endm\n m\n")[0][2]


def test_a_missing_file_is_an_error_with_its_name(tmp_path: Path) -> None:
    with pytest.raises(toolchain.AssemblyError, match="nothing.asm"):
        toolchain.assemble_file(tmp_path / "nothing.asm")
    with pytest.raises(toolchain.AssemblyError, match="directory"):
        toolchain.assemble_file(tmp_path)


@pytest.mark.parametrize(
    ("line", "column", "message"),
    [
        ("\tadi r0,r1", 2, "did you mean 'addi'"),
        ("\tldi r0", 2, "takes 2 operands, not 1"),
        ("\tsti r0 || sti r1,*ar1", 2, "'sti' takes 2 operands, not 1"),
        ("\tsti r0,*ar0 || sti r1", 17, "'sti' takes 2 operands, not 1"),
        ("\tldi *ar0 || ldi *ar1,r1", 2, "'ldi' takes 2 operands, not 1"),
        ("\tldi *ar0,r0 || ldi *ar1", 17, "'ldi' takes 2 operands, not 1"),
        ("\tabsi *ar0 || sti r1,*ar1", 2, "'absi' takes 2 operands, not 1"),
        ("\taddi 5,r0,r1,r2", 12, "operands, not 4"),
        ("\tldf ar0,r0", 6, "only R0 to R11"),
        ("\tldi 70000,r0", 6, "-32768 to 32767"),
        ("\tand 70000,r0", 6, "(0 to 65535)"),
        ("\tmpyuhi -32769,r0", 9, "(-32768 to 65535)"),
        ("\taddi3 *+ar0(300),r0,r1", 8, "*+ARn(0..31), or any indirect form with a displacement of 1"),
        ("\taddi3 r0,*+ar0(32),r1", 11, "*+ARn(0..31)"),
        ("\taddi3 200,r0,r1", 8, "-128 to 127"),
        ("\tldi *ar0(1),r0", 10, "write *+ARn(x)"),
        ("\tldi *+ar0(256),r0", 6, "0 to 255"),
        ("\tldi *++ar0++,r0", 12, "not both"),
        ("\tldi *ar0++(ir1)b,r0", 17, "*ARn++(IR0)B"),
        ("\tldi *+r0(1),r0", 8, "AR0 to AR7"),
        ("\tldi nowhere,r0", 6, "undefined symbol 'nowhere'"),
        ("nowher:\tldi nowhere,r0", 13, "undefined symbol 'nowhere'; did you mean 'nowher'?"),
        ("fa2:\tldi foo,r0", 10, "undefined symbol 'foo'"),
        ("\t.wrd 1", 2, "there is no directive '.wrd'; did you mean '.word'?"),
        ("\t.zzzzzz 1", 2, "there is no directive '.zzzzzz'"),
        ("\t.endi", 2, "there is no directive '.endi'; did you mean '.endif'?"),
        ("\t.endiff", 2, "there is no directive '.endiff'; did you mean '.endif'?"),
        ("\t.ifdeff x", 2, "there is no directive '.ifdeff'; did you mean '.ifdef'?"),
        ("\t.elsif 1", 2, "there is no directive '.elsif'; did you mean '.elseif'?"),
        ('\t.titel "a"', 2, "there is no directive '.titel'; did you mean '.title'?"),
        ("\tldi label,r0", 6, "LDHI hi16(x)"),
        ("\tldf 300.0,r0", 6, "16-bit float"),
        ("\tldi 1.5,r0", 6, "integer is needed"),
        ("\taddf3 1.0,r0,r1", 8, "immediate"),
        ("\tsubi3 r1,5,r0", 11, "immediate"),
        ("\tldfi r0,r1", 7, "@address or *ARn"),
        ("\tlda r0,st", 9, "LDA loads"),
        ("\tlda ar0,ar0", 6, "from itself"),
        ("\tb far", 4, "reaches 16 bits"),
        ("\tdb r0,label", 5, "AR0 to AR7"),
        ("\ttrap 512", 7, "0 to 511"),
        ("\tstik 16,@0", 7, "-16 to 15"),
        ("\tldep r0,r1", 7, "IVTP or TVTP"),
        ("\tldf *ar0,r8 || stf r1,*ar1", 11, "R0 to R7"),
        ("\tldf *ar0,r0 || stf r1,*+ar1(2)", 24, "only be 1"),
        ("\tmpyf3 *ar0,*ar1,r2 || addf3 r0,r1,r2", 18, "R0 or R1"),
        ("\tmpyf3 r0,r1,r0 || addi3 r0,r1,r2", 20, "in parallel"),
        ("\t.frobnicate", 2, "no directive"),
        ("\t.word 0x", 8, "not a number"),
        ("\t.word 0x9g", 8, "not a number"),
        ("\t.word 1.5", 8, ".float"),
        ("\t.word 100000000h", 8, "32 bits"),
        ("\t.word 1/0", 9, "division by zero"),
        ("\t.word (1", 10, "')' expected"),
        ("\t.word 1 2", 10, "end of line expected"),
        ("\t.word r0+1", 8, "register"),
        ("\t.word log(2)", 8, "no function"),
        ("\t.float label", 9, "address"),
        ('\t.string "abc', 10, "closing quote"),
        ("\t.align 3", 2, "power of 2"),
        ("\t.def missing", 7, "not defined"),
        ("\t.endif", 2, "without .if"),
        ("\t.endm", 2, "closes nothing"),
        ("\t.bss", 2, None),
        ("ldi r0,r1", 1, "first column"),
        ("label: nop", 1, "defined already"),
        ("|| stf r0,*ar0", 1, "no instruction before it"),
    ],
)
def test_each_mistake_is_reported_at_its_place(line: str, column: int, message: str | None) -> None:
    source = f"far .set 900000h\nlabel: .word 0\n{line}\n"
    if message is None:  # .bss alone is legal: it selects the section
        toolchain.assemble(source)
        return
    found = errors(source)
    assert len(found) == 1
    assert found[0][:2] == (3, column) and message in found[0][2]


def test_all_errors_of_a_file_come_at_once_in_its_order_with_text_and_caret() -> None:
    source = "\tldi 70000,r0\n\tnop\n\t.bogus\n\tldi missing,r1\n"
    with pytest.raises(toolchain.AssemblyError) as caught:
        toolchain.assemble(source, name="prog.asm")
    assert [d["line"] for d in caught.value.diagnostics] == [1, 3, 4]
    assert str(caught.value).splitlines()[:3] == [
        "prog.asm:1:6: error: 70000 is out of range (-32768 to 32767)",
        "  \tldi 70000,r0",
        "  \t    ^",
    ]


def test_an_error_in_a_macro_names_the_line_of_the_macro_and_of_its_call() -> None:
    with pytest.raises(toolchain.AssemblyError) as caught:
        toolchain.assemble("m .macro x\n\tldi x,r0\n\t.endm\n\tnop\n\tm 99999\n", name="prog.asm")
    (diagnostic,) = caught.value.diagnostics
    assert (diagnostic["line"], diagnostic["text"]) == (2, "\tldi 99999,r0")
    assert diagnostic["notes"] == ["expanded from prog.asm:5: \tm 99999"]


@pytest.mark.parametrize(
    ("source", "line", "message"),
    [
        ("\t.if 1\n\tnop\n", 1, ".if has no .endif"),
        ("\tnop\nm .macro\n\tnop\n", 2, ".macro has no .endm"),
        ("\t.rept 2\n\tnop\n", 1, ".rept has no .endr"),
        ("\t.LOOP 3\n\tnop\n", 1, ".loop has no .endloop"),
        ("\t.loop x\n\tnop\n", 1, ".loop has no .endloop"),
        ("\nu .union\nx .int\n", 2, ".union has no .endunion"),
    ],
)
def test_what_is_left_open_is_reported_where_it_was_opened(source: str, line: int, message: str) -> None:
    assert (line, 1, message) in errors(source)


def test_a_wrong_head_that_is_left_open_is_named_too() -> None:
    assert (1, 1, ".rept has no .endr") in errors("\t.rept 1 2\n\tnop\n")


def test_a_members_name_that_is_there_already_is_reported_in_its_line() -> None:
    source = "x .struct\na .word\nb .int\nc .word\na: .word\nn .endstruct\n\t.word n\nx.b .set 7\n"
    assert errors(source) == [
        (5, 1, "'x.a' is defined already at <text>:2"),
        (8, 1, "'x.b' is defined already at <text>:3"),
    ]
    inner = "p .struct\na .int\n .endstruct\nq .struct\ni.a .int\ni .tag p\n .endstruct\n"
    assert errors(inner) == [(6, 1, "'q.i.a' is defined already at <text>:5")]


def test_what_an_option_says_is_named_by_the_option() -> None:
    for options, message in (
        ({"entry": "man"}, "--entry man: error: the entry symbol 'man' is not defined"),
        (
            {"sections": {".bss": 0x300000}},
            "--section .bss: error: the sections '.text' (1 words at 300000h) and '.bss' (2 words at 300000h) overlap",
        ),
    ):
        with pytest.raises(toolchain.AssemblyError) as caught:
            toolchain.assemble("\tnop\n\t.bss v,2\n", **({"sections": {".text": 0x300000}} | options))
        assert str(caught.value) == message


def test_a_slip_costs_neither_memory_nor_time() -> None:
    assert "operators" in errors("\t.word " + "(" * 10_000 + "\n")[0][2]
    assert "operators" in errors("\t.word " + "1+" * 10_000 + "1\n")[0][2]
    assert "would pass" in errors("\t.space 0FFFFFFFFh\n")[0][2]
    assert "lines to assemble" in errors("\t.rept 1000000\n\t.rept 1000000\n\t.endr\n\t.endr\n")[0][2]


@pytest.mark.parametrize(
    ("source", "warning"),
    [
        ("\tbd $\n\tnop\n\tb $\n\tnop\n", "<text>:3:2: warning: program control in slot 2 of the delayed 'bud'"),
        ("\trpts 5\n\tidle\n", "RPTS cannot repeat"),
        ("\trptb end\n\tnop\nend: b $\n", "last instruction of a repeated block"),
        ("\tldi 40000,r0\n", "taken as the signed number -25536"),
    ],
)
def test_code_that_assembles_but_does_not_work_gives_a_warning(source: str, warning: str) -> None:
    assert any(warning in text for text in toolchain.assemble(source).warnings)


def test_sound_code_gives_no_warning() -> None:
    source = "\trptb end\n\tnop\nend: nop\n\tbd $\n\tnop\n\tnop\n\tnop\n\tb $\n\trpts 3\n\tmpyf3 *ar0,*ar1,r0 || addf3 r0,r2,r2\n"
    assert toolchain.assemble(source + "\t.word 0x60000000\n").warnings == []
