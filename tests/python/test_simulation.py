"""cmrc.run: a run in Python's hands."""

import threading
import time

import cmrc
import numpy as np
import pytest


@pytest.fixture(scope="module")
def result() -> cmrc.Result:
    return cmrc.run(dsps=2, duration_s=0.1)


def test_tables(result: cmrc.Result) -> None:
    tasks = result.tasks
    assert "pid" in tasks["kind"]
    assert tasks.rows == 13
    outcomes = ("on_time", "late", "unfinished", "never_started", "lost", "dropped")
    assert np.array_equal(tasks["released"], sum(tasks[outcome] for outcome in outcomes))
    assert result.dsps.rows == 2
    causes = [name for name in result.dsps if name.startswith("causes_")]
    assert np.array_equal(result.dsps["cycles"], sum(result.dsps[name] for name in causes))
    assert set(result.buses["bus"]) == {"A", "B"}
    assert "host" in result.buses["master"]
    assert {"t_3_s", "T_g_s", "delivered_s"} <= set(result.cycles)
    assert "2 DSPs" in result.text
    assert "2 DSPs" in repr(result)


def test_signals_are_in_step(result: cmrc.Result) -> None:
    signals = result.signals
    time_s = signals["time_s"]
    assert time_s[-1] == pytest.approx(0.1, abs=0.0101)
    assert np.all(np.diff(time_s) > 0)
    assert all(len(column) == len(time_s) for column in signals.values())
    assert {"psi_rad", "l_m", "sway_alpha_rad", "agv0_x_m"} <= set(signals)
    assert np.all(np.isfinite(signals["psi_rad"]))


def test_pandas(result: cmrc.Result) -> None:
    pytest.importorskip("pandas")
    frame = result.tasks.to_pandas().set_index("kind")
    assert frame.loc["pid", "released"] == result.report["tasks"]["pid"]["released"]


def test_same_settings_same_hash(result: cmrc.Result) -> None:
    assert cmrc.run(settings={"machine.dsps": 2, "run.duration_s": 0.1}).hash == result.hash
    assert cmrc.run(dsps=2, duration_s=0.1, turn_order=9).hash == result.hash


def test_cut_runs_are_the_same_run(result: cmrc.Result) -> None:
    simulation = cmrc.Simulation(dsps=2, duration_s=0.1)
    for milliseconds in (7, 13, 50):
        simulation.run_until(milliseconds * 1e-3)
        assert simulation.time_s == pytest.approx(milliseconds * 1e-3)
        assert not simulation.ended
    assert simulation.run().hash == result.hash
    assert simulation.ended


def test_progress_can_stop_a_run() -> None:
    seen: list[float] = []

    def stop_at_60_ms(simulated_s: float, duration_s: float) -> bool:
        assert duration_s == 10
        seen.append(simulated_s)
        return simulated_s < 0.06

    result = cmrc.run(dsps=1, duration_s=10, on_progress=stop_at_60_ms)
    assert result.stop_reason == "interrupted"
    assert result.report["simulated_s"] == pytest.approx(0.06)
    assert len(seen) == 3


def test_the_gil_is_free_while_a_run_continues() -> None:
    done = threading.Event()
    counted = 0

    def count() -> None:
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    cmrc.Simulation(dsps=1, duration_s=0.3).run_until(0.3)  # one call into C++, without progress
    done.set()
    thread.join()
    assert counted > 5


def test_bad_settings_are_value_errors() -> None:
    with pytest.raises(cmrc.ConfigError, match="dsps"):
        cmrc.run(dsps=0)
    with pytest.raises(cmrc.ConfigError, match="duration_s"):
        cmrc.run(durations=1)
    with pytest.raises(ValueError, match="heavy"):
        cmrc.run(preset="hevy")
    with pytest.raises(cmrc.ConfigError, match="missing.toml"):
        cmrc.run(config="missing.toml")


def test_a_scripted_failure_is_in_the_report() -> None:
    simulation = cmrc.Simulation(dsps=3, duration_s=0.1)
    simulation.at(0.03, "fail", dsp=0)
    result = simulation.run()
    assert result.report["dsps"][0]["causes"]["halted"] > 0.05 * 25e6
    outcomes = ("on_time", "late", "unfinished", "never_started", "lost", "dropped")
    for task in result.report["tasks"].values():
        assert task["released"] == sum(task[outcome] for outcome in outcomes)


def test_each_missed_job_has_its_chain() -> None:
    result = cmrc.run(dsps=1, duration_s=0.03)
    assert len(result.missed) == result.misses > 0
    for miss in result.missed:
        assert sum(miss["parts_ps"].values()) == miss["lateness_ps"]
    assert cmrc.Table.from_rows(result.missed).rows == result.misses
    assert cmrc.run(dsps=1, duration_s=0.03, misses_max=1).report["misses_left_out"] == result.misses - 1


def test_a_dsp_can_be_looked_at_on_the_way() -> None:
    simulation = cmrc.Simulation(dsps=2, slots=3, duration_s=0.1)
    simulation.run_until(0.001)
    loading = simulation.dsp(1)
    assert not loading.booted and loading.pc < 0x1000  # in the boot ROM
    assert 0 < loading.port(3)["received"] < 10_000 and loading.peripherals["LMICR"] == 0x1DEA4000
    simulation.run_until(0.05)
    words = simulation.result().report["boot_words"]
    assert loading.booted and loading.port(3)["read"] == words and loading.port(3)["sent"] == 1
    assert loading.registers["DP"] == 0x2F and 0x300000 <= loading.pc < 0x310000
    assert loading.memory[0x300040] == 1  # dsp_slot
    assert not simulation.dsp(2).plugged
    with pytest.raises(IndexError, match="slots are 0 to 2"):
        simulation.dsp(3)


def test_a_comparison_is_asked_for_its_metrics() -> None:
    found = cmrc.Comparison("", {"duration_s": 1.0, "metrics": {"f_p missed": {"run": 1.0}, "lag": {"run": 2.0}}})
    assert "f_p missed" in found and "load" not in found and 0 not in found
    assert list(found) == ["f_p missed", "lag"] and found["lag"] == {"run": 2.0}
