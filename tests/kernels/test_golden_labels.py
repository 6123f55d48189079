"""Golden traces do not depend on addresses: a word added for one kernel changes no other kernel's golden trace."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from cmrc import _core
from harness_agv import Dsp, image
from locations import ROOT
from test_golden_kernels import CASES, kernel_trace
from traces import condensed, without_operands

USER = "inverse_crane"  # early in the image: most kernels and functions come after it, and move
LONG = "avoidance_dwa"  # nearly all of the instructions of all kernels together, and a vehicle's: of the crane's area it knows nothing


def substitute(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert text.count(old) == 1, f"{old!r} in {path.name}"
    path.write_text(text.replace(old, new))


def at_the_end(areas: str) -> str:
    """A word after the last one of the crane's area."""
    last = 0x240 + 8  # CR_SPEED, its words, and one more, for a pointer may point behind them
    assert (
        "CR_SPEED            .set 240h" in areas
        and "SPEED_WORDS         .set 7 " in areas
        and "CR_WORDS            .set 280h" in areas
    )
    return areas + f"CR_ADDED            .set 0{last:X}h\n"


def before(word: str) -> Callable[[str], str]:
    """A word before this one of the crane's, which moves up with all that come later. What kernels copy up to the new
    word would show: a pointer then points to it. Words that they copy beginning behind it, as PID the joint points of
    CR_RING, do not."""

    def added(areas: str) -> str:
        found = re.search(rf"^{word}\s+\.set 0?([0-9A-F]+)h", areas, re.MULTILINE)
        assert found is not None
        place, lines = int(found[1], 16), []
        for line in areas.splitlines():
            offset = re.match(r"(CR_\w+)(\s+\.set )([0-9A-F]+)h", line)
            moves = offset and offset[1] not in ("CR_BASE", "CR_WORDS") and int(offset[3], 16) >= place
            lines.append(f"{offset[1]} .set 0{int(offset[3], 16) + 1:X}h" if offset and moves else line)
        return "\n".join([*lines, f"CR_ADDED .set 0{place:X}h"]) + "\n"

    return added


AT_THE_END = "at the end"


@pytest.fixture(scope="module")
def traces() -> dict[str, str]:
    """The golden ones: test_golden_kernels.py compares them with those of the programs as they are."""
    return {kernel: (ROOT / "tests" / "golden" / "kernels" / f"{kernel}.trace").read_text() for kernel, *_ in CASES}


@pytest.mark.parametrize(
    "added",
    [at_the_end, before("CR_SPEED"), before("CR_RING"), before("CR_TRAJECTORY")],
    ids=[AT_THE_END, "CR_SPEED", "CR_RING", "CR_TRAJECTORY"],
)
def test_a_word_added_for_one_kernel_changes_no_other_golden_trace(
    added: Callable[[str], str],
    traces: dict[str, str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    request: pytest.FixtureRequest,
) -> None:
    programs = tmp_path / "c40_programs"
    shutil.copytree(ROOT / "c40_programs", programs)
    areas = programs / "include" / "areas.inc"
    areas.write_text(added(areas.read_text()))
    # The kernel uses the word, and a constant of its own that moves all later ones.
    entry = f"kernel_{USER}:\n"
    substitute(
        programs / "kernels" / f"{USER}.asm",
        entry,
        entry + "        ldi     CR_ADDED, ir0\n        ldi     *+ar6(ir0), ir0\n        ldi     @K_ADDED, ir0\n",
    )
    constants = programs / "constants.asm"
    first = next(line for line in constants.read_text().splitlines() if line.strip().startswith('.include "kernels/'))
    substitute(constants, first + "\n", f"K_ADDED .set $ - LIFT\n        .float 1.5\n{first}\n")

    before = image().symbols
    monkeypatch.setenv("CMRC_PROGRAMS", str(programs))
    after = image().symbols
    assert sum(after[f"kernel_{kernel}"] != before[f"kernel_{kernel}"] for kernel, *_ in CASES) > 15  # they did move
    # All variants move the long one alike: once is enough.
    cases = [case for case in CASES if case[0] != LONG or AT_THE_END in request.node.name]
    changed = [kernel for kernel, *rest in cases if kernel_trace(kernel, *rest) != traces[kernel]]
    assert changed == [USER]


def test_code_that_moves_changes_cycles_and_no_steps(emulator: Path, tmp_path: Path) -> None:
    """By six words the cycles change, by a segment of the cache (32) nothing; the page's commands leave cycles out."""
    page = (ROOT / "docs" / "trace.md").read_text(encoding="utf-8")
    shown = re.search(r"^    (for build in OLD NEW;.*)\n    (diff OLD.steps NEW.steps)$", page, re.MULTILINE)
    assert shown is not None
    for words in (0, 6, 32):
        programs = tmp_path / f"moved-{words}"
        shutil.copytree(ROOT / "c40_programs", programs)
        added = "        nop\n" * (words - 1) + "        rets\n" if words else ""
        substitute(programs / "lib" / "arithmetic.asm", "m_reciprocal:\n", added + "m_reciprocal:\n")
        arguments = ["--dsps", "2", "--duration", "0.05", "--quiet", "--set", "machine.boot=preloaded"]
        arguments += ["--programs", str(programs), "--trace", str(tmp_path / f"t{words}")]
        for slot in ("0", "1"):
            arguments += ["--trace-instructions", slot]
        subprocess.run([emulator, *arguments, "--trace-labels"], check=True, timeout=300)
    for slot in (0, 1):
        traces = {words: (tmp_path / f"t{words}.dsp{slot}").read_text() for words in (0, 6, 32)}
        assert traces[0] == traces[32] != traces[6]
        (tmp_path / "OLD").write_text(traces[0])
        (tmp_path / "NEW").write_text(traces[6])
        command = ["bash", "-c", f"{shown[1]}\n{shown[2]}"]
        same = subprocess.run(command, check=True, cwd=tmp_path, capture_output=True)
        assert same.stdout == b""
        (tmp_path / "NEW").write_text(traces[6].replace("ldi *ar0++, r0", "ldi *ar0--, r0"))
        assert subprocess.run(command, check=False, cwd=tmp_path, capture_output=True).returncode == 1


def test_a_golden_hash_sees_data_cycles_causes_and_mnemonics() -> None:
    line = "12 [dsp 0] start+0x4 -  ldi *+ar0(3), r0  ; R0=0000000003 @SCRATCH=00000003 branch=3"

    def digest(text: str) -> str:
        return condensed([text], 0, keep=lambda cycle: False)[0]

    same = [line.replace("*+ar0(3), r0", "*+ar0(4), r0")]
    other = [
        line.replace(old, new)
        for old, new in (
            ("12 ", "13 "),
            ("+0x4", "+0x5"),
            ("ldi", "ldf"),
            ("R0=0000000003", "R0=0000000004"),
            ("SCRATCH", "SCRATCH+0x1"),
            ("=3", "=2"),
        )
    ]
    assert [digest(text) == digest(line) for text in same] == [True]
    assert all(digest(text) != digest(line) for text in other)
    assert (
        without_operands("1 [dsp 0] a -  mpyf3 *ar0, r1, r0 || addf3 r2, r3, r2  ; R0=1")
        == "1 [dsp 0] a -  mpyf3||addf3  ; R0=1"
    )
    assert without_operands("1 [dsp 0] a -  rets") == "1 [dsp 0] a -  rets"


@pytest.mark.parametrize(
    ("symbol", "offset", "name"),
    [
        ("kernel_pid", 0, "kernel_pid"),
        ("kernel_pid", 1, "kernel_pid+0x1"),
        ("STACK", 5, "STACK+0x5"),
        ("SCRATCH", 0x80, "SCRATCH+0x80"),
        ("K_HALF_PI", 0, "K_HALF_PI"),
    ],
)
def test_names_of_addresses(symbol: str, offset: int, name: str) -> None:
    dsp = Dsp()
    assert _core.trace.Labels.of_dock(dsp.image).name(dsp.symbols[symbol] + offset) == name


def test_names_of_the_windows() -> None:
    dsp = Dsp()
    s, labels = dsp.symbols, _core.trace.Labels.of_dock(dsp.image)
    crane, vehicle = s["WINDOW_A"] + s["CR_BASE"], s["WINDOW_A"] + s["AG_BASE"] + 2 * s["AG_WORDS"]
    assert labels.name(crane + s["CR_RING"] + 3) == "CR_RING+0x3"
    assert labels.name(vehicle + s["AG_POINT"] + 1) == "AG2.AG_POINT+0x1"
    assert labels.name(s["WINDOW_A"] + s["BLOCK_POOL"] + 3 * s["BLOCK_WORDS"] + s["TB_FLAG"]) == "TB3.TB_FLAG"
    assert labels.name(s["WINDOW_A"] + s["SEMAPHORE"]) == "SEMAPHORE"
    assert labels.name(s["WINDOW_A"] + 0xF000) == "A+0xF000"  # behind the last table
    assert labels.name(s["WINDOW_B"] + s["ENCODER"] + 2) == "ENCODER+0x2"
    assert labels.name(0x12345678) == "12345678"


@pytest.mark.golden
def test_where_each_name_of_the_windows_begins(golden: Callable[[str, str], None]) -> None:
    """Every word of both windows and of the RAM on chip: a line where another name begins."""
    dsp = Dsp()
    s, labels = dsp.symbols, _core.trace.Labels.of_dock(dsp.image)
    ranges = [(s["WINDOW_A"], 0x20002), (s["WINDOW_B"], 0x2002), (s["TASK"], 0x300000 - s["TASK"])]
    lines, last = [], ""
    for base, words in ranges:
        for address in range(base, base + words):
            name = labels.name(address).split("+")[0]
            if name != last and name != f"{address:08X}":
                lines.append(f"{address:08X} {labels.name(address)}\n")
            last = name
    golden("labels.table", "".join(lines))
