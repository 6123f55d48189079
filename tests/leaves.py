"""Saved states, value by value: every listed value is loaded, and a comparison names it."""

import re
from collections.abc import Callable, Iterable
from typing import Any

TOGETHER = 64  # values that are changed in one load


def check_that_every_value_is_loaded(
    make: Callable[[], Any], full: Any, leave_out: Callable[[str], bool] = lambda path: False
) -> int:
    """Changes each number of `full`'s state by a bit, loads that into a new object, saves it, and looks for the
    changes.

    `leave_out` tells the paths of which another value is no state. Returns how many values were changed."""
    state = full._state()
    again = make()
    again._load_state(state)
    assert again._state() == state and full._state_difference(again) is None
    leaves = full._state_leaves()
    numbers = [
        (path, offset)
        for (path, offset, size), (following, _, _) in zip(leaves, [*leaves[1:], ("", 0, 0)], strict=True)
        # Not numbers: how many there are of something; which alternative a variant has, a number before its value.
        if not (path.endswith(".count") or path == following or size not in (1, 2, 4, 8, 16) or leave_out(path))
    ]

    def fault(changed: list[tuple[str, int]]) -> str | None:
        other = bytearray(state)
        for _, offset in changed:
            other[offset] ^= 1
        again = make()
        again._load_state(bytes(other))
        difference = full._state_difference(again)
        if again._state() == bytes(other) and difference is not None and difference.startswith(changed[0][0] + ": "):
            return None
        return f"{changed[0][0]}: {difference}"

    def check(changed: list[tuple[str, int]]) -> None:
        if (found := fault(changed)) is None:
            return
        assert len(changed) > 1, found
        half = len(changed) // 2  # by themselves, as one of them may hide another
        check(changed[:half]), check(changed[half:])

    for first in range(0, len(numbers), TOGETHER):
        check(numbers[first : first + TOGETHER])
    return len(numbers)


def fields(objects: Iterable[Any]) -> str:
    """The fields that these objects' states list, a line each, with * for numbers, sorted. A golden file of them shows
    a field that is left out of both saving and loading, which may matter in one run of a thousand."""
    paths = (path for one in objects for path, _, _ in one._state_leaves())
    return "".join(sorted({re.sub(r"(?<![^. ])\d+(?![^.])", "*", path) + "\n" for path in paths}))


def check_that_other_bytes_are_refused(make: Callable[[], Any], state: bytes) -> None:
    import pytest

    for wrong in (state[:-1], state + b"\0", b"\xff" * len(state), b""):
        with pytest.raises(ValueError, match="no snapshot of this version"):
            make()._load_state(wrong)
