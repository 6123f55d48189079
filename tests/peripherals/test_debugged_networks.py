"""The debugger over random networks: one instant for all chips, what it shows, and that looking changes nothing."""

import random

import pytest
from cmrc.debug import Debugger
from cmrc.network import Network
from test_random_networks import network as random_network


def of_machine(network: Network) -> dict[str, bytes]:
    """The state of a network, without how far its search for loops that poll has come: that depends on how a run is cut."""
    state, leaves = network._core._state(), network._core._state_leaves()
    return {path: state[offset : offset + size] for path, offset, size in leaves if "patience" not in path and ".looking" not in path}


def add_some_stops(debugger: Debugger, rng: random.Random, symbols: list[str]) -> None:
    for _ in range(rng.randrange(1, 4)):
        chip = rng.randrange(len(debugger.chips()))
        if rng.random() < 0.5:
            debugger.break_at(rng.choice(symbols), chip=rng.choice([None, 0]), ignore=rng.choice([0, 0, 7]))
        else:
            debugger.watch(0x2FF800 + rng.randrange(40), rng.choice([1, 8]), on=rng.choice(["write", "read", "access", "change"]), chip=chip)


@pytest.mark.parametrize("seed", range(12))
def test_at_a_stop_a_network_is_as_one_that_nobody_looks_at(seed: int) -> None:
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


@pytest.mark.parametrize("seed", range(6))
def test_a_network_goes_back_through_the_stops_that_it_came_by(seed: int) -> None:
    rng = random.Random(seed)
    network = random_network(seed, 0)
    debugger = network.debug()
    add_some_stops(debugger, rng, sorted(name for name in network._core.program(0).symbols if not name.startswith(".")))
    for number in debugger.hits():
        assert number > 0
    forth = []
    for _ in range(6):
        stop = debugger.go(60e-6)
        if not stop.hits:
            break
        forth.append((stop.time_ps, sorted(hit.text for hit in stop.hits), of_machine(network)))
    if len(forth) < 2 or any(trigger for trigger in debugger.hits().values() if trigger > 6):
        return
    for time_ps, texts, before in reversed(forth[:-1]):
        stop = debugger.back()
        assert (stop.time_ps, sorted(hit.text for hit in stop.hits)) == (time_ps, texts)
        assert of_machine(network) == before
