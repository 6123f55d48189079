"""The bus model compared with the rules of PCI as plant-and-bus.md 3.1 and 3.6 count them."""

import random
from itertools import pairwise

import pytest
from cmrc_test import bus_model as pci


def config(kind: type, **values: object) -> object:
    """A configuration object with some fields set."""
    result = kind()
    for name, value in values.items():
        setattr(result, name, value)
    return result


def one_master(target: pci.TargetConfig, **bus: object) -> tuple[pci.Bus, pci.Memory]:
    """A bus with one master and one memory of 4096 words."""
    result = pci.Bus(config(pci.BusConfig, **bus))
    result.add_master(config(pci.MasterConfig, latency_timer=248))
    return result, result.add_memory(target, 0, 0x1000)


def occupied(bus: pci.Bus) -> int:
    """Clocks from the first FRAME# to the end of the last turnaround."""
    return bus.attempts[-1].last + 2 - bus.attempts[0].frame


ZERO_WAIT = {"devsel": 2, "read_initial": 0, "write_initial": 0}
SLOW = {"devsel": 2, "read_initial": 8, "read_step": 1, "write_initial": 8, "write_step": 1}


@pytest.mark.parametrize(
    "words, zero_wait, slow_read", [(1, 4, 12), (4, 7, 18), (7, 10, 24), (16, 19, 42), (64, 67, 138)]
)
def test_the_table_of_transaction_lengths(words: int, zero_wait: int, slow_read: int) -> None:
    for write in (False, True):
        bus, _ = one_master(config(pci.TargetConfig, **ZERO_WAIT))
        bus.write(0, 0, list(range(words)), 5) if write else bus.read(0, 0, words, 5)
        assert len(bus.advance_to(1000)) == 1
        assert occupied(bus) == zero_wait
    bus, _ = one_master(config(pci.TargetConfig, **SLOW))
    bus.read(0, 0, words, 5)
    bus.advance_to(1000)
    assert occupied(bus) == slow_read


def test_an_s5933_burst_of_four_words_takes_thirteen_clocks() -> None:
    """The vendor's own sum: disconnect after 4 words, REQ# off for 2 clocks, 4 clocks to regain the grant: 390 ns per
    16 bytes."""
    bus, memory = one_master(
        config(pci.TargetConfig, max_burst=4, **ZERO_WAIT), parking=pci.Parking.none, grant_clocks=4
    )
    bus.write(0, 0, list(range(100, 140)), 0)
    (ended,) = bus.advance_to(1000)
    assert [b.frame - a.frame for a, b in pairwise(bus.attempts)] == [13] * 9
    assert ended.disconnects == 9 and [memory[i] for i in range(40)] == list(range(100, 140))


def test_a_parked_grant_starts_at_once_and_another_after_the_arbiter() -> None:
    bus = pci.Bus()
    bus.add_master()
    bus.add_master()
    bus.add_memory()
    bus.read(0, 0, 1, 10)
    assert bus.advance_to(100)[0].framed == 10
    bus.read(1, 0, 1, 100)
    assert bus.advance_to(200)[0].framed == 102
    bus.read(1, 0, 1, 201)
    assert bus.advance_to(300)[0].framed == 201


def test_arbitration_hides_behind_the_running_transaction() -> None:
    bus = pci.Bus()
    for _ in range(3):
        bus.add_master()
    bus.add_memory(config(pci.TargetConfig, **ZERO_WAIT))
    for master in range(3):
        bus.read(master, 0, 4, 0)
    bus.advance_to(100)
    assert [(a.master, a.frame) for a in bus.attempts] == [(0, 0), (1, 7), (2, 14)]


def test_fast_back_to_back_saves_the_turnaround_after_a_write_of_the_same_master() -> None:
    ends = {}
    for fast in (False, True):
        bus = pci.Bus(config(pci.BusConfig, fast_back_to_back=fast))
        bus.add_master()
        bus.add_memory()
        bus.write(0, 0, [1], 0)
        first = bus.advance_to(4)[0]
        bus.write(0, 1, [2], first.ended)
        bus.advance_to(50)
        ends[fast] = bus.attempts[1].frame - first.ended
        assert bus.statistics(50).total() == 50
    assert ends == {False: 1, True: 0}


def test_the_latency_timer_cuts_only_when_another_asks() -> None:
    for rival in (False, True):
        bus = pci.Bus()
        bus.add_master(config(pci.MasterConfig, latency_timer=16))
        bus.add_master()
        bus.add_memory(config(pci.TargetConfig, **ZERO_WAIT))
        bus.read(0, 0, 64, 0)
        if rival:
            bus.read(1, 0, 1, 5)
        bus.advance_to(500)
        assert [(a.master, a.frame, a.words) for a in bus.attempts] == (
            [(0, 0, 15), (1, 18, 1), (0, 22, 49)] if rival else [(0, 0, 64)]
        )


@pytest.mark.parametrize("masters, latency_timer, seed", [(2, 32, 1), (4, 32, 2), (5, 64, 3), (8, 16, 4), (16, 8, 5)])
def test_round_robin_bounds_every_wait(masters: int, latency_timer: int, seed: int) -> None:
    draw = random.Random(seed)
    bus = pci.Bus()
    for _ in range(masters):
        bus.add_master(config(pci.MasterConfig, latency_timer=latency_timer))
    for i, target in enumerate([(1, 15, 7), (2, 14, 3), (3, 0, 0)]):
        devsel, initial, step = target
        bus.add_memory(
            config(
                pci.TargetConfig,
                devsel=devsel,
                read_initial=initial,
                write_initial=initial,
                read_step=step,
                write_step=step,
            ),
            i * 4096,
            4096,
        )
    waits = []
    for _ in range(600 // masters):
        start = bus.now() + 400 * masters * 10
        for master in range(masters):
            address, words, clock = (
                draw.randrange(3) * 4096 + draw.randrange(3000),
                draw.randrange(1, 257),
                start + draw.randrange(60),
            )
            bus.read(master, address, words, clock) if draw.random() < 0.5 else bus.write(
                master, address, [0] * words, clock
            )
        ended = bus.advance_to(start + 400 * masters * 9)
        assert len(ended) == masters
        waits += [t.framed - t.requested for t in ended]
    assert max(waits) <= (masters - 1) * (latency_timer + 16 + 8)
    assert max(waits) > masters  # the bound was tried


def traffic(
    seed: int, arbitration: pci.Arbitration = pci.Arbitration.round_robin
) -> tuple[pci.Bus, list[pci.Memory], list[pci.Transaction], list[tuple[int, int, list[int]]]]:
    """Random transactions of four masters over an SRAM, an S5933, a drive card and a target with posted writes and
    delayed reads."""
    draw = random.Random(seed)
    bus = pci.Bus(config(pci.BusConfig, arbitration=arbitration, fast_back_to_back=seed % 2 == 0))
    for _ in range(4):
        bus.add_master(config(pci.MasterConfig, latency_timer=draw.choice([8, 16, 32])))
    slow = config(pci.TargetConfig, delayed_read=True, fetch=40, post_words=6, post_drain=9)
    targets = [pci.TargetConfig.sram(), pci.TargetConfig.s5933(), pci.TargetConfig.drive_card(), slow]
    memories = [bus.add_memory(target, i * 0x1000, 0x1000) for i, target in enumerate(targets)]
    done: list[pci.Transaction] = []
    written = []
    due = [0] * 4
    count = 0
    while count < 600 or bus.next_event() is not None:
        for master in range(4):
            if due[master] is not None and due[master] <= bus.now() and count < 600:
                address, words = draw.randrange(4) * 0x1000 + draw.randrange(0xF00), draw.choice([1, 1, 1, 3, 8, 20])
                if draw.random() < 0.5:
                    values = [draw.randrange(1 << 32) for _ in range(words)]
                    written.append((master, address, values))
                    bus.write(master, address, values, bus.now() + draw.randrange(9))
                else:
                    bus.read(master, address, words, bus.now() + draw.randrange(9))
                due[master] = None
                count += 1
        for transaction in bus.advance_to(bus.now() + 1):
            done.append(transaction)
            due[transaction.master] = transaction.ended + draw.randrange(30)
    return bus, memories, done, written


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("arbitration", [pci.Arbitration.round_robin, pci.Arbitration.fixed])
def test_the_bus_has_one_owner_and_loses_no_word(seed: int, arbitration: pci.Arbitration) -> None:
    bus, memories, done, written = traffic(seed, arbitration)
    for before, after in pairwise(bus.attempts):
        assert after.frame >= before.last + 1 + (not (seed % 2 == 0 and before.write and before.master == after.master))
    assert len(done) == 600 and all(t.result == pci.Result.done for t in done)
    moved = sum(a.words for a in bus.attempts)
    seen = sum(len(m.accesses) for m in memories)
    assert moved == sum(t.count for t in done)
    # A burst read that the latency timer cuts is fetched again from there; nothing else is touched twice.
    assert sum(a.write for m in memories for a in m.accesses) == sum(len(values) for _, _, values in written)
    assert seen >= moved
    # Every word written arrived, in order, and what memory holds is the last of them.
    for master, address, values in written:
        log = [a for a in memories[address >> 12].accesses if a.write and a.master == master]
        assert any(
            [a.value for a in log[i : i + len(values)]] == values and log[i].offset == address & 0xFFF
            for i in range(len(log))
        )
    for memory in memories:
        for offset, value in {a.offset: a.value for a in memory.accesses if a.write}.items():
            assert memory[offset] == value


@pytest.mark.parametrize("seed", range(3))
def test_a_retry_repeats_the_identical_transaction(seed: int) -> None:
    bus, _, done, _ = traffic(seed)
    refused = 0
    for master in range(4):
        own = [a for a in bus.attempts if a.master == master]
        for before, after in pairwise(own):
            if before.kind == pci.AttemptKind.retry:
                refused += 1
                assert (after.write, after.address, after.wanted, after.target) == (
                    before.write,
                    before.address,
                    before.wanted,
                    before.target,
                )
                assert after.frame >= before.last + 2 + 2
                assert before.last + 2 - before.frame in (3, 4, 5)
    assert refused == sum(t.retries for t in done) > 20


@pytest.mark.parametrize("seed", range(3))
def test_every_clock_is_counted_once(seed: int) -> None:
    bus, _, _, _ = traffic(seed)
    end = bus.now() + 7
    total = bus.statistics(end)
    assert total.total() == end
    assert total.data == sum(a.words for a in bus.attempts)
    assert total.address == len(bus.attempts)
    owned = sum(bus.master_statistics(m).owned for m in range(4))
    busy = total.address + total.data + total.wait + total.turnaround
    assert 0 <= owned - busy <= len(bus.attempts) and (owned == busy or seed % 2 == 0)


def test_the_count_of_clocks_holds_in_the_middle_of_everything() -> None:
    bus = pci.Bus()
    bus.add_master()
    bus.add_master()
    bus.add_memory(pci.TargetConfig.s5933())
    bus.read(0, 0, 5, 3)
    bus.write(1, 0, [1, 2], 9)
    for clock in range(80):
        bus.advance_to(clock)
        assert bus.statistics(clock).total() == clock


def test_clocks_of_a_stall_are_requested_from_the_first_request_on() -> None:
    """Whoever starts after the stall, and whoever has left the bus during the stall."""

    def idle(left: int | None, until: int) -> tuple[int, int]:
        bus = pci.Bus(config(pci.BusConfig, arbitration=pci.Arbitration.fixed))
        for _ in range(2):
            bus.add_master(config(pci.MasterConfig))
        bus.add_memory(config(pci.TargetConfig), 0, 0x1000)
        bus.stall(0, 100)
        bus.read(1, 0, 1, 20)  # master 0 comes first, but requests last
        if left is not None:
            bus.advance_to(left)
            bus.withdraw(1, left)
        bus.read(0, 0, 1, 60)
        bus.advance_to(until)
        assert bus.audit(until) == []
        counts = bus.statistics(until)
        bus.advance_to(200)
        assert bus.attempts[0].master == 0 and bus.attempts[0].frame == 100
        return counts.idle, counts.idle_requested

    assert idle(None, 99) == (20, 79) and idle(None, 102) == (20, 80)
    # From 20 to 50, and from 60 on.
    assert idle(50, 99) == (30, 69) and idle(50, 102) == (30, 70)


def test_a_delayed_read_is_fetched_while_the_bus_is_free() -> None:
    bus = pci.Bus()
    bus.add_master()
    memory = bus.add_memory(config(pci.TargetConfig, delayed_read=True, fetch=20, **ZERO_WAIT))
    memory[3] = 77
    bus.read(0, 3, 1, 0)
    (ended,) = bus.advance_to(200)
    assert ended.words == [77] and ended.retries >= 1 and ended.first_data >= 22


def test_a_delayed_read_is_answered_from_the_clock_on_in_which_its_word_is_there() -> None:
    """The target fetches for `fetch` clocks from the first attempt on, and refuses attempts before the end of that
    time."""
    just_in_time = 0
    for fetch in range(1, 40):
        bus = pci.Bus()
        bus.add_master()
        bus.add_memory(config(pci.TargetConfig, delayed_read=True, fetch=fetch, **ZERO_WAIT))
        bus.read(0, 3, 1, 0)
        bus.advance_to(200)
        first, *again, last = [attempt.frame for attempt in bus.attempts]
        assert all(frame - first < fetch for frame in again) and last - first >= fetch
        just_in_time += last - first == fetch
    assert just_in_time > 0


def test_a_target_that_takes_as_much_as_the_master_gives_still_disconnects() -> None:
    """The target ends the transaction: the master releases REQ#, as does a master without a limit."""
    ends = []
    for most in (0, 4):
        bus = pci.Bus(config(pci.BusConfig, parking=pci.Parking.none, grant_clocks=4))
        bus.add_master(config(pci.MasterConfig, max_burst=most))
        bus.add_memory(config(pci.TargetConfig, max_burst=4, **ZERO_WAIT))
        bus.write(0, 0, list(range(16)), 0)
        (ended,) = bus.advance_to(1000)
        ends.append((ended.disconnects, [attempt.frame for attempt in bus.attempts]))
    assert ends[0] == ends[1] and ends[0][0] == 3


def test_no_target_answers() -> None:
    bus, memory = one_master(pci.TargetConfig())
    bus.read(0, 0x5000, 2, 0)
    (ended,) = bus.advance_to(100)
    assert ended.result == pci.Result.master_abort and ended.words == [0xFFFFFFFF] * 2 and ended.count == 0
    (attempt,) = bus.attempts
    assert attempt.last - attempt.frame == 4  # the clock for subtractive decoding (docs/buses.md)
    memory.answer = pci.Answer.abort
    bus.write(0, 0, [1], 100)
    (ended,) = bus.advance_to(200)
    assert ended.result == pci.Result.target_abort and memory.accesses == []


def test_a_stuck_target_delays_no_other_target() -> None:
    bus = pci.Bus()
    bus.add_master()
    bus.add_master()
    stuck = bus.add_memory(pci.TargetConfig(), 0, 0x1000)
    bus.add_memory(pci.TargetConfig(), 0x1000, 0x1000)
    stuck.answer = pci.Answer.retry
    bus.read(0, 0, 1, 0)
    for i in range(20):
        bus.read(1, 0x1000, 8, bus.now() + 3)
        assert len(bus.advance_to(bus.now() + 60)) == 1, i
    stuck.answer = pci.Answer.accept
    assert [t.master for t in bus.advance_to(bus.now() + 60)] == [0]


@pytest.mark.parametrize("pulled, arrived", [(1, 0), (5, 0), (6, 1), (8, 3), (100, 16)])
def test_a_master_pulled_out_in_mid_burst_leaves_what_it_has_moved(pulled: int, arrived: int) -> None:
    bus = pci.Bus()
    bus.add_master()
    bus.add_master()
    memory = bus.add_memory(config(pci.TargetConfig, devsel=2, write_initial=3))
    bus.write(0, 0, list(range(1, 17)), 0)
    bus.read(1, 100, 1, 3)
    bus.advance_to(pulled)
    bus.withdraw(0, pulled)
    ended = bus.advance_to(300)
    assert [memory[i] for i in range(16)] == [i + 1 if i < arrived else 0 for i in range(16)]
    assert len([t for t in ended if t.master == 1]) == 1 or pulled == 100
    if pulled < 20:
        assert bus.attempts[1].frame == pulled + 1 if pulled > 3 else bus.attempts[1].frame <= 5
    assert bus.statistics(300).total() == 300


def test_impossible_parameters_are_refused() -> None:
    bus = pci.Bus()
    with pytest.raises(ValueError, match="multiple of 8"):
        bus.add_master(config(pci.MasterConfig, latency_timer=33))
    with pytest.raises(ValueError, match="within 16 clocks"):
        bus.add_memory(config(pci.TargetConfig, read_initial=15))
    with pytest.raises(ValueError, match="within 16 clocks"):
        bus.add_memory(config(pci.TargetConfig, devsel=2, write_initial=15))
    bus.add_memory(config(pci.TargetConfig, devsel=2, write_initial=14, read_initial=14), 1 << 20, 1)
    bus.add_memory(pci.TargetConfig(), (1 << 32) - 100, 100)  # the last words of all
    with pytest.raises(ValueError, match="within 2\\^32 words"):
        bus.add_memory(pci.TargetConfig(), (1 << 32) - 99, 100)
    bus.add_memory(pci.TargetConfig(), 0, 100)
    with pytest.raises(ValueError, match="overlaps"):
        bus.add_memory(pci.TargetConfig(), 99, 100)
    bus.add_master()
    bus.read(0, 0, 1, 0)
    with pytest.raises(RuntimeError, match="already has a transaction"):
        bus.read(0, 0, 1, 0)


def test_the_histogram_against_sorted_values() -> None:
    draw = random.Random(7)
    values = sorted(int(draw.expovariate(0.01)) for _ in range(5000))
    histogram = pci.Histogram()
    for value in values:
        histogram.add(value)
    for fraction in (0.5, 0.99, 0.999, 1.0):
        true = values[max(0, -(-int(fraction * 100000) * 5000 // 100000) - 1)]
        assert true <= histogram.percentile(fraction) <= max(true, true * 9 // 8)
    assert (histogram.count(), histogram.sum(), histogram.max()) == (5000, sum(values), values[-1])
    octaves = histogram.octaves()
    assert octaves[5] == sum(32 <= v < 64 for v in values) and octaves[0] == sum(v < 2 for v in values)
