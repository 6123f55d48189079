"""Images over every boot source, width and format; texts of EPROMs with odd records."""

from pathlib import Path

import pytest
from command_line import emulator

SOURCES = {
    0x300000: "1101",
    0x40000000: "1011",
    0x60000000: "1001",
    0x80000000: "0111",
    0xA0000000: "0101",
    0xC0000000: "0011",
}
BOARD = 'name = "b"\n[pins]\nromen = true\niiof = "{iiof}"\n[[region]]\nname = "EPROM"\nbase = 0x{base:X}\nwords = {words}\nbus = "{bus}"\n'
PROGRAM = "start: ldi 42,r5\n ldi @total,r6\nend: b end\n .data\ntotal: .word 1234h\n"


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sources")
    (folder / "p.asm").write_text(PROGRAM.replace("start:", "start: ldp @total\n"))
    done = emulator(
        "asm", folder / "p.asm", "-o", folder / "p.out", "--section", ".text=2FFC00h", "--section", ".data=2FFD00h"
    )
    assert done.returncode == 0, done.stderr
    return folder / "p.out"


@pytest.mark.parametrize("width", [8, 16, 32])
@pytest.mark.parametrize("source", SOURCES)
def test_every_source_and_width_boots_every_format(program: Path, tmp_path: Path, source: int, width: int) -> None:
    text = BOARD.format(iiof=SOURCES[source], base=source, words=0x200, bus="global" if source >> 31 else "local")
    (tmp_path / "b.toml").write_text(text)
    for form in ("intel-hex", "srec", "binary"):
        made = emulator(
            "image", program, "--format", form, "--width", width, "--board", tmp_path / "b.toml", "-o", tmp_path / "rom"
        )
        assert made.returncode == 0, made.stderr
        (tmp_path / "c.toml").write_text(text + 'file = "rom"\n')  # the same, as a region's contents
        for given in (
            ("--board", tmp_path / "b.toml", "--rom", f"{tmp_path / 'rom'}@{source:#x}", "--boot", f"{source:#x}"),
            ("--board", tmp_path / "c.toml", "--boot", "reset"),
        ):
            done = emulator("exec", *given)
            assert done.returncode == 0, done.stderr
            assert "R5  800000002A" in done.stdout and "R6  8000001234" in done.stdout, done.stdout
    (tmp_path / "d.toml").write_text(text.replace(f"words = {0x200}", "words = 8") + 'file = "rom"\n')
    small = emulator("exec", "--board", tmp_path / "d.toml", "--boot", "reset")
    assert (
        small.returncode == 2
        and "d.toml:10: region.file of EPROM: " in small.stderr
        and "words do not go into 8" in small.stderr
    ), small.stderr


@pytest.mark.parametrize("port", range(6))
def test_every_port_boots(program: Path, port: int) -> None:
    done = emulator("exec", program, "--boot", port)
    assert done.returncode == 0 and "R5  800000002A" in done.stdout and "R6  8000001234" in done.stdout, done.stderr


def intel(*records: tuple[int, int, bytes], end: str = "\n") -> str:
    lines = []
    for kind, address, data in records:
        line = bytes([len(data), address >> 8, address & 0xFF, kind]) + data
        lines.append(":" + (line + bytes([-sum(line) & 0xFF])).hex().upper())
    return end.join(lines) + end


def motorola(*records: tuple[int, int, bytes], end: str = "\n") -> str:
    size = {0: 2, 1: 2, 2: 3, 3: 4, 5: 2, 7: 4, 8: 3, 9: 2}
    lines = []
    for kind, address, data in records:
        line = bytes([size[kind] + len(data) + 1]) + address.to_bytes(size[kind], "big") + data
        lines.append(f"S{kind}" + (line + bytes([~sum(line) & 0xFF])).hex().upper())
    return end.join(lines) + end


LOW, HIGH, LAST = (0, 0, b"\x01\x02\x03\x04"), (0, 4, b"\x05\x06\x07\x08"), (1, 0, b"")
BYTES = {
    "in order": intel(LOW, HIGH, LAST),
    "the last first": intel(HIGH, LOW, LAST),
    "blank lines and DOS ends": "\r\n\r\n" + intel(LOW, HIGH, LAST, end="\r\n\r\n"),
    "blanks before, lower case": "  " + intel(LOW, HIGH, LAST).lower().replace("\n", "\n\t"),
    "DOS end of file": intel(LOW, HIGH, LAST) + "\x1a",
    "no line end at the end": intel(LOW, HIGH, LAST).rstrip("\n"),
    "segments": intel((2, 0, b"\x10\x00"), LOW, (2, 0, b"\x0f\xff"), (0, 0x14, b"\x05\x06\x07\x08"), LAST),
    "upper addresses": intel((4, 0, b"\x00\x01"), LOW, (4, 0, b"\x00\x01"), HIGH, (5, 0, b"\0\0\0\0"), LAST),
    "a start of the 8086": intel((3, 0, b"\0\0\0\0"), LOW, HIGH, LAST),
    "S1": motorola((0, 0, b"HDR"), (1, 0, LOW[2]), (1, 4, HIGH[2]), (5, 2, b""), (9, 0, b"")),
    "S2 and S3, the last first": motorola((3, 0x10004, HIGH[2]), (2, 0x10000, LOW[2]), (8, 0, b"")),
    "S, blank lines and DOS ends": "\r\n"
    + motorola((1, 0, LOW[2]), (1, 4, HIGH[2]), (9, 0, b""), end="\r\n \r\n")
    + "\x1a",
}


@pytest.mark.parametrize("name", BYTES)
def test_records_in_any_order_and_lines_of_any_end_are_one_image(tmp_path: Path, name: str) -> None:
    (tmp_path / "p.asm").write_text("start: b start\n")
    (tmp_path / "rom").write_text(BYTES[name], newline="")
    done = emulator("exec", tmp_path / "p.asm", "--load", f"{tmp_path / 'rom'}@2FFB00h", "--dump", "2FFB00h:3")
    assert done.returncode == 0, done.stderr
    assert "002FFB00: 04030201 08070605 00000000" in done.stdout


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (intel(LOW, LAST, HIGH), "rom:3: a record after the last one"),
        (intel(LOW, LAST) + intel(LOW, LAST), "rom:3: a record after the last one"),
        (motorola((1, 0, LOW[2]), (9, 0, b""), (1, 4, HIGH[2])), "rom:3: a record after the last one"),
        (motorola((1, 0, LOW[2]), (5, 2, b""), (9, 0, b"")), "rom:2: 1 lines of data before this count, which says 2"),
        (intel(LOW, (0, 2, HIGH[2]), LAST), "rom:2: address 2h has a byte already"),
        (intel(LOW, (4, 0, b"\0"), LAST), "rom:2: an address record holds 2 bytes"),
        ("\r\n\r\n" + intel(LOW, LAST).replace("01020304", "01020305"), "rom:3: the checksum is F2h; F1h is expected"),
        ("\n" + intel(LOW), "rom:2: the file ends without its last record: it is cut short"),
        (intel(LOW, HIGH, LAST).replace(":04000400", ":0400040"), "rom:2: an odd number of digits"),
        (intel(LOW) + "; made by hand\n" + intel(LAST), "rom:2: a line of Intel hex begins with ':'"),
    ],
)
def test_what_is_no_image_is_refused_with_its_line(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "p.asm").write_text("start: b start\n")
    (tmp_path / "rom").write_text(text, newline="")
    done = emulator("exec", tmp_path / "p.asm", "--load", f"{tmp_path / 'rom'}@2FFB00h")
    assert done.returncode == 2 and message in done.stderr, done.stderr


@pytest.mark.parametrize(
    ("roms", "message"),
    [
        (("rom@300000h", "rom@300004h"), "overlap those of"),
        (("rom@3001FCh",), "do not lie in memory"),
        (("cut@300000h",), "stop: "),
    ],
)
def test_images_that_overlap_do_not_fit_or_are_cut_short(
    program: Path, tmp_path: Path, roms: tuple[str, ...], message: str
) -> None:
    (tmp_path / "b.toml").write_text(BOARD.format(iiof="1101", base=0x300000, words=0x200, bus="local"))
    assert emulator("image", program, "--format", "binary", "--width", 8, "-o", tmp_path / "rom").returncode == 0
    (tmp_path / "cut").write_bytes((tmp_path / "rom").read_bytes()[:30])
    done = emulator(
        "exec",
        "--board",
        tmp_path / "b.toml",
        "--boot",
        "300000h",
        "--max-cycles",
        100000,
        *(word for rom in roms for word in ("--rom", tmp_path / rom)),
    )
    assert done.returncode in (1, 2) and (message in done.stderr or done.returncode == 1 and "stop: " in done.stdout), (
        done.stdout[:300] + done.stderr
    )


@pytest.mark.parametrize(("width", "read_as"), [(8, 16), (8, 32), (16, 8), (16, 32), (32, 8), (32, 16)])
def test_a_stream_of_another_width_than_its_memory_is_warned_of_and_the_loader_is_named(
    program: Path, tmp_path: Path, width: int, read_as: int
) -> None:
    assert emulator("image", program, "--format", "binary", "--width", width, "-o", tmp_path / "rom").returncode == 0
    done = emulator(
        "exec",
        "--rom",
        f"{tmp_path / 'rom'}@80000000h",
        "--rom-width",
        read_as,
        "--boot",
        "80000000h",
        "--max-cycles",
        200_000,
    )
    assert done.returncode == 1
    assert (
        f"rom: warning: its first word says {width} bits, as to a boot loader, and --rom-width {read_as}" in done.stderr
    )
    first = done.stdout.splitlines()[0]
    assert (
        "this is the boot loader, which reads the stream at 80000000h: a whole one is expected, in memory of the width that its first word says"
        in first
    ), first


def test_a_stream_that_is_cut_short_in_its_header_or_leads_nowhere_names_the_loader(tmp_path: Path) -> None:
    head = (32, 0x1DEA4000, 0x1DEA4000)
    for words in (head[:1], (*head, 2, 0x50000000, 1, 2, 0, 0, 0, 0)):
        (tmp_path / "rom").write_bytes(b"".join(word.to_bytes(4, "little") for word in words))
        done = emulator(
            "exec", "--rom", f"{tmp_path / 'rom'}@80000000h", "--boot", "80000000h", "--max-cycles", 200_000
        )
        assert (
            done.returncode == 1
            and "this is the boot loader, which reads the stream at 80000000h" in done.stdout.splitlines()[0]
        ), done.stdout[:300]
