"""The kernels know the plant as it is: each parameter of crane and drives a tenth larger, against the plant's own
equations (which MuJoCo and Pinocchio check)."""

from __future__ import annotations

import functools
import math
import random
from typing import Any

import numpy as np
import pytest
from cmrc import _core
from cmrc_test import run_setup
from harness import Dsp, from_ti, image_of, to_ti
from test_crane import put_ring, single
from test_torque_builds import BOUND, CLOSED_FORM, NEWTON_EULER

cmrc, plant = _core.cmrc, _core.plant
KEYS = {key["name"]: key for key in cmrc.config_keys()}
# No kernel computes with these: what the plant does by itself, what is checked before the run, the drives' own
# protection.
NOT_THEIRS = {
    "rated_load_kg", "sway_damping", "portal_along_m", "portal_landside_m", "portal_waterside_m", "portal_leg_m", "portal_height_m",
    "torque_lag_s", "stribeck", "stribeck_speed", "brake", "overspeed", "overspeed_time_s", "saturation_time_s", "saturation_swings", "thermal_time_s", "thermal_trip",
}  # fmt: skip
# End stops that inverse kinematics does not go by: those of the rope on the slewing crane, of travel, slewing and
# rotator.
FREE = {"slewing.travel", "slewing.slew", "slewing.hoist", "slewing.rotate", "gantry.rotate"}


def parameters(machine: str) -> list[str]:
    return [name for name in KEYS if name.split(".")[0] == machine]


@functools.cache
def changed(name: str) -> float:
    """A tenth more, or a tenth less where more makes a crane that is refused: too heavy a spreader, a gear too slow for
    the trajectory."""
    default, machine = KEYS[name]["default"], name.split(".")[0]
    for value in (default * 1.1, default * 0.9) if default else (1.0,):
        try:
            run_setup.dock_of(
                cmrc.config(settings={"dock.crane": machine if machine == "gantry" else "slewing", name: value})
            )
        except cmrc.ConfigError:
            continue
        return float(value)
    raise AssertionError(f"{name} can neither grow nor shrink by a tenth")


def known(name: str) -> bool:
    table, _, field = name.rpartition(".")
    return not (field in NOT_THEIRS or field.startswith(("lower_", "upper_")) and table in FREE)


def constants(**settings: Any) -> list[int]:
    dsp = Dsp(**settings)
    s = dsp.symbols
    tables = s["gantry_masses"]
    return [
        *dsp.chip.read(s["constants"], s["constants_end"] - s["constants"]),
        *dsp.chip.read(tables, s["gantry_travel"] - tables),
    ]


@pytest.mark.parametrize("machine", ["slewing", "gantry"])
def test_each_parameter_that_a_kernel_needs_changes_its_constants_and_no_other_does(machine: str) -> None:
    usual = constants(dock__crane=machine)
    for name in parameters(machine):
        differs = constants(**{"dock__crane": machine, name.replace(".", "__"): changed(name)}) != usual
        assert differs == known(name), name
    image_of.cache_clear()


def test_what_every_plant_has_alike_is_put_there_too() -> None:
    """By hand: gravity, half of the scanner's 8 mm, 12 bits of sway over 10 degrees, 100 Hz of it at 8 kHz, 2 % of a
    rated speed of 10000."""
    dsp = Dsp()
    lift = dsp.symbols["LIFT"]
    for name, value in (
        ("K_GRAVITY", 9.81),
        ("K_ONE_OVER_G", 1 / 9.81),
        ("K_ID_QUANTUM", 0.004),
        ("K_PD_SWAY_UNIT", math.radians(10) / 2048),
    ):
        assert dsp.chip.peek(dsp.symbols[name] + lift) == to_ti(value), name
    for name, word in (("K_PD_SAMPLE", 80), ("K_PD_TURNS", 200)):
        assert dsp.chip.peek(dsp.symbols[name] + lift) == word, name


def vehicles() -> list[str]:
    return [
        f"agv.{name}"
        for name in (
            "mass_kg",
            "length_m",
            "width_m",
            "front_axle_m",
            "rear_axle_m",
            "cornering_n_rad",
            "steer_limit_deg",
            "acceleration_m_s2",
            "braking_m_s2",
        )
    ]


@pytest.mark.parametrize(("braking", "emergency", "weaker"), [(1.0, 2.0, 1.0), (1.0, 0.4, 0.4), (0.3, 2.0, 0.3)])
def test_vehicles_plan_with_the_weaker_of_their_brakes(braking: float, emergency: float, weaker: float) -> None:
    """Planning brakes with 0.8 of what the drive can do, avoidance with 0.9: its ramp, and its brakes' greatest
    force."""
    dsp = Dsp(agv__braking_m_s2=braking, agv__emergency_m_s2=emergency)
    for name, share in (("K_TA_BRAKE", 0.8), ("K_AV_B", 0.9)):
        word = dsp.chip.peek(dsp.symbols[name] + dsp.symbols["LIFT"])
        assert from_ti(word) == pytest.approx(share * weaker, rel=1e-6), name


def test_so_do_the_vehicles() -> None:
    usual = constants()
    assert all(constants(**{name.replace(".", "__"): changed(name)}) != usual for name in vehicles())


def wanted(
    model: Any, p: Any, joints: tuple[int, ...], load: float, q: list[float], qd: list[float], qdd: list[float]
) -> list[float]:
    """Motor torques of the rigid crane by the plant's matrices; coordinates s, psi, phi, l, alpha, beta, kappa."""
    inertia = p.spreader_inertia + (12.192**2 + 2.438**2) / 12 * max(0.0, load - p.spreader_mass)
    full = [[*v[:4], 0.0, 0.0, v[4]] for v in (q, qd, qdd)]
    force = (
        np.asarray(model.mass_matrix(full[0], load, inertia)) @ full[2]
        + model.bias(full[0], full[1], load, inertia)
        + model.gravity(full[0], load)
    )
    torques = []
    for j in joints:
        d, v, k = p.drives[j], qd[j], (0, 1, 2, 3, 6)[j]
        rated, top = d.gear * d.rated_torque, d.rated_speed / d.gear
        friction = rated * (d.coulomb * math.tanh(v / (d.smooth_speed * top)) + d.viscous * v / top)
        torques.append((force[k] + friction) / (d.gear * d.efficiency))
    return torques


@pytest.mark.parametrize("build", [CLOSED_FORM, NEWTON_EULER])
@pytest.mark.parametrize("machine", ["slewing", "gantry"])
def test_torque_compensation_is_the_plants_inverse_dynamics_whatever_its_parameters(machine: str, build: str) -> None:
    r = random.Random(11)
    gantry = machine == "gantry"
    kernel = "torque_gantry" if gantry and build == CLOSED_FORM else build
    joints = (0, 2, 3, 4) if gantry else (0, 1, 2, 3, 4)
    channels = (1, 2, 3, 4) if gantry else joints
    for name in [name for name in parameters(machine) if known(name)]:
        settings = {"dock.crane": machine, name: changed(name)}
        p = run_setup.dock_of(cmrc.config(settings=settings)).crane
        model = plant.Crane(p)
        dsp = Dsp(**{key.replace(".", "__"): value for key, value in settings.items()})
        dsp.servo_rates(consumed=2)
        for _ in range(2):
            load = round(r.uniform(10e3, 50e3))
            if gantry:
                q = [
                    single(r.uniform(-20, 20)),
                    math.pi / 2,
                    *(single(r.uniform(a, b)) for a, b in ((-30, 38), (4, 48), (-3, 3))),
                ]
                qd, qdd = (
                    [single(r.uniform(-v, v)) if v else 0.0 for v in span]
                    for span in ((0.7, 0.0, 2.3, 1.0, 0.1), (0.1, 0.0, 0.5, 0.3, 0.03))
                )
            else:
                q = [single(r.uniform(a, b)) for a, b in ((-40, 40), (-3, 3), (0.4, 1.35), (5, 43), (-3, 3))]
                qd, qdd = (
                    [single(r.uniform(-v, v)) for v in span]
                    for span in ((0.5, 0.12, 0.05, 1.0, 0.1), (0.1, 0.02, 0.01, 0.3, 0.03))
                )
            row = [[0.0, v[0], *v[2:]] if gantry else v for v in (q, qd, qdd)]
            for slot in (0, 1):
                put_ring(dsp, slot, *row)
            dsp.hang(load)
            assert dsp.run(kernel, tick=8)[:2] == (load << 8, 0)
            got = dsp.floats("CR_FEED_FORWARD", 5)
            for channel, j, want in zip(channels, joints, wanted(model, p, joints, load, q, qd, qdd), strict=True):
                most = max(p.drives[j].peak, 1.5) * p.drives[j].rated_torque
                assert got[channel] == pytest.approx(want, abs=1.2 * BOUND[build] * 2**-23 * most), (name, j)
    image_of.cache_clear()


@pytest.mark.parametrize(
    "name",
    ["slewing.a0_m", "slewing.jib_m", "slewing.pivot_height_m", "slewing.luff.lower_deg", "slewing.luff.upper_deg"],
)
def test_inverse_kinematics_puts_the_load_where_it_should_be(name: str) -> None:
    r = random.Random(12)
    p = run_setup.dock_of(cmrc.config(settings={name: changed(name)})).crane
    model = plant.Crane(p)
    dsp = Dsp(**{name.replace(".", "__"): changed(name)})
    for k in range(20):
        x, y, z, yaw = (single(r.uniform(a, b)) for a, b in ((-12, 12), (14, 18), (2, 16), (-0.3, 0.3)))
        dsp.put("CR_POINT", x, y, z, yaw, *[0.0] * 10, offset=(k & 1) * 16)
        dsp.run("inverse_crane", argument=k)
        q = dsp.floats("CR_RING", 5, offset=(k & 3) * 16)
        assert list(model.payload_position([*q[:4], 0.0, 0.0, q[4]])) == pytest.approx([x, y, z], abs=3e-5)
        assert q[1] + q[4] == pytest.approx(yaw, abs=1e-6)
