"""Layouts in which the controller cannot do its job are refused, with the place and what would be right
(docs/plant.md, Your own layout)."""

from pathlib import Path
from typing import Any

import cmrc
import numpy as np
import pytest
from cmrc import _core

core = _core.cmrc
ONE = "[[containers]]\nx_m = 3.0\ny_m = 24.0\n"


def dock(tmp_path: Path, layout: str, **settings: Any) -> Any:
    file = tmp_path / "layout.toml"
    file.write_text(layout, encoding="utf-8")
    return core.dock_of(core.config(settings={"dock.layout": str(file), **settings}))


REFUSED = [
    # What would make the set-point of psi or kappa jump by a whole turn.
    ("slewing", "[home]\nx_m = -16\ny_m = -6\nz_m = 16\n", "from home to .* slew through 180 degrees.*expected"),
    ("slewing", "[home]\nyaw_deg = -130\n" + ONE, "from home .* rotator would turn through 180 degrees.*yaw_deg"),
    ("slewing", "[home]\nyaw_deg = 300\n" + ONE, "rotator would turn through 180 degrees"),
    ("slewing", "[home]\nx_m = -16\ny_m = 0.01\n" + ONE, "home at .* needs psi = 180.0 degrees"),
    ("gantry", "[home]\nyaw_deg = -95\n", "from home .* rotator would turn through 180 degrees"),
    # The travel.
    ("slewing", "[home]\ngantry_m = 0.05\n", r"\[home\] gantry_m is 0.05 m.*expected is gantry_m = 0"),
    ("gantry", "[home]\ngantry_m = 3\n", r"layout.toml:2:12: gantry_m of home is 3 m.*x_m of its load, 0 m"),
    # What the bay scanner cannot see.
    ("slewing", "[[containers]]\nx_m = 0\ny_m = 25.3\n", r"container 0 at \(0, 25.3\) m is out of the bay scanner's"),
    ("slewing", "[[containers]]\nx_m = 20\ny_m = 24\n", r"x_m from -19.70 to 19.30"),
    ("slewing", "[[containers]]\nx_m = 0\ny_m = 24\nyaw_deg = 30\n", "yaw_deg near 0"),
    # Ways that pass too near to the column.
    ("slewing", "[home]\nx_m = 14\ny_m = -8\nz_m = 11\n[portal]\nleg_m = 0\n", "way from home to container 0"),
    (
        "slewing",
        "[spot]\nx_m = -22\ny_m = -10\n[warehouse]\nx_m = -34\ny_m = -34\n[[containers]]\nx_m = 0\ny_m = 24\n",
        r"the loading spot",
    ),
]


@pytest.mark.parametrize(("crane", "layout", "what"), REFUSED)
def test_a_layout_in_which_the_job_cannot_be_done_is_refused(
    tmp_path: Path, crane: str, layout: str, what: str
) -> None:
    with pytest.raises(cmrc.ConfigError, match=rf"(?s)dock\.layout: .*{what}"):
        dock(tmp_path, layout, **{"dock.crane": crane})


TAKEN = [
    ("slewing", "[home]\nyaw_deg = 20\n"),
    ("slewing", "[home]\nx_m = -5\ny_m = 22\nz_m = 16\n" + ONE),
    ("slewing", "[[containers]]\nx_m = 19.2\ny_m = 24.3\nyaw_deg = 2\n"),
    ("gantry", "[home]\nyaw_deg = -80\n"),
    ("gantry", "[home]\nx_m = 4\n"),
    ("gantry", "[home]\nx_m = 4\ngantry_m = 4\n"),
]


@pytest.mark.parametrize(("crane", "layout"), TAKEN)
def test_a_layout_in_which_the_job_can_be_done_is_taken(tmp_path: Path, crane: str, layout: str) -> None:
    made = dock(tmp_path, layout, **{"dock.crane": crane})
    assert crane == "slewing" or made.home.s == made.home.x


def test_a_way_near_the_column_is_taken_by_a_trajectory_that_is_slow_enough(tmp_path: Path) -> None:
    near = "[home]\nx_m = 14\ny_m = -4\nz_m = 11\n[portal]\nleg_m = 0\n" + ONE
    with pytest.raises(cmrc.ConfigError, match="slewing needs 0.1[0-9]* rad/s.*trips above 0.144 rad/s"):
        dock(tmp_path, near)
    dock(tmp_path, near, **{"control.slew_speed_limit_rad_s": 0.08})
    dock(tmp_path, near, **{"kernels.trajectory": "quintic_shaper"})


def test_the_scanner_sees_a_container_at_the_end_of_its_row(tmp_path: Path) -> None:
    """The first container is looked for and planned: the crane leaves home."""
    file = tmp_path / "layout.toml"
    file.write_text("[[containers]]\nx_m = 19.2\ny_m = 24.0\n", encoding="utf-8")
    settings = {"dock.layout": str(file), "report.reference": "none"}
    result = cmrc.run(dsps=2, duration_s=3.0, settings=settings)
    assert result.report["tasks"]["grab_path"]["released"] == 1
    assert np.ptp(result.signals["psi_rad"]) > 1e-4


def test_an_ideal_run_has_one_dsp() -> None:
    """With two, PID lacks the torque compensation of its own tick: claimed at the same time."""
    settings = {"report.reference": "none"}
    alone, four = (cmrc.run(dsps=dsps, duration_s=0.3, ideal=True, settings=settings) for dsps in (1, 4))
    assert alone.hash == four.hash and len(four.report["dsps"]) == 1
