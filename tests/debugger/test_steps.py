"""Steps: what they leave behind, the same ones backwards, interrupts, and SWI."""

from collections.abc import Callable
from itertools import islice
from pathlib import Path

import cmrc
import pytest
from cmrc import c40
from cmrc.debug import Debugger
from cmrc.network import Network
from command_line import emulator
from editor import Editor

NESTED = """
        .text
start:  ldhi 2fh,sp
        or 0fc00h,sp
        call outer
        ldi 2,r0
        call outer
        ldi 3,r0
done:   b done
outer:  addi 1,r1
        call inner
        addi 1,r1
        rets
inner:  addi 1,r1
in:     nop
        rets
"""
SWIS = """
        .text
start:  ldi 1, r0
        swi
        swi
        ldi 3, r0
        swi
done:   b done
"""
RETURNS = """
        .text
start:  ldhi 2fh,sp
        or 0fc00h,sp
        push r0
        ldi 1,r0
        pop r0
        {link} linked
        nop
        nop
        nop
        ldi 1,r0
        call plain
        ldi 2,r0
        call jumps
        ldi 3,r0
        callne plain
        bne over
        call plain
over:   ldi 4,r0
done:   b done
plain:  addi 1,r1
        rets
jumps:  push r1
        addi 1,r1
        pop r1
        pop ar2
        bud ar2
        nop
        nop
        nop
linked: addi 1,r1
        {back}
"""
TIMER = """
        .sect "vec"
        .align 512
vec:    .space 2
        .word isr
        .space 61
        .text
start:  ldhi 2fh,sp
        or 0fc00h,sp
        ldhi hi16(vec),ar0
        or lo16(vec),ar0
        ldpe ar0,ivtp
        ldhi 10h,ar1
        or 20h,ar1
        ldi 15,r0
        sti r0,*+ar1(8)
        ldi 3c1h,r0
        sti r0,*ar1
        ldi 1,iie
        or 2000h,st
        {waits}
        {waits}
        ldi 0,iie
        nop
done:   b done
isr:    addi 1,r1
        addi 1,r2
        reti
"""
CALLS = """
        .text
start:  ldi 1,r0
first:  swi
        ldi 2,r0
second: swi
        ldi 3,r0
done:   b done
"""
SWI = 0x66000000


def alone(source: str) -> Debugger:
    return c40.Processor(c40.assemble(source)).debug()


def network(source: str) -> Debugger:
    return Network([c40.assemble(source)]).debug()


@pytest.mark.parametrize("make", [alone, network])
@pytest.mark.parametrize("step", ["over", "next_line", "out"])
def test_a_step_that_another_stop_ends_leaves_no_stop_condition(make: Callable[[str], Debugger], step: str) -> None:
    debugger = make(NESTED)
    debugger.break_at("outer" if step == "out" else "start+2")
    debugger.go()
    number = debugger.break_at("in")
    assert debugger.step(step).reason == "breakpoint" and debugger.value("pc == in")
    assert 0 not in debugger.hits()
    debugger.remove(number)
    stop = debugger.go()
    assert (stop.reason == "breakpoint" and stop.hits) if step == "out" else stop.reason == "over"


def test_a_step_of_the_dock_that_another_stop_ends_leaves_none() -> None:
    debugger = cmrc.Simulation(dsps=1, settings={"run.duration_s": 0.03, "report.reference": "none"}).debug()
    number = debugger.break_at("kernel_pid")
    assert [debugger.step("refresh").reason for _ in range(2)] == ["step", "breakpoint"]
    assert list(debugger.hits()) == [number]


@pytest.mark.parametrize("make", [alone, network])
def test_a_step_behind_the_end_leaves_none(make: Callable[[str], Debugger]) -> None:
    debugger = make(NESTED.replace("in:     nop", "in:     b in"))
    assert debugger.go().reason == "over"
    assert debugger.step("out").reason == "over" and debugger.hits() == {}
    assert debugger.back().reason == "start"


def chain(debugger: Debugger, how: str) -> list[int]:
    """The instants of steps to the end of the program."""
    times = []
    while debugger.value("pc != done"):
        times.append(debugger.stop.time_ps)
        assert debugger.step(how).reason == "step"
    return times


@pytest.mark.parametrize("make", [alone, network])
@pytest.mark.parametrize("how", ["over", "next_line"])
@pytest.mark.parametrize("link", ["laj", "lajne"])
@pytest.mark.parametrize("back", ["b r11", "bud r11\n        nop\n        nop\n        nop"])
def test_steps_over_calls_go_back_the_way_they_came(
    make: Callable[[str], Debugger], how: str, link: str, back: str
) -> None:
    debugger = make(RETURNS.format(link=link, back=back))
    times = chain(debugger, how)
    assert [debugger.step_back(how).time_ps for _ in times] == times[::-1]


def test_a_call_of_long_ago_is_found() -> None:
    """Longer than what is looked at instruction by instruction."""
    debugger = alone(
        NESTED.replace("in:     nop", "        ldi 1000,ar2\nin:     rpts 200\n        nop\n        db ar2,in")
    )
    times = chain(debugger, "over")
    assert times[-1] - times[-2] > 10**9
    assert [debugger.step_back("over").time_ps for _ in times] == times[::-1]


@pytest.mark.parametrize("make", [alone, network])
@pytest.mark.parametrize("waits", ["idle", "rpts 40\n        nop"])
def test_an_interrupt_is_a_step_of_its_own(make: Callable[[str], Debugger], waits: str) -> None:
    debugger = make(TIMER.format(waits=waits))
    states = []
    while debugger.value("pc != done"):
        states.append((debugger.stop.time_ps, debugger._core.state()))
        assert debugger.step().reason == "step"
    begun = debugger.break_at("isr")
    for state in states[::-1]:
        assert (debugger.step_back().time_ps, debugger._core.state()) == state
    while debugger.go().hits:
        assert debugger.stop.time_ps in dict(states)
    assert debugger.hits()[begun] == 2


@pytest.mark.parametrize("make", [alone, network])
def test_a_step_back_over_calls_passes_over_an_interrupt(make: Callable[[str], Debugger]) -> None:
    debugger = make(TIMER.format(waits="idle"))
    before = debugger.value("r1")
    debugger.break_at("isr+2")
    debugger.go()
    assert debugger.step("over").reason == "step"
    returned = debugger.value("pc")
    debugger.step_back("over")
    assert debugger.value("pc") == returned - 1 and debugger.value("r1") == before


# ---- SWI ----


@pytest.mark.parametrize("make", [alone, network])
def test_swi_is_a_stop_and_is_passed_by_a_changed_pc(make: Callable[[str], Debugger]) -> None:
    debugger = make(CALLS)
    for place in ("first", "second"):
        for _ in range(2):  # again when it continues
            stop = debugger.go()
            assert stop.reason == "software_interrupt" and debugger.value(f"pc == {place}"), stop
            assert "SWI" in stop.text and "there is none" not in stop.text and not stop.hits
        assert debugger.step().reason == "software_interrupt"
        debugger.set_register("pc", f"{place} + 1")
    assert debugger.go().reason == "over" and debugger.value("r0") == 3


@pytest.mark.parametrize("make", [alone, network])
def test_swi_is_found_again_after_going_back(make: Callable[[str], Debugger]) -> None:
    debugger = make(CALLS)
    stop = debugger.go()
    for _ in range(2):
        debugger.go_to(0)
        assert debugger.go() == stop
        debugger.step_back()
        assert debugger.step("over").reason == "software_interrupt" and debugger.stop.time_ps == stop.time_ps
        assert debugger.go().reason == debugger.go_to(1e-3).reason == "software_interrupt"


@pytest.mark.parametrize("make", [alone, network])
def test_every_stop_includes_those_at_swi(make: Callable[[str], Debugger]) -> None:
    assert [stop.reason for stop in make(CALLS).run()] == ["software_interrupt"]


@pytest.mark.parametrize("make", [alone, network])
def test_every_stop_includes_swi_of_the_same_instant_where_the_pc_is_set(make: Callable[[str], Debugger]) -> None:
    debugger, places = make(SWIS), []
    for stop in islice(debugger.run(), 9):
        places.append((stop.reason, debugger.value("pc - start")))
        debugger.set_register("pc", "pc + 1")
    assert places == [("software_interrupt", 1), ("software_interrupt", 2), ("software_interrupt", 4)]
    assert debugger.value("r0") == 3 and debugger.stop.reason == "over"


def test_every_stop_includes_swi_of_two_chips_in_one_cycle() -> None:
    chips = [c40.assemble(SWIS)] * 2
    debugger, stops = Network(chips).debug(), []
    for stop in islice(debugger.run(), 9):
        assert stop.reason == "software_interrupt" and stop.chip is not None
        stops.append((stop.chip, debugger.value("pc - start", chip=stop.chip)))
        debugger.set_register("pc", "pc + 1", chip=stop.chip)
    assert sorted(stops) == [(chip, place) for chip in (0, 1) for place in (1, 2, 4)]
    assert [debugger.value("r0", chip=chip) for chip in (0, 1)] == [3, 3]
    # Left where they are, both are one stop; a PC that is set to where it was changes nothing.
    for sets in (False, True):
        debugger, stops = Network(chips).debug(), []
        for stop in islice(debugger.run(), 9):
            stops.append((stop.chip, stop.text.count("before SWI")))
            if sets:
                debugger.set_register("pc", "pc", chip=stop.chip)
        assert stops == [(0, 2)]


def test_other_chips_continue() -> None:
    """The stop is one instant of all chips; without the debugger it is a fault, at the same instant."""
    sources = [CALLS, NESTED]
    chips = Network([c40.assemble(source) for source in sources])
    debugger = chips.debug()
    ends = debugger.on("fault")
    stop = debugger.go()
    assert (stop.reason, stop.chip, stop.time_ps) == ("software_interrupt", 0, 50_000)
    stop = debugger.go()
    assert (
        stop.reason == "software_interrupt"
        and stop.chip == 0
        and debugger.value("chip1.pc") == debugger.places("done", chip=1)[0]
    )
    assert debugger.hits()[ends] == 0
    stop = debugger.back()
    assert (stop.reason, stop.chip, stop.time_ps) == ("software_interrupt", 0, 50_000)


def test_a_dsp_of_the_dock_stops_there_and_has_its_fault_when_the_run_continues() -> None:
    debugger = cmrc.Simulation(dsps=2, settings={"run.duration_s": 0.021, "report.reference": "none"}).debug()
    kernel = debugger.places("kernel_pid")[0]
    debugger.break_at(kernel)
    begins = debugger.go()
    for chip in range(2):
        debugger.set_word(kernel, SWI, chip=chip)
    debugger.go_to_ps(begins.time_ps - 1_000_000)
    debugger.go()
    assert debugger.step().reason == "software_interrupt" and debugger.stop.chip == begins.chip
    stops = list(debugger.run())
    assert {stop.reason for stop in stops} <= {"software_interrupt", "breakpoint"}
    assert f"DSP {begins.chip}: stands still" in debugger.page("dsps")


def test_the_terminal_and_an_editor_say_so_too(tmp_path: Path) -> None:
    path = tmp_path / "calls.asm"
    path.write_text(CALLS)
    shown = emulator("debug", path, stdin="c\nc\nset pc = first + 1\nc\nchips\nset pc = done\nc\n").stdout
    assert shown.count("software_interrupt: ") == 3 and shown.count("over: ") == 1 and "there is none" not in shown
    with Editor() as editor:
        editor.begin(program=str(path))
        editor.configured()
        for _ in range(2):
            assert "SWI" in editor.stopped().text
            editor.client.continue_(1)


def test_the_first_step_of_a_session_marks_what_it_changes(tmp_path: Path) -> None:
    path = tmp_path / "calls.asm"
    path.write_text(CALLS)
    shown = emulator("debug", path, stdin="registers\nstepi\nregisters\n").stdout
    before, after = shown.split("chip 0  0030000", 2)[1:]
    assert "*" not in before and "*R0" in after and "*PC" in after and "*R1" not in after
