"""The decoder against words that the GNU tools assembled and disassembled, and against the reserved patterns of the
reference."""

import re
from pathlib import Path

import pytest
from cmrc._core import isa

ENCODINGS = [
    (int(address, 16), int(word, 16), text)
    for address, word, text in (
        line.split(maxsplit=2)
        for line in (Path(__file__).parent / "encodings.txt").read_text().splitlines()
        if not line.startswith("#")
    )
]


def normal_form(text: str) -> str:
    """Numbers in one spelling; LDP spelt as the instruction that it is; L0 is address 0.

    GNU shows the immediates of SUBC and MPYUHI signed; the chip zero-extends them (c40-isa.md 10.6, 10.15).
    """
    text = re.sub(r"^(subc|mpyuhi) (-\d+),", lambda m: f"{m[1]} {int(m[2]) % 65536},", text)
    text = re.sub(r"^ldp (.*)$", r"ldiu \1,dp", text.strip())
    text = re.sub(r"\bL0\b", "0", text)
    text = re.sub(r"\b0x[0-9a-f]+\b|(?<![.\w])-?\d+(?![.\w])", lambda m: str(int(m.group(0), 0)), text)
    return re.sub(r"\s+", " ", text)


def test_there_are_596_verified_encodings() -> None:
    assert len(ENCODINGS) == 596


def test_words_of_the_gnu_tools_disassemble_to_their_source() -> None:
    assert not {
        f"{address:03x}: {word:08x}": (ours, text)
        for address, word, text in ENCODINGS
        if normal_form(ours := isa.disassemble(word, address)) != normal_form(text)
    }


@pytest.mark.parametrize(
    ("word", "reason"),
    [
        (0x90000000, "operation"),  # groups 1001 and 1010
        (0xA0000000, "operation"),
        (0x10800000, "operation"),  # LOPOWER and MAXSPEED of low-power C3x parts
        (0x10800001, "operation"),
        (0x16000000, "operation"),  # SIGI without operands, C3x
        (0x06000002, "operation"),  # beside IDLE and IDLE2
        (0x0C800001, "operation"),  # NOP with a source register
        (0x67000000, "operation"),
        (0x29800000, "operation"),  # three-operand op5 19
        (0xF4000000, "operation"),  # parallel op5 26
        (0xBD000000, "operation"),  # MH2, which GNU's table has and the chip has not
        (0xB6E00000 | 0x0A000000, "operation"),  # LHU group's neighbour 1011 111xx
        (0x30801C1D, "operation"),  # ADDF3 with an 8-bit immediate (type 2, T = 00)
        (0x20008000, "must be 0"),  # register byte of a three-operand word, bits 7..5
        (0x08000020, "must be 0"),  # LDI with register code 32
        (0x23000001 | 1 << 16, "operation"),  # CMPF3 with a destination
        (0x01800008, "register"),  # ADDF AR0,R0
        (0x01880000, "register"),  # ADDF R0,AR0
        (0x1E800000, "register"),  # LDA R0,R0
        (0x1E950000, "register"),  # LDA R0,ST
        (0x1E880008, "itself"),  # LDA AR0,AR0
        (0x0840D000, "26 to 31"),  # LDI *<modn 26>
        (0x08404201, "displacement"),  # LDI *+AR2(IR0) with a displacement
        (0x0840C101, "displacement"),  # LDI *AR1 with a displacement
        (0x6A0B0000, "conditions"),
        (0x55800000, "conditions"),  # LDIcond 11
        (0x6A150000, "conditions"),
        (0x760D0002, "expansion"),  # LDEP of expansion register 2
        (0x76820000, "expansion"),
        (0x6B000000, "operation"),  # Bcond with bit 24
        (0x6A400000, "operation"),  # Bcond type 010
        (0x78A00000, "operation"),  # RETScondD
        (0x74000200, "operation"),  # trap number of 10 bits
        (0x800000D0, "26 to 31"),  # MPYF3 || ADDF3 with the later chips' register byte
        (0xD90E0000 | 1 << 19, "operation"),  # LDF || STF with a src1 field
    ],
)
def test_reserved_words_are_reported_with_their_reason(word: int, reason: str) -> None:
    assert isa.decode(word) is None
    assert reason in isa.reserved_reason(word).lower()
    assert isa.disassemble(word) == f".word 0x{word:08x}"


def test_roles_of_subtract_and_its_reverse() -> None:
    """SUBI src,dst computes dst - src, SUBRI src - dst; src1 is the minuend of both."""
    subi, subri = isa.decode(0x18010002), isa.decode(0x19810002)
    assert subi["operation"] == subri["operation"] == "subi"
    assert (subi["src1"]["register"], subi["src2"]["register"], subi["dst"]["register"]) == ("r1", "r2", "r1")
    assert (subri["src1"]["register"], subri["src2"]["register"], subri["dst"]["register"]) == ("r2", "r1", "r1")


@pytest.mark.parametrize(
    ("word", "product", "second"),
    [  # mpyf3 || subf3 with J = *ar2, I = *ar1, K = r5, H = r4; the second half's (src3 - src4) by c40-isa.md 3.6
        (0x842CC2C1, {"*ar1", "*ar2"}, ("r5", "r4")),
        (0x852CC2C1, {"*ar2", "r5"}, ("*ar1", "r4")),
        (0x862CC2C1, {"r4", "r5"}, ("*ar2", "*ar1")),
        (0x872CC2C1, {"*ar2", "r5"}, ("r4", "*ar1")),
    ],
)
def test_roles_of_multiply_subtract(word: int, product: set[str], second: tuple[str, str]) -> None:
    def show(operand: dict[str, object]) -> str:
        return ("*" if operand["kind"] == "indirect" else "") + str(operand["register"])

    decoded = isa.decode(word)
    assert {show(decoded["src1"]), show(decoded["src2"])} == product
    assert (show(decoded["src3"]), show(decoded["src4"])) == second
    assert (decoded["dst"]["register"], decoded["dst2"]["register"]) == ("r0", "r2")


def test_relative_targets_count_from_one_or_three_words_on() -> None:
    assert isa.decode(0x60000000)["src1"]["value"] == 1
    assert isa.decode(0x61FFFFFF)["src1"]["value"] == 2
    assert isa.decode(0x6A00FFFF)["src1"]["value"] == 0
    assert isa.decode(0x6A60FFFD)["src1"]["value"] == 0
    assert isa.disassemble(0x6A00FFFF, 0x300000) == "bu 0x300000"
    assert isa.disassemble(0x60FFFFFE, 0) == "br 0xffffffff"
    assert isa.disassemble(0x6A00FFFF, 5, lambda address: "here" if address == 5 else "") == "bu here"


def test_hazards_name_the_registers_of_address_generation() -> None:
    """ADDF3 *AR5++(IR1),R9 reads through AR5 and IR1; circular modes use BK; direct ones DP; LDA writes early."""
    h = isa.decode(0x20BCA51D)["hazards"]  # addf3 r9... with *ar5++(ir1)
    assert set(h["address_reads"]) == {"ar5", "ir1"} and h["address_updates"] == ["ar5"] and h["memory_reads"] == 1
    h = isa.decode(0x08403103)["hazards"]  # ldi *ar1++(3)%,r0
    assert set(h["address_reads"]) == {"ar1", "bk"} and h["execute_writes"] == ["r0"]
    assert isa.decode(0x0832FFFF)["hazards"]["address_reads"] == ["dp"]
    assert isa.decode(0x1E8E0001)["hazards"]["read_writes"] == ["ar6"]
    assert isa.decode(0x1F700030)["hazards"]["decode_writes"] == ["dp"]
    h = isa.decode(0xC146B2C1)["hazards"]  # stf r5,*ar1 || stf r6,*ar2++(ir1)%
    assert (h["memory_reads"], h["memory_writes"]) == (0, 2)
    h = isa.decode(0x0CC02301)["hazards"]  # nop *ar3++(1)
    assert h["memory_reads"] == 0 and h["address_updates"] == ["ar3"]


def test_every_row_is_reached_and_rows_claim_only_words_they_match() -> None:
    """Each row's fixed bits with its letters 0 (a G that the row has) decode to that row or to a reserved word."""
    for number, row in enumerate(isa.rows()):
        modes = [mode for mode in range(4) if row["modes"] >> mode & 1]
        has_mode_field = "gg" in row["picture"] or "tt" in row["picture"]
        words = [row["match"] | (mode << 21) for mode in modes] if has_mode_field else [row["match"]]
        decoded = [isa.decode(word | low) for word in words for low in (0, 0xC0C0, 0x00080000, 0x0001)]
        assert any(d is not None and d["row"] == number for d in decoded), row["mnemonic"]
        assert row["match"] & ~row["mask"] == 0


def test_the_sweep_counts_what_decode_says() -> None:
    words = [0x08000000 + 0x10001 * n & 0xFFFFFFFF for n in range(2000)]
    assert isa.count_instructions(0x08000000, 2000, 0x10001) == sum(isa.decode(word) is not None for word in words)


@pytest.mark.parametrize(
    ("word", "reads", "writes", "stack"),
    [
        (0x74000005, 1, 1, True),  # trapu 5: reads its vector, pushes the PC
        (0x74800005, 1, 0, False),  # latu 5: reads its vector; the PC goes to R11
        (0x6200000F, 0, 1, True),  # call
        (0x6300000D, 0, 0, False),  # laj
        (0x78800000, 1, 0, True),  # retsu
        (0x78000000, 1, 0, True),  # retiu
        (0x0F200000, 0, 1, True),  # push r0
        (0x0E200000, 1, 0, True),  # pop r0
        (0x0CC02301, 0, 0, False),  # nop *ar3++(1): forms the address only
    ],
)
def test_hazards_count_the_accesses_that_no_operand_names(word: int, reads: int, writes: int, stack: bool) -> None:
    h = isa.decode(word)["hazards"]
    assert (h["memory_reads"], h["memory_writes"]) == (reads, writes)
    assert ("sp" in h["address_reads"]) == ("sp" in h["address_updates"]) == stack
