"""Arguments by name or as numbers, with their error messages."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cmrc.arguments import number


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


def numbers(what: str, values: object, count: int) -> list[float]:
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (count,):
        raise ValueError(f"{what} must be {count} numbers, not {values!r}")
    return [float(value) for value in array]


def device_code(what: str, value: float, scale: float, least: int, most: int) -> int:
    """A value in SI units as a device's integer."""
    if not least <= number(what, value) * scale <= most:
        raise ValueError(f"{what} must be {least / scale:g} to {most / scale:g} (got {value})")
    return round(value * scale)
