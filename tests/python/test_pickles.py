"""Pickling of what the C++ core gives: the same again, or a TypeError, by each of pickle's protocols.

By protocols 0 and 1 pickle calls the base class of all classes that pybind11 makes, which used to end the process."""

import copy
import pickle
from collections.abc import Callable
from typing import Any

import cmrc
import pytest
from cmrc import c40, network, plant

LOOP = c40.assemble("_start: b _start\n")
PROTOCOLS = range(pickle.HIGHEST_PROTOCOL + 1)


def simulation() -> cmrc.Simulation:
    return cmrc.Simulation(dsps=1, duration_s=0.05, settings={"report.reference": "none"})


NEVER: dict[str, tuple[Callable[[], Any], str]] = {
    "image": (lambda: LOOP, "cannot pickle"),
    "dock": (lambda: plant.Dock(plant.default_dock()), "cannot pickle"),
    "core": (lambda: simulation()._core, "cannot pickle"),
}
BY_FORK, BY_SNAPSHOT = r"fork\(\) makes a second one", r"restore\(\) gives the state in snapshot\(\) to another one"
ONE_STATE: dict[str, tuple[Callable[[], Any], str]] = {
    "Simulation": (simulation, BY_FORK),
    "Processor": (lambda: c40.Processor(LOOP), BY_FORK),
    "Network": (lambda: network.Network([LOOP]), BY_FORK),
    "Crane": (plant.Crane, BY_SNAPSHOT),
    "Agv": (plant.Agv, BY_SNAPSHOT),
    "Scene": (plant.Scene, BY_SNAPSHOT),
    "CraneEnv": (lambda: plant.CraneEnv((0, 20, 5)), "reset with the same seed"),
}


@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize("name", NEVER)
def test_what_has_no_pickle_says_so(name: str, protocol: int) -> None:
    made, message = NEVER[name]
    with pytest.raises(TypeError, match=message):
        pickle.dumps(made(), protocol)


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, pickle.dumps])
@pytest.mark.parametrize("name", ONE_STATE)
def test_what_has_one_state_is_not_copied_and_says_how_to_make_a_second(
    name: str, copied: Callable[[Any], object]
) -> None:
    """A copy used to change the original."""
    made, second = ONE_STATE[name]
    with pytest.raises(TypeError, match=f"^an? {name} is not copied or pickled, since .* one state; .*{second}"):
        copied(made())


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
