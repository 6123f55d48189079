"""emulator image and exec --rom: EPROMs from programs and back, over formats, widths and boot sources; formats against
objcopy."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest
from cmrc import c40
from command_line import emulator

SOURCE = """
        .sect   "prog"
        .word   0               ; the entry is not the section's beginning
start:  ldp     total
        ldi     5,r0
        ldi     0,r1
again:  addi    r0,r1
        subi    1,r0
        bnz     again
        sti     r1,@total
end:    b       end
        .data
        .word   12345678h
total:  .word   0
"""
FORMATS = ["intel-hex", "srec", "binary"]
SOURCES = ["300000h", "80000000h"]  # of the default board, of those that the pins can choose


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("image")
    (folder / "p.asm").write_text(SOURCE)
    done = emulator(
        "asm",
        folder / "p.asm",
        "-o",
        folder / "p.out",
        "--section",
        "prog=2FF900h",
        "--section",
        ".data=2FFA00h",
        "--entry",
        "start",
    )
    assert done.returncode == 0, done.stderr
    return folder / "p.out"


def made(program: Path, folder: Path, form: str, width: int) -> Path:
    out = folder / "rom"
    done = emulator("image", program, "--format", form, "--width", width, "-o", out)
    assert done.returncode == 0, done.stderr
    return out


@pytest.mark.parametrize("source", SOURCES)
@pytest.mark.parametrize("width", [8, 16, 32])
@pytest.mark.parametrize("form", FORMATS)
def test_a_program_boots_from_its_image(program: Path, tmp_path: Path, form: str, width: int, source: str) -> None:
    rom = made(program, tmp_path, form, width)
    done = emulator("exec", "--rom", f"{rom}@{source}", "--boot", source, "--dump", "2FFA00h:2")
    assert done.returncode == 0, done.stderr
    assert "branch to itself at 002FF908h" in done.stdout and "002FFA00: 12345678 0000000F" in done.stdout
    # With the program file given too, its symbols are known; the chip runs the ROM.
    named = emulator("exec", program, "--rom", f"{rom}@{source}", "--boot", source, "--dump", "total:1")
    assert named.stdout.count("0000000F") == done.stdout.count("0000000F")


@pytest.mark.skipif(shutil.which("objcopy") is None, reason="objcopy is not installed")
@pytest.mark.parametrize("width", [8, 32])
@pytest.mark.parametrize(("form", "target"), [("intel-hex", "ihex"), ("srec", "srec")])
def test_the_formats_are_those_of_objcopy(program: Path, tmp_path: Path, form: str, target: str, width: int) -> None:
    plain = made(program, tmp_path, "binary", width).read_bytes()
    rom = made(program, tmp_path, form, width)
    subprocess.run(["objcopy", "-I", target, "-O", "binary", rom, tmp_path / "theirs"], check=True)
    assert (tmp_path / "theirs").read_bytes() == plain
    (tmp_path / "plain").write_bytes(plain)
    subprocess.run(["objcopy", "-I", "binary", "-O", target, tmp_path / "plain", tmp_path / "rom2"], check=True)
    done = emulator("exec", "--rom", f"{tmp_path / 'rom2'}@300000h", "--boot", "300000h", "--dump", "2FFA01h:1")
    assert "002FFA01: 0000000F" in done.stdout, done.stderr


def test_an_image_of_more_than_64_kib_has_upper_addresses(tmp_path: Path) -> None:
    (tmp_path / "big.asm").write_text("start: b start\n .loop 30000\n .word $\n .endloop\n")
    rom = made(tmp_path / "big.asm", tmp_path, "intel-hex", 32)
    assert ":02000004000" in rom.read_text()
    done = emulator(
        "exec",
        "--rom",
        f"{rom}@80000000h",
        "--boot",
        "80000000h",
        "--dump",
        "307000h:1",
        "--dump",
        "307530h:1",
        "--max-cycles",
        "9000000",
    )
    assert "00307000: 00307000" in done.stdout and "00307530: 00307530" in done.stdout, done.stderr


def test_a_stream_for_a_port_is_what_exec_sends(program: Path, tmp_path: Path) -> None:
    done = emulator("image", program, "--format", "boot-stream", "-o", tmp_path / "stream")
    words = [int(line, 16) for line in (tmp_path / "stream").read_text().split()]
    # Two interface control registers; then the block at the entry: 8 words at 2FF901h.
    assert done.returncode == 0 and words[2:5] == [8, 0x2FF901, 0x1F70002F] and words[-4:-1] == [0, 0, 0]


def test_loads_pokes_and_values_waited_for(program: Path, tmp_path: Path) -> None:
    (tmp_path / "three").write_bytes(bytes([1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0]))
    done = emulator(
        "exec",
        program,
        "--load",
        f"{tmp_path / 'three'}@2FFB00h",
        "--poke",
        "2FFB01h=0ABh",
        "--poke",
        "total=7",
        "--until",
        "total == 15".replace(" ", ""),
        "--dump",
        "2FFB00h:3",
    )
    assert done.returncode == 0, done.stderr
    assert "until: 002FFA01h holds 0000000Fh" in done.stdout and "00000001 000000AB 00000003" in done.stdout
    at_once = emulator("exec", program, "--poke", "total=15", "--until", "total==15")
    assert "0 instructions" in at_once.stdout
    never = emulator("exec", program, "--until", "total==16")
    assert never.returncode == 0 and "halt" in never.stdout


REPEATS = """
start:  ldhi    002Fh,ar0
        or      0FB00h,ar0
        ldi     0,r0
        ldi     9,rc
        rptb    last
        addi    1,r0
last:   sti     r0,*ar0
        ldi     0,r1
        rpts    9
        addi    1,r1
        bd      there
        addi    1,r2
        addi    1,r2
slot:   addi    1,r2
        addi    99,r2
there:  sti     r2,*+ar0(1)
end:    b       end
"""


@pytest.mark.parametrize(
    ("until", "reason", "registers"),
    [
        (["last"], "reached", {"R0": 1}),
        (["2FFB00h==4"], "holds 00000004h", {"R0": 4}),
        (["2FFB00h==4", "2FFB00h==3"], "holds 00000003h", {"R0": 3}),
        (["slot"], "reached", {"R0": 10, "R1": 10, "R2": 2}),
        (["there", "slot", "2FFB01h==3"], "reached", {"R2": 2}),
        (["2FFB01h==3"], "holds 00000003h", {"R2": 3}),
        (["end", "2FFB00h==0FFFFFFFFh"], "reached", {"R2": 3}),
        (["0x2FFB00==10"], "holds 0000000Ah", {"R0": 10}),
    ],
)
def test_what_is_met_first_ends_the_run_also_in_repeats_and_delayed_branches(
    tmp_path: Path, until: list[str], reason: str, registers: dict[str, int]
) -> None:
    (tmp_path / "p.asm").write_text(REPEATS)
    done = emulator("exec", tmp_path / "p.asm", "--json", *(word for text in until for word in ("--until", text)))
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["stop"]["reason"] == "until" and reason in found["stop"]["message"]
    assert {name: found["registers"][name] & 0xFFFFFFFF for name in registers} == registers


def test_chips_of_a_network_are_poked_loaded_and_stopped(program: Path, tmp_path: Path) -> None:
    (tmp_path / "three").write_bytes(bytes([1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0]))
    done = emulator(
        "exec", program, program, "--poke", "1:total=0ABh", "--poke", "0:2FFB01h=total", "--load", f"{tmp_path / 'three'}@1:2FFB00h",
        "--until", "1:again", "--until", "end", "--dump", "0:2FFB00h:2", "--dump", "1:2FFB00h:3", "--dump", "1:total:1", "--dump", "0:total:1",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    for line in (
        "chip 0 002FFB00: 00000000 002FFA01",
        "chip 1 002FFB00: 00000001 00000002 00000003",
        "chip 1 002FFA01: 000000AB",
        "chip 0 002FFA01: 0000000F",
    ):
        assert line in done.stdout, done.stdout


def test_a_dma_may_write_the_value_that_is_waited_for(tmp_path: Path) -> None:
    (tmp_path / "dma.asm").write_text("""
start:  ldhi    0010h,ar0
        or      00A0h,ar0             ; channel 0
        ldhi    002Fh,r0
        or      0FB00h,r0
        sti     r0,*+ar0(1)             ; source
        addi    10h,r0
        sti     r0,*+ar0(4)             ; destination
        ldi     1,r1
        sti     r1,*+ar0(2)
        sti     r1,*+ar0(5)
        ldi     3,r1
        sti     r1,*+ar0(3)
        ldhi    00C0h,r1
        or      0004h,r1
        sti     r1,*ar0
here:   nop
        b       here
""")
    done = emulator(
        "exec", tmp_path / "dma.asm", "--poke", "2FFB02h=77h", "--until", "2FFB12h==77h", "--max-cycles", "2000"
    )
    assert "until: 002FFB12h holds 00000077h" in done.stdout, done.stdout + done.stderr


def test_an_intel_segment_counts_in_sixteen_bytes(tmp_path: Path) -> None:
    """Record type 2, of the 8086: segment 1000h begins at byte 10000h, word 4000h of 32 bits."""
    (tmp_path / "rom").write_text(":0400000001020304F2\n:020000021000EC\n:0400000005060708E2\n:00000001FF\n")
    words = c40.read_rom(tmp_path / "rom", width=32)
    assert len(words) == 0x4001 and (words[0], words[0x4000]) == (0x04030201, 0x08070605)


BROKEN = [
    (":020000040030CA\n", "ends without its last record"),
    (":0200000400", "an odd number|5 bytes|by its count"),
    (":0100000011EE\n:0100000011EF\n", "checksum is EFh; EEh is expected"),
    (":01000000AA55\n:01000000AA55\n:00000001FF\n", "2: address 0h has a byte already"),
    (":01000006AA4F\n:00000001FF\n", "record type 06h"),
    (":0G000000\n", "'G' is no hexadecimal digit"),
    (":00000001FF\n", "contains no byte"),
    (":0100000055AA\n:020000040FFFEC\n:0100000055AA\n:00000001FF\n", "span more than 64 MiB"),
    ("S1040000AA51\n", "ends without its last record"),
    ("S1040000AA51\nS5030002FA\nS9030000FC\n", "1 lines of data before this count, which says 2"),
    ("S5030001FB\nS9030000FC\n", "0 lines of data before this count, which says 1"),
    ("S1040000AA50\nS9030000FC\n", "checksum is 50h; 51h is expected"),
    ("S4040000AA51\n", "not S4"),
    ("S101FE\nS9030000FC\n", "ends within its address"),
    ("", "contains no byte"),
    ("abcdefgh", "does not say how wide it is; --rom-width"),
]


@pytest.mark.parametrize(("text", "message"), BROKEN)
def test_broken_images_are_refused_with_the_place(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "rom").write_text(text)
    done = emulator("exec", "--rom", f"{tmp_path / 'rom'}@300000h", "--boot", "300000h")
    assert done.returncode == 2
    assert any(part in done.stderr for part in message.split("|")), done.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["exec", "--rom", "ROM@300000h"], "needs --boot"),
        (["exec", "--rom", "ROM@300000h", "--boot", "0"], "through the port"),
        (["exec", "--rom", "ROM", "--boot", "300000h"], "is not FILE@ADDRESS"),
        (["exec", "--rom", "ROM@nowhere", "--boot", "300000h"], "nowhere"),
        (["exec", "--rom", "ROM@70000000h", "--boot", "300000h"], "do not lie in memory"),
        (["exec", "--rom", "ROM@300000h", "--boot", "300000h", "--rom-width", "12"], "--rom-width"),
        (["exec", "PROGRAM", "--rom-width", "8"], "needs --rom"),
        (["exec", "PROGRAM", "--poke", "5"], "is not ADDRESS=WORD"),
        (["exec", "PROGRAM", "--poke", "70000000h=5"], "do not lie in memory"),
        (["exec", "PROGRAM", "--poke", "total=what"], "behind ="),
        (["exec", "PROGRAM", "--load", "/nowhere@2FF800h"], "/nowhere"),
        (["exec", "PROGRAM", "--until", "70000000h==5"], "no memory of this board"),
        (
            ["exec", "PROGRAM", "PROGRAM", "--link", "0.0:1.3", "--poke", "total=5"],
            '"total=5" is not CHIP:ADDRESS=WORD, which a network needs',
        ),
        (["exec", "PROGRAM", "PROGRAM", "--poke", "2:total=5"], 'there is no chip "2"; 0 to 1 are possible'),
        (["exec", "PROGRAM", "PROGRAM", "--load", "ROM@2FF800h"], "is not FILE@CHIP:ADDRESS, which a network needs"),
        (["exec", "PROGRAM", "PROGRAM", "--load", "ROM@7:2FF800h"], 'there is no chip "7"'),
        (["exec", "PROGRAM", "PROGRAM", "--until", "total==5"], "the value of a word ends a run of one chip"),
        (["exec", "PROGRAM", "PROGRAM", "--until", "0:end", "--until", "0:again"], "chip 0 ends at 002FF908h already"),
        (["exec", "PROGRAM", "PROGRAM", "--until", "end", "--until", "again"], "every chip has an end already"),
        (["exec", "PROGRAM", "--until", "again", "--until", "nowhere"], '"nowhere" is neither a symbol of the program'),
        (["exec", "PROGRAM", "--until", "agan"], 'decimal); did you mean "again"?'),
        (["exec", "PROGRAM", "--until", "total=5"], '"total=5" is neither a symbol of the program'),
        (["image", "PROGRAM", "--format", "tape", "-o", "OUT"], "--format"),
        (["image", "PROGRAM", "--format", "binary", "--width", "12", "-o", "OUT"], "--width"),
        (["image", "PROGRAM", "--format", "boot-stream", "--width", "8", "-o", "OUT"], "a port takes words of 32 bits"),
        (["image", "PROGRAM", "--format", "binary", "-o", "PROGRAM"], "PROGRAM"),
        (["image", "/nowhere.out", "--format", "binary", "-o", "OUT"], "no such file"),
    ],
)
def test_what_makes_no_sense_is_refused(program: Path, tmp_path: Path, arguments: list[str], message: str) -> None:
    rom = made(program, tmp_path, "binary", 8)
    before = program.read_bytes()
    names = {"ROM": str(rom), "PROGRAM": str(program), "OUT": str(tmp_path / "out")}
    given = [names.get(word, word.replace("ROM@", f"{rom}@")) for word in arguments]
    done = emulator(*given)
    assert done.returncode == 2 and message.replace("PROGRAM", str(program)) in done.stderr, done.stderr
    assert program.read_bytes() == before and not (tmp_path / "out").exists()


def test_a_program_below_the_boot_rom_cannot_be_booted(tmp_path: Path) -> None:
    (tmp_path / "low.asm").write_text("start: b start\n")
    out = tmp_path / "low.out"
    emulator("asm", tmp_path / "low.asm", "-o", out, "--section", ".text=100h")
    done = emulator("image", out, "--format", "binary", "-o", tmp_path / "rom")
    assert done.returncode == 2 and "the boot ROM is there" in done.stderr and not (tmp_path / "rom").exists()
