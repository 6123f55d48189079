"""Runs that share a beginning: run once per worker, and the same results as whole runs, to the last bit."""

from pathlib import Path
from typing import Any

import cmrc
import pytest
from cmrc import _core
from cmrc.sweeps import GridError, grid, sweep, work
from cmrc.sweeps.identity import Keys, run_of

pytest.importorskip("distributed")
pytest.importorskip("pyarrow")

AT_S = 0.06
FUTURES: list[dict[str, Any]] = [
    {"name": "nothing happens"},
    {"name": "DSP 1 dies", "events": [{"at_s": AT_S, "action": "fail", "dsp": 1}]},
    {
        "name": "DSP 1 comes back",
        "events": [{"at_s": 0.08, "action": "plug", "dsp": 1}, {"at_s": 0.07, "action": "unplug", "dsp": 1}],
    },
    {"name": "p rises", "events": [{"at_s": 0.07, "action": "set", "key": "scheduling.p", "value": 0x5000}]},
    {"name": "a drive fails", "events": [{"at_s": 0.07, "action": "fail_drive", "joint": "slew"}]},
]
GRID: dict[str, Any] = {
    "fixed": {"duration_s": 0.1, "phase_jitter": True},
    "axes": {"dsps": [2, 3]},
    "events": [{"at_s": 0.05, "action": "pause_host", "lasts_ms": 0.3}],
    "futures": FUTURES,
}
FORKED = {**GRID, "fork": {"at_s": AT_S}}


def test_a_forked_sweep_gives_the_hashes_and_reports_of_whole_runs(tmp_path: Path) -> None:
    forked = sweep(FORKED, tmp_path / "forked", workers=1)
    assert forked.counts() == {"done": 10, "refused": 0, "failed": 0} and forked.axes == ["machine.dsps", "future"]
    hashes = set()
    for future in FUTURES:
        events = [*future.get("events", []), *GRID["events"]]
        whole = cmrc.run(dsps=3, settings=GRID["fixed"], events=events)
        kept = forked.report(dsps=3, future=future["name"])
        assert kept["hash"] == whole.hash
        assert not cmrc.diff(kept, whole)
        hashes.add(whole.hash)
    assert len(hashes) == len(FUTURES)
    again = sweep(GRID, tmp_path / "forked", workers=1)  # whole runs have the same keys: nothing is to be run
    assert len(again) == 10 and len(list(again.folder.rows())) == 10


def test_the_beginning_is_run_once(monkeypatch: pytest.MonkeyPatch) -> None:
    made = []
    simulation = _core.cmrc.Simulation

    def counted(config: Any, *more: Any) -> Any:
        made.append(simulation(config, *more))
        return made[-1]

    monkeypatch.setattr(work, "_beginnings", {})
    monkeypatch.setattr(work, "_references", {})
    monkeypatch.setattr(work._core.cmrc, "Simulation", counted)
    points = [point for point in grid.made(FORKED).points() if point.settings["machine.dsps"] == 2]
    execute = work.Forked(AT_S)
    answers = []
    for point in points:
        run = run_of(point, Keys(), AT_S)
        answers.append(execute(run.key, run.toml()))
    assert [answer["status"] for answer in answers] == ["done"] * 5
    assert len(made) == 1 and made[0].time_s == AT_S


def test_a_run_that_ends_before_the_fork_is_a_whole_run() -> None:
    late = {**FORKED, "fork": {"at_s": 0.2}, "futures": [{"name": "a"}, {"name": "b", "events": []}]}
    [first, *_] = grid.made(late).points()
    run = run_of(first, Keys(), 0.2)
    answer = work.Forked(0.2)(run.key, run.toml())
    assert answer["status"] == "done" and answer["hash"] == work.execute(run.key, run.toml())["hash"]


def test_runs_that_begin_alike_are_neighbours() -> None:
    groups = [run_of(point, Keys(), AT_S).group for point in grid.made(FORKED).points()]
    assert len({group[:64] for group in groups}) == 2  # two numbers of DSPs
    assert len(set(groups)) == 2 * 3  # failures of the machine share an ideal run, the other two have their own


@pytest.mark.parametrize(("change", "says"), [
    ({"fork": {"at_s": 0.065}}, "futures[1].events[0].at_s: 0.06 s is before fork.at_s, 0.065 s"),
    ({"fork": {"at_s": 0}}, "fork.at_s: an instant"),
    ({"fork": {}}, "fork.at_s: an instant"),
    ({"fork": {"at_s": "x"}}, "fork.at_s: an instant"),
    ({"fork": {"at_s": 10**400}}, "fork.at_s: an instant"),
    ({"fork": {"at_s": float("inf")}}, "fork.at_s: an instant"),
    ({"fork": {"at": 1}}, "fork.at: unknown; at_s is known"),
    ({"futures": []}, "fork: only runs that differ by [[futures]] can share their beginnings"),
    ({"futures": [{"name": "a"}]}, "at least two futures are expected"),
    ({"futures": [{"name": "a"}, {"name": "a"}]}, "futures[1].name: 'a' is given twice"),
    ({"futures": [{"events": []}]}, "futures[0].name: a name for this future"),
    ({"futures": [{"name": "a", "event": []}]}, "futures[0].event: unknown"),
    ({"futures": [{"name": "a", "events": 3}]}, "futures[0].events: a list of tables"),
    ({"futures": {"a": 1}}, "futures: a list of tables is expected, [[futures]]"),
    ({"axes": {"future": ["a"]}}, "axes.future: no such key; "),
])  # fmt: skip
def test_a_bad_fork_says_where_and_what_would_be_right(change: dict[str, Any], says: str) -> None:
    with pytest.raises(GridError) as error:
        grid.made({**FORKED, **change}, name="bad.toml")
    assert str(error.value).startswith("bad.toml: ") and says in str(error.value)


def test_a_fork_into_another_run_is_refused() -> None:
    config = _core.cmrc.config(settings={"run.duration_s": 0.1})
    beginning = _core.cmrc.Simulation(config)
    beginning.run_until(0.05)
    for other, says in (
        (
            {"settings": {"run.duration_s": 0.1, "machine.dsps": 2}},
            "begins differently: .machine. dsps = 2, here dsps = 4",
        ),
        (
            {"settings": {"run.duration_s": 0.1}, "events": [{"at_s": 0.04, "action": "fail", "dsp": 1}]},
            "begins differently",
        ),
    ):
        with pytest.raises(cmrc.ConfigError, match=says):
            beginning.fork_into(_core.cmrc.config(**other))
    with pytest.raises(cmrc.ConfigError, match="ideal run of another configuration"):
        reference = _core.cmrc.Simulation(_core.cmrc.config(settings={"run.duration_s": 0.06}))
        reference.run()
        beginning.fork_into(config, reference.reference())
    beginning.run()
    with pytest.raises(cmrc.ConfigError, match="has ended at 0.1 s"):
        beginning.fork_into(config)
