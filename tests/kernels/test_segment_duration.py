"""What the host takes for the duration of a segment (``segment_seconds``; it refuses layouts by it) is what the crane's
kernel lays."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest
from cmrc import _core
from cmrc_test import run_setup
from harness import Dsp

core = _core.cmrc
PROGRAMS = Path(__file__).resolve().parents[2] / "c40_programs"
HOME = [12.0, 16.0, 14.0, 0.0]
# From home by x, y, z and yaw; what limits each is in the comment.
WAYS = [
    (10.0, -24.0, 0.0, 0.0),  # speed in plan
    (-24.0, 8.0, -5.0, 0.0),
    (3.0, -16.0, 2.0, 0.0),  # acceleration in plan
    (1.5, 0.5, 0.0, 0.0),  # snap
    (0.2, 0.0, -0.1, 0.0),
    (3.0, 3.0, -12.0, 0.0),  # vertical speed
    (0.0, 0.0, -8.5, 0.0),
    (0.1, 0.1, 3.0, 0.0),  # vertical acceleration
    (10.0, -24.0, 0.0, 1.0),  # plan and yaw together
    (0.5, 0.0, 1.0, 2.8),  # speed in yaw
    (0.2, 0.2, 0.1, -0.4),  # acceleration in yaw
    (4.0, -3.0, 6.0, 0.3),
]


def laid(dsp: Dsp, kernel: str, way: tuple[float, ...]) -> float:
    """The kernel's first duration of a leg of one segment."""
    dsp.put("CR_POINT_PERIOD", 0.008)
    dsp.put("CR_HOME", *HOME)
    dsp.put("CR_LEG", 1)
    dsp.put("CR_ROUTE_COUNT", 1, offset=1)
    dsp.put("CR_ROUTE", *(a + d for a, d in zip(HOME, way, strict=True)))
    dsp.put("CR_TRAJECTORY", 0)
    dsp.run(kernel, 0)
    s = dsp.symbols
    bank = 1 + (dsp.word("CR_TRAJECTORY") - 1) * s["TJ_BANK_STRIDE"]
    return dsp.floats("CR_TRAJECTORY", 1, offset=bank + s["TJ_DURATION"] - s["TJ_K0"])[0]


def told(way: tuple[float, ...], **settings: Any) -> float:
    x, y, z, yaw = way
    named = {name.replace("__", "."): value for name, value in settings.items()}
    return run_setup.segment_seconds(core.config(settings=named), (x * x + y * y) ** 0.5, abs(z), abs(yaw))


@pytest.mark.parametrize("way", WAYS)
def test_the_host_knows_the_duration_that_the_kernel_lays(way: tuple[float, ...]) -> None:
    assert told(way) == pytest.approx(laid(Dsp(), "trajectory_crane", way), rel=2e-6)


@pytest.mark.parametrize("way", WAYS[:6])
def test_and_so_with_lower_speed_limits(way: tuple[float, ...]) -> None:
    dsp = Dsp()
    # In plan 2.3 m/s by the slowest of slew (half), luff and rotator; vertically 0.8 of the hoist's; in yaw the
    # rotator's.
    dsp.speeds([1 / 1.15, 1 / 0.4, 1 / 0.1, 0.0, 1 / 0.06, 1 / 0.05, 1 / 0.5])
    limits = {
        "control__slew_speed_limit_rad_s": 0.06,
        "control__hoist_speed_limit_m_s": 0.5,
        "control__rotator_speed_limit_rad_s": 0.1,
    }
    assert told(way, **limits) == pytest.approx(laid(dsp, "trajectory_crane", way), rel=2e-6)


@pytest.mark.parametrize("way", WAYS[:6])
def test_and_so_of_a_slowed_crane(way: tuple[float, ...]) -> None:
    """Intervals are whole refreshes: 64 of them by 1.3034 are 83, so the factor is 83/64."""
    dsp = Dsp()
    dsp.put("CR_STRETCH", 83 / 64)
    slowed = {"scheduling__work_mode": "slowed_crane", "scheduling__slow_factor": 1.3034}
    assert told(way, **slowed) == pytest.approx(laid(dsp, "trajectory_crane", way), rel=2e-6)
    assert told(way, **slowed | {"scheduling__work_mode": "slowed_agv"}) == told(way)


@pytest.mark.parametrize(
    "way", [(0.5, 0.0, 0.0, 0.0), (0.1, 0.1, 3.0, 0.0), (0.2, 0.2, 0.1, -0.4), (1.0, 1.0, -3.0, 0.5)]
)
def test_the_shapers_segments_last_so_long_where_no_joint_is_too_fast(way: tuple[float, ...]) -> None:
    kernel = {"kernels__trajectory": "quintic_shaper"}
    assert told(way, **kernel) == pytest.approx(laid(Dsp(**kernel), "trajectory_crane_shaper", way), rel=2e-6)


def test_the_limits_are_those_of_the_users_programs(tmp_path: Path) -> None:
    shutil.copytree(PROGRAMS, tmp_path / "programs")
    constants = tmp_path / "programs" / "kernels" / "trajectory_crane_constants.asm"
    text = constants.read_text(encoding="utf-8")
    assert text.count("9.372 / 0.4") == 1
    constants.write_text(text.replace("9.372 / 0.4", "9.372 / 0.1"), encoding="utf-8")
    way, own = (3.0, -16.0, 2.0, 0.0), {"machine__programs": str(tmp_path / "programs")}
    assert told(way, **own) == pytest.approx(2 * told(way), rel=1e-6)
    constants.write_text(text.replace("K_TJ_XY1 ", "K_TJ_OTHER "), encoding="utf-8")
    kernel = tmp_path / "programs" / "kernels" / "trajectory_crane.asm"
    kernel.write_text(kernel.read_text(encoding="utf-8").replace("K_TJ_XY1", "K_TJ_OTHER"), encoding="utf-8")
    with pytest.raises(core.ConfigError, match="machine.programs: K_TJ_XY1"):
        told(way, **own)
