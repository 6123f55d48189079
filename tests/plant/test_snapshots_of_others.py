"""A snapshot of another crane or vehicle is refused, and nothing changes then; the load and the place are state."""

import pickle

import pytest
from cmrc import plant

CRANES = {
    "machine": ({"machine": "gantry", "home": (0.0, 0.0, 16.0, 14.0, 0.0)}, {}),
    "parameter or drive": ({"jib": 31.0}, {}),
    "parameter or drive, of a drive": ({"drives": {"luff": {"gear": 300.0}}}, {}),
    "parameter or drive, the rated load": ({"load_mass": 30e3}, {"rated_load": 1e3}),
    "model": ({"model": "rigid"}, {}),
    "integrator": ({"integrator": "adams"}, {}),
    "order": ({"order": 5}, {}),
    "tolerance": ({"tolerance": 1e-8}, {}),
    "bookkeeping": ({"bookkeeping": True}, {}),
    "seed or sway_noise": ({"sway_noise": 0.01}, {}),
    "wind": ({"wind": {"mean": 5.0}}, {}),
}


@pytest.mark.parametrize("case", CRANES)
@pytest.mark.parametrize("again", [lambda value: value, lambda value: pickle.loads(pickle.dumps(value))])
def test_a_snapshot_of_another_crane_is_refused(case, again):
    its, own = CRANES[case]
    crane, other = plant.Crane(**own), plant.Crane(**its)
    for one in (crane, other):
        one.step([0.0, 500.0, 0.0, 0.0, 0.0], 0.05)
    before = pickle.dumps(crane.snapshot())
    message = f"the snapshot is of a crane with another {case.partition(',')[0]}; one of a crane with the same config"
    for call in (crane.restore, crane.linearize):
        with pytest.raises(ValueError, match=message):
            call(again(other.snapshot()))
    assert pickle.dumps(crane.snapshot()) == before
    plant.Crane(**its).restore(again(other.snapshot()))


def test_the_load_and_the_place_may_differ():
    crane, other = plant.Crane(load_mass=20e3), plant.Crane(home=(1.0, 12.0, 17.0, 13.0, 0.1))
    crane.step([0.0, 500.0, 3300.0, 2400.0, 1.0], 0.1)
    other.restore(crane.snapshot())
    for one in (crane, other):
        one.step([0.0, 500.0, 3300.0, 2400.0, 1.0], 0.1)
    assert pickle.dumps(crane.state) == pickle.dumps(other.state)
    other.linearize(crane.snapshot())


@pytest.mark.parametrize(
    ("what", "its"),
    [("drive", {"drive": "differential"}), ("parameter", {"mass": 20e3}), ("tolerance", {"tolerance": 1e-7})],
)
def test_a_snapshot_of_another_vehicle_is_refused(what, its):
    agv, other = plant.Agv(), plant.Agv(**its)
    other.step(3.0, 0.2, 0.1, 2.0)
    before = agv.state
    with pytest.raises(ValueError, match=f"the snapshot is of an AGV with another {what}; one of an AGV with the same"):
        agv.restore(pickle.loads(pickle.dumps(other.snapshot())))
    assert agv.state == before


def test_a_vehicle_with_another_start_and_load_is_the_same_vehicle():
    agv, other = plant.Agv(start=(1.0, 2.0, 0.3), load_mass=10e3), plant.Agv()
    agv.step(3.0, 0.2, 0.1, 2.0)
    other.restore(agv.snapshot())
    assert other.state == agv.state
