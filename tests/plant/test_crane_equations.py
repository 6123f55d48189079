"""The crane's closed-form equations against independent ones: differentiated energies, Pinocchio and MuJoCo."""

import math

import numpy as np
import pytest
from cmrc._core import plant
from cmrc_test import plant as parts
from lossless import without_losses

GRAVITY = 9.81
RNG = np.random.default_rng(20)


def parameters(rotors: bool = False) -> plant.CraneParameters:
    crane = plant.CraneParameters()
    if not rotors:
        drives = crane.drives
        for drive in drives:
            drive.rotor_inertia = 0.0
        crane.drives = drives
    return crane


def states(n: int):
    for _ in range(n):
        q = np.array(
            [
                RNG.uniform(-20, 20),
                RNG.uniform(-3, 3),
                RNG.uniform(0.4, 1.35),
                RNG.uniform(5, 50),
                RNG.uniform(-0.5, 0.5),
                RNG.uniform(-0.5, 0.5),
                RNG.uniform(-3, 3),
            ]
        )
        qd = RNG.uniform(-1, 1, 7) * np.array([0.5, 0.13, 0.05, 1.0, 0.3, 0.3, 0.2])
        yield q, qd


class Bodies:
    """The crane as separate mass points and bodies, written from the geometry alone, complex-step friendly."""

    def __init__(self, crane: plant.CraneParameters, mass: float, inertia: float):
        self.c, self.mass, self.inertia = crane, mass, inertia

    def points(self, q):
        c = self.c
        s, psi, phi, l, alpha, beta, _ = q
        radial = np.array([np.cos(psi), np.sin(psi), 0 * psi])
        tangential = np.array([-np.sin(psi), np.cos(psi), 0 * psi])
        up = np.array([0.0, 0.0, 1.0])
        base = s * np.array([1.0, 0.0, 0.0])
        pivot = base + c.a0 * radial + c.pivot_height * up
        jib = np.cos(phi) * radial + np.sin(phi) * up
        rope = np.sin(alpha) * np.cos(beta) * radial + np.sin(beta) * tangential - np.cos(alpha) * np.cos(beta) * up
        return [
            (c.gantry_mass, base),
            (c.counterweight, base - c.counterweight_radius * radial),
            (c.jib_mass, pivot + c.jib_centre * jib),
            (self.mass, pivot + c.jib * jib + l * rope),
        ]

    def spins(self, q, qd):
        """Rotational kinetic energy: slewing platform, slender jib, load about the vertical, rotors."""
        c = self.c
        psid, phid, kappad = qd[1], qd[2], qd[6]
        energy = 0.5 * c.slew_inertia * psid**2
        energy += 0.5 * c.jib_inertia * (phid**2 + (np.cos(q[2]) * psid) ** 2)
        energy += 0.5 * self.inertia * (psid + kappad) ** 2
        for drive, k in zip(c.drives, (0, 1, 2, 3, 6)):
            energy += 0.5 * drive.rotor_inertia * (drive.gear * qd[k]) ** 2
        return energy

    def kinetic(self, q, qd):
        """Point velocities by a complex step along qd: exact to rounding."""
        h = 1e-30
        moved = self.points(q + 1j * h * qd)
        return self.spins(q, qd) + sum(0.5 * m * np.sum((p.imag / h) ** 2) for m, p in moved)

    def potential(self, q):
        return sum(m * GRAVITY * p[2] for m, p in self.points(q)[2:])

    def mass_matrix(self, q):
        e = np.eye(7)
        t = [self.kinetic(q, e[i]) for i in range(7)]
        return np.array([[self.kinetic(q, e[i] + e[j]) - t[i] - t[j] for j in range(7)] for i in range(7)])

    def gravity(self, q):
        h = 1e-30
        return np.array([self.potential(q + 1j * h * e).imag / h for e in np.eye(7)])

    def bias(self, q, qd):
        """h = d/dt(M qd) at qdd = 0, minus dT/dq; central differences."""
        d = 1e-5
        rate = (self.mass_matrix(q + d * qd) - self.mass_matrix(q - d * qd)) / (2 * d)
        slope = np.array([(self.kinetic(q + d * e, qd) - self.kinetic(q - d * e, qd)) / (2 * d) for e in np.eye(7)])
        return rate @ qd - slope


def close(a, b, tolerance):
    a, b = np.asarray(a), np.asarray(b)
    assert np.max(np.abs(a - b)) <= tolerance * np.max(np.abs(b))


@pytest.mark.parametrize("rotors", [False, True])
def test_mass_gravity_and_bias_follow_from_the_energies(rotors):
    crane = parameters(rotors)
    model, bodies = plant.Crane(crane), Bodies(crane, 31e3, 4e5)
    for q, qd in states(60):
        close(model.mass_matrix(q, 31e3, 4e5), bodies.mass_matrix(q), 1e-12)
        close(model.gravity(q, 31e3), bodies.gravity(q), 1e-12)
        close(model.bias(q, qd, 31e3, 4e5), bodies.bias(q, qd), 2e-8)
        close(model.kinetic_energy(q, qd, 31e3, 4e5), bodies.kinetic(q, qd), 1e-12)


def test_the_level_robot_of_sub_process_3_is_the_same_model_with_the_sway_held():
    """L0 inverse dynamics as printed for the torque compensation (plant-and-bus.md 1.3)."""
    c = parameters()
    model, mp, ik = plant.Crane(c), 30e3, 4e5
    for q, qd in states(40):
        q[4] = q[5] = qd[4] = qd[5] = 0.0
        qdd = RNG.uniform(-1, 1, 7) * np.array([0.1, 0.02, 0.02, 0.3, 0, 0, 0.05])
        _s, psi, phi, _, _, _, _ = q
        _, psid, phid, _, _, _, _ = qd
        sdd, psidd, phidd, ldd, _, _, kappadd = qdd
        r = c.a0 + c.jib * math.cos(phi)
        a = mp * c.jib + c.jib_mass * c.jib_centre
        mu = c.jib_mass * (c.a0 + c.jib_centre * math.cos(phi)) + mp * r - c.counterweight * c.counterweight_radius
        m_psi = (
            c.slew_inertia
            + c.jib_inertia * math.cos(phi) ** 2
            + c.counterweight * c.counterweight_radius**2
            + c.jib_mass * (c.a0 + c.jib_centre * math.cos(phi)) ** 2
            + mp * r**2
        )
        m_phi = c.jib_inertia + c.jib_mass * c.jib_centre**2 + mp * c.jib**2
        turn = m_phi * math.cos(phi) + c.a0 * a
        expected = [
            (c.gantry_mass + c.jib_mass + c.counterweight + mp) * sdd
            - mu * (psid**2 * math.cos(psi) + psidd * math.sin(psi))
            - a
            * (
                math.cos(phi) * math.cos(psi) * phid**2
                + math.sin(phi) * math.cos(psi) * phidd
                - 2 * math.sin(phi) * math.sin(psi) * phid * psid
            ),
            m_psi * psidd - mu * math.sin(psi) * sdd - 2 * math.sin(phi) * phid * psid * turn + ik * (psidd + kappadd),
            m_phi * phidd
            - a * math.sin(phi) * math.cos(psi) * sdd
            - mp * c.jib * math.cos(phi) * ldd
            + GRAVITY * a * math.cos(phi)
            + math.sin(phi) * psid**2 * turn,
            mp * (ldd - GRAVITY - c.jib * math.cos(phi) * phidd + c.jib * math.sin(phi) * phid**2),
            ik * (psidd + kappadd),
        ]
        force = np.asarray(model.mass_matrix(q, mp, ik)) @ qdd + model.bias(q, qd, mp, ik) + model.gravity(q, mp)
        close(force[[0, 1, 2, 3, 6]], expected, 1e-11)
        full = np.zeros(7)
        full[[0, 1, 2, 3, 6]] = expected
        close(model.acceleration(q, qd, full, mp, ik, 0b0110000), qdd, 1e-9)


def pinocchio_model(pin, crane, mass, inertia):
    """Chain PX, RZ, R(-y), R(-y), RX, P(-z) (plant-and-bus.md 1.7) plus the rotator; the sway joint angle is alpha -
    phi."""
    model = pin.Model()
    place = pin.SE3.Identity()

    def inertia_at(m, where, about=(0.0, 0.0, 0.0)):
        return pin.Inertia(m, np.array(where), np.diag(about))

    s = model.addJoint(0, pin.JointModelPX(), place, "s")
    model.appendBodyToJoint(s, inertia_at(crane.gantry_mass, (0, 0, 0)), place)
    psi = model.addJoint(s, pin.JointModelRZ(), place, "psi")
    model.appendBodyToJoint(psi, inertia_at(0.0, (0, 0, 0), (0, 0, crane.slew_inertia)), place)
    model.appendBodyToJoint(psi, inertia_at(crane.counterweight, (-crane.counterweight_radius, 0, 0)), place)
    down = np.array([0.0, -1.0, 0.0])
    pivot = pin.SE3(np.eye(3), np.array([crane.a0, 0.0, crane.pivot_height]))
    phi = model.addJoint(psi, pin.JointModelRevoluteUnaligned(down), pivot, "phi")
    model.appendBodyToJoint(
        phi, inertia_at(crane.jib_mass, (crane.jib_centre, 0, 0), (0, crane.jib_inertia, crane.jib_inertia)), place
    )
    tip = pin.SE3(np.eye(3), np.array([crane.jib, 0.0, 0.0]))
    alpha = model.addJoint(phi, pin.JointModelRevoluteUnaligned(down), tip, "alpha")
    beta = model.addJoint(alpha, pin.JointModelRX(), place, "beta")
    rope = model.addJoint(beta, pin.JointModelPrismaticUnaligned(np.array([0.0, 0.0, -1.0])), place, "l")
    model.appendBodyToJoint(rope, inertia_at(mass, (0, 0, 0)), place)
    model.gravity.linear = np.array([0.0, 0.0, -GRAVITY])
    return model


# ours (s, psi, phi, l, alpha, beta) -> chain (s, psi, phi, alpha - phi, beta, l)
CHAIN = np.zeros((6, 6))
CHAIN[0, 0] = CHAIN[1, 1] = CHAIN[2, 2] = CHAIN[3, 4] = CHAIN[4, 5] = CHAIN[5, 3] = 1.0
CHAIN[3, 2] = -1.0


def test_pinocchio_agrees():
    pin = pytest.importorskip("pinocchio")
    crane = parameters()
    model, mass = plant.Crane(crane), 33e3
    chain = pinocchio_model(pin, crane, mass, 0.0)
    data = chain.createData()
    for q, qd in states(100):
        x, v = CHAIN @ q[:6], CHAIN @ qd[:6]
        upper = np.triu(pin.crba(chain, data, x))
        theirs = CHAIN.T @ (upper + np.triu(upper, 1).T) @ CHAIN
        close(np.asarray(model.mass_matrix(q, mass, 0.0))[:6, :6], theirs, 1e-13)
        both = np.asarray(model.bias(q, qd, mass, 0.0)) + model.gravity(q, mass)
        close(both[:6], CHAIN.T @ pin.rnea(chain, data, x, v, np.zeros(6)), 1e-12)
        force = RNG.uniform(-1e5, 1e5, 6)
        theirs = np.linalg.solve(CHAIN, pin.aba(chain, data, x, v, np.linalg.solve(CHAIN.T, force)))
        ours = model.acceleration(q, qd, [*force, 0.0], mass, 0.0, 1 << 6)
        close(ours[:6], theirs, 1e-9)


def random_parameters(rng) -> plant.CraneParameters:
    crane = parameters()
    for name in ("a0", "jib", "pivot_height", "gantry_mass", "slew_inertia", "jib_mass", "jib_centre", "jib_inertia", "counterweight",
                 "counterweight_radius"):  # fmt: skip
        setattr(crane, name, getattr(crane, name) * rng.uniform(0.4, 2.0))
    return crane


def test_pinocchio_agrees_for_cranes_of_other_sizes():
    pin = pytest.importorskip("pinocchio")
    rng = np.random.default_rng(20)
    for q, qd in states(30):
        crane, mass = random_parameters(rng), rng.uniform(2e3, 60e3)
        model = plant.Crane(crane)
        chain = pinocchio_model(pin, crane, mass, 0.0)
        data = chain.createData()
        x, v = CHAIN @ q[:6], CHAIN @ qd[:6]
        upper = np.triu(pin.crba(chain, data, x))
        close(
            np.asarray(model.mass_matrix(q, mass, 0.0))[:6, :6], CHAIN.T @ (upper + np.triu(upper, 1).T) @ CHAIN, 1e-13
        )
        both = np.asarray(model.bias(q, qd, mass, 0.0)) + model.gravity(q, mass)
        close(both[:6], CHAIN.T @ pin.rnea(chain, data, x, v, np.zeros(6)), 1e-12)
        force = rng.uniform(-1e5, 1e5, 6)
        theirs = np.linalg.solve(CHAIN, pin.aba(chain, data, x, v, np.linalg.solve(CHAIN.T, force)))
        close(model.acceleration(q, qd, [*force, 0.0], mass, 0.0, 1 << 6)[:6], theirs, 1e-9)


def free_swing(rng, crane, mass):
    """A random start with free sway, without losses, under constant forces near those that hold luff and hoist."""
    without_losses(crane)
    q = np.array(
        [
            0.0,
            rng.uniform(-2, 2),
            rng.uniform(0.6, 1.1),
            rng.uniform(10, 25),
            rng.uniform(-0.3, 0.3),
            rng.uniform(-0.3, 0.3),
            0.0,
        ]
    )
    qd = np.array([0.1, 0.05, 0.0, 0.2, rng.uniform(-0.1, 0.1), rng.uniform(-0.1, 0.1), 0.0])
    force = np.asarray(plant.Crane(crane).gravity(q, mass))[:6] * [0, 0, 1, 1, 0, 0] + rng.uniform(-1e3, 1e3, 6) * [
        1,
        1,
        1,
        1,
        0,
        0,
    ]
    state, inputs = plant.CraneState(), parts.CraneInputs()
    state.q, state.qd = list(q), list(qd)
    inputs.payload, inputs.locked, inputs.external = (mass, 1.0), 1 << 6, [*force, 0.0]
    return state, inputs, force


def test_pinocchio_follows_the_same_trajectory():
    """Its forward dynamics in a Runge-Kutta scheme of this test, against SUNDIALS' ERKStep: 5 s under constant forces,
    free sway."""
    pin = pytest.importorskip("pinocchio")
    rng = np.random.default_rng(21)
    for _ in range(4):
        crane, mass = random_parameters(rng), rng.uniform(5e3, 50e3)
        chain = pinocchio_model(pin, crane, mass, 0.0)
        data = chain.createData()
        state, inputs, force = free_swing(rng, crane, mass)
        x, v, tau = CHAIN @ state.q[:6], CHAIN @ state.qd[:6], np.linalg.solve(CHAIN.T, force)

        def rate(y, chain=chain, data=data, tau=tau):
            return np.concatenate([y[6:], pin.aba(chain, data, y[:6], y[6:], tau)])

        y, h = np.concatenate([x, v]), 0.005
        for _ in range(1000):
            k1 = rate(y)
            k2 = rate(y + h / 2 * k1)
            k3 = rate(y + h / 2 * k2)
            k4 = rate(y + h * k3)
            y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        parts.CraneMotion(crane, 1e-11).advance(state, inputs, 5.0)
        np.testing.assert_allclose(state.q[:6], np.linalg.solve(CHAIN, y[:6]), atol=1e-6, rtol=1e-8)


def mujoco_model(mujoco, c, mass):
    """The same chain in MJCF. MuJoCo requires inertias that satisfy the triangle inequality, so the platform's inertia
    is spread over its axes."""
    tiny = "1e-4 1e-4 1e-4"
    return mujoco.MjModel.from_xml_string(f"""<mujoco><compiler angle="radian" boundinertia="1e-9" boundmass="1e-9"/>
      <option gravity="0 0 -{GRAVITY}" integrator="RK4" timestep="0.002"><flag contact="disable"/></option><worldbody>
      <body><joint type="slide" axis="1 0 0"/><inertial pos="0 0 0" mass="{c.gantry_mass}" diaginertia="1 1 1"/>
      <body><joint type="hinge" axis="0 0 1"/><inertial pos="{-c.counterweight_radius} 0 0" mass="{c.counterweight}"
        diaginertia="{c.slew_inertia} {c.slew_inertia} {c.slew_inertia}"/>
      <body pos="{c.a0} 0 {c.pivot_height}"><joint type="hinge" axis="0 -1 0"/>
        <inertial pos="{c.jib_centre} 0 0" mass="{c.jib_mass}" diaginertia="1e-3 {c.jib_inertia} {c.jib_inertia}"/>
      <body pos="{c.jib} 0 0"><joint type="hinge" axis="0 -1 0"/><inertial pos="0 0 0" mass="1e-6" diaginertia="{tiny}"/>
      <body><joint type="hinge" axis="1 0 0"/><inertial pos="0 0 0" mass="1e-6" diaginertia="{tiny}"/>
      <body><joint type="slide" axis="0 0 -1"/><inertial pos="0 0 0" mass="{mass}" diaginertia="{tiny}"/>
      </body></body></body></body></body></body></worldbody></mujoco>""")


def full_matrix(mujoco, m, d):
    full = np.zeros((6, 6))
    try:
        mujoco.mj_fullM(m, d, full)
    except TypeError:  # before 4.0
        mujoco.mj_fullM(m, full, d.qM)
    return full


@pytest.mark.parametrize("sizes", ["default", "random"])
def test_mujoco_agrees(sizes):
    mujoco = pytest.importorskip("mujoco")
    rng = np.random.default_rng(22)
    for q, qd in states(40):
        c, mass = (parameters(), 33e3) if sizes == "default" else (random_parameters(rng), rng.uniform(5e3, 60e3))
        m = mujoco_model(mujoco, c, mass)
        d, model = mujoco.MjData(m), plant.Crane(c)
        force = RNG.uniform(-1e5, 1e5, 6)
        d.qpos[:], d.qvel[:] = CHAIN @ q[:6], CHAIN @ qd[:6]
        d.qfrc_applied[:] = np.linalg.solve(CHAIN.T, force)
        mujoco.mj_forward(m, d)
        close(np.asarray(model.mass_matrix(q, mass, 0.0))[:6, :6], CHAIN.T @ full_matrix(mujoco, m, d) @ CHAIN, 1e-9)
        both = np.asarray(model.bias(q, qd, mass, 0.0)) + model.gravity(q, mass)
        close(both[:6], CHAIN.T @ d.qfrc_bias, 1e-6)
        ours = model.acceleration(q, qd, [*force, 0.0], mass, 0.0, 1 << 6)
        close(ours[:6], np.linalg.solve(CHAIN, d.qacc), 1e-6)


def test_mujoco_follows_the_same_trajectory():
    """Its own Runge-Kutta steps of 2 ms against SUNDIALS: 4 s under constant forces, free sway."""
    mujoco = pytest.importorskip("mujoco")
    rng = np.random.default_rng(23)
    for _ in range(4):
        c, mass = random_parameters(rng), rng.uniform(5e3, 50e3)
        m = mujoco_model(mujoco, c, mass)
        d = mujoco.MjData(m)
        state, inputs, force = free_swing(rng, c, mass)
        d.qpos[:], d.qvel[:] = CHAIN @ state.q[:6], CHAIN @ state.qd[:6]
        d.qfrc_applied[:] = np.linalg.solve(CHAIN.T, force)
        for _ in range(2000):
            mujoco.mj_step(m, d)
        parts.CraneMotion(c, 1e-11).advance(state, inputs, 4.0)
        np.testing.assert_allclose(state.q[:6], np.linalg.solve(CHAIN, d.qpos), atol=2e-6, rtol=1e-7)


def test_inverse_kinematics_puts_the_spreader_where_it_should_be():
    crane = parameters()
    model = plant.Crane(crane)
    for x, y, z, yaw in [(12, 16, 14, 0), (0, 24, 6.5, 0), (22, 8, 1.6, 0.1), (-12.7, 26.6, 9.1, 0)]:
        q = plant.inverse_kinematics(crane, plant.CranePose(0.0, x, y, z, yaw))
        assert model.payload_position(q) == pytest.approx([x, y, z], abs=1e-12)
        assert q[1] + q[6] == pytest.approx(yaw, abs=1e-12)
    with pytest.raises(ValueError, match="jib reaches"):
        plant.inverse_kinematics(crane, plant.CranePose(0.0, 60.0, 0.0, 5.0, 0.0))
    with pytest.raises(ValueError, match="hoist"):
        plant.inverse_kinematics(crane, plant.CranePose(0.0, 0.0, 24.0, 45.0, 0.0))


def test_velocities_are_the_derivatives_of_positions():
    crane = parameters()
    model = plant.Crane(crane)
    for q, qd in states(20):
        d = 1e-6
        for position, velocity in ((model.tip, model.tip_velocity), (model.payload_position, model.payload_velocity)):
            difference = (np.asarray(position(q + d * qd)) - position(q - d * qd)) / (2 * d)
            assert velocity(q, qd) == pytest.approx(difference, abs=1e-7)
