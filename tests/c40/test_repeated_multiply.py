"""RPTS of a multiply-accumulate runs as one function: it must do what the instruction does one at a time."""

import random

import pytest
import small_programs

DATA = small_programs.DATA
SHAPES = {
    "circular": "        mpyf3 *ar0++(1)%,*ar1++(1)%,r0\n||      addf3 r0,r2,r2\n",
    "straight": "        mpyf3 *ar0++(1),*ar1++(1),r1\n||      addf3 r3,r1,r3\n",
}
EDGES = [
    0x80000000,
    0x00000000,
    0x7F7FFFFF,
    0x7F800000,
    0x817FFFFF,
    0x81000000,
    0x80FFFFFF,
    0x3F000000,
    0x40800000,
    0xC0000001,
]
STATE = ("R0", "R1", "R2", "R3", "AR0", "AR1", "RC", "RS", "RE", "ST")


def run(
    shape: str,
    passes: int,
    words: list[int],
    registers: dict[str, int],
    exact: bool,
    at: int = DATA,
    board: str = "default",
) -> tuple[dict[str, int], dict[str, int], int]:
    processor, image = small_programs.load(f"        rpts r5\n{SHAPES[shape]}stop:   bu stop\n", board)
    processor.set_exact(exact)
    for i, word in enumerate(words):
        processor.poke(at + i, word)
    for name, value in {"R5": passes - 1, **registers}.items():
        processor.set(name, value)
    for _ in range(2):  # the first time the block is recorded, the second time it runs
        processor.pc = image.symbols["stop"] - 2
        processor.run(5000, until=image.symbols["stop"])
    return {name: processor.get(name) for name in STATE}, processor.causes, processor.cycle


def float40(rng: random.Random) -> int:
    return rng.choice(
        [0x8000000000, 0x7F7FFFFFFF, 0x7F80000000, 0x8180000000, 0x8100000000, rng.getrandbits(40), rng.getrandbits(40)]
    )


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("seed", range(40))
def test_the_same_as_one_at_a_time(shape: str, seed: int) -> None:
    rng = random.Random(seed)
    length = rng.choice([1, 2, 3, 7, 8, 63, 64])
    words = [
        rng.choice(EDGES) if rng.random() < 0.3 else (rng.randint(-10, 10) & 0xFF) << 24 | rng.getrandbits(24)
        for _ in range(512)
    ]
    if seed % 4 == 0:  # the whole range of exponents: overflow and underflow on the way
        words = [rng.getrandbits(32) for _ in range(512)]
    registers = {
        "R0": float40(rng), "R1": float40(rng), "R2": float40(rng), "R3": float40(rng), "BK": length,
        "AR0": DATA + rng.randrange(length), "AR1": DATA + 256 + rng.randrange(length), "ST": rng.choice([0, 0x60, 0x800A]),
    }  # fmt: skip
    passes = rng.choice([1, 2, 5, 64, 100])
    assert run(shape, passes, words, registers, exact=False) == run(shape, passes, words, registers, exact=True)


@pytest.mark.parametrize("registers", [
    {"BK": 0}, {"BK": 5, "AR0": DATA + 6}, {"BK": 5, "AR0": DATA + 7},  # no buffer; pointers behind it
    {"BK": 0x7FFFFFFF}, {"BK": 2000},  # longer than the RAM
    {"AR0": DATA + 0x3F0}, {"AR0": DATA + 0x7F0, "BK": 16},  # into the other block, and out of RAM
])  # fmt: skip
@pytest.mark.parametrize("shape", SHAPES)
def test_what_it_cannot_do_is_left_to_the_instruction(shape: str, registers: dict[str, int]) -> None:
    words = [0x01000000 + i for i in range(600)]
    given = {"AR0": DATA, "AR1": DATA + 256, "BK": 8, **registers}
    assert run(shape, 40, words, given, exact=False, board="flat") == run(
        shape, 40, words, given, exact=True, board="flat"
    )


@pytest.mark.parametrize("shape", SHAPES)
def test_flags_that_are_set_from_outside_between_two_passes_are_cleared_by_the_next(shape: str) -> None:
    ends = []
    for exact in (False, True):
        processor, image = small_programs.load(f"        rpts r5\n{SHAPES[shape]}stop:   bu stop\n")
        processor.set_exact(exact)
        for n in range(512):
            processor.poke(DATA + n, 0x01000000 + n)
        for name, value in {"R5": 99, "AR0": DATA, "AR1": DATA + 256, "BK": 8}.items():
            processor.set(name, value)
        for _ in range(2):
            processor.pc = image.symbols["stop"] - 2
            processor.run(40, until=image.symbols["stop"])
            processor.set("ST", processor.get("ST") | 0xF)
            processor.run(5000, until=image.symbols["stop"])
        ends.append({name: processor.get(name) for name in STATE})
    assert ends[0] == ends[1]
    assert ends[0]["ST"] & 0xF == 1  # C is not among them
