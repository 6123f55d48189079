"""The claims: every experiment at a small size, and every verdict both ways from invented numbers. A campaign compares
the page with its commands."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from cmrc.results import __main__ as command
from cmrc.results import cost, ends, judgement, page
from cmrc.results.claim import Claim
from cmrc.results.cost import Cost
from cmrc.results.dsps import Dsps
from cmrc.results.failures import Failures
from cmrc.results.fleet import Fleet
from cmrc.results.hotplug import Hotplug
from cmrc.results.importance import Importance
from cmrc.results.learning import Learning
from cmrc.results.runs import Laboratory, Run
from drawn import described
from locations import ROOT
from matplotlib.figure import Figure

Rows = list[dict[str, Any]]


@pytest.mark.golden
@pytest.mark.parametrize("claim", command.CLAIMS, ids=lambda claim: claim.NAME)
def test_every_experiment_runs_in_small(
    claim: type[Claim], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, golden: Callable[[str, str], None]
) -> None:
    """Its section and what its plot shows are those that are kept."""
    said: list[str] = []
    shown: list[str] = []
    save = Figure.savefig
    monkeypatch.setattr(
        Figure, "savefig", lambda self, *to, **how: (save(self, *to, **how), shown.append(described(self)))
    )
    section = command.examine(claim.quick(), Laboratory(jobs=1, progress=said.append), tmp_path, "results")
    assert section.startswith(f"## {claim.NUMBER}. {claim.TITLE}\n\n**")
    assert "| " in section and f"--claim {claim.NUMBER}" in section
    assert "runs" in "".join(said)
    drawn = list(tmp_path.glob("*.svg"))
    assert len(drawn) == len(shown) == ("![" in section) and all(file.stat().st_size > 5000 for file in drawn)
    golden(f"claims/{claim.NUMBER}.text", section + "".join(shown))


def load_rows(missed: dict[int, float], release: str = "together", **more: float) -> Rows:
    row = {"part": "load", "release": release, "seed": 1, "f_a": 0.0, "avoidance": 0.0, "block_ms": 13.2, **more}
    return [{**row, "dsps": n, "f_p": m, "f_t": m / 2} for n, m in missed.items()]


def rate_rows(best: dict[int, float], grid: tuple[float, ...], **more: float) -> Rows:
    healthy = {
        "skipped": 0,
        "host": 20.0,
        "refresh_us": 4.0,
        "bus_a": 30.0,
        "pid_run_us": 50.0,
        "behind_identify": 0,
        **more,
    }
    return [
        {"part": "rate", "dsps": n, "servo_hz": f, "misses": int(f > top), **healthy}
        for n, top in best.items()
        for f in grid
    ]


GRID = (1000.0, 2000.0, 4000.0, 8000.0)
ADDING = Dsps(dsps=(1, 2, 4), rate_dsps=(1, 2, 4), servo_hz=GRID)


@pytest.mark.parametrize(
    "missed, word",
    [
        ({1: 40.0, 2: 5.0, 4: 0.0}, "holds"),
        ({1: 40.0, 2: 5.0, 4: 1.0}, "holds in part"),
        ({1: 40.0, 2: 38.0, 4: 37.0}, "fails"),
        ({1: 40.0, 2: 0.0, 4: 12.0}, "fails"),  # more DSPs made it worse again
        ({1: 0.0, 2: 0.0, 4: 0.0}, "not tested"),
    ],
)
def test_adding_dsps(missed: dict[int, float], word: str) -> None:
    assert ADDING.verdict(load_rows(missed) + rate_rows({1: 2000, 2: 4000, 4: 4000}, GRID)).word == word


def test_a_plateau_and_what_ends_it_are_reported() -> None:
    p = Dsps(dsps=(1, 3, 4, 5))
    rows = load_rows({1: 98.0, 3: 68.5, 4: 68.5, 5: 0.0}) + load_rows({1: 98.0, 3: 20.0, 4: 0.0, 5: 0.0}, "staggered")
    judged = p.verdict(rows + load_rows({1: 98.0, 3: 68.5, 4: 0.0, 5: 0.0}, "together-cap", avoidance=25.0))
    assert judged.word == "holds" and "none with 5 or more" in judged.why
    assert "4 (staggered)" in judged.why
    assert "4 (at most 3 at a time; 25 % of the avoidance blocks are late then)" in judged.why
    assert "From 3 to 4 DSPs nothing is won" in judged.limit and "the servo stands for 66 % of the time" in judged.limit


@pytest.mark.parametrize(
    "measured, named",
    [
        ({"skipped": 30.0}, "the host's refresh of the list"),
        ({"host": 97.0}, "the host's refresh of the list"),
        ({"bus_a": 93.0}, "bus A (93 % in use)"),
        ({"pid_run_us": 110.0}, "the PID block itself"),
        ({}, "DSPs: bus A is 30 % in use"),
    ],
)
def test_what_ends_the_gain_of_more_dsps_is_named(measured: dict[str, float], named: str) -> None:
    rows = load_rows({1: 9.0, 2: 0.0, 4: 0.0}) + rate_rows({1: 2000, 2: 4000, 4: 4000}, GRID, **measured)
    limit = ADDING.verdict(rows).limit
    assert named in limit and "2 kHz with 1, 4 kHz with 2 DSPs" in limit


def test_the_highest_rate_ends_at_the_first_miss_below_it() -> None:
    rows = rate_rows({1: 8000}, GRID)
    rows[1]["misses"] = 1  # 2 kHz misses although 4 and 8 kHz pass: an anomaly of non-preemptive scheduling
    assert ends.highest_rate(rows, 1) == 1000


def test_what_waits_for_identify_is_never_left_out() -> None:
    rows = rate_rows({1: 0, 2: 4000, 4: 4000}, GRID)
    for row in rows[:2]:
        row["behind_identify"] = 1  # up to 2 kHz it is all that one DSP misses
    assert ends.highest_rate(rows, 1) is None
    limit = ADDING.verdict(load_rows({1: 9.0, 2: 0.0, 4: 0.0}) + rows).limit
    assert (
        "1 DSP misses some jobs at every f_p of the grid: up to 2 kHz those that wait for identify, and no other"
        in limit
    )


def test_bus_a_is_full_beyond_95_percent_of_it() -> None:
    def row(dsps: int, bus_a: float) -> dict[str, Any]:
        return {
            "part": "policy",
            "policy": "spin",
            "dsps": dsps,
            "bus_a": bus_a,
            "refresh_us": 9.0 * dsps,
            "pid_us": 70.0,
        }

    assert ends.shared_limits([row(2, 60.0), row(4, 95.0)]) == ""
    said = ends.shared_limits([row(2, 60.0), row(4, 95.1), row(8, 99.0)])
    assert "With idle policy spin bus A is full from 4 DSPs on; with 8 a refresh takes 72 µs" in said


def test_a_grid_of_dsps_in_any_order_is_judged_alike() -> None:
    rows = load_rows({1: 40.0, 2: 38.0, 4: 0.0}) + rate_rows({1: 2000, 2: 4000, 4: 4000}, GRID)
    judged = {str(dataclasses.replace(ADDING, dsps=dsps).verdict(rows)) for dsps in ((1, 2, 4), (2, 1, 4))}
    assert len(judged) == 1


def test_misses_are_put_down_to_identify_along_their_chain() -> None:
    def miss(number: int, previous: int | None, behind: str = "") -> dict[str, Any]:
        return {"kind": "pid", "number": number, "previous": previous, "behind": [{"kind": behind}] if behind else []}

    chain = [
        miss(3, 2),
        miss(2, 1),
        miss(1, None, "identify"),
        miss(8, 7),
        miss(7, None, "obstacle_avoidance"),
        {**miss(9, None, "identify"), "kind": "identify"},
    ]
    assert ends.behind_identify({"misses": chain}) == 3


def trial(dsps_left: int = 1, **more: Any) -> dict[str, Any]:
    row = {
        "dsps": dsps_left + 1,
        "action": "fail",
        "samples": 3,
        "lost": 0,
        "recomputed": 1,
        "violations": 0,
        "detected_ms": 1.1,
        "phase": "runs",
        "kind": "pid",
    }
    return {**row, "stopped": False, "braked": False, **more}


def test_failures() -> None:
    p = Failures()
    assert p.verdict([trial()] * 5).word == "holds"
    assert p.verdict([trial()] * 5 + [trial(lost=1)]).word == "fails"
    assert p.verdict([trial()] * 5 + [trial(violations=1)]).word == "fails"
    assert p.verdict([trial(recomputed=0)] * 5).word == "not tested"
    # No demand on the only DSP, but its failure is reported.
    alone = p.verdict([trial(), trial(0, stopped=True, braked=True, lost=1), trial(0)])
    assert alone.word == "holds" and "1 ended the work, and 1 of these left the crane braked" in alone.limit


def plug(before: float, after: float, claims: int = 9, n: int = 1, **more: Any) -> dict[str, Any]:
    return {
        "dsps": n,
        "before": before,
        "after": after,
        "claims": claims,
        "first_claim_ms": 1.5 if claims else None,
        "violations": 0,
        **more,
    }


def test_hotplug() -> None:
    p = Hotplug()
    assert p.verdict([plug(50.0, 0.0)] * 3).word == "holds"
    assert p.verdict([plug(50.0, 45.0)] * 3).word == "holds in part"
    assert p.verdict([plug(50.0, 0.0), plug(50.0, 50.0, claims=0)]).word == "fails"
    assert p.verdict([plug(50.0, 0.0), plug(50.0, 0.0, violations=1)]).word == "fails"
    assert p.verdict([plug(0.0, 0.0)]).word == "not tested"
    unseen = [{**plug(50.0, 0.0), "first_claim_ms": None}]  # the first block came after the last look for it
    assert "took blocks by itself. With 1 + 1 DSPs" in p.verdict(unseen).why
    assert "Where 4 DSPs already do" in p.verdict([plug(50.0, 0.0), plug(0.0, 0.0, claims=0, n=4)]).limit


def gap(ratio: int, servo: float, planning: float = 0.0, equation: str = "restored") -> dict[str, Any]:
    return {
        "part": "gaps",
        "equation": equation,
        "ratio": ratio,
        "servo": servo,
        "crane": planning,
        "agv": planning,
        "idle": 20.0,
        "servo_misses": 9,
        "identify": 9,
    }


def starving(a: int, agv: float, servo_hz: float = 5000) -> dict[str, Any]:
    return {"part": "starving", "servo_hz": servo_hz, "a": a, "agv": agv, "servo": 0.0, "crane": 3.0}


@pytest.mark.parametrize(
    "rows, word",
    [
        ([gap(2, 30.0), gap(8, 0.0), starving(1, 60.0), starving(20, 2.0)], "holds"),
        ([gap(8, 0.0), starving(1, 60.0), starving(20, 55.0)], "holds in part"),
        ([gap(8, 9.0), starving(1, 60.0), starving(20, 2.0)], "holds in part"),
        ([gap(8, 0.1, planning=30.0), starving(1, 60.0), starving(20, 55.0)], "fails"),
        ([gap(8, 0.0), starving(1, 0.0), starving(20, 0.0)], "holds in part"),  # a was not needed
        ([gap(8, 0.0, equation="as_printed"), starving(1, 0.0)], "not tested"),
    ],
)
def test_importance(rows: Rows, word: str) -> None:
    assert Importance(crowded_hz=(5000.0,)).verdict(rows).word == word


def test_importance_says_where_a_and_where_the_ratio_of_rates_matter() -> None:
    limit = (
        Importance(crowded_hz=(5000.0,))
        .verdict([gap(2, 30.0), gap(8, 0.0), starving(1, 60.0), starving(20, 2.0)])
        .limit
    )
    assert limit.endswith(". With f_s = 2 f_p it misses more than 1 %.") and "60 %" in limit
    alike = (
        Importance(crowded_hz=(5000.0,)).verdict([gap(4, 0.0), gap(8, 0.0), starving(1, 60.0), starving(20, 2.0)]).limit
    )
    assert alike.endswith(". f_s from 4 to 8 f_p makes no difference to the misses.") and "60 %" in alike


def cycles(rule: str, t_w: list[float], t_v: float = 0.0, T_g: tuple[float, ...] = (100.0,)) -> Rows:
    """A run's closed cycles."""
    return [
        {"rule": rule, "lane_m": 0.0, "cycle": n, "interval": 40, "driving_s": 80.0, "t_w_s": value, "t_v_s": t_v, "T_g_s": T_g[n % len(T_g)]}
        for n, value in enumerate(t_w)
    ]  # fmt: skip


LONG = [60.0] * 8


@pytest.mark.parametrize(
    "rows, word",
    [
        (cycles("off", LONG) + cycles("proportional", [60, 60, 40, 20, 3, 1, 0, 0]), "holds"),
        (cycles("off", LONG) + cycles("proportional", [60, 60, 55, 40, 30, 25, 30, 25]), "holds in part"),
        (cycles("off", LONG) + cycles("proportional", [60, 60, 55, 60, 55, 60, 55, 60]), "fails"),
        (
            cycles("off", LONG) + cycles("proportional", [60, 60, 40, 20, 0, 0, 0, 0], t_v=20.0),
            "holds in part",
        ),  # the crane pays for it
        (
            cycles("off", LONG, T_g=(85.0, 115.0))
            + cycles("proportional", [60, 60, 40, 20, 15, 12, 14, 12], T_g=(85.0, 115.0)),
            "holds in part",
        ),  # the variation of T_g does not excuse it
        (cycles("off", LONG) + cycles("proportional", LONG[:3]), "not tested"),
        (cycles("off", [1.0] * 8) + cycles("proportional", [1.0] * 8), "not tested"),
        (
            cycles("off", LONG)
            + [{**row, "interval": 2} for row in cycles("proportional", [60, 60, 40, 20, 15, 15, 15, 15])],
            "holds",
        ),  # a refresh more or less is 40 s of driving: it cannot do better
    ],
)
def test_learning(rows: Rows, word: str) -> None:
    assert Learning(last=3).verdict(rows).word == word


def test_learning_by_one_is_reported() -> None:
    rows = cycles("off", LONG) + cycles("proportional", [60, 60, 40, 20, 3, 1, 0, 0]) + cycles("unit", [58.0] * 8)
    assert "Changing N̂_a by 1 per cycle, as printed, leaves 58 s" in Learning().verdict(rows).limit


def test_every_lane_of_a_long_list_is_drawn_and_looks_different() -> None:
    lanes = tuple(10.0 * n for n in range(1, 10))
    rows = [{**row, "lane_m": lane} for lane in lanes for row in cycles("off", LONG)]
    figure = Figure()
    Learning(lanes_m=lanes).draw(rows, figure)
    for axes in figure.axes:
        assert [line.get_label() for line in axes.lines] == [f"off, {lane:g} m" for lane in lanes]
        assert len({(line.get_linestyle(), line.get_linewidth()) for line in axes.lines}) == len(lanes)


def box(agvs: int, t_v: float | None, t_w: float = 0.0) -> dict[str, Any]:
    return {"agvs": agvs, "t_v_s": t_v, "t_v": f"{t_v}", "t_w_s": t_w, "T_g_s": 100.0, "per_hour": 30.0}


@pytest.mark.parametrize(
    "rows, word",
    [
        ([box(1, 60.0), box(2, 10.0), box(3, 0.1, 40.0)], "holds"),
        ([box(1, 60.0), box(2, 30.0)], "holds in part"),
        ([box(1, 60.0), box(2, 58.0)], "fails"),
        ([box(1, 0.5), box(2, 0.0)], "not tested"),
        ([box(1, None), box(2, 0.0)], "not tested"),
    ],
)
def test_fleet(rows: Rows, word: str) -> None:
    assert Fleet().verdict(rows).word == word


def test_the_joints_are_told_of_each_family_with_tight_loops() -> None:
    rows = [lost(f"{family}, tight", 30, 3, path) for family, path in (("scattered misses", 0.5), ("gaps", 2.0))]
    said = cost.tight_loops([{**row, "preset": "tight", "unstable": "–"} for row in rows])
    assert said.count("With preset `tight`") == 2 and "and scattered misses the joints are so far off" in said
    assert "30 % missed 0.5 mm" in said and "30 % missed 2 mm" in said


def lost(family: str, share: float, gap: float, path: float, f_t: float = 0.0, lag: float = 0.0) -> dict[str, Any]:
    row = {
        "family": family,
        "name": f"{gap:g} ms",
        "f_p": share,
        "f_t": f_t,
        "gap_ms": gap,
        "load_mm": path,
        "path_mm": path,
        "lag_s": lag,
    }
    margins = {"travel": 105.2, "other joints": 10.0}
    return {**row, "margins": margins, "stop": "completed", "makespan_s": None, "landings_missed": 0, "errors": "–"}


@pytest.mark.parametrize(
    "rows, word",
    [
        (
            [lost("slow clocks", 60, 2, 1.0), lost(cost.HALF, 50, 90, 20.0, 45.0, 2.0)],
            "holds in part",
        ),  # time, and no accuracy
        ([lost("slow clocks", 60, 2, 190.0), lost(cost.HALF, 50, 90, 20.0, 45.0, 2.0)], "holds"),
        ([lost("slow clocks", 60, 2, 1.0), lost(cost.HALF, 50, 90, 20.0)], "fails"),
        ([lost("slow clocks", 0, 0, 1.0)], "not tested"),
    ],
)
def test_cost(rows: Rows, word: str) -> None:
    assert Cost().verdict(rows).word == word


def test_a_pause_of_the_host_loses_as_many_samples_as_it_says() -> None:
    base = {"machine.dsps": 1, "report.misses_max": 10000}
    for gap in (3, 20):
        [[report]] = Laboratory(1, progress=lambda text: None).all(
            [Run({}, base, 0.15, events=cost.pauses(gap, gap + 5, 0.15))], "pauses"
        )
        assert cost.longest_gap(report) in (gap - 1, gap, gap + 1), gap


def test_a_run_that_is_too_short_for_a_pause_has_none() -> None:
    assert cost.pauses(20, 25, 0.02) == [] and len(cost.pauses(20, 25, 0.09)) == 1


def test_runs_of_a_group_share_an_ideal_run() -> None:
    runs = [Run({"n": n}, {"machine.dsps": n}, 0.03, group="shared") for n in (1, 2)]
    [[one], [two]] = Laboratory(1, progress=lambda text: None).all(runs, "shared")
    assert one["reference_elapsed_s"] == two["reference_elapsed_s"] > 0
    assert one["rates"]["f_p"]["demanded"] == two["rates"]["f_p"]["demanded"]
    [[alone]] = Laboratory(1, progress=lambda text: None).all([Run({}, {"machine.dsps": 1}, 0.03)], "alone")
    assert alone["rates"] is None and alone["hash"] == one["hash"]


def test_an_interval_of_what_does_not_vary_is_not_printed() -> None:
    assert judgement.with_interval([5.0, 5.0, 5.0]) == "5.00"
    assert judgement.with_interval([49.21, 49.24], 1) == "49.2"
    assert judgement.with_interval([1.0, 2.0, 3.0, 4.0], 1).startswith("2.5 [")
    assert judgement.with_interval([]) == "–"


def test_intervals() -> None:
    # Wilson's interval of 8 of 10: Newcombe 1998 gives 0.490 to 0.943.
    assert judgement.share_interval(8, 10) == pytest.approx((0.490, 0.943), abs=5e-4)
    assert judgement.share_interval(10, 10)[1] == 1.0
    mean, low, high = judgement.mean_interval([float(i % 10) for i in range(400)])
    half = 1.96 * 8.25**0.5 / 400**0.5  # a mean of 400 draws of variance 8.25
    assert mean == 4.5 and (mean - low, high - mean) == pytest.approx((half, half), rel=0.15)


def test_a_section_is_replaced_alone(tmp_path: Path) -> None:
    file = tmp_path / "results.md"
    page.write(file, 3, "## 3. three\n\noutdated")
    page.write(file, 1, "## 1. one\n\nkept")
    page.write(file, 3, "## 3. three\n\nnew")
    text = file.read_text()
    assert text.index("## 1. one\n\nkept") < text.index("## 3. three\n\nnew")
    assert "outdated" not in text and text.startswith("# The claims")


def test_help_explains_every_parameter(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        command.main(["--help"])
    judged = " ".join(capsys.readouterr().out.split())
    for claim in command.CLAIMS:
        for one in dataclasses.fields(claim):
            assert f"--{one.name.replace('_', '-')}" in judged and " ".join(one.metadata["help"].split()) in judged, (
                claim.NAME,
                one.name,
            )


@pytest.mark.campaign
@pytest.mark.parametrize("claim", command.CLAIMS, ids=lambda claim: claim.NAME)
def test_the_page_says_what_its_command_prints(claim: type[Claim], tmp_path: Path) -> None:
    written = (ROOT / "docs" / "results.md").read_text(encoding="utf-8")
    now = command.examine(claim(), Laboratory(jobs=2), tmp_path, "results")
    first, last = page.marks(claim.NUMBER)
    assert written[written.index(first) + len(first) + 1 : written.index(last)].rstrip() == now.rstrip()
    [plot] = tmp_path.glob("*.svg")
    assert plot.read_text(encoding="utf-8") == (ROOT / "docs" / "results" / plot.name).read_text(encoding="utf-8")


def test_earlier_runs_are_used_again(tmp_path: Path) -> None:
    run = Run({"n": 1}, {"machine.dsps": 1}, 0.021)
    said: list[str] = []
    first = Laboratory(1, tmp_path, said.append).all([run], "a")
    again = Laboratory(1, tmp_path, said.append).all([run], "b")
    assert again == first and not any("b:" in text for text in said)
    assert Run({"n": 1}, {"machine.dsps": 2}, 0.021).key() != run.key()


@pytest.mark.parametrize(
    "arguments, message",
    [
        (["--claim", "2", "--servo-hz", "fast"], "--servo-hz: 'fast'; a number above 0 is expected"),
        (
            ["--claim", "1", "--quick", "--releases", "never"],
            "--releases: 'never' is unknown; together, staggered, together-cap",
        ),
        (["--claim", "2", "--trials", "1,2"], "--trials: '1,2'; claim 2 expects one value"),
        (["--claim", "2", "--dsps", ""], "--dsps: ''; claim 2 expects one value or several"),
        (["--claim", "5", "--trials", "3"], "--trials: claim 5 has no such parameter"),
        (["--claim", "6", "--quick", "--agvs", "99"], "dock.agvs: 99 is out of range"),
        (["--jobs", "0"], "--jobs: at least 1 is expected"),
    ],
)
def test_bad_input_is_named(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(arguments) == 2
    assert message in capsys.readouterr().err


def test_other_parameters_by_the_command_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main(["--claim", "3", "--quick", "--dsps", "2", "--servo-hz", "4000", "--jobs", "1"]) == 0
    out = capsys.readouterr().out
    assert "| 2 + 1 | 1 |" in out and "f_p 4000 Hz" in out
