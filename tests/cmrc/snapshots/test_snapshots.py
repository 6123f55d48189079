"""Snapshots: a run that continues from a snapshot is the same as a run that never stopped (docs/snapshots.md)."""

from __future__ import annotations

import json
import os
import pickle
import random
import subprocess
import sys
from pathlib import Path
from typing import Any

import cmrc
import pytest
from cmrc import _core
from locations import AT_ONCE, BUILD, ROOT

EMULATOR = BUILD / "bin" / "emulator"
core = _core.cmrc
SCENES: dict[str, dict[str, Any]] = {
    "booting": {"dsps": 2, "duration_s": 0.06, "report.reference": "none"},
    "at_once": {"dsps": 4, "duration_s": 0.06, "report.reference": "none", **AT_ONCE},
    "heavy": {"dsps": 2, "preset": "heavy", "duration_s": 0.06, "report.reference": "none", "agvs": 2, **AT_ONCE},
    "gantry": {"dsps": 3, "crane": "gantry", "duration_s": 0.05, "report.reference": "none", **AT_ONCE},
    "one_bus": {"dsps": 3, "topology": "single", "duration_s": 0.05, "report.reference": "none", **AT_ONCE},
    "bridged": {
        "dsps": 3,
        "topology.buses": "A B",
        "topology.boards": "A",
        "topology.bridges": "A-B",
        "run.phase_jitter": True,
        "bus.multi_transaction_clocks": 40,
        "duration_s": 0.05,
        "agvs": 2,
        "report.reference": "none",
        **AT_ONCE,
    },
    "troubled": {
        "dsps": 4,
        "duration_s": 0.06,
        "report.reference": "none",
        "watchdog.silence_ms": 4.0,
        "dock.sway_sensors": 2,
        **AT_ONCE,
    },
}
EVENTS: dict[str, list[dict[str, Any]]] = {
    "at_once": [{"at_s": 0.021, "action": "fail", "dsp": 1}, {"at_s": 0.03, "action": "slow", "dsp": 0, "factor": 0.7}],
    "heavy": [{"at_s": 0.02, "action": "hang", "dsp": 0}, {"at_s": 0.035, "action": "stall_bus", "bus": "A", "lasts_ms": 0.3}],
    "gantry": [{"at_s": 0.0213, "action": "unplug", "dsp": 2}, {"at_s": 0.0307, "action": "plug", "dsp": 2},
               {"at_s": 0.025, "action": "set", "key": "scheduling.p", "value": 0x5000}],
    "troubled": [{"at_s": 0.010, "action": "stick_sway", "axis": "alpha"}, {"at_s": 0.012, "action": "stick_encoder", "joint": "slew"},
                 {"at_s": 0.0150401, "action": "hang", "dsp": 1}, {"at_s": 0.0160302, "action": "freeze", "dsp": 2}, {"at_s": 0.018, "action": "pause_host", "lasts_ms": 1.5},
                 {"at_s": 0.020, "action": "set", "key": "control.slew_bandwidth_rad_s", "value": 9.0}, {"at_s": 0.022, "action": "stall_bus", "bus": "A", "lasts_ms": 0.4},
                 {"at_s": 0.024, "action": "fail_drive", "joint": "luff"}, {"at_s": 0.028, "action": "break_link", "dsp": 3}, {"at_s": 0.0290301, "action": "reset", "dsp": 3},
                 {"at_s": 0.034, "action": "repair_link", "dsp": 3}, {"at_s": 0.036, "action": "repair_drive", "joint": "luff"},
                 {"at_s": 0.040, "action": "slow", "dsp": 0, "factor": 0.2}, {"at_s": 0.044, "action": "stick_load_cell"}],
}  # fmt: skip


def configuration(scene: str, **more: Any) -> Any:
    settings = {**SCENES[scene], **more}
    preset = settings.pop("preset", None)
    return core.config(preset=preset, settings=settings, events=EVENTS.get(scene, []))


def without_elapsed(report: str) -> Any:
    found = json.loads(report)
    found.pop("elapsed_s")
    return found


def seen(simulation: Any) -> Any:
    return without_elapsed(simulation.report_json()), simulation.dock_events(), simulation.time_s


def to_the_end(simulation: Any) -> Any:
    simulation.run()
    return seen(simulation), simulation.snapshot().state


def instants(scene: str, count: int) -> list[float]:
    """In turn: any instant; one in the traffic after a refresh of the list; one soon after an event of the scene."""
    rng = random.Random(scene)
    end = SCENES[scene]["duration_s"]
    events = [event["at_s"] for event in EVENTS.get(scene, [])]
    found = []
    for number in range(count):
        instant = rng.uniform(0, end)
        if number % 3 == 1:
            instant = round(instant * 8000) / 8000 + rng.uniform(0, 60e-6)
        elif number % 3 == 2 and events:
            instant = rng.choice(events) + rng.uniform(0, 1.5e-3) * rng.random()
        found.append(int(min(instant, end * 0.999) * 1e12) * 1e-12)
    return found


@pytest.mark.parametrize("scene", SCENES)
def test_a_run_continues_from_any_instant_as_if_never_stopped(scene: str) -> None:
    whole = to_the_end(core.Simulation(configuration(scene)))
    for instant in instants(scene, 6):
        first = core.Simulation(configuration(scene))
        first.run_until(instant)
        snapshot = core.Snapshot.from_bytes(first.snapshot().to_bytes())
        resumed = core.Simulation(configuration(scene))
        resumed.restore(snapshot)
        assert resumed.difference(first) is None, instant
        assert seen(resumed) == seen(first), instant
        assert to_the_end(resumed) == whole, instant
        assert to_the_end(first) == whole, instant  # looking at the run changed nothing


@pytest.mark.parametrize("scene", SCENES)
def test_the_state_at_an_instant_does_not_depend_on_how_the_run_came_there(scene: str) -> None:
    rng = random.Random(scene)
    for instant in instants(scene, 3):
        straight = core.Simulation(configuration(scene))
        straight.run_until(instant)
        cut = core.Simulation(configuration(scene, turn_order=rng.randrange(1, 1 << 30)))
        for earlier in sorted(rng.uniform(0, instant) for _ in range(30)):
            cut.run_until(earlier)
        cut.run_until(instant)
        assert cut.difference(straight) is None, instant
        assert cut.snapshot().state == straight.snapshot().state


def test_a_boot_that_was_given_up_is_reported_however_the_run_is_cut_there() -> None:
    """The host reports it at its next rest: here after an access to another DSP's port, 50 to 54 us after power-on."""
    settings = {
        "machine.dsps": 4,
        "machine.boot": "link",
        "watchdog.boot_limit_ms": 0.05,
        "report.reference": "none",
        "duration_s": 0.03,
    }
    config = core.config(settings=settings, events=[{"at_s": 0.0, "action": "unplug", "dsp": 1}])
    first = core.Simulation(config)
    for quarter in range(200, 220):
        first.run_until(quarter * 0.25e-6)
        resumed = core.Simulation(config)
        resumed.restore(first.snapshot())
        resumed.run_until(60e-6)
        failures = json.loads(resumed.report_json())["failures"]
        assert [(one["dsp"], one["kind"], one["message"]) for one in failures] == [
            (1, "boot", "it never requested its program")
        ], quarter


def test_going_back_and_on_again_and_again() -> None:
    simulation = core.Simulation(configuration("heavy"))
    simulation.run_until(0.01)
    snapshots = [simulation.snapshot()]
    for step in range(1, 5):
        simulation.run_until(0.01 + step * 0.0093)
        snapshots.append(simulation.snapshot())
    whole = to_the_end(simulation)
    rng = random.Random(1)
    for _ in range(6):
        index = rng.randrange(len(snapshots))
        simulation.restore(snapshots[index])
        for later in snapshots[index + 1 :]:
            simulation.run_until(later.time_s)
            assert simulation.snapshot().state == later.state
    simulation.restore(snapshots[0])
    assert to_the_end(simulation) == whole


def test_two_futures_of_one_past() -> None:
    run = cmrc.Simulation(dsps=2, duration_s=0.05, settings={**AT_ONCE, "report.reference": "none"})
    run.run_until(0.03)
    other = run.fork()
    other.at(0.03, "fail", dsp=1)
    with_two, with_one = run.run(), other.run()
    failed = cmrc.run(
        dsps=2,
        duration_s=0.05,
        settings={**AT_ONCE, "report.reference": "none"},
        events=[{"at_s": 0.03, "action": "fail", "dsp": 1}],
    )
    assert with_one.hash == failed.hash != with_two.hash


def test_a_fork_has_the_ideal_run_beside_it() -> None:
    run = cmrc.Simulation(dsps=2, duration_s=0.05, settings=AT_ONCE)
    run.run_until(0.02)
    other = run.fork()
    assert run.run().errors == other.run().errors


RESUME = """
import sys, json, cmrc
run = cmrc.Simulation.resume(sys.argv[1])
result = run.run()
print(json.dumps([result.hash, result.report["errors"]]))
"""


def test_another_process_continues(tmp_path: Path) -> None:
    """The command and Python continue, each from the other's file; the ideal run is made again."""
    options = ["--quiet", "--dsps", "2", "--duration", "0.06"]
    for name, value in AT_ONCE.items():
        options += ["--set", f"{name}={value}"]
    reports = []
    for number, arguments in enumerate([
        [*options, "--snapshot-at", "0.0312345:later.snap", "--snapshot-at", "0.02:snap"],
        ["--quiet", "--resume", "snap"],
        ["--quiet", "--resume", "later.snap"],
    ]):  # fmt: skip
        finished = subprocess.run(
            [EMULATOR, *arguments, "--report", f"{number}.json"],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
        )
        assert finished.returncode in (0, 1) and finished.stderr == "", finished.stderr
        report = json.loads((tmp_path / f"{number}.json").read_text())
        report.pop("elapsed_s")
        report.pop("reference_elapsed_s")
        reports.append(report)
    assert reports[0] == reports[1] == reports[2]
    python = subprocess.run(
        [sys.executable, "-c", RESUME, "snap"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(BUILD / "python")},
    )
    assert python.returncode == 0, python.stderr
    digest, errors = json.loads(python.stdout)
    assert (digest, errors) == (reports[0]["hash"], reports[0]["errors"])
    cmrc.write_snapshot(tmp_path / "python.snap", cmrc.read_snapshot(tmp_path / "snap"))
    assert (tmp_path / "python.snap").read_bytes() == (tmp_path / "snap").read_bytes()


@pytest.mark.parametrize("dsps", [1, 2, 4])
def test_the_two_parts_of_a_golden_scenes_trace_are_the_whole(tmp_path: Path, dsps: int) -> None:
    """The scenes of tests/cli/test_golden_scene.py, cut at a picosecond within the window that is traced."""
    picosecond = random.Random(dsps).randrange(22_000_000_000, 29_000_000_000)
    slots = [word for slot in range(dsps) for word in ("--trace-instructions", str(slot))]
    common = ["--quiet", "--trace-window", "0.02:0.03", *slots]
    whole = [
        "--dsps",
        str(dsps),
        "--duration",
        "0.05",
        "--set",
        "report.reference=none",
        "--snapshot-at",
        f"{picosecond * 1e-12:.12f}:snap",
        "--trace",
        "whole",
    ]
    for arguments in (whole, ["--resume", "snap", "--trace", "rest"]):
        assert subprocess.run([EMULATOR, *common, *arguments], cwd=tmp_path, check=False).returncode == 0

    def parts(name: str) -> tuple[list[str], list[str]]:
        lines = (tmp_path / name).read_text().splitlines()
        return [line for line in lines if not line[0].isdigit()], [line for line in lines if line[0].isdigit()]

    header, events = parts("whole")
    header_of_rest, rest = parts("rest")
    assert header == header_of_rest
    early = [line for line in events if float(line.split()[0]) < picosecond * 1e-12 - 0.001]
    assert early and rest and [*early, *rest] == events
    executed = 0
    for slot in range(dsps):
        _, instructions = parts(f"whole.dsp{slot}")
        _, later = parts(f"rest.dsp{slot}")
        assert instructions[len(instructions) - len(later) :] == later
        executed += 0 < len(later) < len(instructions)
    assert executed > 0  # with four, one is idle


def test_a_snapshot_is_refused_by_name_and_nothing_has_changed(tmp_path: Path) -> None:
    simulation = core.Simulation(configuration("at_once"))
    simulation.run_until(0.01)
    snapshot = simulation.snapshot()
    other = core.Simulation(configuration("at_once", dsps=3))
    other.run_until(0.005)
    state = other.snapshot().state
    with pytest.raises(cmrc.SnapshotError, match=r"another configuration: \[machine\] dsps = 4, here dsps = 3"):
        other.restore(snapshot)
    assert other.snapshot().state == state and other.time_s == 0.005
    whole = snapshot.to_bytes()
    assert pickle.loads(pickle.dumps(snapshot)).to_bytes() == whole
    rng = random.Random(1)
    for _ in range(40):
        damaged = bytearray(whole)
        damaged[rng.randrange(len(whole))] ^= 1 << rng.randrange(8)
        with pytest.raises(cmrc.SnapshotError):
            core.Snapshot.from_bytes(bytes(damaged))
        with pytest.raises(cmrc.SnapshotError):
            core.Snapshot.from_bytes(whole[: rng.randrange(len(whole))])
    (tmp_path / "bad").write_bytes(whole[:-1])
    with pytest.raises(cmrc.SnapshotError, match=r"bad: the snapshot was cut short"):
        cmrc.read_snapshot(tmp_path / "bad")
    with pytest.raises(TypeError, match="snapshot: "):
        cmrc.Simulation(duration_s=0.03).restore("snap")  # type: ignore[arg-type]


def test_a_file_has_room_for_what_a_second_adds() -> None:
    """10 MB for 180 s of the default dock with 4 DSPs (issue 18): 55 kB per second, and the fixed part with which each
    run begins."""
    simulation = core.Simulation(core.config(settings={"dsps": 4, "duration_s": 180.0}))
    sizes = []
    for instant in (2.0, 5.0):
        simulation.run_until(instant)
        snapshot = simulation.snapshot()
        sizes.append(len(snapshot.to_bytes()))
        again = core.Snapshot.from_bytes(snapshot.to_bytes())
        assert again.state == snapshot.state and again.to_bytes() == snapshot.to_bytes()
    assert sizes[0] < 400_000 and (sizes[1] - sizes[0]) / 3 < 55_000, sizes


def test_a_report_leaves_the_rest_as_it_is_and_a_last_report_ends_the_run() -> None:
    whole = to_the_end(core.Simulation(configuration("at_once")))
    simulation = core.Simulation(configuration("at_once"))
    simulation.run_until(0.0213)
    then, report = simulation.snapshot(), simulation.report_json()
    assert simulation.report_json() == report and simulation.snapshot().state == then.state
    last = without_elapsed(simulation.report_so_far_json())
    assert last == without_elapsed(report)
    for call in (simulation.run, lambda: simulation.run_until(0.03), simulation.snapshot):
        with pytest.raises(RuntimeError, match="report_so_far has ended the run"):
            call()
    simulation.restore(then)
    assert to_the_end(simulation) == whole


def test_a_snapshot_from_inside_a_callback_and_of_a_profile_is_refused() -> None:
    simulation = cmrc.Simulation(dsps=1, duration_s=0.03, settings={**AT_ONCE, "report.reference": "none"})
    refused: list[str] = []

    def on_progress(_now: float, _end: float) -> None:
        for call in (simulation.snapshot, simulation.fork):
            try:
                call()
            except RuntimeError as error:
                refused.append(str(error))

    simulation.run(on_progress)
    assert len(refused) >= 2 and "from inside a callback" in refused[0]
    profiled = cmrc.Simulation(dsps=1, duration_s=0.03, profile=True, settings={**AT_ONCE, "report.reference": "none"})
    with pytest.raises(RuntimeError, match="a run with a profile has no snapshots"):
        profiled.snapshot()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--snapshot-at", "x:f"], 'is not S:FILE'),
        (["--snapshot-at", "0.01:"], 'is not S:FILE'),
        (["--snapshot-at", "1:f", "--duration", "0.5"], "1 s is after the end of the run; it ends at 0.5 s"),
        (["--resume", "there_is_none"], "there_is_none: cannot be read"),
        (["--resume", "text"], "text: 5 bytes that are not a snapshot"),
        (["--resume", "snap", "--dsps", "2"], "another configuration: [machine] dsps = 1, here dsps = 2"),
        (["--resume", "snap", "--report", "snap"], "--report: snap is the same file as --resume"),
        (["--resume", "snap", "--snapshot-at", "0.001:f"], "0.001 s has passed"),
        (["--resume", "snap", "--profile"], "a run with a profile has no snapshots"),
        (["--snapshot-at", "0.01:f", "--report", "f"], "--report: f is the same file as --snapshot-at"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_said_before_anything_runs(tmp_path: Path, arguments: list[str], words: str) -> None:
    (tmp_path / "text").write_text("hello")
    simulation = core.Simulation(core.config(settings={"dsps": 1, "duration_s": 0.03, "report.reference": "none"}))
    simulation.run_until(0.01)
    (tmp_path / "snap").write_bytes(simulation.snapshot().to_bytes())
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    finished = subprocess.run([EMULATOR, *arguments], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert finished.returncode == 2 and words in finished.stderr, finished.stderr
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_file_is_the_same_by_whatever_name(tmp_path: Path) -> None:
    """A configuration's paths begin at its folder, so the spelling of its own path is part of theirs."""
    (tmp_path / "d").mkdir()
    for name in ("lay.toml", "other.toml", "same.toml"):
        (tmp_path / "d" / name).write_text("[warehouse]\ntake_s = 20\n" if name != "other.toml" else "")
    text = '[run]\nduration_s = 0.03\n[report]\nreference = "none"\n[dock]\nlayout = "lay.toml"\n'
    for name in ("lay", "other", "same"):
        (tmp_path / "d" / f"run_{name}.toml").write_text(text.replace("lay.toml", f"{name}.toml"))

    def run(*arguments: str | Path, folder: Path = tmp_path) -> subprocess.CompletedProcess[str]:
        return subprocess.run([EMULATOR, *arguments], cwd=folder, capture_output=True, text=True, check=False)

    assert run("--config", "d/run_lay.toml", "--snapshot-at", "0.01:s.snap", "--quiet").returncode == 0
    again = [(tmp_path, name) for name in ("./d/run_lay.toml", tmp_path / "d/run_lay.toml", "d/run_same.toml")]
    for folder, name in [*again, (tmp_path / "d", "run_lay.toml")]:
        ended = run("--resume", tmp_path / "s.snap", "--config", name, "--quiet", folder=folder)
        assert (ended.returncode, ended.stderr) == (0, "")
    refused = run("--resume", "s.snap", "--config", "d/run_other.toml", "--quiet").stderr
    assert 'another program, layout or board: [dock] layout = "d/lay.toml", here layout = "d/other.toml"' in refused
    (tmp_path / "d" / "lay.toml").write_text("")
    for name, why in (("d/run_lay.toml", "have changed since"), ("./d/run_lay.toml", 'here layout = "./d/lay.toml"')):
        ended = run("--resume", "s.snap", "--config", name, "--quiet")
        assert ended.returncode == 2 and why in ended.stderr


def test_a_run_that_is_over_before_says_so(tmp_path: Path) -> None:
    toml = tmp_path / "dies.toml"
    toml.write_text('[machine]\ndsps = 1\nboot = "preloaded"\n[run]\nduration_s = 3.0\nafter_stop_s = 0.1\n[report]\nreference = "none"\n'
                    '[[events]]\nat_s = 0.05\naction = "fail"\ndsp = 0\n')  # fmt: skip
    finished = subprocess.run(
        [EMULATOR, "--quiet", "--config", toml, "--snapshot-at", "0.01:early", "--snapshot-at", "2.5:late"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert finished.returncode == 1 and "late is not written; the run ended at" in finished.stderr
    assert (tmp_path / "early").exists() and not (tmp_path / "late").exists()


def test_the_example_asks_what_would_have_happened() -> None:
    ran = subprocess.run(
        [sys.executable, ROOT / "examples" / "what_if.py"],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": str(BUILD / "python")},
    )
    fails, does_not = ran.stdout.splitlines()
    misses = [int(line.split(" deadlines")[0].split()[-1]) for line in (fails, does_not)]
    assert fails.startswith("DSP 1 fails at 0.5 s") and misses[0] > misses[1]
