"""docs/results.md lists the settings of its runs: a run with what a section says is the run that it measured."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cmrc
import pytest
from cmrc import _core
from cmrc.results import __main__ as command
from cmrc.results import cost, page
from cmrc.results.claim import Claim
from cmrc.results.failures import Failures
from cmrc.results.runs import Laboratory, Run
from locations import ROOT

SETTING = re.compile(r"`([a-z_.]+) = ([^`]+)`")
EVENT = re.compile(r"event `\{([^`]+)\}`(?: and again every (\S+) s, (\d+) in all)?")
LAYOUT = re.compile(r"`dock.layout` with ((?:`[^`]+` ?)+)")


def runs_of(claim: type[Claim]) -> tuple[Claim, list[Run]]:
    """The page's own runs; of the failures, whose instants are drawn, fewer looks choose them."""
    chosen = Failures(looks=150) if claim is Failures else claim()
    return chosen, chosen.runs()


def table_of(number: int) -> dict[str, str]:
    """The settings that the page's section says, by the runs that they belong to."""
    text = (ROOT / "docs" / "results.md").read_text(encoding="utf-8")
    first, last = page.marks(number)
    section = text[text.index(first) : text.index(last)]
    assert section.count("**Settings.**") == 1
    lines = section[section.index("**Settings.**") :].splitlines()
    cells = [re.split(r" \| ", line.strip("| ")) for line in lines if line.startswith("| ")]
    return {runs: said for runs, said in cells[1:]}


def fits(claim: Claim, run: Run, scope: str, n: dict[str, Any]) -> bool:
    """Whether a row with these words is one for this run; ``n`` gets the value of the label that they call so."""
    part = claim.part(run)
    parts, colon, name = scope.rpartition(": ")
    if scope in ("all", "each trial") or (part in scope.split("; ") and not colon):
        return True
    if part not in parts.split("; "):
        return False
    for label, value in run.label.items():
        if name in (claim.named(label, value), claim.named(label, "n")):
            n["n"] = value
            return True
    return False


def said_of(claim: Claim, run: Run, table: Mapping[str, str], tmp_path: Path) -> _core.cmrc.Config:
    """The configuration of a run from what the page says of it; what is drawn is the run's own."""
    settings: dict[str, Any] = {}
    events: list[dict[str, Any]] = []
    preset = None
    for scope, said in table.items():
        n: dict[str, Any] = {}
        if not fits(claim, run, scope, n):
            continue
        if "drawn: " in said:
            drawn = re.findall("`([a-z_.]+)`", said)
            events = list(run.events) if "events" in drawn else events
            own = {"run.duration_s": run.duration_s, "run.seed": run.settings.get("run.seed")}
            settings |= {key: own[key] for key in drawn if key != "events"}
            continue
        if found := re.search("preset `([a-z]+)`", said):
            preset = found[1]
        for key, value in SETTING.findall(LAYOUT.sub("", EVENT.sub("", said))):
            settings[key] = n["n"] if value == "n" else json.loads(value)
        if found := LAYOUT.search(said):
            settings["dock.layout"] = str(tmp_path / "said.toml")
            (tmp_path / "said.toml").write_text("\n".join(re.findall("`([^`]+)`", found[1])) + "\n")
        for fields, every, count in EVENT.findall(said):
            first = dict(re.split(" = ", field) for field in fields.split(", "))
            event = {key: json.loads(value) for key, value in first.items()}
            events += [
                {**event, "at_s": round(event["at_s"] + k * float(every or 0), 9)} for k in range(int(count or 1))
            ]
    return _core.cmrc.config(preset=preset, settings=settings, events=events)


@pytest.mark.parametrize("claim", command.CLAIMS, ids=lambda claim: claim.NAME)
def test_a_run_with_what_the_page_says_is_the_run_that_was_measured(claim: type[Claim], tmp_path: Path) -> None:
    chosen, runs = runs_of(claim)
    table = table_of(claim.NUMBER)
    for run in runs:
        layout = tmp_path / "said.toml"
        layout.unlink(missing_ok=True)
        said = said_of(chosen, run, table, tmp_path)
        own = run.all_settings(str(layout) if run.layout else "")
        assert (layout.read_text() if layout.exists() else "") == run.layout, run.label
        layout.write_text(run.layout)
        measured = _core.cmrc.config(preset=run.preset, settings=own, events=[dict(one) for one in run.events])
        assert said.to_toml() == measured.to_toml(), run.label


@pytest.mark.parametrize("claim", command.CLAIMS, ids=lambda claim: claim.NAME)
def test_each_row_of_the_settings_belongs_to_a_run(claim: type[Claim]) -> None:
    chosen, runs = runs_of(claim)
    for scope in table_of(claim.NUMBER):
        assert any(fits(chosen, run, scope, {}) for run in runs), scope


def test_the_margins_of_a_whole_job_are_those_of_its_own_loops() -> None:
    job = next(run for run in cost.Cost().whole_jobs())
    own = cost.margins_ms(_core.cmrc.config(settings=job.all_settings()).to_dict())
    usual = cost.margins_ms(_core.cmrc.config().to_dict())
    tight = cost.margins_ms(_core.cmrc.config(preset="tight").to_dict())
    # docs/control.md, One joint: 5, 40 and 80 rad/s at 1 kHz.
    assert {joint: round(ms, 2) for joint, ms in usual.items()} == {"travel": 105.2, "other joints": 10.01}
    assert round(tight["other joints"], 2) == 3.56
    assert {joint: round(ms, 1) for joint, ms in own.items()} == {"hoist": 57.7, "other joints": 98.5}
    said = " ".join((ROOT / "docs" / "results.md").read_text(encoding="utf-8").split())
    assert "(delay margins: hoist 57.7 ms, other joints 98.5 ms)" in said


def test_a_kept_report_gives_the_run_with_what_was_drawn(tmp_path: Path) -> None:
    event = {"at_s": 0.0234, "action": "unplug", "dsp": 1}
    run = Run({}, {"machine.dsps": 2, "run.phase_jitter": True, "run.seed": 8}, 0.03, events=[event])
    Laboratory(1, tmp_path, lambda text: None).all([run], "kept")
    [file] = tmp_path.glob("*.json")
    report = json.loads(file.read_text(encoding="utf-8"))[-1]
    assert cmrc.run(config=report).report["hash"] == report["hash"]
