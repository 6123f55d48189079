"""One emulated DSP with the real image. Its windows are plain RAM (board `flat`), which the test fills and reads."""

from __future__ import annotations

import functools
import math
import os
from typing import Any

import reference
from cmrc import _core
from cmrc_test import run_setup
from words import signed

WINDOW_A, WINDOW_B = 0xC0000000, 0x70000000
RETURN = 0x3FF000  # nothing is here: where the called code returns to


@functools.cache
def image_of(programs: str, settings: tuple[tuple[str, str | float], ...]) -> Any:
    return run_setup.dsp_image(_core.cmrc.config(settings={"machine.programs": programs, **dict(settings)}))


def image(**settings: str | float) -> Any:
    """The DSPs' program as a run with these settings loads it; names have ``__`` for the dot.

    The one that the build has assembled, or that of the folder CMRC_PROGRAMS.
    """
    return image_of(
        os.environ.get("CMRC_PROGRAMS", ""),
        tuple((name.replace("__", "."), value) for name, value in sorted(settings.items())),
    )


def to_ti(x: float) -> int:
    """The nearest single of the C40: x = M 2^(e - 23), M in [2^23, 2^24) or [-2^24, -2^23), sign and fraction
    stored."""
    if x == 0:
        return 0x80000000
    fraction, exponent = math.frexp(x)
    m, e = round(fraction * 2**24), exponent - 1
    if m == 2**24:
        m, e = 2**23, e + 1
    if m == -(2**23):
        m, e = -(2**24), e - 1
    return ((e & 0xFF) << 24) | ((m ^ 0x800000) & 0xFFFFFF)


def from_ti(word: int) -> float:
    return float(_core.c40.float40.value(_core.c40.float40.from_single(word)))


def gantry_constants(chip: Any, symbols: dict[str, int]) -> None:
    """Puts the gantry's constants in the place of the slewing crane's (dock.crane = "gantry")."""
    gantry = _core.c40.Processor("flat")
    gantry.load_image(image(dock__crane="gantry"))
    first, last = symbols["constants"], symbols["constants_end"]
    chip.load_words(symbols["CONSTANTS"], gantry.read(first, last - first))
    tables = symbols["gantry_masses"]
    chip.load_words(tables, gantry.read(tables, symbols["gantry_travel"] - tables))


def single(x: float) -> float:
    """As the C40 stores it."""
    return from_ti(to_ti(x))


class Dsp:
    """The DSP after `_start` has copied the constants; `area` is the address of the robot's area."""

    def __init__(self, **settings: str | float) -> None:
        program = image(**settings)
        self.symbols: dict[str, int] = program.symbols
        self.chip = _core.c40.Processor("flat")
        self.chip.load_image(program)
        first, last = self.symbols["constants"], self.symbols["constants_end"]
        self.chip.load_words(self.symbols["CONSTANTS"], self.chip.read(first, last - first))
        self.area = WINDOW_A + self.symbols["CR_BASE"]
        self.chip.poke(self.symbols["EXEC_BLOCK"], WINDOW_A + self.symbols["BLOCK_POOL"])
        self.control(reference.control_block(), generation=1)
        self.speeds(reference.SPEED_WORDS)

    def control(self, block: list[float], generation: int) -> None:
        """What the host writes for PID's law."""
        self.put("CR_CONTROL_BLOCK", *block)
        self.put("CR_CONTROL", generation)

    def servo_rates(self, consumed: int | None = None) -> None:
        """The default rates as the host writes them: the servo each millisecond, a point each eighth time; with
        `consumed`, so many points of the ring that begin at tick 0."""
        self.put("CR_SERVO_PERIOD", 0.001)
        self.put("CR_POINT_TICKS", 64)
        self.put("CR_SERVO_TICKS", 8)
        self.put("CR_PID_STAGE", 2)
        if consumed is not None:
            self.put("CR_CONSUMED", consumed)
            self.put("CR_SEGMENT_START", 0)

    def speeds(self, words: list[float]) -> None:
        """What the host writes of the speed limits."""
        self.put("CR_SPEED", *words)

    # ---- words of the area and of the devices
    def put(self, name: str, *values: float, offset: int = 0) -> None:
        """Floats as TI singles, integers as they are."""
        for i, v in enumerate(values):
            word = to_ti(v) if isinstance(v, float) else v & 0xFFFFFFFF
            self.chip.poke(self.area + self.symbols[name] + offset + i, word)

    def floats(self, name: str, count: int, offset: int = 0) -> list[float]:
        return [from_ti(w) for w in self.chip.read(self.area + self.symbols[name] + offset, count)]

    def word(self, name: str, offset: int = 0) -> int:
        return signed(self.chip.peek(self.area + self.symbols[name] + offset))

    def hang(self, mass: int) -> None:
        """kg on the rope: the load cell shows it, and has done so for long."""
        self.device("LOAD_CELL", mass)
        self.put("CR_LOAD", float(mass))

    def device(self, name: str, value: int, offset: int = 0) -> None:
        self.chip.poke(WINDOW_B + self.symbols[name] + offset, value & 0xFFFFFFFF)

    def device_word(self, name: str, offset: int = 0) -> int:
        return signed(self.chip.peek(WINDOW_B + self.symbols[name] + offset))

    # ---- running
    def call(self, label: str) -> int:
        """Calls what is at `label` and returns its cycles."""
        s, chip = self.symbols, self.chip
        chip.set("DP", s["PAGE"])
        chip.set("SP", s["STACK"])
        chip.set("ST", 0x0800)
        chip.poke(s["STACK"], RETURN)
        chip.pc = s[label]
        before = chip.cycle
        stop = chip.run(20_000_000, RETURN)
        assert stop["reason"] == "breakpoint", stop
        assert chip.get("DP") == s["PAGE"] and chip.get("SP") == s["STACK"] - 1
        return int(chip.cycle - before)

    def function(self, label: str, *arguments: float) -> tuple[float, ...]:
        """R0, R1, ... of a library function whose arguments are 40-bit floats exactly equal to doubles rounded to
        single."""
        for i, a in enumerate(arguments):
            self.chip.set(f"R{i}", _core.c40.float40.from_single(to_ti(a)))
        self.call(label)
        return tuple(float(self.chip.value(f"R{i}")) for i in range(5))

    def run(self, kernel: str, argument: int = 0, tick: int = 0) -> tuple[int, int, int]:
        """TB_RESULT, TB_NOTIFY and the kernel's cycles with windows that cost nothing."""
        s, chip = self.symbols, self.chip
        chip.poke(s["TASK"] + s["TB_ARGUMENT"], argument)
        chip.poke(s["TASK"] + s["TB_TICK"], tick)
        chip.set("AR6", self.area)
        chip.set("AR7", s["TASK"])
        cycles = self.call(f"kernel_{kernel}")
        return chip.get("R0") & 0xFFFFFFFF, chip.get("R1") & 0xFFFFFFFF, cycles
