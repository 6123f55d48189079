"""Whole runs against replays of their event traces: the scheduling rule, and why jobs were late."""

import json
from pathlib import Path
from typing import Any

import chain_replay
import pytest
import scheduling_replay
from locations import AT_ONCE_OPTIONS
from scheduling_replay import Replay, Rule
from traced_run import events_of

# All AGVs drive to the warehouse from the start: their planning runs at once.
DRIVING = """
[[processes]]
number = 8
name = "AGV to initial state"
robot = "agv"
subprocesses = [1, 2, 5]
steps = ["task home.agv", "leg 1"]
initial = [1, 4, 5]
final = true
"""


def run(tmp_path: Path, *options: str, toml: str = "") -> tuple[list[scheduling_replay.Event], dict[str, Any]]:
    """The events and the report of a run."""
    return events_of(tmp_path, "--set", "report.misses_max=100000", *options, toml=toml)


def failures(*rows: tuple[float, str, dict[str, Any]]) -> str:
    text = ""
    for at, action, fields in rows:
        text += f'[[events]]\nat_s = {at}\naction = "{action}"\n' + "".join(
            f"{key} = {json.dumps(value)}\n" for key, value in fields.items()
        )
    return text


CROWDED = (
    "--dsps 1 --duration 0.15 --set dock.agvs=8 --set load.avoidance_cycles=30000 --set scheduling.agv_phase=together"
)
# The host takes the list from a DSP that has become too slow to release it.
SLOW = failures((0.02002, "slow", {"dsp": 1, "factor": 0.001}))
# DSP 1 never boots.
NEVER_BOOTED = failures((0.00005, "break_link", {"dsp": 1}), (0.01, "pause_host", {"lasts_ms": 1.7}))
DYING = failures(
    (0.04003, "fail", {"dsp": 0}),
    (0.06003, "hang", {"dsp": 1}),
    (0.09004, "unplug", {"dsp": 2}),
    (0.12, "plug", {"dsp": 2}),
)
ROUGH = failures(
    (0.0203, "pause_host", {"lasts_ms": 1.7}), (0.03, "stall_bus", {"bus": "A", "lasts_ms": 0.9}), (0.0402, "hang", {"dsp": 0}), (0.05, "slow", {"dsp": 1, "factor": 0.05}),
    (0.08, "slow", {"dsp": 1, "factor": 1}),
)  # fmt: skip


@pytest.mark.parametrize(
    ("options", "toml", "rule", "kinds"),
    [
        ("--dsps 1 --duration 0.15", "", Rule(), {1, 3, 5, 6, 7, 8}),
        ("--dsps 4 --duration 0.15", "", Rule(), {1, 3, 5, 6, 7, 8}),
        ("--dsps 16 --duration 0.13 --set dock.agvs=8", "", Rule(), {5, 6, 7}),
        ("--dsps 4 --duration 0.15 --set dock.agvs=8", DRIVING, Rule(), {2, 4, 5, 6, 10}),
        (CROWDED, DRIVING, Rule(), {2, 4, 5, 6, 10, 11}),
        ("--dsps 1 --duration 0.2 --preset saturated", "", Rule(), {5, 6, 11}),
        ("--dsps 2 --duration 0.13 --preset saturated --idle-policy spin", "", Rule(), {5, 6, 11}),
        ("--dsps 4 --duration 0.13", DYING, Rule(), {5, 6}),
        ("--dsps 2 --duration 0.13 --idle-policy pause", ROUGH, Rule(), {5, 6}),
        (
            "--dsps 3 --duration 0.13 --set scheduling.gamma_refreshes=2 --set scheduling.alpha_refreshes=30",
            "",
            Rule(gamma=2, alpha=30),
            {5, 6},
        ),
        ("--dsps 2 --duration 0.13 --preset saturated --set scheduling.slice_cycles=10000", ROUGH, Rule(), {5, 6, 11}),
        (
            "--dsps 2 --duration 0.13 --set rates.servo_frequency_hz=2000 --set scheduling.p=20480",
            "",
            Rule(servo=4, p=20480),
            {5, 6},
        ),
    ],
)
def test_the_list_and_every_claim_follow_equation_7(
    tmp_path: Path, options: str, toml: str, rule: Rule, kinds: set[int]
) -> None:
    events, report = run(tmp_path, *options.split(), toml=toml)
    replay = Replay(rule, doorbells="--idle-policy" not in options)
    replay.follow(events)
    assert replay.faults == []
    assert (
        replay.refreshes == report["host"]["refreshes"]
        and replay.claims == sum(dsp["claims"] for dsp in report["dsps"]) > 50
    )
    assert kinds <= replay.kinds


def test_the_replay_notices_a_broken_rule(tmp_path: Path) -> None:
    events, _ = run(tmp_path, *CROWDED.split(), *AT_ONCE_OPTIONS, toml=DRIVING)
    rules = [
        Rule(),
        Rule(gamma=1),
        Rule(a=0x200),
        Rule(b=0x2100),
        Rule(alpha=120),
        Rule(beta=300),
        Rule(agv=60),
        Rule(p=0x1000, q=0x100),
    ]
    faults = []
    for rule in rules:
        replay = Replay(rule)
        replay.follow(events)
        faults.append(len(replay.faults))
    assert faults[0] == 0 and all(faults[1:])
    swapped = [
        (time, component, name, {**n, "kind": {5: 6, 6: 5}.get(n["kind"], n["kind"])} if name == "load" else n)
        for time, component, name, n in events
    ]
    replay = Replay(Rule())
    replay.follow(swapped)
    assert any("work pointer" in fault or "order" in fault for fault in replay.faults)


@pytest.mark.parametrize(
    ("options", "toml", "dsps", "least"),
    [
        ("--dsps 1 --duration 0.15", "", 1, 2),
        ("--dsps 1 --duration 0.2 --preset saturated", "", 1, 20),
        ("--dsps 2 --duration 0.15 --preset saturated", "", 2, 20),
        ("--dsps 4 --duration 0.25 --preset saturated --set scheduling.agv_phase=together", "", 4, 20),
        ("--dsps 2 --duration 0.15 --preset saturated --idle-policy spin", "", 2, 20),
        ("--dsps 2 --duration 0.15 --preset saturated --idle-policy pause", "", 2, 20),
        ("--dsps 4 --duration 0.13", DYING, 4, 1),
        ("--dsps 2 --duration 0.13 --preset saturated", ROUGH, 2, 10),
        ("--dsps 2 --duration 0.13", ROUGH, 2, 3),
        ("--dsps 2 --duration 0.06 --preset saturated --set machine.boot=preloaded", SLOW, 2, 6),
        ("--dsps 2 --duration 0.06 --preset saturated", NEVER_BOOTED, 2, 3),
        ("--dsps 1 --duration 1.0", failures((0.05, "fail", {"dsp": 0})), 1, 1),
        ("--dsps 3 --duration 0.15 --set machine.cycle_time_factor=14", "", 3, 50),
        ("--dsps 1 --duration 0.15 --preset saturated --set scheduling.slice_cycles=10000", "", 1, 20),
        ("--dsps 2 --duration 0.13 --preset saturated --set scheduling.slice_cycles=20000", ROUGH, 2, 10),
        ("--dsps 3 --duration 0.13 --preset saturated --set scheduling.slice_cycles=5000", DYING, 3, 1),
    ],
)
def test_chains_add_up_and_are_those_of_the_trace(
    tmp_path: Path, options: str, toml: str, dsps: int, least: int
) -> None:
    events, report = run(tmp_path, *options.split(), toml=toml)
    assert report["misses_left_out"] == 0
    assert len(report["misses"]) == sum(task["misses"] for task in report["tasks"].values())
    trace = chain_replay.Trace(events, dsps, servo=8, refresh_hz=8000, preloaded="machine.boot=preloaded" in options)
    assert chain_replay.check(trace, report) >= least
    for kind, task in report["tasks"].items():
        why = task["why_late"]
        own = [miss for miss in report["misses"] if miss["kind"] == kind]
        chained = [miss for miss in own if miss["runs"] or miss["outcome"] != "dropped"]
        dropped = sum(count for part, count in why.items() if part.startswith("dropped_"))
        assert why["jobs"] == len(chained) and dropped == len(own) - len(chained)
        assert sum(why["parts_ps"].values()) == why["lateness_ps"]
        for part, total in why["parts_ps"].items():
            assert total == sum(miss["parts_ps"].get(part, 0) for miss in chained), (kind, part)
