"""Programs in the manner of C30 and C40 sources of the 1990s (tests/programs/period): interrupt routines, compiled C,
an executive with traps, a library called by LAJ, a parameterised FFT. Each against NumPy, zlib or exact integers, at
many moments of interruption, and the same watched by the self-checks."""

from __future__ import annotations

import math
import random
import zlib
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from cmrc import c40
from locations import ROOT
from words import signed

PERIOD = ROOT / "tests" / "programs" / "period"
VECTORS, TRAPS = 0x2FFA00, 0x2FFC00
ULP = 2.0**-23


def processor(name: str, entry: str, symbols: dict[str, int] | None = None, checks: bool = False) -> c40.Processor:
    program = c40.assemble_file(
        PERIOD / f"{name}.asm", entry=entry, symbols=symbols or {}, sections={"vectors": VECTORS, "traps": TRAPS}
    )
    return c40.Processor(program, checks=checks)


def words(chip: c40.Processor, name: str, count: int = 1) -> list[int]:
    return chip.memory[chip.address(name) : chip.address(name) + count]


def put(chip: c40.Processor, name: str, *values: int) -> None:
    chip.memory[chip.address(name) : chip.address(name) + len(values)] = [value & 0xFFFFFFFF for value in values]


def run_to(chip: c40.Processor, stop: str, cycles: int = 5_000_000) -> None:
    reached = chip.run(cycles, until=stop)
    assert reached.reason == "until", reached
    assert chip.diagnostics == []


# ---- FIR in an interrupt service routine

TAPS = [0.0125, -0.04, 0.0875, 0.125, -0.25, 0.5, 0.3125, -0.1, 0.04, 0.02, -0.01]  # from the oldest sample on


def filtered(gaps: list[int], checks: bool = False) -> tuple[np.ndarray, np.ndarray, list[int]]:
    rng = np.random.default_rng(len(gaps))
    samples = rng.uniform(-1, 1, len(gaps)).astype(np.float32).astype(float)
    chip = processor("fir_interrupt", "BEGIN", checks=checks)
    chip.run(200)  # set up; interrupts are enabled
    for served, (gap, sample) in enumerate(zip(gaps, samples, strict=True)):
        chip.run(gap)
        chip.memory.write_floats(chip.address("input"), [sample])
        chip.raise_interrupt("TINT0")
        chip.run(150)  # the routine's length and more
        assert words(chip, "served") == [served + 1]
    run_to(chip, "STOP")
    assert words(chip, "served") == [len(gaps)]
    return samples, np.array(chip.memory.read_floats(chip.address("outputs"), len(gaps))), words(chip, "chaos", 2)


@pytest.mark.parametrize("seed", range(4))
def test_fir_in_an_interrupt_routine_beside_a_program_that_misses_no_bit(seed: int) -> None:
    rng = random.Random(seed)
    _, _, undisturbed = filtered([])
    samples, got, chaos = filtered([rng.randint(1, 60) for _ in range(150)], checks=seed == 0)
    assert chaos == undisturbed
    h = np.array(TAPS[::-1])
    expected = np.convolve(samples, h)[: len(samples)]
    # Coefficients and the result are rounded or cut to 24 bits, everything between has 32.
    bound = (2 * ULP + len(TAPS) * 2.0**-30) * np.convolve(np.abs(samples), np.abs(h))[: len(samples)]
    assert (np.abs(got - expected) <= bound).all()


# ---- compiled C


def switched(op: int, a: int, b: int) -> int:
    return {0: a + b, 1: a - b, 2: a * b, 3: a & b, 4: a | b}.get(op, -1)


@pytest.mark.parametrize(
    ("queens", "solutions", "checks"), [(4, 2, True), (5, 10, False), (6, 4, False), (7, 40, False), (8, 92, False)]
)  # OEIS A000170
def test_compiled_c(queens: int, solutions: int, checks: bool) -> None:
    chip = processor("c_compiled", "_c_int00", {"QUEENS": queens}, checks)
    run_to(chip, "_exit", 20_000_000)
    assert words(chip, "_solutions") == [solutions]
    assert words(chip, "_ackermann") == [9]  # A(2, 3)
    assert [signed(word) for word in words(chip, "_cases", 8)] == [switched(op, -37, 11) for op in range(8)]
    assert words(chip, "_array", 5) == [x * x + 1 for x in (3, -4, 0, 100, -1000)]
    assert chip.registers["SP"] == chip.registers["AR3"] == chip.address("_stack")


# ---- the application notes' FFT


@pytest.mark.parametrize("m", [2, 3, 4, 6, 8, 10])
def test_fft_of_any_size(m: int) -> None:
    n = 1 << m
    chip = processor("fft_stages", "FFT", {"N": n, "M": m}, checks=m == 4)
    chip.memory.write_floats(chip.address("SINE"), np.sin(2 * np.pi * np.arange(n + n // 4) / n).tolist())
    rng = np.random.default_rng(m)
    parts = rng.standard_normal((n, 2)).astype(np.float32).astype(float)
    chip.memory.write_floats(chip.address("INP"), parts.ravel().tolist())
    run_to(chip, "DONE")
    got = np.array(chip.memory.read_floats(chip.address("INP"), 2 * n)).reshape(n, 2) @ [1, 1j]
    x = parts @ [1, 1j]
    # As in test_examples: at most 4 units of 2^-23 a stage on each part, of values below the sum of all moduli.
    assert np.abs(got - np.fft.fft(x)).max() < m * 4 * math.sqrt(2) * ULP * np.abs(x).sum()


# ---- tasks


def run_tasks(interval: Any, checks: bool = False) -> tuple[c40.Processor, int]:
    """The chip at its end, and how often the timer came; `interval` gives the cycles between, None for no timer."""
    chip = processor("tasks", "START", checks=checks)
    rng = random.Random(11)
    message = [rng.getrandbits(32) for _ in range(32)]
    put(chip, "message", *message)
    chip.memory.write_floats(chip.address("factor"), [3.9])
    ticks = 0
    for _ in range(2_000):
        if chip.run(interval() if interval else 1_000_000, until="STOP").reason == "until":
            break
        chip.raise_interrupt("TINT0")
        ticks += 1
    assert words(chip, "ended") == [3]
    assert words(chip, "primes") == [sum(all(n % d for d in range(2, n)) for n in range(2, 500))]
    assert words(chip, "crc") == [zlib.crc32(b"".join(word.to_bytes(4, "little") for word in message))]
    assert chip.registers["SP"] == chip.address("idle_stack")
    assert chip.diagnostics == []
    return chip, ticks


@pytest.mark.parametrize("period", [400, 401, 457, 613, 1009, 5003, "random", "watched"])
def test_tasks_do_not_feel_how_the_chip_is_divided(period: int | str) -> None:
    plain, ticks = run_tasks(None)
    assert ticks == 0
    rng = random.Random(str(period))
    chip, ticks = run_tasks(
        lambda: period if isinstance(period, int) else rng.randint(350, 900), checks=period == "watched"
    )
    assert ticks > 5
    assert words(chip, "chaos", 2) == words(plain, "chaos", 2)
    assert words(chip, "switches")[0] >= ticks - 1


# ---- a vector library


@pytest.mark.parametrize("count", [2, 3, 17, 300])
@pytest.mark.parametrize("checks", [False, True])
def test_vector_library(count: int, checks: bool) -> None:
    rng = np.random.default_rng(count)
    x = rng.uniform(-4, 4, count).astype(np.float32).astype(float)
    if count == 17:
        x[5] = x[11] = 4.5  # the largest twice
    x[-1] = -0.5
    y = rng.uniform(-1, 1, count).astype(np.float32).astype(float)
    a = 0.8125
    chip = processor("vector_library", "START", checks=checks)
    put(chip, "count", count)
    for name, values in (("a", [a]), ("x", x.tolist()), ("y", y.tolist())):
        chip.memory.write_floats(chip.address(name), values)
    run_to(chip, "DONE")

    def got(name: str) -> float:
        return chip.memory.read_floats(chip.address(name), 1)[0]

    magnitude = float(np.abs(x) @ np.abs(y))
    assert abs(got("dot") - x @ y) <= abs(x @ y) * ULP + (count + 1) * 2.0**-30 * magnitude
    result = np.array(chip.memory.read_floats(chip.address("result"), count))
    assert (np.abs(result - (a * x + y)) <= np.abs(a * x + y) * ULP + 2.0**-29 * (np.abs(a * x) + np.abs(y))).all()
    assert got("top") == x.max() and words(chip, "where") == [int(x.argmax())]
    polynomial = Fraction(0)
    for coefficient in y:
        polynomial = polynomial * Fraction(a) + Fraction(coefficient)
    assert abs(got("poly") - polynomial) <= abs(float(polynomial)) * ULP + 2.0**-29 / (1 - a)
    assert words(chip, "below") == [int(np.argmax(x < 0))]
    assert chip.registers["SP"] == chip.address("stack")
