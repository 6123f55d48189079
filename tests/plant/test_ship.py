"""The motion of the moored ship: amplitudes and periods by a seed; containers that move with the ship; a draught that
changes."""

import math

import numpy as np
import pytest
from cmrc._core import plant
from controller import Crane, quiet_dock

SECOND = 10**12


def moving(scale=1.0, seed=1, **more):
    config = quiet_dock(**more)
    config.ship.scale, config.ship.seed = scale, seed
    return config


def track(config, seconds=240.0, step=0.5):
    dock = plant.Dock(config)
    rows = []
    for k in range(round(seconds / step)):
        dock.advance_to(round(k * step * SECOND))
        rows.append([(c.x, c.y, c.z) for c in dock.containers[:3]])
    return np.array(rows)


def test_containers_ride_within_the_sizes_of_the_motion():
    still = np.array([(c.x, c.y, c.z + 2.591) for c in plant.default_dock().layout.containers[:3]])
    away = track(moving(), 50.0) - still
    # surge 0.2 m and pitch at the deck's height; sway 0.1 m and roll; heave 0.1 m, roll over 4 m, pitch over 12.7 m
    deg = math.pi / 180
    most = [0.2 + 0.1 * deg * 4, 0.1 + 0.5 * deg * 4, 0.1 + 0.5 * deg * 4 + 0.1 * deg * 12.7]
    assert (np.abs(away).max(axis=(0, 1)) <= most).all() and (
        np.abs(away).max(axis=(0, 1)) > 0.3 * np.array(most)
    ).all()


def test_the_motion_depends_on_the_seed_alone_and_is_off_by_default():
    one, again, other = track(moving(), 10), track(moving(), 10), track(moving(seed=2), 10)
    assert (one == again).all() and (one != other).any()
    assert np.ptp(track(quiet_dock(), 5), axis=0).max() == 0.0


def test_the_deck_rises_as_containers_leave():
    config = quiet_dock()
    config.ship.draught = 1e-6
    config.layout.containers = config.layout.containers[1:2] + config.layout.containers[3:4]
    dock = plant.Dock(config)
    before = dock.containers[1].z
    crane = Crane(dock)
    crane.hold(0.3)
    crane.move(crane.pose(12.7, 24.0, 6.42), 4.0)
    crane.hold(0.8)
    dock.spreader_command(1, crane.t)
    crane.hold(1.0)
    assert dock.containers[0].state == "carried"
    assert dock.containers[1].z - before == pytest.approx(1e-6 * config.layout.containers[0].mass)


def test_a_spreader_lands_on_a_moving_container_and_rides_along():
    dock = plant.Dock(moving(scale=0.3, z=7.2))
    crane = Crane(dock)
    crane.hold(0.3)
    crane.move(crane.pose(12.7, 24.0, 6.3), 5.0)
    crane.hold(4.0)
    top = dock.containers[1].z
    assert "touch" in [event.kind for event in dock.events]
    assert dock.signal.payload[2] == pytest.approx(top, abs=0.02)
    relative = [dock.signal.payload[0] - dock.containers[1].x]
    crane.hold(3.0)
    relative.append(dock.signal.payload[0] - dock.containers[1].x)
    assert abs(relative[1] - relative[0]) < 0.02 and np.isfinite(dock.signal.payload).all()


def test_a_touch_is_as_fast_as_it_is_against_the_container_that_moves():
    """The deck heaves at up to 0.2 m/s against a spreader that comes down at a few centimetres per second."""
    dock = plant.Dock(moving(scale=3.0, z=7.9))
    crane = Crane(dock)
    crane.hold(0.3)
    before = []

    def touched():
        if not [event for event in dock.events if event.kind == "touch"]:
            box = dock.containers[1]
            before.append((dock.time, np.array(dock.signal.payload), np.array([box.x, box.y, box.z])))
            return False
        return True

    crane.move(crane.pose(12.7, 24.0, 6.0), 20.0, touched)
    (touch,) = [event for event in dock.events if event.kind == "touch"][:1]
    (t0, spreader0, box0), (t1, spreader1, box1) = before[-6], before[-1]
    seconds = (t1 - t0) * 1e-12
    x, y, closing = ((spreader0 - box0) - (spreader1 - box1)) / seconds
    own = (spreader0[2] - spreader1[2]) / seconds
    assert touch.values[0] == pytest.approx(closing, abs=0.03)
    assert touch.values[1] == pytest.approx(math.hypot(x, y), abs=0.001) and math.hypot(x, y) > 0.02
    assert abs(own - closing) > 0.06  # against the quay it would be another speed


def rotation(axis, angle):
    """Rodrigues' formula."""
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * k @ k


def turn_of(up):
    """The ship's rotation from what is up on its deck: roll about its own axis, which pitches."""
    pitch, roll = math.atan2(up[0], up[2]), -math.asin(up[1])
    return rotation((0, 1, 0), pitch) @ rotation((1, 0, 0), roll)


def top_of(container):
    return np.array([container.x, container.y, container.z])


def test_containers_move_and_tilt_as_points_of_one_rigid_body():
    config = moving(scale=5.0)
    calm = np.array([(c.x, c.y, c.z + 2.591) for c in config.layout.containers])
    middle = np.array([0.0, 28.0, 0.0])  # of the ship, on the quay's level
    dock, most = plant.Dock(config), 0.0
    for second in range(40):
        dock.advance_to(second * SECOND)
        here = dock.containers
        turn = turn_of(here[0].up)
        assert all(c.up == here[0].up for c in here) and np.linalg.norm(here[0].up) == pytest.approx(1.0, abs=1e-14)
        where = np.array([top_of(c) for c in here])
        shift = where[0] - middle - turn @ (calm[0] - middle)
        assert np.allclose(where, middle + shift + (calm - middle) @ turn.T, atol=1e-12)
        assert (np.abs(shift) <= [1.0, 0.5, 0.5]).all()  # 5 times surge, sway, heave: the ship turns about its middle
        most = max(most, math.degrees(math.acos(here[0].up[2])))
    assert 1.5 < most < 2.6


def test_the_scanner_sees_the_tilted_tops():
    config = moving(scale=5.0)
    config.layout.containers = config.layout.containers[:1]
    dock = plant.Dock(config)
    dock.advance_to(4 * SECOND)
    (c,) = dock.containers
    dock.select_row(0, dock.time)
    y, seen = 1e-3 * dock.scan_y(dock.time), []
    for i in range(128):
        x = 1e-3 * (dock.scan_x0() + i * dock.scan_dx())
        if abs(x - c.x) < 5.5:
            height = c.z - (c.up[0] * (x - c.x) + c.up[1] * (y - c.y)) / c.up[2]
            assert 0.0 <= 1e3 * height - dock.profile(i, dock.time) <= 8.0 + 1e-6
            seen.append(height)
    assert len(seen) > 20 and max(seen) - min(seen) > 0.02


def landed(scale, seed=3):
    """A spreader on container 1, near x = 12.7 m, its rope slack. No controller follows the ship, so the seed is one
    with which the spreader lands."""
    config = moving(scale=scale, seed=seed, z=7.5)
    config.layout.containers = config.layout.containers[:2]
    config.landing.guide_window = 0.4
    dock = plant.Dock(config)
    crane = Crane(dock)
    crane.hold(0.3)
    for top, seconds in ((0.5, 3.0), (-0.35, 3.0)):
        at = dock.containers[1]
        crane.move(crane.pose(at.x, at.y, at.z + top), seconds)
    crane.hold(1.0)
    assert dock.spreader_status(crane.t) & 0xF == 0xF
    return dock, crane


def lock(dock, crane, closed):
    dock.spreader_command(int(closed), crane.t)
    for _ in range(1500):
        crane.hold(0.001)
        if dock.spreader_status(crane.t) & (0x10 if closed else 0x20):
            return
    raise AssertionError([e.kind for e in dock.events])


def test_what_is_locked_to_a_container_on_deck_tilts_with_it():
    dock, crane = landed(2.0)
    lock(dock, crane, True)
    ups, decks = [], []
    for _ in range(24):
        crane.hold(0.25)
        carried, other = dock.containers[1], dock.containers[0]
        assert carried.state == "carried" and other.state == "on_ship"
        ups.append(carried.up), decks.append(other.up)
    assert np.ptp(decks, axis=0)[1] > 0.01  # it rolls by more than half a degree meanwhile
    assert np.abs(np.subtract(ups, decks)).max() < 2e-3  # corners seat within 5 mm over 2.26 m


def test_locking_takes_momentum_and_energy_that_the_container_had_on_the_ship():
    dock, crane = landed(2.0)
    rows = []
    dock.spreader_command(1, crane.t)
    while dock.containers[1].state == "on_ship":
        c = dock.containers[1]
        rows.append(
            [dock.time * 1e-12, *(top_of(c) - 0.5 * 2.591 * np.array(c.up)), dock.signal.payload[2]]
        )  # the container's middle; where it will hang
        crane.hold(0.001)
    (switch,) = [s for s in dock.switches if s.kind == "locked"]
    t = np.array(rows[-40:])[:, 0] - switch.time * 1e-12
    fits = [np.polyfit(t, np.array(rows[-40:])[:, k], 2) for k in (1, 2, 3, 4)]
    velocity, height = np.array([f[1] for f in fits[:3]]), fits[3][2]
    mass = dock.config.layout.containers[1].mass
    assert np.linalg.norm(velocity) > 0.03
    gained = np.subtract(switch.after.payload, switch.before.payload)
    assert np.allclose(gained / mass, velocity, atol=1e-4)
    # Its energy comes with it: the height at which it hangs, and its motion. The spreader gives a little up to follow
    # it.
    want = mass * 9.81 * height + 0.5 * mass * velocity @ velocity
    assert switch.energy_after - switch.energy_before == pytest.approx(want, abs=30.0)


def test_a_snapshot_on_a_rolling_container_continues_bit_for_bit():
    dock, crane = landed(2.0)
    again = plant.Dock(dock.config)
    again.restore(dock.snapshot())
    for each in (dock, again):
        each.enable_drives(0, crane.t)
        each.advance_to(crane.t + SECOND)
    assert again.state_hash() == dock.state_hash() and dock.signal.contact


def test_a_container_set_back_on_deck_stands_where_it_stood():
    dock, crane = landed(2.0)
    lock(dock, crane, True)
    crane.hold(2.0)
    lock(dock, crane, False)
    assert dock.containers[1].state == "on_ship"
    distances = []
    for _ in range(8):
        crane.hold(0.25)
        one, other = dock.containers[1], dock.containers[0]
        assert one.up == other.up
        distances.append(turn_of(one.up).T @ (top_of(one) - top_of(other)))
    calm = [np.array([c.x, c.y, c.z]) for c in dock.config.layout.containers]
    assert np.ptp(distances, axis=0).max() < 1e-12  # rides along
    assert np.abs(distances[0] - (calm[1] - calm[0])).max() < 0.02
    assert one.yaw == pytest.approx(dock.config.layout.containers[1].yaw, abs=0.01)


def test_a_wrong_scale_is_refused():
    with pytest.raises(ValueError, match="scale of motion"):
        plant.Dock(moving(scale=-1.0))


def test_only_what_stands_on_the_ship_moves_with_it():
    """One container on the quay, one on top of it, one on a box beyond the ship, and one on deck."""
    config = moving()
    config.ship.draught = 1e-6
    config.layout.no_go = [plant.Box(20, 36, 14, 18, 0.0, 2.0)]
    config.layout.containers = [
        plant.ContainerPlace(22, -6, 0, 0, 20e3),
        plant.ContainerPlace(22, -6, 2.591, 0, 20e3),
        plant.ContainerPlace(28, 16, 2.0, 0, 20e3),
        plant.ContainerPlace(0, 24, 3.909, 0, 20e3),
    ]
    dock = plant.Dock(config)
    assert [c.state for c in dock.containers] == ["on_ground"] * 3 + ["on_ship"]
    alone = moving()
    alone.ship.draught = 1e-6
    alone.layout.containers = config.layout.containers[3:]
    other = plant.Dock(alone)
    for second in (1, 4, 11):
        for each in (dock, other):
            each.advance_to(second * SECOND)
        *quay, deck = dock.containers
        for container, place in zip(quay, config.layout.containers, strict=False):
            assert (container.x, container.y, container.z) == (place.x, place.y, place.z + 2.591)
            assert tuple(container.up) == (0.0, 0.0, 1.0)
        # What never was on the ship does not raise it.
        assert (deck.x, deck.y, deck.z) == (other.containers[0].x, other.containers[0].y, other.containers[0].z)
        assert deck.z != 6.5
