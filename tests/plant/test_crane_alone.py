"""The crane by itself: torques at the start, copies of its state and parameters, its linearisation, the motors' lag,
orders that SUNDIALS gets wrong."""

import copy
import pickle

import numpy as np
import pytest
from cmrc import plant
from cmrc._core import plant as core
from cmrc_test import plant as parts

REST = (0.0, 0.3, 0.8, 14.0, 0.02, -0.01, 0.1)


def test_reset_takes_torques_and_the_lag_is_exact():
    crane = plant.Crane(load_mass=20e3)
    start, command, lag = (
        np.array([10.0, -200.0, 3000.0, 2500.0, 5.0]),
        np.array([20.0, 100.0, 3200.0, 2500.0, 0.0]),
        3e-3,
    )
    crane.reset(REST, torques=start)
    assert (crane.state.torque == start).all()
    for step in (1.0e-3, 0.4e-3, 7.0e-3):
        before = crane.state
        crane.step(command, step)
        np.testing.assert_allclose(
            crane.state.torque, command + (before.torque - command) * np.exp(-step / lag), rtol=1e-13, atol=1e-11
        )


@pytest.mark.parametrize("torques", [(0.0,) * 4, (0.0, np.nan, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1e6, 0.0)])
def test_torques_that_no_motor_gives_are_refused(torques):
    with pytest.raises(ValueError, match="torque"):
        plant.Crane().reset(REST, torques=torques)


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda value: pickle.loads(pickle.dumps(value))])
def test_snapshots_continue_bit_for_bit(again):
    crane = plant.Crane(load_mass=20e3)
    crane.step([0.0, 500.0, 3300.0, 2400.0, 1.0], 0.237)
    kept = again(crane.snapshot())
    crane.step([0.0, 400.0, 3300.0, 2400.0, 1.0], 0.5)
    other = plant.Crane(load_mass=20e3)
    other.restore(kept)
    other.step([0.0, 400.0, 3300.0, 2400.0, 1.0], 0.5)
    assert pickle.dumps(other.state) == pickle.dumps(crane.state)


def test_what_a_crane_knew_of_its_state_is_forgotten_with_its_load():
    crane, fresh = plant.Crane(load_mass=20e3), plant.Crane(load_mass=5e3)
    crane.step([0.0, 500.0, 3300.0, 2400.0, 1.0], 0.237)
    here = crane.state
    heavy = crane.acceleration()
    crane.set_load(5e3)
    fresh.reset(here.q, here.qd, here.torque)
    assert crane.acceleration().tobytes() == fresh.acceleration().tobytes() != heavy.tobytes()


@pytest.mark.parametrize("order", [3, 4, 5])
def test_a_crane_that_has_moved_before_moves_as_a_fresh_one(order):
    used, fresh = (plant.Crane(load_mass=20e3, order=order) for _ in range(2))
    used.step([0.0, 500.0, 3300.0, 2400.0, 1.0], 0.237)
    for crane in (used, fresh):
        crane.reset(REST)
        crane.step([0.0, 400.0, 3300.0, 2400.0, 1.0], 0.02)
    assert pickle.dumps(used.state) == pickle.dumps(fresh.state)


def test_a_snapshot_of_another_size_is_refused():
    with pytest.raises(ValueError, match="bytes"):
        core.CraneAloneState.__setstate__(core.CraneAloneState.__new__(core.CraneAloneState), b"short")


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda value: pickle.loads(pickle.dumps(value))])
def test_parameters_are_copied_whole(again):
    config = plant.gantry_dock(2)
    config.crane.jib_mass, config.wind.mean, config.tolerance = 26e3, 7.0, 1e-7
    config.layout.movers = [plant.Mover(0.4, 1.8, [plant.Waypoint(0, 40, 9), plant.Waypoint(5, 45, 9)], True)]
    same = again(config)
    assert same is not config and values(same) == values(config)
    same.crane.jib_mass = 1.0
    assert config.crane.jib_mass == 26e3


def values(thing):
    """Everything that can be read of it, by name."""
    if isinstance(thing, (list, tuple)):
        return [values(part) for part in thing]
    members = [name for name, member in vars(type(thing)).items() if isinstance(member, property)]
    return (
        {name: values(getattr(thing, name)) for name in members}
        if type(thing).__module__.endswith("plant") and members
        else thing
    )


@pytest.mark.parametrize("machine", ["slewing", "gantry"])
def test_the_linearisation_is_the_cranes_own_near_by(machine):
    """Compared with the crane itself from states slightly off the equilibrium: x(t) = exp(A t) x(0) + integral of exp(A
    s) B u."""
    home = (0.0, 12.0, 16.0, 14.0, 0.0) if machine == "slewing" else (0.0, 0.0, 12.0, 14.0, 0.0)
    crane = plant.Crane(machine=machine, load_mass=20e3, home=home, tolerance=1e-12, order=5)
    q, hold = crane.state.q, np.zeros(5)
    for _ in range(3):  # the torques that hold it, by Newton
        crane.reset(q, torques=hold)
        gains = crane.linearize().A[7:14, 14:][list(plant.ACTUATED)]
        gains[~gains.any(axis=1)] = np.eye(5)[~gains.any(axis=1)]
        hold = hold - np.linalg.solve(gains, crane.acceleration()[list(plant.ACTUATED)])
    crane.reset(q, torques=hold)
    assert np.abs(crane.acceleration()).max() < 1e-9
    model = crane.linearize(crane.snapshot())
    assert (
        model.A.shape == (19, 19) and model.B.shape == (19, 5) and model.C.shape == (7, 19) and model.D.shape == (7, 5)
    )
    assert (
        len(model.states) == len(model.state_units) == 19
        and len(model.inputs) == 5
        and len(model.outputs) == len(model.output_units) == 7
    )
    rng = np.random.default_rng(3)
    small, drive, seconds = 1e-6 * rng.normal(size=19), 1e-3 * rng.normal(size=5), 0.05
    if machine == "gantry":
        small[[1, 8]] = 0.0
    start = np.concatenate([q, np.zeros(7), hold]) + small
    crane.reset(start[:7], start[7:14], start[14:])
    crane.step(hold + drive, seconds)
    state = crane.state
    end = np.concatenate([state.q - q, state.qd, state.torque - hold])
    whole = np.zeros((24, 24))
    whole[:19, :19], whole[:19, 19:] = model.A * seconds / 1024, model.B * seconds / 1024
    power = np.eye(24)
    for k in range(12, 0, -1):
        power = np.eye(24) + whole @ power / k
    for _ in range(10):
        power = power @ power
    expected = (power @ np.concatenate([small, drive]))[:19]
    np.testing.assert_allclose(model.C @ end, model.C @ expected, rtol=2e-3, atol=2e-11)
    np.testing.assert_allclose(end[7:14], expected[7:14], rtol=2e-3, atol=2e-9)


@pytest.mark.parametrize("order", [2, 6, 7, 8])
def test_orders_whose_tables_sundials_misuses_are_refused(order):
    with pytest.raises(ValueError, match="order"):
        plant.Crane(order=order)
    with pytest.raises(ValueError, match="order"):
        parts.CraneMotion(core.CraneParameters(), 1e-8, order)


@pytest.mark.parametrize("order", [3, 4, 5])
def test_several_fixed_steps_in_one_call_have_the_order_they_say(order):
    """h = 4 and 2 ms (issue 15), against an integration of tight tolerance; the command is the torque, which then is
    constant."""
    inputs = parts.CraneInputs()
    inputs.payload = (30e3, 1.25e5)
    inputs.command = torque = [0.0, 800.0, 3000.0, 2400.0, 2.0]

    def end(fixed):
        s = core.CraneState()
        s.q, s.qd, s.torque, s.step = list(REST), [0.1, 0.05, 0.01, 0.3, 0.5, -0.4, 0.02], torque, 1e-4
        if fixed:
            parts.CraneMotion(core.CraneParameters(), 1e-8, order).advance_fixed(s, inputs, 0.4, fixed)
        else:
            parts.CraneMotion(core.CraneParameters(), 1e-13, 5).advance(s, inputs, 0.4)
        return np.array(s.q)

    exact = end(None)
    errors = [np.abs(end(h) - exact).max() for h in (32e-3, 16e-3, 4e-3, 2e-3)]
    assert np.isfinite(errors).all() and errors[-1] < 1e-6
    assert np.log2(errors[0] / errors[1]) > order - 0.8
