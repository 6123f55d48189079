"""`emulator --perfetto`: what overlaps, what is cut, what is under way at either end, and who else watches the run."""

import itertools
import json
from pathlib import Path

import pytest
import timeline
from drawn_runs import CLOCK_PS, MS, Drawn, draw

PRELOADED = ["--set", "machine.boot=preloaded"]


def event(folder: Path, at_s: float, action: str, **more: float | str) -> list[str]:
    rows = {"at_s": at_s, "action": action, **more}
    file = folder / f"{action}.toml"
    file.write_text("[[events]]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in rows.items()))
    return ["--config", str(file)]


def slices(drawn: Drawn, *path: str) -> list[timeline.Slice]:
    """Of the track and of those beside it for what overlaps."""
    named = [
        uuid
        for uuid, name in drawn.timeline.paths.items()
        if name == path or (name[:-1] == path[:-1] and name[-1].startswith(f"{path[-1]} ("))
    ]
    return sorted((one for uuid in named for one in drawn.timeline.slices[uuid]), key=lambda one: one.begin)


# ---- what overlaps


@pytest.mark.parametrize(
    ("scene", "overlap"),
    [
        (["--dsps", "8", "--idle-policy", "spin", "--duration", "0.03"], True),
        (["--dsps", "4", "--duration", "0.03", "--set", "host.refresh_overhead_ns=130000"], True),
        (["--dsps", "2", "--duration", "0.04"], False),
    ],
)
def test_a_refresh_may_begin_before_the_release_of_the_one_before(
    tmp_path: Path, scene: list[str], overlap: bool
) -> None:
    drawn = draw(tmp_path, *PRELOADED, *scene)
    timeline.check_order(drawn.timeline)
    refreshes = slices(drawn, "host", "refreshes")
    reported = drawn.report["host"]["refresh_duration_ps"]
    assert len(refreshes) == reported["count"] > 50
    assert any(one.end > after.begin for one, after in itertools.pairwise(refreshes)) == overlap
    assert max(one.end - one.begin for one in refreshes) <= reported["worst"]


# ---- who else watches


def test_a_page_beside_it_changes_nothing(tmp_path: Path) -> None:
    scene = ["--preset", "saturated", "--dsps", "1", "--duration", "0.06"]
    alone, beside = tmp_path / "alone", tmp_path / "beside"
    for folder in (alone, beside):
        folder.mkdir()
    drawn = draw(alone, *scene)
    draw(beside, *scene, "--page", "page.html")
    assert (beside / drawn.file.name).read_bytes() == drawn.file.read_bytes()


def test_the_host_puts_a_block_back_after_its_dsp_was_reset(tmp_path: Path) -> None:
    """The DSP runs another block by then, and continues."""
    scene = ["--preset", "saturated", "--dsps", "1", "--duration", "0.1", *PRELOADED]
    drawn = draw(tmp_path, *scene, *event(tmp_path, 0.05, "reset", dsp=0))
    timeline.check_order(drawn.timeline)
    sums: dict[str, int] = {}
    for block in drawn.blocks(0):
        sums[block.name] = sums.get(block.name, 0) + block.end - block.begin
    assert sums == drawn.report["dsps"][0]["tasks_ps"]
    assert "taken_away" not in {block.notes.get("end") for block in drawn.blocks(0)}


def test_the_cranes_process_for_an_agv_is_the_cranes(tmp_path: Path) -> None:
    rows = {
        "number": 4,
        "name": "load",
        "robot": "crane",
        "account": "t_4",
        "steps": ["hold 0.02"],
        "must": [5],
        "may": [3, 7, 8],
        "initial": [3, 6],
        "clears": ["5->8"],
    }
    config = tmp_path / "load.toml"
    config.write_text("[[processes]]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in rows.items()))
    drawn = draw(tmp_path, "--config", config, "--dsps", "2", "--duration", "0.06", *PRELOADED)
    timeline.check_order(drawn.timeline)
    (load,) = (one for one in slices(drawn, "processes", "crane") if one.name == "4 load")
    assert load.notes == {"agv": 0} and 19 * MS < load.end - load.begin < 21 * MS
    assert [one.name[0] for one in slices(drawn, "processes", "no robot")] == ["1", "2"]
    assert len([path for path in drawn.timeline.paths.values() if path[0] == "processes" and "(" in path[-1]]) == 0
    agv = slices(drawn, "processes", "agv 0")
    assert [(one.name, one.begin, one.notes) for one in agv] == [("5 to the warehouse", load.end, {})]


# ---- windows


def test_every_slice_of_a_window_is_whole(tmp_path: Path) -> None:
    scene = ["--preset", "saturated", "--dsps", "1", "--duration", "0.06"]
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    for folder in (whole, cut):
        folder.mkdir()
    window = ["--perfetto-window", "0.0305:0.031", "--perfetto-detail", "bus"]
    drawn, part = draw(whole, *scene), draw(cut, *scene, *window)
    timeline.check_order(part.timeline)
    inside = [
        (one.name, one.begin, one.end)
        for one in drawn.dsp(0)
        if one.end > 30_500_000_000 and one.begin < 31_000_000_000
    ]
    assert [(one.name, one.begin, one.end) for one in part.dsp(0)] == inside
    assert "executive" in {name for name, _, _ in inside}


# ---- what is under way


def test_a_refresh_under_way_at_the_end(tmp_path: Path) -> None:
    drawn = draw(
        tmp_path, "--dsps", "2", "--duration", "0.05", *event(tmp_path, 0.03, "pause_host", lasts_ms=40), *PRELOADED
    )
    timeline.check_order(drawn.timeline)
    refreshes = slices(drawn, "host", "refreshes")
    assert len(refreshes) == drawn.report["host"]["refresh_duration_ps"]["count"]
    assert (refreshes[-1].end, refreshes[-1].notes) == (50 * MS, {"end": "running"})
    assert refreshes[-1].end - refreshes[-1].begin == drawn.report["host"]["refresh_duration_ps"]["worst"] >= 20 * MS


def test_the_clocks_of_an_attempt_on_a_bus_at_the_end(tmp_path: Path) -> None:
    window = ["--perfetto-window", "0:1", "--perfetto-detail", "bus"]
    cut = 0
    for end_ns in (20_625_730, 20_626_220, 20_627_160):
        scene = ["--dsps", "2", "--duration", f"{end_ns / 1e9:.9f}"]  # the host's refresh is at work
        drawn = draw(tmp_path, *scene, *window, *PRELOADED)
        timeline.check_order(drawn.timeline)
        for name, bus in drawn.report["buses"].items():
            transactions = drawn.timeline.slices[drawn.timeline.track(f"bus {name}", "transactions")]
            running = [one for one in transactions if one.notes.get("end") == "running"]
            assert running in ([], transactions[-1:])
            assert all(one.end <= end_ns * 1000 for one in running)
            cut += len(running)
            clocks = sum((one.end - one.begin) // CLOCK_PS for one in transactions)
            assert clocks == bus["clocks_by_use"]["data"] + bus["clocks_by_use"]["wait"]
    assert cut > 0


def test_processes_that_began_before_a_snapshot(tmp_path: Path) -> None:
    scene = ["--preset", "heavy", "--dsps", "2", "--duration", "0.2"]
    whole = draw(tmp_path, *scene, "--snapshot-at", "0.1001:half.snapshot")
    rest = draw(tmp_path, "--resume", "half.snapshot")
    timeline.check_order(rest.timeline)
    drawn = 0
    for path in whole.timeline.paths.values():
        if path[0] != "processes" or len(path) == 1:
            continue
        later = [
            (one.name, max(one.begin, 100_100_000_000), one.end, one.begin < 100_100_000_000)
            for one in slices(whole, *path)
            if one.end > 100_100_000_000
        ]
        assert [
            (one.name, one.begin, one.end, one.notes.get("begun") == "before the snapshot")
            for one in slices(rest, *path)
        ] == later
        drawn += len(later)
    assert drawn > 1


def test_a_snapshot_between_the_reset_and_the_putting_back(tmp_path: Path) -> None:
    scene = ["--preset", "saturated", "--dsps", "1", "--duration", "0.1", *PRELOADED]
    whole = draw(tmp_path, *scene, *event(tmp_path, 0.05, "reset", dsp=0), "--snapshot-at", "0.053:half.snapshot")
    rest = draw(tmp_path, "--resume", "half.snapshot")
    timeline.check_order(rest.timeline)
    later = [(one.name, one.begin, one.end) for one in whole.blocks(0) if one.end > 53 * MS]
    assert [(one.name, one.begin, one.end) for one in rest.blocks(0)] == later
