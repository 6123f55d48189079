"""Arbiters, parking, timers and bursts: random traffic against a second bus that steps clock by clock, and tables
counted by hand from plant-and-bus.md 3.1."""

import random

import pytest
from bus_model.clocked_pci import Board, Job, Master, Timing
from bus_model.clocked_pci import Bus as ClockedBus
from cmrc_test import bus_model as pci

RULES = ["round_robin", "fixed", "two_level", "host_fair"]
TARGETS = [
    Timing(2, (3, 0), (1, 0)),
    Timing(1, (8, 1), (2, 1), 4),
    Timing(3, (0, 0), (0, 2)),
    Timing(2, (6, 0), (2, 0), 8),
]


def event_driven(board: Board, jobs: list[list[Job]], clocks: int) -> tuple[pci.Bus, list[tuple[int, int, int, int]]]:
    """When each master of the event-driven model holds the bus, under the same traffic."""
    config = pci.BusConfig()
    config.arbitration = getattr(pci.Arbitration, board.rule)
    config.parking = getattr(pci.Parking, board.parking)
    config.grant_clocks = board.grant
    config.multi_transaction_timer = board.keep
    config.host_bridge = board.host_bridge
    bus = pci.Bus(config)
    for timer, first, burst in zip(board.timer, board.first_level, board.max_burst, strict=True):
        master = pci.MasterConfig()
        master.latency_timer, master.first_level, master.max_burst = timer, first, burst
        bus.add_master(master)
    for i, timing in enumerate(board.targets):
        target = pci.TargetConfig()
        target.devsel, target.max_burst = timing.devsel, timing.disconnect
        target.read_initial, target.read_step = timing.read
        target.write_initial, target.write_step = timing.write
        bus.add_memory(target, i * 0x1000, 0x1000)
    left = [list(own) for own in jobs]

    def submit(master: int, clock: int) -> None:
        if left[master]:
            job = left[master].pop(0)
            address, when = job.target * 0x1000, clock + job.gap
            bus.write(master, address, [1] * job.words, when) if job.write else bus.read(
                master, address, job.words, when
            )

    for master in range(len(jobs)):
        submit(master, 0)
    while (event := bus.next_event()) is not None and event <= clocks:
        for ended in bus.advance_to(event):
            submit(ended.master, ended.ended)
    return bus, [(a.master, a.frame, a.words, a.last) for a in bus.attempts]


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("seed", range(6))
def test_random_traffic_as_on_a_bus_that_steps_clock_by_clock(rule: str, seed: int) -> None:
    draw = random.Random(f"{rule} {seed}")
    masters = draw.randrange(2, 7)
    board = Board(
        rule,
        draw.choice(["none", "last_owner", "first"]),
        draw.choice([1, 2, 4]),
        draw.choice([0, 0, 24, 64]),
        [draw.choice([8, 16, 32]) for _ in range(masters)],
        [draw.random() < 0.4 for _ in range(masters)],
        [draw.choice([0, 0, 6]) for _ in range(masters)],
        TARGETS,
        host_bridge=draw.random() < 0.6,
    )
    busy = draw.choice([3, 30, 200])  # gaps, from a crowded bus to a mostly idle one
    jobs = [
        [
            Job(draw.randrange(busy), draw.random() < 0.5, draw.randrange(4), draw.choice([1, 1, 2, 5, 12, 40]))
            for _ in range(120)
        ]
        for _ in range(masters)
    ]
    clocks = 8000
    reference = ClockedBus(board, [Master(list(own)) for own in jobs]).run(clocks)
    _, seen = event_driven(board, jobs, clocks)
    expected = [(s.master, s.frame, s.words, s.last) for s in reference]
    assert len(expected) > 80
    assert seen[: len(expected)] == expected


def crowd(rule: pci.Arbitration, first_level: list[bool], turns: int, **bus_fields: object) -> list[int]:
    """The order of owners when every master asks again at once, for one word each."""
    board = pci.BusConfig()
    board.arbitration = rule
    for name, value in bus_fields.items():
        setattr(board, name, value)
    bus = pci.Bus(board)
    for high in first_level:
        master = pci.MasterConfig()
        master.first_level = high
        bus.add_master(master)
    bus.add_memory(pci.TargetConfig.sram(), 0, 0x1000)
    for master in range(len(first_level)):
        bus.read(master, 0, 1, 0)
    while len(bus.attempts) < turns:
        for ended in bus.advance_to(bus.next_event()):
            bus.read(ended.master, 0, 1, ended.ended)
    return [a.master for a in bus.attempts]


def test_which_master_is_served_when_all_ask() -> None:
    plain = [False] * 4
    assert crowd(pci.Arbitration.round_robin, plain, 9) == [0, 1, 2, 3, 0, 1, 2, 3, 0]
    # A master that has just ended asks one clock later: the fixed order falls to the next one in between.
    assert set(crowd(pci.Arbitration.fixed, plain, 9)) == {0, 1}
    assert crowd(pci.Arbitration.host_fair, plain, 9) == [0, 1, 0, 2, 0, 3, 0, 1, 0]
    assert crowd(pci.Arbitration.host_fair, plain, 9, host_bridge=False) == [0, 1, 2, 3, 0, 1, 2, 3, 0]
    assert crowd(pci.Arbitration.two_level, [True, True, False, False], 9) == [0, 1, 2, 0, 1, 3, 0, 1, 2]


def test_the_multi_transaction_timer_keeps_an_owner_that_asks_in_time() -> None:
    def owners(keep: int) -> list[int]:
        config = pci.BusConfig()
        config.multi_transaction_timer = keep
        bus = pci.Bus(config)
        target = pci.TargetConfig()
        target.write_initial = 0
        bus.add_memory(target, 0, 0x1000)
        for _ in range(2):
            master = pci.MasterConfig()
            master.max_burst = 4
            bus.add_master(master)
        bus.write(0, 0, [0] * 32, 0)
        bus.write(1, 0, [0] * 32, 0)
        bus.advance_to(1000)
        return [a.master for a in bus.attempts]

    # A burst of 4 takes 7 clocks, its last data phase is clock 5: the sixth burst's comes when 40 clocks are over.
    assert owners(0) == [0, 1] * 8
    assert owners(40) == [0] * 6 + [1] * 6 + [0] * 2 + [1] * 2


def test_bursts_of_a_master_end_at_its_own_limit() -> None:
    bus = pci.Bus()
    master = pci.MasterConfig()
    master.max_burst = 16
    bus.add_master(master)
    bus.add_memory(pci.TargetConfig.sram(), 0, 0x1000)
    bus.read(0, 0, 40, 0)
    (ended,) = bus.advance_to(500)
    assert [a.words for a in bus.attempts] == [16, 16, 8] and ended.disconnects == 0 and ended.count == 40


def test_commands_follow_the_cache_lines() -> None:
    bus = pci.Bus()
    bus.add_master()
    bus.add_memory(pci.TargetConfig.sram(), 0, 0x1000)
    seen = []
    for address, words in ((0, 1), (7, 2), (0, 3), (2, 6), (2, 7), (0, 64)):
        bus.read(0, address, words, bus.now())
        seen += [t.command for t in bus.advance_to(bus.now() + 300)]
    read = pci.Command
    assert seen == [read.read, read.read, read.read_line, read.read_line, read.read_multiple, read.read_multiple]


@pytest.mark.parametrize("command, words", [(pci.Command.write, [15, 49]), (pci.Command.write_invalidate, [16, 48])])
def test_memory_write_invalidate_continues_to_the_end_of_its_line(command: pci.Command, words: list[int]) -> None:
    bus = pci.Bus()
    master = pci.MasterConfig()
    master.latency_timer = 16
    bus.add_master(master)
    bus.add_master()
    target = pci.TargetConfig()
    target.write_initial = target.read_initial = 0
    bus.add_memory(target, 0, 0x1000)
    bus.write(0, 0, [1] * 64, 0, command)
    bus.read(1, 0, 1, 5)
    bus.advance_to(500)
    assert [a.words for a in bus.attempts if a.master == 0] == words


def test_a_delayed_read_brings_what_its_command_says() -> None:
    """Memory Read brings one word, Read Line four, Read Multiple eight; the master asks again for the rest."""
    for words, stays in ((1, [1]), (5, [4, 1]), (20, [8, 8, 4])):
        bus = pci.Bus()
        bus.add_master()
        target = pci.TargetConfig()
        target.delayed_read, target.fetch, target.prefetch = True, 30, pci.Prefetch(1, 4, 8)
        bus.add_memory(target, 0, 0x1000)
        bus.read(0, 0, words, 0)
        (ended,) = bus.advance_to(2000)
        assert [a.words for a in bus.attempts if a.words] == stays
        assert ended.retries >= len(stays) and ended.disconnects == len(stays) - 1 and ended.count == words


def test_a_refused_master_thinks_before_it_tries_again() -> None:
    for think in (0, 7):
        bus = pci.Bus()
        master = pci.MasterConfig()
        master.think_on_retry = think
        bus.add_master(master)
        bus.add_memory(pci.TargetConfig.sram(), 0, 0x1000).answer = pci.Answer.retry
        bus.read(0, 0, 1, 0)
        bus.advance_to(100)
        first, second = bus.attempts[:2]
        assert second.frame - (first.last + 2) == 2 + think


def test_the_three_parts_of_latency() -> None:
    """REQ# to GNT#, GNT# to FRAME#, FRAME# to the first data phase (plant-and-bus.md 3.1)."""
    bus = pci.Bus()
    for _ in range(2):
        bus.add_master()
    bus.add_memory(pci.TargetConfig.sram(), 0, 0x1000)
    bus.read(0, 0, 8, 0)  # frame 0, data 5 .. 12
    bus.read(1, 0, 1, 4)  # GNT# with the last data phase, FRAME# after the turnaround
    first, second = bus.advance_to(100)
    assert (first.requested, first.granted, first.framed, first.first_data) == (0, 0, 0, 5)
    assert (second.requested, second.granted, second.framed, second.first_data) == (4, 12, 14, 19)
    counts = bus.master_statistics(1)
    assert (counts.arbitration, counts.acquisition, counts.target) == (8, 2, 5)


def test_impossible_parameters_are_refused() -> None:
    config = pci.BusConfig()
    config.line_words = 6
    with pytest.raises(ValueError, match="line_words is a power of two"):
        pci.Bus(config)
    bus = pci.Bus()
    master = pci.MasterConfig()
    master.think_on_retry = -1
    with pytest.raises(ValueError, match="think_on_retry"):
        bus.add_master(master)


def test_the_audit_finds_nothing_under_random_traffic() -> None:
    board = Board("round_robin", "last_owner", 2, 0, [16] * 4, [False] * 4, [0] * 4, TARGETS)
    draw = random.Random(5)
    jobs = [
        [Job(draw.randrange(20), draw.random() < 0.5, draw.randrange(4), draw.choice([1, 9, 30])) for _ in range(80)]
        for _ in range(4)
    ]
    bus, _ = event_driven(board, jobs, 6000)
    assert bus.audit(bus.now()) == [] and len(bus.attempts) > 300
