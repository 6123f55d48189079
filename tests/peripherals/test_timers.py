"""Timers against counts by hand and a model that steps every cycle (c40-hardware.md 4, 11.5)."""

from __future__ import annotations

import itertools
import random
from typing import Any

import cmrc_test
import pytest
from cmrc._core import c40, toolchain
from cmrc.c40 import assemble
from cmrc.network import Network
from dma_chips import chip_with, low

CONTROL, COUNTER, PERIOD = 0x100020, 0x100024, 0x100028
TABLE = 0x2FFA00

SERVICE = """
        ldhi 2fh,ar1
        or 0fa00h,ar1
        ldpe ar1,ivtp
        ldhi 10h,ar0
        or OFFSET,ar0
        ldhi PERIOD_HIGH,r0
        or PERIOD_LOW,r0
        sti r0,*+ar0(8)
        ldi CONTROL,r0
        ldi MASK,r1
        lsh SHIFT,r1
        ldi r1,iie
        or 2000h,st
start:  sti r0,*ar0
wait:   idle
        bu wait
isr:    addi 1,r2
        reti
"""


def program(timer: int, control: int, period: int) -> tuple[Any, Any]:
    text = SERVICE.replace("OFFSET", f"{0x20 + 0x10 * timer:x}h").replace("PERIOD_HIGH", str(period >> 16))
    text = (
        text.replace("PERIOD_LOW", str(period & 0xFFFF))
        .replace("CONTROL", f"0{control:x}h")
        .replace("MASK", "1")
        .replace("SHIFT", str(31 * timer))
    )
    image = toolchain.assemble("        .text\n" + text, "timer.asm", sections={".text": 0x2FFC00})
    chip = c40.Processor("default")
    chip.load_image(image)
    chip.pc = 0x2FFC00
    chip.set("SP", 0x2FFB00)
    chip.poke(TABLE + (2 if timer == 0 else 0x2B), image.symbols["isr"])
    return chip, image


def interrupts(chip: Any, cycles: int) -> list[int]:
    return [record["cycle"] for record in chip.trace(cycles) if "interrupt" in record]


@pytest.mark.parametrize("timer", [0, 1])
@pytest.mark.parametrize(("control", "period", "cycles"), [(0x2C2, 8250, 16_500), (0x3C0, 100, 400), (0x2C0, 100, 200)])
def test_golden_vectors(timer: int, control: int, period: int, cycles: int) -> None:
    chip, image = program(timer, control, period)
    chip.run(100, until=image.symbols["start"])
    started = chip.cycle
    taken = interrupts(chip, 5 * cycles)
    assert [at - started for at in taken][:2] == [2 * period, 2 * period + cycles]
    assert {b - a for a, b in itertools.pairwise(taken)} == {cycles}
    assert sum(chip.causes.values()) == chip.cycle


def test_go_reads_back_as_zero_and_hold_freezes_the_counter() -> None:
    chip, image = program(0, 0x2C0, 1000)
    chip.run(100, until=image.symbols["start"])
    started = chip.cycle
    chip.run(200)
    assert chip.peripheral("timer0.control") == 0x280
    assert chip.peripheral("TIMER0.counter") == (chip.cycle - started) // 2
    chip.poke(CONTROL, 0x200)
    frozen = chip.peripheral("TIMER0.counter")
    chip.run(500)
    assert chip.peripheral("TIMER0.counter") == frozen
    chip.poke(CONTROL, 0x280)
    chip.run(100)
    assert chip.peripheral("TIMER0.counter") == frozen + 50


def test_a_counter_beyond_the_period_continues_through_the_top() -> None:
    chip, image = program(0, 0x2C0, 1000)
    chip.run(100, until=image.symbols["wait"])
    chip.run(100)
    chip.poke(PERIOD, 10)
    chip.poke(COUNTER, 0xFFFFFFF0)
    first = chip.cycle
    taken = interrupts(chip, 200)
    assert [at - first for at in taken] in (
        [52, 72, 92, 112, 132, 152, 172, 192],
        [51, 71, 91, 111, 131, 151, 171, 191],
    )


def free_timer(control: int, period: int, counter: int | None = None) -> Any:
    """A chip whose timer 0 starts in this cycle; its interrupts are not enabled."""
    chip, image = program(0, 0, 0)
    chip.run(100, until=image.symbols["start"])
    chip.set("IIE", 0)
    chip.set("ST", 0)
    chip.run(30)
    chip.set("IIF", 0)
    chip.poke(PERIOD, period)
    if counter is None:
        chip.poke(CONTROL, control)
    else:
        chip.poke(COUNTER, counter)
        chip.poke(CONTROL, control & ~0x40)  # without GO: it continues from there
    return chip


def flags(chip: Any, cycles: int) -> list[int]:
    """The cycles after which TINT0 was set, one by one."""
    seen = []
    for cycle in range(1, cycles + 1):
        chip.run(1)
        if chip.get("IIF") & 1 << 24:
            chip.set("IIF", 0)
            seen.append(cycle)
    return seen


PULSE, CLOCK, TSTAT = 0x2C0, 0x3C0, 1 << 11


def test_a_period_of_0_stays_high_in_pulse_mode_and_toggles_each_cycle_in_clock_mode() -> None:
    """With counter 0: one event, or an output of period 2/f(H1): a rising edge each 2 cycles (c40-hardware.md 4)."""
    pulse = free_timer(PULSE, 0)
    assert len(flags(pulse, 40)) == 1
    assert {pulse.peripheral("TIMER0.control") & TSTAT for _ in range(5) if pulse.run(1)} == {TSTAT}
    clock = free_timer(CLOCK, 0)
    taken = flags(clock, 40)
    assert {b - a for a, b in itertools.pairwise(taken)} == {2} and len(taken) == 20
    levels = [clock.peripheral("TIMER0.control") & TSTAT for _ in range(6) if clock.run(1)]
    assert levels in ([0, TSTAT] * 3, [TSTAT, 0] * 3)


@pytest.mark.parametrize(("control", "period", "every"), [(PULSE, 1, 2), (CLOCK, 1, 4), (PULSE, 2, 4), (CLOCK, 2, 8)])
def test_the_shortest_periods(control: int, period: int, every: int) -> None:
    assert flags(free_timer(control, period), 64) == list(range(2 * period, 65, every))


def test_the_longest_period_ends_where_the_counter_is_all_ones() -> None:
    chip = free_timer(PULSE, 0xFFFFFFFF, counter=0xFFFFFFFC)
    assert flags(chip, 5) == [] and chip.peripheral("TIMER0.counter") == 0xFFFFFFFE
    assert flags(chip, 1) == [1] and chip.peripheral("TIMER0.counter") == 0  # three ticks of two cycles
    assert flags(chip, 200) == [] and chip.peripheral("TIMER0.counter") == 100


@pytest.mark.parametrize(("counter", "first"), [(99, 2), (100, 2), (98, 4)])
def test_a_counter_at_its_period_overflows_with_the_next_tick(counter: int, first: int) -> None:
    assert flags(free_timer(PULSE, 100, counter), 210) == [first, first + 200]


def test_a_counter_one_beyond_its_period_continues() -> None:
    chip = free_timer(PULSE, 100, 101)
    assert flags(chip, 400) == [] and chip.peripheral("TIMER0.counter") == 301


@pytest.mark.parametrize("before", [5, 1000])
def test_a_wrap_to_a_period_of_0_interrupts_whatever_happened_before(before: int) -> None:
    """The counter counts on to FFFFFFFFh and wraps to 0: TSTAT goes from 0 to 1, once."""
    chip = free_timer(PULSE, before)
    flags(chip, 41)
    chip.poke(PERIOD, 0)
    chip.poke(COUNTER, 0xFFFFFFF0)
    assert chip.peripheral("TIMER0.control") & TSTAT == 0
    assert len(flags(chip, 33)) == 1 and chip.peripheral("TIMER0.counter") == 0
    assert chip.peripheral("TIMER0.control") & TSTAT and flags(chip, 40) == []


def test_period_and_counter_set_to_0_after_a_pulse_begin_a_new_one_with_the_next_tick() -> None:
    chip = free_timer(PULSE, 5)
    assert flags(chip, 13) == [10]
    chip.poke(PERIOD, 0)
    chip.poke(COUNTER, 0)
    assert chip.peripheral("TIMER0.control") & TSTAT == 0
    assert len(flags(chip, 20)) == 1 and chip.peripheral("TIMER0.control") & TSTAT
    chip.poke(PERIOD, 3)  # ends the pulse
    assert chip.peripheral("TIMER0.control") & TSTAT == 0
    assert len(flags(chip, 18)) == 3


@pytest.mark.parametrize("cycles", [20, 21, 30, 31])
@pytest.mark.parametrize("counter", [0xFFFFFFFD, 0xFFFFFFFE])
def test_after_a_wrap_in_clock_mode_a_period_of_0_toggles_in_each_cycle(counter: int, cycles: int) -> None:
    chip = free_timer(CLOCK, 5)
    chip.run(cycles)
    chip.poke(PERIOD, 0)
    chip.poke(COUNTER, counter)
    before = chip.peripheral("TIMER0.control") & TSTAT
    chip.set("IIF", 0)
    levels, told = [], []
    for _ in range(20):
        chip.run(1)
        levels.append(chip.peripheral("TIMER0.control") & TSTAT)
        told.append(chip.get("IIF") & 1 << 24 != 0)
        chip.set("IIF", 0)
    first = next(n for n, level in enumerate(levels) if level != before)
    assert 2 * (2**32 - counter) - 2 <= first < 2 * (2**32 - counter) + 1
    assert all(a != b for a, b in itertools.pairwise(levels[first - 1 :]))
    assert told == [
        level != 0 and (n == 0 and not before or n > 0 and not levels[n - 1]) for n, level in enumerate(levels)
    ]


@pytest.mark.parametrize("register", [CONTROL, PERIOD])
@pytest.mark.parametrize("every", [1, 2, 3])
def test_a_write_of_the_control_register_or_period_loses_no_tick(register: int, every: int) -> None:
    """A write overrides the timer's own update of the register that is written."""
    chip = free_timer(PULSE, 30)
    value = {CONTROL: 0x280, PERIOD: 30}[register]
    for cycle in range(1, 59):
        chip.run(1)
        if cycle % every == 0:
            chip.poke(register, value)
        assert chip.peripheral("TIMER0.counter") == cycle // 2
    assert flags(chip, 10) == [2]


def test_a_write_of_the_counter_overrides_the_tick_of_its_cycle() -> None:
    chip = free_timer(PULSE, 1000)
    for _ in range(20):
        chip.run(1)
        chip.poke(COUNTER, 7)
        assert chip.peripheral("TIMER0.counter") == 7
    chip.run(20)
    assert chip.peripheral("TIMER0.counter") in (16, 17)


def after_a_write(
    control: int, period: int, delay: int, register: int, value: int, cycles: int
) -> tuple[int, bool, bool]:
    """Counter, TSTAT and TINT of a timer that was started in cycle 0, and written in cycle `delay`: cycle by cycle, the
    tick first."""
    counter, status, rose, runs, clock = 0, False, False, True, bool(control & 0x100)
    for cycle in range(1, cycles + 1):
        status = status and clock
        if runs and cycle % 2 == 0:
            event = counter in (period - 1, period)
            counter = 0 if event else counter + 1
            if event:
                status = not (status and clock)
                rose = rose or status
        if cycle == delay:
            counter = value if register == COUNTER else counter
            period = value if register == PERIOD else period
            runs = runs and register != CONTROL
    return counter, status, rose


def written_timer(control: int, period: int, delay: int, register: int, value: int) -> str:
    """A program that starts timer 0, and reads it three cycles after another write. AR0 is at its control register, R6
    at 7."""
    fill = "        nop\n" * (delay - 1)
    return f"""
        ldhi 10h,ar0
        or 20h,ar0
        ldi {period},r0
        sti r0,*+ar0(8)
        ldi {control:#x},r1
        ldi {value:#x},r2
        ldi 1,r3
        sti r3,*+ar0(18h)
        ldi 2c0h,r3
START   sti r1,*ar0
{fill}        sti r2,*+ar0({register - CONTROL})
        nop
        nop
        ldi *+ar0(4),r4
        ldi *ar0,r5
stop:   bu stop
"""


HELD = {PULSE: 0x200, CLOCK: 0x300}
WRITES = [("held", CONTROL, 0), ("period", PERIOD, 9), ("shorter", PERIOD, 1), ("counter", COUNTER, 1)]


@pytest.mark.parametrize("way", ["whole", "stepped", "looked at", "exact"])
@pytest.mark.parametrize("other", ["alone", "timer 1", "timer 1, a cycle later"])
@pytest.mark.parametrize(("register", "value"), [w[1:] for w in WRITES], ids=[w[0] for w in WRITES])
@pytest.mark.parametrize("control", [PULSE, CLOCK])
def test_a_write_in_the_cycle_of_a_tick_comes_after_it_whatever_the_other_timer_does(
    control: int, register: int, value: int, other: str, way: str
) -> None:
    """A tick and its event are not lost; only a counter that is written has the written value afterwards."""
    starts = {
        "alone": "        nop\n        nop\n",
        "timer 1": "        sti r3,*+ar0(10h)\n        nop\n",
        "timer 1, a cycle later": "        nop\n        sti r3,*+ar0(10h)\n",
    }[other]
    for period, delay in itertools.product((1, 2, 3, 9), range(1, 20)):
        written = HELD[control] if register == CONTROL else value
        text = written_timer(control, period, delay, register, written).replace("START", starts)
        chip, image = chip_with(text)
        chip.set_exact(way == "exact")
        while chip.pc != image.symbols["stop"]:
            if way in ("whole", "exact"):
                chip.run(1000, until=image.symbols["stop"])
            else:
                chip.step()
                assert way == "stepped" or chip.peripheral("TIMER0.control") is not None
        at = f"period {period}, written {delay} cycles after the start"
        counter, _status, rose = after_a_write(control, period, delay, register, value, delay + 3)
        assert low(chip, "R4") == counter, at
        *_, status, _rose = after_a_write(control, period, delay, register, value, delay + 4)
        assert (low(chip, "R5") & TSTAT != 0) == status, at
        *_, rose = after_a_write(control, period, delay, register, value, delay + 5)
        assert (chip.get("IIF") & 1 << 24 != 0) == rose, at


@pytest.mark.parametrize(("register", "value"), [(CONTROL, 0x301), (PERIOD, 9), (COUNTER, 1)])
def test_a_net_at_the_pin_changes_nothing_for_the_timer(register: int, value: int) -> None:
    for period, delay in itertools.product((1, 2), range(1, 12)):
        text = "        .text\nmain:\n" + written_timer(0x3C1, period, delay, register, value).replace("START", "")
        seen = []
        for nets in ((), ("0.TCLK0>1.IIOF1",)):
            network = Network([assemble(text), assemble("        .text\nstop: bu stop\n")], boards="flat", nets=nets)
            network.run(until_us=20)
            registers = network.chips[0].registers
            seen.append((registers["R4"], registers["R5"]))
        assert seen[0] == seen[1], f"period {period}, written {delay} cycles after the start"


def test_the_pins_time_is_not_counted_when_the_internal_clock_returns() -> None:
    chip = free_timer(PULSE, 1000)
    chip.run(10)
    chip.poke(CONTROL, 0x80)  # the pin, which nobody drives
    chip.run(100)
    before = chip.peripheral("TIMER0.counter")
    chip.poke(CONTROL, 0x280)
    assert chip.peripheral("TIMER0.counter") == before
    chip.run(20)
    assert chip.peripheral("TIMER0.counter") == before + 10


def test_the_flag_stays_while_the_interrupt_is_off() -> None:
    chip, image = program(0, 0x2C0, 100)
    chip.run(100, until=image.symbols["start"])
    chip.set("IIE", 0)
    started = chip.cycle
    chip.run(199)
    assert chip.get("IIF") & 1 << 24 == 0
    chip.run(2)
    assert chip.cycle - started == 201 and chip.get("IIF") & 1 << 24
    chip.set("IIE", 1)
    assert not chip.idle


def test_an_external_clock_counts_rising_edges_and_inverted_ones() -> None:
    for inverted in (0, 0x400):
        chip, _image = program(1, 0xC1 | inverted, 3)  # FUNC, GO, HLD; clock from the pin; pulse mode
        chip.run(100)
        counts = []
        for _ in range(4):
            chip.set_timer_pin(1, True)
            counts.append(chip.peripheral("TIMER1.counter"))
            chip.set_timer_pin(1, False)
            chip.run(20)
        assert counts == ([1, 2, 0, 1] if not inverted else [0, 1, 2, 0])
        assert chip.get("R2") & 0xFFFFFFFF == 1


def test_the_pin_shows_the_status_and_its_inverse() -> None:
    chip, image = program(0, 0x3C1, 10)  # FUNC, clock mode
    chip.run(100, until=image.symbols["start"])
    started = chip.cycle
    levels = []
    while chip.cycle < started + 80:
        chip.run(1)
        levels.append((chip.cycle - started, chip.timer_pin(0)))
    assert all(level == (cycle // 20 % 2 == 1) for cycle, level in levels)


def test_general_purpose_pin() -> None:
    chip, _ = program(0, 0, 0)
    chip.poke(CONTROL, 0b110)
    assert chip.timer_pin(0) and chip.peripheral("TIMER0.control") == 0b1110
    chip.poke(CONTROL, 0b010)
    assert not chip.timer_pin(0)
    chip.poke(CONTROL, 0)
    chip.set_timer_pin(0, True)
    assert chip.peripheral("TIMER0.control") == 0b1000


class Stepped:
    """A timer, tick by tick."""

    def __init__(self) -> None:
        self.clock = self.running = self.status = False
        self.counter = self.period = 0
        self.phase = 0
        self.rose: list[int] = []

    def cycle(self, at: int) -> None:
        """The cycle `at` begins."""
        if not self.running:
            return
        self.phase += 1
        if self.phase < 2:
            return
        self.phase = 0
        self.counter = (self.counter + 1) & 0xFFFFFFFF
        if self.counter != self.period:
            return
        self.counter = 0
        if self.clock:
            self.status = not self.status
        if self.status or not self.clock:
            self.rose.append(at)


def test_random_periods_against_the_stepped_model() -> None:
    for seed in range(20):
        rng = random.Random(seed)
        chip, image = program(0, 0, 0)
        chip.run(100, until=image.symbols["start"])
        chip.set("IIE", 0)
        chip.set("ST", 0)
        chip.run(30)
        model = Stepped()
        seen: list[int] = []
        for _ in range(12):
            period, clock = rng.randint(1, 40), rng.random() < 0.5
            chip.poke(PERIOD, period)
            chip.poke(CONTROL, 0x3C0 if clock else 0x2C0)
            model.period, model.clock, model.counter, model.phase, model.status, model.running = (
                period,
                clock,
                0,
                0,
                False,
                True,
            )
            for _ in range(rng.randint(1, 200)):
                chip.run(1)
                model.cycle(chip.cycle)
                assert chip.peripheral("TIMER0.counter") == model.counter
                if chip.get("IIF") & 1 << 24:
                    chip.set("IIF", 0)
                    seen.append(chip.cycle)
                assert (seen[-1:] == [chip.cycle]) == (model.rose[-1:] == [chip.cycle])
        assert seen


def test_register_names() -> None:
    chip, _ = program(0, 0, 0)
    registers = cmrc_test.peripheral_registers()
    assert len(registers) == 2 + 2 * 3 + 6 * 3 + 6 * 9
    assert {entry["name"]: entry["address"] for entry in registers}["DMA3.link"] == 0x1000D6
    assert chip.peripheral("gmicr") == 0x1DEA4000
    for wrong, right in [
        ("PROT3.control", r'did you mean "PORT3\.control"\?'),
        ("dma3.ilnk", r'did you mean "DMA3\.link"\?'),
        ("zzzzzzzzzzzzzz", r"zzzzzzzzzzzzzz; docs/peripherals\.md lists the registers$"),
    ]:
        with pytest.raises(IndexError, match=right):
            chip.peripheral(wrong)
