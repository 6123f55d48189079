"""Arguments by name or as numbers, with their error messages."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal
from numbers import Real

import numpy as np
from numpy.typing import NDArray

from cmrc.arguments import number, shown


def assign(target: object, what: str, values: object, *others: str) -> None:
    """Sets attributes by name; ``others`` are names that the caller handles."""
    if not isinstance(values, Mapping):
        raise TypeError(f"the parameters of {what} must be given by name, not {values!r}")
    known = sorted({name for name in dir(target) if not name.startswith("_")}.union(others))
    for name, value in values.items():
        if name not in known:
            raise ValueError(f"{what} has no parameter {name!r}; it has {', '.join(known)}")
        try:
            setattr(target, name, value)
        except (TypeError, AttributeError):
            raise ValueError(f"the {name} of {what} cannot be {value!r}") from None


def array(values: object) -> NDArray[np.float64] | None:
    """Numbers as doubles; None for anything else: texts, durations, numbers beyond a double, masked ones."""
    try:
        found = np.asarray(values)
        if np.ma.is_masked(values) or found.dtype.kind not in "biufO":
            return None
        if found.dtype == object and not all(map(_is_number, found.flat)):
            return None
        return found.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        return None


def _is_number(one: object) -> bool:
    return isinstance(one, (Real, Decimal, np.bool_)) and not isinstance(one, np.timedelta64)


def numbers(what: str, values: object, count: int) -> list[float]:
    # An array of doubles, as one that steps a crane gives each time, needs no look at its elements.
    found = values if type(values) is np.ndarray and values.dtype == np.float64 else array(values)
    if found is None or found.shape != (count,):
        raise ValueError(f"{what} must be {count} numbers, not {shown(values)}")
    numbers: list[float] = found.tolist()
    return numbers


def device_code(what: str, value: float, scale: float, least: int, most: int) -> int:
    """A value in SI units as a device's integer."""
    if not least <= number(what, value) * scale <= most:
        raise ValueError(f"{what} must be {least / scale:g} to {most / scale:g} (got {value})")
    return round(value * scale)
