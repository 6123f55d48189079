"""The bridge between a processor and PCI: posting, combining, ordering, reading ahead (ruling 25)."""

import random

import pytest
from cmrc_test import bus_model as pci

LINE_LIMIT = 0x1000


def make(prefetch: int = 8, depth: int = 8, bridges: int = 1) -> tuple[pci.Bus, list[pci.Bridge], pci.Memory]:
    """A bus with bridges, a memory at 0 (of which reads may be fetched ahead) and one at 1000h (registers)."""
    bus = pci.Bus()
    config = pci.BridgeConfig()
    config.prefetch_words, config.prefetch_limit, config.post_depth = prefetch, LINE_LIMIT, depth
    made = [bus.add_bridge(pci.MasterConfig(), config) for _ in range(bridges)]
    memory = bus.add_memory(pci.TargetConfig.sram(), 0, LINE_LIMIT)
    bus.add_memory(pci.TargetConfig.sram(), LINE_LIMIT, 0x100)
    return bus, made, memory


def finish_read(bus: pci.Bus, bridge: pci.Bridge) -> tuple[int, int, int]:
    """Runs the bus until the processor has its word: (value, ready, arbitration)."""
    while (answer := bridge.take_answer()) is None:
        event = bus.next_event()
        assert event is not None
        bus.advance_to(event)
    value, ready, arbitration, result = answer
    assert result == pci.Result.done
    return value, ready, arbitration


def test_rising_addresses_combine_into_one_burst_and_others_do_not() -> None:
    bus, (bridge,), memory = make()
    for i, address in enumerate([10, 11, 12, 20, 19, 18]):
        bridge.write(address, 100 + i, 1 if i < 3 else 2)
    bus.advance_to(200)
    assert [(a.address, a.words) for a in bus.attempts] == [(10, 3), (20, 1), (19, 1), (18, 1)]
    assert [landing[:2] for landing in bridge.landings] == [
        (10, 100),
        (11, 101),
        (12, 102),
        (20, 103),
        (19, 104),
        (18, 105),
    ]
    assert [memory[a] for a in (10, 11, 12, 20, 19, 18)] == list(range(100, 106))


def test_a_word_is_not_taken_before_its_time() -> None:
    bus, (bridge,), _ = make()
    bridge.write(0, 1, 0)
    bridge.write(1, 2, 50)
    bus.advance_to(200)
    assert [(a.address, a.frame >= least) for a, least in zip(bus.attempts, (2, 52), strict=True)] == [
        (0, True),
        (1, True),
    ]


@pytest.mark.parametrize(("clock", "bursts"), [(-1, [(0, 2)]), (0, [(0, 1), (1, 1)])])
def test_a_word_of_the_clock_of_the_frame_is_left_for_later(clock: int, bursts: list[tuple[int, int]]) -> None:
    bus, (bridge,), _ = make()
    bridge.write(0, 1, 0)
    bus.advance_to(20)
    frame = bus.attempts[0].frame
    bus, (bridge,), _ = make()
    bridge.write(0, 1, 0)
    bridge.write(1, 2, frame + clock)
    bus.advance_to(100)
    assert bus.attempts[0].frame == frame
    assert [(a.address, a.words) for a in bus.attempts] == bursts


def test_a_full_fifo_holds_the_processor_until_words_have_left() -> None:
    bus, (bridge,), memory = make(depth=4)
    for i in range(4):
        bridge.write(2 * i, i + 1, 0)
    assert not bridge.has_room()
    bridge.write(8, 5, 0)
    assert bridge.blocked
    bus.advance_to(200)
    room = bridge.take_room()
    assert room == bridge.landings[0][2]
    assert [memory[2 * i] for i in range(5)] == [1, 2, 3, 4, 5]


def test_a_read_sees_every_write_before_it() -> None:
    bus, (bridge,), memory = make()
    for i in range(8):
        bridge.write(3 * i, 1000 + i, 0)
    bridge.read(21, 0)
    value, ready, arbitration = finish_read(bus, bridge)
    assert value == 1007
    assert len(bridge.landings) == 8 and ready > bridge.landings[-1][2]
    assert 0 <= arbitration <= ready
    assert memory[21] == 1007


def test_the_cost_of_a_read_by_hand() -> None:
    """2 clocks in, grant parked, address, devsel 2, 3 wait states, data, 2 clocks back; the line continues word by
    word."""
    bus, (bridge,), memory = make()
    for i in range(16):
        memory[i] = i * i
    bridge.read(2, 10)
    value, ready, arbitration = finish_read(bus, bridge)
    assert (value, ready, arbitration) == (4, 10 + 2 + 1 + 2 + 3 + 2, 0)
    assert [bridge.look_up(a) for a in (1, 2, 3, 7, 8)] == [None, (4, 20), (9, 21), (49, 25), None]
    bus.advance_to(100)
    assert [a.words for a in bus.attempts] == [6]


def test_words_of_a_slow_target_come_at_its_pace() -> None:
    """Each further word takes two clocks more: read_step wait states and its own."""
    bus = pci.Bus()
    config = pci.BridgeConfig()
    config.prefetch_words, config.prefetch_limit = 4, LINE_LIMIT
    bridge = bus.add_bridge(pci.MasterConfig(), config)
    slow = pci.TargetConfig.sram()
    slow.read_step = 2
    memory = bus.add_memory(slow, 0, LINE_LIMIT)
    for i in range(4):
        memory[i] = 7 * i
    bridge.read(0, 10)
    _, ready, _ = finish_read(bus, bridge)
    assert [bridge.look_up(a) for a in range(5)] == [(0, ready), (7, ready + 3), (14, ready + 6), (21, ready + 9), None]


def test_the_line_goes_with_a_write_and_with_a_register_read() -> None:
    for drop, register in (("write", 0), ("register", 0), ("register", 3)):
        bus, (bridge,), _ = make()
        bridge.read(0, 0)
        finish_read(bus, bridge)
        bus.advance_to(50)
        assert bridge.look_up(5) is not None
        if drop == "write":
            bridge.write(500, 1, 50)
        else:
            bridge.read(LINE_LIMIT + register, 50)
            assert finish_read(bus, bridge)[1] == 50 + 10
        assert bridge.look_up(5) is None


def test_registers_are_read_one_by_one() -> None:
    bus, (bridge,), _ = make()
    bridge.read(LINE_LIMIT, 0)
    finish_read(bus, bridge)
    bus.advance_to(50)
    assert [a.words for a in bus.attempts] == [1]


def test_waiting_for_the_bus_is_arbitration_and_the_rest_transfer() -> None:
    bus, (first, second), _ = make(bridges=2)
    for i in range(8):
        first.write(i, 0, 0)
    second.read(100, 3)
    _, ready, arbitration = finish_read(bus, second)
    frame = [a.frame for a in bus.attempts if a.master == 1] or [ready - 2 - 1 - 5]
    assert arbitration == frame[0] - (3 + 2)
    assert arbitration > 0


@pytest.mark.parametrize("seed", range(5))
def test_two_processors_with_random_traffic_stay_coherent_with_themselves(seed: int) -> None:
    """Each processor owns every other word: what it reads there is always what it wrote last."""
    draw = random.Random(seed)
    bus, bridges, _ = make(bridges=2, prefetch=8, depth=draw.choice([1, 2, 8]))
    last: dict[int, int] = {}
    clock = [0, 0]
    for _ in range(1500):
        which = 0 if clock[0] <= clock[1] else 1
        bridge = bridges[which]
        bus.advance_to(max(bus.now(), clock[which]))
        address = draw.randrange(40) * 2 + which
        if draw.random() < 0.6:
            bridge.write(address, value := draw.randrange(1 << 32), clock[which])
            last[address] = value
            while bridge.blocked:
                bus.advance_to(bus.next_event())
            room = bridge.take_room()
            clock[which] = max(clock[which], room if room is not None else 0) + draw.randrange(1, 6)
            continue
        hit = bridge.look_up(address)
        if hit is None:
            bridge.read(address, clock[which])
            value, ready, _ = finish_read(bus, bridge)
        else:
            value, ready = hit
        assert value == last.get(address, 0)
        clock[which] = max(clock[which], ready) + draw.randrange(1, 6)
    assert len(last) > 60


def test_clearing_drops_what_is_posted() -> None:
    bus, (bridge,), memory = make()
    bridge.write(0, 1, 0)
    bridge.write(50, 2, 0)
    bus.advance_to(9)
    bridge.clear(9)
    bus.advance_to(100)
    assert (memory[0], memory[50]) == (1, 0) and bridge.posted == 0
    bridge.write(7, 9, 100)
    bus.advance_to(200)
    assert memory[7] == 9


def test_of_a_burst_that_is_cleared_only_the_words_that_moved_have_landed() -> None:
    whole, (bridge,), _ = make()
    for i in range(8):
        bridge.write(i, 1 + i, 0)
    whole.advance_to(200)
    last = whole.attempts[0].last
    bus, (bridge,), memory = make()
    for i in range(8):
        bridge.write(i, 1 + i, 0)
    bus.advance_to(last - 2)
    bridge.clear(last - 2)
    bus.advance_to(200)
    there = [i for i in range(8) if memory[i] != 0]
    assert 0 < len(there) < 8 and [landing[:2] for landing in bridge.landings] == [(i, 1 + i) for i in there]


def test_clearing_forgets_the_words_that_were_read_ahead() -> None:
    """Another master may have written there since: the processor that is reset reads again."""
    bus, (bridge,), memory = make()
    bridge.read(0, 0)
    assert finish_read(bus, bridge)[0] == 0
    assert bridge.look_up(1) is not None
    bus.advance_to(60)
    bridge.clear(60)
    memory[1] = 7
    assert bridge.look_up(1) is None
    bridge.read(1, 60)
    assert finish_read(bus, bridge)[0] == 7


def test_impossible_bridges_are_refused() -> None:
    bus = pci.Bus()
    config = pci.BridgeConfig()
    config.prefetch_words = 6
    with pytest.raises(ValueError, match="power of two"):
        bus.add_bridge(pci.MasterConfig(), config)
    config = pci.BridgeConfig()
    master = pci.MasterConfig()
    master.latency_timer = 16
    with pytest.raises(ValueError, match="latency_timer"):
        bus.add_bridge(master, config)
