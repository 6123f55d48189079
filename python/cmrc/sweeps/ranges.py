"""The values of a grid: single ones, lists, ranges from a number to another one, seeds (docs/sweeps.md)."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cache
from typing import Any

from cmrc import _core
from cmrc.errors import Error
from cmrc.floats import shortest
from cmrc.simulation import Setting

RANGE = ("from", "to", "step", "count", "scale")
MOST_RUNS = 10_000_000
MOST_WHOLE = 2**63 - 1


class GridError(Error, ValueError):
    """A grid that cannot be run. The message says where, and what would be right."""


@cache
def schema() -> dict[str, dict[str, Any]]:
    """The configuration's keys by full name."""
    return {key["name"]: key for key in _core.cmrc.config_keys()}


def plain(value: Any) -> Any:
    """A number of NumPy as Python's."""
    single = hasattr(value, "item") and not isinstance(value, (str, bytes)) and getattr(value, "ndim", 1) == 0
    return value.item() if single else value


def short_names(names: Sequence[str]) -> list[str]:
    """The last part of each name; more parts where several names have the same last ones."""
    return [_short(name, [other for other in names if other != name]) for name in names]


def _short(name: str, others: Sequence[str]) -> str:
    parts = name.split(".")
    endings = (".".join(parts[-n:]) for n in range(1, len(parts)))
    return next((end for end in endings if not any(f".{other}".endswith(f".{end}") for other in others)), name)


def as_typed(name: str, value: Any) -> Any:
    """1 is 1.0 where a setting may have a fraction."""
    whole = schema().get(name, {}).get("type", "integer") == "integer"
    return value if whole or isinstance(value, bool) or not isinstance(value, int) else float(value)


def scalar(value: Any, where: str) -> Setting:
    value = plain(value)
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    if not isinstance(value, (bool, int, float, str)):
        raise GridError(f"{where}: {type(value).__name__} cannot be used; true, false, a number or a text is expected")
    if isinstance(value, int) and not -MOST_WHOLE <= value <= MOST_WHOLE:
        raise GridError(f"{where}: {value} is beyond 64 bits")
    if isinstance(value, float) and not math.isfinite(value):
        raise GridError(f"{where}: {value} is not a number that a setting can have")
    return value


def number(value: Any, where: str) -> int | float:
    value = plain(value)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise GridError(f"{where}: a number is expected")
    scalar(value, where)
    return value


def values_of(key: str, value: Any, where: str, unique: bool = True) -> list[Setting]:
    if isinstance(value, Mapping):
        return _range(key, value, where)
    if hasattr(value, "tolist"):
        value = value.tolist()
    if not isinstance(value, (list, tuple, range)):
        raise GridError(f"{where}: a list of values, or from and to with step or count, is expected")
    if not value:
        raise GridError(f"{where}: the list is empty; at least one value is expected")
    values = [scalar(one, f"{where}[{n}]") for n, one in enumerate(value)]
    seen = set()
    for n, one in enumerate(values):
        typed = isinstance(one, bool), as_typed(key, one)  # True is not 1, and 1 is 1.0
        if unique and typed in seen:
            raise GridError(f"{where}[{n}]: {one!r} is given twice; each is run once")
        seen.add(typed)
    return values


def _range(key: str, value: Mapping[str, Any], where: str) -> list[Setting]:
    for part in value:
        if part not in RANGE:
            raise GridError(f"{where}.{part}: unknown; {', '.join(RANGE)} are known")
    numbers = {}
    for part in ("from", "to", "step", "count"):
        if part in value:
            numbers[part] = number(value[part], f"{where}.{part}")
    if "to" not in numbers or ("step" in numbers) == ("count" in numbers):
        raise GridError(f"{where}: from and to, and either step or count, are expected")
    begin, end = numbers["from"], numbers["to"]
    if not begin < end:
        raise GridError(f"{where}: from {begin} to {end}; from < to is expected")
    log = check_steps(value, where)
    if "step" in numbers:
        found = _by_step(begin, end, numbers["step"], log, where)
    else:
        found = _by_count(begin, end, numbers["count"], log, where)
    if schema().get(key, {}).get("type") != "integer":
        found = [float(one) for one in found]
    else:
        for one in found:
            if not isinstance(one, int):
                raise GridError(f"{where}: {shortest(one)} is among its values; {key} is a whole number")
    if len(set(found)) < len(found):
        raise GridError(f"{where}: neighbours are one number ({found[0]!r} and so on); each is run once")
    return list(found)


def check_steps(value: Mapping[str, Any], where: str) -> bool:
    """The scale of a range is logarithmic. Raises GridError for another scale, and for a step that is not above 0."""
    scale = value.get("scale", "linear")
    if not isinstance(scale, str) or scale not in ("linear", "log"):
        raise GridError(f'{where}.scale: "linear" or "log" is expected')
    if "step" in value and not (step := number(value["step"], f"{where}.step")) > 0:
        raise GridError(f"{where}.step: {step}; a step above 0 is expected")
    return scale == "log"


def _by_step(begin: float, end: float, step: float, log: bool, where: str) -> list[int | float]:
    if log:
        raise GridError(f'{where}.scale: "log" goes with count, not with step')
    steps = (_exact(end) - _exact(begin)) / _exact(step)
    count = math.floor(steps * (1 + Fraction(1, 10**12))) + 1
    if count > MOST_RUNS:
        raise GridError(f"{where}.step: {count} values; at most {MOST_RUNS} are expected")
    return _evenly(_exact(begin), _exact(end), _exact(step), count)


def _by_count(begin: float, end: float, count: float, log: bool, where: str) -> list[int | float]:
    if count != int(count) or not 2 <= count <= MOST_RUNS:
        raise GridError(f"{where}.count: {count}; a whole number from 2 to {MOST_RUNS} is expected")
    parts = int(count) - 1
    if not log:
        return _evenly(_exact(begin), _exact(end), (_exact(end) - _exact(begin)) / parts, parts + 1)
    if not begin > 0:
        raise GridError(f"{where}.from: {begin}; a logarithmic range begins above 0")
    inner = [_whole_if_near(begin ** (1 - n / parts) * end ** (n / parts)) for n in range(1, parts)]
    return [int(begin) if begin == int(begin) else begin, *inner, int(end) if end == int(end) else end]


def _exact(number: float) -> Fraction:
    """The number as it is written: 0.1 is a tenth."""
    return Fraction(repr(number))


def _evenly(begin: Fraction, end: Fraction, step: Fraction, count: int) -> list[int | float]:
    """Each value is exact if it is whole, else the nearest number; none is beyond the end."""
    whole = math.lcm(begin.denominator, end.denominator, step.denominator)
    first, last, each = (int(one * whole) for one in (begin, end, step))
    values = (min(first + n * each, last) for n in range(count))
    return [one // whole if one % whole == 0 else one / whole for one in values]


def _whole_if_near(number: float) -> int | float:
    """To 12 digits, which is more than a power is worth."""
    return round(number) if abs(number - round(number)) <= 1e-12 * number else float(f"{number:.12g}")


def seeds_of(seeds: Any, first: Any, has_first: bool) -> list[int]:
    where = "repeats.seeds"
    if isinstance(seeds, (list, tuple)):
        if has_first:
            raise GridError("repeats.first: goes with a number of seeds, not with a list of them")
        if not seeds or any(
            not isinstance(one, int) or isinstance(one, bool) or not 0 <= one <= MOST_WHOLE for one in seeds
        ):
            raise GridError(f"{where}: whole numbers from 0 to 2^63 - 1 are expected, at least one")
        if len(set(seeds)) < len(seeds):
            raise GridError(f"{where}: a seed is given twice; each is run once")
        return list(seeds)
    for place, number, least in ((where, seeds, 1), ("repeats.first", first, 0)):
        if not isinstance(number, int) or isinstance(number, bool) or not least <= number <= MOST_RUNS:
            raise GridError(f"{place}: a whole number from {least} to {MOST_RUNS} is expected")
    return list(range(first, first + seeds))
