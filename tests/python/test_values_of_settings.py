"""Settings as Python programs have them: NumPy's numbers, exact numbers, paths."""

from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import cmrc
import numpy as np
import pytest
from cmrc.sweeps import Sweep

VALUES: list[tuple[str, Any, object]] = [
    ("run.strict", np.bool_(True), True),
    ("run.strict", np.bool_(False), False),
    ("run.duration_s", np.float32(0.25), 0.25),
    ("run.duration_s", Fraction(1, 4), 0.25),
    ("run.duration_s", Decimal("0.25"), 0.25),
    ("machine.dsps", np.uint8(3), 3),
    ("machine.dsps", np.array(3), 3),
    ("machine.dsp_clock", np.str_("C40-50"), "C40-50"),
]


@pytest.mark.parametrize(("key", "value", "meant"), VALUES)
def test_a_setting(key: str, value: Any, meant: object) -> None:
    found = cmrc.Simulation(settings={key: value}).config.to_dict()[key]
    assert found == meant and type(found) is type(meant)


def test_a_keyword_holds_over_settings() -> None:
    for settings in ({"machine.dsps": 2}, {"dsps": 2}, {"machine": {"dsps": 2}}):
        assert cmrc.Simulation(dsps=3, settings=settings).config.to_dict()["machine.dsps"] == 3


def test_a_path_is_a_text(tmp_path: Path) -> None:
    layout = tmp_path / "layout.toml"
    layout.write_text("")
    assert cmrc.Simulation(settings={"dock": {"layout": layout}}).config.to_dict()["dock.layout"] == str(layout)
    fixed = {"run.duration_s": 0.03, "report.reference": "none", "run.strict": np.bool_(False)}
    made = cmrc.sweep({"axes": {"dock.layout": [layout]}, "fixed": fixed}, tmp_path / "sweep")
    assert isinstance(made, Sweep) and [run["settings"]["dock.layout"] for run in made.runs] == [str(layout)]


def test_an_event_takes_the_same() -> None:
    made = cmrc.Simulation(duration_s=0.05, settings={"report.reference": "none"})
    made.at(np.float64(0.02), "fail", dsp=np.int64(1))
    assert made.run().report["timed_events"] == [{"time_s": 0.02, "what": "fail DSP 1"}]
