"""Exact percentiles, and the identities of the account of jobs (ruling 16)."""

import json
import random
from fractions import Fraction

import pytest
from cmrc_test import report
from hypothesis import given
from hypothesis import strategies as st

KINDS = ["pid", "identify"]
CAUSES = ["execute", "bus_arbitration"]
OUTCOMES = ["on_time", "late", "unfinished", "never_started", "lost", "dropped"]
PERIOD = 1_000_000


def account() -> report.TaskAccount:
    return report.TaskAccount(KINDS, CAUSES, [PERIOD, 0])


def tasks(of: report.TaskAccount) -> dict[str, dict]:
    run = report.RunReport()
    run.set_tasks(of)
    return json.loads(run.to_json())["tasks"]


@given(st.lists(st.integers(-10, 10**12), min_size=1, max_size=400))
def test_summary_is_exact(samples: list[int]) -> None:
    summary = report.summary(samples)
    assert (summary.count, summary.best, summary.worst) == (len(samples), min(samples), max(samples))
    assert summary.mean == pytest.approx(float(Fraction(sum(samples), len(samples))), rel=1e-15)
    for value, share in (
        (summary.p50, Fraction(1, 2)),
        (summary.p99, Fraction(99, 100)),
        (summary.p99_9, Fraction(999, 1000)),
    ):
        # Nearest rank, by its definition: enough samples at or below it, and not enough below it.
        assert value in samples
        assert sum(sample <= value for sample in samples) >= share * len(samples)
        assert sum(sample < value for sample in samples) < share * len(samples)


@pytest.mark.parametrize("samples_max", [10_000, 50])
@pytest.mark.parametrize(("count", "p50", "p99", "p99_9"), [
    (50, 25, 50, 50), (51, 26, 51, 51), (100, 50, 99, 100), (101, 51, 100, 101), (999, 500, 990, 999),
    (1000, 500, 990, 999), (1001, 501, 991, 1000), (2000, 1000, 1980, 1998), (2001, 1001, 1981, 1999),
])  # fmt: skip
def test_nearest_ranks_of_long_rows(samples_max: int, count: int, p50: int, p99: int, p99_9: int) -> None:
    """The numbers 1 to n: a value is its own rank, P % of n, rounded up. Bins of 1/1024 hold one number each here."""
    samples = list(range(1, count + 1))
    random.Random(count).shuffle(samples)
    summary = report.summary(samples, samples_max)
    assert (summary.p50, summary.p99, summary.p99_9) == (p50, p99, p99_9)
    assert summary.exact_percentiles == (count <= samples_max)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_percentile_from_bins_is_the_middle_of_its_bin_on_either_side_of_zero(sign: int) -> None:
    """2^20 + 1000 shares its bin with 2^20 to 2^20 + 1023."""
    summary = report.summary([sign * 2_000_000, 0] + [sign * (2**20 + 1000)] * 58, 50)
    assert summary.p50 == sign * (2**20 + 512) and not summary.exact_percentiles


def test_histogram_bins_are_powers_of_two() -> None:
    histogram = report.summary([0, 1, 2, 3, 4, 7, 8, 1023, 1024]).log2_histogram
    assert histogram[:5] == [1, 1, 2, 2, 1]
    assert (histogram[10], histogram[11]) == (1, 1)
    assert sum(histogram) == 9


def test_each_outcome_is_what_ruling_16_says() -> None:
    book = account()
    assert book.add(0, "finished", released=0, deadline=100, claimed=10, finished=100, now=100) == "on_time"
    assert book.add(0, "finished", released=0, deadline=100, claimed=10, finished=101, now=101) == "late"
    assert book.add(0, "running", released=0, deadline=100, claimed=10, now=90) == "unfinished"
    assert book.add(0, "running", released=0, deadline=100, claimed=10, now=110) == "unfinished"
    assert book.add(0, "waiting", released=0, deadline=100, now=110) == "never_started"
    assert book.add(0, "lost", released=0, deadline=100, claimed=10, now=110) == "lost"
    assert book.add(0, "dropped", released=0, now=0) == "dropped"
    assert book.add(1, "finished", released=0, claimed=10, finished=10**15, now=10**15) == "on_time"
    pid = tasks(book)["pid"]
    assert [pid[outcome] for outcome in OUTCOMES] == [1, 1, 2, 1, 1, 1]
    assert pid["misses"] == 5  # all but the one on time and the one still running before its deadline
    assert pid["longest_miss_streak"] == 4
    assert pid["lateness_ps"]["worst"] == 1


@pytest.mark.parametrize("progress", ["running", "waiting"])
def test_what_is_not_done_by_the_end_is_a_miss_when_its_deadline_has_passed(progress: str) -> None:
    misses = []
    for now in (100, 101):
        book = account()
        book.add(0, progress, released=0, deadline=100, claimed=10, now=now)
        misses.append(tasks(book)["pid"]["misses"])
    assert misses == [0, 1]


def test_outcomes_always_sum_to_released() -> None:
    rng = random.Random(7)
    book = account()
    for _ in range(2_000):
        progress = rng.choice(["finished", "running", "waiting", "lost", "dropped"])
        released = rng.randrange(1000)
        claimed = released + rng.randrange(1000)
        deadline = rng.choice([None, released + rng.randrange(2000)])
        finished = claimed + rng.randrange(1000)
        book.add(
            rng.randrange(2),
            progress,
            released=released,
            deadline=deadline,
            claimed=claimed,
            finished=finished,
            now=3000,
        )
    for task in tasks(book).values():
        assert task["released"] == sum(task[outcome] for outcome in OUTCOMES) > 500


def test_jitter_is_taken_between_neighbouring_ticks_only() -> None:
    book = account()
    starts = {0: 0, 1: PERIOD + 30, 2: 2 * PERIOD - 10, 5: 5 * PERIOD + 70, 6: 6 * PERIOD + 70}
    for tick, start in starts.items():
        book.add(0, "finished", released=tick * PERIOD, claimed=start, finished=start + 5, now=start + 5, tick=tick)
    jitter = tasks(book)["pid"]["start_jitter_ps"]
    # Deviations: +30, -40, (2 to 5 is no neighbour), 0.
    assert (jitter["count"], jitter["peak_to_peak"], jitter["worst"]) == (3, 70, 40)
    assert jitter["rms"] == pytest.approx((2500 / 3) ** 0.5)


def test_a_tick_that_comes_63_later_still_has_both_its_neighbours() -> None:
    book = account()
    for tick in (0, *range(2, 65), 1):
        book.add(
            0,
            "finished",
            released=tick * PERIOD,
            claimed=tick * PERIOD,
            finished=tick * PERIOD + 5,
            now=65 * PERIOD,
            tick=tick,
        )
    assert tasks(book)["pid"]["start_jitter_ps"]["count"] == 64


def test_causes_of_another_length_are_refused() -> None:
    with pytest.raises(ValueError, match="causes"):
        account().add(0, "finished", released=0, claimed=0, finished=1, now=1, causes=[1])


def test_text_counts_the_misses_and_fits_100_columns() -> None:
    book = account()
    for tick in range(3):
        released = tick * PERIOD
        book.add(
            0,
            "finished",
            released=released,
            deadline=released + PERIOD,
            claimed=10**9,
            finished=10**9 + 10,
            now=10**9,
            tick=tick,
        )
    run = report.RunReport()
    run.set_tasks(book)
    text = run.to_text()
    assert "pid: 3 of 3 missed (100.0 %), at most 3 in a row" in text
    assert max(map(len, text.splitlines())) <= 100


@given(st.lists(st.integers(-(10**9), 10**13), min_size=2, max_size=400), st.integers(0, 50))
def test_percentiles_of_many_samples_are_within_a_thousandth(samples: list[int], samples_max: int) -> None:
    summary, exact = report.summary(samples, samples_max), report.summary(samples)
    assert exact.exact_percentiles
    assert summary.exact_percentiles == (len(samples) <= samples_max)
    for name in ("count", "best", "worst", "mean", "log2_histogram"):
        assert getattr(summary, name) == getattr(exact, name)
    for name in ("p50", "p99", "p99_9"):
        assert abs(getattr(summary, name) - getattr(exact, name)) <= 1e-3 * abs(getattr(exact, name))
    assert summary.best <= summary.p50 <= summary.p99 <= summary.p99_9 <= summary.worst


def test_the_sample_after_the_last_exact_one() -> None:
    samples = [10**9 + 10**6 * i for i in range(100)]
    assert report.summary(samples, 100).exact_percentiles
    assert not report.summary(samples, 99).exact_percentiles


def test_jitter_of_a_long_row_with_late_bookings() -> None:
    """The same as from all starts sorted, where none is booked more than a few ticks late."""
    rng = random.Random(3)
    starts = {tick: tick * PERIOD + rng.randrange(-500, 500) for tick in range(5000) if rng.random() > 0.1}
    order = sorted(starts, key=lambda tick: tick + rng.uniform(0, 20))
    book = account()
    for tick in order:
        book.add(0, "finished", released=0, claimed=starts[tick], finished=starts[tick], now=10**13, tick=tick)
    deviations = [starts[tick + 1] - starts[tick] - PERIOD for tick in starts if tick + 1 in starts]
    jitter = tasks(book)["pid"]["start_jitter_ps"]
    assert jitter["count"] == len(deviations)
    assert jitter["peak_to_peak"] == max(deviations) - min(deviations)
    assert jitter["rms"] == pytest.approx((sum(d * d for d in deviations) / len(deviations)) ** 0.5, rel=1e-12)
