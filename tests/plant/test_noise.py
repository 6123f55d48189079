"""Streams of noise: normal, repeatable, and none of them a part of another."""

import itertools

import numpy as np
import pytest
from cmrc._core import plant

SAMPLES = range(2000)


def values(draw, stream, seed=1):
    return np.array([draw(seed, stream, i) for i in SAMPLES])


@pytest.mark.parametrize("draw", [plant.uniform, plant.normal])
def test_no_stream_shares_a_number_with_another(draw):
    """Not even from another sample on: a key that mixes purpose and sample lets one stream repeat the other,
    shifted."""
    seen = {stream: values(draw, stream) for stream in plant.Stream}
    assert len(np.unique(np.concatenate(list(seen.values())))) == len(seen) * len(SAMPLES)
    for (_, a), (_, b) in itertools.combinations(seen.items(), 2):
        for shift in range(-20, 21):
            left, right = (a[shift:], b[: len(b) - shift]) if shift >= 0 else (a[:shift], b[-shift:])
            assert abs(np.corrcoef(left, right)[0, 1]) < 6.0 / np.sqrt(len(left))


def test_deviates_are_normal_and_depend_on_the_seed():
    one = values(plant.normal, plant.Stream.sway_radial)
    assert (one == values(plant.normal, plant.Stream.sway_radial)).all()
    assert abs(one.mean()) < 4.0 / np.sqrt(len(one)) and one.std() == pytest.approx(1.0, rel=0.06)
    assert np.mean(np.abs(one) < 1.0) == pytest.approx(0.683, abs=0.04)
    other = values(plant.normal, plant.Stream.sway_radial, seed=2)
    assert abs(np.corrcoef(one, other)[0, 1]) < 4.0 / np.sqrt(len(one))
