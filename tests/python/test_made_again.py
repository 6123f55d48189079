"""The run of a report can be made again, with its events, tasks and processes."""

import json
import shutil
import subprocess
from pathlib import Path

import cmrc
import pytest
from locations import BUILD, ROOT

TASK = (ROOT / "docs" / "add-a-task.md").read_text(encoding="utf-8")
EVENTS = """
[[events]]
at_s = 0.05
action = "fail"
dsp = 0
[[events]]
at_s = 0.06
action = "set"
key = "scheduling.p"
value = 0x5000
"""
ROWS = """
[[subprocesses]]
number = 6
name = "watch the load"
crane = "user.sway_watch"
release = "interval"
[[processes]]
number = 3
name = "grab"
robot = "crane"
account = "t_3"
subprocesses = [1, 2, 3, 4, 6]
steps = ["leg 1", "settle", "lower", "lock", "raise", "leg 2", "settle"]
must = [1]
may = [4]
initial = [4]
clears = ["4->7", "4->8"]
"""


def block(text: str, language: str) -> str:
    return text.partition(f"```{language}\n")[2].partition("```")[0]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    shutil.copytree(ROOT / "c40_programs", tmp_path / "my_programs")
    (tmp_path / "my_programs" / "kernels" / "user.asm").write_text(block(TASK, "asm"))
    (tmp_path / "events.toml").write_text(EVENTS)
    (tmp_path / "tasks.toml").write_text(block(TASK, "toml"))
    (tmp_path / "all.toml").write_text(block(TASK, "toml").replace("period_ms = 10", "period_ms = 0") + ROWS + EVENTS)
    return tmp_path


@pytest.mark.parametrize("name", ["events", "tasks", "all"])
def test_the_run_of_a_report_is_made_again(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    first = cmrc.run(2, 0.1, config=f"{name}.toml", settings={"report.reference": "none"}, seed=5)
    report = json.loads(json.dumps(first.report))
    plain = cmrc.run(2, 0.1, settings={"report.reference": "none"}, seed=5)
    assert first.hash != plain.hash
    again = cmrc.run(config=report)
    assert again.hash == first.hash and not first.diff(again)
    assert again.report["configuration_toml"] == first.report["configuration_toml"]
    other = cmrc.run(config=report, dsps=3)
    assert other.hash != first.hash and other.report["configuration"]["run.seed"] == 5
    (folder / "again.toml").write_text(report["configuration_toml"])
    command = [BUILD / "bin" / "emulator", "--config", "again.toml", "--quiet", "--report", "r.json"]
    subprocess.run(command, cwd=folder, check=True)
    assert json.loads((folder / "r.json").read_text())["hash"] == first.hash


def test_a_report_without_it_is_refused_and_its_reader_is_told(tmp_path: Path) -> None:
    report = cmrc.run(2, 0.03, settings={"report.reference": "none"}).report
    old = {key: value for key, value in report.items() if key != "configuration_toml"}
    with pytest.raises(cmrc.ConfigError, match='config: a dictionary without "configuration_toml"; the path of a TOML'):
        cmrc.run(config=old)
    for found, says in (
        ({**report, "schema_version": 3}, "cmrc.run(config=report)"),
        ({**old, "schema_version": 3}, "with its events, tasks and processes, which are not in the report"),
    ):
        (tmp_path / "r.json").write_text(json.dumps(found))
        with pytest.raises(cmrc.Error) as error:
            cmrc.diff(tmp_path / "r.json", report)
        assert says in str(error.value)
