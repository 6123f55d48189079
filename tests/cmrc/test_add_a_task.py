"""docs/add-a-task.md, done to the letter: its blocks are taken from the page and run. Then what it promises of faulty tasks."""

import json
import os
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from cmrc import _core
from locations import ROOT

cmrc = _core.cmrc
PAGE = (ROOT / "docs" / "add-a-task.md").read_text()


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


@pytest.fixture
def desk(tmp_path: Path) -> Path:
    """A directory with what the page tells to write."""
    shutil.copytree(ROOT / "c40_programs", tmp_path / "my_programs")
    (tmp_path / "my_programs" / "kernels" / "user.asm").write_text(blocks("asm")[0])
    (tmp_path / "my_tasks.toml").write_text(blocks("toml")[0])
    before = Path.cwd()
    os.chdir(tmp_path)
    yield tmp_path
    os.chdir(before)


def test_the_page_works_as_it_stands(desk: Path) -> None:
    run, reference = blocks("python")
    exec(compile(run, "add-a-task.md: running it", "exec"), {})  # noqa: S102 - what the page shows is what is tested
    exec(compile(reference, "add-a-task.md: a reference test", "exec"), {})  # noqa: S102


def report_of(toml: str, **settings: Any) -> dict[str, Any]:
    simulation = cmrc.Simulation(cmrc.config(toml=toml, settings=settings))
    simulation.run()
    report: dict[str, Any] = json.loads(simulation.report_json())
    return report


def test_a_task_that_never_returns_is_contained(desk: Path) -> None:
    (desk / "my_programs" / "kernels" / "user.asm").write_text("kernel_sway_watch:\n        br      kernel_sway_watch\n")
    toml = blocks("toml")[0].replace("period_ms = 10", "period_ms = 200")
    report = report_of(toml, duration_s=0.5, **{"watchdog.long_run_us": 1000})
    mine = report["tasks"]["user.sway_watch"]
    assert mine["dropped"] >= 1 and mine["on_time"] == 0
    assert report["tasks"]["error"]["on_time"] >= 1
    assert report["stop_reason"] == "completed"
    assert report["tasks"]["pid"]["released"] == 500
    assert any("user.sway_watch" in failure["what"] + failure.get("detail", "") for failure in map(flat, report["failures"]))


def flat(failure: dict[str, Any]) -> dict[str, str]:
    return {"what": " ".join(str(v) for v in failure.values()), "detail": ""}


def test_importance_row_decides_between_waiting_and_due(desk: Path) -> None:
    """Before it is due its J is importance_waiting, and 0 of that keeps it out of the DSPs' hands."""
    toml = blocks("toml")[0].replace("importance_waiting = 0x1000", "importance_waiting = 0")
    report = report_of(toml, duration_s=0.3)
    waiting = report["tasks"]["user.sway_watch"]["waiting_ps"]
    assert 4.8e9 < waiting["best"] and waiting["worst"] < 5.5e9  # 40 refreshes of 125 us


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("kind = 14", "kind = 8", "tasks.kind: 8 is one of the paper's own"),
        ("kind = 14", 'kind = "x"', "tasks.kind"),
        ('name = "sway_watch"', "", "tasks.name: is missing"),
        ("period_ms = 10", "period_ms = 0", 'tasks.period_ms: nobody releases "sway_watch"'),
        ("period_ms = 10", "period_ms = 0.001", "tasks.period_ms: 0.001 is out of range"),
        ("parameter_0", "parameter_1", "parameter"),
        ("deadline_ms", "deadlin_ms", "tasks.deadlin_ms: no such field"),
    ],
)
def test_bad_rows_are_refused_with_their_place(old: str, new: str, says: str) -> None:
    with pytest.raises(cmrc.ConfigError, match=re.escape(says)) as error:
        cmrc.config(toml=blocks("toml")[0].replace(old, new), name="my.toml")
    assert str(error.value).startswith("my.toml:")


def test_an_unknown_program_is_named(desk: Path) -> None:
    with pytest.raises(cmrc.ConfigError, match="no label kernel_other"):
        cmrc.Simulation(cmrc.config(toml=blocks("toml")[0].replace("kernel_sway_watch", "kernel_other")))


def test_rows_are_written_back() -> None:
    config = cmrc.config(toml=blocks("toml")[0])
    assert cmrc.config(toml=config.to_toml()).to_toml() == config.to_toml()


def test_a_sub_process_of_ones_own_runs_where_its_process_lists_it(desk: Path) -> None:
    """As docs/processes.md has it: once per point interval (8 ms) of the crane, while process 3 runs (from 2.4 ms on)."""
    row = re.findall(r"```toml\n(.*?)```", (ROOT / "docs" / "processes.md").read_text(), re.DOTALL)[1]
    grab = re.search(r"\[\[processes\]\]\nnumber = 3.*?\n\n", (ROOT / "emulator" / "cmrc" / "processes.toml").read_text(), re.DOTALL)
    assert grab is not None
    tasks = blocks("toml")[0].replace("period_ms = 10", "period_ms = 0")
    with_it = grab[0].replace("[1, 2, 3, 4]", "[1, 2, 3, 4, 6]")
    assert report_of(tasks + row + with_it, duration_s=0.1)["tasks"]["user.sway_watch"]["on_time"] == 12
    assert report_of(tasks + row, duration_s=0.1)["tasks"]["user.sway_watch"]["released"] == 0


def test_a_task_can_be_a_step(desk: Path) -> None:
    tasks = blocks("toml")[0].replace("period_ms = 10", "period_ms = 0")
    steps = '[[processes]]\nnumber = 9\nname = "look"\nrobot = "none"\nsteps = ["task user.sway_watch", "task user.sway_watch"]\nloaded = true\n'
    row = report_of(tasks + steps, duration_s=0.05)["tasks"]["user.sway_watch"]
    assert (row["released"], row["on_time"]) == (2, 2)
