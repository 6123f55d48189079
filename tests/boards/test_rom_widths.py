"""The width of a ROM: given, or said by the file's first word, by every front end. If both differ, the given one holds,
and a warning says so."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Callable
from pathlib import Path

import pytest
from board_parts import HEAD
from cmrc.c40 import Processor, assemble, read_rom
from cmrc.network import Network
from command_line import emulator

BASE = 0x80000000
SOURCE = "start: b start\n"
Front = Callable[[Path, int | None], tuple[list[int], str]]
"""The first four words of the ROM in a folder, and what was warned of."""


def region(folder: Path, width: int | None) -> Path:
    """A board with the ROM; for the ways that take a board."""
    text = f'\n[[region]]\nname = "EPROM"\nbase = 0x{BASE:X}\nwords = 0x100\nbus = "global"\nfile = "rom"\n'
    (folder / "b.toml").write_text(HEAD + text + ("" if width is None else f"width = {width}\n"))
    (folder / "p.asm").write_text(SOURCE)
    (folder / "n.toml").write_text('[[chip]]\nprogram = "p.asm"\nboard = "b.toml"\n' * 2)
    return folder / "b.toml"


def printed(*arguments: object) -> tuple[list[int], str]:
    done = emulator("exec", *arguments, "--cycles", 1, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["dumps"][0]["words"], done.stderr


def by_option(folder: Path, width: int | None) -> tuple[list[int], str]:
    given = [] if width is None else ["--rom-width", width]
    rom = f"{folder / 'rom'}@{BASE:X}h"
    return printed("--rom", rom, *given, "--boot", f"{BASE:X}h", "--dump", f"{BASE:X}h:4")


def by_board(folder: Path, width: int | None) -> tuple[list[int], str]:
    return printed(folder / "p.asm", "--board", region(folder, width), "--dump", f"{BASE:X}h:4")


def by_boards_of_a_network(folder: Path, width: int | None) -> tuple[list[int], str]:
    board = region(folder, width)
    return printed(folder / "p.asm", folder / "p.asm", "--board", board, "--dump", f"1:{BASE:X}h:4")


def by_network_file(folder: Path, width: int | None) -> tuple[list[int], str]:
    region(folder, width)
    return printed("--network", folder / "n.toml", "--dump", f"1:{BASE:X}h:4")


def by_debugger(folder: Path, width: int | None) -> tuple[list[int], str]:
    done = emulator("debug", folder / "p.asm", "--board", region(folder, width), stdin=f"x {BASE:X}h 4\n")
    return [int(word, 16) for word in re.findall(r" ([0-9A-F]{8})\b", done.stdout.splitlines()[-1])], done.stderr


def in_python(folder: Path, make: Callable[[], Processor | Network]) -> tuple[list[int], str]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        made = make()
    chip = made.chips[-1] if isinstance(made, Network) else made
    return chip.memory[BASE : BASE + 4], "".join(f"{each.message}\n" for each in caught)


def by_processor(folder: Path, width: int | None) -> tuple[list[int], str]:
    return in_python(folder, lambda: Processor(assemble(SOURCE), board=region(folder, width)))


def by_chips(folder: Path, width: int | None) -> tuple[list[int], str]:
    return in_python(folder, lambda: Network([assemble(SOURCE)], boards=str(region(folder, width))))


def by_network_file_in_python(folder: Path, width: int | None) -> tuple[list[int], str]:
    region(folder, width)
    return in_python(folder, lambda: Network.from_file(folder / "n.toml"))


def by_load_rom(folder: Path, width: int | None) -> tuple[list[int], str]:
    def made() -> Processor:
        processor = Processor(board="default")
        processor.load_rom(folder / "rom", BASE, width=width)
        return processor

    return in_python(folder, made)


def by_read_rom(folder: Path, width: int | None) -> tuple[list[int], str]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        words = read_rom(folder / "rom", width=width)
    return words[:4], "".join(f"{each.message}\n" for each in caught)


FRONTS: list[tuple[Front, str]] = [
    (by_option, "--rom-width"),
    *(
        (front, "region.width")
        for front in (
            by_board, by_boards_of_a_network, by_network_file, by_debugger, by_processor, by_chips, by_network_file_in_python,
        )
    ),
    (by_load_rom, "width"),
    (by_read_rom, "width"),
]  # fmt: skip
WIDE, NARROW, SIXTEEN = [32, 0x04030201], [8, 0, 0, 0], [16, 0, 0x0201, 0x0403]
# The first word, the width that is given, the words in memory, what the warning says of the first word.
CASES = [
    (32, None, WIDE, None),
    (32, 32, WIDE, None),
    (32, 8, [32, 0, 0, 0], 32),
    (8, None, NARROW, None),
    (8, 32, [8, 0x04030201], 8),
    (16, None, SIXTEEN, None),
    (16, 8, [16, 0, 0, 0], 16),
    (9, 16, [9, 0, 0x0201, 0x0403], None),
]


@pytest.mark.parametrize(("front", "name"), FRONTS, ids=[front.__name__ for front, _ in FRONTS])
@pytest.mark.parametrize(("first", "width", "words", "said"), CASES)
def test_a_given_width_holds_and_one_that_the_rom_contradicts_is_warned_of(
    tmp_path: Path, front: Front, name: str, first: int, width: int | None, words: list[int], said: int | None
) -> None:
    (tmp_path / "rom").write_bytes(bytes([first, 0, 0, 0, 1, 2, 3, 4]) + bytes(8))
    found, warned = front(tmp_path, width)
    assert found[: len(words)] == words
    if said is None:
        assert warned == ""
    else:
        lines = warned.splitlines()
        assert f"its first word says {said} bits, as to a boot loader, and {name} {width}" in lines[0], warned
        assert len(set(lines)) == 1  # of each chip in Python
