"""What a report says of the host's refreshes, and of DSPs that are gone, computed from the trace or by hand."""

from pathlib import Path
from typing import Any

import cmrc
import pytest
from traced_run import events_of

US, MS = 1_000_000, 1_000_000_000  # ps
HOST = 255  # as the owner of a semaphore


@pytest.mark.parametrize("policy", ["doorbell", "pause", "spin"])
def test_a_refresh_lasts_until_its_release_of_the_list_is_in_the_memory(policy: str, tmp_path: Path) -> None:
    """The host's writes are posted: they reach the memory after the host has done its work."""
    events, report = events_of(
        tmp_path, "--dsps", 2, "--duration", 0.03, "--idle-policy", policy, "--set", "machine.boot=preloaded"
    )
    every_ps = 10**12 // round(report["configuration"]["rates.refresh_frequency_hz"])
    lasted, tick = [], None
    for at, component, name, arguments in events:
        if (component, name) == ("host", "refresh"):
            tick = arguments["number"]  # of the host
        if name == "semaphore" and (arguments["state"], arguments["owner"]) == (0, HOST) and tick is not None:
            lasted.append(at - tick * every_ps)
            tick = None
    told = report["host"]["refresh_duration_ps"]
    assert told["count"] == len(lasted) == report["host"]["refreshes"] > 50
    if policy == "doorbell":  # the host reads the mask of sleeping DSPs after it
        assert told["mean"] > sum(lasted) / len(lasted) and told["worst"] >= max(lasted)
    else:
        assert told["mean"] == pytest.approx(sum(lasted) / len(lasted), abs=1)
        assert (told["best"], told["worst"]) == (min(lasted), max(lasted))


def parts_of(report: dict[str, Any], kind: str, number: int) -> dict[str, int]:
    [miss] = [miss for miss in report["misses"] if (miss["kind"], miss["number"]) == (kind, number)]
    parts: dict[str, int] = miss["parts_ps"]
    return parts


def test_a_job_that_waits_for_a_refresh_that_is_under_way_at_the_end_waits_for_the_refresh() -> None:
    """The host stops within a refresh: the same job in a run that ends meanwhile, and in one that continues."""
    stop = [{"at_s": 0.095002, "action": "pause_host", "lasts_ms": 20}]
    settings = {"report.reference": "none"}
    ends, continues = (
        cmrc.run(dsps=2, duration_s=seconds, settings=settings, events=stop).report for seconds in (0.1, 0.13)
    )
    number = min(miss["number"] for miss in ends["misses"] if miss["kind"] == "pid")
    cut, whole = parts_of(ends, "pid", number), parts_of(continues, "pid", number)
    assert "not_due" not in cut and "not_due" not in whole
    assert cut["host_refresh"] == pytest.approx(5 * MS, abs=50 * US)
    assert whole["host_refresh"] == pytest.approx(20 * MS, abs=50 * US)


def test_a_dsp_that_hangs_without_a_block_is_not_there_although_its_doorbell_rings() -> None:
    report = cmrc.run(
        dsps=1,
        duration_s=0.06,
        settings={"report.reference": "none"},
        events=[{"at_s": 0.0304, "action": "hang", "dsp": 0}],
    ).report
    parts = report["tasks"]["pid"]["why_late"]["parts_ps"]
    assert parts["no_dsp"] > 20 * MS and parts.get("claim", 0) < 50 * US
