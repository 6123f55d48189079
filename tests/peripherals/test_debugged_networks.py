"""The debugger over random networks: one instant for all chips, what it shows, and that looking changes nothing."""

import random

import pytest
from cmrc.debug import Debugger
from cmrc.network import Network
from test_random_networks import network as random_network

SEEDS = [*range(12), *(pytest.param(seed, marks=pytest.mark.campaign) for seed in range(12, 500))]


def of_machine(network: Network) -> dict[str, bytes]:
    state, leaves = network._core._state(), network._core._state_leaves()
    return {path: state[offset : offset + size] for path, offset, size in leaves}


def add_some_stops(
    debugger: Debugger, rng: random.Random, symbols: list[str], ignored: tuple[int, ...] = (0, 0, 7)
) -> None:
    for _ in range(rng.randrange(1, 4)):
        chip = rng.randrange(len(debugger.chips()))
        if rng.random() < 0.5:
            debugger.break_at(rng.choice(symbols), chip=rng.choice([None, 0]), ignore=rng.choice(ignored))
        else:
            debugger.watch(
                0x2FF800 + rng.randrange(40),
                rng.choice([1, 8]),
                on=rng.choice(["write", "read", "access", "change"]),
                chip=chip,
            )


@pytest.mark.parametrize("seed", SEEDS)
def test_at_a_stop_a_network_is_as_without_a_debugger(seed: int) -> None:
    rng = random.Random(seed)
    network = random_network(seed, 0)
    debugger = network.debug()
    add_some_stops(debugger, rng, sorted(name for name in network._core.program(0).symbols if not name.startswith(".")))
    for _ in range(8):
        stop = debugger.go(60e-6)
        if not stop.hits:
            break
        alone = random_network(seed, 0)
        alone._core.run_until(stop.time_ps)
        assert of_machine(network) == of_machine(alone), (seed, stop)
    debugger.close()
    end = random_network(seed, 0)
    for one in (network, end):
        one._core.run_until(200_000_000)
    assert network._core.event_trace() == end._core.event_trace()


@pytest.mark.parametrize("seed", SEEDS)
def test_a_network_goes_back_through_the_stops_that_it_came_by(seed: int) -> None:
    rng = random.Random(seed)
    network = random_network(seed, 0)
    debugger = network.debug()
    add_some_stops(
        debugger,
        rng,
        sorted(name for name in network._core.program(0).symbols if not name.startswith(".")),
        ignored=(0,),
    )
    forth = []
    for _ in range(6):
        stop = debugger.go(60e-6)
        if not stop.hits:
            break
        forth.append((stop.time_ps, sorted(hit.text for hit in stop.hits), of_machine(network)))
    stands_at_the_last = bool(forth) and debugger.stop.time_ps == forth[-1][0]
    for time_ps, texts, before in reversed(forth[:-1] if stands_at_the_last else forth):
        stop = debugger.back()
        assert (stop.time_ps, sorted(hit.text for hit in stop.hits)) == (time_ps, texts)
        assert of_machine(network) == before
