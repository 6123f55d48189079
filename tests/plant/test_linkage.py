"""The level-luffing linkage (IDA): it closes, keeps its energy, moves as the one-freedom system that its geometry
makes, and keeps its nose level."""

import math

import numpy as np
import pytest
from cmrc._core import plant

G = 9.81
P = plant.LinkageParameters()


def pose(t):
    """Angles of all bars with the jib at t, from the triangle alone."""
    x, z = P.jib * math.cos(t) - P.base_x, P.jib * math.sin(t) - P.base_z
    span = math.hypot(x, z)
    fly = math.atan2(z, x) - math.acos((span**2 + P.back**2 - P.tie**2) / (2 * span * P.back))
    return t, fly, math.atan2(z - P.back * math.sin(fly), x - P.back * math.cos(fly))


def centres(t):
    """Where the masses are: (mass, inertia, point, angle)."""
    a, b, c = pose(t)
    joint = P.jib * np.array([math.cos(a), math.sin(a)])
    along = np.array([math.cos(b), math.sin(b)])
    tie = np.array([P.base_x, P.base_z]) + P.tie / 2 * np.array([math.cos(c), math.sin(c)])
    return [
        (P.jib_mass, P.jib_mass * P.jib**2 / 12, joint / 2, a),
        (P.fly_mass, P.fly_mass * (P.fly + P.back) ** 2 / 12, joint + (P.fly - P.back) / 2 * along, b),
        (P.tie_mass, P.tie_mass * P.tie**2 / 12, tie, c),
        (P.load, 0.0, joint + P.fly * along, 0.0),
    ]


def inertia(t, h=1e-6):
    """Twice the kinetic energy at a jib rate of 1."""
    return sum(
        m * float(((p1 - p0) ** 2).sum()) / (2 * h) ** 2 + (i * ((a1 - a0) / (2 * h)) ** 2 if i else 0.0)
        for (m, i, p1, a1), (_, _, p0, a0) in zip(centres(t + h), centres(t - h), strict=True)
    )


def height_energy(t):
    return sum(m * G * p[1] for m, _, p, _ in centres(t))


def test_the_loop_closes_and_the_nose_stays_level():
    linkage = plant.Linkage(P)
    noses = []
    for t in np.linspace(0.75, 1.25, 30):
        linkage.place(t)
        assert linkage.open < 1e-12 and list(linkage.angles) == pytest.approx(pose(t))
        joint, angle = P.jib * np.array([math.cos(t), math.sin(t)]), pose(t)[1]
        assert linkage.nose == pytest.approx(joint + P.fly * np.array([math.cos(angle), math.sin(angle)]))
        noses.append(linkage.nose)
    x, z = np.array(noses).T
    assert np.ptp(x) > 15 and np.ptp(z) < 0.2  # a straight jib would lift its nose by 10 m


def test_holding_torque_is_the_slope_of_the_height_energy():
    linkage = plant.Linkage(P)
    for t in (0.8, 1.0, 1.2):
        linkage.place(t)
        assert linkage.holding_torque == pytest.approx(
            (height_energy(t + 1e-5) - height_energy(t - 1e-5)) / 2e-5, rel=1e-6
        )
        bare = plant.LinkageParameters()
        bare.load = 0.0
        empty = plant.Linkage(bare)
        empty.place(t)
        assert (
            abs(linkage.holding_torque - empty.holding_torque) < 0.06 * G * P.load * P.jib
        )  # level luffing: the load hardly counts


def test_free_motion_keeps_the_energy_and_the_loop():
    linkage = plant.Linkage(P, 1e-10)
    linkage.place(1.0, 0.1)
    before, moving = linkage.energy, linkage.energy - height_energy(1.0)
    assert moving == pytest.approx(0.5 * inertia(1.0) * 0.01, rel=1e-6)
    for _ in range(10):
        linkage.advance(0.0, 0.1)
        assert linkage.open < 1e-7
    assert abs(linkage.energy - before) < 1e-5 * moving


def test_it_moves_as_its_one_freedom_does():
    """J(t) t'' + J'(t) t'^2 / 2 + V'(t) = torque, integrated here by Runge and Kutta."""
    linkage = plant.Linkage(P, 1e-10)
    linkage.place(1.05)
    torque = linkage.holding_torque + 1e6

    def rate(y):
        t, w = y
        d = 1e-4
        slope = (inertia(t + d) - inertia(t - d)) / (2 * d)
        weight = (height_energy(t + d) - height_energy(t - d)) / (2 * d)
        return np.array([w, (torque - 0.5 * slope * w * w - weight) / inertia(t)])

    y, h = np.array([1.05, 0.0]), 0.02
    for _ in range(75):
        k1 = rate(y)
        k2 = rate(y + h / 2 * k1)
        k3 = rate(y + h / 2 * k2)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(y + h * k3))
    linkage.advance(torque, 1.5)
    assert y[0] > 1.06
    assert linkage.angles[0] == pytest.approx(y[0], abs=2e-6) and linkage.rates[0] == pytest.approx(y[1], abs=2e-6)


def test_power_put_in_is_energy_gained():
    linkage = plant.Linkage(P, 1e-10)
    linkage.place(0.9)
    before = linkage.energy
    linkage.advance(linkage.holding_torque + 1e5, 2.0)
    held = plant.Linkage(P)
    held.place(0.9)
    assert linkage.energy - before == pytest.approx((held.holding_torque + 1e5) * (linkage.angles[0] - 0.9), rel=1e-6)


@pytest.mark.parametrize(("name", "value"), [("jib", -1.0), ("fly_mass", 0.0), ("load", -5.0), ("tie", math.nan)])
def test_bars_that_cannot_be_are_refused(name, value):
    bad = plant.LinkageParameters()
    setattr(bad, name, value)
    with pytest.raises(ValueError, match="linkage"):
        plant.Linkage(bad)


def test_a_loop_that_cannot_close_is_refused():
    with pytest.raises(ValueError, match="does not close"):
        plant.Linkage(P).place(-1.5)
    with pytest.raises(ValueError, match="3600"):
        plant.Linkage(P).advance(0.0, -1.0)
