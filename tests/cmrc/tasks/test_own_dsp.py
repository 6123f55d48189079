"""Tasks that are bound to one DSP (docs/add-a-task.md, dsp): which DSP claims which block, from the event trace and the
report."""

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from cmrc import _core
from cmrc_test import run_setup
from locations import AT_ONCE
from own_dsp_run import US, Run, row, toml_of
from scheduling_replay import Rule

cmrc = _core.cmrc


# ---- claims

MIXED = [row("high", 2, importance=0xFBFE), row("low", 2, importance=0x0100), row("other", 0), row("anybody", None)]


@pytest.mark.parametrize(
    ("options", "rule"),
    [
        ("--dsps 4 --duration 0.12", Rule()),
        ("--dsps 3 --duration 0.12 --idle-policy spin", Rule()),
        ("--dsps 3 --duration 0.12 --idle-policy pause", Rule()),
        ("--dsps 4 --duration 0.12 --preset saturated", Rule()),
        ("--dsps 3 --duration 0.2 --preset saturated --set scheduling.slice_cycles=10000", Rule()),
        ("--dsps 16 --duration 0.1 --set dock.agvs=8", Rule()),
        ("--dsps 3 --duration 0.12 --set scheduling.gamma_refreshes=2", Rule(gamma=2)),
    ],
)
def test_only_its_dsp_ever_claims_a_block_and_the_order_of_all_is_by_importance(
    tmp_path: Path, own_programs: Path, options: str, rule: Rule
) -> None:
    run = Run(tmp_path, own_programs, MIXED, *options.split(), rule=rule)
    assert {slot for _, slot in run.claims("high")} == {slot for _, slot in run.claims("low")} == {2}
    assert {slot for _, slot in run.claims("other")} == {0}
    assert len(run.claims("high")) >= run.task("high")["released"] - 1 >= 18
    assert run.replay.refreshes == run.report["host"]["refreshes"]


def test_a_block_for_anybody_is_claimed_past_one_that_waits_for_its_dsp(tmp_path: Path, own_programs: Path) -> None:
    """DSP 1 has work for 4 ms, and another block of its own waits behind that. Blocks for any DSP are claimed, although
    their J is lower."""
    rows = [
        row("long", 1, argument=100_000, importance=0x7002),
        row("waits", 1, importance=0x7001),
        row("anybody", None, importance=0x7000),
    ]
    run = Run(tmp_path, own_programs, rows, "--dsps", "2", "--duration", "0.2")
    assert (
        run.task("long")["on_time"] == 0 and run.task("waits")["late"] >= 18
    )  # 4 ms, and the blocks before it in the list
    assert run.task("anybody")["misses"] == 0
    for (waits, _), (anybody, slot) in zip(run.claims("waits"), run.claims("anybody"), strict=False):
        assert anybody < waits and slot == 0


def test_two_tasks_with_dsps_of_their_own_run_at_the_same_time(tmp_path: Path, own_programs: Path) -> None:
    run = Run(tmp_path, own_programs, [row("one", 0), row("two", 1)], "--dsps", "2", "--duration", "0.2")
    pairs = list(zip(run.runs("one"), run.runs("two"), strict=True))
    assert len(pairs) >= 38 and run.task("one")["misses"] == run.task("two")["misses"] == 0
    beside = [min(a[1], b[1]) - max(a[0], b[0]) for a, b in pairs]
    assert min(beside) > 300 * US  # of 500 us each, less what PID and planning take of either DSP before
    alone = Run(tmp_path, own_programs, [row("one", 0), row("two", 0)], "--dsps", "2", "--duration", "0.2")
    assert all(a[1] < b[0] for a, b in zip(alone.runs("one"), alone.runs("two"), strict=True))


def test_a_dsp_is_left_to_its_own_block_where_another_can_do_what_stands_before_it(
    tmp_path: Path, own_programs: Path
) -> None:
    """Both DSPs sleep; the block for any DSP comes first by J. The host rings DSP 1 for it, and DSP 0 for its own
    block."""
    period = 41  # refreshes: most releases fall between two servo ticks, which are 8 apart
    rows = [
        row(name, dsp, importance=j, argument=50_000, period_ms=period / 8)
        for name, dsp, j in (("anybody", None, 0x7001), ("own", 0, 0x7000))
    ]
    run = Run(tmp_path, own_programs, rows, "--dsps", "2", "--duration", "0.3")
    quiet = [
        (a, b)
        for n, (a, b) in enumerate(zip(run.claims("anybody"), run.claims("own"), strict=False))
        if 2 <= period * (n + 1) % 8
    ]
    assert len(quiet) > 35
    assert [a[1] for a, _ in quiet] == [1] * len(quiet) and max(b[0] - a[0] for a, b in quiet) < 10 * US


STEPS = """
[[processes]]
number = 9
name = "look"
robot = "none"
steps = ["task user.one", "task user.one", "task user.one"]
loaded = true
"""


def test_the_step_of_a_process_is_for_the_same_dsp(own_programs: Path) -> None:
    settings = {**AT_ONCE, "machine.programs": str(own_programs), "report.reference": "none", "run.duration_s": 0.05}
    run = cmrc.Simulation(cmrc.config(toml=toml_of([row("one", 2, period_ms=0)]) + STEPS, settings=settings))
    run.run()
    report = json.loads(run.report_json())
    assert report["tasks"]["user.one"]["on_time"] == 3
    assert [dsp["slot"] for dsp in report["dsps"] if "user.one" in dsp["tasks_ps"]] == [2]


def test_what_a_claim_costs(own_programs: Path) -> None:
    """Torque compensation is the first block of its tick: its claim reads one word more, the owner."""
    median = {}
    for dsp in (None, 0):
        run = cmrc.Simulation(
            core(own_programs, [row("one", dsp, period_ms=50)], **{"machine.dsps": 1, "run.duration_s": 0.1})
        )
        run.run()
        median[dsp] = json.loads(run.report_json())["tasks"]["torque_compensation"]["waiting_ps"]["p50"]
    assert round((median[0] - median[None]) / US, 1) == 0.8


# ---- state, ideal run, words


def core(own_programs: Path, rows: list[dict[str, Any]], **settings: Any) -> Any:
    return cmrc.config(
        toml=toml_of(rows),
        settings={**AT_ONCE, "machine.programs": str(own_programs), "report.reference": "none", **settings},
    )


def test_a_snapshot_in_the_middle_continues_bit_for_bit(own_programs: Path) -> None:
    config = core(own_programs, MIXED, **{"machine.dsps": 3, "run.duration_s": 0.06})
    whole = cmrc.Simulation(config)
    whole.run()
    whole_hash = json.loads(whole.report_json())["hash"]
    for at_s in (0.0200301, 0.0400017, 0.0400023, 0.0400031):
        first, second = cmrc.Simulation(config), cmrc.Simulation(config)
        first.run_until(at_s)
        second.restore(first.snapshot())
        second.run()
        assert json.loads(second.report_json())["hash"] == whole_hash


def test_the_ideal_run_has_one_dsp_that_does_it_all(own_programs: Path) -> None:
    simulation = cmrc.Simulation(
        core(own_programs, MIXED, **{"machine.dsps": 3, "run.duration_s": 0.05, "report.reference": "ideal"})
    )
    simulation.run()
    report = json.loads(simulation.report_json())
    assert report["reference_problem"] in ("", None) and report["errors"] is not None


def test_without_a_dsp_the_words_are_as_ever(own_programs: Path) -> None:
    """The image of a configuration without `dsp` has no code for it. With `dsp`, all other code and data keep their
    places."""
    without, within = (run_setup.dsp_image(core(own_programs, [row("one", dsp)])) for dsp in (None, 0))
    assert "own_claim" not in without.symbols
    others = {
        name: value for name, value in within.symbols.items() if not name.startswith("own_") and name != "OWN_BLOCKS"
    }
    assert others == without.symbols
    assert "dsp" not in cmrc.config(toml=toml_of([row("one", None)])).to_toml().split("[[tasks]]")[1].split("[[")[0]


def test_the_row_is_written_back() -> None:
    config = cmrc.config(toml=toml_of([row("one", 3), row("two", 0)]))
    assert cmrc.config(toml=config.to_toml()).to_toml() == config.to_toml()
    assert re.findall(r"^dsp = (\d)$", config.to_toml(), re.MULTILINE) == ["3", "0"]


# ---- bad input


@pytest.mark.parametrize(
    ("dsp", "settings", "says"),
    [
        ("-1", {}, "tasks.dsp: -1 is out of range; a number from 0 to 15 is expected"),
        ("16", {}, "tasks.dsp: 16 is out of range; a number from 0 to 15 is expected"),
        ("1.5", {}, "tasks.dsp: 1.5 is not an integer; an integer is expected"),
        ("nan", {}, "tasks.dsp: nan is out of range; a number from 0 to 15 is expected"),
        ('"0"', {}, 'tasks.dsp: "0" is a string; a number from 0 to 15 is expected'),
        ("true", {}, "tasks.dsp: true is a boolean; a number from 0 to 15 is expected"),
        (
            "4",
            {},
            (
                'tasks.dsp: "one" is for DSP 4, and there is no such slot; '
                "0 to 3 is expected, or more machine.dsps or machine.slots"
            ),
        ),
        ("1", {"machine.dsps": 1}, "0 is expected: there is one slot"),
        ("6", {"machine.slots": 6}, "0 to 5 is expected"),
    ],
)
def test_a_slot_that_is_none_is_refused_with_its_place(dsp: str, settings: dict[str, Any], says: str) -> None:
    toml = toml_of([row("one", None)]) + f"dsp = {dsp}\n"
    with pytest.raises(cmrc.ConfigError, match=re.escape(says)) as error:
        cmrc.config(toml=toml, settings=settings, name="my.toml")
    assert str(error.value).startswith(f"my.toml:{toml.count(chr(10))}:")


def test_programs_whose_executive_does_not_know_it_are_refused(tmp_path: Path, own_programs: Path) -> None:
    old = tmp_path / "old"
    shutil.copytree(own_programs, old)
    main = old / "dsp.asm"
    main.write_text(main.read_text().replace(".ifdef  OWN_BLOCKS", ".ifdef  OTHER"))
    executive = old / "executive.asm"
    executive.write_text(executive.read_text().replace(".ifdef  OWN_BLOCKS", ".ifdef  OTHER"))
    with pytest.raises(cmrc.ConfigError, match="does not support blocks for one DSP alone"):
        cmrc.Simulation(core(old, [row("one", 0)]))
    cmrc.Simulation(core(old, [row("one", None)]))
