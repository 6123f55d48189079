"""What sources of the 1990s contain that TI's last manual does not describe (docs/assembler.md, Old sources)."""

import pytest
from cmrc._core import toolchain


def words(source: str) -> list[int]:
    return list(toolchain.assemble(source).sections[0].words)


NOP = 0x0C800000

SAME = [
    # as old sources have it, as it is written otherwise
    ("m .macro NAME\n:NAME: nop\n .endm\n m foo\n b foo\n", "foo: nop\n b foo\n"),
    ("m .macro NAME\n:NAME:_x nop\n .endm\n m foo\n b foo_x\n", "foo_x: nop\n b foo_x\n"),
    ("m .macro NAME\nNAME nop\n .endm\n m foo\n b foo\n", "foo: nop\n b foo\n"),
    ("m .macro\n nop\n .endm\nm\n nop\n b m\n", "m: nop\n b m\n"),
    ("m .macro\n nop\n .endm\nm ldi 1,r0\n b m\n", "m: ldi 1,r0\n b m\n"),
    ("X EQU 5\nY equ X+1\n ldi Y,r0\n", "X .set 5\n ldi X+1,r0\n"),
    ("R EQU ar3\n ldi R,r0\n", " ldi ar3,r0\n"),
    (" .word 'A','ab','abc','abcd'\n", " .word 41h,6261h,636261h,64636261h\n"),
    (" .word '''',';;'\n", " .word 27h,3B3Bh\n"),
    (" ldi 'ab',r0 ; it's\n", " ldi 6261h,r0\n"),
    (" nop\n\x1a", " nop\n"),
    (" nop\x1a\x1a\nthis is behind the end of the file", " nop\n"),
    (" .regalias\n ldf f3,f1\n", " ldf r3,r1\n"),
    (" .const\nx: .word 7\n", ' .sect ".const"\nx: .word 7\n'),  # MACS.EQU:49 of a game of 1994
    ("\ufeffx: nop\n b x\n", "x: nop\n b x\n"),  # the byte order mark of UTF-8
    ("x: nop\n\f b x\n\f\n", "x: nop\n b x\n"),
    # As a boot EPROM of the Hydra board, built by TI's tools, has it beside its source.
    (" sti ivtp,*ar0++\n sti tvtp,*ar0++\n ldi ivtp,ar0\n", " .word 15402001h,15412001h\n ldi r0,ar0\n"),
]


@pytest.mark.parametrize(("old", "new"), SAME)
def test_old_forms_mean_what_new_ones_do(old: str, new: str) -> None:
    assert words(old) == words(new)


def test_four_characters_are_packed_as_a_string_is() -> None:
    assert words(" .word 'wxyz'\n") == words(' .string "wxyz"\n')


def test_what_an_expansion_register_is_taken_for_is_warned_of() -> None:
    image = toolchain.assemble(" sti ivtp,*ar0\n")
    assert len(image.warnings) == 1 and "ivtp is taken as R0" in image.warnings[0] and "LDEP" in image.warnings[0]
    with pytest.raises(toolchain.AssemblyError, match="not the expansion register ivtp"):
        toolchain.assemble(" sti ivtp,*ar0\n", dialect="gnu")


@pytest.mark.parametrize(("register", "number"), [("R0", 0), ("r3", 3), ("AR2", 10)])
def test_a_register_as_a_size_gives_its_number_with_a_warning(register: str, number: int) -> None:
    """SND.ASM:23 of a game of 1994."""
    source = f'x .usect "ram",{register}\ny .usect "ram",1\n .word y-x\n'
    image = toolchain.assemble(source)
    assert next(section for section in image.sections if section.name == ".text").words == [number]
    assert (
        len(image.warnings) == 1
        and f"is a register: its number, {number}, is taken as the size" in image.warnings[0]
        and "<text>:1:" in image.warnings[0]
    )
    with pytest.raises(toolchain.AssemblyError, match="cannot be part of an expression"):
        toolchain.assemble(source, dialect="gnu")


def test_a_macro_may_be_defined_again_with_a_warning() -> None:
    image = toolchain.assemble("m .macro\n ldi 1,r0\n .endm\n m\nm .macro\n nop\n .endm\n m\n")
    assert list(image.sections[0].words) == [0x08600001, NOP]
    assert len(image.warnings) == 1 and "<text>:5:" in image.warnings[0] and "defined already" in image.warnings[0]


def test_a_macro_that_redefines_itself_does_its_first_work_once() -> None:
    once = "init .macro\n ldi 1,r0\ninit .macro\n nop\n .endm\n .endm\n init\n init\n"
    assert words(once) == [0x08600001, NOP]


MISTAKES = [
    (" FooBar r0,1\n", "'FooBar'"),  # as it was written
    (" push IE\n", "IE is a register of the C3x; the C40 has IIE"),
    (" ldi 1,if\n", "the C40 has IIF"),
    (" ldi iof,r0\n", "undefined symbol 'iof': iof is a register of the C3x; the C40 has IIF"),
    (" .word 'abcde'\n", "one to four characters"),
    (" .word ''\n", "one to four characters"),
    (" .word 'ab\n", "one to four characters"),
    (" EQU 5\n", "'EQU'"),
    (
        'x .usect "ram",R0+1\n',
        ":1:16: error: the register R0 cannot be part of an expression: a number or a symbol is needed",
    ),
    ("x .bss y,r0\n", "the register r0 cannot be part of an expression"),
    (" .word r0\n", "the register r0 cannot be part of an expression"),
]


@pytest.mark.parametrize(("source", "message"), MISTAKES)
def test_mistakes_are_named(source: str, message: str) -> None:
    with pytest.raises(toolchain.AssemblyError, match=message):
        toolchain.assemble(source)
