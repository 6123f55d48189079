"""Plots of results and sweeps: what is drawn is what the data say, with units, legends outside."""

import itertools
import math
from collections.abc import Callable
from pathlib import Path

import cmrc
import numpy as np
import pytest
from cmrc.sweeps import Sweep
from cmrc.sweeps.store import Folder

pytest.importorskip("matplotlib")
pytest.importorskip("pyarrow")
from cmrc import plot
from cmrc.events import built_in_tasks
from drawn import described
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from sweep_rows import row


@pytest.fixture(scope="module")
def result() -> cmrc.Result:
    return cmrc.run(dsps=1, duration_s=0.04, keep_events=True)


def axes() -> Axes:
    return Figure(figsize=(6, 4), layout="constrained").subplots()


@pytest.fixture(scope="module")
def sweep(tmp_path_factory: pytest.TempPathFactory) -> Sweep:
    path = tmp_path_factory.mktemp("plots") / "s"
    rows, n = [], 0
    for dsps in (4, 2, 3):
        for phase in ("together", "staggered"):
            for seed in (1, 2):
                misses = (
                    None if (dsps, phase) == (3, "together") else 10 * (5 - dsps) + (seed if phase == "together" else 0)
                )
                rows.append(row(n, {"machine.dsps": dsps, "scheduling.agv_phase": phase}, seed, misses))
                n += 1
    with Folder(path) as folder:
        folder.write(rows)
    return Sweep(path)


def test_a_grid_is_drawn_in_order_with_gaps_and_intervals(sweep: Sweep) -> None:
    drawn = axes()
    plot.grid(sweep, drawn, x="dsps")
    staggered, together = drawn.containers
    assert [c.get_label() for c in (staggered, together)] == ["agv_phase = staggered", "agv_phase = together"]
    assert list(staggered.lines[0].get_xdata()) == [2, 3, 4] and list(staggered.lines[0].get_ydata()) == [30, 20, 10]
    assert all(tick == int(tick) for tick in drawn.get_xticks())  # there is no half a DSP
    found = together.lines[0].get_ydata()
    assert found[0] == 31.5 and math.isnan(found[1]) and found[2] == 11.5
    bars = together.lines[2][0].get_segments()
    assert bars[0][0][1] == 31 and bars[0][1][1] == 32  # of two values the bootstrap reaches from one to the other
    assert (drawn.get_xlabel(), drawn.get_ylabel()) == ("machine.dsps", "misses, jobs") and "95 %" in drawn.get_title()
    by_words = axes()
    plot.grid(sweep, by_words, x="agv_phase", lines="dsps")
    assert [tick.get_text() for tick in by_words.get_xticklabels()] == ["staggered", "together"]
    with pytest.raises(ValueError, match="is not an axis of the sweep"):
        plot.grid(sweep, axes(), x="seed")


def test_long_names_below_an_axis_do_not_lie_on_each_other(
    tmp_path: Path, sweep: Sweep, capsys: pytest.CaptureFixture[str]
) -> None:
    from cmrc.commands import main

    names = ["漢字漢字 wide", *(f"{'a very long name ' * 6}{n}" for n in range(3))]
    with Folder(tmp_path / "s") as folder:
        folder.write([row(n, {"future": name}, 1, 10 + n) for n, name in enumerate(names)])
    drawn = axes()
    plot.grid(Sweep(tmp_path / "s"), drawn, x="future")
    drawn.figure.canvas.draw()  # type: ignore[union-attr]
    ticks = drawn.get_xticklabels()
    assert len({tick.get_text() for tick in ticks}) == 4 and max(len(tick.get_text()) for tick in ticks) < 30
    assert [tick.get_text() for tick in ticks[:3]] == [f"{name[:14]}…{name[-13:]}" for name in names[1:]]
    assert {tick.get_rotation() for tick in ticks} == {25}
    places = [drawn.transData.transform((n, 0))[0] for n in range(4)]
    height = max(tick.get_fontsize() for tick in ticks) * drawn.figure.dpi / 72
    assert min(b - a for a, b in itertools.pairwise(places)) * math.sin(math.radians(25)) > height
    short = axes()
    plot.grid(sweep, short, x="agv_phase", lines="dsps")
    assert {tick.get_rotation() for tick in short.get_xticklabels()} == {0}
    # What the font lacks is said in one sentence, not by warnings of a library.
    assert (
        main(["sweep", str(tmp_path / "s.toml"), "--show", "--metric", "misses", "--plot", str(tmp_path / "a.png")])
        == 0
    )
    said = [line for line in capsys.readouterr().err.splitlines() if "reading" not in line]
    assert len(said) == 1 and "a.png: the font has not all characters" in said[0] and (tmp_path / "a.png").exists()


def test_lines_of_a_legend_can_be_distinguished_in_grey() -> None:
    from cmrc.result_plots import MARKS, style

    looks = [(tuple(style(n).values()), MARKS[n % len(MARKS)]) for n in range(40)]
    assert len(set(looks)) == 40
    assert len({str(style(n)["linestyle"]) for n in range(24)}) == 24


def test_each_kind_of_a_gantt_chart_has_its_own_hatch_on_a_colour_that_shows_it() -> None:
    kinds = [f"user.{n}" for n in range(8)]
    tasks: dict[str, dict[str, int]] = {kind: {} for kind in [*built_in_tasks(), *kinds]}
    events = "".join(
        f"{0.001 * n:.9f} [dsp 0] claim block={n} kind={n}\n{0.001 * n + 0.0005:.9f} [dsp 0] finish block={n} kind={n}\n"
        for n in range(len(tasks))
    )
    report = {"tasks": tasks, "dsps": [{}], "simulated_s": 1.0, "misses": []}
    plot.gantt(cmrc.Result(report, "", cmrc.Table(), None, events), drawn := axes(), 0.0, 1.0)
    bars = drawn.get_legend_handles_labels()[0]
    assert len(bars) == 20 and len({bar.get_hatch() for bar in bars}) == 20
    assert min(float(sum(bar.get_facecolor()[0][:3])) for bar in bars) > 0.5


def test_no_legend_covers_anything(result: cmrc.Result, sweep: Sweep) -> None:
    for draw in (
        lambda a: plot.grid(sweep, a, x="dsps"),
        lambda a: plot.cdf(result, a),
        lambda a: plot.misses(result, a),
        lambda a: plot.load_error(result, a),
        lambda a: plot.gantt(result, a, 0.02, 0.024),
        lambda a: plot.cost(sweep, a),
    ):
        drawn = axes()
        draw(drawn)
        drawn.figure.canvas.draw()  # type: ignore[union-attr]
        legend = drawn.get_legend()
        assert legend is not None and legend.get_window_extent().x0 >= drawn.get_window_extent().x1 - 1
        assert drawn.get_xlabel()


def test_a_short_name_of_the_lines_means_the_axis_without_x_too(sweep: Sweep) -> None:
    for lines in ("dsps", "machine.dsps"):
        plot.grid(sweep, drawn := axes(), lines=lines)
        assert [line.get_label() for line in drawn.containers] == ["dsps = 2", "dsps = 3", "dsps = 4"]
        assert drawn.get_xlabel() == "scheduling.agv_phase"


def test_the_cost_of_misses_is_a_point_per_run(sweep: Sweep) -> None:
    drawn = axes()
    plot.cost(sweep, drawn)
    points = sorted((x, y) for line in drawn.lines for x, y in zip(line.get_xdata(), line.get_ydata(), strict=True))
    assert (
        len(points) == 10 and points[0] == (0.10, pytest.approx(10e-6)) and points[-1] == (0.32, pytest.approx(32e-6))
    )
    assert drawn.get_xlabel() == "f_p_missed, share" and drawn.get_ylabel() == "load_rms, m"


def test_a_gantt_chart_has_the_blocks_of_the_trace(result: cmrc.Result) -> None:
    from cmrc.result_plots import runs

    blocks = list(runs(result))
    tasks = result.report["tasks"]
    ended = {kind: sum(block[1] == kind for block in blocks) for kind in tasks}
    running = sum(task["unfinished"] for task in tasks.values())
    assert sum(ended.values()) == sum(task["execution_ps"]["count"] for task in tasks.values()) + running
    identify = next(block for block in blocks if block[1] == "identify")
    assert identify[3] - identify[2] == pytest.approx(tasks["identify"]["execution_ps"]["mean"] * 1e-12, rel=0.01)
    with pytest.raises(ValueError, match="not a window"):
        plot.gantt(result, axes(), 0.02, 0.02)
    quiet = cmrc.Result(result.report, result.text, result.signals)
    with pytest.raises(ValueError, match="keep_events=True"):
        plot.gantt(quiet, axes(), 0.02, 0.03)


@pytest.mark.parametrize("action", ["fail", "freeze", "unplug", "reset", "hang"])
def test_a_bar_ends_with_its_dsp_the_watchdog_or_the_run(action: str) -> None:
    from cmrc.result_plots import runs

    events = [{"at_s": 0.05, "action": action, "dsp": 1}]
    found = cmrc.run(preset="saturated", dsps=2, duration_s=0.09, keep_events=True, events=events)
    blocks = list(runs(found))
    [cut] = [block for block in blocks if block[0] == 1 and block[2] < 0.05 <= block[3]]
    assert cut[3] == 0.05
    assert max(block[3] for block in blocks) == 0.09
    for slot, dsp in enumerate(found.report["dsps"]):
        busy = sum(block[3] - block[2] for block in blocks if block[0] == slot)
        assert busy == pytest.approx(sum(dsp["tasks_ps"].values()) * 1e-12, rel=1e-3)


def test_a_gantt_chart_has_the_misses_of_the_trace_and_the_reports_names(tmp_path: Path) -> None:
    found = cmrc.run(preset="saturated", dsps=1, duration_s=0.1, keep_events=True, misses_max=3)
    drawn = axes()
    plot.gantt(found, drawn, 0.05, 0.09)
    in_window = [
        line for line in (found.events or "").splitlines() if " miss " in line and 0.05 < float(line.split()[0]) < 0.09
    ]
    assert len(found.missed) == 3 and len(in_window) > 20
    assert [len(line.get_xdata()) for line in drawn.lines] == [len(in_window)]  # type: ignore[arg-type]
    plot.gantt(found, drawn := axes(), 0.05, float(in_window[-1].split()[0]))  # both ends belong to the window
    assert [len(line.get_xdata()) for line in drawn.lines] == [len(in_window)]  # type: ignore[arg-type]
    whole = cmrc.run(preset="saturated", dsps=1, duration_s=0.1, keep_events=True)
    plot.gantt(whole, drawn := axes(), 0.0, 0.2)
    assert sum(len(line.get_xdata()) for line in drawn.lines) == len(whole.missed)  # type: ignore[arg-type]


@pytest.mark.parametrize("action", [{"action": "pause_host"}, {"action": "stall_bus", "bus": "A"}])
def test_a_gantt_chart_has_the_misses_that_the_host_did_not_come_to(action: dict[str, str]) -> None:
    away = {"at_s": 0.05, "lasts_ms": 200, **action}
    found = cmrc.run(preset="saturated", dsps=2, duration_s=0.1, keep_events=True, events=[away])
    plot.gantt(found, drawn := axes(), 0.0, 0.1)
    crosses = [x for line in drawn.lines for x in line.get_xdata()]  # type: ignore[union-attr]
    assert len(crosses) == found.misses == len(found.missed) > 100
    last = [miss for miss in found.missed if miss["kind"] == "pid" and miss["release_ps"] > 52e9]
    assert {miss["outcome"] for miss in last} == {"dropped"}
    assert all(miss["release_ps"] / 1e9 in crosses for miss in last)


def test_a_run_without_misses_has_the_names_of_its_tasks() -> None:
    found = cmrc.run(dsps=2, duration_s=0.1)
    plot.misses(found, drawn := axes())
    assert found.misses == 0 and not drawn.containers
    released = [kind for kind, task in found.report["tasks"].items() if task["released"]]
    assert [tick.get_text() for tick in drawn.get_yticklabels()] == released


@pytest.mark.parametrize(("dsps", "any_miss"), [(1, True), (16, False)])
def test_the_bars_of_misses_are_those_of_the_report(dsps: int, any_miss: bool) -> None:
    """Jobs that run or wait at the end before their deadline are no misses."""
    found = cmrc.run(preset="saturated", dsps=dsps, duration_s=0.1)
    tasks = {kind: task for kind, task in found.report["tasks"].items() if task["released"]}
    assert (found.misses > 0) == any_miss and any(task["unfinished"] for task in tasks.values())
    plot.misses(found, drawn := axes())
    misses = [task["misses"] for task in tasks.values()]
    long = [sum(part.patches[y].get_width() for part in drawn.containers) for y in range(len(tasks))]
    assert long == misses
    assert [text.get_text() for text in drawn.texts] == [
        f" {missed} of {task['released']}" for missed, task in zip(misses, tasks.values(), strict=True)
    ]
    parts = {str(part.get_label()): [bar.get_width() for bar in part.patches] for part in drawn.containers}
    assert parts.get("late", [0] * len(tasks)) == [task["late"] for task in tasks.values()]


def test_cumulated_response_times_hold_the_percentiles(result: cmrc.Result) -> None:
    drawn = axes()
    plot.cdf(result, drawn)
    pid = next(line for line in drawn.lines if line.get_label() == "pid")
    x, y = np.asarray(pid.get_xdata(), dtype=float), np.asarray(pid.get_ydata(), dtype=float)
    response = result.report["tasks"]["pid"]["response_ps"]
    assert (
        x[0] == pytest.approx(response["best"] / 1e6)
        and x[-1] == pytest.approx(response["worst"] / 1e6)
        and y[-1] == 100
    )
    assert np.all(np.diff(y) >= 0) and y[np.argmin(abs(x - response["p50"] / 1e6))] == pytest.approx(50, abs=2)


def test_each_percentile_has_its_share() -> None:
    at = {"best": 1e6, "p50": 4e6, "p99": 1e7, "p99_9": 3e7, "worst": 4e7}
    task = {"response_ps": {**at, "count": 1000, "log2_histogram": [0] * 40}}
    drawn = axes()
    plot.cdf(cmrc.Result({"tasks": {"pid": task}}, "", cmrc.Table()), drawn)
    [pid] = drawn.lines
    shares = dict(zip(np.round(pid.get_xdata(), 6).tolist(), pid.get_ydata(), strict=True))
    assert [shares[time] for time in (1, 4, 10, 30, 40)] == pytest.approx([0, 50, 99, 99.9, 100])


def test_the_title_says_how_many_repeats_there_are(tmp_path: Path) -> None:
    for n, (repeats, title) in enumerate(
        (
            ({1: 1, 2: 1}, "one run per point"),
            ({1: 2, 2: 2}, "mean of n = 2: all repeats agree"),
            ({1: 3, 2: 1}, "mean of n = 1 to 3: all repeats agree"),
        )
    ):
        rows = [
            row(10 * dsps + seed, {"machine.dsps": dsps}, seed, 5)
            for dsps, seeds in repeats.items()
            for seed in range(seeds)
        ]
        with Folder(tmp_path / str(n)) as folder:
            folder.write(rows)
        plot.grid(Sweep(tmp_path / str(n)), drawn := axes(), x="dsps")
        assert drawn.get_title() == title


def test_the_sheet_is_drawn_also_of_a_run_without_a_reference(result: cmrc.Result, tmp_path: Path) -> None:
    result.plot().savefig(tmp_path / "a.png", dpi=40)
    bare = cmrc.run(dsps=1, duration_s=0.03, settings={"report.reference": "none"}).plot()
    bare.savefig(tmp_path / "b.png", dpi=40)
    assert "text 'no reference: no true error' at 0.5 0.5" in described(bare)
    assert (tmp_path / "a.png").stat().st_size > 5000 < (tmp_path / "b.png").stat().st_size


@pytest.mark.golden
def test_plots_show_what_is_kept(result: cmrc.Result, sweep: Sweep, golden: Callable[[str, str], None]) -> None:
    """Titles, units, bars, lines and legends of a run and of a sweep."""
    window = axes()
    plot.gantt(result, window, 0.021, 0.0235)
    over_dsps, over_words, price = axes(), axes(), axes()
    plot.grid(sweep, over_dsps)
    plot.grid(sweep, over_words, x="agv_phase", metric="load_rms")
    plot.cost(sweep, price)
    figures = [result.plot(), *(drawn.figure for drawn in (window, over_dsps, over_words, price))]
    golden("plots.text", "\n".join(described(figure) for figure in figures))  # type: ignore[arg-type]


def test_a_notebook_shows_the_sheet_without_pyplot(result: cmrc.Result) -> None:
    shown = result.plot()._repr_png_()  # type: ignore[attr-defined]
    assert shown.startswith(b"\x89PNG") and len(shown) > 5000
