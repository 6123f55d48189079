"""`emulator vectors`: two other cores' 16,000 cases pass, every kind of difference is seen, bad lines are named."""

import gzip
import json
import lzma
import subprocess
from pathlib import Path

import pytest
from locations import ROOT

COMMON = ROOT / "tests" / "c40" / "data" / "c3x-common-vectors.txt.xz"
# ADDI @2000h,R0 with R0 = 1 and 7 in memory.
ADD = "id=add R0=0000000001 AR0=00002000 @2000=00000007 op=02202000 -> PC=001001 R0=0000000008 ST=00000000"
STORE = "id=store R8=1200000005 DP=00000000 op=153C2000 -> PC=001001 @2000=00000005"


def run(emulator: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run([emulator, "vectors", *map(str, arguments)], capture_output=True, text=True, check=False)


@pytest.fixture
def vectors(emulator: Path, tmp_path: Path):
    def of(text: str, *arguments: str) -> subprocess.CompletedProcess[str]:
        path = tmp_path / "some.txt"
        path.write_text(text)
        return run(emulator, path, *arguments)

    return of


def test_the_cases_of_two_other_cores_pass(emulator: Path) -> None:
    """One of them was checked against a VC33 board."""
    result = run(emulator, COMMON)
    assert (result.returncode, result.stdout) == (0, "16000 passed, 0 failed\n")


def test_lines_pass_plain_and_compressed_and_add_up_over_files(emulator: Path, tmp_path: Path) -> None:
    text = f"# a comment\n\n{ADD}\r\n{STORE}"
    (tmp_path / "plain").write_text(text)
    (tmp_path / "gz").write_bytes(gzip.compress(text.encode()))
    (tmp_path / "xz").write_bytes(lzma.compress(text.encode()))
    result = run(emulator, *(tmp_path / name for name in ("plain", "gz", "xz")))
    assert (result.returncode, result.stdout) == (0, "6 passed, 0 failed\n")


@pytest.mark.parametrize(
    ("line", "named"),
    [
        (ADD.replace("R0=0000000008", "R0=0000000009"), "R0 is 0000000008, expected 0000000009"),
        (ADD.replace(" R0=0000000008", ""), "R0 is 0000000008, expected 0000000001"),
        (ADD.replace("R0=0000000008", "R0=0100000008"), "R0 is 0000000008, expected 0100000008"),
        (ADD.replace("ST=00000000", "ST=00000001"), "ST is 00000000, expected 00000001"),
        (ADD.replace("PC=001001", "PC=001002"), "PC is 00001001, expected 00001002"),
        (ADD + " TVTP=00000200", "TVTP is 00000000, expected 00000200"),
        (ADD + " @2001=00000001", "@00002001 is 00000000, expected 00000001"),
        (ADD + " rd@2001", "the bus shows rd@00002000, expected rd@00002001"),
        (ADD + " rd@2000 rd@2000", "the bus shows rd@00002000, expected rd@00002000 rd@00002000"),
        (STORE + " rd@2000", "the bus shows wr@00002000=00000005, expected rd@00002000"),
        (STORE + " wr@2000=6", "the bus shows wr@00002000=00000005, expected wr@00002000=00000006"),
        (STORE.replace(" @2000=00000005", ""), "@00002000 is 00000005, expected 00000000"),
        (ADD.replace("op=02202000", "op=10800000"), "no instruction"),
    ],
)
def test_each_kind_of_difference_fails_and_is_named(vectors, line: str, named: str) -> None:
    result = vectors(f"{STORE}\n{line}\n{ADD}\n")
    assert result.returncode == 1
    assert f"some.txt:2: {line.split()[0][3:]}: " in result.stdout
    assert named in result.stdout
    assert result.stdout.endswith("\n2 passed, 1 failed\n")


def test_masked_status_bits_and_steps(vectors) -> None:
    masked = ADD.replace("id=add", "id=add m=fe").replace("ST=00000000", "ST=00000001")
    twice = ADD.replace("op=02202000", "steps=2 op=02202000 op=02202000").replace("PC=001001", "PC=001002")
    assert vectors(masked).stdout == "1 passed, 0 failed\n"
    assert vectors(twice.replace("R0=0000000008", "R0=000000000F")).stdout == "1 passed, 0 failed\n"


def test_two_reads_of_one_instruction_may_come_in_either_order_unless_asked(vectors) -> None:
    """LDI *AR0,R1 || LDI *AR1,R2; a read and a write have an order."""
    pair = "id=pair AR0=00002001 AR1=00002000 @2000=5 @2001=6 op=C650C1C0 -> PC=001001 R1=0000000006 R2=0000000005 "
    assert vectors(pair + "rd@2000 rd@2001").returncode == 0
    assert vectors(pair + "rd@2001 rd@2000").returncode == 0
    assert vectors(pair + "rd@2001 rd@2000", "--every-access").returncode == 1
    both = "id=both AR0=00002001 AR1=00002000 R3=0000000009 @2001=6 op=DA43C1C0 -> PC=001001 R1=0000000006 @2000=9 "
    assert vectors(both + "rd@2001 wr@2000=9").returncode == 0
    assert vectors(both + "wr@2000=9 rd@2001").returncode == 1


def test_every_access_must_be_named_if_asked(vectors) -> None:
    assert vectors(ADD).returncode == 0
    assert "the bus shows rd@00002000, expected nothing" in vectors(ADD, "--every-access").stdout
    assert vectors(ADD + " rd@2000", "--every-access").returncode == 0


def test_json_and_the_number_of_failures_shown(vectors) -> None:
    wrong = ADD.replace("ST=00000000", "ST=00000001") + "\n"
    result = vectors(wrong * 3 + ADD, "--json", "--show", "2")
    document = json.loads(result.stdout)
    assert (document["passed"], document["failed"], len(document["failures"])) == (1, 3, 2)
    assert document["failures"][1]["line"] == 2
    assert "... and 1 more\n1 passed, 3 failed\n" in vectors(wrong * 3 + ADD, "--show", "2").stdout


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (ADD.replace("AR0=", "AR8="), '"AR8=00002000": unknown token'),
        (ADD + " cycles=3", '"cycles=3": unknown token'),
        (ADD.replace("->", "-"), '"->"'),
        (ADD.replace("op=02202000", ""), "op=WORD"),
        (ADD.replace("R0=0000000001", "R0=00000001"), "10 hexadecimal digits"),
        (ADD.replace("AR0=00002000", "AR0=2z"), "hexadecimal digits"),
        (ADD.replace("AR0=00002000", "R0=0000000001"), "given twice"),
        (ADD.replace("op=", "steps=0 op="), "number of instructions"),
        (ADD.replace("op=", "PC=001000 op="), "1000h"),
        (ADD + " rd@2000=7", "a read has no value"),
        ("word " * 2_000_000 + ADD, "unknown token"),
    ],
)
def test_bad_lines_are_errors_with_their_place(vectors, line: str, message: str) -> None:
    result = vectors(f"{ADD}\n{line}\n")
    assert result.returncode == 2
    assert "some.txt:2: " in result.stderr
    assert message in result.stderr
    assert len(result.stderr) < 500


def test_damaged_and_missing_files_are_bad_input(emulator: Path, tmp_path: Path) -> None:
    for name, data in [
        ("cut.xz", lzma.compress(ADD.encode() * 100)[:-20]),
        ("cut.gz", gzip.compress(ADD.encode() * 100)[:-20]),
        ("empty", b""),
    ]:
        (tmp_path / name).write_bytes(data)
        result = run(emulator, tmp_path / name)
        assert result.returncode == 2 and name in result.stderr, name
    assert run(emulator, tmp_path / "none").returncode == 2
    assert run(emulator, tmp_path).returncode == 2
