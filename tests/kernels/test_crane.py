"""Trajectory, inverse kinematics and torque compensation of the crane against the double-precision reference.

Bounds. A stored word is cut to 24 bits: 2^-19 m on positions below 32 m, 2^-23 relative on the rest. Each test says
what multiplies that.
"""

from __future__ import annotations

import math
import random

import pytest
import reference as ref
from harness import Dsp, single

END_OF_LEG, UNREACHABLE = 1, 0x10000
PERIOD = 0.008


def pose(r: random.Random) -> list[float]:
    angle, radius = r.uniform(0.2, 1.9), r.uniform(12, 28)
    return [
        single(v) for v in (radius * math.cos(angle), radius * math.sin(angle), r.uniform(5, 15), r.uniform(-0.5, 0.5))
    ]


@pytest.fixture
def dsp() -> Dsp:
    dsp = Dsp()
    dsp.put("CR_POINT_PERIOD", PERIOD)
    return dsp


def put_route(dsp: Dsp, leg: int, vias: list[list[float]]) -> None:
    dsp.put("CR_ROUTE_COUNT", len(vias), offset=leg)
    for i, via in enumerate(vias):
        dsp.put("CR_ROUTE", *via, offset=(leg - 1) * 32 + 4 * i)


def assert_point(dsp: Dsp, k: int, want: ref.Point) -> None:
    got = dsp.floats("CR_POINT", 14, offset=(k & 1) * 16)
    # Durations T_i are rounded to 2^-24 and start times are sums of up to 8 of them: t is off by <= 100 s * 2^-23 =
    # 1.2e-5 s, times the next derivative (2.5 m/s, 1 m/s2, 1 m/s3, 5 m/s4); partial sums are cut at 2^-19 m three times
    # over, and l / g <= 4 s2 carries the second derivative's error into x and y.
    for j in range(4):
        assert got[j] == pytest.approx(want.pose[j], abs=5e-5), ("pose", j, k)
        assert got[4 + j] == pytest.approx(want.velocity[j], abs=6e-5), ("velocity", j, k)
        assert got[8 + j] == pytest.approx(want.acceleration[j], abs=1.2e-4), ("acceleration", j, k)
    for j in range(2):
        assert got[12 + j] == pytest.approx(want.payload[j], abs=1.5e-5)


@pytest.mark.parametrize("seed", range(6))
def test_trajectory_follows_the_route_of_a_leg(dsp: Dsp, seed: int) -> None:
    r = random.Random(seed)
    home = pose(r)
    vias = [pose(r) for _ in range([1, 2, 3, 4, 8, 1][seed])]
    leg = ref.Leg(home, vias)
    dsp.put("CR_HOME", *home)
    dsp.put("CR_LEG", 1)
    put_route(dsp, 1, vias)
    period = single(PERIOD)
    last = leg.points(period) - 1
    first = 1000  # a leg may begin at any point number
    ks = sorted({0, 1, *(r.randrange(last) for _ in range(60))})
    for k in ks:
        result, notify, _ = dsp.run("trajectory_crane", first + k)
        assert notify == 0x600
        assert result == 0
        assert_point(dsp, first + k, ref.trajectory(leg, (k + 1) * period))
    ends = [dsp.run("trajectory_crane", first + last + d)[0] for d in (-1, 0)]
    assert END_OF_LEG in ends  # rounding may move the end by one point
    got = dsp.floats("CR_POINT", 14, offset=((first + last) & 1) * 16)
    assert got[:4] == pytest.approx(vias[-1], abs=1e-5)
    assert got[4:] == pytest.approx([0] * 10, abs=1e-6)


@pytest.mark.parametrize("turn", [-2.5, -0.4, 0.0, 0.4, 2.5])
def test_a_leg_keeps_slewing_and_rotator_within_their_speeds(dsp: Dsp, turn: float) -> None:
    """A quarter of a circle through points at 19 m and beyond, while the box turns: the rotator turns with it and
    against the slewing."""
    period = single(0.1)
    dsp.put("CR_POINT_PERIOD", period)
    chain = [
        [single(v) for v in (25 * math.cos(a), 25 * math.sin(a), 10.0, turn * (a - 0.3))] for a in (0.3, 0.7, 1.1, 1.5)
    ]
    dsp.put("CR_HOME", *chain[0])
    dsp.put("CR_LEG", 1)
    put_route(dsp, 1, chain[1:])
    slewing, rotator = [], []
    for k in range(10_000):
        done = dsp.run("trajectory_crane", k)[0]
        x, y, _, _, xd, yd, _, yawd = dsp.floats("CR_POINT", 14, offset=(k & 1) * 16)[:8]
        slewing.append((x * yd - y * xd) / (x * x + y * y))
        rotator.append(yawd - slewing[-1])
        if done:
            break
    # 2.3 m/s at 19 m is 0.121 rad/s; the suspension leads the load by less than 0.004 rad/s here.
    assert max(map(abs, slewing)) < 0.121 * 19 / 23 + 0.004
    assert 0.04 < max(map(abs, rotator)) < 0.125


def test_planning_demands_itself_until_the_last_point_of_a_leg(dsp: Dsp) -> None:
    r = random.Random(13)
    home, target = pose(r), pose(r)
    dsp.put("CR_HOME", *home)
    dsp.put("CR_LEG", 1)
    put_route(dsp, 1, [target])
    last = ref.Leg(home, [target]).points(single(PERIOD)) - 1
    more, s = (0, dsp.symbols["MUST_TRAJECTORY"] | dsp.symbols["MUST_INVERSE"]), dsp.symbols
    assert [dsp.run("trajectory_crane", k)[:2] for k in (0, 500, last - 2)] == [more] * 3
    results = [dsp.run("trajectory_crane", k)[:2] for k in (last - 1, last, last + 1)]
    assert (s["RESULT_END_OF_LEG"], s["MUST_INVERSE"]) in results


def test_an_alignment_starts_where_the_leg_before_ended_and_aims_at_the_agv(dsp: Dsp) -> None:
    r = random.Random(11)
    home, target, via = pose(r), pose(r), pose(r)
    dsp.put("CR_HOME", *home)
    dsp.put("CR_LEG", 2)
    put_route(dsp, 2, [target])
    dsp.put("CR_AGV", dsp.symbols["AGV_UNIT"] + 2 * dsp.symbols["AGV_UNIT_WORDS"])
    dsp.put("CR_AGV_DECK", 1.6)
    dsp.put("CR_BOX_HEIGHT", 2.591)
    dsp.put("CR_CLEARANCE", 1.5)
    period = single(PERIOD)
    count = ref.Leg(home, [target]).points(period)
    k = 0
    while not dsp.run("trajectory_crane", k)[0]:
        k += 97 if k + 97 < count - 2 else 1
    assert abs(k - (count - 1)) <= 1
    dsp.put("CR_LEG", dsp.symbols["LEG_ALIGN"])
    put_route(dsp, 1, [via])  # the next routes may be planned meanwhile
    put_route(dsp, 2, [via, via])
    unit = 2 * dsp.symbols["AGV_UNIT_WORDS"] + dsp.symbols["AGV_UNIT"]
    dsp.device("AGV_X", 22013, offset=unit)
    dsp.device("AGV_Y", 7988, offset=unit)
    dsp.device("AGV_HEADING", 3141593 - 20000, offset=unit)  # facing -x: the box fits either way round
    end = [
        22.013,
        7.988,
        1.6 + 2.591 + 1.5,
        (3141593 - 20000) * 1e-6 - math.pi * round((3.121593 - target[3]) / math.pi),
    ]
    leg = ref.Leg(target, [end])
    for n in (0, 1, 500, 1000, leg.points(period) - 1):
        _result, _, _ = dsp.run("trajectory_crane", k + 1 + n)
        dsp.device("AGV_X", 0, offset=unit)  # it is measured when the leg begins
        assert_point(dsp, k + 1 + n, ref.trajectory(leg, (n + 1) * period))
    assert dsp.floats("CR_ROUTE", 4, offset=32) == pytest.approx(via, abs=4e-6)  # the next way there is untouched


def test_trajectory_run_again_gives_the_same_words(dsp: Dsp) -> None:
    """The watchdog may have a block run twice: at the start of a leg, within it, and at its end."""
    r = random.Random(12)
    home, first, second = pose(r), pose(r), pose(r)
    dsp.put("CR_HOME", *home)
    dsp.put("CR_LEG", 1)
    put_route(dsp, 1, [first])
    put_route(dsp, 3, [second])
    last = ref.Leg(home, [first]).points(single(PERIOD)) - 1
    if dsp.run("trajectory_crane", 0)[0] == 0:
        pass
    for k in (0, 0, 700, 700, last + 1, last + 1, last + 2, last + 2):
        if k > last:
            dsp.put("CR_LEG", 3)
        once = dsp.run("trajectory_crane", k)[:2], dsp.floats("CR_POINT", 14, offset=(k & 1) * 16)
        again = dsp.run("trajectory_crane", k)[:2], dsp.floats("CR_POINT", 14, offset=(k & 1) * 16)
        assert once == again


def random_point(r: random.Random) -> ref.Point:
    return ref.Point(
        pose(r),
        [single(r.uniform(-2, 2)) for _ in range(4)],
        [single(r.uniform(-0.5, 0.5)) for _ in range(4)],
        [single(r.uniform(-0.4, 0.4)) for _ in range(2)],
    )


def put_point(dsp: Dsp, k: int, p: ref.Point) -> None:
    dsp.put("CR_POINT", *p.pose, *p.velocity, *p.acceleration, *p.payload, offset=(k & 1) * 16)


def test_inverse_kinematics_in_closed_form(dsp: Dsp) -> None:
    r = random.Random(20)
    for k in range(200):
        p = random_point(r)
        put_point(dsp, k, p)
        result, notify, _ = dsp.run("inverse_crane", k)
        want = ref.inverse(p)
        assert (result, notify) == ((k + 1) & 0xFFFF | (UNREACHABLE if want.unreachable else 0), 0)
        assert dsp.word("CR_PRODUCED") == k + 1
        got = dsp.floats("CR_RING", 15, offset=(k & 3) * 16)
        # q: rounded to 24 bits (2^-19 m of l, 2^-23 rad) plus 1e-8 of the arc tangents. Rates and accelerations: cut at
        # 2^-23 relative to their own terms, the largest of which stay below 4.
        assert got[:5] == pytest.approx(want.q, abs=2.1e-6)
        assert got[1:3] == pytest.approx(want.q[1:3], abs=1.5e-7)
        assert got[5:10] == pytest.approx(want.qd, abs=5e-7)
        assert got[10:15] == pytest.approx(want.qdd, abs=5e-7)
        assert dsp.floats("CR_SWAY", 4, offset=(k & 3) * 4) == pytest.approx(want.sway, rel=2**-22, abs=1e-8)


def test_inverse_of_the_forward_map(dsp: Dsp) -> None:
    """Independent of the reference: the joints' tip and rope lead back to the pose."""
    r = random.Random(21)
    for k in range(50):
        p = random_point(r)
        put_point(dsp, k, p)
        dsp.run("inverse_crane", k)
        s, psi, phi, rope, kappa = dsp.floats("CR_RING", 5, offset=(k & 3) * 16)
        radius = ref.A0 + ref.JIB * math.cos(phi)
        x, y, z, yaw = p.pose
        assert [s + radius * math.cos(psi), radius * math.sin(psi)] == pytest.approx([x, y], abs=1e-5)
        assert ref.PIVOT + ref.JIB * math.sin(phi) - rope == pytest.approx(z, abs=1e-5)
        assert math.remainder(psi + kappa - yaw, 2 * math.pi) == pytest.approx(0, abs=4e-7)


def test_out_of_reach_is_clamped_and_said(dsp: Dsp) -> None:
    for radius, phi in ((5.0, math.radians(80)), (34.0, math.radians(20))):
        put_point(dsp, 0, ref.Point([radius, 0.0, 8.0, 0.0], [0.0] * 4, [0.0] * 4, [0.0] * 2))
        assert dsp.run("inverse_crane", 0)[0] == 1 | UNREACHABLE
        assert dsp.floats("CR_RING", 3)[2] == pytest.approx(phi, abs=2e-7)


def put_ring(dsp: Dsp, k: int, q: list[float], qd: list[float], qdd: list[float]) -> None:
    dsp.put("CR_RING", *q, *qd, *qdd, offset=(k & 3) * 16)


def random_joints(r: random.Random) -> tuple[list[float], list[float], list[float]]:
    q = [0.0, r.uniform(-1, 3), r.uniform(0.4, 1.3), r.uniform(10, 45), r.uniform(-3, 3)]
    qd = [0.0, r.uniform(-0.1, 0.1), r.uniform(-0.05, 0.05), r.uniform(-1, 1), r.uniform(-0.1, 0.1)]
    qdd = [0.0, r.uniform(-0.02, 0.02), r.uniform(-0.01, 0.01), r.uniform(-0.3, 0.3), r.uniform(-0.02, 0.02)]
    return tuple([single(x) for x in v] for v in (q, qd, qdd))  # type: ignore[return-value]


@pytest.mark.parametrize("ramp", [False, True])
def test_torque_compensation_is_the_inverse_dynamics_of_the_set_point(dsp: Dsp, ramp: bool) -> None:
    r = random.Random(30 + ramp)
    dsp.servo_rates()
    for n in range(60):
        payload = round(r.uniform(10e3, 50e3))
        a, b = random_joints(r), random_joints(r)
        consumed, start, tick = r.randrange(2, 500), r.randrange(1000), 0
        phase = r.randrange(0, 9)
        tick = start + 8 * phase
        put_ring(dsp, consumed - 2, *a)
        put_ring(dsp, consumed - 1, *b)
        dsp.put("CR_CONSUMED", consumed)
        dsp.put("CR_SEGMENT_START", start)
        dsp.hang(payload)
        q, qd, qdd = ([x + phase / 8 * (y - x) for x, y in zip(u, v, strict=True)] for u, v in zip(a, b, strict=True))
        if ramp:
            ticks, elapsed, delta = r.randrange(16000, 80000), r.randrange(-5000, 90000), single(r.uniform(-1.5, 1.5))
            dsp.put("CR_RAMP_TICKS", ticks)
            dsp.put("CR_RAMP_START", tick - elapsed)
            dsp.put("CR_RAMP_BASE", 0.25)
            dsp.put("CR_RAMP_DELTA", delta)
            s, s1, s2 = ref.quintic(elapsed / ticks)
            seconds = ticks / 8000
            q[3] += 0.25 + delta * s
            qd[3] += delta * s1 / seconds
            qdd[3] += delta * s2 / seconds**2
        assert dsp.run("torque", tick=tick)[:2] == (payload << 8, 0)  # kg on the rope; no wind
        got, want = dsp.floats("CR_FEED_FORWARD", 5), ref.torque(q, qd, qdd, payload)
        # The set-point's words are cut at 2^-23; the terms of each joint add up to less than its u_max, so each 24-bit
        # word or constant contributes 2^-24 u_max; some ten of them. tanh turns 2^-23 of a speed near 0 into 2^-23 F_c.
        # Near the knee of the friction curve the slope 1 / v_0 acts on speeds cut at 2^-23 of their own: nothing more.
        for j in range(5):
            assert got[j] == pytest.approx(want[j], abs=ref.U_MAX[j] * 12 * 2**-23), (j, n)


def test_torque_compensation_says_nothing_before_pid_has_taken_the_pose(dsp: Dsp) -> None:
    dsp.put("CR_FEED_FORWARD", 1.0, 2.0, 3.0, 4.0, 5.0)
    dsp.run("torque", tick=8)
    assert dsp.floats("CR_FEED_FORWARD", 5) == [0.0] * 5
