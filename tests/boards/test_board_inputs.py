"""What devices are sent: files, standard input and its recording, host scripts; the run's hash; errors."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest
from board_parts import END, START, assembled, board, device, low
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
