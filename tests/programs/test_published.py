"""The routines after TI's published structures compute what they claim, against NumPy, and take as long as their loops
say."""

import random

import numpy as np
import pytest
from script_modules import script

published = script("published_counts")


def read(chip, address: int, count: int) -> np.ndarray:
    return np.array(chip.memory.read_floats(address, count))


@pytest.mark.parametrize("taps", [16, 64, 256])
def test_fir(taps: int) -> None:
    call = published.fir(taps)
    chip, cycles = call.run()
    h, x = call.memory.values()
    assert chip.floats["R2"] == pytest.approx(np.dot(h, x), abs=1e-4)
    assert cycles == 11 + taps - 1


@pytest.mark.parametrize("stages", [1, 4, 16])
def test_biquads(stages: int) -> None:
    call = published.biquads(stages)
    chip, _ = call.run()
    coefficients, delays = (np.array(values) for values in call.memory.values())
    x = 0.75
    for i in range(stages):
        a2, b2, a1, b1, b0 = coefficients[5 * i : 5 * i + 5]
        d2, d1 = delays[i], delays[stages + i]
        d = x + a2 * d2 + a1 * d1
        x = b0 * d + b1 * d1 + b2 * d2
    assert chip.floats["R0"] == pytest.approx(x, rel=1e-4, abs=1e-9)


def test_lms() -> None:
    call = published.lms(16)
    chip, _ = call.run()
    w, x = (np.array(values) for values in call.memory.values())
    y = w @ x
    assert chip.floats["R2"] == pytest.approx(y, abs=1e-5)
    assert read(chip, published.BLOCK0, 16) == pytest.approx(w + 0.125 * (0.5 - y) * x, abs=1e-5)


def test_matrix_vector() -> None:
    call = published.matrix_vector(8, 16)
    chip, _ = call.run()
    m, v = (np.array(values) for values in call.memory.values())
    assert read(chip, published.BLOCK1 + 0x200, 8) == pytest.approx(m.reshape(8, 16) @ v, abs=1e-5)


def test_inverse_and_root() -> None:
    for routine, expected in (("inverse", 1 / 3), ("square_root", 3**0.5)):
        chip, _ = published.Call(routine, {}, {"R0": 3.0}).run()
        assert chip.floats["R2"] == pytest.approx(expected, rel=1e-7)


def test_integer_division_is_that_of_c() -> None:
    rng = random.Random(5)
    pairs = [
        (2**31 - 1, 1),
        (2**31 - 1, -3),
        (5, 9),
        (-5, 9),
        (0, 4),
        (-7, -7),
        (2**30, 2**30),
        (2**31 - 1, 2**31 - 1),
        (-(2**31) + 1, 2),
    ]
    pairs += [
        (rng.randrange(-(2**31) + 1, 2**31), rng.choice([-1, 1]) * (rng.randrange(2**31) >> rng.randrange(31) or 1))
        for _ in range(60)
    ]
    for dividend, divisor in pairs:
        chip, _ = published.division(dividend, divisor).run()
        quotient = abs(dividend) // abs(divisor) * (1 if dividend * divisor > 0 else -1)
        assert chip.registers["R0"] & 0xFFFFFFFF == quotient & 0xFFFFFFFF, (dividend, divisor)


def test_integer_division_takes_a_cycle_for_each_bit() -> None:
    cycles = [published.division(2**bits - 1, 1).run()[1] for bits in range(1, 32)]
    assert cycles == list(range(cycles[0], cycles[0] + 31))


@pytest.mark.parametrize(("radix", "points"), [(2, 64), (2, 512), (2, 1024), (4, 64), (4, 256), (4, 1024)])
def test_fft(radix: int, points: int) -> None:
    call = published.fft(radix, points)
    chip, _ = call.run()
    data = np.array(call.memory[published.fft_places(points)[0]])
    result = read(chip, published.fft_places(points)[1], 2 * points)
    expected = np.fft.fft(data[0::2] + 1j * data[1::2])
    assert np.abs(result[0::2] + 1j * result[1::2] - expected).max() < 1e-3


@pytest.mark.parametrize(("make", "slope"), [("fir", 1), ("biquads", 6), ("lms", 3)])
def test_slopes(make: str, slope: int) -> None:
    one, other = (getattr(published, make)(n).run()[1] for n in (8, 16))
    assert other - one == 8 * slope
