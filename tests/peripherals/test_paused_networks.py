"""A pause, a look in the debugger and the order of turns change nothing: chips that branch to themselves, chips with a
RESET pin, and the end of a network."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import pytest
from cmrc.network import Network
from net_programs import COUNT, EDGE, END, assembled, clock, iiof
from network_programs import DATA, PERIOD_PS, STOP, program, receiver, sender
from scenarios import RUN, STOP_AT_END, SYNC, channel, die

EVERY_61_NS = [n * 0.0611 for n in range(1, 330)]


def outcome(network: Network, cuts: Sequence[float], until_us: float | None) -> tuple[Any, ...]:
    for at in cuts:
        if until_us is None or at <= until_us:
            network.run(until_us=at)
    stop = network.run(until_us=until_us)
    chips = [(c.status, c.message, c.cycles, c.instructions, c.causes, c.peripherals) for c in network.chips]
    return stop, network.event_trace, chips


def alike(make: Callable[[int], Network], until_us: float | None, *more: Sequence[float]) -> Network:
    """The run in one piece; the same in every order of turns, and with pauses."""
    whole = make(0)
    expected = outcome(whole, (), until_us)
    for order in (1, 2, 3):
        assert outcome(make(order), (), until_us) == expected, order
    for cuts in (EVERY_61_NS, *more):
        assert outcome(make(0), cuts, until_us) == expected, cuts[:3]
    return whole


def cycles(network: Network, kind: str, chip: int = 0) -> list[int]:
    return [event.cycle for event in network.peripheral_events if event.kind == kind and event.chip == chip]


# ---- a branch to itself ----

SENDS_WHEN_EMPTY = "isr:    sti r1,*ar4\n        nop\n        reti\n"


@pytest.mark.parametrize("loop", ["wait:   b wait\n", "wait:   nop\n        b wait\n"])
def test_a_port_interrupts_a_branch_to_itself_alike(loop: str) -> None:
    """OCEMPTY of port 0, vector 10h: its routine sends the next word. The link takes the last word of the FIFO in some
    cycle: the branch that begins in this cycle is executed, and the next instruction is interrupted (docs/networks.md,
    Order)."""

    def make(order: int) -> Network:
        text = "        nop\n" * 6 + "        or 2000h,st\n" + "        nop\n" * 3 + loop + SENDS_WHEN_EMPTY
        image = program(text)
        network = Network(
            [image, program(STOP)], links=["0.0:1.3"], turn_order=order, record_words=True, record_peripherals=True
        )
        chip = network.chips[0]
        values = {"AR4": 0x100042, "R1": 7, "SP": 0x2FFB00, "IVTP": 0x2FFA00, "IIE": 1 << 4}
        for name, value in values.items():
            chip.registers[name] = value
        chip.memory[0x2FFA10] = image.symbols["isr"]
        return network

    network = alike(make, 20)
    taken, sent = cycles(network, "interrupt"), [e.time_ps // PERIOD_PS for e in network.events if e.kind == "word"]
    assert len(taken) > 4
    # A word takes 5 cycles, so that the FIFO became empty 5 cycles before its word arrived.
    assert all(at - 5 not in taken for at in sent)


@pytest.mark.parametrize("driver_mhz", [40, 50, 33.33])
def test_a_pin_interrupts_a_branch_to_itself_alike(driver_mhz: float) -> None:
    """Edges at many distances from one another, so that some come in the cycle in which a branch begins."""
    edges = "".join(
        "        ldi 20h,iif\n        nop\n        ldi 60h,iif\n" + "        nop\n" * (7 * n % 13 + 1)
        for n in range(40)
    )
    driver = assembled("        ldi 60h,iif\n        nop\n" + edges + END)
    vector = "        ldi 0,r2\n        ldhi hi16(isr),r0\n        or lo16(isr),r0\n        sti r0,*+ar1(3)\n"
    waits = assembled(iiof(0, EDGE) + vector + "        or 2000h,st\nwait:   b wait\n" + COUNT)

    def make(order: int) -> Network:
        return Network(
            [waits, driver],
            nets=["1.IIOF1>0.IIOF0"],
            clocks_mhz=[40, driver_mhz],
            turn_order=order,
            record_peripherals=True,
        )

    assert len(cycles(alike(make, 40), "interrupt")) > 20


# ---- RESET ----


@pytest.mark.parametrize("text", ["        nop\n" * 200 + STOP, STOP, "wait:   addi 1,r0\n        bu wait\n"])
def test_a_low_reset_holds_a_chip_in_one_cycle_wherever_the_run_is_paused(text: str) -> None:
    """The edge at 0.527 us is sampled in cycle 11 (0.55 us) and acts in cycle 12. What waits for its instruction's end
    is held later."""

    def make(order: int) -> Network:
        other = program("        rpts 100\n        nop\n" + STOP)
        network = Network(
            [program(text), other], nets=["r: >0.RESET"], turn_order=order, record_words=True, record_peripherals=True
        )
        network.pulse(0, 0.527, width_us=0.4)
        return network

    near = [[at] for at in (0.54, 0.55, 0.56, 0.58, 0.599, 0.6, 0.601, 0.65)]
    network = alike(make, 30, *near)
    (held,) = [event.time_ps for event in network.events if event.kind == "hold"]
    assert held == 600_000 or "addi" in text
    looked_at = make(0)
    with looked_at.debug() as debugger:
        debugger.go_to_ps(560_000)
        debugger.go_to_ps(30_000_000)
    assert looked_at.event_trace == network.event_trace


def test_a_chip_that_is_pulled_out_has_no_reset_pin() -> None:
    """Not at that instant either: the edge comes before the action."""
    network = Network([program("        nop\n" * 99 + STOP)], nets=["r: >0.RESET"])
    network.pulse(0, 0.527, width_us=0.4)
    network.pull_out(0, 0.6)
    network.run(until_us=9)
    assert network.chips[0].status == "pulled_out"


# ---- actions ----


@pytest.mark.parametrize("at_us", [2, 3, 7])
@pytest.mark.parametrize("held_before", [False, True])
def test_a_release_of_a_chip_that_is_not_held_changes_nothing(at_us: float, held_before: bool) -> None:
    """A chip that waits, and one that has ended."""

    def run(releases: int) -> tuple[Any, ...]:
        network = Network(
            [program("        rpts 99\n        nop\n" + sender(0, 3)), program(receiver(3, 3)), program(STOP)],
            links=["0.0:1.3"], record_peripherals=True,
        )  # fmt: skip
        if held_before:
            network.hold(1, 0.5)
            network.release(1, 1)
        for chip in (1, 2) * releases:
            network.release(chip, at_us)
        network.run(until_us=30)
        return outcome(network, (), 30)[1:]

    trace, chips = run(0)
    for releases in (1, 2):
        more, same = run(releases)
        assert same == chips
        assert [line for line in more if f"{at_us * 1_000_000} release" not in line] == trace


# ---- the end ----


def test_a_chip_that_waits_at_the_end_has_not_stood() -> None:
    """Its timer changes a pin to which nobody listens, one of its DMA channels is armed, and the network ends in the
    cycle of a change, or in another one."""
    waits = assembled(clock(5) + "        ldi *+ar0(41h),r0\n" + END)

    def make(length: int) -> Network:
        network = Network(
            [waits, program(STOP), program(f"        rpts {length}\n        nop\n" + STOP)],
            nets=["0.TCLK0>1.IIOF1"], links=["0.0:1.3"], record_peripherals=True,
        )  # fmt: skip
        channel(
            network.chips[0], 1, RUN | STOP_AT_END, source=0x100051, source_index=0, counter=1, destination=DATA,
            destination_index=1,
        )  # fmt: skip
        return network

    for length in range(80, 102):
        expected = outcome(make(length), (), None)
        assert expected[0].reason == "deadlock" and expected[2][0][0] == "waiting"
        assert expected[2][0][4]["halted"] == 0, length
        for cuts in ([expected[0].time_ps / 1e6], EVERY_61_NS):
            assert outcome(make(length), cuts, None) == expected, length


def test_a_network_has_not_ended_while_a_timer_could_move_the_dma() -> None:
    """The DMA's channel waits for the timer, and then for a word. The end is the timer's event: no earlier event of
    another timer is missing in the trace, and none is later."""
    sleeps = assembled(
        "        ldi 50,r0\n        sti r0,*+ar0(28h)\n        ldi 2c1h,r0\n        sti r0,*+ar0(20h)\n"
        "wait:   idle\n        b wait\n"
    )
    other = assembled(
        "        ldi 30,r0\n        sti r0,*+ar0(28h)\n        ldi 2c1h,r0\n        sti r0,*+ar0(20h)\n"
        "        ldi *+ar0(71h),r0\n" + END
    )

    def make(order: int) -> Network:
        network = Network([sleeps, other], links=["0.0:1.3"], turn_order=order, record_peripherals=True)
        channel(
            network.chips[0], 2, RUN | STOP_AT_END | SYNC & 1 << 6, source=0x100041, source_index=0, counter=2,
            destination=DATA, destination_index=1,
        )  # fmt: skip
        network.chips[0].registers["DIE"] = die(2, 6, 0)
        return network

    network = alike(make, None, [4], [5], [6], [7])
    assert network.run().reason == "deadlock"
    ticks = [e.cycle for e in network.peripheral_events if e.kind == "timer"]
    assert network.now_ps == max(cycles(network, "timer")) * PERIOD_PS
    assert len(ticks) >= 2 and max(ticks) * PERIOD_PS == network.now_ps
