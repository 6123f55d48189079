"""Instants are the nearest doubles, and every function of the plant takes and refuses the same numbers."""

import decimal
import fractions

import numpy as np
import pytest
from cmrc import plant

REST = [0.0] * 5


def test_instants_are_the_nearest_doubles():
    crane, scene, agv = plant.Crane(), plant.Scene(agvs=0), plant.Agv()
    for k in range(1, 131):
        crane.step(REST, 0.01)
        agv.step(0.0, 0.0, 0.0, 0.01)
        scene.step(None, 0.01)
        assert crane.state.time_s == agv.state.time_s == scene.time_s == k * 10**10 / 1e12


def test_a_loop_until_an_instant_makes_no_step_too_many():
    crane, steps = plant.Crane(), 0
    while crane.state.time_s < 0.3:
        crane.step(REST, 0.1)
        steps += 1
    assert steps == 3


@pytest.mark.parametrize(("duration", "steps"), [(0.27, 27), (0.54, 54), (1.07, 107), (0.1, 10), (0.265, 27)])
def test_an_episode_ends_after_its_duration(duration, steps):
    env = plant.CraneEnv((0.0, 12.0, 16.0), dt=0.01, duration=duration)
    env.reset(seed=1)
    made = 0
    while True:
        made += 1
        if env.step(REST)[3]:
            break
    assert made == steps


class Labelled:
    """As a Series of pandas: the index is no place."""

    def __len__(self):
        return 5

    def __getitem__(self, index):
        return {"a": 0.0}[index]

    def __array__(self, dtype=None, copy=None):
        return np.array(REST)


CALLS = {
    "Crane.step": lambda values: plant.Crane().step(values, 0.01),
    "Crane.run": lambda values: plant.Crane().run(values, 0.01, 1),
    "Crane.reset": lambda values: plant.Crane().reset((0.0, 0.3, 0.8, 14.0, 0.0, 0.0, 0.0), torques=values),
    "Crane.sensitivity": lambda values: plant.Crane().sensitivity(values, 0.01),
    "Scene.step": lambda values: plant.Scene(agvs=0).step(values, 0.01),
    "CraneEnv.step": lambda values: plant.CraneEnv((0.0, 12.0, 16.0)).step(values),
}
REFUSED = {
    "beyond a double": [10**400] * 5,
    "no dimensions": np.array(1.0),
    "one is masked": np.ma.array([0.1, 0.2, 0.3, 0.0, 0.0], mask=[0, 1, 0, 0, 0]),
    "texts": ["1"] * 5,
    "a text among them": [0.0, 0.0, "1", 0.0, 0.0],
    "durations": np.ones(5, "m8[s]"),
    "complex": [1j] * 5,
    "four": [0.0] * 4,
    "rows": [REST],
    "none": None,
    "a set, which has no order": {0.0, 1.0, 2.0, 3.0, 4.0},
    "keys": dict.fromkeys(range(5)).keys(),
    "a generator": iter(REST),
}
TAKEN = {
    "integers": [0, 1, 0, 0, 0],
    "a tuple": (0.0,) * 5,
    "float16": np.zeros(5, np.float16),
    "longdouble": np.zeros(5, np.longdouble),
    "objects": np.array([0, 0.0, fractions.Fraction(1, 4), decimal.Decimal("0.5"), True], object),
    "an unmasked masked array": np.ma.array(REST),
    "strided": np.zeros(10)[::2],
    "with an array of its own": Labelled(),
}


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_five_numbers_is_refused(call, case):
    if call == "Scene.step" and REFUSED[case] is None:
        pytest.skip("None leaves the drives off")
    with pytest.raises(ValueError, match="numbers, not|five torques are needed"):
        CALLS[call](REFUSED[case])


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("case", TAKEN)
def test_five_numbers_of_any_kind_are_taken(call, case):
    CALLS[call](TAKEN[case])


@pytest.mark.parametrize("value", [10**400, "1000", np.timedelta64(1, "s"), None])
def test_a_mass_is_a_number(value):
    with pytest.raises(ValueError, match="load_mass"):
        plant.Crane(load_mass=value)


@pytest.mark.parametrize("value", ["no", "False", 0, None])
def test_a_flag_is_true_or_false(value):
    with pytest.raises(TypeError, match="bookkeeping: .* True or False is expected"):
        plant.Crane(bookkeeping=value)


def test_a_flag_and_an_order_may_be_of_numpy():
    plant.Crane(bookkeeping=np.True_)
    plant.Crane(order=np.int64(3))
    with pytest.raises(TypeError, match="order must be 3, 4 or 5, not 4.0"):
        plant.Crane(order=4.0)


def test_the_wind_at_what_is_no_instant():
    wind = plant.WindParameters()
    wind.mean, wind.gust = 5.0, 1.0
    speeds = plant.wind_speed(wind, [0.0, 1.0])
    assert speeds.shape == (2,) and plant.wind_speed(wind, 1) == speeds[1] and isinstance(speeds[1], float)
    for value in (None, "a", ["1"], 10**400):
        with pytest.raises(TypeError, match="seconds: .* a number of seconds, or an array of them, is expected"):
            plant.wind_speed(wind, value)
