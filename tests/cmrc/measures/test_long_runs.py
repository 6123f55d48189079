"""A long run's memory is bounded: what is kept coarser is what docs/report.md, Long runs, says, and nothing else
changes."""

import re
import subprocess

import cmrc
import numpy as np
import pytest
from locations import BUILD
from low_rates import AT_ONCE_AND_LOW

SHORT = {"duration_s": 4.0, "machine.dsps": 1, "machine.cycle_time_factor": 9.0}


def test_a_run_with_bounds_that_are_reached_says_the_same() -> None:
    whole = cmrc.run(settings=SHORT | {"report.signal_decimation": 8})
    bounded = cmrc.run(
        settings=SHORT
        | {
            "report.signal_decimation": 8,
            "report.signal_rows_max": 1000,
            "report.error_rows_max": 5000,
            "report.samples_max": 100,
        }
    )
    assert bounded.hash == whole.hash
    a, b = whole.report["tasks"]["pid"]["response_ps"], bounded.report["tasks"]["pid"]["response_ps"]
    assert (a.pop("percentiles"), b.pop("percentiles")) == ("exact", "within 0.1 %")
    percentiles = {"p50", "p99", "p99_9"}
    assert {k: v for k, v in a.items() if k not in percentiles} == {k: v for k, v in b.items() if k not in percentiles}
    assert [b[k] for k in sorted(percentiles)] == pytest.approx([a[k] for k in sorted(percentiles)], rel=1e-3)
    # 4000 rows of 1 ms: each second one goes at 1000, 2000 and 4000 ms.
    rows = np.asarray(bounded.signals["time_s"])
    assert len(rows) <= 1000
    assert np.allclose(np.diff(rows), 0.008 if len(rows) <= 500 else 0.004)
    kept = np.isin(np.asarray(whole.signals["time_s"]), rows)
    assert kept.sum() == len(rows)
    for name in ("payload_x_m", "phi_rad", "sway_alpha_rad", "agv0_x_m"):
        assert np.array_equal(np.asarray(whole.signals[name])[kept], np.asarray(bounded.signals[name]))
    # 32,000 latches: each eighth has a row.
    for row in ("rms", "peak", "end"):
        exact, coarse = whole.errors["load_m"][row], bounded.errors["load_m"][row]
        assert coarse == pytest.approx(exact, rel=0.01)
    assert bounded.rates == whole.rates
    assert bounded.errors["lag"] == whole.errors["lag"]


def test_sway_and_distances_from_lanes_do_not_depend_on_how_often_signals_are_recorded() -> None:
    """They are taken each 10 ms (docs/report.md), which is a row of the default signals."""

    def recorded(**settings: int) -> cmrc.Result:
        of_report = {f"report.{key}": value for key, value in settings.items()}
        driving = {**AT_ONCE_AND_LOW, "dock.agvs": 1, "load.driving": True, "duration_s": 12.0}
        return cmrc.run(settings={**driving, **of_report})

    each_10_ms = recorded(signal_decimation=80)
    for other in (recorded(signal_decimation=7), recorded(signal_decimation=80000), recorded(signal_rows_max=16)):
        assert other.hash == each_10_ms.hash
        for key in ("sway", "agvs"):
            assert other.report[key] == each_10_ms.report[key]
    signals = each_10_ms.signals
    for angle in ("alpha", "beta"):
        sway, said = signals[f"sway_{angle}_rad"], each_10_ms.report["sway"][angle]
        assert said["rms"] == pytest.approx(np.sqrt(np.mean(sway**2)), rel=1e-9)
        assert said["peak"] == np.abs(sway).max() > 0
    assert each_10_ms.report["agvs"]["agv 0 lateral"]["peak"] > 0


def peak_kib(*arguments: str) -> int:
    """The most memory that a run of the command line has had, of all its processes the largest."""
    done = subprocess.run(
        ["/usr/bin/env", "python3", "-c", PEAK, str(BUILD / "bin" / "emulator"), *arguments],
        capture_output=True,
        text=True,
        check=True,
    )
    return int(re.findall(r"\d+", done.stdout)[-1])


PEAK = """
import resource, subprocess, sys
subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL, check=True)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
"""


@pytest.mark.campaign
def test_an_hour_needs_no_more_than_twice_the_memory_of_a_minute() -> None:
    minute, hour = (peak_kib("--dsps", "4", "--duration", str(s)) for s in (60, 3600))
    assert hour <= 2 * minute, (minute, hour)
