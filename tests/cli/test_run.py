"""The main job from the command line: sums that hold, hashes that repeat, files that are whole."""

import json
import os
import pty
import re
import signal
import subprocess
import time
from pathlib import Path

import pytest

SHORT = 0.08
KINDS = [
    "pid", "torque_compensation", "trajectory_planning.crane", "trajectory_planning.agv", "inverse_kinematics.crane",
    "inverse_kinematics.agv", "obstacle_avoidance", "identify", "grab_path", "home.crane", "home.agv", "error", "recompute",
]  # fmt: skip
OUTCOMES = ["on_time", "late", "unfinished", "never_started", "lost", "dropped"]


@pytest.fixture
def report_of(run, tmp_path: Path):
    def call(*arguments: object) -> dict:
        result = run("--duration", SHORT, "--report", "r.json", "--quiet", *arguments)
        assert (result.returncode, result.stdout, result.stderr) == (0, "", "")
        return json.loads((tmp_path / "r.json").read_text())

    return call


@pytest.mark.parametrize("dsps", [1, 2, 4, 8, 16])
def test_the_identities_of_the_report(report_of, dsps: int) -> None:
    report = report_of("--dsps", dsps)
    assert report["schema_version"] == 4
    assert report["stop_reason"] == "completed"
    assert report["simulated_s"] == SHORT
    assert list(report["tasks"]) == KINDS
    for task in report["tasks"].values():
        assert task["released"] == sum(task[outcome] for outcome in OUTCOMES)
        finished, mean = task["execution_ps"]["count"], task["execution_ps"]["mean"]
        assert (mean is None) == (finished == 0)
        assert sum(task["execution_causes_ps"].values()) == pytest.approx(finished * (mean or 0.0), rel=1e-6)
    assert report["tasks"]["pid"]["released"] >= 55
    assert len(report["dsps"]) == dsps
    for dsp in report["dsps"]:
        # No chip stays behind in virtual time: each has counted the whole run, to within an instruction's stall.
        assert dsp["cycles"] == sum(dsp["causes"].values())
        assert dsp["cycles"] == pytest.approx(SHORT * dsp["clock_hz"], abs=2000)
    assert set(report["buses"]) == {"A", "B"}
    for bus in report["buses"].values():
        assert bus["clocks"] == sum(bus["clocks_by_use"].values())
        assert bus["clocks"] == pytest.approx(SHORT * bus["clock_hz"], abs=2)
    claims = sum(dsp["claims"] for dsp in report["dsps"])
    taken = sum(task["released"] - task["never_started"] - task["dropped"] for task in report["tasks"].values())
    assert claims >= taken > 100
    assert re.fullmatch("[0-9a-f]{64}", report["hash"])


def test_the_hash_repeats_and_depends_on_the_run_only(report_of) -> None:
    plain = report_of("--dsps", 3)
    for same in (
        ["--turn-order", 5],
        ["--turn-order", 77],
        ["--trace", "t", "--trace-window", "0.01:0.02", "--trace-instructions", 1],
    ):
        other = report_of("--dsps", 3, *same)
        assert other["hash"] == plain["hash"], same
        apart = ("elapsed_s", "reference_elapsed_s", "configuration", "configuration_toml")
        assert {key: value for key, value in other.items() if key not in apart} == {
            key: value for key, value in plain.items() if key not in apart
        }
    assert report_of("--dsps", 2)["hash"] != plain["hash"]
    assert report_of("--dsps", 3, "--idle-policy", "pause")["hash"] != plain["hash"]


def test_a_dsp_that_is_plugged_in_later_has_an_instruction_trace(run, tmp_path: Path) -> None:
    (tmp_path / "later.toml").write_text(
        '[machine]\ndsps = 1\nslots = 3\n[[events]]\nat_s = 0.01\naction = "plug"\ndsp = 2\n'
    )
    result = run("--config", "later.toml", "--duration", SHORT, "--quiet", "--trace", "t", "--trace-instructions", 2)
    assert result.returncode == 0, result.stderr
    assert float((tmp_path / "t.dsp2").read_text().splitlines()[1].split()[0]) >= 0.01


@pytest.mark.parametrize("given", [["--dsps", "2", "--set", "dsps=3"], ["--set", "machine.dsps=3", "--dsps", "2"]])
def test_a_flag_holds_over_set_in_whatever_order(run, tmp_path: Path, given: list[str]) -> None:
    assert run(*given, "--duration", "0.021", "--quiet", "--report", "r.json").returncode == 0
    assert json.loads((tmp_path / "r.json").read_text())["configuration"]["machine.dsps"] == 2


def test_traces_are_of_their_window_and_in_order(run, tmp_path: Path) -> None:
    result = run(
        "--duration", SHORT, "--quiet", "--trace", "t", "--trace-window", "0.05:0.052", "--trace-instructions", 0
    )
    assert result.returncode == 0, result.stderr
    lines = (tmp_path / "t").read_text().splitlines()
    assert lines[0] == "# cmrc event trace 1"
    times = [float(line.split()[0]) for line in lines[1:]]
    assert times == sorted(times)
    assert all(0.05 <= at < 0.052 for at in times)
    kinds = {line.split("] ")[1].split()[0] for line in lines[1:]}
    assert {"refresh", "claim", "finish", "bus_transaction", "latch", "interrupt"} <= kinds
    assert sum(" latch " in line for line in lines) == 16  # 8 kHz
    instructions = (tmp_path / "t.dsp0").read_text().splitlines()
    assert instructions[0] == "# cmrc instruction trace 1"
    cycles = [int(line.split()[0]) for line in instructions[1:]]
    assert cycles == sorted(cycles)
    assert all(0.05 * 25e6 <= cycle < 0.052 * 25e6 for cycle in cycles)
    assert len(cycles) > 200
    assert {path.name for path in tmp_path.iterdir()} == {"t", "t.dsp0"}


def test_a_window_of_a_slowed_dsp_is_one_of_simulated_time(run, tmp_path: Path) -> None:
    slow = '[[events]]\nat_s = 0.021\naction = "slow"\ndsp = 0\nfactor = 0.1\n'
    (tmp_path / "c.toml").write_text(slow)
    done = run("--config", "c.toml", "--dsps", 1, "--duration", 0.03, "--quiet", "--trace", "t", "--trace-window",
               "0.025:0.026", "--trace-instructions", 0)  # fmt: skip
    assert done.returncode == 0, done.stderr
    cycles = [int(line.split()[0]) for line in (tmp_path / "t.dsp0").read_text().splitlines()[1:]]
    before_slow, hertz = 525_000, 2.5e6
    assert cycles
    assert all(before_slow + 0.004 * hertz - 2 <= cycle < before_slow + 0.005 * hertz + 2 for cycle in cycles)
    assert cycles[-1] - cycles[0] > 0.9 * 0.001 * hertz


def test_the_terminal_report(run) -> None:
    result = run("--duration", SHORT, "--dsps", 2)
    assert (result.returncode, result.stderr) == (0, "")
    text = result.stdout
    assert text.startswith("2 DSPs, 0.080 s simulated in ")
    for part in (
        "Deadlines",
        "Response times",
        "% of cycles",
        "Bus A",
        "Bus B",
        "Work cycles",
        "joint psi",
        "refreshes",
        "hash ",
    ):
        assert part in text
    assert max(map(len, text.splitlines())) <= 100


def test_strict_fails_when_a_deadline_was_missed(run) -> None:
    # One DSP runs `identify` for some ms while PID falls due.
    lenient = run("--duration", SHORT, "--dsps", 1)
    strict = run("--duration", SHORT, "--dsps", 1, "--strict")
    assert "Why deadlines were missed" in lenient.stdout
    assert (lenient.returncode, strict.returncode) == (0, 1)
    assert run("--duration", SHORT, "--dsps", 2, "--strict").returncode == 0  # no deadline is missed


def test_ctrl_c_ends_the_run_with_a_report(emulator: Path, tmp_path: Path) -> None:
    process = subprocess.Popen(
        [emulator, "--duration", "5000", "--report", "r.json", "--snapshot-at", "0.1:under_way"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    while not (tmp_path / "under_way").exists():
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=30)
    assert stderr == ""
    assert "The run ended early: interrupted" in stdout
    report = json.loads((tmp_path / "r.json").read_text())
    assert report["stop_reason"] == "interrupted"
    assert 0.1 <= report["simulated_s"] < 5000  # the signal may come at the snapshot itself
    for task in report["tasks"].values():
        assert task["released"] == sum(task[outcome] for outcome in OUTCOMES)


@pytest.mark.parametrize("command", [[], ["compare"]], ids=["run", "compare"])
def test_the_progress_line_shows_on_a_terminal_only(emulator: Path, tmp_path: Path, command: list[str]) -> None:
    try:
        ours, theirs = pty.openpty()
    except OSError:
        pytest.skip("no pseudo-terminals here (a chroot without /dev/pts)")
    process = subprocess.Popen(
        [emulator, *command, "--duration", "5000"], cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=theirs
    )
    os.close(theirs)
    seen = b""
    while b"x real time" not in seen:
        seen += os.read(ours, 1000)
    process.send_signal(signal.SIGINT)
    try:
        while part := os.read(ours, 1000):
            seen += part
    except OSError:  # the terminal's other end has closed
        pass
    process.wait(timeout=30)
    assert b" of 5000.0 s" in seen
    assert b"missed" in seen


def test_programs_from_a_directory(run, report_of, tmp_path: Path) -> None:
    root = Path(__file__).parents[2] / "c40_programs"
    built_in = report_of()
    assert report_of("--programs", root)["hash"] == built_in["hash"]
    broken = tmp_path / "programs"
    broken.mkdir()
    for source in root.rglob("*"):
        if source.suffix in (".asm", ".inc"):
            target = broken / source.relative_to(root)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(source.read_text())
    executive = broken / "executive.asm"
    executive.write_text(executive.read_text() + "\n        bogus r1,r2\n")
    result = run("--programs", broken, "--duration", SHORT, "--report", "new.json")
    assert result.returncode == 2
    assert "executive.asm:" in result.stderr
    assert "bogus" in result.stderr
    assert not (tmp_path / "new.json").exists()
