"""Dry friction with stiction: joints stick, break away at F_s, and stop in the time that Coulomb's law says."""

import math

import pytest
from cmrc import plant

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
