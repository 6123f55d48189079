"""Sequences that c40-hardware.md 7.6 does not count: computed by hand from c40-hardware.md 7.1 to 7.5, and drawn
(drawings.py)."""

import drawn_accesses
import drawn_hazards
import pytest
import small_programs
from drawings import B0, LOCAL, WAIT, Case, load, parse

# 4 cycles, then what a pass costs
REPEATS = [
    Case(
        "a pass of RPTS reads and writes one block: 1 + 4 + 10",
        "ldf *ar0++,r0 / rpts 9 / ldf *ar0++,r0 || stf r0,*ar1++",
        15,
        {"AR0": B0, "AR1": B0 + 32},
    ),
    Case("RPTS of a read without wait states: 4 + 4", "rpts 3 / ldi *ar0++,r0", 8, {"AR0": LOCAL}),
    Case("with one: 4 + 4 x 2", "rpts 3 / ldi *ar0++,r0", 12, {"AR0": WAIT}),
    Case(
        "of a write: each waits for the one before; nothing waits for the last: 4 + 4 x 2 - 1",
        "rpts 3 / sti r0,*ar0++",
        11,
        {"AR0": LOCAL},
    ),
    Case(
        "a store and two loads of its block in a loop: 1 + 4 + 3 x 3",
        "ldi 2,rc / rptb l / stf r0,*ar0 / l: ldf *ar1,r1 || ldf *ar2,r2",
        14,
        {"AR0": B0, "AR1": B0 + 1, "AR2": B0 + 2},
    ),
    Case(
        "two stores at a loop's end, two loads at its begin: 1 + 4 + 3 x 3 and 2 between the passes",
        "ldi 2,rc / rptb l / ldf *ar1,r1 || ldf *ar2,r2 / nop / l: stf r0,*ar0 || stf r1,*ar3",
        16,
        {"AR0": B0, "AR1": B0 + 1, "AR2": B0 + 2, "AR3": B0 + 3},
    ),
]
CASES = [*drawn_hazards.CASES, *drawn_accesses.CASES, *REPEATS]


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.why)
def test_count(case: Case, exact: bool) -> None:
    processor, stop = load(case, exact)
    result = processor.run(10000, until=stop)
    assert result["reason"] == "breakpoint", result
    assert processor.cycle == case.cycles
    assert small_programs.consistent(processor)


@pytest.mark.parametrize("case", [case for case in CASES if parse(case)[1]], ids=lambda case: case.why)
def test_stages_are_where_they_were_drawn(case: Case) -> None:
    processor, _ = load(case, True)
    records = processor.trace(case.cycles)
    drawn = parse(case)[1]
    assert len(records) >= len(drawn)
    for (cells, text), record in zip(drawn, records, strict=False):
        assert dict(zip("FDRE", record["stages"], strict=True)) == {
            letter: cells.index(letter) - 3 for letter in "FDRE"
        }, text


def test_what_is_drawn_ends_with_the_count() -> None:
    """Of drawings that show all: the last E is the last cycle, or a branch's, which takes 3 more."""
    for case in CASES:
        rows = parse(case)[1]
        if not rows:
            continue
        last, text = rows[-1]
        assert case.cycles == last.rindex("E") - 3 + (4 if text.startswith("br ") else 1), case.why
