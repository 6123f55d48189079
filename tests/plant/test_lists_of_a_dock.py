"""A list of a dock's configuration is given back as a tuple of copies, and assigned whole."""

import copy
import pickle
import subprocess
import sys

import pytest
from cmrc import plant
from locations import BUILD

MEMBERS = {
    "crane.drives": lambda c: c.crane.drives,
    "crane.lower": lambda c: c.crane.lower,
    "crane.upper": lambda c: c.crane.upper,
    "layout.rows": lambda c: c.layout.rows,
    "layout.containers": lambda c: c.layout.containers,
    "layout.no_go": lambda c: c.layout.no_go,
    "layout.movers": lambda c: c.layout.movers,
    "layout.legs": lambda c: c.layout.legs,
    "layout.legs[0]": lambda c: c.layout.legs[0],
    "layout.movers[0].path": lambda c: c.layout.movers[0].path,
}


def dock() -> plant.DockConfig:
    config = plant.default_dock(1)
    config.layout.movers = [plant.Mover(0.3, 2.0, [plant.Waypoint(0, 33.0, 8.9), plant.Waypoint(1, 34.0, 8.9)])]
    config.layout.no_go = [plant.Box(40, 41, -40, -39, 0, 1)]
    return config


@pytest.mark.parametrize("member", MEMBERS)
def test_a_list_is_a_tuple(member):
    given = MEMBERS[member](dock())
    assert type(given) is tuple and given
    with pytest.raises(TypeError):
        given[0] = given[0]
    assert not hasattr(given, "append")


def test_an_element_is_a_copy():
    config = dock()
    first, mover, drive = config.layout.containers[0], config.layout.movers[0], config.crane.drives[0]
    waypoint, segment = mover.path[1], config.layout.legs[0][0]
    before = first.mass, mover.radius, drive.gear, waypoint.x, segment.x
    first.mass, mover.radius, drive.gear, waypoint.x, segment.x = 1.0, 9.0, 99.0, 7.0, 8.0
    mover.repeats = True
    assert before == (
        config.layout.containers[0].mass,
        config.layout.movers[0].radius,
        config.crane.drives[0].gear,
        config.layout.movers[0].path[1].x,
        config.layout.legs[0][0].x,
    )


def test_a_list_is_assigned_whole():
    config = dock()
    places = list(config.layout.containers)
    places[0], places[1] = places[1], places[0]
    places[0].mass = 12e3
    config.layout.containers = places
    assert config.layout.containers[0].mass == 12e3
    assert [p.x for p in places] == [p.x for p in config.layout.containers]
    config.crane.drives = config.crane.drives
    config.crane.lower = [-1, *config.crane.lower[1:]]
    assert config.crane.lower[0] == -1.0
    again = pickle.loads(pickle.dumps(config))
    for same in (copy.copy(config), copy.deepcopy(config), again):
        assert same.crane.lower == config.crane.lower and same.layout.movers[0].path[1].x == 34.0
        assert [len(leg) for leg in same.layout.legs] == [len(leg) for leg in config.layout.legs]


def test_a_wrong_value_is_named():
    config = dock()
    with pytest.raises(
        TypeError, match=r"^DockConfig.drive_delay: 'x' \(str\) cannot be used; a whole number is expected"
    ):
        config.drive_delay = "x"
    with pytest.raises(
        TypeError, match=r"^Layout.containers: 3 \(int\) cannot be used; .*ContainerPlace.* is expected"
    ):
        config.layout.containers = 3
    with pytest.raises(TypeError, match="^CraneParameters.lower: .* cannot be used"):
        config.crane.lower = [1.0]


def test_a_part_belongs_to_its_whole():
    config = dock()
    ship, wind = config.layout.ship, config.wind
    ship.x_min, wind.mean = -99.0, 3.0
    assert (config.layout.ship.x_min, config.wind.mean) == (-99.0, 3.0)
    del config
    assert (ship.x_min, wind.mean) == (-99.0, 3.0)


AFTER_ITS_LIST = """
from cmrc import plant
mover = plant.Mover(1., 2., [plant.Waypoint(float(i), 1., 1.) for i in range(10_000)])
last = mover.path[-1]
mover.path = [plant.Waypoint(float(i), 1., 1.) for i in range(40_000)]
config = plant.default_dock(1)
place = config.layout.containers[0]
config.layout.containers = [plant.ContainerPlace(1., 2., 3., 4., 5.)] * 100
junk = [bytearray(b"\\x41" * n) for n in range(280, 330) for _ in range(50)]
place.mass = -1.0
print(last.time, place.x, sum(j.count(0x41) != len(j) for j in junk))
"""


def test_an_element_outlives_its_list():
    path = f"import sys; sys.path.insert(0, {str(BUILD / 'python')!r})\n"
    done = subprocess.run(
        [sys.executable, "-c", path + AFTER_ITS_LIST], capture_output=True, text=True, timeout=60, check=False
    )
    place = plant.default_dock(1).layout.containers[0]
    assert (done.returncode, done.stdout.split()) == (0, ["9999.0", str(place.x), "0"]), done.stderr
