"""The dock through its devices: latches, sensors, the landing, the AGVs. A plain controller in Python drives it."""

import math

import numpy as np
import pytest
from cmrc._core import plant
from cmrc_test import plant as parts
from controller import LATCH, Crane, quiet_dock

MS = 1_000_000_000


def kinds(dock: plant.Dock) -> list[str]:
    return [event.kind for event in dock.events]


def test_encoder_is_the_floored_motor_angle_in_24_bits():
    dock = plant.Dock(quiet_dock())
    dock.advance_to(LATCH * 8)
    q = dock.signal.q
    for joint, drive in enumerate(dock.config.crane.drives):
        counts = math.floor(q[joint] * drive.gear * 16384 / (2 * math.pi))
        assert abs(dock.encoder_total(joint, dock.time) - counts) <= 1
        assert dock.encoder(joint, dock.time) == dock.encoder_total(joint, dock.time) % 2**24


def test_code_is_taken_at_the_first_latch_after_the_write_and_held():
    dock = plant.Dock(quiet_dock())
    dock.enable_drives(0x1F, 0)
    dock.advance_to(2 * LATCH)
    dock.set_torque_code(1, 300, 2 * LATCH)  # on the latch: the next one takes it
    assert dock.signal.code[1] == 0
    dock.advance_to(3 * LATCH - 1)
    assert dock.signal.code[1] == 0
    dock.advance_to(3 * LATCH)
    assert dock.signal.code[1] == 300
    dock.advance_to(50 * LATCH)
    assert dock.signal.code[1] == 300


def test_codes_are_clamped_to_twelve_bits():
    dock = plant.Dock(quiet_dock())
    dock.set_torque_code(0, 5000, 0)
    dock.set_torque_code(1, -5000, 0)
    dock.advance_to(LATCH)
    assert list(dock.signal.code[:2]) == [2047, -2048]


@pytest.mark.parametrize(
    ("asked", "taken"), [(2046, 2046), (2047, 2047), (2048, 2047), (-2047, -2047), (-2048, -2048), (-2049, -2048)]
)
def test_the_last_codes_of_twelve_bits(asked, taken):
    dock = plant.Dock(quiet_dock())
    dock.set_torque_code(3, asked, 0)
    dock.advance_to(LATCH)
    assert dock.signal.code[3] == taken


def test_an_encoder_counts_through_both_ends_of_its_24_bits():
    """One turn of the motor is 16384 counts, so 1024 turns fill the counter. Below 0 the counter shows 2^24 - 1."""
    config = quiet_dock()
    drives = config.crane.drives
    slew, jib = drives[1], 1.0  # rad
    signs = set()
    for turns in (1023.999, 1024.001, -0.001, 0.001, -1024.001):
        slew.gear = abs(turns) * 2 * math.pi / jib
        config.crane.drives = [drives[0], slew, *drives[2:]]
        yaw = math.copysign(jib, turns)
        config.home = plant.CranePose(0.0, 22.0 * math.cos(yaw), 22.0 * math.sin(yaw), 12.0, 0.0)
        dock = plant.Dock(config)
        total = math.floor(turns * 16384)
        assert dock.encoder_total(1, 0) == pytest.approx(total, abs=1)
        assert dock.encoder(1, 0) == pytest.approx(total % 2**24, abs=1) and 0 <= dock.encoder(1, 0) < 2**24
        signs.add(dock.encoder(1, 0) > 2**23)
    assert signs == {True, False}


def test_motor_torque_follows_its_code_with_the_drives_lag():
    dock = plant.Dock(quiet_dock())
    dock.enable_drives(1, 0)
    dock.set_torque_code(0, 1000, 0)
    wanted = 1000 / 2047 * dock.config.crane.drives[0].maximum_torque
    dock.advance_to(25 * LATCH)  # 24 latches = 3 ms = one time constant after the code was taken
    assert dock.signal.torque[0] == pytest.approx(wanted * (1 - math.exp(-1)), rel=1e-5)


def test_no_reader_disturbs_the_dock():
    def run(reads: bool):
        dock = plant.Dock(quiet_dock())
        crane = Crane(dock)
        rng = np.random.default_rng(1)
        for i in range(60):
            crane.tick(crane.reference + 1e-4 * i, np.zeros(5), np.zeros(5))
            if reads:
                for t in sorted(int(crane.t + x) for x in rng.integers(0, 8 * LATCH, 5)):
                    dock.encoder(int(rng.integers(5)), t)
                    dock.sway(0, t)
                    dock.agv_x(0, t)
                dock.spreader_status(crane.t + 8 * LATCH)
            crane.dock.advance_to(crane.t + 8 * LATCH)
            crane.t += 8 * LATCH
        return dock.state_hash()

    assert run(False) == run(True)


@pytest.mark.parametrize("share", [0.0, 0.02, 2.0])
def test_a_brake_slips_under_more_than_it_holds(share):
    """Wind along the rails, at a crane that hangs its load rigidly and rolls without friction: what the brake does not
    hold accelerates the crane."""
    config = plant.default_dock(0)
    config.rigid = True
    config.wind.mean, config.wind.direction = 40.0, 0.0
    drives = config.crane.drives
    drives[0].coulomb = drives[0].viscous = 0.0
    drives[0].brake = share
    config.crane.drives = drives
    dock = plant.Dock(config)
    dock.advance_to(2 * 10**12)
    p, drive = config.crane, drives[0]
    wind = 0.5 * 1.225 * config.wind.spreader_area * 40.0**2
    mass = p.gantry_mass + p.jib_mass + p.counterweight + p.spreader_mass + drive.rotor_inertia * drive.gear**2
    pull = max(0.0, wind - share * drive.gear * drive.rated_torque)
    assert dock.signal.q[0] == pytest.approx(0.5 * pull / mass * 2.0**2, rel=0.02, abs=1e-9)


def test_a_joint_that_is_pressed_into_its_stop_has_reached_it_once():
    config = plant.default_dock(1)
    upper = list(config.crane.upper)
    upper[0] = 0.3
    config.crane.upper = upper
    dock = plant.Dock(config)
    dock.enable_drives(1, 0)
    for _ in range(50):
        dock.set_torque_code(0, 900, dock.time)
        dock.advance_to(dock.time + 50 * 10**9)
    assert dock.signal.q[0] == 0.3
    assert [event.index for event in dock.events if event.kind == "joint_limit"] == [0]


def test_brakes_hold_when_the_drives_are_off():
    dock = plant.Dock(quiet_dock())
    before = np.array(dock.signal.q)
    dock.advance_to(2000 * MS)
    assert np.abs(np.array(dock.signal.q) - before).max() < 2e-3
    assert not dock.faulted


def test_restored_dock_continues_bit_for_bit():
    dock = plant.Dock(quiet_dock())
    crane = Crane(dock)
    crane.hold(0.2)
    state = dock.snapshot()
    other = plant.Dock(quiet_dock())
    other.restore(state)
    before = dock.state_hash()
    for d in (dock, other):
        d.set_torque_code(1, 100, d.time)
        d.advance_to(d.time + 100 * LATCH)
    assert dock.state_hash() == other.state_hash() != before


@pytest.fixture(scope="module")
def picked():
    """The crane lands on the container at x = 12.7 m, locks, and lifts it by two metres."""
    dock = plant.Dock(quiet_dock())
    crane = Crane(dock)
    crane.hold(0.5)
    top = 6.5
    crane.move(crane.pose(12.7, 24.0, top + 0.05), 3.0)
    crane.move(crane.pose(12.7, 24.0, top - 0.08), 2.0)
    crane.hold(1.0)
    landed = dock.spreader_status(crane.t)
    dock.spreader_command(1, crane.t)
    start = crane.t
    while not dock.spreader_status(crane.t) & 0x10:
        crane.hold(0.01)
    lock_seconds = (crane.t - start) * 1e-12
    crane.move(crane.pose(12.7, 24.0, top + 2), 5.0)
    return dock, crane, landed, lock_seconds


def test_landing_closes_all_corner_switches_softly(picked):
    dock, _, landed, _ = picked
    assert landed & 0xF == 0xF and not landed & 0x10
    touch = next(event for event in dock.events if event.kind == "touch")
    assert 0 < touch.values[0] < 0.25 and "hard_landing" not in kinds(dock)


def test_locks_take_their_time_and_the_load_hangs_on_the_rope(picked):
    dock, _, _, lock_seconds = picked
    assert 0.8 <= lock_seconds <= 0.82
    assert dock.containers[1].state == "carried"
    assert dock.payload_mass == pytest.approx(dock.config.crane.spreader_mass + dock.containers[1].mass)
    assert dock.signal.tension == 0 or dock.signal.tension == pytest.approx(9.81 * dock.payload_mass, rel=0.05)
    assert dock.containers[1].z == pytest.approx(8.5, abs=0.1)


def test_hand_over_to_the_rigid_body_and_back_keeps_the_energy(picked):
    dock = picked[0]
    jumps = [abs(event.values[1]) for event in dock.events if event.kind in ("near_contact", "free_again")]
    assert jumps and max(jumps) < 0.02 * 9.81 * dock.payload_mass  # the potential energy of two centimetres


def test_locks_do_not_turn_in_the_air():
    dock = plant.Dock(quiet_dock())
    dock.spreader_command(1, 0)
    dock.advance_to(1500 * MS)
    assert dock.spreader_status(dock.time) & 0x3F == 0x20 and not kinds(dock)


def test_static_sink_of_a_box_is_its_weight_over_four_corners():
    rows = parts.drop_box(30480.0, (12.192, 2.438, 2.591), 0.02, 0.25, 0.0, 0.00025, 12000)
    assert rows[-1][0] == pytest.approx(-30480 * 9.81 / (4 * 1e7), rel=1e-3)
    assert max(row[0] for row in rows) <= 0.0201 and min(row[0] for row in rows) > -0.02


@pytest.mark.parametrize(("degrees", "slides"), [(10, False), (30, True)])
def test_friction_cone(degrees, slides):
    rows = parts.drop_box(30480.0, (12.192, 2.438, 2.591), 0.0, 0.0, math.radians(degrees), 0.0005, 4000)
    assert (abs(rows[-1][3] - rows[1000][3]) > 0.5) == slides


def drive(dock, seconds, speed, front, rear, period_us=20000):
    start = dock.time
    dock.agv_period(0, period_us, start)
    for i in range(round(seconds * 1e6 / period_us)):
        t = start + i * period_us * 1_000_000
        dock.agv_push(0, speed, front, rear, t)
        dock.advance_to(t + period_us * 1_000_000)


def test_agv_circle_has_the_radius_of_its_geometry():
    dock = plant.Dock(quiet_dock())
    angle = math.radians(10)
    drive(dock, 8.0, 2000, round(angle * 1e6), -round(angle * 1e6))
    agv = dock.agv(0)
    wheelbase = dock.config.agv.front + dock.config.agv.rear
    assert agv.speed == pytest.approx(2.0, rel=0.02)
    assert agv.speed / agv.yaw_rate == pytest.approx(wheelbase / (2 * math.tan(angle)), rel=0.03)


@pytest.mark.parametrize("speed", [2000, -2000])
def test_agv_drives_the_same_circle_forwards_and_backwards(speed):
    dock = plant.Dock(quiet_dock())
    angle = math.radians(6)
    drive(dock, 9.0, speed, round(angle * 1e6), -round(angle * 1e6))
    agv = dock.agv(0)
    assert agv.speed == pytest.approx(speed * 1e-3, rel=0.03)
    assert agv.speed / agv.yaw_rate == pytest.approx(4.5 / math.tan(angle), rel=0.03)


def test_agv_whose_set_points_run_dry_stops_and_says_so():
    dock = plant.Dock(quiet_dock())
    drive(dock, 4.0, 1500, 0, 0)
    assert not dock.agv_status(0, dock.time) & 0x40
    x, speed = dock.agv(0).x, dock.agv(0).speed
    dock.advance_to(dock.time + 6000 * MS)
    assert dock.agv_status(0, dock.time) & 0x50 == 0x50 and "agv_dry" in kinds(dock)
    # Brakes give at most 2 m/s2; the ramp asks for 1 m/s2, and the drive lags by 0.3 s.
    assert speed**2 / (2 * 2.0) < dock.agv(0).x - x < speed**2 / 2 + 0.3 * speed


def test_scanner_sees_the_containers():
    dock = plant.Dock(quiet_dock())
    dock.select_row(0, 0)
    dock.advance_to(LATCH)
    assert dock.scan_y(LATCH) == 24000
    x = np.array([dock.scan_x0() + i * dock.scan_dx() for i in range(128)])
    z = np.array([dock.profile(i, LATCH) for i in range(128)])
    tops = {0.0: 9091, 12700.0: 6500, -12700.0: 6500}
    for centre, top in tops.items():
        inside = np.abs(x - centre) < 5900
        assert (np.abs(z[inside] - top) <= 8).all() and (z % 8 == 0).all()
    assert (z[x > 12700 + 6200] <= dock.scan_deck()).all()


def test_wrong_configuration_says_which_value():
    config = plant.default_dock()
    config.tolerance = -1.0
    with pytest.raises(ValueError, match="tolerance"):
        plant.Dock(config)
