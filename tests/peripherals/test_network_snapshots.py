"""A network's state, saved and loaded: rings of nasty programs continue from random instants in another network."""

import random

import pytest
from cmrc.c40 import assemble
from cmrc.network import Network, SharedMemory
from leaves import check_that_every_value_is_loaded
from nasty_programs import CYCLES
from nasty_rings import ring, ring_network
from nasty_runs import Bench


def seen(network):
    return (
        network.event_trace,
        [(c.status, c.message, c._core.cycle, c._core.snapshot(), c._core.digest()) for c in network.chips],
        network.links,
    )


@pytest.mark.parametrize("seed", range(40))
def test_a_ring_of_nasty_programs_continues_in_another_network(seed, tmp_path):
    programs, bench = ring(seed), Bench(tmp_path)
    rng = random.Random(seed)
    network, other = ring_network(programs, bench), ring_network(programs, bench, turn_order=seed + 1)
    other.run(until_us=rng.uniform(0, 20))
    now, end, reason = 0.0, CYCLES * 2 / 33, "limit"
    while now < end and reason == "limit":
        now = min(end, now + rng.choice([0.05, 0.3, 2, 10]) * rng.uniform(0.2, 1))
        reason = network.run(until_us=now).reason
        snapshot = network.snapshot()
        other.restore(snapshot)
        assert other.snapshot() == snapshot
        assert seen(other) == seen(network), (seed, now)
        if reason == "limit":
            now = min(end, now + rng.choice([0.05, 1, 5]))
            stops = network.run(until_us=now), other.run(until_us=now)
            assert stops[0] == stops[1]
            assert seen(other) == seen(network), (seed, now)
            reason = stops[0].reason


# Each takes a lock in a shared memory several times, and waits for a word that the other writes there; at last the
# second polls one that is never written.
LOCKS = """        .text
start:  ldhi 7000h,ar0
        ldhi 30h,ar1
        ldi 6,r5
again:  ldii *ar0,r4
        ldi 40,r6
stay:   subi 1,r6
        bnz stay
        addi 1,r4
        stii r4,*ar0
        subi 1,r5
        bnz again
        cmpi 0,r0
        bz tell
poll:   ldi *+ar0(1),r4
        bz poll
        ldi *+ar0(2),r4
never:  ldi *+ar0(3),r4
        bz never
tell:   ldhi 1,r6
        lsh -1,r6
later:  subi 1,r6
        bnz later
        sti r0,*+ar0(2)
        ldi 7,r4
        sti r4,*+ar0(1)
end:    b end
"""


# 589: timers behind a DMA; 1101: an access that a chip waited for when its DMA failed; 2669: a DMA behind its
# processor; 3351: a write of a DMA register in a cycle that the DMA has passed.
@pytest.mark.parametrize(
    "seed",
    [589, 1101, 2669, 3351, *range(20), *(pytest.param(seed, marks=pytest.mark.campaign) for seed in range(20, 3500))],
)
def test_a_ring_of_nasty_programs_has_one_state_at_an_instant(seed, tmp_path):
    programs, bench = ring(seed), Bench(tmp_path)
    rng = random.Random(seed)
    whole, cut = ring_network(programs, bench), ring_network(programs, bench, turn_order=seed + 1)
    instant = rng.randrange(100_000, 40_000_000)
    stop = whole._core.run_until(instant)
    time, stop_of_cut = 0, ("limit", 0)
    while time < instant and stop_of_cut[0] == "limit":
        time = min(instant, time + rng.randrange(1, 4_000_000))
        stop_of_cut = cut._core.run_until(time)
    assert stop_of_cut == stop
    if stop[0] == "limit":
        assert whole._core._state_difference(cut._core) is None


# A choice between alternatives is no number. Of an access without a waiting chip, and of a hold without a held chip,
# the state keeps nothing.
NO_NUMBERS = (
    "memory.pages.",
    "undisturbed",
    "reported_breakpoint",
    "looks",
    "waiting_access",
    "port_slot",
    ".access.",
    ".port_access.",
    "chip.held",
    "chip.reported",
)


def test_every_value_of_a_network_is_loaded_and_named_by_a_comparison(tmp_path):
    programs, bench = ring(3), Bench(tmp_path)
    network = ring_network(programs, bench)
    network.run(until_us=3)
    checked = check_that_every_value_is_loaded(
        lambda: ring_network(programs, bench)._core,
        network._core,
        lambda path: any(name in path for name in NO_NUMBERS),
    )
    assert checked > 1500


def locking(turn_order=0):
    memory = SharedMemory("shared", words=16, places={0: 0x70000000, 1: 0x70000000}, waits=9)
    network = Network(assemble(LOCKS), topology="ring:2", memories=[memory], clocks_mhz=[40, 50], turn_order=turn_order)
    network.hold(1, 20)
    network.release(1, 60)
    return network


def test_locks_polls_and_actions_continue_in_another_network():
    rng = random.Random(5)
    whole = locking()
    end = whole.run(until_us=100_000)
    assert end.reason == "deadlock"
    instants = [rng.uniform(0, 70) for _ in range(25)] + [rng.uniform(70, end.time_ps / 1e6 * 0.999) for _ in range(25)]
    for at in instants:
        network, other = locking(), locking(turn_order=3)
        other.run(until_us=rng.uniform(0, 100))
        network.run(until_us=at)
        snapshot = network.snapshot()
        other.restore(snapshot)
        assert other.snapshot() == snapshot
        assert [chip.message for chip in other.chips] == [chip.message for chip in network.chips], at
        assert other.run(until_us=100_000) == network.run(until_us=100_000), at
        assert seen(other) == seen(network), at
        assert other.memory(0) == network.memory(0) == whole.memory(0), at


def test_a_network_that_deadlocks_after_a_snapshot_does_so_at_the_same_instant():
    """The search for polling loops is part of the state: its start, and what it has found so far."""
    program = assemble(
        "        .text\nstart:  ldhi 10h,ar6\npoll:   ldi *+ar6(70h),r0\n        and 1E00h,r0\n        bz poll\nend:    bu end\n",
        sections={".text": 0x2FF800},
    )
    whole = Network([program, program], links=["0.3:1.0"])
    stop = whole.run()
    assert stop.reason == "deadlock"
    for share in (0.01, 0.3, 0.55, 0.93, 0.97, 0.999):
        part = Network([program, program], links=["0.3:1.0"])
        part.run(until_us=stop.time_ps * share / 1e6)
        resumed = Network([program, program], links=["0.3:1.0"], turn_order=5)
        resumed.restore(part.snapshot())
        assert resumed.run() == stop
        assert [chip.status for chip in resumed.chips] == [chip.status for chip in whole.chips]
        assert resumed.chips[0].cycles == whole.chips[0].cycles
