"""Errors, lag, demand and rates (docs/report.md, Errors): recomputed from signals and traces. A controller without
enough processor time must not look better."""

import itertools
import json
import subprocess
from pathlib import Path
from typing import Any

import cmrc
import numpy as np
import pytest
from locations import BUILD
from low_rates import QUARTER_RATES

EMULATOR = BUILD / "bin" / "emulator"
EVERY_LATCH = {"report.signal_decimation": 1}
# The hoist and the gains of 22 November 2026: the figures of measures.md 3 are measured with them. That hoist cannot
# hold 24 t, but within 5 s it lifts nothing.
NOVEMBER = {
    "slewing.hoist.rated_torque_n_m": 3185.0, "slewing.hoist.rotor_inertia_kg_m2": 16.0, "slewing.rated_load_kg": 19_500, "dock.container_mass_kg": 19_000,
    "control.travel_bandwidth_rad_s": 3.0, "control.slew_bandwidth_rad_s": 5.0, "control.luff_bandwidth_rad_s": 5.0, "control.hoist_bandwidth_rad_s": 8.0,
    "control.rotator_bandwidth_rad_s": 5.0,
}  # fmt: skip
SIX = ("on_time", "late", "unfinished", "never_started", "lost", "dropped")
F_T = 125.0


def starved(factor: float, duration_s: float = 5.0, **more: Any) -> cmrc.Result:
    return cmrc.run(
        dsps=1,
        duration_s=duration_s,
        settings={**NOVEMBER, "machine.cycle_time_factor": factor, "report.misses_max": 0},
        **more,
    )


def as_recorded(values: np.ndarray) -> np.ndarray:
    """Positions as a course records them: rounded to the nearest 2^-30 m or rad (docs/report.md, Errors)."""
    return np.asarray(np.floor(values * 2.0**30 + 0.5) / 2.0**30)


def loads(signals: Any) -> np.ndarray:
    return as_recorded(np.stack([signals[f"payload_{axis}_m"] for axis in "xyz"]))


def test_a_slower_machine_never_looks_better() -> None:
    """The property of measures.md 3: the same scene with slower and slower instruction cycles."""
    first = cmrc.Simulation(dsps=1, duration_s=5.0, settings={**NOVEMBER, "report.misses_max": 0})
    runs = [first.run()]
    reference = first.reference()
    runs += [starved(factor, reference=reference) for factor in (10, 12, 15, 18, 22, 30, 60)]
    rms = [run.errors["load_m"]["rms"] for run in runs]
    cost = [run.report["control_cost"]["cost_m2s"] for run in runs]
    lag = [run.errors["lag"]["crane"]["end_s"] for run in runs]
    for values in (rms, cost):
        assert all(after >= 0.95 * before for before, after in itertools.pairwise(values)), values
    assert all(after >= before - 1 / F_T for before, after in itertools.pairwise(lag)), lag
    for run in runs[5:]:
        assert 0.95 <= run.errors["load_of_doing_nothing"] <= 1.05
        assert run.rates["f_t"]["finished"] == 0 and run.rates["f_t"]["missed_share"] == 1
    # Regression figures of this controller. measures.md 3 has 0.0006, 0.0081, 0.034, 0.205, measured independently with
    # an earlier PID that did not detect errors: its ticks took 75 us. They take 93 us now, since PID observes the wind;
    # and torque compensation reads the load cell. Where the servo is almost lost, a few per cent of a task's time
    # change the result: at factor 15 hardly any time is left for planning.
    assert rms[:4] == pytest.approx([0.0006, 0.0102, 0.1134, 0.3234], rel=0.05)


def test_errors_are_those_of_the_ideal_run_of_the_same_scene() -> None:
    run = cmrc.run(dsps=1, duration_s=0.6, settings={**EVERY_LATCH, "machine.cycle_time_factor": 14})
    ideal = cmrc.run(
        dsps=1,
        duration_s=0.6,
        ideal=True,
        settings={**EVERY_LATCH, "machine.cycle_time_factor": 14, "report.reference": "none"},
    )
    begin, end = run.errors["window_s"]
    window = (ideal.signals["time_s"] >= begin - 1e-9) & (ideal.signals["time_s"] <= end + 1e-9)
    distance = np.linalg.norm(loads(run.signals) - loads(ideal.signals), axis=0)[window]
    distance_errors = run.errors["load_m"]
    assert distance_errors["rms"] == pytest.approx(np.sqrt(np.mean(distance**2)), rel=1e-9)
    assert (distance_errors["peak"], distance_errors["end"]) == pytest.approx(
        (distance.max(), distance[-1]), rel=1e-9
    ) and distance_errors["peak"] > 1e-5
    still = np.linalg.norm(loads(ideal.signals)[:, window] - loads(ideal.signals)[:, window][:, :1], axis=0)
    assert run.errors["doing_nothing_m"] == pytest.approx(np.sqrt(np.mean(still**2)), rel=1e-9)
    weighed = 0.0
    for joint, lever in {"s": 1, "psi": 34.5, "phi": 32, "l": 1, "kappa": 12.192 / 2}.items():
        unit = run.errors["joints"][joint]["unit"]
        meant = as_recorded(ideal.signals[f"{joint}_{unit}"])
        error = as_recorded(run.signals[f"{joint}_{unit}"]) - meant
        assert run.signals[f"{joint}_error_{unit}"] == pytest.approx(error, abs=1e-15)
        assert run.signals[f"{joint}_reference_{unit}"][1:] == pytest.approx(meant[1:], abs=1e-15)
        assert run.errors["joints"][joint]["rms"] == pytest.approx(
            np.sqrt(np.mean(error[window] ** 2)), rel=1e-9, abs=1e-15
        )
        weighed += float(((lever * error[window]) ** 2).sum()) * 125e-6
    cost = run.report["control_cost"]
    codes = [run.signals[f"{joint}_code"] for joint in ("s", "psi", "phi", "l", "kappa")]
    assert cost["error_m2s"] == pytest.approx(weighed, rel=1e-9)
    assert cost["drive_s"] == pytest.approx(sum(float(((code / 2047) ** 2).sum()) for code in codes) * 125e-6, rel=0.01)
    assert cost["cost_m2s"] == pytest.approx(cost["error_m2s"] + cost["rho_m2"] * cost["drive_s"])


def test_path_errors_take_the_lag_out() -> None:
    result = starved(18, 3.0)
    joints = result.errors["joints"]
    assert joints["psi"]["rms"] > 10 * joints["psi"]["path"]["rms"] > 0
    assert result.errors["lag"]["crane"]["end_s"] > 0.5


@pytest.mark.parametrize(
    ("dsps", "more"), [(1, {"preset": "saturated"}), (2, {}), (1, {"settings": {"machine.cycle_time_factor": 16}})]
)
def test_demand_is_what_the_ideal_run_released(dsps: int, more: dict[str, Any]) -> None:
    real = cmrc.run(dsps=dsps, duration_s=1.02, **more).report
    with_reference_off = {**more.get("settings", {}), "report.reference": "none"}
    ideal = cmrc.run(dsps=1, duration_s=1.02, ideal=True, **{**more, "settings": with_reference_off}).report
    for kind, demand in real["errors"]["demand"].items():
        own = real["tasks"][kind]
        assert demand["released"] == own["released"] == sum(own[outcome] for outcome in SIX)
        assert demand["demanded"] == ideal["tasks"][kind]["released"], kind
        assert demand["demanded"] + demand["extra"] == demand["released"] + demand["not_demanded"]
        assert demand["misses"] == own["misses"]
    for name, rate in real["rates"].items():
        kinds = [real["errors"]["demand"][kind] for kind in rate["kinds"] if kind in real["errors"]["demand"]]
        assert rate["demanded"] == sum(kind["demanded"] for kind in kinds), name
        if rate["demanded"]:
            assert rate["missed_share"] == pytest.approx(
                (rate["misses"] + rate["not_demanded"]) / (rate["demanded"] + rate["extra"])
            )


def test_a_starving_servo_does_not_stop_the_demand_for_points() -> None:
    report = cmrc.run(dsps=1, preset="saturated", duration_s=1.02).report
    planning = report["errors"]["demand"]["trajectory_planning.crane"]
    assert planning["demanded"] >= 124 and planning["released"] < 10
    assert planning["not_demanded"] == planning["demanded"] - planning["released"]
    assert report["rates"]["f_t"]["missed_share"] > 0.9


def test_realised_rates_count_finished_jobs_in_the_time_of_demand() -> None:
    result = cmrc.run(dsps=2, duration_s=3.0)
    servo = result.errors["demand"]["pid"]
    begin, end = result.errors["window_s"]
    assert servo["realised_hz"] == pytest.approx(servo["finished"] / (end - begin))
    assert servo["demanded_hz"] == pytest.approx(1000, abs=1) and servo["realised_worst_hz"] <= 1000
    assert result.errors["demand"]["identify"]["realised_hz"] is None
    shorter = cmrc.run(dsps=2, duration_s=0.5).errors["demand"]["pid"]
    assert shorter["realised_worst_hz"] == pytest.approx(shorter["realised_hz"])  # one window


def test_pid_that_never_ran_has_no_error_of_its_own() -> None:
    assert starved(60, 0.5).report["pid_error"]["psi"] == {"unit": "rad", "rms": None, "peak": None}


def test_a_starved_run_is_better_than_the_ideal_in_nothing() -> None:
    found = cmrc.compare(dsps=1, preset="saturated", duration_s=1.5).report["metrics"]
    more_is_better = ("f_p realised", "f_t realised", "f_a realised", "containers delivered")
    compared = 0
    for name, row in found.items():
        if row["measures"] == "effort" or row["run"] is None or row["ideal"] is None:
            continue
        sign = -1 if name.startswith(more_is_better) else 1
        assert sign * row["difference"] >= 0, name
        compared += 1
    assert compared > 40
    for name in ("load error RMS", "lag crane at the end", "control cost", "f_p missed", "f_t missed"):
        assert found[name]["difference"] > 0, name
    for name in ("f_p realised", "f_t realised"):
        assert found[name]["difference"] < 0, name


def test_the_ideal_run_has_no_error_against_itself() -> None:
    result = cmrc.run(dsps=1, duration_s=1.0, ideal=True)
    assert result.errors["load_m"] == {"rms": 0, "peak": 0, "end": 0} and result.errors["lag"]["crane"] == {
        "end_s": 0,
        "peak_s": 0,
    }
    assert all(joint["path"]["peak"] == 0 for joint in result.errors["joints"].values())
    assert all(kind["not_demanded"] == kind["extra"] == 0 for kind in result.errors["demand"].values())


def test_without_a_reference_nothing_is_called_an_error() -> None:
    result = cmrc.run(dsps=2, duration_s=0.1, settings={"report.reference": "none"})
    assert (result.report["errors"], result.report["rates"], result.report["control_cost"]["cost_m2s"]) == (
        None,
        None,
        None,
    )
    assert "Errors against" not in result.text and "tracking" not in result.text.lower()
    assert not any("_error_" in name or "_reference_" in name for name in result.signals)
    with pytest.raises(KeyError, match="reference"):
        _ = result.errors


def test_a_run_cut_by_its_caller_is_measured_alike() -> None:
    whole = cmrc.run(dsps=1, duration_s=0.5, settings={"machine.cycle_time_factor": 12}).report
    cut = cmrc.Simulation(dsps=1, duration_s=0.5, settings={"machine.cycle_time_factor": 12})
    for time in (0.0131, 0.2, 0.2500001, 0.4999):
        cut.run_until(time)
        assert cut.result().report["errors"] is None  # it is not over
    cut.run_until(0.5)
    ended = cut.result().report
    apart = ("elapsed_s", "reference_elapsed_s")
    assert {k: v for k, v in ended.items() if k not in apart} == {k: v for k, v in whole.items() if k not in apart}


def test_an_interrupted_run_is_measured_as_far_as_it_came_and_continues() -> None:
    simulation = cmrc.Simulation(dsps=2, duration_s=0.4)
    part = simulation.run(lambda now, _: now < 0.1)
    assert part.stop_reason == "interrupted" and part.errors["window_s"][1] == part.report["simulated_s"] < 0.2
    assert part.rates["f_p"]["demanded"] == pytest.approx(2 * (part.report["simulated_s"] - 0.02) * 1000, abs=4)
    rest, whole = simulation.run(), cmrc.run(dsps=2, duration_s=0.4)
    assert rest.hash == whole.hash and rest.errors == whole.errors and rest.rates == whole.rates


def test_the_rates_of_an_interrupted_run_are_those_of_its_window() -> None:
    """A host that pauses runs faster than its ideal run: the window ends where that one has come."""
    pause = {"at_s": 0.1, "action": "pause_host", "lasts_ms": 4800}
    result = cmrc.Simulation(dsps=2, duration_s=30.0, events=[pause]).run(lambda now, _: now < 5.2)
    end = result.errors["window_s"][1]
    assert result.stop_reason == "interrupted" and end <= result.report["simulated_s"]
    rate = result.rates["f_p"]
    assert rate["released"] <= 2 * (end - 0.02) * 1000 + 4 and rate["misses"] <= rate["released"]
    assert rate["finished"] <= rate["released"] and rate["extra"] <= 4
    assert rate["realised_hz"] == pytest.approx(rate["finished"] / 2 / (end - 0.02), rel=0.02)


def test_one_ideal_run_serves_every_number_of_dsps_and_no_other_scene() -> None:
    simulation = cmrc.Simulation(dsps=1, duration_s=0.2)
    simulation.run()
    reference = simulation.reference()
    shared, own = cmrc.run(dsps=3, duration_s=0.2, reference=reference), cmrc.run(dsps=3, duration_s=0.2)
    assert shared.errors == own.errors and shared.rates == own.rates
    with pytest.raises(cmrc.ConfigError, match="another configuration"):
        cmrc.run(dsps=3, duration_s=0.2, agvs=2, reference=reference)


def test_what_the_operator_sets_happens_in_the_ideal_run_too() -> None:
    simulation = cmrc.Simulation(dsps=4, duration_s=0.4)
    simulation.run_until(0.1)
    simulation.at(0.2, "fail_drive", joint="slew")
    result = simulation.run()
    assert result.errors["load_m"]["peak"] < 1e-3  # the ideal run's crane lost the same drive


# ---- the lag beyond the last milestone of the window -----------------------------------------------------------------


def test_the_lag_grows_beyond_the_last_milestone_while_the_ideal_run_moves() -> None:
    """One point per second. The last one within the window is used at about 2 s. The machine dies at 2.1 s, 0.9 s
    before the window ends; the crane of the ideal run moves on."""
    scene: dict[str, Any] = {"dsps": 2, "duration_s": 3.0, "settings": {"rates.crane_point_frequency_hz": 1.0}}
    dead = cmrc.run(**scene, events=[{"at_s": 2.1, "action": "fail", "dsp": dsp} for dsp in (0, 1)])
    assert dead.stop_reason == "no_dsp_left"
    assert 0.7 < dead.errors["lag"]["crane"]["end_s"] <= dead.errors["lag"]["crane"]["peak_s"] < 0.91
    alive = cmrc.run(**scene)
    assert alive.errors["lag"]["crane"]["peak_s"] < 0.005  # it does what the ideal run does


def test_where_the_window_ends_changes_no_lag() -> None:
    """One point per second. The ideal run uses one at 2.022 s, the run 2 ms later; a window that ends between the two
    must not cost the run the second since the point before."""
    for end in (2.021, 2.022, 2.023, 2.024):
        run = cmrc.run(dsps=2, duration_s=end, settings={"rates.crane_point_frequency_hz": 1.0})
        lag = run.errors["lag"]["crane"]
        assert 0.0015 < lag["end_s"] <= lag["peak_s"] < 0.003, end
        assert run.errors["joints"]["psi"]["path"]["peak"] < 5e-6, end


def test_the_lag_of_a_dead_machine_grows_by_a_second_per_second_where_points_are_far_apart() -> None:
    def lag(end: float) -> float:
        dead = [{"at_s": 1.1, "action": "fail", "dsp": dsp} for dsp in (0, 1)]
        settings = {"rates.crane_point_frequency_hz": 1.0}
        return float(cmrc.run(dsps=2, duration_s=end, settings=settings, events=dead).errors["lag"]["crane"]["end_s"])

    early, late = lag(2.5), lag(3.0)
    assert late - early == pytest.approx(0.5, abs=1e-3) and 3.0 - 2.03 < late < 3.0 - 1.02


def test_the_lag_of_a_vehicle_is_counted_from_its_last_points() -> None:
    """A point each 20 ms. The machine dies while both vehicles drive. Each uses the points that it has (three at most),
    and brakes; the vehicles of the ideal run drive on."""
    dead = [{"at_s": 2.0, "action": "fail", "dsp": dsp} for dsp in range(3)]
    run = cmrc.run(dsps=3, duration_s=3.0, events=dead, settings={"load.driving": True, "agvs": 2})
    for vehicle in ("agv 0", "agv 1"):
        lag, error = run.errors["lag"][vehicle], run.errors["agvs"][vehicle]
        assert 2.0 < 3.0 - lag["end_s"] < 2.06 and lag["peak_s"] == lag["end_s"]
        assert 0.3 < error["end"] == error["peak"]


# ---- how runs end ----------------------------------------------------------------------------------------------------


def test_when_the_last_dsp_is_gone_the_plant_continues_braked() -> None:
    result = cmrc.run(
        dsps=1, duration_s=16.0, events=[{"at_s": 4.0, "action": "fail", "dsp": 0}], settings=QUARTER_RATES
    )
    report = result.report
    assert report["stop_reason"] == "no_dsp_left" and report["account_end_s"] == pytest.approx(4.5, abs=0.02)
    assert report["simulated_s"] == pytest.approx(report["account_end_s"] + 10, abs=1e-6)
    after = report["after_stop"]
    assert after["load_moved_m"] > 0.1 and after["sway_peak_rad"] > 0.01
    late = result.signals["time_s"] > 6.0
    assert np.ptp(result.signals["psi_rad"][late]) == pytest.approx(0, abs=1e-6)  # braked
    assert np.abs(result.signals["sway_beta_rad"][late]).max() > 0.01  # and the load swings
    assert result.signals["time_s"][-1] == pytest.approx(report["simulated_s"], abs=0.02)
    assert result.errors["window_s"][1] == 16.0  # not the end of the run
    assert result.errors["load_m"]["end"] > 1.0
    assert "After the stop, braked" in result.text
    assert not any("drive_resumed" in failure["message"] for failure in report["failures"])


def test_the_sway_at_the_end_is_that_of_two_seconds_and_of_the_instant_at_which_they_begin() -> None:
    """The account ends at 1.5 s, the run at 3.75 s, and the load swings less and less from 1.5 s on: the window's
    largest sway is at its start, 1.75 s."""
    settings = {**EVERY_LATCH, "run.after_stop_s": 2.25, "report.reference": "none"}
    result = cmrc.run(dsps=1, duration_s=4.0, events=[{"at_s": 1.0, "action": "fail", "dsp": 0}], settings=settings)
    report = result.report
    ended, distance_errors = (report["account_end_s"], report["simulated_s"]), report["after_stop"]["sway_end_rad"]
    assert ended == (1.5, 3.75)
    sway = np.hypot(result.signals["sway_alpha_rad"], result.signals["sway_beta_rad"])
    begins = np.searchsorted(result.signals["time_s"], 1.75 - 1e-9)
    before, most, after = float(sway[begins - 1]), float(sway[begins]), float(sway[begins + 1 :].max())
    assert before > most > after
    assert distance_errors == pytest.approx(most, rel=1e-9)


def test_a_run_interrupted_after_its_account_has_ended_continues_with_the_same_reason() -> None:
    whole = cmrc.run(dsps=1, duration_s=1.5, events=[{"at_s": 0.1, "action": "unplug", "dsp": 0}])
    cut = cmrc.Simulation(dsps=1, duration_s=1.5, events=[{"at_s": 0.1, "action": "unplug", "dsp": 0}])
    part = cut.run(lambda now, _: now < 1.0)
    assert (part.stop_reason, part.report["account_end_s"]) == ("interrupted", whole.report["account_end_s"])
    rest = cut.run()
    assert (
        rest.stop_reason == whole.stop_reason == "no_dsp_left"
        and rest.hash == whole.hash
        and rest.errors == whole.errors
    )


def test_a_crane_whose_drives_stay_stopped_ends_the_run() -> None:
    result = cmrc.run(dsps=1, preset="saturated", duration_s=2.5, settings={"run.after_stop_s": 1.0})
    assert result.stop_reason == "drives_stopped"
    assert 1.0 < result.report["simulated_s"] < 2.0
    assert result.errors["window_s"][1] == 2.5


HOME_AT_ONCE = """
[[processes]]
number = 7
name = "crane to initial state"
robot = "crane"
subprocesses = [3, 4]
steps = ["hold 0.05"]
initial = [1, 4]
final = true

[[processes]]
number = 8
name = "AGV to initial state"
robot = "agv"
steps = ["hold 0.03"]
initial = [1, 4, 5]
replaces = [6]
final = true
"""


def test_a_run_until_the_job_is_done_ends_when_processes_7_and_8_have_ended(tmp_path: Path) -> None:
    file = tmp_path / "home.toml"
    file.write_text(HOME_AT_ONCE, encoding="utf-8")
    report = cmrc.run(config=file, dsps=2, duration_s=2.0, agvs=2, settings={"run.until": "job_done"}).report
    assert report["stop_reason"] == "job_done" and 0.05 < report["simulated_s"] < 0.15
    assert report["failures"] == [] and report["makespan_s"] is None  # nothing was delivered
    assert report["errors"]["window_s"][1] < 0.2


@pytest.mark.campaign
def test_a_job_that_is_done_ends_the_run_without_failures(tmp_path: Path) -> None:
    """One container a few metres away, on the gantry: processes 1 to 8."""
    layout = tmp_path / "layout.toml"
    layout.write_text(
        "[home]\nx_m = 0.1\ny_m = 9.8\nz_m = 7.2\n[[containers]]\nx_m = 0.0\ny_m = 10.0\n", encoding="utf-8"
    )
    settings = {
        "dock.crane": "gantry",
        "dock.containers": 1,
        "dock.layout": str(layout),
        "run.until": "job_done",
        "report.reference": "none",
        "rates.servo_frequency_hz": 250,
        "rates.refresh_frequency_hz": 2000,
        "scheduling.alpha_refreshes": 8,
        "scheduling.beta_refreshes": 4,
    }
    report = cmrc.run(dsps=2, duration_s=400, settings=settings).report
    assert report["stop_reason"] == "job_done" and report["simulated_s"] < 400
    assert report["failures"] == []
    delivered = report["cycles"][0]["delivered_s"]
    assert report["makespan_s"] == pytest.approx(delivered - 0.02, abs=1e-9)


def test_a_job_that_is_not_done_has_no_makespan() -> None:
    report = cmrc.run(dsps=2, duration_s=0.1, settings={"run.until": "job_done"}).report
    assert report["stop_reason"] == "completed" and report["makespan_s"] is None


def test_limits_do_not_pass_what_starves_and_report_what_points_cost() -> None:
    found = cmrc.limits(cycles=[1, 10], errors=True, duration_s=0.3, settings={"machine.dsps": 2})
    good, bad = found.report["scans"]["cycles"]["points"]
    assert good["passed"] and good["starved_intervals"] == 0
    assert good["errors"]["f_p_realised_hz"] > bad["errors"]["f_p_realised_hz"]
    assert good["errors"]["load_rms_m"] < bad["errors"]["load_rms_m"]
    assert found.report["scans"]["cycles"]["limit"] == 1


def test_the_command_prints_rates_first(tmp_path: Path) -> None:
    file = tmp_path / "report.json"
    command = [EMULATOR, "--dsps", "1", "--duration", "0.3", "--report", file]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    report = json.loads(file.read_text())
    assert lines[1].split()[:3] == ["against", "nominal", "demanded"]
    assert lines[2].split()[:4] == ["f_p", "1000", "Hz", str(report["rates"]["f_p"]["demanded"])]
    assert lines[4].lstrip().startswith("load error:") and lines[5].lstrip().startswith("lag at the end: crane")
