"""cmrc.plant: the crane and the scene from Python, without any DSP."""

import copy
import itertools
import math
import pickle
import time

import numpy as np
import pytest
from cmrc import plant

QUIET = {joint: {"coulomb": 0.0, "viscous": 0.0} for joint in plant.JOINTS}


def holding(crane: plant.Crane) -> list[float]:
    bias = crane.bias()
    return [bias[k] / (d.gear * d.efficiency) for k, d in zip(plant.ACTUATED, crane.parameters.drives, strict=True)]


@pytest.mark.campaign  # a benchmark: it depends on the clock
def test_a_million_steps_take_less_than_a_minute():
    """With other torques at each step, as a controller gives them: then each step begins with the drives' fast
    transient."""
    crane = plant.Crane(load_mass=20e3)
    rated = [drive.rated_torque for drive in crane.parameters.drives]
    torques = (
        np.array(holding(crane)) + np.random.default_rng(1).normal(size=(20000, 5)) * 0.01 * np.array(rated)
    ).tolist()
    start = time.process_time()
    for row in torques:
        crane.step(row, 1e-3)
    assert (time.process_time() - start) / 20000 < 60e-6
    assert not crane.events  # no end stop or brake held it


@pytest.mark.campaign  # a benchmark: it depends on the clock
def test_an_environment_makes_twelve_thousand_steps_a_second():
    """Steps of 10 ms with another action each, the best of five runs of 400."""
    actions = np.random.default_rng(1).uniform(-0.05, 0.05, size=(400, 5)) + [0.0, 0.0, 0.28, 0.3, 0.0]
    best = math.inf
    for _ in range(5):
        env = plant.CraneEnv(target=(14.0, 18.0, 10.0), load_mass=20e3)
        env.reset(seed=1)
        start = time.process_time()
        for action in actions:
            env.step(action)
        best = min(best, time.process_time() - start)
    assert not env.crane.events
    assert len(actions) / best > 12000


def test_mass_matrix_is_that_of_the_kinetic_energy():
    crane = plant.Crane(load_mass=20e3, load_inertia=4e5)
    rng = np.random.default_rng(7)
    q = crane.state.q + rng.uniform(-0.1, 0.1, 7)
    crane.reset(q)
    rest = crane.energy()
    qd = rng.uniform(-0.3, 0.3, 7)
    crane.reset(q, qd)
    assert crane.energy() - rest == pytest.approx(0.5 * qd @ crane.mass_matrix() @ qd, rel=1e-8)


def test_energy_grows_by_what_the_motors_put_in():
    drives = {joint: {**values, "efficiency": 1.0} for joint, values in QUIET.items()}
    crane = plant.Crane(drives=drives, sway_damping=0.0, load_mass=15e3)
    gears = np.array([d.gear for d in crane.parameters.drives])
    torques = np.array(holding(crane)) + [100.0, 300.0, 50.0, -40.0, 1.0]
    before, work, dt = crane.energy(), 0.0, 1e-3
    powers = []
    for _ in range(4000):
        state = crane.state
        powers.append(float((state.torque * gears) @ state.qd[list(plant.ACTUATED)]))
        crane.step(torques, dt)
    state = crane.state
    powers.append(float((state.torque * gears) @ state.qd[list(plant.ACTUATED)]))
    p = np.array(powers)
    work = dt / 3 * (p[0] + 4 * p[1:-1:2].sum() + 2 * p[2:-1:2].sum() + p[-1])
    assert crane.energy() - before == pytest.approx(work, rel=1e-4)


def test_snapshot_continues_bit_for_bit():
    crane = plant.Crane()
    crane.run([50, 200, 1300, -1000, 1], 1e-3, 500)
    kept = crane.snapshot()
    crane.run([50, -200, 1300, -1000, 1], 1e-3, 500)
    once = crane.state
    crane.restore(kept)
    for _ in range(500):
        crane.step([50, -200, 1300, -1000, 1], 1e-3)
    again = crane.state
    assert (once.q == again.q).all() and (once.qd == again.qd).all() and once.time_s == again.time_s


def test_rigid_crane_does_not_sway():
    crane = plant.Crane(model="rigid")
    crane.run([300, 1500, 1300, -1000, 5], 1e-3, 3000)
    state = crane.state
    assert state.q[4] == state.q[5] == 0.0 and abs(state.q[1] - plant.Crane().state.q[1]) > 0.01


def test_sensitivities_are_the_differences_of_neighbouring_runs():
    torques = [200.0, 600.0, 1300.0, -1000.0, 2.0]

    def after(mass: float, length: float) -> np.ndarray:
        crane = plant.Crane(load_mass=mass, tolerance=1e-11)
        q = crane.state.q
        q[3] += length
        crane.reset(q)
        crane.run(torques, 1e-3, 3000)
        return crane.state.q

    found = plant.Crane(load_mass=1e4, tolerance=1e-10).sensitivity(torques, 3.0)
    by_mass = (after(1e4 + 100, 0) - after(1e4 - 100, 0)) / 200
    by_length = (after(1e4, 0.01) - after(1e4, -0.01)) / 0.02
    np.testing.assert_allclose(found.q_by_mass, by_mass, rtol=2e-3, atol=1e-4 * np.abs(by_mass).max())
    np.testing.assert_allclose(found.q_by_length, by_length, rtol=2e-3, atol=1e-5)
    assert np.abs(by_mass[4]) > 0 and np.abs(by_length[4]) > 1e-5


def test_derivatives_that_do_not_contain_an_event_or_the_wind_are_refused():
    torques = [100.0, 800.0, 3155.0, -1000.0, 8.0]
    crane = plant.Crane(load_mass=20e3)
    q = crane.state.q
    q[3] = 59.8
    crane.reset(q, np.array([0.1, 0.02, 0.01, 0.1, 0.0, 0.0, 0.02]))
    with pytest.raises(ValueError, match=r"l reaches its end stop after 0\.\d+ s; expected is a time that ends before"):
        crane.sensitivity(torques, 2.0)
    assert crane.events == [] and crane.state.q[3] == 59.8
    crane.sensitivity(torques, 0.2)
    crane.run(torques, 1e-2, 200)
    with pytest.raises(ValueError, match="one rests in its end stop"):
        crane.sensitivity(torques, 0.1)
    with pytest.raises(ValueError, match="all drives, but one is off"):
        crane.step([math.nan, *torques[1:]], 1e-3)
        crane.sensitivity(torques, 0.1)
    windy = plant.Crane(wind={"mean": 20.0})
    for call in (lambda: windy.sensitivity(torques, 0.1), windy.linearize):
        with pytest.raises(ValueError, match=r"leave the wind out.*got 20"):
            call()


def test_a_torque_that_is_no_number_faults_its_drive_and_the_brake_holds():
    crane = plant.Crane()
    torques = holding(crane)
    torques[1] = 1500.0
    crane.run(torques, 1e-3, 2000)
    assert crane.state.qd[1] > 0.01
    torques[1] = math.nan
    crane.step(torques, 1e-3)
    torques[1] = 1500.0
    crane.run(torques, 1e-3, 8000)
    state = crane.state
    assert crane.faulted == ("slew",) and state.qd[1] == 0.0
    assert np.isfinite(state.q).all() and np.isfinite(state.qd).all()


def test_end_stops_stop():
    crane = plant.Crane(drives=QUIET)
    torques = holding(crane)
    torques[3] = 0.0  # the load runs down
    crane.run(torques, 1e-2, 1500)
    assert "hoist" in crane.at_limit and crane.state.q[3] == 60.0 and crane.state.qd[3] == 0.0


@pytest.mark.parametrize("end", ["lower", "upper"])
@pytest.mark.parametrize("joint", range(4))
def test_a_joint_stands_at_its_end_to_the_last_bit_and_leaves_it(joint: int, end: str) -> None:
    crane = plant.Crane(load_mass=20e3)
    towards = -1.0 if end == "lower" else 1.0
    stop = list(getattr(crane.parameters, end))[joint]
    q = crane.state.q
    place = (0, 1, 2, 3)[joint]
    q[place] = stop - towards * 1e-3
    crane.reset(q)
    torques = holding(crane)
    held = torques[joint]
    torques[joint] = held + towards * 3000.0
    crane.run(torques, 1e-2, 60)
    assert (crane.state.q[place], crane.state.qd[place]) == (stop, 0.0) and len(crane.at_limit) == 1
    torques[joint] = held - towards * 3000.0
    crane.run(torques, 1e-2, 60)
    assert crane.at_limit == () and towards * (stop - crane.state.q[place]) > 1e-3


@pytest.mark.parametrize("end", ["lower", "upper"])
def test_an_end_is_reached_at_its_instant_whatever_the_step(end: str) -> None:
    towards = -1.0 if end == "lower" else 1.0

    def jib(step: float) -> plant.Crane:
        crane = plant.Crane(load_mass=20e3)
        q = crane.state.q
        q[2] = list(getattr(crane.parameters, end))[2] - towards * 1e-2
        crane.reset(q)
        torques = holding(crane)
        torques[2] += towards * 3000.0
        crane.run(torques, step, round(0.8 / step))
        return crane

    coarse, fine = jib(1e-2), jib(1e-4)
    assert coarse.at_limit == fine.at_limit == ("luff",)
    assert np.abs(coarse.state.q - fine.state.q).max() < 1e-5  # 5e-4, were the blow noticed at the next step


def test_a_step_is_integrated_in_one_go_while_nothing_needs_to_be_looked_at_and_each_millisecond_at_an_end_stop():
    parts = plant.Crane(load_mass=20e3)
    q = parts.state.q
    q[0] = parts.parameters.lower[0] + 1e-3
    parts.reset(q)
    whole = plant.Crane(load_mass=20e3)
    torques = holding(parts)
    torques[0] = -3000.0
    alike = {}
    for _ in range(12):
        whole.restore(parts.snapshot())
        before = parts.at_limit
        whole.step(torques, 1e-2)
        parts.run(torques, 1e-3, 10)
        if before == parts.at_limit:
            alike.setdefault(before, set()).add(
                bytes(whole.state.q) + bytes(whole.state.qd) == bytes(parts.state.q) + bytes(parts.state.qd)
            )
    assert alike == {(): {False}, ("gantry",): {True}}


def test_torques_saturate():
    one, other = plant.Crane(), plant.Crane()
    one.step([1e9] * 5, 0.1)
    other.step(list(one.maximum_torques), 0.1)
    assert (one.state.q == other.state.q).all()


@pytest.mark.parametrize(
    ("config", "says"),
    [
        ({"spreader_mass": -1.0}, "spreader_mass must be positive"),
        ({"jib_mass": math.nan}, "jib_mass must be positive"),
        ({"home": (0, 80, 0, 14, 0)}, "reach"),
        ({"load_mass": 40001.0}, "rated_load"),
        ({"load_mass": -1.0}, "rated_load"),
        ({"jib_length": 3.0}, "no parameter 'jib_length'"),
        ({"drives": {"hook": {}}}, "no joint 'hook'"),
        ({"drives": {"hoist": {"gear": 0.0}}}, "gear must be positive"),
        ({"model": "L9"}, "sway"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"lower": [0.0] * 5, "upper": [0.0] * 5}, "limit"),
    ],
)
def test_an_impossible_crane_is_refused(config, says):
    with pytest.raises(ValueError, match=says):
        plant.Crane(config)


@pytest.mark.parametrize("dt", [-1e-3, math.nan, math.inf, 3600.0])
def test_an_impossible_step_is_refused(dt):
    with pytest.raises(ValueError, match="0 to 60 s"):
        plant.Crane().step([0] * 5, dt)
    with pytest.raises(ValueError, match="0 to 60 s"):
        plant.Scene().step(None, dt)


def test_a_step_of_zero_changes_nothing():
    crane = plant.Crane()
    before = crane.state
    crane.step([100] * 5, 0.0)
    assert (crane.state.q == before.q).all() and crane.state.time_s == 0.0


def test_environment_gives_the_tuples_of_gymnasium():
    target = plant.Crane().payload()
    env = plant.CraneEnv(target + [0.0, 0.0, 1.0], duration=0.05)
    first, info = env.reset(seed=3, options={"sway": 0.1})
    again, _ = env.reset(seed=3, options={"sway": 0.1})
    assert (first == again).all() and first.shape == (17,) and info == {}
    for i in itertools.count(1):
        observation, reward, terminated, truncated, _ = env.step([0, 0, 0.1, -0.2, 0])
        if truncated:
            break
    assert i == 5 and not terminated and reward < 0 and np.isfinite(observation).all()


def test_scene_drives_an_agv_and_its_crane():
    scene = plant.Scene(agvs=2)
    scene.hold(1, 0.5)
    for _ in range(4):
        scene.drive(1, 1.0, 0.0, 0.0)
    start = scene.agv(1).x
    scene.step([0, 1500, 0, 0, 0], 2.0)
    assert scene.agv(1).x > start + 0.3 and scene.ranges(1).shape == (180,) and scene.time_s == 2.0
    kept = scene.snapshot()
    scene.step([0, math.nan, 0, 0, 0], 1.0)
    once = scene.signal.q
    assert all(math.isfinite(x) for x in once)
    scene.restore(kept)
    scene.step([0, math.nan, 0, 0, 0], 1.0)
    assert scene.signal.q == once


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda value: pickle.loads(pickle.dumps(value))])
def test_a_scenes_snapshot_is_copied_and_pickled(again):
    config = plant.default_dock(2)
    config.sensors.range_rate, config.drive_delay = 20.0, 3  # with what only some docks have
    scene, other = plant.Scene(config), plant.Scene(config)
    for it in (scene, other):
        it.drive(1, 1.0, 0.0, 0.0)
        it.step([0, 1500, 3000, 0, 0], 0.3)
    kept = again(scene.snapshot())
    scene.step([0, 900, 3000, 0, 0], 0.2)
    other.step(None, 1.0)
    other.restore(kept)
    other.step([0, 900, 3000, 0, 0], 0.2)
    assert other._dock.state_hash() == scene._dock.state_hash()
    with pytest.raises(ValueError, match="range sensors"):
        plant.Scene(plant.default_dock(2)).restore(kept)


@pytest.mark.parametrize(
    "cut", [lambda text: text[:-1], lambda text: text + b"x", lambda text: text[:400] + b"\xff" * (len(text) - 400)]
)
def test_bytes_that_are_no_snapshot_are_refused(cut):
    state = plant.Scene().snapshot()
    other = type(state).__new__(type(state))
    with pytest.raises(ValueError, match="no snapshot of this version"):
        other.__setstate__(cut(state.__getstate__()))


def test_a_dock_with_a_negative_mass_is_refused():
    config = plant.default_dock()
    config.crane.jib_mass = -5.0
    with pytest.raises(ValueError, match="jib_mass"):
        plant.Scene(config)
