"""Addresses at which a board has no device: a fault, or an access that is ignored and reported (docs/boards.md); the
loader's messages about them."""

import json
import subprocess
from pathlib import Path

import cmrc
import pytest

RAM = '[[region]]\nname = "SRAM"\nbase = 0x300000\nwords = 0x10000\nbus = "local"\n'
FAR = '[[region]]\nname = "far SRAM"\nbase = 0x80000000\nwords = 0x10000\nbus = "global"\nwaits = 2\n'
WINDOW = '[[region]]\nname = "window"\nkind = "window"\nbase = 0xC0000000\nwords = 0x100\nbus = "global"\n'
PROGRAM = """
        .text
start:  ldhi    40h,ar0
        ldi     7,r0
        ldi     5,r1
        ldi     *ar0,r0         ; 00400000h: nothing
        sti     r1,*+ar0(1)
        sti     r1,*+ar0(1)
        ldi     *+ar0(1),r2
        ldi     *ar0,r3
done:   b       done
"""
DMA = """
        .text
start:  ldp     list
        ldi     @dma,ar0
        ldi     @control,r0
        ldi     @from,r1
        ldi     @to,r2
        sti     r1,*+ar0(1)
        ldi     1,r3
        sti     r3,*+ar0(2)
        sti     r3,*+ar0(3)
        sti     r2,*+ar0(4)
        sti     r3,*+ar0(5)
        sti     r0,*ar0
wait:   ldi     *+ar0(3),r4
        bnz     wait
done:   b       done
list:
dma:    .word   1000A0h
control .word   0C00005h
from:   .word   400000h
to:     .word   90000000h
"""


def board(folder: Path, text: str) -> Path:
    (folder / "board.toml").write_text(text)
    return folder / "board.toml"


def program(folder: Path, text: str = PROGRAM) -> Path:
    (folder / "p.asm").write_text(text)
    return folder / "p.asm"


def run(emulator: Path, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([emulator, "exec", *arguments], capture_output=True, text=True, check=False)


def test_without_a_word_an_access_is_a_fault(emulator: Path, tmp_path: Path) -> None:
    for head in ("", 'reserved = "fault"\n'):
        done = run(emulator, program(tmp_path), "--board", board(tmp_path, head + RAM), "--json")
        stop = json.loads(done.stdout)["stop"]
        assert (
            done.returncode == 1
            and stop["reason"] == "fault"
            and "read of 00400000h, which is reserved" in stop["message"]
        )
        assert "reserved" not in json.loads(done.stdout)


def test_ignored_accesses_read_0_and_are_reported_once_for_each_address(emulator: Path, tmp_path: Path) -> None:
    ignoring = board(tmp_path, 'reserved = "ignore"\n' + RAM)
    done = run(emulator, program(tmp_path), "--board", ignoring, "--json")
    out = json.loads(done.stdout)
    assert done.returncode == 0 and out["stop"]["reason"] == "halt"
    assert [out["registers"][name] & 0xFFFFFFFF for name in ("R0", "R2", "R3")] == [0, 0, 0]
    first, second = out["reserved"]["addresses"]
    assert out["reserved"]["accesses"] == 5
    assert (first["address"], first["reads"], first["writes"], first["first"], first["pc"]) == (
        0x400000,
        2,
        0,
        "read",
        0x300003,
    )
    assert (second["address"], second["reads"], second["writes"], second["first"], second["value"]) == (
        0x400001,
        1,
        2,
        "write",
        5,
    )
    assert second["cycle"] > first["cycle"] and first["dma_channel"] is None
    text = run(emulator, program(tmp_path), "--board", ignoring).stdout
    assert "reserved addresses: 5 accesses, ignored\n  00400000h: read from PC 00300003h at cycle" in text
    assert "00400001h: write of 00000005h from PC 00300004h" in text and "1 reads, 2 writes" in text


def test_the_time_is_that_of_memory_without_wait_states(emulator: Path, tmp_path: Path) -> None:
    socket = '[[region]]\nname = "there"\nbase = 0x400000\nwords = 16\nbus = "local"\n'
    cycles = {}
    for name, text in (("ignored", 'reserved = "ignore"\n' + RAM), ("memory", RAM + socket)):
        done = run(emulator, program(tmp_path), "--board", board(tmp_path, text), "--json")
        out = json.loads(done.stdout)
        cycles[name] = out["cycles"]
    assert cycles["ignored"] == cycles["memory"]


def test_regions_say_it_for_themselves(emulator: Path, tmp_path: Path) -> None:
    ignore = '[[region]]\nname = "socket"\nkind = "ignore"\nbase = 0x400000\nwords = 2\n'
    fault = ignore.replace('"ignore"', '"fault"')
    assert run(emulator, program(tmp_path), "--board", board(tmp_path, RAM + ignore)).returncode == 0
    narrow = run(
        emulator, program(tmp_path), "--board", board(tmp_path, RAM + ignore.replace("words = 2", "words = 1"))
    )
    assert narrow.returncode == 1 and "write to 00400001h, which is reserved" in narrow.stdout
    kept = run(emulator, program(tmp_path), "--board", board(tmp_path, 'reserved = "ignore"\n' + RAM + fault))
    assert kept.returncode == 1 and "read of 00400000h, which is reserved" in kept.stdout


def test_the_chips_own_reserved_addresses_are_among_them(emulator: Path, tmp_path: Path) -> None:
    """The Hydra's monitor reads 00100100h on purpose (c40-hardware.md 1.1)."""
    source = program(tmp_path, PROGRAM.replace("ldhi    40h,ar0", "ldhi    10h,ar0\n or 100h,ar0"))
    for text in (
        'reserved = "ignore"\n' + RAM,
        RAM + '[[region]]\nname = "own"\nkind = "ignore"\nbase = 0x100100\nwords = 0x1FF700\n',
    ):
        done = run(emulator, source, "--board", board(tmp_path, text), "--json")
        assert done.returncode == 0 and json.loads(done.stdout)["reserved"]["addresses"][0]["address"] == 0x100100


def test_the_dma_is_ignored_too(emulator: Path, tmp_path: Path) -> None:
    done = run(emulator, program(tmp_path, DMA), "--board", board(tmp_path, 'reserved = "ignore"\n' + RAM), "--json")
    out = json.loads(done.stdout)
    assert done.returncode == 0, out["stop"]
    first, second = out["reserved"]["addresses"]
    assert (first["address"], first["first"], first["dma_channel"]) == (0x400000, "read", 0)
    assert (second["address"], second["first"], second["value"], second["dma_channel"]) == (0x90000000, "write", 0, 0)


def test_instructions_and_the_places_of_devices_stay_what_they_are(emulator: Path, tmp_path: Path) -> None:
    ignoring = board(tmp_path, 'reserved = "ignore"\n' + RAM + WINDOW)
    fetch = run(emulator, program(tmp_path, " ldhi 40h,ar0\n b ar0\n"), "--board", ignoring)
    assert fetch.returncode == 1 and "instruction fetch from 00400000h" in fetch.stdout
    window = run(emulator, program(tmp_path, " ldhi 0C000h,ar0\n ldi *ar0,r0\nd: b d\n"), "--board", ignoring)
    assert window.returncode == 1 and "external_access" in window.stdout
    low = run(emulator, program(tmp_path, " ldi 0,ar0\n ldi *ar0,r0\nd: b d\n"), "--board", ignoring)
    assert low.returncode == 1 and "read of 00000000h, which is reserved" in low.stdout


def test_a_network_ignores_them_chip_by_chip(emulator: Path, tmp_path: Path) -> None:
    ignoring = board(tmp_path, 'reserved = "ignore"\n' + RAM)
    done = run(emulator, program(tmp_path), "--topology", "ring:3", "--board", ignoring, "--json")
    chips = json.loads(done.stdout)["chips"]
    assert done.returncode == 0 and [chip["reserved"]["accesses"] for chip in chips] == [5, 5, 5]
    assert (
        run(emulator, program(tmp_path), "--topology", "ring:3", "--board", ignoring).stdout.count(
            "reserved addresses: 5 accesses"
        )
        == 3
    )
    network = cmrc.network.Network([cmrc.c40.assemble(PROGRAM)] * 2, links=["0.0:1.3"], boards=str(ignoring))
    network.run()
    assert [note["address"] for note in network.chips[1].reserved_accesses] == [0x400000, 0x400001]
    with pytest.raises(ValueError, match="no window that holds 16 words"):
        cmrc.network.Network(
            [cmrc.c40.assemble(PROGRAM)] * 2,
            memories=[cmrc.network.SharedMemory("m", 16, {0: 0x500000, 1: 0x500000})],
            boards=str(ignoring),
        )


def test_a_processor_reports_them_and_its_snapshots_hold_the_reports(tmp_path: Path) -> None:
    ignoring = board(tmp_path, 'reserved = "ignore"\n' + RAM)
    processor = cmrc.c40.Processor(cmrc.c40.assemble(PROGRAM), board=ignoring)
    processor.run(until=0x300006)
    kept = processor.snapshot()
    processor.run(1000)
    whole = processor.reserved_accesses
    assert [(note["address"], note["reads"], note["writes"]) for note in whole] == [(0x400000, 2, 0), (0x400001, 1, 2)]
    processor.restore(kept)
    assert [(note["address"], note["reads"], note["writes"]) for note in processor.reserved_accesses] == [
        (0x400000, 1, 0),
        (0x400001, 0, 2),
    ]
    processor.run(1000)
    assert processor.reserved_accesses == whole
    plain = cmrc.c40.Processor(cmrc.c40.assemble(PROGRAM))
    assert plain.run(1000).reason == "fault" and plain.reserved_accesses == []


def test_a_device_of_ones_own_comes_before_them(tmp_path: Path) -> None:
    class Seven:
        words = 1

        def read(self, offset: int, cycle: int) -> int:
            return 7

        def write(self, offset: int, value: int, cycle: int) -> None:
            raise AssertionError

    processor = cmrc.c40.Processor(
        cmrc.c40.assemble(PROGRAM), board=board(tmp_path, 'reserved = "ignore"\n' + RAM), devices={0x400000: Seven()}
    )
    processor.run(1000)
    assert processor.registers["R3"] & 0xFFFFFFFF == 7 and [
        note["address"] for note in processor.reserved_accesses
    ] == [0x400001]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('reserved = "open"\n' + RAM, "board.toml:1: reserved: fault or ignore is expected"),
        ("reserved = true\n" + RAM, "reserved: text in quotes is expected"),
        (
            RAM + '[[region]]\nname = "a"\nkind = "ignore"\nbase = 0x300000\nwords = 4\n',
            "region a (00300000h, 4 words): another region",
        ),
        (
            RAM + '[[region]]\nname = "a"\nkind = "fault"\nbase = 0x1000F0\nwords = 32\n',
            "an address of the chip itself is there",
        ),
        (RAM + '[[region]]\nname = "a"\nkind = "ignore"\nbase = 0x10\nwords = 4\n', "the boot ROM, or an address"),
        (RAM + 2 * '[[region]]\nname = "a"\nkind = "ignore"\nbase = 0x400000\nwords = 4\n', "another region"),
        (
            RAM + '[[region]]\nname = "a"\nkind = "ignore"\nbase = 0xFFFFFFFF\nwords = 2\n',
            "region.words of a: 1 to 1 words",
        ),
        (RAM + '[[region]]\nname = "a"\nkind = "ignore"\nbase = 0x400000\nwords = 0\n', "region.words of a"),
        (
            RAM + '[[region]]\nname = "a"\nkind = "ignore"\nbase = 0x400000\n',
            'region of kind "ignore": words is missing',
        ),
        (
            RAM + '[[region]]\nname = "a"\nkind = "ignore"\nbase = 0x400000\nwords = 4\nwaits = 1\n',
            "no such key region.waits",
        ),
        (
            RAM + '[[region]]\nname = "a"\nkind = "open"\nbase = 0x400000\nwords = 4\nbus = "local"\n',
            "ram, window (to a shared bus), fault or ignore",
        ),
        (
            'reserved = "ignore"\n' + RAM + '[[device]]\nname = "d"\nkind = "led"\nbase = 0x400000\n',
            "device.base of d: a device needs",
        ),
    ],
)
def test_what_is_wrong_in_a_board_file_is_named(emulator: Path, tmp_path: Path, text: str, message: str) -> None:
    done = run(emulator, program(tmp_path), "--board", board(tmp_path, text))
    assert done.returncode == 2 and message in done.stderr and "board.toml" in done.stderr, done.stderr


def test_all_that_is_wrong_is_reported_together(emulator: Path, tmp_path: Path) -> None:
    text = (
        'reserved = "open"\ngmicr = -1\n'
        + RAM
        + '[[region]]\nname = "a"\nkind = "ignore"\nbase = 0x300000\nwords = 4\nwaits = 1\n'
    )
    done = run(emulator, program(tmp_path), "--board", board(tmp_path, text))
    assert done.returncode == 2
    for message in (
        "board.toml:1: reserved: fault or ignore",
        "board.toml:2: gmicr",
        "board.toml:8: region a (00300000h",
        "board.toml:13: no such key region.waits",
    ):
        assert message in done.stderr, done.stderr


def test_steps_ignore_them_as_runs_do(tmp_path: Path) -> None:
    processor = cmrc.c40.Processor(cmrc.c40.assemble(PROGRAM), board=board(tmp_path, 'reserved = "ignore"\n' + RAM))
    for _ in range(8):
        processor.step()
    assert [(note["address"], note["reads"], note["writes"]) for note in processor.reserved_accesses] == [
        (0x400000, 2, 0),
        (0x400001, 1, 2),
    ]


def test_the_dock_refuses_such_a_board(emulator: Path, tmp_path: Path) -> None:
    windows = "".join(
        f'[[region]]\nname = "{bus}"\nkind = "window"\nbase = {base}\nwords = {words}\nbus = "{bus}"\n'
        for bus, base, words in (("local", 0x70000000, 0x10000000), ("global", 0xC0000000, 0x40000000))
    )
    done = subprocess.run(
        [emulator, "--duration", "0.1", "--board", board(tmp_path, 'reserved = "ignore"\n' + RAM + windows)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (
        done.returncode == 2
        and 'reserved: a DSP of the dock that leaves its memory has failed, and the run says where; "fault" is expected'
        in done.stderr
    )


# What the loader says


def test_a_section_outside_memory_is_an_error_with_the_nearest_regions(emulator: Path, tmp_path: Path) -> None:
    at = "section .text ({} words at {}) is not in RAM of board {}: nearest "
    source = program(tmp_path)
    for suffix, address, words in ((RAM + FAR, 0x600000, 9), (RAM, 0x600000, 9)):
        image = cmrc.c40.assemble(PROGRAM, sections={".text": address})
        cmrc.c40.write_coff(image, tmp_path / "p.out")
        done = run(emulator, tmp_path / "p.out", "--board", board(tmp_path, 'name = "mine"\n' + suffix))
        assert done.returncode == 2 and at.format(words, f"{address:08X}h", "mine") in done.stderr
        assert (
            "are the chip's own RAM (002FF800h to 002FFFFFh) and SRAM (00300000h to 0030FFFFh)" in done.stderr
            or "SRAM (00300000h to 0030FFFFh) and the chip's own RAM" in done.stderr
        )
        assert "docs/boards.md" in done.stderr and "--board flat" not in done.stderr
    network = run(emulator, tmp_path / "p.out", "--topology", "ring:2")
    assert (
        network.returncode == 2
        and "chip 0: section .text" in network.stderr
        and "local SRAM (00300000h to 003FFFFFh)" in network.stderr
    )
    with pytest.raises(IndexError, match=r"section \.text .* nearest are local SRAM"):
        cmrc.c40.Processor(cmrc.c40.read_coff(tmp_path / "p.out"))
    high = cmrc.c40.assemble(PROGRAM, sections={".text": 0xC0000000})
    cmrc.c40.write_coff(high, tmp_path / "p.out")
    window = run(emulator, tmp_path / "p.out")
    assert "nearest are the window window to bus A (C0000000h to FFFFFFFFh) and global SRAM (80000000h" in window.stderr
    assert source.exists()
