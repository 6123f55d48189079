"""The host's pause before it tries again to acquire the list varies, so that it does not stay in step with DSPs that
poll."""

import pytest
from audited_run import run


@pytest.mark.parametrize("arbiter", ["fixed", "host_fair"])
@pytest.mark.parametrize("retry_ns", [0, 1, 5, 200])
def test_every_refresh_comes_about_beside_dsps_that_poll(retry_ns: float, arbiter: str) -> None:
    settings = {"idle_policy": "spin", "host.semaphore_retry_ns": retry_ns, "bus.arbiter": arbiter}
    report = run([], duration_s=0.03, dsps=4, **settings)
    assert report["host"]["refreshes"] == 80
    assert sum(task["misses"] for task in report["tasks"].values()) == 0


@pytest.mark.parametrize("dsps", [5, 6, 8])
@pytest.mark.parametrize("retry_ns", [0, 100, 200])
def test_it_does_not_stay_in_step_with_dsps_that_fill_the_bus(retry_ns: float, dsps: int) -> None:
    """Five or six DSPs that poll took turns among each other: from 34 ms on the list was never free for the host."""
    report = run([], duration_s=0.07, dsps=dsps, idle_policy="spin", **{"host.semaphore_retry_ns": retry_ns})
    assert report["host"]["refreshes"] >= 395 and report["host"]["refresh_duration_ps"]["worst"] < 500e6
    assert sum(task["misses"] for task in report["tasks"].values()) == 0


@pytest.mark.parametrize("pause_ms", [1, 10, 30])
def test_ticks_without_a_refresh_count_up_to_the_end(pause_ms: int) -> None:
    """400 ticks before 0.07 s; the last pause lasts beyond the end. A refresh that it stops is under way then."""
    events = [{"at_s": 0.055, "action": "pause_host", "lasts_ms": pause_ms}]
    host = run(events, duration_s=0.07, dsps=2)["host"]
    assert host["refreshes"] + host["skipped_refreshes"] == 400
    assert host["refresh_duration_ps"]["count"] == host["refreshes"]
    assert abs(host["skipped_refreshes"] - min(pause_ms, 15) * 8) <= 1
