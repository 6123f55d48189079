"""Networks compared with the simplest possible driver of chips and links (linked_processors), and with counts by
hand."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from cmrc import c40
from cmrc.network import Network
from linked_processors import Network as PlainNetwork
from linked_processors import processor
from network_programs import (
    CODE,
    DATA,
    PERIOD_PS,
    RELAY,
    STOP,
    WORDS,
    base,
    check_balance,
    mixed_network,
    program,
    receiver,
    sender,
    state,
    stream_by_dma,
)


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
    assert [
        [event.time_ps for event in network.events if event.kind == "word" and event.place == n] for n in range(4)
    ] == words
    assert min(len(times) for times in words) > 20
    assert [chip.causes for chip in network.chips] == [chip.causes for chip in plain.chips]
    assert [chip.port(n) for chip in network.chips for n in range(6)] == [
        chip.port(n) for chip in plain.chips for n in range(6)
    ]


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
        network = Network(
            [program(works), program("wait:   idle\n        bu wait\n")],
            links=["0.0:1.3"],
            clocks_mhz=clocks,
            turn_order=seed,
            record_words=True,
        )
        stream_by_dma(network.chips[0]._core, network.chips[1]._core)
        network.run(until_us=30)
        assert network.chips[1].memory[DATA : DATA + len(WORDS)] == WORDS
        check_balance(network)
        times = [event.time_ps for event in network.events if event.kind == "word"]
        assert (times[-1] - times[0]) / (len(WORDS) - 1) == pytest.approx(5 * 2e6 / clocks[0], rel=0.002)
        results.append(state(network))
    assert all(result == results[0] for result in results)


def test_the_order_of_turns_changes_nothing() -> None:
    results = []
    for seed in range(6):
        network = mixed_network(seed)
        stop = network.run(until_us=120)
        check_balance(network)
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
    """Each chip takes a word from the west (0 at the edge) and one from the north, adds one to the greater, and sends
    it east and south: the number in column x, row y is x + y + 1."""
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
    assert [chip.registers["R8"] & 0xFFFFFFFF for chip in network.chips] == [
        x + y + 1 for y in range(8) for x in range(8)
    ]
    assert len(network.links) == 2 * 7 * 8 and all(
        link.forth.sent == 1 and link.back.sent == 0 for link in network.links
    )


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


@pytest.mark.parametrize("mhz", [0.001, 1000])
def test_the_slowest_clock_and_the_quickest(mhz: float) -> None:
    assert Network(program(STOP), clocks_mhz=mhz).run().reason == "ended"


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
