"""exec --profile, --pipeline and board files: each cycle of a program that is counted by hand appears at its place."""

import json
import re
from pathlib import Path

import pytest
from locations import ROOT

EXAMPLES = ROOT / "c40_programs" / "examples"

# Costs of the hardware document: DP or ARn written in execute and used at once 2 more, LDA 1 more, call and return 4.
PROGRAM = """
        .text
start:  ldi 2fh,dp
        ldi @0f900h,r0
        call f
        ldi 3,ar0
        ldf *ar0,r1
        brd done
        nop
        nop
        nop
f:      lda @0fff0h,ar1
        ldi *ar1,r1
        rets
done:   br done
"""
LINE_CYCLES = {3: 1, 4: 3, 5: 4, 6: 1, 7: 3, 8: 1, 9: 1, 10: 1, 11: 1, 12: 1, 13: 2, 14: 4}

BOARD = """
name = "small"
clock_mhz = 40
[[region]]
name = "program"
base = 0x300000
words = 0x10000
bus = "local"
[[region]]
name = "slow"
base = 0x80000000
words = 0x10000
bus = "global"
read_waits = 3
write_waits = 1
"""


@pytest.fixture
def program(tmp_path: Path) -> Path:
    path = tmp_path / "p.asm"
    path.write_text(PROGRAM)
    return path


def test_profile_places_every_cycle(run, program) -> None:
    report = json.loads(run("exec", program, "--board", "flat", "--profile", "--json").stdout)
    assert {line["line"]: line["cycles"] for line in report["profile"]["lines"]} == LINE_CYCLES
    routines = {routine["name"]: routine for routine in report["profile"]["routines"]}
    assert (routines["f"]["calls"], routines["f"]["cycles"]) == (1, 7)
    assert routines["start"]["cycles"] == sum(LINE_CYCLES.values()) - 7
    stalls = {line["line"]: line["causes"] for line in report["profile"]["lines"]}
    assert stalls[4]["register_conflict"] == 2 and stalls[13]["register_conflict"] == 1 and stalls[5]["branch"] == 3


@pytest.mark.parametrize("name", ["crc32", "fft1024", "lms", "quicksort", "strings", "divide"])
def test_profile_adds_up_to_the_report(run, name) -> None:
    arguments = (
        "exec",
        EXAMPLES / f"{name}.asm",
        "--entry",
        "start",
        "--until",
        "done",
        "--json",
        "--max-cycles",
        200000,
    )
    plain = json.loads(run(*arguments).stdout)
    report = json.loads(run(*arguments, "--profile").stdout)
    profile = report.pop("profile")
    assert report == plain, "profiling changes nothing"
    assert not any(profile["outside"].values()), "no interrupts and no idling here"
    for part in ("lines", "routines"):
        for cause, cycles in plain["causes"].items():
            assert sum(entry["causes"][cause] for entry in profile[part]) == cycles, (part, cause)
        assert sum(entry["instructions"] for entry in profile[part]) == plain["instructions"]
        assert sum(entry["cycles"] for entry in profile[part]) == plain["cycles"]


def test_profile_as_text_annotates_the_source(run, program) -> None:
    text = run("exec", program, "--board", "flat", "--profile").stdout
    call = next(line for line in text.splitlines() if "call f" in line)
    assert call.split()[:2] == ["1", "4"]


def test_pipeline_is_drawn_as_the_manual_draws_it(run, program) -> None:
    """A standard branch: the next instruction is fetched while the branch executes, four cycles from slot to slot."""
    text = run("exec", program, "--board", "flat", "--pipeline", "0:20").stdout
    rows = text[text.index("pipeline, cycles") :].splitlines()[3:]
    cells = {line[23:31]: line[:21].rstrip() for line in rows}
    assert cells["00300000"] == "E"
    assert cells["00300001"] == "-DRE", "the read of DP waits two cycles in front of decode"
    assert cells["00300002"] == " FDRE"
    assert cells["00300009"] == "     FDRE"
    assert cells["0030000A"] == "      F-DRE"
    assert cells["0030000B"] == "        FDRE"
    assert any("branch 3" in line and "call" in line for line in rows)


@pytest.mark.parametrize("window", ["0:30", "7:40", "9:45", "95:140", "988:1031", "99995:100040", "123456:123460"])
def test_the_ruler_has_every_tenth_cycle(run, tmp_path, window) -> None:
    (tmp_path / "loop.asm").write_text("start: nop\n b start\n")
    text = run("exec", "loop.asm", "--cycles", 100100, "--pipeline", window).stdout
    lines = text[text.index("pipeline, cycles") :].splitlines()
    first, last = map(int, window.split(":"))
    tens, units = lines[1:3]
    assert units == "".join(str(cycle % 10) for cycle in range(first, last + 1))
    for cycle in range(first, last + 1):
        if cycle % 10 == 0:
            at = cycle - first
            assert tens[at:].split(" ")[0] == str(cycle) and (at == 0 or tens[at - 1] == " ")
    assert set(tens.split()) <= {str(cycle) for cycle in range(first, last + 1) if cycle % 10 == 0 or cycle == first}


def test_a_wait_for_a_port_stands_in_the_row_of_the_read(run, tmp_path) -> None:
    (tmp_path / "send.asm").write_text("start: ldhi 0010h,ar0\n rpts 30\n nop\n sti r0,*+ar0(42h)\nhalt: b halt\n")
    (tmp_path / "take.asm").write_text("start: ldhi 0010h,ar0\n ldi *+ar0(71h),r5\n addi 1,r5\nhalt: b halt\n")
    arguments = ("exec", "send.asm", "take.asm", "--link", "0.0:1.3", "--pipeline", "0:150")
    waited = json.loads(run(*arguments, "--json").stdout)["chips"][1]["causes"]["comm_port"]
    assert waited > 30
    text = run(*arguments).stdout
    rows = text[text.index("chip 1:") :].splitlines()
    drawn = {row: row[:151].count("p") for row in rows if re.match("  00300", row[151:])}
    assert [count for row, count in drawn.items() if "ldi *+ar0(71h),r5" in row] == [waited]
    assert sum(drawn.values()) == waited, "in no other row"
    read = next(row for row in rows if "ldi *+ar0(71h)" in row)
    assert re.search(r"Rp+E ", read) and f"comm_port {waited}" in read
    assert "p port" in text


def test_what_the_dma_holds_up_is_drawn_so(run) -> None:
    """In the row of the waiting instruction: as many cycles as the account charges it."""
    faults = Path(__file__).parents[1] / "peripherals" / "data" / "faults"
    arguments = (
        "exec",
        faults / "fetch_dma_first.asm",
        "--board",
        faults / "timing-board.toml",
        "--until",
        "done",
        "--pipeline",
        "0:199",
    )
    text = run(*arguments).stdout
    rows = [row for row in text[text.index("pipeline, cycles") :].splitlines() if re.match("  00", row[200:])]
    charged = {row: int(match[1]) for row in rows if (match := re.search(r"dma_conflict (\d+)", row))}
    assert len(charged) == 40 and all(row[:200].count("d") == count for row, count in charged.items())
    assert all(row[:200].strip() == "dFDRE" for row in charged)  # it is the fetch that waits
    assert all("d" not in row[:200] for row in rows if row not in charged)


@pytest.mark.parametrize("window", ["5", "9:3", "a:b", "0:100000", "-1:4"])
def test_bad_window(run, program, window) -> None:
    result = run("exec", program, f"--pipeline={window}")
    assert result.returncode == 2 and "--pipeline" in result.stderr


def test_board_file_costs_its_wait_states(run, tmp_path: Path) -> None:
    (tmp_path / "b.toml").write_text(BOARD)
    (tmp_path / "p.asm").write_text(" .text\n ldhi 8000h,ar0\n nop\n nop\n ldi *ar0,r0\n nop\nhalt: br halt\n")
    report = json.loads(run("exec", "p.asm", "--board", "b.toml", "--json").stdout)
    assert report["causes"]["wait_state"] == 3
    assert report["cycles"] == 5 + 3
    assert report["microseconds"] == pytest.approx(8 * 0.05)


@pytest.mark.parametrize(
    ("old", "new", "names"),
    [
        ("clock_mhz = 40", "clock_mhz = 0", "clock_mhz"),
        ("clock_mhz = 40", 'clock_mhz = "fast"', "clock_mhz"),
        ("read_waits = 3", "read_waits = 16", "region.read_waits"),
        ("write_waits = 1", "write_waits = -1", "region.write_waits"),
        ("base = 0x80000000", "base = 0x300100", "region.bus"),
        ("base = 0x300000", "base = 0x2FF800", "region.base"),
        ("words = 0x10000", "words = 0", "region.words"),
        ('bus = "local"', 'bus = "third"', "region.bus"),
        ('bus = "local"', 'bus = "local"\nspeed = 1', "region.speed"),
        ('name = "program"', "", "name is missing"),
        ("[[region]]", "[[regions]]", "regions"),
        ("clock_mhz = 40", "clock_mhz = ", "b.toml:3"),
    ],
)
def test_bad_board(run, tmp_path: Path, program, old, new, names) -> None:
    assert old in BOARD
    (tmp_path / "b.toml").write_text(BOARD.replace(old, new))
    result = run("exec", program, "--board", "b.toml")
    assert result.returncode == 2 and names in result.stderr and "b.toml" in result.stderr, result.stderr


def test_overlapping_memories(run, tmp_path: Path, program) -> None:
    extra = '[[region]]\nname = "more"\nbase = 0x30FFFF\nwords = 2\nbus = "local"\n'
    (tmp_path / "b.toml").write_text(BOARD + extra)
    result = run("exec", program, "--board", "b.toml")
    assert result.returncode == 2 and "more" in result.stderr and "overlaps program" in result.stderr


def test_access_to_nothing_names_address_and_pc(run, tmp_path: Path) -> None:
    (tmp_path / "b.toml").write_text(BOARD)
    (tmp_path / "p.asm").write_text(" .text\n ldhi 9000h,ar0\n ldi *ar0,r0\nhalt: br halt\n")
    result = run("exec", "p.asm", "--board", "b.toml")
    assert result.returncode == 1 and "90000000h" in result.stdout and "PC 00300001h" in result.stdout
