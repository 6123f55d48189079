"""docs/add-a-task.md, done to the letter: its blocks are taken from the page and run. Then what it promises of faulty
tasks."""

import json
import os
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from cmrc import _core
from locations import AT_ONCE, ROOT

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


def run_of(toml: str, **settings: Any) -> Any:
    simulation = cmrc.Simulation(cmrc.config(toml=toml, settings={**AT_ONCE, "report.reference": "none", **settings}))
    simulation.run()
    return simulation


def report_of(toml: str, **settings: Any) -> dict[str, Any]:
    report: dict[str, Any] = json.loads(run_of(toml, **settings).report_json())
    return report


def test_a_task_that_never_returns_is_contained(desk: Path) -> None:
    (desk / "my_programs" / "kernels" / "user.asm").write_text(
        "kernel_sway_watch:\n        br      kernel_sway_watch\n"
    )
    toml = blocks("toml")[0].replace("period_ms = 10", "period_ms = 200")
    report = report_of(toml, duration_s=0.5, **{"watchdog.long_run_us": 1000, "report.reference": "ideal"})
    mine = report["tasks"]["user.sway_watch"]
    assert mine["dropped"] >= 1 and mine["on_time"] == 0
    assert report["tasks"]["error"]["on_time"] >= 1
    assert report["stop_reason"] == "completed"
    assert report["tasks"]["pid"]["released"] == 499  # ticks 1 ms, 2 ms, ... 499 ms
    assert (
        "does not end" in report["reference_problem"] and report["errors"] is None
    )  # nor would it at a thousand times the speed
    assert any(
        "user.sway_watch" in failure["what"] + failure.get("detail", "") for failure in map(flat, report["failures"])
    )


BEATS = """kernel_sway_watch:
        ldi     60, ar2                         ; 60 turns of 0.1 ms
beat_on:
        ldi     2500 - 40, rc
        rpts    rc
        nop
        call    alive
        {more}
        subi    1, ar2
        cmpi    0, ar2
        bgt     beat_on
        ldi     0, r0
        ldi     0, r1
        rets
"""


def test_a_long_task_with_a_heartbeat_is_left_alone_and_found_when_it_hangs(desk: Path) -> None:
    toml = blocks("toml")[0].replace("period_ms = 10", "period_ms = 100\nheartbeat_ms = 0.2")
    program = desk / "my_programs" / "kernels" / "user.asm"
    program.write_text(BEATS.format(more=""))
    # Without the heartbeat 6 ms are twice what the watchdog allows here, 3 x 1 ms.
    report = report_of(toml, duration_s=0.15, **{"watchdog.long_run_us": 1000})
    assert report["tasks"]["user.sway_watch"]["on_time"] == 1 and report["host"]["recomputed"] == 0
    without = report_of(toml.replace("heartbeat_ms = 0.2", ""), duration_s=0.15, **{"watchdog.long_run_us": 1000})
    assert without["host"]["recomputed"] > 0
    # It hangs at its 30th turn, 3 ms after its claim at 100 ms.
    program.write_text(BEATS.format(more="cmpi    30, ar2\n        beq     $"))
    report = report_of(toml, duration_s=0.15)
    first = next(failure for failure in report["failures"] if failure["kind"] == "watchdog")
    assert "user.sway_watch has had no heartbeat" in first["message"] and 0.103 < first["time_s"] < 0.106


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
        (
            "kind = 14",
            "kind = 8",
            "tasks.kind: 8 is a kind of the paper; 3, 4, 9, 10, 14 to 20 or one from 23 on is expected",
        ),
        ("kind = 14", 'kind = "x"', "tasks.kind"),
        ('name = "sway_watch"', "", "tasks.name: is missing"),
        ("period_ms = 10", "period_ms = 0", 'tasks.period_ms: nothing releases "sway_watch"'),
        ("period_ms = 10", "period_ms = 0.001", "tasks.period_ms: 0.001 is out of range"),
        (
            "period_ms = 10",
            "period_ms = 0.3",
            (
                'tasks.period_ms: 0.3 ms of "sway_watch" are 2.4 refreshes: a task is released at a refresh, every 0.125 ms; '
                "0.25 or 0.375 is expected, or another rates.refresh_frequency_hz"
            ),
        ),
        (
            "period_ms = 10",
            "period_ms = 0.05",
            "0.125 is the shortest period, or more rates.refresh_frequency_hz is expected",
        ),
        (
            "parameter_0",
            "parameter_1",
            "tasks.parameter_1: is given without parameter_0; parameter_0, parameter_1, ... without a gap are expected",
        ),
        (
            "parameter_0 = 0.02",
            "\n".join(f"parameter_{n} = {n}" for n in range(33)),
            "tasks.parameter_32: no such parameter; at most 32 are expected, parameter_0 to parameter_31",
        ),
        ("parameter_0", "parameter_00", "tasks.parameter_00: no such parameter; at most 32 are expected"),
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
    """As docs/processes.md has it: once per point interval (8 ms) of the crane, while process 3 runs (from 2.4 ms
    on)."""
    page = (ROOT / "docs" / "processes.md").read_text()
    row, with_it = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)[1:3]
    grab = re.search(
        r"\[\[processes\]\]\nnumber = 3.*?\n\n",
        (ROOT / "emulator" / "cmrc" / "configuration" / "rows" / "processes.toml").read_text(),
        re.DOTALL,
    )
    assert grab is not None
    built_in = re.sub(r" +#.*", "", grab[0])
    assert with_it.strip() == built_in.replace("[1, 2, 3, 4]", "[1, 2, 3, 4, 6]").strip()
    tasks = blocks("toml")[0].replace("period_ms = 10", "period_ms = 0")
    assert report_of(tasks + row + with_it, duration_s=0.1)["tasks"]["user.sway_watch"]["on_time"] == 12
    assert report_of(tasks + row, duration_s=0.1)["tasks"]["user.sway_watch"]["released"] == 0


def test_a_task_can_be_a_step(desk: Path) -> None:
    tasks = blocks("toml")[0].replace("period_ms = 10", "period_ms = 0")
    steps = '[[processes]]\nnumber = 9\nname = "look"\nrobot = "none"\nsteps = ["task user.sway_watch", "task user.sway_watch"]\nloaded = true\n'
    row = report_of(tasks + steps, duration_s=0.05)["tasks"]["user.sway_watch"]
    assert (row["released"], row["on_time"]) == (2, 2)
    # With another task before it, its area is the second one; SW_RUNS is word 9.
    head, second = tasks.split("[[tasks]]")
    first = (
        second.replace("sway_watch", "before", 1).replace("kind = 14", "kind = 15").replace("_ms = 0", "_ms = 10", 1)
    )
    both = f"{head}[[tasks]]{first}\n[[tasks]]{second}"
    simulation = run_of(both + steps, duration_s=0.05)
    areas = [simulation.symbol("US_BASE") + task * simulation.symbol("US_WORDS") for task in (0, 1)]
    assert [simulation.peek(area + 9) for area in areas] == [4, 2]


# ---- tasks that do what they must not: contained, reported, survived by the rest

KEEPS_TO_ITSELF = {
    "pid",
    "torque_compensation",
    "trajectory_planning.crane",
    "inverse_kinematics.crane",
    "identify",
    "grab_path",
}


def sabotage(desk: Path, body: str, **settings: Any) -> dict[str, Any]:
    (desk / "my_programs" / "kernels" / "user.asm").write_text(
        f"kernel_sway_watch:\n{body}        ldi     0, r0\n        ldi     0, r1\n        rets\n"
    )
    report = report_of(blocks("toml")[0].replace("parameter_0 = 0.02\n", ""), duration_s=0.3, dsps=3, **settings)
    assert report["stop_reason"] == "completed"
    assert report["audit"]["violations"] == []
    return report


def others_are_well(report: dict[str, Any]) -> None:
    for kind in KEEPS_TO_ITSELF:
        assert report["tasks"][kind]["misses"] == 0, kind
    assert max(report["pid_error"][joint]["peak"] for joint in report["pid_error"]) < 1e-3


# Words of others: the whole list, the crane's area with PID's state, AGV 0's; 4000 words from there on.
# In the list it may write two words, result and notify of its own block.
@pytest.mark.parametrize(
    ("first", "words", "own"),
    [("LIST_WORK_POINTER", 0x440, 3), ("CR_BASE", 0x200, 0), ("AG_BASE", 0x100, 0), ("US_BASE + US_WORDS", 4000, 0)],
)
def test_writes_outside_the_area_are_refused_and_reported(desk: Path, first: str, words: int, own: int) -> None:
    body = f"""        ldhi    hi16(WINDOW_A + {first}), ar0
        or      lo16(WINDOW_A + {first}), ar0
        ldhi    0DEADh, r0
        ldi     {words - 1}, rc
        rptb    sabotage_end
sabotage_end:
        sti     r0, *ar0++
"""
    report = sabotage(desk, body)
    others_are_well(report)
    mine = report["tasks"]["user.sway_watch"]
    guarded = [failure for failure in report["failures"] if failure["kind"] == "guard"]
    assert guarded and all(
        "user.sway_watch wrote" in failure["message"] and "the first DEAD0000h at offset" in failure["message"]
        for failure in guarded
    )
    assert sum(int(re.search(r"wrote (\d+) words", failure["message"])[1]) for failure in guarded) == mine[
        "on_time"
    ] * (words - own)
    assert mine["released"] == mine["on_time"] == 29


def test_without_the_guard_the_list_is_spoilt(desk: Path) -> None:
    """What the guard is for: the same task on a board that takes every write."""
    body = """        ldhi    hi16(WINDOW_A + CR_BASE), ar0
        or      lo16(WINDOW_A + CR_BASE), ar0
        ldhi    0DEADh, r0
        ldi     1FFh, rc
        rptb    sabotage_end
sabotage_end:
        sti     r0, *ar0++
"""
    report = sabotage(desk, body, **{"machine.guard": False})
    assert not [failure for failure in report["failures"] if failure["kind"] == "guard"]
    assert max(report["pid_error"][joint]["peak"] for joint in report["pid_error"]) > 1e-3 or any(
        report["tasks"][kind]["misses"] for kind in KEEPS_TO_ITSELF
    )


def test_a_task_that_spoils_its_dsps_own_program_costs_only_resets(desk: Path) -> None:
    """It overwrites the executive and the kernels in local memory: the DSP runs wild, is found by the watchdog, booted
    again; the block is dropped at last."""
    body = """        ldhi    30h, ar0
        ldhi    6000h, r0
        ldi     3FFFh, rc
        rptb    sabotage_end
sabotage_end:
        sti     r0, *ar0++
"""
    report = sabotage(desk, body, **{"watchdog.long_run_us": 3000, "watchdog.retries_max": 1})
    assert report["tasks"]["user.sway_watch"]["on_time"] == 0
    assert sum(dsp["resets"] for dsp in report["dsps"]) >= 3
    assert any(
        failure["kind"] == "stopped" and "user.sway_watch" in failure["message"] for failure in report["failures"]
    )
    assert report["tasks"]["pid"]["on_time"] > 280
    assert max(report["pid_error"][joint]["peak"] for joint in report["pid_error"]) < 1e-3


def test_a_task_that_touches_an_address_with_nothing_behind_it_stops_its_dsp(desk: Path) -> None:
    body = """        ldhi    hi16(WINDOW_B + 0FFF0h), ar0
        or      lo16(WINDOW_B + 0FFF0h), ar0
        sti     r0, *ar0
"""
    report = sabotage(desk, body, **{"watchdog.long_run_us": 3000, "watchdog.retries_max": 0})
    faults = [failure for failure in report["failures"] if failure["kind"] == "fault"]
    assert faults and all("7000FFF0h" in failure["message"] and "PC 0030" in failure["message"] for failure in faults)
    assert report["tasks"]["user.sway_watch"]["dropped"] >= 1
    assert report["tasks"]["pid"]["on_time"] > 280


def test_a_period_is_kept_to_the_refresh_or_refused(desk: Path) -> None:
    """Of 3000 refreshes in a second two last 0.666667 ms: the digits that one writes are enough."""
    toml = blocks("toml")[0].replace("deadline_ms = 10", "deadline_ms = 0")
    thirds = {"rates.refresh_frequency_hz": 3000, "rates.servo_frequency_hz": 750, "scheduling.alpha_refreshes": 6}
    for written, at_rates in {"0.625": {}, "0.666667": thirds, "0.6666666666666666": thirds}.items():
        report = report_of(toml.replace("period_ms = 10", f"period_ms = {written}"), duration_s=0.1, dsps=3, **at_rates)
        mine = report["tasks"]["user.sway_watch"]
        assert mine["released"] == pytest.approx(0.1 / (float(written) * 1e-3), abs=1) and mine["dropped"] == 0, written
    with pytest.raises(cmrc.ConfigError, match=r"0.6666666666666666 or 1.0 is expected"):
        cmrc.config(toml=toml.replace("period_ms = 10", "period_ms = 0.7"), settings=thirds)


def test_a_deadline_is_judged_as_it_is_written_between_refreshes(desk: Path) -> None:
    """A deadline that every block needs longer for; then one between the fastest and the slowest response."""
    toml = blocks("toml")[0].replace("period_ms = 10", "period_ms = 1")
    report = report_of(toml.replace("deadline_ms = 10", "deadline_ms = 0.001"), duration_s=0.1, dsps=3)
    mine = report["tasks"]["user.sway_watch"]
    assert (mine["on_time"], mine["late"]) == (0, mine["released"]) and mine["late"] > 90
    own = [miss for miss in report["misses"] if miss["kind"] == "user.sway_watch"]
    assert {miss["deadline_ps"] - miss["release_ps"] for miss in own} == {1_000_000}
    fastest, slowest = mine["response_ps"]["best"], mine["response_ps"]["worst"]
    assert 1_000_000 < fastest < slowest and slowest % 125_000_000 != 0
    shares = {slowest: (1, 1), slowest - 1: (0.01, 0.999), fastest: (0.01, 0.999), fastest - 1: (0, 0)}
    for allowed, (least, most) in shares.items():
        again = report_of(toml.replace("deadline_ms = 10", f"deadline_ms = {allowed * 1e-9!r}"), duration_s=0.1, dsps=3)
        mine = again["tasks"]["user.sway_watch"]
        assert mine["response_ps"]["worst"] == slowest, "a deadline changes nothing in the run"
        assert least <= mine["on_time"] / mine["released"] <= most, allowed


def test_a_task_that_overruns_is_reported_as_late_and_delays_no_other_with_a_dsp_to_spare(desk: Path) -> None:
    body = """        ldhi    1, rc                           ; 65 537 turns of a cycle and more: 2.6 ms, deadline 1 ms
        rptb    sabotage_end
sabotage_end:
        nop
"""
    (desk / "my_programs" / "kernels" / "user.asm").write_text(
        f"kernel_sway_watch:\n{body}        ldi     0, r0\n        ldi     0, r1\n        rets\n"
    )
    report = report_of(blocks("toml")[0].replace("deadline_ms = 10", "deadline_ms = 1"), duration_s=0.2, dsps=3)
    mine = report["tasks"]["user.sway_watch"]
    assert (mine["released"], mine["on_time"]) == (19, 0)
    assert mine["late"] == 19
    assert report["tasks"]["pid"]["misses"] == 0
