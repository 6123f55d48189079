"""Double-precision reference of the crane kernels, written from the mathematics (docs/kernels.md), not from the
assembly.

Every function is a plain function of numbers; the tests fill the shared memory of an emulated DSP with the same numbers
and compare. The same functions close the loop around the plant in test_closed_loop.py and scripts used for design.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field

from cmrc import _core

JOINTS = ("s", "psi", "phi", "l", "kappa")

# ---- crane, plant-and-bus.md 1.2 to 1.4: the symbols of docs/plant.md, their values from the plant's own list
P = _core.plant.CraneParameters()
A0, JIB, PIVOT, GRAVITY = P.a0, P.jib, P.pivot_height, 9.81
M_GANTRY, J_SLEW, M_JIB, C_JIB, I_JIB = P.gantry_mass, P.slew_inertia, P.jib_mass, P.jib_centre, P.jib_inertia
M_CW, R_CW = P.counterweight, P.counterweight_radius
M_SPREADER, I_SPREADER = P.spreader_mass, P.spreader_inertia
I_PER_KG = (12.192**2 + 2.438**2) / 12  # yaw inertia of a container, m2
GEAR = tuple(d.gear for d in P.drives)
ROTOR = tuple(d.rotor_inertia for d in P.drives)
EFFICIENCY = tuple(d.efficiency for d in P.drives)
RATED_TORQUE = tuple(d.rated_torque for d in P.drives)
RATED_SPEED = 157.0
COULOMB, VISCOUS, SMOOTH = 0.03, 0.015, 0.01
U_MAX = tuple(1.5 * t for t in RATED_TORQUE)
COUNTS = tuple(16384 / (2 * math.pi) * n for n in GEAR)  # encoder counts per joint unit

# ---- trajectory limits
V_XY, A_XY, SNAP_XY = 2.3, 0.4, 0.0813  # m/s, m/s2, m/s4
V_Z, A_Z = 0.8, 0.12
V_YAW, A_YAW = 0.12, 0.03
V_SLEW, V_LUFF, V_HOIST = 0.12, 0.05, 1.0  # of the look-ahead
SPEED_WORDS = [1 / V_XY, 1 / V_Z, 1 / V_YAW, 0.0, 1 / V_SLEW, 1 / V_LUFF, 1 / V_HOIST]  # CR_SPEED
PEAK1, PEAK2, PEAK4 = 315 / 128, 9.372, 623.0  # peaks of S', S'', S'''' of the blend


def blend(u: float) -> tuple[float, float, float, float, float]:
    """S of degree 9 with four vanishing derivatives at both ends, and its derivatives S', S'', S''', S''''."""
    u = min(max(u, 0.0), 1.0)
    v = 1 - u
    s = u**5 * (126 - 420 * u + 540 * u**2 - 315 * u**3 + 70 * u**4)
    w, d = u * v, 1 - 2 * u
    return (s, 630 * w**4, 2520 * w**3 * d, 630 * (12 * w * w * d * d - 8 * w**3), 15120 * w * d * (d * d - 3 * w))


def quintic(u: float) -> tuple[float, float, float]:
    u = min(max(u, 0.0), 1.0)
    return (u**3 * (10 - 15 * u + 6 * u * u), 30 * u * u * (1 - u) ** 2, 60 * u * (1 - u) * (1 - 2 * u))


def segment_time(a: list[float], b: list[float]) -> float:
    """Duration of the segment from a to b (x, y, z, yaw) within the limits of speed, acceleration and snap."""
    h = math.hypot(b[0] - a[0], b[1] - a[1])
    z, yaw = abs(b[2] - a[2]), abs(b[3] - a[3])
    return max(
        math.sqrt(PEAK2 * h / A_XY),
        math.sqrt(math.sqrt(PEAK4 * h / SNAP_XY)),
        PEAK1 * z / V_Z,
        math.sqrt(PEAK2 * z / A_Z),
        PEAK1 * (h / V_XY + yaw / V_YAW),  # the rotator turns by the yaw and against the slewing
        math.sqrt(PEAK2 * yaw / A_YAW),
    )


def start_times(durations: list[float]) -> list[float]:
    """Each segment starts before its predecessor ends, by half the shorter of the two."""
    starts = [0.0]
    for a, b in itertools.pairwise(durations):
        starts.append(starts[-1] + a - 0.5 * min(a, b))
    return starts


@dataclass
class Leg:
    start: list[float]
    vias: list[list[float]]
    durations: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        chain = [self.start, *self.vias]
        self.durations = [segment_time(a, b) for a, b in itertools.pairwise(chain)]

    def total(self) -> float:
        return start_times(self.durations)[-1] + self.durations[-1] if self.durations else 0.0

    def points(self, period: float) -> int:
        return max(1, math.ceil(self.total() / period))


@dataclass
class Point:
    pose: list[float]  # x, y, z, yaw of the suspension
    velocity: list[float]
    acceleration: list[float]
    payload: list[float]  # acceleration of the payload, x, y


def payload_motion(leg: Leg, t: float) -> list[list[float]]:
    """Position and derivatives 1..4 of x, y, z, yaw of the payload at time t of the leg."""
    out = [list(leg.start), [0.0] * 4, [0.0] * 4, [0.0] * 4, [0.0] * 4]
    chain = [leg.start, *leg.vias]
    for i, (t0, duration) in enumerate(zip(start_times(leg.durations), leg.durations, strict=True)):
        if duration == 0:
            continue
        s = blend((t - t0) / duration)
        for j in range(4):
            step = chain[i + 1][j] - chain[i][j]
            for n in range(5):
                out[n][j] += step * s[n] / duration**n
    return out


def trajectory(leg: Leg, t: float) -> Point:
    """The suspension point above which a payload that follows the leg hangs: p + (l / g) p'' in x and y."""
    p = payload_motion(leg, t)
    r = math.hypot(p[0][0], p[0][1])
    lam = (PIVOT + math.sqrt(max(JIB**2 - (r - A0) ** 2, 0.0)) - p[0][2]) / GRAVITY
    pose, velocity, acceleration = list(p[0]), list(p[1]), list(p[2])
    for j in range(2):
        pose[j] += lam * p[2][j]
        velocity[j] += lam * p[3][j]
        acceleration[j] += lam * p[4][j]
    return Point(pose, velocity, acceleration, [p[2][0], p[2][1]])


@dataclass
class JointPoint:
    q: list[float]
    qd: list[float]
    qdd: list[float]
    sway: list[float]  # reference angles alpha, beta; d phi / d r; d psi / d t
    unreachable: bool = False


def wrap(a: float) -> float:
    return math.remainder(a, 2 * math.pi)


PHI_LOW, PHI_HIGH = math.radians(20), math.radians(80)


def inverse(point: Point) -> JointPoint:
    x, y, z, yaw = point.pose
    xd, yd, zd, yawd = point.velocity
    xdd, ydd, zdd, yawdd = point.acceleration
    r = math.hypot(x, y)
    psi = math.atan2(y, x)
    cphi = (r - A0) / JIB
    unreachable = not math.cos(PHI_HIGH) <= cphi <= math.cos(PHI_LOW)
    cphi = min(max(cphi, math.cos(PHI_HIGH)), math.cos(PHI_LOW))
    sphi = math.sqrt(1 - cphi * cphi)
    phi = math.atan2(sphi, cphi)
    rd = (x * xd + y * yd) / r
    psid = (x * yd - y * xd) / r**2
    phid = -rd / (JIB * sphi)
    ld = JIB * cphi * phid - zd
    rdd = (xd * xd + yd * yd + x * xdd + y * ydd - rd * rd) / r
    psidd = (x * ydd - y * xdd - 2 * r * rd * psid) / r**2
    phidd = -(rdd + JIB * cphi * phid**2) / (JIB * sphi)
    ldd = JIB * (cphi * phidd - sphi * phid**2) - zdd
    px, py = point.payload
    sway = [-(px * x + py * y) / (r * GRAVITY), -(py * x - px * y) / (r * GRAVITY), -1 / (JIB * sphi), 1 / r]
    return JointPoint(
        [0.0, psi, phi, PIVOT + JIB * sphi - z, wrap(yaw - psi)],
        [0.0, psid, phid, ld, yawd - psid],
        [0.0, psidd, phidd, ldd, yawdd - psidd],
        sway,
        unreachable,
    )


def joint_torques(q: list[float], qd: list[float], qdd: list[float], payload: float) -> list[float]:
    """Joint forces of the L0 crane, closed form of plant-and-bus.md 1.3, gantry at rest; no rotors, no friction."""
    psi, phi = q[1], q[2]
    sdd, psidd, phidd, ldd, kappadd = qdd
    psid, phid = qd[1], qd[2]
    sp, cp, sf, cf = math.sin(psi), math.cos(psi), math.sin(phi), math.cos(phi)
    a = payload * JIB + M_JIB * C_JIB
    radius = A0 + JIB * cf
    mu = M_JIB * (A0 + C_JIB * cf) + payload * radius - M_CW * R_CW
    h = I_JIB + M_JIB * C_JIB**2 + payload * JIB**2
    m_psi = J_SLEW + I_JIB * cf * cf + M_CW * R_CW**2 + M_JIB * (A0 + C_JIB * cf) ** 2 + payload * radius**2
    coupling = h * cf + A0 * a
    i_k = I_SPREADER + I_PER_KG * max(0.0, payload - M_SPREADER)
    kappa = i_k * (psidd + kappadd)
    return [
        (M_GANTRY + M_JIB + M_CW + payload) * sdd
        - mu * (psid**2 * cp + psidd * sp)
        - a * (cf * cp * phid**2 + sf * cp * phidd - 2 * sf * sp * phid * psid),
        m_psi * psidd - mu * sp * sdd - 2 * sf * phid * psid * coupling + kappa,
        h * phidd - a * sf * cp * sdd - payload * JIB * cf * ldd + GRAVITY * a * cf + sf * psid**2 * coupling,
        payload * (ldd - GRAVITY - JIB * cf * phidd + JIB * sf * phid**2),
        kappa,
    ]


def torque(q: list[float], qd: list[float], qdd: list[float], payload: float) -> list[float]:
    """Motor torques: inverse dynamics, rotors, friction, gear."""
    out = []
    for j, t in enumerate(joint_torques(q, qd, qdd, payload)):
        n = GEAR[j]
        rated = n * RATED_TORQUE[j]
        top = RATED_SPEED / n
        friction = rated * (COULOMB * math.tanh(qd[j] / (SMOOTH * top)) + VISCOUS * qd[j] / top)
        out.append((t + ROTOR[j] * n * n * qdd[j] + friction) / (n * EFFICIENCY[j]))
    return out


# ---- PID (docs/control.md)
BANDWIDTH = (5.0, 40.0, 40.0, 40.0, 40.0)  # rad/s, double pole of the rigid joint
T_D = tuple(2 / w for w in BANDWIDTH)
T_I = tuple(6 / w for w in BANDWIDTH)
T_T = tuple(math.sqrt(a * b) for a, b in zip(T_D, T_I, strict=True))
N_D = 20.0


def inertia(phi: float, mass: float) -> list[float]:
    """What each drive has to move above the load's swing, at the joint, kg or kg m2: the load below a rope counts where
    it moves with it."""
    rotor = [j * n * n for j, n in zip(ROTOR, GEAR, strict=True)]
    c = math.cos(phi)
    return [
        rotor[0] + M_GANTRY + M_JIB + M_CW,
        rotor[1] + J_SLEW + M_CW * R_CW**2 + I_JIB * c * c + M_JIB * (A0 + C_JIB * c) ** 2,
        rotor[2] + I_JIB + M_JIB * C_JIB**2 + mass * (JIB * c) ** 2,
        rotor[3] + mass,
        rotor[4] + I_SPREADER,  # the load does not count: near anything it hangs on falls that are slack in skew
    ]


def stiffness(phi: float, mass: float) -> list[float]:
    """K of each joint, motor N m per m or rad."""
    return [m * w * w / (n * e) for m, w, n, e in zip(inertia(phi, mass), BANDWIDTH, GEAR, EFFICIENCY, strict=True)]


def control_block() -> list[float]:
    """The words of CR_CONTROL_BLOCK: the terms of K by cos phi and mass, found from `stiffness` itself, then the
    rest."""

    def at(cos: float, mass: float) -> list[float]:
        return stiffness(math.acos(cos), mass)

    words: list[float] = []
    for j in range(5):
        free, loaded = ([at(c, m)[j] for c in (0.0, 1.0, -1.0)] for m in (0.0, 1000.0))
        per_kg = [(b - a) / 1000.0 for a, b in zip(free, loaded, strict=True)]
        words += [free[0], per_kg[0], (free[1] - free[2]) / 2, (free[1] + free[2]) / 2 - free[0], per_kg[1] - per_kg[0]]
        words += [N_D, T_D[j], 1 / T_I[j], 1 / T_T[j], 1.0, 1.0]
    return [*words, SWAY_GAIN, WIND_OBSERVER, SWAY_FILTER, SWAY_LIMIT]


CODE = tuple(2047 / u for u in U_MAX)
SWAY_GAIN, WIND_OBSERVER, SWAY_FILTER, SWAY_LIMIT = 9.0, 0.5, 0.15, 0.03  # m/s per rad, rad/s, s, rad
WIND_MOST, OBSERVER_STEP, WINDY = 0.785, 0.02, 0.03  # m/s2; s; m/s2
SETTLE_TIME = 1.5  # s
REST = 1e-4  # joint speed below which the reference counts as at rest


@dataclass
class PidState:
    integral: list[float] = field(default_factory=lambda: [0.0] * 5)  # with K times the last error
    derivative: list[float] = field(default_factory=lambda: [0.0] * 5)
    error: list[float] = field(default_factory=lambda: [0.0] * 5)
    beside: list[float] = field(default_factory=lambda: [0.0, 0.0])  # the load off its path: radial, tangential, m
    sway: list[float] = field(default_factory=lambda: [0.0, 0.0])  # filtered angle of the rope off its reference, rad
    speed: list[float] = field(default_factory=lambda: [0.0, 0.0])  # of the load off its path, m/s
    wind: list[float] = field(default_factory=lambda: [0.0, 0.0])  # acceleration that the wind gives it, m/s2

    def shift(self, length: float) -> list[float]:
        """Where the suspension goes: against the load's speed, and upwind by what the wind displaces."""
        return [-(SWAY_GAIN * v + length * w) / GRAVITY for v, w in zip(self.speed, self.wind, strict=True)]


def hermite(a: float, ad: float, b: float, bd: float, f: float, period: float) -> float:
    """Cubic through a and b with slopes ad and bd at the ends of `period`."""
    return (
        a * (1 + 2 * f) * (1 - f) ** 2
        + b * f * f * (3 - 2 * f)
        + period * (ad * f * (1 - f) ** 2 + bd * f * f * (f - 1))
    )


def sway_update(
    state: PidState, measured: list[float], reference: list[float], h: float, length: float, *, stands: bool = False,
    moves: bool = False,
) -> list[float]:  # fmt: skip
    """A step of h s of the observer; returns the suspension's shift. `stands`: the load does not hang freely; `moves`:
    the path does."""
    step = min(h, OBSERVER_STEP)
    calm = sum(map(abs, state.wind)) + sum(map(abs, state.speed)) / 8 < WINDY
    before = state.shift(length)
    for i in range(2):
        hangs = state.wind[i] / GRAVITY
        swing = min(max(measured[i] - reference[i] - hangs, -SWAY_LIMIT), SWAY_LIMIT)
        state.sway[i] += h / (SWAY_FILTER + h) * (hangs + swing - state.sway[i])
        y, v, w = state.beside[i], state.speed[i], state.wind[i]
        if stands:
            state.beside[i], state.speed[i] = y - step * y, v - step * v
            continue
        if moves and calm:
            state.beside[i] = before[i] + length * state.sway[i]
            state.speed[i] = v + step * (w - GRAVITY * state.sway[i] - WIND_OBSERVER / 4 * v)
            continue
        e = before[i] + length * state.sway[i] - y
        state.beside[i] = y + step * (v + 3 * WIND_OBSERVER * e)
        state.speed[i] = v + step * (w - GRAVITY * state.sway[i] + 3 * WIND_OBSERVER**2 * e)
        state.wind[i] = min(max(w + step * WIND_OBSERVER**3 * e, -WIND_MOST), WIND_MOST)
    return state.shift(length)


def pid(
    state: PidState, reference: list[float], measured: list[float], feed: list[float], h: float, k_p: list[float]
) -> list[float]:
    """Motor torques (clamped) of one tick; h = seconds since the last, k_p = K of each joint now."""
    out = []
    for j in range(5):
        e = reference[j] - measured[j]
        c = T_D[j] / (T_D[j] + N_D * h)
        state.derivative[j] = c * (state.derivative[j] + k_p[j] * N_D * (e - state.error[j]))
        p = state.integral[j] + k_p[j] * (e - state.error[j])
        v = p + state.derivative[j] + feed[j]
        u = min(max(v, -U_MAX[j]), U_MAX[j])
        state.integral[j] = p + k_p[j] * h / T_I[j] * e + h / T_T[j] * (u - v)
        state.error[j] = e
        out.append(u)
    return out
