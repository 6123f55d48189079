"""The programs of a ship-to-shore gantry: against the plant's own equations (which MuJoCo checks,
tests/plant/test_gantry.py) and closed forms.

What a gantry shares with the slewing crane is tested with that crane. Tests here cover what differs, and that the image
has the plant's constants.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator

import numpy as np
import pytest
import reference as ref
import test_closed_loop as loop
import test_pid
from cmrc import _core
from cmrc_test import plant as parts
from harness import Dsp, gantry_constants
from test_crane import END_OF_LEG, PERIOD, UNREACHABLE, assert_point, put_point, put_ring, put_route, single
from test_torque_builds import BOUND, CLOSED_FORM, NEWTON_EULER

plant = _core.plant
P = plant.gantry_crane()
MODEL = plant.Crane(P)
HALF = math.pi / 2
# The joints of drive channels 1 to 4; channel 0 is spare.
DRIVES = [P.drives[j] for j in (0, 2, 3, 4)]
COUNTS = (0.0, *(16384 / (2 * math.pi) * d.gear for d in DRIVES))
U_MAX = (1.0, *(1.5 * d.rated_torque for d in DRIVES))
TRAVEL_SPEED, TRAVEL_ACCELERATION = 0.65, 0.1


class Gantry(Dsp):
    def __init__(self) -> None:
        super().__init__()
        gantry_constants(self.chip, self.symbols)
        with pytest.MonkeyPatch.context() as patch:
            for name, value in REFERENCE.items():
                patch.setattr(ref, name, value)
            self.control(ref.control_block(), generation=1)
        self.speeds([1 / ref.V_XY, 1 / ref.V_Z, 1 / ref.V_YAW, 1 / TRAVEL_SPEED, 0.0, 0.0, 0.0])


@pytest.fixture
def dsp() -> Dsp:
    dsp = Gantry()
    dsp.put("CR_POINT_PERIOD", PERIOD)
    return dsp


# ---- trajectory


def pose(r: random.Random) -> list[float]:
    return [single(v) for v in (r.uniform(-20, 20), r.uniform(-9, 25), r.uniform(4, 18), r.uniform(-0.3, 0.3))]


class Leg(ref.Leg):
    def __init__(self, start: list[float], vias: list[list[float]], stretch: float = 1.0) -> None:
        super().__init__(start, vias)
        chain = [start, *vias]
        for i, (a, b) in enumerate(zip(chain, vias, strict=False)):
            h = abs(b[0] - a[0])
            along = max(ref.PEAK1 * h / TRAVEL_SPEED, math.sqrt(ref.PEAK2 * h / TRAVEL_ACCELERATION))
            self.durations[i] = stretch * max(self.durations[i], along)


def trajectory(leg: ref.Leg, t: float) -> ref.Point:
    p = ref.payload_motion(leg, t)
    lam = (P.pivot_height - p[0][2]) / ref.GRAVITY
    at = [[p[n][j] + (lam * p[n + 2][j] if j < 2 else 0.0) for j in range(4)] for n in range(3)]
    return ref.Point(*at, [p[2][0], p[2][1]])


@pytest.mark.parametrize("seed", range(6))
def test_a_leg_is_as_slow_as_its_slowest_axis(dsp: Dsp, seed: int) -> None:
    r = random.Random(seed)
    home, vias = pose(r), [pose(r) for _ in range([1, 2, 3, 8, 1, 1][seed])]
    if seed == 4:
        vias[0][0] = home[0]  # no travel: one pass is enough
    if seed == 5:
        vias[0] = [single(home[0] + 2.0), *home[1:]]  # so short that the limit of acceleration decides
    stretch = 1.5 if seed == 1 else 1.0
    dsp.put("CR_STRETCH", stretch)
    dsp.put("CR_HOME", *home)
    dsp.put("CR_LEG", 1)
    put_route(dsp, 1, vias)
    leg, period = Leg(home, vias, stretch), single(PERIOD)
    last = leg.points(period) - 1
    for k in sorted({0, 1, *(r.randrange(last) for _ in range(40))}):
        result, notify, cycles = dsp.run("trajectory_gantry", 50 + k)
        assert (result, notify) == (0, 0x600) and cycles < (5000 if k == 0 else 1200)
        assert_point(dsp, 50 + k, trajectory(leg, (k + 1) * period))
    assert END_OF_LEG in [dsp.run("trajectory_gantry", 50 + last + d)[0] for d in (-1, 0)]
    assert dsp.floats("CR_POINT", 4, offset=((50 + last) & 1) * 16) == pytest.approx(vias[-1], abs=1e-5)


def test_no_axis_passes_its_limit() -> None:
    leg = Leg([0.0, -8.0, 14.0, 0.0], [[12.0, 10.0, 9.0, 0.0]])
    speeds = np.array([ref.payload_motion(leg, t)[1] for t in np.linspace(0, leg.total(), 400)])
    assert abs(speeds[:, 0]).max() == pytest.approx(TRAVEL_SPEED, rel=1e-3) and abs(speeds[:, 1]).max() < ref.V_XY
    assert TRAVEL_SPEED < 157.0 / DRIVES[0].gear and ref.V_XY < 157.0 / DRIVES[1].gear  # what the drives can do


def test_a_leg_whose_first_point_is_run_again_stays_the_same(dsp: Dsp) -> None:
    home, vias = [0.0, -8.0, 14.0, 0.0], [[3.0, 0.0, 16.0, 0.0], [9.0, 10.0, 9.0, 0.0]]
    dsp.put("CR_HOME", *home)
    dsp.put("CR_LEG", 1)
    put_route(dsp, 1, vias)
    want, again = (
        [dsp.run("trajectory_gantry", k)[:2] + (dsp.floats("CR_POINT", 14, offset=(k & 1) * 16),) for k in (0, 700)]
        for _ in range(2)
    )
    assert again == want


def test_the_shaper_takes_the_ropes_length_and_the_travels_time(dsp: Dsp) -> None:
    home, end = [0.0, -8.0, 14.0, 0.0], [6.0, 10.0, 9.0, 0.0]
    dsp.put("CR_HOME", *home)
    dsp.put("CR_LEG", 1)
    put_route(dsp, 1, [end])
    h = 6.0
    slowest = max(1.875 * h / TRAVEL_SPEED, math.sqrt(10 / math.sqrt(3) * h / TRAVEL_ACCELERATION))
    swing = 2 * math.pi * math.sqrt((34.0 - 11.5) / ref.GRAVITY)
    period = single(PERIOD)
    for k in (0, 1, 400, 1500, 2500):
        dsp.run("trajectory_gantry_shaper", k)
        t = (k + 1) * period
        for order, offset in ((0, 0), (1, 4), (2, 8)):
            shares = [ref.quintic((t - n * swing / 2) / slowest)[order] / slowest**order for n in range(3)]
            s = (shares[0] + 2 * shares[1] + shares[2]) / 4
            want = [(a if order == 0 else 0.0) + s * (b - a) for a, b in zip(home, end, strict=True)]
            assert dsp.floats("CR_POINT", 4, offset=(k & 1) * 16 + offset) == pytest.approx(want, abs=6e-5)
    last = math.ceil((slowest + swing) / period) - 1
    assert END_OF_LEG in [dsp.run("trajectory_gantry_shaper", last + d)[0] for d in (-1, 0, 1)]


# ---- inverse kinematics


def test_joints_are_the_plants_and_the_load_hangs_at_the_reference_sway(dsp: Dsp) -> None:
    r = random.Random(5)
    for k in range(60):
        moved = [[single(r.uniform(-0.5, 0.5)) for _ in range(4)] for _ in range(2)]
        p = ref.Point(pose(r), *moved, [single(r.uniform(-0.4, 0.4)) for _ in range(2)])
        put_point(dsp, k, p)
        assert dsp.run("inverse_gantry", k)[:2] == (k + 1, 0)
        got = dsp.floats("CR_RING", 15, offset=(k & 3) * 16)
        x, y, z, yaw = p.pose
        q = plant.inverse_kinematics(P, plant.CranePose(x, x, y, z, yaw))
        # rounded to 24 bits below 64 m and below 4 rad
        assert [got[0], *got[1:4]] == pytest.approx([0.0, q[0], q[2], q[3]], abs=2**-18)
        assert math.remainder(got[4] - q[6], 2 * math.pi) == pytest.approx(0.0, abs=2**-22)
        for offset, (dx, dy, dz, turn) in ((5, moved[0]), (10, moved[1])):
            assert got[offset : offset + 5] == [0.0, dx, dy, -dz, turn]
        assert dsp.word("CR_PRODUCED") == k + 1

        alpha, beta, by_trolley, by_travel = dsp.floats("CR_SWAY", 4, offset=(k & 3) * 4)
        hanging = list(q)
        hanging[4], hanging[5] = alpha, beta
        behind = (
            np.subtract(MODEL.tip(q), MODEL.payload_position(hanging))[:2] / q[3]
        )  # the rope pulls where the load accelerates
        assert behind == pytest.approx(
            np.array(p.payload) / ref.GRAVITY, abs=4e-5
        )  # sin against its argument: 0.04^3 / 3
        # A metre towards the side to which positive angles hang moves the joints by the factors.
        for angle, joint, factor in ((4, 2, by_trolley), (5, 0, by_travel)):
            swung, shifted = list(q), list(q)
            swung[angle] += 1e-6
            shifted[joint] += factor * 1e-6 * q[3]
            assert np.subtract(MODEL.payload_position(swung), MODEL.payload_position(shifted)) == pytest.approx(
                [0, 0, 0], abs=1e-10
            )


@pytest.mark.parametrize(
    ("at", "joint", "limit"),
    [((0, 40, 10), 2, 38.5), ((0, -34, 10), 2, -33.0), ((-201, 0, 10), 1, -200.0), ((0, 0, 32), 3, 3.0)],
)
def test_out_of_reach_is_clamped_and_said(dsp: Dsp, at: tuple[float, float, float], joint: int, limit: float) -> None:
    put_point(dsp, 0, ref.Point([float(v) for v in at] + [0.0], [0.0] * 4, [0.0] * 4, [0.0] * 2))
    assert dsp.run("inverse_gantry", 0)[0] == 1 | UNREACHABLE
    assert dsp.floats("CR_RING", 5)[joint] == limit
    assert limit in (*P.lower, *P.upper)


# ---- torque compensation


@pytest.mark.parametrize(("kernel", "build"), [("torque_gantry", CLOSED_FORM), ("torque_newton_euler", NEWTON_EULER)])
def test_torques_are_the_plants_inverse_dynamics(dsp: Dsp, kernel: str, build: str) -> None:
    r = random.Random(7)
    dsp.servo_rates(consumed=2)
    for _ in range(60):
        load = round(r.uniform(10e3, 50e3))
        q = [0.0, *(single(r.uniform(a, b)) for a, b in ((-20, 20), (-30, 38), (4, 48), (-3, 3)))]
        qd = [0.0, *(single(r.uniform(-v, v)) for v in (0.7, 2.3, 1.0, 0.1))]
        qdd = [0.0, *(single(r.uniform(-v, v)) for v in (0.1, 0.5, 0.3, 0.03))]
        for slot in (0, 1):
            put_ring(dsp, slot, q, qd, qdd)
        dsp.hang(load)
        assert dsp.run(kernel, tick=8)[:2] == (load << 8, 0)
        got = dsp.floats("CR_FEED_FORWARD", 5)
        # Plumb: alpha = beta = 0; coordinates s, psi, phi (trolley), l, alpha, beta, kappa.
        place = [q[1], HALF, q[2], q[3], 0.0, 0.0, q[4]]
        rate, second = ([v[1], 0.0, v[2], v[3], 0.0, 0.0, v[4]] for v in (qd, qdd))
        inertia = P.spreader_inertia + ref.I_PER_KG * (load - P.spreader_mass)
        force = (
            np.asarray(MODEL.mass_matrix(place, load, inertia)) @ second
            + MODEL.bias(place, rate, load, inertia)
            + MODEL.gravity(place, load)
        )
        assert got[0] == 0.0
        for channel, (k, d) in enumerate(zip((0, 2, 3, 6), DRIVES, strict=True), start=1):
            rated, top = d.gear * d.rated_torque, d.rated_speed / d.gear
            friction = rated * (d.coulomb * math.tanh(rate[k] / (d.smooth_speed * top)) + d.viscous * rate[k] / top)
            want = (force[k] + friction) / (d.gear * d.efficiency)
            assert got[channel] == pytest.approx(want, abs=BOUND[build] * 2**-23 * U_MAX[channel]), channel
    dsp.put("CR_PID_STAGE", 0)
    dsp.run(kernel, tick=8)
    assert dsp.floats("CR_FEED_FORWARD", 5) == [0.0] * 5


# ---- PID

BANDWIDTH = (1.0, 5.0, 40.0, 40.0, 40.0)
POSE = [0.0, 1.5, -8.0, 20.0, -1.5]


def inertia(phi: float, mass: float) -> list[float]:
    """What each drive moves above the load's swing (docs/control.md); the first channel is spare."""
    rotor = [0.0, *(d.rotor_inertia * d.gear**2 for d in DRIVES)]
    yaw = ref.I_SPREADER + ref.I_PER_KG * (mass - ref.M_SPREADER)
    return [0.0, rotor[1] + P.gantry_mass + P.jib_mass, rotor[2] + P.jib_mass, rotor[3] + mass, rotor[4] + yaw]


# The PID's reference with a gantry's drives.
REFERENCE = {
    "COUNTS": COUNTS, "U_MAX": U_MAX, "CODE": (0.0, *(2047 / u for u in U_MAX[1:])), "BANDWIDTH": BANDWIDTH, "inertia": inertia,
    "GEAR": (1.0, *(d.gear for d in DRIVES)), "EFFICIENCY": (1.0, *(d.efficiency for d in DRIVES)),
    "T_D": tuple(2 / w for w in BANDWIDTH), "T_I": tuple(6 / w for w in BANDWIDTH), "T_T": tuple(math.sqrt(12) / w for w in BANDWIDTH),
}  # fmt: skip


@pytest.fixture
def gains(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    for name, value in REFERENCE.items():
        monkeypatch.setattr(ref, name, value)
    monkeypatch.setattr(test_pid, "Dsp", Gantry)
    yield


class Servo(test_pid.Servo):
    kernel = "pid_gantry"

    def run(self) -> int:
        result, notify, _ = self.dsp.run(self.kernel, tick=self.tick)
        assert notify & 0x7FFFFF == 0
        self.tick += test_pid.SERVO_TICKS
        return result


@pytest.mark.parametrize("kernel", ["pid_gantry", "pid_gantry_document"])
def test_the_drives_wait_for_the_hoists_feed_forward(gains: None, kernel: str) -> None:
    servo = Servo(POSE)
    servo.kernel = kernel
    assert servo.run() == 0 and servo.dsp.word("CR_PID_STAGE") == 1
    assert servo.dsp.floats("CR_RING", 15, offset=48) == pytest.approx(POSE + [0.0] * 10, abs=5e-6)
    assert servo.dsp.floats("CR_SWAY", 4, offset=12) == [0.0, 0.0, 1.0, -1.0]
    servo.dsp.put("CR_FEED_FORWARD", 0.0, 0.0, 0.0, 1.0, 0.0)  # a word of 0 reads as 1.0
    servo.run()
    assert servo.dsp.device_word("DRIVE_ENABLE") == 0 and servo.dsp.word("CR_PID_STAGE") == 1
    feed = [0.0, 20.0, -30.0, -1100.0, 1.0]
    servo.dsp.put("CR_FEED_FORWARD", *feed)
    servo.run()
    assert servo.dsp.device_word("DRIVE_ENABLE") == 0x1F and servo.dsp.word("CR_PID_STAGE") == 2
    assert servo.codes() == pytest.approx(
        [0] + [round(f * 2047 / u) for f, u in zip(feed[1:], U_MAX[1:], strict=True)], abs=2
    )
    again = servo.tick
    servo.run()
    assert servo.dsp.word("CR_ENCODER_LAST", offset=-5) == again  # the word before it: the last tick


def test_one_tick_is_the_reference_with_a_gantrys_drives(gains: None) -> None:
    for seed in range(8):
        r = random.Random(seed)
        servo = Servo(POSE)
        servo.run()
        servo.dsp.put("CR_FEED_FORWARD", 0.0, 0.0, 0.0, -1000.0, 0.0)
        servo.run()
        dsp = servo.dsp
        a = [0.0, *(single(x + r.uniform(-0.01, 0.01)) for x in POSE[1:])]
        b = [0.0, *(single(x + r.uniform(-0.001, 0.001)) for x in a[1:])]
        ad, bd = ([0.0, *(single(r.uniform(-0.05, 0.05)) for _ in range(4))] for _ in range(2))
        sway_a, sway_b = ([*(single(r.uniform(-0.02, 0.02)) for _ in range(2)), 1.0, -1.0] for _ in range(2))
        servo.put_point(6, a, ad, sway_a)
        servo.put_point(7, b, bd, sway_b)
        dsp.put("CR_CONSUMED", 8)
        phase = r.randrange(0, 8)
        dsp.put("CR_SEGMENT_START", servo.tick - 8 * phase)
        state = ref.PidState(
            *([0.0, *(single(r.uniform(-s, s)) for _ in range(4))] for s in (50.0, 50.0, 0.01)),
            *([single(r.uniform(-s, s)) for _ in range(2)] for s in (0.2, 0.01, 0.3, 0.3)),
        )
        loops = ((24, state.integral), (29, state.derivative), (34, state.error))
        for offset, values in (*loops, (5, state.beside), (13, state.sway), (45, state.speed), (47, state.wind)):
            dsp.put("CR_CONSUMED", *values, offset=offset)
        feed = [0.0, *(single(r.uniform(-0.9, 0.9) * u) for u in U_MAX[1:])]
        dsp.put("CR_FEED_FORWARD", *feed)
        moved = [c + r.randrange(-200, 200) for c in servo.total]
        servo.encoders(moved)
        codes = [r.randrange(-400, 400) for _ in range(2)]
        for i, c in enumerate(codes):
            dsp.device("SWAY_ALPHA", c, offset=i)
        reference = [ref.hermite(*v, phase / 8, test_pid.PERIOD) for v in zip(a, ad, b, bd, strict=True)]
        sway = [x + phase / 8 * (y - x) for x, y in zip(sway_a, sway_b, strict=True)]
        measured = [0.0, *(m / c for m, c in zip(moved[1:], COUNTS[1:], strict=True))]
        shift = ref.sway_update(state, [c * math.radians(10) / 2048 for c in codes], sway[:2], test_pid.H, measured[3])
        reference[1] -= shift[1]  # travel, along -e_t; the load keeps its height and its yaw by itself
        reference[2] += shift[0]
        k_p = ref.stiffness(0.0, test_pid.MASS)
        want = ref.pid(state, reference, measured, feed, test_pid.H, k_p)
        servo.run()
        for j in range(5):
            e = 4 * 2**-20  # as in test_pid: four halves of the last place of a length
            assert servo.codes()[j] == pytest.approx(
                want[j] * ref.CODE[j], abs=1 + k_p[j] * (1 + ref.N_D) * e * ref.CODE[j]
            ), (seed, j)


# ---- in closed loop around the plant's gantry


class Loop(loop.Crane):
    kernels = ("trajectory_gantry", "inverse_gantry", "torque_gantry", "pid_gantry")
    channels = (1, 0, 2, 3, 4)
    scales, u_max = COUNTS, U_MAX
    parameters = staticmethod(plant.gantry_crane)
    processor = Gantry

    def __init__(self, home: list[float], payload: float) -> None:
        assert list(self.channels) == list(parts.drive_channels(plant.Machine.gantry))
        super().__init__(home, payload)
        self.inputs.locked = self.inputs.locked | 0b10  # psi is built in


def test_a_loaded_leg_ends_where_it_should_without_sway() -> None:
    home, target = [0.0, 2.0, 12.0, 0.0], [0.5, 6.0, 10.5, 0.1]
    gantry = Loop(home, 40e3)
    gantry.go([target])
    leg = Leg(home, [target])
    taken = gantry.run_until(loop.SETTLED, leg.total() + 4)
    assert taken == pytest.approx(leg.total() + ref.SETTLE_TIME, abs=1.5)
    assert gantry.load() == pytest.approx(target[:3], abs=0.04)


def test_a_pushed_load_comes_to_rest_in_two_swings_along_and_across() -> None:
    gantry = Loop([0.0, 6.0, 14.0, 0.0], 30e3)
    for _ in range(20):
        gantry.step()
    qd = list(gantry.state.qd)
    qd[4], qd[5] = 0.010, -0.008
    gantry.state.qd = qd
    period = 2 * math.pi * math.sqrt(gantry.state.q[3] / ref.GRAVITY)
    for _ in range(int(2 * period * loop.REFRESH / loop.SERVO_TICKS)):
        gantry.step()
    for angle, pushed in ((4, 0.010), (5, 0.008)):
        assert math.hypot(gantry.state.qd[angle], gantry.state.q[angle] * 2 * math.pi / period) < 0.35 * pushed
