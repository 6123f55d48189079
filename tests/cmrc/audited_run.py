"""What tests of failures share: a run whose audit finds nothing, and programs with a kernel that never returns."""

import json
import shutil
from pathlib import Path
from typing import Any

from cmrc import _core
from locations import ROOT

cmrc = _core.cmrc
Report = dict[str, Any]


def run(events: list[dict[str, Any]], **settings: Any) -> Report:
    """The report of a run to its end; without an ideal run beside it."""
    simulation = cmrc.Simulation(cmrc.config(settings={"report.reference": "none", **settings}, events=events))
    simulation.run()
    report: Report = json.loads(simulation.report_json())
    assert report["audit"]["violations"] == []
    return report


def misses(report: Report) -> int:
    return sum(task["misses"] for task in report["tasks"].values())


def programs_with(directory: Path, kernel: str, entry: str) -> str:
    """A copy of the DSP programs in which `entry` of the file `kernel` branches to itself."""
    shutil.copytree(ROOT / "c40_programs", directory / "programs")
    source = directory / "programs" / "kernels" / kernel
    text = source.read_text()
    assert text.count(f"\n{entry}:\n") == 1
    source.write_text(text.replace(f"\n{entry}:\n", f"\n{entry}:\n        br      {entry}\n"))
    return str(directory / "programs")
