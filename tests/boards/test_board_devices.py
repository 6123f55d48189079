"""Devices behind the windows of a board, and ROMs in its regions: exec, Processor, and classes of Python."""

import json
import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from board_parts import HEAD
from cmrc.c40 import Processor, SnapshotError, assemble
from command_line import emulator
from locations import BUILD, ROOT

BOARD = (
    HEAD
    + """
[[device]]
name = "UART"
kind = "console"
base = 0xA0000000
waits = 3

[[device]]
name = "VIC"
kind = "registers"
base = 0xA0000100
words = 0x10
value = 0x55

[[device]]
name = "front"
kind = "led"
base = 0xA0000200
"""
)
# Sends what is typed, in capitals, until a full stop; then it writes to the VIC and the LED.
SOURCE = """
start:  ldhi    0A000h,ar0
        ldhi    0A000h,ar1
        or      100h,ar1
        ldhi    0A000h,ar2
        or      200h,ar2
        ldi     *+ar1(15),r3            ; 55h
        sti     r3,*ar2
wait:   ldi     *+ar0(1),r0
        tstb    1,r0
        bz      wait
        ldi     *ar0,r1
        cmpi    2Eh,r1
        bz      done
        andn    20h,r1
        sti     r1,*ar0
        b       wait
done:   ldi     0Ah,r1
        sti     r1,*ar0
        ldi     7,r4
        sti     r4,*+ar1(2)
        ldi     *+ar1(2),r5
        sti     r5,*ar2
        sti     r5,*ar2                 ; no change
end:    b       end
"""


@pytest.fixture
def board(tmp_path: Path) -> Path:
    (tmp_path / "board.toml").write_text(BOARD)
    return tmp_path / "board.toml"


@pytest.fixture
def source(tmp_path: Path) -> Path:
    (tmp_path / "p.asm").write_text(SOURCE)
    return tmp_path / "p.asm"


def test_a_console_and_an_led_in_exec(board: Path, source: Path, tmp_path: Path) -> None:
    done = emulator("exec", source, "--board", board, "--console-input", "-", stdin="hello.")
    assert done.returncode == 0, done.stderr
    assert (
        done.stdout.startswith("HELLO\n")
        and "led front: 55h at cycle" in done.stdout
        and "led front: 7h at cycle" in done.stdout
    )
    assert done.stdout.count("led front") == 2
    (tmp_path / "typed").write_text("hello.")
    report = json.loads(
        emulator("exec", source, "--board", board, "--console-input", tmp_path / "typed", "--json").stdout
    )
    assert report["console"] == "HELLO\n" and [led["value"] for led in report["leds"]] == [0x55, 7]


def test_the_first_thousand_changes_of_an_led_are_kept_and_all_are_counted(board: Path, tmp_path: Path) -> None:
    """A program that blinks without an end must not fill the memory."""
    blink = " .text\nstart: ldhi 0A000h,ar0\n or 200h,ar0\nl: addi 1,r0\n sti r0,*ar0\n b l\n"
    (tmp_path / "blink.asm").write_text(blink)
    run = ["exec", tmp_path / "blink.asm", "--board", board, "--cycles", "50000"]
    report = json.loads(emulator(*run, "--json").stdout)
    written = report["registers"]["R0"] & 0xFFFFFFFF
    assert report["led_changes"] in (written, written - 1) and written > 2000
    assert [led["value"] for led in report["leds"]] == list(range(1, 1001))
    assert f"led: {report['led_changes'] - 100} more changes" in emulator(*run).stdout
    processor = Processor(assemble(blink), board=board)
    processor.run(max_cycles=50000)
    assert (processor.led_change_count, len(processor.led_changes)) == (report["led_changes"], 1000)
    again = Processor(assemble(blink), board=board)
    again.restore(pickle.loads(pickle.dumps(processor.snapshot())))
    assert again.led_change_count == report["led_changes"] and again.led_changes == processor.led_changes


def test_an_access_takes_the_waits_of_its_device(tmp_path: Path) -> None:
    (tmp_path / "one.asm").write_text("start: ldhi 0A000h,ar0\n ldi *ar0,r0\nend: b end\n")
    cycles = []
    for waits in (0, 5):
        (tmp_path / "b.toml").write_text(BOARD.replace("waits = 3", f"waits = {waits}"))
        cycles.append(
            json.loads(emulator("exec", tmp_path / "one.asm", "--board", tmp_path / "b.toml", "--json").stdout)[
                "cycles"
            ]
        )
    assert cycles[1] == cycles[0] + 5


def test_the_same_in_python_with_snapshots(board: Path) -> None:
    program = assemble(SOURCE)
    processor, other = Processor(program, board=board), Processor(program, board=board)
    processor.type("hel")
    processor.run(max_cycles=2000)
    assert processor.console == b"HEL" and processor.led_changes[0][::2] == ("front", 0x55)
    processor.type(b"lo.")
    other.restore(pickle.loads(pickle.dumps(processor.snapshot())))
    for one in (processor, other):
        assert one.run(max_cycles=2000, until="end").reason == "until"
        assert one.console == b"HELLO\n" and one.registers["R5"] & 0xFF == 7
    assert processor.cycles == other.cycles
    with pytest.raises(SnapshotError, match="board"):
        Processor(program).restore(processor.snapshot())


class Counter:
    """Counts its reads, and keeps what is written."""

    words = 4
    waits = 2

    def __init__(self) -> None:
        self.reads = 0
        self.written: list[tuple[int, int]] = []

    def read(self, offset: int, cycle: int) -> int:
        self.reads += 1
        return self.reads * 100 + offset

    def write(self, offset: int, value: int, cycle: int) -> None:
        if value == 13:
            raise RuntimeError("thirteen")
        self.written.append((offset, value))


PYTHONS = """
start:  ldhi    0C000h,ar0
        ldi     *+ar0(3),r0
        ldi     *+ar0(1),r1
        sti     r1,*+ar0(2)
        sti     r2,*ar0
end:    b       end
"""


def test_a_class_of_ones_own_is_a_device() -> None:
    counter = Counter()
    processor = Processor(assemble(PYTHONS), devices={0xC0000000: counter})
    assert processor.run(until="end").reason == "until"
    assert (processor.registers["R0"] & 0xFFFF, processor.registers["R1"] & 0xFFFF) == (103, 201)
    assert counter.written == [(2, 201), (0, 0)]
    with pytest.raises(SnapshotError, match=r"the device Counter at C0000000h is Python's"):
        processor.snapshot()
    bare = Processor(assemble(PYTHONS))
    assert bare.run(until="end").reason == "external_access"


def test_what_a_device_raises_comes_out_and_the_access_still_waits() -> None:
    processor = Processor(assemble(PYTHONS), devices={0xC0000000: Counter()})
    processor.registers["R2"] = 13
    with pytest.raises(RuntimeError, match="thirteen"):
        processor.run(until="end")
    processor.complete_write()
    assert processor.run(until="end").reason == "until"


class NoRead:
    words = 1


@pytest.mark.parametrize(
    ("devices", "message"),
    [
        ({0: NoRead()}, r"no read\(\)"),
        ({"x": Counter()}, "word address"),
        ({0: Counter(), 2: Counter()}, "overlap"),
        ({2**32 - 1: Counter()}, "words of the one at FFFFFFFFh"),
    ],
)
def test_wrong_devices_are_refused(devices: Any, message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=message):
        Processor(devices=devices)


@pytest.mark.parametrize("width", [8, 32])
def test_a_region_holds_a_rom_and_the_board_boots_from_it(tmp_path: Path, width: int) -> None:
    (tmp_path / "p.asm").write_text("start: ldi 42,r0\nend: b end\n")
    assert emulator("asm", tmp_path / "p.asm", "-o", tmp_path / "p.out", "--section", ".text=2FFC00h").returncode == 0
    assert (
        emulator(
            "image", tmp_path / "p.out", "--format", "intel-hex", "--width", width, "-o", tmp_path / "boot.hex"
        ).returncode
        == 0
    )
    text = (
        BOARD
        + '\n[[region]]\nname = "EPROM"\nbase = 0x80000000\nwords = 0x1000\nbus = "global"\nfile = "boot.hex"\n\n[pins]\nromen = true\niiof = "0111"\n'
    )
    (tmp_path / "b.toml").write_text(text)
    done = emulator("exec", "--board", tmp_path / "b.toml", "--boot", "reset")
    assert done.returncode == 0 and "R0  800000002A" in done.stdout, done.stdout + done.stderr


REFUSED = [
    ("", 'kind = "led"', 'kind = "lamp"', "console, registers, led, fifo"),
    ("", "base = 0xA0000200", "base = 0xA0010000", "needs a"),
    ("", "base = 0xA0000200", "base = 0xA0000105", "VIC is there"),
    ("", "words = 0x10\nvalue", "words = 0\nvalue", "from 1 to 1048576"),
    ("", "waits = 3", "words = 3", "a console has its 2 words"),
    ("", "waits = 3", "value = 3", "a console has none; registers, led, vic068a has"),
    ("", "waits = 3", "speed = 3", "no such key device.speed"),
    ("", 'name = "front"\n', "", "name is missing"),
    ("", 'words = 0x10000\nbus = "local"', 'words = 0x10000\nbus = "local"\nfile = "nowhere.hex"', "nowhere.hex"),
    ("", 'words = 0x10000\nbus = "local"', 'words = 0x10000\nbus = "local"\nwidth = 8', "`file` is missing"),
    ("", 'bus = "global"', 'bus = "global"\nfile = "x"', "a window has no contents"),
]


@pytest.mark.parametrize(("_", "old", "new", "message"), REFUSED)
def test_a_board_that_cannot_be_is_refused_with_the_line(
    source: Path, tmp_path: Path, _: str, old: str, new: str, message: str
) -> None:
    (tmp_path / "b.toml").write_text(BOARD.replace(old, new, 1))
    done = emulator("exec", source, "--board", tmp_path / "b.toml")
    assert done.returncode == 2 and message in done.stderr and "b.toml:" in done.stderr, done.stderr


def test_the_dock_has_none(board: Path) -> None:
    done = emulator("--duration", "0.1", "--board", board)
    assert done.returncode == 2 and "device UART: the dock has no devices of a board file" in done.stderr, done.stderr


def test_a_console_that_is_not_there_takes_no_input(source: Path, board: Path) -> None:
    done = emulator("exec", source, "--console-input", "-")
    assert done.returncode == 2 and "no [[device]]" in done.stderr
    done = emulator("exec", source, "--board", board, "--console-input", "/nowhere")
    assert done.returncode == 2 and "/nowhere" in done.stderr


def test_a_processor_boots_from_an_eprom_in_python(board: Path, tmp_path: Path) -> None:
    (tmp_path / "p.asm").write_text("start: ldi 42,r0\nend: b end\n")
    emulator("asm", tmp_path / "p.asm", "-o", tmp_path / "p.out", "--section", ".text=2FFC00h")
    emulator("image", tmp_path / "p.out", "--format", "srec", "--width", "8", "-o", tmp_path / "boot")
    processor = Processor(board=board, boots_from=0x300000)
    processor.load_rom(tmp_path / "boot", 0x300000)
    processor.boot()
    processor.run(max_cycles=5000)
    other = processor.fork()
    assert processor.registers["R0"] & 0xFF == other.registers["R0"] & 0xFF == 42 and processor.pc == 0x2FFC01
    with pytest.raises(ValueError, match="the pins choose no memory"):
        Processor(board=board, boots_from=0x310000)
    (tmp_path / "broken").write_text(":00")
    with pytest.raises(ValueError, match="broken:1"):
        processor.load_rom(tmp_path / "broken", 0x300000)
    with pytest.raises(ValueError, match="width"):
        processor.load_rom(tmp_path / "p.out", 0x300000)


EPROM = ROOT / "build-foreign" / "helios" / "kernel/C40/arielbits/monitor/source/boot/monitor/monitor.hex"


@pytest.mark.campaign
@pytest.mark.skipif(not EPROM.exists(), reason="scripts/foreign helios has not been run here")
def test_the_hydras_monitor_boots_a_second_dsp_over_a_link() -> None:
    done = subprocess.run(
        [sys.executable, ROOT / "examples" / "hydra_link.py", EPROM, EPROM.with_name("others.hex")],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": str(BUILD / "python")},
    )
    assert (
        "Booting other processor ... Successful" in done.stdout
        and "Testing local SRAM on DSP 2 ... Passed" in done.stdout
    )
    assert "504 words to DSP 2, 11 back" in done.stdout


@pytest.mark.skipif(not EPROM.exists(), reason="scripts/foreign helios has not been run here")
def test_the_hydras_monitor_comes_to_its_prompt_and_answers() -> None:
    done = subprocess.run(
        [sys.executable, ROOT / "examples" / "hydra_monitor.py", EPROM, "?", "x"],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": str(BUILD / "python")},
    )
    assert "Hydra_Mon Command summary" in done.stdout and "Unknown command : x" in done.stdout
