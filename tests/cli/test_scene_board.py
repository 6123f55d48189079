"""Boards of the dock's DSPs from TOML files: the same machine when they say the same, its costs when they do not, and
errors before the run."""

import shutil
import subprocess
from pathlib import Path
from typing import Any

import cmrc
import pytest
from locations import ROOT

# The board `default` as ruling 26 describes it.
DEFAULT = """
name = "as ruling 26"
gmicr = 0x1DEA4000
lmicr = 0x1DEA4000
[[region]]
name = "local SRAM"
base = 0x300000
words = 0x100000
bus = "local"
[[region]]
name = "slow local SRAM"
base = 0x40000000
words = 0x100000
bus = "local"
waits = 1
[[region]]
name = "window to bus B"
kind = "window"
base = 0x70000000
words = 0x10000000
bus = "local"
[[region]]
name = "global SRAM"
base = 0x80000000
words = 0x100000
bus = "global"
[[region]]
name = "window to bus A"
kind = "window"
base = 0xC0000000
words = 0x40000000
bus = "global"
"""
PROGRAM_WAITS = (
    'words = 0x100000\nbus = "local"\n[[region]]\nname = "slow',
    'words = 0x100000\nbus = "local"\nwaits = 2\n[[region]]\nname = "slow',
)


def run(tmp_path: Path, board: str, **settings: Any) -> cmrc.Result:
    (tmp_path / "b.toml").write_text(board)
    return cmrc.run(dsps=2, duration_s=0.05, board=str(tmp_path / "b.toml"), **settings)


def test_a_file_that_says_what_the_default_is_gives_the_default_run(tmp_path: Path) -> None:
    assert run(tmp_path, DEFAULT).hash == cmrc.run(dsps=2, duration_s=0.05).hash


def test_the_clock_of_the_board_is_that_of_the_chip(tmp_path: Path) -> None:
    slow = run(tmp_path, "clock_mhz = 40\n" + DEFAULT, dsp_clock="C40-60")
    assert slow.report["dsps"][0]["clock_hz"] == 20e6
    assert slow.hash == cmrc.run(dsps=2, duration_s=0.05, dsp_clock="C40-40").hash


def test_a_slow_clock_is_one_of_whole_hertz(tmp_path: Path) -> None:
    """33333334 / 2 Hz at 0.333333 and some ppm is no fraction that a clock could have."""
    events = [{"at_s": 0.01, "action": "slow", "dsp": 1, "factor": 0.333333}]
    slow = run(tmp_path, "clock_mhz = 33.333334\n" + DEFAULT, phase_jitter=True, events=events)
    cycles = [dsp["cycles"] for dsp in slow.report["dsps"]]
    assert cycles[1] / cycles[0] == pytest.approx((1 + 4 * 0.333333) / 5, rel=0.01)


def test_wait_states_of_the_program_memory(tmp_path: Path) -> None:
    """A kernel's straight code misses the cache and waits twice for its fetch; of the dock, execution gets longer, not
    wrong."""
    fast, slow = run(tmp_path, DEFAULT), run(tmp_path, DEFAULT.replace(*PROGRAM_WAITS))
    before, after = (r.report["tasks"]["torque_compensation"] for r in (fast, slow))
    assert before["execution_cycles"]["wait_state"] == 0
    assert before["on_time"] == after["on_time"] >= 30
    executed = after["execution_cycles"]["execute"]
    assert executed == pytest.approx(before["execution_cycles"]["execute"], rel=1e-3)  # later, the plant is read later
    # Two cycles for each miss; what is called again soon (sine and cosine), hits.
    assert 0.5 * executed < after["execution_cycles"]["cache_miss"] < 2 * executed


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("[[region]]", "clock_mhz = 0\n[[region]]", "clock_mhz: a number from 0.001 to 1000 is expected"),
        ("waits = 1\n", "waits = 16\n", "region.waits"),
        ('kind = "window"', 'kind = "bus"', "region.kind of window to bus B"),
        ('kind = "window"', 'kind = "window"\nwaits = 1', "region.waits of window to bus B"),
        ("base = 0x40000000", "base = 0x380000", "overlaps local SRAM (00300000h"),
        ("base = 0xC0000000", "base = 0xB0000000", "bus A at C0000000h, and there is no window"),
        ("base = 0x70000000", "base = 0x6F000000", "bus B at 70000000h, and there is no window"),
        ("words = 0x40000000", "words = 0x1000", "the devices on the bus need"),
        ("words = 0x100000", "words = 0x400", "no RAM holds section .text of the DSP programs"),
        ("base = 0x300000", "base = 0x500000", "no RAM holds section .text of the DSP programs"),
    ],
)
def test_bad_boards_are_refused_before_the_run(tmp_path: Path, old: str, new: str, says: str) -> None:
    assert old in DEFAULT
    with pytest.raises(cmrc.ConfigError, match="machine.board: ") as error:
        run(tmp_path, DEFAULT.replace(old, new, 1))
    assert says in str(error.value)
    assert "b.toml:" in str(error.value) or "board as ruling 26" in str(error.value)


def test_the_ideal_run_of_a_slow_board_is_instant_too(tmp_path: Path) -> None:
    """A thousand times 1 kHz was slower than the host, and the run with this reference never ended."""
    slow, usual = (run(tmp_path, clock + DEFAULT).report["errors"] for clock in ("clock_mhz = 0.001\n", ""))
    for kind in ("pid", "torque_compensation", "inverse_kinematics.crane"):
        assert slow["demand"][kind]["demanded"] == usual["demand"][kind]["demanded"] > 5
    assert slow["demand"]["pid"]["finished"] == 0


def test_a_dsp_hangs_on_a_board_of_less_memory_as_on_the_default_one(tmp_path: Path) -> None:
    """The loop was in the last word of the default board's memory, which no other board has."""
    hang = [{"at_s": 0.03, "action": "hang", "dsp": 0}]
    small = DEFAULT.replace("words = 0x100000", "words = 0x8000", 1)
    whole, little = (
        run(tmp_path, board, events=hang, settings={"watchdog.silence_ms": 5}).report for board in (DEFAULT, small)
    )
    for part in ("failures", "tasks", "dsps", "buses", "errors"):
        assert whole[part] == little[part]  # the hash knows the address
    assert [failure["kind"] for failure in little["failures"]] == ["silent"]


@pytest.mark.parametrize("name", ["flat", "third", "nowhere.toml"])
def test_boards_that_are_none_of_the_dock(name: str) -> None:
    with pytest.raises(cmrc.ConfigError, match="machine.board"):
        cmrc.run(board=name)


def test_from_the_command_line(emulator: Path, tmp_path: Path) -> None:
    (tmp_path / "b.toml").write_text(DEFAULT)
    (tmp_path / "c.toml").write_text('[machine]\nboard = "b.toml"\n')
    flag, file = (
        subprocess.run(
            [emulator, "--duration", "0.03", *more], capture_output=True, text=True, cwd=tmp_path, check=True
        ).stdout.split("\nhash")[1]
        for more in (["--board", "b.toml"], ["--config", "c.toml"])
    )
    assert flag == file
    bad = subprocess.run([emulator, "--board", "none.toml"], capture_output=True, text=True, cwd=tmp_path, check=False)
    assert bad.returncode == 2 and "none.toml" in bad.stderr


def test_an_access_to_nothing_names_dsp_pc_and_address(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "c40_programs", tmp_path / "programs")
    (tmp_path / "programs" / "kernels" / "user.asm").write_text(
        "kernel_lost:\n        ldhi    9000h, ar0\n        ldi     *ar0, r0\n        ldi     0, r1\n        rets\n"
    )
    (tmp_path / "c.toml").write_text(
        f'[machine]\nprograms = "{tmp_path / "programs"}"\n[[tasks]]\nname = "lost"\nprogram = "kernel_lost"\nkind = 14\n'
        "importance = 0xF3FF\nperiod_ms = 10\n"
    )
    result = run(tmp_path, DEFAULT, config=tmp_path / "c.toml")
    faults = [failure for failure in result.report["failures"] if failure["kind"] == "fault"]
    assert faults and faults[0]["dsp"] in (0, 1)
    pc = cmrc.c40.assemble_file(tmp_path / "programs" / "dsp.asm").symbols["kernel_lost"] + 1
    assert f"DSP {faults[0]['dsp']} at PC {pc:08X}h" in faults[0]["message"]
    assert "90000000h" in faults[0]["message"] and "reserved on board as ruling 26" in faults[0]["message"]
