"""The programs of c40_programs/examples/networks, held against NumPy and counts by hand; their link traces against
golden ones."""

from __future__ import annotations

import hashlib
import json
import subprocess
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from cmrc.c40 import assemble_file
from cmrc.network import Network
from locations import ROOT

EXAMPLES = ROOT / "c40_programs" / "examples" / "networks"
CYCLE_PS = 50_000
CHIPS = (1, 2, 4, 8, 16)


def trace(network: Network) -> str:
    return "".join(event.text + "\n" for event in network.events)


def test_ring(golden: Callable[[str, str], None]) -> None:
    for chips in (1, 2, 8, 64):
        network = Network(EXAMPLES / "ring.asm", topology=f"ring:{chips}", record_words=True)
        assert network.run().reason == "ended"
        first = network.chips[0]
        assert first.memory[first.address("token")] == 10 * chips
        assert all(link.forth.sent == 10 and link.back.sent == 0 for link in network.links)
        if chips == 8:
            golden("networks/ring.trace", trace(network))


def round_trips(network: Network, name: str = "cycles") -> list[int]:
    first = network.chips[0]
    return first.memory[first.address(name) : first.address(name) + 9]


def test_bandwidth(golden: Callable[[str, str], None]) -> None:
    network = Network([EXAMPLES / "bandwidth.asm"] * 2, links=["0.0:1.3"], record_words=True)
    assert network.run().reason == "ended"
    golden("networks/bandwidth.trace", trace(network))
    cycles = round_trips(network)
    sizes = [2**n for n in range(9)]
    # A word more costs five cycles each way; the timer counts in twos.
    for (a, n), (b, m) in zip(zip(cycles, sizes, strict=True), zip(cycles[1:], sizes[1:], strict=True), strict=False):
        if n >= 4:
            assert abs(b - a - 10 * (m - n)) <= 4, (n, m)
    assert 5 < cycles[-1] / (2 * 256) < 5.3
    assert cycles[0] >= 2 * 13  # two latencies with the token elsewhere
    words = [event.time_ps for event in network.events if event.kind == "word"][-256:]
    assert {b - a for a, b in pairwise(words)} == {5 * CYCLE_PS}
    assert [event.kind for event in network.events].count("token") == 17  # all but the first message need it


def test_bandwidth_dma(golden: Callable[[str, str], None]) -> None:
    network = Network(
        [EXAMPLES / "bandwidth_dma.asm"] * 2, links=["0.0:1.3"], record_words=True, record_peripherals=True
    )
    assert network.run().reason == "ended"
    golden(
        "networks/bandwidth-dma.trace",
        "".join(line + "\n" for line in network.event_trace if "port_" not in line and " word " not in line),
    )
    cycles = round_trips(network)
    sizes = [2**n for n in range(9)]
    for (a, n), (b, m) in zip(zip(cycles, sizes, strict=True), zip(cycles[1:], sizes[1:], strict=True), strict=False):
        if n >= 4:
            assert b - a == 10 * (m - n), (n, m)  # five cycles a word each way, however it is moved
    assert 5 < cycles[-1] / (2 * 256) < 5.3
    moved = [event for event in network.peripheral_events if event.kind in ("port_read", "port_write")]
    assert len(moved) == 4 * sum(sizes) and all(event.channel in (0, 3) for event in moved)  # the processors touch none
    words = [event.time_ps for event in network.events if event.kind == "word"][-256:]
    assert {b - a for a, b in pairwise(words)} == {5 * CYCLE_PS}
    assert all(chip.causes["idle"] > 0.8 * chip.cycles for chip in network.chips)


def thinned(network: Network, every: int) -> str:
    """Every n-th word of each direction of each link, and the hash of the whole trace."""
    seen: dict[tuple[int, int], int] = {}
    lines = []
    for event in network.events:
        key = (event.place, event.side)
        seen[key] = seen.get(key, 0) + 1
        if seen[key] % every == 1:
            lines.append(event.text + "\n")
    return (
        "".join(lines)
        + f"# sha256 of all {len(network.events)} lines: {hashlib.sha256(trace(network).encode()).hexdigest()}\n"
    )


def test_matrix_ring_golden(golden: Callable[[str, str], None]) -> None:
    network = Network(EXAMPLES / "matrix_ring.asm", topology="ring:4", record_words=True)
    for k, chip in enumerate(network.chips):
        for name in ("a_part", "b_part"):
            chip.memory.write_floats(chip.address(name), [((7 * i + 3 * k) % 31 - 15) / 8 for i in range(16 * 64)])
    assert network.run().reason == "ended"
    golden("networks/matrix.trace", thinned(network, 128))


def test_fft_hypercube_golden(golden: Callable[[str, str], None]) -> None:
    network = Network(EXAMPLES / "fft_hypercube.asm", topology="hypercube:4", record_words=True)
    for k, chip in enumerate(network.chips):
        for name in ("real", "imaginary"):
            chip.memory.write_floats(chip.address(name), [((5 * i + k) % 17 - 8) / 4 for i in range(256)])
    assert network.run().reason == "ended"
    golden("networks/fft.trace", thinned(network, 64))


def test_matrix_ring() -> None:
    rng = np.random.default_rng(11)
    a, b = (rng.uniform(-1, 1, (64, 64)).astype(np.float32).astype(float) for _ in range(2))
    took = {}
    for chips in CHIPS:
        network = Network(EXAMPLES / "matrix_ring.asm", topology=f"ring:{chips}")
        m = 64 // chips
        for k, chip in enumerate(network.chips):
            chip.memory.write_floats(chip.address("a_part"), list(a[k * m : (k + 1) * m].ravel()))
            chip.memory.write_floats(chip.address("b_part"), list(b.T[k * m : (k + 1) * m].ravel()))
        assert network.run().reason == "ended"
        c = np.concatenate(
            [np.reshape(chip.memory.read_floats(chip.address("c_part"), m * 64), (m, 64)) for chip in network.chips]
        )
        # Products and sums in extended precision, one rounding to 24 bits at the end.
        assert (np.abs(c - a @ b) <= np.abs(a @ b) * 2.0**-23 + 65 * 2.0**-30 * (np.abs(a) @ np.abs(b))).all()
        took[chips] = max(chip.cycles for chip in network.chips)
        assert all(link.forth.sent == (chips - 1) * m * 64 for link in network.links)
    speed_up = {chips: took[1] / took[chips] for chips in CHIPS}
    assert all(1 < speed_up[2 * n] / speed_up[n] <= 2 for n in CHIPS[:-1])
    assert speed_up[4] > 3 and speed_up[16] > 8


def test_fft_hypercube() -> None:
    rng = np.random.default_rng(12)
    signal = (rng.standard_normal(1024) + 1j * rng.standard_normal(1024)).astype(np.complex64).astype(complex)
    took = {}
    for chips in CHIPS:
        network = Network(EXAMPLES / "fft_hypercube.asm", topology=f"hypercube:{chips}")
        points = 1024 // chips
        for k, chip in enumerate(network.chips):
            part = signal[k * points : (k + 1) * points]
            chip.memory.write_floats(chip.address("real"), list(part.real))
            chip.memory.write_floats(chip.address("imaginary"), list(part.imag))
        assert network.run().reason == "ended"
        got = np.concatenate([
            np.array(chip.memory.read_floats(chip.address("real"), points)) + 1j * np.array(chip.memory.read_floats(chip.address("imaginary"), points))
            for chip in network.chips
        ])  # fmt: skip
        reversed_bits = [int(f"{n:010b}"[::-1], 2) for n in range(1024)]
        # The bound of examples/fft1024: ten stages, four units of 2^-23 each on real and imaginary part.
        assert np.abs(got[reversed_bits] - np.fft.fft(signal)).max() < 10 * 4 * 2**0.5 * 2.0**-23 * np.abs(signal).sum()
        took[chips] = max(chip.cycles for chip in network.chips)
        dimensions = chips.bit_length() - 1
        assert sum(link.forth.sent + link.back.sent for link in network.links) == dimensions * 2 * 1024
    speed_up = {chips: took[1] / took[chips] for chips in CHIPS}
    assert all(1 < speed_up[2 * n] / speed_up[n] <= 2.05 for n in CHIPS[:-1])
    assert speed_up[16] > 8


@pytest.mark.parametrize(("columns", "rows"), [(1, 1), (4, 4), (3, 2)])
def test_worm(columns: int, rows: int) -> None:
    chips = columns * rows
    source = assemble_file(EXAMPLES / "worm.asm", entry="start")
    network = Network(source, topology=f"grid:{columns}x{rows}", boots=range(1, chips))
    assert network.run(max_cycles=200_000).reason == "ended"
    for n, chip in enumerate(network.chips):
        x, y = n % columns, n // columns
        here = [chip.memory[chip.address(name)] for name in ("column", "row", "columns", "rows", "count")]
        below = rows - y
        assert here == [x, y, columns, rows, below if y else rows * (columns - x)]
        code = chip.address("end") - chip.address("booted")
        assert chip.memory[chip.address("booted") : chip.address("end")] == list(source.sections[0].words[:code])
    sent = {link.forth.sent for link in network.links}
    assert sent <= {0, code + 8 + 4}  # GMICR, LMICR, size, address, the block, 0, IVTP, TVTP, IACK; then four words
    assert sum(link.back.sent for link in network.links) == chips - 1


def test_worm_from_its_file(emulator: Path, golden: Callable[[str, str], None], tmp_path: Path) -> None:
    command = [
        emulator,
        "exec",
        "--network",
        EXAMPLES / "worm.toml",
        "--json",
        "--dump",
        "0:count:1",
        "--link-trace",
        tmp_path / "trace",
    ]
    report = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    assert report["stop"]["reason"] == "ended" and report["dumps"][0]["words"] == [16]
    lines = (tmp_path / "trace").read_text().splitlines(keepends=True)
    golden("networks/worm.trace", "".join(line for line in lines if " 0.0>" in line or "token" in line))


def test_every_network_example_is_tested_and_listed() -> None:
    text, page = Path(__file__).read_text(), (ROOT / "docs" / "networks.md").read_text()
    for path in EXAMPLES.glob("*.asm"):
        assert f'EXAMPLES / "{path.name}"' in text and f"`{path.name}`" in page, path.name


@pytest.mark.parametrize("seed", [1, 2])
def test_turns(seed: int) -> None:
    def run(turn_order: int) -> tuple[str, list[int]]:
        network = Network(
            EXAMPLES / "fft_hypercube.asm", topology="hypercube:8", turn_order=turn_order, record_words=True
        )
        network.run()
        return trace(network), [chip.cycles for chip in network.chips]

    assert run(seed) == run(0)
