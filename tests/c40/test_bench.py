"""c40_bench compares the registers of its plain interpreter with those of the chip: they agree after every instruction
that the interpreter knows."""

import subprocess
from pathlib import Path

import pytest
from cmrc._core import toolchain
from locations import BUILD

# Loops; what is written to R0, R2, R5, AR0 and AR3 is compared after a million cycles.
INTEGERS = """
loop:   ldi     -1, r0
        ldi     8000h, r2           ; the immediate value has a sign: FFFF8000h
        ldi     7fffh, r5
        or      0ff00h, r2          ; a logical one has none
        addi    -2, r5
        subi    -7, r0
        ldi     r0, ar0
        ldi     r2, ar3
        b       loop
"""


@pytest.mark.parametrize("more", range(4))  # the end of the run falls on other instructions
def test_the_plain_interpreter_agrees_about_integers(tmp_path: Path, more: int) -> None:
    image = toolchain.assemble("        ldi     r1, r1\n" * more + INTEGERS, "integers.asm", sections={".text": 0x1000})
    hexadecimal = tmp_path / "integers.hex"
    hexadecimal.write_text("".join(f"{word:08x}\n" for word in image.sections[0].words))
    done = subprocess.run(
        [BUILD / "bin" / "c40_bench", "--millions", "1", "--repeat", "1", hexadecimal],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[1].startswith("integers ")
