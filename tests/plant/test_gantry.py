"""The ship-to-shore gantry, the second machine by configuration: against MuJoCo, against the textbook's cart with a
pendulum, and in the dock."""

import math

import numpy as np
import pytest
from cmrc import plant as public
from cmrc._core import plant
from cmrc_test import plant as parts
from lossless import without_losses

G = 9.81
HALF = math.pi / 2


def lossless():
    return without_losses(plant.gantry_crane(), rotors=False)


def test_mujoco_agrees():
    """Slides along and across the quay, two hinges, a sliding rope: psi is held, so its row does not count."""
    mujoco = pytest.importorskip("mujoco")
    p, mass = lossless(), 31e3
    tiny = "1e-4 1e-4 1e-4"
    m = mujoco.MjModel.from_xml_string(f"""<mujoco><compiler angle="radian" boundinertia="1e-9" boundmass="1e-9"/>
      <option gravity="0 0 -{G}"><flag contact="disable"/></option><worldbody>
      <body><joint type="slide" axis="1 0 0"/><inertial pos="0 0 0" mass="{p.gantry_mass}" diaginertia="1 1 1"/>
      <body pos="0 0 {p.pivot_height}"><joint type="slide" axis="0 1 0"/><inertial pos="0 0 0" mass="{p.jib_mass}" diaginertia="1 1 1"/>
      <body><joint type="hinge" axis="1 0 0"/><inertial pos="0 0 0" mass="1e-6" diaginertia="{tiny}"/>
      <body><joint type="hinge" axis="0 1 0"/><inertial pos="0 0 0" mass="1e-6" diaginertia="{tiny}"/>
      <body><joint type="slide" axis="0 0 -1"/><inertial pos="0 0 0" mass="{mass}" diaginertia="{tiny}"/>
      </body></body></body></body></body></worldbody></mujoco>""")
    d, model, rng = mujoco.MjData(m), plant.Crane(p), np.random.default_rng(4)
    order = [0, 2, 4, 5, 3]  # s, trolley, alpha, beta, l
    for _ in range(40):
        q = np.array(
            [
                rng.uniform(-9, 9),
                HALF,
                rng.uniform(-30, 38),
                rng.uniform(5, 40),
                rng.uniform(-0.5, 0.5),
                rng.uniform(-0.5, 0.5),
                0.3,
            ]
        )
        qd = np.array(
            [0.3, 0.0, rng.uniform(-2, 2), rng.uniform(-1, 1), rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3), 0.0]
        )
        d.qpos[:], d.qvel[:] = q[order], qd[order]
        force = rng.uniform(-1e4, 1e4, 7)
        d.qfrc_applied[:] = force[order]
        mujoco.mj_forward(m, d)
        both = np.asarray(model.bias(q, qd, mass, 0.0)) + model.gravity(q, mass)
        np.testing.assert_allclose(both[order], d.qfrc_bias, atol=1e-6 * np.abs(d.qfrc_bias).max())
        force[[1, 6]] = 0.0
        ours = np.asarray(model.acceleration(q, qd, force, mass, 1.0, 0b1000010))
        np.testing.assert_allclose(ours[order], d.qacc, atol=1e-6 * np.abs(d.qacc).max())


def test_trolley_with_a_hanging_load_swings_with_the_pendulums_and_the_carts_frequency():
    p, mass, length = lossless(), 40e3, 20.0
    state, inputs = plant.CraneState(), parts.CraneInputs()
    state.q = [0, HALF, 10.0, length, 1e-4, 0, 0]
    inputs.payload, inputs.locked = (mass, 1e5), 0b1001011  # trolley and sway are free
    w = math.sqrt(G / length * (1 + mass / p.jib_mass))
    parts.CraneMotion(p, 1e-11).advance(state, inputs, math.pi / w)
    assert state.q[4] == pytest.approx(-1e-4, rel=1e-6)
    assert state.q[2] - 10.0 == pytest.approx(2e-4 * length * mass / (mass + p.jib_mass), rel=1e-5)


def test_kinetic_energy_is_that_of_the_moving_masses():
    p = lossless()
    model = plant.Crane(p)
    q, qd = [1, HALF, 12, 20, 0.2, -0.1, 0.3], np.array([0.4, 0, 1.5, -0.6, 0.1, 0.2, 0.05])
    h = 1e-6
    load = (np.array(model.payload_position(q + h * qd)) - model.payload_position(q - h * qd)) / (2 * h)
    want = 0.5 * (p.gantry_mass * 0.16 + p.jib_mass * (0.16 + 1.5**2) + 3e4 * load @ load + 2e5 * 0.05**2)
    assert model.kinetic_energy(q, qd, 3e4, 2e5) == pytest.approx(want, rel=1e-8)
    assert model.tip(q) == pytest.approx([1, 12, p.pivot_height])


def test_the_gantry_from_python():
    crane = public.Crane(machine="gantry", load_mass=2e4, home=(0, 0, 16, 14, 0), bookkeeping=True)
    assert crane.payload() == pytest.approx([0, 16, 14])
    hold = crane.bias()[3] / (crane.parameters.drives[3].gear * crane.parameters.drives[3].efficiency)
    before = crane.energy()
    crane.run([0, 1e6, 600, hold, 0], 1e-3, 3000)
    state, w = crane.state, crane.work
    assert state.q[2] > 16.5 and state.q[1] == HALF and abs(state.q[4]) > 1e-3
    assert crane.energy() - before == pytest.approx(
        w.motors - w.gears - w.friction - w.damping + w.external - w.impacts, abs=1.0
    )
    with pytest.raises(ValueError, match="machine"):
        public.Crane(machine="tower")
    with pytest.raises(ValueError, match="trolley"):
        public.Crane(machine="gantry", home=(0, 0, 60, 14, 0))


def test_the_gantry_in_the_dock():
    scene = public.Scene(public.gantry_dock())
    start = scene.signal
    assert start.payload == pytest.approx([0, -8, 14]) and start.tip == pytest.approx([0, -8, 34])
    hold = -10e3 * G * 0.00955 / 0.88  # the empty spreader
    for _ in range(1000):
        scene.step([0, 1e6, 200.0, hold, 0], 1e-3)  # however hard what does not slew is pushed
    assert scene.signal.q[1] == HALF and scene.signal.payload[0] == pytest.approx(0.0, abs=1e-9)
    assert scene.signal.payload[1] > start.payload[1] and scene.signal.payload[2] == pytest.approx(14, abs=0.1)


def test_a_gantrys_psi_stays_when_the_load_is_pushed_sideways():
    """The gantry's psi is fixed: no brake can slip under any load at the end of the boom."""
    config = public.gantry_dock()
    config.wind.mean, config.wind.direction, config.wind.spreader_area = (
        80.0,
        0.0,
        5000.0,
    )  # 2e7 N on the load, along the quay
    scene = public.Scene(config)
    for _ in range(50):
        scene.step([0, 0, 0, 0, 0], 1e-3)
    assert scene.signal.q[1] == HALF and abs(scene.signal.beta) > 0.05


def test_the_held_slewing_has_its_row_of_the_mass_matrix_too():
    """Column of psi by the masses' x as psi turns: trolley and load across the quay, a counterweight behind."""
    crane = public.Crane(
        machine="gantry", counterweight=40e3, counterweight_radius=5.0, home=(0.0, 0.0, 12.0, 14.0, 0.0), load_mass=20e3
    )
    q, m = crane.state.q, crane.mass_matrix()
    p = crane.parameters
    assert m[0, 1] == m[1, 0] == pytest.approx(40e3 * 5.0 - (p.jib_mass + p.spreader_mass + 20e3) * q[2])


@pytest.mark.parametrize("make", [plant.default_dock, plant.gantry_dock])
@pytest.mark.parametrize("agvs", range(17))
def test_every_number_of_vehicles_has_its_loop(make, agvs):
    legs = make(agvs).layout.legs
    assert all(segment.length >= 0.0 for lane in legs for segment in lane)
    plant.Dock(make(agvs))
