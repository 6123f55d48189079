"""Pickling of what the C++ core gives: the same again, or a TypeError, by each of pickle's protocols.

By protocols 0 and 1 pickle calls the base class of all classes that pybind11 makes, which used to end the process."""

import copy
import pickle
from typing import Any

import cmrc
import pytest
from cmrc import c40, plant

LOOP = c40.assemble("_start: b _start\n")
PROTOCOLS = range(pickle.HIGHEST_PROTOCOL + 1)


def simulation() -> cmrc.Simulation:
    return cmrc.Simulation(dsps=1, duration_s=0.05, settings={"report.reference": "none"})


NEVER = {
    "image": lambda: LOOP,
    "simulation": simulation,
    "processor": lambda: c40.Processor(LOOP),
    "dock": lambda: plant.Dock(plant.default_dock()),
}


@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize("name", NEVER)
def test_what_has_no_pickle_says_so(name: str, protocol: int) -> None:
    with pytest.raises(TypeError, match="cannot pickle"):
        pickle.dumps(NEVER[name](), protocol)


def test_the_base_of_all_classes_makes_no_object() -> None:
    base: Any = type(LOOP).__mro__[-2]
    with pytest.raises(TypeError, match="cannot make 'pybind11_object' object"):
        base()


@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_parameters_are_the_same_again(protocol: int) -> None:
    crane = plant.CraneParameters()
    crane.jib_mass = 1234.5
    assert pickle.loads(pickle.dumps(crane, protocol)).jib_mass == 1234.5


@pytest.mark.parametrize("protocol", PROTOCOLS[2:])
def test_a_snapshot_is_the_same_again(protocol: int) -> None:
    snapshot = simulation().snapshot()
    assert pickle.loads(pickle.dumps(snapshot, protocol)).to_bytes() == snapshot.to_bytes()


def test_a_simulation_is_forked_and_not_copied() -> None:
    with pytest.raises(TypeError, match=r"fork\(\) makes a second run"):
        copy.copy(simulation())
