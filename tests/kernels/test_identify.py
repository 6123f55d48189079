"""Process 1 on an emulated DSP: bays with known containers."""

import math
import random

import numpy as np
import pytest
from harness_agv import WINDOW_B, Dsp
from reference_agv import BOX_LENGTH, BOX_WIDTH, identify

HEIGHT, DECK = 2.591, 3.909
X0, DX = -25.6, 0.4
# Four heights floored to 8 mm make an edge's place uncertain by 8 mm / H of a cell each, half of it for the middle of
# two edges; H is a tier or more.
EDGES = 4 * 0.008 / HEIGHT * DX / 2 + 1e-4
Stack = tuple[float, int]  # x of the middle; number of containers in the stack


class Bay(Dsp):
    """A DSP before a scanner with several rows: selecting a row is a device write, so the run stops there and the row
    is put in place."""

    def look(self, rows: list[tuple[float, list[Stack]]]) -> tuple[int, int, int]:
        s = self.symbols
        self.put("CR_BOX_HEIGHT", HEIGHT)
        profiles = [profile(stacks) for _, stacks in rows]
        for name, value in (("SCAN_ROWS", len(rows)), ("SCAN_X0", X0), ("SCAN_DX", DX), ("SCAN_DECK", DECK)):
            self.device(s[name], value if name == "SCAN_ROWS" else round(value * 1e3))
        self.device(s["SCAN_ROW"], -1)
        start = self.start("identify")
        while True:
            stop = self.chip.run(2_000_000, s["identify_scan"] + 2)  # behind the write of SCAN_ROW
            if stop["reason"] != "breakpoint":
                raise AssertionError(stop)
            row = self.chip.peek(WINDOW_B + s["SCAN_ROW"])
            self.device(s["SCAN_Y"], round(rows[row][0] * 1e3))
            for i, z in enumerate(profiles[row]):
                self.device(s["SCAN_PROFILE"] + i, z)
            self.chip.step()
            if row == len(rows) - 1:
                return self.finish(start)


def profile(stacks: list[Stack]) -> list[int]:
    """mm, floored to 8: the mean height of each cell. Stacks do not overlap."""
    out = []
    for i in range(128):
        low, high = X0 + (i - 0.5) * DX, X0 + (i + 0.5) * DX
        z = DECK
        for x, n in stacks:
            z += n * HEIGHT * max(0.0, min(high, x + BOX_LENGTH / 2) - max(low, x - BOX_LENGTH / 2)) / DX
        out.append(math.floor(z * 1e3 / 8) * 8)
    return out


@pytest.fixture(scope="module")
def bay() -> Bay:
    return Bay()


def test_topmost_then_nearest(bay: Bay) -> None:
    """The default ship, unloaded container by container: the upper tier first, then by distance from the column."""
    rows = {24.0: {0.0: 2, 12.7: 1, -12.7: 1}, 26.6: {0.0: 1, 12.7: 1, -12.7: 2}}
    order = []
    for _ in range(8):
        scene = [(y, [(x, n) for x, n in stacks.items() if n]) for y, stacks in rows.items()]
        result, notify, _ = bay.look(scene)
        assert (result, notify) == (1, 1 << 2)
        x, y, z, yaw = bay.floats("CR_TARGET", 4)
        y = round(y, 3)
        nearest = min(rows[y], key=lambda at: abs(at - x))
        assert abs(x - nearest) <= EDGES
        assert z == pytest.approx(DECK + rows[y][nearest] * HEIGHT, abs=0.005)
        assert yaw == 0.0
        order.append((y, nearest, rows[y][nearest]))
        rows[y][nearest] -= 1
    assert order[:2] == [(24.0, 0.0, 2), (26.6, -12.7, 2)]
    assert [math.hypot(x, y) for y, x, _ in order[2:]] == sorted(math.hypot(x, y) for y, x, _ in order[2:])
    result, notify, _ = bay.look([(24.0, []), (26.6, [])])
    assert (result, notify) == (0, (0x10000 << 7) | (0x10000 << 8))


def test_agrees_with_the_reference_and_with_the_truth(bay: Bay) -> None:
    rng = random.Random(11)
    errors = []
    for _ in range(40):
        rows: list[tuple[float, list[Stack]]] = []
        for y in (24.0, 26.6, 29.2)[: rng.randint(1, 3)]:
            at = rng.uniform(-19, -12)
            stacks = []
            while at < 19:
                if rng.random() < 0.7:
                    stacks.append((at, rng.randint(1, 4)))
                at += BOX_LENGTH + rng.uniform(0.5, 3.0)
            rows.append((y, stacks))
        want = identify([(y, np.array(profile(s)) / 1e3) for y, s in rows], X0, DX, DECK, HEIGHT)
        result, _, cycles = bay.look(rows)
        assert cycles < 200_000
        assert bool(result) == (want is not None) == any(s for _, s in rows)
        if want is None:
            continue
        got = bay.floats("CR_TARGET", 3)
        assert got == pytest.approx(want, abs=1e-4)
        tops = [(n, x) for y, s in rows if abs(y - got[1]) < 1e-3 for x, n in s]
        assert got[2] == pytest.approx(DECK + max(n for _, s in rows for _, n in s) * HEIGHT, abs=0.005)
        errors.append(min(abs(x - got[0]) for _, x in tops))
        box = bay.floats("CR_BAY", 6)
        spans = [(x - BOX_LENGTH / 2, x + BOX_LENGTH / 2) for _, s in rows for x, _ in s]
        assert (
            box[0] <= min(a for a, _ in spans) <= box[0] + 2 * DX
            and box[1] - 2 * DX <= max(b for _, b in spans) <= box[1]
        )
        assert box[2] == pytest.approx(rows[0][0] - BOX_WIDTH / 2, abs=1e-4)
        assert box[3] == pytest.approx(rows[-1][0] + BOX_WIDTH / 2, abs=1e-4)
        assert box[5] == pytest.approx(got[2], abs=0.01)
    assert max(errors) < EDGES


def test_a_container_that_sticks_out_of_the_scan_is_seen_as_far_as_it_goes(bay: Bay) -> None:
    left = X0 - DX / 2
    result, _, _ = bay.look([(24.0, [(left + BOX_LENGTH / 2 - 0.5, 1)])])
    assert result == 1
    seen = (left + left - 0.5 + BOX_LENGTH) / 2
    assert bay.floats("CR_TARGET", 1)[0] == pytest.approx(seen, abs=EDGES)


@pytest.mark.parametrize("share", [0.0, 0.25, 0.5])
def test_containers_end_to_end_are_told_apart_from_the_gap_on_that_layouts_must_have(bay: Bay, share: float) -> None:
    """A share of the gap lies in the cell to the left of an edge of cells. The container to the left is the nearer one.
    At half and half the gap shows least: 10 mm less, and the crane would aim between the two
    (tests/cmrc/settings/test_dock_job.py: such layouts are refused)."""
    cells = X0 + DX / 2 + 79 * DX  # an edge between two cells

    def found(gap: float) -> tuple[float, float]:
        left = cells - share * gap - BOX_LENGTH / 2
        result, _, _ = bay.look([(24.0, [(left, 1), (left + BOX_LENGTH + gap, 1)])])
        assert result == 1
        return bay.floats("CR_TARGET", 1)[0], left

    x, left = found(0.078)
    assert abs(x - left) < DX / 2
    if share == 0.5:
        assert abs(x - left) < EDGES
        x, left = found(0.068)
        assert x - left > 6


def test_ropes_and_hatch_covers_are_no_containers(bay: Bay) -> None:
    """Steps of half a tier, and boxes of half the length."""
    s = bay.symbols
    bay.look([(24.0, [])])
    bay.device(s["SCAN_ROWS"], 1)
    for i in range(128):
        z = DECK + (0.5 * HEIGHT if 20 <= i < 60 else HEIGHT if 80 <= i < 95 else 0.0)
        bay.device(s["SCAN_PROFILE"] + i, round(z * 1e3))
    assert bay.run("identify")[0] == 0
