"""emulator trace-diff names the first difference: time, component and field."""

from pathlib import Path

import pytest

EVENTS = """# cmrc event trace 1
0.000125000000 [host] refresh number=1 blocks=3 waiting=2 pointer=0x50 skipped=0
0.000127412000 [dsp 2] claim block=0x50 kind=6 area=0x1000 tick=8 generation=2
0.000250000000 [host] refresh number=2 blocks=3 waiting=1 pointer=0x60 skipped=0
"""
INSTRUCTIONS = """# cmrc instruction trace 1
12 [dsp 0] 00300004 6A06FFFB  bnz 00300000h  ; branch=3
16 [dsp 0] 00300000 02610001  addi 1,r1  ; R1=0000000003 ST=00000000 @00310000=00000005
"""


@pytest.fixture
def diff(run, tmp_path: Path):
    def call(left: str, right: str):
        (tmp_path / "a.trace").write_text(left)
        (tmp_path / "b.trace").write_text(right)
        return run("trace-diff", "a.trace", "b.trace")

    return call


def test_equal_traces(diff) -> None:
    result = diff(EVENTS, EVENTS.replace("\n", "\n# a comment\n", 2))
    assert (result.returncode, result.stdout) == (0, "no difference\n")


@pytest.mark.parametrize(
    ("trace", "old", "new", "message"),
    [
        (EVENTS, "tick=8", "tick=9", "time 0.000127412000 s, dsp 2, field tick: 8 (line 3) and 9 (line 3)"),
        (
            EVENTS,
            "[dsp 2]",
            "[dsp 1]",
            "time 0.000127412000 s, dsp 2, field component: dsp 2 (line 3) and dsp 1 (line 3)",
        ),
        (EVENTS, "claim", "finish", "time 0.000127412000 s, dsp 2, field event: claim (line 3) and finish (line 3)"),
        (
            EVENTS,
            "7412",
            "7413",
            "time 0.000127412000 s, dsp 2, field time: 0.000127412000 (line 3) and 0.000127413000 (line 3)",
        ),
        (
            INSTRUCTIONS,
            "R1=0000000003",
            "R1=0000000004",
            "cycle 16, dsp 0, field R1: 0000000003 (line 3) and 0000000004 (line 3)",
        ),
        (
            INSTRUCTIONS,
            "bnz 00300000h",
            "bnz 00300001h",
            "cycle 12, dsp 0, field instruction: bnz 00300000h (line 2) and bnz 00300001h (line 2)",
        ),
        (INSTRUCTIONS, "branch=3", "branch=2", "cycle 12, dsp 0, field branch: 3 (line 2) and 2 (line 2)"),
        (INSTRUCTIONS, " @00310000=00000005", "", "cycle 16, dsp 0, field @00310000: 00000005 (line 3) and - (line 3)"),
        (INSTRUCTIONS, "02610001", "02610002", "cycle 16, dsp 0, field word: 02610001 (line 3) and 02610002 (line 3)"),
        (INSTRUCTIONS, "16 [dsp", "17 [dsp", "cycle 16, dsp 0, field cycle: 16 (line 3) and 17 (line 3)"),
    ],
)
def test_the_first_difference_is_named(diff, trace: str, old: str, new: str, message: str) -> None:
    result = diff(trace, trace.replace(old, new))
    assert result.returncode == 1
    assert result.stdout.splitlines()[0] == f"first difference: {message}"


def test_a_word_that_is_written_twice_is_compared_twice(diff) -> None:
    """Both halves of STI || STI may go to one address. A fuzz target found that a second one was passed over
    if only the second trace had it."""
    once = INSTRUCTIONS.replace("@00310000=00000005", "@00310000=00000005 @00310000=00000005")
    other = INSTRUCTIONS.replace("@00310000=00000005", "@00310000=00000005 @00310000=00000007")
    where = "first difference: cycle 16, dsp 0, field @00310000: "
    assert diff(once, once).stdout == "no difference\n"
    for left, right, values in (
        (once, other, "00000005 (line 3) and 00000007 (line 3)"),
        (other, once, "00000007 (line 3) and 00000005 (line 3)"),
        (INSTRUCTIONS, other, "- (line 3) and 00000007 (line 3)"),
        (other, INSTRUCTIONS, "00000007 (line 3) and - (line 3)"),
    ):
        result = diff(left, right)
        assert result.returncode == 1 and result.stdout.splitlines()[0] == where + values


def test_a_trace_that_ends_early(diff) -> None:
    result = diff(EVENTS, EVENTS.rsplit("\n", 2)[0] + "\n")
    assert result.returncode == 1
    assert "the second trace has ended, the other continues at its line 4" in result.stdout


def test_a_line_that_is_too_long_is_named_by_its_number(diff) -> None:
    long = "0.000300000000 [host] refresh number=" + 70_000 * "1"
    result = diff(EVENTS, EVENTS + long + "\n")
    assert result.returncode == 2 and "line 5: not a line of a trace: a line longer than 65535" in result.stderr


@pytest.mark.parametrize(
    ("left", "right", "message"),
    [
        (EVENTS, INSTRUCTIONS, "traces of two kinds"),
        (EVENTS, "hello\n", "line 1: not a line of a trace"),
        (EVENTS, "", "the file is empty"),
        (EVENTS, EVENTS + "0.1 nobody\n", "line 5: not a line of a trace"),
    ],
)
def test_what_is_no_trace_is_bad_input(diff, left: str, right: str, message: str) -> None:
    result = diff(left, right)
    assert result.returncode == 2
    assert message in result.stderr
    assert "a.trace and b.trace" in result.stderr


def test_the_instructions_of_a_dsp_that_the_scene_has_not_are_refused(diff) -> None:
    trace = "# cmrc instruction trace 1\n# emulator --dsps 1\n0 [dsp 1] 00300000 00000000  part  ; sha256=aaaa\n"
    result = diff(trace, trace.replace("aaaa", "bbbb"))
    assert result.returncode == 2 and "b.trace: line 3: dsp 1 in a scene of 1 DSPs" in result.stderr
