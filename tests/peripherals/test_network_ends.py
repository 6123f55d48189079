"""How the run of a network ends: a deadlock, which names each chip and what it waits for; an end; a fault."""

from __future__ import annotations

import itertools
from itertools import pairwise
from typing import Any

import pytest
from cmrc import c40
from cmrc.network import Network, SharedMemory
from network_programs import (
    CODE,
    DATA,
    IDLES,
    PERIOD_PS,
    STOP,
    WORDS,
    base,
    check_balance,
    interrupt_program,
    program,
    receiver,
    sender,
    state,
    stream_by_dma,
)


def test_a_ring_in_which_all_read_first_is_a_deadlock_that_names_each_wait() -> None:
    network = Network(program(receiver(3, 1)), topology="ring:3")
    stop = network.run()
    assert stop.reason == "deadlock"
    assert [chip.waits_for for chip in network.chips] == [2, 0, 1]
    for n, chip in enumerate(network.chips):
        assert chip.message.startswith(f"waits for a word in input FIFO 3 from chip {(n + 2) % 3} port 0 since cycle ")
        assert f"PC {CODE + 4:08X}h" in chip.message and "<text>:" in chip.message


def polls(port: int) -> str:
    return base(port) + "loop:   ldi *ar0,r0\n        and 1e00h,r0\n        bz loop\n        ldi *+ar0(1),r1\n" + STOP


@pytest.mark.parametrize("ends", [IDLES, STOP])
@pytest.mark.parametrize("interrupts", [True, False])
def test_a_dma_that_is_never_served_is_a_deadlock_where_a_processor_sleeps_for_it(ends: str, interrupts: bool) -> None:
    """Otherwise all processors have ended, and so has the network."""
    network = Network([program(ends)] * 2, links=["0.0:1.3"])
    stream_by_dma(network.chips[0]._core, network.chips[1]._core)
    core = network.chips[1]._core
    core.poke(0x1000D3, len(WORDS) + 1)  # one word more than arrives
    core.set("ST", 0x2000)
    core.set("IIE", interrupts << 28)
    stop = network.run()
    assert stop.reason == ("deadlock" if interrupts else "ended") and stop.time_ps < 20_000_000
    assert (
        network.chips[1].status == ("waiting" if interrupts else "idle" if ends == IDLES else "halt")
        and network.chips[1].waits_for == 0
    )
    armed = "DMA channel 3 waits for a word in input FIFO 3 (read of 00100071h) from chip 0 port 0 since cycle "
    assert armed in network.chips[1].message and network.chips[1].message.startswith(armed) == interrupts
    assert network.chips[1].memory[DATA : DATA + len(WORDS)] == WORDS
    check_balance(network)


def test_a_processor_that_idles_beside_its_dma_has_ended_in_the_cycle_in_which_both_have() -> None:
    """This holds however the run is cut, and in every order of turns; also where DMA and processor end in the same
    cycle."""
    seen: dict[int, set[tuple[int, int]]] = {}
    for nops, order, cut_us in itertools.product(range(20), range(3), [1000.0, 0.05]):
        network = Network(
            [program(IDLES), program("        nop\n" * nops + IDLES)],
            links=["0.0:1.3"],
            turn_order=order,
            record_peripherals=True,
        )
        stream_by_dma(network.chips[0]._core, network.chips[1]._core)
        for core, counter in (network.chips[0]._core, 0x1000A3), (network.chips[1]._core, 0x1000D3):
            core.poke(counter, 2)
        while network.run(until_us=network.now_ps * 1e-6 + cut_us).reason == "limit":
            pass
        chip = network.chips[1]
        done_ps = next(int(line.split()[0]) for line in network.event_trace if "chip 1: dma_end 3" in line)
        seen.setdefault(nops, set()).add((chip.cycles - done_ps // PERIOD_PS, chip.causes["idle"]))
    together = 15  # NOPs, after which the processor begins to idle in the cycle of the DMA's end
    assert seen == {nops: {(max(nops - together, 0), max(together - nops, 0))} for nops in range(20)}


def test_a_stop_watch_is_nothing_to_wait_for() -> None:
    """A running timer without readers does not hide a DMA that waits without end."""
    network = Network([program(IDLES)] * 2, links=["0.0:1.3"])
    stream_by_dma(network.chips[0]._core, network.chips[1]._core)
    receiver_chip = network.chips[1]
    receiver_chip.memory[0x1000D3] = len(WORDS) + 1
    receiver_chip.memory[0x100028] = 0xFFFFFFFF
    receiver_chip.memory[0x100020] = 0x2C0
    receiver_chip.registers["IIE"] = 1 << 28
    stop = network.run()
    assert (
        stop.reason == "deadlock"
        and stop.time_ps < 20_000_000
        and "DMA channel 3 waits for a word" in receiver_chip.message
    )


def test_the_dma_continues_while_its_processor_waits_for_a_port() -> None:
    waits = base(3, "ar2") + "        ldi *+ar2(1),r1\n" + STOP
    late = (
        base(0, "ar2") + "        ldi 1000,ar3\nl:      db ar3,l\n        ldi 7,r0\n        sti r0,*+ar2(2)\n" + IDLES
    )
    results = []
    for seed in range(3):
        network = Network(
            [program(waits), program(late)], links=["0.0:1.3", "1.0:0.3"], turn_order=seed, record_words=True
        )
        stream_by_dma(network.chips[0]._core, network.chips[1]._core)
        assert network.run().reason == "ended"
        assert (
            network.chips[1].memory[DATA : DATA + len(WORDS)] == WORDS and network.chips[0].registers["R1"] & 0xFF == 7
        )
        times = [event.time_ps for event in network.events if event.kind == "word"]
        assert [b - a for a, b in pairwise(times[: len(WORDS)])] == [5 * PERIOD_PS] * (len(WORDS) - 1)
        results.append(state(network))
    assert all(result == results[0] for result in results)


def test_a_processor_and_its_dma_both_wait_forever() -> None:
    waits = base(3, "ar2") + "        ldi *+ar2(1),r1\n" + STOP
    network = Network([program(STOP), program(waits)], links=["0.0:1.3"])
    stream_by_dma(network.chips[1]._core, network.chips[1]._core)  # channels 0 and 3; port 0 is not linked
    network.chips[1].registers["DIE"] = 1 << 2 | 1 << 14
    assert network.run().reason == "deadlock"
    message = network.chips[1].message
    assert "waits for a word in input FIFO 3 from chip 0 port 0" in message
    assert "DMA channel 0 waits for room in output FIFO 0 (write to 00100042h), to which nothing is linked," in message
    assert "DMA channel 3 waits for a word in input FIFO 3 (read of 00100071h) from chip 0 port 0" in message


def test_loops_that_poll_what_never_changes_are_a_deadlock() -> None:
    network = Network([program(polls(0)), program(polls(3))], links=["0.0:1.3"])
    stop = network.run()
    assert stop.reason == "deadlock" and stop.time_ps < 20_000 * PERIOD_PS
    assert [chip.status for chip in network.chips] == ["looping"] * 2 and [
        chip.waits_for for chip in network.chips
    ] == [1, 0]
    assert network.chips[1].message.startswith(
        "polls port 3 from chip 0 port 0; no change since cycle 0, at PC 002FFC02h (loop, <text>:"
    )


def test_chips_that_wait_for_a_boot_stream_that_never_comes() -> None:
    results = []
    for seed in range(3):
        network = Network([program(STOP)] * 3, links=["0.0:1.3", "1.0:2.3"], boots=[1, 2], turn_order=seed)
        assert network.run().reason == "deadlock"
        assert [chip.status for chip in network.chips] == ["halt", "looping", "looping"] and network.chips[
            2
        ].waits_for == 1
        assert (
            "polls port 3 from chip 1 port 0; ports 0, 1, 2, 4, 5, to which nothing is linked; "
            in network.chips[2].message
        )
        assert "(the boot loader)" in network.chips[2].message
        results.append(state(network))
    assert all(result == results[0] for result in results)


def test_a_loop_that_polls_is_served_however_late() -> None:
    late = (
        base(0)
        + "        ldi 9,r1\nmuch:   ldi 30000,ar3\nl:      db ar3,l\n        subi 1,r1\n        bnz much\n        ldi 7,r0\n        sti r0,*+ar0(2)\n"
        + STOP
    )
    network = Network([program(late), program(polls(3))], links=["0.0:1.3"])
    assert network.run().reason == "ended"
    assert network.chips[1].registers["R1"] & 0xFF == 7 and network.chips[1].cycles > 1_000_000
    network = Network([program(STOP), program(polls(3))], links=["0.0:1.3"])
    network.reset(0, 5000)  # something is still to come
    stop = network.run()
    assert stop.reason == "deadlock" and stop.time_ps > 5_000_000_000


def test_a_loop_that_polls_a_shared_memory() -> None:
    polls_memory = "        ldhi 0c000h,ar0\nl:      ldi *ar0,r4\n        bz l\n" + STOP
    writes = (
        "        ldi 30000,ar3\nd:      db ar3,d\n        ldhi 0c000h,ar0\n        ldi 9,r4\n        sti r4,*ar0\n"
        + STOP
    )
    memory = SharedMemory("mailbox", 4, {0: 0xC0000000, 1: 0xC0000000})
    network = Network([program(polls_memory), program(STOP)], memories=[memory])
    assert network.run().reason == "deadlock" and "polls memory mailbox at C0000000h" in network.chips[0].message
    network = Network([program(polls_memory), program(writes)], memories=[memory])
    assert network.run().reason == "ended" and network.chips[0].registers["R4"] & 0xFF == 9


def test_a_loop_that_reads_nothing_of_others_is_an_end() -> None:
    network = Network([program("loop:   nop\n        bu loop\n"), program(STOP)], links=["0.0:1.3"])
    assert network.run().reason == "ended"
    assert [chip.status for chip in network.chips] == ["looping", "halt"]
    counts = Network([program("loop:   addi 1,r0\n        bu loop\n"), program(STOP)], links=["0.0:1.3"])
    assert counts.run(max_cycles=200_000).reason == "limit"  # it does not do the same


def test_a_network_ends_when_its_last_word_has_arrived() -> None:
    """Both chips have ended long before that."""
    network = Network([program(sender(0, 3)), program(STOP)], links=[("0.0:1.3", {"word_cycles": 500})])
    stop = network.run()
    assert stop.reason == "ended" and network.links[0].forth.arrived == 3
    assert 3 * 500 * PERIOD_PS < stop.time_ps < (3 * 500 + 20) * PERIOD_PS


def test_a_network_ends_when_its_link_is_cut_in_the_middle_of_a_word() -> None:
    network = Network([program(sender(0, 3)), program(STOP)], links=[("0.0:1.3", {"word_cycles": 500})])
    network.cut(0, 40)
    stop = network.run()
    assert stop.time_ps == 40_000_000 and (network.links[0].forth.arrived, network.links[0].forth.lost) == (1, 1)


def test_chips_that_sleep_are_no_deadlock() -> None:
    network = Network(
        [program(interrupt_program(3, "wait:   idle\n        bu wait\n")), program(STOP)], links=["0.3:1.0"]
    )
    assert network.run().reason == "ended"
    assert [chip.status for chip in network.chips] == ["sleeping", "halt"]


def test_a_fault_ends_a_chip_and_not_the_others() -> None:
    network = Network(
        [program("        .word 0ffffffffh\n"), program(sender(0, 2)), program(receiver(3, 2))], links=["1.0:2.3"]
    )
    assert network.run().reason == "ended"
    assert [chip.status for chip in network.chips] == ["fault", "halt", "halt"]
    assert network.chips[0].message


def test_until_is_an_end() -> None:
    network = Network(
        [
            program(sender(0, 2).replace("end:    bu", "there:  nop\nend:    bu")),
            program(receiver(3, 2) + "there:  nop\n"),
        ],
        links=["0.0:1.3"],
        until="there",
    )
    assert network.run().reason == "ended"
    assert network.chips[0].status == "until" and network.chips[0].pc == network.chips[0].address("there")


LOOPS = {
    "branch": "start: nop\n br start\n",
    "poll": " ldhi 7000h,ar4\nagain: ldi *ar4,r1\n bz again\nstart: b start\n",
    "late": " ldi 200,rc\n rptb x\n nop\n nop\nx: addi 1,r0\nstart: nop\n nop\n br start\n",
    "ends": " ldi 900,rc\n rptb x\n nop\nx: addi 1,r0\nstart: b start\n",
}


@pytest.mark.parametrize(
    "kinds", [("branch", "branch"), ("branch", "late"), ("branch", "poll", "ends"), ("late", "ends")]
)
@pytest.mark.parametrize("net", ["n: >0.IIOF2", "n: >0.RESET"])
def test_no_chip_in_a_loop_goes_beyond_the_end(kinds: tuple[str, ...], net: str) -> None:
    """The end is stated for the whole network; the order of turns does not change where each chip is then."""

    def run(order: int) -> tuple[Any, ...]:
        programs = [c40.assemble(LOOPS[kind]) for kind in kinds]
        memory = SharedMemory("m", 4, dict.fromkeys(range(len(kinds)), 0x70000000), waits=2)
        clocks = [50, 33.333, 40][: len(kinds)]
        network = Network(programs, nets=[net], memories=[memory], clocks_mhz=clocks, turn_order=order)
        network.reset(0, 12.5)
        stop = network.run()
        for chip, mhz in zip(network.chips, clocks, strict=True):
            assert chip.cycles * 2 / mhz <= stop.time_ps / 1e6 + 10 * 2 / mhz, (
                "beyond the end by an instruction at most"
            )
        return stop.reason, stop.time_ps, [(c.status, c.pc, c.cycles, c.instructions) for c in network.chips]

    whole = run(0)
    for order in (*range(1, 9), 15, 27, 30):
        assert run(order) == whole, order
