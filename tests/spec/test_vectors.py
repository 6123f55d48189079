"""Our own single-step vectors: they come from the specification, cover every encoding, and the emulator passes them."""

import lzma
import subprocess
from collections import Counter
from functools import cache
from pathlib import Path

from cmrc._core import isa

from spec.encodings import encodings
from spec.vectors import vectors_of

FILE = Path(__file__).parent / "data" / "c40-vectors.txt.xz"
SEED = 1


@cache
def lines() -> list[str]:
    with lzma.open(FILE, "rt") as text:
        return text.read().splitlines()


def word_of(line: str) -> int:
    return int(line[line.index(" op=") + 4 :][:8], 16)


def test_the_emulator_passes_every_vector_access_by_access(emulator: Path) -> None:
    result = subprocess.run([emulator, "vectors", "--every-access", FILE], capture_output=True, text=True, check=False)
    assert (result.returncode, result.stdout) == (0, f"{len(lines())} passed, 0 failed\n"), result.stdout


def test_every_row_of_the_instruction_table_has_at_least_100_vectors_and_every_mode_some() -> None:
    """The table is the emulator's, the encodings are the specification's: neither knows the other."""
    rows = isa.rows()
    by_row: Counter[int] = Counter()
    by_mode: Counter[tuple[int, int]] = Counter()
    for line in lines():
        word = word_of(line)
        decoded = isa.decode(word)
        assert decoded is not None, f"{word:08X}: {isa.reserved_reason(word)}"
        by_row[decoded["row"]] += 1
        by_mode[decoded["row"], word >> 21 & 3] += 1
    assert {n: by_row[n] for n in range(len(rows)) if by_row[n] < 100} == {}
    for number, row in enumerate(rows):
        if "gg" in row["picture"] or "tt" in row["picture"]:
            for mode in range(4):
                assert (by_mode[number, mode] > 0) == bool(row["modes"] >> mode & 1), (row["mnemonic"], mode)


def test_every_way_of_indirect_addressing_and_every_condition_occurs() -> None:
    words = [word_of(line) for line in lines()]
    general = Counter(w >> 11 & 31 for w in words if w >> 29 == 0 and w >> 21 & 3 == 2 and w >> 23 & 63 != 12)
    assert set(general) == set(range(26))
    assert {w >> 11 & 31 for w in words if w >> 30 == 3} == set(range(26))
    assert {w >> 3 & 31 for w in words if w >> 30 == 3} == set(range(26))
    for group in ((w >> 23 & 31 for w in words if w >> 29 == 2), (w >> 16 & 31 for w in words if w >> 27 == 13)):
        assert set(group) == set(range(21)) - {11}


def test_the_file_is_what_the_specification_gives() -> None:
    """The first two of every encoding; `make vectors` writes the others again."""
    written = set(lines())
    for encoding in encodings():
        for line in vectors_of(encoding, 2, SEED):
            assert line in written, line
