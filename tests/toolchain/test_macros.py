"""Macros, substitution symbols, conditional assembly, repeats, included files."""

from pathlib import Path

import pytest
from assembling import errors, words
from cmrc._core import toolchain


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


def test_a_repeat_goes_on_behind_a_macro_in_it() -> None:
    source = """
put     .macro  n
        .loop   3
        .word   n
        .break  n = 2
        .endloop
        .endm
        .eval   0,n
        .loop   5
        .eval   n+1,n
        put     n
        .break  n = 3
        .endloop
"""
    assert words(source) == [1, 1, 1, 2, 3, 3, 3]


def test_functions_of_substitution_symbols() -> None:
    source = """
        .asg    abcab,s
        .word   $symlen(s),$symlen("xy"),$symcmp(s,abcab),$symcmp(a,b),$firstch(s,'b'),$lastch(s,'b'),$firstch(s,'z')
        .word   $isname(s),$isname(1),$isname("a b"),$isreg(AR3),$isreg(s)
each    .macro  items
        .var    item
        .loop
        .break  $ismember(item,items) == 0
        .word   item*2
        .endloop
        .endm
        each    1,2,3
"""
    assert words(source) == [5, 2, 0, 0xFFFFFFFF, 2, 5, 0, 1, 0, 0, 1, 0, 2, 4, 6]


@pytest.mark.parametrize(
    ("text", "kind"),
    [("101b", 1), ("0b11", 1), ("17q", 2), ("12h", 3), ("0xFF", 3), ("'a'", 4), ("\"'ab'\"", 4), ("12", 5), ("017", 5)]
    + [("1.5", 0), ("0ABh", 3), ("ABh", 0), ("12ab", 0), ("18q", 0), ("name", 0), ("-5", 0), ('""', 0)],
)
def test_iscons_says_how_a_constant_is_written(text: str, kind: int) -> None:
    assert words(f"\t.word $iscons({text})\n") == [kind]
    assert words(f"m .macro a\n .word $iscons(a)\n .endm\n m {text}\n") == [kind]


def test_isdefed_looks_for_a_symbol_of_the_name_that_a_text_has() -> None:
    source = """
one     .set    1
        .asg    one,s
        .asg    two,t
        .word   $isdefed("one"),$isdefed("two"),$isdefed(s),$isdefed(t),$isdefed("s"),$isdefed(".TMS320C40")
        .if     !$isdefed("two")
two     .set    2
        .endif
        .word   two,$isdefed(t)
"""
    assert words(source) == [1, 0, 1, 0, 0, 1, 2, 1]


def test_an_option_sets_a_predefined_symbol_in_any_case_of_letters() -> None:
    source = "\t.word .REGPARM,.regparm,.BigModel\n\t.if .regparm\n\t.word 7\n\t.endif\n"
    assert words(source) == [0, 0, 0]
    assert words(source, symbols={".REGPARM": 1, ".bigmodel": 2}) == [1, 1, 2, 7]


def test_a_macros_definition_has_comments_that_begin_with_an_exclamation_mark() -> None:
    source = """
m       .macro  x
! a comment, with x and 'odd (things
! .endm
        .loop   2
! in a repeat
        .word   x
        .endloop
        .endm
        m       5
"""
    assert words(source) == [5, 5]
    assert errors("m .macro\n nop\n .endm\n m\n! no macro\n")[0][:2] == (5, 1)


def test_a_function_may_look_for_a_comma() -> None:
    assert words("\t.asg \"ab,c,d\",s\n\t.word $firstch(s,','),$lastch(s,','),$firstch(s,'d'),$symlen(s)\n") == [
        3,
        5,
        6,
        6,
    ]


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


def test_included_files_are_found_in_any_case_of_letters(tmp_path: Path) -> None:
    (tmp_path / "regs.inc").write_text("N .set 7\n")
    (tmp_path / "main.asm").write_text('\t.include "REGS.INC"\n\t.word N\n')
    assert list(toolchain.assemble_file(tmp_path / "main.asm").sections[0].words) == [7]


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


@pytest.mark.parametrize(
    "operation",
    [".global y", ".def y", ".asg 1,n", ".eval 1,n", ".unasg n", ".version 40", ".dialect ti", '.wmsg "w"', ".end"]
    + [
        ".newblock",
        ".page",
        '.title "t"',
        ".rept 0\n\t.endr",
        ".if 1\n\t.endif",
        ".ifdef x\n\t.endif",
        ".label z",
        ".bss b,3",
        ".if 0\n\t.elseif 1\n\t.endif",
    ],
)
def test_a_label_that_its_directive_has_no_use_for_names_the_place(operation: str) -> None:
    assert words(f"x\t.word 7,y-x\ny:\t{operation}\n") == [7, 2]


@pytest.mark.parametrize(("first", "second", "part"), [(1, 1, 1), (1, 0, 1), (0, 1, 2), (0, 0, 3)])
def test_a_label_between_two_branches_belongs_to_both(first: int, second: int, part: int) -> None:
    source = f"""
        .word   9
a:      .if     {first}
        .word   1
b:      .elseif {second}
        .word   2
c:      .else
        .word   3
d:      .endif
        .word   """
    places = {"a": 0, "b": 1 if part == 1 else 0, "c": 1 if part == 2 else 0, "d": 1}
    unknown = {1: "c", 3: "b"}.get(part)  # neither of its branches is assembled
    for name, place in places.items():
        if name == unknown:
            assert [text for _, _, text in errors(f"{source}{name}-a\n")] == [f"undefined symbol '{name}'"]
        else:
            assert words(f"{source}{name}-a\n") == [9, part, place]


def test_a_label_in_a_branch_that_is_left_out_is_left_out() -> None:
    source = "\t.if 0\n\t.if 1\n\tnop\nb:\t.else\n\t.endif\n\t.endif\n\t.word b\n"
    assert [text for _, _, text in errors(source)] == ["undefined symbol 'b'"]


def test_errors_at_the_line_between_two_branches_are_said_once() -> None:
    twice = "b:\t.if 1\n\t.word 1\nb:\t.else\n\t.word 2\n\t.endif\n\t.word 3\n"
    assert errors(twice) == [(3, 1, "'b' is defined already at <text>:1")]
    assert errors("\t.if 0\n\t.elseif nothing\n\t.endif\n") == [(2, 10, "undefined symbol 'nothing'")]


def test_what_closes_a_macro_or_a_repeat_takes_no_label() -> None:
    assert errors("\t.rept 2\n\tnop\nx:\t.endr\n") == [
        (3, 1, "'.endr' takes no label; a line of its own before it is expected")
    ]


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


def test_character_constants_are_arguments_as_they_are() -> None:
    macro = "two .macro a,b\n .word a,b\n .endm\n"
    for constant in ("?", "(", ")", '"', ",", ";"):
        assert words(f"{macro} two '{constant}',9\n") == [ord(constant), 9]


def test_functions_stand_in_code_alone() -> None:
    assert words("\tnop ; see $symlen(\n\tnop ; $symcmp(a)\n") == [0x0C800000] * 2
    text = [int.from_bytes(part, "little") for part in (b"$isr", b"eg(r", b"0)")]
    assert words('\t.string "$isreg(r0)"\n') == text
    assert words("\t.asg \"a)b\",N\n\t.word $firstch(N,')'),$symlen(N)\n") == [2, 3]


def test_a_substitution_symbol_with_a_semicolon_is_assigned_again() -> None:
    assert words('\t.asg "x;y",N\n\t.asg "z;long",N\n\t.word $symlen(N)\n') == [6]


def test_a_parameter_with_the_name_of_a_directive() -> None:
    assert words("m .macro align,word\n\t.align align\n\t.word word\n\t.endm\n m 8,3\n") == [3]


def test_a_quote_behind_a_backslash_does_not_end_a_text() -> None:
    assert words('\t.asg 5,n\n\t.string "a\\"n"\n') == [int.from_bytes(b'a"n', "little")]


@pytest.mark.parametrize("live", [".asg ar2,p", ".asg 7,p", ".eval 7,p", ".asg q,p"])
@pytest.mark.parametrize("head", ["get .macro p", "\t.macro get p", "\t.macro get, p ; p"])
def test_a_parameter_keeps_its_name_beside_a_substitution_symbol(live: str, head: str) -> None:
    assert words(f"\t{live}\n{head}\n ldi *p,r0\n .word N\n .endm\nN .set 1\n get ar5\n") == [0x0840C500, 1]


def test_a_parameters_default_is_text() -> None:
    assert words('\t.asg 5,d\n\t.asg 6,a\nm .macro a,b=d,c=$symlen("xyz") ; a\n .word a,b,c\n .endm\n m 1\n') == [
        1,
        5,
        3,
    ]


def test_a_macro_in_a_macro_has_its_own_parameters_and_gets_the_outer_ones_of_other_names() -> None:
    source = """
m       .macro  a,b,c
n       .macro  a,d=b
        .var    c
        .asg    9,c
        .word   a,b,c,d
o       .macro  b
        .word   a,b,c
        .endm
        .endm
        .word   a
        .endm
        m       5,6,7
        n       1
        o       2
        n       3,4
"""
    # In o, a and c are those of n at its expansion.
    assert words(source) == [5, 1, 6, 9, 6, 1, 2, 9, 3, 6, 9, 4]


def test_a_name_that_a_macros_argument_gives_is_put_in_where_it_is_forced() -> None:
    source = """
m       .macro  p,s
n       .macro  v\\p,:s:w
        .word   v:p:,xw
        .endm
        .asg    8,g:s:
        .endm
        m       5,x
        n       3,4
        .word   gx
"""
    assert words(source) == [3, 4, 8]


@pytest.mark.parametrize("name", ["a", "ab", "abc", "abcd", "abcdefgh"])
def test_a_name_in_a_character_constant_is_put_in_where_it_is_forced(name: str) -> None:
    x, xy = ord("x"), ord("x") | ord("y") << 8
    constants = f"':{name}:','\\{name}',':{name}(2):','{name[:4]}',':no:'"
    kept = [int.from_bytes(name[:4].encode(), "little"), int.from_bytes(b":no:", "little")]
    for value, whole in (("x", x), ("xy", xy)):
        expected = [whole, whole, ord(value[1]) if value[1:] else None, *kept]
        text = constants if value[1:] else constants.replace(f",':{name}(2):'", "")
        expected = [word for word in expected if word is not None]
        assert words(f"m .macro {name}\n .word {text}\n .endm\n m {value}\n") == expected
        assert words(f"\t.asg {value},{name}\n .word {text}\n") == expected
    assert words(f"\t.asg x,{name}\n .byte ':{name}:',{4 * chr(39)}\n") == [x, 39]
    assert "one to four characters" in errors(f"\t.asg hello,{name}\n .word ':{name}:'\n")[0][2]


def test_the_least_number_is_put_in_by_eval() -> None:
    assert words("\t.eval 1<<63,x\n\t.eval x+1,y\n\t.word x>>32,x>>63,y==-9223372036854775807,3*(x/x)\n") == [
        0x80000000,
        0xFFFFFFFF,
        1,
        3,
    ]
