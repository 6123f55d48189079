"""Where a breakpoint stands: at the end of a program, in each of several programs, in one of two files of a name; and
who has called."""

import re
from itertools import islice
from pathlib import Path

import pytest
from cmrc import c40
from cmrc.debug import DebugError, Debugger
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


def front_ends(source: str) -> tuple[Debugger, Debugger]:
    return Network([c40.assemble(source)]).debug(), c40.Processor(c40.assemble(source)).debug()


@pytest.mark.parametrize("ignore", [0, 1])
@pytest.mark.parametrize("first", ["nop", "or 2000h,st", "ldi 1,iie"], ids=["plain", "GIE", "without GIE"])
@pytest.mark.parametrize("last", ["b done", "idle", "br done"])
def test_every_front_end_comes_to_the_same_end(first: str, last: str, ignore: int) -> None:
    seen = []
    for debugger in front_ends(ENDS.replace("nop", first, 1).replace("b done", last)):
        debugger.break_at("done", ignore=ignore)
        stops = [(stop.time_ps, stop.reason, len(stop.hits)) for stop in islice(debugger.run(), 5)]
        ends = [(debugger.go().reason, debugger.time_s, debugger.value("cycle"), debugger.value("pc")) for _ in "12"]
        assert len(stops) == 1 - ignore and ends[0] == ends[1] and ends[0][0] == "over"
        seen.append((stops, ends))
    assert seen[0] == seen[1]


def test_the_end_is_found_again_after_going_back() -> None:
    for debugger in front_ends(ENDS):
        end = debugger.go()
        for instant in (0.0, end.time_s / 2, end.time_s):
            debugger.go_to(instant)
            assert debugger.go(1e-3) == end
        number = debugger.break_at("done")
        debugger.go_to(end.time_s / 2)
        assert [stop.hits[0].number for stop in islice(debugger.run(), 5)] == [number]


def test_a_branch_to_itself_that_an_interrupt_leaves_is_no_end() -> None:
    """The timer's interrupt returns behind the branch."""
    source = """
        .text
start:  ldp     stack
        ldi     @stack,sp
        ldi     @vectors,r0
        ldpe    r0,ivtp
        ldi     @timer,ar0
        ldi     100,r0
        sti     r0,*+ar0(8)
        ldi     03C1h,r0
        sti     r0,*ar0
        ldi     1,iie
        or      2000h,st
wait:   b       wait
done:   b       done
served: pop     r0
        addi    1,r0
        push    r0
        ldi     0,iie
        andn    2000h,st
        retsu
stack:  .word   2FF900h
timer:  .word   100020h
vectors: .word  table
        .align  200h
table:  .space  2
        .word   served
"""
    for debugger in front_ends(source):
        debugger.break_at("done")
        (stop,) = islice(debugger.run(), 5)
        assert stop.reason == "breakpoint" and stop.time_s > 100 * 50e-9
        debugger.go_to(1e-6)
        debugger.break_at("wait")
        assert len(list(islice(debugger.run(), 5))) == 5


def test_a_processor_runs_by_itself_as_without_its_debugger() -> None:
    program = c40.assemble(ENDS)
    processor, alone = c40.Processor(program), c40.Processor(program)
    debugger = processor.debug()
    debugger.go()
    debugger.close()
    alone.run(3 * 4)
    debugger = processor.debug()
    debugger.go()
    for run in ({"max_cycles": 100}, {"max_cycles": 100, "until": "done"}):
        assert processor.run(**run).reason == alone.run(**run).reason
    debugger.close()
    assert processor.run(100).reason == "limit"
    processor.reset()
    processor.pc = "start"
    assert processor.run(100, until="done").reason == "until"


# ---- a change by hand at the end ----


def test_the_end_is_met_from_inside_its_last_instruction() -> None:
    for debugger in front_ends(ENDS.replace("nop", "b done", 1)):
        end = debugger.go()
        assert end.reason == "over"
        for back_ps in (100_000, 50_000, 25_000, 1):
            debugger.go_to_ps(end.time_ps - back_ps)
            number = debugger.break_at("done")
            assert [hit.number for hit in debugger.go().hits] == [number]
            assert debugger.stop.time_ps == end.time_ps
            debugger.remove(number)
            assert debugger.go().time_ps == end.time_ps and debugger.stop.reason == "over"


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


WAITS = """
        .text
start:  ldhi    10h,ar0
        or      41h,ar0         ; input FIFO of port 0
        nop
wait:   ldi     *ar0,r0
        nop
good:   addi    1,r5
done:   b       done
"""


@pytest.mark.parametrize("place", ["good", "done", "wait", "pc"])
def test_a_changed_pc_takes_a_wait_for_a_port_away(place: str, tmp_path: Path) -> None:
    write(tmp_path, waits_asm=WAITS)
    commands = ("continue", "assert pc == wait", f"set pc = {place}", "continue", "goto 1 ms", "print pc - done")
    shown = by_commands(tmp_path, *commands, arguments=("waits.asm",))
    last = re.findall("^over: .*", shown, re.MULTILINE)[-1]
    waits = place in ("wait", "pc")
    assert ("at PC 00300003h (wait" in last) == waits and ("branches to itself" in last) != waits
    for debugger in front_ends(WAITS):
        debugger.go()
        debugger.set_register("pc", place)
        assert debugger.go().reason == "over"
        assert debugger.value("pc - wait" if waits else "pc - done") == 0
        assert debugger.value("r5") == (place == "good")


def test_it_is_taken_away_in_the_middle_of_a_run_too() -> None:
    """Chip 1 sends a word that chip 0 does not wait for any more; it is left in the FIFO."""
    sends = c40.assemble(
        "        .text\nstart:  ldhi 10h,ar0\n        or 72h,ar0\n        ldi 999,rc\n        rptb to\n"
        "to:     nop\n        sti r0,*ar0\nend:    b end\n"
    )
    network = Network([c40.assemble(WAITS), sends], links=["0.0:1.3"])
    debugger = network.debug()
    debugger.go_to(20e-6)
    assert debugger.value("pc - wait", chip=0) == 0 and debugger.value("pc - to", chip=1) == 0
    debugger.set_register("pc", "good", chip=0)
    debugger.break_at("done", chip=0)
    stop = debugger.go(1e-3)
    assert stop.reason == "breakpoint" and 20e-6 < stop.time_s < 21e-6
    assert debugger.go(1e-3).reason == "over"
    assert debugger.value("pc - done", chip=0) == 0 and network.chips[0].message.startswith("branches to itself")
    debugger.go_to(10e-6)
    assert debugger.go(1e-3) == stop


def test_it_is_taken_away_where_a_window_has_nothing_behind_it() -> None:
    for debugger in front_ends(WAITS.replace("10h,ar0", "0C000h,ar0")):
        assert debugger.go().reason == "over"
        debugger.set_register("pc", "good")
        assert debugger.go().reason == "over"
        assert debugger.value("pc - done") == 0


FAULTS = WAITS.replace("10h,ar0", "5000h,ar0")


def test_a_fault_is_an_end_that_a_changed_pc_does_not_take_away(tmp_path: Path) -> None:
    for debugger in front_ends(FAULTS):
        end = debugger.go()
        assert end.reason == "over" and "50000041h" in end.text
        with pytest.raises(DebugError, match="a fault has halted the chip, and only a reset ends that"):
            debugger.set_register("pc", "good")
        debugger.set_register("r1", "7")
        assert debugger.go().text == end.text and debugger.value("r1") == 7
        debugger.go_to(0.0)
        debugger.go_to(end.time_s)
        debugger.step_back()
        debugger.set_register("pc", "good")
        assert debugger.go().text != end.text and debugger.value("pc - done") == 0
    write(tmp_path, faults_asm=FAULTS)
    (tmp_path / "commands.txt").write_text("continue\nset pc = good\n")
    done = emulator("debug", "faults.asm", "-x", "commands.txt", folder=tmp_path)
    assert done.returncode == 2 and "the PC of chip 0 cannot be set" in done.stdout


def test_a_call_for_a_debugger_is_passed_by_a_changed_pc() -> None:
    for debugger in front_ends(FAULTS.replace("ldi     *ar0,r0", "swi")):
        assert "SWI" in debugger.go().text
        debugger.set_register("pc", "good")
        assert debugger.go().reason == "over" and debugger.value("pc - done") == 0


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


def test_of_many_addresses_the_first_are_named_and_the_others_counted(tmp_path: Path) -> None:
    write(tmp_path, many_asm="start:  ldi 0,r0\n        .rept 10\n        addi 1,r0\n        .endr\nend:    b end\n")
    shown = by_commands(tmp_path, "break many.asm:3", arguments=("many.asm",))
    named = ", ".join(f"start+0x{n} (0030000{n}h)" for n in range(1, 9))
    assert f"1: before {named}, and 2 more\n" in shown
