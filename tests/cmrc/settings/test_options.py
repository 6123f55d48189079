"""Options of plant-and-bus.md 4.6 and 4.4: the trace of a run shows the effect of each."""

import json
import re
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cmrc import _core
from locations import AT_ONCE, AT_ONCE_OPTIONS
from traced_run import trace_of

cmrc = _core.cmrc
KIND = {"torque": 5, "pid": 6, "avoidance": 11}
OUTCOMES = ("on_time", "late", "unfinished", "never_started", "lost", "dropped")


def run(preset: str = "base", **settings: Any) -> dict[str, Any]:
    simulation = cmrc.Simulation(cmrc.config(preset=preset, settings={"report.reference": "none", **settings}))
    simulation.run()
    report: dict[str, Any] = json.loads(simulation.report_json())
    assert report["audit"]["violations"] == []
    for task in report["tasks"].values():
        assert task["released"] == sum(task[name] for name in OUTCOMES)
    return report


def claims_and_ends(
    path: Path, duration_s: float, *settings: str, preset: str = "base", dsps: int = 4
) -> list[tuple[float, str, int, int, int]]:
    """(second, "claim" or "finish", kind, tick, block)."""
    sets = [word for setting in settings for word in ("--set", setting)]
    trace, _report = trace_of(
        path, "--dsps", dsps, "--preset", preset, "--duration", duration_s, *AT_ONCE_OPTIONS, *sets
    )
    events, ticks = [], {}
    for line in trace.read_text().splitlines():
        found = re.match(r"([0-9.]+) \[dsp \d+\] (claim|finish) block=0x([0-9a-f]+) kind=(\d+)(?:.* tick=(\d+))?", line)
        if found is None:
            continue
        block = int(found[3], 16)
        if found[2] == "claim":
            ticks[block] = int(found[5])
        events.append((float(found[1]), found[2], int(found[4]), ticks[block], block))
    return events


def servo(events: list[tuple[float, str, int, int, int]]) -> dict[int, dict[tuple[str, int], float]]:
    ticks: dict[int, dict[tuple[str, int], float]] = defaultdict(dict)
    for at, what, kind, tick, _ in events:
        if kind in (KIND["torque"], KIND["pid"]):
            ticks[tick][what, kind] = at
    return {tick: seen for tick, seen in ticks.items() if len(seen) == 4}


def test_pid_waits_for_torque_compensation_of_its_tick(tmp_path: Path) -> None:
    beside = servo(claims_and_ends(tmp_path, 0.05))
    after = servo(claims_and_ends(tmp_path, 0.05, "pid_after_torque=true"))
    assert len(beside) == len(after) == 49
    assert all(seen["claim", KIND["pid"]] < seen["finish", KIND["torque"]] for seen in beside.values())
    assert all(seen["claim", KIND["pid"]] > seen["finish", KIND["torque"]] for seen in after.values())
    # It is claimed at the refresh that finds torque compensation done: the next one, 125 us after the tick.
    assert all(seen["claim", KIND["pid"]] - tick * 125e-6 < 2 * 125e-6 for tick, seen in after.items())
    assert run(duration_s=0.2, pid_after_torque=True)["tasks"]["pid"]["misses"] == 0


def most_at_once(events: list[tuple[float, str, int, int, int]]) -> int:
    out, most = 0, 0
    for _, what, kind, _, _ in events:
        if kind == KIND["avoidance"]:
            out += 1 if what == "claim" else -1
            most = max(most, out)
    return most


def test_a_cap_on_long_blocks_keeps_a_dsp_for_the_servo(tmp_path: Path) -> None:
    # Four AGVs, a block of 13.2 ms each every 20 ms, all released together. The servo guarantee of 4.5: one DSP more
    # than long blocks at a time.
    assert most_at_once(claims_and_ends(tmp_path, 0.1, "agv_phase=together", preset="saturated")) == 4
    assert (
        most_at_once(claims_and_ends(tmp_path, 0.1, "agv_phase=together", "long_blocks_max=3", preset="saturated")) == 3
    )
    capped = run(preset="saturated", duration_s=0.3, dsps=4, agv_phase="together", long_blocks_max=3)["tasks"]
    free = run(preset="saturated", duration_s=0.3, dsps=4, agv_phase="together")["tasks"]
    staggered = run(preset="saturated", duration_s=0.3, dsps=4)["tasks"]
    # Identify runs at the start and is as long: it is under the cap, too.
    assert capped["pid"]["misses"] == capped["torque_compensation"]["misses"] == 0
    assert free["pid"]["misses"] > 100
    # The price: the block that had to wait for another's end needs 26.4 ms, and has 20 ms. Staggered, each begins 5 ms
    # after the one before.
    assert capped["obstacle_avoidance"]["misses"] > 0
    assert sum(task["misses"] for task in staggered.values()) == 0


def test_slowed_robots_plan_less_often() -> None:
    full, crane, factor3 = (run(duration_s=3, **settings)["tasks"] for settings in (
        {}, {"work_mode": "slowed_crane"}, {"work_mode": "slowed_crane", "slow_factor": 3}))  # fmt: skip
    points = [tasks["trajectory_planning.crane"]["released"] for tasks in (full, crane, factor3)]
    # One point per 64, 96, 192 refreshes of 125 us, and at most three more than consumed.
    for released, interval_s in zip(points, (8e-3, 12e-3, 24e-3), strict=True):
        assert 2.9 / interval_s < released < 3 / interval_s + 4
    assert all(
        tasks["pid"]["misses"] == tasks["trajectory_planning.crane"]["misses"] == 0 for tasks in (full, crane, factor3)
    )


def test_slowed_agvs_have_a_longer_interval() -> None:
    config = cmrc.config(settings={"work_mode": "slowed_agv", "slow_factor": 1.75})
    assert config.intervals()["N_a_slowed"] == 280
    assert (
        cmrc.config(settings={"work_mode": "slowed_agv", "agv_interval_refreshes": 200}).intervals()["N_a_slowed"]
        == 200
    )
    with pytest.raises(cmrc.ConfigError, match=r"N\^_a = 480 is above N\^_a,max = 320"):
        cmrc.config(settings={"work_mode": "slowed_agv", "slow_factor": 3})


@pytest.mark.campaign
def test_a_slowed_crane_carries_its_load_the_same_way() -> None:
    # The load itself, not the jib, which leads it by the acceleration. Planned is the same way in k times the time; the
    # load leaves it by what the trajectory neglects (docs/kernels.md, Trajectory), and that is of second order in the
    # accelerations: a quarter at half the speed. The host begins at 0: a start later than that is no part of the way,
    # and takes as long in all three.
    halved_rates = {
        "dsps": 1,
        "refresh_frequency_hz": 4000,
        "servo_frequency_hz": 500,
        "alpha_refreshes": 12,
        "beta_refreshes": 6,
        **AT_ONCE,
    }
    ways, points = {}, []
    for factor in (1.0, 1.5, 3.0):
        mode = {} if factor == 1 else {"work_mode": "slowed_crane", "slow_factor": factor}
        simulation = cmrc.Simulation(
            cmrc.config(settings={"duration_s": 14.0 * factor, "report.reference": "none", **halved_rates, **mode})
        )
        simulation.run()
        signals = simulation.signals()
        points.append(json.loads(simulation.report_json())["tasks"]["inverse_kinematics.crane"]["released"])
        times = [factor * second for second in np.arange(1.0, 13.5, 0.5)]
        ways[factor] = np.array([np.interp(times, signals["time_s"], signals[f"payload_{axis}_m"]) for axis in "xyz"])
    assert max(points) - min(points) <= 3
    off = {factor: float(np.abs(ways[factor] - ways[3.0]).max()) for factor in (1.0, 1.5)}
    assert off[1.0] < 0.05  # of 12 m, at up to 1 m/s
    assert off[1.5] < off[1.0] / 2
    assert np.ptp(ways[1.0][1]) > 2


def test_t_grows_by_one_or_by_what_has_elapsed() -> None:
    # The host pauses for 5 ms, 40 refreshes, while servo blocks wait for their tick: after it they are 40 older, or 1.
    oldest = {}
    for reading in ("elapsed", "one"):
        events = [{"at_s": 0.0504, "action": "pause_host", "lasts_ms": 5}]
        simulation = cmrc.Simulation(
            cmrc.config(settings={"duration_s": 0.06, "time_after_delay": reading, "dsps": 1}, events=events)
        )
        symbol, seen = simulation.symbol, [0]
        for k in range(40):
            simulation.run_until(0.0553 + k * 5e-6)
            seen += [
                simulation.peek(symbol("BLOCK_POOL") + n * symbol("BLOCK_WORDS") + symbol("TB_T"))
                for n in range(symbol("BLOCK_COUNT"))
            ]
        oldest[reading] = max(seen)
    assert oldest["elapsed"] >= 40
    assert oldest["one"] < 20


def test_an_agvs_buffer_may_be_as_deep_as_its_fifo(tmp_path: Path) -> None:
    with pytest.raises(cmrc.ConfigError, match="an integer from 0 to 4"):
        cmrc.config(settings={"agv_buffer_points": 5})
    with pytest.raises(cmrc.ConfigError, match="an integer from 1 to 2"):
        cmrc.config(settings={"buffer_points": 3})


def test_split_tasks_let_the_servo_through() -> None:
    # One DSP: identify is longer than a servo period, and in blocks of one row of the bay it is not.
    whole, split = (run(duration_s=0.1, dsps=1, slice_cycles=cycles)["tasks"] for cycles in (0, 10_000))
    assert whole["pid"]["misses"] > 0
    assert split["pid"]["misses"] == split["torque_compensation"]["misses"] == 0
    # Two blocks, one job: released once, and what it ran is what both parts ran.
    assert (split["identify"]["released"], split["identify"]["on_time"]) == (1, 1)
    ran, responded = split["identify"]["execution_ps"]["mean"], split["identify"]["response_ps"]["mean"]
    assert whole["identify"]["execution_ps"]["mean"] == pytest.approx(ran, rel=0.1) and responded > ran + 125e6
    cycles = sum(split["identify"]["execution_cycles"].values())
    assert cycles * 40_000 == pytest.approx(ran, rel=1e-6)
    # Four AGVs and four DSPs: every block of 13.2 ms takes a DSP; in pieces of 0.4 ms the servo comes in between.
    saturated = run(preset="saturated", duration_s=0.2, dsps=4, agv_phase="together", slice_cycles=10_000)["tasks"]
    assert saturated["pid"]["misses"] == 0
    # 330 000 cycles in 33 blocks: one job each, loaded again in the first period after it.
    row = saturated["obstacle_avoidance"]
    assert 4 <= row["on_time"] + row["late"] and row["released"] <= 4 * 9
    assert row["execution_ps"]["best"] >= 330_000 * 40_000
