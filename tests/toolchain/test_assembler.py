"""Directives, expressions, placement, data, symbols."""

import pytest
from assembling import errors, words
from cmrc._core import isa, toolchain


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


def test_a_sections_name_needs_no_quotes() -> None:
    image = toolchain.assemble("stack\t.usect vars,7\n\t.sect tables ; of words\n\t.word 1\n")
    assert {(section.name, section.size) for section in image.sections} == {("vars", 7), ("tables", 1)}


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


def test_halves_of_constants_are_numbers_like_any_other() -> None:
    """Of an address that is not assigned yet, a half stands alone; of a constant, the whole shift and mask count."""
    source = ".word (12345678h >> 16) + 1, (0FFFFFFFFh + 1) >> 16, (12345678h & 0FFFFh) + 1, -65537 >> 16"
    assert words(source) == [0x1235, 0x10000, 0x5679, 0xFFFFFFFE]


def test_constants_may_be_used_before_they_are_defined_and_repeated_unchanged() -> None:
    assert words("\tldi N,r0\nN\t.set M+1\nM\t.equ 41\nM .set 41\n\t.set K,7\n\tldi K,r1\n") == [0x0860002A, 0x08610007]
    assert errors("M .set 41\nM .set 42\n")[0] == (2, 1, "'M' is defined already at <text>:1")
    assert "in terms of itself" in errors("P .set Q\nQ .set P\n\t.word P\n")[0][2]


def test_labels_and_constants_end_up_in_the_symbols() -> None:
    image = toolchain.assemble(
        "base .set 10h\nrate .set 0.5\nhere: nop\nthere nop\nsize .set there-here\n", symbols={"N": 3}
    )
    assert image.symbols == {"base": 0x10, "rate": 0xFF000000, "here": 0x300000, "there": 0x300001, "size": 1, "N": 3}


def test_a_label_may_be_a_directive() -> None:
    image = toolchain.assemble("\tnop\n\t.label there\nx:\t.word there, x\n")
    assert (image.symbols["there"], list(image.sections[0].words)[1:]) == (0x300001, [0x300001, 0x300001])


def test_a_section_that_is_placed_askew_is_an_error_of_no_line() -> None:
    message = "the section '.text' at 300001h must be aligned to 4 words"
    assert errors("\tnop\n\t.align 4\n", sections={".text": 0x300001}) == [(0, 1, message)]


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
    assert words("x .set 1.5\n\t.word single(x*2)\n\t.float x,-x,3\n") == [
        0x01400000,
        0x00400000,
        0x00C00000,
        0x01400000,
    ]


def test_numbers_take_a_word_per_character_and_strings_a_word_per_four() -> None:
    """As GNU as has them: its authors had TI's manual. The first and the last line are the manual's examples."""
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
    # IEEE rounds halves to even; a value just above or below the half is rounded to its own side.
    assert words("\t.ieee 16777217,16777219,16777217.00000000000000001\n") == [0x4B800000, 0x4B800002, 0x4B800001]
    # Extended: the word that STF stores, then the mantissa.
    assert words("\t.ldouble 1.0,-1.0,1.000000001\n") == [0, 0, 0xFF800000, 0x80000000, 0, 2]
    assert "out of the range" in errors("\t.ieee 3.5e38\n")[0][2]


def test_registers_have_further_names() -> None:
    assert words("FP .set AR3\nacc .equ r2\n\tLDI *-FP(2),acc\n\tstik 8,*+FP(2)\n") == [0x08420B02, 0x15680302]
    assert "cannot be part" in errors("FP .set AR3\n\t.word FP+1\n")[0][2]


def test_predefined_symbols_and_the_processors_version() -> None:
    assert words("\t.word .TMS320C40,.tms320xx,.C3X,.bigmodel\n\t.if .C4X\n\t.word 4\n\t.endif\n") == [1, 40, 0, 0, 4]
    assert toolchain.assemble("\t.word .C40\n").symbols == {}
    assert toolchain.assemble("\t.version 40\n\tnop\n").warnings == []
    assert "C3x" in toolchain.assemble("\t.version 30\n\tnop\n").warnings[0]
    assert "no processor" in errors("\t.version 50\n")[0][2]


def test_labels_may_have_the_names_of_instructions() -> None:
    assert words("B .set 5\n\tldi B,r0\nstore ldi 1,r0\nOR: nop\nabsf\tnop\n") == [
        0x08600005,
        0x08600001,
        0x0C800000,
        0x0C800000,
    ]


def test_a_structure_is_as_large_as_its_offset_and_its_members() -> None:
    source = "none\t.struct 3\nsize\t.endstruct\none\t.struct 3\nx\t.int\n\t.endstruct\n\t.word size,none,one,one.x\n"
    assert words(source) == [3, 3, 4, 3]


def test_the_least_and_the_greatest_number_of_some_bits() -> None:
    assert words("\t.byte -128,255\n\t.hword -32768,65535\n") == [128, 255, 32768, 65535]
    for line in (".byte -129", ".byte 256", ".hword -32769", ".hword 65536"):
        assert "does not fit in" in errors(f"\t{line}\n")[0][2]


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


def test_what_compilers_and_listings_need_is_accepted() -> None:
    ignored = (
        '.title "x"|.page|.list|.nolist|.length 60|.width 132|.option B|.sym _f,_f,32,2,0|.func 6|.line 2|.file "a.c"'
        '|.stag .fake0,96|.member _a,0,15,8,32|.eos|.endfunc 29,000000000H,2|.sblock ".text"|.mlib "m.lib"|.fclist|.tab 8'
    )
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


def test_line_records_name_the_source_of_every_word() -> None:
    image = toolchain.assemble("\tnop\n\t.word 1,2,3\n\tldi 5,r0 ; five\n", name="prog.asm")
    assert [(r.address, image.files[r.file], r.line) for r in image.lines] == [
        (0x300000, "prog.asm", 1), (0x300001, "prog.asm", 2), (0x300004, "prog.asm", 3),
    ]  # fmt: skip
    listing = image.listing()
    assert "00300004 08600005      3  \tldi 5,r0 ; five" in listing and "00300003 00000003" in listing
    assert isa.disassemble(image.sections[0].words[4]) == "ldi 5,r0"


def test_defined_means_before_this_line_everywhere() -> None:
    assert words("start: .word defined(x),defined(start)\n ldi defined(x),r0\nx: nop\n") == [
        0,
        1,
        0x08600000,
        0x0C800000,
    ]


def test_a_label_on_a_line_of_its_own_names_the_next_field() -> None:
    source = "\t.field 1,4\nx:\n\t.field 2,4\ny:\t.field 3,4\n"
    image = toolchain.assemble(source)
    assert list(image.sections[0].words) == [1, 0x32]
    assert image.symbols == {"x": 0x300001, "y": 0x300001}


def test_a_large_integer_is_rounded_once() -> None:
    assert words("\t.float 1152921573326323711,1152921573326323711.0\n") == [0x3C000000] * 2


@pytest.mark.parametrize("number", ["300", "-129"])
def test_a_number_in_a_string_is_a_character(number: str) -> None:
    assert errors(f"\t.string {number}\n") == [(1, 10, f"{number} does not fit in 8 bits")]
    assert words("\t.string 255,-1,65\n") == [0x41FFFF]


@pytest.mark.parametrize(("first", "second"), [("AR3", "AR4"), ("AR3", "5"), ("5", "AR3")])
def test_a_name_of_a_register_keeps_its_meaning(first: str, second: str) -> None:
    assert words("FP .set AR3\nFP .set AR3\n\tldi FP,r0\n") == [0x0800000B]
    assert "'FP' is defined already" in errors(f"FP .set {first}\nFP .set {second}\n")[0][2]


@pytest.mark.parametrize("use", ["rpts x", "subc x,r0", "mpyuhi x,r0", "lbu0 x,r0"])
def test_an_address_that_does_not_fit_is_an_error_but_for_the_logical_ones(use: str) -> None:
    assert "an address has 32 bits" in errors(f"x:\t{use}\n")[0][2]
    assert words("x:\tor x,r0\n\tand x,r0\n\ttstb x,r0\n") == [0x10600000, 0x02E00000, 0x1A600000]


def test_label_ends_the_word_of_fields_as_a_label_on_its_own_line_does() -> None:
    source = "\t.field 1,4\n\t{}\n\t.field 2,4\n\t.word x\n"
    assert words(source.format(".label x")) == words("\t.field 1,4\nx:\n\t.field 2,4\n\t.word x\n")
    assert words(source.format(".label x")) == [1, 2, 0x300001]
