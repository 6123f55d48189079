"""Crane, drives and vehicles as keys: every parameter of the plant is one, kernels know the plant's own, and what
cannot work is refused."""

import math
from typing import Any

import numpy as np
import pytest
from cmrc import _core
from cmrc_test import run_setup
from low_rates import AT_ONCE_AND_LOW

cmrc, plant = _core.cmrc, _core.plant
KEYS = {key["name"]: key for key in cmrc.config_keys()}
TABLES = ("slewing", "gantry", "agv", "landing")
MINE = [name for name in KEYS if name.split(".")[0] in TABLES]
RATES: dict[str, Any] = {**AT_ONCE_AND_LOW, "report.signal_decimation": 4}
# Soft loops that hardly react to the sway sensor's noise: a torque that the feed-forward does not know moves them.
SOFT = {
    "control.sway_gain_m_s_rad": 0.0,
    **{f"control.{joint}_bandwidth_rad_s": 5.0 for joint in ("travel", "slew", "luff", "trolley", "hoist", "rotator")},
}


def numbers(of: Any, path: str = "") -> dict[str, float]:
    """Every number among the attributes of a parameters' class, lists and classes inside it too."""
    found: dict[str, float] = {}
    for name in dir(of):
        if name.startswith("_") or callable(value := getattr(of, name)):
            continue
        here = f"{path}.{name}"
        if (
            isinstance(value, bool)
            or isinstance(type(of).__dict__.get(name), property)
            and type(of).__dict__[name].fset is None
        ):
            continue
        if isinstance(value, int | float):
            found[here] = float(value)
        elif isinstance(value, list | tuple):
            for i, element in enumerate(value):
                if isinstance(element, float):
                    found[f"{here}[{i}]"] = element
                else:
                    found |= numbers(element, f"{here}[{i}]")
        elif type(value).__name__ == "Portal":
            found |= numbers(value, here)
    return found


def dock_of(**settings: Any) -> Any:
    return run_setup.dock_of(cmrc.config(settings=settings))


def parts(dock: Any) -> dict[str, float]:
    return {**numbers(dock.crane, "crane"), **numbers(dock.agv, "agv"), **numbers(dock.landing, "landing")}


def larger(name: str) -> float:
    """A tenth more, where that is allowed; a limit of 0 moves by one."""
    key = KEYS[name]
    value = key["default"] * 1.1 if key["default"] else key["default"] + 1.0
    return float(value if value <= key["maximum"] else key["default"] * 0.9)


# What has no key of its own name. Of either machine: the other one's geometry.
ELSEWHERE = {"landing.guide_window": "dock.capture_window_m"}
NOT_OF_A_GANTRY = {
    "crane.a0", "crane.jib", "crane.slew_inertia", "crane.jib_centre", "crane.jib_inertia", "crane.counterweight", "crane.counterweight_radius",
    "crane.lower[1]", "crane.upper[1]",
}  # fmt: skip


@pytest.mark.parametrize("machine", ["slewing", "gantry"])
def test_every_parameter_of_the_plant_is_one_key(machine: str) -> None:
    keys = [name for name in MINE if name.split(".")[0] in (machine, "agv", "landing")]
    config = cmrc.config(settings={"dock.crane": machine})
    before = parts(run_setup.dock_of(config))
    reached: dict[str, str] = {}
    for name in keys:
        # A tenth of a parameter may make a dock that is refused as a whole; the smallest step shows which one it is.
        default = KEYS[name]["default"]
        try:
            after = parts(dock_of(**{"dock.crane": machine, name: default * (1 + 1e-9) or 1e-9}))
        except cmrc.ConfigError:
            after = parts(dock_of(**{"dock.crane": machine, name: default * (1 - 1e-9)}))
        [changed] = [path for path in before if before[path] != after[path]]
        assert changed not in reached, (name, reached[changed])
        reached[changed] = name
    missing = set(before) - set(reached) - set(ELSEWHERE)
    if machine == "gantry":
        missing -= NOT_OF_A_GANTRY | {path for path in before if path.startswith("crane.drives[1]")}
    assert missing == set()


def test_a_machine_does_not_mind_the_other_ones_parameters() -> None:
    assert parts(dock_of(**{"gantry.trolley_mass_kg": 3e4})) == parts(dock_of())
    assert parts(dock_of(**{"dock.crane": "gantry", "slewing.jib_m": 40.0})) == parts(
        dock_of(**{"dock.crane": "gantry"})
    )


def test_degrees_are_degrees_and_an_untouched_default_keeps_its_bits() -> None:
    crane = dock_of(**{"slewing.luff.lower_deg": 25.0}).crane
    assert crane.lower[2] == pytest.approx(math.radians(25)) and crane.upper[2] == plant.CraneParameters().upper[2]
    assert parts(dock_of()) == {**parts(plant.default_dock(1))}
    config = cmrc.config(settings={"slewing.luff.lower_deg": 25.0, "agv.mass_kg": 26e3})
    again = cmrc.config(toml=config.to_toml())
    assert parts(run_setup.dock_of(again)) == parts(run_setup.dock_of(config)) and again.to_dict() == config.to_dict()


# ---- at rest


def drift(machine: str, **settings: Any) -> np.ndarray:
    """How far each joint leaves its place within 0.13 s of the drives' being on, before the first leg has moved the
    crane: in counts of its encoder."""
    config = cmrc.config(settings={**RATES, "dock.crane": machine, "duration_s": 0.17, **SOFT, **settings})
    simulation = cmrc.Simulation(config)
    simulation.run()
    signals = simulation.signals()
    crane = run_setup.dock_of(config).crane
    joints = ("s", "psi", "phi", "l", "kappa") if machine == "slewing" else ("s", "psi", "trolley", "l", "kappa")
    columns = [next(n for n in signals if n in (f"{joint}_m", f"{joint}_rad")) for joint in joints]
    moved = np.array([np.ptp(signals[column]) for column in columns])
    return np.asarray(moved * [16384 / (2 * math.pi) * drive.gear for drive in crane.drives])


@pytest.mark.parametrize("machine", ["slewing", "gantry"])
def test_no_parameter_leaves_an_offset_at_rest(machine: str) -> None:
    """A tenth more of each parameter. If a kernel did not know of it, a joint would move as soon as the brakes open, or
    with the first set-point."""
    usual = drift(machine)
    tables = (machine,) if machine == "gantry" else ("slewing", "agv", "landing")
    offsets = {}
    for name in (name for name in MINE if name.split(".")[0] in tables):
        try:
            offsets[name] = drift(machine, **{name: larger(name)})
        except cmrc.ConfigError:  # too heavy a spreader, a gear too slow for the trajectory: then a tenth less
            offsets[name] = drift(machine, **{name: KEYS[name]["default"] * 0.9})
    beyond = {name: moved.round(1).tolist() for name, moved in offsets.items() if (moved > 1.5 * usual + 4).any()}
    assert beyond == {}, usual


@pytest.mark.parametrize(("key", "joint"), [("control.hoist_feed_forward", 3), ("control.luff_feed_forward", 2)])
def test_such_an_offset_would_be_seen(key: str, joint: int) -> None:
    """A tenth less torque on load and jib acts like a tenth more mass that no kernel knows of."""
    assert drift("slewing", **{key: 0.9})[joint] > 1.5 * drift("slewing")[joint] + 4


@pytest.mark.parametrize(
    ("drive", "limit"),
    [
        ("slewing.slew", "slew_speed_limit_rad_s"),
        ("slewing.hoist", "hoist_speed_limit_m_s"),
        ("gantry.trolley", "trolley_speed_limit_m_s"),
    ],
)
def test_a_speed_limit_is_held_against_the_configured_drive(drive: str, limit: str) -> None:
    """With a third of a drive's rated speed the usual limit is above what the drive can do; a lower one is not."""
    rated, key = f"{drive}.rated_speed_rad_s", f"control.{limit}"
    settings = {
        "dock.crane": drive.split(".")[0],
        rated: KEYS[rated]["default"] / 3,
        "report.reference": "none",
        "duration_s": 1.0,
        **SOFT,
    }
    with pytest.raises(cmrc.ConfigError, match=f"{key}: .* is above the drive's rated speed"):
        cmrc.Simulation(cmrc.config(settings=settings))
    cmrc.Simulation(cmrc.config(settings={**settings, key: KEYS[key]["default"] / 3.5, "dock.ramp_speed_m_s": 0.1}))
