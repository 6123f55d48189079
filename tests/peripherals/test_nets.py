"""Nets between pins of chips. Expected values are counted by hand from docs/networks.md, Pins: an edge needs no time, a
receiver samples its pins at the start of each of its cycles, and the sample takes effect one cycle later."""

from __future__ import annotations

import random
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest
from cmrc.network import ChipSnapshot, Network
from net_programs import COUNT, EDGE, END, LEVEL, assembled, clock, iiof, listener

CYCLE = 50_000  # ps, of H1 at 40 MHz


def edges(network: Network) -> list[tuple[int, str]]:
    return [(event.time_ps, event.kind) for event in network.events if event.kind in ("rise", "fall")]


def interrupts(network: Network, chip: int) -> list[int]:
    return [event.time_ps for event in network.peripheral_events if event.kind == "interrupt" and event.chip == chip]


def low(network: Network, chip: int, register: str = "R2") -> int:
    """The integer in an extended-precision register."""
    return int(network.chips[chip].registers[register]) & 0xFFFFFFFF


def run(
    programs: list[Any],
    nets: list[str],
    until_us: float | None = None,
    script: Callable[[Network], None] = lambda network: None,
    **how: Any,
) -> Network:
    """The run. It must be the same in every order of turns, and wherever it is cut, also by a snapshot."""
    outcomes = []
    for order in (0, 5, 6):
        network = Network(programs, nets=nets, record_words=True, record_peripherals=True, turn_order=order, **how)
        script(network)
        if order == 6 and until_us is not None:
            for cut in sorted(random.Random(order).uniform(0, until_us) for _ in range(4)):
                network.run(until_us=cut)
            other = Network(programs, nets=nets, record_words=True, record_peripherals=True, turn_order=1, **how)
            other.restore(ChipSnapshot.from_bytes(network.snapshot().to_bytes()))
            network = other
        stop = network.run(until_us=until_us) if until_us is not None else network.run()
        outcomes.append(
            (
                stop,
                network.event_trace,
                network.nets,
                [(chip.status, chip.message, chip.cycles, chip.registers["R2"]) for chip in network.chips],
            )
        )
        assert outcomes[-1] == outcomes[0], order
    return network


# ---- timing ----


def test_an_edge_interrupts_a_sleeping_chip_one_cycle_later() -> None:
    network = run([assembled(clock(100) + END), listener(4, iiof(1))], ["0.TCLK0>1.IIOF1"], 100)
    falls = [at for at, kind in edges(network) if kind == "fall"]
    assert all(later - earlier == 400 * CYCLE for earlier, later in pairwise(falls)) and len(falls) == 5
    assert [at for at, kind in edges(network) if kind == "rise"] == [at + 200 * CYCLE for at in falls]
    assert interrupts(network, 1)[1:] == [
        at + CYCLE for at in falls[1:]
    ]  # at the first edge the chip does not sleep yet
    assert low(network, 1) == 5


def test_a_pin_without_a_net_may_be_driven_beside_one_with_a_net() -> None:
    other = clock(30, timer=1) + "        ldi 60h,iif\n"  # TCLK1, and IIOF1 as an output
    network = run([assembled(other + clock(100) + END), listener(4, iiof(1))], ["0.TCLK0>1.IIOF1"], 100)
    assert len([at for at, kind in edges(network) if kind == "fall"]) == 5 == low(network, 1)


@pytest.mark.parametrize("mhz", [33.0, 50.0, 60.0])
def test_a_receiver_looks_at_its_own_cycles(mhz: float) -> None:
    network = run([assembled(clock(100) + END), listener(4, iiof(1))], ["0.TCLK0>1.IIOF1"], 100, clocks_mhz=[40, mhz])
    falls = [at for at, kind in edges(network) if kind == "fall"]

    def looked(at: int) -> int:
        number = -(-at * int(mhz * 500_000) // 10**12)
        return (number + 1) * 10**12 // int(mhz * 500_000)

    assert interrupts(network, 1)[1:] == [looked(at) for at in falls[1:]]


def test_pulse_mode_gives_pulses_of_one_cycle() -> None:
    text = clock(50).replace("3c1h", "2c1h")
    network = run([assembled(text + END), listener(4, iiof(1))], ["0.TCLK0>1.IIOF1"], 50)
    rises = [at for at, kind in edges(network) if kind == "rise"]
    falls = [at for at, kind in edges(network) if kind == "fall"]
    assert len(rises) == 9 and falls[1:] == [
        at + CYCLE for at in rises
    ]  # the first falling edge is the one at which the timer takes the pin
    assert interrupts(network, 1)[1:] == [at + CYCLE for at in falls[1:]]


def test_a_short_pulse_is_missed_by_a_slow_receiver_and_counted() -> None:
    text = clock(50).replace("3c1h", "2c1h")
    network = run([assembled(text + END), listener(4, iiof(1))], ["0.TCLK0>1.IIOF1"], 50, clocks_mhz=[50, 34.7])
    (net,) = network.nets
    seen = sum(
        at > edges(network)[0][0] + CYCLE * 10 for at in interrupts(network, 1)
    )  # none at the edge at which the timer takes the pin
    assert net.missed == sum(event.kind == "missed" for event in network.events)
    assert seen > 0 < net.missed and seen + net.missed == sum(kind == "rise" for _, kind in edges(network))


# ---- effects ----


def test_a_level_interrupts_as_long_as_it_lasts() -> None:
    network = run(
        [listener(4, iiof(1, LEVEL))], ["wire: >0.IIOF1"], 60, lambda network: network.pulse("wire", 20, width_us=5)
    )
    fall, rise = edges(network)
    assert (fall, rise) == ((20_000_000, "fall"), (25_000_000, "rise"))
    taken = interrupts(network, 0)
    assert len(taken) > 3 and taken[0] == 20_000_000 + CYCLE and taken[-1] <= 25_000_000 + CYCLE + 4 * CYCLE


@pytest.mark.parametrize(("nibble", "flags", "taken"), [(LEVEL, [1, 0], 0), (EDGE, [1, 1], 1)])
def test_an_edge_lasts_and_a_level_does_not(nibble: int, flags: list[int], taken: int) -> None:
    """IIOF1 is low from 4 to 6 us. The program reads IIF at 5 us, and again before it sets GIE."""
    text = f"{iiof(1, nibble)}        ldi 0,r2\n        ldhi hi16(isr),r0\n        or lo16(isr),r0\n        sti r0,*+ar1(4)\n"
    waits = "        rpts 99\n        nop\n"
    text += waits + "        ldi iif,r3\n" + waits + "        ldi iif,r4\n        or 2000h,st\n" + waits + END + COUNT
    network = run([assembled(text)], ["wire: >0.IIOF1"], 60, lambda network: network.pulse("wire", 4, width_us=2))
    assert [low(network, 0, register) >> 6 & 1 for register in ("R3", "R4")] == flags
    assert low(network, 0) == taken


def test_nmi_needs_no_enabling() -> None:
    text = (
        "        ldi 0,r2\n        ldhi hi16(isr),r0\n        or lo16(isr),r0\n        sti r0,*+ar1(1)\nwait:   b wait\n"
        + COUNT
    )
    network = run(
        [assembled(text)],
        ["wire: >0.NMI"],
        60,
        lambda network: network.pulse("wire", 20, width_us=1, period_us=10, count=3),
    )
    assert low(network, 0) == 3
    assert [at // 10_000_000 for at in interrupts(network, 0)] == [2, 3, 4]


COUNTS_NMI = (
    "        ldi 0,r2\n        ldhi hi16(isr),r0\n        or lo16(isr),r0\n        sti r0,*+ar1(1)\nwait:   b wait\n"
    + COUNT
)


def test_who_drives_a_net_ends_the_pulses_on_it() -> None:
    def act(network: Any) -> None:
        network.pulse("wire", 20, width_us=1, period_us=10, count=5)
        network.drive("wire", True, 45)

    network = run([assembled(COUNTS_NMI)], ["wire: >0.NMI"], 80, act)
    assert [at // 10_000_000 for at in interrupts(network, 0)] == [2, 3, 4]


def test_a_second_row_of_pulses_begins_with_its_first() -> None:
    def act(network: Any) -> None:
        network.pulse("wire", 20, width_us=1, period_us=10, count=2)
        network.pulse("wire", 45, width_us=1, period_us=10, count=2)

    network = run([assembled(COUNTS_NMI)], ["wire: >0.NMI"], 90, act)
    assert [at // 5_000_000 for at in interrupts(network, 0)] == [4, 6, 9, 11]


def test_a_general_purpose_input_reads_the_level() -> None:
    """FLAG of IIOF2 is bit 10 of IIF."""
    text = "wait:   ldi iif,r1\n        and 400h,r1\n        bnz wait\n        addi 1,r2\nback:   ldi iif,r1\n        and 400h,r1\n        bz back\n        b wait\n"
    network = run(
        [assembled("        ldi 0,iif\n        ldi 0,r2\n" + text)],
        ["wire: >0.IIOF2"],
        60,
        lambda network: network.pulse("wire", 20, width_us=5, period_us=10, count=3),
    )
    assert low(network, 0) == 3


def test_a_timer_counts_encoder_pulses_and_the_index_pulse_reads_it() -> None:
    """Timer 0 counts rising edges of its pin; the service routine of IIOF1 stores the count."""
    text = "        ldhi 0ffffh,r0\n        sti r0,*+ar0(28h)\n        ldi 0c1h,r0\n        sti r0,*+ar0(20h)\n" + iiof(
        1
    )
    program = listener(4, text, "isr:    addi 1,r2\n        ldi *+ar0(24h),r3\n        reti\n")

    def script(network: Network) -> None:
        network.pulse("encoder", 10, width_us=0.5, period_us=1, count=300)
        network.pulse("index", 110.6, width_us=0.5, period_us=100)

    network = run([program], ["encoder: >0.TCLK0", "index: >0.IIOF1"], 330, script)
    assert low(network, 0) == 3 and network.chips[0].peripherals["TIMER0.counter"] == 300
    assert low(network, 0, "R3") == 300  # from 310.6 us on; the last edge was at 309.5 + 0.5
    network = run([program], ["encoder: >0.TCLK0", "index: >0.IIOF1"], 250, script)
    assert low(network, 0, "R3") == 201  # edges at 10.5, 11.5, ... 210.5 us


def test_an_edge_lets_the_dma_move_a_word() -> None:
    """DMA channel 2, synchronised by IIOF2 (DIE code 4): one word per pulse."""
    start = (
        "        ldhi 10h,ar2\n        or 0c0h,ar2\n        ldhi 2fh,r0\n        or 0f800h,r0\n        sti r0,*+ar2(1)\n        ldi 1,r1\n"
        "        sti r1,*+ar2(2)\n        ldi 10,r1\n        sti r1,*+ar2(3)\n        addi 64,r0\n        sti r0,*+ar2(4)\n        ldi 1,r1\n        sti r1,*+ar2(5)\n"
        "        ldi 100h,iif\n        ldi 400h,die\n        ldhi 0c0h,r1\n        or 47h,r1\n        sti r1,*ar2\n        ldi 0,r2\n"
    )
    network = run(
        [assembled(start + "wait:   idle\n        b wait\n")],
        ["wire: >0.IIOF2"],
        200,
        lambda network: network.pulse("wire", 20, width_us=5, period_us=10, count=4),
    )
    assert network.chips[0].peripherals["DMA2.counter"] == 10 - 4


def test_one_chip_holds_another_in_reset_and_lets_it_start() -> None:
    """A net that is low at rest: chip 1 is held until chip 0 makes an output of IIOF1 and drives it high (IIF 60h; 20h
    drives low)."""
    master = assembled(
        "        ldi 99,rc\n        rpts rc\n        nop\n        ldi 60h,iif\n        ldi 99,rc\n        rpts rc\n        nop\n        ldi 20h,iif\n"
        + END
    )
    slave = assembled("        ldi 7,r2\n" + END)
    network = run([master, slave], ["reset: 0.IIOF1>1.RESET"], 30)
    kinds = [(event.kind, event.place) for event in network.events]
    assert kinds == [("rise", 0), ("fall", 0), ("hold", 1)] or kinds == [("fall", 0), ("hold", 1)]
    assert network.chips[1].status == "held" and low(network, 1) == 7


# ---- several drivers ----


def puller(delay: int, length: int) -> Any:
    """Drives IIOF1 low for a while: 20h is an output that is low, 60h one that is high."""
    wait = "        rpts {}\n        nop\n"
    return assembled(
        "        ldi 60h,iif\n"
        + wait.format(delay)
        + "        ldi 20h,iif\n"
        + wait.format(length)
        + "        ldi 60h,iif\n"
        + END
    )


def test_an_open_drain_net_is_low_while_one_pulls() -> None:
    alone = [run([puller(*times)], ["0.IIOF1>0.IIOF2"], 60) for times in ((100, 300), (200, 400))]
    falls, rises = [
        [[at for at, kind in edges(network) if kind == which] for network in alone] for which in ("fall", "rise")
    ]
    both = run([puller(100, 300), puller(200, 400), listener(3, iiof(0))], ["0.IIOF1&1.IIOF1>2.IIOF0"], 60)
    assert edges(both) == [(falls[0][0], "fall"), (rises[1][0], "rise")]
    assert interrupts(both, 2) == [falls[0][0] + CYCLE]


def test_an_input_that_is_made_an_output_is_a_fault() -> None:
    network = run(
        [assembled(clock(100) + END), assembled("        rpts 200\n        nop\n        ldi 20h,iif\n" + END)],
        ["sync: 0.TCLK0>1.IIOF1"],
        100,
    )
    assert network.chips[1].status == "fault"
    assert "pin IIOF1 becomes an output, and a net or device drives it" in network.chips[1].message


# ---- links beside nets ----


def test_a_word_that_is_asked_for_by_a_pin_interrupts_its_driver_that_runs_on() -> None:
    """Chip 0 alone is awake. Its timer's edges wake chip 1, which answers each by a word: ICRDY of port 0 (vector Eh)
    interrupts chip 0."""
    vector = "        ldi 0,r2\n        ldhi hi16(isr),r0\n        or lo16(isr),r0\n        sti r0,*+ar1(0eh)\n        ldi 4,iie\n        or 2000h,st\n"
    first = assembled(
        vector
        + clock(1000)
        + "wait:   addi 1,r4\n        b wait\nisr:    ldi *+ar0(41h),r1\n        addi 1,r2\n        reti\n"
    )
    second = listener(4, iiof(1), "isr:    addi 1,r2\n        sti r2,*+ar0(72h)\n        reti\n")
    network = run([first, second], ["0.TCLK0>1.IIOF1"], 1100, links=["0.0:1.3"])
    asked = [at for at, kind in edges(network) if kind == "fall"]
    # The time to take the interrupt, to store the word and to send it. Before the first word, chip 1 also has to get
    # the token.
    after = [answer - edge for answer, edge in zip(interrupts(network, 0), asked, strict=True)]
    assert len(after) == 6 and all(16 * CYCLE < cycles < 28 * CYCLE for cycles in after)


# ---- the end ----


def test_a_clock_without_a_listener_does_not_keep_a_network_running() -> None:
    network = run([assembled(clock(100) + END), assembled(END)], ["0.TCLK0>1.IIOF1"])
    assert [chip.status for chip in network.chips] == ["halt", "halt"] and network.now_ps < 10_000_000


def test_a_sleeping_chip_whose_net_does_not_change_has_ended() -> None:
    network = run([assembled(END), listener(4, iiof(1))], ["0.TCLK0>1.IIOF1"])
    assert network.chips[1].status == "sleeping" and network.chips[1].message.endswith("until a pin interrupts it")


def test_future_pulses_keep_a_sleeping_chip_waiting() -> None:
    network = run(
        [listener(4, iiof(1))], ["wire: >0.IIOF1"], None, lambda network: network.pulse("wire", 50_000, width_us=1)
    )
    assert low(network, 0) == 1
