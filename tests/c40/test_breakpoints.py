"""A breakpoint in a loop stops each round, however the loop is run: by blocks that follow each other, or one
instruction at a time."""

from itertools import pairwise

import pytest
from cmrc._core import c40, toolchain

LOOPS = {
    "branch": "        ldi 9,ar0\nhere:   addi 1,r0\n        db ar0,here\nend:    bu end\n",
    "delayed branch": "        ldi 9,ar0\nhere:   addi 1,r0\n        dbd ar0,here\n        nop\n        nop\n        nop\nend:    bu end\n",
    "repeated block": "        ldi 9,rc\n        rptb last\nhere:   addi 1,r0\nlast:   nop\nend:    bu end\n",
    "repeated block of one word": "        ldi 9,rc\n        rptb here\nhere:   addi 1,r0\nend:    bu end\n",
    "inside": "        ldi 9,ar0\nback:   nop\nhere:   addi 1,r0\n        db ar0,back\nend:    bu end\n",
}
ROUNDS = 10


@pytest.mark.parametrize("exact", [False, True], ids=["blocks", "exact"])
@pytest.mark.parametrize("loop", LOOPS)
def test_a_breakpoint_stops_each_round(loop: str, exact: bool) -> None:
    image = toolchain.assemble(f"        .text\nstart:\n{LOOPS[loop]}", "loop.asm", sections={".text": 0x2FFC00})
    chip = c40.Processor("default")
    chip.load_image(image)
    chip.set_exact(exact)
    chip.add_breakpoint(image.symbols["here"])
    rounds = []
    while chip.run(1000)["reason"] == "breakpoint":
        assert chip.pc == image.symbols["here"]
        rounds.append(chip.get("R0") & 0xFFFFFFFF)
    assert rounds == list(range(ROUNDS))


@pytest.mark.parametrize("exact", [False, True], ids=["blocks", "exact"])
def test_a_breakpoint_at_a_branch_to_itself_stops_each_round(exact: bool) -> None:
    image = toolchain.assemble("        .text\nstart:  nop\nend:    bu end\n", "end.asm", sections={".text": 0x2FFC00})
    chip = c40.Processor("default")
    chip.load_image(image)
    chip.set_exact(exact)
    chip.add_breakpoint(image.symbols["end"])
    cycles = []
    for _ in range(6):
        assert chip.run(1000)["reason"] == "breakpoint"
        cycles.append(chip.cycle)
    assert [after - before for before, after in pairwise(cycles)] == [4] * 5  # of a branch (c40-hardware.md 7.2)


def test_where_one_run_ends_no_other_does_but_at_a_breakpoint_of_its_own() -> None:
    image = toolchain.assemble("        .text\nstart:  nop\nend:    bu end\n", "end.asm", sections={".text": 0x2FFC00})
    chip, end = c40.Processor("default"), image.symbols["end"]
    chip.load_image(image)
    for _ in range(3):
        assert chip.run(1000, until=end)["reason"] == "breakpoint"
        assert chip.run(1000)["reason"] == "limit"
        assert chip.run(1000, until=end)["reason"] == "breakpoint"
        assert len(chip.trace(40)) == 10  # branches of 4 cycles
    chip.add_breakpoint(end)
    assert chip.run(1000, until=end)["reason"] == "breakpoint"
    assert chip.run(1000)["reason"] == "breakpoint"
    chip.remove_breakpoint(end)
    assert chip.run(1000)["reason"] == "limit"
    chip.run(1000, until=end)
    chip.add_breakpoint(end)
    chip.remove_breakpoint(end)
    assert chip.run(1000, until=end)["reason"] == "breakpoint"
