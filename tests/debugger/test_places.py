"""Where a breakpoint stands: at the end of a program, in each of several programs, in one of two files of a name; and
who has called."""

import re
from pathlib import Path

import pytest
from cmrc import c40
from cmrc.network import Network
from command_line import emulator

ENDS = "start:  nop\n        nop\ndone:   b done\n"
ENDLESS = "start:  ldi 0,r0\nloop:   addi 1,r0\n        nop\n        b loop\n"
COMMON = "cloop:  addi 1,r1\n        addi 2,r1\n"
FIRST = 'start:  ldi 10,r0\n        .include "common.inc"\nend:    b end\n'
SECOND = 'start:  ldi 20,r0\n        nop\n        nop\n        .include "common.inc"\nlast:   b last\n'
LINK = ("--link", "0.0:1.3")
STACK = "        ldi @stack,sp\n"


def by_commands(folder: Path, *commands: str, arguments: tuple[str, ...]) -> str:
    (folder / "commands.txt").write_text("\n".join(commands) + "\n")
    done = emulator("debug", *arguments, "-x", "commands.txt", folder=folder)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def write(folder: Path, **files: str) -> None:
    for name, text in files.items():
        path = folder / name.replace("__", "/").replace("_", ".")
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)


# ---- at the end of a program ----


@pytest.mark.parametrize("steps", [("continue",), ("stepi", "stepi"), ("goto 50 ns", "stepi")])
def test_a_breakpoint_at_the_end_is_met_once_and_then_the_run_is_over(tmp_path: Path, steps: tuple[str, ...]) -> None:
    write(tmp_path, ends_asm=ENDS)
    shown = by_commands(
        tmp_path, "break done", *steps, "assert pc == done", "stops", "continue", "stops", arguments=("ends.asm",)
    )
    assert re.search(r"^breakpoint: 1: chip 0 before done", shown, re.MULTILINE)
    assert shown.count("met 1 times") == 2 and shown.index("met 1") < shown.index("over: ")


def test_it_is_met_where_another_chip_goes_on(tmp_path: Path) -> None:
    write(tmp_path, ends_asm=ENDS, endless_asm=ENDLESS)
    shown = by_commands(
        tmp_path, "break done", "continue 10 us", "assert time_s < 1e-6", arguments=("ends.asm", "endless.asm", *LINK)
    )
    assert "breakpoint: 1: chip 0 before done" in shown


def test_where_until_ends_the_run_too(tmp_path: Path) -> None:
    write(tmp_path, ends_asm=ENDS.replace("        nop", "middle: nop", 1))
    shown = by_commands(tmp_path, "break middle", "continue", "continue", arguments=("ends.asm", "--until", "middle"))
    assert shown.index("breakpoint: 1") < shown.index("over: ")


def test_every_front_end_says_the_same_of_it() -> None:
    for debugger in (Network([c40.assemble(ENDS)]).debug(), c40.Processor(c40.assemble(ENDS)).debug()):
        debugger.break_at("done")
        stop = debugger.go()
        assert (stop.reason, len(stop.hits)) == ("breakpoint", 1)


# ---- a change by hand at the end ----


def test_a_changed_pc_at_the_end_goes_on_from_there(tmp_path: Path) -> None:
    write(tmp_path, ends_asm=ENDS)
    shown = by_commands(
        tmp_path,
        *("continue 1 ms", "set pc = start", "stepi", "assert pc == start + 1", "continue", "assert pc == done"),
        *("goto 0 s", "goto 2 ms", "assert pc == done", "assert instructions == 4"),
        arguments=("ends.asm",),
    )
    assert shown.count("over: ") == 3


def test_a_chip_that_has_long_ended_begins_now() -> None:
    network = Network([c40.assemble(ENDS), c40.assemble(ENDLESS)], links=["0.0:1.3"])
    debugger = network.debug()
    debugger.go_to(1e-3)
    assert debugger.value("pc - done", chip=0) == 0
    debugger.set_register("pc", "start", chip=0)
    debugger.break_at("start+1", chip=0)
    stop = debugger.go(2e-3)
    assert stop.reason == "breakpoint" and 1e-3 < stop.time_s < 1e-3 + 1e-6
    at = stop.time_ps
    debugger.go_to(0.5e-3)
    assert debugger.go(2e-3).time_ps == at


def test_a_change_that_ends_nothing_leaves_the_end_where_it_is(tmp_path: Path) -> None:
    write(tmp_path, ends_asm=ENDS)
    shown = by_commands(tmp_path, "continue", "set r5 = 7", "continue", "print cycle", arguments=("ends.asm",))
    unchanged = by_commands(tmp_path, "continue", "print cycle", arguments=("ends.asm",))
    assert shown.splitlines()[-1] == unchanged.splitlines()[-1]


# ---- several programs ----


def test_a_label_or_line_stops_each_chip_whose_program_has_it_there(tmp_path: Path) -> None:
    write(tmp_path, first_asm=FIRST, second_asm=SECOND, common_inc=COMMON)
    programs = ("first.asm", "second.asm", *LINK)
    for place in ("cloop", "common.inc:1", "cloop chip 0", "end", "last"):
        shown = by_commands(tmp_path, f"break {place}", "continue", "continue", "stops", arguments=programs)
        stops = re.findall(r"^breakpoint: .*", shown, re.MULTILINE)
        chips = [re.search(r"chip \d before \w+", stop)[0] for stop in stops]  # type: ignore[index]
        expected = {
            "cloop chip 0": ["chip 0 before cloop"],
            "end": ["chip 0 before end"],
            "last": ["chip 1 before last"],
        }.get(place, ["chip 0 before cloop", "chip 1 before cloop"])
        assert chips == expected, (place, shown)
    assert "1: before cloop (00300001h) of chip 0, cloop (00300003h) of chip 1, met" in by_commands(
        tmp_path, "break cloop", "stops", arguments=programs
    )


def test_it_does_so_from_python_too(tmp_path: Path) -> None:
    write(tmp_path, first_asm=FIRST, second_asm=SECOND, common_inc=COMMON)
    images = [c40.assemble_file(tmp_path / name) for name in ("first.asm", "second.asm")]
    debugger = Network(images, links=["0.0:1.3"]).debug()
    number = debugger.break_at("cloop")
    found = [(hit.number, hit.chip, hit.pc) for stop in debugger.run() for hit in stop.hits]
    assert found == [(number, chip, image.symbols["cloop"]) for chip, image in enumerate(images)]


def test_an_address_is_of_all_chips(tmp_path: Path) -> None:
    write(tmp_path, first_asm=FIRST, second_asm=SECOND, common_inc=COMMON)
    shown = by_commands(tmp_path, "break 300001h", "continue", "stops", arguments=("first.asm", "second.asm", *LINK))
    assert "chip 0 before cloop" in shown and "chip 1 before start+0x1" in shown


# ---- files of one name ----


def test_only_the_named_one_of_two_files_of_a_name_is_meant(tmp_path: Path) -> None:
    write(
        tmp_path,
        two_asm='start:  nop\n        .include "one/x.inc"\n        .include "other/x.inc"\nend:    b end\n',
        one__x_inc="        addi 1,r0\n        addi 2,r0\n",
        other__x_inc="        addi 3,r1\n        addi 4,r1\n",
    )
    for named in ("other/x.inc", f"{tmp_path}/other/x.inc", f"{tmp_path}/./other/../other/x.inc"):
        shown = by_commands(tmp_path, f"break {named}:1", "continue", "assert pc == start + 3", arguments=("two.asm",))
        assert shown.count("breakpoint: ") == 1
    both = by_commands(tmp_path, "break x.inc:1", "stops", arguments=("two.asm",))
    assert "1: before start+0x1 (00300001h), start+0x3 (00300003h), met" in both
    (tmp_path / "commands.txt").write_text("break /somewhere/else/x.inc:1\n")
    refused = emulator("debug", "two.asm", "-x", "commands.txt", folder=tmp_path)
    assert refused.returncode == 2 and "files with lines: two.asm, one/x.inc, other/x.inc" in refused.stdout
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "two.asm").write_text("        nop\n")
    (tmp_path / "commands.txt").write_text(f"break {tmp_path}/elsewhere/two.asm:1\n")
    refused = emulator("debug", "two.asm", "-x", "commands.txt", folder=tmp_path)
    assert refused.returncode == 2, refused.stdout  # that file is known, and is another one
    assert "before start" in by_commands(tmp_path, "break /moved/away/two.asm:1", "stops", arguments=("two.asm",))


# ---- who has called ----

CALLS = f"""\
MASK    .set 0Ch
start:  ldp stack
{STACK}        call sub
        addi 1,r5
end:    b end
sub:    ldi 2,r0
inner:  subi 1,r0
        bnz inner
        call leaf
behind: addi 2,r5
        rets
leaf:   ldi 1,r1
also:   nop
        rets
stack   .word 310000h
"""
RECURSIVE = f"""\
start:  ldp stack
{STACK}        ldi 5,r0
        call f
end:    b end
f:      subi 1,r0
        bz x
        call f
x:      rets
stack   .word 310000h
"""


def frames(shown: str) -> list[int]:
    """The lines of the last `stack`."""
    return [int(line) for line in re.findall(r"^ *\d+ [0-9A-F]{8}h .*:(\d+)\)$", shown, re.MULTILINE)]


def test_a_label_inside_a_routine_hides_no_caller(tmp_path: Path) -> None:
    write(tmp_path, calls_asm=CALLS)
    assert frames(by_commands(tmp_path, "break inner", "continue", "stack", arguments=("calls.asm",))) == [8, 4]
    shown = by_commands(tmp_path, "break also", "continue", "stack", arguments=("calls.asm",))
    assert frames(shown) == [14, 10, 4]
    by_commands(
        tmp_path,
        *("break also", "continue", "out", "assert pc == behind", "out", "assert pc == end - 1"),
        arguments=("calls.asm",),
    )
    by_commands(tmp_path, "break inner+2", "continue", "rout", "assert pc == start + 2", arguments=("calls.asm",))


def test_a_constant_is_no_routine(tmp_path: Path) -> None:
    """The program is at address 0, where the constant is an address inside `sub`."""
    program = (
        "MASK .set 0Ch\nstart: ldhi 31h,ar0\n ldi ar0,sp\n call sub\nend: b end\n nop\n nop\n nop\n nop\nsub: nop\n"
        + " nop\n" * 6
        + " rets\n"
    )
    write(tmp_path, low_asm=program)
    assert emulator("asm", "low.asm", "--section", ".text=0", "-o", "low.out", folder=tmp_path).returncode == 0
    by_commands(
        tmp_path,
        *("break 0Dh", "continue", "out", "assert pc == end"),
        arguments=("low.out", "--board", "flat"),
    )


def test_each_call_of_a_recursion_is_a_frame(tmp_path: Path) -> None:
    write(tmp_path, calls_asm=RECURSIVE)
    shown = by_commands(tmp_path, "break x", "continue", "stack", arguments=("calls.asm",))
    assert frames(shown) == [9, 8, 8, 8, 8, 4]


def test_one_line_with_several_addresses_is_one_stop_condition(tmp_path: Path) -> None:
    text = "m       .macro\n        addi 1,r0\n        .endm\nstart:  ldi 0,r0\nagain:  m\n        m\n        m\n        b again\n"
    write(tmp_path, many_asm=text)
    shown = by_commands(
        tmp_path,
        *("break many.asm:2 ignore 4", "continue", "assert r0 == 4", "continue", "assert r0 == 5", "stops"),
        arguments=("many.asm",),
    )
    assert re.findall(r"^(\d): .*met (\d) times", shown, re.MULTILINE) == [("1", "6")]
