"""The sequences with exact counts of c40-hardware.md 7.6, on chip and on the external buses; the counts are the
document's."""

import pytest
import small_programs

BLOCK0, BLOCK1 = 0x2FF900, 0x2FFE00  # data; code lies at the start of block 1
LOCAL, SLOW, GLOBAL = 0x300000, 0x40000000, 0x80000000

# number, instructions, registers, cycles. Code is in block 1 and data in block 0 unless the case says otherwise.
CASES = [
    (1, "addf r0,r1 / mpyf r2,r3 / subi r4,r5", {}, 3),
    (2, "br go / nop / nop / nop / go:", {}, 4),
    (3, "brd go / nop / nop / nop / nop / go:", {}, 4),
    (4, "ldi 5,ar0 / ldf *ar0,r0", "flat", 4),
    (5, "ldi 5,ar0 / nop / ldf *ar0,r0", "flat", 4),
    (6, "ldi 5,ar0 / nop / nop / ldf *ar0,r0", "flat", 4),
    (7, "lda *ar3,ar0 / ldf *ar0,r0", "flat", 3),
    (8, "lda *ar3,ar0 / nop / ldf *ar0,r0", "flat", 3),
    (9, "addi ar0,r1 / ldf *ar0,r0", {"AR0": BLOCK0}, 3),
    (10, "ldi 5,ar1 / ldf *ar0,r0", {"AR0": BLOCK0}, 2),
    (11, "ldf *ar0++,r0 / ldf *ar0++,r1", {"AR0": BLOCK0}, 2),
    (12, "ldpk 2fh / ldi @0f900h,r0", {}, 2),
    (13, "ldi 2fh,dp / ldi @0f900h,r0", {}, 4),
    (14, "stf r0,*ar1 / ldf *ar2,r1 || ldf *ar3,r2", {"AR1": BLOCK0, "AR2": BLOCK0 + 1, "AR3": BLOCK0 + 2}, 3),
    (15, "stf r0,*ar1 / ldf *ar2,r1 || ldf *ar3,r2", {"AR1": BLOCK1, "AR2": BLOCK0 + 1, "AR3": BLOCK0 + 2}, 2),
    (16, "stf r0,*ar1 || stf r3,*ar2 / ldf *ar3,r1", {"AR1": BLOCK0, "AR2": BLOCK0 + 1, "AR3": BLOCK0 + 2}, 3),
    (17, "stf r0,*ar1 || stf r3,*ar2 / ldf *ar3,r1", {"AR1": BLOCK0, "AR2": BLOCK1, "AR3": BLOCK0 + 2}, 2),
    (
        18,
        "stf r0,*ar1 || stf r3,*ar2 / ldf *ar3,r1 || ldf *ar4,r2",
        {"AR1": BLOCK0, "AR2": BLOCK0 + 1, "AR3": BLOCK0 + 2, "AR4": BLOCK0 + 3},
        3,
    ),
    (19, "addf3 *ar0,*ar1,r0 / nop / nop / nop / nop", {"AR0": BLOCK1, "AR1": BLOCK1 + 1}, 6),
    (19, "addf3 *ar0,*ar1,r0 / nop / nop / nop / nop", {"AR0": BLOCK0, "AR1": BLOCK0 + 1}, 5),
    (20, " / ".join(["addf3 *ar0,*ar1,r0"] * 8 + ["nop"] * 4), {"AR0": BLOCK1, "AR1": BLOCK1 + 1}, 20),
    (20, " / ".join(["addf3 *ar0,*ar1,r0"] * 8 + ["nop"] * 4), {"AR0": BLOCK0, "AR1": BLOCK0 + 1}, 12),
    (21, "ldi *ar0,r0 / ldi *ar1,r1 / ldi *ar2,r2", {"AR0": LOCAL, "AR1": LOCAL, "AR2": LOCAL}, 3),
    (22, "sti r0,*ar0 / sti r1,*ar1 / sti r2,*ar2", {"AR0": LOCAL, "AR1": LOCAL, "AR2": LOCAL}, 5),
    (23, "sti r0,*ar0 / ldi *ar1,r1", {"AR0": LOCAL, "AR1": LOCAL + 1}, 5),
    (24, "sti r0,*ar0 / ldi *ar1,r1", {"AR0": LOCAL, "AR1": GLOBAL}, 2),
    (25, "ldf *ar0,r0 || ldf *ar1,r1", {"AR0": LOCAL, "AR1": LOCAL + 1}, 2),
    (25, "ldf *ar0,r0 || ldf *ar1,r1", {"AR0": LOCAL, "AR1": GLOBAL}, 1),
    (25, "ldf *ar0,r0 || ldf *ar1,r1", {"AR0": BLOCK0, "AR1": BLOCK0 + 1}, 1),
    (26, "ldi *ar1,r1 / sti r0,*ar0", {"AR0": LOCAL, "AR1": LOCAL + 1}, 2),
    (27, "rpts 63 / mpyf3 *ar0++,*ar1++,r0 || addf3 r0,r2,r2", {"AR0": BLOCK0, "AR1": BLOCK0 + 64}, 68),
    (28, "ldi 9,rc / rptb l / addi 1,r0 / l: addi 1,r1", {}, 25),
    (29, "ldi 9,rc / rptbd l / nop / nop / nop / addi 1,r0 / l: addi 1,r1", {}, 25),
    (30, "call f / br go / f: rets / go:", {}, 8 + 4),
    (31, "laj f / nop / nop / nop / br go / f: bud r11 / nop / nop / nop / go:", {}, 8 + 4),
    (32, "l: addi 1,r0 / dbd ar0,l / nop / nop / nop", {"AR0": 9}, 50),
    (33, "l: addi 1,r0 / addi 1,r1 / addi 1,r2 / addi 1,r3 / db ar0,l", {"AR0": 9}, 80),
    (
        34,
        (
            "call f / br go / f: mpyf3 *ar0++,*ar1++,r0 / ldf 0.0,r2 / rpts 14 /"
            " mpyf3 *ar0++,*ar1++,r0 || addf3 r0,r2,r2 / addf r0,r2 / rets / go:"
        ),
        {"AR0": BLOCK0, "AR1": BLOCK0 + 64},
        4 + (11 + 15) + 4,
    ),
]


def assembly(text: str) -> str:
    lines = []
    for part in text.split(" / "):
        label, colon, rest = part.partition(":")
        lines.append(f"{label.strip()}: {rest.strip()}" if colon else f"        {part.strip()}")
    return "\n".join(lines + ["stop:   nop", "        nop", ""]).replace("|| ", "\n||      ")


@pytest.mark.parametrize("exact", [True, False])
@pytest.mark.parametrize(("number", "text", "registers", "cycles"), CASES)
def test_sequence_takes_its_cycles(number: int, text: str, registers: object, cycles: int, exact: bool) -> None:
    flat = registers == "flat"
    processor, image = small_programs.load(
        assembly(text), "flat" if flat else "default", 0x1000 if flat else small_programs.CODE
    )
    processor.set_exact(exact)
    if isinstance(registers, dict):
        for name, value in registers.items():
            processor.set(name, value)
    if flat:
        processor.set("AR3", 0x2000)
    # What follows must not begin before the sequence is over: the sequence's own branches lead to `stop`.
    stop = image.symbols["stop"]
    result = processor.run(10000, until=stop)
    assert result["reason"] == "breakpoint", result
    assert processor.cycle == cycles
    assert small_programs.consistent(processor)


def test_wait_states_of_a_slow_region() -> None:
    """c40-hardware.md 8.2 for one wait state: a read takes 2, a write occupies the bus for 3."""
    processor, image = small_programs.load(
        "        ldi *ar0,r0\n        ldi *ar0,r1\n        ldi *ar0,r2\nstop:   nop\n"
    )
    processor.set("AR0", SLOW)
    processor.run(100, until=image.symbols["stop"])
    assert (processor.cycle, processor.causes["wait_state"]) == (6, 3)
    processor, image = small_programs.load(
        "        sti r0,*ar0\n        sti r1,*ar0\n        sti r2,*ar0\nstop:   nop\n"
    )
    processor.set("AR0", SLOW)
    processor.run(100, until=image.symbols["stop"])
    assert (processor.cycle, processor.causes["memory_conflict"]) == (7, 4)
