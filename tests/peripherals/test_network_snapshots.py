"""A network's state, saved and loaded: rings of nasty programs go on from random instants in another network."""

import random

import pytest
from cmrc.network import Network
from nasty_programs import CYCLES, Bench, assembled, prepare, ring


def network_of(programs, bench, turn_order=0):
    images = [assembled(program) for program in programs]
    links = [f"{n}.0:{(n + 1) % len(images)}.3" for n in range(len(images))]
    network = Network(images, links=links, boards=[bench.board(program) for program in programs], clocks_mhz=[program.clocks[0] for program in programs],
                      turn_order=turn_order, record_words=True, record_peripherals=True)  # fmt: skip
    for program, chip, image in zip(programs, network.chips, images, strict=True):
        prepare(chip._core, program, image.symbols)
    return network


def seen(network):
    return (
        network.event_trace,
        [(c.status, c.message, c._core.cycle, c._core.snapshot(), c._core.digest()) for c in network.chips],
        network.links,
    )


@pytest.mark.parametrize("seed", range(40))
def test_a_ring_of_nasty_programs_goes_on_in_another_network(seed, tmp_path):
    programs, bench = ring(seed), Bench(tmp_path)
    rng = random.Random(seed)
    network, other = network_of(programs, bench), network_of(programs, bench, turn_order=seed + 1)
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
