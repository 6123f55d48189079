"""Runs of the dock with a timeline, read back, and their reports."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import timeline
from command_line import emulator

ALONE = ["--quiet", "--set", "report.reference=none"]
MS = 10**9
CLOCK_PS = 30_000


def run(folder: Path, *arguments: object) -> Any:
    """The report of a run."""
    report = folder / "report.json"
    done = emulator(*arguments, *ALONE, "--report", report, folder=folder)
    assert done.returncode == 0, done.stderr
    return json.loads(report.read_text())


@dataclass
class Drawn:
    timeline: timeline.Timeline
    report: Any
    file: Path

    def dsp(self, slot: int) -> list[timeline.Slice]:
        return self.timeline.slices[self.timeline.track("DSPs", f"DSP {slot}")]

    def blocks(self, slot: int) -> list[timeline.Slice]:
        return [one for one in self.dsp(slot) if one.parent is not None]


def draw(folder: Path, *arguments: object) -> Drawn:
    file = folder / "t.perfetto-trace"
    report = run(folder, *arguments, "--perfetto", file)
    return Drawn(timeline.read(file), report, file)
