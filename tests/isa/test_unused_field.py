"""Compares of type 2: the chip ignores the field where others have a destination (docs/fidelity.md)."""

import subprocess
from pathlib import Path

import pytest
from cmrc._core import isa, toolchain

CMPI3, CMPF3, TSTB3 = 0x33800000, 0x33000000, 0x37800000
WORDS = [
    CMPI3 | 0x0105,
    CMPI3 | 0x400000 | 0x0905,
    CMPI3 | 0x600000 | 0x1319,
    TSTB3 | 0x01FF,
    TSTB3 | 0x200000 | 0x0111,
    CMPF3 | 0x200000 | 0x0111,
    CMPF3 | 0x600000 | 0x1319,
]


@pytest.mark.parametrize("word", WORDS)
@pytest.mark.parametrize("field", [1, 2, 11, 17, 28, 31])
def test_the_field_changes_what_is_printed_and_nothing_else(word: int, field: int) -> None:
    plain, filled = isa.decode(word), isa.decode(word | field << 16)
    assert plain is not None and filled is not None and filled.pop("word") == plain.pop("word") | field << 16
    assert filled == plain and filled["dst"] is None
    text = isa.disassemble(word | field << 16)
    assert text == f"{isa.disassemble(word)},={field}"
    assert list(toolchain.assemble(f" {text}\n").sections[0].words) == [word | field << 16]


def test_of_type_1_it_has_to_be_0() -> None:
    for word in (0x23800001, 0x23000001, 0x27800001):
        assert isa.decode(word) is not None and isa.reserved_reason(word | 1 << 16) is not None


def test_no_other_instruction_takes_such_a_field() -> None:
    for line, message in (
        ("cmpi3 5,r1,=32", "=x is a field of 5 bits here"),
        ("cmpi3 r2,r1,=3", "no encoding takes the register r2 here"),
        ("cmpi3 5,r1,3", "2 operands"),
        ("tstb r1,r2,=3", "no encoding takes the register r1 here"),
    ):
        with pytest.raises(toolchain.AssemblyError, match=message):
            toolchain.assemble(f" {line}\n")


def test_the_chip_compares_and_writes_no_register(emulator: Path, tmp_path: Path) -> None:
    """CMPI3 7,R1 with the number of R2 in the field: Z is set, R2 stays."""
    lines = []
    for field in (0, 2, 19, 31):
        lines.append(
            f"id=cmpi3 R1=0000000007 R2=0000000009 op={CMPI3 | field << 16 | 0x0107:08X} -> PC=00001001 ST=00000004"
        )
        lines.append(
            f"id=tstb3 R1=0000000007 R2=0000000009 op={TSTB3 | field << 16 | 0x0108:08X} -> PC=00001001 ST=00000004"
        )
        lines.append(
            f"id=memory AR1=00002000 R2=0000000009 @00002003=00000007 R1=0000000007 op={CMPI3 | 0x200000 | field << 16 | 0x0119:08X} -> PC=00001001 ST=00000004"
        )
    (tmp_path / "v.txt").write_text("\n".join(lines) + "\n")
    done = subprocess.run([emulator, "vectors", tmp_path / "v.txt"], capture_output=True, text=True, check=False)
    assert done.returncode == 0 and f"{len(lines)} passed, 0 failed" in done.stdout, done.stdout
    (tmp_path / "v.txt").write_text(lines[2].replace("ST=00000004", "ST=00000000") + "\n")
    assert subprocess.run([emulator, "vectors", tmp_path / "v.txt"], capture_output=True, check=False).returncode == 1
