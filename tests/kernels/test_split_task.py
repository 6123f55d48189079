"""The survey of examples/split_task.py, whole and in halves, against its mathematics in Python; the example itself."""

from __future__ import annotations

import functools
import importlib.util
import math
import random
import re
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from cmrc import _core
from cmrc_test import run_setup
from harness import WINDOW_B, Dsp
from locations import ROOT
from words import signed

RAYS, SECTORS, MOST, HALF_WIDTH = 180, 36, 30_000, 1800


@functools.cache
def example() -> ModuleType:
    spec = importlib.util.spec_from_file_location("split_task", ROOT / "examples" / "split_task.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("split")
    example().programs(made / "programs")
    return made


class Survey(Dsp):
    """A DSP with the survey's programs; `area` is the first task's."""

    def __init__(self, folder: Path, rays: list[int]) -> None:
        super().__init__()
        config = _core.cmrc.config(toml=example().HALVES, settings={"machine.programs": str(folder / "programs")})
        program = run_setup.dsp_image(config)
        self.symbols = s = program.symbols
        self.chip.load_image(program)
        first, last = s["constants"], s["constants_end"]
        self.chip.load_words(s["CONSTANTS"], self.chip.read(first, last - first))
        self.area = 0xC0000000 + s["US_BASE"]
        self.sensor = s["AGV_RANGE"]
        for name, value in {
            "RANGE_COUNT": RAYS,
            "RANGE_FIRST": -1_562_069,
            "RANGE_STEP": 17_453,
            "RANGE_MOUNT": 2900,
            "RANGE_SCAN": 77,
        }.items():
            self.chip.poke(WINDOW_B + self.sensor + s[name], value & 0xFFFFFFFF)
        self.chip.load_words(WINDOW_B + self.sensor + s["RANGE_RAY"], rays)

    def task(self, name: str, area: int, tick: int = 40, looks: int = 3) -> int:
        """Runs one task; its TB_RESULT."""
        self.area = area
        self.put("SU_SENSOR", self.sensor)
        self.put("SU_PATIENCE", looks)
        return self.run(f"survey_{name}", tick=tick)[0]

    def results(self, area: int) -> tuple[int, list[int]]:
        s = self.symbols
        return signed(self.chip.peek(area + s["SU_FREE"])), [
            signed(word) for word in self.chip.read(area + s["SU_SECTOR"], SECTORS)
        ]


def model(rays: list[int]) -> tuple[float, list[int]]:
    """How far ahead of the vehicle's centre its way is free, mm, and the sectors' nearest echoes."""
    seen = [ray or MOST for ray in rays]
    sectors = [min(seen[5 * k : 5 * k + 5]) for k in range(SECTORS)]
    free = float(MOST)
    for n, ray in enumerate(seen):
        angle = (-1_562_069 + 17_453 * n) * 1e-6
        ahead, aside = 2900 + ray * math.cos(angle), abs(ray * math.sin(angle))
        assert ray == MOST or abs(aside - HALF_WIDTH) > 0.02, "on the edge: the rounding would decide"
        if ray < MOST and aside <= HALF_WIDTH and ahead >= 0:
            free = min(free, ahead)
    return free, sectors


def drawn(seed: int) -> list[int]:
    draw = random.Random(seed)
    return [draw.choice([0, MOST, 8 * draw.randint(10, 3000), 8 * draw.randint(100, 1000)]) for _ in range(RAYS)]


@pytest.mark.parametrize(
    "rays", [[MOST] * RAYS, [0] * RAYS, [1600] * RAYS, *map(drawn, range(20))], ids=lambda rays: ""
)
def test_whole_joined_and_alone_are_the_model(folder: Path, rays: list[int]) -> None:
    free, sectors = model(rays)
    d = Survey(folder, rays)
    first, second = d.area, d.area + d.symbols["US_WORDS"]
    ways = {"whole": [("whole", first)], "joined": [("second", second), ("first", first)], "alone": [("first", first)]}
    for tick, (way, tasks) in enumerate(ways.items(), start=100):
        for name, area in tasks:
            result = d.task(name, area, tick)
        assert result == (1 if way == "alone" else 0)
        got, nearest = d.results(first)
        assert nearest == sectors
        assert abs(got + 0.5 - free) <= 0.51  # FIX rounds down; the products to 24 bits


def test_halves_of_two_scans_are_reported(folder: Path) -> None:
    d = Survey(folder, drawn(1))
    first, second = d.area, d.area + d.symbols["US_WORDS"]
    d.task("second", second)
    d.chip.poke(WINDOW_B + d.sensor + d.symbols["RANGE_SCAN"], 78)
    assert d.task("first", first) == 2


def test_the_second_half_of_another_release_is_not_taken(folder: Path) -> None:
    d = Survey(folder, drawn(2))
    first, second = d.area, d.area + d.symbols["US_WORDS"]
    d.task("second", second, tick=40)
    assert d.task("first", first, tick=80) == 1


def test_the_example(capsys: pytest.CaptureFixture[str]) -> None:
    example().main(duration_s=0.3)
    out = capsys.readouterr().out
    whole, shared, linked, *alone = (float(us) for us in re.findall(r"response +([\d.]+) us, worst", out))
    assert whole / 2 < shared < 0.7 * whole and whole / 2 < linked < 0.7 * whole
    assert len(alone) == 2 and whole < min(alone) and max(alone) < 5000
    assert out.count("the same results: True") == 2
    cycles = [int(n) for n in re.findall(r"(\d+) (?:\+|cycles)", out)]
    assert len(cycles) == 7 and all(cycles[0] < cycles[n] + cycles[n + 1] < 1.3 * cycles[0] for n in (1, 3))
    assert out.count("first: 0 misses") == 2 and out.count("of which 1 came to nothing") == 2


@pytest.mark.parametrize("way", ["", "_link"])
@pytest.mark.parametrize("at_us", [60, 130, 200, 270, 340])
def test_the_first_never_waits_forever(folder: Path, at_us: int, way: str) -> None:
    """The partner's DSP dies at several instants of its half: the first DSP waits for the configured time, then does
    the whole task."""
    split: Any = example()
    run = (
        split.simulation(folder, split.LINKED, 0.2, **split.LINK)
        if way
        else split.simulation(folder, split.HALVES, 0.2)
    )
    run.at(0.1 + at_us * 1e-6, "fail", dsp=1)
    report = run.run().report
    first = report["tasks"][f"user.first{way}"]
    assert (first["released"], first["misses"]) == (36, 0) and report["audit"]["violations"] == []
    # 100 looks of 5 to 15 us and both halves, in more than half of its jobs; the longest is behind identify, 2.1 ms.
    assert 1.0e9 < first["response_ps"]["p50"] < 2.0e9 and first["response_ps"]["worst"] < 4e9
    # By a link the second's words do not all find room in the FIFOs: it waits for a first that is behind identify.
    assert report["tasks"][f"user.second{way}"]["misses"] == (2 if way else 1)
