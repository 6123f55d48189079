"""Metrics by name, and what repeats say of them."""

import math
import re
from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction
from functools import partial
from typing import Any

import cmrc
import numpy as np
import pytest
from cmrc.sweeps import metrics

REPORT: dict[str, Any] = {
    "tasks": {"pid": {"misses": 3, "on_time": 9, "response_ps": {"p99": 5, "count": 2, "worst": 7_000_000}},
              "home.crane": {"misses": 0, "on_time": 0, "response_ps": {"p99": None, "count": 0, "worst": None}}},
    "rates": None, "errors": {"load_m": {"rms": 0.5}}, "dsps": [{"cycles": 10}, {"cycles": 20}],
}  # fmt: skip


def test_places_and_short_names() -> None:
    assert metrics.value(REPORT, "tasks.pid.response_ps.p99") == 5
    assert metrics.value(REPORT, "dsps[1].cycles") == 20
    assert metrics.value(REPORT, "misses") == 3 and metrics.value(REPORT, "any_miss") is True
    assert metrics.value(REPORT, "load_rms") == 0.5 and metrics.value(REPORT, "worst_response_us") == 7.0
    assert math.isnan(metrics.value(REPORT, "tasks.home.crane.response_ps.p99"))
    assert math.isnan(metrics.value(REPORT, "rates.f_p.missed_share"))
    assert metrics.value(REPORT, lambda report: len(report["dsps"])) == 2
    for bad in ("tasks.pidd.misses", "dsps[2].cycles", "dsps.cycles", "tasks", ""):
        with pytest.raises(KeyError):
            metrics.value(REPORT, bad)


def test_of_two_kinds_whose_names_begin_alike_a_place_means_the_longer_one_that_fits() -> None:
    """A task of the user may be named like the first part of another kind."""
    report = {"tasks": {"home": {"misses": 1}, "home.crane": {"misses": 2}, "home.crane.late": {"misses": 3}}}
    for name, misses in (("home", 1), ("home.crane", 2), ("home.crane.late", 3)):
        assert metrics.value(report, f"tasks.{name}.misses") == misses


def test_a_controller_that_has_done_nothing_yet_has_no_number_of_misses() -> None:
    for on_time, misses in ((0, math.nan), (1, 0)):
        booting = {"tasks": {"pid": {"misses": 0, "on_time": on_time}}}
        assert metrics.value(booting, "misses") == pytest.approx(misses, nan_ok=True)
        assert metrics.value(booting, "any_miss") == pytest.approx(misses, nan_ok=True)


def test_nothing_random_has_no_interval() -> None:
    found = metrics.spread([2.0, 2.0, 2.0])
    assert (found.n, found.mean, found.varies) == (3, 2.0, False) and math.isnan(found.low)
    assert str(found) == "2"
    assert metrics.spread([math.nan]).n == 0 and str(metrics.spread([])) == "–"


def test_shares_have_wilsons_interval() -> None:
    # Wilson 1927 of 1 in 10 at 95 %: 0.0179 to 0.4042 (Newcombe 1998, table I gives these for r = 1, n = 10).
    found = metrics.spread([True] + [False] * 9)
    assert (
        found.mean == 0.1
        and found.low == pytest.approx(0.0179, abs=2e-4)
        and found.high == pytest.approx(0.4042, abs=2e-4)
    )


def test_the_bootstrap_is_seeded_and_holds_the_mean() -> None:
    values = [1.0, 2.0, 3.0, 10.0]
    found = metrics.spread(values)
    assert found == metrics.spread(values) and found.low < found.mean == 4.0 < found.high
    assert found.n == 4 and found.varies
    assert metrics.spread([*values, math.nan]) == found


@pytest.mark.parametrize(("metric", "unit"), [
    ("misses", "jobs"),
    ("wind.limit_m_s", "m/s"),
    ("tasks.pid.response_ps.p99", "ps"),
    ("tasks.pid.response_ps.count", "jobs"),
    ("tasks.pid.response_ps.log2_histogram[3]", "jobs"),
    ("host.semaphore_hold_ps.count", ""),
    ("dsps[0].clock_hz", "Hz"),
    ("dsps[0].clock_ppm", "ppm"),
    ("dsps[0].tasks_ps.trajectory_planning.crane", "ps"),
    ("errors.load_m.rms", "m"),
    ("errors.window_s[0]", "s"),
    ("wind.above_share", "share"),
    ("control_cost.cost_m2s", "m2 s"),
    ("configuration.control.slew_bandwidth_rad_s", "rad/s"),
    ("configuration.agv.drag_n_s2_m2", ""),
    ("pid_error.s.rms", ""),
    ("tasks.user.zeta_s.released", ""),
    ("tasks.user.count.released", ""),
    ("tasks.user.zeta_s.response_ps.p99", "ps"),
    ("dsps[0].tasks_ps.user.zeta_s", "ps"),
    ("dsps[0].causes.zeta_s", ""),
])  # fmt: skip
def test_a_unit_is_that_of_the_whole_ending(metric: str, unit: str) -> None:
    assert metrics.unit_of(metric) == unit


def test_numbers_of_numpy_are_numbers() -> None:
    for given, found in ((np.int64(3), 3), (np.float32(0.5), 0.5), (np.bool_(True), True), (Fraction(1, 4), 0.25)):
        measured = metrics.value(REPORT, lambda report, given=given: given)
        assert measured == found and type(measured) is type(found)
    for no in ("3", [3], np.array([1, 2]), 1j, Decimal(1)):
        with pytest.raises(TypeError, match="is no number"):
            metrics.value(REPORT, lambda report, no=no: no)


def test_names_of_columns_are_different() -> None:
    def seed(report: Any) -> int:
        return 5

    of = [lambda report: 1, "misses", lambda report: 2, seed, partial(seed), partial(seed), "misses", seed]
    assert metrics.names_of(of, {"seed", "status"}) == [
        "<lambda>", "misses", "<lambda> 2", "seed 2", "metric", "metric 2", "misses", "seed 3",
    ]  # fmt: skip
    assert metrics.names_of(["misses", "seed", "misses", "seed"], {"seed"}) == ["misses", "seed 2", "misses", "seed 2"]


def test_a_function_changes_nothing_that_others_measure() -> None:
    def changing(report: Any) -> int:
        report["tasks"].clear()
        report["dsps"][0]["cycles"] = 99
        return 1

    assert metrics.values(REPORT, [changing, "misses", lambda report: report["dsps"][0]["cycles"]]) == [1, 3, 10]
    assert REPORT["dsps"][0]["cycles"] == 10


def test_a_place_that_only_some_reports_have_is_nan_in_the_others() -> None:
    reports = [(str(n), {"dsps": [{"claims": 10 * n + slot} for slot in range(n)]}) for n in (2, 4)]
    found = metrics.of_reports(reports, ["dsps[3].claims", "dsps[0].claims"])
    assert np.isnan(found["2"][0]) and [*found["2"][1:], *found["4"]] == [20, 43, 40]
    with pytest.raises(KeyError, match=r"dsps\[4\].claims: there is no \[4\].claims"):
        metrics.of_reports(reports, ["dsps[0].claims", "dsps[4].claims"])


def test_a_bin_that_a_histogram_leaves_out_is_0_up_to_the_last_one() -> None:
    place = "tasks.home.crane.waiting_ps.log2_histogram[{}]".format
    with_bins = [("a", [0, 3]), ("b", [0, 0, 0, 1]), ("c", [])]
    reports = [(key, {"tasks": {"home.crane": {"waiting_ps": {"log2_histogram": bins}}}}) for key, bins in with_bins]
    reports.append(("none", {"tasks": {"pid": {}}}))
    found = metrics.of_reports(reports, [place(1), place(3), place(63)])
    assert [found[key] for key in "abc"] == [[3, 0, 0], [0, 1, 0], [0, 0, 0]]
    assert all(np.isnan(value) for value in found["none"])
    third = metrics.spread([found[key][1] for key in found])
    assert (third.n, third.mean) == (3, pytest.approx(1 / 3))
    metrics.check_place(place(63))
    with pytest.raises(KeyError, match=r"\[64\]: a histogram has no such bin; 0 to 63 is expected"):
        metrics.of_reports(reports, [place(64)])
    with pytest.raises(ValueError, match="a histogram has no such bin"):
        metrics.check_place(place(64))
    masters = [{"wait_clocks": {"log2_histogram": [1]}}]
    with pytest.raises(KeyError, match=r"there is no \[1\]"):
        metrics.value({"buses": {"A": {"masters": masters}}}, "buses.A.masters[1].wait_clocks.log2_histogram[0]")


def places(node: Any, place: str = "") -> Iterator[str]:
    """The places of all numbers in a report."""
    if isinstance(node, dict):
        for name, value in node.items():
            yield from places(value, f"{place}.{name}" if place else name)
    elif isinstance(node, list):
        for n, value in enumerate(node):
            yield from places(value, f"{place}[{n}]")
    elif isinstance(node, (int, float)):
        yield place


def test_before_a_run_its_places_are_known_and_others_are_refused() -> None:
    report = cmrc.run(preset="heavy", dsps=3, duration_s=0.03).report
    known = list(places(report))
    assert len(known) > 1000
    for place in [*known, *metrics.NAMED, "makespan_s", "tasks.home.crane.misses", "dsps[15].cycles", "after_stop.any"]:
        metrics.check_place(place)
    for place, says in (
        ("misess", 'misess: the report has no such place; did you mean "misses"?'),
        ("makespan", 'did you mean "makespan_s"?'),
        ("tasks.pid.missses", 'tasks.pid.missses: the report has no such place; did you mean "misses"?'),
        ("dsps.cycles", "the report has no such place"),
        ("dsps[0]", "is no number"),
        ("hash", "hash: is no number"),
        ("", "an empty name"),
    ):
        with pytest.raises(ValueError, match=re.escape(says)):
            metrics.check_place(place)
        if place:
            with pytest.raises(KeyError):
                metrics.value({**report, "makespan_s": None}, place)


def test_a_wrong_name_in_a_report_gets_a_suggestion() -> None:
    for place, near in (("misess", "misses"), ("tasks.pidd.misses", "pid"), ("dsps[0].cycels", "cycles")):
        with pytest.raises(KeyError, match=f'no such place; did you mean "{near}"\\?'):
            metrics.value(REPORT, place)
