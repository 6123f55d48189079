"""The crane in motion, against closed forms: energy, order, periods, conserved momentum, and a second integrator."""

import itertools
import math

import numpy as np
import pytest
from cmrc._core import plant
from cmrc_test import plant as parts
from lossless import without_losses

G = 9.81
ACTUATED = (0, 1, 2, 3, 6)


def frictionless() -> plant.CraneParameters:
    return without_losses(plant.CraneParameters())


def payload_inputs(mass=20e3, inertia=2e5):
    inputs = parts.CraneInputs()
    inputs.payload = (mass, inertia)
    return inputs


def state(q, qd=(0,) * 7):
    s = plant.CraneState()
    s.q, s.qd = list(q), list(qd)
    return s


def locked(*coordinates):
    return sum(1 << c for c in coordinates)


@pytest.mark.parametrize("length", [10.0, 20.0, 35.0])
def test_small_swing_has_the_period_of_a_pendulum(length):
    motion = parts.CraneMotion(frictionless(), 1e-10)
    inputs = payload_inputs()
    inputs.locked = locked(*ACTUATED)
    s = state((0, 0.3, 0.8, length, 1e-3, 0, 0))
    period = 2 * math.pi * math.sqrt(length / G)
    motion.advance(s, inputs, period / 4)
    assert abs(s.q[4]) < 1e-7
    motion.advance(s, inputs, 3 * period / 4)
    assert s.q[4] == pytest.approx(1e-3, rel=1e-5)


def test_undriven_frictionless_crane_keeps_its_energy():
    crane = frictionless()
    motion = parts.CraneMotion(crane, 1e-11)
    model = plant.Crane(crane)
    inputs = payload_inputs()
    inputs.locked = locked(2, 3)  # luff and hoist would fall
    s = state((0, 0.2, 0.9, 18.0, 0.2, -0.15, 0.1), (0.1, 0.02, 0, 0, 0.1, 0.05, 0.01))

    def energy():
        return model.kinetic_energy(s.q, s.qd, 20e3, 2e5) + model.potential_energy(s.q, 20e3)

    start, kinetic = energy(), model.kinetic_energy(s.q, s.qd, 20e3, 2e5)
    for _ in range(400):
        motion.advance(s, inputs, 0.05)
    assert abs(energy() - start) < 1e-6 * max(kinetic, 1.0)


def test_travel_momentum_is_conserved_without_travel_force():
    crane = frictionless()
    motion = parts.CraneMotion(crane, 1e-11)
    model = plant.Crane(crane)
    inputs = payload_inputs()
    inputs.locked = locked(2, 3)
    s = state((0, 0.5, 0.9, 18.0, 0.3, 0.1, 0.0), (0.2, 0.05, 0, 0, 0, 0.1, 0))

    def momentum():
        return (np.array(model.mass_matrix(s.q, 20e3, 2e5)) @ np.array(s.qd))[0]

    start = momentum()
    for _ in range(100):
        motion.advance(s, inputs, 0.05)
    assert momentum() == pytest.approx(start, rel=1e-7)


def test_fixed_steps_converge_with_fourth_order():
    inputs = payload_inputs()
    inputs.locked = locked(2, 3)
    q, qd = (0, 0.2, 0.9, 12.0, 0.4, -0.3, 0.1), (0.1, 0.05, 0, 0, 0.1, 0.05, 0.01)
    results = []
    for step in (0.1, 0.05, 0.025, 0.0125 / 8):
        s = state(q, qd)
        parts.CraneMotion(frictionless(), 1e-8).advance_fixed(s, inputs, 2.0, step)
        results.append(np.array(s.q))
    errors = [np.abs(r - results[-1]).max() for r in results[:-1]]
    slopes = [math.log2(a / b) for a, b in itertools.pairwise(errors)]
    assert all(3.7 < slope < 4.4 for slope in slopes), slopes


def test_an_independent_multistep_integrator_agrees():
    inputs = payload_inputs()
    inputs.command = [100.0, 300.0, 0.0, 0.0, 10.0]
    inputs.locked = locked(2, 3)
    one, two = (state((0, 0.2, 0.9, 12.0, 0.1, -0.1, 0.1)) for _ in range(2))
    parts.CraneMotion(plant.CraneParameters(), 1e-9).advance(one, inputs, 3.0)
    parts.CraneMotion(plant.CraneParameters(), 1e-9, method=plant.Method.adams).advance(two, inputs, 3.0)
    assert np.allclose(one.q, two.q, rtol=0, atol=1e-6)
