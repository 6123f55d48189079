"""Bridges between buses: posting, delayed reads, the ordering of PCI 2.1, and no deadlock."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field

import pytest
from cmrc_test import bus_model as pci

SIZE = 0x100


def chain(count: int, **fields: int) -> tuple[pci.Buses, list[pci.Memory]]:
    """Buses in a row, each with a memory of SIZE words at bus * 1000h, and all bridges' windows."""
    buses = pci.Buses(count)
    config = pci.BusBridgeConfig()
    for name, value in fields.items():
        setattr(config, name, value)
    memories = [buses[i].add_memory(pci.TargetConfig.sram(), i * 0x1000, SIZE) for i in range(count)]
    for i in range(count - 1):
        buses.join(i, i + 1, config)
    for i in range(count - 1):
        for j in range(count):
            buses.claim(i, i if j > i else i + 1, j * 0x1000, SIZE)
    return buses, memories


def agent(number: int) -> pci.MasterConfig:
    config = pci.MasterConfig()
    config.agent = number
    return config


@dataclass
class Processor:
    """Makes one access after the other. `think` chooses each from the answer of the last one: (write?, address,
    words)."""

    bus: int
    master: int
    think: Callable[[list[int]], tuple[bool, int, list[int] | int] | None]
    done: int = 0
    reads: list[list[int]] = field(default_factory=list)


def play(buses: pci.Buses, processors: list[Processor], limit: int = 400_000) -> None:
    """Lets all of them run until none has anything left to do."""

    def go(p: Processor, clock: int, answer: list[int]) -> None:
        access = p.think(answer)
        if access is None:
            return
        write, address, words = access
        if write:
            assert isinstance(words, list)
            buses[p.bus].write(p.master, address, words, clock)
        else:
            assert isinstance(words, int)
            buses[p.bus].read(p.master, address, words, clock)

    by_place = {(p.bus, p.master): p for p in processors}
    for p in processors:
        go(p, 0, [])
    for _ in range(limit):
        if buses.next_event() is None:
            return
        for bus, ended in buses.step():
            p = by_place.get((bus, ended.master))
            if p is None:
                continue
            assert ended.result == pci.Result.done
            p.done += 1
            if not ended.write:
                p.reads.append(ended.words)
            go(p, ended.ended + 1, [] if ended.write else ended.words)
    raise AssertionError("still busy: locked up?")


def test_a_read_and_a_write_across_by_hand() -> None:
    """Devsel 2, SRAM 3 wait states (read) and 1 (write), 3 clocks through the bridge."""
    buses, memories = chain(2)
    buses[0].add_master(agent(7))
    buses[0].write(2, 0x1005, [55], 0)  # master 2: after the bridge's two
    while not buses.deliveries:
        buses.step()
    # FRAME# 2 (not parked), data 4 (devsel 2, no wait), accepted 5; REQ# 8, FRAME# 8 (parked on master 0), data 11
    assert buses.deliveries == [(7, 0x1005, 55, 12)] and memories[1][5] == 55
    while buses.next_event() is not None:
        buses.step()
    start = buses[1].now() + 50
    buses[0].read(2, 0x1005, 1, start)
    ended = []
    while not ended:
        ended = [e for bus, e in buses.step() if bus == 0 and e.master == 2]
    assert ended[0].words == [55] and ended[0].retries >= 1
    (fetch,) = [a for a in buses[1].attempts if not a.write]
    # FRAME# asks the bridge; 3 clocks; another 2, the grant being parked with the writes; address, devsel 2, 3 waits,
    # data
    assert fetch.frame == start + 3 + 2 and fetch.last == fetch.frame + 5
    assert ended[0].first_data > fetch.last


def test_what_a_read_fetches_goes_by_its_command() -> None:
    for words, fetched in ((1, [1]), (4, [8]), (8, [8]), (30, [16, 16])):
        buses, _ = chain(2)
        buses[0].add_master(agent(1))
        plan: list[tuple[bool, int, int] | None] = [(False, 0x1000, words), None]
        play(buses, [Processor(0, 2, lambda _, plan=plan: plan.pop(0))])  # type: ignore[misc]
        assert [a.words for a in buses[1].attempts] == fetched, words


def test_posted_words_combine_and_a_full_bridge_refuses() -> None:
    buses, memories = chain(2, post_depth=8)
    buses[0].add_master(agent(1))
    plan: list[tuple[bool, int, list[int]] | None] = [(True, 0x1000, list(range(100, 140))), None]
    play(buses, [Processor(0, 2, lambda _: plan.pop(0))])
    assert [memories[1][i] for i in range(40)] == list(range(100, 140))
    near = [a for a in buses[0].attempts]
    assert sum(a.words for a in near) == 40 and max(a.words for a in near) == 8
    assert any(a.kind == pci.AttemptKind.retry for a in near)
    assert max(a.words for a in buses[1].attempts) == 8


@pytest.mark.parametrize(
    "count, depth, delayed, seed", [(2, 32, 4, 1), (3, 2, 1, 2), (4, 1, 1, 3), (4, 4, 2, 4), (4, 1, 1, 5)]
)
def test_nothing_is_lost_doubled_reordered_or_locked_up(count: int, depth: int, delayed: int, seed: int) -> None:
    """Two agents on each bus write and read everywhere; each reads its own words as it last wrote them."""
    draw = random.Random(seed)
    buses, _ = chain(count, post_depth=depth, delayed_reads=delayed)
    processors, written = [], {}
    for number in range(2 * count):
        bus = number // 2
        master = buses[bus].add_master(agent(number))
        last: dict[int, int] = {}
        expect: list[int] = []
        left = [250]
        written[number] = log = []

        def think(answer: list[int], last=last, expect=expect, left=left, log=log, number=number):  # type: ignore[no-untyped-def]
            if expect:
                assert answer == [expect.pop()]
            left[0] -= 1
            if left[0] < 0:
                return None
            address = draw.randrange(count) * 0x1000 + draw.randrange(SIZE // 16) * 16 + number
            if draw.random() < 0.6:
                last[address] = draw.randrange(1 << 32)
                log.append((address, last[address]))
                return True, address, [last[address]]
            expect.append(last.get(address, 0))
            return False, address, 1

        processors.append(Processor(bus, master, think))
    play(buses, processors)
    assert all(p.done == 250 for p in processors)
    for number, log in written.items():
        far = [(a, v) for a, v in log if a >> 12 != number // 2]
        # Delivered word by word, in order for each path: with two hops each bridge reports a word.
        for bus in range(count):
            sent = [(a, v) for a, v in far if a >> 12 == bus]
            hops = abs(bus - number // 2)
            delivered = [(a, v) for bridge, a, v, _ in buses.deliveries if bridge == number and a >> 12 == bus]
            assert len(delivered) == hops * len(sent)
            if hops == 1:
                assert delivered == sent
    for i in range(count):
        assert buses[i].audit(buses[i].now()) == []


@pytest.mark.parametrize("seed", range(4))
def test_a_flag_never_arrives_before_its_data(seed: int) -> None:
    """The producer on bus C posts data to a memory on A, then sets a flag on its own bus C; the consumer on A reads the
    flag across two bridges, and then the data beside it: PCI's ordering makes them new."""
    draw = random.Random(seed)
    buses, _ = chain(3, post_depth=draw.choice([4, 16]))
    producer_master = buses[2].add_master(agent(1))
    consumer_master = buses[0].add_master(agent(2))
    rounds = 40
    produced = []
    for number in range(1, rounds + 1):
        produced += [(True, 0x0010 + i, [1000 * number + i]) for i in draw.sample(range(5), 5)]
        produced += [(True, 0x2000, [number])]
        produced += [(False, 0x2000, 1)] * draw.randrange(60)  # time goes by
    produced.append(None)
    seen = []
    state = {"wait": True}

    def consume(answer: list[int]):  # type: ignore[no-untyped-def]
        if state["wait"]:
            if answer and answer[0] > len(seen) and answer[0] > (seen[-1][0] if seen else 0):
                state["wait"] = False
                state["flag"] = answer[0]
                return False, 0x0010, 5
            return (False, 0x2000, 1) if not answer or answer[0] < rounds else None
        seen.append((state["flag"], answer))
        state["wait"] = True
        return (False, 0x2000, 1) if state["flag"] < rounds else None

    play(buses, [Processor(2, producer_master, lambda _: produced.pop(0)), Processor(0, consumer_master, consume)])
    assert len(seen) > 5
    for flag, data in seen:
        assert all(word >= 1000 * flag + i for i, word in enumerate(data)), (flag, data)


@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize("words", [1, 8])
def test_an_agent_that_starts_again_is_given_no_words_that_were_read_before(count: int, words: int) -> None:
    """It leaves its bus at any clock of a read over one bridge or two, and soon makes the same read again."""
    address = (count - 1) * 0x1000
    for leaves in range(1, 100):
        buses, memories = chain(count)
        master = buses[0].add_master(agent(7))
        buses[0].read(master, address, words, 0)
        ended = []
        while (event := buses.next_event()) is not None and event <= leaves:
            ended += buses.step()
        if any((bus, read.master) == (0, master) for bus, read in ended):
            break  # the read has its answer
        buses[0].withdraw(master, leaves)
        buses.forget(7)
        for i in range(SIZE):
            memories[-1][i] = 1000 + i
        buses[0].read(master, address, words, leaves + 5)
        ended = []
        while buses.next_event() is not None:
            ended += [read.words for bus, read in buses.step() if (bus, read.master) == (0, master)]
        assert ended == [list(range(1000, 1000 + words))], leaves
        assert all(buses[i].audit(buses[i].now()) == [] for i in range(count))
    else:
        raise AssertionError("no read had its answer")
    assert leaves > 10


def test_impossible_bridges_are_refused() -> None:
    buses = pci.Buses(2)
    config = pci.BusBridgeConfig()
    config.post_depth = 0
    with pytest.raises(ValueError, match="post_depth is 1 to 256"):
        buses.join(0, 1, config)
    with pytest.raises(ValueError, match="joins two buses"):
        buses.join(0, 0)
