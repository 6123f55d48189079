"""Wind on the load: where it hangs in a steady wind, and what the gusts are."""

import itertools
import math

import numpy as np
import pytest
from cmrc import plant
from cmrc._core import plant as core

BRAKES = [math.nan] * 5


AIR = 1.225  # kg/m3


@pytest.mark.parametrize(
    ("load", "area"),
    [(0.0, lambda angle: 8.0), (20e3, lambda angle: 38.0 * abs(math.sin(angle)) + 7.6 * abs(math.cos(angle)))],
)
@pytest.mark.parametrize("direction", [0.7, 2.5])
def test_the_load_hangs_aslant_by_force_over_weight(load, area, direction):
    """Area by load and by the wind's angle to the load's long side (control-notes.md 3)."""
    crane = plant.Crane(
        load_mass=load, sway_damping=0.5, home=(0.0, 12.0, 16.0, 14.0, 0.3), wind={"mean": 15.0, "direction": direction}
    )
    crane.step(BRAKES, 40.0)
    q = crane.state.q
    force = 0.5 * AIR * area(direction - q[1] - q[6]) * 15.0**2
    way = crane.payload() - crane.tip()
    assert math.hypot(way[0], way[1]) / -way[2] == pytest.approx(force / ((10e3 + load) * 9.81), rel=2e-3)
    assert math.atan2(way[1], way[0]) == pytest.approx(direction, abs=1e-3)


def test_the_wind_is_felt_relative_to_the_load():
    """A crane that rolls freely along the quay takes on the wind's speed: m dv/dt = k (V - v)^2, so v = V^2 k t / (m +
    V k t)."""
    drives = {"gantry": {"coulomb": 0.0, "viscous": 0.0}}
    wind, area, seconds = 2.0, 40e3, 10.0
    crane = plant.Crane(
        model="rigid", drives=drives, home=(0.0, 20.0, 0.0, 14.0, 0.0), wind={"mean": wind, "spreader_area": area}
    )
    crane.step([0.0, math.nan, math.nan, math.nan, math.nan], seconds)
    p = crane.parameters
    mass = (
        p.gantry_mass
        + p.jib_mass
        + p.counterweight
        + p.spreader_mass
        + p.drives[0].rotor_inertia * p.drives[0].gear ** 2
    )
    k = 0.5 * AIR * area
    assert crane.state.qd[0] == pytest.approx(wind**2 * k * seconds / (mass + wind * k * seconds), rel=1e-3)
    assert crane.state.qd[0] > 0.5 * wind


def parameters(mean, gust, seed):
    wind = core.WindParameters()
    wind.mean, wind.gust, wind.seed = mean, gust, seed
    return wind


@pytest.mark.parametrize("mean", [8.0, -15.0])
def test_gusts_have_kaimals_spectrum(mean):
    """20 seeds of 600 s: the variance within 5 %, the length by Whittle's likelihood of the mean periodogram within 15
    %."""
    sigma, step, seconds = 0.13 * abs(mean), 0.1, 600.0
    times = np.arange(0.0, seconds, step)
    speeds = np.array([core.wind_speed(parameters(mean, sigma, seed), times) for seed in range(20)])
    assert speeds.mean() == pytest.approx(mean, abs=0.25 * sigma)
    assert ((speeds - mean) ** 2).mean() == pytest.approx(sigma**2, rel=0.05)
    n = np.fft.rfftfreq(len(times), step)[1:]
    density = (2.0 * step / len(times) * np.abs(np.fft.rfft(speeds - mean, axis=1)[:, 1:]) ** 2).mean(axis=0)
    low = n < 1.0
    lengths = np.geomspace(50.0, 500.0, 400)
    losses = []
    for length in lengths:
        f = n[low] * length / abs(mean)
        model = sigma**2 / n[low] * 4.0 * f / (1.0 + 6.0 * f) ** (5.0 / 3.0)
        losses.append((np.log(model) + density[low] / model).sum())
    assert lengths[int(np.argmin(losses))] == pytest.approx(170.0, rel=0.15)
    # And the shape, by bands of a third of a decade.
    for least, most in itertools.pairwise(np.geomspace(0.01, 1.0, 7)):
        band = (n >= least) & (n < most)
        f = n[band] * 170.0 / abs(mean)
        model = sigma**2 / n[band] * 4.0 * f / (1.0 + 6.0 * f) ** (5.0 / 3.0)
        assert density[band].sum() == pytest.approx(model.sum(), rel=0.2)


def test_gusts_have_their_size_and_their_seed():
    times = np.arange(0.0, 3000.0, 0.25)
    one = core.wind_speed(parameters(8.0, 2.0, 1), times)
    assert one.std() == pytest.approx(2.0, rel=0.1)
    assert (core.wind_speed(parameters(8.0, 2.0, 1), times[::-1])[::-1] == one).all()  # whatever the calls before
    assert core.wind_speed(parameters(8.0, 2.0, 1), 100.0) == one[400]
    assert np.abs(core.wind_speed(parameters(8.0, 2.0, 2), times) - one).max() > 1.0


def test_the_dock_feels_it_and_continues_from_a_snapshot():
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


@pytest.mark.parametrize(
    "wind",
    [
        {"mean": math.nan},
        {"gust": -1.0},
        {"speed": 3.0},
        {"direction": math.inf},
        {"gust": 1.0},
        {"mean": 0.5, "gust": 0.1},
        {"end_area": -1.0},
    ],
)
def test_an_impossible_wind_is_refused(wind):
    with pytest.raises(ValueError, match="wind"):
        plant.Crane(wind=wind)


@pytest.mark.parametrize("load", [0.0, 20e3])
def test_a_negative_mean_is_the_same_wind_from_the_other_side(load):
    """The force is odd in the speed: -15 m/s along 0.7 rad is 15 m/s along 0.7 - pi."""
    hangs = []
    for mean, direction in ((-15.0, 0.7), (15.0, 0.7 - math.pi), (15.0, 0.7)):
        wind = {"mean": mean, "direction": direction}
        crane = plant.Crane(load_mass=load, sway_damping=0.5, home=(0.0, 12.0, 16.0, 14.0, 0.3), wind=wind)
        crane.step(BRAKES, 30.0)
        hangs.append((crane.payload() - crane.tip())[:2])
    assert hangs[0] == pytest.approx(hangs[1], abs=1e-6)
    along = np.array([math.cos(0.7), math.sin(0.7)])
    assert hangs[0] @ along < -0.05 and hangs[2] @ along > 0.05


def test_gusts_of_a_negative_mean_are_those_of_the_positive_one():
    """Kaimal's f = n L / U takes the speed's size: the same gusts about either mean."""
    times = np.arange(0.0, 60.0, 0.05)
    forth, back = (core.wind_speed(parameters(mean, 2.0, 1), times) for mean in (8.0, -8.0))
    assert back + 8.0 == pytest.approx(forth - 8.0, abs=1e-12)


@pytest.mark.parametrize(("mean", "carried"), [(-1.0, True), (-0.999, False), (1.0, True), (0.999, False)])
def test_gusts_need_a_mean_of_1_m_per_s_in_either_direction(mean, carried):
    wind = {"mean": mean, "gust": 0.1}
    if carried:
        plant.Crane(wind=wind)
    else:
        with pytest.raises(ValueError, match="must be 1 m/s or more"):
            plant.Crane(wind=wind)


@pytest.mark.parametrize(("mean", "possible"), [(-100.0, True), (100.0, True), (-100.001, False), (100.001, False)])
def test_a_mean_is_within_100_m_per_s(mean, possible):
    if possible:
        plant.Crane(wind={"mean": mean})
    else:
        with pytest.raises(ValueError, match="within 100 m/s"):
            plant.Crane(wind={"mean": mean})
