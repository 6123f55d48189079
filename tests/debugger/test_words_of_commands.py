"""What words mean in commands of the debugger: fields of events, names of places, quotes, comments. What means nothing
is refused."""

import re
import subprocess
from pathlib import Path
from typing import Any

import cmrc
import pytest
from cmrc import c40
from cmrc.debug import DebugError, Debugger
from cmrc.network import Network
from command_line import emulator
from dap import responses
from editor import Editor
from locations import AT_ONCE, AT_ONCE_OPTIONS
from sums import write_program

DOCK = ("--dsps", "1", "--duration", "0.05", "--set", "report.reference=none", *AT_ONCE_OPTIONS)
# Labels that are words of expressions and of commands.
ODD = "        .text\nstart:  ldp 0,dp\n" + "".join(
    f"{label}: addi 1,r1\n" for label in ("cycle", "pc", "ivtp", "log", "instructions", "time_s", "PC")
) + "done:   b done\n"  # fmt: skip


def debug(*arguments: object, stdin: str = "", folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    return emulator("debug", *arguments, stdin=stdin, folder=folder)


def commands(folder: Path, program: str, *lines: str) -> subprocess.CompletedProcess[str]:
    return debug(program, stdin="\n".join(lines), folder=folder)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_program(tmp_path)
    (tmp_path / "odd.asm").write_text(ODD)
    return tmp_path


# ---- fields of events ----


def dock(**settings: str | int) -> Debugger:
    return cmrc.Simulation(
        settings={"run.duration_s": 0.05, "report.reference": "none", "machine.dsps": 1, **AT_ONCE, **settings}
    ).debug()


def test_a_number_of_an_event_may_have_any_form() -> None:
    debugger = dock()
    debugger.on("claim")
    first = debugger.go().hits[0].text
    block = int(re.findall(r" block=0x([0-9a-f]+) ", first)[0], 16)
    forms = [str(block), f"{block:X}h", f"0{block:x}H", f"{block:#x}", f"{block:#X}"]
    for form in [*forms, block]:
        debugger = dock()
        debugger.on("claim", block=form)
        assert [hit.text for hit in debugger.go().hits] == [first], form
    done = debug(*DOCK, stdin=f"on claim block={block:#x}\ncontinue\n")
    assert done.returncode == 0 and first in done.stdout


def test_every_field_that_an_event_tells_is_one_that_a_condition_takes() -> None:
    """In the form in which the stop shows it; and only events of chips are of a chip."""
    debugger = dock()
    usual = {"refresh", "load", "claim", "finish", "remove", "semaphore", "doorbell", "interrupt", "idle"}
    numbers = {kind: debugger.on(kind) for kind in debugger.event_kinds() if kind not in ("rule", "bus_transaction")}
    while usual & set(numbers):
        for hit in debugger.go().hits:
            component, kind, fields = re.findall(r"^\S+ \[(.*)\] (\w+) ?(.*)$", hit.text)[0]
            if kind not in numbers:
                continue  # a second one at this instant
            debugger.remove(numbers.pop(kind))
            other = dock()
            other.on(kind, **dict(field.split("=") for field in fields.split()))
            assert hit.text in [found.text for found in other.go().hits], hit.text
            if hit.chip is None:
                with pytest.raises(DebugError, match=f"{kind} is an event of no chip"):
                    other.on(kind, chip=0)
            else:
                assert component == f"dsp {hit.chip}" and other.on(kind, chip=hit.chip)


def test_a_latch_has_signed_numbers_and_a_container_may_be_none() -> None:
    debugger = dock()
    debugger.on("latch", s="-1")
    debugger.on("landed", place="none")
    with pytest.raises(DebugError, match=r"^place=nowhere: a number of 32 bits \(80, 50h, 0x50, -3\), or none is"):
        debugger.on("landed", place="nowhere")


@pytest.mark.parametrize(
    ("kind", "fields", "message"),
    [
        ("claim", {"foo": "1"}, "foo is not a field of claim; task, block, kind, area, tick, generation are possible$"),
        ("claim", {"blok": "1"}, 'are possible; did you mean "block"'),
        ("claim", {"task": "bogus"}, "bogus is not a task; pid, torque_compensation, .*, error are possible$"),
        ("claim", {"task": "PID"}, "PID is not a task; pid, "),
        ("claim", {"task": "identfy"}, 'identfy is not a task; .*; did you mean "identify"'),
        ("claim", {"task": "recompute"}, "recompute is not a task"),
        ("claim", {"tick": ""}, "tick=: a number of 32 bits"),
        ("claim", {"block": "5.0"}, "block=5.0: a number of 32 bits"),
        ("claim", {"block": "kernel_pid"}, "a number of 32 bits"),
        ("claim", {"block": 1 << 32}, "block=4294967296: a number of 32 bits"),
        ("claim", {"block": -(1 << 31) - 1}, "a number of 32 bits"),
        ("claim", {"block": True}, "block=True: a number of 32 bits"),
        ("any", {"foo": 1}, "foo is not a field of any; "),
        ("any", {"rule": "circular"}, "rule is not a field of any"),
        ("any", {"words": 1}, "words is not a field of any"),
        ("rule", {"task": "pid"}, "task is not a field of rule; rule are possible"),
    ],
)
def test_a_field_or_a_value_that_no_event_has_is_refused(kind: str, fields: dict[str, Any], message: str) -> None:
    debugger = dock()
    with pytest.raises(DebugError, match=message):
        debugger.on(kind, **fields)
    assert not debugger.hits()


def test_a_task_of_the_user_is_a_task_of_events(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(
        '[[tasks]]\nname = "mine"\nprogram = "kernel_error"\nkind = 14\nimportance = 0x200\nperiod_ms = 10\n'
    )
    script = "on claim task=mine\non claim task=yours\n"
    done = debug(*DOCK, "--config", "mine.toml", stdin=script, folder=tmp_path)
    assert "1: at claim task=mine" in done.stdout and "error, mine are possible" in done.stdout, (
        done.stdout + done.stderr
    )


def test_events_of_networks_have_a_status_and_chips() -> None:
    network = Network([c40.assemble("start: nop\n nop\ndone: b done\n")] * 2, links=["0.0:1.3"]).debug()
    network.on("end", status="halt", chip=1)
    network.on("any", status="halt")
    network.on("reset", chip=0)
    for kind, fields, message in (
        ("end", {"status": "fault"}, "fault is not a status; halt, idle, until, looping, external_access are possible"),
        ("fault", {"status": "halt"}, "halt is not a status; fault are possible"),
        ("cut", {"link": 0}, "link: cut has no fields"),
        ("cut", {"chip": 0}, "cut is an event of no chip, so that chip 0 never has it"),
    ):
        with pytest.raises(DebugError, match=message):
            network.on(kind, **fields)  # type: ignore[arg-type]
    assert sorted(hit.number for hit in network.go().hits) == [1, 2, 2]
    assert "freezes" in network.event_kinds()["hold"]


def test_the_kinds_are_listed_with_their_fields() -> None:
    done = debug(*DOCK, stdin="kinds\non claim task=pid task=pid\n")
    assert re.search(
        r"^  claim +a DSP claims a task block \(task, block, kind, area, tick, generation\)$", done.stdout, re.MULTILINE
    )
    assert "task: the field is there twice" in done.stdout and done.returncode == 2


# ---- what can be watched ----


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("watch PC", "PC is not a register that can be watched; R0 to R11"), ("watch pc change", "pc is not a register that can be watched"), ("watch ivtp", "ivtp is not a register"), ("watch TVTP", "TVTP is not a register"),
        ("watch r1,2", r"r1 is a register, not a place; the word to which it points is \[r1\]"), ("watch pc,1", "pc is a register"), ("watch r1 write", "of a register, only changes can be watched"), ("watch r1 access", "only changes"),
        ("watch total read write", "the end of the command"), ("watch cycle", "cycle is a counter, not a place"), ("watch instructions", "a counter"), ("watch cause.execute", "a counter"), ("watch time_s", "is not an address"),
        ("watch chip0.r1", "chip0.r1 is a register"), ("lastwrite r1", "r1 is a register"), ("lastwrite PC", "PC is a register"), ("lastwrite cycle", "a counter"), ("set cycle = 1", "a counter"), ("x cycle", "a counter"), ("set Pc = 1.5", "holds integers"),
    ],
)  # fmt: skip
def test_what_is_no_word_and_no_register_to_watch_is_refused(folder: Path, command: str, message: str) -> None:
    done = commands(folder, "sums.asm", command)
    assert done.returncode == 2 and re.search(message, done.stdout), done.stdout


def test_a_place_of_another_chip_is_refused(folder: Path) -> None:
    for command in ("watch chip1.done", "lastwrite chip1.done", "x chip1.sp"):
        done = debug("sums.asm", "odd.asm", "--link", "0.0:1.3", stdin=command, folder=folder)
        assert done.returncode == 2 and "is of chip 1, and a place is one of chip 0" in done.stdout, done.stdout


def test_a_word_to_watch_is_a_label_before_all_else(folder: Path) -> None:
    labels = ("cycle", "pc", "ivtp", "log", "instructions", "time_s", "PC")
    done = commands(
        folder, "odd.asm", *(f"watch {label}" for label in labels), "watch cycle+1", "watch cycle,2", "stops"
    )
    assert done.returncode == 0, done.stdout
    first = 0x00300001
    for n, label in enumerate(labels):
        assert f"{n + 1}: after writes to {label} ({first + n:08X}h) as chip 0 sees it" in done.stdout
    assert f"8: after writes to pc ({first + 1:08X}h)" in done.stdout
    assert f"9: after writes to cycle ({first:08X}h, 2 words)" in done.stdout
    changed = commands(folder, "odd.asm", "set cycle = 0C800000h", "assert [300001h] == 0C800000h", "lastwrite cycle")
    assert changed.returncode == 0 and "not written" in changed.stdout, changed.stdout


def test_registers_point_to_words(folder: Path) -> None:
    done = commands(
        folder, "sums.asm", "set ar0 = total", "watch [ar0]", "watch ar0+1", "x ar0 1", "x sp 1", "lastwrite [ar0]"
    )
    assert done.returncode == 0, done.stdout
    assert "writes to total (0030000Dh)" in done.stdout and "(0030000Eh)" in done.stdout
    assert "\n0030000Dh 00000000" in done.stdout


def test_a_client_is_told_what_can_be_watched(folder: Path) -> None:
    with Editor() as editor:
        editor.begin(program=str(folder / "odd.asm"), stopOnEntry=True)
        editor.configured()
        editor.stopped()

        def watched(name: str, reference: int | None = None) -> str | None:
            arguments = {"name": name} | ({} if reference is None else {"variablesReference": reference})
            answer = editor.ask(editor.send("dataBreakpointInfo", **arguments), responses.DataBreakpointInfoResponse)
            assert answer.dataId or answer.description
            found: str | None = answer.dataId
            return found

        scopes = editor.ask(editor.client.scopes(editor.top().id), responses.ScopesResponse).scopes
        registers, peripherals = scopes[0].variablesReference, scopes[1].variablesReference
        shown = editor.ask(editor.client.variables(registers), responses.VariablesResponse).variables
        for variable in shown:
            can_be = variable.name not in ("PC", "IVTP", "TVTP")
            assert watched(variable.name, registers) == (f"0:{variable.name}" if can_be else None)
        parts = next(v.variablesReference for v in shown if v.name == "R0")
        assert watched("integer", parts) is None and watched("float", parts) is None
        page = editor.ask(editor.client.variables(scopes[2].variablesReference), responses.VariablesResponse).variables
        assert page[0].name == "1" and watched("1", scopes[2].variablesReference) is None
        assert watched("TIMER0.counter", peripherals) == f"0:{0x100024}:1"
        # A name without a scope is a user's text.
        assert watched("cycle") == f"0:{0x300001}:1" and watched("TVTP") is None and watched("r1") == "0:r1"
        assert watched("r1 * 0 + 300000h") == f"0:{0x300000}:1" and watched("f(r1)") is None


# ---- quotes, comments, options ----


@pytest.mark.parametrize("name", ["in c.asm", "prög ä.asm", "a #b.asm"])
def test_a_path_with_blanks_stands_in_quotes(folder: Path, name: str) -> None:
    (folder / "d ir").mkdir()
    (folder / "d ir" / name).write_text("loop:   addi 1,r0\n        b loop\n")
    (folder / "includes.asm").write_text(f'start:  nop\n        .include "d ir/{name}"\n')
    places = [f'"d ir/{name}:1"', f"'{name}:1'", f'"d ir/{name}":1']
    done = commands(
        folder,
        "includes.asm",
        *(f"break {place} ignore 1 # a comment" for place in places),
        "stops",
        f"list {places[0]}",
    )
    assert done.returncode == 0 and done.stdout.count("before loop (00300001h), the first 1 ignored, met 0") == 3, (
        done.stdout
    )
    (folder / f"script {name}").write_text("print 6 * 7\n")
    for quoted in (f'"script {name}"', f"'script {name}'"):
        done = commands(folder, "includes.asm", f"source {quoted}  # a comment")
        assert done.returncode == 0 and "42 (" in done.stdout
    done = commands(folder, "includes.asm", f'break "d ir/{name}:1')
    assert done.returncode == 2 and 'a closing " is expected' in done.stdout


def test_a_comment_begins_at_a_word(folder: Path) -> None:
    done = commands(
        folder,
        "sums.asm",
        "break add # the subroutine",
        "watch total change # of any kind",
        "  # nothing else",
        "break add if r0 == 4 # the second round",
        'break add log it is #{r0} # "of" 5',
        "break add log now if r0 == 3 # the third round",
        "when r0 == 2 # the fourth",
        "stops # all",
        "continue # go",
        "stepi 1 # one",
        "assert r0 == 5 # still",
        "set r2 = 7 # lucky",
        "print r2 # shown",
        "delete 1 # no more",
        "goto 2 us # early",
    )
    assert done.returncode == 0, done.stdout
    assert re.findall(r"^\d: (.*), met 0 times", done.stdout, re.MULTILINE) == [
        "before add (00300009h)",
        "after changes of total (0030000Dh) as chip 0 sees it",
        "before add (00300009h) if r0 == 4",
        'before add (00300009h), tells: it is #{r0} # "of" 5',
        "before add (00300009h) if r0 == 3, tells: now",
        "when r0 == 2",
    ]
    assert "7 (00000007h)" in done.stdout
    assert commands(folder, "sums.asm", "break add#1").returncode == 2


def test_if_and_log_come_in_either_order(folder: Path) -> None:
    orders = ("break add if r0 == 4 log round {r0}", "break add log round {r0} if r0 == 4")
    told = [commands(folder, "sums.asm", order, "continue 1 ms", "stops").stdout for order in orders]
    assert told[0] == told[1] and "round 4 (00000004h)" in told[0] and "if r0 == 4, tells: round {r0}, met 1" in told[0]
    done = commands(folder, "sums.asm", "break add if r0 == 4 log why? if not now # yes", "stops")
    assert "before add (00300009h) if r0 == 4, tells: why? if not now # yes, met" in done.stdout
    done = commands(folder, "odd.asm", "break done if log == 300004h", "break done if log == 300004h log here", "stops")
    assert done.returncode == 0 and "if log == 300004h, tells: here" in done.stdout, done.stdout
    for wrong in ("break add if log text", "break add if r0 == log text", "break add if # 1"):
        assert commands(folder, "sums.asm", wrong).returncode == 2, wrong


# ---- inputs that are no commands ----


def test_a_folder_is_no_script(folder: Path) -> None:
    (folder / "scripts").mkdir()
    by_option = debug("sums.asm", "-x", "scripts", folder=folder)
    assert by_option.returncode == 2 and "scripts: is a directory; a file of commands is expected" in by_option.stderr
    sourced = commands(folder, "sums.asm", "source scripts")
    assert sourced.returncode == 2 and "scripts: is a directory" in sourced.stdout
    (folder / "wide.txt").write_text("print 1\n", encoding="utf-16")
    assert "wide.txt:1: the text is in UTF-16" in debug("sums.asm", "-x", "wide.txt", folder=folder).stderr


def test_a_script_may_be_a_pipe_and_end_without_a_line_feed(folder: Path) -> None:
    done = debug("sums.asm", "-x", "/dev/stdin", stdin="print 6 * 7\r\n\r\nprint 6 * 8", folder=folder)
    assert done.returncode == 0 and "42 (" in done.stdout and "48 (" in done.stdout
