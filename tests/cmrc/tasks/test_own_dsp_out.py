"""Tasks with a DSP of their own, when that DSP fails, hangs, is pulled out or is never there: from the trace and the
report."""

from pathlib import Path

import pytest
from own_dsp_run import FIRST, MS, Run, row


def test_what_is_for_a_dsp_that_fails_waits_and_says_so(tmp_path: Path, own_programs: Path) -> None:
    rows = [row("own", 1), row("anybody", None)]
    run = Run(
        tmp_path,
        own_programs,
        rows,
        "--dsps",
        "3",
        "--duration",
        "0.2",
        events=[{"at_s": 0.0802, "action": "fail", "dsp": 1}],
    )
    claims = run.claims("own")
    assert claims and max(time for time, _ in claims) < 81 * MS and {slot for _, slot in claims} == {1}
    assert run.task("anybody")["misses"] <= 1 and len(run.claims("anybody")) >= 38
    own = run.task("own")
    assert own["misses"] == own["never_started"] + own["lost"] == 1
    (miss,) = [miss for miss in run.report["misses"] if miss["kind"] == "user.own"]
    # Of the 120 ms that are left the watchdog takes 45, 3 x watchdog.long_run_us.
    assert 70 * MS < miss["parts_ps"]["own_dsp_out"] < 80 * MS and "no_dsp" not in miss["parts_ps"]
    assert run.chains >= 1


def test_the_watchdogs_second_try_is_for_the_same_dsp(tmp_path: Path, own_programs: Path) -> None:
    """It hangs in its own block: put back, passed by all others, and run by the same DSP after its reset."""
    rows = [row("own", 1, argument=25_000)]
    instant = 0.1002
    run = Run(
        tmp_path,
        own_programs,
        rows,
        "--dsps",
        "3",
        "--duration",
        "0.2",
        "--set",
        "watchdog.long_run_us=1500",
        events=[{"at_s": instant, "action": "hang", "dsp": 1}],
    )
    put_back = [(time, n) for time, _, what, n in run.events if what == "requeue" and n["kind"] == FIRST]
    assert len(put_back) == 1 and put_back[0][1]["owner"] == 1
    again = next((time, slot) for time, slot in run.claims("own") if time > put_back[0][0])
    assert again[1] == 1 and again[0] > 100 * MS
    booted = [
        time for time, component, what, n in run.events if what == "reset" and component == "dsp 1" and n["state"] == 1
    ]
    assert booted and again[0] > booted[-1]
    assert (
        run.task("own")["released"]
        == run.task("own")["on_time"]
        + run.task("own")["late"]
        + run.task("own")["unfinished"]
        + run.task("own")["never_started"]
    )


def test_a_board_that_is_pulled_and_put_in_again_finds_its_block(tmp_path: Path, own_programs: Path) -> None:
    events = [{"at_s": 0.0511, "action": "unplug", "dsp": 1}, {"at_s": 0.1033, "action": "plug", "dsp": 1}]
    run = Run(
        tmp_path, own_programs, [row("own", 1), row("anybody", None)], "--dsps", "2", "--duration", "0.2", events=events
    )
    times = [time for time, _ in run.claims("own")]
    assert not [time for time in times if 51.1 * MS < time < 103.3 * MS]
    assert min(time for time in times if time > 103.3 * MS) < 108 * MS
    assert len([time for time in times if time > 103.3 * MS]) >= 18
    late = [miss for miss in run.report["misses"] if miss["kind"] == "user.own"]
    assert len(late) == 1 and 40 * MS < late[0]["parts_ps"]["own_dsp_out"] < 53 * MS


def test_a_slot_that_is_empty_from_the_start(tmp_path: Path, own_programs: Path) -> None:
    """The servo and other tasks work as if the block were not there."""
    options = ["--dsps", "2", "--duration", "0.2", "--set", "machine.slots=3"]
    run = Run(tmp_path, own_programs, [row("own", 2), row("anybody", None)], *options)
    assert run.claims("own") == [] and run.task("own")["never_started"] == run.task("own")["misses"] == 1
    (miss,) = [miss for miss in run.report["misses"] if miss["kind"] == "user.own"]
    assert miss["parts_ps"]["own_dsp_out"] > 190 * MS
    assert run.report["tasks"]["pid"]["misses"] == 0 and run.task("anybody")["misses"] == 0
    filled = Run(
        tmp_path,
        own_programs,
        [row("own", 2), row("anybody", None)],
        *options,
        events=[{"at_s": 0.1, "action": "plug", "dsp": 2}],
    )
    assert len(filled.claims("own")) >= 19 and {slot for _, slot in filled.claims("own")} == {2}


def test_a_block_that_waits_forever_holds_back_no_long_ones(tmp_path: Path, own_programs: Path) -> None:
    """scheduling.long_blocks_max counts only blocks that any DSP may run."""
    rows = [row("own", 2, argument=100_000), row("long", None, argument=40_000, importance=0x6000)]
    run = Run(
        tmp_path,
        own_programs,
        rows,
        "--dsps",
        "2",
        "--duration",
        "0.1",
        "--set",
        "machine.slots=3",
        "--set",
        "scheduling.long_blocks_max=1",
    )
    assert len(run.claims("long")) >= 18


# ---- failures at any instant


@pytest.mark.parametrize("policy", ["doorbell", "spin"])
def test_failures_in_the_middle_of_claims(tmp_path: Path, own_programs: Path, policy: str) -> None:
    """Resets at instants that are spread over the claims of busy DSPs; every replay and the audit hold."""
    rows = [
        row("own", 1, period_ms=1, argument=5000, deadline_ms=1),
        row("other", 0, period_ms=1, argument=3000, deadline_ms=1),
        row("anybody", None, period_ms=1, argument=2000),
    ]
    events = [
        {
            "at_s": round(0.02 + 0.0071 * n + 1.37e-6 * n * n, 9),
            "action": ("reset", "hang", "freeze")[n % 3],
            "dsp": n % 2,
        }
        for n in range(20)
    ]
    options = ["--dsps", "3", "--duration", "0.2", *(["--idle-policy", policy] if policy != "doorbell" else [])]
    run = Run(tmp_path, own_programs, rows, *options, events=events)
    assert {slot for _, slot in run.claims("own")} == {1} and {slot for _, slot in run.claims("other")} == {0}
    assert len(run.claims("own")) > 50


def test_a_dsp_that_dies_with_the_list_in_its_hands(tmp_path: Path, own_programs: Path) -> None:
    """DSP 1 freezes between the write of 0Fh and the release of the list: the host frees it and finds every block."""
    rows = [row("own", 1), row("other", 0), row("anybody", None)]
    sound = Run(tmp_path, own_programs, rows, "--dsps", "3", "--duration", "0.1")
    claim = next(time for time, _ in sound.claims("own") if time > 50 * MS)
    for after_ns in (50, 150, 300, 600):
        at_s = round(claim * 1e-12 + after_ns * 1e-9, 10)
        run = Run(
            tmp_path,
            own_programs,
            rows,
            "--dsps",
            "3",
            "--duration",
            "0.1",
            "--set",
            "watchdog.long_run_us=1500",
            events=[{"at_s": at_s, "action": "freeze", "dsp": 1}],
        )
        assert {slot for _, slot in run.claims("own")} == {1}
        assert len(run.claims("own")) >= 16 and run.task("anybody")["misses"] <= 1
