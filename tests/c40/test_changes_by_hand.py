"""Registers and memory that are changed from outside, between instructions."""

from __future__ import annotations

import pytest
from cmrc import c40

CACHE = "start: or 800h,st\n xor 400h,st\n xor 400h,st\n xor 400h,st\n nop\n nop\nend: b end\n"


@pytest.mark.parametrize("steps", range(5))
def test_st_can_be_changed_as_often_as_one_likes(steps: int) -> None:
    """However many changes of CE, CF and CC are still in the pipeline; the last value counts."""
    chip = c40.Processor(c40.assemble(CACHE))
    for _ in range(steps):
        chip.step()
    for value in (0xC00, 0x800, 0xC00, 0x800, 0x1800, 0x1800, 0x1800, 0x400):
        chip.registers["ST"] = value
    assert chip.registers["ST"] == 0x400
    assert chip.run(100, until="end").reason == "until"


def test_a_flat_board_that_is_full_says_so() -> None:
    chip = c40.Processor(c40.assemble("end: b end\n"), board="flat")
    with pytest.raises(
        IndexError, match=r"address [0-9A-F]{8}h: more than the 256 MiB of RAM that board flat may take"
    ):
        for n in range(3000):
            chip.memory[(n * 0x123457) & 0xFFFFFFFF] = n
