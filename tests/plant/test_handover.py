"""The hand-over of a container: its phases, the limits of the tolerances, retries, and the effect of each phase on
energy and momentum."""

import numpy as np
import pytest
from cmrc._core import plant
from controller import Crane, quiet_dock

TOP = 6.5  # m, of the container at x = 12.7


def land(dx=0.0, dy=0.0, yaw=0.0, seconds=3.0, **landing):
    """Lands beside the only container's place by (dx, dy), turned by yaw."""
    config = quiet_dock(above=(12.7 + dx, 24 + dy), z=TOP + 0.3, yaw=yaw)
    config.layout.containers = [config.layout.containers[1]]
    for name, value in landing.items():
        setattr(config.landing, name, value)
    dock = plant.Dock(config)
    crane = Crane(dock)
    crane.hold(0.3)
    crane.move(crane.pose(12.7 + dx, 24 + dy, TOP - 0.08, yaw), seconds)
    crane.hold(0.8)
    return dock, crane


# Castings seat within 25 mm, guides catch up to 150 mm; a yaw of 25 mm over the 6.1 m to a corner is 4.1 mrad, of 150
# mm 24.6 mrad.
@pytest.mark.parametrize(
    ("offset", "guides", "lands"),
    [
        ({"dy": 0.024}, False, True), ({"dy": 0.026}, False, False), ({"dx": -0.024}, False, True), ({"dx": 0.026}, False, False),
        ({"yaw": 0.0038}, False, True), ({"yaw": 0.0044}, False, False), ({"dy": 0.14}, True, True), ({"dy": 0.16}, True, False),
        ({"dx": 0.16}, True, False), ({"yaw": 0.02}, True, True), ({"yaw": 0.026}, True, False),
        ({"dy": 0.1485}, True, True), ({"dy": 0.1515}, True, False), ({"dx": -0.1485}, True, True),
        ({"dx": -0.1515}, True, False),
    ],
)  # fmt: skip
def test_the_edges_of_the_tolerances(offset, guides, lands):
    dock, crane = land(**offset, guides=guides)
    assert (dock.spreader_status(crane.t) & 0xF == 0xF) == lands
    assert dock.handover.phase == ("landed" if lands else "align") and dock.handover.attempts == 1


def test_a_missed_landing_is_tried_again():
    dock, crane = land(dy=0.16)
    for at in ((12.7, 24.16, TOP + 0.25), (12.7, 24.0, TOP + 0.25), (12.7, 24.0, TOP - 0.08)):
        crane.move(crane.pose(*at), 3.0)
        crane.hold(1.0)
    missed = [event for event in dock.events if event.kind == "missed"]
    assert [event.index for event in missed] == [1]
    assert dock.handover.phase == "landed" and dock.handover.attempts == 2
    assert [event.kind for event in dock.events].count("touch") == 2


def test_a_load_near_contact_pulls_at_the_drives_as_one_that_hangs():
    """Near contact the load is a body on four falls; before, the crane's equations have it. The crane stands, out of
    reach of the container at first, then above it."""
    config = quiet_dock(above=(12.7, 24), z=TOP + 2.0)
    config.layout.containers = [config.layout.containers[1]]
    dock = plant.Dock(config)
    crane = Crane(dock)
    torques = []
    for above, phase in ((2.0, "free"), (0.2, "align")):
        crane.move(crane.pose(12.7, 24, TOP + above), 4.0)
        crane.hold(3.0)
        assert dock.handover.phase == phase
        torques.append(np.array(dock.signal.torque))
    assert torques[0][3] < -1000 and torques[0][2] > 1000  # the hoist and the luff carry the load
    assert np.allclose(torques[1], torques[0], rtol=0.03, atol=2)


@pytest.mark.parametrize(("seconds", "accepted"), [(3.0, True), (1.0, False)])
def test_a_strict_landing_refuses_a_hard_touch(seconds, accepted):
    dock, crane = land(seconds=seconds, strict=True)
    touch = next(event for event in dock.events if event.kind == "touch")
    assert (touch.values[0] <= dock.config.landing.touch_speed) == accepted
    dock.spreader_command(1, crane.t)
    crane.hold(1.0)
    assert bool(dock.spreader_status(crane.t) & 0x10) == accepted


@pytest.fixture(scope="module")
def taken():
    """Lands on the container, takes it, lifts it clear, sets it down again and leaves it. Returns the dock and the
    phases seen."""
    dock, crane = land()
    phases = ["free"]

    def see():
        h = dock.handover
        if phases[-1] != h.phase:
            phases.append(h.phase)

    def act(seconds):
        for _ in range(round(seconds / 0.01)):
            crane.hold(0.01)
            see()

    def move(z, seconds):
        crane.move(crane.pose(12.7, 24.0, z), seconds, stop=lambda: see())
        see()

    see()
    dock.spreader_command(1, crane.t)
    act(1.0)
    move(TOP + 0.7, 4.0)
    act(0.5)
    move(TOP - 0.12, 5.0)
    act(0.8)
    dock.spreader_command(0, crane.t)
    act(1.2)
    move(TOP + 0.7, 3.0)
    act(0.5)
    return dock, phases


def test_the_phases_come_in_order_and_back(taken):
    _, phases = taken
    once = ["landed", "lock", "tension", "lift", "free"]
    assert phases == ["free", *once, "align", *once]


def test_every_switch_keeps_its_books(taken):
    dock, _ = taken
    books = dock.switches
    assert [entry.kind for entry in books] == [
        "near_contact",
        "locked",
        "free_again",
        "near_contact",
        "opened",
        "free_again",
    ]
    assert [entry.container for entry in books] == [-1, 0, 0, 0, 0, -1]
    for entry in books:
        size = max(abs(entry.before.slewing), 1.0)
        if entry.kind in ("near_contact", "free_again"):  # between the levels nothing of the whole's momentum is lost
            assert entry.after.travel == pytest.approx(entry.before.travel, abs=1e-6)
            assert entry.after.slewing == pytest.approx(entry.before.slewing, abs=1e-8 * size)
            weight = 9.81 * (30e3 if entry.container >= 0 else 10e3)
            assert abs(entry.energy_after - entry.energy_before) < 0.03 * weight
        if entry.kind == "locked":  # a container at rest joins: momentum stays
            assert entry.after.payload == pytest.approx(entry.before.payload, rel=1e-9, abs=1e-9)
    attached = next(entry for entry in books if entry.kind == "locked")
    box = dock.config.layout.containers[0]
    middle = 9.81 * box.mass * box.z  # of the payload's underside, with the container's mass
    assert attached.energy_after - attached.energy_before > middle


@pytest.mark.parametrize("turned", [0.0, np.pi, -np.pi])
def test_a_container_is_taken_with_either_end_ahead(turned):
    """Both ends are alike: its yaw is that of the spreader, not of the half turn beyond."""
    config = quiet_dock(above=(12.7, 24), z=TOP + 0.3)
    stands = config.layout.containers[1]
    config.layout.containers = [plant.ContainerPlace(stands.x, stands.y, stands.z, turned, stands.mass)]
    dock = plant.Dock(config)
    crane = Crane(dock)
    crane.hold(0.3)
    crane.move(crane.pose(12.7, 24.0, TOP - 0.08), 3.0)
    crane.hold(0.8)
    for command, state in ((1, "carried"), (0, "on_ship")):
        dock.spreader_command(command, crane.t)
        crane.hold(1.2)
        assert dock.containers[0].state == state and abs(dock.containers[0].yaw) < 1e-3


def spreader_on_a_container(lock_time, beside=0.0):
    """The container is on the vehicle's deck, but not yet the vehicle's load; the spreader rests on it with its locks
    open."""
    y = 8.0 + beside
    config = plant.default_dock()
    config.layout.containers = [plant.ContainerPlace(22.0, y, 1.6, 0.0, 20e3)]
    config.home = plant.CranePose(0.0, 22.0, y, 4.191 + 0.3, 0.0)
    config.landing.lock_time = lock_time
    dock = plant.Dock(config)
    crane = Crane(dock)
    crane.hold(0.2)
    crane.move(crane.pose(22.0, y, 4.191 - 0.08), 3.0)
    crane.hold(0.5)
    return dock, crane


def test_a_load_keeps_its_place_on_a_vehicle_that_turns():
    dock, crane = spreader_on_a_container(lock_time=0.1, beside=0.02)
    for command in (1, 0):
        dock.spreader_command(command, crane.t)
        crane.hold(0.5)
    crane.move(crane.pose(22.0, 8.02, 6.0), 3.0)
    places, headings = [], []
    dock.agv_period(0, 1_000_000, crane.t)
    for _ in range(20):
        dock.agv_push(0, 1500, 500_000, 0, crane.t)
        crane.hold(0.2)
        box, agv = dock.containers[0], dock.agv(0)
        away = complex(box.x - agv.x, box.y - agv.y) * np.exp(-1j * agv.heading)
        places.append([away.real, away.imag, box.yaw - agv.heading])
        headings.append(agv.heading)
    assert dock.containers[0].state == "on_agv" and max(np.abs(headings)) > 0.2
    assert np.ptp(places, axis=0) == pytest.approx([0, 0, 0], abs=1e-9) and abs(places[0][1] - 0.02) < 0.005


def test_a_rolling_vehicle_shares_its_momentum_with_the_container_set_on_it():
    dock, crane = spreader_on_a_container(lock_time=0.3)
    dock.spreader_command(1, crane.t)
    crane.hold(0.5)
    assert dock.containers[0].state == "carried"
    dock.spreader_command(0, crane.t)
    dock.agv_period(0, 1_000_000, crane.t)
    dock.agv_push(0, 300, 0, 0, crane.t)
    speeds = []
    while dock.containers[0].state == "carried" and len(speeds) < 500:
        speeds.append(dock.agv(0).speed)
        crane.hold(0.001)
    assert dock.containers[0].state == "on_agv" and speeds[-1] > 0.02
    set_down = next(entry for entry in dock.switches if entry.kind == "opened")
    resting = set_down.before.payload[0] / 30e3  # m/s, the container's own small speed
    assert dock.agv(0).speed == pytest.approx((25e3 * speeds[-1] + 20e3 * resting) / 45e3, abs=5e-4)

    dock.spreader_command(
        1, crane.t
    )  # and taken off again underway: vehicle and container keep their speed, the spreader is dragged along
    speeds = []
    while dock.containers[0].state == "on_agv" and len(speeds) < 500:
        speeds.append(dock.agv(0).speed)
        crane.hold(0.001)
    taken = dock.switches[-1]
    assert taken.kind == "locked" and dock.agv(0).speed == pytest.approx(speeds[-1], abs=2e-3)
    joined = taken.before.payload[0] + 20e3 * speeds[-1]
    assert taken.after.payload[0] == pytest.approx(joined, abs=20e3 * 2e-3) and abs(taken.after.payload[0]) > 1000


def turning_vehicle(front):
    """A container on a vehicle that turns under it: front wheels one way, rear wheels the other, the locks closing."""
    dock, crane = spreader_on_a_container(lock_time=0.4)
    for command in (1, 0):  # taken and set down again: now it is the vehicle's load
        dock.spreader_command(command, crane.t)
        crane.hold(0.7)
    assert dock.containers[0].state == "on_agv"
    dock.agv_period(0, 1_000_000, crane.t)
    dock.agv_push(0, 600, front, -front, crane.t)
    dock.spreader_command(1, crane.t)
    return dock, crane


@pytest.mark.parametrize("front", [500_000, -500_000])
def test_a_container_taken_off_a_turning_vehicle_brings_its_spin(front):
    """Its moment of inertia, m (L^2 + B^2) / 12, times the vehicle's yaw rate is what the spreader gains in spin."""
    dock, crane = turning_vehicle(front)
    rows = []
    while dock.containers[0].state == "on_agv" and len(rows) < 800:
        rows.append([dock.time * 1e-12, dock.agv(0).heading, dock.agv(0).speed])
        crane.hold(0.001)
    taken = dock.switches[-1]
    assert taken.kind == "locked"
    t, heading, speed = np.array(rows[-20:]).T
    rate = np.polyfit(t - taken.time * 1e-12, heading, 3)[2]
    inertia = 20e3 * (12.192**2 + 2.438**2) / 12
    gained = taken.after.spin - taken.before.spin
    assert gained == pytest.approx(inertia * rate, rel=0.01) and gained * front > 0
    assert abs(gained) > abs(taken.before.spin) > 0  # the spreader had a spin of its own, and keeps it
    assert taken.after.payload[0] - taken.before.payload[0] == pytest.approx(20e3 * speed[-1], rel=1e-4)


@pytest.mark.parametrize(("radius", "takes"), [(1.001, True), (0.999, False)])
def test_the_warehouse_takes_what_stands_within_its_radius_for_its_time(radius, takes):
    """A vehicle that is loaded 1 m beside the warehouse's middle: the container is gone 0.25 s later, at a step of 1
    ms."""
    config = plant.default_dock()
    config.layout.containers = [plant.ContainerPlace(22.0, 8.0, 1.6, 0.0, 20e3)]
    config.layout.warehouse = plant.Pose(22.0, 9.0, 0.0)
    config.layout.warehouse_radius, config.layout.warehouse_take = radius, 0.25
    config.home = plant.CranePose(0.0, 22.0, 8.0, 4.191 + 0.3, 0.0)
    config.landing.lock_time = 0.1
    dock = plant.Dock(config)
    crane = Crane(dock)
    crane.hold(0.2)
    crane.move(crane.pose(22.0, 8.0, 4.191 - 0.08), 3.0)
    crane.hold(0.5)
    for command, seconds in ((1, 0.2), (0, 1.0)):
        dock.spreader_command(command, crane.t)
        crane.hold(seconds)
    times = {event.kind: event.time for event in dock.events if event.kind in ("agv_arrived", "delivered")}
    assert set(times) == ({"agv_arrived", "delivered"} if takes else set())
    assert not takes or times["delivered"] - times["agv_arrived"] == 250_000_000_000
    assert dock.containers[0].state == ("delivered" if takes else "on_agv")
    assert dock.delivered == int(takes)


@pytest.mark.parametrize("height", [0.5, 1.4, 2.2])
def test_a_vehicle_does_not_collide_with_what_is_set_on_it(height):
    """The container settles a little into its deck."""
    config = quiet_dock(above=(22, 13), z=2.9)
    config.agv.deck_height = height
    config.crane.sway_damping = 0.4
    config.layout.containers = [plant.ContainerPlace(22, 13, 0, 0, 8e3)]
    dock = plant.Dock(config)
    crane = Crane(dock, period_ms=10)
    crane.hold(0.3)
    crane.move(crane.pose(22, 13, 2.51), 3.0)
    crane.hold(0.8)
    dock.spreader_command(1, crane.t)
    crane.hold(1.2)
    crane.move(crane.pose(22, 13, 7.0), 8.0)
    crane.move(crane.pose(22, 8, 7.0), 12.0)
    crane.hold(6.0)
    crane.move(crane.pose(22, 8, height + 2.7), 8.0)
    crane.hold(3.0)
    crane.move(crane.pose(22, 8, height + 2.5), 3.0)
    crane.hold(0.8)
    dock.spreader_command(0, crane.t)
    crane.hold(1.5)
    assert dock.containers[0].state == "on_agv"
    vehicle = dock.agv(0)
    assert (vehicle.x, vehicle.y) == pytest.approx((22, 8), abs=1e-9)
    assert not [event for event in dock.events if event.kind == "collision"]


def to_and_fro(crane, start, end):
    """Up from one place and down on another one, (x, y, height of the spreader), each after a rest."""
    crane.move(crane.pose(*start[:2], start[2] + 0.7), 5.0)
    crane.move(crane.pose(*start[:2], 9.0), 12.0)
    crane.move(crane.pose(*end[:2], 9.0), 20.0)
    crane.hold(8.0)
    crane.move(crane.pose(*end[:2], end[2] + 0.15), 12.0)
    crane.hold(4.0)
    crane.move(crane.pose(*end[:2], end[2] - 0.12), 4.0)
    crane.hold(1.0)


def test_the_locks_do_not_open_over_what_a_vehicle_carries():
    """What is set on a vehicle's load would hang in the air once the vehicle drives off."""
    config = plant.default_dock()
    config.crane.portal.leg = 0.0
    config.crane.sway_damping = 0.4
    config.layout.containers = [plant.ContainerPlace(22, y, z, 0, 8e3) for y, z in ((8, 1.6), (13, 0))]
    config.home = plant.CranePose(0.0, 22.0, 8.0, 4.191 + 0.3, 0.0)
    dock = plant.Dock(config)
    crane = Crane(dock, period_ms=10)
    crane.hold(0.2)
    crane.move(crane.pose(22.0, 8.0, 4.191 - 0.08), 3.0)
    crane.hold(0.5)
    for command in (1, 0):
        dock.spreader_command(command, crane.t)
        crane.hold(1.2)
    assert dock.containers[0].state == "on_agv"
    to_and_fro(crane, (22, 8, 4.191), (22, 13, 2.591))
    dock.spreader_command(1, crane.t)
    crane.hold(1.2)
    to_and_fro(crane, (22, 13, 2.591), (22, 8, 1.6 + 2 * 2.591))
    assert dock.spreader_status(crane.t) & 0xF == 0xF
    dock.spreader_command(0, crane.t)
    crane.hold(2.0)
    assert dock.spreader_status(crane.t) & 0x1F == 0x1F and dock.containers[1].state == "carried"
    assert "refused" not in [event.kind for event in dock.events]
    to_and_fro(
        crane, (22, 8, 1.6 + 2 * 2.591), (22, 17, 2.591)
    )  # the command waits for a place where the container can stay
    crane.hold(1.2)
    assert dock.containers[1].state == "on_ground" and dock.containers[1].z == pytest.approx(2.591, abs=0.01)


def test_a_load_that_tips_over_an_edge_comes_to_rest_on_the_ground():
    """A container is set with its end on another one, and its rope goes slack: its free end lies on the ground."""
    config = plant.default_dock(0)
    config.crane.portal.leg = 0.0
    config.crane.sway_damping = 0.4
    config.layout.containers = [plant.ContainerPlace(18, -6, 0, 0, 8e3), plant.ContainerPlace(26, -12, 0, 0, 8e3)]
    config.home = plant.CranePose(0, 18, -6, 2.591 + 0.25, 0)
    dock = plant.Dock(config)
    crane = Crane(dock, period_ms=10)
    crane.hold(0.5)
    crane.move(crane.pose(18, -6, 2.511), 3.0)
    crane.hold(0.8)
    dock.spreader_command(1, crane.t)
    crane.hold(1.2)
    crane.move(crane.pose(18, -6, 7.0), 10.0)
    crane.move(crane.pose(18, -12, 7.0), 20.0)
    crane.hold(5.0)
    crane.move(crane.pose(18, -12, 2 * 2.591 + 0.1), 10.0)
    crane.hold(3.0)

    def lowest():
        box = dock.containers[0]
        up = np.array(box.up)
        along = np.array([np.cos(box.yaw), np.sin(box.yaw), 0.0])
        along -= up * (up @ along)
        along /= np.linalg.norm(along)
        middle = np.array([box.x, box.y, box.z]) - 2.591 * up
        across = np.cross(up, along)
        return min((middle + u * 6.096 * along + v * 1.219 * across)[2] for u in (1, -1) for v in (1, -1))

    slack = list(crane.reference)
    slack[3] += 4.5
    seen = []
    crane.move(slack, 8.0, stop=lambda: seen.append(lowest()))
    for _ in range(30):
        crane.hold(0.05)
        seen.append(lowest())
    assert min(seen) > -0.05 and abs(seen[-1]) < 0.03
    tilt = np.arccos(dock.containers[0].up[2])
    assert 0.30 < tilt < 0.36 and dock.signal.tension == 0.0
