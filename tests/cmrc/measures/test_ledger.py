"""Every job is booked under exactly one outcome (ruling 16)."""

import json

import cmrc
import hypothesis.strategies as st
import pytest
from cmrc import _core
from cmrc_test import ledger as ledgers
from hypothesis import given, settings

OUTCOMES = ("on_time", "late", "unfinished", "never_started", "lost", "dropped")


def ledger() -> ledgers.LedgerInSeconds:
    return ledgers.LedgerInSeconds()


def test_each_class() -> None:
    jobs = ledger()
    for block in range(6):
        jobs.release(block, "pid", 1.0, 2.0)
    jobs.claimed(0, 0, 1.1, [0, 0])
    jobs.finished(0, 0, 2.0, [1, 1])  # at its deadline: on time
    jobs.removed(0)
    jobs.claimed(1, 0, 1.1, [0, 0])
    jobs.finished(1, 0, 2.000001, [1, 1])
    jobs.removed(1)
    jobs.claimed(2, 1, 1.5, [0, 0])
    jobs.claimed(4, 0, 2.5, [0, 0])
    jobs.slot_failed(1)
    jobs.dropped(5, 2.5)
    jobs.skipped("pid", 3.0, 4.0, 3)
    row = jobs.report(5.0)["pid"]
    assert {name: row[name] for name in OUTCOMES} == {
        "on_time": 1,
        "late": 1,
        "unfinished": 1,
        "never_started": 1,
        "lost": 1,
        "dropped": 2,
    }
    assert row["released"] == 7
    assert row["misses"] == 6  # all but the first: deadlines of the open ones have passed


def test_open_jobs_before_their_deadline_are_no_misses() -> None:
    jobs = ledger()
    jobs.release(0, "pid", 1.0, 9.0)
    jobs.release(1, "identify", 1.0)
    row = jobs.report(5.0)
    assert row["pid"]["misses"] == 0 and row["identify"]["misses"] == 0


def test_a_job_released_after_the_end_does_not_exist_yet() -> None:
    jobs = ledger()
    jobs.release(0, "pid", 6.0, 7.0)
    assert jobs.report(5.0)["pid"]["released"] == 0


PS = 1e-12


def test_a_deadline_is_missed_one_picosecond_after_it() -> None:
    """A job that is open at the end is missed if its deadline has passed; at the deadline itself it has not."""
    for claimed, outcome in ((False, "never_started"), (True, "unfinished")):
        for late, misses in ((-PS, 0), (0.0, 0), (PS, 1)):
            jobs = ledger()
            jobs.release(0, "pid", 1.0, 2.0)
            if claimed:
                jobs.claimed(0, 0, 1.5, [0, 0])
            row = jobs.report(2.0 + late)["pid"]
            assert (row["released"], row[outcome], row["misses"]) == (1, 1, misses), (outcome, late)


def test_a_job_that_ends_at_its_deadline_or_one_picosecond_beside_it() -> None:
    for late, outcome in ((-PS, "on_time"), (0.0, "on_time"), (PS, "late")):
        jobs = ledger()
        jobs.release(0, "pid", 1.0, 2.0)
        jobs.claimed(0, 0, 1.5, [0, 0])
        jobs.finished(0, 0, 2.0 + late, [1, 1])
        row = jobs.report(3.0)["pid"]
        assert row[outcome] == 1 and row["misses"] == (late > 0)


@pytest.mark.parametrize(("late", "released", "misses"), [(-PS, 10, 2), (0.0, 10, 2), (PS, 11, 4)])
def test_a_run_that_ends_at_a_deadline_or_one_picosecond_beside_it(late: float, released: int, misses: int) -> None:
    """The only DSP dies at 28.8 ms. The job of 29 ms never starts; its deadline is the tick of 30 ms. A picosecond
    after it, this tick has passed with that job in the way: it is dropped."""
    settings = {"dsps": 1, "boot": "preloaded", "duration_s": 0.03 + late, "report.reference": "none"}
    events = [{"at_s": 0.0288, "action": "fail", "dsp": 0}]
    simulation = _core.cmrc.Simulation(_core.cmrc.config(settings=settings, events=events))
    simulation.run()
    row = json.loads(simulation.report_json())["tasks"]["pid"]
    assert (row["released"], row["never_started"], row["misses"]) == (released, 1, misses)


def test_a_job_released_one_picosecond_before_the_end_exists_and_at_the_very_end_it_does_not() -> None:
    for at, released in ((5.0 - PS, 1), (5.0, 0), (5.0 + PS, 0)):
        jobs = ledger()
        jobs.release(0, "pid", at, 6.0)
        assert jobs.report(5.0)["pid"]["released"] == released


def test_a_recomputed_job_counts_once_with_its_last_claim() -> None:
    jobs = ledger()
    jobs.release(0, "pid", 1.0, 5.0)
    jobs.claimed(0, 0, 1.1, [0, 0])
    jobs.slot_failed(0)
    jobs.put_back(0, 3.0)
    jobs.claimed(0, 1, 3.1, [10, 10])
    jobs.finished(0, 0, 3.2, [0, 0])  # the dead one's late word changes nothing
    jobs.finished(0, 1, 4.0, [12, 11])
    jobs.removed(0)
    row = jobs.report(9.0)["pid"]
    assert (row["released"], row["on_time"], row["lost"]) == (1, 1, 0)


def test_causes_of_a_run_sum_to_its_length() -> None:
    jobs = ledger()
    jobs.release(0, "pid", 0.0, 1.0)
    jobs.claimed(0, 0, 0.1, [100, 7])
    jobs.finished(0, 0, 0.1 + 3e-12 * 7, [102, 8])  # 21 ps, shared 2 : 1
    jobs.removed(0)
    assert jobs.report(1.0)["pid"]["causes"] == {"execute": 14, "bus": 7}


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 7), st.integers(0, 1)), max_size=60))
def test_nothing_falls_between_the_classes(steps: list[tuple[int, int, int]]) -> None:
    jobs = ledger()
    loaded: set[int] = set()
    released = 0
    for at, (action, block, slot) in enumerate(steps):
        if block not in loaded:
            jobs.release(block, "pid", float(at), at + 5.0)
            loaded.add(block)
            released += 1
        elif action == 0:
            jobs.claimed(block, slot, float(at), [at, 0])
        elif action == 1:
            jobs.finished(block, slot, float(at), [at, 0])
        elif action == 2:
            jobs.put_back(block, float(at))
        elif action == 3:
            jobs.dropped(block, float(at))
            loaded.discard(block)
        elif action == 4:
            jobs.slot_failed(slot)
        else:
            jobs.skipped("pid", float(at), at + 1.0, at)
            released += 1
    row = jobs.report(float(len(steps)))["pid"]
    assert row["released"] == sum(row[name] for name in OUTCOMES) == released


@pytest.mark.parametrize(("steps", "message"), [
    ("load claim0 finish0 remove", None),
    ("load claim0 back claim1 finish1 remove load claim0", None),
    ("load claim0 drop load", None),
    ("load load", "loaded while waiting"),
    ("load claim0 claim1", "claimed while taken"),
    ("load claim0 finish1", "claimed by DSP 0, finished by DSP 1"),
    ("load claim0 finish0 finish0", "finished while done"),
    ("load claim0 back finish0", "finished while waiting"),  # a late finisher that no fence stopped
    ("load claim0 finish0 back", "put back while done"),     # a block that would be done twice
    ("load claim0 remove", "removed while taken"),
    ("load drop", "given up while waiting"),
])  # fmt: skip
def test_a_block_that_leaves_its_life_is_noticed(steps: str, message: str | None) -> None:
    jobs = ledger()
    for number, step in enumerate(steps.split()):
        at = 1.0 + number
        name, slot = step.rstrip("01"), int(step[-1]) if step[-1] in "01" else 0
        if name == "load":
            jobs.release(0, "pid", at)
        elif name in ("claim", "finish"):
            getattr(jobs, {"claim": "claimed", "finish": "finished"}[name])(0, slot, at, [0, 0])
        elif name == "remove":
            jobs.removed(0)
        else:
            getattr(jobs, {"back": "put_back", "drop": "dropped"}[name])(0, at)
    assert [violation.split(": ")[1] for violation in jobs.violations()] == ([] if message is None else [message])


def test_the_servos_jobs_have_their_ticks_and_so_a_jitter() -> None:
    tasks = cmrc.run(dsps=2, duration_s=0.06, settings={"report.reference": "none"}).report["tasks"]
    for kind in ("pid", "torque_compensation"):
        assert tasks[kind]["start_jitter_ps"]["count"] == tasks[kind]["on_time"] - 1 > 20
    assert tasks["inverse_kinematics.crane"]["start_jitter_ps"]["count"] == 0


def test_misses_by_robot_are_those_of_the_kind_late_or_skipped() -> None:
    report = cmrc.run(dsps=1, duration_s=0.12).report
    tasks, demand = report["tasks"], report["errors"]["demand"]
    assert tasks["pid"]["dropped"] > 0 and tasks["pid"]["late"] > 0
    for kind, one in demand.items():
        assert (one["misses"], one["released"]) == (tasks[kind]["misses"], tasks[kind]["released"]), kind
        assert one["missed_share"] is None or one["missed_share"] == one["misses"] / one["released"]
