"""Chains of causes in small scenes, computed by hand (docs/report.md, Why late)."""

import json
from typing import Any

from cmrc_test import ledger as ledgers


def scene(kept: int = 1000) -> ledgers.LedgerInPicoseconds:
    return ledgers.LedgerInPicoseconds(kept)


def report_at(jobs: ledgers.LedgerInPicoseconds, now: int, causes: list[list[int]] | None = None) -> dict[str, Any]:
    report = json.loads(jobs.report_json(now, causes or []))
    assert report["audit"]["violations"] == []
    return report


def usual_pid(jobs: ledgers.LedgerInPicoseconds, execution: int = 50, bus: int = 10) -> None:
    """One PID on time, alone: execution + bus."""
    jobs.refresh(0, 0, 0, 0, [])
    jobs.slot(0, "asleep", 0)
    jobs.release(60, "pid", 0, 1_000_000)
    jobs.refresh(0, 0, 0, 0, [60])
    jobs.claimed(60, 0, 10, [0, 0])
    jobs.finished(60, 0, 10 + execution + bus, [execution, bus])
    jobs.removed(60)


def test_each_kind_of_waiting_once() -> None:
    jobs = scene()
    usual_pid(jobs)
    jobs.slot(1, "off", 0)
    jobs.release(1, "identify", 100, None)
    jobs.refresh(100, 100, 100, 100, [1])
    jobs.claimed(1, 0, 110, [60, 10])
    jobs.release(2, "pid", 1000, 1500)
    jobs.refresh(1005, 1015, 1022, 1030, [2])  # late by 5, works 10, waits 7 for the list, works 8
    jobs.slot(
        1, "asleep", 1400
    )  # from 1030 on only the identify block keeps the one DSP: blocked for 370, then a sleeper for 20
    jobs.slot(1, "awake", 1420)
    jobs.list(0xFF, 1430)  # 10 of claiming
    jobs.list(0, 1445)  # 15 of the host holding the list
    jobs.bus(1, True, 1450, 1470)  # 5 of claiming, 20 on bus A
    jobs.bus(1, False, 1471, 1473)  # 1 of claiming, 2 on bus B
    jobs.list(2, 1475)  # its own hold is no contention
    jobs.claimed(2, 1, 1480, [0, 0])  # 7 of claiming
    jobs.finished(2, 1, 1600, [70, 50])  # 60 longer than the usual 50 + 10
    jobs.removed(2)
    [miss] = report_at(jobs, 2000)["misses"]
    assert miss["parts_ps"] == {
        "host_late": 5, "host_refresh": 18, "host_lock": 7, "doorbell": 20, "claim": 10 + 5 + 1 + 7, "claim_bus_a": 20, "claim_bus_b": 2, "lock": 15,
        "blocked": 370, "execution.execute": 20, "execution.bus": 40, "slack": -(500 - 60),
    }  # fmt: skip
    assert sum(miss["parts_ps"].values()) == miss["lateness_ps"] == 100
    assert (
        miss["kind"],
        miss["outcome"],
        miss["release_ps"],
        miss["deadline_ps"],
        miss["end_ps"],
        miss["usual_ps"],
    ) == ("pid", "late", 1000, 1500, 1600, 60)
    assert miss["behind"] == [
        {
            "kind": "identify",
            "robot": 0,
            "number": 0,
            "dsp": 0,
            "claimed_ps": 110,
            "from_ps": 1030,
            "to_ps": 1400,
            "share_ps": 370,
            "overtook": False,
        }
    ]
    assert miss["runs"] == [{"dsp": 1, "claimed_ps": 1480, "ended_ps": 1600, "end": "done"}]
    assert miss["unavoidable_ps"] == 1441  # the first instant after 1500 - 60


def test_blocks_before_it_in_the_list_are_distinguished_from_those_that_ran() -> None:
    jobs = scene()
    usual_pid(jobs)
    jobs.slot(1, "asleep", 0)
    jobs.release(1, "identify", 100, None)
    jobs.release(2, "grab_path", 100, None)
    jobs.refresh(100, 100, 100, 100, [1, 2])
    jobs.claimed(1, 0, 100, [60, 10])
    jobs.claimed(2, 1, 100, [0, 0])
    jobs.release(3, "pid", 1000, 1100, 0)
    jobs.release(4, "obstacle_avoidance", 1000, None, 2)
    jobs.refresh(1000, 1000, 1000, 1000, [3, 4])
    jobs.finished(1, 0, 1101, [61, 10])  # both DSPs taken for 101: 51 and 50
    jobs.removed(1)
    jobs.claimed(4, 0, 1101, [61, 10])  # it outranks PID: every instant from here on is its
    jobs.finished(4, 0, 1161, [61, 70])
    jobs.removed(4)
    jobs.claimed(3, 0, 1161, [61, 70])
    jobs.finished(3, 0, 1221, [111, 80])
    jobs.removed(3)
    report = report_at(jobs, 2000)
    [miss] = report["misses"]
    assert miss["parts_ps"] == {"blocked": 101, "behind_list": 60, "slack": -40}
    assert [(b["kind"], b["robot"], b["dsp"], b["share_ps"], b["overtook"]) for b in miss["behind"]] == [
        ("identify", 0, 0, 51, False), ("grab_path", 0, 1, 50, False), ("obstacle_avoidance", 2, 0, 60, True),
    ]  # fmt: skip
    why = report["tasks"]["pid"]["why_late"]
    assert why["behind_ps"] == {"identify": 51, "grab_path": 50, "obstacle_avoidance": 60}
    assert why["parts_ps"] == miss["parts_ps"] and why["lateness_ps"] == 121 and why["usual_ps"] == 60


def test_a_dead_dsp_costs_its_run_and_the_watchdog() -> None:
    jobs = scene()
    usual_pid(jobs)
    jobs.slot(1, "asleep", 0)
    jobs.release(2, "pid", 1000, 1500)
    jobs.refresh(1000, 1000, 1000, 1000, [2])
    jobs.claimed(2, 0, 1000, [50, 10])
    jobs.slot_failed(0, 1030)
    jobs.refresh(3000, 3000, 3000, 3000, [])
    jobs.put_back(2, 3000)
    jobs.refresh(3000, 3005, 3005, 3005, [2])
    jobs.slot(1, "awake", 3010)
    jobs.claimed(2, 1, 3011, [0, 0])
    jobs.finished(2, 1, 3070, [50, 9])  # the shortest run by now
    jobs.removed(2)
    [miss] = report_at(jobs, 4000)["misses"]
    assert miss["parts_ps"] == {
        "host_refresh": 5,
        "doorbell": 5,
        "claim": 1,
        "lost_run": 30,
        "watchdog": 1970,
        "slack": -441,
    }
    assert sum(miss["parts_ps"].values()) == 3070 - 1500
    assert [run["end"] for run in miss["runs"]] == ["failed", "done"]
    assert (
        miss["unavoidable_ps"] == 1500 - 59 + 1
    )  # claimed in time; after 1030 it would have to start again, for which there is time until then


def test_a_dropped_tick_names_the_job_that_was_out() -> None:
    jobs = scene()
    usual_pid(jobs)
    jobs.release(2, "pid", 1000, 1500)
    jobs.skipped("pid", 1500, 2000, 3, 1507)
    jobs.skipped("torque_compensation", 1500, 2000, 3, 2600)
    first, second = report_at(jobs, 1600)["misses"][:2]
    assert first["parts_ps"] == {"previous_out": 500, "not_run": -60, "slack": -440} and first["previous"] == 1
    assert first["lateness_ps"] == 0 and first["unavoidable_ps"] == 1507
    assert second["parts_ps"] == {"host_late": 500, "slack": -500} and second["previous"] is None
    assert second["unavoidable_ps"] == 2001


def test_what_has_not_ended_is_reported_up_to_the_end_of_the_run() -> None:
    jobs = scene()
    usual_pid(jobs)
    jobs.slot(0, "off", 100)
    jobs.slot(1, "awake", 900)
    jobs.release(1, "pid", 1000, 1500)
    jobs.release(2, "pid", 1000, 1500)
    jobs.refresh(1000, 1000, 1000, 1000, [1, 2])
    jobs.claimed(1, 1, 1000, [0, 0])
    jobs.slot_failed(1, 1980)
    unfinished, waiting = report_at(jobs, 2000)["misses"]
    assert unfinished["outcome"] == "lost"
    assert unfinished["parts_ps"] == {"lost_run": 980, "watchdog": 20, "not_run": -60, "slack": -440}
    assert waiting["outcome"] == "never_started" and waiting["parts_ps"] == {
        "behind_list": 980,
        "no_dsp": 20,
        "not_run": -60,
        "slack": -440,
    }
    assert unfinished["unavoidable_ps"] == 1501 and waiting["unavoidable_ps"] == 1441


def test_a_running_job_is_reported_by_what_it_has_spent() -> None:
    jobs = scene()
    usual_pid(jobs)
    jobs.release(1, "pid", 1000, 1100)
    jobs.refresh(1000, 1000, 1000, 1000, [1])
    jobs.claimed(1, 0, 1000, [50, 10])
    [miss] = report_at(jobs, 1300, [[250, 110]])["misses"]
    assert miss["outcome"] == "unfinished"
    assert miss["parts_ps"] == {"execution.execute": 150, "execution.bus": 90, "slack": -40}


def test_the_list_of_misses_is_bounded_and_the_sums_are_not() -> None:
    jobs = scene(kept=2)
    usual_pid(jobs)
    for number in range(5):
        start = 1000 * (number + 1)
        jobs.release(1, "pid", start, start + 10)
        jobs.refresh(start, start, start, start, [1])
        jobs.claimed(1, 0, start, [0, 0])
        jobs.finished(1, 0, start + 70, [60, 10])
        jobs.removed(1)
    report = report_at(jobs, 10_000)
    assert [miss["number"] for miss in report["misses"]] == [1, 2] and report["misses_left_out"] == 3
    why = report["tasks"]["pid"]["why_late"]
    assert (
        why["jobs"] == 5 and why["lateness_ps"] == 5 * 60 and why["parts_ps"] == {"execution.execute": 50, "slack": 250}
    )
