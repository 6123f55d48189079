"""Sweeps on workers of this machine: what is run, what is kept, and what a dead worker costs."""

import contextlib
import itertools
import os
import re
import shutil
import signal
import socket
import subprocess
import threading
import time
from pathlib import Path
from typing import Any

import cmrc
import numpy as np
import pytest
import sweep_helpers
from cmrc.sweeps import Status, Sweep, SweepError, grid, session, store, study, sweep
from cmrc.sweeps.session import Place
from locations import ROOT

pytest.importorskip("distributed")
pytest.importorskip("pyarrow")

FIXED = {"duration_s": 0.03, "report.reference": "none"}
SMALL = {"fixed": FIXED, "axes": {"dsps": [1, 2], "servo_frequency_hz": [500.0, 9000.0]}}
"""Four runs, of which two are refused: f_s is less than 2 f_p."""


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Sweep:
    return sweep(SMALL, tmp_path_factory.mktemp("sweeps") / "small", workers=2)


def test_every_point_is_a_row_and_its_report_is_the_runs(done: Sweep) -> None:
    assert done.counts() == {"done": 2, "refused": 2, "failed": 0} and len(done) == 4
    refused = [run for run in done.runs if run["status"] == "refused"]
    assert all("f_s >= 2 f_p is required" in run["message"] for run in refused)
    alone = cmrc.run(dsps=2, servo_frequency_hz=500.0, settings=FIXED)
    kept = done.report(dsps=2, servo_frequency_hz=500.0)
    assert not cmrc.diff(kept, alone) and kept["hash"] == alone.hash
    table = done.table("misses", "tasks.pid.response_ps.p99")
    assert table.rows == 4 and list(table["machine.dsps"]) == [1, 1, 2, 2]
    assert list(table["seed"]) != [] and "tasks.pid.response_ps.p99" in table
    with pytest.raises(KeyError, match="2 runs"):
        done.report(servo_frequency_hz=500.0)


def test_a_table_has_a_column_for_each_metric(done: Sweep) -> None:
    def status(report: Any) -> bool:
        return True

    table = done.table(lambda report: report["dsps"][0]["slot"], lambda report: np.int64(7), status, "misses")
    assert list(table) == [
        "machine.dsps", "rates.servo_frequency_hz", "seed", "status", "message",
        "<lambda>", "<lambda> 2", "status 2", "misses",
    ]  # fmt: skip
    assert list(table["status"]) == [run["status"] for run in done.runs]
    assert np.nansum(table["<lambda> 2"].astype(float)) == 14 and list(table["status 2"][:1]) == [True]
    assert "<lambda> 2" in done.text(lambda report: 1, lambda report: 2)


def test_a_new_metric_and_the_same_sweep_run_nothing(done: Sweep, monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: object) -> None:
        raise AssertionError("a cluster was started")

    monkeypatch.setattr(session, "cluster_of", never)
    again = sweep(SMALL, done.folder.path)
    assert again.counts() == done.counts()
    assert list(again.values("dsps[0].cycles").values()) == pytest.approx([0.03 * 25e6] * 2, abs=2000)
    assert Sweep(done.folder.path).text() == again.text()


@pytest.mark.usefixtures("one_worker")
def test_a_grid_that_has_grown_runs_what_is_new(done: Sweep, tmp_path: Path) -> None:
    marks = tmp_path / "marks"
    marks.mkdir()
    more = {**SMALL, "axes": {"dsps": [1, 2, 3], "servo_frequency_hz": [500.0, 9000.0]}}
    seen: list[Status] = []
    execute = sweep_helpers.Takes(0.0, marks)
    grown = study.run_grid(grid.made(more), done.folder.path, Place(workers=1), execute, on_progress=seen.append)
    assert (
        len(list(marks.iterdir())) == 1
        and len(grown) == 6
        and seen[-1].known == 4
        and seen[-1].done == seen[-1].runs == 6  # what is refused is done, too
        and seen[-1].refused == 1
    )


@pytest.mark.usefixtures("one_worker")
def test_a_run_of_an_earlier_grid_has_its_place_in_the_new_one(tmp_path: Path) -> None:
    """A setting that was fixed, or had its default, becomes an axis; seeds are added."""
    fixed = {**FIXED, "dsps": 2}
    sweep({"fixed": fixed, "axes": {"servo_frequency_hz": [500.0, 1000.0]}}, tmp_path / "s", workers=1)
    sweep({"fixed": FIXED, "axes": {"servo_frequency_hz": [500.0]}}, tmp_path / "s", workers=1)  # on 4 DSPs, by default
    seen: list[Status] = []
    more = {
        "fixed": FIXED,
        "axes": {"dsps": [1, 2, 4], "servo_frequency_hz": [500.0, 1000.0]},
        "repeats": {"seeds": 2},
    }
    grown = sweep(more, tmp_path / "s", workers=1, on_progress=seen.append)
    assert seen[-1].known == 3 and seen[-1].runs == 12
    for found in (grown, Sweep(tmp_path / "s")):
        assert len(found) == 12 and found.axes == ["machine.dsps", "rates.servo_frequency_hz"]
        assert [spread.n for _, spread in found.summary("misses")] == [2] * 6
        assert sorted(set(found.table("misses")["seed"])) == [1, 2]
        kept = found.report(dsps=2, servo_frequency_hz=1000.0, seed=1)
        assert kept["configuration"]["machine.dsps"] == 2
    assert grown.text() == Sweep(tmp_path / "s").text()


@pytest.mark.usefixtures("one_worker")
def test_runs_of_a_changed_grid_are_no_repeats(tmp_path: Path) -> None:
    """A setting without an axis, the preset, the events, a future of the same name."""
    base: dict[str, Any] = {
        "fixed": {**FIXED, "duration_s": 0.03},
        "axes": {"dsps": [1, 2]},
        "futures": [{"name": "dies", "events": [{"at_s": 0.025, "action": "fail", "dsp": 0}]}],
    }
    at_26 = {"at_s": 0.026, "action": "fail", "dsp": 0}
    paused = {"at_s": 0.021, "action": "pause_host", "lasts_ms": 1.0}
    for changed in (
        base,
        {**base, "fixed": {**FIXED, "duration_s": 0.031}},
        {**base, "fixed": {**FIXED, "preset": "saturated"}},
        {**base, "futures": [{"name": "dies", "events": [at_26]}]},
        {**base, "events": [paused]},
        {**base, "repeats": {"seeds": [1, 2]}},
    ):
        sweep(changed, tmp_path / "s", workers=1)
    found = Sweep(tmp_path / "s")
    assert found.axes == ["machine.dsps", "future", "run.duration_s", "preset", "events"] and len(found) == 12
    fails = "action=fail dsp=0"
    points = {tuple(place.values())[2:]: spread.n for place, spread in found.summary() if place["machine.dsps"] == 2}
    assert points == {
        (0.03, "base", f"at_s=0.025 {fails}"): 2,
        (0.031, "base", f"at_s=0.025 {fails}"): 1,
        (0.03, "saturated", f"at_s=0.025 {fails}"): 1,
        (0.03, "base", f"at_s=0.026 {fails}"): 1,
        (0.03, "base", f"at_s=0.021 action=pause_host lasts_ms=1.0; at_s=0.025 {fails}"): 1,
    }
    assert found.report(dsps=2, duration_s=0.031)["simulated_s"] == 0.031
    paused_too = [place["events"] for place, _ in found.summary() if "pause_host" in place["events"]]
    assert found.report(dsps=1, events=paused_too[0])["timed_events"][0]["what"] == "pause_host for 1 ms"


@pytest.mark.usefixtures("one_worker")
def test_runs_of_a_changed_file_are_no_repeats(tmp_path: Path) -> None:
    config, board = tmp_path / "base.toml", tmp_path / "board.toml"
    regions = [
        ("0x300000", "0x100000", "local", "ram"),
        ("0x70000000", "0x10000000", "local", "window"),
        ("0x80000000", "0x100000", "global", "ram"),
        ("0xC0000000", "0x40000000", "global", "window"),
    ]
    text = "".join(
        f'[[region]]\nname = "{base}"\nbase = {base}\nwords = {words}\nbus = "{bus}"\nkind = "{kind}"\n'
        for base, words, bus, kind in regions
    )
    board.write_text(text)
    small: dict[str, Any] = {"fixed": {**FIXED, "config": str(config)}}
    config.write_text("[rates]\nservo_frequency_hz = 500.0\n")
    sweep({**small, "repeats": {"seeds": [1, 2]}}, tmp_path / "s", workers=1)
    config.write_text("[rates]\nservo_frequency_hz = 250.0\n")
    sweep({**small, "repeats": {"seeds": [3]}}, tmp_path / "s", workers=1)
    found = Sweep(tmp_path / "s")
    assert [(place, spread.n) for place, spread in found.summary()] == [
        ({"rates.servo_frequency_hz": 250.0}, 1),
        ({"rates.servo_frequency_hz": 500.0}, 2),
    ]
    of_board = {"fixed": {**FIXED, "machine.board": str(board)}}
    sweep(of_board, tmp_path / "b", workers=1)
    board.write_text(text + "\n# another\n")
    sweep(of_board, tmp_path / "b", workers=1)
    with pytest.raises(SweepError, match="two runs are at {}, seed None, and are no repeats: a file"):
        Sweep(tmp_path / "b").text()
    assert Sweep(tmp_path / "b").table().rows == 2


@pytest.mark.usefixtures("one_worker")
def test_fixed_seeds_are_repeats(tmp_path: Path) -> None:
    for seed in (1, 2):
        sweep({"fixed": {**FIXED, "seed": seed}}, tmp_path / "s", workers=1)
    found = Sweep(tmp_path / "s")
    assert [(place, spread.n) for place, spread in found.summary()] == [({}, 2)]
    assert list(found.table()["seed"]) == [1, 2]


@pytest.mark.usefixtures("one_worker")
def test_points_that_make_one_run_are_rows_of_their_own(tmp_path: Path) -> None:
    seen: list[Status] = []
    tables = {"fixed": FIXED, "axes": {"turn_order": [1, 2, 3]}}
    found = sweep(tables, tmp_path / "s", workers=1, on_progress=seen.append)
    assert len(found) == 3 and seen[-1].runs == 1 and len({run["hash"] for run in found.runs}) == 1
    assert [place["run.turn_order"] for place, spread in found.summary() if spread.n == 1] == [1, 2, 3]


@pytest.mark.usefixtures("one_worker")
def test_a_row_can_be_run_again_with_its_signals(tmp_path: Path) -> None:
    tables = {
        "fixed": {**FIXED, "preset": "saturated", "duration_s": 0.04},
        "futures": [{"name": "well"}, {"name": "one dies", "events": [{"at_s": 0.025, "action": "fail", "dsp": 1}]}],
    }
    found = sweep(tables, tmp_path / "s", workers=1)
    for run in found.runs:
        again = found.rerun(run, keep_events=True)
        assert again.hash == run["hash"] and again.signals.rows > 1 and again.events
    assert len({run["hash"] for run in found.runs}) == 2


@pytest.mark.usefixtures("one_worker")
def test_n_stands_beside_what_not_every_repeat_has_measured(tmp_path: Path) -> None:
    found = sweep({"fixed": FIXED, "repeats": {"seeds": 3}}, tmp_path / "s", workers=1)
    values = iter([1.0, None, 2.0])
    text = found.text("misses", lambda report: next(values))
    assert "(n = 2)" in text and text.splitlines()[1].split()[0] == "3"


@pytest.mark.usefixtures("one_worker")
def test_repeats_that_agree_have_no_interval_and_the_table_says_so(tmp_path: Path) -> None:
    found = sweep({"fixed": FIXED, "repeats": {"seeds": 2}}, tmp_path / "s", workers=1)
    text = found.text("misses", "any_miss")
    assert "All repeats of every point agree: these numbers have no randomness" in text and "95 %" not in text
    [(place, spread)] = found.summary("misses")
    assert place == {} and spread.n == 2 and not spread.varies
    numbers = iter([1.0, 3.0])
    varied = found.text(lambda report: next(numbers))
    assert "no randomness" not in varied and "Intervals of 95 %" in varied and "2 [1, 3]" in varied


def test_what_changes_no_result_is_not_in_the_key() -> None:
    from cmrc.sweeps.identity import Keys, run_of

    def key(**fixed: Any) -> str:
        return run_of(next(grid.made({"fixed": {"duration_s": 0.03, **fixed}}).points()), Keys()).key

    assert key() == key(turn_order=7) == key(strict=True) == key(dsps=4)
    assert len({key(), key(seed=2), key(dsps=3), key(misses_max=3)}) == 4
    with_event = grid.made({"fixed": {"duration_s": 0.03}, "events": [{"at_s": 0.01, "action": "fail", "dsp": 0}]})
    assert run_of(next(with_event.points()), Keys()).key != key()


def test_the_key_is_over_the_files_and_not_their_names(tmp_path: Path) -> None:
    from cmrc.sweeps.identity import Keys, run_of

    def key(board: Path) -> str:
        return run_of(
            next(grid.made({"fixed": {"duration_s": 0.03, "machine.board": str(board)}}).points()), Keys()
        ).key

    one, same, other = (tmp_path / name for name in ("one.toml", "same.toml", "other.toml"))
    text = (ROOT / "tests" / "peripherals" / "data" / "faults" / "timing-board.toml").read_text()
    one.write_text(text)
    same.write_text(text)
    other.write_text(text + "\n# another\n")
    assert key(one) == key(same) != key(other)


@pytest.mark.unsanitized
def test_a_run_that_ends_its_process_three_times_is_a_failure_and_no_other_run_suffers(tmp_path: Path) -> None:
    marks = tmp_path / "marks"
    marks.mkdir()
    points = grid.made({"fixed": FIXED, "axes": {"dsps": [1, 2, 3, 4, 5, 6]}})
    execute = sweep_helpers.Deadly("dsps = 3", marks)
    found = study.run_grid(points, tmp_path / "s", Place(workers=2), execute)
    assert found.counts() == {"done": 5, "refused": 0, "failed": 1}
    [failed] = [run for run in found.runs if run["status"] == "failed"]
    assert failed["place"] == {"machine.dsps": 3}
    assert failed["message"] == "the run has ended its process 3 times, alone in it: ended by SIGSEGV"
    assert len(list(marks.glob("*-deadly"))) == 5  # twice with its worker, three times alone
    again = study.run_grid(points, tmp_path / "s", Place(workers=1), sweep_helpers.Takes(0, marks), again_failed=True)
    assert again.counts() == {"done": 6, "refused": 0, "failed": 0}


@pytest.mark.usefixtures("one_worker")
def test_a_run_that_is_refused_where_it_runs_is_told_as_refused(tmp_path: Path) -> None:
    points = grid.made({"fixed": FIXED, "axes": {"dsps": [1, 2, 3]}})
    seen: list[Status] = []
    (tmp_path / "marks").mkdir()
    execute = sweep_helpers.Refuses("dsps = 3", tmp_path / "marks")
    found = study.run_grid(points, tmp_path / "s", Place(workers=1), execute, on_progress=seen.append)
    assert found.counts() == {"done": 2, "refused": 1, "failed": 0}
    assert (seen[-1].done, seen[-1].refused, seen[-1].failed) == (3, 1, 0)


def kill_workers(stop: threading.Event, every_s: float, killed: list[int]) -> None:
    """Sends SIGKILL to one worker after the other until none is left."""
    for turn in itertools.count():
        if stop.wait(every_s):
            return
        pids = workers_of(os.getpid())
        if pids:
            with contextlib.suppress(ProcessLookupError):  # it has ended by itself
                os.kill(pids[turn % len(pids)], signal.SIGKILL)
                killed.append(pids[turn % len(pids)])


def parents() -> dict[int, tuple[int, bytes]]:
    """Parent and command line of every process, from /proc."""
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            command = (folder / "cmdline").read_bytes()
            found[int(folder.name)] = (int((folder / "stat").read_text().rsplit(")", 1)[1].split()[1]), command)
        except (OSError, IndexError):
            continue
    return found


def workers_of(starter: int) -> list[int]:
    """Workers of a sweep that this process runs: children of the child that forks them."""
    all_of_them = {
        pid: parent for pid, (parent, command) in parents().items() if b"cmrc.sweeps.local_worker" in command
    }
    return sorted(pid for pid, parent in all_of_them.items() if all_of_them.get(parent) == starter)


def sweep_under_fire(runs: int, every_s: float, takes_s: float, tmp_path: Path) -> tuple[Sweep, list[int], Status]:
    marks = tmp_path / "marks"
    marks.mkdir()
    points = grid.made({"fixed": FIXED, "repeats": {"seeds": runs}})
    stop, killed, seen = threading.Event(), [], []  # type: ignore[var-annotated]
    killer = threading.Thread(target=kill_workers, args=(stop, every_s, killed))
    killer.start()
    try:
        execute = sweep_helpers.Takes(takes_s, marks)
        found = study.run_grid(points, tmp_path / "s", Place(workers=2), execute, on_progress=seen.append)
    finally:
        stop.set()
        killer.join()
    return found, killed, seen[-1]


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="processes are found in /proc")
def test_killed_workers_cost_no_row(tmp_path: Path) -> None:
    found, killed, status = sweep_under_fire(15, 2.5, 0.4, tmp_path)
    assert found.counts() == {"done": 15, "refused": 0, "failed": 0}
    assert killed and sorted(run["seed"] for run in found.runs) == list(range(1, 16))
    assert len(list(found.folder.rows())) == 15 and status.done == 15


@pytest.mark.campaign
@pytest.mark.skipif(not Path("/proc").is_dir(), reason="processes are found in /proc")
def test_workers_killed_every_second_cost_no_row_of_a_hundred(tmp_path: Path) -> None:
    found, killed, status = sweep_under_fire(100, 1.0, 0.5, tmp_path)
    assert found.counts() == {"done": 100, "refused": 0, "failed": 0}
    assert sorted(run["seed"] for run in found.runs) == list(range(1, 101))
    assert len(killed) >= 15 and status.begun_again > 5, (killed, status)


def test_an_interrupted_sweep_keeps_what_was_done_and_continues(tmp_path: Path) -> None:
    marks = tmp_path / "marks"
    marks.mkdir()
    points = grid.made({"fixed": FIXED, "repeats": {"seeds": 8}})

    def interrupt(status: Status) -> None:
        if status.done >= 3:
            raise KeyboardInterrupt

    execute = sweep_helpers.Takes(0.1, marks)
    with pytest.raises(KeyboardInterrupt):
        study.run_grid(points, tmp_path / "s", Place(workers=1), execute, on_progress=interrupt)
    before = Sweep(tmp_path / "s")
    assert 3 <= len(before) < 8
    seen: list[Status] = []
    after = study.run_grid(points, tmp_path / "s", Place(workers=1), execute, on_progress=seen.append)
    assert len(after) == 8 and seen[0].known == len(before)
    deadline = time.monotonic() + 60
    while workers_of(os.getpid()) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert workers_of(os.getpid()) == []


def test_a_cluster_that_is_not_there_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from cmrc.sweeps import cluster

    monkeypatch.setattr(cluster, "CONNECT_S", 0.5)
    with pytest.raises(SweepError, match=r"tcp://127.0.0.1:9: no cluster answers there"):
        sweep(SMALL, tmp_path / "s", address="tcp://127.0.0.1:9")
    with pytest.raises(SweepError, match="no cluster answers"):
        sweep(SMALL, tmp_path / "s", address="nonsense://x")
    with pytest.raises(SweepError, match="one of address and workers"):
        sweep(SMALL, tmp_path / "s", address="tcp://127.0.0.1:9", workers=2)
    assert Sweep(tmp_path / "s").counts() == {"done": 0, "refused": 2, "failed": 0}


def test_whoever_listens_and_does_not_answer_is_no_cluster(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from cmrc.sweeps import cluster

    monkeypatch.setattr(cluster, "CONNECT_S", 1.0)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        began = time.monotonic()
        with pytest.raises(SweepError, match=f"{address}: no cluster answers there: .* has not answered within 1 s"):
            sweep({"fixed": FIXED}, tmp_path / "s", address=address)
        assert time.monotonic() - began < 20


def test_tls_options_are_passed_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A cluster that requires certificates: with the right ones the sweep runs, without them it does not."""
    openssl = shutil.which("openssl")
    if openssl is None:
        pytest.skip("openssl is missing, which makes certificates")
    from cmrc.sweeps import cluster
    from distributed import LocalCluster, Security

    certificate, key = str(tmp_path / "me.pem"), str(tmp_path / "me.key")
    made = [openssl, "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", key, "-out", certificate]
    subprocess.run([*made, "-days", "2", "-subj", "/CN=localhost"], check=True, capture_output=True)
    both = {"tls_ca_file": certificate, "require_encryption": True}
    own = {
        f"tls_{role}_{kind}": path
        for role in ("scheduler", "worker")
        for kind, path in (("cert", certificate), ("key", key))
    }
    mine = {**both, "tls_client_cert": certificate, "tls_client_key": key}
    options = {"processes": False, "protocol": "tls", "host": "127.0.0.1", "dashboard_address": "127.0.0.1:0"}
    monkeypatch.setattr(cluster, "CONNECT_S", 10.0)
    grid_of_one = {"fixed": FIXED}
    with LocalCluster(
        n_workers=1, threads_per_worker=1, silence_logs=50, security=Security(**mine, **own), **options
    ) as safe:
        with pytest.raises(SweepError, match="no cluster answers there"):
            sweep(grid_of_one, tmp_path / "s", address=safe.scheduler_address)
        with pytest.raises(SweepError, match=r"security.tls_client_key: .*none.key is not a file"):
            sweep(
                grid_of_one,
                tmp_path / "s",
                address=safe.scheduler_address,
                security={**mine, "tls_client_key": str(tmp_path / "none.key")},
            )
        found = sweep(grid_of_one, tmp_path / "s", address=safe.scheduler_address, security=mine)
    assert found.counts() == {"done": 1, "refused": 0, "failed": 0}


def test_runs_of_another_build_are_refused(done: Sweep, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(session, "build", lambda: "f" * 64)
    with pytest.raises(
        SweepError, match=f"holds runs of emulator {re.escape(cmrc.__version__)}, build .*; this is build ffffffffffff"
    ):
        sweep(SMALL, done.folder.path)


def test_a_worker_with_another_build_stops_the_sweep(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from cmrc.sweeps import identity

    monkeypatch.setattr(identity, "build", lambda: "f" * 64)
    monkeypatch.setattr(session, "build", lambda: "f" * 64)
    with pytest.raises(SweepError, match="this worker has another build of cmrc"):
        sweep({"fixed": FIXED}, tmp_path / "s", workers=1)


def test_a_missing_extra_says_what_to_install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ImportError, match=r"pip install 'cmrc\[sweep\]'"):
        sweep(SMALL, tmp_path / "s")
    assert not (tmp_path / "s").exists()


def test_bad_arguments() -> None:
    with pytest.raises(TypeError, match="grid"):
        sweep(3, "x")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="workers"):
        sweep(SMALL, "x", workers=0)
    with pytest.raises(TypeError, match="on_progress"):
        sweep(SMALL, "x", on_progress=3)  # type: ignore[arg-type]
    assert store.FORMAT == 1


def test_a_cluster_by_its_address_gives_the_same_reports(done: Sweep, tmp_path: Path) -> None:
    from distributed import LocalCluster

    options = {"processes": False, "protocol": "tcp", "host": "127.0.0.1", "dashboard_address": "127.0.0.1:0"}
    with LocalCluster(n_workers=1, threads_per_worker=1, silence_logs=50, **options) as cluster:
        found = sweep(SMALL, tmp_path / "s", address=cluster.scheduler_address)
    assert found.counts() == done.counts()
    assert not cmrc.diff(found.report(dsps=2, servo_frequency_hz=500.0), done.report(dsps=2, servo_frequency_hz=500.0))
