"""AGVs among each other and among obstacles: impacts, bumpers, movers, the protective field, both kinds of drive, range
sensors with a rate."""

import math
from fractions import Fraction

import numpy as np
import pytest
from cmrc._core import plant

MS = 10**9
SECOND = 10**12


def dock(agvs=1, **agv) -> plant.Dock:
    config = plant.default_dock(agvs)
    return plant.Dock(changed(config, **agv))


def changed(config, **agv):
    for name, value in agv.items():
        setattr(config.agv, name, value)
    return config


def drive(d, agv, speed, front=0, rear=0):
    d.agv_period(agv, 50000, d.time)
    d.agv_push(agv, speed, front, rear, d.time)


def run(d, seconds, *commands):
    """commands: (agv, mm/s, front, rear), each given again every 50 ms."""
    for _ in range(round(seconds / 0.05)):
        for agv, *what in commands:
            drive(d, agv, *what)
        d.advance_to(d.time + 50 * MS)


def collisions(d):
    return [event for event in d.events if event.kind == "collision"]


def test_a_moving_vehicle_shares_its_momentum_with_the_one_ahead():
    d = dock(2)
    gap = d.agv(0).x - d.agv(1).x - d.config.agv.length
    run(d, 0.5, (1, 1500, 0, 0))
    before = 0.0
    while not collisions(d):
        before = d.agv(1).speed
        run(d, 0.05, (1, 1500, 0, 0))
    (hit,) = collisions(d)
    assert hit.index == 0 and hit.values[1] == 1 and hit.values[0] == pytest.approx(before, rel=0.05)
    # Equal masses, plastic: both continue with half the speed, and their brakes stop them at 2 m/s2.
    assert d.agv(0).speed == pytest.approx(hit.values[0] / 2, rel=0.2) and d.agv(1).speed == pytest.approx(
        d.agv(0).speed, abs=0.05
    )
    assert d.agv_status(0, d.time) & 0x80 and d.agv_status(1, d.time) & 0x80
    x = d.agv(0).x
    run(d, 2.0, (1, 1500, 0, 0))  # set-points are refused until the bumper is reset
    assert d.agv(0).speed == d.agv(1).speed == 0.0 and 0.0 < d.agv(0).x - x < 0.5
    assert d.agv(0).x - d.agv(1).x >= d.config.agv.length - 0.01 and gap > 0
    d.agv_reset_bumper(1, d.time)
    run(d, 2.0, (1, -500, 0, 0))
    assert d.agv(1).speed < -0.1 and len(collisions(d)) == 1


def test_the_set_points_that_wait_are_gone_with_an_impact():
    d = dock(2)
    run(d, 1.5, (1, 1500, 0, 0))
    while not collisions(d):
        drive(d, 1, 1500)
        d.advance_to(d.time + 20 * MS)  # they come faster than they are taken
    drive(d, 1, 1500)
    assert d.agv_status(1, d.time) & 0xF == 0
    d.advance_to(d.time + 2 * SECOND)
    d.agv_reset_bumper(1, d.time)
    d.advance_to(d.time + SECOND)
    assert d.agv_status(1, d.time) & 0xFF == 0x10  # it stands, and never ran dry


@pytest.mark.parametrize("height", [0.15, 0.25, 0.5, 1.4, 1.6, 3.0])
def test_vehicles_collide_whatever_the_height_of_their_decks(height):
    d = dock(2, deck_height=height)
    run(d, 6.0, (1, 1500, 0, 0))
    assert [hit.index for hit in collisions(d)] == [0] and d.agv(0).x - d.agv(1).x >= d.config.agv.length - 0.01


@pytest.mark.parametrize(
    ("deck", "bottom", "hits"), [(2.5, 1.4, 1), (2.5, 1.6, 1), (2.5, 2.4, 1), (2.5, 2.6, 0), (1.0, 1.2, 0)]
)
def test_a_vehicle_runs_into_a_box_that_begins_below_its_deck(deck, bottom, hits):
    config = changed(plant.default_dock(1), deck_height=deck)
    config.layout.no_go = [plant.Box(33, 35, 5, 11, bottom, 4.0)]
    d = plant.Dock(config)
    run(d, 8.0, (0, 1500, 0, 0))
    assert len(collisions(d)) == hits and (d.agv(0).x < 26.0) == (hits == 1)


@pytest.mark.parametrize(
    ("begin", "end", "along"),
    [((35, 8), (28, 8), 2), ((9, 8), (16, 8), 2), ((22, 3), (22, 7), 3), ((24, 14), (24, 9), 3)],
)
def test_a_mover_hits_a_standing_vehicle_with_its_own_speed_from_any_side(begin, end, along):
    config = plant.default_dock(1)
    mover = plant.Mover(0.5, 2.0, [plant.Waypoint(0, *begin), plant.Waypoint(4, *end)])
    config.layout.movers = [mover]
    d = plant.Dock(config)
    d.advance_to(4 * SECOND)
    (hit,) = collisions(d)
    speed = plant.mover_place(mover, hit.time * 1e-12)[along]
    assert hit.values[0] == pytest.approx(abs(speed), rel=1e-6) and abs(speed) > 1


def test_a_slow_touch_opens_the_bumper_and_is_an_event_too():
    config = plant.default_dock(1)
    config.layout.movers = [plant.Mover(0.2, 2.0, [plant.Waypoint(0, 22 + 7.4 + 0.2 + 0.0005, 8)])]
    d = plant.Dock(config)
    run(d, 2.0, (0, 5, 0, 0))
    assert d.agv_status(0, d.time) & 0x80
    (hit,) = collisions(d)
    assert hit.index == 0 and 0 < hit.values[0] < 0.006 and hit.values[1] == -1
    run(d, 1.0, (0, 5, 0, 0))
    assert len(collisions(d)) == 1
    d.agv_reset_bumper(0, d.time)
    run(d, 2.0, (0, 5, 0, 0))  # against the post again
    assert d.agv_status(0, d.time) & 0x80 and len(collisions(d)) == 2


def test_without_collisions_vehicles_go_through_each_other():
    config = plant.default_dock(2)
    config.collisions = False
    d = plant.Dock(config)
    run(d, 8.0, (1, 1500, 0, 0))
    assert not collisions(d) and d.agv(1).x > d.agv(0).x - config.agv.length  # through it


def test_a_post_stops_a_vehicle_off_its_middle_and_turns_it():
    config = plant.default_dock(1)
    config.layout.movers = [plant.Mover(0.3, 2.0, [plant.Waypoint(0, 33.0, 8.9)])]
    d = plant.Dock(config)
    while not collisions(d):
        run(d, 0.05, (0, 1500, 0, 0))
    run(d, 3.0)
    assert d.agv(0).speed == 0.0 and d.agv(0).x + 7.4 < 33.0 + 0.05
    assert d.agv(0).heading > 1e-4  # pushed back on its left side, it turns left


def test_an_impact_leaves_no_gap_and_no_overlap():
    """Within 125 us a vehicle of 1.6 m/s comes 0.2 mm deep: it is put out of the post by just that."""
    config = plant.default_dock(1)
    config.layout.movers = [plant.Mover(0.3, 2.0, [plant.Waypoint(0, 33.0, 8.0)])]
    d = plant.Dock(config)
    for _ in range(100):
        if collisions(d):
            break
        run(d, 0.05, (0, 1500, 0, 0))
    assert collisions(d)[0].values[0] > 1.5 and d.agv(0).speed == 0.0
    assert 32.7 - (d.agv(0).x + 7.4) == pytest.approx(0.0, abs=1e-7)


def test_movers_follow_their_waypoints_smoothly():
    path = [plant.Waypoint(1, 0, 0), plant.Waypoint(3, 4, 0), plant.Waypoint(5, 4, 6)]
    mover = plant.Mover(0.4, 1.8, path, True)
    for way in path[:2]:
        assert plant.mover_place(mover, way.time)[:2] == pytest.approx([way.x, way.y])
    assert plant.mover_place(mover, 0.0) == [0, 0, 0, 0]
    for t in np.linspace(1.05, 4.9, 30):
        a, b, here = (plant.mover_place(mover, t + dt) for dt in (-1e-5, 1e-5, 0.0))
        assert here[2:] == pytest.approx([(b[0] - a[0]) / 2e-5, (b[1] - a[1]) / 2e-5], abs=1e-6)
    assert plant.mover_place(mover, 2.0) == pytest.approx(plant.mover_place(mover, 6.0))


def test_the_sensor_sees_a_mover_as_a_cylinder():
    config = plant.default_dock(1)
    config.layout.movers = [plant.Mover(0.5, 2.0, [plant.Waypoint(0, 40.0, 9.0), plant.Waypoint(10, 50.0, 9.0)])]
    d = plant.Dock(config)
    for seconds in (0.0, 5.0):
        t = round(seconds * SECOND)
        x, y, *_ = plant.mover_place(config.layout.movers[0], seconds)
        px, py = x - (22.0 + 7.4), y - 8.0
        for ray in range(60, 120):
            angle = math.radians(ray - 89.5)
            along = px * math.cos(angle) + py * math.sin(angle)
            beside = abs(-px * math.sin(angle) + py * math.cos(angle))
            got = d.agv_range(0, ray, t)
            if beside < 0.49:
                assert got == pytest.approx(1e3 * (along - math.sqrt(0.25 - beside**2)), abs=12)
            elif beside > 0.51:
                assert got > 1e3 * along + 1000


def test_range_sensors_with_a_rate_hold_their_scan_and_drop_some_rays():
    config = plant.default_dock(2)
    config.sensors.range_rate, config.sensors.range_dropout = 20.0, 0.1
    d = plant.Dock(config)

    def scan(t):
        return [d.agv_range(1, ray, t) for ray in range(180)]

    first, number = scan(10 * MS), d.range_scan(1, 10 * MS)
    assert scan(49 * MS) == first and d.range_scan(1, 49 * MS) == number
    second = scan(51 * MS)
    assert second != first and d.range_scan(1, 51 * MS) == number + 1
    lost = [r == 0 for r in first + second]
    assert 0.04 < sum(lost) / 360 < 0.17
    state = d.snapshot()
    later = scan(300 * MS)
    other = plant.Dock(config)
    other.restore(state)
    assert [other.agv_range(1, ray, 300 * MS) for ray in range(180)] == later


@pytest.mark.parametrize("rate", [0.4, 20.0, 30.0, 300.0, 400.0, 600.0, 700.0, 999.9, 1000.0])
def test_range_sensors_scan_at_their_rate_though_it_is_no_whole_number_of_milliseconds(rate: float):
    config = plant.default_dock(1)
    config.sensors.range_rate = rate
    d = plant.Dock(config)
    first = d.range_scan(0, 0)
    scans = [(d.range_scan(0, ms * MS) - first) % 2**32 for ms in range(3001)]
    # The scan of tick n is that of the first step of 1 ms at or after n / rate.
    assert scans == [math.floor(ms * Fraction(str(rate)) / 1000) for ms in range(3001)]


@pytest.mark.parametrize("rate", [-1.0, 1e-9, 0.0009, 1000.1, math.inf, math.nan])
def test_a_rate_that_no_range_sensor_has_is_refused(rate: float):
    config = plant.default_dock(1)
    config.sensors.range_rate = rate
    with pytest.raises(ValueError, match=r"range_rate must be 0 .*, or 0.001 to 1000 Hz \(got"):
        plant.Dock(config)


def test_the_protective_field_stops_before_a_post():
    config = changed(plant.default_dock(1), protective_field=True)
    config.layout.movers = [plant.Mover(0.3, 2.0, [plant.Waypoint(0, 56.0, 8.5)])]
    d = plant.Dock(config)
    run(d, 17.0, (0, 5000, 0, 0))
    front = d.agv(0).x + 7.4
    assert not collisions(d) and d.agv(0).speed < 0.1
    assert 0.3 < 55.7 - front < 2.0


def test_without_the_field_the_same_post_is_hit():
    config = plant.default_dock(1)
    config.layout.movers = [plant.Mover(0.3, 2.0, [plant.Waypoint(0, 56.0, 8.5)])]
    d = plant.Dock(config)
    run(d, 17.0, (0, 5000, 0, 0))
    assert len(collisions(d)) == 1 and collisions(d)[0].values[0] > 3.0


class Follower:
    """Drives an AGV round the lanes: pure pursuit with both axles, one set-point each 50 ms."""

    def __init__(self, lanes):
        points = []
        for lane in lanes:
            for u in np.arange(0.0, lane.length, 0.25):
                turned = lane.heading + lane.curvature * u
                if lane.curvature:
                    points.append(
                        (
                            lane.x + (math.sin(turned) - math.sin(lane.heading)) / lane.curvature,
                            lane.y - (math.cos(turned) - math.cos(lane.heading)) / lane.curvature,
                            lane.speed,
                        )
                    )
                else:
                    points.append(
                        (lane.x + u * math.cos(lane.heading), lane.y + u * math.sin(lane.heading), lane.speed)
                    )
        self.points = np.array(points)

    def command(self, signal):
        here = np.hypot(self.points[:, 0] - signal.x, self.points[:, 1] - signal.y)
        i = int(here.argmin())
        goal = self.points[(i + 24) % len(self.points)]
        c, s = math.cos(signal.heading), math.sin(signal.heading)
        dx, dy = goal[0] - signal.x, goal[1] - signal.y
        ahead, left = c * dx + s * dy, -s * dx + c * dy
        angle = math.atan(4.5 * 2 * left / (ahead**2 + left**2))
        return round(goal[2] * 400), round(angle * 1e6), round(-angle * 1e6)


def test_eight_vehicles_among_moving_obstacles_do_not_collide():
    config = changed(plant.default_dock(8), protective_field=True)
    config.layout.movers = [
        plant.Mover(0.4, 1.8, [plant.Waypoint(0, 36, 13), plant.Waypoint(12, 36, 2)]),  # crosses before the first
        plant.Mover(
            1.2, 3.0, [plant.Waypoint(0, 28, -16), plant.Waypoint(25, 16, -16), plant.Waypoint(32, 12, -24)]
        ),  # slow ahead, then leaves
        plant.Mover(0.3, 2.0, [plant.Waypoint(0, 30, 11.5)]),  # beside the lane
    ]
    d = plant.Dock(config)
    lanes = [lane for leg in config.layout.legs[:2] for lane in leg]
    followers = [Follower(lanes) for _ in range(8)]
    start = [d.agv(i).x for i in range(8)]
    while d.time < 24 * SECOND:
        run(d, 0.05, *((i, *follower.command(d.agv(i))) for i, follower in enumerate(followers)))
    assert not collisions(d)
    assert all(math.hypot(d.agv(i).x - start[i], d.agv(i).y - 8.0) > 5.0 for i in range(8))


def test_differential_drive_turns_on_the_spot_and_on_its_circle():
    d = dock(drive=plant.AgvDrive.differential)
    track = d.config.agv.track
    d.agv_period(0, 20000, 0)
    for k in range(200):
        d.agv_push_wheels(0, -120, 120, d.time)
        d.advance_to(d.time + 20 * MS)
    spin = d.agv(0)
    assert abs(spin.speed) < 1e-3 and spin.yaw_rate == pytest.approx(0.24 / track, rel=0.01)
    assert math.hypot(spin.x - 22, spin.y - 8) < 0.01
    for k in range(600):
        d.agv_push_wheels(0, 1000, 800, d.time)
        d.advance_to(d.time + 20 * MS)
    turn = d.agv(0)
    assert turn.speed == pytest.approx(0.9, rel=0.02) and turn.yaw_rate == pytest.approx(-0.2 / track, rel=0.02)
    with pytest.raises(ValueError, match="differential"):
        dock().agv_push_wheels(0, 1, 1, 0)


@pytest.mark.parametrize(("left", "right"), [(1_000_000_000, 1_000_000_000), (2**31 - 1, 2**31 - 1)])
def test_the_fastest_wheel_speeds_are_two_numbers_of_32_bits(left, right):
    d = dock(drive=plant.AgvDrive.differential)
    d.agv_period(0, 50000, 0)
    for _ in range(10):
        d.agv_push_wheels(0, left, right, d.time)
        d.advance_to(d.time + 50 * MS)
    assert d.agv(0).speed_command == pytest.approx(0.5e-3 * (left + right))
    assert d.agv(0).speed > 0


@pytest.mark.parametrize(("front", "rear"), [(0.1, -0.1), (0.5, 0.0), (0.0, 0.5), (0.5, 0.3)])
def test_differential_drive_takes_the_steered_set_points_too(front, rear):
    d = dock(drive=plant.AgvDrive.differential)
    run(d, 8.0, (0, 1000, round(1e6 * front), round(1e6 * rear)))
    signal = d.agv(0)
    assert signal.yaw_rate / signal.speed == pytest.approx((math.tan(front) - math.tan(rear)) / 9.0, rel=0.03)


@pytest.mark.parametrize("wheels", [(-120, 120), (0, 240), (120, -120)])
def test_a_turning_vehicle_stops_and_says_so_when_no_set_points_are_left(wheels):
    d = dock(drive=plant.AgvDrive.differential)
    d.agv_period(0, 50000, 0)
    for _ in range(40):
        d.agv_push_wheels(0, *wheels, d.time)
        d.advance_to(d.time + 50 * MS)
    before = abs(d.agv(0).yaw_rate)
    assert before == pytest.approx(0.24 / d.config.agv.track, rel=0.05)
    d.advance_to(d.time + 600 * MS)
    assert 0.2 * before < abs(d.agv(0).yaw_rate) < 0.8 * before  # it brakes; it is not stopped at once
    d.advance_to(d.time + 3 * SECOND)
    assert d.agv(0).yaw_rate == 0.0 and d.agv_status(0, d.time) & 0x40
    assert [event.kind for event in d.events] == ["agv_dry"]


def test_a_vehicle_without_set_points_keeps_its_curve_while_it_brakes():
    d = dock(drive=plant.AgvDrive.differential)
    d.agv_period(0, 50000, 0)
    for _ in range(120):
        d.agv_push_wheels(0, 2200, 1800, d.time)
        d.advance_to(d.time + 50 * MS)
    d.advance_to(d.time + SECOND)
    assert 0.5 < d.agv(0).speed < 1.8
    assert d.agv(0).yaw_rate / d.agv(0).speed == pytest.approx(-0.4 / d.config.agv.track / 2.0, rel=0.25)


def test_wheels_slip_when_more_is_asked_than_the_ground_gives():
    slippery = dock(adhesion=0.02, drive=plant.AgvDrive.differential)
    run(slippery, 2.0, (0, 3000, 0, 0))
    grip = 0.02 * 9.81
    assert 0 < slippery.agv(0).speed <= grip * 2.0


LAYOUT = """
rows_m = [24.0]
[[containers]]
x_m = 0.0
y_m = 24.0
mass_kg = 20000
[[containers]]
x_m = 0.0
y_m = 24.0
tier = 1
[[boxes]]
x_m = [-40, -38]
y_m = [0, 2]
z_m = [0, 3]
[[posts]]
x_m = 30
y_m = 12
[[movers]]
radius_m = 0.5
repeats = true
path = [[0, 30, 2], [10, 30, 14]]
[spot]
x_m = 20.0
[agv]
drive = "differential"
protective_field = true
[sensors]
range_rate_hz = 20
"""


def test_a_layout_from_toml():
    config = plant.default_dock(2)
    plant.apply_layout(config, LAYOUT)
    layout = config.layout
    assert [c.z for c in layout.containers] == pytest.approx([3.909, 6.5]) and layout.containers[0].mass == 20000
    assert len(layout.movers) == 2 and layout.movers[0].repeats and layout.no_go[0].x_max == -38
    assert (
        layout.legs[0][0].x == 20.0
        and config.agv.drive == plant.AgvDrive.differential
        and config.sensors.range_rate == 20
    )
    plant.Dock(config).advance_to(SECOND)


def test_the_warehouse_of_the_default_loop_may_say_its_heading():
    config = plant.default_dock(1)
    plant.apply_layout(config, "[warehouse]\nheading_deg = -180\nx_m = 8\n")
    assert config.layout.legs[0][-1].length == 34
    config.layout.warehouse = plant.Pose(8, -16, math.pi / 2)
    with pytest.raises(plant.LayoutError, match=r"layout:1:1: heading_deg of the warehouse is 90"):
        plant.apply_layout(config, "[spot]\nx_m = 20\n")


def test_the_deck_of_a_layout_is_where_its_containers_stand():
    config = plant.default_dock(1)
    plant.apply_layout(config, "deck_m = 3.0\n[[containers]]\nx_m = 0\ny_m = 24\n")
    assert config.layout.containers[0].z == config.layout.ship.z_max == 3.0
    plant.Dock(config).advance_to(SECOND // 100)


def test_a_folder_is_no_layout(tmp_path):
    with pytest.raises(plant.LayoutError, match="is a directory"):
        plant.load_layout(plant.default_dock(1), str(tmp_path))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[[boxes]]\nx_m = [0, 1]\ny_m = [0, 1]\nz = [0, 1]", r"layout:4:1: a box has no z; it has x_m, y_m, z_m"),
        ("[[posts]]\nx_m = 1", r"layout:1:1: a post needs y_m"),
        ("deck_m = true", r"layout:1:10: deck_m of the layout needs a number"),
        ("[[movers]]\npath = [[0, 1]]", r"layout:2:9: path of a mover needs a list of 3 numbers"),
        ("[agv]\ndrive = 'tracks'", r'layout:2:9: drive of agv needs one of "steered", "differential"'),
        ("[spot]\nheading_deg = 90", "default loop"),
        (
            "[warehouse]\nheading_deg = 90",
            r"layout:2:15: heading_deg of the warehouse is 90, .* expected is 180, no head",
        ),
        ("[warehouse]\nheading_deg = 0\nx_m = 8", r"layout:2:15: heading_deg of the warehouse is 0, .* \[lanes\]"),
        ("[[containers]]\nx_m = 0\ny_m = 24\ntier = -1", r"layout:1:1: a container's tier is 0, 1, 2"),
        ("boxes = 3", "list of tables"),
        ("x = [", r"layout:1:\d+: "),
        ("[lanes]\nto_warehouse = [[10, 0, 3]]\nto_spot = [[10, 0, 3]]", "to_spot ends at"),
    ],
)
def test_wrong_layouts_say_where(text, says):
    with pytest.raises(plant.LayoutError, match=says):
        plant.apply_layout(plant.default_dock(), text)
