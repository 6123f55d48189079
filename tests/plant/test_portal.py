"""The crane's legs stand on the dock and travel with it: rays end at them, vehicles and loads run into them, lanes keep
clear of them."""

import math

import numpy as np
import pytest
from cmrc._core import plant
from controller import Crane

SECOND = 10**12
LEG = 0.5  # half a leg's side, m
AIR = 1.225  # kg/m3


def dock_beside_the_crane(x, y, s=0.0, **machine):
    config = machine.get("config") or plant.default_dock(1)
    config.home = plant.CranePose(s, s + 12.0, 16.0, 14.0, 0.0)
    config.layout.spot = plant.Pose(x, y, 0.0)
    return plant.Dock(config)


def travel(dock, code, seconds):
    dock.enable_drives(1, dock.time)
    for _ in range(round(seconds / 0.05)):
        dock.set_torque_code(0, code, dock.time)
        dock.advance_to(dock.time + SECOND // 20)


@pytest.mark.parametrize("s", [0.0, 3.0, -2.5])
def test_rays_end_at_the_leg_wherever_the_crane_stands(s):
    dock = dock_beside_the_crane(-22.0, 8.0, s)
    travel(dock, 800 if s < 0 else -800, 4.0)
    s_now = dock.signal.q[0]
    assert abs(s_now - s) > 0.1
    front, seen = -22.0 + 7.4, 0
    for ray in range(180):
        angle = math.radians(ray - 89.5)
        # Where the ray passes the plane of the waterside leg's landward-left face, x = s - 5.5: on that face, or past
        # it.
        way = (s_now - 5.0 - LEG - front) / math.cos(angle)
        y = 8.0 + way * math.sin(angle)
        if abs(y - 5.0) < LEG - 0.02:
            assert dock.agv_range(0, ray, dock.time) == pytest.approx(1e3 * way, abs=13)
            seen += 1
    assert seen > 3


def test_a_vehicle_beside_its_lane_runs_into_the_leg():
    dock = dock_beside_the_crane(-20.0, 5.0)
    dock.agv_period(0, 50000, 0)
    while not [e for e in dock.events if e.kind == "collision"] and dock.time < 20 * SECOND:
        dock.agv_push(0, 1500, 0, 0, dock.time)
        dock.advance_to(dock.time + SECOND // 20)
    (hit,) = [e for e in dock.events if e.kind == "collision"]
    assert hit.index == 0 and hit.values[1] == -1
    dock.advance_to(dock.time + 2 * SECOND)
    assert dock.agv(0).x + 7.4 == pytest.approx(-5.0 - LEG, abs=0.02) and dock.agv(0).speed == 0.0


def test_a_crane_that_travels_pushes_the_vehicle_that_stands_in_its_way():
    dock = dock_beside_the_crane(-14.0, 5.0)  # its front 1.1 m from the leg
    start = dock.agv(0).x
    travel(dock, -350, 7.0)  # slow enough for the drive not to trip
    hit = next(e for e in dock.events if e.kind == "collision")
    speed = abs(dock.signal.qd[0])
    assert 0.05 < hit.values[0] <= speed + 0.05
    assert dock.agv(0).x < start - 0.2
    assert dock.agv(0).x + 7.4 == pytest.approx(dock.signal.q[0] - 5.0 - LEG, abs=0.05)


def test_a_load_does_not_go_through_the_cranes_own_leg():
    """The spreader, along y, is slewed from the right against the leg at (5, 5), which it meets 2.6 m above the
    ground."""
    config = plant.default_dock(0)
    config.home = plant.CranePose(0.0, 9.0, 9.0, 2.6, math.pi / 2)
    dock = plant.Dock(config)
    crane = Crane(dock)
    crane.hold(0.2)
    target = crane.pose(6.0, 9.0, 2.6, math.pi / 2)
    crane.move(target, 8.0)
    assert dock.signal.contact
    half_width, turned = 1.219, abs(dock.signal.yaw - math.pi / 2)
    assert dock.signal.payload[0] - half_width == pytest.approx(5.0 + LEG, abs=0.05 + 6.1 * turned)
    free = plant.default_dock(0)
    free.home, free.crane.portal.leg = config.home, 0.0
    dock = plant.Dock(free)
    crane = Crane(dock)
    crane.hold(0.2)
    crane.move(target, 8.0)
    assert not dock.signal.contact and dock.signal.payload[0] - half_width < 5.0


@pytest.mark.parametrize("gap_m", [0.02, 0.1])
def test_near_a_leg_there_is_no_contact_before_the_load_touches_it(gap_m):
    config = plant.default_dock(0)
    config.home = plant.CranePose(0.0, 5.0 + LEG + 1.219 + gap_m, 9.0, 2.6, math.pi / 2)
    dock = plant.Dock(config)
    Crane(dock).hold(0.2)
    assert [event.kind for event in dock.events] == ["near_contact"]
    assert not dock.signal.contact


def test_the_leg_pushes_the_crane_as_it_pushes_the_load():
    """Wind presses the load against the leg. The crane rolls without friction, so the whole crane accelerates by force
    over mass, as if the load were fixed to it."""
    config = plant.default_dock(0)
    config.crane.portal.along = 3.0
    config.home = plant.CranePose(0.0, 5.0, 9.0, 2.6, math.pi / 2)
    drives = config.crane.drives
    drives[0].coulomb = drives[0].viscous = 0.0
    config.crane.drives = drives
    config.wind.mean, config.wind.spreader_area, config.wind.direction = 10.0, 200.0, math.pi
    dock = plant.Dock(config)
    dock.enable_drives(1, 0)
    p, speeds = config.crane, {}
    for ms in range(10, 12001, 10):
        dock.set_torque_code(0, 0, dock.time)
        dock.advance_to(ms * SECOND // 1000)
        speeds[ms] = dock.signal.qd[0]
    assert dock.signal.contact
    force = 0.5 * AIR * 200.0 * (10.0 + speeds[10000]) ** 2  # of the wind as the load feels it, which goes with it
    mass = (
        p.gantry_mass + p.jib_mass + p.counterweight + p.spreader_mass + drives[0].rotor_inertia * drives[0].gear ** 2
    )
    assert (speeds[12000] - speeds[8000]) / 4.0 == pytest.approx(-force / mass, rel=0.01)


def test_a_touch_at_a_leg_is_as_fast_as_the_load_is_against_the_leg():
    """The crane rolls, and its leg comes to the load that swings below it."""
    config = plant.default_dock(0)
    config.home = plant.CranePose(0, 12.15, 5.0, 5.0, 0)
    drives = config.crane.drives
    drives[0].coulomb = drives[0].viscous = 0.0
    config.crane.drives = drives
    config.layout.containers, config.drive_timeout = [], 0.0
    dock = plant.Dock(config)
    dock.enable_drives(1, 0)
    dock.set_torque_code(0, 1000, 0)
    dock.advance_to(1500 * SECOND // 1000)
    dock.set_torque_code(0, 0, dock.time)
    touches, before, against = [], dock.signal, 0.0
    while dock.time < 16 * SECOND:
        dock.advance_to(dock.time + SECOND // 1000)
        now = dock.signal
        events = [event for event in dock.events if event.kind == "touch"]
        if len(events) > len(touches):
            touches.append((events[-1].values[1], against))
        against = abs((now.payload[0] - before.payload[0]) * 1e3 - now.qd[0])
        before = now
    assert len(touches) == 2
    for shown, true in touches:
        assert shown == pytest.approx(true, abs=0.005)


def test_layouts_say_where_the_legs_stand():
    config = plant.default_dock()
    plant.apply_layout(config, "[portal]\nalong_m = 4\nwaterside_m = 4.5\nleg_m = 0.8\n")
    assert (
        config.crane.portal.along,
        config.crane.portal.waterside,
        config.crane.portal.landside,
        config.crane.portal.leg,
    ) == (4.0, 4.5, -5.0, 0.8)
    with pytest.raises(ValueError, match="the portal has no rails"):
        plant.apply_layout(config, "[portal]\nrails = 4\n")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "[portal]\nwaterside_m = 7",
            r"an AGV at \(-10\..*\) m of its lane runs into the crane's leg at \(-5\.00, 7\.00\) m",
        ),
        ("[portal]\nleg_m = -1", "the portal's leg must not be negative"),
        ("[portal]\nwaterside_m = -6", "landside rail must be landward"),
        ("[[posts]]\nx_m = 5\ny_m = 5.5", "mover 0 and the crane's leg 0 are inside each other"),
    ],
)
def test_a_portal_in_the_way_is_refused(text, says):
    config = plant.default_dock()
    plant.apply_layout(config, text)
    with pytest.raises(ValueError, match=says):
        plant.Dock(config)


@pytest.mark.parametrize("make", [plant.default_dock, plant.gantry_dock])
@pytest.mark.parametrize("agvs", [1, 2, 4, 8, 16])
def test_the_lanes_are_clear_of_the_legs_wherever_the_crane_works(make, agvs):
    """Every metre of the loop, for every place of the crane over the bays: half a vehicle and half a metre beside the
    legs at least."""
    config = make(agvs)
    reach = (
        13.0 if config.crane.machine == plant.Machine.gantry else 0.0
    )  # a slewing crane does not travel for the bays
    portal = config.crane.portal
    for lane in config.layout.legs:
        for g in lane:
            for way in np.arange(0.0, g.length, 1.0):
                h = g.heading + g.curvature * way
                x = g.x + (
                    way * math.cos(g.heading) if g.curvature == 0 else (math.sin(h) - math.sin(g.heading)) / g.curvature
                )
                y = g.y + (
                    way * math.sin(g.heading) if g.curvature == 0 else (math.cos(g.heading) - math.cos(h)) / g.curvature
                )
                for s in np.linspace(-reach, reach, 5):
                    for u in (-portal.along, portal.along):
                        for rail in (portal.landside, portal.waterside):
                            dx, dy = s + u - x, rail - y
                            ahead, beside = math.cos(h) * dx + math.sin(h) * dy, -math.sin(h) * dx + math.cos(h) * dy
                            assert abs(ahead) > 7.4 + 1.0 or abs(beside) > 1.5 + 0.5 + portal.leg * math.sqrt(0.5)
