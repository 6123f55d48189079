"""The recording of a run in its page: it agrees with report and signals, and the run is the same with and without
it."""

import base64
import hashlib
import html
import json
import random
import re
import struct
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cmrc
import numpy as np
import pytest
from cmrc import page
from cmrc.page import FIRST_KIND, PageError, Recording
from page_runs import BUSY, HOSTILE, KILLED, KILLED_AT_S, recorded

TICK_S = 1e-9


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[cmrc.Simulation, Recording, Path]:
    path = tmp_path_factory.mktemp("page") / "busy.html"
    return (*recorded(BUSY, KILLED, path), path)


def test_every_job_of_the_report_is_in_the_recording_once(run: tuple[cmrc.Simulation, Recording, Path]) -> None:
    simulation, recording, _ = run
    report = simulation.result().report
    jobs, last = recording.jobs, recording.last_runs()
    for number, kind in enumerate(recording.header["kinds"]):
        own = last[jobs["kind"][last] == number]
        reported = report["tasks"][kind]
        for outcome, name in enumerate(recording.header["outcomes"]):
            assert np.count_nonzero(jobs["outcome"][own] == outcome) == reported[name], (kind, name)
        assert np.count_nonzero(jobs["missed"][own]) == reported["misses"], kind
    assert np.count_nonzero(jobs["missed"]) > 50


def test_misses_have_the_times_that_their_chains_have(run: tuple[cmrc.Simulation, Recording, Path]) -> None:
    _, recording, _ = run
    jobs, last = recording.jobs, recording.last_runs()
    at = {(recording.header["kinds"][jobs["kind"][i]], jobs["robot"][i], jobs["number"][i]): i for i in last.tolist()}
    chains = recording.report["misses"]
    assert len(chains) == 200
    for chain in chains:
        row = at[chain["kind"], chain["robot"], chain["number"]]
        assert jobs["missed"][row]
        assert jobs["released_s"][row] == pytest.approx(chain["release_ps"] * 1e-12, abs=2 * TICK_S)
        assert jobs["deadline_s"][row] == pytest.approx(chain["deadline_ps"] * 1e-12, abs=0.99 * TICK_S)
        if chain["runs"]:
            assert jobs["claimed_s"][row] == pytest.approx(chain["runs"][-1]["claimed_ps"] * 1e-12, abs=2 * TICK_S)
            assert jobs["dsp"][row] == chain["runs"][-1]["dsp"]
            assert recording.header["ends"][jobs["end"][row]] == chain["runs"][-1]["end"]
        assert recording.header["outcomes"][jobs["outcome"][row]] == chain["outcome"]


def test_of_a_job_that_was_run_again_the_last_run_counts(tmp_path: Path) -> None:
    """The DSP that runs identify dies."""
    settings = {"machine.dsps": 2, "duration_s": 0.04, "report.reference": "none"}
    dead = [{"at_s": 0.0215, "action": "fail", "dsp": 0}]
    _, recording = recorded(settings, dead, tmp_path / "a.html")
    jobs, last = recording.jobs, recording.last_runs().tolist()
    rows: dict[tuple[int, ...], list[int]] = {}
    for row, job in enumerate(zip(jobs["kind"].tolist(), jobs["robot"].tolist(), jobs["number"].tolist(), strict=True)):
        rows.setdefault(job, []).append(row)
    assert len(last) == len(rows)
    [twice] = [of for of in rows.values() if len(of) > 1]
    [counts] = set(twice) & set(last)
    assert jobs["claimed_s"][counts] == max(jobs["claimed_s"][twice]) > 0.0215


def test_lanes_leave_no_gap_and_sum_to_what_the_report_says_dsps_did(
    run: tuple[cmrc.Simulation, Recording, Path],
) -> None:
    simulation, recording, _ = run
    for lane, dsp in zip(recording.lanes, simulation.result().report["dsps"], strict=True):
        assert lane.from_s[0] == 0 and lane.to_s[-1] == pytest.approx(0.4, abs=TICK_S)
        assert np.array_equal(lane.from_s[1:], lane.to_s[:-1])
        took = lane.to_s - lane.from_s
        for number, kind in enumerate(recording.header["kinds"]):
            own = lane.what == FIRST_KIND + number
            assert took[own].sum() == pytest.approx(dsp["tasks_ps"].get(kind, 0) * 1e-12, abs=TICK_S * (1 + own.sum()))
        assert np.count_nonzero(lane.run >= 0) == dsp["claims"]


def test_a_killed_dsp_is_dead_from_its_instant_on(run: tuple[cmrc.Simulation, Recording, Path]) -> None:
    _, recording, _ = run
    dead = [np.flatnonzero(lane.what == 1) for lane in recording.lanes]
    assert [rows.size for rows in dead] == [0, 1, 0]
    lane = recording.lanes[1]
    assert lane.from_s[dead[1][0]] == pytest.approx(KILLED_AT_S, abs=TICK_S)
    assert [event["time_s"] for event in recording.report["timed_events"]] == [KILLED_AT_S]


def test_a_dsp_that_is_reset_is_dead_until_then_and_boots(tmp_path: Path) -> None:
    settings = {"machine.dsps": 2, "duration_s": 0.12, "report.reference": "none"}
    _, recording = recorded(settings, [{"at_s": 0.04, "action": "hang", "dsp": 1}], tmp_path / "hung.html")
    dsp, lane = recording.report["dsps"][1], recording.lanes[1]
    assert dsp["resets"] == 1
    reset, boot = dsp["boots"][-1]["reset_at_s"], dsp["boots"][-1]["boot_s"]
    later = np.flatnonzero((lane.what < 2) & (lane.from_s > 0.03))
    assert lane.what[later].tolist() == [1, 0]
    assert lane.from_s[later] == pytest.approx([0.04, reset], abs=2 * TICK_S) and lane.to_s[later[1]] == pytest.approx(
        reset + boot, abs=2 * TICK_S
    )


def test_a_block_that_is_put_back_after_a_reset_ends_no_other_block(tmp_path: Path) -> None:
    """The DSP that had it runs another block by then."""
    settings = {
        "preset": "saturated",
        "machine.dsps": 1,
        "machine.boot": "preloaded",
        "duration_s": 0.1,
        "report.reference": "none",
    }
    _, recording = recorded(settings, [{"at_s": 0.05, "action": "reset", "dsp": 0}], tmp_path / "reset.html")
    [lane], [dsp] = recording.lanes, recording.report["dsps"]
    for number, kind in enumerate(recording.header["kinds"]):
        own = lane.what == FIRST_KIND + number
        took = (lane.to_s - lane.from_s)[own].sum()
        assert took == pytest.approx(dsp["tasks_ps"].get(kind, 0) * 1e-12, abs=TICK_S * (1 + own.sum())), kind


def test_signals_are_the_docks(run: tuple[cmrc.Simulation, Recording, Path]) -> None:
    simulation, recording, _ = run
    result = simulation.result()
    theirs, ours = result.signals, recording.signals
    assert np.array_equal(np.round(ours["time_s"][:-1], 9), np.round(np.arange(0, 0.4, 0.01), 9))
    rows = {round(float(time), 6): i for i, time in enumerate(theirs["time_s"])}
    for name in (
        "s_m",
        "psi_rad",
        "l_m",
        "payload_x_m",
        "payload_z_m",
        "sway_alpha_rad",
        "agv3_x_m",
        "agv2_heading_rad",
        "agv0_speed_m_per_s",
    ):
        for i, time in enumerate(ours["time_s"][:-1]):
            assert ours[name][i] == pytest.approx(theirs[name][rows[round(float(time), 6)]], abs=6e-4), (name, time)
    for axis in "xyz":  # the ghost is where the ideal run's load was
        ghost = ours[f"payload_{axis}_m"] + ours[f"ghost_{axis}_m"]
        for i, time in enumerate(ours["time_s"][1:-1], 1):
            assert ghost[i] == pytest.approx(
                theirs[f"payload_reference_{axis}_m"][rows[round(float(time), 6)]], abs=3e-4
            )
    peak = result.report["errors"]["load_m"]["peak"]
    assert ours["load_error_m"].max() == pytest.approx(peak, abs=2e-9) and peak > 1e-6
    away = [np.hypot(ours[f"agv{n}_ghost_x_m"], ours[f"agv{n}_ghost_y_m"]).max() for n in range(4)]
    peaks = [agv["peak"] for agv in result.report["errors"]["agvs"].values()]
    assert away == pytest.approx(peaks, abs=1e-4) and max(peaks) > 1e-4


def test_watching_changes_nothing(run: tuple[cmrc.Simulation, Recording, Path]) -> None:
    simulation, recording, _ = run
    alone = cmrc.Simulation(settings=BUSY, events=KILLED).run()
    assert alone.hash == simulation.result().hash == recording.report["hash"]


def test_the_command_writes_the_page_that_python_writes(emulator: Path, tmp_path: Path) -> None:
    short = ["--dsps", "2", "--duration", "0.05", "--quiet"]
    subprocess.run([emulator, *short, "--page", "a.html", "--report", "a.json"], cwd=tmp_path, check=True)
    subprocess.run([emulator, *short, "--report", "b.json"], cwd=tmp_path, check=True)
    reported = [json.loads((tmp_path / name).read_text())["hash"] for name in ("a.json", "b.json")]
    _, recording = recorded({"machine.dsps": 2, "duration_s": 0.05}, [], tmp_path / "c.html")
    assert reported[0] == reported[1] == recording.report["hash"]
    ours, theirs = Recording.read(tmp_path / "a.html"), recording
    names = [name for name in ours.names() if name != "report"]
    assert names == [name for name in theirs.names() if name != "report"] and len(names) > 40
    assert all(np.array_equal(ours.whole(name), theirs.whole(name)) for name in names)


def test_a_page_can_begin_at_a_snapshot(emulator: Path, tmp_path: Path) -> None:
    short = ["--dsps", "2", "--duration", "0.12", "--quiet"]
    subprocess.run([emulator, *short, "--snapshot-at", "0.05:half", "--page", "whole.html"], cwd=tmp_path, check=True)
    subprocess.run([emulator, "--resume", "half", "--quiet", "--page", "rest.html"], cwd=tmp_path, check=True)
    whole, rest = (Recording.read(tmp_path / name) for name in ("whole.html", "rest.html"))
    assert rest.header["from_s"] == 0.05 and rest.report["hash"] == whole.report["hash"]
    for all_of_it, part in zip(whole.lanes, rest.lanes, strict=True):
        assert part.from_s[0] == pytest.approx(0.05) and part.to_s[-1] == pytest.approx(0.12)
        later = all_of_it.from_s > 0.051
        assert np.allclose(part.from_s[part.from_s > 0.051], all_of_it.from_s[later], atol=2e-9)
        assert np.array_equal(part.what[part.from_s > 0.051], all_of_it.what[later])
    rows = whole.signals["time_s"] >= 0.05 - 1e-9
    for name in ("payload_x_m", "load_error_m"):
        assert np.allclose(rest.signals[name][1:], whole.signals[name][rows][1:], atol=1e-9)


def test_a_page_that_begins_between_two_latches_has_its_rows_in_place(tmp_path: Path) -> None:
    settings = {**BUSY, "duration_s": 0.08, "report.signal_decimation": 1}
    first = cmrc.Simulation(settings=settings)
    first.run_until(0.0412)
    rest = cmrc.Simulation.resume(first.snapshot())
    rest.record()
    signals = rest.run().signals
    rest.write_page(tmp_path / "rest.html")
    recording = Recording.read(tmp_path / "rest.html")
    rows = recording.signals["time_s"]
    assert rows[0] == 0.0412 == recording.header["from_s"] and list(rows[1:]) == pytest.approx([0.05, 0.06, 0.07, 0.08])
    error = np.sqrt(sum((signals[f"payload_{a}_m"] - signals[f"payload_reference_{a}_m"]) ** 2 for a in "xyz"))
    times = np.round(signals["time_s"], 6)
    before = 0.0412
    assert recording.signals["load_error_m"][0] == pytest.approx(error[times <= before][-1], abs=1e-9)
    for row, time in enumerate(rows[1:], 1):
        largest = error[(times > before) & (times <= time + 1e-9)].max()
        assert recording.signals["load_error_m"][row] == pytest.approx(largest, abs=1e-9), time
        before = time + 1e-9


def test_a_moving_ship_and_its_containers_move(tmp_path: Path) -> None:
    _, recording = recorded(
        {"duration_s": 0.3, "dock.ship_motion": 5.0, "report.reference": "none"}, [], tmp_path / "ship.html"
    )
    assert recording.header["layout"]["ship_moves"] and recording.header["ideal_until_s"] is None
    assert all(np.ptp(recording.signals[name]) > 0 for name in ("ship_x_m", "ship_z_m", "ship_up_y"))
    assert "load_error_m" not in recording.signals and recording.header["containers"] == [[]] * 8


def test_lanes_of_a_run_without_end_stop_somewhere(tmp_path: Path) -> None:
    simulation = cmrc.Simulation(settings={"machine.dsps": 2, "duration_s": 0.2, "report.reference": "none"})
    simulation._core.record(stretches=300)
    simulation.run()
    simulation.write_page(tmp_path / "short.html")
    recording = Recording.read(tmp_path / "short.html")
    assert sum(lane.what.size for lane in recording.lanes) == 300 and recording.header["stretches_left_out"] > 100
    assert 0.02 < recording.header["lanes_until_s"] < 0.2
    assert recording.report["hash"] == simulation.result().hash and recording.signals["time_s"][-1] == pytest.approx(
        0.2
    )


def test_lanes_take_few_bytes(run: tuple[cmrc.Simulation, Recording, Path]) -> None:
    sizes = {entry["name"]: entry["size"] for entry in run[1].header["columns"]}
    stretches = sum(lane.what.size for lane in run[1].lanes)
    assert (
        sum(size for name, size in sizes.items() if name.startswith(("lane.", "run.", "job."))) < 4 * stretches
        and stretches > 1000
    )


def test_columns_are_what_the_varints_say() -> None:
    """Against a decoder of one number at a time."""
    rng = np.random.default_rng(5)
    values = [0, -1, 1, 63, 64, -64, -65, 2**40, -(2**40), *rng.integers(-(10**6), 10**6, 200).tolist()]
    data = b""
    for value in values:
        bits = value * 2 if value >= 0 else -value * 2 - 1
        while bits >= 0x80:
            data += bytes([bits & 0x7F | 0x80])
            bits >>= 7
        data += bytes([bits])
    assert page._numbers(data, len(values), 0).tolist() == values
    assert page._numbers(data, len(values), 1).tolist() == np.cumsum(values).tolist()
    assert page._numbers(data, len(values), 2).tolist() == np.cumsum(np.cumsum(values)).tolist()
    with pytest.raises(PageError, match="another length"):
        page._numbers(data, len(values) + 1, 0)


def test_hostile_names_are_text(tmp_path: Path) -> None:
    path = tmp_path / "hostile.html"
    layout = tmp_path / '<!--<script>"x'
    layout.write_text("[[posts]]\nx_m = 34\ny_m = 12\n", encoding="utf-8")
    settings = {"duration_s": 0.03, "dock.layout": str(layout), "report.reference": "none"}
    _, recording = recorded(settings, [], path, HOSTILE)
    assert recording.report["configuration"]["dock.layout"] == str(layout) and recording.header["title"] == HOSTILE
    recorded(settings, [], tmp_path / "plain.html", "plain")
    text, other = path.read_text(encoding="utf-8"), (tmp_path / "plain.html").read_text(encoding="utf-8")
    assert text.count("<") == other.count("<") and "\u0007" not in text
    title = re.search(r"<title>(.*?)</title>", text)
    assert title and html.unescape(title[1]) == HOSTILE.replace("\u0007", " ")


def test_a_page_may_fetch_nothing(run: tuple[cmrc.Simulation, Recording, Path]) -> None:
    """The policy allows the script and the style that are there, by their hashes, and nothing else."""
    text = run[2].read_text(encoding="utf-8")
    policy = re.search(r'<meta http-equiv="Content-Security-Policy" content="([^"]*)">', text)
    assert policy
    rules = dict(rule.strip().split(" ", 1) for rule in policy[1].split(";"))

    def hash_of(found: re.Match[str] | None) -> str:
        assert found
        return f"'sha256-{base64.b64encode(hashlib.sha256(found[1].encode()).digest()).decode()}'"

    assert rules["default-src"] == "'none'" and "connect-src" not in rules
    assert rules["script-src"] == hash_of(re.search(r'<script type="module">(.*?)</script>', text, re.DOTALL))
    assert rules["style-src"] == hash_of(re.search(r"<style>(.*?)</style>", text, re.DOTALL))
    assert (
        re.findall(r"<(?:link|img|iframe|object|embed)\b|<script[^>]*\bsrc", text.split('<script type="module">')[0])
        == []
    )


def spoiled(page: Path, to: Path, spoil: Callable[[bytes], bytes]) -> Path:
    """The page with another recording in it."""
    text = page.read_text(encoding="utf-8")
    found = re.search(r'id="recording">([^<]*)<', text)
    assert found
    recording = base64.b64encode(spoil(base64.b64decode(found[1]))).decode()
    to.write_text(text.replace(found[1], recording), encoding="utf-8")
    return to


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda data: b"nonsense" + data[8:], "no recording"),
        (lambda data: data[:8] + struct.pack("<I", 40) + data[12:], "damaged"),
        (lambda data: data[:-3000], "."),
        (lambda data: data.replace(b'"format":1', b'"format":9'), "format 9"),
    ],
)
def test_a_damaged_page_is_refused(
    run: tuple[cmrc.Simulation, Recording, Path], tmp_path: Path, spoil, says: str
) -> None:  # type: ignore[no-untyped-def]
    path = spoiled(run[2], tmp_path / "damaged.html", spoil)
    with pytest.raises(PageError, match=says):
        assert Recording.read(path).report
    other = tmp_path / "other.html"
    other.write_text("<html></html>", encoding="utf-8")
    with pytest.raises(PageError, match="not a page of this emulator"):
        Recording.read(other)


def with_header(data: bytes, change: Callable[[Any], Any]) -> bytes:
    (size,) = struct.unpack("<I", data[8:12])
    header = json.dumps(change(json.loads(data[12 : 12 + size]))).encode()
    return data[:8] + struct.pack("<I", len(header)) + header + data[12 + size :]


def read_all(recording: Recording) -> None:
    assert recording.report and recording.signals and recording.lanes and recording.jobs and recording.last_runs().size


@pytest.mark.parametrize(
    "change",
    [
        lambda h: [h],
        lambda h: {**h, "slots": 2**40},
        lambda h: {**h, "slots": "4"},
        lambda h: {**h, "tick_ps": 0},
        lambda h: {**h, "from_s": None},
        lambda h: {**h, "columns": 5},
        lambda h: {**h, "columns": [{**column, "count": "x"} for column in h["columns"]]},
        lambda h: {**h, "columns": [{**column, "unit": None} for column in h["columns"]]},
        lambda h: {**h, "columns": h["columns"][:-4]},
        lambda h: {**h, "planned_rows": [1]},
        lambda h: {**h, "kinds": [1]},
        lambda h: {**h, "layout": {**h["layout"], "ship": [1, 2]}},
        lambda h: {**h, "layout": {**h["layout"], "lanes": [[1]]}},
        lambda h: {**h, "layout": {**h["layout"], "agv": {"count": 10**12}}},
    ],
)
def test_a_changed_header_is_refused_by_name(
    run: tuple[cmrc.Simulation, Recording, Path], change: Callable[[Any], Any], tmp_path: Path
) -> None:
    path = spoiled(run[2], tmp_path / "page.html", lambda data: with_header(data, change))
    with pytest.raises(PageError, match=f"^{re.escape(str(path))}: the recording is damaged: "):
        read_all(Recording.read(path))


def test_a_flipped_bit_is_refused_by_name_or_changes_values(
    run: tuple[cmrc.Simulation, Recording, Path], tmp_path: Path
) -> None:
    """The columns have no checksum: a bit may be another value."""
    drawn = random.Random(1)

    def flipped(data: bytes) -> bytes:
        out = bytearray(data)
        out[drawn.randrange(len(out))] ^= 1 << drawn.randrange(8)
        return bytes(out)

    refused = 0
    for _ in range(60):
        path = spoiled(run[2], tmp_path / "page.html", flipped)
        try:
            read_all(Recording.read(path))
        except PageError as error:
            assert str(error).startswith(f"{path}: ") and str(error).count(str(path)) == 1
            refused += 1
    assert 10 < refused < 60


def test_what_cannot_be_recorded_is_refused(tmp_path: Path) -> None:
    simulation = cmrc.Simulation(duration_s=0.03, settings={"report.reference": "none"})
    with pytest.raises(RuntimeError, match="nothing of this run was recorded"):
        simulation.write_page(tmp_path / "x.html")
    simulation.record()
    with pytest.raises(RuntimeError, match="recorded already"):
        simulation.record()
    with pytest.raises(RuntimeError, match="not over"):
        simulation.write_page(tmp_path / "x.html")
    simulation.run()
    with pytest.raises(TypeError, match="title"):
        simulation.write_page(tmp_path / "x.html", 5)  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []
    simulation.write_page(tmp_path / "x.html")
    assert Recording.read(tmp_path / "x.html").header["title"] == "CMRC: 4 DSPs, 0.03 s"
    late = cmrc.Simulation(duration_s=0.03, settings={"report.reference": "none"})
    late.run()
    with pytest.raises(RuntimeError, match="the run is over"):
        late.record()
