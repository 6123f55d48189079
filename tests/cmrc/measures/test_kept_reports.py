"""Short scenes, each with its hash and a digest of each part of its report: a change of the emulator that changes a run
or what the report says of it shows here, by scene and part."""

from collections.abc import Callable
from typing import Any

import cmrc
import pytest
from cmrc import _core
from digests import digest

HOST_ONLY = ("elapsed_s", "reference_elapsed_s", "emulator_version")


def event(at_s: float, action: str, **more: Any) -> dict[str, Any]:
    return {"at_s": at_s, "action": action, **more}


def changes() -> list[dict[str, Any]]:
    """Every live key another value, one after the other while the dock works."""
    live = [key for key in _core.cmrc.config_keys() if key["live"]]
    return [event(round(0.02 + 0.003 * n, 3), "set", key=key["name"], value=another(key)) for n, key in enumerate(live)]


def another(key: dict[str, Any]) -> Any:
    if key["type"] in ("boolean", "choice"):
        return key["choices"][-1] if key["choices"] else not key["default"]
    if key["name"] == "scheduling.agv_interval_refreshes":  # no less than N_a = 160
        return 200
    return key["default"] + 1 if key["type"] == "integer" else key["default"] * 0.9 or 0.9


SCENES: dict[str, dict[str, Any]] = {
    "default": {"duration_s": 0.1},
    "one DSP": {"dsps": 1, "duration_s": 0.12},
    "saturated": {"preset": "saturated", "dsps": 3, "duration_s": 0.15, "settings": {"scheduling.agv_phase": "together"}},
    "heavy": {"preset": "heavy", "dsps": 4, "duration_s": 0.05},
    "spin": {"dsps": 2, "duration_s": 0.03, "settings": {"machine.idle_policy": "spin"}},
    "pause": {"dsps": 2, "duration_s": 0.03, "settings": {"machine.idle_policy": "pause"}},
    "gantry in wind": {"dsps": 2, "duration_s": 0.1, "settings": {"dock.crane": "gantry", "dock.wind_mean_m_s": 8.0, "dock.wind_gust_m_s": 2.0}},
    "jitter": {"dsps": 4, "duration_s": 0.08, "settings": {"run.phase_jitter": True, "run.seed": 9}},
    "failures": {
        "dsps": 3, "duration_s": 0.2,
        "events": [event(0.06, "fail", dsp=0), event(0.08, "hang", dsp=1), event(0.09, "stall_bus", bus="A", lasts_ms=2), event(0.12, "slow", dsp=2, factor=0.25)],
    },
    "changes": {"dsps": 2, "duration_s": 0.3, "events": changes()},
    "drive fails": {"dsps": 2, "duration_s": 0.3, "events": [event(0.2, "fail_drive", joint="slew")]},
    "real drives": {"dsps": 2, "duration_s": 0.08, "settings": {"dock.stiction": True, "dock.gear_losses": True, "dock.sway_sensors": 2, "dock.drive_delay_us": 250}},
}  # fmt: skip


def digests_of(scene: str) -> str:
    given = dict(SCENES[scene])
    result = cmrc.run(**given)
    report = {name: part for name, part in result.report.items() if name not in HOST_ONLY}
    text = "\n".join(line for line in result.text.splitlines() if "simulated in" not in line)
    parts = {name: digest(part) for name, part in report.items()}
    parts = {**parts, "hash": report["hash"], "events": report["events"], "as text": digest(text)}
    return "".join(f"{name} {part}\n" for name, part in parts.items())


@pytest.mark.golden
@pytest.mark.parametrize("scene", SCENES)
def test_the_report_of_a_scene_is_the_kept_one(golden: Callable[[str, str], None], scene: str) -> None:
    golden(f"reports/{scene.replace(' ', '-')}.digests", digests_of(scene))
