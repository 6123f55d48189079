"""The debugger by commands: the exit status for scripts, and the output of the commands."""

import re
import subprocess
from pathlib import Path

import pytest
from command_line import emulator
from locations import AT_ONCE_OPTIONS
from sums import write_program


@pytest.fixture
def program(tmp_path: Path) -> Path:
    return write_program(tmp_path)


def debug(*arguments: object, stdin: str = "") -> subprocess.CompletedProcess[str]:
    return emulator("debug", *arguments, stdin=stdin)


def script(tmp_path: Path, *commands: str) -> Path:
    path = tmp_path / "commands.txt"
    path.write_text("\n".join(commands) + "\n")
    return path


def test_a_firmware_test_is_ten_lines(program: Path, tmp_path: Path) -> None:
    good = script(
        tmp_path,
        "# sums 5 to 1",
        "break end",
        "continue",
        "assert [total] == 15",
        "assert r0 == 0",
        "lastwrite total",
        "back",
        "goto 0 us",
        "assert pc == start",
    )
    done = debug(program, "-x", good)
    assert done.returncode == 0, done.stdout
    assert re.search(r"wrote 0000000Fh \(before: 0000000Eh\) to total .* at add\+0x2", done.stdout)
    bad = debug(program, "-x", script(tmp_path, "break end", "continue", "assert [total] == 16", "print 1"))
    assert (
        bad.returncode == 1
        and "assertion failed: [total] == 16" in bad.stdout
        and f"{tmp_path}/commands.txt:3" in bad.stdout
    )
    assert "1 (00000001h)" not in bad.stdout  # the script has ended there


def test_a_place_may_be_a_line_of_a_file(program: Path, tmp_path: Path) -> None:
    line = 1 + next(n for n, text in enumerate(program.read_text().splitlines()) if text.startswith("add:"))
    done = debug(
        program,
        "-x",
        script(
            tmp_path,
            f"break sums.asm:{line}",
            "continue",
            "assert pc == add",
            f"break *sums.asm:{line + 1}",
            "continue",
            "assert pc == add + 1",
        ),
    )
    assert done.returncode == 0, done.stdout
    for place, message in (
        ("sums.asm:", "LINE a number"),
        ("sums.asm:1x", "LINE a number"),
        ("sums.asm:0123456789", "LINE a number"),
        ("sums.asm:999999999", "no instruction in that line"),
        ("other.asm:3", "files with lines: sums.asm"),
    ):
        done = debug(program, "-x", script(tmp_path, f"break {place}"))
        assert done.returncode != 0 and message in done.stdout + done.stderr, (place, done.stdout, done.stderr)


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("nonsense", "is not a command"), ("brek total", 'help lists the commands; did you mean "break"?'), ("break", "a place is expected"), ("break nowhere", "is not a place"), ("break add if", "an expression is expected"), ("break add if r0 ==", "column"),
        ("break add ignore many", "an integer of at least 0 is expected"), ("break add chip 5", "there is no chip 5"), ("watch", "a place or a register"), ("watch total,0", "PLACE,WORDS"), ("watch total sometimes", "the end of the command is expected"),
        ("on", r"an event is expected \(see: kinds\)"), ("on miss", "is not an event"), ("when", "an expression is expected"), ("delete 9", "there is no stop condition 9"), ("delete x", "an integer of at least 0 is expected"),
        ("goto never", "is not an instant"), ("goto -1 s", "is not an instant"), ("goto 1 day", "s, ms, us, ns, ps or cycles"), ("goto 1e30 s", "9000000 s"), ("stepi -1", "an integer of at least 0 is expected"), ("out", "no caller"),
        ("print", "a value is expected"), ("print [0x40000000000]", "is no number|nothing can be read"), ("x", "a place is expected"), ("peripherals nothing", "begins with nothing"), ("page nothing", "is expected"),
        ("set r0", "is expected"), ("set r0 = 1.5e99", "beyond"), ("set r1 = 4294967296", "does not fit into r1"), ("set [total] = 4294967296", "does not fit into a word"), ("set [total] = -2147483649", "does not fit into a word"), ("set 100000000h = 1", "is not an address"),
        ("watch r1 read", "of a register, only changes can be watched"), ("set ar0 = 1.5", "holds integers"), ("set 0x50000000 = 1", "reserved"), ("chip 3", "there is no chip 3"), ("source /nowhere", "cannot be read"),
        ("lastwrite", "a place is expected"), ("assert", "a value is expected"),
    ],
)  # fmt: skip
def test_commands_that_make_no_sense_say_what_would_be_right(
    program: Path, tmp_path: Path, command: str, message: str
) -> None:
    done = debug(program, "-x", script(tmp_path, command, "print 6 * 7"))
    assert done.returncode == 2 and "42 " not in done.stdout
    assert re.search(message, done.stdout), done.stdout


def test_the_kinds_of_events_are_those_that_can_stop_the_program(program: Path) -> None:
    done = debug(program, stdin="kinds\n")
    kinds = [line.split()[0] for line in done.stdout.splitlines() if line.startswith("  ")]
    assert done.returncode == 0 and {"rule", "any"} <= set(kinds), done.stdout
    for kind in kinds:
        assert debug(program, stdin=f"on {kind}\n").returncode == 0


def test_where_nobody_sees_the_answer_the_first_command_that_fails_is_the_end(program: Path, tmp_path: Path) -> None:
    for failing, status in (("brake", 2), ("break don", 2), ("assert r0 == 99", 1)):
        piped = debug(program, stdin=f"print 3\n{failing}\nprint 6 * 7\n")
        assert piped.returncode == status and f"standard input:2: {failing}" in piped.stdout
        given = debug(program, "-e", "print 3", "-e", failing, stdin="print 6 * 7\n")
        assert given.returncode == status and f"-e: {failing}" in given.stdout
        both = debug(program, "-e", failing, "-x", script(tmp_path, "print 6 * 7"))
        assert both.returncode == status
        assert not any("42 (" in done.stdout for done in (piped, given, both))
    assert debug(program, "-e", "print 3", stdin="print 6 * 7\nquit\nnonsense\n").returncode == 0


def test_a_script_may_begin_with_the_mark_of_utf_8(program: Path, tmp_path: Path) -> None:
    marked = tmp_path / "marked.txt"
    marked.write_bytes(b"\xef\xbb\xbfprint 6 * 7\n")
    for done in (debug(program, "-x", marked), debug(program, stdin=marked.read_text())):
        assert done.returncode == 0 and "42 (" in done.stdout


def test_a_comment_is_no_empty_line(program: Path) -> None:
    done = debug(program, stdin="stepi\n# a comment\nassert instructions == 1\n")
    assert done.returncode == 0, done.stdout


def test_memory_beyond_what_is_shown_at_once_is_named(program: Path) -> None:
    done = debug(program, stdin="x 300000h 5000\n")
    assert done.stdout.splitlines()[-1] == "4096 words at most; the others begin with: x 00301000h 904"
    assert "at most" not in debug(program, stdin="x 300000h 4096\n").stdout


def test_words_that_other_debuggers_have(program: Path) -> None:
    """`run`, `regs` and the like are the same commands."""
    ours = debug(program, stdin="break add\ncontinue\nregisters\nstack\ndelete 1\nstops\n")
    theirs = debug(program, stdin="b add\nrun\nregs\nbacktrace\nd 1\ninfo\n")
    assert ours.returncode == 0 and "before add" in ours.stdout and "is not a command" not in ours.stdout
    assert (theirs.returncode, theirs.stdout) == (0, ours.stdout)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["/nowhere.asm"], "nowhere.asm"), (["--dsps", "99"], "--dsps"), (["--link", "0.0:1.3"], "programs and networks"), (["-x", "/nowhere"], "cannot be read"), (["--snapshot", "/nowhere"], "nowhere"),
    ],
)  # fmt: skip
def test_what_cannot_be_debugged_is_refused(arguments: list[str], message: str) -> None:
    done = debug(*arguments)
    assert done.returncode == 2 and message in done.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        "--link 0.0:1.3", "--net 0.TCLK0>1.IIOF1", "--action 1,cut,0.0:1.3", "--entry start", "--load-at 300000h", "--load words@300000h", "--poke 300000h=1",
        "--until 300000h", "--memory-max 3", "--board default --board flat", "--console-input keys", "--device-input D=words", "--device-script D=words",
    ],
)  # fmt: skip
def test_what_is_for_programs_is_refused_for_the_dock(arguments: str) -> None:
    done = debug("--dsps", "2", *arguments.split())
    assert done.returncode == 2 and "for programs and networks; give a PROGRAM or --network" in done.stderr


def test_a_program_and_the_dock_exclude_each_other(program: Path) -> None:
    done = debug(program, "--dsps", "2")
    assert done.returncode == 2 and "are for the dock" in done.stderr


def test_the_dock_by_commands() -> None:
    done = debug(
        "--dsps",
        "3",
        "--duration",
        "0.1",
        "--set",
        "report.reference=none",
        *AT_ONCE_OPTIONS,
        stdin="on claim task=pid\nc\npage list\nchips\nblock\nrefresh\nrefresh 2\nrrefresh\nstops\nhistory\nlist\nregisters\nstack\n",
    )
    assert done.returncode == 0
    for text in ("task=pid", "DSP 2", "refresh number=", "snapshots from 0.000000000 s", "cycles of its last run"):
        assert text in done.stdout, text
    assert re.search(r"claim task=pid, met [1-9] times", done.stdout) and "error:" not in done.stdout
    first, third, second = map(int, re.findall(r"refresh number=(\d+)", done.stdout))
    assert (second, third) == (first + 1, first + 2)


def test_fields_and_options_of_an_event_stand_in_any_order() -> None:
    orders = ("on claim chip 2 task=pid", "on claim task=pid chip 2", "on claim ignore 0 task=pid chip 2")
    dock = ("--dsps", "3", "--duration", "0.1", "--set", "report.reference=none", *AT_ONCE_OPTIONS)
    done = debug(*dock, stdin="\n".join([*orders, "continue", "stops"]))
    stops = re.findall(r"^\d: at claim .*met (\d+) times$", done.stdout, re.MULTILINE)
    assert stops == ["1", "1", "1"], done.stdout
    for order in ("on claim chip 2 total", "on claim chip 2 =pid"):
        assert "the end of the command is expected" in debug(*dock, stdin=order).stdout


def test_stop_conditions_are_listed_as_they_were_given(program: Path) -> None:
    done = debug(program, stdin="break add\nwatch total\nwatch r1\nwhen r0 == 3\nstops\n")
    assert re.findall(r"^\d: (.*), met 0 times$", done.stdout, re.MULTILINE) == [
        "before add (00300009h)",
        "after writes to total (0030000Dh) as chip 0 sees it",
        "after a change of r1 of chip 0",
        "when r0 == 3",
    ]


def test_all_registers_of_the_processor_are_shown(program: Path) -> None:
    shown = set(re.findall(r"\b[A-Z][A-Z0-9]*\b", debug(program, stdin="registers\n").stdout))
    extended, auxiliary = {f"R{n}" for n in range(12)}, {f"AR{n}" for n in range(8)}
    rest = [
        "PC",
        "DP",
        "IR0",
        "IR1",
        "BK",
        "SP",
        "ST",
        "DIE",
        "IIE",
        "IIF",
        "RS",
        "RE",
        "RC",
        "IVTP",
        "TVTP",
    ]  # c40-isa.md 1
    assert shown >= {*extended, *auxiliary, *rest}


def test_registers_that_the_last_step_has_changed_are_marked(program: Path) -> None:
    done = debug(program, stdin="stepi 5\nregisters\nstepi\nregisters\n")
    last = done.stdout.split("R0 ")[-1]
    assert "*" in done.stdout and "*R0" not in last


def test_an_empty_line_does_not_repeat_a_step_of_a_file(program: Path, tmp_path: Path) -> None:
    steps = script(tmp_path, "stepi 3")
    done = debug(program, stdin=f"source {steps}\n\nassert instructions == 3\n")
    assert done.returncode == 0, done.stdout


def test_a_stop_condition_ends_steps_that_are_counted(program: Path) -> None:
    done = debug(program, stdin="break add\nstepi 50\nassert pc == add\nassert instructions < 20\n")
    assert done.returncode == 0 and "breakpoint: " in done.stdout, done.stdout


def test_the_text_of_a_log_may_have_an_if_of_its_own(program: Path) -> None:
    """The last one begins the condition."""
    done = debug(program, stdin="break add log 4 if it is {r0} if r0 == 4\ncontinue 100 us\nstops\n")
    assert re.findall(r"4 if it is .*", done.stdout) == ["4 if it is 4 (00000004h)", "4 if it is {r0}, met 1 times"]


def test_an_empty_line_does_the_last_step_again(program: Path) -> None:
    once, thrice = debug(program, stdin="stepi\n\n\nprint cycle\n"), debug(program, stdin="stepi 3\nprint cycle\n")
    assert once.stdout.splitlines()[-1] == thrice.stdout.splitlines()[-1]
