"""What a user meets: names that are nearly right, windows after the end, programs shown and refused."""

import re
import shutil
from pathlib import Path

import cmrc
import pytest
from locations import ROOT

CONFIGURATIONS = [
    ("[[event]]\nat_s = 1\n", 'event: no such table; did you mean "[[events]]"?'),
    ("[[task]]\nname = 1\n", 'task: no such table; did you mean "[[tasks]]"?'),
    ("[sheduling]\nzzz = 1\n", 'sheduling: no such table; did you mean "[scheduling]"?'),
    ("[machin]\ndsps = 4\n", 'machin.dsps: no such key; did you mean "machine.dsps"?'),
    ('[[tasks]]\nprogramm = "x"\n', "tasks.programm: no such field; "),
    ('[[tasks]]\nprogramm = "x"\n', 'did you mean "program"?'),
    ("[errors]\nx = 1\n", "errors.x: no such key; the keys of its table are errors.following_travel_m, "),
    (
        "[dock]\nwind = 1\n",
        "dock.wind: no such key; keys with that word are dock.capture_window_m, dock.wind_mean_m_s,",
    ),
    ("zzz = 1\n", "zzz: no such key; docs/configuration.md lists the keys"),
    ("[[events]]\nat = 1\n", 'did you mean "at_s"?'),
    ("[[processes]]\nnumbr = 1\n", 'did you mean "number"?'),
    ("[[subprocesses]]\nnam = 1\n", 'did you mean "name"?'),
]


@pytest.mark.parametrize(("text", "message"), CONFIGURATIONS)
def test_an_unknown_name_gets_the_right_nearest_one(run, tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "c.toml").write_text(text)
    done = run("config", "--config", "c.toml")
    assert (done.returncode, done.stdout) == (2, "")
    assert message in done.stderr


def test_a_folder_is_no_configuration(run, tmp_path: Path) -> None:
    done = run("config", "--config", tmp_path)
    assert done.returncode == 2
    assert "is a directory; the name of a TOML file is expected" in done.stderr


def test_a_number_without_a_fraction_is_an_integer() -> None:
    assert cmrc.Simulation(dsps=4.0).config.to_toml() == cmrc.Simulation(dsps=4).config.to_toml()
    for wrong in (4.5, True, float("nan"), float("inf"), 1e300):
        with pytest.raises(cmrc.ConfigError, match=r"machine.dsps: .*an integer from 1 to 16 is expected"):
            cmrc.Simulation(dsps=wrong)


def test_a_number_of_an_option_is_checked_as_its_key_is(run) -> None:
    done = run("--dsps", "4.0", "--duration", "0.05")
    assert done.returncode == 0 and done.stdout.startswith("4 DSPs, 0.050 s simulated")
    for option, wrong, message in (
        ("--dsps", "4.5", "machine.dsps: 4.5 is a number; an integer from 1 to 16 is expected"),
        ("--dsps", "true", "machine.dsps: true is a boolean; an integer from 1 to 16 is expected"),
        ("--dsps", "nan", "machine.dsps: nan is a number; an integer from 1 to 16 is expected"),
        ("--duration", "long", 'run.duration_s: "long" is a string; a number from 1e-06 to 86400 is expected (s)'),
    ):
        done = run(option, wrong)
        assert (done.returncode, done.stdout) == (2, "") and done.stderr == f"emulator: {option}: {message}\n"
    done = run("exec", "p.out", "--max-cycles", "1.5")
    assert done.returncode == 2 and '--max-cycles: "1.5" cannot be used; an integer is expected' in done.stderr


USAGE = [
    (["exce", "p.out"], 'there is no command "exce"; config, limits, '),
    (["exce", "p.out"], 'are known, and without a command the dock runs; did you mean "exec"? (emulator --help lists commands and options)'),
    (["sweep"], 'are known, and without a command the dock runs; python -m cmrc --help lists those of the Python package (emulator --help'),
    (["p.asm"], 'trace-diff, vectors are known, and without a command the dock runs; emulator exec runs a program (emulator --help'),
    (["--durations", "1"], '--durations: there is no such option; did you mean "--duration"? (emulator --help'),
    (["exec", "p.out", "--max-cycle=5"], '--max-cycle: there is no such option of emulator exec; did you mean "--max-cycles"? (emulator exec --help lists options)'),
    (["--event", "1"], "--event: there is no such option (emulator --help"),
    (["--snapshot", "1:s"], '--snapshot: there is no such option; did you mean "--snapshot-at"? ('),
    (["exec", "p.out", "--until"], "--until: its value is missing: [CHIP:]SYMBOL|ADDRESS[==WORD] ("),
    (["exec", "p.out", "-x"], "-x: there is no such option of emulator exec (emulator exec --help"),
    (["exec", "p.out", "--max-cycles", "-5"], '--max-cycles: "-5" cannot be used; an integer of at least 1 is expected ('),
    (["vectors", "v.txt", "--show", "-1"], '--show: "-1" cannot be used; an integer of at least 0 is expected ('),
    (["--debug", "70000"], '"70000" cannot be used; an integer from 0 to 65535 is expected ('),
    (["asm", "p.asm", "-o", "p.out", "--cpu", "c50"], '--cpu: "c50" cannot be used; c40 or c3x is expected ('),
    (["image", "p.out", "-o", "p.bin", "--format", "hex"], '"hex" cannot be used; boot-stream, intel-hex, srec or binary is expected ('),
    (["config", "p.out"], '"p.out" was not expected (emulator config --help lists options)'),
]  # fmt: skip


@pytest.mark.parametrize(("arguments", "message"), USAGE)
def test_a_wrong_command_line_says_what_would_be_right(run, arguments: list[str], message: str) -> None:
    done = run(*arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert message in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("option", "given"), [("-D", "x=-5"), ("-D", "x=0b11"), ("-D", "x==3"), ("-D", "x=y=3"), ("--section", ".text=zz")]
)
def test_a_number_of_the_assembler_is_not_called_an_address(run, tmp_path: Path, option: str, given: str) -> None:
    (tmp_path / "p.asm").write_text("start: nop\n")
    done = run("asm", tmp_path / "p.asm", "-o", tmp_path / "p.out", option, given)
    value = given.partition("=")[2]
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        f'emulator: {option}: "{value}" cannot be used; a number from 0 to 0FFFFFFFFh is expected '
        "(300000h, 0x300000 or decimal)\n"
    )


def test_a_trace_window_after_the_end_is_refused(run, tmp_path: Path) -> None:
    done = run("--duration", 1, "--trace", "t", "--trace-window", "2:3")
    assert done.returncode == 2
    assert "--trace-window: it begins at 2 s, and the run ends at 1 s" in done.stderr
    assert not (tmp_path / "t").exists()


def test_programs_without_a_symbol_are_bad_input(run, tmp_path: Path) -> None:
    (tmp_path / "dsp.asm").write_text("        .text\n_start: b _start\n        .end\n")
    done = run("--programs", tmp_path, "--duration", 1)
    assert done.returncode == 2
    assert "the program has no symbol" in done.stderr


def test_an_idle_policy_that_the_executive_numbers_otherwise_is_bad_input(run, tmp_path: Path) -> None:
    shutil.copytree(ROOT / "c40_programs", tmp_path / "programs")
    executive = tmp_path / "programs" / "executive.asm"
    text = executive.read_text(encoding="utf-8")
    executive.write_text(text.replace("IDLE_SPIN       .set 2", "IDLE_SPIN       .set 3"), encoding="utf-8")
    done = run("--programs", tmp_path / "programs", "--idle-policy", "spin", "--duration", 0.03)
    assert done.returncode == 2
    assert 'does not know "spin"; executive.asm with IDLE_SPIN .set 2 is expected' in done.stderr
    assert run("--programs", tmp_path / "programs", "--duration", 0.03).returncode == 0


def test_disasm_folds_equal_words_and_shows_data_as_data(run, tmp_path: Path) -> None:
    (tmp_path / "p.asm").write_text(
        "        .text\n_start: b _start\n        .data\nx:      .word 1\n        .space 20\ny:      .word 7\n"
    )
    lines = run("disasm", "p.asm").stdout.splitlines()
    [first] = [i for i, line in enumerate(lines) if line.endswith("00000001  .word 0x00000001")]
    assert re.fullmatch(r"[0-9A-F]{8}  00000000  \.word 0x00000000", lines[first + 1])
    assert re.fullmatch(r"\.\.\.       19 more of the same, to [0-9A-F]{8}h", lines[first + 2])
    assert lines[first + 3] == "y:"
    assert lines[first + 4].endswith("00000007  .word 0x00000007")


REPEATED = {
    "DIR": "d", "NAME[=NUMBER]": "a=1", "NAME=ADDRESS": ".text=1000h", "[CHIP:]ADDRESS:COUNT": "1000h:2", "default|flat|FILE.toml": "flat",
    "CHIP.PORT:CHIP.PORT": "0.0:1.3", "0.TCLK0>1.IIOF1": "0.TCLK0>1.IIOF1", "AT_US,ACTION,LINK|CHIP|NET": "1,cut,0.0:1.3", "[CHIP:]SYMBOL|ADDRESS[==WORD]": "end",
    "FILE@ADDRESS": "rom@1000h", "FILE@[CHIP:]ADDRESS": "words@1000h", "[CHIP:]ADDRESS=WORD": "1000h=2", "NAME=FILE": "D=words", "FILE": "commands", "COMMAND": "quit",
}  # fmt: skip


@pytest.mark.parametrize("command", ["exec", "debug", "asm", "disasm"])
def test_an_option_that_may_be_repeated_takes_one_value_each_time(run, command: str) -> None:
    """What follows the value is the program."""
    options = re.findall(
        r"^  (?:-\w,)?(--?[a-z][\w-]*) (\S+) \.\.\.", run(command, "--help").stdout, flags=re.MULTILINE
    )
    assert options
    for option, value in options:
        if option == "--set":  # of the dock: no program follows
            continue
        before = {"asm": ["-o", "p.out"], "--rom": ["--boot", "1000h"]}
        given = [*before.get(command, []), *before.get(option, []), option, REPEATED[value], "p.asm"]
        done = run(command, *given)
        expected = ("p.asm: no such file", "there is no device D")
        assert done.returncode == 2 and any(text in done.stderr for text in expected), (given, done.stderr)
