"""The folder of a sweep: locks, versions, damage, full disks."""

import json
import os
import re
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from cmrc.sweeps import Sweep, SweepError, store, sweep
from cmrc.sweeps.identity import build
from cmrc.sweeps.store import Folder
from locations import BUILD
from sweep_helpers import report_with

pytest.importorskip("pyarrow")


def row(number: int, **more: Any) -> dict[str, Any]:
    return {
        "key": f"{number:064}",
        "status": store.DONE,
        "message": "",
        "place": "{}",
        "seed": number,
        "settings": "{}",
        "hash": "",
        "build": build(),
        "emulator_version": "0.1.0",
        "elapsed_s": 1.0,
        "host": "here",
        "report": store.packed({"number": number}),
        **more,
    }


def keys(folder: Folder) -> list[int]:
    return [int(found["key"]) for found in folder.rows(())]


def test_parts_are_read_in_order_and_compacted(tmp_path: Path) -> None:
    with Folder(tmp_path / "new" / "sweep") as folder:
        folder.write([row(1), row(2)])
        folder.write([row(3)])
        assert keys(folder) == [1, 2, 3] and len(folder.parts()) == 2
        folder.compact()
        assert keys(folder) == [1, 2, 3] and len(folder.parts()) == 1
        assert [store.unpacked(found["report"])["number"] for found in folder.rows()] == [1, 2, 3]
        folder.write([row(4, status=store.FAILED)])
        folder.drop(lambda found: found["status"] == store.FAILED)
        assert keys(folder) == [1, 2, 3]
    with Folder(tmp_path / "new" / "sweep") as again:
        assert keys(again) == [1, 2, 3]


def test_failed_runs_are_removed_from_a_folder_of_one_part(tmp_path: Path) -> None:
    """A sweep that is over has one part. With ``again_failed`` the failed runs in it have to go."""
    with Folder(tmp_path / "s") as folder:
        folder.write([row(1), row(2, status=store.FAILED), row(3, status=store.REFUSED)])
        folder.compact()
        assert keys(folder) == [1, 2, 3]
        folder.drop(lambda found: found["status"] == store.FAILED)
        assert keys(folder) == [1, 3] and len(folder.parts()) == 1


def test_a_row_in_two_parts_counts_once(tmp_path: Path) -> None:
    """This state remains when a compaction is killed before it has removed the old parts."""
    with Folder(tmp_path / "s") as folder:
        folder.write([row(1), row(2)])
        old = folder.parts()[0].read_bytes()
        folder.write([row(3)])
        folder.compact()
        (tmp_path / "s" / "part-000001.parquet").write_bytes(old)
        assert sorted(keys(folder)) == [1, 2, 3]
    (tmp_path / "s" / ".part-left").write_bytes(b"half")
    with Folder(tmp_path / "s") as folder:
        assert sorted(keys(folder)) == [1, 2, 3] and not (tmp_path / "s" / ".part-left").exists()


def test_the_table_of_a_folder(tmp_path: Path) -> None:
    """A line for each point in the order of its numbers, what has no value last. A dash stands for what was not
    measured, n where not every repeat was. Reasons are counted, ten at the most."""

    def done(number: int, dsps: int, seed: int, misses: int, lag: float | None) -> dict[str, Any]:
        report = report_with(tasks={"pid": {"misses": misses, "on_time": 1}}, errors={"lag": {"crane": {"end_s": lag}}})
        return row(number, place=json.dumps({"machine.dsps": dsps}), seed=seed, report=store.packed(report))

    def refused(number: int, why: str) -> dict[str, Any]:
        return row(number, status=store.REFUSED, message=why, seed=None, report=None)

    with Folder(tmp_path / "n") as folder:
        names = [json.dumps({"future": name}) for name in ("a\nb", "\x1b[31m")]
        folder.write([row(n, place=place, seed=None, status=store.FAILED) for n, place in enumerate(names)])
    named = Sweep(tmp_path / "n").text("misses").splitlines()
    assert [line.split()[0] for line in named[1:3]] == ["\\x1B[31m", "a\\x0Ab"]  # a row is a line
    with Folder(tmp_path / "s") as folder:
        folder.write([refused(20 + n, f"reason {min(n, 10)}\nand more") for n in range(12)])
        folder.write([done(1, 10, 1, 3, None), done(2, 10, 2, 5, None), done(3, 2, 1, 7, 0.5), done(4, 2, 2, 7, None)])
    assert Sweep(tmp_path / "s").text("misses", "lag").splitlines() == [
        "dsps  n  misses (jobs)      lag (s)",
        "   2  2              7  0.5 (n = 1)",
        "  10  2       4 [3, 5]            –",
        "   –  0              –            –",
        "",
        "4 runs done, 12 refused, 0 failed.",
        "Intervals of 95 %: Wilson's of shares of runs, else bootstrap of the mean; none where all repeats agree.",
        *(f"  1 refused: reason {n}" for n in range(10)),
    ]


@pytest.mark.parametrize("wrong", [5, None, ["misses"], b"x"])
def test_what_is_no_metric_is_refused(wrong: Any, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    from cmrc import plot
    from matplotlib.figure import Figure

    with Folder(tmp_path / "s") as folder:
        folder.write([row(1)])
    found, axes = Sweep(tmp_path / "s"), Figure().subplots()
    for call in (
        lambda: found.text(wrong),
        lambda: found.text("misses", wrong),
        lambda: found.table(wrong),
        lambda: found.values(wrong),
        lambda: found.summary(wrong),
        lambda: plot.grid(found, axes, metric=wrong),
        lambda: plot.cost(found, axes, missed=wrong),
    ):
        with pytest.raises(TypeError, match=r"metric: .* cannot be used; the name of a metric, or a function of a rep"):
            call()


def test_a_second_sweep_is_refused_and_names_the_first(tmp_path: Path) -> None:
    with Folder(tmp_path / "s"):
        with pytest.raises(SweepError, match=f"process {os.getpid()} on .* one sweep at a time"):
            Folder(tmp_path / "s").__enter__()
        program = f"from cmrc.sweeps.store import Folder\nFolder({str(tmp_path / 's')!r}).__enter__()"
        done = subprocess.run(
            [sys.executable, "-c", program],
            env={**os.environ, "PYTHONPATH": str(BUILD / "python")},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 1 and "one sweep at a time" in done.stderr
    with Folder(tmp_path / "s"):
        pass


def test_nothing_of_the_user_before_is_left_in_the_lock(tmp_path: Path) -> None:
    """The name of the process or of its machine may have been longer."""
    (tmp_path / "s").mkdir()
    (tmp_path / "s" / store.LOCK).write_text("process 4194304 on " + "long" * 50)
    with Folder(tmp_path / "s"):
        assert (tmp_path / "s" / store.LOCK).read_text() == f"process {os.getpid()} on {socket.gethostname()}"


def test_other_folders_are_refused_by_name(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.tex").write_text("x")
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / store.HEAD).write_text(json.dumps({"format": 0, "cmrc": "0.0.9"}))
    (tmp_path / "bad").mkdir()
    (tmp_path / "bad" / store.HEAD).write_text("{")
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / store.HEAD).write_text("[" * 100_000)
    for name, says in (
        ("file", "is a file"),
        ("full", "not a folder of a sweep"),
        ("bad", "cannot be read"),
        ("deep", "cannot be read"),
        ("old", "written by cmrc 0.0.9 in format 0; cmrc .* reads format 1"),
    ):
        with pytest.raises(SweepError, match=f"{name}.*{says}"):
            Folder(tmp_path / name).__enter__()
    with pytest.raises(SweepError, match="file/s: cannot be made: Not a directory"):
        Folder(tmp_path / "file" / "s").__enter__()
    assert (tmp_path / "full" / "thesis.tex").read_text() == "x" and len(list((tmp_path / "full").iterdir())) == 1


@pytest.mark.parametrize(("schema", "says"), [(3, "is to be made again"), (5, "as new as its writer")])
def test_reports_of_another_schema_are_refused_by_name(schema: int, says: str, tmp_path: Path) -> None:
    with Folder(tmp_path / "s") as folder:
        folder.write([row(1, report=store.packed({"schema_version": schema, "emulator_version": "0.0.7"}))])
    sweep = Sweep(tmp_path / "s")
    assert len(sweep) == 1  # what ran is known
    with pytest.raises(
        SweepError, match=f"s: the report has schema version {schema}, written by emulator 0.0.7.*{says}"
    ):
        sweep.text()


def test_texts_and_numbers_of_every_kind_come_back(tmp_path: Path) -> None:
    """Among them a path that is no UTF-8, as Python has it, and nothing at all."""
    odd = row(1, message="no file: \udcff, ä", seed=None, elapsed_s=None, hash=None, report=None)
    with Folder(tmp_path / "s") as folder:
        folder.write([odd, row(2**62, report=b"\x00\xff")])
        first, second = folder.rows()
    assert first == {**odd, "message": "no file: \\udcff, ä"}
    assert second == row(2**62, report=b"\x00\xff")


def said_by(program: str) -> str:
    """The output of a separate Python process, which also finds this folder's modules."""
    path = os.pathsep.join([str(BUILD / "python"), str(Path(__file__).parent), str(Path(__file__).parents[1])])
    return subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
    ).stdout


def test_a_part_is_written_without_pandas(tmp_path: Path) -> None:
    program = (
        "import sys\nfrom test_sweep_folder import row\nfrom cmrc.sweeps.store import Folder\n"
        f"with Folder({str(tmp_path / 's')!r}) as folder:\n    folder.write([row(1)])\n    print(len(list(folder.rows())))\n"
        "print('pandas' in sys.modules)"
    )
    assert said_by(program).split() == ["1", "False"]


def test_a_damaged_part_is_named(tmp_path: Path) -> None:
    with Folder(tmp_path / "s") as folder:
        folder.write([row(1)])
        folder.parts()[0].write_bytes(folder.parts()[0].read_bytes()[:-20])
        with pytest.raises(SweepError, match=r"part-000001-[0-9a-f]{16}.parquet: cannot be read: it was changed"):
            keys(folder)


def test_a_flipped_bit_of_a_part_is_refused_by_name(tmp_path: Path) -> None:
    with Folder(tmp_path / "s") as folder:
        folder.write([row(1), row(2)])
    part = Folder(tmp_path / "s").parts()[0]
    whole = part.read_bytes()
    for bit in range(0, 8 * len(whole), 61):
        changed = bytearray(whole)
        changed[bit // 8] ^= 1 << bit % 8
        part.write_bytes(changed)
        with pytest.raises(SweepError, match=part.name):
            Sweep(tmp_path / "s")
    part.write_bytes(whole)
    assert len(Sweep(tmp_path / "s")) == 2


def test_a_part_of_an_earlier_version_has_no_checksum_and_is_read_and_compacted(tmp_path: Path) -> None:
    with Folder(tmp_path / "s") as folder:
        folder.write([row(1), row(2)])
        folder.parts()[0].rename(tmp_path / "s" / "part-000001.parquet")
        assert keys(folder) == [1, 2]
        folder.write([row(3)])
        folder.compact()
        assert keys(folder) == [1, 2, 3]
        assert [part.name[:12] for part in folder.parts()] == ["part-000003-"]


def unchecked(folder: Path, **cells: Any) -> None:
    """A part of an earlier version, or made by hand: without a checksum."""
    with Folder(folder) as made:
        made.write([row(1, **cells)])
        made.parts()[0].rename(folder / "part-000001.parquet")


REPORT = report_with()


@pytest.mark.parametrize(("cells", "says"), [
    ({"place": "{"}, "the place of the run 000000000000 is damaged"),
    ({"place": "[1]"}, "the place of the run 000000000000 is damaged"),
    ({"settings": "5"}, "the settings of the run 000000000000 is damaged"),
    *(({"place": f'{{"machine.dsps": {value}}}'}, "the place of the run 000000000000 is damaged: machine.dsps: ")
      for value in ('{"a": 1}', "[1]", "NaN", "1e999", str(2**63))),
    *(({"settings": f'{{"machine.dsps": {value}}}'}, "the settings of the run 000000000000 is damaged: machine.dsps: ")
      for value in ('{"a": 1}', "[1]", "null", "1e999")),
    *(({"settings": f'{{"{name}": {value}}}'}, f"the settings of the run 000000000000 is damaged: {name}")
      for name, value in (("events", 5), ("events", "[1]"), ("events", '[{"at_s": [1]}]'), ("config", 5),
                          ("preset", "[1]"))),
    ({"place": None}, "part-000001.parquet: cannot be read: a run has no place"),
    ({"build": None}, "part-000001.parquet: cannot be read: a run has no build"),
    ({"status": "weird"}, "part-000001.parquet: cannot be read: a run has the status weird"),
    ({"report": b"xx"}, "the report of the run 000000000000 is damaged"),
    ({"report": None}, "the report of the run 000000000000 is damaged"),
    ({"report": store.packed("[]")}, "the report of the run 000000000000 is damaged"),
    ({"report": store.packed("[" * 100_000)}, "the report of the run 000000000000 is damaged"),
    ({"report": store.packed(REPORT)[:-4]}, "the report of the run 000000000000 is damaged: it is cut short"),
    ({"report": store.packed({**REPORT, "tasks": []})}, "the report has no 'tasks'"),
    ({"report": store.packed(" " * ((1 << 20) + 1))}, "is damaged: it is cut short, or larger than 1 MiB"),
])  # fmt: skip
def test_a_cell_that_no_sweep_writes_is_refused_by_name(
    cells: dict[str, Any], says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(store, "LARGEST_REPORT", 1 << 20)
    unchecked(tmp_path / "s", **cells)
    opens = not says.startswith(("the place", "the settings"))
    with pytest.raises(SweepError, match=f"{re.escape(str(tmp_path / 's'))}.*{re.escape(says)}"):
        list(Sweep(tmp_path / "s").reports() if opens else [Sweep(tmp_path / "s")])


@pytest.mark.parametrize("settings", ["{", "5", "[" * 100_000, '{"events": 5}'])
def test_a_refused_row_that_is_damaged_is_named_before_a_run(settings: str, tmp_path: Path) -> None:
    unchecked(tmp_path / "s", status=store.REFUSED, settings=settings)
    grid = {"fixed": {"duration_s": 0.03, "report.reference": "none"}, "axes": {"dsps": [1, 17]}}
    with pytest.raises(SweepError, match="the settings of the run 000000000000 is damaged"):
        sweep(grid, tmp_path / "s", workers=1)


def test_other_columns_and_other_names_are_refused_by_name(tmp_path: Path) -> None:
    from pyarrow import parquet

    unchecked(tmp_path / "s")
    part = tmp_path / "s" / "part-000001.parquet"
    table = parquet.read_table(part)
    parquet.write_table(table.drop_columns(["seed"]), part)
    with pytest.raises(SweepError, match="part-000001.parquet: cannot be read: there is no column seed of int64"):
        Sweep(tmp_path / "s")
    parquet.write_table(table.set_column(0, "key", [[1]]), part)
    with pytest.raises(SweepError, match="part-000001.parquet: cannot be read: there is no column key of string"):
        Sweep(tmp_path / "s")
    part.unlink()
    part.symlink_to("nowhere")
    with pytest.raises(SweepError, match="part-000001.parquet: cannot be read: No such file"):
        Sweep(tmp_path / "s")
    part.rename(tmp_path / "s" / "part-abc.parquet")
    with pytest.raises(SweepError, match="part-abc.parquet: is not the name of a part"):
        Sweep(tmp_path / "s")


def test_a_lock_that_is_a_link_keeps_its_target(tmp_path: Path) -> None:
    with Folder(tmp_path / "s"):
        pass
    (tmp_path / "victim").write_text("precious")
    (tmp_path / "s" / store.LOCK).unlink()
    (tmp_path / "s" / store.LOCK).symlink_to("../victim")
    with pytest.raises(SweepError, match="s/lock: is a link; a file is expected"):
        Folder(tmp_path / "s").__enter__()
    assert (tmp_path / "victim").read_text() == "precious"


def test_a_part_is_written_and_read_in_pieces_of_bounded_size(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A column of Parquet has at most 2 GiB."""
    from pyarrow import parquet

    monkeypatch.setattr(store, "BATCH_BYTES", 10_000)
    with Folder(tmp_path / "s") as folder:
        for first in (0, 10):
            folder.write([row(n, report=os.urandom(3000)) for n in range(first, first + 10)])
        folder.compact()
        (part,) = folder.parts()
        with parquet.ParquetFile(part) as opened:
            sizes = [opened.metadata.row_group(n).num_rows for n in range(opened.num_row_groups)]
        assert sum(sizes) == 20 and max(sizes) == 4
        assert keys(folder) == list(range(20))


def test_nothing_is_left_of_a_part_that_could_not_be_made(tmp_path: Path) -> None:
    with Folder(tmp_path / "s") as folder:
        with pytest.raises(TypeError):
            folder.write([row(1, report=[1])])
        assert not list((tmp_path / "s").glob(".part-*"))


FULL = """
import resource, signal
from pathlib import Path
from test_sweep_folder import row, keys
from cmrc.sweeps.store import Folder
from cmrc.sweeps import SweepError
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
with Folder({path!r}) as folder:
    folder.write([row(1)])
    resource.setrlimit(resource.RLIMIT_FSIZE, (2000, resource.RLIM_INFINITY))
    try:
        folder.write([row(n, message="x" * 50 + str(n) * 40) for n in range(2, 2000)])
    except SweepError as error:
        print(error)
    print(keys(folder), sorted(p.name for p in Path({path!r}).iterdir()))
"""


def test_a_full_disk_is_an_error_and_loses_nothing(tmp_path: Path) -> None:
    """A limit on the size of files simulates a full disk: the write fails half-way."""
    program = FULL.format(path=str(tmp_path / "s"))
    said, after = said_by(program).splitlines()
    assert "part-000002.parquet: cannot be written" in said and "continues from them" in said
    assert re.fullmatch(r"\[1\] \['lock', 'part-000001-[0-9a-f]{16}.parquet', 'sweep.json'\]", after)


FULL_AT_THE_END = """
import os, resource, signal
from test_sweep_folder import row, keys
from cmrc.sweeps.store import Folder
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
with Folder({path!r}) as folder:
    for number in (1, 2):
        folder.write([row(number, report=os.urandom(20_000))])
    resource.setrlimit(resource.RLIMIT_FSIZE, (30_000, resource.RLIM_INFINITY))
    folder.compact()
    print(keys(folder), len(folder.parts()))
    resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    folder.compact()
    print(keys(folder), len(folder.parts()))
"""


def test_without_room_for_all_runs_in_one_part_the_parts_stay(tmp_path: Path) -> None:
    """A sweep whose runs are all there is done; their parts are joined the next time."""
    assert said_by(FULL_AT_THE_END.format(path=str(tmp_path / "s"))) == "[1, 2] 2\n[1, 2] 1\n"


def test_a_folder_that_is_compacted_while_it_is_read_loses_no_row(tmp_path: Path) -> None:
    with Folder(tmp_path / "s") as folder:
        for number in range(1, 5):
            folder.write([row(number)])
        reader = Folder(tmp_path / "s").rows(())
        assert int(next(reader)["key"]) == 1
        folder.compact()
        assert [int(found["key"]) for found in reader] == [2, 3, 4]
