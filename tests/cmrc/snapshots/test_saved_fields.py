"""What the states of docks and networks list, as it is kept in tests/golden."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import test_snapshots
from cmrc import _core
from cmrc.network import Network
from leaves import fields
from locations import ROOT
from nasty_rings import ring, ring_network
from nasty_runs import Bench


def docks() -> Iterator[Any]:
    for scene in test_snapshots.SCENES:
        simulation = _core.cmrc.Simulation(test_snapshots.configuration(scene))
        simulation.run_until(test_snapshots.instants(scene, 3)[-1])
        yield simulation


def networks(scratch: Path) -> Iterator[Any]:
    """Links, DMA, timers, pins of nasty programs; devices and a dual-port memory of examples/carriers."""
    network = ring_network(ring(3), Bench(scratch))
    network.run(until_us=3)
    yield network._core
    place = ROOT / "examples" / "carriers"
    carriers = Network.from_file(place / "carriers.toml")
    carriers.run(max_cycles=2000)
    yield carriers._core


@pytest.mark.golden
def test_the_state_of_a_dock_lists_what_it_did(golden: Callable[[str, str], None]) -> None:
    golden("state-dock.fields", fields(docks()))


@pytest.mark.golden
def test_the_state_of_a_network_lists_what_it_did(golden: Callable[[str, str], None], tmp_path: Path) -> None:
    golden("state-network.fields", fields(networks(tmp_path)))
