"""cmrc.plant as a user sees it: every part of the dock is public and documented; an AGV by itself; balances of random
cranes; bad values are refused."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from cmrc import plant

PARTS = [
    "AgvParameters", "Box", "ContainerPlace", "CraneParameters", "CranePose", "Dock", "DockConfig", "DriveParameters", "Handover", "LandingParameters", "LaneSegment", "Layout",
    "Linkage", "LinkageParameters", "Momentum", "Mover", "Pose", "SensorParameters", "ShipMotion", "Switch", "Waypoint", "WindParameters",
]  # fmt: skip


@pytest.mark.parametrize("name", PARTS)
def test_every_part_of_the_dock_is_public_and_documented(name: str) -> None:
    assert len((getattr(plant, name).__doc__ or "").split()) >= 3


@pytest.mark.parametrize(
    "name",
    [
        "LandingParameters",
        "AgvParameters",
        "SensorParameters",
        "WindParameters",
        "ShipMotion",
        "Layout",
        "DockConfig",
        "CraneParameters",
    ],
)
def test_configurations_can_be_made(name: str) -> None:
    getattr(plant, name)()


def test_a_scene_of_parts() -> None:
    config = plant.default_dock(2)
    config.layout.movers = [
        plant.Mover(
            0.4,
            1.8,
            [plant.Waypoint(0, 40, 9), plant.Waypoint(5, 45, 9), plant.Waypoint(9, 45, 9), plant.Waypoint(12, 50, 9)],
        )
    ]
    config.agv.drive = plant.AgvDrive.differential
    config.ship.scale, config.wind.mean, config.wind.gust, config.sensors.range_rate = 0.5, 8.0, 1.0, 20.0
    scene = plant.Scene(config)
    scene.step(None, 6.0)
    # Between two waypoints at one place a mover does not move, and the ray straight ahead shows it there.
    assert plant.mover_place(config.layout.movers[0], 7.0) == [45.0, 9.0, 0.0, 0.0]
    assert scene.ranges(0)[90:100].min() == pytest.approx(math.hypot(45 - 29.4, 1.0) - 0.4, abs=0.05)
    assert scene.handover.phase == "free" and scene.switches == []


def test_torques_become_codes_of_12_bits() -> None:
    """Code 2047 is the greatest torque of a drive; what is beyond it is cut."""
    scene = plant.Scene()
    most = [drive.maximum_torque for drive in scene._dock.config.crane.drives]
    for share, code in ((1.0, 2047), (0.5, 1024), (-0.25, -512), (-1.0, -2047), (3.0, 2047), (0.0, 0)):
        scene.step([share * torque for torque in most], 250e-6)
        assert list(scene.signal.code) == [code] * 5


def test_a_scene_without_vehicles_says_so() -> None:
    with pytest.raises(ValueError, match="index: 0 is out of range; a scene with AGVs is expected, this one has none"):
        plant.Scene(agvs=0).agv(0)
    with pytest.raises(ValueError, match="index: 2 is out of range; the number of an AGV, 0 to 1, is expected"):
        plant.Scene(agvs=2).ranges(2)


def test_movers_overshoot_none_of_their_waypoints() -> None:
    rng = np.random.default_rng(4)
    for _ in range(20):
        times, xs = np.cumsum(rng.uniform(0.5, 20, 6)), rng.choice([-5.0, 0.0, 0.0, 7.0], 6) + rng.choice([0.0, 0.3], 6)
        mover = plant.Mover(0.4, 1.8, [plant.Waypoint(t, x, 0.0) for t, x in zip(times, xs)])
        for i in range(5):
            at = [plant.mover_place(mover, t)[0] for t in np.linspace(times[i], times[i + 1], 40)]
            assert min(at) >= min(xs[i : i + 2]) - 1e-9 and max(at) <= max(xs[i : i + 2]) + 1e-9
            assert (np.diff(at) * (xs[i + 1] - xs[i]) >= -1e-9).all()


# ---- an AGV by itself


def test_an_agv_in_a_steady_curve() -> None:
    """Neutral steering on a circle: v / r = base / (tan front - tan rear), with slip angles that carry m v^2 / R."""
    agv = plant.Agv(load_mass=10e3, load_inertia=1e5)
    for _ in range(600):
        agv.step(3.0, 0.1, -0.1, 0.05)
    s = agv.state
    assert s.speed == pytest.approx(3.0, rel=0.02) and s.time_s == pytest.approx(30.0)
    # Both axles slip by m v r / (2 C), which at neutral steering leaves the circle's radius as it is.
    assert s.speed / s.yaw_rate == pytest.approx(4.5 / math.tan(0.1), rel=0.03)
    assert agv.energy() == pytest.approx(0.5 * 35e3 * (s.speed**2 + s.side**2) + 0.5 * 5.8e5 * s.yaw_rate**2)


def test_an_agv_by_itself_drives_as_on_the_dock() -> None:
    scene = plant.Scene(agvs=1)
    at = scene.agv(0)
    agv = plant.Agv(start=(at.x, at.y, at.heading))
    scene.hold(0, 0.05)
    scene.step(None, 0.01)
    for _ in range(100):
        scene.drive(0, 1.5, 0.1, -0.1)
        scene.step(None, 0.05)
        agv.step(1.5, 0.1, -0.1, 0.05)
    there = scene.agv(0)
    assert (agv.state.x, agv.state.y) == pytest.approx((there.x, there.y), abs=0.1)
    assert agv.state.speed == pytest.approx(there.speed, abs=0.03)


def test_a_load_taken_underway_keeps_the_momentum() -> None:
    agv = plant.Agv(drive="differential")
    for _ in range(100):
        agv.step(2.0, 0.0, 0.0, 0.05, turn=0.1)
    before = agv.state
    agv.set_load(30e3, 3e5)
    after = agv.state
    assert 55e3 * after.speed == pytest.approx(25e3 * before.speed) and 7.8e5 * after.yaw_rate == pytest.approx(
        4.8e5 * before.yaw_rate
    )
    kept = agv.snapshot()
    agv.step(2.0, 0.0, 0.0, 0.737)
    one = agv.state
    agv.restore(kept)
    agv.step(2.0, 0.0, 0.0, 0.737)
    assert agv.state == one
    moving = agv.state
    agv.set_load(0.0)  # what is taken off takes its share along
    assert (agv.state.speed, agv.state.yaw_rate) == (moving.speed, moving.yaw_rate)


@pytest.mark.parametrize(
    ("config", "says"),
    [({"mass": -1.0}, "AGV's mass"), ({"wheels": 4}, "no parameter 'wheels'"), ({"drive": "tracks"}, "steered"), ({"load_mass": -5.0}, "load must not be negative"),
     ({"start": (math.nan, 0, 0)}, "pose"), ({"tolerance": 1.0}, "tolerance"), ({"steer_limit": 2.0}, "steer_limit")],
)  # fmt: skip
def test_an_agv_that_cannot_be_is_refused(config: dict[str, object], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        plant.Agv(config)


@pytest.mark.parametrize(
    ("speed", "dt", "says"), [(math.nan, 0.1, "set-point"), (1.0, -0.1, "0 to 60 s"), (1.0, 3600.0, "0 to 60 s")]
)
def test_impossible_steps_of_an_agv(speed: float, dt: float, says: str) -> None:
    agv = plant.Agv()
    with pytest.raises(ValueError, match=says):
        agv.step(speed, 0.0, 0.0, dt)
    agv.step(1.0, 0.0, 0.0, 0.0)
    assert agv.state.time_s == 0.0


def test_the_time_of_an_agv_is_counted_not_added_up() -> None:
    agv = plant.Agv()
    for _ in range(10_000):
        agv.step(0.0, 0.0, 0.0, 0.001)
    assert agv.state.time_s == 10.0


# ---- bad values through the public names


@pytest.mark.parametrize(
    ("config", "says"),
    [({"sway_noise": math.nan}, "sway_noise"), ({"sway_noise": -1.0}, "sway_noise"), ({"jib_mass": "heavy"}, "jib_mass"), ({"home": (0, 12, 16)}, "home .* 5 numbers"),
     ({"load_mass": "full"}, "load_mass"), ({"seed": -1}, "seed"), ({"lower": [0, 1]}, "lower"), ({"drives": {"slew": {"maximum_torque": 1}}}, "maximum_torque")],
)  # fmt: skip
def test_a_cranes_values_of_the_wrong_kind_are_named(config: dict[str, object], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        plant.Crane(config)


@pytest.mark.parametrize(
    ("drives", "error", "says"),
    [
        (3, TypeError, "drives must be {joint: {parameter: value}}, not 3"),
        ({"slew": 3}, TypeError, "the parameters of a drive must be given by name, not 3"),
        ({"s": {}}, ValueError, "there is no joint 's'; the joints are gantry, slew, luff, hoist, rotator"),
    ],
)
def test_drives_are_given_by_joint_and_name(drives: object, error: type[Exception], says: str) -> None:
    with pytest.raises(error) as found:
        plant.Crane(drives=drives)
    assert str(found.value) == says


def test_arrays_of_the_wrong_shape_are_named() -> None:
    crane, scene = plant.Crane(), plant.Scene()
    for torques in ([0.0] * 4, np.zeros((5, 1)), 3.0, None, ["a"] * 5):
        for call in (
            lambda t=torques: crane.step(t, 0.1),
            lambda t=torques: crane.run(t, 0.1, 1),
            lambda t=torques: crane.sensitivity(t, 1.0),
        ):
            with pytest.raises(ValueError, match="five torques are needed"):
                call()
    with pytest.raises(ValueError, match="q must be 7 numbers"):
        crane.reset([0.0] * 6)
    with pytest.raises(ValueError, match="phi = 0 is outside its limits 0.349"):
        crane.reset([0, 0, 0, 20, 0, 0, 0])
    with pytest.raises(ValueError, match="steps"):
        crane.run([0.0] * 5, 0.001, -1)
    with pytest.raises(ValueError, match="torques .* 5 numbers"):
        scene.step([0.0] * 4, 0.1)
    for speed in (math.nan, math.inf, 1e12):
        with pytest.raises(ValueError, match=r"speed \(m/s\)"):
            scene.drive(0, speed, 0.0, 0.0)
    with pytest.raises(ValueError, match="seconds must be"):
        scene.hold(0, -1.0)
    with pytest.raises(ValueError, match="waypoint"):
        plant.mover_place(plant.Mover(0.3, 1.8, []), 1.0)


# ---- the environment


def rolled_out(environment: plant.CraneEnv, seed: int) -> bytes:
    rng = np.random.default_rng(1)
    seen = [environment.reset(seed=seed, options={"sway": 0.2})[0]]
    for _ in range(20):
        observation, reward, *_ = environment.step(rng.uniform(-0.3, 0.3, 5))
        assert environment.observation_space.contains(observation)
        seen.append(np.append(observation, reward))
    return np.concatenate(seen).tobytes()


def test_an_environment_has_spaces_and_repeats_itself() -> None:
    environment = plant.CraneEnv(target=(10.0, 12.0, 10.0))
    assert environment.action_space.shape == (5,) and environment.observation_space.shape == (17,)
    assert environment.action_space.contains(environment.action_space.sample())
    first = rolled_out(environment, 3)
    assert (
        first
        == rolled_out(environment, 3)
        == rolled_out(plant.CraneEnv(target=(10.0, 12.0, 10.0)), 3)
        != rolled_out(environment, 4)
    )
    drawn = [plant.CraneEnv(target=(10.0, 12.0, 10.0)).reset(options={"sway": 0.1})[0][4] for _ in range(2)]
    assert drawn[0] == drawn[1] != 0.0


def test_an_environment_is_one_of_gymnasiums() -> None:
    checker = pytest.importorskip("gymnasium.utils.env_checker")
    checker.check_env(plant.CraneEnv(target=(10.0, 12.0, 10.0)), skip_render_check=True)


@pytest.mark.parametrize(
    ("call", "says"),
    [(lambda: plant.CraneEnv(target=(1, 2)), "target"), (lambda: plant.CraneEnv(target=(1, 2, 3), dt=-1), "dt"), (lambda: plant.CraneEnv(target=(1, 2, 3), duration=math.nan), "duration"),
     (lambda: plant.CraneEnv(target=(1, 2, 3)).step([0] * 4), "action"), (lambda: plant.CraneEnv(target=(1, 2, 3)).reset(options={"swing": 1.0}), "swing"),
     (lambda: plant.CraneEnv(target=(1, 2, 3)).reset(options={"sway": 1.0}), "40 degrees")],
)  # fmt: skip
def test_an_environment_names_what_is_wrong(call: Callable[[], object], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        call()


# ---- bad docks through the public names


def test_containers_heavier_than_rated_and_things_inside_each_other() -> None:
    config = plant.default_dock(1)
    place = config.layout.containers[0]
    config.layout.containers = [plant.ContainerPlace(place.x, place.y, place.z, 0.0, 60e3)]
    with pytest.raises(ValueError, match="too heavy for the crane: to hold 60000 kg"):
        plant.Scene(config)
    config = plant.default_dock(1)
    config.layout.movers = [
        plant.Mover(0.5, 2.0, [plant.Waypoint(0, 60, 0)]),
        plant.Mover(0.5, 2.0, [plant.Waypoint(0, 60.3, 0)]),
    ]
    with pytest.raises(ValueError, match="inside each other"):
        plant.Scene(config)


@pytest.mark.parametrize("bad", [[math.nan] * 5, [math.inf, 0, 0, 0, 0]])
def test_torques_that_are_no_numbers_leave_a_scene_finite(bad: list[float]) -> None:
    scene = plant.Scene()
    scene.step(bad, 1.0)
    assert np.isfinite(scene.signal.q).all() and np.isfinite(scene.energy())


# ---- balances of cranes whose parameters are not in the tree


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("gear_losses", [False, True])
def test_energy_of_random_cranes_is_what_went_in_less_what_was_lost(seed: int, gear_losses: bool) -> None:
    rng = np.random.default_rng(seed)
    names = ["jib_mass", "gantry_mass", "counterweight", "slew_inertia", "jib_inertia", "spreader_mass"]
    default = plant.CraneParameters()
    config = {name: getattr(default, name) * rng.uniform(0.5, 1.8) for name in names}
    crane = plant.Crane(config, load_mass=rng.uniform(0, 38e3), bookkeeping=True, gear_losses=gear_losses, tolerance=1e-10,
                        drives={j: {"efficiency": rng.uniform(0.7, 0.95)} for j in plant.JOINTS})  # fmt: skip
    start = crane.energy()
    for _ in range(8):
        gravity = np.asarray(crane.bias())[list(plant.ACTUATED)]
        torques = [
            (g * rng.uniform(0.9, 1.1)) / (d.gear * d.efficiency) for g, d in zip(gravity, crane.parameters.drives)
        ] + rng.uniform(-0.2, 0.2, 5) * crane.maximum_torques
        crane.step(torques, 0.5)
    w = crane.work
    gained = w.motors - w.gears - w.friction - w.damping + w.external - w.impacts
    assert crane.energy() - start == pytest.approx(gained, abs=2e-7 * abs(w.motors) + 1.0)
    assert w.friction > 0 and w.damping > 0


def test_gears_lose_in_both_directions_when_asked_to() -> None:
    """A load that drives its hoist: held by torque x gear / efficiency; lowering at the balance of 1.3 as printed gains
    energy in the gear, which no gear does."""
    for losses in (False, True):
        crane = plant.Crane(
            load_mass=30e3, gear_losses=losses, bookkeeping=True, drives={"hoist": {"coulomb": 0.0, "viscous": 0.0}}
        )
        drive = crane.parameters.drives[3]
        weight = 40e3 * 9.81
        factor = 1 / drive.efficiency if losses else drive.efficiency
        luff = crane.bias()[2] / (crane.parameters.drives[2].gear * crane.parameters.drives[2].efficiency)
        crane.step(
            [0, 0, luff, -0.9 * weight / (drive.gear * factor), 0], 0.5
        )  # gives way by a tenth, and gathers speed
        qd = crane.state.qd[3]
        assert qd > 0.05
        gear = crane.work.gears
        crane.step([0, 0, luff, -weight / (drive.gear * factor), 0], 2.0)  # now in balance: the speed stays
        assert crane.state.qd[3] == pytest.approx(qd, rel=0.05)
        assert (crane.work.gears > gear) == losses


def test_a_linkage_by_its_public_name() -> None:
    linkage = plant.Linkage(plant.LinkageParameters())
    linkage.place(1.0)
    linkage.advance(linkage.holding_torque, 1.0)
    assert np.abs(linkage.rates).max() < 1e-6 and linkage.open < 1e-7
    bad = plant.LinkageParameters()
    bad.jib_mass = -1.0
    with pytest.raises(ValueError, match="positive"):
        plant.Linkage(bad)


def test_an_episode_does_not_end_while_the_load_rushes_past_its_target() -> None:
    """Without torque the drives let the load fall: after 0.1 s it is still there, and faster than 5 cm/s."""
    start = plant.CraneEnv(target=(0.0, 0.0, 0.0)).crane.payload()
    env = plant.CraneEnv(target=start.tolist())
    env.reset(seed=1)
    for _ in range(100):
        _, _, terminated, _, info = env.step([0.0] * 5)
        if info["speed_m_s"] > 0.05:
            break
    assert info["way_m"] < 0.1 and not terminated
    env.reset(seed=1)
    assert env.step([0.0] * 5)[2]  # at rest it is there


def test_a_step_of_the_environment_is_a_minute_at_most() -> None:
    assert plant.CraneEnv(target=(14.0, 18.0, 10.0), dt=60.0).dt == 60.0
    for dt in (0.0, 60.1):
        with pytest.raises(ValueError, match=f"dt must be above 0, at most 60 s .got {dt}."):
            plant.CraneEnv(target=(14.0, 18.0, 10.0), dt=dt)
