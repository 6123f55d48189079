"""The groups of plant-and-bus.md 1.7 that test_motion.py, test_crane_equations.py and test_dock.py do not hold: long
energy, power, momentum about the slewing axis, the order of ODE, a second engine, the levels against each other, the
work of a landing, the times of events."""

import itertools
import math

import numpy as np
import pytest
from cmrc import plant as public
from cmrc._core import plant
from cmrc_test import plant as parts
from controller import LATCH
from lossless import without_losses

G = 9.81
SECOND = 10**12


def lossless() -> plant.CraneParameters:
    return without_losses(plant.CraneParameters(), rotors=False)


def start(q, qd, mass, *locked, inertia=2e5):
    state, inputs = plant.CraneState(), parts.CraneInputs()
    state.q, state.qd = list(q), list(qd)
    inputs.payload, inputs.locked = (mass, inertia), sum(1 << k for k in locked)
    return state, inputs


@pytest.mark.parametrize("settings", [(1e-11, 5, plant.Method.erk), (1e-11, 4, plant.Method.adams)])
def test_free_crane_keeps_its_energy_over_a_hundred_seconds(settings):
    crane, mass = lossless(), 20e3
    model, motion = plant.Crane(crane), parts.CraneMotion(crane, *settings)
    state, inputs = start((0, 0.2, 0.9, 18.0, 0.2, -0.15, 0.1), (0.1, 0.02, 0, 0, 0.1, 0.05, 0.01), mass, 2, 3)
    lowest = model.potential_energy([*state.q[:4], 0.0, 0.0, 0.0], mass)

    def energy():
        return model.kinetic_energy(state.q, state.qd, mass, 2e5) + model.potential_energy(state.q, mass) - lowest

    before = energy()
    motion.advance(state, inputs, 100.0)
    assert abs(energy() / before - 1) < (1e-8 if settings[2] == plant.Method.erk else 1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_power_balance_with_drives_friction_and_sway_damping(seed):
    """Work put in less all losses is the growth of the energy, for cranes of random sizes."""
    rng = np.random.default_rng(seed)
    sizes = {
        name: getattr(plant.CraneParameters(), name) * rng.uniform(0.6, 1.6)
        for name in ("jib_mass", "slew_inertia", "gantry_mass", "counterweight")
    }
    crane = public.Crane(bookkeeping=True, tolerance=1e-11, load_mass=rng.uniform(0, 35e3), load_inertia=3e5, **sizes)
    bias = crane.bias()
    hold = np.array(
        [bias[k] / (d.gear * d.efficiency) for k, d in zip(public.ACTUATED, crane.parameters.drives, strict=True)]
    )
    before = crane.energy()
    for _ in range(8):
        crane.step(hold + rng.uniform(-0.3, 0.3, 5) * crane.maximum_torques, 0.5)
    w = crane.work
    stored = w.motors - w.gears - w.friction - w.damping + w.external - w.impacts
    put_in = abs(w.motors) + abs(w.gears) + w.friction + w.damping
    assert w.friction > 0 and w.damping > 0
    assert abs(crane.energy() - before - stored) < 1e-7 * put_in


def test_slewing_momentum_is_conserved_with_the_gantry_held():
    crane, mass = lossless(), 20e3
    model, motion = plant.Crane(crane), parts.CraneMotion(crane, 1e-11)
    state, inputs = start((0, 0.5, 0.9, 18.0, 0.3, 0.1, 0.0), (0, 0.05, 0, 0, 0, 0.1, 0), mass, 0, 2, 3)

    def momentum():
        return (np.array(model.mass_matrix(state.q, mass, 2e5)) @ np.array(state.qd))[1]

    before = momentum()
    for _ in range(50):
        motion.advance(state, inputs, 0.1)
    assert momentum() == pytest.approx(before, rel=1e-9)
    inputs.locked &= ~1  # with the gantry free it is not
    for _ in range(50):
        motion.advance(state, inputs, 0.1)
    assert abs(momentum() / before - 1) > 1e-3


@pytest.fixture(scope="module")
def two_engines():
    """ODE's joints at four step sizes, and SUNDIALS on our equations: 3 s, all of gantry, slew, luff and sway free."""
    crane, mass, seconds = lossless(), 40e3, 3.0
    q, qd = (0, 0.4, 0.9, 15, 0.2, -0.15, 0), (0.1, 0.03, 0, 0, 0.1, 0.05, 0)
    force = [0.0, 2e5, plant.Crane(crane).gravity(q, mass)[2]]
    state, inputs = start(q, qd, mass, 3, 6, inertia=1.0)
    inputs.external = [*force, 0, 0, 0, 0]
    parts.CraneMotion(crane, 1e-11).advance(state, inputs, seconds)
    steps = [4e-3, 2e-3, 1e-3, 5e-4]
    return [np.array(parts.swing_in_ode(crane, mass, q, qd, force, h, round(seconds / h))) for h in steps], np.array(
        state.q
    )


def test_crane_of_ode_joints_converges_to_the_equations(two_engines):
    ode, ours = two_engines
    errors = [np.abs(x - ours).max() for x in ode]
    assert errors == sorted(errors, reverse=True)
    assert np.abs(2 * ode[-1] - ode[-2] - ours).max() < 1e-4


def test_ode_takes_as_many_steps_as_it_is_asked_for():
    """A gantry at 1 m/s with the jib and the load at rest beside it: a metre a second, and after no step nothing has
    changed."""
    crane, mass, q, qd = lossless(), 40e3, (2.0, 0.4, 0.9, 15, 0, 0, 0), (1.0, 0, 0, 0, 0, 0, 0)
    hold = [0.0, 0.0, plant.Crane(crane).gravity(q, mass)[2]]
    assert parts.swing_in_ode(crane, mass, q, qd, hold, 1e-3, 0) == pytest.approx(q, abs=1e-12)
    for steps in (1, 2, 10):
        assert parts.swing_in_ode(crane, mass, q, qd, hold, 1e-3, steps)[0] - q[0] == pytest.approx(
            1e-3 * steps, rel=0.01
        )


def test_ode_is_of_first_to_second_order(two_engines):
    ode, ours = two_engines
    errors = [np.abs(x - ours).max() for x in ode]
    slopes = [math.log2(a / b) for a, b in itertools.pairwise(errors)]
    assert all(0.8 < slope < 2.2 for slope in slopes), slopes


def swinging_dock(**landing):
    """The slew drive pushes for a second, then its brake stops it and the load swings."""
    config = plant.default_dock()
    config.tolerance, config.crane.sway_damping = 1e-10, 0.0
    for name, value in landing.items():
        setattr(config.landing, name, value)
    dock = plant.Dock(config)
    dock.enable_drives(2, 0)
    for k in range(10):
        dock.set_torque_code(1, 1500, k * SECOND // 10)
    dock.advance_to(SECOND)
    dock.enable_drives(0, SECOND)
    dock.advance_to(6 * SECOND)
    return dock


def test_stiff_falls_swing_as_the_ideal_rope_does():
    ideal = swinging_dock()
    apart = []
    for stiffness in (1e6, 1e7, 5e7):
        falls = swinging_dock(near=100.0, away=200.0, fall_stiffness=stiffness, yaw_stiffness=2e7)
        assert [event.kind for event in falls.events] == ["near_contact"]
        apart.append(float(np.linalg.norm(np.array(falls.signal.payload) - ideal.signal.payload)))
    assert np.linalg.norm(np.array(ideal.signal.payload) - ideal.signal.tip) > 10
    assert apart[-1] < 1e-3 and apart[0] > 10 * apart[-1]


def test_held_sway_is_the_rigid_level():
    torques = [300.0, 900.0, 1300.0, -1000.0, 5.0]
    rigid = public.Crane(model="rigid", load_mass=2e4, tolerance=1e-11)
    rigid.run(torques, 1e-3, 2000)
    state, inputs = plant.CraneState(), parts.CraneInputs()
    state.q = public.Crane().state.q
    inputs.command, inputs.locked = torques, 0b0110000
    inputs.payload = (rigid.parameters.spreader_mass + 2e4, rigid.parameters.spreader_inertia)
    parts.CraneMotion(rigid.parameters, 1e-11, method=plant.Method.adams).advance(state, inputs, 2.0)
    np.testing.assert_allclose(rigid.state.q, state.q, atol=2e-8)
    swaying = public.Crane(load_mass=2e4)
    swaying.run(torques, 1e-3, 2000)
    assert np.abs(swaying.state.q - rigid.state.q).max() > 1e-3


def test_a_landing_gives_its_energy_to_the_dampers_and_springs():
    """What a box had is, after it settled, in the springs m^2 g^2 / 2k, and the rest is gone: it does not bounce up
    again."""
    mass, stiffness, h, speed, gap = 30480.0, 4e7, 0.00025, 0.2, 0.02
    rows = np.array(parts.drop_box(mass, (12.192, 2.438, 2.591), gap, speed, 0.0, h, 8000))
    height, velocity, force = rows[:, 0], rows[:, 1], rows[:, 2]
    spring = 0.5 * stiffness * np.minimum(height, 0.0) ** 2
    energy = 0.5 * mass * velocity**2 + mass * G * height + spring
    first = int(np.argmax(force > 0))
    assert energy[first - 1] == pytest.approx(0.5 * mass * speed**2 + mass * G * gap, rel=5e-3)
    assert (np.diff(energy[first:]) < 1e-3 * energy[0]).all()  # contact only takes
    assert energy[-1] == pytest.approx(-((mass * G) ** 2) / (2 * stiffness), rel=1e-2)
    assert height[first + 400 :].max() < 0.003
    # The floor's impulse stops the box and carries its weight.
    assert (force * h).sum() == pytest.approx(mass * (speed + G * 8000 * h), rel=2e-3)


def limit_time(dt, **settings):
    crane = public.Crane(**settings)
    crane.reset([0.0, 6.2, 0.9, 15.0, 0.0, 0.0, 0.0], [0.0, 0.06, 0.0, 0.0, 0.0, 0.0, 0.0])
    bias = crane.bias()
    hold = [bias[k] / (d.gear * d.efficiency) for k, d in zip(public.ACTUATED, crane.parameters.drives, strict=True)]
    hold[1] = 900.0
    for _ in range(round(2.0 / dt)):
        crane.step(hold, dt)
    (event,) = (event for event in crane.events if event.kind == "limit")
    assert event.joint == "slew" and crane.state.q[1] <= 2 * math.pi
    return event.time_s


def test_times_of_events_do_not_depend_on_the_step():
    times = [limit_time(dt, tolerance=1e-12) for dt in (1e-3, 4e-4, 1e-2, 0.25)]
    times += [limit_time(1e-3, tolerance=1e-12, integrator=name) for name in ("adams", "bdf")]
    assert max(times[:4]) - min(times[:4]) < 1e-9
    assert max(times) - min(times) < 1e-7  # three methods


def test_times_of_the_docks_events_do_not_depend_on_the_reader():
    def fault_time(quantum):
        config = plant.default_dock(0)
        config.layout.containers = []
        config.crane.upper = [60, 0.95, 1.39, 60, 6.3]
        dock = plant.Dock(config)
        dock.enable_drives(2, 0)
        for t in range(0, 3 * SECOND, quantum):
            dock.set_torque_code(1, 1800, t)
            dock.encoder(1, t + quantum - 1)
        return next(event.time for event in dock.events if event.kind == "joint_limit")

    first, second = fault_time(LATCH * 16), fault_time(LATCH * 48)
    assert first == second and first % LATCH != 0


@pytest.mark.parametrize("method", [plant.Method.erk, plant.Method.adams, plant.Method.bdf])
def test_docks_are_the_same_bits_on_every_run_and_after_a_snapshot(method):
    def build():
        config = plant.default_dock(2)
        config.method = method
        dock = plant.Dock(config)
        dock.enable_drives(31, 0)
        return dock

    def run(dock, seconds):
        end = dock.time + round(seconds * SECOND)
        while dock.time < end:
            for joint, code in enumerate((100, 600, 700, -650, 30)):
                dock.set_torque_code(joint, code, dock.time)
            dock.agv_push(0, 900, 20000, -20000, dock.time)
            dock.advance_to(dock.time + 80 * LATCH)

    one, other = build(), build()
    run(one, 0.5), run(other, 0.2)
    state = other.snapshot()
    run(other, 0.3)
    assert one.state_hash() == other.state_hash()
    third = build()
    third.restore(state)
    run(third, 0.3)
    assert third.state_hash() == one.state_hash()


def test_selectable_integrators_agree():
    ends = {}
    for name in public.INTEGRATORS:
        crane = public.Crane(integrator=name, tolerance=1e-10)
        crane.run([100, 900, 1300, -1000, 2], 1e-3, 1500)
        ends[name] = crane.state.q
    np.testing.assert_allclose(ends["adams"], ends["erk"], atol=1e-6)
    np.testing.assert_allclose(ends["bdf"], ends["erk"], atol=1e-6)
    assert (ends["adams"] != ends["erk"]).any()
