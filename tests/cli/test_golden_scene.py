"""Golden traces of the scene (ruling 31): from the start of process 3, with 1, 2 and 4 DSPs."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from cmrc import _core
from locations import ROOT
from traces import condensed

HZ = 25_000_000
LENGTH_S = 0.009  # holds a claim of trajectory planning, which comes every 8 ms
WINDOW_S = 0.0005


def start_of_process_3(events: list[str]) -> float:
    return next(float(line.split()[0]) for line in events if " process number=3 state=1 " in line)


def claim_of(kind: int, events: list[str], after: float) -> float:
    claims = (float(line.split()[0]) for line in events if f" kind={kind} " in line and "] claim " in line)
    return next(time for time in claims if time > after)


def labelled(event: str, labels: _core.trace.Labels, windows: dict[str, int]) -> str:
    """Bus addresses and job areas as what areas.inc and task_block.inc call them."""
    event = re.sub(
        r"(\[bus A\] .* address=|\] (?:load|claim) .*area=)0x([0-9a-f]+)",
        lambda m: m[1] + labels.name(windows["A"] + int(m[2], 16)),
        event,
    )
    return re.sub(
        r"(\[bus B\] .* address=)0x([0-9a-f]+)", lambda m: m[1] + labels.name(windows["B"] + int(m[2], 16)), event
    )


@pytest.mark.golden
@pytest.mark.parametrize("dsps", [1, 2, 4])
def test_scene(run, golden: Callable[[str, str], None], tmp_path: Path, dsps: int) -> None:
    def trace(window: str, *slots: int) -> list[str]:
        extra = [argument for slot in slots for argument in ("--trace-instructions", slot)]
        if slots:  # assembled here, so that the lines have the source's text
            extra += ["--trace-labels", "--programs", ROOT / "c40_programs"]
        result = run("--dsps", dsps, "--duration", 0.05, "--quiet", "--trace", "t", "--trace-window", window, *extra)
        assert result.returncode == 0, result.stderr
        return (tmp_path / "t").read_text().splitlines()[1:]

    start = start_of_process_3(trace("0:0.05"))
    start = int(start * 1e4) / 1e4  # windows and hashes on whole tenths of a millisecond
    end = start + LENGTH_S
    events = trace(f"{start:.4f}:{end:.4f}", *range(dsps))
    # A servo tick, and a tick at which planning is claimed beside torque compensation and PID.
    windows = [int(claim_of(kind, events, start + 0.001) * 1e4) / 1e4 for kind in (6, 1)]

    def keep(cycle: int) -> bool:
        return any(window <= cycle / HZ < window + WINDOW_S for window in windows)

    image = _core.toolchain.assemble_file(ROOT / "c40_programs" / "dsp.asm", entry="_start")
    labels = _core.trace.Labels.of_dock(image)
    buses = {bus: image.symbols[f"WINDOW_{bus}"] for bus in "AB"}
    lines = ["# cmrc scene trace 2", f"# emulator --dsps {dsps}", *(labelled(event, labels, buses) for event in events)]
    for slot in range(dsps):
        instructions = (tmp_path / f"t.dsp{slot}").read_text().splitlines()[1:]
        lines += condensed(instructions, slot, keep)
    assert any(re.search(r"\[dsp 0\] .*; count=", line) for line in lines)
    golden(f"scene-{dsps}.trace", "\n".join(lines) + "\n")


def test_golden_files_stay_small() -> None:
    directory = Path(__file__).parents[1] / "golden"
    assert 0 < sum(path.stat().st_size for path in directory.rglob("*.trace")) < 5_000_000


WRONG = "0123456789abcdef"


def test_trace_diff_regenerates_the_text_behind_a_differing_hash(run, tmp_path: Path) -> None:
    run(
        "--dsps",
        1,
        "--duration",
        0.0241,
        "--quiet",
        "--trace",
        "t",
        "--trace-window",
        "0.024:0.0241",
        "--trace-instructions",
        0,
        "--trace-labels",
    )
    executed = (tmp_path / "t.dsp0").read_text().splitlines()[1:]
    assert executed
    hashed = condensed(executed, 0, keep=lambda cycle: False)
    text = "\n".join(["# cmrc scene trace 2", "# emulator --dsps 1", *hashed]) + "\n"
    (tmp_path / "a.trace").write_text(text)
    (tmp_path / "b.trace").write_text(re.sub("sha256=.{16}", f"sha256={WRONG}", text))
    for first, second in (("a.trace", "b.trace"), ("b.trace", "a.trace")):
        result = run("trace-diff", first, second)
        assert result.returncode == 1 and result.stderr == ""
        assert "cycle 600000, dsp 0, field sha256: " in result.stdout
        assert (
            result.stdout.split("instructions that this emulator executes there, equal to those of a.trace:\n")[
                1
            ].splitlines()
            == executed
        )


def test_trace_diff_shows_no_instructions_that_neither_trace_has(run, tmp_path: Path) -> None:
    """Golden scenes are of the programs of the tree. Others execute something else there."""
    golden = (ROOT / "tests" / "golden" / "scene-1.trace").read_text()
    (tmp_path / "a.trace").write_text(golden)
    (tmp_path / "b.trace").write_text(re.sub("sha256=.{16}", f"sha256={WRONG}", golden, count=1))
    shutil.copytree(ROOT / "c40_programs", tmp_path / "others")
    executive = tmp_path / "others" / "executive.asm"
    executive.write_text(executive.read_text().replace("exec_next:\n", "exec_next:\n        nop\n"))
    other = run("trace-diff", "a.trace", "b.trace", "--programs", tmp_path / "others")
    assert other.returncode == 1 and "instructions that this emulator executes" not in other.stdout
    assert "error: this emulator executes other instructions there" in other.stderr and "--programs DIR" in other.stderr
    for programs in ((), ("--programs", ROOT / "c40_programs")):
        same = run("trace-diff", "a.trace", "b.trace", *programs)
        assert same.returncode == 1 and same.stderr == ""
    line = next(line for line in golden.splitlines() if "sha256=" in line)
    executed = same.stdout.split("equal to those of a.trace:\n")[1].splitlines()
    assert condensed(executed, 0, keep=lambda cycle: False) == [line]
    missing = run("trace-diff", "a.trace", "b.trace", "--programs", tmp_path)
    assert missing.returncode == 2 and "dsp.asm" in missing.stderr


def test_trace_diff_says_where_it_cannot_print_what_is_behind_a_hash(run, tmp_path: Path) -> None:
    golden = (ROOT / "tests" / "golden" / "kernels" / "pid.trace").read_text()
    (tmp_path / "a.trace").write_text(golden)
    (tmp_path / "b.trace").write_text(re.sub("sha256=.{16}", f"sha256={WRONG}", golden, count=1))
    result = run("trace-diff", "a.trace", "b.trace")
    assert result.returncode == 1 and "for a scene's trace only" in result.stdout
