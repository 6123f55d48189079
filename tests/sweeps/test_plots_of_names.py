"""What plots and tables call things: names as they are, values that can be told apart, axes that go together."""

import io
from pathlib import Path
from typing import Any

import cmrc
import pytest
from cmrc.limit_scans import NOT_RUN, Scan
from cmrc.sweeps import Sweep
from cmrc.sweeps.grid import made
from cmrc.sweeps.ranges import short_names
from cmrc.sweeps.store import Folder

matplotlib = pytest.importorskip("matplotlib")
pytest.importorskip("pyarrow")
from cmrc import plot
from cmrc.sweep_plots import check_grid
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from sweep_rows import row

DOLLARS = ("$\\foo$", "costs $5 and $6")


def axes() -> Axes:
    return Figure(figsize=(6, 4), layout="constrained").subplots()


def swept(folder: Path, *places: dict[str, Any], refused: int = 0) -> Sweep:
    """A sweep with one run for each place, of which the last ones were refused."""
    done = len(places) - refused
    with Folder(folder) as opened:
        opened.write([row(n, place, 1, n + 1 if n < done else None) for n, place in enumerate(places)])
    return Sweep(folder)


def legend(drawn: Axes) -> list[str]:
    shown = drawn.get_legend()
    return [] if shown is None else [text.get_text() for text in shown.get_texts()]


def written(drawn: Axes) -> str:
    out = io.StringIO()
    with matplotlib.rc_context({"svg.fonttype": "none"}):
        drawn.figure.savefig(out, format="svg")  # type: ignore[union-attr]
    return out.getvalue()


def test_a_dollar_in_a_name_is_a_dollar(tmp_path: Path) -> None:
    sweep = swept(tmp_path / "s", *({"future": name, "machine.dsps": n} for name in DOLLARS for n in (1, 2)))
    for begin, draw in (
        ("", lambda drawn: plot.grid(sweep, drawn, x="future", lines="dsps")),
        ("future = ", lambda drawn: plot.grid(sweep, drawn, x="dsps", lines="future")),
        ("future = ", lambda drawn: plot.cost(sweep, drawn)),
    ):
        draw(drawn := axes())
        assert all(f">{begin}{name}</text>" in written(drawn) for name in DOLLARS)

    def price(report: Any) -> int:
        return 1

    price.__name__ = DOLLARS[0]
    plot.grid(sweep, drawn := axes(), metric=price)
    assert f">{DOLLARS[0]}</text>" in written(drawn)
    task = cmrc.run(dsps=2, duration_s=0.03, keep_events=True).report["tasks"]["pid"]
    result = cmrc.Result({"tasks": {f"user.{name}": task for name in DOLLARS}}, "", cmrc.Table())
    for show in (plot.misses, plot.histogram, plot.cdf):
        show(result, drawn := axes())
        assert all(f">user.{name}</text>" in written(drawn) for name in DOLLARS)


def test_a_plot_that_cannot_be_drawn_loses_no_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from cmrc.commands import main

    three = ("machine.dsps", "machine.cycle_time_factor", "run.duration_s")
    values = ((1, 1.0, 1.0), (2, 1.0, 1.0), (1, 2.0, 1.0), (1, 1.0, 2.0))
    swept(tmp_path / "s", *(dict(zip(three, place, strict=True)) for place in values))
    asked = ["--metric", "misses", "--plot", str(tmp_path / "a.png"), "--csv", str(tmp_path / "a.csv")]
    assert main(["sweep", str(tmp_path / "s.toml"), "--show", *asked]) == 2
    shown = capsys.readouterr()
    assert "4 runs done" in shown.out and "a sweep over two axes is expected" in shown.err
    assert (tmp_path / "a.csv").exists() and not (tmp_path / "a.png").exists()


def test_a_refused_run_without_a_value_on_an_axis_is_a_gap(tmp_path: Path) -> None:
    for axis, values in (("machine.dsps", [2, 17]), ("machine.cycle_time_factor", [1.0, 2.0])):
        grid = {"fixed": {"duration_s": 0.03, "reference": "none"} | ({} if axis.endswith("dsps") else {"dsps": 2})}
        cmrc.sweep({**grid, "axes": {axis: values}}, tmp_path / "s", workers=1)
    sweep = Sweep(tmp_path / "s")
    assert sweep.counts()["refused"] == 1
    plot.grid(sweep, drawn := axes())
    assert (drawn.get_xlabel(), legend(drawn)) == ("machine.cycle_time_factor", [])
    assert [list(part.lines[0].get_xdata()) for part in drawn.containers] == [[1.0, 2.0]]
    plot.grid(sweep, drawn := axes(), x="dsps")
    assert legend(drawn) == ["cycle_time_factor = 1", "cycle_time_factor = 2"]


def test_a_run_without_a_future_is_drawn_as_the_table_shows_it(tmp_path: Path) -> None:
    sweep = swept(tmp_path / "s", {"future": "a"}, {"future": None})
    plot.grid(sweep, drawn := axes())
    assert [tick.get_text() for tick in drawn.get_xticklabels()] == ["a", "–"]


def test_settings_that_go_together_are_one_axis(tmp_path: Path) -> None:
    grid = {"together": [{"dsps": [1, 2, 3], "cycle_time_factor": [1.0, 2.0, 2.0]}], "axes": {"duration_s": [0.1, 0.2]}}
    points = list(made(grid).points())
    sweep = swept(tmp_path / "one", *(dict(point.place) for point in points if point.place["run.duration_s"] == 0.1))
    plot.grid(sweep, drawn := axes())
    assert (drawn.get_xlabel(), len(drawn.containers), legend(drawn)) == ("machine.dsps", 1, [])
    sweep = swept(tmp_path / "two", *(dict(point.place) for point in points))
    check_grid(made(grid))
    plot.grid(sweep, drawn := axes())
    assert (drawn.get_xlabel(), legend(drawn)) == ("machine.dsps", ["duration_s = 0.1", "duration_s = 0.2"])
    plot.grid(sweep, drawn := axes(), lines="dsps")
    assert (drawn.get_xlabel(), len(drawn.containers)) == ("run.duration_s, s", 3)


def test_a_sweep_without_axes_says_so(tmp_path: Path) -> None:
    sweep = swept(tmp_path / "s", {})
    for x in (None, "dsps"):
        with pytest.raises(ValueError, match="^grid: the sweep has no axes; at least one is expected$"):
            plot.grid(sweep, axes(), x=x)
    plot.cost(sweep, axes())


def test_axes_with_the_same_last_part_have_different_heads(tmp_path: Path) -> None:
    names = ["slewing.slew.coulomb", "slewing.luff.coulomb", "machine.dsps"]
    assert short_names(names) == ["slew.coulomb", "luff.coulomb", "dsps"]
    assert short_names(["a.b.c", "d.b.c", "b.c"]) == ["a.b.c", "d.b.c", "b.c"]
    slew, luff = names[:2]
    sweep = swept(tmp_path / "s", *({slew: one, luff: other} for one in (0.1, 0.2) for other in (0.1, 0.2)))
    assert sweep.text("misses").split()[:2] == ["slew.coulomb", "luff.coulomb"]
    plot.grid(sweep, drawn := axes())
    assert legend(drawn) == ["luff.coulomb = 0.1", "luff.coulomb = 0.2"]


def test_values_that_differ_look_different(tmp_path: Path) -> None:
    factors = (1.0000001, 1.0000002)
    places = [{"machine.dsps": n, "machine.cycle_time_factor": factor} for factor in factors for n in (1, 2, 3)]
    sweep = swept(tmp_path / "s", *places)
    names = [f"cycle_time_factor = {factor}" for factor in factors]
    plot.grid(sweep, drawn := axes())
    assert legend(drawn) == names
    futures = [f"{'a long beginning ' * 3}{n}{' and a long end' * 3}" for n in (1, 2)]
    plot.cost(swept(tmp_path / "f", *({"future": name} for name in futures)), drawn := axes())
    assert legend(drawn) == [f"future = {name}" for name in futures]
    points = [{**NOT_RUN, "value": value, "realised": 1000.0, "ran": True} for value in (999.99999, 1000.0)]
    text = Scan("servo", "rates.servo_frequency_hz", "f_p", True, points).text()
    assert [line.rpartition("  ")[0].strip() for line in text.splitlines()[2:4]] == ["999.99999 (runs at 1000)", "1000"]
