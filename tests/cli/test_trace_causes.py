"""The causes in instruction traces against the causes in the report: every cycle is in a line, or in a gap."""

import json
import re
from collections import Counter
from pathlib import Path

import pytest
from cmrc import c40
from conftest import Run
from locations import AT_ONCE_OPTIONS, ROOT

EXAMPLES = ROOT / "c40_programs" / "examples"
RESTS = ("idle", "halted")
# Its timer interrupts it in IDLE, and its stack and its vectors are in slow memory.
SLOW = """
        .text
start:  ldp     stack
        ldi     @stack,sp
        ldi     @vectors,r0
        ldpe    r0,ivtp
        ldi     @timer,ar0
        ldi     150,r0
        sti     r0,*+ar0(8)
        ldi     03C1h,r0
        sti     r0,*ar0
        ldi     1,iie
        ldi     5,r7
        or      2000h,st
again:  idle
        subi    1,r7
        bnn     again
        ldi     0,iie
done:   b       done
served: reti
stack:  .word   40000100h
timer:  .word   100020h
vectors: .word  table
        .align  200h
table:  .space  2
        .word   served
"""
BOARD = """
[[region]]
name = "program"
base = 0x300000
words = 0x4000
bus = "local"
waits = 2
[[region]]
name = "stack"
base = 0x40000000
words = 0x1000
bus = "local"
waits = 5
"""


def causes_of(trace: Path, end: int, first: int = 0) -> Counter[str]:
    """Of all lines; a gap between two lines counts as `gap`."""
    causes: Counter[str] = Counter()
    at = first
    for line in trace.read_text().splitlines():
        if line.startswith("#"):
            continue
        cycle = int(line.split()[0])
        causes["gap"] += cycle - at
        found = {name: int(count) for name, count in re.findall(r" ([a-z_]+)=(\d+)(?= |$)", line.partition("  ;")[2])}
        found.pop("vector", None)
        if not line.partition("] ")[2].startswith("-------- --------  interrupt"):
            found["execute"] = 1
        causes.update(found)
        at = cycle + sum(found.values())
    causes["gap"] += end - at
    return +causes


def reported(causes: dict[str, int]) -> Counter[str]:
    expected = Counter(causes)
    expected["gap"] = sum(expected.pop(rest, 0) for rest in RESTS)
    return +expected


@pytest.mark.parametrize(
    "arguments",
    [
        [EXAMPLES / "peripherals" / "dma_chain.asm", "--until", "done"],
        [EXAMPLES / "fft1024.asm", "--until", "done"],
        [EXAMPLES / "quicksort.asm", "--cycles", "3000"],
        ["slow.asm", "--board", "slow.toml"],
        ["slow.asm"],
        [ROOT / "tests" / "toolchain" / "bench" / "armed.asm", "--cycles", "5000"],
    ],
    ids=["DMA", "FFT", "until a cycle", "slow memory", "fast memory", "armed"],
)
def test_the_causes_of_a_chips_trace_are_those_of_its_report(run: Run, tmp_path: Path, arguments: list[object]) -> None:
    (tmp_path / "slow.asm").write_text(SLOW)
    (tmp_path / "slow.toml").write_text(BOARD)
    done = run("exec", *arguments, "--trace", "trace", "--json")
    report = json.loads(done.stdout)
    assert causes_of(tmp_path / "trace", report["cycles"]) == reported(report["causes"]), done.stderr
    if "slow.asm" in arguments:
        assert report["causes"]["interrupt"] == 6 * 8 and report["causes"]["idle"] > 100
        waits = 7 if "slow.toml" in arguments else 1
        line = f"interrupt  ; vector=2 wait_state={waits} interrupt=8\n"
        assert (tmp_path / "trace").read_text().count(line) == 6


def test_python_has_the_same_lines(run: Run, tmp_path: Path) -> None:
    (tmp_path / "slow.asm").write_text(SLOW)
    report = json.loads(run("exec", "slow.asm", "--trace", "trace", "--json").stdout)
    processor = c40.Processor(c40.assemble_file(tmp_path / "slow.asm"))
    lines = [line for line in (tmp_path / "trace").read_text().splitlines() if not line.startswith("#")]
    assert processor.trace(report["cycles"]) == lines and any("interrupt=8" in line for line in lines)


@pytest.mark.parametrize(
    "arguments",
    [
        [*[EXAMPLES / "peripherals" / "servo.asm"] * 2, "--link", "0.0:1.3", "--cycles", "20000"],
        [EXAMPLES / "networks" / "ring.asm", "--topology", "ring:4"],
        [EXAMPLES / "networks" / "ring.asm", EXAMPLES / "networks" / "bandwidth_dma.asm", "--link", "0.0:1.3"],
        ["slow.asm", "slow.asm", "--link", "0.0:1.3", "--action", "5,hold,1", "--action", "9,release,1"],
    ],
    ids=["servo", "ring", "DMA", "held"],
)
def test_the_causes_of_a_networks_traces_are_those_of_its_report(
    run: Run, tmp_path: Path, arguments: list[object]
) -> None:
    (tmp_path / "slow.asm").write_text(SLOW)
    done = run("exec", *arguments, "--trace", "trace", "--json")
    chips = json.loads(done.stdout)["chips"]
    for n, chip in enumerate(chips):
        assert causes_of(tmp_path / f"trace.chip{n}", chip["cycles"]) == reported(chip["causes"]), n
    assert len(chips) > 1


def test_the_causes_of_a_docks_traces_are_those_of_its_report(run: Run, tmp_path: Path) -> None:
    dsps = ["--trace-instructions", "0", "--trace-instructions", "1"]
    quick = ["--duration", "0.01", "--set", "report.reference=none", *AT_ONCE_OPTIONS]
    done = run("--dsps", "2", *quick, "--trace", "trace", *dsps, "--quiet", "--report", "report.json")
    assert done.returncode == 0, done.stderr
    for n, dsp in enumerate(json.loads((tmp_path / "report.json").read_text())["dsps"]):
        causes = reported(dsp["causes"])
        assert causes_of(tmp_path / f"trace.dsp{n}", sum(dsp["causes"].values())) == causes, n
