"""A store that walks into words that have been executed, as the last instruction of a repeated block: the block is left
after it, and what follows is timed from there. Blocks and the exact engine, which asks the pipeline model about every
instruction, agree."""

import pytest
from cmrc._core import c40, toolchain


def outcome(size: int, walk: int, at: int, exact: bool) -> tuple[int, int, dict[str, int]]:
    text = f"""        .text
        .space  8
start:  ldhi    hi16(start - {walk}), ar0
        or      lo16(start - {walk}), ar0
        ldhi    hi16({at:x}h), ar1
        or      lo16({at:x}h), ar1
        ldi     9, rc
        rptb    last
{"        addi    1, r2" + chr(10) if size > 1 else ""}{("        ldi     *ar1, r1" + chr(10)) * (size - 2)}last:   sti     r0, *ar0++
        ldi     *ar1, r3
        addi    r3, r4
        ldi     *ar1, r5
done:   b       done
"""
    image = toolchain.assemble(text, "walk.asm", sections={".text": at})
    chip = c40.Processor("default")
    chip.load_image(image)
    chip.pc = image.symbols["start"]
    chip.set_exact(exact)
    chip.run(200)
    return chip.cycle, chip.instructions, {cause: cycles for cause, cycles in chip.causes.items() if cycles}


@pytest.mark.parametrize("size", range(1, 9))
@pytest.mark.parametrize("at", [0x2FFC00, 0x300000, 0x80000000])
def test_a_block_left_after_its_last_instruction_continues_as_the_exact_engine_does(at: int, size: int) -> None:
    for walk in range(2, 8):
        assert outcome(size, walk, at, exact=False) == outcome(size, walk, at, exact=True), walk
