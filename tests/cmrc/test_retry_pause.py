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
