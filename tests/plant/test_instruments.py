"""Drive status and speed, load cell, second sway sensor, anemometer: what they show, also after a failure, and that
snapshots keep their state."""

import math

import numpy as np
import pytest
from cmrc._core import plant

MS = 1_000_000_000
READY, FAULT, LATE, BRAKE = 1, 2, 4, 8


def moving(duration_ms: int = 400, **wind: float) -> plant.Dock:
    config = plant.default_dock(1)
    for name, value in wind.items():
        setattr(config.wind, name, value)
    dock = plant.Dock(config)
    dock.enable_drives(0x1F, 0)
    for t in range(0, duration_ms, 20):
        for joint in range(5):
            dock.set_torque_code(joint, 500, t * MS)
    dock.advance_to(duration_ms * MS)
    return dock


def test_a_drive_says_ready_fault_time_out_and_brake() -> None:
    dock = plant.Dock(plant.default_dock(1))
    assert dock.drive_status(2, 0) == READY | BRAKE
    dock.enable_drives(0x1F, 1 * MS)
    for joint in range(5):
        dock.set_torque_code(joint, 0, 1 * MS)
    assert dock.drive_status(2, 2 * MS) == READY
    dock.fail_drive(2, True, 3 * MS)
    assert (dock.drive_status(2, 4 * MS), dock.drive_status(1, 4 * MS)) == (FAULT | BRAKE, READY)
    dock.fail_drive(2, False, 5 * MS)
    assert dock.drive_status(2, 6 * MS) == READY
    assert dock.drive_status(0, 100 * MS) == READY
    assert dock.drive_status(0, 103 * MS) == LATE | BRAKE  # no code for 100 ms
    dock.set_torque_code(0, 0, 104 * MS)
    assert (dock.drive_status(0, 105 * MS), dock.drive_status(1, 105 * MS)) == (READY, LATE | BRAKE)


def test_a_drive_times_out_when_its_last_code_is_older_than_100_ms() -> None:
    """At its latches of 125 us: the last one at which the code is 100 ms old is good, the next one is late."""
    dock = plant.Dock(plant.default_dock(1))
    dock.enable_drives(1, 1 * MS)
    dock.set_torque_code(0, 0, 1 * MS)
    latch = 125_000_000
    assert dock.drive_status(0, 101 * MS) == READY
    assert dock.drive_status(0, 101 * MS + latch - 1) == READY
    assert dock.drive_status(0, 101 * MS + latch) == LATE | BRAKE


def test_the_time_out_of_a_drive_without_a_code_begins_when_it_is_switched_on() -> None:
    dock = plant.Dock(plant.default_dock(1))
    dock.enable_drives(0b11, 250 * MS)
    dock.set_torque_code(1, 100, 300 * MS)
    assert [dock.drive_status(joint, 350 * MS) for joint in (0, 1, 2)] == [READY, READY, READY | BRAKE]
    assert [dock.drive_status(joint, 353 * MS) for joint in (0, 1)] == [LATE | BRAKE, READY]
    dock.enable_drives(0b111, 360 * MS)
    stopped = [(e.index, e.time) for e in dock.events if e.kind.startswith("drive_")]
    latch = MS // 8
    assert stopped == [(0, 350 * MS + latch)]
    dock.advance_to(480 * MS)
    stopped = [(e.index, e.time) for e in dock.events if e.kind.startswith("drive_")]
    assert stopped[1:] == [(1, 400 * MS + latch), (2, 460 * MS + latch)]


def test_a_drive_that_is_switched_on_does_not_continue_with_an_old_code() -> None:
    dock = plant.Dock(plant.default_dock(1))
    for joint, at in ((0, 0), (1, 10 * MS)):
        dock.set_torque_code(joint, 500, at)
    dock.enable_drives(0b11, 250 * MS)
    dock.advance_to(260 * MS)
    assert [dock.drive_status(joint, 260 * MS) for joint in (0, 1)] == [LATE | BRAKE] * 2
    assert dock.signal.torque[0] == dock.signal.torque[1] == 0


def test_the_drives_estimate_is_its_motors_speed() -> None:
    dock = moving()
    signal = dock.signal
    for joint, drive in enumerate(dock.config.crane.drives):
        rated = drive.rated_speed / drive.gear
        assert dock.drive_speed(joint, 400 * MS) == pytest.approx(signal.qd[joint] / rated * 10000, abs=0.6)
    assert abs(dock.drive_speed(1, 400 * MS)) > 20


def test_the_load_cell_shows_what_hangs_on_the_rope() -> None:
    dock = plant.Dock(plant.default_dock(1))
    assert dock.load_cell(0) == 10_000  # spreader at rest
    dock = moving()
    assert dock.load_cell(400 * MS) % 10 == 0
    assert dock.load_cell(400 * MS) == pytest.approx(dock.signal.tension / 9.81, rel=0.05)


def test_the_second_sway_sensor_sees_the_same_through_a_noise_of_its_own() -> None:
    dock = moving(50)
    pairs = []
    for t in range(60, 3000, 10):
        for joint in range(5):
            dock.set_torque_code(joint, 0, t * MS)
        pairs.append((dock.sway(0, t * MS), dock.second_sway(0, t * MS)))
    differences = [a - b for a, b in pairs]
    mean = sum(differences) / len(differences)
    spread = math.sqrt(sum((d - mean) ** 2 for d in differences) / len(differences))
    noise = 0.02 / 10 * 2048
    assert abs(mean) < 3 * noise * math.sqrt(2 / len(pairs))
    assert spread == pytest.approx(noise * math.sqrt(2), rel=0.15)  # independent of each other


def test_the_anemometer_shows_the_mean_of_three_seconds() -> None:
    dock = plant.Dock(plant.default_dock(1))
    assert dock.wind_mean(0) == 0
    config = plant.default_dock(1)
    config.wind.mean, config.wind.gust = 8.0, 3.0
    dock = plant.Dock(config)
    speeds = plant.wind_speed(config.wind, 7.0 + 3.0 * (np.arange(3000) + 0.5) / 3000)
    assert dock.wind_mean(10_000 * MS) == pytest.approx(1000 * speeds.mean(), abs=1)


# ---- each register at both ends of its range (c40_programs/include/devices.inc)


@pytest.mark.parametrize(("direction", "ends"), [(0.0, (2047, -2048)), (math.pi, (-2048, 2047))])
def test_sway_sensors_stop_at_the_ends_of_12_bits(direction: float, ends: tuple[int, int]) -> None:
    """Wind moves the load out of a narrow range: the code stays at the end of the range, and does not wrap."""
    config = plant.default_dock(1)
    config.wind.mean, config.wind.direction = 30.0, direction
    config.sensors.sway_range, config.sensors.sway_noise = 0.004, 0.0
    dock = plant.Dock(config)
    seen = [(dock.sway(axis, t * MS), dock.second_sway(axis, t * MS)) for t in range(0, 8000, 50) for axis in (0, 1)]
    for axis, end in enumerate(ends):
        codes = [code for pair in seen[axis::2] for code in pair]
        assert (max(codes) if end > 0 else min(codes)) == end
        assert codes.count(end) > 20 and all(abs(code - end) < 2100 for code in codes)


def test_a_code_of_sway_is_2048_to_the_range() -> None:
    """10 degrees are 2048, so half of the range is 1024; it is rounded down: just below 0 the code is -1."""
    config = plant.default_dock(1)
    config.wind.mean, config.sensors.sway_noise = 20.0, 0.0
    for sway_range in (math.pi / 18, 0.02):
        config.sensors.sway_range = sway_range
        dock = plant.Dock(config)
        checked = 0
        for t in range(1000, 2400, 100):
            # Sampled every 10 ms, shown a sample later.
            dock.advance_to((t - 10) * MS)
            angles = dock.signal.alpha, dock.signal.beta
            for axis, angle in enumerate(angles):
                if abs(angle / sway_range) < 0.99:
                    assert dock.sway(axis, t * MS) == math.floor(angle / sway_range * 2048)
                    checked += 1
            dock.advance_to(t * MS)
        assert checked >= 14


@pytest.mark.parametrize("sign", [1, -1])
def test_the_drives_estimate_ends_at_three_times_rated_speed(sign: int) -> None:
    config = plant.default_dock(1)
    drives = config.crane.drives
    drives[0].rated_speed, drives[0].overspeed = 0.02 * drives[0].rated_speed, 10.0
    config.crane.drives = drives
    dock = plant.Dock(config)
    dock.enable_drives(1, 0)
    shown = []
    for t in range(0, 1500, 5):
        dock.set_torque_code(0, sign * 1500, t * MS)
        dock.advance_to(t * MS)
        share = dock.signal.qd[0] / (drives[0].rated_speed / drives[0].gear)
        shown.append((share, dock.drive_speed(0, t * MS)))
    assert max(abs(share) for share, _ in shown) > 3.2
    for share, code in shown:
        assert code == pytest.approx(max(-3.0, min(3.0, share)) * 10000, abs=0.51)
    assert (max if sign > 0 else min)(code for _, code in shown) == sign * 30000


@pytest.mark.parametrize(
    ("mean", "shown"), [(-8.0, -8000), (-8.0004, -8000), (-8.0006, -8001), (100.0, 100_000), (-100.0, -100_000)]
)
def test_the_anemometer_at_the_ends_and_against_its_direction(mean: float, shown: int) -> None:
    config = plant.default_dock(1)
    config.wind.mean = mean
    assert plant.Dock(config).wind_mean(0) == shown


@pytest.mark.parametrize(
    ("spreader", "shown"), [(9_999.0, 9_990), (10_000.0, 10_000), (10_009.0, 10_000), (10_010.0, 10_010)]
)
def test_the_load_cell_counts_whole_steps_of_10_kg(spreader: float, shown: int) -> None:
    config = plant.default_dock(1)
    config.crane.spreader_mass = spreader
    assert plant.Dock(config).load_cell(0) == shown


FAILURES = {
    "drive_status": (lambda d, t: d.drive_status(2, t), lambda d, on, t: d.fail_drive_status(2, on, t)),
    "drive_speed": (lambda d, t: d.drive_speed(1, t), lambda d, on, t: d.fail_drive_speed(1, on, t)),
    "load_cell": (lambda d, t: d.load_cell(t), lambda d, on, t: d.fail_load_cell(on, t)),
    "second_sway": (lambda d, t: d.second_sway(0, t), lambda d, on, t: d.fail_second_sway(0, on, t)),
    "anemometer": (lambda d, t: d.wind_mean(t), lambda d, on, t: d.fail_anemometer(on, t)),
}


@pytest.mark.parametrize("name", FAILURES)
def test_a_failed_instrument_shows_the_same_until_it_is_repaired_and_a_snapshot_knows(name: str) -> None:
    read, fail = FAILURES[name]
    dock = moving(mean=8.0, gust=3.0)
    before = dock.state_hash()
    fail(dock, True, 400 * MS)
    assert dock.state_hash() != before
    held = read(dock, 400 * MS)
    if name == "drive_status":
        dock.fail_drive(2, True, 401 * MS)
    kept = dock.snapshot()
    shown = {read(dock, t * MS) for t in range(401, 900, 20)}
    assert shown == {held}
    dock.restore(kept)
    assert read(dock, 800 * MS) == held
    fail(dock, False, 900 * MS)
    assert len({read(dock, t * MS) for t in range(911, 1400, 20)} | {held}) > 1


def test_a_dock_with_one_sway_sensor_has_no_second() -> None:
    config = plant.default_dock(1)
    config.sensors.second_sway = False
    with pytest.raises(ValueError, match="one sway sensor"):
        plant.Dock(config).second_sway(0, 0)
