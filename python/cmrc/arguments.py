"""Checks of arguments: one message with the argument's name, its value, and what would be right.

Each function returns the argument in the right type. Raises TypeError for a wrong type, ValueError for a wrong value.
"""

from __future__ import annotations

import functools
import math
import numbers
import operator
import os
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NoReturn, ParamSpec, TypeVar

Kind = TypeVar("Kind")
Drawn = TypeVar("Drawn")
P = ParamSpec("P")


NUMBER = re.compile(
    r"-?\d+|0x[\da-f]+|-?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?|-?(?:inf|infinity|nan)", re.ASCII | re.IGNORECASE
)
"""What ``emulator`` takes for a number (emulator/isa/ascii.hpp). Python's own conversions also take 1_0, +1, blanks and
the digits of other scripts."""


WHOLE = re.compile(r"-?\d+|0x[\da-f]+", re.ASCII | re.IGNORECASE)


def read_number(text: str) -> int | float:
    """A number on a command line. Raises ValueError."""
    if NUMBER.fullmatch(text) is None:
        raise ValueError(f"{text!r} is no number")
    try:
        return read_whole(text)
    except ValueError:
        return float(text)


def read_whole(text: str) -> int:
    """The same of a whole number. Raises ValueError."""
    if WHOLE.fullmatch(text) is None:
        raise ValueError(f"{text!r} is no whole number")
    return int(text, 16 if text[:2] in ("0x", "0X") else 10)


def whole_option(text: str) -> int:
    """The type of an option that is a whole number, for argparse."""
    try:
        return read_whole(text)
    except ValueError:
        from argparse import ArgumentTypeError

        raise ArgumentTypeError(f"{text!r} cannot be used; a whole number is expected") from None


def refuse(name: str, value: object, right: str) -> NoReturn:
    raise TypeError(f"{name}: {shown(value)} ({type(value).__name__}) cannot be used; {right} is expected")


def shown(value: object) -> str:
    try:
        shown = repr(value)
    except ValueError:  # Python writes no integer of more than 4300 digits
        return "a number of thousands of digits"
    return shown if len(shown) <= 60 else shown[:57] + "..."


def mapping(name: str, value: object, right: str) -> dict[str, Any]:
    """A dictionary with names as keys; None is an empty one."""
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        refuse(name, value, right)
    for key in value:
        if not isinstance(key, str):
            refuse(f"{name}, key", key, "a name")
    return dict(value)


def chips(name: str, value: object, right: str) -> Mapping[Any, Any]:
    """A dictionary with numbers of chips as keys; None is an empty one."""
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        refuse(name, value, right)
    return value


def items(name: str, value: object, right: str) -> list[Any]:
    """A list, tuple, array or generator; not a text, not a dictionary."""
    if isinstance(value, (str, bytes, Mapping)) or not isinstance(value, Iterable):
        refuse(name, value, right)
    return list(value)


def text(name: str, value: object, right: str = "a text") -> str:
    if not isinstance(value, str):
        refuse(name, value, right)
    return value


def path(name: str, value: object, right: str = "the path of a file") -> str:
    if not isinstance(value, (str, os.PathLike)):
        refuse(name, value, right)
    found = os.fspath(value)
    if not isinstance(found, str):
        found = os.fsdecode(found)
    if "\0" in found:
        raise ValueError(f"{name}: {found!r} contains a zero byte; {right} is expected")
    try:
        os.fsencode(found)
    except UnicodeEncodeError:
        raise ValueError(f"{name}: {found!r} has a surrogate that stands for no byte; {right} is expected") from None
    return found


def number(name: str, value: object, right: str = "a number", least: float = -math.inf) -> float:
    if not isinstance(value, numbers.Real):
        refuse(name, value, right)
    try:
        found = float(value)
    except OverflowError:
        raise ValueError(f"{name}: {shown(value)} is beyond the range of a double; {right} is expected") from None
    if not found >= least:  # nan is neither
        raise ValueError(
            f"{name}: {value} is no {'number' if math.isnan(found) else 'possible value'}; {right} is expected"
        )
    return found


def whole(name: str, value: object, right: str, least: int = 0, most: int = 2**32 - 1) -> int:
    try:
        found = operator.index(value)  # type: ignore[arg-type]  # what has no __index__ is what is looked for
    except TypeError:
        refuse(name, value, right)
    if not least <= found <= most:
        raise ValueError(f"{name}: {shown(found)} is out of range; {right} is expected")
    return found


def flag(name: str, value: object) -> bool:
    if type(value).__module__ == "numpy" and type(value).__name__.startswith("bool"):
        return bool(value)
    if value is not True and value is not False:
        refuse(name, value, "True or False")
    return value


def function(name: str, value: object, right: str) -> None:
    """None or a callable."""
    if value is not None and not callable(value):
        refuse(name, value, right)


def instance(name: str, value: object, kind: type[Kind], right: str) -> Kind:
    if not isinstance(value, kind):
        refuse(name, value, right)
    return value


def drawn_from(name: str, kind: Callable[[], type], right: str) -> Callable[[Callable[P, Drawn]], Callable[P, Drawn]]:
    """A plot whose first argument must be of a class; ``kind`` gives the class when it is called. The second one, if it
    has one, is an Axes."""

    def decorate(plot: Callable[P, Drawn]) -> Callable[P, Drawn]:
        @functools.wraps(plot)
        def checked(*given: P.args, **keywords: P.kwargs) -> Drawn:
            if given or name in keywords:
                instance(name, given[0] if given else keywords[name], kind(), right)
            axes = given[1:2] or ([keywords["axes"]] if "axes" in keywords else [])
            if axes and not hasattr(axes[0], "add_patch"):
                refuse("axes", axes[0], "an Axes of matplotlib")
            return plot(*given, **keywords)

        return checked

    return decorate
