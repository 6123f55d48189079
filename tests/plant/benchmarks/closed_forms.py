"""Motions with a known answer. Each function returns (what was reached as a relative error, what is allowed).

``python tests/plant/benchmarks/closed_forms.py`` prints the table of docs/plant.md.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from cmrc._core import plant
from cmrc_test import plant as parts

G = 9.81
S, PSI, PHI, L, ALPHA, BETA, KAPPA = range(7)
ACTUATED = (S, PSI, PHI, L, KAPPA)
MASS = 20e3


def crane(**changes) -> plant.CraneParameters:
    """Without friction, damping or rotors, unless changed."""
    p = plant.CraneParameters()
    p.sway_damping = 0.0
    drives = p.drives
    for drive in drives:
        drive.coulomb = drive.viscous = drive.rotor_inertia = 0.0
    for name, value in changes.pop("drive", {}).items():
        for drive in drives:
            setattr(drive, name, value)
    p.drives = drives
    for name, value in changes.items():
        setattr(p, name, value)
    return p


def motion(p, q, qd=(0,) * 7, free=(ALPHA, BETA), mass=MASS, **given):
    inputs = parts.CraneInputs()
    inputs.payload = (mass, 2e5)
    inputs.locked = sum(1 << k for k in range(7) if k not in free)
    for name, value in given.items():
        setattr(inputs, name, list(value))
    state = plant.CraneState()
    state.q, state.qd = list(q), list(qd)
    return parts.CraneMotion(p, 1e-11), state, inputs


def vector(coordinate: int, value: float) -> list[float]:
    return [value if k == coordinate else 0.0 for k in range(7)]


def bessel(order: int, x: float) -> float:
    t = (np.arange(400) + 0.5) * math.pi / 400
    return float(np.cos(order * t - x * np.sin(t)).mean())


def pendulum_at_finite_amplitude() -> tuple[float, float]:
    length, start = 18.0, 0.6
    a, b = 1.0, math.cos(start / 2)
    for _ in range(6):
        a, b = (a + b) / 2, math.sqrt(a * b)
    period = 2 * math.pi * math.sqrt(length / G) / a
    m, s, i = motion(crane(), (0, 0.3, 0.8, length, start, 0, 0))
    m.advance(s, i, 10.25 * period)  # through plumb
    return abs(s.q[ALPHA]) / start, 1e-7


def pendulum_while_the_rope_pays_out() -> tuple[float, float]:
    # Small sway on a rope l = l0 + v t: J1(2 sqrt(g l) / v) / sqrt(l).
    v, l0, size = 1.0, 12.0, 1e-4

    def sway(length):
        return size * bessel(1, 2 * math.sqrt(G * length) / v) / math.sqrt(length)

    rate = v * (sway(l0 + 1e-4) - sway(l0 - 1e-4)) / 2e-4
    p = crane()
    drives = p.drives
    drives[3].rotor_inertia = 1e8  # a drum that nothing disturbs
    p.drives = drives
    m, s, i = motion(
        p, (0, 0, 0.8, l0, sway(l0), 0, 0), (0, 0, 0, v, rate, 0, 0), free=(L, ALPHA), external=vector(L, -MASS * G)
    )
    m.advance(s, i, 10.0)
    return abs(s.q[ALPHA] - sway(l0 + 10 * v)) / size, 1e-5


def residual_sway_after_a_moving_pivot() -> tuple[float, float]:
    # Accelerated by a for a time T: amplitude 2 a/g |sin(w T / 2)|.
    length, a, pulse = 20.0, 0.01, 2.0
    huge = 1e13
    w = math.sqrt(G / length)
    p = crane(gantry_mass=huge)
    m, s, i = motion(p, (0, 0, 0.8, length, 0, 0, 0), free=(S, ALPHA), external=vector(S, huge * a))
    m.advance(s, i, pulse)
    i.external = [0.0] * 7
    amplitude = math.hypot(s.q[ALPHA], s.qd[ALPHA] / w)
    return abs(amplitude / (2 * a / G * abs(math.sin(w * pulse / 2))) - 1), 1e-5


def conical_pendulum() -> tuple[float, float]:
    length, angle = 15.0, 0.4
    w = math.sqrt(G / (length * math.cos(angle)))
    # At alpha = angle, beta = 0 the load moves along tangential: l betad = w l sin(angle).
    m, s, i = motion(crane(), (0, 0, 0.8, length, angle, 0, 0), (0, 0, 0, 0, 0, w * math.sin(angle), 0))
    m.advance(s, i, 2 * math.pi / w * 3.25)
    return math.hypot(s.q[ALPHA], s.q[BETA] - angle), 1e-7


def rope_force_at_the_bottom_of_a_swing() -> tuple[float, float]:
    length, start = 18.0, 0.5
    speed = math.sqrt(2 * G * (1 - math.cos(start)) / length)
    m, s, i = motion(crane(), (0, 0, 0.8, length, 0, 0, 0), (0, 0, 0, 0, speed, 0, 0))
    force = m.holding_force(s, i)[L]
    return abs(-force / (MASS * G * (3 - 2 * math.cos(start))) - 1), 1e-12


def load_slung_outward_by_slewing() -> tuple[float, float]:
    length, w, phi = 12.0, 0.12, 0.8
    p = crane()
    reach = p.a0 + p.jib * math.cos(phi)
    alpha = 0.0
    for _ in range(200):
        alpha = math.atan(w * w * (reach + length * math.sin(alpha)) / G)
    huge = crane(slew_inertia=1e16)
    m, s, i = motion(huge, (0, 0, phi, length, alpha, 0, 0), (0, w, 0, 0, 0, 0, 0), free=(PSI, ALPHA, BETA))
    m.advance(s, i, 30.0)
    return abs(s.q[ALPHA] - alpha) / alpha, 1e-7


def motor_behind_its_gear_and_lag() -> tuple[float, float]:
    torque, lag, t = 500.0, 3e-3, 0.5
    p = crane(drive={"rotor_inertia": 0.4, "efficiency": 0.9, "torque_lag": lag})
    n = p.drives[0].gear
    moved = p.gantry_mass + p.jib_mass + p.counterweight + MASS + 0.4 * n * n
    m, s, i = motion(p, (0, 0, 0.8, 12, 0, 0, 0), free=(S,), command=[torque, 0, 0, 0, 0])
    m.advance(s, i, t)
    speed = n * 0.9 * torque / moved * (t - lag * (1 - math.exp(-t / lag)))
    return abs(s.qd[S] / speed - 1), 1e-8


def running_down_by_viscous_friction() -> tuple[float, float]:
    p = crane(drive={"viscous": 0.5})
    b = 0.5 * p.drives[0].rated_force / p.drives[0].rated_joint_speed
    moved = p.gantry_mass + p.jib_mass + p.counterweight + MASS
    m, s, i = motion(p, (0, 0, 0.8, 12, 0, 0, 0), (0.3, 0, 0, 0, 0, 0, 0), free=(S,))
    m.advance(s, i, 2.0)
    return abs(s.qd[S] / (0.3 * math.exp(-b / moved * 2.0)) - 1), 1e-8


def stopping_by_dry_friction() -> tuple[float, float]:
    # M vd = -F tanh(v / v0): sinh(v / v0) falls exponentially.
    p = crane(drive={"coulomb": 0.1, "stribeck": 1.0})
    drive = p.drives[0]
    v0 = drive.smooth_speed * drive.rated_joint_speed
    moved = p.gantry_mass + p.jib_mass + p.counterweight + MASS
    rate = 0.1 * drive.rated_force / (moved * v0)
    m, s, i = motion(p, (0, 0, 0.8, 12, 0, 0, 0), (0.04, 0, 0, 0, 0, 0, 0), free=(S,))
    t = 0.9 * 0.04 / (rate * v0)
    m.advance(s, i, t)
    exact = v0 * math.asinh(math.sinh(0.04 / v0) * math.exp(-rate * t))
    return abs(s.qd[S] / exact - 1), 1e-6


def load_running_off_an_open_drum() -> tuple[float, float]:
    p = crane(drive={"rotor_inertia": 16.0})
    m, s, i = motion(p, (0, 0, 0.8, 10, 0, 0, 0), free=(L,))
    m.advance(s, i, 1.5)
    a = G * MASS / (MASS + 16.0 * p.drives[3].gear ** 2)
    return abs((s.q[L] - 10) / (0.5 * a * 1.5**2) - 1), 1e-9


def vehicle_in_a_steady_curve() -> tuple[float, float]:
    # Both axles steered by d against each other, a neutral vehicle at low lateral acceleration: radius = half wheelbase
    # / tan d.
    dock = plant.Dock(plant.default_dock())
    angle, speed, ms = 0.1, 1.0, 10**9
    dock.agv_period(0, 20000, 0)
    for k in range(0, 20000, 20):
        dock.agv_push(0, int(speed * 1e3), int(angle * 1e6), -int(angle * 1e6), k * ms)
    signal = dock.agv(0)
    return abs(signal.speed / signal.yaw_rate / (4.5 / math.tan(angle)) - 1), 2e-2


def settling_on_corner_springs() -> tuple[float, float]:
    mass, k, d, h = 30.48e3, 4e7, 6e5, 2.5e-4
    rows = np.array(parts.drop_box(mass, [12.0, 2.4, 2.6], 0.0, 0.0, 0.0, h, 400))
    w0 = math.sqrt(k / mass)
    z = d / (2 * math.sqrt(k * mass))
    wd = w0 * math.sqrt(1 - z * z)
    deepest = -(mass * G / k) * (1 + math.exp(-z * w0 * math.pi / wd))
    return abs(rows[:, 0].min() / deepest - 1), 2e-2


def sliding_down_a_slope() -> tuple[float, float]:
    slope, h, steps = math.radians(30), 2.5e-4, 4000
    rows = np.array(parts.drop_box(30e3, [12.0, 2.4, 2.6], -30e3 * G * math.cos(slope) / 4e7, 0.0, slope, h, steps))
    a = G * (math.sin(slope) - 0.4 * math.cos(slope))
    middle, end = steps // 2, steps - 1
    measured = (rows[end, 3] - 2 * rows[middle, 3] + rows[2 * middle - end, 3]) / ((end - middle) * h) ** 2
    return abs(measured / a - 1), 2e-2


BENCHMARKS: tuple[Callable[[], tuple[float, float]], ...] = (
    pendulum_at_finite_amplitude, pendulum_while_the_rope_pays_out, residual_sway_after_a_moving_pivot, conical_pendulum,
    rope_force_at_the_bottom_of_a_swing, load_slung_outward_by_slewing, motor_behind_its_gear_and_lag, running_down_by_viscous_friction,
    stopping_by_dry_friction, load_running_off_an_open_drum, vehicle_in_a_steady_curve, settling_on_corner_springs, sliding_down_a_slope,
)  # fmt: skip


if __name__ == "__main__":
    print("| motion with a known answer | error reached | allowed |\n|---|---|---|")
    for benchmark in BENCHMARKS:
        reached, allowed = benchmark()
        print(f"| {benchmark.__name__.replace('_', ' ')} | {reached:.1e} | {allowed:.0e} |")
