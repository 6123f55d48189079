"""The C run-time of c40_programs/lib on an emulated chip: its objects for one way of giving arguments, linked, and
calls of single functions."""

from __future__ import annotations

import atexit
import functools
import shutil
import struct
import subprocess
import tempfile
from pathlib import Path

from cmrc import c40
from cmrc.floats import extended_to_float, float_to_extended, float_to_single
from locations import BUILD, ROOT

LIBRARY = ROOT / "c40_programs" / "lib"
SOURCES = (LIBRARY / "crt0.asm", *sorted((LIBRARY / "c").glob("*.asm")))
EMULATOR = BUILD / "bin" / "emulator"
BACK, STACK = 0x3F0000, 0x3E0000
CONVENTIONS = ("stack", "registers")
SAVED = ("R4", "R5", "R6", "R7", "R8", "AR3", "AR4", "AR5", "AR6", "AR7", "DP")
"""What a C function gives back as it was."""


def assemble(source: Path, folder: Path, *options: str) -> Path:
    target = folder / f"{source.stem}.o"
    done = subprocess.run(
        [EMULATOR, "asm", "-c", source, "-o", target, "-I", ROOT / "c40_programs/include", *options],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return target


@functools.cache
def objects(convention: str) -> tuple[Path, ...]:
    folder = Path(tempfile.mkdtemp(prefix="c_library"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    options = ["-D", "REGPARM"] if convention == "registers" else []
    return tuple(assemble(source, folder, *options) for source in SOURCES)


def link(inputs: list[Path], output: Path, *options: str | Path) -> str:
    """What the linker says; "" if it is content."""
    done = subprocess.run(
        [EMULATOR, "link", *inputs, "-o", output, *options], capture_output=True, text=True, check=False
    )
    return done.stderr


@functools.cache
def program(convention: str) -> c40.Program:
    """The whole library, with a main that does nothing."""
    made = objects(convention)
    main = made[0].parent / "main.asm"
    main.write_text("\t.global _main\n\t.text\n_main:\trets\n")
    output = made[0].parent / "library.out"
    assert link([*made, assemble(main, made[0].parent)], output) == ""
    return c40.read_coff(output)


class Library:
    """A chip with the library; registers that a function may not change hold marks."""

    def __init__(self, convention: str) -> None:
        self.convention = convention
        self.chip = c40.Processor(program(convention))

    def marked(self, names: tuple[str, ...]) -> dict[str, int]:
        marks = {
            name: (0x1234567800 + number) if name.startswith("R") and name[1:].isdigit() else 0x1000 + number
            for number, name in enumerate(names)
        }
        for name, mark in marks.items():
            self.chip.registers[name] = mark
        return marks

    def enter(self, name: str, pushed: list[int], kept: tuple[str, ...]) -> None:
        """Calls with `pushed` on the stack, the last argument first; comes back, and looks at what is to be kept."""
        marks = self.marked(kept)
        chip = self.chip
        for offset, word in enumerate([*pushed, BACK]):
            chip.memory[STACK + 1 + offset] = word
        chip.registers["SP"] = STACK + 1 + len(pushed)
        chip.registers["ST"] = 0
        chip.pc = name
        stop = chip.run(100_000, until=BACK)
        assert stop.reason == "until", stop
        assert chip.registers["SP"] == STACK + len(pushed)
        for register, mark in marks.items():
            assert chip.registers[register] == mark, register

    def operator(self, name: str, left: int, right: int, kept: tuple[str, ...]) -> int:
        """One of TI's: R0 := R0 op R1."""
        names = tuple(register for register in kept if register not in ("R0", "R1"))
        self.chip.registers["R0"], self.chip.registers["R1"] = left, right
        self.enter(name, [], names)
        return self.chip.registers["R0"]

    def call(self, name: str, *arguments: float) -> int:
        """A C function of whole numbers and floats; R0 with its 40 bits."""
        words = [
            argument & 0xFFFF_FFFF if isinstance(argument, int) else float_to_single(argument) for argument in arguments
        ]
        if self.convention == "stack":
            self.enter(name, words[::-1], SAVED)
            return self.chip.registers["R0"]
        whole, floats = ["AR2", "R2", "R3"], ["R2", "R3"]
        for argument, word in zip(arguments, words, strict=True):
            if isinstance(argument, int):
                register = whole.pop(0)
                self.chip.registers[register] = word
            else:
                register = floats.pop(0)
                self.chip.registers[register] = float_to_extended(argument)
        self.enter(name, [], SAVED)
        return self.chip.registers["R0"]

    def call_with_long_doubles(self, name: str, *arguments: float) -> int:
        """R0 with its 40 bits."""
        forty = [float_to_extended(argument) for argument in arguments]
        if self.convention == "stack":
            # The high word first on the way to the argument: exponent and 24 bits, then all 32 of the mantissa.
            pushed = [word for value in forty[::-1] for word in (value >> 8 & 0xFFFF_FFFF, value & 0xFFFF_FFFF)]
            self.enter(name, pushed, SAVED)
        else:
            for register, value in zip(("R2", "R3"), forty, strict=False):
                self.chip.registers[register] = value
            self.enter(name, [], SAVED)
        return self.chip.registers["R0"]

    def call_with_long_longs(self, name: str, *arguments: int) -> int:
        """R1:R0 as 64 bits: on the stack in either convention."""
        pushed = [word for value in arguments[::-1] for word in (value & 0xFFFF_FFFF, value >> 32 & 0xFFFF_FFFF)]
        self.enter(name, pushed, SAVED)
        return self.both()

    def both(self) -> int:
        return (self.chip.registers["R1"] & 0xFFFF_FFFF) << 32 | self.chip.registers["R0"] & 0xFFFF_FFFF

    def float(self, register: str = "R0") -> float:
        return extended_to_float(self.chip.registers[register])


def single(value: float) -> float:
    """The nearest of 24 bits."""
    return float(struct.unpack("f", struct.pack("f", value))[0])
