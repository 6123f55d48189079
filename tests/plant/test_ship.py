"""The moored ship's motion: its sizes and periods, seeded; what stands on it rides along; a draught that changes."""

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
    assert (np.abs(away).max(axis=(0, 1)) <= most).all() and (np.abs(away).max(axis=(0, 1)) > 0.3 * np.array(most)).all()


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
            before.append((dock.time, dock.signal.payload[2], dock.containers[1].z))
            return False
        return True

    crane.move(crane.pose(12.7, 24.0, 6.0), 20.0, touched)
    (touch,) = [event for event in dock.events if event.kind == "touch"][:1]
    (t0, z0, top0), (t1, z1, top1) = before[-6], before[-1]
    seconds = (t1 - t0) * 1e-12
    closing, own = ((z0 - top0) - (z1 - top1)) / seconds, (z0 - z1) / seconds
    assert touch.values[0] == pytest.approx(closing, abs=0.03)
    assert abs(own - closing) > 0.06  # against the quay it would be another speed


def test_a_wrong_scale_is_refused():
    with pytest.raises(ValueError, match="scale of motion"):
        plant.Dock(moving(scale=-1.0))
