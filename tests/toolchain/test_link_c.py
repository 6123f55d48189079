"""scripts/link_c: from what a compiler writes to a program that runs, and what it refuses (docs/from-c.md)."""

import subprocess
import sys
from pathlib import Path

import pytest
from cmrc import c40
from locations import BUILD, ROOT

COMPILED = """
gcc2_compiled.:
\t.data
\t.global _table
_table:
\t.word 30
\t.word 12
\t.text
\t.ref ___udivqi3
\t.global _main
_main:
\tldhi ^_table,ar0
\tor #_table,ar0
\tlda *ar0,ar2
\tldiu *+ar0(1),r2
\tlaj ___udivqi3
\tnop
\tnop
\tpush r11
\trets
"""


def link_c(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, ROOT / "scripts" / "link_c", *arguments], capture_output=True, text=True, check=False
    )


@pytest.mark.skipif(BUILD != ROOT / "build", reason="the script takes the emulator of build/")
@pytest.mark.parametrize("model", ["rom", "ram"])
def test_what_gcc_writes_links_with_what_it_calls_and_no_more(model: str, tmp_path: Path) -> None:
    (tmp_path / "compiled.s").write_text(COMPILED)
    done = link_c(tmp_path / "compiled.s", "-o", tmp_path / "a.out", "--c-model", model)
    assert done.returncode == 0, done.stderr
    image = c40.read_coff(tmp_path / "a.out")
    assert "DIV_U" in image.symbols and "_malloc" not in image.symbols and "_putchar" not in image.symbols
    chip = c40.Processor(image)
    assert chip.run(10_000, until="c_exit").reason == "until"
    assert chip.registers["R0"] & 0xFFFF_FFFF == 30 // 12


@pytest.mark.skipif(BUILD != ROOT / "build", reason="the script takes the emulator of build/")
def test_bad_input_is_named_and_nothing_is_written(tmp_path: Path) -> None:
    (tmp_path / "bad.s").write_text("_main:\tnonsense r0\n")
    done = link_c(tmp_path / "bad.s", "-o", tmp_path / "a.out")
    assert done.returncode == 2 and "bad.s:1" in done.stderr and not (tmp_path / "a.out").exists()
    done = link_c(tmp_path / "none.s", "-o", tmp_path / "a.out")
    assert done.returncode == 2 and f"no file {tmp_path / 'none.s'}" in done.stderr
    (tmp_path / "lost.s").write_text("\t.global _helper\n\t.text\n_helper:\trets\n")
    done = link_c(tmp_path / "lost.s", "-o", tmp_path / "a.out")
    assert done.returncode == 2 and "undefined symbol '_main'" in done.stderr and not (tmp_path / "a.out").exists()


# As the manual of TI's compiler has it: FP is AR3, a structure is returned to where AR0 points, DP is set once.
STRUCTURE = """
FP      .set    AR3
        .globl  _main, _get, _next
        .text
_get:   push    FP                      ; struct { int a; float b; int c[3]; } get(int x, float y)
        ldi     sp,FP
        addi    1,sp
        push    r4
        push    ar4
        ldi     ar0,ar4
        ldi     *-FP(2),r0
        sti     r0,*ar4
        ldf     *-FP(3),r1
        stf     r1,*+ar4(1)
        ldi     2,r4
fill:   addi    1,r0
        ldi     r4,ir0
        sti     r0,*+ar4(ir0)
        addi    1,r4
        cmpi    4,r4
        ble     fill
        pop     ar4
        pop     r4
        ldi     *-FP(1),r1
        bd      r1
        ldi     *FP,FP
        nop
        subi    3,sp
_main:  push    FP
        ldi     sp,FP
        addi    5,sp
        ldf     @CONST,r0
        pushf   r0
        ldi     @_count,r1
        push    r1
        addi3   1,FP,ar0
        call    _get
        subi    2,sp
        ldi     *+FP(1),r0              ; 7
        addi    *+FP(5),r0              ; and 10
        ldi     @CONST+1,ar0
        addi    *+ar0(2),r0             ; and 30 of the table
        ldi     @_pointer,r1
        push    r0
        callu   r1                      ; and 1
        subi    1,sp
        fix     *+FP(2),r1
        addi    r1,r0                   ; and 2 of 2.5
        ldi     *-FP(1),r1
        bd      r1
        ldi     *FP,FP
        nop
        subi    7,sp
_next:  ldi     sp,ar0
        ldi     *-ar0(1),r0
        addi    1,r0
        rets
        .sect   ".const"
table:  .word   10,20,30
        .bss    _count,1
        .bss    _pointer,1
        .bss    CONST,2
        .sect   ".cinit"
        .word   1,_count
        .int    7
        .word   SIZE,_pointer
        .word   _next
SIZE    .set    1
        .word   2,CONST
        .float  2.5
        .word   table
"""
SIX_IN_REGISTERS = """
        .globl  _main, _sum
_sum:   addi3   r2,ar2,r0               ; int sum(int, int, int, int, int, int, int): the seventh on the stack
        addi    r3,r0
        addi    rc,r0
        addi    rs,r0
        addi    re,r0
        ldi     sp,ar0
        addi    *-ar0(1),r0
        rets
_main:  ldi     7000,r0
        push    r0
        ldi     1,ar2
        ldi     2,r2
        ldi     4,r3
        ldi     8,rc
        ldi     16,rs
        ldi     32,re
        call    _sum
        subi    1,sp
        rets
"""
INTERRUPTS = """
FP      .set    AR3
        .globl  _main, _c_int02, _ticks, vectors
_c_int02:
        push    st
        push    dp
        push    r0
        pushf   r0
        ldp     _ticks
        ldi     @_ticks,r0
        addi    1,r0
        sti     r0,@_ticks
        popf    r0
        pop     r0
        pop     dp
        pop     st
        reti
_main:  ldi     @VECTORS,r0
        ldpe    r0,ivtp
        ldhi    10h,ar1                 ; timer 0
        or      20h,ar1
        ldi     50,r0
        sti     r0,*+ar1(8)
        ldi     3c1h,r0
        sti     r0,*ar1
        ldi     1,iie
        or      2000h,st
wait:   ldi     @_ticks,r0
        cmpi    5,r0
        blt     wait
        ldi     0,iie
        rets
        .bss    _ticks,1
        .bss    VECTORS,1
        .sect   ".cinit"
        .word   1,_ticks,0
        .word   1,VECTORS,vectors
        .sect   "vectors"
        .word   0,0,_c_int02
"""
PAGES = """
        .globl  _main, _far
_main:  push    dp                      ; the big model: DP is set for each access
        ldp     @_far
        ldi     @_far,r0
        ldp     @_far+0FFF8h
        addi    @_far+0FFF8h,r0
        ldp     @_farther+2
        addi    @_farther+2,r0
        pop     dp
        rets
        .bss    before,0FFF0h
        .bss    _far,10000h
        .bss    _farther,3
        .sect   ".cinit"
        .word   1,_far,1
        .word   1,_far+0FFF8h,100
        .word   3,_farther,0,0,10
"""
ONE_PAGE = """
        .globl  _main
_main:  ldi     @_a,r0                  ; the small model: DP stays
        addi    @_b,r0
        rets
        .bss    _a,1
        .bss    fill,100h
        .bss    _b,1
        .sect   ".cinit"
        .word   1,_a,3
        .word   1,_b,4
"""


@pytest.mark.skipif(BUILD != ROOT / "build", reason="the script takes the emulator of build/")
@pytest.mark.parametrize("model", ["rom", "ram"])
@pytest.mark.parametrize(
    ("source", "arguments", "memory_map", "result"),
    [
        (STRUCTURE, "stack", "", 7 + 10 + 30 + 1 + 2),
        (SIX_IN_REGISTERS, "registers", "", 7063),
        (INTERRUPTS, "stack", '[sections]\n"vectors" = { memory = "m", align = 0x200, size = 0x40 }\n', 5),
        (PAGES, "stack", "", 111),
        (ONE_PAGE, "stack", "behind 30FF00h", 7),
    ],
    ids=["structure", "registers", "interrupts", "big model", "small model"],
)
def test_programs_by_the_rules_of_tis_compiler(
    source: str, arguments: str, memory_map: str, result: int, model: str, tmp_path: Path
) -> None:
    origin, rest = (0x30FF00, "") if memory_map.startswith("behind") else (0x300000, memory_map)
    (tmp_path / "map.toml").write_text(f"[memory]\nm = {{ origin = {origin:#x}, length = 0x80000 }}\n{rest}")
    (tmp_path / "main.asm").write_text(source)
    done = link_c(
        tmp_path / "main.asm", "--arguments", arguments, "--c-model", model, "--map", tmp_path / "map.toml",
        "-o", tmp_path / "a.out",
    )  # fmt: skip
    said = done.stdout + done.stderr
    assert done.returncode == 0
    assert said.endswith("only the first, one of the big model all\n") if source is PAGES else said == ""
    chip = c40.Processor(c40.read_coff(tmp_path / "a.out"))
    assert chip.run(2_000_000, until="c_exit").reason == "until"
    assert chip.registers["R0"] & 0xFFFF_FFFF == result
