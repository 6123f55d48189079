"""Processes 2 and 7 on an emulated DSP: against the reference planner, and against the boxes themselves."""

import math
import random
from itertools import pairwise

import numpy as np
import pytest
from harness_agv import Dsp, from_ti, to_ti
from reference_agv import Box, Pose, faces, grow, plan

HOME: Pose = (12.0, 16.0, 14.0, 0.0)
SPOT = (22.0, 8.0, 0.0)
DECK, HEIGHT, CLEARANCE = 1.6, 2.591, 1.5
HOUSE: Box = (-34.0, -24.0, 20.0, 34.0, 0.0, 25.0)
BAY: Box = (-19.2, 19.2, 22.781, 27.819, 3.909, 9.092)
BOUND = 1e-4  # m, docs/kernels_job.md
STATIONS = np.linspace(0.0, 1.0, 101)


def single(x: float) -> float:
    return from_ti(to_ti(float(x)))


@pytest.fixture(scope="module")
def dsp() -> Dsp:
    return Dsp()


def prepare(dsp: Dsp, boxes: list[Box], bay: Box, target: Pose, produced: int = 0, at: Pose = HOME) -> None:
    for i, value in enumerate(SPOT):
        dsp.put("CR_SPOT", value, i)
    for name, value in (("CR_CLEARANCE", CLEARANCE), ("CR_AGV_DECK", DECK), ("CR_BOX_HEIGHT", HEIGHT)):
        dsp.put(name, value)
    dsp.put("CR_PRODUCED", produced)
    dsp.put("CR_BOX_COUNT", len(boxes))
    for i in range(4):
        dsp.put("CR_HOME", float(HOME[i]), i)
        dsp.put("CR_TARGET", float(target[i]), i)
        if produced:
            dsp.put("CR_POINT", float(at[i]), ((produced - 1) & 1) * 16 + i)
    for j, box in enumerate([*boxes, *[(0.0,) * 6] * (8 - len(boxes)), bay]):
        for i, value in enumerate(box):
            dsp.put("CR_BOX", float(value), 6 * j + i)


def route(dsp: Dsp, number: int) -> list[list[float]]:
    return [dsp.floats("CR_ROUTE", 4, (number - 1) * 32 + 4 * i) for i in range(dsp.word("CR_ROUTE_COUNT", number))]


def deepest(box: Box, hang: float, chain: list[np.ndarray]) -> float:
    """How deep the load, an upright box along x, enters a box anywhere on the way (m; negative: it is clear of all)."""
    worst = -math.inf
    for p, q in pairwise(chain):
        for t in STATIONS:
            x, y, z, _ = p + t * (q - p)
            worst = max(
                worst,
                min(x + 6.096 - box[0], box[1] - x + 6.096, y + 1.219 - box[2], box[3] - y + 1.219, box[5] - z + hang),
            )
    return worst


def test_default_dock(dsp: Dsp) -> None:
    """Straight to the topmost container; with it straight up clear of its neighbours, and straight to the AGV."""
    prepare(dsp, [HOUSE], BAY, (0.0, 24.0, 9.092, 0.0))
    result, notify, cycles = dsp.run("grab_path")
    assert (result, notify) == (3, 0x10000 << 3)
    assert cycles < 10_000
    assert route(dsp, 1) == [pytest.approx([0.0, 24.0, 9.092 + CLEARANCE, 0.0], abs=BOUND)]
    lift, end = route(dsp, 2)
    assert lift[:2] == pytest.approx([0.0, 24.0], abs=BOUND) and lift[2] - HEIGHT >= 9.092 + 0.5 - BOUND
    assert end == pytest.approx([22.0, 8.0, DECK + HEIGHT + CLEARANCE, 0.0], abs=BOUND)


def random_scene(rng: random.Random) -> tuple[list[Box], Box, Pose, int]:
    boxes = [HOUSE]
    for _ in range(rng.randint(0, 4)):
        x, y, w, b, h = (
            rng.uniform(-15, 25),
            rng.uniform(10, 26),
            rng.uniform(0.5, 4),
            rng.uniform(0.5, 4),
            rng.uniform(3, 16),
        )
        boxes.append((x - w, x + w, y - b, y + b, 0.0, h))
    top = rng.uniform(6.5, 12)
    target = (
        rng.uniform(-13, 13),
        rng.choice([24.0, 26.6]),
        top - rng.choice([0.0, HEIGHT]),
        rng.choice([0.0, 0.0, 0.1, -0.1]),
    )
    boxes = [tuple(map(single, box)) for box in boxes]  # type: ignore[misc]
    bay = (*map(single, BAY[:5]), single(top))
    return boxes, bay, tuple(map(single, target)), rng.choice([0, 7, 8])  # type: ignore[return-value]


def test_routes_agree_with_the_reference(dsp: Dsp) -> None:
    rng = random.Random(5)
    straight = banded = 0
    for _ in range(60):
        boxes, bay, target, produced = random_scene(rng)
        at: Pose = (22.0, 8.0, 6.0, 0.0) if produced else HOME
        prepare(dsp, boxes, bay, target, produced, at)
        result, _, cycles = dsp.run("grab_path")
        assert cycles < 1_000_000
        above = (target[0], target[1], target[2] + CLEARANCE, target[3])
        grown = [grow(b, target[3], 0.0) for b in (*boxes, bay)]
        first = plan(grown, at, above, False, 0.0)
        loaded = [grow(b, SPOT[2], HEIGHT) for b in (*boxes, bay)]
        second = plan(
            loaded, above, (*SPOT[:2], DECK + HEIGHT + CLEARANCE, SPOT[2]), True, max(0.0, loaded[-1][4] - above[2])
        )
        assert result == len(first) + len(second)
        for number, want in ((1, first), (2, second)):
            got = np.array(route(dsp, number))
            assert got.shape == (len(want), 4)
            assert np.max(np.abs(got - np.array(want))) < BOUND
            banded += len(want) > 2
            straight += len(want) <= 2
        for number, start, hang, around in ((1, at, 0.0, grown), (2, above, HEIGHT, loaded)):
            chain = [np.array(start), *map(np.array, route(dsp, number))]
            for box, big in zip(boxes, around):
                if not any(np.all(faces(big, p) > 0) for p in (chain[0], chain[-1])):
                    assert deepest(box, hang, chain) <= 0.0
    assert banded > 20 and straight > 20


@pytest.mark.parametrize("x", [-2.0, 4.0, 10.0])
@pytest.mark.parametrize("height", [6.0, 12.0, 20.0])
def test_the_hanging_load_clears_a_stack_in_the_way(dsp: Dsp, x: float, height: float) -> None:
    """One stack between the bay and the spot, on the straight way: neither spreader nor container gets into it, and the
    detour is sane."""
    stack: Box = (x, x + 2.4, 14.0, 16.4, 0.0, height)
    target: Pose = (0.0, 24.0, 9.092, 0.0)
    prepare(dsp, [HOUSE, stack], BAY, target)
    dsp.run("grab_path")
    above = np.array([0.0, 24.0, 9.092 + CLEARANCE, 0.0])
    chain = [above, *map(np.array, route(dsp, 2))]
    assert deepest(stack, HEIGHT, chain) <= 0.0
    assert deepest(HOUSE, HEIGHT, chain) <= 0.0
    length = sum(float(np.linalg.norm((q - p)[:3])) for p, q in pairwise(chain))
    direct = float(np.linalg.norm((chain[-1] - above)[:3]))
    assert length < direct + 2.0 * max(0.0, height + HEIGHT + 1.0 - 9.0) + 12.0
    if not np.all(faces(grow(stack, 0.0, 0.0), np.array(HOME)) > 0):
        assert deepest(stack, 0.0, [np.array(HOME), *map(np.array, route(dsp, 1))]) <= 0.0


def test_going_home(dsp: Dsp) -> None:
    prepare(dsp, [HOUSE], BAY, (0.0, 24.0, 9.092, 0.0), 12, (22.0, 8.0, 5.7, 0.0))
    assert dsp.run("home_crane")[:2] == (1, 0)
    assert route(dsp, 3) == [pytest.approx(list(HOME), abs=1e-6)]
    wall: Box = (16.0, 17.0, 11.0, 12.0, 0.0, 11.0)
    prepare(dsp, [wall], BAY, (0.0, 24.0, 9.092, 0.0), 12, (22.0, 2.0, 5.7, 0.0))
    dsp.run("home_crane")
    chain = [np.array([22.0, 2.0, 5.7, 0.0]), *map(np.array, route(dsp, 3))]
    assert len(chain) > 2 and deepest(wall, 0.0, chain) <= 0.0


def test_planning_again_changes_nothing(dsp: Dsp) -> None:
    prepare(dsp, [HOUSE, (4.0, 6.4, 14.0, 16.4, 0.0, 12.0)], BAY, (0.0, 24.0, 9.092, 0.0))
    dsp.run("grab_path")
    once = dsp.chip.read(dsp.area, dsp.symbols["CR_WORDS"])
    dsp.run("grab_path")
    assert dsp.chip.read(dsp.area, dsp.symbols["CR_WORDS"]) == once
