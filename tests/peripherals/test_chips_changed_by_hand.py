"""Registers and words that Python changes between two runs of a network: what had come to rest looks again, and what it
does then it does from that instant on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from cmrc import c40
from cmrc.network import Network, SharedMemory
from network_programs import PERIOD_PS

STACK, VECTORS, WORD = 0x2FF900, 0x80000200, 0x2FFA00
TINT0, GIE = 1 << 24, 0x2000
KEEPS_RUNNING = c40.assemble("        .text\n        rpts 65000\n        nop\nend:    b end\n")
COUNTS_INTERRUPTS = "isr:    addi 1,r6\n        reti\n"
TIMER = "        sti r2,*+ar0(28h)\n        sti r3,*+ar0(20h)\n"  # with R2 and R3: an event every 200 cycles
SLEEPS = c40.assemble(
    "        .text\n" + TIMER + "        idle\n        addi 1,r5\nwait:   idle\n        b wait\n" + COUNTS_INTERRUPTS
)
BRANCHES = c40.assemble("        .text\n        nop\ndone:   b done\n" + COUNTS_INTERRUPTS)
POLLS = c40.assemble("        .text\npoll:   ldi *ar3,r0\n        bz poll\n        addi 1,r5\ndone:   b done\n")


def prepared(chip: Any, image: Any) -> None:
    for name, value in {"AR0": 0x100000, "R2": 100, "R3": 0x2C0, "IVTP": VECTORS, "SP": STACK, "AR3": WORD}.items():
        chip.registers[name] = value
    if "isr" in image.symbols:
        chip.memory[VECTORS + 2] = image.symbols["isr"]


def network(image: Any, alone: bool = False) -> Network:
    made = Network([image] if alone else [image, KEEPS_RUNNING], boards="flat", record_peripherals=True)
    prepared(made.chips[0], image)
    return made


def low(chip: Any, name: str) -> int:
    return int(chip.registers[name] & 0xFFFFFFFF)


def interrupts_ps(made: Network) -> list[int]:
    return [event.time_ps for event in made.peripheral_events if event.kind == "interrupt"]


def by_python(made: Network, name: str, value: int) -> None:
    made.chips[0].registers[name] = value


def by_debugger(made: Network, name: str, value: int) -> None:
    debugger = made.debug()
    debugger.set_register(name, value, chip=0)
    debugger.close()


def same(made: Network) -> Network:
    return made


def restored(made: Network) -> Network:
    made.restore(made.snapshot())
    return made


@pytest.mark.parametrize("later", [same, Network.fork, restored])
@pytest.mark.parametrize("change", [by_python, by_debugger])
def test_an_interrupt_that_is_enabled_while_a_chip_rests_in_idle_is_taken(
    change: Callable[[Network, str, int], None], later: Callable[[Network], Network]
) -> None:
    """As a processor takes it that runs alone: the flag was pending, and the timer continues."""
    alone = c40.Processor(SLEEPS, board="flat")
    prepared(alone, SLEEPS)
    alone.run(500)
    alone.registers["IIE"] = 1
    alone.run(1000)
    made = network(SLEEPS)
    made.run(until_us=25)
    assert made.chips[0].status == "idle"
    change(made, "IIE", 1)
    made = later(made)
    made.run(until_us=75)
    chip = made.chips[0]
    assert (low(chip, "R5"), low(chip, "R6")) == (low(alone, "R5"), low(alone, "R6")) == (1, 6)
    assert min(interrupts_ps(made)) == 25_000_000
    assert chip.cycles == sum(chip.causes.values())


@pytest.mark.parametrize("change", [by_python, by_debugger])
@pytest.mark.parametrize("alone", [True, False])
def test_an_interrupt_that_is_enabled_takes_a_chip_out_of_a_branch_to_itself(
    change: Callable[[Network, str, int], None], alone: bool
) -> None:
    made = network(BRANCHES, alone)
    made.run(until_us=20)
    assert made.chips[0].status == "halt"
    began = made.now_ps
    for name, value in {"IIF": TINT0, "IIE": 1, "ST": GIE}.items():
        change(made, name, value)
    made.run(until_us=30)
    assert low(made.chips[0], "R6") == 1 and made.chips[0].status == "halt"
    assert len(interrupts_ps(made)) == 1 and interrupts_ps(made)[0] >= began


def test_a_register_of_a_peripheral_that_is_set_while_a_chip_rests_acts_from_that_instant_on() -> None:
    made = network(BRANCHES)
    made.run(until_us=20)
    chip = made.chips[0]
    chip.memory[0x100028], chip.memory[0x100020] = 100, 0x2C0
    chip.registers["IIE"], chip.registers["ST"] = 1, GIE
    made.run(until_us=50)
    first = 20_000_000 + 200 * PERIOD_PS
    assert interrupts_ps(made)[0] in range(first, first + 8 * PERIOD_PS) and low(chip, "R6") == 2


def test_a_dma_that_is_started_while_its_chip_rests_moves_its_words_from_that_instant_on() -> None:
    made = network(BRANCHES)
    made.run(until_us=20)
    chip = made.chips[0]
    chip.memory[WORD : WORD + 4] = [5, 6, 7, 8]
    for register, value in {1: WORD, 2: 1, 3: 4, 4: WORD + 4, 5: 1, 0: 0xC00004}.items():
        chip.memory[0x1000A0 + register] = value
    made.run(until_us=30)
    assert chip.memory[WORD + 4 : WORD + 8] == [5, 6, 7, 8]
    times = [event.time_ps for event in made.peripheral_events if event.kind.startswith("dma")]
    assert len(times) == 2 and min(times) >= 20_000_000 - PERIOD_PS


def test_a_polled_word_that_is_changed_ends_the_loop_and_its_status() -> None:
    made = network(POLLS)
    made.run(until_us=2000)
    chip = made.chips[0]
    assert chip.status == "looping"
    chip.memory[WORD] = 1
    assert chip.status == "running"
    made.run(until_us=2010)
    assert (low(chip, "R5"), chip.status, chip.cycles) == (1, "halt", 40006)


def test_a_word_of_a_shared_memory_that_is_changed_ends_the_loop_that_polls_it() -> None:
    memory = SharedMemory("m", 16, {0: 0xC0000000})
    made = Network([POLLS, KEEPS_RUNNING], memories=[memory])
    made.chips[0].registers["AR3"] = 0xC0000003
    made.run(until_us=2000)
    made.write_memory(0, 3, [1])
    assert made.chips[0].status != "looping"
    made.run(until_us=2010)
    assert low(made.chips[0], "R5") == 1 and made.chips[0].status == "halt"


@pytest.mark.parametrize("image", [SLEEPS, BRANCHES])
def test_what_wakes_nothing_changes_nothing_else(image: Any) -> None:
    changed, other = network(image), network(image)
    for made in (changed, other):
        made.run(until_us=25)
    changed.chips[0].registers["R7"] = 5
    changed.chips[1].memory[WORD] = 5
    for made in (changed, other):
        made.run(until_us=50)
    chip, like = changed.chips[0], other.chips[0]
    assert (chip.status, chip.cycles, chip.causes) == (like.status, like.cycles, like.causes)
    assert changed.event_trace == other.event_trace and low(chip, "R7") == 5
