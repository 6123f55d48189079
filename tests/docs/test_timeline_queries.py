"""The queries of docs/timelines.md, run over the events of a run in which deadlines are missed."""

import json
import re
import subprocess
from collections import Counter
from pathlib import Path
from typing import Any

import cmrc.__main__
import duckdb
import pyarrow.parquet
import pytest
from locations import BUILD, ROOT

QUERIES = dict(
    re.findall(
        r"```sql\n-- query: (\w+)\n(.*?)```", (ROOT / "docs" / "timelines.md").read_text(encoding="utf-8"), re.DOTALL
    )
)

# The page asks about the tick at 1 s; the run of this test lasts 0.16 s.
TICK_OF_THE_PAGE, TICK = "8000", "800"


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("events")
    settings = [
        "--set",
        "scheduling.agv_phase=together",
        "--set",
        "report.reference=none",
        "--set",
        "report.misses_max=100000",
    ]
    asked = [BUILD / "bin" / "emulator", "config", "--preset", "saturated", *settings]
    saturated = subprocess.run(asked, capture_output=True, text=True, check=True).stdout
    (folder / "c.toml").write_text(
        saturated.replace("\ndsps = 4\n", "\ndsps = 3\n").replace("duration_s = 180.0", "duration_s = 0.16")
    )
    run = ["--config", "c.toml", "--quiet", "--report", "r.json", "--trace", "t.trace"]
    subprocess.run([BUILD / "bin" / "emulator", *run], cwd=folder, check=True)
    return folder


@pytest.fixture(scope="module")
def events(scene: Path) -> Path:
    assert cmrc.__main__.main(["events", str(scene / "c.toml"), "-o", str(scene / "events.parquet")]) == 0
    return scene / "events.parquet"


@pytest.fixture(scope="module")
def report(scene: Path) -> Any:
    return json.loads((scene / "r.json").read_text())


def ask(events: Path, query: str) -> list[tuple[Any, ...]]:
    return duckdb.sql(QUERIES[query].replace("events.parquet", str(events)).replace(TICK_OF_THE_PAGE, TICK)).fetchall()


def test_all_are_asked() -> None:
    assert set(QUERIES) == {"occupied", "causes", "on_the_bus", "waiting"}


def test_a_trace_gives_the_same_table_as_the_run(scene: Path, events: Path, report: Any) -> None:
    assert cmrc.__main__.main(["events", str(scene / "t.trace"), "-o", str(scene / "of_trace.parquet")]) == 0
    table = pyarrow.parquet.read_table(events)
    assert table.num_rows == report["events"]
    assert table.equals(pyarrow.parquet.read_table(scene / "of_trace.parquet"))


def test_dsps_are_occupied_as_the_report_says(events: Path, report: Any) -> None:
    reported = {(f"dsp {dsp['slot']}", task): ps for dsp in report["dsps"] for task, ps in dsp["tasks_ps"].items()}
    rows = {(dsp, task): int(ps) for dsp, task, _, ps in ask(events, "occupied")}
    assert reported.keys() == rows.keys()
    # At the end of the run a block may be open: it has no end among the events.
    open_ps = [reported[key] - rows[key] for key in reported if reported[key] != rows[key]]
    assert len(open_ps) <= 3 and all(0 < ps < 10**11 for ps in open_ps)


def test_the_largest_cause_is_that_of_the_report(events: Path, report: Any) -> None:
    rows = ask(events, "causes")
    behind: Counter[tuple[str, str]] = Counter()
    for miss in report["misses"]:
        for block in miss["behind"]:
            if miss["outcome"] == "late":
                behind[miss["kind"], block["kind"]] += block["share_ps"]
    assert (rows[0][0], rows[0][1]) == behind.most_common(1)[0][0]
    assert {row[0] for row in rows} == {kind for kind, task in report["tasks"].items() if task["late"]}


def test_which_master_is_on_the_bus(scene: Path, events: Path) -> None:
    """The same from the lines of the trace."""
    lines = [line.split() for line in (scene / "t.trace").read_text().splitlines()[1:]]
    fields = [(line[0], dict(pair.split("=") for pair in line if "=" in pair), line) for line in lines]
    ((loaded, block, generation),) = [
        (at, f["block"], f["generation"])
        for at, f, line in fields
        if "load" in line and f["kind"] == "6" and f["tick"] == TICK
    ]
    (claimed,) = [
        at for at, f, line in fields if "claim" in line and f["block"] == block and f["generation"] == generation
    ]
    words: Counter[int] = Counter()
    for at, f, line in fields:
        if loaded <= at <= claimed and line[1:3] == ["[bus", "A]"] and "bus_transaction" in line:
            words[int(f["master"])] += int(f["words"])
    rows = ask(events, "on_the_bus")
    assert {master: int(sum_of_words) for master, _, sum_of_words, _ in rows} == dict(words)
    assert len(rows) > 1


def test_blocks_wait_longest_where_the_report_says(events: Path, report: Any) -> None:
    rows = {task: (count, longest) for task, count, _, longest in ask(events, "waiting")}
    assert all(count <= report["tasks"][task]["released"] for task, (count, _) in rows.items())
    # Others than the servo's are released when they are loaded. From a claim to its arrival, and to the host's loading,
    # it is microseconds.
    released_at_once = [
        task
        for task in rows
        if task not in ("pid", "torque_compensation") and not report["tasks"][task]["never_started"]
    ]
    assert len(released_at_once) > 3
    for task in released_at_once:
        assert rows[task][1] == pytest.approx(report["tasks"][task]["waiting_ps"]["worst"] / 1e6, abs=60)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["none.toml", "-o", "o"], "none.toml"),
        (["t", "-o", "t"], "RUN"),
        (["t", "-o", "no/folder"], "no/folder"),
        (["t", "-o", "."], "is a folder"),
        (["t", "-o", "o", "--set", "machine.dsps=2"], "--set: RUN is a trace"),
        (["t", "-o", "o"], "line 3: not a line of an event trace: '0.5 [host] nothing of the kind'"),
        (["empty", "-o", "o"], "line 1: not an event trace"),
    ],
)
def test_bad_input(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], arguments: list[str], says: str
) -> None:
    monkeypatch.chdir(tmp_path)
    content = "# cmrc event trace 1\n0.000125000000 [host] refresh number=1 blocks=3 waiting=2 pointer=0x50 skipped=0\n0.5 [host] nothing of the kind\n"
    (tmp_path / "t").write_text(content)
    (tmp_path / "empty").write_text("")
    assert cmrc.__main__.main(["events", *arguments]) == 2
    assert says in capsys.readouterr().err
    assert {path.name for path in tmp_path.iterdir()} == {"t", "empty"}
    assert (tmp_path / "t").read_text() == content


@pytest.mark.parametrize(
    "line",
    [
        "0.000125000000 [host] refresh number=1 blocks=3 waiting=2 pointer=0x50 skipped=0x100000000",
        "0.000125000000 [host] refresh number=1 blocks=3 waiting=2 pointer=-1 skipped=0",
        "0.000125000000 [host] refresh number=1 blocks=3 waiting=2 pointer=0x50",
        "0.000125000000 [host] refresh number=1 blocks=3 waiting=2 pointer=0x50 skipped=0 more=1",
        "9999999.000125000000 [host] refresh number=1 blocks=3 waiting=2 pointer=0x50 skipped=0",
        "0.000125000000 [host] load block=0x40 area=0x1000 tick=160 generation=1",
    ],
)
def test_a_line_that_no_run_writes_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str], line: str) -> None:
    (tmp_path / "t").write_text(f"# cmrc event trace 1\n{line}\n")
    assert cmrc.__main__.main(["events", str(tmp_path / "t"), "-o", str(tmp_path / "o")]) == 2
    assert "line 2: not a line of an event trace" in capsys.readouterr().err


def test_without_pyarrow_the_extra_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    (tmp_path / "t").write_text("# cmrc event trace 1\n")
    assert cmrc.__main__.main(["events", str(tmp_path / "t"), "-o", str(tmp_path / "o")]) == 2
    assert "pip install 'cmrc[events]'" in capsys.readouterr().err


def test_a_trace_numbers_the_tasks_of_the_configuration(tmp_path: Path) -> None:
    from cmrc import events

    trace = tmp_path / "t"
    kinds = len(events.built_in_tasks())
    lines = [f"0.500000000000 [dsp 0] start block=0x50 kind={kind}" for kind in (0, kinds, kinds + 1)]
    trace.write_text("\n".join([events.HEADER, *lines, ""]))
    [batch] = events.of_trace(trace)
    assert batch["task"].to_pylist() == [events.built_in_tasks()[0], "user 0", "user 1"]


def test_each_event_of_a_block_names_its_task(tmp_path: Path) -> None:
    from cmrc import _core, events

    of_blocks = ["load", "claim", "start", "finish", "remove", "requeue", "miss"]
    arguments = {event: names for event, names in _core.report.event_names().values()}
    lines = [
        f"0.500000000000 [host] {event} " + " ".join(f"{name}=1" for name in arguments[event])
        for event in [*of_blocks, "fault"]
    ]
    (tmp_path / "t").write_text("\n".join([events.HEADER, *lines, ""]))
    [batch] = events.of_trace(tmp_path / "t")
    assert batch["kind"].to_pylist() == [1] * 8
    assert batch["task"].to_pylist() == [events.built_in_tasks()[1]] * 7 + [None]  # a fault's kind is another


def test_a_long_trace_is_read_in_pieces_and_each_event_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from cmrc import events

    monkeypatch.setattr(events, "BATCH", 3)
    for count in (2, 3, 6, 7):
        lines = [f"{n}.000000000000 [host] doorbell slot={n}" for n in range(count)]
        (tmp_path / "t").write_text("\n".join([events.HEADER, *lines, ""]))
        batches = list(events.of_trace(tmp_path / "t"))
        assert [slot for batch in batches for slot in batch["slot"].to_pylist()] == list(range(count))
        assert events.write(batches, tmp_path / "e.parquet") == count
