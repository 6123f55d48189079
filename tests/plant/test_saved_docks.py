"""A dock that is saved at any instant and loaded into another continues bit for bit, with what it has recorded."""

import math
import random
from typing import Any

import numpy as np
import pytest
from cmrc._core import plant
from controller import LATCH, Crane, quiet_dock
from leaves import check_that_every_value_is_loaded, check_that_other_bytes_are_refused

SECOND = 10**12


class Heard:
    """A dock that records each call of a device with its answer."""

    def __init__(self, config: plant.DockConfig) -> None:
        self.dock, self.calls = plant.Dock(config), []

    def __getattr__(self, name: str) -> Any:
        found = getattr(self.dock, name)
        if not callable(found):
            return found

        def call(*arguments: Any) -> Any:
            answer = found(*arguments)
            self.calls.append((name, arguments, answer))
            return answer

        return call


def read_everything(dock: Any, t: int) -> None:
    for joint in range(5):
        (
            dock.encoder_total(joint, t),
            dock.drive_status(joint, t),
            dock.drive_speed(joint, t),
            dock.drive_trip(joint, t),
            dock.drive_heat(joint, t),
        )
    for axis in range(2):
        dock.sway(axis, t)
    dock.load_cell(t), dock.wind_mean(t), dock.spreader_status(t), dock.scan_y(t), dock.profile(64, t)
    for agv in range(dock.agv_count):
        (
            dock.agv_x(agv, t),
            dock.agv_speed(agv, t),
            dock.agv_status(agv, t),
            dock.agv_range(agv, 90, t),
            dock.range_scan(agv, t),
            dock.range_way(agv, t),
        )


def land(dock: Any, rng: random.Random) -> None:
    """The crane lands on the container at x = 12.7 m, locks and lifts it. Devices are read between latches."""
    crane = Crane(dock)
    crane.hold(0.2)
    read_everything(dock, crane.t + rng.randrange(LATCH))
    crane.t += 8 * LATCH
    top = 6.5
    crane.move(crane.pose(12.7, 24.0, top + 0.05), 3.0)
    crane.move(crane.pose(12.7, 24.0, top - 0.08), 2.0)
    dock.spreader_command(1, crane.t)
    for _ in range(14):
        crane.hold(0.1)
        read_everything(dock, crane.t + rng.randrange(8 * LATCH))
        crane.t += 8 * LATCH
    crane.move(crane.pose(12.7, 24.0, top + 0.7), 1.5)


def drive_on(dock: Any, rng: random.Random) -> None:
    """Codes at random, vehicles that run into each other, sensors and drives that fail and are repaired, at random
    instants."""
    t = 0
    dock.enable_drives(0x1F, 0)
    switches = ["fail_encoder", "fail_drive", "fail_drive_status", "fail_drive_speed"]
    for step in range(600):
        t += rng.randrange(1, 320 * LATCH)
        for agv in (0, 1):
            dock.agv_period(agv, 50000, t)
            dock.agv_push(agv, 1500 if agv == 1 else 0, rng.randrange(-20000, 20000), 0, t)
        for joint in range(5):
            if rng.random() < 0.7:
                dock.set_torque_code(joint, round(900 * math.sin(t / SECOND + joint)), t)
        kind = rng.randrange(12)
        if kind < 4:
            getattr(dock, switches[kind])(rng.randrange(5), rng.random() < 0.3, t)
        elif kind == 4:
            dock.fail_sway(rng.randrange(2), rng.random() < 0.5, t)
        elif kind == 5:
            dock.fail_load_cell(rng.random() < 0.5, t)
        elif kind == 6:
            dock.fail_anemometer(rng.random() < 0.5, t)
        elif kind == 7:
            dock.enable_drives(0x1F if rng.random() < 0.9 else 0x15, t)
        elif kind == 8:
            dock.select_row(rng.randrange(dock.scan_rows()), t)
        elif kind == 9:
            dock.agv_reset_bumper(rng.randrange(2), t)
        if step % 20 == 0:
            t += rng.randrange(LATCH)
            read_everything(dock, t)


def quiet() -> plant.DockConfig:
    config = quiet_dock()
    config.signal_decimation, config.signal_rows_max = 16, 100  # rows are thinned more than once
    return config


def moving() -> plant.DockConfig:
    config = quiet()
    config.wind.mean, config.wind.gust = 8.0, 2.0
    config.sensors.range_rate, config.sensors.range_dropout, config.drive_delay = 20.0, 0.1, 3
    config.ship.scale = 1.0
    return config


def crowded() -> plant.DockConfig:
    config = plant.default_dock(2)
    config.signal_decimation, config.signal_rows_max = 8, 200
    config.wind.mean, config.wind.gust = 12.0, 3.0
    config.drive_timeout = 0.06
    config.agv.protective_field = False
    return config


SCENES = {
    "landing": (quiet, land),
    "landing on a ship in wind": (moving, land),
    "collision and faults": (crowded, drive_on),
}


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.campaign) for seed in range(2, 7))])
def test_a_dock_continues_in_another_one_at_any_instant(scene: str, seed: int) -> None:
    config, course = SCENES[scene]
    rng = random.Random(seed)
    whole = Heard(config())
    course(whole, rng)
    kinds = {event.kind for event in whole.events}
    assert ({"collision", "drive_stopped"} if course is drive_on else {"near_contact", "touch"}) <= kinds
    cuts = set(rng.sample(range(len(whole.calls)), 40))
    dock = plant.Dock(config())
    for number, (name, arguments, answer) in enumerate(whole.calls):
        assert getattr(dock, name)(*arguments) == answer, (number, name, arguments)
        if number in cuts:
            state = dock._state()
            dock = plant.Dock(config())
            dock._load_state(state)
            assert dock._state() == state
    assert dock._state_difference(whole.dock) is None
    for what in ("events", "switches", "signals", "agv_signals"):
        assert repr_of(getattr(dock, what)) == repr_of(getattr(whole.dock, what)), what


def repr_of(rows: Any) -> list[Any]:
    def plain(row: Any) -> Any:
        if isinstance(row, list):
            return [plain(part) for part in row]
        names = [name for name in dir(row) if not name.startswith("_")]
        if names and not isinstance(row, (int, float, str, np.ndarray)):
            return [plain(getattr(row, name)) for name in names]
        return row

    return [plain(row) for row in rows]


def some_dock() -> plant.Dock:
    return plant.Dock(moving())


def test_every_value_of_a_dock_is_loaded() -> None:
    dock = some_dock()
    dock.enable_drives(0x1F, 0)
    for step in range(4):
        dock.set_torque_code(1, 100 * step, step * 16 * LATCH)
        dock.agv_push(0, 500, 0, 0, step * 16 * LATCH)
    dock.fail_encoder(2, True, 70 * LATCH + 5)
    assert check_that_every_value_is_loaded(some_dock, dock) > 600


def test_a_state_that_is_none_of_this_dock_is_refused() -> None:
    check_that_other_bytes_are_refused(some_dock, some_dock()._state())
    with pytest.raises(ValueError, match="other AGVs or containers"):
        plant.Dock(plant.default_dock(2))._load_state(some_dock()._state())


def test_calls_before_the_last_one_are_refused_as_they_were() -> None:
    dock, other = some_dock(), some_dock()
    dock.encoder(0, LATCH // 2)
    other._load_state(dock._state())
    with pytest.raises(ValueError, match="nondecreasing"):
        other.encoder(0, LATCH // 2 - 1)
