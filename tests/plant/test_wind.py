"""Wind on the load: where it hangs in a steady wind, and what the gusts are."""

import math

import numpy as np
import pytest
from cmrc import plant
from cmrc._core import plant as core

BRAKES = [math.nan] * 5


def test_the_load_hangs_aslant_by_force_over_weight():
    crane = plant.Crane(load_mass=0.0, sway_damping=0.5, wind={"mean": 15.0, "direction": 0.7})
    crane.step(BRAKES, 30.0)
    force = 0.5 * 1.225 * 38.0 * 15.0**2
    way = crane.payload() - crane.tip()
    assert math.hypot(way[0], way[1]) / -way[2] == pytest.approx(force / (10e3 * 9.81), rel=1e-3)
    assert math.atan2(way[1], way[0]) == pytest.approx(0.7, abs=1e-3)


def test_gusts_have_their_size_and_their_seed():
    def speeds(seed):
        wind = core.WindParameters()
        wind.mean, wind.gust, wind.seed = 8.0, 2.0, seed
        return np.array([core.wind_speed(wind, t) for t in np.arange(0.0, 3000.0, 0.25)])

    one = speeds(1)
    assert one.mean() == pytest.approx(8.0, abs=0.05) and one.std() == pytest.approx(2.0, rel=0.02)
    assert (speeds(1) == one).all() and np.abs(speeds(2) - one).max() > 1.0


def test_the_dock_feels_it_and_goes_on_from_a_snapshot():
    config = plant.default_dock()
    config.wind.mean, config.wind.gust = 12.0, 3.0
    windy, calm = plant.Scene(config), plant.Scene()
    windy.step(None, 3.0)
    calm.step(None, 3.0)
    assert abs(windy.signal.alpha) + abs(windy.signal.beta) > 0.005 > abs(calm.signal.alpha) + abs(calm.signal.beta)
    kept = windy.snapshot()
    windy.step(None, 1.0)
    once = (windy.signal.alpha, windy.signal.beta)
    windy.restore(kept)
    windy.step(None, 0.4)
    windy.step(None, 0.6)
    assert (windy.signal.alpha, windy.signal.beta) == once


@pytest.mark.parametrize("wind", [{"mean": math.nan}, {"gust": -1.0}, {"speed": 3.0}, {"direction": math.inf}])
def test_an_impossible_wind_is_refused(wind):
    with pytest.raises(ValueError, match="wind"):
        plant.Crane(wind=wind)
