"""What a folder alone says of the points that it was filled from: those that were refused before, and those that are
one run."""

import json
from pathlib import Path
from typing import Any

import pytest
from cmrc import _core
from cmrc.sweeps import Status, Sweep, session, store, sweep
from cmrc.sweeps.store import Folder

pytest.importorskip("distributed")
pytest.importorskip("pyarrow")
pytestmark = pytest.mark.usefixtures("one_worker")

FIXED = {"duration_s": 0.03, "report.reference": "none"}


def test_a_file_that_is_missing_is_not_an_empty_one(tmp_path: Path) -> None:
    for key in ("dock.layout", "machine.board"):
        config = _core.cmrc.config(settings={key: str(tmp_path / "my.toml")})
        with pytest.raises(_core.cmrc.ConfigError, match="my.toml: cannot be read"):
            _core.cmrc.inputs_digest(config)
    (tmp_path / "my.toml").touch()
    assert len(_core.cmrc.inputs_digest(config)) == 64


def test_a_refused_point_is_made_again_and_its_refusal_does_not_stay(tmp_path: Path) -> None:
    layout = tmp_path / "my.toml"
    grid = {"fixed": {**FIXED, "dock.layout": str(layout)}, "axes": {"dsps": [1, 2]}}
    other = {"fixed": FIXED, "axes": {"dsps": [17]}}  # of another grid, and not allowed

    def counts() -> dict[str, int]:
        return Sweep(tmp_path / "s").counts()

    sweep(other, tmp_path / "s", workers=1)
    missing = sweep(grid, tmp_path / "s", workers=1)
    assert missing.counts() == {"done": 0, "refused": 2, "failed": 0}
    assert all("my.toml: cannot be read" in run["message"] for run in missing.runs)
    layout.write_text("[wrong")
    wrong = sweep(grid, tmp_path / "s", workers=1)
    assert all("my.toml:1" in run["message"] for run in wrong.runs)
    assert counts() == {"done": 0, "refused": 3, "failed": 0}
    layout.write_text("")  # an empty layout is the usual one
    turned = {"axes": {"dsps": [1, 2]}, "fixed": {"dock.layout": str(layout), **FIXED}}  # the same points
    assert sweep(turned, tmp_path / "s", workers=1).counts() == {"done": 2, "refused": 0, "failed": 0}
    assert counts() == {"done": 2, "refused": 1, "failed": 0}


def test_points_that_are_not_allowed_are_refused_again_without_a_new_part(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    grid = {"fixed": FIXED, "axes": {"dsps": [2, 17]}}
    sweep(grid, tmp_path / "s", workers=1)
    before = Folder(tmp_path / "s").parts()
    monkeypatch.setattr(session, "cluster_of", None)
    seen: list[Status] = []
    again = sweep(grid, tmp_path / "s", workers=1, on_progress=seen.append)
    assert again.counts() == {"done": 1, "refused": 1, "failed": 0} and Folder(tmp_path / "s").parts() == before


def test_a_run_that_was_refused_on_its_worker_is_run_again(tmp_path: Path) -> None:
    """What the making of a run shows may depend on more than its configuration and files."""
    grid: dict[str, Any] = {"fixed": FIXED}
    [run] = sweep(grid, tmp_path / "s", workers=1).runs
    with Folder(tmp_path / "s") as folder:
        [row] = folder.rows()
        folder.drop(lambda _: True)
        folder.write([{**row, "status": store.REFUSED, "message": "not here", "hash": None, "report": None}])
    [again] = sweep(grid, tmp_path / "s", workers=1).runs
    assert again["status"] == "done" and again["hash"] == run["hash"]
    assert len(Sweep(tmp_path / "s")) == 1


FAILS = [{"at_s": 0.025, "action": "fail", "dsp": 0}]
THREE = {"fixed": FIXED, "futures": [{"name": "nothing"}, {"name": "control"}, {"name": "fails", "events": FAILS}]}


def test_points_that_are_one_run_are_all_in_the_folder(tmp_path: Path) -> None:
    made = sweep(THREE, tmp_path / "s", workers=1)
    kept = Sweep(tmp_path / "s")
    assert kept.counts() == made.counts() == {"done": 3, "refused": 0, "failed": 0}
    assert {run["place"]["future"] for run in kept.runs} == {"nothing", "control", "fails"}
    assert kept.report(future="control")["hash"] == kept.report(future="nothing")["hash"]
    assert kept.report(future="control")["hash"] != kept.report(future="fails")["hash"]
    assert sorted(kept.text().splitlines()) == sorted(made.text().splitlines())
    assert len(list(kept.reports())) == 3 and kept.table("misses").rows == 3
    control = next(run for run in kept.runs if run["place"]["future"] == "control")
    assert kept.rerun(control).hash == control["hash"]
    reports = [row["report"] for row in Folder(tmp_path / "s").rows(("report",))]
    assert sorted(report is None for report in reports) == [False, False, True]  # each once


def test_a_point_of_several_grids_is_there_once(tmp_path: Path) -> None:
    grids: list[dict[str, Any]] = [
        {"fixed": FIXED, "axes": {"turn_order": [1, 2]}},
        {"fixed": FIXED, "axes": {"turn_order": [1, 2], "dsps": [2, 4]}},  # 4 is the default
        {"fixed": FIXED, "axes": {"turn_order": [1, 2, 3], "dsps": [4]}},
    ]
    for grid in grids:
        assert [spread.n for _, spread in sweep(grid, tmp_path / "s", workers=1).summary()] in (
            [1] * 2,
            [1] * 4,
            [1] * 3,
        )
    found = Sweep(tmp_path / "s")
    places = [(place["run.turn_order"], place["machine.dsps"], spread.n) for place, spread in found.summary()]
    assert sorted(places) == [(1, 2, 1), (1, 4, 1), (2, 2, 1), (2, 4, 1), (3, 4, 1)]
    parts = Folder(tmp_path / "s").parts()
    assert len(sweep(grids[1], tmp_path / "s", workers=1)) == 4 and Folder(tmp_path / "s").parts() == parts


def test_a_run_that_has_lost_its_report_is_damaged(tmp_path: Path) -> None:
    sweep(THREE, tmp_path / "s", workers=1)
    with Folder(tmp_path / "s") as folder:
        rows = [{**row, "report": None} for row in folder.rows()]
        folder.drop(lambda _: True)
        folder.write(rows)
    assert all(json.loads(row["place"]) for row in rows)
    with pytest.raises(store.SweepError, match=r"the report of the run .* is damaged"):
        list(Sweep(tmp_path / "s").reports())
