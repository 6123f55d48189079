"""The programs of c40_programs/examples on an emulated chip, held against what Python, zlib, hashlib and NumPy say."""

import hashlib
import math
import random
import zlib
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from cmrc import c40
from locations import ROOT
from words import signed

EXAMPLES = ROOT / "c40_programs" / "examples"
ULP = 2.0**-23  # of the single format's mantissa, relative: its last place at worst


class Example:
    """A program, its variables by name, and a run from `start` to `done`."""

    def __init__(self, name: str) -> None:
        self.chip = c40.Processor(c40.assemble_file(EXAMPLES / f"{name}.asm", entry="start"))

    def at(self, name: str) -> int:
        return self.chip.address(name)

    def put(self, name: str, *words: int) -> None:
        self.chip.memory[self.at(name) : self.at(name) + len(words)] = list(words)

    def put_floats(self, name: str, values: object) -> None:
        self.chip.memory.write_floats(self.at(name), [float(value) for value in np.ravel(values)])

    def words(self, name: str, count: int) -> list[int]:
        return self.chip.memory[self.at(name) : self.at(name) + count]

    def word(self, name: str) -> int:
        return self.words(name, 1)[0]

    def floats(self, name: str, count: int) -> np.ndarray:
        return np.array(self.chip.memory.read_floats(self.at(name), count))

    def run(self, max_cycles: int = 20_000_000) -> int:
        """The cycles it took."""
        self.chip.pc = "start"
        before = self.chip.cycles
        stop = self.chip.run(max_cycles, until="done")
        assert stop.reason == "until", stop
        return self.chip.cycles - before


def packed(data: bytes) -> list[int]:
    """Four bytes to a word, the first in bits 7 to 0."""
    data += b"\0" * (-len(data) % 4)
    return [int.from_bytes(data[i : i + 4], "little") for i in range(0, len(data), 4)]


def unpacked(words: list[int]) -> bytes:
    return b"".join(word.to_bytes(4, "little") for word in words)


MESSAGES = [
    b"",
    b"a",
    b"ab",
    b"abc",
    b"123456789",
    bytes(range(256)),
    b"The quick brown fox jumps over the lazy dog",
    *(random.Random(n).randbytes(n) for n in (54, 55, 56, 57, 63, 64, 65, 119, 120, 500)),
]


@pytest.fixture(scope="module")
def crc() -> Example:
    return Example("crc32")


@pytest.mark.parametrize("message", MESSAGES, ids=len)
def test_crc32(crc: Example, message: bytes) -> None:
    crc.put("message", *packed(message))
    crc.put("length", len(message))
    crc.run()
    assert crc.word("crc_by_bits") == crc.word("crc_by_table") == zlib.crc32(message)


@pytest.fixture(scope="module")
def sha1() -> Example:
    return Example("sha1")


@pytest.mark.parametrize("message", MESSAGES, ids=len)
def test_sha1(sha1: Example, message: bytes) -> None:
    sha1.put("message", *packed(message + b"\xff" * 8))  # what lies behind the message must not matter
    sha1.put("length", len(message))
    sha1.run()
    digest = b"".join(word.to_bytes(4, "big") for word in sha1.words("digest", 5))
    assert digest.hex() == hashlib.sha1(message).hexdigest()


@pytest.mark.parametrize("kind", ["random", "rising", "falling", "equal", "few", "extreme", "one", "none"])
def test_quicksort(kind: str) -> None:
    rng = random.Random(5)
    numbers = {
        "random": [rng.getrandbits(32) for _ in range(3000)],
        "rising": list(range(2000)),
        "falling": list(range(2000, 0, -1)),
        "equal": [7] * 500,
        "few": [rng.choice([0, 1, 0xFFFFFFFF]) for _ in range(1000)],
        "extreme": [0x7FFFFFFF, 0x80000000, 0, 0x80000000, 0x7FFFFFFF, 0xFFFFFFFF] * 20,
        "one": [3],
        "none": [],
    }[kind]
    example = Example("quicksort")
    example.put("numbers", *numbers, 0x5A5A5A5A)
    example.put("count", len(numbers))
    example.run()
    assert [signed(word) for word in example.words("numbers", len(numbers))] == sorted(map(signed, numbers))
    assert example.words("numbers", len(numbers) + 1)[-1] == 0x5A5A5A5A
    if kind in ("random", "rising", "falling"):
        assert example.word("deepest") < 3 * 4 * math.log2(len(numbers))  # three words a level


def test_fft_against_numpy() -> None:
    rng = np.random.default_rng(1)
    k = np.arange(1024)
    signals = [
        rng.standard_normal(1024) + 1j * rng.standard_normal(1024),
        np.exp(2j * np.pi * 37 * k / 1024),
        (k == 3).astype(complex),
    ]
    example = Example("fft1024")
    for signal in signals:
        signal = signal.real.astype(np.float32) + 1j * signal.imag.astype(np.float32).astype(float)
        example.put_floats("real", signal.real)
        example.put_floats("imaginary", signal.imag)
        example.run()
        got = example.floats("real", 1024) + 1j * example.floats("imaginary", 1024)
        # Every stage rounds twice (sum or difference; products and their sum: truncated), and its factors are rounded
        # to 24 bits: at most 4 units of 2^-23 on each part, sqrt 2 on the modulus. No value on the way exceeds the sum
        # of all moduli.
        bound = 10 * 4 * math.sqrt(2) * ULP * np.abs(signal).sum()
        assert np.abs(got - np.fft.fft(signal)).max() < bound


@pytest.mark.parametrize(
    ("rows", "inner", "columns"), [(1, 1, 1), (1, 5, 1), (4, 2, 3), (3, 32, 7), (16, 16, 16), (32, 1, 32)]
)
def test_matrix_product(rows: int, inner: int, columns: int) -> None:
    rng = np.random.default_rng(rows * 100 + inner)
    a = rng.uniform(-2, 2, (rows, inner)).astype(np.float32).astype(float)
    b = rng.uniform(-2, 2, (inner, columns)).astype(np.float32).astype(float)
    example = Example("matrix")
    for name, value in (("rows", rows), ("inner", inner), ("columns", columns)):
        example.put(name, value)
    example.put_floats("a", a)
    example.put_floats("b_matrix", b)
    example.run()
    got = example.floats("c_matrix", rows * columns).reshape(rows, columns)
    # Products and sums in extended precision (2^-31 each), one rounding to 24 bits at the end.
    bound = np.abs(a @ b) * ULP + (inner + 1) * 2.0**-30 * (np.abs(a) @ np.abs(b))
    assert (np.abs(got - a @ b) <= bound).all()


def test_lms_learns_an_unknown_system() -> None:
    rng = np.random.default_rng(3)
    taps, samples, two_mu = 16, 1500, 0.05
    system = rng.uniform(-1, 1, taps)
    x = rng.standard_normal(samples).astype(np.float32).astype(float)
    d = np.convolve(x, system)[:samples].astype(np.float32).astype(float)
    w, errors = np.zeros(taps), []
    for n in range(samples):
        window = np.array([x[n - k] if n >= k else 0.0 for k in range(taps)])
        e = d[n] - w @ window
        w = w + two_mu * e * window
        errors.append(e)
    example = Example("lms")
    example.put("samples", samples)
    example.put_floats("two_mu", [two_mu])
    example.put_floats("input", x)
    example.put_floats("desired", d)
    example.run()
    weights = example.floats("weights", taps)[::-1]  # stored from the oldest tap on
    # Each update rounds the weights to 24 bits; the adaptation forgets with 1 - 2 mu per sample, so what stays is 1/(2
    # mu) roundings or so, times the input's size.
    assert weights == pytest.approx(w, abs=1 / two_mu * taps * ULP)
    assert weights == pytest.approx(system, abs=1e-4)
    got = example.floats("errors", samples)
    assert got == pytest.approx(np.array(errors), abs=1 / two_mu * taps * ULP * np.abs(x).max() * taps)
    assert np.abs(got[-100:]).max() < 1e-4 < np.abs(got[:100]).max()


def test_division_and_square_root() -> None:
    rng = random.Random(4)
    pairs = [
        (1.0, 3.0),
        (-1.0, 3.0),
        (2.0, -7.0),
        (1.0, 1.0),
        (0.0, 5.0),
        (1e10, 1e-10),
        (3.5, -1.0),
        (-4.0, 2.0),
        (1.9999998807907104, 1.0000001192092896),
    ]
    while len(pairs) < 250:
        pairs.append(
            tuple(rng.choice([-1, 1]) * np.float32(rng.uniform(1, 2) * 2.0 ** rng.randint(-40, 40)) for _ in range(2))
        )  # type: ignore[arg-type]
    example = Example("divide")
    example.put("count", len(pairs))
    example.put_floats("dividends", [a for a, _ in pairs])
    example.put_floats("divisors", [b for _, b in pairs])
    example.run()
    quotients, roots = example.floats("quotients", len(pairs)), example.floats("roots", len(pairs))
    for (a, b), quotient, root in zip(pairs, quotients, roots, strict=True):
        exact = Fraction(float(a)) / Fraction(float(b))
        # Rounded to 24 bits, half a unit in the last place; the 32-bit arithmetic before adds 2^-29 at most.
        assert abs(Fraction(float(quotient)) - exact) <= abs(exact) * (Fraction(1, 2**24) + Fraction(1, 2**29)), (a, b)
        assert root == pytest.approx(math.sqrt(abs(a)), rel=2.0**-24 + 2.0**-29, abs=0)


def test_integer_division() -> None:
    rng = random.Random(6)
    edges = [0, 1, 2, 3, 7, 0x7FFFFFFF, 0x80000000, 0x80000001, 0xFFFFFFFE, 0xFFFFFFFF, 0xA0000000, 0x40000000]
    pairs = [(a, b) for a in edges for b in edges]
    while len(pairs) < 256:
        pairs.append((rng.getrandbits(rng.randint(1, 32)), rng.getrandbits(rng.randint(1, 32))))
    example = Example("integer_division")
    example.put("count", len(pairs))
    example.put("dividends", *(a for a, _ in pairs))
    example.put("divisors", *(b for _, b in pairs))
    example.run()
    results = [
        example.words(name, len(pairs)) for name in ("quotients", "remainders", "signed_quotients", "signed_remainders")
    ]
    for (a, b), q, r, sq, sr in zip(pairs, *results, strict=True):
        assert (q, r) == (divmod(a, b) if b else (0xFFFFFFFF, a)), (a, b)
        x, y = signed(a), signed(b)
        if y == 0:
            continue
        truncated = abs(x) // abs(y) * (1 if (x < 0) == (y < 0) else -1)
        assert (sq, sr) == (truncated & 0xFFFFFFFF, (x - truncated * y) & 0xFFFFFFFF), (x, y)


def test_arithmetic_of_64_bits() -> None:
    rng = random.Random(7)
    edges = [0, 1, 0xFFFFFFFF, 0x100000000, 0x7FFFFFFFFFFFFFFF, 0x8000000000000000, 0xFFFFFFFFFFFFFFFF]
    pairs = ([(a, b) for a in edges for b in edges] + [(rng.getrandbits(64), rng.getrandbits(64)) for _ in range(64)])[
        :64
    ]
    example = Example("int64")
    example.put("count", len(pairs))
    for name, side in (("left", 0), ("right", 1)):
        example.put(name, *(word for pair in pairs for word in (pair[side] & 0xFFFFFFFF, pair[side] >> 32)))
    example.run()

    def longs(name: str) -> list[int]:
        words = example.words(name, 2 * len(pairs))
        return [low | high << 32 for low, high in zip(words[::2], words[1::2], strict=True)]

    mask = (1 << 64) - 1
    assert longs("sums") == [(a + b) & mask for a, b in pairs]
    assert longs("differences") == [(a - b) & mask for a, b in pairs]
    assert longs("products") == [a * b & mask for a, b in pairs]
    assert longs("shifted") == [a << 1 & mask for a, _ in pairs]
    assert [signed(word) for word in example.words("orders", len(pairs))] == [(a > b) - (a < b) for a, b in pairs]


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (b"", b""),
        (b"abc", b"abc"),
        (b"abc", b"abd"),
        (b"abcd", b"abc"),
        (b"Hello, World! zZaA@[`{", b"Hello"),
        (b"\x80", b"\x7f"),
        (b"long enough to span several words", b"long enough to span several Words"),
    ],
)
@pytest.mark.parametrize("offset", range(5))
def test_strings(first: bytes, second: bytes, offset: int) -> None:
    example = Example("strings")
    memory = first + b"\0" + b"behind the end"
    size = 13
    example.put("first", *packed(memory + b"\0" * 8))
    example.put("second", *packed(second + b"\0"))
    example.put("size", size)
    example.put("offset", offset)
    example.run()
    assert example.word("first_length") == len(first)
    assert signed(example.word("order")) == (first > second) - (first < second)
    assert unpacked(example.words("upper", 16))[: len(first) + 1] == first.upper() + b"\0"
    assert unpacked(example.words("copy", 4))[:size] == (memory + b"\0" * 24)[offset : offset + size]


def test_every_example_is_tested_and_listed() -> None:
    sources = {path.stem for path in EXAMPLES.glob("*.asm")}
    text = Path(__file__).read_text()
    page = (EXAMPLES / "README.md").read_text()
    for name in sources:
        assert f'Example("{name}")' in text and f"`{name}.asm`" in page, name
