"""``cmrc page``, its old name, and the plots of a page."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from cmrc import Simulation
from cmrc import __main__ as command
from cmrc.page import Recording

SHORT = "[run]\nduration_s = 0.3\n[dock]\nagvs = 2\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("command")
    (folder / "scene.toml").write_text(SHORT + f'layout = "{folder / "layout.toml"}"\n', encoding="utf-8")
    (folder / "layout.toml").write_text(
        "[[posts]]\nx_m = 34\ny_m = 12\n[[movers]]\npath = [[0, 30, 0], [2, 30, 3]]\n", encoding="utf-8"
    )
    assert command.main(["page", str(folder / "scene.toml"), "--set", "machine.dsps=2"]) == 0
    return folder


def test_the_page_stands_beside_its_configuration(folder: Path) -> None:
    recording = Recording.read(folder / "scene.html")
    assert recording.header["title"] == "scene: 2 DSPs, 0.3 s" and recording.header["slots"] == 2
    assert [radius for radius, _ in recording.header["layout"]["movers"]] == [0.4, 0.3]  # the mover, the post
    assert recording.signals["mover0_y_m"][-1] > recording.signals["mover0_y_m"][0] == 0.0
    assert set(recording.signals["mover1_x_m"].tolist()) == {34.0}


def test_the_title_of_a_run_has_its_dsps_and_its_duration() -> None:
    for dsps, title in ((1, "1 DSP, 0.5 s"), (2, "2 DSPs, 0.5 s")):
        assert Simulation(dsps=dsps, duration_s=0.5).title == title


@pytest.mark.golden
def test_a_page_can_be_plotted(folder: Path, golden: Callable[[str, str], None]) -> None:
    pytest.importorskip("matplotlib")
    assert command.main(["page", str(folder / "scene.html"), "--plots", str(folder / "run.png")]) == 0
    assert (folder / "run.png").stat().st_size > 20_000
    from cmrc import plot

    figure = plot.overview(Recording.read(folder / "scene.html"))
    titles = [axes.get_title() for axes in figure.axes]
    assert (
        titles[0] == "plan"
        and titles[2:] == ["joints", "joint errors against the ideal run", "sway", "deadlines"]
        and len(figure.axes[0].lines) >= 3
    )
    figure.canvas.draw()
    for axes in figure.axes:
        covers = axes.get_legend().get_window_extent()
        frame = axes.get_window_extent()
        assert covers.x0 >= frame.x1 - 1 or covers.y1 <= frame.y0 + 1, axes.get_title()
        assert axes.get_xlabel().endswith((", s", ", m"))
    legend = figure.axes[3].get_legend()
    assert legend and [text.get_text() for text in legend.get_texts()] == [
        "gantry, mm",
        "slew, mrad",
        "luff, mrad",
        "rope, mm",
        "rotator, mrad",
    ]
    from drawn import described

    golden("page-plots.text", described(figure))


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["missing.toml"], "missing.toml"),
        (["run.json", "--plots", "x.png"], "is not a page of this emulator"),
        (["scene.html"], "only --plots is possible"),
        (["broken.html", "--plots", "x.png"], "not a page of this emulator"),
        (["scene.toml", "--out", "none/x.html"], "no folder"),
        (["scene.toml", "--out", "."], "is a folder"),
        (["scene.toml", "--out", "x.html", "--plots", "x.xyz"], "not a picture file"),
        (["scene.toml", "--out", "x.html", "--plots", "x.html"], "is the same file"),
        (["scene.toml", "--out", "x.html", "--set", "machine.dsps"], "KEY=VALUE"),
    ],
)
def test_bad_input_is_reported_and_nothing_is_written(
    folder: Path, arguments: list[str], says: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    (folder / "run.json").write_text(json.dumps({"format": 4}), encoding="utf-8")
    (folder / "broken.html").write_text("<html>", encoding="utf-8")
    before = sorted(path.name for path in folder.iterdir())
    assert command.main(["page", *arguments]) == 2
    assert says in capsys.readouterr().err
    assert sorted(path.name for path in folder.iterdir()) == before


@pytest.mark.unsanitized
def test_it_runs_as_a_module() -> None:
    helped = subprocess.run(
        [sys.executable, "-m", "cmrc"],
        check=False,
        capture_output=True,
        text=True,
        env={"PYTHONPATH": ":".join(sys.path)},
    )
    assert helped.returncode == 2 and "page" in helped.stderr and "demo" in helped.stderr
