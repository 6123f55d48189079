"""`--console-input live`: a run waits for who types, and its recording repeats it."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path
from typing import Any

import pytest
from board_parts import END, START, assembled, board, device, enabled, low, vector
from cmrc.c40 import Processor
from command_line import EMULATOR, emulator

PROMPT = "        ldi 3eh,r0\n        sti r0,*ar2\n"
ISR = "isr:    ldi *ar2,r3\n        sti r3,*ar2\n        addi 1,r2\n        reti\n"
# They end when nobody types any more.
SLEEPERS = {"idle": "wait:   idle\n        b wait\n", "halt": "wait:   b wait\n"}
POLLS = "wait:   ldi *+ar2(1),r0\n        tstb 1,r0\n        bz wait\n        ldi *ar2,r1\n        sti r1,*ar2\n        b wait\n"
# 131 million cycles, and an end.
LONG = "        ldi 2000,ar5\n        ldhi 0,r6\n        or 0ffffh,r6\nl:      rpts r6\n        nop\n        db ar5,l\n"
# Half a million cycles in which it sends back what comes to two consoles.
TWO = (
    "        ldi 4000,ar5\n"
    + "".join(
        f"l{at}:    ldi *+ar2({at + 1}),r0\n        tstb 1,r0\n        bz m{at}\n        ldi *+ar2({at}),r1\n        sti r1,*+ar2({at})\n"
        f"m{at}:    nop\n"
        for at in (0, 16)
    )
    + "        db ar5,l0\n        ldi *+ar2(16),r7\n"
    + END
)


def program(folder: Path, text: str) -> Path:
    (folder / "p.asm").write_text(START + text)
    return folder / "p.asm"


def sleeper(folder: Path, text: str) -> list[object]:
    text = vector(4) + PROMPT + enabled(1) + text + ISR
    return [program(folder, text), "--board", board(folder, device("console", name="TTY", pin="IIOF1"))]


def started(*arguments: object) -> subprocess.Popen[str]:
    command = [str(each) for each in (EMULATOR, "exec", *arguments, "--console-input", "live")]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


@pytest.mark.parametrize("stop", SLEEPERS)
def test_no_cycles_pass_while_a_program_sleeps_until_somebody_types(tmp_path: Path, stop: str) -> None:
    run, record = sleeper(tmp_path, SLEEPERS[stop]), tmp_path / "record"
    with started(*run, "--console-record", record) as running:
        assert running.stdin is not None and running.stdout is not None
        assert running.stdout.read(1) == ">"
        for letter in "ab":
            running.stdin.write(letter)
            running.stdin.flush()
            assert running.stdout.read(1) == letter  # the answer comes before more is typed
        rest = running.communicate(timeout=60)[0]
    cycles = int(re.findall(r"(\d+) cycles", rest)[0])
    assert running.returncode == 0 and f"stop: {stop}: " in rest and cycles < 1000, rest
    again = emulator("exec", *run, "--device-script", f"TTY={record}").stdout
    assert again.splitlines()[0] == ">ab" and f"{cycles} cycles" in again
    assert again.splitlines()[-1] == rest.splitlines()[-1]


def test_an_input_is_read_up_to_a_limit(tmp_path: Path) -> None:
    """The program reads none of it: one without an end would fill the memory."""
    text = LONG.replace("ldi 2000,", "ldi 4000,") + END
    run = [program(tmp_path, text), "--board", board(tmp_path, device("console", name="TTY"))]
    (tmp_path / "typed").write_bytes(b"y" * (2**20 + 1))
    command = [str(each) for each in (EMULATOR, "exec", *run, "--console-input", "live")]
    with (tmp_path / "typed").open("rb") as typed:
        done = subprocess.run(command, stdin=typed, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "--console-input live: what came behind the first 1 MiB was not read" in done.stderr
    assert "stop: halt: " in done.stdout


def test_a_sleep_that_no_character_ends_is_the_end(tmp_path: Path) -> None:
    run = [program(tmp_path, PROMPT + "        idle\n"), "--board", board(tmp_path, device("console", name="TTY"))]
    with started(*run) as running:
        assert running.stdout is not None and "stop: idle: " in running.stdout.read()


@pytest.mark.parametrize(
    ("text", "limit", "typed", "expected"),
    [
        (LONG + END, [], None, "stop: halt: "),
        (POLLS, ["--max-cycles", "20000"], None, "stop: limit: --max-cycles 20000 reached at "),
        (POLLS, ["--cycles", "20000"], None, "stop: limit: the 20000 cycles of --cycles have passed"),
        (LONG + "        b start\n", [], "", "stop: limit: --max-cycles 100000000 reached at "),
        (LONG + "        b start\n", [], "x", "stop: limit: --max-cycles 100000000 reached since the end of the input at"),
    ],
    ids=["none while one may type", "an explicit one", "a length", "the input has ended", "the input ends"],
)  # fmt: skip
def test_the_limit_of_a_live_run(tmp_path: Path, text: str, limit: list[str], typed: str | None, expected: str) -> None:
    run = [program(tmp_path, text), "--board", board(tmp_path, device("console", name="TTY", pin="IIOF1"))]
    with started(*run, *limit) as running:
        assert running.stdin is not None and running.stdout is not None
        if typed is not None:
            running.stdin.write(typed)
            running.stdin.close()
        assert expected in running.stdout.read()


CONSOLE, OTHER = device("console", name="C", pin="IIOF0"), device("console", 0xA0000010, name="D")
BOARDS = {
    "one": [CONSOLE],
    "two": [CONSOLE, OTHER],
    "with input": [device("console", name="C", input="given"), OTHER],
    "with a script": [device("console", name="C", script="script"), device("console", 0xA0000010, name="D", input="given")],
}  # fmt: skip


@pytest.mark.parametrize("devices", BOARDS.values(), ids=BOARDS)
@pytest.mark.parametrize("length", [5, 1000])
def test_a_live_run_and_its_replay_are_the_same(tmp_path: Path, devices: list[str], length: int) -> None:
    """What is typed comes behind `input` and `script`, on the one console."""
    (tmp_path / "given").write_text("abc")
    (tmp_path / "script").write_text('on 7Ah "!"\nat 20000 "?"\nwait 50 "#"\n')
    typed = "".join(chr(ord("a") + n % 26) for n in range(length))
    path = board(tmp_path, *devices)
    run = ["exec", program(tmp_path, TWO), "--board", path, "--json"]
    record = tmp_path / "record"
    live = json.loads(emulator(*run, "--console-input", "live", "--console-record", record, stdin=typed).stdout)
    replay = json.loads(emulator(*run, "--device-script", f"C={record}").stdout)
    same = ("hash", "cycles", "console", "registers")
    assert {key: live[key] for key in same} == {key: replay[key] for key in same}
    assert bytes.fromhex("".join(re.findall(r" 0x(..)", record.read_text()))).decode().endswith(typed)


def test_only_the_console_of_the_option_is_recorded(tmp_path: Path) -> None:
    (tmp_path / "given").write_text("abc")
    path = board(tmp_path, CONSOLE, device("console", 0xA0000010, name="D", input="given"))
    record = tmp_path / "record"
    emulator(
        "exec", program(tmp_path, TWO), "--board", path, "--console-input", "-", "--console-record", record, stdin="xy"
    )
    assert record.read_text() == "at 0 0x78 0x79\n"


# Sends a prompt first, and reads what has come 6 times, 100 cycles apart: R4 has the status bits, R5 the digits.
SLOW = (
    PROMPT
    + "        ldi 5,ar5\nl:      rpts 99\n        nop\n        ldi *+ar2(1),r0\n        and 1,r0\n        mpyi 10,r4\n        addi r0,r4\n"
    "        mpyi 10,r5\n        ldi *ar2,r0\n        addi r0,r5\n        db ar5,l\n        nop\n        nop\n        nop\n" + END
)  # fmt: skip
SCRIPTS = [
    ("at 0 1 2\non 3Eh 3 4\n", 111100, 123400),
    ("on 3Eh 3\nat 0 4 5\n", 111000, 345000),
    ("at 0 1 2 3\nafter 1 4\nwait 420 5\n", 111110, 123450),
    ("at 10 1\nwait 100 2\nwait 300 3\n", 110100, 120300),
    ("at 5 1\nat 2 2\nat 450 3\n", 110100, 120300),
]


@pytest.mark.parametrize("kind", ["console", "fifo"])
@pytest.mark.parametrize(("script", "status", "words"), SCRIPTS)
def test_a_host_script_means_the_same_to_a_console_and_to_a_fifo(
    tmp_path: Path, kind: str, script: str, status: int, words: int
) -> None:
    """A step begins when the one before has been sent, whether or not the program has read it."""
    (tmp_path / "host").write_text(script)
    path = board(tmp_path, device(kind, script="host"))
    for whole in (True, False):
        processor: Any = Processor(assembled("        ldi 0,r4\n        ldi 0,r5\n" + SLOW), board=path)
        while not whole and processor.cycles < 1500:
            processor.step()
            processor.restore(processor.snapshot())
        processor.run(1_000_000, until="done")
        assert (low(processor, "R4"), low(processor, "R5")) == (status, words)
