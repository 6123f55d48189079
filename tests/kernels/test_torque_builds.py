"""Both builds of torque compensation against Lagrange's equations, computed from the positions of the masses only."""

from __future__ import annotations

import itertools
import math
import random

import numpy as np
import pytest
import reference as ref
from harness import Dsp, from_ti, to_ti

CLOSED_FORM, NEWTON_EULER = "torque", "torque_newton_euler"
# In units of 2^-23 u_max. Closed form: some ten 24-bit words or constants enter each sum, whose terms stay below u_max.
# Newton-Euler: beside those twelve, a force passes through at most six links and is stored four times in each
# (acceleration, force, turned force, moment), rounded to 2^-24 of a term that stays below 2 u_max: 24 more.
BOUND = {CLOSED_FORM: 12, NEWTON_EULER: 36}
# plant-and-bus.md 2.2; a build may cost from half to twice that
ESTIMATE = {CLOSED_FORM: 700, NEWTON_EULER: 2300}


def masses(payload: float) -> list[tuple[float, object]]:
    """Mass and place of each particle as a function of q = (s, psi, phi, l, kappa); complex q allowed."""

    def radial(q: np.ndarray, r: complex, z: complex) -> np.ndarray:
        return np.array([q[0] + r * np.cos(q[1]), r * np.sin(q[1]), z])

    return [
        (ref.M_GANTRY, lambda q: np.array([q[0], 0 * q[0], 0 * q[0]])),
        (ref.M_CW, lambda q: radial(q, -ref.R_CW + 0 * q[0], 0 * q[0])),
        (ref.M_JIB, lambda q: radial(q, ref.A0 + ref.C_JIB * np.cos(q[2]), ref.C_JIB * np.sin(q[2]))),
        (payload, lambda q: radial(q, ref.A0 + ref.JIB * np.cos(q[2]), ref.JIB * np.sin(q[2]) - q[3])),
    ]


def mass_matrix(q: np.ndarray, payload: float) -> np.ndarray:
    m = np.zeros((5, 5))
    for mass, place in masses(payload):
        columns = []
        for j in range(5):
            step = q.astype(complex)
            step[j] += 1e-30j  # exact to rounding: no difference is taken
            columns.append(place(step).imag / 1e-30)
        jacobian = np.array(columns).T
        m += mass * jacobian.T @ jacobian
    # What turns: the platform and the slender jib about the vertical, the jib about its own middle, the load about the
    # vertical.
    m[1, 1] += ref.J_SLEW + ref.I_JIB * math.cos(q[2]) ** 2
    m[2, 2] += ref.I_JIB
    yaw = ref.I_SPREADER + ref.I_PER_KG * (payload - ref.M_SPREADER)
    m[np.ix_((1, 4), (1, 4))] += yaw
    return m


def lagrange(q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, payload: float) -> np.ndarray:
    """d/dt dT/dqd - dT/dq + dV/dq with dM/dq by central differences (1e-9 relative)."""
    h = 1e-4
    slopes = np.array([(mass_matrix(q + d, payload) - mass_matrix(q - d, payload)) / (2 * h) for d in np.eye(5) * h])
    force = (
        mass_matrix(q, payload) @ qdd
        + np.einsum("k,kij,j->i", qd, slopes, qd)
        - np.einsum("i,kij,j->k", qd, slopes, qd) / 2
    )
    for mass, place in masses(payload)[1:]:
        for j in range(5):
            step = q.astype(complex)
            step[j] += 1e-30j
            force[j] += ref.GRAVITY * mass * place(step)[2].imag / 1e-30
    return force


def motor_torques(q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, payload: float) -> list[float]:
    out = []
    for j, force in enumerate(lagrange(q, qd, qdd, payload)):
        n, rated = ref.GEAR[j], ref.GEAR[j] * ref.RATED_TORQUE[j]
        top = ref.RATED_SPEED / n
        friction = rated * (ref.COULOMB * math.tanh(qd[j] / (ref.SMOOTH * top)) + ref.VISCOUS * qd[j] / top)
        out.append((force + ref.ROTOR[j] * n * n * qdd[j] + friction) / (n * ref.EFFICIENCY[j]))
    return out


@pytest.fixture(scope="module")
def dsp() -> Dsp:
    dsp = Dsp()
    dsp.servo_rates(consumed=2)
    return dsp


def singles(r: random.Random, *spans: float) -> np.ndarray:
    return np.array([from_ti(to_ti(r.uniform(-x, x))) for x in spans])


def states(seed: int, count: int) -> list[tuple[np.ndarray, np.ndarray, np.ndarray, float]]:
    r = random.Random(seed)
    out = []
    for _ in range(count):
        q = singles(r, 40.0, 3.0, 0.5, 18.0, 3.0) + np.array([0, 0, 0.875, 25.0, 0])
        q = np.array([from_ti(to_ti(float(x))) for x in q])
        payload = float(round(r.uniform(10e3, 50e3)))
        out.append((q, singles(r, 0.5, 0.12, 0.05, 1.0, 0.1), singles(r, 0.1, 0.02, 0.01, 0.3, 0.03), payload))
    return out


def run(dsp: Dsp, kernel: str, state: tuple[np.ndarray, np.ndarray, np.ndarray, float]) -> tuple[list[float], int]:
    *motion, payload = state
    for slot in (0, 1):  # the set-point rests on one joint point
        dsp.put("CR_RING", *(float(x) for part in motion for x in part), offset=slot * 16)
    dsp.hang(int(payload))
    result, notify, cycles = dsp.run(kernel, tick=8)
    assert (result, notify) == (int(payload) << 8, 0)
    return dsp.floats("CR_FEED_FORWARD", 5), cycles


@pytest.mark.parametrize("kernel", [CLOSED_FORM, NEWTON_EULER])
def test_a_build_solves_lagranges_equations(dsp: Dsp, kernel: str) -> None:
    for state in states(1, 80):
        got, cycles = run(dsp, kernel, state)
        assert ESTIMATE[kernel] / 2 < cycles < 2 * ESTIMATE[kernel]
        for j, want in enumerate(motor_torques(*state)):
            assert got[j] == pytest.approx(want, abs=BOUND[kernel] * 2**-23 * ref.U_MAX[j]), j


def test_each_term_is_there() -> None:
    """The oracle itself: gravity, centrifugal and Coriolis terms of plant-and-bus.md 1.3, one at a time."""
    zero = np.zeros(5)
    q = np.array([0.0, 0.4, 0.9, 20.0, 0.0])
    p = 30e3
    moment = p * ref.JIB + ref.M_JIB * ref.C_JIB
    held = lagrange(q, zero, zero, p)
    assert held[2] == pytest.approx(ref.GRAVITY * moment * math.cos(0.9), rel=1e-9)
    assert held[3] == pytest.approx(-p * ref.GRAVITY, rel=1e-12)
    turning = lagrange(q, np.array([0, 0.1, 0, 0, 0.0]), zero, p) - held
    coupling = (ref.I_JIB + ref.M_JIB * ref.C_JIB**2 + p * ref.JIB**2) * math.cos(0.9) + ref.A0 * moment
    assert turning[2] == pytest.approx(math.sin(0.9) * 0.01 * coupling, rel=1e-6)


def test_nothing_before_pid_has_taken_the_pose(dsp: Dsp) -> None:
    for stage, kernel in itertools.product((0,), (CLOSED_FORM, NEWTON_EULER)):
        dsp.put("CR_PID_STAGE", stage)
        dsp.put("CR_FEED_FORWARD", 1.0, 2.0, 3.0, 4.0, 5.0)
        dsp.run(kernel, tick=8)
        assert dsp.floats("CR_FEED_FORWARD", 5) == [0.0] * 5
    dsp.put("CR_PID_STAGE", 2)
