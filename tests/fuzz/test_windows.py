"""Programs full of accesses through windows: by blocks, instruction by instruction, cut anywhere, answered before the
chip stops or after, they end alike. What compares the ways is the fuzz target `program`; here are programs for it."""

import random
import subprocess
from pathlib import Path

import pytest
from cmrc import c40
from locations import BUILD

# AR6 and AR7 point into windows, AR0 to AR2 anywhere.
LINES = [
    "LDI *AR6++, R0", "LDI *AR6, R1", "LDI *+AR7(3), R2", "LDF *AR7++(2), R3", "ADDI *AR6, R1", "MPYI *+AR6(1), R2",
    "STI R1, *AR7++", "STI R2, *+AR6(2)", "STF R3, *AR7--", "LDII *AR6, R0", "STII R0, *AR7", "SIGI *AR6, R1",
    "ADDI3 *AR0++, *AR6, R4", "ADDI3 *AR6++, *AR7, R4", "SUBI3 *AR6, R1, R2", "LDI *AR6++, R0 || LDI *AR0, R1",
    "STI R0, *AR7++ || STI R1, *AR0++", "LDI *AR6, R0 || STI R1, *AR0++", "LDI *AR0, R0 || STI R1, *AR7++",
    "LDINZ *AR6, R5", "CMPI *AR6, R1", "TSTB *AR7, R1", "ADDI 1, R1", "LDI *AR0++, R0", "STI R1, *AR1++", "XOR R1, R2",
    "PUSH R0", "POP R1", "MPYF3 *AR6, *AR0, R0 || ADDF3 R0, R2, R2", "NOP *AR6++", "ROL R1",
    # AR0 walks from one memory into another after the window has answered.
    "ADDI3 *AR6, *AR0++(IR0), R4", "SUBI3 *AR6++, *AR0++(IR0), R2", "LDI *AR6, R0 || LDI *AR0++(IR0), R1",
]  # fmt: skip
REPEATED = ["LDI *AR6++, R0", "ADDI *AR6, R1", "STI R1, *AR7++", "ADDI3 *AR0++, *AR6, R4", "LDI *AR6, R1", "NOP"]


def program(choose: random.Random) -> str:
    """A loop of a few turns over a body with repetitions and delayed branches."""
    body: list[str] = []
    for label in range(choose.randint(3, 10)):
        match choose.randrange(8):
            case 0:
                body += [f" RPTS {choose.randint(0, 5)}", f" {choose.choice(REPEATED)}"]
            case 1:
                body += [f" LDI {choose.randint(0, 4)}, RC", f" RPTB e{label}",
                         *(f" {choose.choice(LINES)}" for _ in range(choose.randint(3, 5))),
                         f"e{label}: {choose.choice(REPEATED)}"]  # fmt: skip
            case 2:
                body += [f" BNZD s{label}", *(f" {choose.choice(LINES)}" for _ in range(3)), f"s{label}: NOP"]
            case _:
                body.append(f" {choose.choice(LINES)}")
    lines = [f" LDI {choose.randint(2, 9)}, AR3", "loop:", *body, " DBU AR3, loop", " NOP", " NOP", "end: BU end"]
    return "\n".join(lines) + "\n"


def given(choose: random.Random) -> bytes:
    """An input of the target (fuzz/targets/program.cpp): board, pointers, ST, IIE, IIF, DIE, cuts, words."""

    def anywhere() -> int:
        return choose.randrange(256)

    def in_window() -> int:
        return choose.randrange(256) | 6

    stack = 2 | choose.randrange(16) << 3
    pointers = [anywhere() for _ in range(6)] + [in_window(), in_window(), stack] + [anywhere() for _ in range(11)]
    status = choose.choice([0, 0x0800, 0x0C00, 0x0400])  # the cache off, on, frozen
    words = c40.assemble(program(choose)).sections[0].words
    cuts = bytes(choose.randrange(40) for _ in range(4))
    numbers = [status, 0, 0, 0]
    return b"".join([
        bytes([choose.randrange(16), *pointers]),
        *(number.to_bytes(4, "little") for number in numbers),
        cuts,
        *(int(word).to_bytes(4, "little") for word in words),
    ])  # fmt: skip


def ends_alike(folder: Path, seed: int, count: int) -> None:
    choose = random.Random(seed)
    for n in range(count):
        (folder / f"{n:04}").write_bytes(given(choose))
    last = folder.parent / "last-input"
    done = subprocess.run(
        [BUILD / "fuzzers" / "program", "--keep", last, folder], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{done.stderr[-2000:]}\nthe input is {last}"
    assert f"{count} files" in done.stderr


def test_programs_that_go_through_windows_end_alike_in_all_ways(tmp_path: Path) -> None:
    (tmp_path / "inputs").mkdir()
    ends_alike(tmp_path / "inputs", 1, 300)


@pytest.mark.campaign
def test_many_programs_that_go_through_windows(tmp_path: Path) -> None:
    (tmp_path / "inputs").mkdir()
    ends_alike(tmp_path / "inputs", 2, 20000)
