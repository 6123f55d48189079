"""The order of the tests for several workers (pytest-xdist, `--dist worksteal`).

Each worker begins with an equal part of the tests, one after another in the list, and takes tests from another worker
when it has none left. So each part begins with files that have slow tests: at the end of the run only fast tests are
left, and no worker waits for a long one of another."""

from collections.abc import Callable, Sequence
from itertools import groupby
from typing import TypeVar

Test = TypeVar("Test")


def dealt(
    tests: Sequence[Test], workers: int, file_of: Callable[[Test], object], is_slow: Callable[[Test], bool]
) -> list[Test]:
    """The same tests, those of a file together. The files with slow tests are dealt to the workers in turn."""
    files = [list(group) for _, group in groupby(tests, key=file_of)]
    slow = [file for file in files if any(is_slow(test) for test in file)]
    fast = iter([file for file in files if not any(is_slow(test) for test in file)])
    order: list[Test] = []
    for worker in range(workers):
        for file in slow[worker::workers]:
            order += file
        while len(order) < len(tests) * (worker + 1) // workers and (file := next(fast, [])):
            order += file
    for file in fast:
        order += file
    return order
