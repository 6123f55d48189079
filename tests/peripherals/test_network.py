"""Networks: held against the plainest possible driver of chips and links (linked_processors), and against counts by hand."""

from __future__ import annotations

import itertools
import json
import os
import random
import subprocess
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from cmrc import c40
from cmrc.network import Network, NetworkError, SharedMemory
from linked_processors import Network as PlainNetwork
from linked_processors import processor

CODE, DATA, STACK = 0x2FFC00, 0x2FF800, 0x2FFB00
PERIOD_PS = 50_000  # of H1 at 40 MHz
STOP = "end:    bu end\n"


def program(text: str) -> Any:
    return c40.assemble("        .text\n" + text, sections={".text": CODE})


def base(port: int, register: str = "ar0") -> str:
    return f"        ldhi 10h,{register}\n        or {0x40 + 0x10 * port:x}h,{register}\n"


def sender(port: int, count: int, first: int = 1) -> str:
    return base(port) + f"        ldi {first},r0\n" + "        sti r0,*+ar0(2)\n        addi 1,r0\n" * count + STOP


def receiver(port: int, count: int) -> str:
    """Blocking reads, to 2FF800h on."""
    return base(port) + "        ldhi 2fh,ar1\n        or 0f800h,ar1\n" + "        ldi *+ar0(1),r0\n        sti r0,*ar1++\n" * count + STOP


RELAY = """
        ldi 100,r0
        bu FIRST
loop:   ldi *+ar2(1),r0
        addi 1,r0
seed:   sti r0,*+ar0(2)
        bu loop
"""


def state(network: Network) -> tuple[Any, ...]:
    """Everything that can be read of a network, except the order in which its chips were advanced."""
    registers = [{name: chip.registers[name] for name in c40.REGISTERS} for chip in network.chips]
    ports = [chip.port(n) for chip in network.chips for n in range(6)]
    chips = [(chip.status, chip.message, chip.pc, chip.cycles, chip.instructions, chip.causes) for chip in network.chips]
    return network.now_ps, registers, ports, chips, network.links, network.events


def balanced(network: Network) -> bool:
    """For each direction: written = read + in FIFOs + under way + lost + discarded, counted from the chips' side."""
    for link in network.links:
        for (chip, port), (other, other_port), traffic in ((link.a, link.b, link.forth), (link.b, link.a, link.back)):
            mine, theirs = network.chips[chip].port(port), network.chips[other].port(other_port)
            there = theirs["read"] + len(theirs["input"]) + theirs["discarded_input"]
            if mine["written"] != len(mine["output"]) + mine["discarded_output"] + traffic.under_way + traffic.lost + there:
                return False
    return True


# ---- order and time ----


def test_one_word_leaves_an_idle_link_six_cycles_after_the_store() -> None:
    network = Network([program(sender(0, 1)), program(receiver(3, 1))], links=["0.0:1.3"], record_words=True)
    assert network.run().reason == "ended"
    assert network.chips[1].memory[DATA] == 1
    (word,) = [event for event in network.events if event.kind == "word"]
    alone = c40.Processor(program(sender(0, 1)))
    while alone.pc != CODE + 3:
        alone.step()
    stop = alone.step()
    written = stop.cycle - 1
    assert word.time_ps == (written + 1 + 5) * PERIOD_PS
    assert word.text == f"{word.time_ps} word 0.0>1.3 00000001"


@pytest.mark.parametrize("clocks", [(40, 40, 40, 40), (40, 50, 60, 40), (33.333, 40, 50, 60)])
def test_a_ring_as_the_plainest_driver_runs_it(clocks: tuple[float, ...]) -> None:

    def text(n: int) -> str:
        return base(n % 3) + base(3 + n % 3, "ar2") + RELAY.replace("FIRST", "seed" if n == 0 else "loop")

    hertz = [round(mhz * 1e6 / 2) for mhz in clocks]
    until = 150_000_000
    plain = PlainNetwork([processor(text(n)) for n in range(4)], hertz=hertz)
    for n in range(4):
        plain.join(n, n % 3, (n + 1) % 4, 3 + (n + 1) % 4 % 3)
    plain.run(until)
    links = [f"{n}.{n % 3}:{(n + 1) % 4}.{3 + (n + 1) % 4 % 3}" for n in range(4)]
    network = Network([program(text(n)) for n in range(4)], links=links, clocks_mhz=clocks, record_words=True)
    for chip in network.chips:
        chip.registers["R0"], chip.registers["R1"], chip.registers["R2"], chip.registers["R3"] = 0x8000000000, 0, 0, 0
    assert network.run(until_us=until / 1e6).reason == "limit"
    words = [[event["time"] for event in link.events if event["kind"] == "word"] for link in plain.links]
    assert [[event.time_ps for event in network.events if event.kind == "word" and event.place == n] for n in range(4)] == words
    assert min(len(times) for times in words) > 20
    assert [chip.causes for chip in network.chips] == [chip.causes for chip in plain.chips]
    assert [chip.port(n) for chip in network.chips for n in range(6)] == [chip.port(n) for chip in plain.chips for n in range(6)]


WORDS = list(range(1000, 1060))


def stream_by_dma(sender_core: Any, receiver_core: Any) -> None:
    """60 words from 2FF800h of one chip through channel 0 and port 0 to 2FF800h of the other, through port 3 and channel 3."""
    for n, word in enumerate(WORDS):
        sender_core.poke(DATA + n, word)
    run, stop_at_end = 3 << 22, 1 << 2
    for core, base_address, source, source_index, destination, destination_index, control, die in (
        (sender_core, 0x1000A0, DATA, 1, 0x100042, 0, run | stop_at_end | 1 << 7, 1 << 2),
        (receiver_core, 0x1000D0, 0x100071, 0, DATA, 1, run | stop_at_end | 1 << 18 | 1 << 6, 1 << 14),
    ):
        for offset, value in enumerate((source, source_index, len(WORDS), destination, destination_index), start=1):
            core.poke(base_address + offset, value)
        core.poke(base_address, control)
        core.set("DIE", die)


@pytest.mark.parametrize("clocks", [(40, 40), (50, 33.333), (33.333, 60)])
def test_dma_as_the_plainest_driver_runs_it(clocks: tuple[float, float]) -> None:
    idles = "wait:   idle\n        bu wait\n"
    hertz, until = [round(mhz * 1e6 / 2) for mhz in clocks], 30_000_000
    plain = PlainNetwork([processor(idles), processor(idles)], hertz=hertz)
    link = plain.join(0, 0, 1, 3)
    stream_by_dma(plain.chips[0], plain.chips[1])
    plain.run(until)
    words = [event["time"] for event in link.events if event["kind"] == "word"]
    assert len(words) == len(WORDS)
    network = Network([program(idles), program(idles)], links=["0.0:1.3"], clocks_mhz=clocks, record_words=True)
    stream_by_dma(network.chips[0]._core, network.chips[1]._core)
    network.run(until_us=until / 1e6)
    assert network.chips[1].memory[DATA : DATA + len(WORDS)] == WORDS
    assert [event.time_ps for event in network.events if event.kind == "word"] == words


@pytest.mark.parametrize("clocks", [(40, 40), (50, 33.333), (33.333, 60)])
def test_dma_beside_a_processor_that_works_as_the_plainest_driver_runs_it(clocks: tuple[float, float]) -> None:
    works = "        ldhi 2fh,ar4\n        or 0f900h,ar4\nloop:   ldi *ar4,r0\n        addi 1,r0\n        sti r0,*ar4\n        bu loop\n"
    idles = "wait:   idle\n        bu wait\n"
    hertz, until = [round(mhz * 1e6 / 2) for mhz in clocks], 30_000_000
    plain = PlainNetwork([processor(works), processor(idles)], hertz=hertz)
    link = plain.join(0, 0, 1, 3)
    stream_by_dma(plain.chips[0], plain.chips[1])
    plain.run(until)
    network = Network([program(works), program(idles)], links=["0.0:1.3"], clocks_mhz=clocks, record_words=True)
    stream_by_dma(network.chips[0]._core, network.chips[1]._core)
    network.run(until_us=until / 1e6)
    words = [event["time"] for event in link.events if event["kind"] == "word"]
    assert len(words) == len(WORDS) and [event.time_ps for event in network.events if event.kind == "word"] == words


@pytest.mark.parametrize("clocks", [(40, 40), (50, 33.333), (33.333, 60)])
def test_dma_streams_at_the_links_rate_beside_a_processor_that_works(clocks: tuple[float, float]) -> None:
    works = "        ldhi 2fh,ar4\n        or 0f900h,ar4\nloop:   ldi *ar4,r0\n        addi 1,r0\n        sti r0,*ar4\n        bu loop\n"
    results = []
    for seed in range(3):
        network = Network([program(works), program("wait:   idle\n        bu wait\n")], links=["0.0:1.3"], clocks_mhz=clocks, turn_order=seed, record_words=True)
        stream_by_dma(network.chips[0]._core, network.chips[1]._core)
        network.run(until_us=30)
        assert network.chips[1].memory[DATA : DATA + len(WORDS)] == WORDS and balanced(network)
        times = [event.time_ps for event in network.events if event.kind == "word"]
        assert (times[-1] - times[0]) / (len(WORDS) - 1) == pytest.approx(5 * 2e6 / clocks[0], rel=0.002)
        results.append(state(network))
    assert all(result == results[0] for result in results)


def interrupt_program(port: int, work: str) -> str:
    """ICRDY of `port` takes a word to 2FFA00h on; the main program is `work`. Vectors stand at 2FF800h."""
    vector = 0x0D + 4 * port + 1
    return f"""
        ldhi 2fh,ar7
        or 0fb00h,ar7
        ldi ar7,sp
        ldhi 2fh,ar6
        or 0f800h,ar6
        ldpe ar6,ivtp
        addi {vector},ar6
        ldhi 2fh,r8
        or take & 0ffffh,r8
        sti r8,*ar6
        ldhi 2fh,ar5
        or 0fa00h,ar5
{base(port, "ar2")}        ldi 0,r9
        ldhi {(1 << (2 + 4 * port)) >> 16:x}h,r10
        or {(1 << (2 + 4 * port)) & 0xFFFF:x}h,r10
        ldi r10,iie
        or 2000h,st
{work}
take:   ldi *+ar2(1),r11
        sti r11,*ar5++
        reti
"""


def mixed_network(seed: int) -> Network:
    """A sender with gaps, a chip that is interrupted while it computes, one that idles until interrupted and passes words on, and a reader."""
    rng = random.Random(5)
    gaps = "".join("        sti r0,*+ar0(2)\n        addi 1,r0\n" + "        nop\n" * rng.randrange(30) for _ in range(30))
    first = base(0) + base(1, "ar1") + "        ldi 1,r0\n" + gaps.replace("addi 1,r0", "addi 1,r0\n        sti r0,*+ar1(2)") + STOP
    busy = interrupt_program(3, "spin:   addi 1,r9\n        mpyi r9,r9\n        bu spin\n")
    idle = interrupt_program(4, base(0, "ar4") + "wait:   idle\n        ldi *-ar5(1),r7\n        sti r7,*+ar4(2)\n        bu wait\n")
    last = base(3) + "loop:   ldi *+ar0(1),r0\n        addi r0,r9\n        bu loop\n"
    return Network(
        [program(first), program(busy), program(idle), program(last)],
        links=["0.0:1.3", "0.1:2.4", "2.0:3.3"], clocks_mhz=[40, 50, 60, 33.333], turn_order=seed, record_words=True,
    )  # fmt: skip


def test_the_order_of_turns_changes_nothing() -> None:
    results = []
    for seed in range(6):
        network = mixed_network(seed)
        stop = network.run(until_us=120)
        assert balanced(network)
        results.append((stop, state(network)))
    assert all(result == results[0] for result in results)
    network = mixed_network(0)
    network.run(until_us=120)
    taken = network.chips[1].memory[0x2FFA00 : 0x2FFA00 + 30]
    assert taken == list(range(1, 31))
    assert network.chips[3].port(3)["read"] > 10
    assert network.chips[2].causes["idle"] > 0 and network.chips[1].causes["interrupt"] >= 30 * 8


def test_how_a_run_is_cut_into_calls_changes_nothing() -> None:
    whole = mixed_network(0)
    whole.run(until_us=120)
    parts = mixed_network(0)
    for until in (0.001, 3.3, 17.77, 17.78, 60, 119.99, 120):
        parts.run(until_us=until)
    assert state(parts) == state(whole)


def test_sixty_four_chips_in_a_grid() -> None:
    """Each chip takes a word from the west (0 at the edge) and one from the north, adds one to the greater, and sends it east and south:
    the number in column x, row y is x + y + 1."""
    text = f"""
        ldi r0,r4
        ldi r2,r6
        subi 1,r6
        and r6,r4
        ldi r0,r5
        lsh -3,r5
{base(0, "ar0")}{base(1, "ar1")}{base(3, "ar3")}{base(4, "ar4")}
        ldi 0,r8
        ldi 0,r9
        cmpi 0,r4
        beq north
        ldi *+ar3(1),r8
north:  cmpi 0,r5
        beq sum
        ldi *+ar4(1),r9
sum:    cmpi r8,r9
        ldigt r9,r8
        addi 1,r8
        cmpi 7,r4
        beq south
        sti r8,*+ar0(2)
south:  cmpi 7,r5
        beq end
        sti r8,*+ar1(2)
{STOP}"""
    network = Network(program(text), topology="grid:8x8")
    assert network.run().reason == "ended"
    assert [chip.registers["R8"] & 0xFFFFFFFF for chip in network.chips] == [x + y + 1 for y in range(8) for x in range(8)]
    assert len(network.links) == 2 * 7 * 8 and all(link.forth.sent == 1 and link.back.sent == 0 for link in network.links)


@pytest.mark.parametrize(("topology", "chips", "links", "degree"), [
    ("ring:5", 5, 5, 2), ("line:5", 5, 4, None), ("torus:4x4x4", 64, 192, 6), ("torus:3x2", 6, 12, 4), ("hypercube:64", 64, 192, 6), ("hypercube:16", 16, 32, 4), ("grid:2x3", 6, 7, None),
])  # fmt: skip
def test_topologies(topology: str, chips: int, links: int, degree: int | None) -> None:
    network = Network(program(STOP), topology=topology)
    assert (len(network.chips), len(network.links)) == (chips, links)
    ends = [end for link in network.links for end in (link.a, link.b)]
    assert len(set(ends)) == len(ends)
    assert all((a in (0, 1, 2)) and (b in (3, 4, 5)) for (_, a), (_, b) in ((link.a, link.b) for link in network.links))
    if degree is not None:
        assert {sum(end[0] == n for end in ends) for n in range(chips)} == {degree}
    if topology.startswith("hypercube"):
        assert all((link.a[0] ^ link.b[0]).bit_count() == 1 for link in network.links)
        assert len({frozenset((link.a[0], link.b[0])) for link in network.links}) == links


# ---- what is done to a network ----


@pytest.mark.parametrize(("into", "bytes_over"), [(0, 0), (1, 0), (2, 1), (3, 2), (4, 3)])
def test_cutting_a_link_in_mid_word(into: int, bytes_over: int) -> None:
    def made() -> Network:
        return Network([program(sender(0, 12)), program(receiver(3, 11))], links=["0.0:1.3"], record_words=True)

    whole = made()
    whole.run()
    third = [event.time_ps for event in whole.events if event.kind == "word"][2]
    network = made()
    cut = third - (5 - into) * PERIOD_PS
    network.cut(0, cut / 1e6)
    network.restore(0, cut / 1e6 + 10)
    assert network.run().reason == "ended"
    (lost,) = [event for event in network.events if event.kind == "lost"]
    assert (lost.time_ps, lost.place, lost.side, lost.word, lost.count) == (cut, 0, 0, 3, bytes_over)
    assert network.chips[1].memory[DATA : DATA + 11] == [n for n in range(1, 13) if n != 3]
    assert network.links[0].forth.lost == 1 and balanced(network)
    after = [event.time_ps for event in network.events if event.kind == "word"][2]
    assert after == cut + 10_000_000 + 5 * PERIOD_PS


def test_a_cut_for_good_is_a_deadlock_that_says_so() -> None:
    network = Network([program(sender(0, 12)), program(receiver(3, 12))], links=["0.0:1.3"])
    network.cut(0, 1.2)
    assert network.run().reason == "deadlock"
    assert [chip.status for chip in network.chips] == ["halt", "waiting"]
    assert "(the link is cut)" in network.chips[1].message


def test_reset_of_the_side_without_a_right_to_it_loses_the_token_and_says_what_was_discarded() -> None:
    """Chip 1 sends through a port that begins without the token, gets it, and is reset: then neither end has it."""
    network = Network([program(STOP), program(sender(3, 20))], links=["0.0:1.3"])
    network.reset(1, 5)
    network.run(until_us=50)
    assert network.links[0].token_lost
    kinds = [event.kind for event in network.events]
    assert kinds.count("reset") == 1 and kinds.count("dead") == 1
    discarded = [event for event in network.events if event.kind == "discarded"]
    assert discarded and {(event.place, event.side, event.count) for event in discarded} == {(1, 3, 0)}
    assert network.chips[1].port(3)["discarded_output"] == len(discarded)
    assert "(the token is lost)" in network.chips[1].message
    assert balanced(network)


def test_a_held_chip_does_nothing_and_goes_on() -> None:
    network = Network([program(sender(0, 40)), program(receiver(3, 40))], links=["0.0:1.3"])
    network.hold(1, 2)
    assert network.run().reason == "deadlock"  # until somebody releases it
    assert network.chips[1].status == "held"
    network.release(1, 200)
    assert network.run().reason == "ended"
    assert network.chips[1].memory[DATA : DATA + 40] == list(range(1, 41))
    assert network.chips[1].causes["halted"] in range(197 * 20, 199 * 20)


def test_a_chip_pulled_out_takes_its_links_with_it() -> None:
    network = Network([program(sender(0, 20)), program(receiver(3, 20))], links=["0.0:1.3"])
    network.pull_out(1, 2)
    assert network.run().reason == "deadlock"
    assert network.chips[1].status == "pulled_out" and network.links[0].cut
    assert network.chips[0].waits_for == 1 and "room in output FIFO 0" in network.chips[0].message
    assert balanced(network)


def test_random_cuts_holds_and_resets_lose_no_word_unsaid() -> None:
    for seed in range(12):
        rng = random.Random(seed)
        network = mixed_network(seed)
        for _ in range(12):
            at = rng.uniform(1, 100)
            kind = rng.choice(["cut", "restore", "hold", "release", "reset"])
            getattr(network, kind)(rng.randrange(3), at)
        other = mixed_network(seed + 100)
        rng = random.Random(seed)
        for _ in range(12):
            at = rng.uniform(1, 100)
            kind = rng.choice(["cut", "restore", "hold", "release", "reset"])
            getattr(other, kind)(rng.randrange(3), at)
        network.run(until_us=120)
        other.run(until_us=120)
        assert balanced(network)
        assert state(network) == state(other)
        lost = sum(traffic.lost for link in network.links for traffic in (link.forth, link.back))
        assert lost == sum(event.kind == "lost" for event in network.events)
        discarded = sum(chip.port(n)[f"discarded_{side}"] for chip in network.chips for n in range(6) for side in ("input", "output"))
        assert discarded == sum(event.kind == "discarded" for event in network.events)


# ---- the end ----


def test_a_ring_in_which_all_read_first_is_a_deadlock_and_says_who_waits_for_whom() -> None:
    network = Network(program(receiver(3, 1)), topology="ring:3")
    stop = network.run()
    assert stop.reason == "deadlock"
    assert [chip.waits_for for chip in network.chips] == [2, 0, 1]
    for n, chip in enumerate(network.chips):
        assert chip.message.startswith(f"waits for a word in input FIFO 3 from chip {(n + 2) % 3} port 0 since cycle ")
        assert f"PC {CODE + 4:08X}h" in chip.message and "<text>:" in chip.message


IDLES = "wait:   idle\n        bu wait\n"


def polls(port: int) -> str:
    return base(port) + "loop:   ldi *ar0,r0\n        and 1e00h,r0\n        bz loop\n        ldi *+ar0(1),r1\n" + STOP


@pytest.mark.parametrize("ends", [IDLES, STOP])
@pytest.mark.parametrize("interrupts", [True, False])
def test_a_dma_that_nobody_will_ever_serve_is_a_deadlock_where_a_processor_sleeps_for_it(ends: str, interrupts: bool) -> None:
    """Otherwise all processors have ended, and so has the network."""
    network = Network([program(ends)] * 2, links=["0.0:1.3"])
    stream_by_dma(network.chips[0]._core, network.chips[1]._core)
    core = network.chips[1]._core
    core.poke(0x1000D3, len(WORDS) + 1)  # one more than comes
    core.set("ST", 0x2000)
    core.set("IIE", interrupts << 28)
    stop = network.run()
    assert stop.reason == ("deadlock" if interrupts else "ended") and stop.time_ps < 20_000_000
    assert network.chips[1].status == ("waiting" if interrupts else "idle" if ends == IDLES else "halt") and network.chips[1].waits_for == 0
    armed = "DMA channel 3 waits for a word in input FIFO 3 (read of 00100071h) from chip 0 port 0 since cycle "
    assert armed in network.chips[1].message and network.chips[1].message.startswith(armed) == interrupts
    assert network.chips[1].memory[DATA : DATA + len(WORDS)] == WORDS and balanced(network)


def test_a_processor_that_idles_beside_its_dma_has_ended_in_the_cycle_in_which_both_have() -> None:
    """However the run is cut, and in whatever order the chips are advanced; DMA and processor end in one cycle, too."""
    seen: dict[int, set[tuple[int, int]]] = {}
    for nops, order, cut_us in itertools.product(range(20), range(3), [1000.0, 0.05]):
        network = Network([program(IDLES), program("        nop\n" * nops + IDLES)], links=["0.0:1.3"], turn_order=order, record_peripherals=True)
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
    assert stop.reason == "deadlock" and stop.time_ps < 20_000_000 and "DMA channel 3 waits for a word" in receiver_chip.message


def test_the_dma_goes_on_while_its_processor_waits_for_a_port() -> None:
    waits = base(3, "ar2") + "        ldi *+ar2(1),r1\n" + STOP
    late = base(0, "ar2") + "        ldi 1000,ar3\nl:      db ar3,l\n        ldi 7,r0\n        sti r0,*+ar2(2)\n" + IDLES
    results = []
    for seed in range(3):
        network = Network([program(waits), program(late)], links=["0.0:1.3", "1.0:0.3"], turn_order=seed, record_words=True)
        stream_by_dma(network.chips[0]._core, network.chips[1]._core)
        assert network.run().reason == "ended"
        assert network.chips[1].memory[DATA : DATA + len(WORDS)] == WORDS and network.chips[0].registers["R1"] & 0xFF == 7
        times = [event.time_ps for event in network.events if event.kind == "word"]
        assert [b - a for a, b in pairwise(times[: len(WORDS)])] == [5 * PERIOD_PS] * (len(WORDS) - 1)
        results.append(state(network))
    assert all(result == results[0] for result in results)


def test_a_processor_and_its_dma_both_wait_for_ever() -> None:
    waits = base(3, "ar2") + "        ldi *+ar2(1),r1\n" + STOP
    network = Network([program(STOP), program(waits)], links=["0.0:1.3"])
    stream_by_dma(network.chips[1]._core, network.chips[1]._core)  # channels 0 and 3; port 0 is not linked
    network.chips[1].registers["DIE"] = 1 << 2 | 1 << 14
    assert network.run().reason == "deadlock"
    message = network.chips[1].message
    assert "waits for a word in input FIFO 3 from chip 0 port 0" in message
    assert "DMA channel 0 waits for room in output FIFO 0 (write to 00100042h), to which nothing is linked," in message
    assert "DMA channel 3 waits for a word in input FIFO 3 (read of 00100071h) from chip 0 port 0" in message


def test_loops_that_poll_what_nobody_will_change_are_a_deadlock() -> None:
    network = Network([program(polls(0)), program(polls(3))], links=["0.0:1.3"])
    stop = network.run()
    assert stop.reason == "deadlock" and stop.time_ps < 20_000 * PERIOD_PS
    assert [chip.status for chip in network.chips] == ["looping"] * 2 and [chip.waits_for for chip in network.chips] == [1, 0]
    assert network.chips[1].message.startswith("polls port 3 from chip 0 port 0; no change since cycle 0, at PC 002FFC02h (loop, <text>:")


def test_chips_that_wait_for_a_boot_stream_that_nobody_sends() -> None:
    results = []
    for seed in range(3):
        network = Network([program(STOP)] * 3, links=["0.0:1.3", "1.0:2.3"], boots=[1, 2], turn_order=seed)
        assert network.run().reason == "deadlock"
        assert [chip.status for chip in network.chips] == ["halt", "looping", "looping"] and network.chips[2].waits_for == 1
        assert "polls port 3 from chip 1 port 0; ports 0, 1, 2, 4, 5, to which nothing is linked; " in network.chips[2].message
        assert "(the boot loader)" in network.chips[2].message
        results.append(state(network))
    assert all(result == results[0] for result in results)


def test_a_loop_that_polls_is_served_however_late() -> None:
    late = base(0) + "        ldi 9,r1\nmuch:   ldi 30000,ar3\nl:      db ar3,l\n        subi 1,r1\n        bnz much\n        ldi 7,r0\n        sti r0,*+ar0(2)\n" + STOP
    network = Network([program(late), program(polls(3))], links=["0.0:1.3"])
    assert network.run().reason == "ended"
    assert network.chips[1].registers["R1"] & 0xFF == 7 and network.chips[1].cycles > 1_000_000
    network = Network([program(STOP), program(polls(3))], links=["0.0:1.3"])
    network.reset(0, 5000)  # something is still to come
    stop = network.run()
    assert stop.reason == "deadlock" and stop.time_ps > 5_000_000_000


def test_a_loop_that_polls_a_shared_memory() -> None:
    polls_memory = "        ldhi 0c000h,ar0\nl:      ldi *ar0,r4\n        bz l\n" + STOP
    writes = "        ldi 30000,ar3\nd:      db ar3,d\n        ldhi 0c000h,ar0\n        ldi 9,r4\n        sti r4,*ar0\n" + STOP
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


def test_chips_that_sleep_are_no_deadlock() -> None:
    network = Network([program(interrupt_program(3, "wait:   idle\n        bu wait\n")), program(STOP)], links=["0.3:1.0"])
    assert network.run().reason == "ended"
    assert [chip.status for chip in network.chips] == ["sleeping", "halt"]


def test_a_fault_ends_a_chip_and_not_the_others() -> None:
    network = Network([program("        .word 0ffffffffh\n"), program(sender(0, 2)), program(receiver(3, 2))], links=["1.0:2.3"])
    assert network.run().reason == "ended"
    assert [chip.status for chip in network.chips] == ["fault", "halt", "halt"]
    assert network.chips[0].message


def test_until_is_an_end() -> None:
    network = Network([program(sender(0, 2).replace("end:    bu", "there:  nop\nend:    bu")), program(receiver(3, 2) + "there:  nop\n")], links=["0.0:1.3"], until="there")
    assert network.run().reason == "ended"
    assert network.chips[0].status == "until" and network.chips[0].pc == network.chips[0].address("there")


# ---- shared memory ----


def counting(rounds: int) -> str:
    """Adds one to word 0 of the memory at C0000000h `rounds` times, under a lock."""
    return f"""
        ldhi 0c000h,ar0
        ldi {rounds - 1},ar1
loop:   ldii *ar0,r4
        addi 1,r4
        nop
        stii r4,*ar0
        db ar1,loop
{STOP}"""


def test_a_lock_keeps_the_others_out() -> None:
    results = []
    for seed in range(4):
        memory = SharedMemory("counter", 16, {0: 0xC0000000, 1: 0xC0000000, 2: 0xC0000000}, waits=1)
        network = Network([program(counting(50))] * 3, memories=[memory], clocks_mhz=[40, 50, 60], turn_order=seed)
        assert network.run().reason == "ended"
        assert network.memory(0)[0] == 150
        results.append(state(network))
    assert all(result == results[0] for result in results)
    assert any(chip.causes["bus_arbitration"] > 0 for chip in network.chips)


def test_a_reset_gives_a_chips_own_lock_back_and_nobody_elses() -> None:
    memory = SharedMemory("counter", 16, {0: 0xC0000000, 1: 0xC0000000, 2: 0xC0000000})
    taker = "        ldhi 0c000h,ar0\n        ldii *ar0,r4\n" + STOP
    late = "        nop\n" * 20 + "        ldhi 0c000h,ar0\n        ldi *ar0,r4\n" + STOP
    for reset, waits in ((0, None), (2, 0)):  # the holder; one that has nothing to do with it
        network = Network([program(taker), program(late), program(STOP)], memories=[memory])
        network.hold(reset, 5)  # it does not take the lock again
        network.reset(reset, 5)
        network.hold(reset, 5)
        network.run(until_us=20)
        assert network.chips[1].waits_for == waits, reset


def test_a_lock_never_given_back_is_a_deadlock() -> None:
    memory = SharedMemory("counter", 16, {0: 0xC0000000, 1: 0xC0000000})
    taker = "        ldhi 0c000h,ar0\n        ldii *ar0,r4\n" + STOP
    late = "        nop\n" * 20 + "        ldhi 0c000h,ar0\n        ldi *ar0,r4\n" + STOP
    network = Network([program(taker), program(late)], memories=[memory])
    assert network.run().reason == "deadlock"
    assert network.chips[1].waits_for == 0 and "which chip 0 has locked" in network.chips[1].message


def test_actions_at_one_instant_are_done_in_the_order_in_which_they_were_given() -> None:
    for names, status in ((("hold", "release"), "halt"), (("release", "hold"), "held")):
        network = Network([program("        rpts 99\n        nop\n" + STOP)] * 2, links=["0.0:1.3"])
        for name in names:
            getattr(network, name)(1, 1)
        network.run(until_us=50)
        assert network.chips[1].status == status


def test_an_action_may_be_at_the_very_time_up_to_which_a_network_has_been_run() -> None:
    network = Network([program("        rpts 999\n        nop\n" + STOP)] * 2, links=["0.0:1.3"])
    network.run(until_us=10)
    network.hold(1, 10)
    network.run(until_us=50)
    assert network.chips[1].status == "held"


@pytest.mark.parametrize("mhz", [0.001, 1000])
def test_the_slowest_clock_and_the_quickest(mhz: float) -> None:
    assert Network(program(STOP), clocks_mhz=mhz).run().reason == "ended"


# ---- bad input ----


@pytest.mark.parametrize(("links", "message"), [
    (["0.0:1.7"], "chip 1 has no port 7; 0 to 5 are possible"),
    (["0.0:2.3"], "there is no chip 2; the network has chips 0 to 1"),
    (["0.0:0.0"], "chip 0 port 0 cannot be linked to itself"),
    (["0.0:1.1"], "both begin with the token; connect one of ports 0 to 2 with one of 3 to 5"),
    (["0.3:1.5"], "both begin without the token"),
    (["0.0:1.3", "0.0:1.4"], "port 0 of chip 0 already has link 0.0:1.3"),
    (["0.0-1.3"], "CHIP.PORT:CHIP.PORT is expected"),
    (["00:1.3"], "CHIP.PORT is expected"),
    (["x.0:1.3"], "there is no chip x"),
])  # fmt: skip
def test_links_that_cannot_be(links: list[str], message: str) -> None:
    with pytest.raises(NetworkError) as error:
        Network([program(STOP)] * 2, links=links)
    assert message in str(error.value) and links[-1] in str(error.value)


def test_networks_that_cannot_be() -> None:
    for given, message in [
        ({"topology": "ring:65"}, "at most 64|1 to 64"),
        ({"topology": "hypercube:12"}, "1, 2, 4, 8, 16, 32 or 64"),
        ({"topology": "star:4"}, "not a topology"),
        ({"clocks_mhz": [40, 40]}, "clocks_mhz"),
        ({"clocks_mhz": -3}, "clock of -3"),
        ({"memories": [SharedMemory("m", 4, {0: 0x300000})]}, "no window that holds"),
        ({"memories": [SharedMemory("m", 4, {3: 0xC0000000})]}, "no chip 3"),
    ]:
        with pytest.raises(NetworkError, match=message):
            Network(program(STOP), **given)  # type: ignore[arg-type]
    with pytest.raises(NetworkError, match="factor of 2"):
        Network([program(STOP)] * 2, links=["0.0:1.3"], clocks_mhz=[60, 25])
    network = Network(program("        nop\n" + STOP), topology="ring:2")
    with pytest.raises(NetworkError, match="there is no link 2"):
        network.cut(2, 1)
    with pytest.raises(NetworkError, match="there is no chip 2"):
        network.reset(2, 1)
    network.run()
    with pytest.raises(NetworkError, match="has already run to"):
        network.cut(0, 0)


# ---- from the command line ----


@pytest.fixture
def run(emulator: Path, tmp_path: Path) -> Callable[..., subprocess.CompletedProcess[str]]:
    (tmp_path / "send.asm").write_text("        .text\n" + sender(0, 3))
    (tmp_path / "take.asm").write_text("        .text\n" + receiver(3, 3))

    def command(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([emulator, "exec", *arguments], capture_output=True, text=True, check=False, cwd=tmp_path, timeout=60)

    return command


FILE = """
[[chip]]
name = "left"
program = "send.asm"
clock_mhz = 50
[[chip]]
program = "take.asm"
[[link]]
ports = "left.0:1.3"
word_cycles = 10
[[event]]
at_us = 1.0
action = "cut"
link = "0.0:1.3"
[[event]]
at_us = 4.0
action = "restore"
link = "1.3:left.0"
"""


def test_two_programs_and_a_link(run: Any) -> None:
    result = run("send.asm", "take.asm", "--link", "0.0:1.3", "--json", "--dump", f"1:{DATA}:3", "--link-trace", "trace")
    report = json.loads(result.stdout)
    assert result.returncode == 0 and report["stop"]["reason"] == "ended"
    assert report["dumps"] == [{"chip": 1, "address": DATA, "words": [1, 2, 3]}]
    assert report["links"][0]["forth"] == {"sent": 3, "arrived": 3, "under_way": 0, "lost": 0, "tokens": 0}
    assert all(sum(chip["causes"].values()) == chip["cycles"] for chip in report["chips"])


def test_a_network_file(run: Any, tmp_path: Path) -> None:
    (tmp_path / "network.toml").write_text(FILE)
    result = run("--network", "network.toml", "--json", "--dump", f"1:{DATA}:3")
    report = json.loads(result.stdout)
    assert [event.split()[1] for event in report["events"]] == ["cut", "lost", "restored"]
    assert report["stop"]["reason"] == "deadlock" and result.returncode == 1  # one word is gone, and chip 1 waits for a third
    assert report["chips"][1]["waits_for"] == 0 and report["chips"][0]["name"] == "left"
    for old, new, message in [
        ('name = "left"', 'nam = "left"', "network.toml:3: no such key chip.nam; known are"),
        ('"left.0:1.3"', '"left.7:1.3"', "network.toml:9: link left.7:1.3: left.7: chip 0 has no port 7; 0 to 5 are possible"),
        ('"left.0:1.3"', '"right.0:1.3"', "there is no chip right"),
        ("word_cycles = 10", "word_cycles = -1", "network.toml:10: word_cycles: an integer from 0"),
        ('action = "cut"', 'action = "bite"', 'there is no action "bite"; cut, restore, reset, hold, release, pull_out, low, high, open, pulse is expected'),
        ('link = "1.3:left.0"', 'link = "0.1:1.3"', "there is no link 0.1:1.3"),
        ("at_us = 1.0", "at_us = -1.0", "event.at_us: a number from 0"),
        ('program = "take.asm"', 'name = "x"', "chip 1 has no program"),
        ("[[chip]]\nname", "[chip]\nname", "network.toml"),
    ]:  # fmt: skip
        (tmp_path / "network.toml").write_text(FILE.replace(old, new, 1))
        bad = run("--network", "network.toml")
        assert bad.returncode == 2 and bad.stdout == "" and message in bad.stderr, (new, bad.stderr)


def test_what_is_done_to_a_network_from_the_command_line_as_from_a_file(run: Any, tmp_path: Path) -> None:
    (tmp_path / "network.toml").write_text(FILE)
    from_file = json.loads(run("--network", "network.toml", "--json").stdout)
    (tmp_path / "network.toml").write_text(FILE[: FILE.index("[[event]]")])
    asked = json.loads(run("--network", "network.toml", "--json", "--action", "1,cut,left.0:1.3", "--action", "4.0,restore,1.3:0.0").stdout)
    assert asked == from_file
    held = json.loads(run("send.asm", "take.asm", "--link", "0.0:1.3", "--json", "--action", "0.5,hold,1", "--action", "100,release,1", "--action", "200,reset,0").stdout)
    assert [event.split()[1:] for event in held["events"]] == [["hold", "1"], ["release", "1"], ["reset", "0"]]
    assert held["chips"][1]["causes"]["halted"] in range(1980, 2000)
    out = json.loads(run("send.asm", "take.asm", "--link", "0.0:1.3", "--json", "--action", "0.5,pull_out,1").stdout)
    assert out["chips"][1]["status"] == "pulled_out" and out["links"][0]["cut"]


@pytest.mark.parametrize(("action", "message"), [
    ("1,bite,0", 'there is no action "bite"; cut, restore, reset, hold, release, pull_out, low, high, open, pulse is expected'),
    ("1,cut,0.1:1.3", "there is no link 0.1:1.3"),
    ("1,cut,0", "CHIP.PORT:CHIP.PORT is expected"),
    ("1,reset,2", "there is no chip 2; the network has chips 0 to 1"),
    ("x,reset,1", "AT_US,ACTION,TARGET is expected"),
    ("-1,reset,1", "AT_US,ACTION,TARGET is expected"),
    ("1,reset", "AT_US,ACTION,TARGET is expected"),
])  # fmt: skip
def test_actions_that_cannot_be(run: Any, action: str, message: str) -> None:
    result = run("send.asm", "take.asm", "--link", "0.0:1.3", "--action", action)
    assert result.returncode == 2 and result.stdout == "" and message in result.stderr, result.stderr


def test_what_one_chip_can_be_asked_a_network_can(run: Any, tmp_path: Path) -> None:
    options = ["--trace", "t", "--events", "e", "--check", "--profile", "--pipeline", "0:20", "--peripherals"]
    plain = json.loads(run("send.asm", "take.asm", "--link", "0.0:1.3", "--json").stdout)
    result = run("send.asm", "take.asm", "--link", "0.0:1.3", "--json", *options)
    report = json.loads(result.stdout)
    assert result.returncode == 0 and report["stop"] == plain["stop"]
    for n, (chip, before) in enumerate(zip(report["chips"], plain["chips"], strict=True)):
        assert {key: chip[key] for key in before} == before
        trace = (tmp_path / f"t.chip{n}").read_text().splitlines()
        assert len(trace) == 1 + chip["instructions"] and all(f"[dsp {n}]" in line for line in trace[1:])
        assert chip["diagnostics"] == [] and chip["profile"]["causes"] == chip["causes"] and chip["profile"]["instructions"] == chip["instructions"]
        assert "ldhi 10h,ar0" in chip["pipeline"]
        assert chip["peripherals"]["PORT3.control"]["fields"]["PORT DIR"] == 1 and chip["peripherals"]["DMA5.auxiliary_link"] == {"value": 0}
    events = (tmp_path / "e").read_text().splitlines()
    times = [int(line.split()[0]) for line in events]
    assert times == sorted(times) and len(events) == 9
    assert [line.split(" ", 1)[1] for line in events if line.endswith("00000002")] == ["chip 0: port_write 0 = 00000002", "word 0.0>1.3 00000002", "chip 1: port_read 3 = 00000002"]
    for seed in "12":
        again = run("send.asm", "take.asm", "--link", "0.0:1.3", "--json", "--turn-order", seed, *options)
        assert again.stdout == result.stdout and (tmp_path / "e").read_text().splitlines() == events
    text = run("send.asm", "take.asm", "--link", "0.0:1.3", *options).stdout
    assert [text.count(word) for word in ("checks: no rule was broken", "profile: routines", "pipeline, cycles 0 to 20")] == [2, 2, 2]


def test_a_network_from_a_file_in_python(run: Any, tmp_path: Path) -> None:
    (tmp_path / "network.toml").write_text(FILE)
    run("--network", "network.toml", "--events", "e")
    network = Network.from_file(tmp_path / "network.toml", record_words=True, record_peripherals=True)
    assert network.run().reason == "deadlock"
    assert network.event_trace == (tmp_path / "e").read_text().splitlines()
    assert [event.kind for event in network.events if event.kind not in ("word", "token")] == ["cut", "lost", "restored"]
    assert [(event.chip, event.kind, event.number, event.value, event.channel) for event in network.peripheral_events][:2] == [(0, "port_write", 0, 1, None), (0, "port_write", 0, 2, None)]
    assert network.chips[0].name == "left" and network.chips[0].pc == network.chips[0].address("end")
    chip = network.chips[1]
    assert chip.peripherals["PORT3.control"] == 4 and chip.fields("port3.control")["INPUT LEVEL"] == 0 and len(chip.peripherals) == 2 + 6 + 6 + 54
    with pytest.raises(IndexError, match=r"PORT9\.control.*PORT"):
        chip.fields("PORT9.control")
    (tmp_path / "network.toml").write_text(FILE.replace('"cut"', '"bite"'))
    with pytest.raises(NetworkError, match="network.toml:13: there is no action"):
        Network.from_file(tmp_path / "network.toml")
    with pytest.raises(NetworkError, match="nowhere.toml: cannot be read"):
        Network.from_file(tmp_path / "nowhere.toml")


def test_interrupts_and_dma_are_events() -> None:
    network = Network([program(IDLES)] * 2, links=["0.0:1.3"], record_peripherals=True)
    stream_by_dma(network.chips[0]._core, network.chips[1]._core)
    network.run(until_us=40)
    seen = [(event.chip, event.kind, event.number, event.channel) for event in network.peripheral_events]
    assert seen.count((0, "port_write", 0, 0)) == seen.count((1, "port_read", 3, 3)) == len(WORDS)
    assert seen[-1] == (1, "dma_end", 3, None) and seen.count((0, "dma_end", 0, None)) == 1
    network = Network([program(sender(0, 2)), program(interrupt_program(3, IDLES))], links=["0.0:1.3"], record_peripherals=True)
    network.run(until_us=40)
    taken = [event for event in network.peripheral_events if event.kind == "interrupt"]
    assert [(event.chip, event.number) for event in taken] == [(1, 0x0D + 4 * 3 + 1)] * 2
    assert network.chips[1].memory[0x2FFA00:0x2FFA02] == [1, 2]


@pytest.mark.parametrize(("arguments", "message"), [
    (["send.asm", "take.asm", "--link", "0.0:1.6"], "chip 1 has no port 6; 0 to 5 are possible"),
    (["send.asm", "--topology", "ring"], "--topology"),
    (["send.asm", "take.asm", "--topology", "ring:3"], "one program for all or 3 programs are expected, not 2"),
    (["send.asm", "take.asm", "--boot", "3"], "--boot: in a network the chips boot one another: boot = true of a [[chip]]"),
    (["send.asm", "take.asm", "--load-at", "1000h"], "--load-at: is for .hex files only"),
    (["send.asm", "take.asm", "--pipeline", "5"], "--pipeline: \"5\" is not FIRST:LAST"),
    (["send.asm", "take.asm", "--dump", "table:3"], "is not CHIP:ADDRESS:COUNT"),
    (["send.asm", "take.asm", "--dump", "2:0x300000:3"], "there is no chip 2"),
    (["--network", "nowhere.toml"], "nowhere.toml: no such file"),
    (["--network", "nowhere.toml", "--until", "end"], "where a chip starts and ends are given in the file"),
])  # fmt: skip
def test_bad_commands(run: Any, arguments: list[str], message: str) -> None:
    result = run(*arguments)
    assert result.returncode == 2 and result.stdout == "" and message in result.stderr, result.stderr


def test_memory_that_no_program_has_touched_costs_nothing_in_a_second_network_either() -> None:
    """64 chips have 700 MB of RAM. calloc would fill what an earlier network has freed with zeros."""

    def resident_mb() -> float:
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6

    before = resident_mb()
    for _ in range(4):
        network = Network(c40.assemble("loop:   bu loop\n"), topology="torus:4x4x4")
        network.run(until_us=1)
        del network
    assert resident_mb() - before < 250
