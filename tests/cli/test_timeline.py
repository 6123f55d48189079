"""`emulator --perfetto`: the drawing agrees with the report, by PyPI's perfetto schema; drawing changes nothing."""

import gzip
import itertools
import json
import signal
import subprocess
from collections import Counter, defaultdict
from pathlib import Path
from typing import Any

import pytest
import timeline
from command_line import EMULATOR, emulator
from drawn_runs import ALONE, CLOCK_PS, MS, Drawn, draw, run

BUSY = [
    "--dsps",
    "3",
    "--preset",
    "saturated",
    "--duration",
    "1.3",
    "--set",
    "scheduling.agv_phase=together",
    "--set",
    "report.misses_max=100000",
]


@pytest.fixture(scope="module")
def busy(tmp_path_factory: pytest.TempPathFactory) -> Drawn:
    return draw(tmp_path_factory.mktemp("busy"), *BUSY)


# ---- it is whole, and changes nothing


def test_slices_nest_and_follow_one_another(busy: Drawn) -> None:
    timeline.check_order(busy.timeline)
    assert sum(map(len, busy.timeline.slices.values())) > 10000
    assert {path[0] for path in busy.timeline.paths.values()} == {
        "DSPs",
        "host",
        "jobs",
        "bus A",
        "bus B",
        "processes",
        "events",
        "plant",
    }


def test_drawing_changes_nothing(busy: Drawn, tmp_path: Path) -> None:
    assert run(tmp_path, *BUSY)["hash"] == busy.report["hash"]


def test_packed_is_the_same(tmp_path: Path) -> None:
    scene = ["--dsps", "2", "--duration", "0.3"]
    plain, packed = tmp_path / "t", tmp_path / "t.gz"
    hashes = {run(tmp_path, *scene, "--perfetto", plain)["hash"], run(tmp_path, *scene, "--perfetto", packed)["hash"]}
    assert gzip.decompress(packed.read_bytes()) == plain.read_bytes()
    assert len(packed.read_bytes()) < len(plain.read_bytes()) / 5
    assert len(hashes) == 1


# ---- what it says is what the report says


def test_blocks_sum_to_what_each_dsp_was_occupied_with(busy: Drawn) -> None:
    for dsp in busy.report["dsps"]:
        sums: Counter[str] = Counter()
        for block in busy.blocks(dsp["slot"]):
            sums[block.name] += block.end - block.begin
        assert dict(sums) == dsp["tasks_ps"]
        assert sum(block.notes.get("end") != "part" for block in busy.blocks(dsp["slot"])) == dsp["claims"]


def test_blocks_stand_in_the_executive(busy: Drawn) -> None:
    blocks = [block for dsp in busy.report["dsps"] for block in busy.blocks(dsp["slot"])]
    assert {block.parent.name for block in blocks if block.parent} == {"executive"}
    assert all(block.notes["generation"] > 0 for block in blocks)


def jobs_of(drawn: Drawn, kind: str) -> list[timeline.Slice]:
    tracks = [track for track in drawn.timeline.below("jobs") if drawn.timeline.paths[track][1] != "misses"]
    return [job for track in tracks for job in drawn.timeline.slices[track] if job.name == kind]


def test_jobs_have_the_outcomes_of_the_report(busy: Drawn) -> None:
    for kind, task in busy.report["tasks"].items():
        jobs = jobs_of(busy, kind)
        outcomes = Counter(job.notes.get("outcome", "on_time") for job in jobs)
        missed = Counter(one.name.split()[-1] for one in misses_of(busy, kind))
        skipped = sum(count for part, count in task["why_late"].items() if part.startswith("dropped_"))
        assert outcomes["dropped"] + skipped == task["dropped"]
        for outcome in ("on_time", "late", "unfinished", "never_started", "lost"):
            assert outcomes[outcome] == task[outcome], (kind, outcome)
        assert sum(missed.values()) == task["misses"]
        assert missed["late"] == task["late"] and missed["dropped"] == task["dropped"]


def misses_of(drawn: Drawn, kind: str) -> list[timeline.Instant]:
    track = drawn.timeline.track("jobs", "misses")
    return [one for one in drawn.timeline.instants if one.track == track and one.name.split()[0] == kind]


def test_late_begins_at_the_deadline(busy: Drawn) -> None:
    late = [one for track in busy.timeline.below("jobs") for one in busy.timeline.slices[track] if one.name == "late"]
    assert late
    for one in late:
        assert one.parent is not None
        assert one.begin == one.parent.notes["deadline_ps"] and one.end == one.parent.end


def test_misses_show_the_waits_of_their_chains(busy: Drawn) -> None:
    reported = {(miss["kind"], miss["robot"], miss["number"], miss["end_ps"]): miss for miss in busy.report["misses"]}
    drawn = 0
    for kind in busy.report["tasks"]:
        for one in misses_of(busy, kind):
            miss = reported[kind, one.notes["robot"], one.notes["job"], one.at]
            waits = {
                name: ps
                for name, ps in miss["parts_ps"].items()
                if name not in ("slack", "not_run") and not name.startswith("execution.")
            }
            apart = ("lateness_ps", "execution_ps")
            assert {
                name[:-3]: ps for name, ps in one.notes.items() if name.endswith("_ps") and name not in apart
            } == waits
            assert one.notes.get("lateness_ps") == miss["lateness_ps"]
            drawn += 1
    assert drawn == len(reported) > 100


def test_flows_lead_from_each_block_in_the_way_to_the_miss(busy: Drawn) -> None:
    both = timeline.flows(busy.timeline)
    wanted: Counter[tuple[Any, ...]] = Counter()
    for miss in busy.report["misses"]:
        for behind in miss["behind"]:
            wanted[
                (
                    behind["dsp"],
                    behind["kind"],
                    behind["number"],
                    behind["claimed_ps"],
                    behind["from_ps"],
                    behind["to_ps"],
                    miss["kind"],
                    miss["number"],
                    behind["share_ps"],
                )
            ] += 1
    drawn: Counter[tuple[Any, ...]] = Counter()
    for begun, ended in both.values():
        assert abs(begun.at - begun.notes["from_ps"]) <= 1000
        assert begun.inside is not None and begun.notes["job"] == ended.notes["job"]
        slot = int(busy.timeline.paths[begun.track][1].split()[1])
        drawn[
            (
                slot,
                begun.inside.name,
                begun.inside.notes["job"],
                begun.inside.begin,
                *(begun.notes[name] for name in ("from_ps", "to_ps")),
                ended.name.split()[0],
                ended.notes["job"],
                begun.notes["share_ps"],
            )
        ] += 1
    assert drawn == wanted
    assert len(both) > 100


def test_refreshes_are_those_of_the_host(busy: Drawn) -> None:
    refreshes = busy.timeline.slices[busy.timeline.track("host", "refreshes")]
    reported = busy.report["host"]["refresh_duration_ps"]
    durations = [one.end - one.begin for one in refreshes]
    assert len(refreshes) == reported["count"]
    assert sum(durations) / len(durations) == pytest.approx(reported["mean"], rel=1e-12)
    assert (min(durations), max(durations)) == (reported["best"], reported["worst"])


def test_the_length_of_the_list_is_reported_when_it_changes(busy: Drawn) -> None:
    track = busy.timeline.track("host", "list length")
    lengths = [length for _, length in busy.timeline.values[track]]
    assert max(lengths) == busy.report["host"]["list_length"]["worst"]
    assert all(one != after for one, after in itertools.pairwise(lengths))
    ends = {one.end for one in busy.timeline.slices[busy.timeline.track("host", "refreshes")]}
    assert {at for at, _ in busy.timeline.values[track]} <= {end // 1000 for end in ends}


def by_millisecond(values: list[tuple[int, float]], end: int) -> dict[int, float]:
    """A counter's value in each millisecond; it holds until the next one."""
    steps = [*values, (end * 10**6, 0.0)]
    return {
        ms: value
        for (at, value), (until, _) in itertools.pairwise(steps)
        for ms in range(at // 10**6, until // 10**6)
        if value
    }


def test_the_masters_clocks_are_those_of_the_bus(busy: Drawn) -> None:
    for name, bus in busy.report["buses"].items():
        clocks = [by_millisecond(busy.timeline.values[track], 1301) for track in busy.timeline.below(f"bus {name}")]
        assert sum(sum(one.values()) for one in clocks) == bus["clocks_by_use"]["data"] + bus["clocks_by_use"]["wait"]
        assert max(sum(one.get(ms, 0) for one in clocks) for ms in range(1300)) <= MS / CLOCK_PS + 1
    masters = [busy.timeline.paths[track][1] for track in busy.timeline.below("bus A")]
    assert [name.lower() for name in masters] == [name.lower() for name in busy.report["buses"]["A"]["masters"]]


def test_processes_and_the_plant(busy: Drawn) -> None:
    for robot, numbers in (("no robot", ["1", "2"]), ("crane", ["3"])):
        drawn = busy.timeline.slices[busy.timeline.track("processes", robot)]
        assert [one.name.split()[0] for one in drawn][:2] == numbers
    assert busy.timeline.units[busy.timeline.track("plant", "load x")] == "m"
    times = [at for at, _ in busy.timeline.values[busy.timeline.track("plant", "l")]]
    assert len(times) > 30 and all(at % 20_000_000 == 0 for at in times)


def test_picoseconds_are_shown_where_clocks_have_them(tmp_path: Path) -> None:
    drawn = draw(tmp_path, "--dsps", "2", "--duration", "0.4", "--set", "run.phase_jitter=true")
    timeline.check_order(drawn.timeline)
    assert any(block.begin % 1000 for slot in (0, 1) for block in drawn.blocks(slot))
    for dsp in drawn.report["dsps"]:
        sums: Counter[str] = Counter()
        for block in drawn.blocks(dsp["slot"]):
            sums[block.name] += block.end - block.begin
        assert dict(sums) == dsp["tasks_ps"]


# ---- windows


@pytest.fixture(scope="module")
def window(tmp_path_factory: pytest.TempPathFactory) -> Drawn:
    detail = ["--perfetto-detail", "all", "--perfetto-window", "0.9:0.92"]
    return draw(tmp_path_factory.mktemp("window"), *BUSY, *detail)


def test_a_window_changes_nothing_either(window: Drawn, busy: Drawn) -> None:
    assert window.report["hash"] == busy.report["hash"]
    timeline.check_order(window.timeline)


def test_what_reaches_into_the_window_is_drawn_as_without(window: Drawn, busy: Drawn) -> None:
    for dsp in busy.report["dsps"]:
        inside = [
            (one.name, one.begin, one.end)
            for one in busy.blocks(dsp["slot"])
            if one.end > 900 * MS and one.begin < 920 * MS
        ]
        assert [(one.name, one.begin, one.end) for one in window.blocks(dsp["slot"])] == inside


def test_each_transaction_counts_in_its_millisecond(window: Drawn) -> None:
    clocks: dict[tuple[str, str, int], int] = defaultdict(int)
    for bus in ("bus A", "bus B"):
        for one in window.timeline.slices[window.timeline.track(bus, "transactions")]:
            for at in range(one.begin, one.end, CLOCK_PS):
                clocks[bus, one.name, at // MS] += 1
        for track in window.timeline.below(bus):
            master = window.timeline.paths[track][1]
            if master == "transactions":
                continue
            counted = by_millisecond(window.timeline.values[track], 920)
            assert {ms: clocks[bus, master, ms] for ms in range(900, 920) if clocks[bus, master, ms]} == counted


def test_each_wait_of_a_block_is_drawn(window: Drawn) -> None:
    seen = 0
    for dsp in window.report["dsps"]:
        waits = window.timeline.slices[window.timeline.track("DSPs", f"DSP {dsp['slot']}", f"DSP {dsp['slot']} waits")]
        for block in window.blocks(dsp["slot"]):
            if block.begin < 900 * MS or block.end >= 920 * MS:
                continue
            sums: Counter[str] = Counter()
            for wait in waits:
                sums[wait.name] += max(0, min(wait.end, block.end) - max(wait.begin, block.begin))
            assert sums["bus A"] == block.notes.get("bus_a_ps", 0) and sums["bus B"] == block.notes.get("bus_b_ps", 0)
            cycles = sum(
                value
                for name, value in block.notes.items()
                if name not in ("job", "robot", "generation") and not name.endswith("_ps")
            )
            assert cycles * 40_000 == block.end - block.begin
            seen += 1
    assert seen > 20


def test_the_list_has_one_owner_at_a_time(window: Drawn) -> None:
    owners = window.timeline.slices[window.timeline.track("host", "list held by")]
    assert {one.name for one in owners} >= {"host", "DSP 0"}
    assert all(one.end <= after.begin for one, after in itertools.pairwise(owners))


# ---- DSPs that fail, runs that end early or continue


def test_a_dsp_that_fails_is_off_from_then_on(tmp_path: Path) -> None:
    config = tmp_path / "failure.toml"
    config.write_text('[[events]]\nat_s = 0.8003\naction = "fail"\ndsp = 0\n')
    drawn = draw(tmp_path, "--dsps", "3", "--preset", "saturated", "--duration", "1.1", "--config", config)
    timeline.check_order(drawn.timeline)
    failure = 800_300_000_000
    off = drawn.dsp(0)[-1]
    assert (off.name, off.begin, off.end) == ("off", failure, 1100 * MS)
    block = drawn.blocks(0)[-1]
    assert (block.end, block.notes["end"]) == (failure, "failed")
    # The report counts no longer either.
    ran = sum(one.end - one.begin for one in drawn.blocks(0) if one.name == block.name)
    assert drawn.report["dsps"][0]["tasks_ps"][block.name] == ran


def test_an_interrupted_run_leaves_a_whole_file(tmp_path: Path) -> None:
    os_pipe = tmp_path / "trace"
    subprocess.run(["mkfifo", os_pipe], check=True)
    arguments = [
        "--dsps",
        "2",
        "--duration",
        "80000",
        *ALONE,
        "--perfetto",
        "t.gz",
        "--report",
        "r.json",
        "--trace",
        "trace",
    ]
    process = subprocess.Popen([EMULATOR, *arguments], cwd=tmp_path, stderr=subprocess.PIPE)
    with os_pipe.open("rb") as trace:
        for line in trace:
            if line.startswith(b"0.2"):
                process.send_signal(signal.SIGINT)
                break
        while trace.read(1 << 16):
            pass
    assert process.wait(60) == 130
    drawn = Drawn(timeline.read(tmp_path / "t.gz"), json.loads((tmp_path / "r.json").read_text()), tmp_path)
    timeline.check_order(drawn.timeline)
    assert drawn.report["stop_reason"] == "interrupted"
    end = round(drawn.report["simulated_s"] * 1e12)
    for dsp in drawn.report["dsps"]:
        assert all(one.end <= end for one in drawn.dsp(dsp["slot"]))
        sums: Counter[str] = Counter()
        for block in drawn.blocks(dsp["slot"]):
            sums[block.name] += block.end - block.begin
        assert dict(sums) == dsp["tasks_ps"]


def test_a_resumed_run_draws_what_is_left(tmp_path: Path) -> None:
    scene = ["--dsps", "2", "--duration", "0.5"]
    whole = draw(tmp_path, *scene, "--snapshot-at", "0.3001:half.snapshot")
    rest = draw(tmp_path, "--resume", "half.snapshot")
    assert rest.report["hash"] == whole.report["hash"]
    timeline.check_order(rest.timeline)
    for slot in (0, 1):
        later = [
            (one.name, one.begin, one.end, one.notes["job"], one.notes["generation"])
            for one in whole.blocks(slot)
            if one.end > 300_100_000_000
        ]
        assert [
            (one.name, one.begin, one.end, one.notes["job"], one.notes["generation"]) for one in rest.blocks(slot)
        ] == later


# ---- bad input


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--perfetto", "t", "--perfetto-window", "0.5:0.2"], '--perfetto-window: "0.5:0.2" is empty'),
        (["--perfetto", "t", "--perfetto-window", "7:8"], "it begins at 7 s, and the run ends at 0.1 s"),
        (["--perfetto", "t", "--perfetto-window", "nan:1"], "is not A:B"),
        (["--perfetto", "t", "--perfetto-window", "0"], "is not A:B"),
        (["--perfetto", "t", "--perfetto-detail", "everything"], "tasks, bus or all"),
        (["--perfetto", "t", "--perfetto-detail", "bus"], "--perfetto-window A:B"),
        (["--perfetto", "t", "--perfetto-detail", "all"], "--perfetto-window A:B"),
        (["--perfetto-window", "0:1"], "needs --perfetto FILE"),
        (["--perfetto-detail", "tasks"], "needs --perfetto FILE"),
        (["--perfetto", "t", "--trace", "t"], "--trace"),
        (["--perfetto", "t", "--report", "./t"], "--report"),
        (["--perfetto", "c.toml", "--config", "c.toml"], "--config"),
        (["--perfetto", "none/t"], "none/t: cannot be written"),
        (["--perfetto", "."], "is a directory"),
        (["--perfetto", ""], "an output file's name is empty"),
        (["--perfetto", "t", "--debug", "0"], "--debug"),
    ],
)
def test_bad_input(tmp_path: Path, arguments: list[str], says: str) -> None:
    (tmp_path / "c.toml").write_text("[machine]\ndsps = 2\n")
    done = emulator("--duration", "0.1", *ALONE, *arguments, folder=tmp_path)
    assert done.returncode == 2
    assert says in done.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"c.toml"}
    assert (tmp_path / "c.toml").read_text() == "[machine]\ndsps = 2\n"


def test_a_device_is_written_into_and_a_full_disk_is_reported(tmp_path: Path) -> None:
    short = ["--dsps", "1", "--duration", "0.1", *ALONE]
    assert emulator(*short, "--perfetto", "/dev/null", folder=tmp_path).returncode == 0
    for name in ("/dev/full",):
        done = emulator(*short, "--perfetto", name, folder=tmp_path)
        assert done.returncode != 0
        assert f"{name}: writing failed: No space left on device" in done.stderr


def test_a_full_disk_is_reported_for_packed_files(tmp_path: Path) -> None:
    (tmp_path / "full.gz").symlink_to("/dev/full")
    done = emulator("--dsps", "1", "--duration", "0.1", *ALONE, "--perfetto", "full.gz", folder=tmp_path)
    assert done.returncode != 0
    assert "full.gz: writing failed: No space left on device" in done.stderr


def test_names_of_tasks_are_written_unchanged(tmp_path: Path) -> None:
    name = 'küh<l>"er & 温度\n'
    rows = f'name = {json.dumps(name)}\nprogram = "kernel_none"\nkind = 14\nimportance = 0xF3FF\nperiod_ms = 10\n'
    (tmp_path / "c.toml").write_text("[[tasks]]\n" + rows)
    drawn = draw(tmp_path, "--config", tmp_path / "c.toml", "--duration", "0.5", "--dsps", "2")
    jobs = drawn.timeline.slices[drawn.timeline.track("jobs", f"user.{name}")]
    assert len(jobs) == drawn.report["tasks"][f"user.{name}"]["released"] > 10
