"""One emulated DSP on the flat board with the real image: shared memory and device registers are words that the tests
fill."""

from __future__ import annotations

import math

from cmrc import _core
from harness import RETURN, WINDOW_A, WINDOW_B, from_ti, image
from words import signed

__all__ = ["RETURN", "WINDOW_A", "WINDOW_B", "Dsp", "from_ti", "image", "signed", "to_ti"]


def to_ti(x: float) -> int:
    """The nearest single of the C40 (ties upwards), from its definition: (mantissa in [1, 2) or [-2, -1)) * 2^e."""
    if x == 0.0:
        return 0x80000000
    m, e = math.frexp(x)
    m, e = 2 * m, e - 1  # 1 <= |m| < 2
    if m == -1.0:
        m, e = -2.0, e - 1
    n = math.floor(m * 2**23 + 0.5)
    if n == 2**24:
        n, e = 2**23, e + 1
    elif n == -(2**23):
        n, e = -(2**24), e - 1
    return (e & 0xFF) << 24 | (n < 0) << 23 | n & 0x7FFFFF


class Dsp:
    def __init__(self) -> None:
        self.image = image()
        self.symbols = self.image.symbols
        self.chip = _core.c40.Processor("flat")
        self.chip.load_image(self.image)
        first, last = self.symbols["constants"], self.symbols["constants_end"]
        self.chip.load_words(self.symbols["CONSTANTS"], self.chip.read(first, last - first))
        self.area = WINDOW_A + self.symbols["CR_BASE"]
        self.chip.poke(self.symbols["EXEC_BLOCK"], WINDOW_A + self.symbols["BLOCK_POOL"])

    def agv(self, index: int) -> None:
        self.area = WINDOW_A + self.symbols["AG_BASE"] + index * self.symbols["AG_WORDS"]

    def put(self, name: str, value: float, offset: int = 0) -> None:
        """A word of the robot's area: floats as TI singles, integers as they are."""
        word = to_ti(value) if isinstance(value, float) else value & 0xFFFFFFFF
        self.chip.poke(self.area + self.symbols[name] + offset, word)

    def floats(self, name: str, count: int, offset: int = 0) -> list[float]:
        return [from_ti(w) for w in self.chip.read(self.area + self.symbols[name] + offset, count)]

    def word(self, name: str, offset: int = 0) -> int:
        return self.chip.peek(self.area + self.symbols[name] + offset)

    def device(self, offset: int, value: int) -> None:
        self.chip.poke(WINDOW_B + offset, value & 0xFFFFFFFF)

    def device_word(self, offset: int) -> int:
        return signed(self.chip.peek(WINDOW_B + offset))

    def start(self, kernel: str, argument: int = 0, tick: int = 0) -> int:
        """Sets the chip as the executive does when it calls a kernel; the cycle at which it starts."""
        s, chip = self.symbols, self.chip
        task = s["TASK"]
        chip.poke(task + s["TB_ARGUMENT"], argument)
        chip.poke(task + s["TB_TICK"], tick)
        chip.set("DP", s["PAGE"])
        chip.set("SP", s["STACK"])
        chip.poke(s["STACK"], RETURN)
        chip.set("AR6", self.area)
        chip.set("AR7", task)
        chip.pc = s[f"kernel_{kernel}"]
        return chip.cycle

    def finish(self, start: int) -> tuple[int, int, int]:
        """TB_RESULT, TB_NOTIFY and the cycles that the kernel took: its own, windows without wait."""
        s, chip = self.symbols, self.chip
        stop = chip.run(20_000_000, RETURN)
        assert stop["reason"] == "breakpoint", stop
        assert chip.get("DP") == s["PAGE"] and chip.get("SP") == s["STACK"] - 1
        return chip.get("R0") & 0xFFFFFFFF, chip.get("R1") & 0xFFFFFFFF, chip.cycle - start

    def run(self, kernel: str, argument: int = 0, tick: int = 0) -> tuple[int, int, int]:
        return self.finish(self.start(kernel, argument, tick))
