"""A sweep names its runs for good: after a change of the working folder, and of the files that it was made from."""

import shutil
from pathlib import Path

import pytest
from cmrc.simulation import configured
from cmrc.sweeps import Sweep, SweepError, sweep, work

pytest.importorskip("distributed")
pytest.importorskip("pyarrow")

BASE = '[run]\nduration_s = 0.03\n[report]\nreference = "none"\n[machine]\ndsps = {}\n'
GRID = {"fixed": {"config": "base.toml"}, "axes": {"servo_frequency_hz": [500.0, 1000.0]}}


@pytest.fixture
def done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Sweep:
    for name, dsps in (("a", 1), ("b", 4)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "base.toml").write_text(BASE.format(dsps))
    monkeypatch.chdir(tmp_path / "a")
    found = sweep(GRID, "out", workers=1)
    monkeypatch.chdir(tmp_path / "b")
    return found


def test_after_a_change_of_the_working_folder_the_numbers_stay(done: Sweep, tmp_path: Path) -> None:
    kept = Sweep(tmp_path / "a" / "out")
    assert done.text() == kept.text() and list(done.table("misses")["misses"]) == list(kept.table("misses")["misses"])
    assert done.report(servo_frequency_hz=1000)["hash"] == done.runs[1]["hash"]
    for found in (done, kept):
        for run in found.runs:
            again = found.rerun(run)
            assert again.hash == run["hash"] and len(again.report["dsps"]) == 1


def test_a_run_whose_file_was_changed_is_not_run_again(done: Sweep, tmp_path: Path) -> None:
    (tmp_path / "a" / "base.toml").write_text(BASE.format(3))
    with pytest.raises(SweepError, match="the run .* would not be the same again: a file that its settings name"):
        done.rerun(done.runs[0])
    with pytest.raises(SweepError, match="would not be the same again"):
        done.rerun(done.runs[0], keep_events=True)
    assert len(done.rerun(done.runs[0], dsps=2).report["dsps"]) == 2  # another run, asked for


def test_a_relative_file_of_another_folder_is_not_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, y in (("a", 24.0), ("b", 24.5)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "own.toml").write_text(f"[[containers]]\nx_m = 0.0\ny_m = {y}\n")
    monkeypatch.chdir(tmp_path / "a")
    fixed = {"duration_s": 0.03, "report.reference": "none", "dock.layout": "own.toml"}
    found = sweep({"fixed": fixed}, "out", workers=1)
    assert found.rerun(found.runs[0]).hash == found.runs[0]["hash"]
    monkeypatch.chdir(tmp_path / "b")
    with pytest.raises(SweepError, match="another one from this working folder"):
        found.rerun(found.runs[0])


def test_a_worker_without_the_files_of_a_run_says_so(tmp_path: Path) -> None:
    toml = configured(None, None, {"machine.programs": str(tmp_path / "none")}, (), {}).to_toml()
    with pytest.raises(RuntimeError, match="the run's files cannot be read here: .*none/dsp.asm is not there"):
        work.execute("0" * 64, toml)


def test_a_folder_that_has_lost_its_runs_is_an_error(done: Sweep) -> None:
    shutil.rmtree(done.folder.path)
    for call in (
        lambda: done.table("misses"),
        lambda: done.text(),
        lambda: done.summary(),
        lambda: done.report(servo_frequency_hz=1000),
        lambda: list(done.reports()),
    ):
        with pytest.raises(SweepError, match="2 of its runs are not there any more"):
            call()


def test_the_events_that_are_given_are_a_copy(tmp_path: Path) -> None:
    grid = {
        "fixed": {"duration_s": 0.03, "report.reference": "none"},
        "events": [{"at_s": 0.02, "action": "fail", "dsp": 1}],
    }
    found = sweep(grid, tmp_path / "s", workers=1)
    found.runs[0]["settings"]["events"][0]["dsp"] = 2
    found.runs[0]["settings"]["events"].clear()
    assert found.runs[0]["settings"]["events"] == [{"at_s": 0.02, "action": "fail", "dsp": 1}]
    assert found.rerun(found.runs[0]).hash == found.runs[0]["hash"]
