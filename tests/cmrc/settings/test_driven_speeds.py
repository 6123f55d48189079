"""The speed that the refusal of a layout names is the one at which the plant's joint turns on that way
(docs/layout.md)."""

from pathlib import Path

import cmrc
import numpy as np
import pytest
from cmrc import _core
from cmrc_test import run_setup
from low_rates import LOW_RATES

core = _core.cmrc


def test_joints_turn_as_fast_as_the_refusal_says(tmp_path: Path) -> None:
    """With drives that trip earlier the way is refused; with the usual ones it is driven."""
    file = tmp_path / "layout.toml"
    file.write_text("[[containers]]\nx_m = -12.7\ny_m = 24.0\n", encoding="utf-8")
    settings = {**LOW_RATES, "dock.layout": str(file)}
    result = cmrc.run(duration_s=75.0, settings=settings)
    assert result.report["failures"] == []
    drives = run_setup.dock_of(core.config()).crane.drives
    for joint, signal, number in (("slew", "psi", 1), ("rotate", "kappa", 4)):
        turned = float(np.abs(result.signals[f"{signal}_rate_rad_per_s"]).max())
        drive = drives[number]
        overspeed = turned * drive.gear / drive.rated_speed
        run_setup.dock_of(core.config(settings={**settings, f"slewing.{joint}.overspeed": 1.005 * overspeed}))
        with pytest.raises(cmrc.ConfigError, match=f"slewing.{joint}.overspeed times") as refusal:
            run_setup.dock_of(core.config(settings={**settings, f"slewing.{joint}.overspeed": 0.995 * overspeed}))
        named = float(str(refusal.value).split(" needs ")[1].split()[0])
        assert turned == pytest.approx(named, rel=0.005)
