"""What devices are sent: files, standard input and its recording, host scripts; the run's hash; errors."""

from __future__ import annotations

import hashlib
import json
import subprocess
from pathlib import Path

import pytest
from board_parts import END, HEAD, START, assembled, board, device, low
from cmrc.c40 import Processor
from command_line import emulator
from locations import BUILD

# Sends back what is typed, in capitals, until a full stop.
SHOUT = (
    "wait:   ldi *+ar2(1),r0\n        tstb 1,r0\n        bz wait\n        ldi *ar2,r1\n        cmpi 2eh,r1\n        bz done\n        andn 20h,r1\n        sti r1,*ar2\n        b wait\n"
    + END
)


@pytest.fixture
def shout(tmp_path: Path) -> list[object]:
    (tmp_path / "p.asm").write_text(START + SHOUT)
    return ["exec", tmp_path / "p.asm", "--board", board(tmp_path, device("console", name="TTY")), "--json"]


def test_standard_input_is_recorded_and_replayed(shout: list[object], tmp_path: Path) -> None:
    record = tmp_path / "record"
    first = json.loads(emulator(*shout, "--console-input", "-", "--console-record", record, stdin="hello.").stdout)
    assert first["console"] == "HELLO" and record.read_text().startswith("at 0 0x68")
    replayed = json.loads(emulator(*shout, "--device-script", f"TTY={record}").stdout)
    assert replayed["hash"] == first["hash"] and replayed["cycles"] == first["cycles"]
    (tmp_path / "typed").write_text("hellO.")
    other = json.loads(emulator(*shout, "--console-input", tmp_path / "typed").stdout)
    assert (
        other["console"] == "HELLO"
        and other["hash"] != first["hash"]
        and other["inputs"][0]["sha256"] != first["inputs"][0]["sha256"]
    )


def test_a_live_run_replays_from_its_recording(shout: list[object], tmp_path: Path) -> None:
    """Typed input arrives at any time: the recording has the cycles."""
    record = tmp_path / "record"
    command = [
        str(word)
        for word in (
            BUILD / "bin" / "emulator",
            *shout,
            "--console-input",
            "live",
            "--console-record",
            record,
            "--max-cycles",
            10**10,
        )
    ]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as running:
        assert running.stdin is not None
        for text in ("ab", "c."):
            running.stdin.write(text)
            running.stdin.flush()
        live = json.loads(running.communicate(timeout=60)[0])
    assert live["console"] == "ABC"
    replayed = json.loads(emulator(*shout, "--device-script", f"TTY={record}").stdout)
    assert (replayed["hash"], replayed["cycles"], replayed["console"]) == (live["hash"], live["cycles"], "ABC")


def test_a_script_answers_what_the_program_sends(tmp_path: Path) -> None:
    """Each step of the script waits for its condition, in this order."""
    (tmp_path / "host").write_text('# a host\non 3Eh "ok\\n"\nafter 3 0x2, 3\nat 2000 4\nafter 3 5\nwait 100 6h\n')
    text = "        ldi 0,r4\n"
    for sent in (0x3E, 1, 2):
        text += f"        ldi {sent},r0\n        sti r0,*ar2\n"
    text += (
        "        ldi 0,r5\nloop:   ldi *+ar2(2),r0\n        bz loop\n        ldi *ar2,r3\n        addi 1,r5\n        mpyi 10,r4\n        addi r3,r4\n        cmpi 8,r5\n        blt loop\n"
        + END
    )
    processor = Processor(assembled(text), board=board(tmp_path, device("fifo", script="host")))
    assert processor.run(10_000, until="done").reason == "until" and processor.cycles > 2100
    expected = 0
    for word in (*b"ok\n", 2, 3, 4, 5, 6):
        expected = expected * 10 + word
    assert low(processor, "R4") == expected
    with pytest.raises(ValueError, match="there is no device X; the board has D"):
        processor.send("X", [1])
    with pytest.raises(ValueError, match=r"script:1: .*at CYCLE"):
        processor.send_script("D", "soon 3")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("later 5 1", 'host:1: "later": at CYCLE, wait CYCLES, after COUNT or on WORD'),
        ("\n\nat", 'host:3: "": a number'),
        ("at x 1", 'host:1: "x": a number'),
        ("at 5", "host:1: there is no word to send"),
        ("at 5 123456789h", '"123456789h" is not a word'),
        ('on 1 "abc', "does not end in this line"),
        ('on 1 "a\\q"', r"\q: "),
    ],
)
def test_a_script_that_makes_no_sense_is_refused_with_its_line(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "host").write_text(text)
    (tmp_path / "p.asm").write_text(START + END)
    done = emulator("exec", tmp_path / "p.asm", "--board", board(tmp_path, device("mailbox", script="host")))
    assert done.returncode == 2 and message in done.stderr and "board.toml:" in done.stderr, done.stderr


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--device-input", "D=/nowhere"), "/nowhere"),
        (("--device-input", "E=/nowhere"), "there is no device E that takes or sends words; D is expected"),
        (("--device-input", "D"), "is not NAME=FILE"),
        (("--device-output", "lamp=x"), "there is no device lamp"),
        (("--console-input", "-"), 'no [[device]] of kind "console"'),
        (("--console-record", "x"), "needs --console-input"),
    ],
)
def test_inputs_that_cannot_be_are_refused(tmp_path: Path, options: tuple[str, ...], message: str) -> None:
    (tmp_path / "p.asm").write_text(START + END)
    path = board(tmp_path, device("fifo"), device("led", 0xA0000100, name="lamp"))
    done = subprocess.run(
        [str(BUILD / "bin" / "emulator"), "exec", str(tmp_path / "p.asm"), "--board", str(path), *options],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 2 and message in done.stderr, done.stderr
    assert not (tmp_path / "x").exists()


TWICE = [
    (("--device-input F=1", "--device-input F=2"), "gives the input of F"),
    (("--device-input F=1", "--device-script F=2"), "gives the input of F"),
    (("--device-script C=1", "--device-script C=2"), "gives the input of C"),
    (("--console-input 1", "--device-input C=2"), "gives the input of C"),
    (("--console-input -", "--device-input F=-"), "reads standard input"),
    (("--console-input live", "--device-input F=-"), "reads standard input"),
    (("--device-input F=-", "--device-script C=-"), "reads standard input"),
    (("--console-input -", "--device-input F=/dev/stdin"), "reads standard input"),
    (("--console-input /dev/fd/0", "--device-input F=-"), "reads standard input"),
]


@pytest.mark.parametrize(("options", "does"), TWICE, ids=[" ".join(options) for options, _ in TWICE])
@pytest.mark.parametrize("chips", [1, 2])
def test_two_options_for_one_input_are_refused_and_both_are_named(
    tmp_path: Path, options: tuple[str, str], does: str, chips: int
) -> None:
    """One of them was dropped without a word. In a network each chip has a board of its own."""
    (tmp_path / "p.asm").write_text(START + END)
    for name in "12":
        (tmp_path / name).write_text("at 0 1\n" if "script" in options[int(name) - 1] else name)
    path = board(tmp_path, device("fifo", name="F"), device("console", 0xA0000010, name="C"))
    given = [word for option in options for word in option.split()]
    run = ["exec", "p.asm", "--board", path]
    if chips == 2:
        if "--console-input live" in options:
            return  # refused for networks
        (tmp_path / "bare.toml").write_text(HEAD)
        run = ["exec", "p.asm", "p.asm", "--board", path, "--board", "bare.toml"]
    done = emulator(*run, *given, folder=tmp_path)
    assert done.returncode == 2 and done.stderr == f"emulator: {options[1]}: {options[0]} {does} already\n", done.stderr


def test_an_option_comes_before_the_board_file_and_may_write_an_output_twice(tmp_path: Path) -> None:
    (tmp_path / "p.asm").write_text(START + "        ldi *ar2,r3\n        sti r3,*ar2\n" + END)
    (tmp_path / "given").write_text("1")
    (tmp_path / "other").write_text("2")
    outputs = ["--device-output", "D=a", "--device-output", "D=b"]
    run = ["exec", "p.asm", "--board", board(tmp_path, device("fifo", input="given"))]
    assert emulator(*run, "--device-input", "D=other", *outputs, folder=tmp_path).returncode == 0
    assert (tmp_path / "a").read_text() == (tmp_path / "b").read_text() == "00000002\n"


def test_a_debugger_leaves_standard_input_to_its_commands(tmp_path: Path) -> None:
    (tmp_path / "p.asm").write_text(START + END)
    (tmp_path / "x=-").write_text("at 1 2\n")
    devices = board(tmp_path, device("fifo"), device("console", 0xA0000010, name="C"))
    for option, given in [
        ("--device-input", "D=-"),
        ("--device-script", "D=-"),
        ("--device-script", "D=/dev/stdin"),
        ("--console-input", "-"),
        ("--console-input", "live"),
        ("--console-input", "/proc/self/fd/0"),
    ]:
        done = emulator("debug", "p.asm", "--board", devices, option, given, stdin="at 1 2\n", folder=tmp_path)
        assert done.returncode == 2 and f"debug: {option} {given}: a file is expected" in done.stderr
    run = ["debug", "p.asm", "--board", devices, "--device-script", "D=x=-"]
    assert emulator(*run, stdin="quit\n", folder=tmp_path).returncode == 0


MARK = "\ufeff"  # the byte order mark, which editors put before UTF-8


@pytest.mark.parametrize(
    ("option", "text"), [("--device-input", "12 34\n"), ("--device-script", "at 0 12h\nwait 5 34h\n")]
)
@pytest.mark.parametrize("where", ["file", "standard input"])
def test_a_byte_order_mark_is_no_word(tmp_path: Path, option: str, text: str, where: str) -> None:
    (tmp_path / "p.asm").write_text(START + "        rpts 20\n        nop\n        ldi *ar2,r3\n" + END)
    (tmp_path / "text").write_text(MARK + text, encoding="utf-8")
    run = ["exec", "p.asm", "--board", board(tmp_path, device("fifo")), "--json"]
    name = "text" if where == "file" else "-"
    done = emulator(*run, option, f"D={name}", folder=tmp_path, stdin=MARK + text if where != "file" else "")
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["registers"]["R3"] & 0xFFFFFFFF == 0x12
    # That of the file, as sha256sum has it.
    assert report["inputs"][0]["sha256"] == hashlib.sha256((MARK + text).encode()).hexdigest()


def test_a_script_from_python_may_have_a_mark(tmp_path: Path) -> None:
    processor = Processor(assembled("        ldi *ar2,r3\n" + END), board=board(tmp_path, device("fifo")))
    processor.send_script("D", MARK + "at 0 7\n")
    processor.run(1000, until="done")
    assert low(processor, "R3") == 7


@pytest.mark.parametrize(
    ("option", "text", "message"),
    [
        ("--device-script", b"at 5\0 1\n", 'text:1: "5\\x00": a number (1Fh, 0x1F or decimal) up to'),
        ("--device-script", b"at 5 \x01z\n", 'text:1: "\\x01z" is not a word; 1Fh, 0x1F'),
        ("--device-input", b"12\0\xff\n", 'text:1: "12\\x00\\xFF" is not a word; a word of up to'),
    ],
)
def test_a_message_about_a_byte_0_is_whole(tmp_path: Path, option: str, text: bytes, message: str) -> None:
    (tmp_path / "p.asm").write_text(START + END)
    (tmp_path / "text").write_bytes(text)
    path = board(tmp_path, device("fifo"))
    done = emulator("exec", "p.asm", "--board", path, option, "D=text", folder=tmp_path)
    assert done.returncode == 2 and message in done.stderr and "expected" in done.stderr, done.stderr


def test_an_output_is_no_input(tmp_path: Path) -> None:
    (tmp_path / "p.asm").write_text(START + END)
    (tmp_path / "words").write_text("1\n")
    path = board(tmp_path, device("fifo"))
    done = emulator(
        "exec",
        tmp_path / "p.asm",
        "--board",
        path,
        "--device-input",
        f"D={tmp_path / 'words'}",
        "--device-output",
        f"D={tmp_path / 'words'}",
    )
    assert done.returncode == 2 and (tmp_path / "words").read_text() == "1\n"
