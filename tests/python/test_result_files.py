"""A result that lasts: saved, loaded, copied, pickled, compared, explained, framed."""

import copy
import io
import json
import pickle
import re
import struct
import subprocess
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cmrc
import numpy as np
import pytest


@pytest.fixture(scope="module")
def result() -> cmrc.Result:
    return cmrc.run(dsps=1, duration_s=0.04, keep_events=True, profile=True)


@pytest.fixture(scope="module")
def other() -> cmrc.Result:
    return cmrc.run(dsps=2, duration_s=0.04, keep_events=True)


def same(one: cmrc.Result, two: cmrc.Result) -> bool:
    return (
        one.report == two.report
        and one.text == two.text
        and one.events == two.events
        and list(one.signals) == list(two.signals)
        and all(np.array_equal(one.signals[name], two.signals[name], equal_nan=True) for name in one.signals)
    )


def test_a_saved_result_is_the_same_when_loaded(result: cmrc.Result, other: cmrc.Result, tmp_path: Path) -> None:
    for n, one in enumerate((result, other)):
        path = tmp_path / f"{n}.cmrc"
        one.save(path)
        loaded = cmrc.Result.load(path)
        assert same(loaded, one)
        assert (loaded.profile is None) == (one.profile is None)
        assert loaded.signals["time_s"].dtype == one.signals["time_s"].dtype
    assert cmrc.Result.load(tmp_path / "0.cmrc").profile.text == result.profile.text  # type: ignore[union-attr]


def test_the_same_result_is_the_same_file(result: cmrc.Result, tmp_path: Path) -> None:
    result.save(tmp_path / "a")
    cmrc.Result.load(tmp_path / "a").save(tmp_path / "b")
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_copies_and_pickles_are_the_same(result: cmrc.Result) -> None:
    for copied in (copy.copy(result), copy.deepcopy(result), pickle.loads(pickle.dumps(result))):
        assert same(copied, result) and copied.tasks.rows == result.tasks.rows
    apart = copy.deepcopy(result)
    apart.report["hash"] = "0"
    assert result.hash != "0"


def test_kept_events_are_the_trace_and_cannot_be_taken_back(
    result: cmrc.Result, emulator: Path, tmp_path: Path
) -> None:
    command = [emulator, "--dsps", "1", "--duration", "0.04", "--trace", tmp_path / "trace"]
    subprocess.run(command, check=False, capture_output=True)
    assert result.events == (tmp_path / "trace").read_text()
    run = cmrc.Simulation(dsps=1, duration_s=0.03, keep_events=True)
    before = run.snapshot()
    run.run_until(0.001)
    with pytest.raises(RuntimeError, match="restore: not with keep_events=True"):
        run.restore(before)
    assert run.fork().result().events is None


def edited(path: Path, into: Path, member: str, content: bytes | None) -> Path:
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(into, "w") as new:
        for name in old.namelist():
            if name != member:
                new.writestr(name, old.read(name))
            elif content is not None:
                new.writestr(name, content)
    return into


def test_what_is_no_result_is_refused_by_name(result: cmrc.Result, tmp_path: Path) -> None:
    whole = tmp_path / "whole"
    result.save(whole)
    bad = [tmp_path / name for name in ("empty", "text", "short", "flipped")]
    bad[0].write_bytes(b"")
    bad[1].write_text("{}")
    bad[2].write_bytes(whole.read_bytes()[:-100])
    changed = bytearray(whole.read_bytes())
    changed[len(changed) // 2] ^= 0xFF
    bad[3].write_bytes(bytes(changed))
    report = dict(result.report)
    bad += [
        edited(whole, tmp_path / "no-report", "report.json", None),
        edited(whole, tmp_path / "no-json", "report.json", b"{"),
        edited(whole, tmp_path / "list", "report.json", b"[]"),
        edited(whole, tmp_path / "deep", "report.json", b"[" * 100_000),
        edited(whole, tmp_path / "kind", "report.json", json.dumps({**report, "configuration": [1]}).encode()),
        edited(whole, tmp_path / "schema", "report.json", json.dumps({**report, "schema_version": 3}).encode()),
        edited(whole, tmp_path / "format", "result.json", b'{"format": 99, "profile": false, "events": false}'),
        edited(whole, tmp_path / "no-arrays", "signals.npz", b"nothing"),
    ]
    for path in bad:
        with pytest.raises(ValueError, match=str(path)):
            cmrc.Result.load(path)
    with pytest.raises(FileNotFoundError):
        cmrc.Result.load(tmp_path / "missing")


def test_a_changed_byte_of_the_directory_is_refused_by_name_or_changes_nothing(tmp_path: Path) -> None:
    """Among them flags of encryption, methods of compression, sizes and places in the file."""
    result = cmrc.run(dsps=1, duration_s=0.021, settings={"report.reference": "none"})
    whole = tmp_path / "whole"
    result.save(whole)
    content = whole.read_bytes()
    (directory,) = struct.unpack("<I", content[-6:-2])
    bad, refused = tmp_path / "bad", []
    for place in range(directory, len(content)):
        for value in {12, 14, content[place] ^ 1} - {content[place]}:
            bad.write_bytes(content[:place] + bytes([value]) + content[place + 1 :])
            try:
                loaded = cmrc.Result.load(bad)
            except ValueError as error:
                assert str(error).startswith(f"{bad}: no saved result ("), (place, value, error)
                refused.append(str(error))
            else:
                assert same(loaded, result), (place, value)
    assert any("encrypted" in error for error in refused)


def test_arrays_that_no_memory_holds_are_refused_by_name(result: cmrc.Result, tmp_path: Path) -> None:
    whole = tmp_path / "whole"
    result.save(whole)
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,), }\n"
    array = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header
    inner = io.BytesIO()
    with zipfile.ZipFile(inner, "w") as archive:
        archive.writestr("time_s.npy", array)
    bomb = edited(whole, tmp_path / "bomb", "signals.npz", inner.getvalue())
    with pytest.raises(ValueError, match=f"{bomb}: no saved result"):
        cmrc.Result.load(bomb)


@pytest.mark.parametrize(("schema", "says"), [
    (3, r"schema version 3, .*the run is to be made again: cmrc\.run\(config=report\)"),
    (99, r"schema version 99, written by emulator .* reads 4: a cmrc as new as its writer"),
])  # fmt: skip
def test_a_result_of_another_schema_is_refused_by_name_and_says_what_to_do(
    schema: int, says: str, result: cmrc.Result, tmp_path: Path
) -> None:
    whole = tmp_path / "whole"
    result.save(whole)
    text = json.dumps({**result.report, "schema_version": schema})
    saved = edited(whole, tmp_path / "saved", "report.json", text.encode())
    (tmp_path / "report.json").write_text(text)
    for path in (saved, tmp_path / "report.json"):
        with pytest.raises(ValueError, match=f"{re.escape(str(path))}: the report has {says}"):
            cmrc.diff(result, path)
    with pytest.raises(ValueError, match=says):
        cmrc.Result.load(saved)


def test_an_older_report_has_what_makes_its_run_again(result: cmrc.Result) -> None:
    """Of a version that had no configuration_toml: all but events, tasks and processes."""
    settings = {name: value for name, value in result.report["configuration"].items() if not isinstance(value, list)}
    assert cmrc.run(settings=settings).hash == result.hash


def test_signals_of_different_lengths_are_refused_by_name(result: cmrc.Result, tmp_path: Path) -> None:
    result.save(tmp_path / "whole")
    arrays = io.BytesIO()
    np.savez(arrays, time_s=np.zeros(4), s_m=np.zeros(3))
    apart = edited(tmp_path / "whole", tmp_path / "apart", "signals.npz", arrays.getvalue())
    with pytest.raises(ValueError, match=f"{re.escape(str(apart))}: .*signals of different lengths"):
        cmrc.Result.load(apart)


def test_a_pickle_among_the_signals_is_not_executed(result: cmrc.Result, tmp_path: Path) -> None:
    class Evil:
        def __reduce__(self) -> tuple[object, ...]:
            return (Path.write_text, (tmp_path / "executed", "x"))

    import io

    whole = tmp_path / "whole"
    result.save(whole)
    arrays = io.BytesIO()
    np.savez(arrays, time_s=np.array([Evil()], dtype=object))
    path = edited(whole, tmp_path / "evil", "signals.npz", arrays.getvalue())
    with pytest.raises(ValueError, match="no saved result"):
        cmrc.Result.load(path)
    assert not (tmp_path / "executed").exists()


def test_columns_of_ones_own_are_saved_or_refused(result: cmrc.Result, tmp_path: Path) -> None:
    """The first two are keywords of numpy.savez."""
    more = copy.deepcopy(result)
    for n, name in enumerate(("file", "allow_pickle", "arr_0", "a/b", "../x", "Größe", "a", "a.npy", "a.npy.npy")):
        more.signals[name] = n + np.arange(more.signals.rows)
    more.save(tmp_path / "more")
    assert same(cmrc.Result.load(tmp_path / "more"), more)
    rows = more.signals.rows
    for name, column in (
        ("a\0b", np.ones(rows)), ("\ud800", np.ones(rows)), ("", np.ones(rows)), (1, np.ones(rows)),
        ("short", np.ones(3)), ("deep", np.ones((rows, 2))), ("objects", np.full(rows, None)), ("no rows", 1.0),
        ("masked", np.ma.masked_equal(np.arange(rows), 0)),
    ):  # fmt: skip
        broken = copy.deepcopy(result)
        broken.signals[name] = column  # type: ignore[index]
        with pytest.raises(ValueError, match=re.escape(repr(name))):
            broken.save(tmp_path / "more")
    more.signals["x" * 70_000] = np.ones(rows)
    with pytest.raises(ValueError, match="at most 1000 characters"):
        more.save(tmp_path / "more")
    del more.signals["x" * 70_000]
    assert same(cmrc.Result.load(tmp_path / "more"), more)
    more.signals = dict(more.signals)  # type: ignore[assignment]
    more.save(tmp_path / "plain")
    assert cmrc.Result.load(tmp_path / "plain").signals.keys() == more.signals.keys()


def test_a_failed_save_keeps_the_file_that_was_there(result: cmrc.Result, tmp_path: Path) -> None:
    with pytest.raises(OSError):
        result.save(tmp_path / "missing" / "a")
    result.save(tmp_path / "a")
    broken = copy.copy(result)
    broken.report = {"not": {1, 2}}  # type: ignore[dict-item]
    with pytest.raises(TypeError):
        broken.save(tmp_path / "a")
    assert cmrc.Result.load(tmp_path / "a").hash == result.hash


def test_a_number_beyond_every_double_differs_without_a_change(result: cmrc.Result, tmp_path: Path) -> None:
    report = json.loads(json.dumps(result.report))
    report["host"]["refreshes"] = 10**400
    for left, right in ((result.report, report), (report, result.report)):
        assert [name for name, *_ in cmrc.diff(left, right).metrics] == ["host.refreshes"]
        assert "(+" not in cmrc.diff(left, right).text() and "(-" not in cmrc.diff(left, right).text()
    (tmp_path / "big.json").write_text(json.dumps(report))
    assert "host.refreshes" in cmrc.diff(result, tmp_path / "big.json").text()


def test_what_is_not_there_is_no_other_value_than_null(result: cmrc.Result) -> None:
    left, right = (json.loads(json.dumps(result.report)) for _ in range(2))
    left["misses"] = [{**result.report["misses"][0], "previous": None}]
    right["misses"] = [{**result.report["misses"][0], "previous": {"kind": "pid"}}]
    assert cmrc.diff(left, right).metrics == [("misses[0].previous.kind", None, "pid")]
    del right["misses"][0]["previous"]
    assert not cmrc.diff(left, right)


def test_a_difference_names_settings_event_and_metrics(result: cmrc.Result, other: cmrc.Result) -> None:
    found = cmrc.diff(result, other)
    assert found and found.configuration == {"machine.dsps": (1, 2)}
    assert found.event is not None
    left, right = (run.events.splitlines() for run in (result, other))  # type: ignore[union-attr]
    first = next(n for n, pair in enumerate(zip(left, right, strict=False)) if pair[0] != pair[1])
    assert (found.event["left_line"], found.event["right_line"]) == (left[first], right[first])
    metrics = {name: (one, two) for name, one, two in found.metrics}
    tasks = result.report["tasks"], other.report["tasks"]
    assert metrics["tasks.pid.misses"] == tuple(task["pid"]["misses"] for task in tasks)
    unlike = [kind for kind in tasks[0] if tasks[0][kind]["response_ps"]["p99"] != tasks[1][kind]["response_ps"]["p99"]]
    assert unlike == [kind for kind in tasks[0] if f"tasks.{kind}.response_ps.p99" in metrics]
    assert not any("elapsed" in name for name in metrics)
    table = found.table
    [own] = [n for n, name in enumerate(table["metric"]) if name == "tasks.pid.misses"]
    one, two = metrics["tasks.pid.misses"]
    assert (table["left"][own], table["right"][own], table["difference"][own]) == (one, two, two - one)
    of_misses = [name.startswith("misses[") for name in table["metric"]]
    assert any(of_misses) and of_misses == sorted(of_misses)  # they come last
    assert "machine.dsps: 1 -> 2" in found.text() and found.event["when"] in found.first
    assert "machine.dsps" in found._repr_html_() and json.dumps(found.to_dict())
    assert result.diff(other).first == found.first


def test_a_job_that_still_ran_is_late_by_the_rest_of_its_run_too() -> None:
    slow = {"machine.cycle_time_factor": 30, "report.reference": "none"}
    cut = cmrc.run(dsps=1, duration_s=0.15, settings=slow)
    running = [n for n, miss in enumerate(cut.missed) if miss["outcome"] == "unfinished" and miss["kind"] == "pid"]
    whole = cmrc.run(dsps=1, duration_s=0.16, settings=slow)
    [same] = [n for n, miss in enumerate(whole.missed) if (miss["kind"], miss["number"]) == ("pid", 148)]
    assert [cut.missed[n]["number"] for n in running] == [148]
    assert cut.missed[running[0]]["usual_ps"] > 1_000_000_000  # longer than from release to deadline
    for explanation in (cut.explain(running[0]), whole.explain(same)):
        assert "before its deadline" not in explanation and "No single cause" in explanation


def test_without_events_the_first_metric_is_named(result: cmrc.Result, other: cmrc.Result) -> None:
    found = cmrc.diff(result.report, other)
    assert found.event is None and found.first.startswith("The first metric that differs is ")
    assert "keep_events=True" in found.first


def test_where_the_hash_alone_differs_a_sentence_says_so(result: cmrc.Result) -> None:
    left, right = copy.deepcopy(result.report), copy.deepcopy(result.report)
    right["hash"] = "0" * 64
    found = cmrc.diff(left, right)
    assert found and found.first.startswith("No metric differs; the events or the final states of the machines do")
    assert (
        found.first in found.text() and found.first in found._repr_html_() and found.to_dict()["first"] == found.first
    )


def many_apart(result: cmrc.Result, metrics: int) -> cmrc.Difference:
    """Two reports that differ in this number of metrics."""
    left, right = copy.deepcopy(result.report), copy.deepcopy(result.report)
    left["host"] = {**left["host"], **{f"number_{n}": n for n in range(metrics)}}
    right["host"] = {**right["host"], **{f"number_{n}": n + 1 for n in range(metrics)}}
    return cmrc.diff(left, right)


def test_a_difference_says_how_many_metrics_it_leaves_out_if_any(result: cmrc.Result) -> None:
    found = many_apart(result, 12)
    assert "host.number_11: 11 -> 12 (+1)" in found.text(most=12) and "more" not in found.text(most=12)
    assert "host.number_11" not in found.text(most=11) and found.text(most=11).endswith("  and 1 more\n")


def test_a_notebook_shows_two_hundred_metrics_that_differ(result: cmrc.Result) -> None:
    assert many_apart(result, 60)._repr_html_().count("<tr><td>metric</td>") == 60
    assert many_apart(result, 300)._repr_html_().count("<tr><td>metric</td>") == 200


def test_a_long_value_is_cut_where_it_would_not_fit(result: cmrc.Result) -> None:
    left, right = copy.deepcopy(result.report), copy.deepcopy(result.report)
    left["configuration"]["dock.layout"], right["configuration"]["dock.layout"] = "f" * 70, "g" * 71
    assert f"dock.layout: {'f' * 70} -> {'g' * 67}...\n" in cmrc.diff(left, right).text()


@pytest.mark.parametrize(("one", "other", "shown"), [
    (1000.0000001, 1000.0000002, "1000.0000001 -> 1000.0000002"),
    ([0] * 40 + [5, 7], [0] * 40 + [6, 7], "[40 alike, 5, 7] -> [40 alike, 6, 7]"),
    ([0] * 40, [0] * 40 + [6], "[40 alike] -> [40 alike, 6]"),
    ([1, *[0] * 40], [2, *[0] * 40], f"[1{', 0' * 21}, ... -> [2{', 0' * 21}, ..."),
    (["f" * 90 + "1"], ["f" * 90 + "2"], f"[...{'f' * 20}1] -> [...{'f' * 20}2]"),
    ("f" * 90 + "1", "f" * 90 + "2", f"...{'f' * 20}1 -> ...{'f' * 20}2"),
])  # fmt: skip
def test_values_that_differ_are_shown_as_different(result: cmrc.Result, one: Any, other: Any, shown: str) -> None:
    left, right = copy.deepcopy(result.report), copy.deepcopy(result.report)
    left["host"]["refreshes"], right["host"]["refreshes"], right["hash"] = one, other, "0" * 64
    found = cmrc.diff(left, right)
    assert f"host.refreshes: {shown}" in found.text() and shown.replace(" -> ", " and ") in found.first
    assert f"<td>{shown.replace(' -> ', '</td><td>')}</td>" in found._repr_html_()


def test_two_runs_of_the_same_are_the_same(result: cmrc.Result) -> None:
    again = cmrc.run(dsps=1, duration_s=0.04, turn_order=3, keep_events=True)
    found = cmrc.diff(result, again)
    assert found.configuration == {"run.turn_order": (0, 3)} and found.metrics == [] and found.event is None
    assert found.same_hash
    assert not cmrc.diff(result, result) and "the same" in cmrc.diff(result, result).text()


def test_files_are_compared_whatever_they_are(result: cmrc.Result, emulator: Path, tmp_path: Path) -> None:
    result.save(tmp_path / "saved")
    command = [emulator, "--dsps", "1", "--duration", "0.04", "--report", tmp_path / "report.json"]
    subprocess.run(command, check=False, capture_output=True)
    assert not cmrc.diff(tmp_path / "saved", str(tmp_path / "report.json"))
    (tmp_path / "none.json").write_text("[1]")
    with pytest.raises(ValueError, match=r"none.json: neither a saved result nor a JSON report"):
        cmrc.diff(tmp_path / "saved", tmp_path / "none.json")
    with pytest.raises(TypeError, match="right"):
        cmrc.diff(result, 7)  # type: ignore[arg-type]


def test_what_was_not_measured_is_null_and_nan(result: cmrc.Result) -> None:
    homes = result.report["tasks"]["home.crane"]
    assert homes["released"] == 0
    for name in ("best", "mean", "p50", "p99", "p99_9", "worst"):
        assert homes["response_ps"][name] is None
    assert homes["start_jitter_ps"]["rms"] is None
    kinds = list(result.tasks["kind"])
    assert np.isnan(result.tasks["response_ps_p99"][kinds.index("home.crane")])
    assert result.tasks["response_ps_p99"][kinds.index("pid")] == result.report["tasks"]["pid"]["response_ps"]["p99"]


def test_the_frame_is_tidy_and_has_the_columns_of_the_docs(result: cmrc.Result) -> None:
    pytest.importorskip("pandas")
    from locations import ROOT

    frame = result.to_frame()
    columns = "`" + "`, `".join(frame.columns) + "`"
    assert columns in (ROOT / "docs" / "experiments.md").read_text(encoding="utf-8")
    assert not frame.duplicated(["kind", "metric"]).any()
    value = frame.set_index(["kind", "metric"])["value"]
    unit = frame.set_index(["kind", "metric"])["unit"]
    assert [unit["pid", f"response_ps_{of}"] for of in ("count", "best", "worst")] == ["jobs", "ps", "ps"]
    assert [unit["pid", f"start_jitter_ps_{of}"] for of in ("count", "rms")] == ["jobs", "ps"]
    assert value["pid", "released"] == result.report["tasks"]["pid"]["released"]
    assert value["run", "misses"] == result.misses
    assert np.isnan(value["home.crane", "response_ps_p99"])
    assert value["pid", "response_ps_p99"] == result.report["tasks"]["pid"]["response_ps"]["p99"]


@pytest.mark.golden
def test_the_frame_has_the_metrics_and_units_that_are_kept(
    result: cmrc.Result, golden: Callable[[str, str], None]
) -> None:
    from cmrc import frames

    rows = list(frames.rows(result.report))
    kinds = {kind: [(metric, unit) for of, metric, unit, _ in rows if of == kind] for kind, *_ in rows}
    assert list(kinds) == [*result.report["tasks"], "run"]
    assert all(kinds[kind] == kinds["pid"] for kind in result.report["tasks"])
    golden(
        "frame.table", "".join(f"{kind} {metric} [{unit}]\n" for kind in ("pid", "run") for metric, unit in kinds[kind])
    )


def test_the_table_of_the_buses_has_a_row_for_each_master(result: cmrc.Result) -> None:
    buses = result.buses
    masters = [(name, master) for name, bus in result.report["buses"].items() for master in bus["masters"]]
    assert list(zip(buses["bus"], buses["master"], strict=True)) == masters
    assert not any("targets" in name for name in buses) and {"utilisation", "clocks_by_use_data"} < set(buses)


def test_a_notebook_shows_a_table(result: cmrc.Result) -> None:
    shown = result._repr_html_()
    assert "<td>pid</td>" in shown and "home.crane" not in shown
    response = result.report["tasks"]["pid"]["response_ps"]
    times = "".join(f"<td>{response[of] / 1e6:.2f}</td>" for of in ("mean", "p99", "worst"))
    pid = result.report["tasks"]["pid"]
    assert f"<td>pid</td><td>{pid['released']}</td><td>{pid['misses']}</td>{times}</tr>" in shown
    hostile = copy.deepcopy(result)
    hostile.report["tasks"]["<script>"] = hostile.report["tasks"]["pid"]
    assert "<script>" not in hostile._repr_html_()


def test_the_version_is_in_every_report(result: cmrc.Result) -> None:
    assert cmrc.__version__ == result.version == result.report["emulator_version"]


def test_an_explanation_names_what_blocked_the_job(result: cmrc.Result) -> None:
    first = min(result.missed, key=lambda miss: miss["deadline_ps"])
    text = result.explain()
    assert text == result.explain(result.missed.index(first))
    assert f"{first['kind']} number {first['number']} of the crane" in text
    for n, miss in enumerate(result.missed):
        explanation = result.explain(n)
        for block in sorted(miss["behind"], key=lambda block: -block["share_ps"])[:3]:
            assert f"{block['kind']} number {block['number']}" in explanation
        if miss["outcome"] == "late":
            assert "too late" in explanation and ("Without" in explanation or "No single cause" in explanation)
    assert "identify" in " ".join(result.explain(n) for n in range(len(result.missed)))
    with pytest.raises(IndexError, match="one by one"):
        result.explain(len(result.missed))
    none = cmrc.run(dsps=2, duration_s=0.03)
    assert none.explain() == "No job missed its deadline."
    with pytest.raises(IndexError, match="n: -1 is out of range; the report lists no missed job$"):
        none.explain(-1)
    assert "misses_max" in cmrc.run(dsps=1, duration_s=0.04, misses_max=0).explain()


def test_what_would_have_avoided_it_is_the_chains_arithmetic(result: cmrc.Result) -> None:
    late = next(
        n
        for n, miss in enumerate(result.missed)
        if miss["outcome"] == "late" and max(miss["parts_ps"].values()) > miss["lateness_ps"]
    )
    miss = result.missed[late]
    spare = max(miss["parts_ps"].values()) - miss["lateness_ps"]
    said = next(
        f"{spare / size:.4g} {unit}"
        for unit, size in (("s", 1e12), ("ms", 1e9), ("us", 1e6), ("ns", 1e3))
        if spare >= size
    )
    assert f"would have been done {said} before its deadline" in result.explain(late)


def test_what_never_ran_would_still_have_had_to_run() -> None:
    """Both DSPs are gone from 25 ms on: without the wait for one the job would have ended a usual run after its
    release."""
    events = [{"at_s": 0.025, "action": "fail", "dsp": dsp} for dsp in (0, 1)]
    result = cmrc.run(dsps=2, duration_s=0.03, events=events, settings={"report.reference": "none"})
    waited = [
        n for n, miss in enumerate(result.missed) if miss["outcome"] == "never_started" and "no_dsp" in miss["parts_ps"]
    ]
    miss = result.missed[waited[0]]
    spare = miss["parts_ps"]["no_dsp"] - miss["lateness_ps"] - miss["usual_ps"]
    assert miss["parts_ps"]["not_run"] == -miss["usual_ps"] < 0
    assert (
        f"no DSP was running, the job would have been done {spare / 1e6:.4g} us before its deadline"
        in result.explain(waited[0])
    )
