"""The watchdog: long blocks by their heartbeat (measures.md 4), and no healthy DSP is reset for time in which the host
did not look (ruling 37)."""

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from audited_run import run
from cmrc import _core
from locations import ROOT

cmrc = _core.cmrc
# Vehicles that stand and look all at once: the load is there from the first interval on.
PARKED = {"load.parked": True, "scheduling.agv_phase": "together"}
LONG = {**PARKED, "load.avoidance_cycles": 50_000}


def noticed(report: dict[str, Any]) -> list[tuple[float, int, str]]:
    return [
        (failure["time_s"], failure["dsp"], failure["message"])
        for failure in report["failures"]
        if failure["kind"] == "watchdog"
    ]


@pytest.mark.parametrize("action", ["hang", "freeze", "fail"])
@pytest.mark.parametrize("at_ms", [20.3, 21.1, 21.95])
def test_a_failure_in_identify_is_noticed_within_3_ms(action: str, at_ms: float) -> None:
    # The first refresh, at 20 ms, hands out torque compensation, PID and, to DSP 2, identify, which takes 2.3 ms.
    report = run([{"at_s": at_ms * 1e-3, "action": action, "dsp": 2}], duration_s=0.03, dsps=4)
    [(when, _, message)] = noticed(report)
    assert "of kind identify" in message
    assert at_ms < when * 1e3 < at_ms + 3
    assert re.search(r"has had no heartbeat for \d+ refreshes", message)
    assert report["host"]["recomputed"] == 1 and report["tasks"]["identify"]["on_time"] == 1


def test_a_dsp_that_hangs_in_the_same_block_again_is_reset_again(tmp_path: Path) -> None:
    """The block was claimed again within the refresh of the reset. The host took this for work on another block."""
    programs = tmp_path / "programs"
    shutil.copytree(ROOT / "c40_programs", programs)
    (programs / "kernels" / "user.asm").write_text("kernel_hangs:\n        br      kernel_hangs\n")
    row = '[[tasks]]\nname = "hangs"\nprogram = "kernel_hangs"\nkind = 9\nimportance = 65530\nperiod_ms = 5\nheartbeat_ms = 1\n'
    settings = {"machine.dsps": 1, "machine.boot": "preloaded", "machine.programs": str(programs), "duration_s": 0.04}
    simulation = cmrc.Simulation(cmrc.config(toml=row, settings={**settings, "report.reference": "none"}))
    simulation.run()
    report = json.loads(simulation.report_json())
    assert report["audit"]["violations"] == []
    assert [dsp for _, dsp, _ in noticed(report)[:3]] == [0, 0, 0]
    # Its heartbeat is 1 ms, 8 refreshes; the factor is 3.
    assert all("has had no heartbeat for 24 refreshes" in message for _, _, message in noticed(report)[:3])
    assert report["dsps"][0]["resets"] >= 3


@pytest.mark.parametrize("idle", ["doorbell", "pause"])
@pytest.mark.parametrize("owner", [0, 33, 99, 0xFFFFFFFF])
def test_a_block_whose_owner_is_no_dsp_is_taken_back_and_no_dsp_is_reset(owner: int, idle: str, tmp_path: Path) -> None:
    """A program has acquired the list's semaphore, has overwritten its block's owner word, and hangs. Owners are 1 to
    16."""
    programs = tmp_path / "programs"
    shutil.copytree(ROOT / "c40_programs", programs)
    text = f"""
kernel_spoils:
        ldi     @EXEC_BLOCK, ar0
        ldhi    {owner >> 16}, ar1
        or      {owner & 0xFFFF}, ar1
        ldhi    0C001h, ar2             ; the holder of the list may write there
takes:  ldi     *ar2, r1
        bnz     takes
        sti     ar1, *+ar0(TB_OWNER)
        sti     r1, *ar2
hangs:  br      hangs
"""
    (programs / "kernels" / "user.asm").write_text(text)
    row = '[[tasks]]\nname = "spoils"\nprogram = "kernel_spoils"\nkind = 9\nimportance = 65530\nperiod_ms = 20\nheartbeat_ms = 1\n'
    settings = {
        "machine.dsps": 2,
        "machine.boot": "preloaded",
        "machine.programs": str(programs),
        "duration_s": 0.028,
        "machine.idle_policy": idle,
    }
    simulation = cmrc.Simulation(cmrc.config(toml=row, settings={**settings, "report.reference": "none"}))
    simulation.run()
    report = json.loads(simulation.report_json())
    assert report["audit"]["violations"] == []
    found = noticed(report)
    assert found and "of kind user.spoils" in found[0][2] and found[0][1] is None
    assert [dsp["resets"] for dsp in report["dsps"]] == [0, 0]


@pytest.mark.parametrize("minimum_refreshes", [16, 20])
@pytest.mark.parametrize("action", ["reset", "unplug"])
def test_a_dsp_that_boots_is_not_reset_for_the_block_of_before(action: str, minimum_refreshes: int) -> None:
    """Its block is put back while it boots, or just after."""
    events: list[dict[str, Any]] = [{"at_s": 0.02304, "action": action, "dsp": 0}]
    if action == "unplug":
        events.append({"at_s": 0.02305, "action": "plug", "dsp": 0})
    report = run(events, duration_s=0.034, dsps=3, minimum_refreshes=minimum_refreshes)
    [(_, dsp, message)] = noticed(report)
    assert dsp is None and "of kind torque_compensation" in message
    assert report["dsps"][0]["resets"] == 0
    *_, boot = report["dsps"][0]["boots"]
    assert boot["boot_s"] is not None and boot["boot_s"] < 0.0026


@pytest.mark.parametrize("at_s", [0.020028, 0.0200282, 0.0200284])
def test_a_claim_that_breaks_off_costs_one_reset_and_one_block(at_s: float) -> None:
    """DSP 0 stops between two words of its claim. It is reset once, then runs a block of avoidance to its end."""
    events = [{"at_s": at_s, "action": "freeze", "dsp": 0}]
    avoidance = {"load.parked": True, "kernels.avoidance": "dynamic_window"}
    report = run(events, duration_s=0.05, dsps=2, agvs=8, boot="preloaded", **avoidance)
    assert report["dsps"][0]["resets"] == 1 and report["host"]["recomputed"] <= 1
    assert report["tasks"]["obstacle_avoidance"]["response_ps"]["worst"] < 14.5e9


@pytest.mark.parametrize("limit", [20, 30])
def test_a_block_is_taken_away_at_the_refresh_of_its_limit(limit: int) -> None:
    """The limit is watchdog.minimum_refreshes, where that is more than the factor times the longest gap."""
    events = [{"at_s": 0.0211, "action": "hang", "dsp": 2}]
    report = run(events, duration_s=0.03, dsps=4, minimum_refreshes=limit)
    [(_, _, message)] = noticed(report)
    assert f"has had no heartbeat for {limit} refreshes" in message


def test_a_failure_in_avoidance_is_noticed_within_3_ms() -> None:
    # Two blocks of 8 ms every 20 ms, from 40 ms on: at 42 ms both run.
    report = run(
        [{"at_s": 0.042, "action": "hang", "dsp": dsp} for dsp in (0, 1, 2, 3)],
        duration_s=0.06,
        dsps=4,
        agvs=2,
        **PARKED,
        **{"load.avoidance_cycles": 200_000},
    )
    found = [when for when, _, message in noticed(report) if "obstacle_avoidance" in message]
    assert len(found) == 2 and all(0.042 < when < 0.045 for when in found)


@pytest.mark.parametrize("pause_ms", [3, 20, 60])
def test_a_pause_of_the_host_has_no_healthy_dsp_reset(pause_ms: float) -> None:
    # Blocks were claimed and DSPs idle during the host's pause. The host did not look, so it must not blame them.
    report = run([{"at_s": 0.1, "action": "pause_host", "lasts_ms": pause_ms}], duration_s=0.22, dsps=4, agvs=8, **LONG)
    assert report["host"]["skipped_refreshes"] >= pause_ms * 8 - 2
    assert report["failures"] == [] and [dsp["resets"] for dsp in report["dsps"]] == [0] * 4
    assert report["host"]["recomputed"] == 0


def test_one_that_dies_in_the_pause_is_found_after_it() -> None:
    events = [
        {"at_s": 0.1, "action": "pause_host", "lasts_ms": 60},
        *({"at_s": 0.102, "action": "hang", "dsp": dsp} for dsp in (1, 2)),
    ]
    report = run(events, duration_s=0.3, dsps=4, agvs=8, **LONG)
    reset = {failure["dsp"] for failure in report["failures"] if failure["kind"] in ("watchdog", "silent")}
    assert reset == {1, 2} and [dsp["resets"] for dsp in report["dsps"]] == [0, 1, 1, 0]


def test_a_host_kept_off_the_list_has_no_healthy_dsp_reset() -> None:
    # Eight DSPs that poll without a pause, and a host that tries again only every 20 us or more: a refresh takes up to
    # some ms.
    settings = {**LONG, "idle_policy": "spin", "host.semaphore_retry_ns": 20_000, "watchdog.semaphore_limit_us": 1e6}
    report = run([], duration_s=0.08, dsps=8, agvs=8, **settings)
    assert report["host"]["skipped_refreshes"] > 100 and report["host"]["refresh_duration_ps"]["worst"] > 2e9
    assert report["failures"] == [] and [dsp["resets"] for dsp in report["dsps"]] == [0] * 8


@pytest.mark.parametrize("factor", [2, 10])
def test_a_slow_dsp_that_beats_is_not_taken_for_broken(factor: float) -> None:
    report = run([], duration_s=0.08, dsps=2, cycle_time_factor=factor)
    assert noticed(report) == [] and report["tasks"]["identify"]["on_time"] == 1


TASK = '[[tasks]]\nname = "look"\nprogram = "kernel_none"\nkind = 9\nimportance = 0x100\nperiod_ms = 10\nheartbeat_ms = {}\n'


def test_a_heartbeat_longer_than_the_watchdogs_limit_is_refused() -> None:
    with pytest.raises(
        cmrc.ConfigError,
        match=r'own\.toml:1:1: tasks\.heartbeat_ms: 2\.5 ms of "look" are longer than the watchdog\'s limit, 16 refreshes: 2 ms',
    ):
        cmrc.config(toml=TASK.format(2.5), name="own.toml")
    with pytest.raises(cmrc.ConfigError, match="heartbeat_ms"):
        cmrc.config(toml=TASK.format(-1), name="own.toml")
    assert "heartbeat_ms = 2" in cmrc.config(toml=TASK.format(2)).to_toml()
    cmrc.config(toml=TASK.format(2.5), settings={"minimum_refreshes": 20})


HOLDS = """
kernel_holds:
        ldhi    hi16(WINDOW_A + SEMAPHORE_LIST), ar1
        or      lo16(WINDOW_A + SEMAPHORE_LIST), ar1
        ldi     *ar1, r0
kernel_holds_on:
        br      kernel_holds_on
"""


def test_an_ideal_run_goes_on_where_a_task_keeps_the_list(emulator: Path, tmp_path: Path) -> None:
    """There no access takes time, and the host asked for the list again and again at one instant. So did the ideal run
    beside every run of such a task, and the run never ended."""
    shutil.copytree(ROOT / "c40_programs", tmp_path / "programs")
    (tmp_path / "programs" / "kernels" / "user.asm").write_text(HOLDS)
    (tmp_path / "c.toml").write_text(
        '[machine]\nprograms = "programs"\n[[tasks]]\nname = "holds"\nprogram = "kernel_holds"\nkind = 14\n'
        "importance = 0xF3FF\nperiod_ms = 50\n"
    )
    subprocess.run(
        [emulator, "--config", "c.toml", "--duration", "0.06", "--quiet", "--report", "r.json"],
        cwd=tmp_path, check=True, timeout=100
    )  # fmt: skip
    report = json.loads((tmp_path / "r.json").read_text())
    assert "semaphore" in {failure["kind"] for failure in report["failures"]}
    assert report["reference"] == "ideal" and report["reference_problem"] is None
