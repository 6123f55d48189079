"""The boot loader of the ROM: the streams of c40-hardware.md 9, from every port, from memory of every width, over a
link."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
from cmrc._core import c40, toolchain
from cmrc_test import forms
from linked_processors import HERTZ, Network, processor

PERIOD = 10**12 // HERTZ
PROGRAM = """
        .text
entry:  ldi 1234h,r7
end:    bu end
        .data
        .word 11,22,33
"""
MINIMAL = [0x3E39FFF0, 0x1DEA4050]


def image(text: str = PROGRAM) -> Any:
    return toolchain.assemble(text, "boot.asm", sections={".text": 0x2FFC00, ".data": 0x300100}, entry="entry")


def feed(chip: Any, port: int, stream: list[int], limit: int = 20_000) -> dict[str, Any]:
    """Words by hand, as fast as the loader asks for them."""
    chip.deliver(port, stream[0])
    rest = list(stream[1:])
    while True:
        stop = chip.run(limit, until=0x2FFC00)
        if stop["reason"] != "port_wait" or not rest:
            return dict(stop)
        chip.deliver(port, rest.pop(0))
        chip.complete_port(stop["access_cycle"])


@pytest.mark.parametrize("port", range(6))
def test_from_a_port(port: int) -> None:
    chip = c40.Processor.bootable()
    chip.boot()
    assert chip.peripheral("GMICR") == 0x3E39FFF0
    stream = forms.boot_stream(image(), ivtp=0x2FFA00, tvtp=0x300000)
    stream[1] = 0x1DEA4050
    stop = feed(chip, port, stream)
    assert (stop["reason"], stop["pc"]) == ("breakpoint", 0x2FFC00)
    assert chip.get("AR3") == 0x100040 + 0x10 * port
    assert (chip.get("IVTP"), chip.get("TVTP")) == (0x2FFA00, 0x300000)
    assert (chip.peripheral("GMICR"), chip.peripheral("LMICR")) == (0x3E39FFF0, 0x1DEA4050)
    assert [chip.peek(0x300100 + i) for i in range(3)] == [11, 22, 33]
    assert chip.get("ST") & 0x2800 == 0  # interrupts and cache off
    chip.run(20)
    assert chip.get("R7") & 0xFFFFFFFF == 0x1234
    assert sum(chip.causes.values()) == chip.cycle


def in_units(words: list[int], width: int) -> list[int]:
    """A stream as it lies in memory of `width` bits: low part first; the unused bits carry rubbish."""
    out = []
    for word in words:
        for shift in range(0, 32, width):
            out.append((word >> shift & (1 << width) - 1) | (0xA5A5A5A5 << width & 0xFFFFFFFF))
    return out


@pytest.mark.parametrize("width", [8, 16, 32])
@pytest.mark.parametrize("address", [0x300000, 0x40000000, 0x80000000])
def test_from_memory(address: int, width: int) -> None:
    chip = c40.Processor.bootable(memory=address)
    stream = [width, *forms.boot_stream(image())]
    assert stream[1:] == forms.boot_stream(image(), memory=True)[1:]
    units = in_units(stream, width) if width < 32 else stream
    chip.load_words(address, units)
    chip.boot()
    assert chip.run(200_000, until=0x2FFC00)["reason"] == "breakpoint"
    assert chip.get("AR1") == address + len(units)
    chip.run(200)
    assert chip.get("R7") & 0xFFFFFFFF == 0x1234
    assert [chip.peek(0x300100 + i) for i in range(3)] == [11, 22, 33]


def test_several_blocks_and_the_first_is_entered() -> None:
    chip = c40.Processor.bootable()
    chip.boot()
    code = [0x08671234, 0x60300000]
    stream = [*MINIMAL, 2, 0x2FFC00, *code, 3, 0x2FF800, 7, 8, 9, 1, 0x80000005, 5, 0, 0, 0, 0x2FF800]
    assert feed(chip, 2, stream)["pc"] == 0x2FFC00
    assert [chip.peek(0x2FF800 + i) for i in range(3)] == [7, 8, 9] and chip.peek(0x80000005) == 5


def test_a_stream_that_is_cut_short_waits_in_the_rom() -> None:
    chip = c40.Processor.bootable()
    chip.boot()
    stop = feed(chip, 1, forms.boot_stream(image())[:-3])
    assert stop["reason"] == "port_wait" and stop["port"] == 1 and stop["pc"] < 0x1000


def test_a_stream_into_memory_that_is_not_there_is_a_fault() -> None:
    chip = c40.Processor.bootable()
    chip.boot()
    stop = feed(chip, 0, [*MINIMAL, 2, 0x00200000, 1, 2, 0, 0, 0, 0x2FF800])
    assert (stop["reason"], stop["kind"]) == ("fault", "reserved_address") and "00200000h" in stop["message"]


def test_without_a_boot_rom_the_reset_vector_is_missing() -> None:
    with pytest.raises(IndexError, match="no boot ROM"):
        c40.Processor("default").boot()
    with pytest.raises(ValueError, match="the pins choose no memory at 12345678h"):
        c40.Processor.bootable(memory=0x12345678)
    with pytest.raises(ValueError, match="the boot ROM is there"):
        forms.boot_stream(
            toolchain.assemble("        .text\nentry:  nop\n", "low.asm", sections={".text": 0x100}, entry="entry")
        )


def test_a_program_begins_in_one_of_its_sections() -> None:
    behind = toolchain.assemble("        .text\n        nop\nentry:\n", "behind.asm", entry="entry")
    with pytest.raises(ValueError, match="the program's entry 00300001h is in no section"):
        forms.boot_stream(behind)


def test_a_chip_boots_its_neighbour() -> None:
    stream = forms.boot_stream(image())
    sender = processor(
        "        ldhi 10h,ar0\n        or 40h,ar0\n        ldhi 30h,ar1\n        ldi COUNT,rc\n        rptb last\n"
        "        ldi *ar1++,r0\nlast:   sti r0,*+ar0(2)\n        ldi *+ar0(1),r6\nend:    bu end\n".replace(
            "COUNT", str(len(stream) - 1)
        )
    )
    sender.load_words(0x300000, stream)
    booted = c40.Processor.bootable()
    booted.boot()
    network = Network([sender, booted])
    network.join(0, 0, 1, 3)
    network.run(4000 * PERIOD)
    assert booted.get("R7") & 0xFFFFFFFF == 0x1234
    assert booted.get("AR3") == 0x100070
    network.balance()


def test_general_purpose_output_on_an_iiof_pin() -> None:
    chip = c40.Processor("default")
    for level in (True, False):
        chip.set("IIF", 0x20 | (0x40 if level else 0))
        assert chip.iiof_pin(1) == level
    bootable = c40.Processor.bootable(memory=0x300000)
    bootable.reset()
    assert bootable.get("IIF") == 0x4404  # IIOF3, 2, 0 high; IIOF1 low
    assert [bootable.iiof_pin(n) for n in range(4)] == [True, False, True, True]


def test_the_command_boots_a_program(emulator: Path, tmp_path: Path) -> None:
    source = tmp_path / "program.asm"
    source.write_text(PROGRAM.replace("        .text\n", "        .text\n        .global entry\n"))
    for how in ("4", "0x80000000"):
        run = subprocess.run([emulator, "exec", source, "--boot", how, "--until", "end", "--peripherals", "--events", tmp_path / "events"],
                             capture_output=True, text=True, check=False)  # fmt: skip
        assert run.returncode == 0, run.stdout + run.stderr
        assert "00001234" in run.stdout and "reached" in run.stdout
    assert (tmp_path / "events").read_text() == ""
    bad = subprocess.run(
        [emulator, "exec", source, "--boot", "0x12340000"], capture_output=True, text=True, check=False
    )
    assert bad.returncode == 2 and "00300000h" in bad.stderr


def test_events_of_ports_timers_and_dma() -> None:
    chip = processor(
        "        ldhi 10h,ar0\n        or 40h,ar0\n        ldi 9,r0\n        sti r0,*+ar0(2)\n        ldi *+ar0(1),r1\nend:    bu end\n"
    )
    chip.record_events()
    chip.deliver(0, 77)
    chip.poke(0x100028, 10)
    chip.poke(0x100020, 0x2C0)
    for offset, value in ((1, 0x2FF800), (3, 2), (4, 0x100052), (0, 0x00C00004)):
        chip.poke(0x1000A0 + offset, value)
    chip.run(50)
    kinds = [(kind, number, value, channel) for kind, _, number, value, channel in chip.events]
    assert ("port_write", 0, 9, -1) in kinds and ("port_read", 0, 77, -1) in kinds
    assert kinds.count(("port_write", 1, 0, 0)) == 2 and ("dma_end", 0, 0, -1) in kinds
    assert [cycle for kind, cycle, *_ in chip.events if kind == "timer"] == [20, 40]


# ---- as the board's pins say ----

BOARD = """
name = "strapped"
[pins]
romen = true
resetloc = 0
iiof = "0111"
[[region]]
name = "local"
base = 0x300000
words = 0x10000
bus = "local"
[[region]]
name = "global"
base = 0x80000000
words = 0x10000
bus = "global"
"""


def run_on(
    emulator: Path, tmp_path: Path, board: str, *arguments: str, program: str = "plain.asm"
) -> subprocess.CompletedProcess[str]:
    (tmp_path / "b.toml").write_text(board)
    (tmp_path / "plain.asm").write_text(PROGRAM)
    return subprocess.run(
        [emulator, "exec", program, "--board", "b.toml", *arguments],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        timeout=60,
    )


def assembled(emulator: Path, tmp_path: Path, text: str, *sections: str) -> str:
    (tmp_path / "p.asm").write_text(text)
    places = [word for section in sections for word in ("--section", section)]
    subprocess.run([emulator, "asm", "p.asm", "-o", "p.out", *places], check=True, cwd=tmp_path)
    return "p.out"


@pytest.mark.parametrize(("levels", "address"), [("0111", 0x80000000), ("1101", 0x300000)])
def test_pins_choose_the_memory_that_the_loader_reads(
    emulator: Path, tmp_path: Path, levels: str, address: int
) -> None:
    program = assembled(emulator, tmp_path, PROGRAM.split("        .data")[0], ".text=0x2FFC00")
    result = run_on(
        emulator, tmp_path, BOARD.replace("0111", levels), "--boot", "reset", "--json", "--peripherals", program=program
    )
    report = json.loads(result.stdout)
    assert result.returncode == 0 and report["stop"]["reason"] == "halt", result.stderr
    assert report["registers"]["R7"] & 0xFFFF == 0x1234
    assert (
        report["registers"]["AR1"] == address + 5 + 2 + 4
    )  # just past the stream: width, GMICR, LMICR, size, address; two words; 0, IVTP, TVTP, IACK
    assert report["peripherals"]["GMICR"]["value"] == 0x1DEA4000  # the stream's header has the board's


@pytest.mark.parametrize(("location", "vector"), [(1, 0x7FFFFFFF), (2, 0x80000000), (3, 0xFFFFFFFF)])
def test_pins_choose_the_reset_vector(emulator: Path, tmp_path: Path, location: int, vector: int) -> None:
    region = f'[[region]]\nname = "vector"\nbase = 0x{vector & ~0xFF:X}\nwords = 0x100\nbus = "{"global" if vector >> 31 else "local"}"\n'
    board = BOARD.replace("resetloc = 0", f"resetloc = {location}").replace("romen = true", "romen = false")
    board = board.replace("0x80000000", "0x90000000") + region
    text = '        .text\nentry:  ldi 77,r7\nend:    bu end\n        .sect "vec"\n        .word entry\n'
    program = assembled(emulator, tmp_path, text, f"vec={vector:#x}")
    result = run_on(emulator, tmp_path, board, "--boot", "reset", "--json", program=program)
    assert result.returncode == 0, result.stderr
    assert json.loads(result.stdout)["registers"]["R7"] & 0xFF == 77


@pytest.mark.parametrize(("old", "new", "message"), [
    ("romen = true", "romen = 1", "b.toml:4: pins.romen: true (the boot ROM is at 0) or false is expected"),
    ("resetloc = 0", "resetloc = 4", "b.toml:5: pins.resetloc: an integer from 0 to 3 is expected"),
    ('"0111"', '"111"', "b.toml:6: pins.iiof: the levels of IIOF3 to IIOF0 are expected"),
    ('"0111"', "7", "pins.iiof: text in quotes is expected"),
    ('"0111"', '"0110"', "IIOF0, must be 1 for the boot loader"),
    ('"0111"', '"0001"', "000 of IIOF3 to IIOF1 is reserved"),
    ("romen", "rom", "b.toml:4: no such key pins.rom; known are romen, resetloc, iiof"),
    ("[pins]", "[[pins]]", "pins: a table, [pins], is expected"),
    ("0x300000", "0x100", "the boot ROM is at 0 to FFFh, and so is region local"),
])  # fmt: skip
def test_pins_that_cannot_be(emulator: Path, tmp_path: Path, old: str, new: str, message: str) -> None:
    result = run_on(emulator, tmp_path, BOARD.replace(old, new, 1))
    assert result.returncode == 2 and result.stdout == "" and message in result.stderr, result.stderr


@pytest.mark.parametrize(("board", "boot", "message"), [
    (BOARD.replace("[pins]", "").replace("romen = true", "").replace("resetloc = 0", "").replace('iiof = "0111"', ""), "reset", "board strapped has no [pins]"),
    (BOARD.replace("0111", "1111"), "reset", "say through which the program comes: --boot 0 to --boot 5"),
    (BOARD, "3", 'romen = true, resetloc = 0, iiof = "1111"; --boot reset starts with the board\'s own pins'),
    (BOARD.replace("0111", "0101"), "reset", "the stream at A0000000h does not lie in memory"),
    (BOARD.replace("romen = true", "romen = false"), "reset", "the reset vector of RESETLOC 0 is at 00000000h, where board strapped has no memory and no boot ROM"),
])  # fmt: skip
def test_boots_that_the_pins_forbid(emulator: Path, tmp_path: Path, board: str, boot: str, message: str) -> None:
    result = run_on(emulator, tmp_path, board, "--boot", boot)
    assert result.returncode == 2 and result.stdout == "" and message in result.stderr, result.stderr


def test_pins_of_a_chip_in_a_network(emulator: Path, tmp_path: Path) -> None:
    """Chip 0 boots from its memory at 80000000h. Chip 1 boots from its ports, and no chip sends it a stream."""
    (tmp_path / "b.toml").write_text(BOARD)
    (tmp_path / "c.toml").write_text(BOARD.replace("0111", "1111"))
    (tmp_path / "p.asm").write_text(PROGRAM)
    (tmp_path / "n.toml").write_text(
        "".join(f'[[chip]]\nprogram = "p.asm"\nboard = "{b}.toml"\nboot = true\n' for b in "bc")
        + '[[link]]\nports = "0.0:1.3"\n'
    )
    result = subprocess.run(
        [emulator, "exec", "--network", "n.toml", "--json"],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        timeout=60,
    )
    report = json.loads(result.stdout)
    assert [chip["status"] for chip in report["chips"]] == ["halt", "looping"] and report["chips"][0]["registers"][
        "R7"
    ] & 0xFFFF == 0x1234
    assert "polls port 3 from chip 0 port 0;" in report["chips"][1]["message"]
    (tmp_path / "b.toml").write_text(BOARD.replace("0111", "0101"))
    bad = subprocess.run(
        [emulator, "exec", "--network", "n.toml"], capture_output=True, text=True, check=False, cwd=tmp_path, timeout=60
    )
    assert (
        bad.returncode == 2
        and "chip 0: board strapped: the boot stream at A0000000h, which the pins choose:" in bad.stderr
    )


ADDED = "        .text\nstart:  ldi 1,r7\nend:    bu end\nother:  ldi 77,r7\nend2:   bu end2\n"
VECTOR = 0x80000000


@pytest.mark.parametrize("how", ["poke", "load"])
@pytest.mark.parametrize("network", [False, True])
def test_words_of_the_command_line_are_there_before_the_reset(
    emulator: Path, tmp_path: Path, how: str, network: bool
) -> None:
    """The word is the reset vector, which the chip reads at its reset."""
    board = BOARD.replace("resetloc = 0", "resetloc = 2").replace("romen = true", "romen = false")
    (tmp_path / "b.toml").write_text(board)
    (tmp_path / "p.asm").write_text(ADDED)
    (tmp_path / "n.toml").write_text('[[chip]]\nprogram = "p.asm"\nboard = "b.toml"\nboot = true\n')
    entry = 0x300000 + 2
    (tmp_path / "vector.bin").write_bytes(entry.to_bytes(4, "little"))
    chip = "0:" if network else ""
    add = {"poke": f"{chip}{VECTOR:#x}={entry:#x}", "load": f"vector.bin@{chip}{VECTOR:#x}"}[how]
    what = ["--network", "n.toml"] if network else ["p.asm", "--board", "b.toml", "--boot", "reset"]
    result = subprocess.run(
        [emulator, "exec", *what, f"--{how}", add, "--json", "--max-cycles", "10000"],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        timeout=60,
    )
    assert result.returncode == 0, result.stderr
    report = json.loads(result.stdout)
    assert (report["chips"][0] if network else report)["registers"]["R7"] & 0xFF == 77


def test_a_program_that_would_overwrite_its_own_stream_is_refused(emulator: Path, tmp_path: Path) -> None:
    """The stream is put where the pins say, and the loader reads it there while it writes the program."""
    program = assembled(emulator, tmp_path, PROGRAM, ".text=0x8000000A", ".data=0x80000100")
    board = BOARD.replace("0x10000", "0x20000")
    refused = run_on(emulator, tmp_path, board, "--boot", "reset", program=program)
    assert refused.returncode == 2 and refused.stdout == ""
    assert "--boot: section .text has a word at 8000000Ah, where the boot loader has not read the stream" in (
        refused.stderr
    )
    (tmp_path / "n.toml").write_text('[[chip]]\nprogram = "p.out"\nboard = "b.toml"\nboot = true\n')
    network = subprocess.run(
        [emulator, "exec", "--network", "n.toml"], capture_output=True, text=True, check=False, cwd=tmp_path, timeout=60
    )
    assert network.returncode == 2 and "section .text has a word at 8000000Ah" in network.stderr
    behind = assembled(emulator, tmp_path, PROGRAM, ".text=0x80000000", ".data=0x80000100")
    done = run_on(emulator, tmp_path, board, "--boot", "reset", "--json", program=behind)
    assert done.returncode == 0 and json.loads(done.stdout)["registers"]["R7"] & 0xFFFF == 0x1234


def test_a_loader_that_reads_memory_is_not_said_to_poll_the_ports(emulator: Path, tmp_path: Path) -> None:
    """The board's pins say the ports; a net pulls IIOF1 low before the loader reads them, which is 300000h."""
    (tmp_path / "b.toml").write_text(BOARD.replace("0111", "1111"))
    (tmp_path / "n.toml").write_text(
        '[[chip]]\nboard = "b.toml"\nboot = true\n[[net]]\nname = "sel"\nreceivers = ["0.IIOF1"]\nrest = "low"\n'
    )
    stream = [32, 0x1DEA4000, 0x1DEA4000, 2, 0x500, 7, 8]
    pokes = [word for n, value in enumerate(stream) for word in ("--poke", f"0:{0x300000 + n:#x}={value:#x}")]
    result = subprocess.run(
        [emulator, "exec", "--network", "n.toml", *pokes],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        timeout=60,
    )
    assert "write to 00000500h, which is in the boot ROM" in result.stdout
    assert "(the boot loader, which reads a stream in memory, its next word at 00300006h)" in result.stdout
