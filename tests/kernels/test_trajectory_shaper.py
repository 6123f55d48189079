"""The crane's trajectory as quintics through an input shaper: against its reference, and beside the default build in
closed loop."""

from __future__ import annotations

import itertools
import math
import random

import pytest
import reference as ref
from harness import Dsp
from test_closed_loop import SETTLED, Crane
from test_crane import PERIOD, pose, put_route, single

SPEEDS = (0.12, 0.05, 1.0)  # rad/s slew, rad/s luff, m/s hoist


def rope(p: list[float]) -> float:
    return ref.PIVOT + math.sqrt(ref.JIB**2 - (math.hypot(p[0], p[1]) - ref.A0) ** 2) - p[2]


class ShapedLeg:
    def __init__(self, chain: list[list[float]]) -> None:
        self.chain = chain
        self.durations = []
        for a, b in itertools.pairwise(chain):
            h, z, yaw = math.hypot(b[0] - a[0], b[1] - a[1]), abs(b[2] - a[2]), abs(b[3] - a[3])
            slowest = ((h, ref.V_XY, ref.A_XY), (z, ref.V_Z, ref.A_Z), (yaw, ref.V_YAW, ref.A_YAW))
            peak = 10 / math.sqrt(3)  # of the quintic's second derivative
            rotator = 1.875 * (h / ref.V_XY + yaw / ref.V_YAW)
            self.durations.append(max(rotator, *(max(1.875 * d / v, math.sqrt(peak * d / a)) for d, v, a in slowest)))
        worst = max([1.0, *(self.over(self.length() * k / 17) for k in range(1, 17))])
        self.durations = [t * worst for t in self.durations]
        self.period = 2 * math.pi * math.sqrt((rope(chain[0]) + rope(chain[-1])) / 2 / ref.GRAVITY)

    def length(self) -> float:
        return ref.start_times(self.durations)[-1] + self.durations[-1]

    def path(self, t: float, order: int) -> list[float]:
        out = list(self.chain[0]) if order == 0 else [0.0] * 4
        for i, (t0, duration) in enumerate(zip(ref.start_times(self.durations), self.durations, strict=True)):
            s = ref.quintic((t - t0) / duration)[order] / duration**order
            for j in range(4):
                out[j] += s * (self.chain[i + 1][j] - self.chain[i][j])
        return out

    def over(self, t: float) -> float:
        """The largest joint speed over its limit, by differences of the inverse kinematics."""
        h = 1e-4
        a, b = (
            [math.atan2(p[1], p[0]), math.acos((math.hypot(p[0], p[1]) - ref.A0) / ref.JIB), rope(p)]
            for p in (self.path(t - h, 0), self.path(t + h, 0))
        )
        return max(abs(y - x) / (2 * h) / v for x, y, v in zip(a, b, SPEEDS, strict=True))

    def shaped(self, t: float, order: int) -> list[float]:
        parts = [self.path(t - n * self.period / 2, order) for n in range(3)]
        return [(a + 2 * b + c) / 4 for a, b, c in zip(*parts, strict=True)]


@pytest.mark.parametrize("seed", range(5))
def test_the_shaped_path_is_followed(seed: int) -> None:
    r = random.Random(seed)
    dsp = Dsp()
    dsp.put("CR_POINT_PERIOD", PERIOD)
    home, vias = pose(r), [pose(r) for _ in range([1, 2, 3, 8, 1][seed])]
    dsp.put("CR_HOME", *home)
    dsp.put("CR_LEG", 1)
    put_route(dsp, 1, vias)
    leg = ShapedLeg([home, *vias])
    period = single(PERIOD)
    last = math.ceil((leg.length() + leg.period) / period) - 1
    for k in (0, 1, *sorted(r.randrange(last) for _ in range(40))):
        result, notify, cycles = dsp.run("trajectory_crane_shaper", k)
        assert (result, notify) == (0, 0x600)
        assert cycles < (20_000 if k == 0 else 4_000)  # the look-ahead is at the beginning
        got = dsp.floats("CR_POINT", 14, offset=(k & 1) * 16)
        t = (k + 1) * period
        # Durations are rounded to 2^-24 and stretched by a difference of 1e-8: t is off by 1.2e-5 s, times 2.5 m/s, 1
        # m/s2, 1 m/s3; sums are cut at 2^-20 m at most 27 times (3 shifted paths of up to 9 terms).
        assert got[:4] == pytest.approx(leg.shaped(t, 0), abs=6e-5)
        assert got[4:8] == pytest.approx(leg.shaped(t, 1), abs=6e-5)
        assert got[8:12] == pytest.approx(leg.shaped(t, 2), abs=1.2e-4)
        assert got[12:14] == got[8:10]
    ends = [dsp.run("trajectory_crane_shaper", last + d)[0] for d in (-1, 0, 1)]
    assert 1 in ends
    assert dsp.floats("CR_POINT", 4, offset=((last + 1) & 1) * 16) == pytest.approx(vias[-1], abs=3e-5)


class ShapedCrane(Crane):
    """The same loop with the other build."""

    def __init__(self, home: list[float], payload: float, kernel: str) -> None:
        super().__init__(home, payload)
        self.kernels = (kernel, *self.kernels[1:])


def travel(kernel: str) -> tuple[float, float, float]:
    """Seconds to PID_SETTLED, and the residual sway over one swing after the leg's last point: amplitude in m at the
    load; largest sway underway, rad."""
    crane = ShapedCrane([14.0, 15.0, 12.0, 0.0], 40e3, kernel)
    crane.go([[10.0, 19.0, 10.5, 0.1]])
    underway = 0.0
    while not (crane.leg_ended and crane.planned == crane.result & 0xFFFF):
        crane.step()
        underway = max(underway, math.hypot(*crane.state.q[4:6]))
    ended, residual = crane.seconds(), 0.0
    for _ in range(int(12 * 8000 / 16)):
        crane.step()
        if crane.seconds() - ended > 0.1:
            residual = max(residual, crane.state.q[3] * math.hypot(*crane.state.q[4:6]))
    taken = ended
    if not crane.result & SETTLED:
        taken += crane.run_until(SETTLED, 40.0) + 12
    return taken, residual, underway


def test_the_default_build_is_the_better_one() -> None:
    blend, shaper = travel("trajectory_crane"), travel("trajectory_crane_shaper")
    # m of residual swing. Where PID's observer took for wind what a leg's reference leaves out of the sway, it was
    # twice that.
    assert blend[1] < 0.02 and shaper[1] < 0.2
    assert blend[0] < shaper[0] and blend[1] < shaper[1]
