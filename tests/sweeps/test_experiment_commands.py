"""cmrc sweep, search, limits, compare, diff: what they print, write and refuse."""

import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import cmrc
import pytest
from cmrc.__main__ import main
from cmrc.commands.common import numbers, setting
from cmrc.progress import ProgressLine, of_sweep
from cmrc.sweeps import Found, Status, metrics
from locations import BUILD

pytest.importorskip("distributed")
pytest.importorskip("pyarrow")

GRID = """
[fixed]
duration_s = 0.03
report.reference = "none"
[axes]
dsps = [1, 2]
"""


def test_a_sweep_from_empty_to_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    file = tmp_path / "grid.toml"
    file.write_text(GRID)
    asked = [
        "sweep",
        str(file),
        "--metric",
        "misses",
        "--csv",
        str(tmp_path / "runs.csv"),
        "--plot",
        str(tmp_path / "a.svg"),
    ]
    assert main([*asked, "--workers", "1"]) == 0
    said = capsys.readouterr().out
    assert (
        said.splitlines()[0].split() == ["dsps", "n", "misses", "(jobs)"]
        and "2 runs done, 0 refused, 0 failed." in said
    )
    rows = (tmp_path / "runs.csv").read_text().splitlines()
    assert rows[0] == "machine.dsps,seed,status,message,misses" and len(rows) == 3
    assert "machine.dsps" in (tmp_path / "a.svg").read_text()
    assert (tmp_path / "grid" / "sweep.json").exists()
    assert main(["sweep", str(file), "--show", "--metric", "dsps[0].claims"]) == 0
    assert "dsps[0].claims" in capsys.readouterr().out


@pytest.mark.parametrize(("text", "more", "says"), [
    ("# nothing yet\n", [], "grid.toml: the grid is empty"),
    ("[axes]\ndsps = []\n", [], "grid.toml: axes.dsps: the list is empty"),
    ("[axes\n", [], "grid.toml: no TOML"),
    (GRID, ["--plot", "a.txt"], "a.txt: not a picture file"),
    (GRID, ["--csv", "missing/a.csv"], "missing/a.csv: there is no folder"),
    (GRID, ["--csv", "grid.toml"], "grid.toml"),
    (GRID, ["--tls-ca", "ca.pem"], "go with --cluster"),
    (GRID, ["--workers", "0"], "workers"),
    (GRID, ["--show"], "not a folder of a sweep"),
    (GRID, ["--metric", "misess"], '--metric: misess: the report has no such place; did you mean "misses"?'),
    (GRID, ["--metric", "misses", "--metric", "dsps[0].cycels"], 'did you mean "cycles"?'),
    (GRID, ["--metric", ""], "--metric: an empty name"),
    (GRID.partition("[axes]")[0], ["--plot", "a.svg"], "--plot: grid: the sweep has no axes"),
    (GRID + "cycle_time_factor = [1, 2]\nphase_jitter = [false, true]\n", ["--plot", "a.svg"],
     "--plot: grid: besides machine.dsps and machine.cycle_time_factor, run.phase_jitter varies; a sweep over two axes is"),
    (GRID + "cycle_time_factor = [1, 2]\nphase_jitter = [false, true]\nstrict = [true, false]\n", ["--plot", "a.svg"],
     "machine.cycle_time_factor, run.phase_jitter, run.strict vary; a sweep over two axes is expected"),
    (None, [], "grid.toml"),
])  # fmt: skip
def test_what_a_user_can_get_wrong_is_a_sentence_and_loses_nothing(
    text: str | None,
    more: list[str],
    says: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    if text is not None:
        Path("grid.toml").write_text(text)
    before = sorted(tmp_path.iterdir())
    assert main(["sweep", "grid.toml", *more]) == 2
    said = capsys.readouterr()
    assert said.out == "" and said.err.startswith("cmrc sweep: ") and says in said.err
    assert sorted(tmp_path.iterdir()) == before
    if text is not None:
        assert Path("grid.toml").read_text() == text


def test_an_unknown_metric_and_an_empty_grid(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "one.toml").write_text('[fixed]\nduration_s = 0.03\nreport.reference = "none"\n')
    assert main(["sweep", str(tmp_path / "one.toml"), "--workers", "1", "--metric", "tasks.pidd.misses"]) == 2
    assert "tasks.pidd.misses: the report has no such place" in capsys.readouterr().err
    assert main(["sweep", str(tmp_path / "one.toml"), "--show", "--metric", "misses"]) == 0
    assert capsys.readouterr().out.splitlines()[0].split() == ["n", "misses", "(jobs)"]


def test_a_sweep_of_which_every_point_is_refused_has_failed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "none.toml").write_text("[axes]\ndsps = [17, 18]\n[fixed]\nduration_s = 0.03\n")
    for more in ([], ["--show"]):
        assert main(["sweep", str(tmp_path / "none.toml"), "--workers", "1", *more]) == 1
        assert "machine.dsps: 17" in capsys.readouterr().out


def test_limits_and_compare_are_the_functions(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["--set", "duration_s=0.03", "--json", str(tmp_path / "a.json")]
    assert main(["limits", "--dsps-grid", "1:2", *asked]) == 0
    found = cmrc.limits(dsps=[1, 2], duration_s=0.03)
    assert capsys.readouterr().out == found.text and json.loads((tmp_path / "a.json").read_text()) == found.report
    assert main(["compare", *asked]) == 0
    assert capsys.readouterr().out == cmrc.compare(duration_s=0.03).text
    assert "metrics" in json.loads((tmp_path / "a.json").read_text())
    for bad in (
        ["limits", "--dsps-grid", "2:1"],
        ["limits", "--servo", "fast"],
        ["compare", "--set", "dsps"],
        ["limits", "--config", "no.toml"],
    ):
        assert main(bad) == 2
        assert capsys.readouterr().err.startswith(f"cmrc {bad[0]}: ")


NO_NUMBERS = ("1_0", "+2", " 2", "2 ", "\u0662")
"""What Python's own conversions take for a number."""


@pytest.mark.parametrize("text", [*NO_NUMBERS, "2.5", "two"])
def test_a_number_of_workers_is_written_as_other_numbers_are(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from cmrc.results import __main__ as results

    (tmp_path / "grid.toml").write_text(GRID)
    with pytest.raises(SystemExit) as status:
        main(["sweep", str(tmp_path / "grid.toml"), "--workers", text])
    assert status.value.code == 2
    assert "--workers: " in (said := capsys.readouterr().err) and "a whole number is expected" in said
    with pytest.raises(SystemExit):
        results.parser().parse_args(["--jobs", text])
    parsed = results.parser().parse_args(["--dsps", text])
    with pytest.raises(ValueError, match="--dsps: .*; a whole number from 0 on or a list of them is expected"):
        results.chosen(results.CLAIMS[0], parsed)


def test_grids_on_the_command_line() -> None:
    assert numbers("1:3:0.5", "--cycles") == [1.0, 1.5, 2.0, 2.5, 3.0] and numbers("1:3", "--dsps-grid") == [
        1.0,
        2.0,
        3.0,
    ]
    assert numbers("500,2000", "--servo") == [500.0, 2000.0]
    assert numbers("0:0.3:0.1", "--cycles") == [0.0, 0.1, 0.2, 0.3]  # no sums of tenths
    assert numbers("1:1.001:0.0005", "--cycles") == [1.0, 1.0005, 1.001]
    assert len(numbers("1:1000", "--servo")) == 1000
    for bad in ("", "a", "1:2:0", "1:2:3:4", "1::2", "1:1001", *NO_NUMBERS, "9" * 400):
        with pytest.raises(ValueError, match="--cycles"):
            numbers(bad, "--cycles")
    for text, value in (
        ("true", True),
        ("-3", -3),
        ("0x5000", 0x5000),
        ("0.5", 0.5),
        (".5e-3", 5e-4),
        ("-inf", -math.inf),
    ):
        assert setting(f"a={text}")[1] == value and type(setting(f"a={text}")[1]) is type(value)
    for text in ("x=y", "", "0x", "1_0", " 1", "1\n", "+1", "1e", "True"):
        assert setting(f"a={text}")[1] == text


def test_the_status_of_a_search_says_whether_its_answer_holds(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """An optimum has nothing to pass; neither has a bisection without further seeds."""
    given: list[Any] = []
    outcomes: list[Found] = []

    def search(*places: Any, workers: int, **_: Any) -> Found:
        given.append((places, workers))
        return outcomes[-1]

    monkeypatch.setattr("cmrc.sweeps.search", search)
    for best, passed, status in (({"a": 1}, None, 0), ({"a": 1}, True, 0), ({"a": 1}, False, 1), (None, None, 1)):
        outcomes.append(Found("misses", best, 0.0, metrics.spread([]), passed, []))
        assert main(["search", "grid.toml", "--out", "there", "--workers", "3"]) == status, (best, passed)
        assert capsys.readouterr().out == outcomes[-1].text() and given[-1] == (("grid.toml", Path("there")), 3)


def test_a_difference_and_its_status(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    runs = [cmrc.run(dsps=n, duration_s=0.03) for n in (1, 2)]
    for n, run in enumerate(runs):
        run.save(tmp_path / f"{n}")
    asked = ["diff", str(tmp_path / "0"), str(tmp_path / "1")]
    assert main([*asked, "--json", str(tmp_path / "d.json")]) == 1
    assert "machine.dsps: 1 -> 2" in capsys.readouterr().out
    found = json.loads((tmp_path / "d.json").read_text())
    assert found["configuration"] == {"machine.dsps": [1, 2]} and not found["same"]
    assert main(["diff", str(tmp_path / "0"), str(tmp_path / "0")]) == 0
    assert capsys.readouterr().out == "The two results are the same.\n"
    assert main([*asked, "--json", str(tmp_path / "0")]) == 2
    assert not cmrc.diff(tmp_path / "0", runs[0])
    assert main(["diff", str(tmp_path / "0"), str(tmp_path / "none")]) == 2


def test_ctrl_c_ends_a_sweep_with_status_130_and_frees_the_folder(tmp_path: Path) -> None:
    (tmp_path / "grid.toml").write_text(GRID.replace("0.03", "20.0"))
    environment = {**os.environ, "PYTHONPATH": str(BUILD / "python")}
    command = [sys.executable, "-m", "cmrc", "sweep", "grid.toml", "--workers", "1"]
    run = subprocess.Popen(
        command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    deadline = time.monotonic() + 60
    while not (tmp_path / "grid" / "sweep.json").exists() and time.monotonic() < deadline and run.poll() is None:
        time.sleep(0.05)
    time.sleep(1.0)  # somewhere between the cluster's start and the first run
    run.send_signal(signal.SIGINT)
    out, err = run.communicate(timeout=60)
    assert run.returncode == 130 and out == "" and "interrupted" in err and "Traceback" not in err, err
    (tmp_path / "grid.toml").write_text(GRID)
    assert main(["sweep", str(tmp_path / "grid.toml"), "--workers", "1", "--metric", "misses"]) == 0


def test_progress_is_a_line_that_goes_away(monkeypatch: pytest.MonkeyPatch) -> None:
    import io

    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    now = [100.0]
    monkeypatch.setattr("cmrc.progress.time.monotonic", lambda: now[0])
    shown = Terminal()
    with ProgressLine("work", shown) as line:
        for _ in range(24):
            line.of(now[0] - 100, 3.0)
            now[0] += 0.125
    assert shown.getvalue().startswith("\rwork: 1 of 3 s simulated, about 2 s left") and shown.getvalue().endswith(
        " \r"
    )
    shorter = Terminal()
    with ProgressLine("work", shorter) as line:
        line.show("10 of 10", now=True)
        line.show("1 of 1", now=True)
    assert shorter.getvalue().split("\r")[1:3] == [
        "work: 10 of 10",
        "work: 1 of 1  ",
    ]  # nothing is left of the longer one
    log = io.StringIO()
    with ProgressLine("work", log) as line:
        for _ in range(400):
            line.show("on")
            now[0] += 0.1
    assert log.getvalue() == "work: on\n" * 3


def test_a_line_of_progress_is_never_longer_than_its_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else it would be two, and each update would leave one behind."""
    import fcntl
    import os
    import pty
    import struct
    import termios

    try:
        ours, theirs = pty.openpty()
    except OSError:
        pytest.skip("no pseudo-terminals here (a chroot without /dev/pts)")
    monkeypatch.setattr("cmrc.progress.SILENT_S", 0.0)

    def seen(columns: int) -> list[str]:
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        line.of(17.5, 180.0, now=True)
        return os.read(ours, 1000).decode().split("\r")

    with os.fdopen(theirs, "w") as shown:
        with ProgressLine("cmrc sweep", shown) as line:
            wide = len(seen(80)[-1])
            assert wide > 40
            for columns in (20, 40, 80, 7):  # the window's size changes under way
                last = seen(columns)[-1]
                assert len(last) == min(wide, columns - 1) and last.startswith("cmrc s"), (columns, last)
        assert os.read(ours, 1000).decode() == "\r" + " " * 6 + "\r"
    os.close(ours)


def test_work_without_reports_shows_that_it_continues(monkeypatch: pytest.MonkeyPatch) -> None:
    import io
    import threading

    monkeypatch.setattr("cmrc.progress.BEAT_S", 0.001)
    monkeypatch.setattr("cmrc.progress.SILENT_S", 0.0)
    shown = io.StringIO()
    with ProgressLine("work", shown) as line, line.beating():
        while not shown.getvalue():
            threading.Event().wait(0.001)
    assert shown.getvalue().startswith("work: running; 0 s so far")


def test_a_notebook_shows_a_line_that_goes_away_and_begins_again(monkeypatch: pytest.MonkeyPatch) -> None:
    import io

    stream = type("OutStream", (io.StringIO,), {"__module__": "ipykernel.iostream"})()
    now = [100.0]
    monkeypatch.setattr("cmrc.progress.time.monotonic", lambda: now[0])
    monkeypatch.setattr("sys.stderr", stream)
    show = cmrc.show_progress("sweep")
    for done in range(5):
        show(Status(4, done, 0, workers=2, elapsed_s=now[0] - 100, planned=4))
        now[0] += 1.0
    assert "\rsweep: 1 of 4 runs on 2 workers, about 3 s left" in stream.getvalue()
    assert stream.getvalue().endswith(" \r")
    for done in (0.0, 0.5, 1.0):  # a run of its own
        show(done, 1.0)
        now[0] += 1.5
    assert "0.5 of 1 s simulated, about 2 s left" in stream.getvalue() and "\n" not in stream.getvalue()


def test_the_time_that_is_left_is_that_of_runs_which_are_run() -> None:
    """Runs that were there before, or that are refused, took no time."""
    status = Status(12, 8, 3, refused=2, workers=2, elapsed_s=30.0, planned=12)
    assert of_sweep(status) == "8 of 12 runs on 2 workers, about 40 s left"


def test_work_that_begins_again_has_a_line_and_a_beginning_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """The work before was interrupted."""
    import io

    stream = io.StringIO()
    now = [100.0]
    monkeypatch.setattr("cmrc.progress.time.monotonic", lambda: now[0])
    monkeypatch.setattr("sys.stderr", stream)
    show = cmrc.show_progress("run")
    show(0.75, 1.0)
    for done in (0.0, 0.5):
        now[0] += 20.0
        show(done, 1.0)
    assert stream.getvalue() == "run: 0.5 of 1 s simulated, about 20 s left\n"


def test_long_commands_show_something_before_their_first_step_is_done(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("cmrc.progress.BEAT_S", 0.01)
    monkeypatch.setattr("cmrc.progress.SILENT_S", 0.0)
    monkeypatch.setattr("cmrc.progress.LOG_S", 0.0)
    assert main(["limits", "--duration", "0.05", "--dsps-grid", "2"]) == 0
    said = capsys.readouterr().err.splitlines()
    # On a busy machine a sign of life comes before the command knows the number of runs.
    assert said[0].startswith(("cmrc limits: 0 of 1 runs", "cmrc limits: no run has ended yet"))
    assert said[-1].startswith("cmrc limits: 1 of 1 runs")
    assert main(["compare", "--duration", "0.1"]) == 0
    assert " of 0.1 s simulated" in capsys.readouterr().err
