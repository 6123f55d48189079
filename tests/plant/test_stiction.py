"""Dry friction with stiction: joints stick, break away at F_s, and stop in the time that Coulomb's law says."""

import math

import pytest
from cmrc import plant
from cmrc._core import plant as core

G = 9.81


def crane(**drive) -> plant.Crane:
    gantry = {"viscous": 0.0, "torque_lag": 1e-3, "efficiency": 1.0, **drive}
    made = plant.Crane(model="rigid", stiction=True, tolerance=1e-11, drives={"gantry": gantry})
    q = made.state.q
    q[1] = math.pi / 2  # the jib across the quay: travel and slewing do not meet
    made.reset(q)
    return made


def force(made: plant.Crane) -> float:
    return made.parameters.drives[0].rated_force


def test_a_joint_stays_put_until_the_force_passes_static_friction():
    made = crane(coulomb=0.1, stribeck=1.3)
    drive = made.parameters.drives[0]
    edge = 0.1 * 1.3 * drive.rated_torque
    for share in (0.2, 0.9, 0.999, -0.999):
        made.step([share * edge, 0, 0, 0, 0], 0.5)
        assert made.state.qd[0] == 0.0 and "gantry" in made.stuck
    made.step([1.001 * edge, 0, 0, 0, 0], 0.5)
    assert made.state.qd[0] > 0.0 and "gantry" not in made.stuck
    assert [e.kind for e in made.events if e.joint == "gantry"] == ["slipped"]


def test_breaking_away_comes_when_the_lag_says():
    """Torque (1 - exp(-t/T)) tau reaches the edge at T ln(1 / (1 - edge/tau))."""
    made = crane(coulomb=0.1, stribeck=1.3, torque_lag=0.05)
    drive = made.parameters.drives[0]
    edge, torque = 0.13 * drive.rated_torque, 0.4 * drive.rated_torque
    for _ in range(30):
        made.step([torque, 0, 0, 0, 0], 0.7e-3)
    slipped = next(e.time_s for e in made.events if e.joint == "gantry")
    assert slipped == pytest.approx(0.05 * math.log(1 / (1 - edge / torque)), abs=1e-8)


def test_a_rolling_joint_stops_after_v_over_mu_g_and_sticks():
    made = crane(coulomb=0.05, stribeck=1.0)
    q, qd = made.state.q, made.state.qd
    qd[0] = 0.3
    made.reset(q, qd)
    p = made.parameters
    moved = float(made.mass_matrix()[0, 0])
    slowing = 0.05 * force(made) / moved
    hold = [0.0, *(b / (d.gear * d.efficiency) for b, d in zip(made.bias()[[1, 2, 3, 6]], p.drives[1:], strict=True))]
    made.run(hold, 1e-3, math.ceil(0.3 / slowing * 1e3) + 50)
    stuck = next(e.time_s for e in made.events if e.joint == "gantry" and e.kind == "stuck")
    assert stuck == pytest.approx(0.3 / slowing, rel=1e-6)
    assert made.state.qd[0] == 0.0 and made.state.q[0] == pytest.approx(0.3**2 / (2 * slowing), rel=1e-5)


def test_stuck_luff_and_hoist_carry_the_load_within_their_friction():
    made = crane()
    torques = [
        b / (d.gear * d.efficiency)
        for b, d in zip(made.bias()[list(plant.ACTUATED)], made.parameters.drives, strict=True)
    ]
    before = made.state.q
    made.run(torques, 1e-3, 500)
    assert {"luff", "hoist", "slew"} <= set(made.stuck) or (abs(made.state.q - before) < 1e-5).all()
    later = made.state.q
    made.run([1.01 * t for t in torques], 1e-3, 3000)  # within 3 % of the rated force
    assert (made.state.q == later).all() and len(made.stuck) == 5


def test_a_load_that_is_hung_on_breaks_the_hoist_away_at_once():
    """The force jumps at the beginning of an interval: 196 kN more, of which friction holds 23 kN."""
    made = plant.Crane(stiction=True, home=(0, 20, 0, 14, 0))
    q, hoist, luff = made.state.q, made.parameters.drives[3], made.parameters.drives[2]
    moment = G * (10e3 * 32 + 22e3 * 14) * math.cos(q[2])
    torques = [0, 0, moment / (luff.gear * luff.efficiency), -G * 10e3 / (hoist.gear * hoist.efficiency), 0]
    made.run(torques, 0.01, 100)
    assert "hoist" in made.stuck
    before = made.state.q[3]
    made.set_load(20e3)
    made.run(torques, 0.01, 30)
    slipped = [e for e in made.events if e.kind == "slipped"]
    assert [e.time_s for e in slipped if e.joint == "hoist"] == [1.0]
    # The load falls against its own inertia, the motor's and the friction.
    inertia = 30e3 + hoist.rotor_inertia * hoist.gear**2
    fall = 0.5 * (G * 20e3 - 0.03 * hoist.rated_force) / inertia * 0.3**2
    assert made.state.q[3] - before == pytest.approx(fall, rel=0.2)


def test_wind_breaks_the_slewing_joint_away_when_its_moment_passes_static_friction():
    wind = {"mean": 28.0, "gust": 4.0, "direction": math.pi / 2, "seed": 2}
    made = plant.Crane(stiction=True, model="rigid", home=(0, 20, 0, 14, 0), wind=wind)
    q, luff, hoist, slew = made.state.q, *(made.parameters.drives[j] for j in (2, 3, 1))
    moment = G * (10e3 * 32 + 22e3 * 14) * math.cos(q[2])
    torques = [0, 0, moment / (luff.gear * luff.efficiency), -G * 10e3 / (hoist.gear * hoist.efficiency), 0]
    gusts = core.WindParameters()
    gusts.mean, gusts.gust, gusts.seed = 28.0, 4.0, 2

    def passes(ms: int) -> bool:
        air = float(core.wind_speed(gusts, ms * 1e-3))
        return 0.5 * 1.225 * 8 * air**2 * 20 > 1.3 * 0.03 * slew.rated_force

    first = next(ms for ms in range(60000) if passes(ms))
    assert 100 < first < 5000
    made.run(torques, 1e-3, first)
    assert made.state.qd[1] == 0 and "slew" in made.stuck
    made.run(torques, 1e-3, 1)
    assert made.state.qd[1] > 0
    assert [(e.time_s, e.kind) for e in made.events if e.joint == "slew"] == [(pytest.approx(first * 1e-3), "slipped")]


def test_a_joint_in_its_end_stop_sticks_where_its_force_cannot_move_it():
    made = crane(coulomb=0.1, stribeck=1.3)
    q, qd = made.state.q, made.state.qd
    q[0], qd[0] = made.parameters.upper[0] - 1e-3, 0.3
    made.reset(q, qd)
    made.run([0, 0, 0, 0, 0], 1e-3, 20)
    events = [e.kind for e in made.events if e.joint == "gantry"]
    assert events == ["limit", "stuck"]
    assert made.state.q[0] == made.parameters.upper[0] and made.state.qd[0] == 0


@pytest.mark.parametrize("stribeck", [1.0, 1.3])
@pytest.mark.parametrize("off", [0.0, 1e-16, -1e-16, 1e-12, -1e-12, 1e-9, 1e-6])
def test_a_joint_whose_force_is_just_at_its_limit_does_not_chatter(stribeck: float, off: float):
    made = crane(coulomb=0.1, stribeck=stribeck)
    edge = 0.1 * stribeck * made.parameters.drives[0].rated_torque
    for _ in range(400):
        made.step([edge * (1 + off), 0, 0, 0, 0], 2.5e-3)
    events = [e.kind for e in made.events if e.joint == "gantry"]
    assert len(events) <= 2 and made.state.qd[0] > -1e-15  # rounding decides at the limit, but not again and again
    if abs(off) > 1e-13:
        assert events == (["slipped"] if off > 0 else []) and ("gantry" in made.stuck) == (off < 0)


def test_a_force_that_jumps_across_the_limit_each_millisecond_makes_two_events_each_time_at_most():
    made = crane(coulomb=0.1, stribeck=1.0, torque_lag=1e-5)
    edge = 0.1 * made.parameters.drives[0].rated_torque
    for k in range(400):
        made.step([edge * (1.001 if k % 2 else 0.2), 0, 0, 0, 0], 1e-3)
    events = [e.kind for e in made.events if e.joint == "gantry"]
    assert 2 <= len(events) <= 400
    assert events == ["slipped", "stuck"] * (len(events) // 2) + ["slipped"] * (len(events) % 2)


def test_luff_and_hoist_that_break_away_together_move_with_their_forces():
    """A load is taken off: neither joint can hold the motors' moments. Each breaks away once, upwards."""
    made = plant.Crane(stiction=True, model="rigid", home=(0, 0, 20, 14, 0), load_mass=30e3)
    q, luff, hoist = made.state.q, made.parameters.drives[2], made.parameters.drives[3]
    moment = G * (40e3 * 32 + 22e3 * 14) * math.cos(q[2])
    torques = [0, 0, moment / (luff.gear * luff.efficiency), -G * 40e3 / (hoist.gear * hoist.efficiency), 0]
    made.reset(q, torques=torques)
    made.step(torques, 0.05)
    made.set_load(0)
    made.run(torques, 1e-3, 50)
    assert [(e.joint, e.kind, e.time_s) for e in made.events] == [
        ("luff", "slipped", 0.05),
        ("hoist", "slipped", 0.05),
    ]
    assert made.state.qd[2] > 0 and made.state.qd[3] < 0


def test_on_the_dock_wind_breaks_the_slewing_joint_away_too():
    config = core.default_dock(0)
    crane, wind = config.crane, config.wind
    crane.stiction = True
    wind.mean, wind.gust, wind.direction, wind.seed = 28.0, 4.0, math.pi / 2, 2
    config.crane, config.wind, config.rigid, config.drive_timeout = crane, wind, True, 0.0
    config.home = core.CranePose(0, 20, 0, 14, 0)
    dock = core.Dock(config)
    luff, hoist = crane.drives[2], crane.drives[3]
    moment = G * (10e3 * 32 + 22e3 * 14) * math.cos(dock.signal.q[2])
    dock.enable_drives(31, 0)
    dock.set_torque_code(2, round(moment / (luff.gear * luff.efficiency) / luff.rated_torque / 1.5 * 2047), 0)
    dock.set_torque_code(3, round(-G * 10e3 / (hoist.gear * hoist.efficiency) / hoist.rated_torque / 1.5 * 2047), 0)
    dock.advance_to(1_200_000_000_000)
    slipped = [e.time * 1e-12 for e in dock.events if e.kind == "joint_slipped" and e.index == 1]
    assert slipped == [pytest.approx(1.04, abs=0.01)] and dock.signal.qd[1] > 0
