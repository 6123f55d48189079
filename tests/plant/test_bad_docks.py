"""Docks that cannot be are refused with the name of what is wrong; bad commands have the answer of docs/plant.md."""

import math

import pytest
from cmrc import plant as public
from cmrc._core import plant


def box(x, y):
    return plant.Box(x - 1, x + 1, y - 1, y + 1, 0.0, 2.0)


def place(container, **changes):
    values = {name: getattr(container, name) for name in ("x", "y", "z", "yaw", "mass")}
    return plant.ContainerPlace(**{**values, **changes})


def first_container(config, **changes):
    containers = config.layout.containers
    config.layout.containers = [place(containers[0], **changes), *containers[1:]]


def rotor(config, joint, inertia):
    drives = config.crane.drives
    drives[joint].rotor_inertia = inertia
    config.crane.drives = drives


def boxes(config, *where):
    config.layout.no_go = [box(*at) for at in where]


def movers(config, *path):
    config.layout.movers = [plant.Mover(1.0, 2.0, [plant.Waypoint(*at) for at in path])]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda c: first_container(c, mass=-1.0), "container 0's mass must be positive"),
        (lambda c: first_container(c, mass=math.nan), "container 0's mass must be positive"),
        (
            lambda c: first_container(c, mass=40001.0),
            "container 0 weighs 40001 kg, more than the crane's rated_load of 40000 kg",
        ),
        (lambda c: first_container(c, x=12.0), r"container 0 and container 1 are inside each other"),
        (lambda c: first_container(c, y=60.0), "cannot reach container 0"),
        (lambda c: first_container(c, z=math.inf), "container 0 needs a place"),
        (lambda c: boxes(c, (40, -40), (41.5, -40)), "box 0 and box 1 are inside each other"),
        (lambda c: boxes(c, (22, 8)), "box 0 and AGV 0 are inside each other"),
        (lambda c: setattr(c.layout, "spot", plant.Pose(22, 19, 0)), "AGV 0 and the ship are inside each other"),
        (lambda c: movers(c, (0, 0, 28)), "mover 0 and the ship are inside each other"),
        (
            lambda c: setattr(c.crane.portal, "waterside", 32.0),
            r"the crane's leg \d and the ship are inside each other",
        ),
        (
            lambda c: movers(c, (-10, 100, 100), (0, 22, 8), (10, -100, 100)),
            r"mover 0 and AGV 0 are inside each other, at \(22.00, 8.00\)",
        ),
        (lambda c: setattr(c.layout, "no_go", [plant.Box(1, 0, 0, 1, 0, 1)]), "box 0 needs min < max"),
        (lambda c: first_container(c, z=12.0), "container 0 must stand on something: its underside is at 12.000 m"),
        (lambda c: first_container(c, z=0.0), "container 0 must stand on something: .* ends at 3.909 m"),
        (lambda c: setattr(c, "home", plant.CranePose(0, 12, 24, 4.0, 0)), "home .* is inside container"),
        (lambda c: setattr(c, "home", plant.CranePose(0, 24.9, 20.5, 3.0, 0)), "home .* is inside the ship"),
        (lambda c: setattr(c, "home", plant.CranePose(0, 12, 16, -1.0, 0)), "home must be above the ground"),
        (
            lambda c: setattr(c.layout, "spot", plant.Pose(22, math.nan, 0)),
            "spot and warehouse must be poses of numbers",
        ),
        (lambda c: setattr(c.layout, "rows", [math.nan]), "a row's place must be a number"),
        (lambda c: setattr(c.layout, "spot", plant.Pose(90.0, 8.0, 0.0)), "cannot reach the loading spot"),
        (lambda c: setattr(c, "home", plant.CranePose(0, 60, 60, 5, 0)), "the jib reaches"),
        (lambda c: setattr(c.crane, "jib", 15.0), "reach"),
        (lambda c: setattr(c.crane, "spreader_mass", -1.0), "spreader_mass must be positive"),
        (lambda c: rotor(c, 3, 0.0), "the hoist's rotor_inertia must be positive"),
        (lambda c: rotor(c, 4, 0.0), "the rotator's rotor_inertia must be positive"),
        (lambda c: setattr(c.agv, "mass", 0.0), "an AGV's mass must be positive"),
        (lambda c: setattr(c.agv, "steer_limit", 2.0), "steer_limit"),
        (lambda c: setattr(c.landing, "corner_stiffness", -1e7), "corner_stiffness must be positive"),
        (lambda c: setattr(c.landing, "away", 0.1), "away must be more than its near"),
        (lambda c: setattr(c.landing, "friction", math.nan), "friction must not be negative"),
        (lambda c: setattr(c.wind, "mean", 1e4), "wind's mean"),
    ],
)
def test_refused(change, says):
    config = plant.default_dock()
    change(config)
    with pytest.raises(ValueError, match=says):
        plant.Dock(config)


def test_a_mover_may_begin_where_a_vehicle_stands_as_long_as_it_has_left_that_place_at_the_start():
    config = plant.default_dock()
    movers(config, (-10, 22, 8), (0, 22, -8), (10, 22, -8))
    plant.Dock(config)


def test_slots_too_near_for_the_vehicles():
    config = plant.default_dock(3)
    config.layout.slot_spacing = 10.0
    with pytest.raises(ValueError, match="AGV 0 and AGV 1 are inside each other"):
        plant.Dock(config)


def test_an_infinite_torque_faults_the_drive_and_the_dock_stays_finite():
    scene = public.Scene()
    scene.step([0, 1500, 0, 0, 0], 1.0)
    for bad in (math.nan, math.inf, -math.inf):
        scene.step([0, bad, 0, 0, 0], 2.0)
        assert all(map(math.isfinite, [*scene.signal.q, *scene.signal.qd, *scene.signal.payload]))
    assert abs(scene.signal.qd[1]) < 1e-12  # the brake holds


@pytest.mark.parametrize("code", [2**31 - 1, -(2**31)])
def test_codes_of_any_size_are_clamped(code):
    dock = plant.Dock(plant.default_dock())
    dock.enable_drives(31, 0)
    dock.set_torque_code(1, code, 0)
    dock.agv_push(0, code, code, code, 0)
    dock.advance_to(10**12)
    assert all(map(math.isfinite, [*dock.signal.q, dock.agv(0).x, dock.agv(0).speed]))
