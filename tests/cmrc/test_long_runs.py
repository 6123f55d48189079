"""A long run's memory is bounded: what is kept coarser is what docs/report.md, Long runs, says, and nothing else changes."""

import random
import re
import subprocess

import cmrc
import numpy as np
import pytest
from cmrc._core import cmrc as core
from locations import BUILD

MS = 10**9  # ps


def test_instants_are_kept_as_they_are_while_there_are_few() -> None:
    instants = core.Instants(kept_max=4, bins_max=100)
    for ms in (7, 3, 5, 9):
        instants.add(ms * MS + 1)
    assert instants.bin_ps == 0
    assert instants.in_order() == [(ms * MS + 1, 1) for ms in (3, 5, 7, 9)]
    assert [instants.until(t) for t in (3 * MS, 3 * MS + 1, 8 * MS, 10 * MS)] == [0, 1, 3, 4]


def test_many_instants_are_counted_in_bins_that_double() -> None:
    rng = random.Random(1)
    instants = core.Instants(kept_max=100, bins_max=64)
    times = [i * MS // 3 + rng.randrange(MS // 3) for i in range(3 * 1000)]
    for n, time in enumerate(times, 1):
        instants.add(time)
        assert instants.count == n
    bin_ps = instants.bin_ps
    assert bin_ps == 16 * MS  # 64 bins of 16 ms hold 1000 ms, 64 of 8 ms do not
    counts = dict(instants.in_order())
    assert len(counts) <= 64
    assert counts == {b * bin_ps: sum(t // bin_ps == b for t in times) for b in range(63)}
    for edge in range(0, 1000 * MS, bin_ps):
        assert instants.until(edge) == sum(t < edge for t in times)
    assert instants.until(max(times)) == len(times)


SHORT = {"duration_s": 4.0, "machine.dsps": 1, "machine.cycle_time_factor": 9.0}


def test_a_run_with_bounds_that_are_reached_says_the_same() -> None:
    whole = cmrc.run(settings=SHORT | {"report.signal_decimation": 8})
    bounded = cmrc.run(settings=SHORT | {"report.signal_decimation": 8, "report.signal_rows_max": 1000, "report.error_rows_max": 5000, "report.samples_max": 100})
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


def peak_kib(*arguments: str) -> int:
    """The most memory that a run of the command line has had, of all its processes the largest."""
    done = subprocess.run(["/usr/bin/env", "python3", "-c", PEAK, str(BUILD / "bin" / "emulator"), *arguments], capture_output=True, text=True, check=True)
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
