"""Searches: what is found, what is checked, and that the number of workers changes nothing."""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cmrc.sweeps import GridError, SweepError, grid, sweep
from cmrc.sweeps import search as function
from cmrc.sweeps.metrics import spread
from cmrc.sweeps.search import Trial, asked_of

pytest.importorskip("optuna")
FIXED = {"duration_s": 0.03, "report.reference": "none"}


class Formula:
    """Replaces the runs: a metric computed from the grid point by a formula."""

    def __init__(self, of: Any, tables: dict[str, Any]) -> None:
        self.of, self.grid, self.trials = of, grid.made(tables), []
        self.batches: list[list[dict[str, Any]]] = []

    def values(self, places: Any, seeds: Any) -> list[Trial]:
        self.batches.append([dict(place) for place in places])
        made = []
        for place in places:
            found = [float(self.of(place, seed)) for seed in seeds or [0]]
            worst = max((value for value in found if not math.isnan(value)), default=math.nan)
            made.append(Trial(dict(place), spread(found), worst, len(found)))
        return made

    def try_all(self, places: Any) -> list[Trial]:
        trials = self.values(places, self.grid.seeds)
        self.trials += trials
        return trials


def bisected(of: Any, **table: Any) -> tuple[Any, Formula]:
    trier = Formula(of, {"search": {"bisect": "cycle_time_factor", "from": 1.0, "to": 4.0, "tolerance": 0.01, **table}})
    asked = asked_of(trier.grid)
    found = asked.find(trier)  # type: ignore[arg-type]
    asked.check(found, trier)  # type: ignore[arg-type]
    return found, trier


@pytest.mark.parametrize("limit", [1.004, 1.5, 2.717, 3.999])
@pytest.mark.parametrize("batch", [1, 4, 7])
def test_a_monotone_limit_is_found_within_the_tolerance(limit: float, batch: int) -> None:
    found, trier = bisected(lambda place, _: place["machine.cycle_time_factor"] > limit, batch=batch)
    at = found.best["machine.cycle_time_factor"]
    assert limit - 0.01 <= at <= limit and found.exceptions == []
    assert all(len(places) <= max(batch, 4) for places in trier.batches)
    tried = [trial.place["machine.cycle_time_factor"] for trial in trier.trials]
    assert len(tried) == len(set(tried)) and min(tried) == 1.0 and max(tried) == 4.0  # also near an end


def test_a_search_ends_where_its_interval_is_the_tolerance() -> None:
    _, trier = bisected(lambda place, _: place["machine.cycle_time_factor"] > 2, batch=1, tolerance=0.75, neighbours=0)
    assert [trial.place["machine.cycle_time_factor"] for trial in trier.trials] == [1.0, 4.0, 2.5, 1.75]


def test_the_easy_end_may_be_the_greater_one() -> None:
    found, _ = bisected(lambda place, _: place["machine.dsps"] < 3, bisect="dsps", **{"from": 8, "to": 1}, tolerance=1)
    assert found.best == {"machine.dsps": 3} and isinstance(found.best["machine.dsps"], int)
    assert found.exceptions == []


def test_where_nothing_or_everything_passes() -> None:
    found, _ = bisected(lambda *_: 1)
    assert found.best is None and math.isnan(found.value) and "Nothing was found" in found.text()
    found, trier = bisected(lambda *_: 0)
    assert found.best == {"machine.cycle_time_factor": 4.0} and len(trier.trials) == 2
    assert found.whole_range and "The end of the range passes, too: the last value may lie beyond it" in found.text()
    found, _ = bisected(lambda place, _: place["machine.cycle_time_factor"] > 2)
    assert not found.whole_range and "The end of the range" not in found.text()


def test_neighbours_show_what_is_not_monotone() -> None:
    """Just before the answer lies a gap that misses: scheduling without preemption has such anomalies."""
    found, _ = bisected(
        lambda place, _: (
            2.028 < place["machine.cycle_time_factor"] < 2.042 or place["machine.cycle_time_factor"] > 2.05
        ),
        neighbours=3,
        batch=2,
    )
    assert found.exceptions and "Not monotone" in found.text()


@pytest.mark.parametrize(("begin", "end"), [(1, 16), (16, 1)])
def test_neighbours_lie_on_both_sides_of_the_answer(begin: int, end: int) -> None:
    """8 is the answer from either end; two before it and two behind the next one are tried, too."""
    misses = {7, 9, 10, 12, *range(12, 17)} if begin < end else {9, 7, 6, *range(1, 5)}
    found, trier = bisected(
        lambda place, _: place["machine.dsps"] in misses,
        bisect="dsps",
        **{"from": begin, "to": end},
        batch=1,
        tolerance=1,
    )
    tried = {trial.place["machine.dsps"] for trial in trier.trials}
    assert found.best == {"machine.dsps": 8}
    assert tried >= ({6, 7, 10, 11} if begin < end else {10, 9, 6, 5})
    assert found.exceptions == ([7, 11] if begin < end else [5, 9])


def test_the_answer_is_run_with_seeds_that_the_search_has_not_seen() -> None:
    seen: list[int] = []

    def of(place: dict[str, float], seed: int) -> bool:
        seen.append(seed)
        return place["machine.cycle_time_factor"] > (2.0 if seed <= 3 else 1.5)

    trier = Formula(of, {"repeats": {"seeds": 3, "phases": True}, "search": {
        "bisect": "cycle_time_factor", "from": 1.0, "to": 4.0, "tolerance": 0.01, "check_seeds": 4}})  # fmt: skip
    asked = asked_of(trier.grid)
    found = asked.find(trier)  # type: ignore[arg-type]
    assert set(seen) == {1, 2, 3}
    asked.check(found, trier)  # type: ignore[arg-type]
    assert set(seen) == {1, 2, 3, 4, 5, 6, 7} and found.checked.n == 4
    assert found.check_passed is False and "DOES NOT PASS" in found.text()


def test_an_optimum_is_found_and_two_searches_make_the_same_runs() -> None:
    table = {"search": {"metric": "lag", "trials": 40, "batch": 5, "seed": 3, "space": {
        "cycle_time_factor": {"from": 1.0, "to": 4.0}, "idle_policy": ["spin", "pause"]}}}  # fmt: skip

    def of(place: dict[str, Any], _: int) -> float:
        return (place["machine.cycle_time_factor"] - 2.2) ** 2 + (place["machine.idle_policy"] == "spin")

    tries = []
    for _ in range(2):
        trier = Formula(of, table)
        found = asked_of(trier.grid).find(trier)  # type: ignore[arg-type]
        assert found.best["machine.idle_policy"] == "pause" and abs(found.best["machine.cycle_time_factor"] - 2.2) < 0.3
        assert all(len(batch) <= 5 for batch in trier.batches)
        tries.append(trier.batches)
    assert tries[0] == tries[1]


def test_a_search_in_real_runs(tmp_path: Path) -> None:
    """The fewest DSPs without a miss in the first 30 ms; with identify in the way one DSP is not enough."""
    spec = {
        "fixed": {**FIXED, "phase_jitter": True},
        "search": {"bisect": "dsps", "from": 3, "to": 1, "check_seeds": 1},
    }
    found = function(spec, tmp_path / "s", workers=1)
    assert found.best == {"machine.dsps": 2} and found.value == 0 and found.check_passed is True
    assert found.sweep is not None and len(found.sweep) == len(found.trials) + 1
    again = function(spec, tmp_path / "s", address="tcp://127.0.0.1:9")  # nothing is due: no cluster is asked for
    assert again.text() == found.text()


def test_what_was_refused_or_failed_has_not_passed() -> None:
    whole = Trial({}, spread([0.0, 0.0]), 0.0, seeds=2)
    assert whole.passes(0) and whole.counts
    for other in (
        Trial({}, spread([0.0]), 0.0, seeds=2, failed=1),
        Trial({}, spread([0.0]), 0.0, seeds=2, refused=1),
        Trial({}, spread([math.nan, 0.0]), 0.0, seeds=2),
        Trial({}, spread([]), math.nan, seeds=2, refused=2),
    ):
        assert not other.passes(0) and not other.counts


def optimised(of: Any, **table: Any) -> tuple[Any, Formula]:
    space = {"cycle_time_factor": [1.0, 2.0, 3.0]}
    trier = Formula(of, {"repeats": {"seeds": 5}, "search": {"trials": 6, "space": space, **table}})
    asked = asked_of(trier.grid)
    found = asked.find(trier)  # type: ignore[arg-type]
    asked.check(found, trier)  # type: ignore[arg-type]
    return found, trier


def test_a_setting_that_few_seeds_have_measured_is_not_the_best() -> None:
    """Its mean would be that of the easy seeds."""
    found, _ = optimised(lambda place, seed: (
        place["machine.cycle_time_factor"] if place["machine.cycle_time_factor"] > 1.5 or seed == 1 else math.nan
    ))  # fmt: skip
    assert found.best == {"machine.cycle_time_factor": 2.0} and found.value == 2.0
    assert "machine.cycle_time_factor = 1: misses 1 (n = 1), 4 not measured\n" in found.text()
    assert "With seeds that the search has not used: 2 (n = 5).\n" in found.text()


@pytest.mark.parametrize(
    ("measured", "says"), [(0, "– (n = 0); not measured in 3 of 3"), (2, "0 (n = 2); not measured in 1 of 3")]
)
def test_a_check_that_has_not_measured_everything_says_so(measured: int, says: str) -> None:
    def of(_: dict[str, Any], seed: int) -> float:
        return 0.0 if seed <= 5 + measured else math.nan

    best, _ = optimised(of, check_seeds=3)
    assert best.text().endswith(f"With seeds that the search has not used: {says}.\n")
    trier = Formula(of, {"repeats": {"seeds": 5}, "search": {
        "bisect": "cycle_time_factor", "from": 1.0, "to": 4.0, "check_seeds": 3}})  # fmt: skip
    asked = asked_of(trier.grid)
    last = asked.find(trier)  # type: ignore[arg-type]
    asked.check(last, trier)  # type: ignore[arg-type]
    assert last.check_passed is False and last.text().endswith(f"not used: {says}. IT DOES NOT PASS.\n")


def test_a_setting_is_written_with_the_digits_that_give_it_back() -> None:
    """Rounded to six digits, the last value that passes does not pass."""
    limit = 9.93549997919
    found, _ = bisected(
        lambda place, _: place["machine.cycle_time_factor"] > limit, **{"from": 9.9, "to": 10.0}, tolerance=1e-9
    )
    written = re.findall(r"machine\.cycle_time_factor = ([^:,]+)", found.text())
    tried = [trial.place["machine.cycle_time_factor"] for trial in found.trials]
    assert [float(text) for text in written] == [*tried, found.best["machine.cycle_time_factor"]]
    assert written[0] == "9.9" and written[1] == "10" and float(written[-1]) <= limit


def test_a_search_continues_in_the_folder_of_a_sweep(tmp_path: Path) -> None:
    sweep({"fixed": {**FIXED, "servo_frequency_hz": 1000.0}, "axes": {"dsps": [1, 2]}}, tmp_path / "s", workers=1)
    spec = {"fixed": FIXED, "repeats": {"seeds": 1}, "search": {"bisect": "dsps", "from": 3, "to": 1, "check_seeds": 1}}
    found = function(spec, tmp_path / "s", workers=1)
    assert found.best == {"machine.dsps": 2} and found.sweep is not None
    assert {run["seed"] for run in found.sweep.runs} == {1, 2}


@pytest.mark.parametrize(("tables", "says"), [
    ({"fixed": {}}, "there is no table [search]"),
    ({"axes": {"dsps": [1]}, "search": {"bisect": "dsps", "from": 1, "to": 2}}, "not with axes"),
    ({"search": {"bisect": "dspss", "from": 1, "to": 2}}, 'search.bisect: dspss: no such key; did you mean "machine.dsps"?'),
    ({"fixed": {"dsps": 1}, "search": {"bisect": "dsps", "from": 1, "to": 2}}, "machine.dsps is fixed, too"),
    ({"search": {"bisect": "dsps", "from": 1}}, "search.to: a number is expected"),
    ({"search": {"bisect": "dsps", "from": 1, "to": 1}}, "search.to: 1 is where it begins"),
    ({"search": {"bisect": "dsps", "from": 1, "to": 4, "tolerance": 0.1}}, "search.tolerance"),
    ({"search": {"bisect": "dsps", "from": 1, "to": 4, "trials": 3}}, "search.trials: unknown"),
    ({"search": {"metric": "misess", "space": {"dsps": [1]}}}, 'search.metric: misess: the report has no such place; did you mean "misses"?'),
    ({"search": {"trials": 3}}, "search.space: the settings that may vary"),
    ({"search": {"goal": "fast", "space": {"dsps": [1]}}}, "search.goal"),
    ({"search": {"batch": 0, "space": {"dsps": [1]}}}, "search.batch"),
    ({"search": {"space": {"dsps": {"from": 4, "to": 1}}}}, "search.space.dsps"),
    ({"search": {"space": {"dsps": {"from": 1.5, "to": 6}}}}, "search.space.dsps.from: 1.5 cannot be used; machine.dsps is a whole"),
    ({"search": {"bisect": "dsps", "from": 8.5, "to": 1}}, "search.from: 8.5 cannot be used; machine.dsps is a whole"),
    ({"search": {"space": {"dsps": 3}}}, "search.space.dsps: a list of values"),
    ({"search": {"space": {"cycle_time_factor": {"from": 1, "to": math.nan}}}}, "search.space.cycle_time_factor.to: nan is not a"),
    ({"search": {"space": {"cycle_time_factor": {"from": 1, "to": math.inf}}}}, "search.space.cycle_time_factor.to: inf is not a"),
    ({"search": {"space": {"cycle_time_factor": {"from": 1, "to": 10**400}}}}, "cycle_time_factor.to: 1000"),
    ({"search": {"space": {"dsps": {"from": 1, "to": 10**400}}}}, "search.space.dsps.to: 1000"),
    ({"search": {"bisect": "cycle_time_factor", "from": 1, "to": 10**400}}, "search.to: 1000"),
    ({"search": {"bisect": "cycle_time_factor", "from": 1, "to": 2, "at_most": math.inf}}, "search.at_most: inf is not a number"),
    ({"search": {"bisect": "cycle_time_factor", "from": 1, "to": 2, "batch": 10**400}}, "search.batch: a whole number from 1 to 10000000"),
    *(({"search": {"space": {"cycle_time_factor": {"from": 1, "to": 2, "scale": scale}}}},
       'search.space.cycle_time_factor.scale: "linear" or "log" is expected')
      for scale in ("lin", "logarithmic", 3, None)),
    *(({"search": {"space": {name: {"from": 1, "to": 2, "step": step}}}},
       f"search.space.{name}.step: {step}; a step above 0 is")
      for name in ("dsps", "cycle_time_factor") for step in (0, -1)),
    *(({**seeded, "search": {"bisect": "dsps", "from": 4, "to": 1, **check}},
       f"search.check_seeds: the last of the {n} seeds")
      for seeded, check, n in (({"repeats": {"seeds": [2**63 - 1]}}, {}, 5),
                               ({"repeats": {"seeds": [2**63 - 5]}}, {}, 5),
                               ({"fixed": {"seed": 2**63 - 1}}, {"check_seeds": 1}, 1))),
])  # fmt: skip
def test_a_bad_search_says_where(tables: dict[str, Any], says: str, tmp_path: Path) -> None:
    with pytest.raises((GridError, SweepError)) as error:
        function(tables, tmp_path / "s")
    assert says in str(error.value) and not (tmp_path / "s").exists()


def test_ends_the_wrong_way_round_are_named() -> None:
    found, _ = bisected(lambda place, _: place["machine.dsps"] < 3, bisect="dsps", **{"from": 1, "to": 6}, tolerance=1)
    assert found.best is None and found.exceptions == [6.0] and not found.whole_range
    assert found.text().endswith(
        "Nothing was found.\n6 passes, and the easy end does not: are from and to the wrong way round?\n"
    )
    nowhere, _ = bisected(lambda place, _: 1)
    assert nowhere.exceptions == [] and nowhere.text().endswith("Nothing was found.\n")


def test_the_ends_may_be_of_numpy() -> None:
    ends = {"from": np.int64(8), "to": np.float64(1)}
    found, _ = bisected(lambda place, _: place["machine.dsps"] < 3, bisect="dsps", **ends, tolerance=np.int32(1))
    assert found.best == {"machine.dsps": 3} and type(found.best["machine.dsps"]) is int


@pytest.mark.parametrize("tables", [
    {"repeats": {"seeds": [2**63 - 6]}},
    {"repeats": {"seeds": [2**63 - 1]}, "check_seeds": 0},
    {"fixed": {"seed": 2**63 - 1}},
    {"fixed": {"seed": "x"}, "check_seeds": 1},
])  # fmt: skip
def test_seeds_that_fit_are_taken(tables: dict[str, Any]) -> None:
    check = {"check_seeds": tables["check_seeds"]} if "check_seeds" in tables else {}
    given = {name: table for name, table in tables.items() if name != "check_seeds"}
    asked_of(grid.made({**given, "search": {"bisect": "dsps", "from": 4, "to": 1, **check}}))


def test_a_choice_that_is_given_twice_is_refused() -> None:
    with pytest.raises(GridError, match="1.0 is given twice"):
        asked_of(grid.made({"search": {"space": {"dsps": [1, 1.0, 2]}}}))
