"""Ranges, defaults and the parameters of both docks, as they are kept in tests/golden: a change of a number shows
there."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from cmrc import _core
from cmrc_test import run_setup

core = _core.cmrc


def dock(**settings: Any) -> Any:
    return run_setup.dock_of(core.config(settings={name.replace("__", "."): value for name, value in settings.items()}))


def lines_of(value: Any, name: str) -> Iterator[str]:
    """Each number of a structure of the plant, with its way there."""
    if isinstance(value, (list, tuple)):
        for place, one in enumerate(value):
            yield from lines_of(one, f"{name}[{place}]")
    elif type(value).__module__.startswith("cmrc") and not hasattr(type(value), "__members__"):
        for field in dir(value):
            if not field.startswith("_") and not callable(getattr(value, field)):
                yield from lines_of(getattr(value, field), f"{name}.{field}" if name else field)
    else:
        yield f"{name} {value!r}"


def keys() -> str:
    rows = []
    for key in core.config_keys():
        range_of = "|".join(key["choices"]) or f"{key['minimum']:.10g} to {key['maximum']:.10g}"
        rows.append(
            f"{key['name']} {key['type']} [{key['unit']}] {range_of}; {key['default']!r}{' live' if key['live'] else ''}\n"
        )
    return "".join(rows)


def presets() -> str:
    """What each preset changes of the configuration as it is printed."""
    base = set(core.config().to_toml().splitlines())
    rows = []
    for name in core.presets():
        rows += [f"{name}: {line}\n" for line in core.config(preset=name).to_toml().splitlines() if line not in base]
    return "".join(rows)


MADE: dict[str, Callable[[], str]] = {
    "keys.table": keys,
    "presets.table": presets,
    "dock-slewing.table": lambda: "\n".join(lines_of(dock(dock__agvs=3), "")) + "\n",
    "dock-gantry.table": lambda: "\n".join(lines_of(dock(dock__agvs=3, dock__crane="gantry"), "")) + "\n",
}


@pytest.mark.golden
@pytest.mark.parametrize("name", MADE)
def test_a_table_is_as_it_is_kept(golden: Callable[[str, str], None], name: str) -> None:
    golden(name, MADE[name]())


def test_a_number_beyond_an_end_of_its_range_is_refused() -> None:
    numbers = [key for key in core.config_keys() if key["type"] in ("integer", "number")]
    assert len(numbers) > 400
    for key in numbers:
        name, whole = key["name"], key["type"] == "integer"
        for end, step in ((key["minimum"], -1), (key["maximum"], 1)):
            if abs(end) == float("inf"):
                continue
            beyond = int(end) + step if whole else end + step * max(1e-9, abs(end) * 1e-9)
            said = "it is taken"
            try:
                core.config(settings={name: beyond})
            except ValueError as error:
                said = str(error)
            assert name in said and "out of range" in said, (name, beyond, said)


REACHED = [
    ("dock.protective_field", True, "agv.protective_field", True),
    ("dock.container_mass_kg", 12345.0, "layout.container_mass", 12345.0),
    ("dock.container_mass_kg", 12345.0, "layout.containers[0].mass", 12345.0),
    ("dock.agv_speed_m_s", 1.25, "layout.legs[0][0].speed", 1.25),
    ("dock.sway_sensors", 1, "sensors.second_sway", False),
    ("dock.crane_model", "rigid", "rigid", True),
    ("dock.integrator", "bdf", "method", _core.plant.Method.bdf),
    ("dock.stiction", True, "crane.stiction", True),
    ("dock.gear_losses", True, "crane.gear_losses", True),
    ("dock.strict_landing", True, "landing.strict", True),
    ("dock.capture_window_m", 0.2, "landing.guide_window", 0.2),
    ("dock.capture_window_m", 0.0, "landing.guides", False),
    ("dock.ship_motion", 0.5, "ship.scale", 0.5),
    ("dock.wind_mean_m_s", 7.0, "wind.mean", 7.0),
    ("dock.wind_direction_deg", 90.0, "wind.direction", 1.5707963267948966),
    ("run.seed", 5, "sensors.seed", 5),
    ("run.seed", 5, "ship.seed", 5),
    ("run.seed", 5, "wind.seed", 5),
    ("dock.drive_timeout_ms", 50.0, "drive_timeout", 0.05),
    ("dock.drive_delay_us", 250, "drive_delay", 2),
    ("report.signal_decimation", 40, "signal_decimation", 40),
    ("report.signal_rows_max", 1024, "signal_rows_max", 1024),
    ("dock.agvs", 3, "agv_count", 3),
]  # fmt: skip


@pytest.mark.parametrize(("key", "value", "place", "reached"), REACHED)
def test_a_setting_reaches_the_dock(key: str, value: Any, place: str, reached: Any) -> None:
    found: Any = run_setup.dock_of(core.config(settings={key: value}))
    for part in place.replace("[", ".[").split("."):
        found = found[int(part[1:-1])] if part.startswith("[") else getattr(found, part)
    assert found == pytest.approx(reached) if isinstance(reached, float) else found == reached


def test_a_layout_lists_its_own_containers_and_gives_those_without_a_mass_the_docks(tmp_path: Path) -> None:
    layout = tmp_path / "layout.toml"
    layout.write_text(
        "containers = [{x_m = 2, y_m = 24}, {x_m = 18, y_m = 24, mass_kg = 5000}]\n[warehouse]\ntake_s = 3\n"
    )
    made = dock(dock__layout=str(layout), dock__container_mass_kg=20000.0)
    assert [container.mass for container in made.layout.containers] == [20000.0, 5000.0]
    assert made.layout.warehouse_take == 3.0


def test_gusts_reach_the_dock() -> None:
    assert dock(dock__wind_mean_m_s=7.0, dock__wind_gust_m_s=3.0).wind.gust == 3.0
