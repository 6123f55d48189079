"""A held chip is frozen: processor, DMA and timers. It continues where it was, and the past stays as it was."""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable
from typing import Any

import pytest
import test_dma_at_windows
import test_random_nets
import test_random_networks
from cmrc import c40
from cmrc.network import Network, SharedMemory
from net_programs import assembled
from network_programs import PERIOD_PS, check_balance

HELD_US, RELEASED_US = 5, 20
HOLD_PS = (RELEASED_US - HELD_US) * 1_000_000
MEMORY = 0xC0000000
WORKS = "        rpts 2000\n        nop\ndone:   b done\n"


def copies(destination: int, index: int) -> Any:
    """100 words by DMA channel 0 from 2FF800h on, while the processor counts."""
    control, values = 0xC40004, (0x2FF800, 1, 100, destination, index)
    text = "        ldhi 10h,ar0\n        or 0a0h,ar0\n"
    for at, value in (*enumerate(values, 1), (0, control)):
        text += f"        ldhi 0{value >> 16:x}h,r0\n        or 0{value & 0xFFFF:x}h,r0\n        sti r0,*+ar0({at})\n"
    return c40.assemble("        .text\n" + text + WORKS)


READS = c40.assemble(
    "        .text\n        ldhi 10h,ar0\n        or 71h,ar0\n" + "        ldi *ar0,r1\n" * 100 + WORKS
)
COUNTS = "        ldi 10,r0\n        sti r0,*+ar0(28h)\n        ldi 3c1h,r0\n        sti r0,*+ar0(20h)\n"


def linked() -> Network:
    return Network([copies(0x100042, 0), READS], links=["0.0:1.3"], record_words=True, record_peripherals=True)


def shared() -> Network:
    memory = SharedMemory("m", 512, {0: MEMORY, 1: MEMORY})
    return Network([copies(MEMORY, 1), c40.assemble(WORKS)], memories=[memory], record_peripherals=True)


def timed() -> Network:
    return Network([assembled(COUNTS + WORKS)], record_peripherals=True)


def lines(network: Network, chip: int = 0) -> list[tuple[int, str]]:
    """The events of a chip, by time."""
    found = (line.split(" ", 1) for line in network.event_trace if f"chip {chip}: " in line)
    return [(int(time), what) for time, what in found]


@pytest.mark.parametrize("made", [shared, timed])
def test_all_that_is_to_come_comes_later_by_the_time_in_which_the_chip_was_held(made: Callable[[], Network]) -> None:
    plain, held = made(), made()
    held.hold(0, HELD_US)
    held.release(0, RELEASED_US)
    plain.run()
    held.run()
    expected = [(time + HOLD_PS * (time >= HELD_US * 1_000_000), what) for time, what in lines(plain)]
    assert lines(held) == expected and len(expected) > 1
    assert expected[0][0] < HELD_US * 1_000_000 < expected[-1][0] - HOLD_PS
    assert held.chips[0].cycles == plain.chips[0].cycles + HOLD_PS // PERIOD_PS


@pytest.mark.parametrize("made", [linked, shared, timed])
@pytest.mark.parametrize("cuts", [(), (19,), (5, 12.34, 20), (4.99, 5.05, 19.95, 20.05)])
def test_a_release_changes_nothing_of_what_was_before_it(made: Callable[[], Network], cuts: tuple[float, ...]) -> None:
    never, whole = made(), made()
    for network in (never, whole):
        network.hold(0, HELD_US)
    whole.release(0, RELEASED_US)
    for at in cuts:
        whole.run(until_us=at)
    whole.run()
    never.run(until_us=RELEASED_US)

    def before(network: Network) -> list[str]:
        return [line for line in network.event_trace if int(line.split()[0]) < RELEASED_US * 1_000_000]

    assert before(whole) == before(never)


def test_after_the_release_words_cross_the_link_no_faster_than_it_carries_them() -> None:
    network = linked()
    network.hold(0, HELD_US)
    network.release(0, RELEASED_US)
    network.run()
    assert network.chips[1].port(3)["read"] == 100
    words = [int(line.split()[0]) for line in network.event_trace if " word 0.0" in line]
    assert len(words) == 100
    assert min(after - before for before, after in itertools.pairwise(words)) == 5 * PERIOD_PS
    written = [time for time, what in lines(network) if "port_write 0" in what]
    assert not [time for time in written if HELD_US * 1_000_000 < time < RELEASED_US * 1_000_000]
    in_fifo = sorted([(time, 1) for time in written] + [(time, -1) for time in words])
    level = most = 0
    for _, change in in_fifo:
        level += change
        most = max(most, level)
    assert most <= 8
    check_balance(network)


def test_a_held_chips_timer_counts_no_edges_of_its_pin() -> None:
    """Ten pulses; the chip is held during five of them. Before, timer 1 was set up to count edges at its pin."""
    sets = "        ldi 100,r0\n        sti r0,*+ar0(38h)\n        ldi 0c1h,r0\n        sti r0,*+ar0(30h)\n"
    network = Network([assembled(sets + "wait:   addi 1,r4\n        b wait\n")], nets=["p: >0.TCLK1"])
    network.pulse(0, 10, width_us=1, period_us=10, count=10)
    network.hold(0, 35)
    network.release(0, 85)
    network.run(until_us=60)
    assert network.chips[0].peripherals["TIMER1.counter"] == 3
    network.run(until_us=150)
    assert network.chips[0].peripherals["TIMER1.counter"] == 5


@pytest.mark.parametrize("order", range(6))
@pytest.mark.parametrize("cuts", [(), (9.3, 11.06, 14)])
def test_a_released_chip_waits_on_as_it_had_waited(order: int, cuts: tuple[float, ...]) -> None:
    """The processor and DMA channel 2 wait for one FIFO, beside a timer: nothing happens after the network's end."""
    base = "        ldhi 10h,ar0\n"
    dma = "".join(
        f"        ldhi 0{value >> 16:x}h,r0\n        or 0{value & 0xFFFF:x}h,r0\n        sti r0,*+ar0(0{0xC0 + at:x}h)\n"
        for at, value in ((1, 0x100071), (3, 4), (4, 0x2FFC00), (0, 0xC00004))
    )
    timer = "        ldi 7,r0\n        sti r0,*+ar0(28h)\n        ldi 2c0h,r0\n        sti r0,*+ar0(20h)\n"
    waits = c40.assemble("        .text\n" + base + timer + dma + "        ldi *+ar0(71h),r3\ndone:   b done\n")
    short = c40.assemble("        .text\n        rpts 100\n        nop\ndone:   b done\n")
    network = Network(
        [waits, short], links=["0.3:1.0"], boards="flat", turn_order=order, record_words=True, record_peripherals=True
    )
    network.hold(0, 11.05)
    network.release(0, 11.07)
    for at in cuts:
        network.run(until_us=at)
    stop = network.run()
    assert (stop.reason, stop.time_ps) == ("deadlock", 11_100_000)
    assert network.event_trace[-1] == "11100000 release 0"
    ticks = [time for time, what in lines(network) if "timer 0" in what]
    assert {after - before for before, after in itertools.pairwise(ticks)} == {14 * PERIOD_PS} and len(ticks) > 10
    counted = (11_050_000 - ticks[-1]) // (2 * PERIOD_PS)
    assert network.chips[0].peripherals["TIMER0.counter"] == counted < 7


TAKES = "        ldhi 0C000h,ar0\n        ldii *ar0,r0\n" + WORKS
WAITS = "        ldhi 0C000h,ar0\n        rpts 100\n        nop\n        ldii *ar0,r5\n        stii r5,*ar0\n        ldi 7,r6\ndone:   b done\n"


@pytest.mark.parametrize(
    ("action", "goes_on"), [("reset", True), ("pull_out", True), ("low", True), ("hold", False), ("nothing", False)]
)
def test_a_chip_that_enters_reset_frees_its_locks(action: str, goes_on: bool) -> None:
    """c40-hardware.md 8.3. A chip that is only held keeps them: it continues later, where it was."""
    memory = SharedMemory("m", 16, {0: MEMORY, 1: MEMORY})
    once = "        ldhi 0C000h,ar0\n        ldi *+ar0(1),r1\n        addi 1,r1\n        sti r1,*+ar0(1)\n        cmpi 1,r1\n        bnz done\n"
    images = [c40.assemble("        .text\n" + text) for text in (once + TAKES, WAITS)]
    network = Network(images, memories=[memory], nets=["rst: >0.RESET"])
    if action == "low":
        network.drive(0, False, 50)
    elif action != "nothing":
        getattr(network, action)(0, 50)
    stop = network.run()
    assert network.chips[1].registers["R6"] & 0xFF == (7 if goes_on else 0)
    assert network.chips[1].causes["bus_arbitration"] in range(880, 1000) or not goes_on
    assert goes_on or stop.reason == "deadlock"


@pytest.mark.parametrize("low_us", [1, 3])
def test_nmi_that_is_low_when_reset_ends_is_taken_at_once(low_us: int) -> None:
    """c40-hardware.md 1.2, whether the pin went low before the chip was held or after. No stack is there yet."""
    vector = "        ldhi hi16(isr),r0\n        or lo16(isr),r0\n        sti r0,*+ar1(1)\n"
    network = Network([assembled(vector + WORKS + "isr:    reti\n")], nets=["n: >0.NMI"])
    network.hold(0, 2)
    network.drive(0, False, low_us)
    network.reset(0, 5)
    network.run()
    assert network.chips[0].status == "fault" and network.chips[0].cycles == 5_000_000 // PERIOD_PS
    assert "interrupt 01h: the stack at 00000001h is not in RAM" in network.chips[0].message


@pytest.mark.parametrize("action", ["release", "reset"])
def test_a_chip_with_a_low_reset_stays_held_whatever_the_script_does(action: str) -> None:
    network = Network([assembled(WORKS)], nets=["rst: >0.RESET"])
    network.drive(0, False, 1)
    getattr(network, action)(0, 3)
    network.run(until_us=4)
    assert network.chips[0].status == "held"
    network.drive(0, True, 5)
    network.run()
    assert network.chips[0].status == "halt" and network.chips[0].registers["RC"] & 0xFFFFFFFF == 0xFFFFFFFF


def act(made: Network, rng: random.Random, pulls_out: bool) -> None:
    """Some chips are held, released, reset, or at last pulled out."""
    for chip in range(len(made.chips)):
        times = sorted(rng.uniform(0.5, 25) for _ in range(rng.randrange(5)))
        for n, at in enumerate(times):
            last = pulls_out and n == len(times) - 1 and rng.random() < 0.3
            kind = "pull_out" if last else rng.choice(["hold", "hold", "release", "release", "reset"])
            getattr(made, kind)(chip, at)


MAKERS = [test_dma_at_windows.random_network, test_random_networks.network, test_random_nets.random_network]
END_US = 60


def check(seed: int) -> None:
    """Nothing that is known at a cut changes later; cuts and the order of turns change nothing."""

    def make(order: int) -> Network:
        made = MAKERS[seed % len(MAKERS)](seed, order)
        act(made, random.Random(seed), pulls_out=seed % len(MAKERS) == 0)  # the others have actions of their own
        return made

    def before(network: Network, until_ps: int) -> list[str]:
        return [line for line in network.event_trace if int(line.split()[0]) < until_ps]

    def still(events: list[str], held: list[int]) -> list[str]:
        """Of links, nets and held chips. Of another chip, the last cycles before a cut may be seen later."""
        chips = tuple(f"chip {n}:" for n in held)
        return [
            line for line in events if not (what := line.split(" ", 1)[1]).startswith("chip ") or what.startswith(chips)
        ]

    def outcome(network: Network) -> tuple[Any, ...]:
        chips = [
            (c.status, c.pc, c.cycles, c.instructions, dict(c.causes), dict(c.registers), dict(c.peripherals))
            for c in network.chips
        ]
        return network.now_ps, chips, network.nets, network.event_trace

    whole = make(0)
    whole.run(until_us=END_US)
    check_balance(whole)
    for order in (1, 2):
        rng = random.Random(seed + order)
        cut = make(order)
        kept = []
        for at in sorted(rng.uniform(0, 30) for _ in range(5)):
            stop = cut.run(until_us=at)
            held = [n for n, c in enumerate(cut.chips) if c.status in ("held", "pulled_out")]
            kept.append((stop.time_ps, held, before(cut, stop.time_ps)))
        cut.run(until_us=END_US)
        assert outcome(cut) == outcome(whole)
        for until, held, events in kept:
            assert not set(events) - set(before(cut, until)), until / 1e6
            assert still(events, held) == still(before(cut, until), held), until / 1e6


@pytest.mark.parametrize("seed", range(60))
def test_the_order_of_turns_and_cuts_change_nothing_and_the_past_stays(seed: int) -> None:
    check(seed)


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(60, 2000))
def test_the_past_stays_by_the_thousand(seed: int) -> None:
    check(seed)
