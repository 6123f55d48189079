"""Runs on the emulated chip that are compared with published figures (scripts/validation)."""

from __future__ import annotations

import importlib.machinery
import importlib.util
import math
import re
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from cmrc import c40
from cmrc._core import toolchain

ROOT = Path(__file__).resolve().parent.parent
MEASURED = ROOT / "c40_programs" / "published" / "measured.asm"
BLOCK0, BLOCK1, CODE, STACK, BACK = 0x2FF800, 0x2FFC00, 0x300000, 0x320000, 0x330000
FLOAT_OPERATION = re.compile(r"\b(?:mpyf|addf|subf|subrf)3?\b")
CLOCKS_MHZ = (40, 50)
"""CLKIN of the C40s of the time; an H1 cycle is two of its periods."""


def microseconds(cycles: float, clkin_mhz: float) -> float:
    return 2 * cycles / clkin_mhz


def script(name: str) -> ModuleType:
    """A script without suffix, as a module."""
    if name not in sys.modules:
        loader = importlib.machinery.SourceFileLoader(name, str(ROOT / "scripts" / name))
        spec = importlib.util.spec_from_loader(name, loader)
        assert spec is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        loader.exec_module(module)
    return sys.modules[name]


def script_module(name: str) -> ModuleType:
    """A module beside this one."""
    if str(ROOT / "scripts") not in sys.path:
        sys.path.insert(0, str(ROOT / "scripts"))
    return importlib.import_module(name)


# ---- the Fourier transform


@dataclass(frozen=True)
class Transform:
    cycles: int
    additions: int
    """Of floats, executed: no cycle has more than one."""
    multiplications: int


def transform(radix: int, points: int) -> Transform:
    call = script("published_counts").fft(radix, points)
    _, cycles = call.run()
    texts = executed(call)
    additions = sum(len(re.findall(r"\b(?:addf|subf|subrf)3?\b", text)) * times for text, times in texts.items())
    multiplications = sum(len(re.findall(r"\bmpyf3?\b", text)) * times for text, times in texts.items())
    return Transform(cycles, additions, multiplications)


def executed(call: Any) -> dict[str, int]:
    """How often each instruction of a call of scripts/published_counts is executed, by its text, one step at a time."""
    counts: dict[str, int] = {}
    texts: dict[int, str] = {}
    original = c40.Processor.run

    def step(chip: c40.Processor, max_cycles: int = 0, *, until: int | str | None = None) -> c40.Stop:
        while chip.pc != until:
            pc = chip.pc
            text = texts.get(pc)
            if text is None:
                text = texts[pc] = c40.disassemble(chip.memory[pc], pc)
            counts[text] = counts.get(text, 0) + 1
            original(chip, 1)
        return c40.Stop("until", chip.pc, chip.cycles)

    c40.Processor.run = step  # type: ignore[method-assign,assignment]
    try:
        call.run()
    finally:
        c40.Processor.run = original  # type: ignore[method-assign]
    return counts


# ---- processes


def switch_cycles(kind: str) -> int:
    """From the call by one process to the next instruction of another, both in the middle of their loops. `kind`:
    "reduced" or "c"."""
    first, second = {"reduced": ("process_a", "process_b"), "c": ("process_c", "process_d")}[kind]
    kept = {"reduced": 1, "c": 10}[kind]
    chip = c40.Processor(c40.assemble_file(MEASURED, sections={".text": CODE}))
    block_a, block_b, stack_a, stack_b = BLOCK0, BLOCK0 + 2, BLOCK1, BLOCK1 + 0x80
    chip.memory[block_a], chip.memory[block_b] = block_b, block_a
    chip.memory[stack_b] = chip.address(second)
    chip.memory[block_b + 1] = stack_b + kept
    chip.registers["SP"], chip.registers["AR7"] = stack_a, block_a
    chip.pc = first
    back = {name: f"back_{name[-1]}" for name in (first, second)}
    for place in (second, back[first], first):
        assert chip.run(1000, until=place).reason == "until"
    before = chip.cycles
    assert chip.run(1000, until=back[second]).reason == "until"
    assert chip.registers["AR7"] == block_b
    return chip.cycles - before


# ---- an image


@dataclass(frozen=True)
class Row:
    cycles: int
    pixels: int
    values: list[float]
    expected: list[float]


def convolved_row(pixels: int = 500) -> Row:
    """One row of 3 x 3 sums, rows and result on chip."""
    chip = c40.Processor(c40.assemble_file(MEASURED, sections={".text": CODE}))
    width = pixels + 2
    places = [BLOCK0, BLOCK0 + width, BLOCK1]
    rows = [[float((7 * x + 13 * y) % 256) for x in range(width)] for y in range(3)]
    coefficients = [1.0, 2.0, 1.0, 2.0, 4.0, 2.0, 1.0, 2.0, -3.0]
    for place, row in zip(places, rows, strict=True):
        chip.memory.write_floats(place, row)
    at, result = BLOCK1 + 0x3F0, 0x80000000  # circular: on a multiple of 16
    chip.memory.write_floats(at, coefficients)
    for name, value in {
        "AR0": places[0],
        "AR1": places[1],
        "AR2": places[2],
        "AR3": result,
        "AR4": at,
        "BK": 9,
        "RC": pixels - 1,
        "SP": STACK,
    }.items():
        chip.registers[name] = value
    chip.memory[STACK] = BACK
    chip.pc = "convolve_row"
    assert chip.run(1_000_000, until=BACK).reason == "until"
    expected = [
        sum(coefficients[3 * y + k] * rows[y][x + k] for y in range(3) for k in range(3)) for x in range(pixels)
    ]
    return Row(chip.cycles, pixels, list(chip.memory.read_floats(result, pixels)), expected)


# ---- the DMA


def dma_cycles(source: int, destination: int, words: int) -> int:
    """From the start of channel 0 until the last word is there; the processor does nothing beside."""
    chip = c40.Processor(c40.assemble("        .text\nwait:   idle\n        b wait\n"))
    chip.run(20)
    for offset in range(words):
        chip.memory[source + offset] = offset + 1
    control = 3 << 22 | 1 << 2  # start, and stop at the end
    for register, value in enumerate((0, source, 1, words, destination, 1)):
        chip.memory[0x1000A0 + register] = value
    before = chip.cycles
    chip.memory[0x1000A0] = control
    while chip.memory[destination + words - 1] != words:
        chip.run(1)
    return chip.cycles - before


# ---- inverse dynamics


@dataclass(frozen=True)
class Work:
    cycles: int
    operations: int
    """Multiplications, additions and subtractions of floats, executed."""

    def megaflops(self, clkin_mhz: float) -> float:
        return self.operations / microseconds(self.cycles, clkin_mhz)

    @property
    def of_peak(self) -> float:
        return self.operations / (2 * self.cycles)


def inverse_dynamics() -> Work:
    """The kernel torque_newton_euler (docs/kernels.md): the recursion of Newton and Euler over six links."""
    for folder in ("tests/kernels", "tests"):
        if str(ROOT / folder) not in sys.path:
            sys.path.insert(0, str(ROOT / folder))
    from test_golden_kernels import CASES

    kernel, prepare, argument, tick = next(case for case in CASES if case[0] == "torque_newton_euler")
    *_, cycles = prepare().run(kernel, argument, tick)
    dsp = prepare()
    dsp.chip = Stepped(dsp.chip)
    dsp.run(kernel, argument, tick)
    return Work(cycles, dsp.chip.operations)


class Stepped:
    """A chip that counts operations on floats while it runs."""

    def __init__(self, chip: Any) -> None:
        object.__setattr__(self, "_chip", chip)
        object.__setattr__(self, "operations", 0)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._chip, name)

    def __setattr__(self, name: str, value: Any) -> None:
        setattr(self._chip, name, value)

    def run(self, _limit: int, until: int) -> dict[str, str]:
        texts: dict[int, int] = {}
        total = 0
        while self._chip.pc != until:
            pc = self._chip.pc
            if pc not in texts:
                texts[pc] = len(FLOAT_OPERATION.findall(c40.disassemble(self._chip.peek(pc), pc)))
            total += texts[pc]
            self._chip.run(1)
        object.__setattr__(self, "operations", total)
        return {"reason": "breakpoint"}


# ---- programs that are not in the tree


def hydra_transform(program: Path, points: int, waits: int = 0) -> tuple[int, float]:
    """Cycles of _rfft in a program of 1992 for the Hydra, and the microseconds that it measures itself (for 40 MHz).
    `waits`: of the memory with its twiddle factors."""
    board = "\n".join(
        f'[[region]]\nname = "{name}"\nbase = {base:#x}\nwords = {words:#x}\nbus = "{bus}"\nwaits = {wait}'
        for name, base, words, bus, wait in (
            ("low", 0, 0x100000, "local", 0),  # the program reads past its tables, as if it did not matter
            ("EPROM", 0x300000, 0x100000, "local", 0),
            ("local SRAM", 0x40000000, 0x20000, "local", 0),
            ("DRAM", 0x80000000, 0x10000000, "global", 0),
            ("global SRAM", 0xC0000000, 0x400000, "global", waits),
        )
    )
    place = program.parent / f"validation-{waits}.toml"
    place.write_text(f'name = "Hydra, as far as its FFT needs it"\n{board}\n')
    try:
        chip = c40.Processor(c40.read_coff(program), board=place)
    finally:
        place.unlink()
    signal = [math.sin(10 * math.pi * i / points) + 0.5 * math.sin(40 * math.pi * i / points) for i in range(points)]
    chip.memory.write_floats(BLOCK0, signal)
    chip.memory[chip.address("_FFTSize")] = points
    chip.memory[chip.address("_start_flag")] = 1
    assert chip.run(10_000_000, until="_rfft").reason == "until"
    before, back = chip.cycles, chip.memory[chip.registers["SP"]]
    stop = chip.run(10_000_000, until=back)
    assert stop.reason == "until", stop
    cycles = chip.cycles - before
    while chip.memory.read_floats(chip.address("_elapsed_time"), 1)[0] == 0:
        chip.run(10)
    peak = chip.memory.read_floats(BLOCK1, 12)[11]  # the fifth value's imaginary part
    assert abs(peak + points / 2) < 1e-3, peak
    return cycles, 1e6 * chip.memory.read_floats(chip.address("_elapsed_time"), 1)[0]


@dataclass(frozen=True)
class Kernel:
    """One of QCDSP's vector functions: what it is, and its arguments, the first first; a float is passed as one."""

    function: str
    what: str
    arguments: tuple[int | float, ...]


QCDSP_KERNELS = (
    Kernel("_mDotMEqual", "product of two SU(3) matrices", (BLOCK0, BLOCK0 + 0x80, BLOCK1)),
    Kernel("_uDotXEqual", "SU(3) matrix times vector", (BLOCK0, BLOCK0 + 0x80, BLOCK1)),
    Kernel("_fTimesV1MinusV2", "f x - y, 24 numbers", (BLOCK0, 0.5, BLOCK0 + 0x80, BLOCK1, 24)),
    Kernel("_vecAddEquVec", "x + y, 24 numbers", (BLOCK0, BLOCK1, 24)),
)


def qcdsp_kernel(source: Path, kernel: Kernel) -> Work:
    """The function of vector_util_asm.asm, assembled for the C40; code and data without wait states, data on chip."""
    program = c40.assemble_file(source)

    def prepared() -> c40.Processor:
        chip = c40.Processor(program)
        chip.memory.write_floats(BLOCK0, [0.01 * i - 0.5 for i in range(0x200)])
        chip.memory.write_floats(BLOCK1, [0.4 - 0.02 * i for i in range(0x200)])
        top = STACK
        for argument in kernel.arguments[::-1]:
            top += 1
            if isinstance(argument, float):
                chip.memory.write_floats(top, [argument])
            else:
                chip.memory[top] = argument
        chip.memory[top + 1] = BACK
        chip.registers["SP"] = top + 1
        chip.registers["AR3"] = STACK
        chip.pc = kernel.function
        return chip

    chip = prepared()
    assert chip.run(100_000, until=BACK).reason == "until"
    operations, stepped, texts = 0, prepared(), {}
    while stepped.pc != BACK:
        pc = stepped.pc
        if pc not in texts:
            texts[pc] = len(FLOAT_OPERATION.findall(c40.disassemble(stepped.memory[pc], pc)))
        operations += texts[pc]
        stepped.run(1)
    return Work(chip.cycles, operations)


@dataclass(frozen=True)
class TiRoutine:
    """A routine of TI's run-time library: its source, what it is, and the cycles that TI's comment says."""

    name: str
    source: str
    what: str
    said: str


TI_ROUTINES = (
    TiRoutine("INV_F40", "invf.asm", "1 / x", "10"),
    TiRoutine("DIV_F40", "divf.asm", "x / y", "18"),
    TiRoutine("DIV_I40", "divi.asm", "integer division, signed", "31-62"),
    TiRoutine("DIV_U40", "divu.asm", "integer division, unsigned", "31-65"),
    TiRoutine("MOD_I40", "modi.asm", "remainder, signed", "31-62"),
    TiRoutine("MOD_U40", "modu.asm", "remainder, unsigned", "31-60"),
)


def ti_library(archive: Path) -> c40.Program:
    """The routines' sources of rts.src, assembled without -mi, so with RPTS, as the counts suppose, and linked."""
    objects = []
    for name, text in script_module("foreign_ti").members(archive.read_bytes()):
        if name in {routine.source for routine in TI_ROUTINES}:
            objects.append(toolchain.assemble_object(text.decode("latin-1"), name))
    return toolchain.link(objects)[0]


def ti_cycles(program: c40.Program, routine: TiRoutine) -> tuple[int, int]:
    """The fewest and the most cycles over operands of every size, from the first instruction to the return; results are
    checked. Before each the routine has run once, so it is in the cache."""
    chip = c40.Processor(program, board="flat")
    counts = []
    for left, right in ti_operands(routine.name):
        for again in range(2):
            chip.registers["SP"], chip.memory[STACK] = STACK, BACK
            if routine.name.endswith("_F40"):
                chip.floats["R0"], chip.floats["R1"] = left, right
            else:
                chip.registers["R0"], chip.registers["R1"] = int(left) & 0xFFFFFFFF, int(right) & 0xFFFFFFFF
            chip.pc = routine.name
            before = chip.cycles
            assert chip.run(1000, until=BACK).reason == "until"
            if again:
                counts.append(chip.cycles - before)
        if routine.name.endswith("_F40"):
            expected = 1 / left if routine.name == "INV_F40" else left / right
            assert abs(chip.floats["R0"] / expected - 1) < 2e-7, (routine.name, left, right)
        else:
            quotient = abs(int(left)) // abs(int(right)) * (1 if (left < 0) == (right < 0) else -1)
            value = quotient if routine.name.startswith("DIV") else int(left) - quotient * int(right)
            assert chip.registers["R0"] & 0xFFFFFFFF == value & 0xFFFFFFFF, (routine.name, left, right)
    return min(counts), max(counts)


def ti_operands(name: str) -> list[tuple[float, float]]:
    """Floats, and integers whose quotients have 1 to 31 bits; of signed routines both signs, of unsigned ones dividends
    of 32 bits, too, which go a way of their own. Not a dividend that is smaller than the divisor."""
    if name.endswith("_F40"):
        return [(x, y) for x in (1.0, 3.0, -7.25, 1e6) for y in (1.0, 3.0, -0.7, 1e-3)]
    signed = "_I" in name
    signs = ((1, 1), (-1, 1), (1, -1), (-1, -1)) if signed else ((1, 1),)
    return [
        (a * dividend, b * divisor)
        for dividend in (1 << 30, (1 << 31) - 1, 12345, 7, *(() if signed else (1 << 31, (1 << 32) - 1)))
        for divisor in (1, 3, 1000, 1 << 20)
        if divisor <= dividend
        for a, b in signs
    ]
