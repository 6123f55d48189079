"""What a dock may need as files: tasks of a user's own in the DSP programs, boards, layouts."""

from __future__ import annotations

import shutil
from pathlib import Path

from locations import ROOT

# Tasks of a user's own (docs/add-a-task.md): a sound one, and those that a controller has to survive.
USER_KERNELS = """
kernel_user_counts:
        ldi     *+ar6(8), r2
        addi    1, r2
        sti     r2, *+ar6(8)
        ldi     0, r0
        ldi     0, r1
        rets
kernel_user_never_returns:
        br      kernel_user_never_returns
kernel_user_takes_long:
        ldhi    1, ar1
        ldi     0, r0
        ldi     0, r1
user_takes_long_loop:
        db      ar1, user_takes_long_loop
        rets
kernel_user_writes_everywhere:
        ldi     ar6, ar1
        subi    80h, ar1
        ldi     0fffh, rc
        ldi     -1, r3
        rptb    user_writes_end
user_writes_end: sti r3, *ar1++
        ldi     0, r0
        ldi     0, r1
        rets
kernel_user_touches_nothing:
        ldhi    5555h, ar1
        ldi     *ar1, r0
        ldi     0, r1
        rets
kernel_user_swi:
        swi
        rets
kernel_user_talks:
        ldhi    0010h, ar0
        or      0040h, ar0
        ldi     *ar0, r0
        and     01E0h, r0               ; OUTPUT LEVEL of port 0
        bnz     talks_end
        sti     r3, *+ar0(2)
talks_end:
        ldi     *+ar0(40h), r0
        and     1E00h, r0               ; INPUT LEVEL of port 4
        bz      talks_done
        ldi     *+ar0(41h), r3
talks_done:
        ldi     0, r0
        ldi     0, r1
        rets
kernel_user_listens:
        ldhi    0010h, ar0
        or      0080h, ar0
        ldi     *+ar0(1), r3            ; waits for a word
        ldi     0, r0
        ldi     0, r1
        rets
kernel_user_pins:
        ldhi    0010h, ar0
        ldi     *+ar0(34h), r3          ; timer 1 counts edges of TCLK1
        ldi     0C1h, r2
        sti     r2, *+ar0(30h)
        addi    40h, r3
        sti     r3, *+ar0(28h)
        ldi     2C1h, r2
        sti     r2, *+ar0(20h)          ; timer 0 gives pulses at TCLK0
        ldhi    0, r2
        or      9920h, r2
        or      r2, iif                 ; IIOF3 and IIOF2 end IDLE; IIOF1 is an output
        xor     40h, iif
        ldi     0, r0
        ldi     0, r1
        rets
"""
USER_PROGRAMS = [
    "counts",
    "counts",
    "never_returns",
    "takes_long",
    "writes_everywhere",
    "touches_nothing",
    "swi",
    "talks",
    "talks",
    "listens",
    "pins",
    "pins",
]


# Boards and layouts of a user's own, by their files. Pages cost the default board nothing; here they do.
WINDOWS = """
[[region]]
name = "window to bus B"
kind = "window"
base = 0x70000000
words = 0x10000000
bus = "local"
[[region]]
name = "window to bus A"
kind = "window"
base = 0xC0000000
words = 0x40000000
bus = "global"
"""
BOARDS = {
    "slow.toml": """
clock_mhz = 33.3
[[region]]
name = "local DRAM"
base = 0x300000
words = 0x100000
bus = "local"
read_waits = 1
write_waits = 2
page_waits = 3
[[region]]
name = "global SRAM"
base = 0x80000000
words = 0x100000
bus = "global"
waits = 1
"""
    + WINDOWS,
    "small.toml": """
clock_mhz = 60
[[region]]
name = "local SRAM"
base = 0x300000
words = 0x10000
bus = "local"
"""
    + WINDOWS,
}
LAYOUTS = {
    "posts.toml": """
[[posts]]
x_m = 30.0
y_m = 12.0
radius_m = 0.4
[[movers]]
path = [[0, 30, 2], [12, 30, 14]]
repeats = true
[agv]
protective_field = true
""",
    "low.toml": """
deck_m = 3.909
[home]
x_m = 0.0
y_m = 23.9
z_m = 7.2
[[containers]]
x_m = 0.0
y_m = 24.0
[[containers]]
x_m = 18.0
y_m = 24.0
mass_kg = 30000
[[boxes]]
x_m = [-40, -38]
y_m = [0, 2]
z_m = [0, 3]
""",
}


def files_of_users(directory: Path) -> Path:
    """The DSP programs with `USER_KERNELS` in them; beside them boards and layouts."""
    shutil.copytree(ROOT / "c40_programs", directory, dirs_exist_ok=True)
    (directory / "kernels" / "user.asm").write_text(USER_KERNELS)
    for name, text in (BOARDS | LAYOUTS).items():
        (directory / name).write_text(text)
    return directory
