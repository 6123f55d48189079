"""How many words are what, against counts by the formats of the reference; the sweep over all 2^32 is a campaign."""

import re
import subprocess
from pathlib import Path

import pytest
from cmrc._core import isa

INDIRECT_8 = 26 * 8  # modn, ARn
INDIRECT_16 = 8 * 8 * 256 + 18 * 8  # with a displacement or without
GENERAL_INTEGER = 32 * (32 + 65536 + INDIRECT_16 + 65536)
GENERAL_FLOAT = 12 * (12 + 65536 + INDIRECT_16 + 65536)


def classify(emulator: Path, first: int, count: int) -> dict[str, int]:
    done = subprocess.run(
        [emulator, "classify", "--range", f"{first:#x}:{count}"], capture_output=True, text=True, check=True
    )
    return {
        re.sub(r" of \d+ encodings", "", name): int(number)
        for number, name in re.findall(r"^ *(\d+) +(.*)$", done.stdout, re.MULTILINE)
    }


@pytest.mark.parametrize(
    ("first", "count", "instructions"),
    [
        (
            0xC8000000,
            1 << 25,
            8 * 8 * INDIRECT_8**2,
        ),  # ABSF || STF: two registers of eight, two addresses (c40-isa.md 3.6)
        (0xCC000000, 1 << 25, 8**3 * INDIRECT_8**2),  # ADDF3 || STF: three registers
        (0x80000000, 1 << 24, 4 * 8 * 8 * INDIRECT_8**2),  # MPYF3 || ADDF3: two bits for the destinations
        (0x50800000, 1 << 23, GENERAL_INTEGER),  # LDILO (c40-isa.md 3.5)
        (0x40800000, 1 << 23, GENERAL_FLOAT),  # LDFLO
        (0x55800000, 1 << 23, 0),  # condition 11
        (0xBD000000, 1 << 24, 0),  # MH2, MH3
        (0x90000000, 1 << 25, 0),
        (0x02000000, 1 << 23, GENERAL_INTEGER),  # ADDI
        (0x21000000, 1 << 23, 32 * (32 * 32 + 2 * 32 * INDIRECT_8 + INDIRECT_8**2)),  # ADDI3, type 1 (c40-isa.md 3.4)
        (0x31000000, 1 << 23, 32 * (32 * 256 + 32 * 256 + 256 * 256 + 256 * 256)),  # ADDI3, type 2
        (
            0x33000000,
            1 << 23,
            32 * (12 * 256 + 256 * 256),
        ),  # CMPF3, type 2: no immediates; nothing reads the field of the destination
        (0x23000000, 1 << 23, 12 * 12 + 2 * 12 * INDIRECT_8 + INDIRECT_8**2),  # CMPF3, type 1: 0 is required there
        (0x60000000, 1 << 24, 1 << 24),  # BR
        (0x74000000, 1 << 24, 2 * 20 * 512),  # TRAPcond, LATcond
        (0x1E800000, 1 << 23, 13 * (32 - 1 + 65536 + INDIRECT_16 + 65536)),  # LDA: 13 destinations, not from itself
    ],
)
def test_words_of_a_group_are_counted_as_its_format_has_them(
    emulator: Path, first: int, count: int, instructions: int
) -> None:
    counts = classify(emulator, first, count)
    assert (counts["words"], counts["instructions"], counts["reserved"]) == (count, instructions, count - instructions)
    assert counts["suit more than one encoding"] == 0


def test_no_two_rows_suit_one_word() -> None:
    rows = isa.rows()
    for i, a in enumerate(rows):
        for b in rows[:i]:
            if (a["match"] ^ b["match"]) & a["mask"] & b["mask"] == 0:
                assert a["modes"] & b["modes"] == 0, (a["mnemonic"], b["mnemonic"])


def test_a_faulty_range_is_refused(emulator: Path) -> None:
    for text in ("5", "x:1", "0:z"):
        done = subprocess.run([emulator, "classify", "--range", text], capture_output=True, text=True, check=False)
        assert done.returncode == 2 and "--range" in done.stderr
