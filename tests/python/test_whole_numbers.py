"""Whole numbers that C++ takes: what is behind the point of another kind of number is not cut off."""

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from cmrc import plant


def set_agvs(value: Any) -> int:
    config = plant.default_dock()
    config.agv_count = value
    return config.agv_count


def set_row(value: Any) -> int:
    plant.Dock(plant.default_dock()).select_row(value, 0)
    return int(value)


TAKES: dict[str, Callable[[Any], int]] = {
    "an argument": lambda value: plant.default_dock(value).agv_count,
    "a member": set_agvs,
    "a device's argument": set_row,
}


@pytest.mark.parametrize("value", [2.5, 2.0, np.float32(2.5), np.array(2.5), Decimal("2.5"), Fraction(5, 2), "2", None])
@pytest.mark.parametrize("name", TAKES)
def test_what_is_no_whole_number_is_refused(name: str, value: Any) -> None:
    with pytest.raises(TypeError, match="whole number"):
        TAKES[name](value)


@pytest.mark.parametrize("value", [2, True, np.int8(2), np.uint64(2), np.array(2)])
@pytest.mark.parametrize("name", TAKES)
def test_every_kind_of_whole_number_is_taken(name: str, value: Any) -> None:
    assert TAKES[name](value) == int(value)


@pytest.mark.parametrize("value", [2**31, -(2**31) - 1, 2**64, -(2**70)])
@pytest.mark.parametrize("name", TAKES)
def test_a_number_beyond_the_range_is_refused(name: str, value: int) -> None:
    with pytest.raises(TypeError, match="whole number"):
        TAKES[name](value)
