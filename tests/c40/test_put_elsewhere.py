"""A chip that is stopped anywhere in its code and put elsewhere continues there: what was known of the code around
is forgotten."""

from typing import Any

from cmrc import c40 as package
from cmrc._core import c40

LOOP = (
    "        .text\nstart:  ldi 20,ar3\nl:\n"
    + "".join(f"        addi 1,r{n % 8}\n" for n in range(16))
    + "        dbu ar3,l\nend:    bu end\n"
)
OTHER = "other:\n" + "".join(f"        addi {3 + n},r{n % 8}\n" for n in range(16)) + "end2:   bu end2\n"


def test_a_chip_that_is_put_elsewhere_in_the_middle_of_a_block_continues_there() -> None:
    image = package.assemble(LOOP + OTHER)

    def moved(cycles: int, exact: bool) -> Any:
        chip = c40.Processor()
        chip.load_image(image)
        chip.set_exact(exact)
        chip.run(cycles)
        chip.pc = image.symbols["other"]
        chip.run(9)
        return chip.snapshot(), chip.digest()

    for cycles in range(1, 100):
        assert moved(cycles, exact=False) == moved(cycles, exact=True), cycles
