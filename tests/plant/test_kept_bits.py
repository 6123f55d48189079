"""Docks with everything that a dock can have, to their last bit: a change of the plant that changes a run shows
here."""

from collections.abc import Callable
from typing import Any

import pytest
from cmrc import _core
from cmrc import plant as public
from cmrc_test import run_setup

plant, core = _core.plant, _core.cmrc
SECOND = 10**12
AT_WORK = {"dock.agvs": 2}
DOCKS: dict[str, dict[str, Any]] = {
    "default": {},
    "windy": {"dock.wind_mean_m_s": 12.0, "dock.wind_gust_m_s": 3.0, "dock.wind_direction_deg": 40.0, "run.seed": 3},
    "at sea": {"dock.ship_motion": 1.0, "run.seed": 7},
    "real drives": {
        "dock.stiction": True,
        "dock.gear_losses": True,
        "dock.sway_sensors": 2,
        "dock.drive_delay_us": 250,
    },
    "gantry": {"dock.crane": "gantry"},
    "gantry in wind": {"dock.crane": "gantry", "dock.wind_mean_m_s": 9.0, "dock.stiction": True},
    "rigid": {"dock.crane_model": "rigid"},
    "bdf": {"dock.integrator": "bdf"},
    "jitter": {"run.phase_jitter": True, "run.seed": 5},
}


def bits(settings: dict[str, Any], more: Callable[[Any], None] = lambda config: None) -> str:
    """A tenth of a second with all drives at work and two vehicles that drive: by step the sensors, twice the state."""
    config = run_setup.dock_of(core.config(settings={**AT_WORK, **settings}))
    more(config)
    dock = plant.Dock(config)
    dock.enable_drives(31, 0)
    for agv, speed in enumerate((1500, -700)):
        dock.agv_period(agv, 20000, 0)
        for step in range(5):
            dock.agv_push(agv, speed, 40000 * step, -20000 * step, 0)
    rows = []
    for step in range(1, 21):
        for joint in range(5):
            dock.set_torque_code(joint, (700 - 310 * joint + 90 * step) % 1900 - 950, dock.time)
        dock.advance_to(step * SECOND // 200)
        now = dock.time
        shown = [dock.encoder(joint, now) for joint in range(5)] + [dock.sway(0, now), dock.load_cell(now)]
        shown += [dock.agv_range(1, ray, now) for ray in (3, 90, 171)]
        rows.append(f"{step}: {' '.join(map(str, shown))}")
        if step % 10 == 0:
            rows.append(f"state {dock.state_hash()}")
    return "\n".join(rows) + "\n"


def rated_sensors(config: Any) -> None:
    config.sensors.range_rate, config.sensors.range_dropout = 40.0, 0.2


def differential(config: Any) -> None:
    config.agv.drive = plant.AgvDrive.differential


def vehicles() -> str:
    """Vehicles by themselves, faster and slower than the speed between their two models, forward and back."""
    rows = []
    for options in ({}, {"drive": "differential"}, {"load_mass": 20e3, "load_inertia": 2.6e5}):
        agv = public.Agv(**options)
        for n in range(60):
            speed, front = abs(n % 32 - 16) / 10 - 0.8, abs(n % 20 - 10) / 16 - 0.3
            agv.step(speed, front, -0.4 * front, 0.1, turn=0.5 * front if "drive" in options else 0.0)
            if n % 3 == 0:
                rows.append(f"{n}: {agv.state}")
    return "\n".join(rows) + "\n"


MADE: dict[str, Callable[[], str]] = {
    **{name: lambda settings=settings: bits(settings) for name, settings in DOCKS.items()},
    "rated sensors": lambda: bits({}, rated_sensors),
    "differential": lambda: bits({}, differential),
    "vehicles": vehicles,
}


@pytest.mark.golden
@pytest.mark.parametrize("name", MADE)
def test_a_dock_has_the_bits_that_are_kept(golden: Callable[[str, str], None], name: str) -> None:
    golden(f"docks/{name.replace(' ', '-')}.bits", MADE[name]())
