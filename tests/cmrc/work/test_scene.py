"""Short runs of the dock with the real programs: identities, reproducibility, failures, the presets."""

import json
from collections.abc import Callable
from typing import Any

import pytest
from audited_run import misses
from cmrc import _core
from locations import AT_ONCE

cmrc = _core.cmrc
Report = dict[str, Any]
OUTCOMES = ("on_time", "late", "unfinished", "never_started", "lost", "dropped")


def run(script: list[tuple[float, str, int]] | None = None, preset: str = "base", **settings: Any) -> Report:
    simulation = cmrc.Simulation(
        cmrc.config(preset=preset, settings={**AT_ONCE, "report.reference": "none", **settings})
    )
    for time_s, action, slot in script or []:
        simulation.at({"at_s": time_s, "action": action, "dsp": slot})
    simulation.run()
    report: Report = json.loads(simulation.report_json())
    for task in report["tasks"].values():
        assert task["released"] == sum(task[name] for name in OUTCOMES)
    for dsp in report["dsps"]:
        assert sum(dsp["causes"].values()) == dsp["cycles"]
    return report


@pytest.fixture(scope="module")
def base() -> Report:
    return run(duration_s=0.5)


def test_servo_jobs_are_released_at_every_tick(base: Report) -> None:
    for kind in ("pid", "torque_compensation"):
        assert base["tasks"][kind]["released"] == 499  # ticks 1 ms, 2 ms, ... 499 ms
        assert base["tasks"][kind]["on_time"] == 499


def test_four_dsps_meet_every_deadline_at_base_rates(base: Report) -> None:
    assert misses(base) == 0
    assert base["host"]["skipped_refreshes"] == 0
    assert base["host"]["refreshes"] == 3999
    held = base["host"]["semaphore_hold_ps"]
    assert held["count"] > 3900 and 0 < held["best"] < held["worst"] < 125e6  # within a refresh


def test_the_crane_plans_as_often_as_it_consumes(base: Report) -> None:
    # 8 ms per point, two points ahead of the one consumed.
    points = base["tasks"]["trajectory_planning.crane"]["released"]
    assert 0.49 * 125 <= points <= 0.5 * 125 + 3


def test_a_run_repeats_bit_for_bit_and_in_any_turn_order(base: Report) -> None:
    assert run(duration_s=0.5)["hash"] == base["hash"]
    assert run(duration_s=0.5, turn_order=12345)["hash"] == base["hash"]


def test_a_run_does_not_depend_on_how_it_is_cut(base: Report) -> None:
    simulation = cmrc.Simulation(cmrc.config(settings={**AT_ONCE, "duration_s": 0.5}))
    for time_s in (0.0001234, 0.1, 0.1000001, 0.37):
        simulation.run_until(time_s)
    simulation.run(slice_s=0.013)
    assert json.loads(simulation.report_json())["hash"] == base["hash"]


def test_the_hash_distinguishes_configurations(base: Report) -> None:
    assert run(duration_s=0.5, dsps=3)["hash"] != base["hash"]


@pytest.mark.parametrize("dsps", [1, 16])
def test_any_number_of_dsps(dsps: int) -> None:
    report = run(duration_s=0.1, dsps=dsps)
    assert len(report["dsps"]) == dsps
    assert report["tasks"]["pid"]["released"] == 99


@pytest.mark.parametrize("policy", ["pause", "spin"])
def test_polling_dsps_do_not_shut_the_host_out(policy: str) -> None:
    report = run(duration_s=0.1, dsps=4, idle_policy=policy)
    assert misses(report) == 0
    assert report["host"]["doorbells"] == 0


def test_misses_fall_as_dsps_are_added_to_the_saturated_preset() -> None:
    # A long block per AGV, all at once: three DSPs cannot carry them, four leave nothing for the servo while they run.
    counts = [misses(run(preset="saturated", duration_s=0.3, dsps=n, agv_phase="together")) for n in (2, 4, 5)]
    assert counts[0] > 1.3 * counts[1] > 0
    assert counts[2] == 0
    # One after the other, four are enough.
    assert misses(run(preset="saturated", duration_s=0.3, dsps=4)) == 0


@pytest.mark.parametrize(("action", "kind"), [("hang", "pid"), ("fail", "pid"), ("unplug", "torque_compensation")])
def test_a_block_of_a_dead_dsp_is_run_again(action: str, kind: str) -> None:
    # The release at 100 ms: DSP 0 takes torque compensation, DSP 1 PID, both within 40 us; the watchdog's limit is 16
    # refreshes of 125 us.
    slot = {"pid": 1, "torque_compensation": 0}[kind]
    report = run([(0.10004, action, slot)], duration_s=0.15, dsps=2)
    task = report["tasks"][kind]
    assert report["host"]["recomputed"] == 1
    assert (task["dropped"], task["late"], task["lost"]) == (2, 1, 0)
    assert task["on_time"] == 150 - 3 - 1
    [failure] = report["failures"]
    assert failure["dsp"] == slot
    assert 0.100 + 16 * 125e-6 < failure["time_s"] < 0.100 + 19 * 125e-6


def test_a_hung_dsp_works_again_and_a_dead_one_does_not() -> None:
    states = {action: run([(0.10004, action, 1)], duration_s=0.15, dsps=2)["dsps"][1] for action in ("hang", "fail")}
    assert not states["hang"]["state"].startswith("halted")
    assert states["fail"]["state"].startswith("halted")


def test_a_dsp_that_dies_holding_the_list_does_not_stop_it() -> None:
    # A sweep over a claim: wherever it breaks off, the servo continues with few ticks lost.
    freed = 0
    for k in range(10, 40, 2):
        report = run([(0.05 + k * 0.4e-6, "hang", 0)], duration_s=0.08, dsps=2)
        freed += report["host"]["semaphores_freed"]
        assert report["stop_reason"] == "completed"
        assert (
            sum(
                report["tasks"][kind]["dropped"] + report["tasks"][kind]["late"]
                for kind in ("pid", "torque_compensation")
            )
            <= 3
        )
    assert freed > 0


def test_pulling_every_dsp_ends_the_run() -> None:
    simulation = cmrc.Simulation(cmrc.config(settings={"duration_s": 5, "dsps": 2, "report.reference": "none"}))
    for slot in (0, 1):
        simulation.at({"at_s": 0.1, "action": "unplug", "dsp": slot})
    simulation.run()
    report = json.loads(simulation.report_json())
    assert report["stop_reason"] == "no_dsp_left"
    assert report["account_end_s"] < 1
    assert simulation.exit_status == 1


def test_a_dsp_plugged_in_starts_working_by_itself() -> None:
    report = run([(0.05, "unplug", 0), (0.08, "plug", 0)], duration_s=0.2, dsps=2)
    assert report["dsps"][0]["state"] != "unplugged"
    assert report["dsps"][0]["resets"] == 0 and report["dsps"][0]["boots"][-1]["reset_at_s"] == 0.08
    assert report["dsps"][0]["claims"] > 150  # more than half of what it did in 200 ms


def test_a_rigid_crane_does_not_sway() -> None:
    simulation = cmrc.Simulation(
        cmrc.config(settings={"duration_s": 4, "crane_model": "rigid", "report.reference": "none"})
    )
    simulation.run()
    signals = simulation.signals()
    assert abs(signals["sway_alpha_rad"]).max() == abs(signals["sway_beta_rad"]).max() == 0
    assert signals["payload_x_m"] == pytest.approx(signals["tip_x_m"], abs=1e-9)
    swaying = cmrc.Simulation(cmrc.config(settings={"duration_s": 4, "report.reference": "none"}))
    swaying.run()
    assert abs(swaying.signals()["sway_beta_rad"]).max() > 1e-4
    error = json.loads(simulation.report_json())["pid_error"]
    assert max(error[joint]["peak"] for joint in ("s", "psi", "phi", "kappa")) < 1e-3
    assert signals["psi_rad"][-1] > 0.9  # it has slewed to the ship


def test_strict_turns_a_miss_into_a_failed_run() -> None:
    status: Callable[[bool], int] = lambda strict: _strict_status(strict)
    assert (status(False), status(True)) == (0, 1)


def _strict_status(strict: bool) -> int:
    # One DSP: identify alone takes longer than a servo period.
    simulation = cmrc.Simulation(
        cmrc.config(settings={"duration_s": 0.04, "dsps": 1, "strict": strict, "report.reference": "none"})
    )
    simulation.run()
    return int(simulation.exit_status)


def test_progress_can_stop_a_run() -> None:
    simulation = cmrc.Simulation(cmrc.config(settings={"duration_s": 1}))
    simulation.run(lambda simulated, duration: simulated < 0.05)
    report = json.loads(simulation.report_json())
    assert report["stop_reason"] == "interrupted"
    assert 0.05 <= report["simulated_s"] <= 0.08


def test_a_directory_without_programs_is_bad_input(tmp_path: Any) -> None:
    with pytest.raises(cmrc.ConfigError, match=r"dsp\.asm is not there"):
        cmrc.Simulation(cmrc.config(settings={"programs": str(tmp_path)}))
