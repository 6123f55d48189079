"""A program with a subroutine and a variable, for front ends of the debugger."""

from pathlib import Path

PROGRAM = """\
        .text
start:  ldp     total
        ldi     5,r0
loop:   call    add
        subi    1,r0
        bnz     loop
end:    b       end
add:    ldi     @total,r1
        addi    r0,r1
        sti     r1,@total
        rets
total:  .word   0
"""
STACK = "        ldhi    2fh,ar7\n        or      0f800h,ar7\n        ldi     ar7,sp\n"
SUMS = [5, 9, 12, 14, 15]


def write_program(folder: Path) -> Path:
    """The program with a stack, in sums.asm."""
    path = folder / "sums.asm"
    path.write_text(PROGRAM.replace("start:  ldp     total\n", "start:  ldp     total\n" + STACK))
    return path
