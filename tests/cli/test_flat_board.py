"""Ruling 34: on board flat, exec and networks keep the chip's peripherals; all else, and everything under `emulator
vectors`, is RAM."""

import json
import resource
import subprocess
from pathlib import Path

import pytest

# Timer 0 counts to 20 by itself (H1/2): its counter moves while the program waits. Port 0 is at 100040h.
PERIPHERALS = """
        .text
start:  ldhi    0010h, ar0
        ldi     1000, r0
        sti     r0, *+ar0(28h)          ; timer 0: period
        ldi     03C1h, r0               ; internal clock, GO, HLD
        sti     r0, *+ar0(20h)
        ldi     *+ar0(24h), r1          ; counter
        rpts    50
        nop
        ldi     *+ar0(24h), r2
        ldi     *ar0, r3                ; GMICR
        ldi     *+ar0(40h), r4          ; port 0's control: reset value
halt:   b       halt
"""


def low(report: dict, name: str) -> int:
    return report["registers"][name] & 0xFFFFFFFF


def test_timers_ports_and_interface_registers_are_there(run, tmp_path: Path) -> None:
    (tmp_path / "p.asm").write_text(PERIPHERALS)
    values = {}
    for board in ("default", "flat"):
        report = json.loads(run("exec", "p.asm", "--board", board, "--json", "--peripherals").stdout)
        assert report["stop"]["reason"] == "halt"
        assert 20 <= low(report, "R2") - low(report, "R1") <= 40, "a tick is two cycles"
        values[board] = [low(report, name) for name in ("R3", "R4")], report["peripherals"]["TIMER0.period"]["value"]
    assert values["flat"] == values["default"]
    assert values["flat"][1] == 1000


@pytest.mark.parametrize(
    "address", ["0FFFFFh", "100100h", "10FFFFh", "2FF7FFh", "300000h", "0C0000000h", "0", "0FFFFFFFFh"]
)
def test_all_else_is_ram(run, tmp_path: Path, address: str) -> None:
    value = int(address[:-1], 16) if address.endswith("h") else int(address)
    (tmp_path / "p.asm").write_text(
        f"start: ldhi {value >> 16},ar0\n or {value & 0xFFFF},ar0\n ldi 77,r0\n sti r0,*ar0\n ldi *ar0,r1\nhalt: b halt\n"
    )
    report = json.loads(run("exec", "p.asm", "--board", "flat", "--json").stdout)
    assert report["stop"]["reason"] == "halt", report["stop"]
    assert low(report, "R1") == 77


def test_a_place_between_the_registers_is_no_ram(run, tmp_path: Path) -> None:
    (tmp_path / "p.asm").write_text("start: ldhi 0010h,ar0\n ldi *+ar0(0FFh),r0\nhalt: b halt\n")
    result = run("exec", "p.asm", "--board", "flat")
    assert result.returncode == 1
    assert "1000FFh" in result.stdout.splitlines()[0].upper().replace("H", "h")


def test_chips_on_flat_boards_talk_over_their_links(run, tmp_path: Path) -> None:
    (tmp_path / "send.asm").write_text("start: ldhi 0010h,ar0\n ldi 1234,r0\n sti r0,*+ar0(42h)\nhalt: b halt\n")
    (tmp_path / "take.asm").write_text("start: ldhi 0010h,ar0\n ldi *+ar0(71h),r5\nhalt: b halt\n")
    result = run("exec", "send.asm", "take.asm", "--link", "0.0:1.3", "--board", "flat", "--json")
    assert result.returncode == 0, result.stdout
    assert low(json.loads(result.stdout)["chips"][1], "R5") == 1234


def test_for_vectors_it_is_all_ram(run, tmp_path: Path) -> None:
    """ldi @20h,r0 (08200020) and sti r0,@20h (15200020) with DP on the page of the registers: 100020h is timer 0's
    control otherwise."""
    (tmp_path / "v.txt").write_text(
        "id=load m=0 DP=10 @00100020=12345678 op=08200020 -> R0=0012345678\nid=store m=0 DP=10 R0=00DEADBEEF op=15200020 -> @00100020=DEADBEEF\n"
    )
    result = run("vectors", "v.txt")
    assert (result.returncode, result.stdout.splitlines()[-1]) == (0, "2 passed, 0 failed")


@pytest.mark.parametrize(("options", "mib"), [(["--memory-max", "1"], 1), ([], 256)])
def test_a_flat_board_is_not_endless(run, tmp_path: Path, options: list[str], mib: int) -> None:
    """A program that writes one word in each 64 K words gets so many MiB of the host, and then an error that says
    so."""
    (tmp_path / "p.asm").write_text("start: ldhi 1,ar0\n ldhi 1,ir0\nloop: sti r0,*ar0++(ir0)\n addi 1,r0\n b loop\n")
    result = run("exec", "p.asm", "--board", "flat", "--json", *options)
    report = json.loads(result.stdout)
    assert result.returncode == 1
    assert report["stop"]["reason"] == "fault"
    assert f"more than the {mib} MiB" in report["stop"]["message"]
    pages = mib * 4  # of 256 KiB; those beside the chip's own memory are shorter
    assert abs(low(report, "R0") - pages) <= 2


def test_memory_max_is_of_the_flat_board(run, tmp_path: Path) -> None:
    (tmp_path / "p.asm").write_text("start: nop\nhalt: b halt\n")
    for boards in ([], ["--board", "default"]):
        result = run("exec", "p.asm", "--memory-max", 1, *boards)
        assert result.returncode == 2
        assert "--memory-max: board default" in result.stderr


def small_address_space() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (300 << 20, 300 << 20))


@pytest.mark.unsanitized
def test_memory_that_the_system_does_not_give_is_an_error_in_words(emulator: Path, tmp_path: Path) -> None:
    """`ulimit -v`, or a container that is full: "std::bad_alloc" is no message."""
    (tmp_path / "p.asm").write_text(
        "        .text\nstart:  ldhi 40h,ar0\nloop:   sti r0,*ar0\n        addi 4096,ar0\n        b loop\n"
    )
    done = subprocess.run(
        [emulator, "exec", "p.asm", "--board", "flat", "--memory-max", "8000"],
        cwd=tmp_path, capture_output=True, text=True, check=False, timeout=120, preexec_fn=small_address_space
    )  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr) == (1, "", "emulator: no memory is left\n")
