"""Words that cover every row of the instruction table and every form of every operand, made from the rows' bit
pictures."""

import functools
import random
from collections.abc import Iterator

from cmrc._core import isa

Row = dict[str, object]


def fields(row: Row) -> dict[str, tuple[int, int]]:
    """Letter: (shift, width); without the unused bits (z)."""
    picture = str(row["picture"]).replace(" ", "")
    letters = [letter for letter in dict.fromkeys(picture) if letter.isalpha() and letter != "z"]
    return {letter: (31 - picture.rindex(letter), picture.count(letter)) for letter in letters}


def indirect_operands() -> list[int]:
    """The 16-bit field of general addressing: every modn with the displacements that matter, every ARn."""
    out = [modn << 11 | ar << 8 | disp for modn in range(8) for ar in (0, 3, 7) for disp in (0, 1, 2, 127, 128, 255)]
    return out + [modn << 11 | ar << 8 for modn in range(8, 26) for ar in range(8)]


def values(letter: str, width: int, rng: random.Random) -> list[int]:
    """All values of a narrow field; of a wide one corners, and every form that its bits can have."""
    if width <= 8:
        return list(range(1 << width))
    top = (1 << width) - 1
    corners = {0, 1, 2, top, top - 1, top >> 1, (top >> 1) + 1, *(1 << bit for bit in range(width))}
    if letter == "s":
        corners.update(indirect_operands())
        corners.update(range(32))
    return sorted(corners | {rng.getrandbits(width) for _ in range(16)})


def of_row(row: Row, rng: random.Random, cpu: str) -> Iterator[int]:
    """Each field through its values, the others at random, until the word is legal."""
    places = fields(row)
    if not places:
        yield int(row["match"])  # type: ignore[call-overload]
    for letter, (shift, width) in places.items():
        others = [place for other, place in places.items() if other != letter]
        modes = range(4) if "g" in places and letter == "s" else [None]
        for value in values(letter, width, rng):
            for mode in modes:
                for _ in range(12):
                    word = int(row["match"]) | value << shift  # type: ignore[call-overload]
                    word |= sum(legal_like(rng, w) << s for s, w in others)
                    if mode is not None:
                        word = word & ~(3 << 21) | mode << 21
                    decoded = isa.decode(word, cpu)
                    if decoded is not None:
                        yield word
                        break


def legal_like(rng: random.Random, width: int) -> int:
    """Random, but often a small number: registers, modes and conditions are."""
    return rng.getrandbits(width) if width < 9 or rng.random() < 0.5 else rng.getrandbits(5)


def filled(words: set[int]) -> set[int]:
    """Compares of type 2 whose unused field holds something."""
    compares = sorted(word for word in words if word >> 23 in (0x33000000 >> 23, 0x33800000 >> 23, 0x37800000 >> 23))
    return {word | n << 16 for word in compares[::40] for n in (1, 7, 16, 31)}


@functools.cache
def every_form(seed: int = 40, cpu: str = "c40") -> list[int]:
    rng = random.Random(seed)
    words = {word for row in isa.rows(cpu) for word in of_row(row, rng, cpu)}
    return sorted(words | filled(words) if cpu == "c40" else words)
