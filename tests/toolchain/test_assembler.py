"""Directives, expressions, macros, placement, and what the assembler says about mistakes."""

from pathlib import Path

import pytest
from cmrc._core import isa, toolchain


def words(source: str, **options: object) -> list[int]:
    return list(toolchain.assemble(source, **options).sections[0].words)


def errors(source: str, **options: object) -> list[tuple[int, int, str]]:
    with pytest.raises(toolchain.AssemblyError) as caught:
        toolchain.assemble(source, **options)
    return [(d["line"], d["column"], d["message"]) for d in caught.value.diagnostics]


def test_sections_follow_each_other_in_the_documented_order() -> None:
    source = """
        .bss    buffer,16
        .data
        .word   buffer,stack
        .sect   ".tables"
table:  .word   1,2,3
stack   .usect  "stack",100
        .text
start:  nop
        nop
"""
    image = toolchain.assemble(source)
    layout = [(s.name, s.address, s.size, s.loaded) for s in sorted(image.sections, key=lambda s: s.address)]
    assert layout == [
        (".text", 0x300000, 2, True),
        (".data", 0x300002, 2, True),
        (".tables", 0x300004, 3, True),
        (".bss", 0x300007, 16, False),
        ("stack", 0x300017, 100, False),
    ]
    assert image.symbols["table"] == 0x300004 and image.entry == 0x300000
    data = next(s for s in image.sections if s.name == ".data")
    assert list(data.words) == [0x300007, 0x300017]
    moved = toolchain.assemble(source, sections={".text": 0x2FF800, ".data": 0x310000, "stack": 0x320000})
    assert {s.name: s.address for s in moved.sections} == {
        ".text": 0x2FF800, ".data": 0x310000, ".tables": 0x310002, ".bss": 0x310005, "stack": 0x320000,
    }  # fmt: skip


def test_overlapping_sections_and_the_end_of_memory_are_errors() -> None:
    source = "\t.space 10\n\t.data\n\t.space 10\n"
    assert "overlap" in errors(source, sections={".text": 0x1000, ".data": 0x1005})[0][2]
    assert "address space" in errors(source, sections={".text": 0xFFFFFFFA, ".data": 0})[0][2]


def test_addresses_of_32_bits_are_loaded_in_halves_and_pages() -> None:
    source = """
        .text
        ldhi    hi16(table),ar0
        or      lo16(table),ar0
        ldp     @table
        ldpk    @table
        ldpk    table
        ldpk    page(table)
        ldpk    30h
        ldf     @table,r0
        .data
table:  .word   table
"""
    got = words(source, sections={".data": 0x80123456})
    assert got == [0x1FE88012, 0x10683456, 0x1F708012, 0x1F708012, 0x1F708012, 0x1F708012, 0x1F700030, 0x07203456]


def test_constants_may_be_used_before_they_are_defined_and_repeated_unchanged() -> None:
    assert words("\tldi N,r0\nN\t.set M+1\nM\t.equ 41\nM .set 41\n\t.set K,7\n\tldi K,r1\n") == [0x0860002A, 0x08610007]
    assert errors("M .set 41\nM .set 42\n")[0] == (2, 1, "'M' is defined already at <text>:1")
    assert "in terms of itself" in errors("P .set Q\nQ .set P\n\t.word P\n")[0][2]


def test_labels_and_constants_end_up_in_the_symbols() -> None:
    image = toolchain.assemble("base .set 10h\nrate .set 0.5\nhere: nop\nthere nop\nsize .set there-here\n", symbols={"N": 3})
    assert image.symbols == {"base": 0x10, "rate": 0xFF000000, "here": 0x300000, "there": 0x300001, "size": 1, "N": 3}


def test_the_entry_is_the_start_symbol_or_the_one_asked_for() -> None:
    source = "\tnop\n_start: nop\nother: nop\n"
    assert toolchain.assemble(source).entry == 0x300001
    assert toolchain.assemble(source, entry="other").entry == 0x300002
    for name in ("c_int00", "start", "START"):
        assert toolchain.assemble(f"\tnop\n{name}: nop\n").entry == 0x300001
    assert "entry symbol" in errors(source, entry="nowhere")[0][2]


def test_data_directives() -> None:
    assert words("\t.word 1,-1,0FFFFFFFFh,'A'\n\t.byte -1,255\n\t.hword -1,65535\n") == [
        1, 0xFFFFFFFF, 0xFFFFFFFF, 65, 255, 255, 65535, 65535,
    ]  # fmt: skip
    assert words("\tnop\n\t.align 4\n\tnop\n\t.space 2\n") == [0x0C800000] * 5 + [0, 0]
    assert words("\t.word $,$-start\nstart: .word $\n") == [0x300000, 0xFFFFFFFE, 0x300002]
    assert words("x .set 1.5\n\t.word single(x*2)\n\t.float x,-x,3\n") == [0x01400000, 0x00400000, 0x00C00000, 0x01400000]


def test_numbers_take_a_word_per_character_and_strings_a_word_per_four() -> None:
    """As GNU as has them, whose authors had TI's manual: its examples are the first and the last line."""
    assert words("\t.byte 10,-1,\"abc\",'a'\n") == [10, 255, 97, 98, 99, 97]
    assert words('\t.int 1,"ab"\n\t.byte "x\\n",0\n') == [1, 97, 98, 120, 10, 0]
    assert words('\t.byte "a\\b""c"\n') == [97, 92, 98, 34, 99]  # only C's escapes are escapes; a quote is doubled
    assert words('\t.asciz "c"\n\t.asciz "abc","d"\n') == [0x63, 0x00636261, 0x64]
    assert words('\t.string "ABCD", 51h, 52h, 53h, 54h, "Houston", 36+12\n') == [
        0x44434241, 0x54535251, 0x73756F48, 0x306E6F74,
    ]  # fmt: skip


def test_fields_fill_words_from_bit_0() -> None:
    source = "\t.field 3,4\nb .field -1,4\n\t.field 5,8\nc .field 7Fh,17\n\t.field 1,1\n\t.word b,c\n\t.field 2\n"
    assert words(source) == [0x05F3, 1 << 17 | 0x7F, 0x300000, 0x300001, 2]
    assert "does not fit in 4 bits" in errors("\t.field 16,4\n")[0][2]


def test_floats_in_the_three_formats() -> None:
    assert words("\t.ieee 1.0,-2.5,0,1e-45\n") == [0x3F800000, 0xC0200000, 0, 1]
    # IEEE halves to even, and what lies a decimal beside the half goes to its side.
    assert words("\t.ieee 16777217,16777219,16777217.00000000000000001\n") == [0x4B800000, 0x4B800002, 0x4B800001]
    # Extended: the word that STF stores, then the mantissa.
    assert words("\t.ldouble 1.0,-1.0,1.000000001\n") == [0, 0, 0xFF800000, 0x80000000, 0, 2]
    assert "out of the range" in errors("\t.ieee 3.5e38\n")[0][2]


def test_substitution_symbols() -> None:
    source = """
        .asg    AR3,FP
        .asg    "1,2",list
        .eval   2*3,n
        ldi     *+FP(n),r0
        .word   list,n
        .eval   n+1,n
        .word   n, :list(3):9
        .asg    n,m
        .word   m
        .unasg  n
n       .set    77
        .word   n
"""
    assert words(source) == [0x08400306, 1, 2, 6, 7, 29, 7, 77]


def test_functions_of_substitution_symbols() -> None:
    source = """
        .asg    abcab,s
        .word   $symlen(s),$symlen("xy"),$symcmp(s,abcab),$symcmp(a,b),$firstch(s,'b'),$lastch(s,'b'),$firstch(s,'z')
        .word   $isdefed(s),$isdefed(t),$iscons(12h),$iscons(s),$isname(s),$isname(1),$isreg(AR3),$isreg(s)
each    .macro  items
        .var    item
        .loop
        .break  $ismember(item,items) == 0
        .word   item*2
        .endloop
        .endm
        each    1,2,3
"""
    assert words(source) == [5, 2, 0, 0xFFFFFFFF, 2, 5, 0, 1, 0, 1, 0, 1, 0, 1, 0, 2, 4, 6]


def test_registers_have_further_names() -> None:
    assert words("FP .set AR3\nacc .equ r2\n\tLDI *-FP(2),acc\n\tstik 8,*+FP(2)\n") == [0x08420B02, 0x15680302]
    assert "cannot be part" in errors("FP .set AR3\n\t.word FP+1\n")[0][2]


def test_local_labels_last_until_the_block_ends() -> None:
    source = """
        b       $1
$1:     b       $1
        .newblock
$1      b       $1
        .data
$1      .word   $1
        .text
        b       $1
$1
"""
    image = toolchain.assemble(source)
    back = 0x6A00FFFF
    assert list(image.sections[0].words) == [0x6A000000, back, back, 0x6A000000]
    assert image.symbols == {}
    assert "undefined symbol '$1'" in errors("$1:\tnop\n\t.newblock\n\tb $1\n")[0][2]
    assert "defined already" in errors("$1:\tnop\n$1:\tnop\n")[0][2]


def test_leaving_macros_and_repeats() -> None:
    source = """
m       .macro  n
        .if     n > 2
        .word   n
        .mexit
        .endif
        .word   -n
        .endm
        m       1
        m       3
        .eval   0,i
        .loop   10
        .eval   i+1,i
        .if     i = 2
        .loop
        .word   99
        .break
        .endloop
        .endif
        .break  i == 4
        .word   i
        .endloop
"""
    assert words(source) == [0xFFFFFFFF, 3, 1, 99, 2, 3]
    assert "outside" in errors("\t.mexit\n")[0][2] and "outside" in errors("\t.break\n")[0][2]


def test_macros_take_lists_and_quoted_arguments() -> None:
    source = 'm .macro a,rest\n .word a,rest\n .endm\n m 1,2,3\n m "4,5",6\n'
    assert words(source) == [1, 2, 3, 4, 5, 6]
    assert words('s .macro a\n .byte a\n .byte ":a(2):"\n .endm\n s """xy"""\n') == [120, 121, ord("x")]


def test_predefined_symbols_and_the_processors_version() -> None:
    assert words("\t.word .TMS320C40,.tms320xx,.C3X,.bigmodel\n\t.if .C4X\n\t.word 4\n\t.endif\n") == [1, 40, 0, 0, 4]
    assert toolchain.assemble("\t.word .C40\n").symbols == {}
    assert toolchain.assemble("\t.version 40\n\tnop\n").warnings == []
    assert "C3x" in toolchain.assemble("\t.version 30\n\tnop\n").warnings[0]
    assert "no processor" in errors("\t.version 50\n")[0][2]


def test_labels_may_have_the_names_of_instructions() -> None:
    assert words("B .set 5\n\tldi B,r0\nstore ldi 1,r0\nOR: nop\nabsf\tnop\n") == [0x08600005, 0x08600001, 0x0C800000, 0x0C800000]


def test_structures_name_places_in_records() -> None:
    source = """
point   .struct
x       .float
y       .float
size    .endstruct
box     .struct 1
lo      .tag    point
hi      .tag    point
name    .string 4
        .align  8
last    .int
        .endstruct
either  .union
a       .int    3
b       .tag    point
esize   .endunion
        .struct
plain   .int    2
after   .int
        .endstruct
        .word   point.x,point.y,size,point
        .word   box.lo,box.hi,box.hi.y,box.name,box.last,box
        .word   either.a,either.b.y,esize,plain,after
b1      .tag    box
        .bss    b1,box
        ldi     @b1.hi.y,r0
"""
    image = toolchain.assemble(source, sections={".bss": 0x310000})
    assert list(image.sections[0].words) == [0, 1, 2, 2, 1, 3, 4, 5, 16, 17, 0, 1, 3, 0, 2, 0x08200004]
    assert errors("s .struct\nx .int\n")[0] == (1, 1, ".struct has no .endstruct")
    assert "no structure" in errors("x .tag y\n")[0][2]
    assert "cannot declare a member" in errors("s .struct\n\t.text\n\t.endstruct\n")[0][2]
    assert "closes nothing" in errors("\t.endstruct\n")[0][2]
    assert "within a structure" in errors("s .struct\n\t.struct\n\t.endstruct\n")[0][2]


def test_included_files_are_found_in_any_case_of_letters(tmp_path: Path) -> None:
    (tmp_path / "regs.inc").write_text("N .set 7\n")
    (tmp_path / "main.asm").write_text('\t.include "REGS.INC"\n\t.word N\n')
    assert list(toolchain.assemble_file(tmp_path / "main.asm").sections[0].words) == [7]


def test_what_compilers_and_listings_need_is_accepted() -> None:
    ignored = ".title \"x\"|.page|.list|.nolist|.length 60|.width 132|.option B|.sym _f,_f,32,2,0|.func 6|.line 2|.file \"a.c\"" \
              "|.stag .fake0,96|.member _a,0,15,8,32|.eos|.endfunc 29,000000000H,2|.sblock \".text\"|.mlib \"m.lib\"|.fclist|.tab 8"
    assert words("".join(f"\t{line}\n" for line in ignored.split("|")) + "\tnop\n\t.END\nrubbish (\n") == [0x0C800000]


def test_output_of_tis_c_compiler_assembles() -> None:
    """The idioms of cg30 for the C40 (prologue, frame pointer, three-operand immediates, constant table, epilogue)."""
    source = """
******************************************************
*    COMPILER OUTPUT
******************************************************
\t.version\t40
FP\t.set\t\tAR3
\t.globl\t_run
\t.text
_run:
\tPUSH\tFP
\tLDI\tSP,FP
\tADDI\t2,SP
\tSTIK\t8,*+FP(2)
\tCMPI\t8,*+FP(1)
\tBGE\tL2
L1:
\tLDA\t@CONST+1,AR0
\tADDI\t1,*+FP(1),R0
\tCMPI\tR0,*-AR1(1)
\tLDIU\t0,R1
\tLDIZ\t1,R1
\tRPTS\t46
\tSTI\tR2,*++AR1
    ||\tLDI\t*AR0++,R2
L2:
EPI0_1:
\tLDI\t*-FP(1),R1
\tBD\tR1
\tLDI\t*FP,FP
\tNOP
\tSUBI\t4,SP
***\tB\tR1\t;BRANCH OCCURS
\t.endfunc\t29,000000000H,2
\t.sect\t".const"
SL0:\t.byte\t"Compare fault at address [%x].",10,0
\t.bss\tCONST,4
\t.sect\t".cinit"
\t.word\t4,CONST
\t.word \t-1073741888      ;1
\t.end
"""
    image = toolchain.assemble(source)
    text = [isa.disassemble(word, 0x300000 + i) for i, word in enumerate(image.sections[0].words)]
    assert text[:6] == [
        "push ar3", "ldi sp,ar3", "addi 2,sp", "stik 8,*+ar3(2)", "cmpi3 8,*+ar3(1)", "bge 0x30000d",
    ]  # fmt: skip
    assert text[7:10] == ["addi3 1,*+ar3(1),r0", "cmpi3 r0,*-ar1(1)", "ldiu 0,r1"]
    assert text[12] == "ldi *ar0++(1),r2 || sti r2,*++ar1(1)"
    assert {section.name for section in image.sections} == {".text", ".const", ".cinit", ".bss"}


def test_a_line_of_ten_megabytes_is_an_error_at_its_place() -> None:
    (found,) = errors("\tnop\n\t.word " + "1," * 5_000_000 + "1\n\tnop\n")
    assert found[0] == 2 and "are the most" in found[2]


def test_conditional_assembly() -> None:
    source = """
N       .set 2
        .if N==1
        .word 1
        .elseif N==2
        .word 2
        .if 0
        .word undefined_but_never_seen
        this is no instruction ((
        .else
        .word 22
        .endif
        .else
        .word 3
        .endif
        .ifdef N
        .word 4
        .endif
        .ifndef N
        .word 5
        .endif
        .if !defined(EXTRA)
        .word 6
        .endif
"""
    assert words(source) == [2, 22, 4, 6]
    assert words(source, symbols={"EXTRA": 1}) == [2, 22, 4]


def test_macros_have_named_arguments_defaults_and_local_labels() -> None:
    source = """
count   .macro  reg, from=3, tail
again?: subi    1,reg
        bnz     again?
        ldi     from,reg
        .word   :tail:1, v\\tail
        .endm
va1     .set    7
a11     .set    8
        count   r1,,a1
        count   r2,(2+2)*2,a1
"""
    subi1, subi2 = 0x18610001, 0x18620001
    branch = 0x6A06FFFE
    assert words(source) == [subi1, branch, 0x08610003, 8, 7, subi2, branch, 0x08620008, 8, 7]


def test_a_local_label_passed_to_a_macro_stays_the_callers() -> None:
    source = "jump .macro to\nhere?: nop\n b to\n .endm\nhere?: nop\n jump here?\n"
    assert words(source) == [0x0C800000, 0x0C800000, 0x6A00FFFD]


def test_repeats() -> None:
    assert words("\t.rept 3\n\t.word $\n\t.endr\n") == [0x300000, 0x300001, 0x300002]
    assert words("\t.loop 2\n\t.rept 2\n\tnop\n\t.endr\n\t.endloop\n\t.rept 0\n\tnop\n\t.endr\n") == [0x0C800000] * 4


def test_includes_are_found_beside_the_file_and_in_the_directories(tmp_path: Path) -> None:
    (tmp_path / "inc").mkdir()
    (tmp_path / "near.inc").write_text("near .set 1\n")
    (tmp_path / "inc" / "far.inc").write_text('far .set 2\n\t.include "farther.inc"\n')
    (tmp_path / "inc" / "farther.inc").write_text("farther .set 3\n")
    main = tmp_path / "main.asm"
    main.write_text('\t.include "near.inc"\n\t.copy far.inc\n\t.include "near.inc"\n\t.word near,far,farther\n')
    image = toolchain.assemble_file(main, include_dirs=[tmp_path / "inc"])
    assert list(image.sections[0].words) == [1, 2, 3]
    with pytest.raises(toolchain.AssemblyError, match="no file 'far.inc'"):
        toolchain.assemble_file(main)


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
        ("\taddi 5,r0,r1,r2", 12, "operands, not 4"),
        ("\tldf ar0,r0", 6, "only R0 to R11"),
        ("\tldi 70000,r0", 6, "-32768 to 32767"),
        ("\tand 70000,r0", 6, "0 to 65535"),
        ("\taddi3 200,r0,r1", 8, "-128 to 127"),
        ("\tldi *ar0(1),r0", 10, "write *+ARn(x)"),
        ("\tldi *+ar0(256),r0", 6, "0 to 255"),
        ("\tldi *++ar0++,r0", 12, "not both"),
        ("\tldi *ar0++(ir1)b,r0", 17, "*ARn++(IR0)B"),
        ("\tldi *+r0(1),r0", 8, "AR0 to AR7"),
        ("\tldi nowhere,r0", 6, "undefined symbol 'nowhere'"),
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
    ("source", "line"),
    [("\t.if 1\n\tnop\n", 1), ("\tnop\nm .macro\n\tnop\n", 2), ("\t.rept 2\n\tnop\n", 1)],
)
def test_what_is_left_open_is_reported_where_it_was_opened(source: str, line: int) -> None:
    assert errors(source)[0][0] == line


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


def test_line_records_name_the_source_of_every_word() -> None:
    image = toolchain.assemble("\tnop\n\t.word 1,2,3\n\tldi 5,r0 ; five\n", name="prog.asm")
    assert [(r.address, image.files[r.file], r.line) for r in image.lines] == [
        (0x300000, "prog.asm", 1), (0x300001, "prog.asm", 2), (0x300004, "prog.asm", 3),
    ]  # fmt: skip
    listing = image.listing()
    assert "00300004 08600005      3  \tldi 5,r0 ; five" in listing and "00300003 00000003" in listing
    assert isa.disassemble(image.sections[0].words[4]) == "ldi 5,r0"
