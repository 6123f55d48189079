"""Board files: everything that is wrong at once, and the boards of examples/, each with a small program on it."""

from __future__ import annotations

from pathlib import Path

import pytest
from board_parts import END, HEAD, START, assembled, board, device, low
from cmrc.c40 import Processor
from command_line import emulator
from locations import ROOT

EXAMPLES = ROOT / "examples"


def refused(tmp_path: Path, text: str) -> list[str]:
    (tmp_path / "b.toml").write_text(text)
    (tmp_path / "p.asm").write_text(START + END)
    done = emulator("exec", tmp_path / "p.asm", "--board", tmp_path / "b.toml")
    assert done.returncode == 2, done.stdout
    return [line for line in done.stderr.splitlines() if "b.toml" in line]


def test_all_errors_are_reported_together_with_their_lines(tmp_path: Path) -> None:
    text = "clock_mhz = -1\ngmicrr = 5\n" + HEAD.replace(
        'words = 0x10000\nbus = "local"', 'words = 0x10000\nbuss = "local"\nwaits = 99\nbus = "locale"'
    )
    text += (
        device("fofo")
        + device("timer", 0xA0000010, name="T", pin="IIOF7", count_cycles=0, dept=4)
        + device("led", 0xB0000000, name="lamp", depth=3)
        + "\n[pins]\nromem = true\n"
    )
    errors = refused(tmp_path, text)
    expected = [
        (1, "clock_mhz: a number from 0.001 to 1000 is expected"),
        (
            2,
            'no such key gmicrr; known are name, clock_mhz, gmicr, lmicr, pins, reserved, region, device; did you mean "gmicr"?',
        ),
        (10, "no such key region.buss"),
        (11, "region.waits: an integer from 0 to 15"),
        (12, "region.bus of RAM: local or global is expected"),
        (
            23,
            'device.kind of D: "fofo" is unknown; console, registers, led, fifo, mailbox, timer, vic068a, vme is expected; did you mean "fifo"?',
        ),
        (30, "device.pin of T: IIOF0 to IIOF3 or NMI is expected"),
        (31, "device.count_cycles of T: an integer from 1"),
        (32, "no such key device.dept"),
        (38, "device.depth of lamp: a led has none; fifo has"),
        (41, 'no such key pins.romem; known are romen, resetloc, iiof; did you mean "romen"?'),
    ]
    assert len(errors) == len(expected), "\n".join(errors)
    for (line, message), error in zip(expected, errors, strict=True):
        assert f"b.toml:{line}: {message}" in error


def test_a_missing_key_or_name_hides_no_other_error(tmp_path: Path) -> None:
    text = '[[region]]\nname = "RAM"\nbus = "locall"\nwaits = 99\nkind = "rom"\n[pins]\nromen = 1\niiof = "11"\n[[device]]\nkind = "leds"\n'
    expected = [
        "1: region 1: base is missing",
        "1: region 1: words is missing",
        "3: region.bus of RAM: local or global is expected",
        "4: region.waits: an integer from 0 to 15 is expected",
        "5: region.kind of RAM: ram, window (to a shared bus), fault or ignore is expected",
        "7: pins.romen: true (the boot ROM is at 0) or false is expected",
        '8: pins.iiof: the levels of IIOF3 to IIOF0 are expected, as "1111"',
        "9: device 1: name is missing",
        '10: device.kind of 1: "leds" is unknown; console, registers, led, fifo, mailbox, timer, vic068a, vme is expected; did you mean "led"?',
    ]
    errors = refused(tmp_path, text)
    assert [error.partition("b.toml:")[2] for error in errors] == expected


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ("words = 0", "region.words of RAM: 1 to"),
        ("waits = 99", "region.waits: an integer from 0 to 15"),
        ("page_waits = -1", "region.page_waits: an integer from 0 to 15"),
        ('kind = "rom"', "region.kind of RAM: ram, window"),
        ("name = 3", "region.name: text in quotes is expected"),
    ],
)
@pytest.mark.parametrize(
    ("base", "bus"), [("0x300000", "global"), ("0x90000000", "local"), ("0x300000", "lokal"), ("-1", "lokal")]
)
def test_a_wrong_bus_of_a_region_is_reported_beside_any_other_error(
    tmp_path: Path, wrong: str, message: str, base: str, bus: str
) -> None:
    keys = {"name": 'name = "RAM"', "base": f"base = {base}", "words": "words = 16", "bus": f'bus = "{bus}"'}
    keys[wrong.partition(" ")[0]] = wrong
    errors = refused(tmp_path, "[[region]]\n" + "\n".join(keys.values()) + "\n")
    assert sum("region.bus of " in error for error in errors) == 1, errors
    if base != "-1" or "words" not in wrong:
        assert any(message.replace("RAM", "1" if "name" in wrong else "RAM") in error for error in errors), errors


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (device("led") + device("led", 0xA0000000, name="E"), "device.base of E: D is there, at A0000000h"),
        (device("led") + device("led", 0xA0000010), "device.name: two devices have the name D"),
        (device("fifo", input="nowhere"), "device.input of D:"),
        (device("fifo", input="b.toml"), "is not a word; a word of up to 8 hexadecimal digits"),
        (device("fifo", input="b.toml", script="b.toml"), "the words come from input already"),
        (device("vme"), "words is missing"),
        (device("vme", words=4, vic="V"), 'no [[device]] of kind "vic068a" named V comes before it'),
        (device("vme", words=4, answer="maybe"), '"bus error" or "ignored"'),
        (device("mailbox", depth=2), "device.depth of D: a mailbox has none; fifo has"),
        (device("fifo", words=2), "a fifo has its 5 words"),
        (device("vic068a", 0xA000FFF0), "needs a"),
        ("\n[[device]]\n", "kind is missing"),
        (device("led", name=""), "device.name: \"\" cannot be used: a name is a text without '=', and not empty"),
        (device("led", name="a=b"), "device.name: \"a=b\" cannot be used: a name is a text without '='"),
        (device("a\\u0000b"), 'device.kind of D: "a\\x00b" is unknown; console, registers'),
    ],
)
def test_a_device_that_cannot_be_is_refused(tmp_path: Path, text: str, message: str) -> None:
    errors = refused(tmp_path, HEAD + text)
    assert any(message in error for error in errors), errors


@pytest.mark.parametrize(
    ("image", "message"),
    [(b":10", "rom"), (b"\x01\x02\x03", "width"), (b"\0" * 0x10001 * 4, "do not go into")],
)
def test_a_rom_that_is_cut_short_or_too_large_is_refused(tmp_path: Path, image: bytes, message: str) -> None:
    (tmp_path / "rom").write_bytes(image)
    width = "" if b"\x01" in image else "\nwidth = 32"
    errors = refused(tmp_path, HEAD.replace('bus = "local"', f'bus = "local"\nfile = "rom"{width}'))
    assert len(errors) == 1 and message in errors[0], errors


@pytest.mark.parametrize(
    ("second", "overlaps"),
    [
        ("2FFFC1h", "002FFFC1h to 00300000h"),
        ("300020h", "00300020h to 0030005Fh"),
        ("30003Fh", "0030003Fh to 0030007Eh"),
        ("2FFFC0h", None),
        ("300040h", None),
    ],
)
def test_roms_that_overlap_are_refused_and_those_that_touch_are_not(
    tmp_path: Path, second: str, overlaps: str | None
) -> None:
    for name in ("a", "b"):
        (tmp_path / name).write_bytes(b"\x08\0\0\0" + b"\0" * 60)
    roms = ("--rom", f"{tmp_path / 'a'}@300000h", "--rom", f"{tmp_path / 'b'}@{second}")
    done = emulator("exec", *roms, "--boot", "300000h", "--cycles", 100)
    if overlaps is None:
        assert done.returncode == 0, done.stderr
    else:
        assert done.returncode == 2 and f"its words {overlaps} overlap those of" in done.stderr, done.stderr


SRAM_TEST = """
        ldhi {base}h,ar3
        ldi 123,r0
        sti r0,*ar3
        ldi *ar3,r4
"""


def test_regions_without_a_name_are_numbered_as_in_the_file(tmp_path: Path) -> None:
    (tmp_path / "b.toml").write_text("[[region]]\nname = 'a'\n[[region]]\nname = 'b'\n")
    with pytest.raises(ValueError) as info:
        Processor(board=tmp_path / "b.toml")
    assert "b.toml:1: region 1: base is missing" in str(info.value)
    assert "b.toml:3: region 2: base is missing" in str(info.value)


def test_a_program_boots_on_the_dakar_f5_and_meets_its_registers() -> None:
    text = (
        SRAM_TEST.format(base="0c030")
        + "        ldhi 0c022h,ar4\n        or 30h,ar4\n        ldi 77,r0\n        sti r0,*+ar4(7)\n        ldi *+ar4(7),r5\n        ldhi 10h,ar5\n        ldi *ar5,r6\n"
    )
    processor = Processor(assembled(text + END), board=EXAMPLES / "dakar_f5.toml")
    assert processor.run(until="done").reason == "until"
    assert (low(processor, "R4"), low(processor, "R5"), low(processor, "R6")) == (123, 77, 0x3D840000)


def test_a_program_boots_on_the_tdm435() -> None:
    text = (
        SRAM_TEST.format(base="03f") + "        ldhi 0bd00h,ar4\n        sti r0,*+ar4(0ch)\n        ldi *+ar4(0ch),r5\n"
    )
    processor = Processor(assembled(text + END), board=EXAMPLES / "tdm435.toml")
    assert processor.run(until="done").reason == "until" and (low(processor, "R4"), low(processor, "R5")) == (123, 123)
    beyond = Processor(
        assembled("        ldhi 0b000h,ar4\n        ldi *ar4,r5\n" + END), board=EXAMPLES / "tdm435.toml"
    )
    assert beyond.run(until="done").reason == "external_access"


def test_a_program_sets_up_the_hydras_bridge() -> None:
    """Register 27h of the VIC is at BFFF0009h: (FFFC0000h or 27h) / 4, as the monitor's writeVIC() has it."""
    text = (
        SRAM_TEST.format(base="0c000")
        + "        ldhi 0bfffh,ar4\n        ldi 55h,r0\n        sti r0,*+ar4(9)\n        ldi *+ar4(9),r5\n        ldi *+ar4(1dh),r6\n"
    )
    processor = Processor(assembled(text + END), board=EXAMPLES / "hydra.toml")
    assert processor.run(until="done").reason == "until"
    assert (low(processor, "R4"), low(processor, "R5"), low(processor, "R6")) == (123, 0x55, 0xF1)


def test_every_board_of_the_page_loads() -> None:
    page = (ROOT / "docs" / "boards.md").read_text()
    for path in sorted(EXAMPLES.glob("*.toml")):
        if "[[region]]" in path.read_text():
            assert f"examples/{path.name}" in page
            Processor(board=path)


def test_devices_and_classes_share_no_address(tmp_path: Path) -> None:
    class Own:
        words = 1

        def read(self, offset: int, cycle: int) -> int:
            return 0

        def write(self, offset: int, value: int, cycle: int) -> None:
            pass

    with pytest.raises(ValueError, match=r"device Own at A0000000h: D is there"):
        Processor(board=board(tmp_path, device("led")), devices={0xA0000000: Own()})
