"""Saved states, value by value: whatever is listed is loaded, and a comparison names it."""

from collections.abc import Callable
from typing import Any


def check_that_every_value_is_loaded(make: Callable[[], Any], full: Any, leave_out: Callable[[str], bool] = lambda path: False) -> int:
    """Changes each number of `full`'s state by a bit, loads it into a new object, saves that, and looks for the change.

    `leave_out` tells the paths of which another value is no state. Returns how many values were changed."""
    state = full._state()
    again = make()
    again._load_state(state)
    assert again._state() == state and full._state_difference(again) is None
    changed = 0
    leaves = full._state_leaves()
    for (path, offset, size), (following, _, _) in zip(leaves, [*leaves[1:], ("", 0, 0)], strict=True):
        # Not numbers: how many there are of something; which alternative a variant has, which stands before its value.
        if path.endswith(".count") or path == following or size not in (1, 2, 4, 8, 16) or leave_out(path):
            continue
        other = bytearray(state)
        other[offset] ^= 1
        again = make()
        again._load_state(bytes(other))
        assert again._state() == bytes(other), path
        difference = full._state_difference(again)
        assert difference is not None and difference.startswith(path + ": "), (path, difference)
        changed += 1
    return changed


def check_that_other_bytes_are_refused(make: Callable[[], Any], state: bytes) -> None:
    import pytest

    for wrong in (state[:-1], state + b"\0", b"\xff" * len(state), b""):
        with pytest.raises(ValueError, match="no snapshot of this version"):
            make()._load_state(wrong)
