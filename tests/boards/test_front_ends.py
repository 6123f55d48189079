"""The inputs of a program in each front end: the same words, wherever the program runs."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from board_parts import END, HEAD, START, device, low
from cmrc.c40 import Processor, assemble_file
from cmrc.network import Network
from command_line import emulator

Front = Callable[[Path], tuple[int, int]]
"""R3 and R4 at the end of the program in a folder."""
ROM = '\n[[region]]\nname = "EPROM"\nbase = 0x80000000\nwords = 0x100\nbus = "global"\nfile = "rom"\nwidth = 32\n'
PROGRAM = START + "        ldi *ar2,r3\n        addi *ar2,r3\n        ldhi 8000h,ar3\n        ldi *+ar3(1),r4\n" + END


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "rom").write_bytes(bytes(4) + (0xABCD).to_bytes(4, "little"))
    (tmp_path / "p.asm").write_text(PROGRAM)
    (tmp_path / "words").write_text("70 7\n")
    (tmp_path / "board.toml").write_text(HEAD + ROM + device("fifo", input="words"))
    (tmp_path / "n.toml").write_text('[[chip]]\nprogram = "p.asm"\nboard = "board.toml"\n')
    return tmp_path


def of_json(registers: dict[str, int]) -> tuple[int, int]:
    return registers["R3"] & 0xFFFFFFFF, registers["R4"] & 0xFFFFFFFF


def by_exec(folder: Path) -> tuple[int, int]:
    done = emulator("exec", folder / "p.asm", "--board", folder / "board.toml", "--json")
    assert done.returncode == 0, done.stderr
    return of_json(json.loads(done.stdout)["registers"])


def by_exec_with_option(folder: Path) -> tuple[int, int]:
    text = (folder / "board.toml").read_text().replace('input = "words"\n', "")
    (folder / "bare.toml").write_text(text)
    done = emulator(
        "exec", folder / "p.asm", "--board", folder / "bare.toml", "--device-input", "D=-", "--json", stdin="70 7"
    )
    assert done.returncode == 0, done.stderr
    return of_json(json.loads(done.stdout)["registers"])


def by_network_file(folder: Path) -> tuple[int, int]:
    done = emulator("exec", "--network", folder / "n.toml", "--json")
    assert done.returncode == 0, done.stderr
    return of_json(json.loads(done.stdout)["chips"][0]["registers"])


def by_debug(folder: Path) -> tuple[int, int]:
    done = emulator(
        "debug", folder / "p.asm", "--board", folder / "board.toml", stdin="break done\ncontinue\nprint r3\nprint r4\n"
    )
    assert done.returncode == 0, done.stderr
    found = [int(text, 16) & 0xFFFFFFFF for text in re.findall(r"([0-9A-F]{8,10})h", done.stdout)[-2:]]
    return found[0], found[1]


def by_processor(folder: Path) -> tuple[int, int]:
    chip = Processor(assemble_file(folder / "p.asm"), board=folder / "board.toml")
    chip.run(until="done")
    return low(chip, "R3"), low(chip, "R4")


def by_network(folder: Path) -> tuple[int, int]:
    network = Network([folder / "p.asm"], boards=str(folder / "board.toml"), until="done")
    network.run()
    return low(network.chips[0], "R3"), low(network.chips[0], "R4")


def by_network_file_in_python(folder: Path) -> tuple[int, int]:
    network = Network.from_file(folder / "n.toml")
    network.run()
    return low(network.chips[0], "R3"), low(network.chips[0], "R4")


@pytest.mark.parametrize(
    "front",
    [by_exec, by_exec_with_option, by_network_file, by_debug, by_processor, by_network, by_network_file_in_python],
)
def test_every_way_of_running_gives_a_program_its_rom_and_its_words(folder: Path, front: Front) -> None:
    assert front(folder) == (0x77, 0xABCD)


def test_an_image_is_made_for_a_board_that_names_it(folder: Path) -> None:
    (folder / "rom").unlink()
    (folder / "words").unlink()
    made = emulator(
        "image", folder / "p.asm", "--format", "binary", "--board", folder / "board.toml", "-o", folder / "rom"
    )
    assert made.returncode == 0 and (folder / "rom").exists(), made.stderr
    missing = emulator("exec", folder / "p.asm", "--board", folder / "board.toml")
    assert missing.returncode == 2 and "device.input of D" in missing.stderr


STRIDES = [("console", 2, 1), ("fifo", 4, 1), ("mailbox", 2, 1), ("timer", 3, 3)]


@pytest.mark.parametrize(("kind", "stride", "last"), STRIDES)
def test_registers_stand_a_stride_apart_and_nothing_is_between(
    tmp_path: Path, kind: str, stride: int, last: int
) -> None:
    """The second register (of a timer the fourth) is read at its stride; between registers a read gives 0."""
    (tmp_path / "b.toml").write_text(HEAD + device(kind, stride=stride))
    at = stride * last
    text = (
        START
        + f"        ldi *+ar2({at}),r3\n        ldi 41h,r0\n        sti r0,*+ar2(1)\n        ldi *+ar2(1),r4\n        sti r0,*ar2\n        ldi *+ar2({at}),r5\n"
        + END
    )
    (tmp_path / "p.asm").write_text(text)
    done = json.loads(emulator("exec", tmp_path / "p.asm", "--board", tmp_path / "b.toml", "--json").stdout)
    words = [done["registers"][name] & 0xFFFFFFFF for name in ("R3", "R4", "R5")]
    assert words[1] == 0
    if kind == "console":
        assert words == [2, 0, 2] and done["console"] == "A"
    elif kind == "timer":
        assert words == [0, 0, 0]
    else:
        assert words[0] == 10 and done["sent"][0]["words"] == [0x41]
    edge = emulator("exec", tmp_path / "p.asm", "--board", tmp_path / "b.toml", "--poke", "0A0000000h=1")
    assert edge.returncode == 2 and "do not lie in memory" in edge.stderr
