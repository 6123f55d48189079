"""Communication ports and links: the counts of c40-hardware.md 2.6, 7.6 (35, 36) and 11.5, by hand; clocks, cuts,
resets."""

from __future__ import annotations

import itertools
import random
from typing import Any

import pytest
from cmrc._core import c40
from linked_processors import DATA, HERTZ, Network, processor
from network_programs import RELAY, STOP, base, receiver, sender

PERIOD = 10**12 // HERTZ  # picoseconds


def port_base(n: int) -> int:
    return 0x100040 + 0x10 * n


def stores(port: int, count: int) -> str:
    return base(port) + "        ldi 7,r0\n        nop\n        nop\n" + "        sti r0,*+ar0(2)\n" * count + STOP


def test_cpcr_after_reset() -> None:
    chip = processor(STOP)
    assert [chip.peek(port_base(n)) & 0x1FFC for n in range(6)] == [0, 0, 0, 4, 4, 4]


def test_output_level_in_cpcr_with_the_channel_halted() -> None:
    chip = processor(base(0) + "        ldi 10h,r0\n        sti r0,*ar0\n" + "        sti r0,*+ar0(2)\n" * 8 + STOP)
    levels = []
    for _ in range(13):
        chip.step()
        level = chip.peek(port_base(0)) & 0x1FFC
        if level not in levels:
            levels.append(level)
    assert levels[:3] == [0x00, 0x10, 0x30]
    assert levels[-2:] == [0xF0, 0x1F0]


def test_a_port_with_nothing_attached_stops_the_chip_and_says_where() -> None:
    chip = processor(stores(2, 9))
    stop = chip.run(1000)
    assert stop["reason"] == "port_wait"
    assert (stop["port"], stop["write"], stop["address"], stop["value"]) == (2, True, port_base(2) + 2, 7)
    assert "output FIFO of communication port 2" in stop["message"]
    assert chip.collect(2) == 7
    chip.complete_port(stop["access_cycle"] + 5)
    assert chip.run(10)["reason"] == "limit"
    assert chip.causes["comm_port"] == 5
    assert sum(chip.causes.values()) == chip.cycle


def test_read_of_an_empty_fifo_takes_one_cycle_more_than_the_word() -> None:
    for late in (0, 1, 7, 100):
        chip = processor(receiver(4, 1))
        stop = chip.run(1000)
        assert stop["reason"] == "port_wait" and not stop["write"] and not stop["ready"]
        before = chip.cycle
        chip.deliver(4, 0xABCD)
        chip.complete_port(stop["access_cycle"] + late)
        chip.step()
        assert chip.cycle - before == 1 + late
        chip.run(20)
        assert chip.peek(DATA) == 0xABCD


def test_a_delivered_word_is_read_without_a_stop() -> None:
    chip = processor(receiver(1, 2))
    chip.deliver(1, 5)
    chip.deliver(1, 6)
    assert chip.run(100)["reason"] == "limit"
    assert [chip.peek(DATA), chip.peek(DATA + 1)] == [5, 6]
    assert chip.causes["comm_port"] == 0


def test_completing_an_access_that_is_not_ready_is_refused() -> None:
    chip = processor(receiver(0, 1))
    with pytest.raises(RuntimeError, match="waits for no communication port"):
        chip.complete_port(0)
    stop = chip.run(1000)
    with pytest.raises(RuntimeError, match="input FIFO is empty"):
        chip.complete_port(stop["access_cycle"])


def test_sixteen_stores_against_a_peer_that_does_not_read() -> None:
    network = Network([processor(stores(0, 17)), processor(STOP)])
    network.join(0, 0, 1, 3)
    network.run(200 * PERIOD)
    writes = [done for chip, kind, _, done in network.log if kind == "write"]
    first = writes[0]
    assert [at - first for at in writes] == [*range(9), *range(11, 42, 5)]
    assert len(writes) == 16  # the 17th waits for the peer
    assert network.waiting[0]["access_cycle"] - first == 42
    assert len(network.chips[1].port(3)["input"]) == len(network.chips[0].port(0)["output"]) == 8
    assert network.chips[1].peek(port_base(3)) & 0x1E00 == 0x1E00
    network.balance()


def test_one_word_over_an_idle_link() -> None:
    """The word is readable seven cycles after the store if the sender has the token, thirteen if the receiver has
    it."""
    for port, latency in ((0, 7), (3, 13)):
        network = Network([processor(stores(port, 1)), processor(receiver(3 - port, 1))])
        network.join(0, port, 1, 3 - port)
        network.run(200 * PERIOD)
        (_, _, _, written), (_, _, _, read) = sorted(network.log, key=lambda entry: entry[0])
        assert read - written == latency
        assert network.chips[1].peek(DATA) == 7
        tokens = [network.chips[0].peek(port_base(port)) & 4, network.chips[1].peek(port_base(3 - port)) & 4]
        assert tokens == [0, 4]  # it stays where it was used last


def test_one_way_stream_is_a_word_per_five_cycles() -> None:
    network = Network([processor(sender(1, 60)), processor(receiver(5, 60))])
    network.join(0, 1, 1, 5)
    network.run(1000 * PERIOD)
    reads = [done for chip, _, _, done in network.log if chip == 1]
    assert {b - a for a, b in itertools.pairwise(reads)} == {5}
    assert [network.chips[1].peek(DATA + i) for i in range(60)] == list(range(1, 61))
    network.balance()


def both_ways(port: int, count: int) -> str:
    """Fills the output FIFO, then writes and reads in turn."""
    return (
        base(port) + "        ldhi 2fh,ar1\n        or 0f800h,ar1\n        ldi 1,r1\n"
        + "        sti r1,*+ar0(2)\n        addi 1,r1\n" * 8
        + "        ldi *+ar0(1),r0\n        sti r0,*ar1++\n        sti r1,*+ar0(2)\n        addi 1,r1\n" * count + STOP
    )  # fmt: skip


def test_both_ways_saturated_is_a_word_per_22_cycles_each_way() -> None:
    network = Network([processor(both_ways(0, 40)), processor(both_ways(3, 40))])
    link = network.join(0, 0, 1, 3)
    network.run(700 * PERIOD)
    for side in (0, 1):
        ends = [event["time"] for event in link.events if event["kind"] == "word" and event["side"] == side]
        gaps = [(b - a) // PERIOD for a, b in itertools.pairwise(ends)]
        assert len(gaps) > 20 and set(gaps[1:]) == {22}
    sides = [event["side"] for event in link.events if event["kind"] == "word"]
    assert all(a != b for a, b in itertools.pairwise(sides))
    network.balance()


def test_a_request_in_the_last_byte_waits_for_one_word_more() -> None:
    """The peer's store is seen at t + 1; the first word of the stream is on the link in cycles 1 to 6 after the first
    store."""
    for delay, before_token in ((4, 1), (5, 2)):
        network = Network(
            [processor("        nop\n" * 8 + stores(0, 3)), processor("        nop\n" * (8 + delay) + stores(3, 1))]
        )
        link = network.join(0, 0, 1, 3)
        network.run(200 * PERIOD)
        kinds = [event["kind"] for event in link.events]
        assert kinds.index("token") == before_token, delay


def test_order_of_turns_changes_nothing() -> None:
    results = []
    for seed in range(6):
        order = list(range(4))
        random.Random(seed).shuffle(order)
        ring = [
            processor(
                base(n % 3, "ar0") + base(3 + n % 3, "ar2") + RELAY.replace("FIRST", "seed" if n == 0 else "loop")
            )
            for n in range(4)
        ]
        network = Network(ring, hertz=[20_000_000, 25_000_000, 30_000_000, 20_000_000], order=order)
        for n in range(4):
            network.join(n, n % 3, (n + 1) % 4, 3 + (n + 1) % 4 % 3)
        network.run(3000 * PERIOD)
        network.balance()
        results.append(([chip.cycle for chip in ring], [chip.causes for chip in ring], [link.events for link in network.links],
                        [chip.port(n) for chip in ring for n in range(6)], sorted(network.log)))  # fmt: skip
    assert all(result == results[0] for result in results)
    assert len([event for event in results[0][2][0] if event["kind"] == "word"]) > 20


def test_two_clocks_stream_at_the_senders_rate() -> None:
    for fast_sender in (True, False):
        hertz = [30_000_000, 20_000_000] if fast_sender else [20_000_000, 30_000_000]
        network = Network([processor(sender(0, 40)), processor(STOP)], hertz=hertz)
        link = network.join(0, 0, 1, 3)
        network.run(8 * 5 * 10**12 // hertz[0] + 30 * 10**12 // hertz[0])
        ends = [event["time"] for event in link.events if event["kind"] == "word"]
        assert len(ends) == 8  # the peer's FIFO
        ticks = [round(time * hertz[0] / 10**12) for time in ends]
        assert {b - a for a, b in itertools.pairwise(ticks)} == {5}
        assert all(time == tick * 10**12 // hertz[0] for time, tick in zip(ends, ticks, strict=True))


def test_links_that_cannot_be_are_refused() -> None:
    a, b = processor(STOP), processor(STOP)
    with pytest.raises(ValueError, match="itself"):
        c40.Link((a, 0), (a, 0))
    with pytest.raises(ValueError, match="both begin with the token"):
        c40.Link((a, 0), (b, 2))
    with pytest.raises(ValueError, match="both begin without the token"):
        c40.Link((a, 3), (b, 5))
    with pytest.raises(ValueError, match="factor of 2"):
        c40.Link((a, 0), (b, 3), (30_000_000, 1), (14_000_000, 1))
    with pytest.raises(ValueError, match="no communication port 6"):
        c40.Link((a, 6), (b, 3))
    link = c40.Link((a, 0), (b, 3))
    with pytest.raises(ValueError, match="is already attached"):
        c40.Link((a, 0), (b, 4))
    del link


def test_a_link_that_is_gone_has_left_its_ports() -> None:
    """Its processors run as if nothing had ever been attached, and may be linked again."""
    a, b = processor(stores(0, 9)), processor(receiver(3, 1))
    link = c40.Link((a, 0), (b, 3))
    del link
    for chip, port, write in ((a, 0, True), (b, 3, False)):
        stop = chip.run(1000)
        assert (stop["reason"], stop["port"], stop["write"]) == ("port_wait", port, write)
    again = c40.Link((a, 0), (b, 3))
    assert again.counters(0)["sent"] == 0


def test_two_ports_of_one_chip_may_be_linked() -> None:
    chip = processor(
        base(0) + base(3, "ar2") + "        ldi 55,r0\n        sti r0,*+ar0(2)\n        ldi *+ar2(1),r1\n" + STOP
    )
    network = Network([chip])
    network.join(0, 0, 0, 3)
    network.run(100 * PERIOD)
    assert chip.get("R1") & 0xFFFFFFFF == 55
    network.balance()


@pytest.mark.parametrize("cycles_into_word", [0, 1, 2, 3, 4])
def test_a_link_cut_in_mid_word_loses_that_word_and_says_so(cycles_into_word: int) -> None:
    network = Network([processor(sender(0, 6)), processor(receiver(3, 6))])
    link = network.join(0, 0, 1, 3)
    network.run(20 * PERIOD)
    word_ends = [event["time"] for event in link.events if event["kind"] == "word"]
    start = word_ends[-1]  # the next word begins at once
    lost_word = len(word_ends) + 1
    network.run(start + cycles_into_word * PERIOD)
    link.cut(start + cycles_into_word * PERIOD)
    lost = [event for event in link.events if event["kind"] == "lost"]
    assert [(event["word"], event["bytes"]) for event in lost] == [(lost_word, cycles_into_word * 4 // 5)]
    network.run(start + 100 * PERIOD)
    network.balance()
    assert network.waiting[1]["port"] == 3  # waits for a word that never comes
    link.restore(start + 100 * PERIOD)
    network.run(start + 300 * PERIOD)
    network.balance()
    expected = [word for word in range(1, 7) if word != lost_word]
    assert [network.chips[1].peek(DATA + i) for i in range(5)] == expected


def test_a_cut_token_exchange_leaves_the_token_where_it_was() -> None:
    network = Network([processor(STOP), processor(stores(3, 1))])
    link = network.join(0, 0, 1, 3)
    network.run(10 * PERIOD)
    link.cut(10 * PERIOD)
    network.run(100 * PERIOD)
    assert network.chips[0].port(0)["token"] and not network.chips[1].port(3)["token"]
    assert len(network.chips[1].port(3)["output"]) == 1
    link.restore(100 * PERIOD)
    network.run(113 * PERIOD)
    assert network.chips[0].port(0)["input"] == [7]


def test_reset_of_one_side_that_borrowed_the_token_kills_the_link_until_the_other_is_reset() -> None:
    network = Network([processor(STOP), processor(stores(3, 1))])
    link = network.join(0, 0, 1, 3)
    network.run(60 * PERIOD)
    assert network.chips[1].port(3)["token"] and network.chips[0].port(0)["input"] == [7]
    network.chips[1].reset()
    assert link.is_dead
    assert link.events[-1]["kind"] == "dead"
    network.chips[0].reset()
    assert not link.is_dead
    assert network.chips[0].port(0)["discarded_input"] == 1
    network.balance()


def test_reset_of_the_receiver_in_mid_word_loses_the_word() -> None:
    network = Network([processor(stores(0, 3)), processor(STOP)])
    link = network.join(0, 0, 1, 3)
    while not [event for event in link.events if event["kind"] == "word"]:
        network.run(network.chips[1].cycle * PERIOD + PERIOD)
    now = network.chips[1].cycle
    network.run((now + 3) * PERIOD)
    network.chips[1].reset()
    assert [event["kind"] for event in link.events].count("lost") >= 1
    network.balance()
    assert not link.is_dead


def test_a_halted_input_channel_holds_the_neighbour_off_and_can_still_be_read() -> None:
    halting = base(3) + "        ldi 8,r0\n        sti r0,*ar0\n" + STOP
    network = Network([processor("        nop\n" * 20 + stores(0, 12)), processor(halting)])
    network.join(0, 0, 1, 3)
    network.run(200 * PERIOD)
    assert network.chips[1].port(3)["input"] == []
    assert len(network.chips[0].port(0)["output"]) == 8
    network.balance()


def test_a_halted_output_channel_keeps_its_words_and_gives_the_token_away() -> None:
    halted = base(0) + "        ldi 10h,r0\n        sti r0,*ar0\n        sti r0,*+ar0(2)\n" + STOP
    network = Network([processor(halted), processor("        nop\n" * 20 + stores(3, 2))])
    network.join(0, 0, 1, 3)
    network.run(200 * PERIOD)
    assert network.chips[0].port(0)["output"] == [0x10]
    assert network.chips[0].port(0)["input"] == [7, 7]
    network.balance()


INTERRUPTED = """
        ldhi 2fh,ar1
        or 0fa00h,ar1
        ldpe ar1,ivtp
        ldi 1,r1
        lsh SOURCE,r1
        ldi r1,iie
        or 2000h,st
end:    idle
        bu end
isr:    ldi *+ar0(1),r0
        addi 1,r2
        reti
"""


def interrupt_chip(port: int, source: int, vector: int) -> Any:
    from cmrc._core import toolchain

    text = "        .text\n" + base(port) + INTERRUPTED.replace("SOURCE", str(1 + 4 * port + source))
    image = toolchain.assemble(text, "test.asm", sections={".text": 0x2FFC00})
    chip = c40.Processor("default")
    chip.load_image(image)
    chip.set("SP", 0x2FFB00)
    chip.poke(0x2FFA00 + vector, image.symbols["isr"])
    return chip


@pytest.mark.parametrize("port", range(6))
def test_icrdy_wakes_the_chip_at_its_own_vector(port: int) -> None:
    chip = interrupt_chip(port, 1, 0x0E + 4 * port)
    chip.run(200)
    assert chip.idle
    chip.deliver(port, 99)
    chip.run(50)
    assert (chip.get("R0") & 0xFFFFFFFF, chip.get("R2") & 0xFFFFFFFF) == (99, 1)


def test_ocrdy_is_true_after_reset_and_interrupts_at_once() -> None:
    chip = interrupt_chip(1, 2, 0x0F + 4)
    chip.deliver(1, 1)
    chip.run(60)
    assert chip.get("R2") & 0xFFFFFFFF >= 1


def test_icfull_needs_eight_words() -> None:
    chip = interrupt_chip(2, 0, 0x0D + 8)
    for word in range(7):
        chip.deliver(2, word)
    chip.run(100)
    assert chip.get("R2") & 0xFFFFFFFF == 0
    chip.deliver(2, 7)
    chip.run(100)
    assert chip.get("R2") & 0xFFFFFFFF == 1  # the read made room


def test_enabling_a_linked_ports_interrupt_ends_the_run_for_a_new_horizon() -> None:
    chip, other = interrupt_chip(0, 1, 0x0E), processor(STOP)
    link = c40.Link((chip, 0), (other, 3))
    stop = chip.run(1000)
    assert stop["reason"] == "horizon" and chip.watches_ports
    assert chip.run(100)["reason"] == "limit"
    assert link.lookahead >= 5 * PERIOD


def test_ways_of_execution_agree() -> None:
    """Block by block, and one instruction at a time."""
    found = []
    for exact in (False, True):
        network = Network([processor(both_ways(0, 30)), processor(both_ways(3, 30))])
        for chip in network.chips:
            chip.set_exact(exact)
        network.join(0, 0, 1, 3)
        network.run(900 * PERIOD)
        found.append((network.log, [chip.causes for chip in network.chips], [chip.cycle for chip in network.chips]))
    assert found[0] == found[1]
