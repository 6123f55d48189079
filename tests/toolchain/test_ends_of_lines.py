"""What stands behind a complete line is an error, in the column where it stands: for every directive and an
instruction."""

from pathlib import Path

import pytest
from cmrc._core import toolchain

# Lines that are complete; ^ is the place behind the one that is put to the test.
COMPLETE = [
    " ldi 1,r0^\n", " ldi *ar0,r0\n || ldi *ar1,r1^\n", "a: nop^\n", " .text^\n", " .data^\n", " .const^\n", ' .sect "x"^\n', ' .section "x"^\n', ' .text\n .sect "x"\n nop\n .text^\n',
    " .bss x,2^\n", " .bss x,2,1^\n", 'x .usect "ram",3^\n', " .align 32^\n", " .align^\n", " .word 1,2^\n", " .int 1^\n", " .byte 1^\n", " .hword 1^\n", " .field 3,4^\n", " .field 3^\n",
    " .float 1.5^\n", " .double 1.5,2^\n", " .ldouble 1.5^\n", " .ieee 1.5^\n", ' .string "ab"^\n', ' .asciz "ab"^\n', " .space 3^\n", "x .bes 3^\n", "x .set 3^\n", " .label x^\n",
    " .newblock^\n", "s .struct^\nx .int\n .endstruct\n", "s .struct\nx .int^\n .endstruct\n", "s .struct\nx .int\n .endstruct^\n", "s .struct\nx .int\n .endstruct\nt .struct\ny .tag s^\n .endstruct\n",
    ' .asg "1",x^\n', " .eval 1,x^\n", "m .macro\n .var x^\n .endm\n m\n", " .asg 1,x\n .unasg x^\n", ' .include "empty.inc"^\n', ' .copy "empty.inc"^\n', " .global x^\n", "x: nop\n .def x^\n",
    " .ref x^\n", " .version 40^\n", "m .macro\n .mexit^\n .endm\n m\n", " .rept 2^\n nop\n .endr\n", " .loop 2\n .break 1^\n .endloop\n", " .if 1^\n nop\n .endif\n",
    " .if 0\n .elseif 1^\n nop\n .endif\n",
]  # fmt: skip


@pytest.mark.parametrize("source", COMPLETE)
def test_nothing_may_stand_behind_a_complete_line(source: str, tmp_path: Path) -> None:
    (tmp_path / "empty.inc").write_text("")
    options = {"include_dirs": [str(tmp_path)]}
    toolchain.assemble(source.replace("^", " ; a comment may"), **options)
    before = source[: source.index("^")]
    line, column = before.count("\n") + 1, len(before) - before.rfind("\n") + 1
    with pytest.raises(toolchain.AssemblyError, match=rf"<text>:{line}:{column}: error: .*\]"):
        toolchain.assemble(source.replace("^", " ] 7"), **options)


@pytest.mark.parametrize("directive", [".space", ".align", ".bes", ".rept", ".if"])
def test_a_value_that_is_not_known_is_marked_where_it_stands(directive: str) -> None:
    with pytest.raises(
        toolchain.AssemblyError,
        match=rf"<text>:2:{len(directive) + 6}: error: .* must be an integer that is known here",
    ):
        toolchain.assemble(f"x: nop\n {directive}    x\n")
