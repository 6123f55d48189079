"""emulator --profile: every cycle of every DSP in one group, each kind's those of its report, and nothing about the run
changed."""

import json
import re
from pathlib import Path
from typing import Any

import cmrc
import pytest
from locations import ROOT

CASES: dict[str, dict[str, Any]] = {
    "doorbell": {"dsps": 2, "duration_s": 0.3},
    "overload": {"dsps": 1, "duration_s": 0.1, "preset": "saturated"},
    "parts": {"dsps": 2, "duration_s": 0.06, "preset": "saturated", "slice_cycles": 20000},
    "parts that end": {"dsps": 1, "duration_s": 0.1, "slice_cycles": 20000},
    "heavy": {"duration_s": 0.1, "preset": "heavy"},
    "spin": {"dsps": 2, "duration_s": 0.05, "idle_policy": "spin", "turn_order": 3},
    "failures": {
        "dsps": 3,
        "slots": 4,
        "duration_s": 0.2,
        "events": [
            {"at_s": 0.0301, "action": "hang", "dsp": 0},
            {"at_s": 0.0603, "action": "unplug", "dsp": 1},
            {"at_s": 0.0901, "action": "plug", "dsp": 1},
            {"at_s": 0.1002, "action": "slow", "dsp": 2, "factor": 0.5},
            {"at_s": 0.12004, "action": "reset", "dsp": 2},
            {"at_s": 0.15, "action": "fail", "dsp": 1},
        ],
    },
}


@pytest.fixture(scope="module", params=CASES, ids=str)
def result(request: pytest.FixtureRequest) -> cmrc.Result:
    return cmrc.run(profile=True, **CASES[request.param])


def test_profiling_changes_nothing(result: cmrc.Result, request: pytest.FixtureRequest) -> None:
    plain = cmrc.run(**CASES[request.node.callspec.params["result"]])
    assert plain.profile is None
    assert (result.hash, result.report["dsps"]) == (plain.hash, plain.report["dsps"])


def test_all_cycles_of_all_dsps_are_there(result: cmrc.Result) -> None:
    assert result.profile is not None
    whole, dsps = result.profile.data, result.report["dsps"]
    for cause in dsps[0]["causes"]:
        assert whole["causes"][cause] == sum(dsp["causes"][cause] for dsp in dsps), cause
        assert whole["causes"][cause] == sum(group["causes"][cause] for group in whole["groups"]), cause
    for count in ("cycles", "instructions"):
        assert whole[count] == sum(dsp[count] for dsp in dsps) == sum(group[count] for group in whole["groups"])
    for group in whole["groups"]:
        for parts in ("lines", "routines"):
            for cause, cycles in group["causes"].items():
                assert cycles == group["outside"][cause] + sum(part["causes"][cause] for part in group[parts])
            assert sum(part["instructions"] for part in group[parts]) == group["instructions"]


def test_a_kind_has_the_cycles_of_its_report(result: cmrc.Result) -> None:
    assert result.profile is not None
    groups = {group["name"]: group for group in result.profile.data["groups"]}
    for kind, task in result.report["tasks"].items():
        assert (kind in groups) == (task["execution_ps"]["count"] > 0), kind
        if kind in groups:
            assert groups[kind]["jobs"] == task["execution_ps"]["count"]
            assert groups[kind]["causes"] == task["execution_cycles"], kind
    assert "pid" in groups


def test_jobs_that_are_not_finished_are_counted_once() -> None:
    """Each job that is open at the end had finished parts; two run now."""
    result = cmrc.run(profile=True, **CASES["parts"])
    assert result.profile is not None
    groups = {group["name"]: group for group in result.profile.data["groups"]}
    unfinished = sum(task["unfinished"] for task in result.report["tasks"].values())
    assert groups["not finished"]["jobs"] == unfinished > 1


def test_jobs_lie_between_their_two_flag_writes(run, tmp_path: Path) -> None:
    """The instruction trace of a single DSP, read by the two writes of the executive that take and end a block."""
    trace, profile = tmp_path / "t", tmp_path / "p.json"
    run("--dsps", 1, "--duration", 0.04, "--quiet", "--trace", trace, "--trace-instructions", 0, "--profile", profile)
    report = json.loads(profile.read_text())
    text = {line["address"]: line["text"] for group in report["groups"] for line in group["lines"]}
    flag_writes = [
        address for address, source in text.items() if re.search(r"sti\s+r[23], \*\+ar[02]\(TB_FLAG\)", source)
    ]
    take, done = (
        next(f"{a:08X}" for a in flag_writes if register in text[a]) for register in ("r3, *+ar2", "r2, *+ar0")
    )
    begun, inside, jobs = None, 0, 0
    for line in (tmp_path / "t.dsp0").read_text().splitlines():
        fields = line.split()
        if len(fields) > 3 and fields[3] == take:
            begun = int(fields[0])
        if len(fields) > 3 and fields[3] == done and begun is not None:
            inside, jobs, begun = inside + int(fields[0]) - begun, jobs + 1, None
    kinds = [
        group
        for group in report["groups"]
        if group["name"] not in ("not finished", "boot", "executive", "claim", "idle", "halted")
    ]
    assert jobs == sum(group["jobs"] for group in kinds) > 30
    assert inside == sum(group["cycles"] for group in kinds)


def test_lines_are_those_of_the_source() -> None:
    result = cmrc.run(dsps=1, duration_s=0.04, profile=True)
    assert result.profile is not None
    sources = {
        path.relative_to(ROOT / "c40_programs").as_posix(): path.read_text().splitlines()
        for path in (ROOT / "c40_programs").rglob("*.asm")
    }
    lines = result.profile.lines
    for i in range(lines.rows):
        row = lines.row(i)
        first, _, second = row["text"].partition("\n")
        assert sources[row["file"]][int(row["line"]) - 1] == first
        assert ("||" in second) == (second != "") and second in ["", *sources[row["file"]]]
    assert any("||" in text for text in lines["text"])
    assert {"executive.asm", "kernels/pid.asm", "lib/arithmetic.asm"} <= set(lines["file"])


def test_what_the_user_sees(run, tmp_path: Path) -> None:
    text = run("--dsps", 1, "--duration", 0.04, "--profile").stdout
    report, profile = text.split("\nprofile: cycles of all DSPs")
    assert "Deadlines" in report
    assert re.search(r"^pid +\d+ +\d+ +\d+", profile, re.MULTILINE)
    assert re.search(r"^profile: pid, \d+ jobs, \d+\.\d cycles on average", profile, re.MULTILINE)
    assert "copy_words" in profile and "kernels/pid.asm" in profile
    run("--dsps", 1, "--duration", 0.04, "--profile", tmp_path / "p.txt")
    assert "profile: cycles of all DSPs" + profile == (tmp_path / "p.txt").read_text().lstrip("\n")


def test_own_programs_have_their_own_source(run, tmp_path: Path) -> None:
    run(
        "--dsps",
        1,
        "--duration",
        0.03,
        "--quiet",
        "--programs",
        ROOT / "c40_programs",
        "--profile",
        tmp_path / "p.json",
    )
    groups = json.loads((tmp_path / "p.json").read_text())["groups"]
    assert any(line["text"].strip().startswith("callu") for group in groups for line in group["lines"])


def test_bad_use(run) -> None:
    quiet = run("--duration", 0.03, "--quiet", "--profile")
    assert quiet.returncode == 2 and "--profile" in quiet.stderr
    nowhere = run("--duration", 0.03, "--profile", "/nowhere/p.json")
    assert nowhere.returncode == 2 and "/nowhere" in nowhere.stderr


def test_a_routine_that_only_the_executive_calls_is_named_before_any_job_has_run() -> None:
    """A moment after the first refresh: the DSP has booted, copied its constants and looked at the list. No kernel has
    called copy_words yet."""
    result = cmrc.run(dsps=1, duration_s=0.02001, profile=True)
    assert result.profile is not None
    groups = {group["name"]: group for group in result.profile.data["groups"]}
    assert sum(group["jobs"] for group in groups.values()) == 0
    (copies,) = (routine for routine in groups["executive"]["routines"] if routine["name"] == "copy_words")
    assert copies["calls"] == 1 and copies["instructions"] > 700
