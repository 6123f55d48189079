"""Registers and words of a DSP of the dock that Python changes between two runs: an idle DSP looks again, as at a
change in the debugger."""

from typing import Any

from cmrc import Simulation, c40
from locations import AT_ONCE

ROUTINE, TINT0 = 0x2FFF00, 1 << 24
IMAGE = c40.assemble("        .text\n        addi 1,r11\n        reti\n", sections={".text": ROUTINE})


def with_an_idle_dsp() -> Simulation:
    settings: dict[str, Any] = {**AT_ONCE, "machine.dsps": 1, "machine.idle_policy": "doorbell", "run.duration_s": 0.01}
    made = Simulation(settings=settings)
    while not made.dsp(0)._core.idle:
        made.run_until(made.time_s + 1e-4)
    return made


def interrupt(made: Simulation, by_debugger: bool) -> None:
    """Timer 0's, with a service routine of its own."""
    dsp = made.dsp(0)
    alone = c40.Processor(IMAGE, board="flat")
    words = {dsp.registers["IVTP"] + 2: ROUTINE, ROUTINE: alone.memory[ROUTINE], ROUTINE + 1: alone.memory[ROUTINE + 1]}
    registers = {"IIF": dsp.registers["IIF"] | TINT0, "IIE": dsp.registers["IIE"] | 1}
    if by_debugger:
        debugger = made.debug()
        for address, word in words.items():
            debugger.set_word(address, word, chip=0)
        for name, value in registers.items():
            debugger.set_register(name, value, chip=0)
        debugger.close()
        return
    for address, word in words.items():
        dsp.memory[address] = word
    for name, value in registers.items():
        dsp.registers[name] = value


def test_an_idle_dsp_takes_an_interrupt_that_python_enables_and_goes_on() -> None:
    outcomes = []
    for by_debugger in (False, True):
        made = with_an_idle_dsp()
        dsp, began, counted = made.dsp(0), made.time_s, made.dsp(0).registers["R11"]
        interrupt(made, by_debugger)
        for after in (1e-5, 1e-4):
            made.run_until(began + after)
            outcomes.append((by_debugger, dsp.cycles, dsp.instructions, dsp.pc, dsp.causes, dsp.registers["R11"]))
            assert dsp.registers["R11"] > counted
    by_python, by_the_debugger = outcomes[:2], outcomes[2:]
    assert [one[1:] for one in by_python] == [one[1:] for one in by_the_debugger]
