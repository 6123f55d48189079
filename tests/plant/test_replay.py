"""Recordings, the replay page and the plots."""

import json
import re
import shutil
import subprocess
import sys
from itertools import pairwise

import cmrc
import pytest
from cmrc import __main__ as command
from cmrc import replay


@pytest.fixture(scope="module")
def recording(tmp_path_factory) -> replay.Recording:
    layout = tmp_path_factory.mktemp("dock") / "layout.toml"
    layout.write_text("[[posts]]\nx_m = 34\ny_m = 12\n[[movers]]\npath = [[0, 30, 0], [2, 30, 3]]\n", encoding="utf-8")
    return replay.record(cmrc.Simulation(duration_s=0.5, agvs=2, settings={"dock.layout": str(layout)}))


def test_obstacles_are_recorded_where_they_are(recording):
    assert [radius for radius, _ in recording["layout"]["movers"]] == [0.4, 0.3]  # the mover, the post
    assert recording["signals"]["mover0_y_m"][-1] > recording["signals"]["mover0_y_m"][0] == 0.0
    assert set(recording["signals"]["mover1_x_m"]) == {34.0}


def test_a_recording_holds_every_job_of_the_report(recording):
    report = cmrc.run(4, 0.5, agvs=2).report
    for kind, row in recording["deadlines"]["kinds"].items():
        assert sum(met for met, _ in row) == report["tasks"][kind]["on_time"]
        assert len(row) == len(recording["deadlines"]["edges_s"]) - 1
    assert "pid" in recording["deadlines"]["kinds"] and len(recording["layout"]["containers"]) == 8


def test_containers_go_where_the_events_say(recording):
    story = {**recording, "events": [[0.1, "locked", 0, 0, 0], [0.3, "opened", 0, 0, 0], [0.3, "set_on_agv", 0, 1.0, 0], [0.4, "delivered", 0, 1.0, 0]]}
    steps = replay.containers(story)[0]
    assert [step[1] for step in steps] == ["ship", "carried", "set", "agv", "gone"] and steps[3][2] == 1


def test_the_page_fetches_nothing(recording):
    page = replay.page(recording)
    assert not re.search(r"(src|href)\s*=|https?:|import\s|@import|fetch\(", page)
    assert "/*RECORDING*/null" not in page


def drawn_page(recording, tmp_path, time: float) -> str:
    browser = next((path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None)
    if browser is None:
        pytest.skip("no Chromium here")
    html = tmp_path / "run.html"
    html.write_text(replay.page(recording), encoding="utf-8")
    return subprocess.run(
        [browser, "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom", f"{html.as_uri()}#t={time}"],
        capture_output=True, text=True, timeout=120, check=True,
    ).stdout  # fmt: skip


def test_a_gantry_is_drawn_as_one(tmp_path):
    recording = replay.record(cmrc.Simulation(duration_s=0.3, settings={"dock.crane": "gantry", "dock.containers": 10}))
    assert len(recording["layout"]["containers"]) == 10
    assert recording["layout"]["ship"][2] == 6.0 and recording["layout"]["crane"]["reach"] == [-33.0, 38.5]
    dom = drawn_page(recording, tmp_path, 0.1)
    assert "travel 0.00 m  trolley -8.00 m" in dom and "slew" not in dom.split("<script>")[0]
    drawn = re.search(r'data-ready="(\d+)"', dom)
    assert drawn and int(drawn[1]) > 300
    pytest.importorskip("matplotlib")
    from cmrc import plot

    joints = plot.overview(recording).axes[2]
    assert [text.get_text().split(",")[0] for text in joints.get_legend().get_texts()] == ["gantry", "trolley", "rope", "rotator"]


def test_the_page_draws_in_a_browser(recording, tmp_path):
    dom = drawn_page(recording, tmp_path, 0.25)
    drawn = re.search(r'data-ready="(\d+)"', dom)
    assert drawn and int(drawn[1]) > 100  # faces: the script ran to its end
    assert "0.25 s of 0.5 s" in dom and "kN" in dom


def test_errors_of_all_intervals_are_those_of_the_report(recording):
    result = cmrc.run(4, 0.5, agvs=2)
    edges = recording["deadlines"]["edges_s"]
    time = result.signals["time_s"]
    for joint, error in recording["tracking"].items():
        told = result.errors["joints"][joint]
        rows = [int(((time > a) & (time <= b)).sum()) for a, b in pairwise(edges)]
        assert len(error["rms"]) == len(rows) and error["unit"] == told["unit"]
        square = sum(n * rms**2 for n, rms in zip(rows, error["rms"], strict=True))
        own = result.signals[f"{joint}_error_{told['unit']}"]
        assert square == pytest.approx(float((own[1:] ** 2).sum()), rel=1e-9)
        assert max(error["rms"]) <= told["peak"]


def test_the_overview_has_its_six_plots(recording, tmp_path):
    pytest.importorskip("matplotlib")
    from cmrc import plot

    figure = plot.overview(recording)
    figure.savefig(tmp_path / "run.png")
    titles = [axes.get_title() for axes in figure.axes]
    assert titles[0] == "plan" and titles[2:] == ["joints", "joint errors against the ideal run", "sway", "deadlines: green met, red missed"] and len(figure.axes[0].lines) >= 3
    tracking = figure.axes[3]
    assert [text.get_text() for text in tracking.get_legend().get_texts()] == ["gantry, mm", "slew, mrad", "luff, mrad", "rope, mm", "rotator, mrad"]
    assert len(tracking.patches) == 5
    assert (tmp_path / "run.png").stat().st_size > 20000


def test_the_command_replays_what_it_saved(recording, tmp_path):
    run = tmp_path / "run.json"
    replay.save(recording, run)
    assert command.main(["replay", str(run), "--html"]) == 0
    assert (tmp_path / "run.html").read_text(encoding="utf-8") == replay.page(json.loads(run.read_text(encoding="utf-8")))


@pytest.mark.parametrize("text", ["{", "[]", '{"format": 99}'])
def test_what_is_no_recording_is_refused(text, tmp_path, capsys):
    run = tmp_path / "run.json"
    run.write_text(text, encoding="utf-8")
    assert command.main(["replay", str(run), "--html"]) == 2
    assert "no recording" in capsys.readouterr().err
    assert command.main(["replay", str(tmp_path / "missing.json"), "--html"]) == 2


def test_what_cannot_be_written_is_said_before_the_run(recording, tmp_path, capsys):
    run = tmp_path / "run.json"
    replay.save(recording, run)
    for arguments, says in (([], "nothing to write"), (["--html", str(tmp_path / "none" / "x.html")], "no folder"), (["--html", str(tmp_path)], "is a folder"),
                            (["--plots", str(tmp_path / "x.xyz")], "no kind of picture"), (["--save", str(tmp_path / "none" / "r.json"), "--html", str(tmp_path / "x.html")], "no folder")):  # fmt: skip
        assert command.main(["replay", str(run), *arguments]) == 2
        assert says in capsys.readouterr().err
    run.write_text(json.dumps({key: value for key, value in recording.items() if key != "signals"}), encoding="utf-8")
    assert command.main(["replay", str(run), "--html", str(tmp_path / "x.html"), "--plots", str(tmp_path / "x.png")]) == 2
    assert "not whole" in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run.json"]


def test_it_runs_as_a_module():
    helped = subprocess.run([sys.executable, "-c", "import sys; sys.argv=['cmrc']; from cmrc.__main__ import main; main()"],
                            check=False, capture_output=True, text=True, env={"PYTHONPATH": ":".join(sys.path)})  # fmt: skip
    assert helped.returncode == 2 and "replay" in helped.stderr


@pytest.mark.parametrize("name", ["<!--<script>", "</script>", "<!-- <script> -->", "]]>", "a < b"])
def test_a_name_cannot_end_the_script_of_the_page(recording: replay.Recording, name: str) -> None:
    """HTML: in a script element "<!--" with "<script" keeps "</script" from ending it, so no "<" of the data may stand in it."""
    page = replay.page({**recording, "title": name, "layout": {**recording["layout"], name: [name]}})
    before, after = replay.page({**recording, "title": "", "layout": recording["layout"]}), page
    assert after.count("<") == before.count("<")
    start = after.index("const R = ") + len("const R = ")
    data, _ = json.JSONDecoder().raw_decode(after[start:])
    assert data["title"] == name and data["layout"][name] == [name]
