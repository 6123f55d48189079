"""The programs of c40_programs/examples/peripherals: counts by hand, NumPy, golden event traces."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
from cmrc.network import Network
from locations import ROOT

EXAMPLES = ROOT / "c40_programs" / "examples" / "peripherals"
CYCLE_PS = 50_000


def test_dma_chain(emulator: Path, golden: Callable[[str, str], None], tmp_path: Path) -> None:
    command = [
        emulator,
        "exec",
        EXAMPLES / "dma_chain.asm",
        "--check",
        "--events",
        tmp_path / "events",
        "--dump",
        "transposed:256",
    ]
    text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    words = [
        int(word, 16)
        for line in text.splitlines()
        if line.startswith(("002FFD", "002FFE"))
        for word in line.split(":")[1].split()
    ]
    assert "no rule was broken" in text
    assert words == [16 * (i % 16) + i // 16 for i in range(256)]
    events = [line.split() for line in (tmp_path / "events").read_text().splitlines()]
    start, ends = int(events[0][0]), [int(event[0]) for event in events if event[1] == "dma_end"]
    assert events[0][1] == "dma_start" and len(ends) == 16
    # One cycle from the write to the first access; a list is 7 reads and 7 register writes, a row 16 reads and 16
    # writes (3.5, 3.7).
    assert ends == [start + 1 + (k + 1) * (14 + 2 * 16) for k in range(16)] and ends[-1] - start == 737
    assert events[-1][1:3] == ["interrupt", "37"] and int(events[-1][0]) == ends[-1]  # 25h; the processor was in IDLE
    golden("peripherals-dma_chain.events", (tmp_path / "events").read_text())


def test_servo(golden: Callable[[str, str], None]) -> None:
    network = Network([EXAMPLES / "servo.asm"] * 2, links=["0.0:1.3"], record_words=True, record_peripherals=True)
    assert network.run().reason == "ended"
    controller = network.chips[0]
    x = v = before = np.float32(0)
    expected = []
    for _ in range(64):
        expected.append(float(x))
        v += np.float32(0.0625) * (1 - x) - np.float32(0.5) * (x - before)
        before = x
        x += v
    got = controller.memory.read_floats(controller.address("positions"), 64)
    assert np.abs(np.array(got) - expected).max() < 1e-5
    assert abs(got[-1] - 1) < 0.02 and max(got) < 1.2
    ticks = [event.time_ps for event in network.peripheral_events if event.kind == "interrupt"]
    assert len(ticks) == 64 and {b - a for a, b in pairwise(ticks)} == {1000 * CYCLE_PS}
    torques = [event.time_ps for event in network.events if event.kind == "word" and event.side == 0]
    assert {b - a for a, b in pairwise(torques)} == {1000 * CYCLE_PS}
    golden(
        "peripherals-servo.events",
        "".join(line + "\n" for line in network.event_trace if int(line.split()[0]) < 10 * 1000 * CYCLE_PS),
    )


def test_every_example_is_tested_and_listed() -> None:
    text, page = Path(__file__).read_text(), (ROOT / "docs" / "peripherals.md").read_text()
    for path in EXAMPLES.glob("*.asm"):
        assert f'EXAMPLES / "{path.name}"' in text and f"`{path.name}`" in page, path.name
