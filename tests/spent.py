"""Processor time of each test, its subprocesses, a browser and new fixtures included: `pytest --spent FILE`.

FILE gets a line for each test. `python tests/spent.py FILE` sums them by files of tests, dearest first; with a part of
a file's name behind, it lists the tests of those files. `python tests/spent.py FILE --slow SECONDS` prints the
functions of tests that take so long or longer: tests/slow_tests.txt, all that `pytest -m fast` leaves out.
"""

import os
import resource
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest


def seconds() -> float:
    """Processor time of this process, of those that it started and waited for, and of those that still run, in s."""
    used = (resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN))
    return sum(each.ru_utime + each.ru_stime for each in used) + seconds_of_those_that_run()


def seconds_of_those_that_run() -> float:
    """Processor time of the processes below this one, and of those below them that have ended, in s."""
    parents: dict[int, int] = {}
    ticks: dict[int, int] = {}
    for process in Path("/proc").glob("[0-9]*"):
        try:  # after the name: state, parent; from the twelfth on user and system time, its own and its children's
            after = (process / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue  # it has ended
        parents[int(process.name)], ticks[int(process.name)] = int(after[1]), sum(map(int, after[11:15]))
    ours = {os.getpid()}
    while below := {one for one, parent in parents.items() if parent in ours} - ours:
        ours |= below
    return sum(ticks[one] for one in ours - {os.getpid()}) / os.sysconf("SC_CLK_TCK")


class Spent:
    """Measures from test to test, and writes when its process ends."""

    def __init__(self, output: Path) -> None:
        self.output = output
        self.lines: list[str] = []
        self.before = 0.0

    def take(self, name: str) -> None:
        now = seconds()
        self.lines.append(f"{now - self.before:.4f}\t{name}\n")
        self.before = now

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        if not self.lines:
            self.take("(start, collection)")
        yield
        self.take(item.nodeid)

    def pytest_unconfigure(self) -> None:
        self.take("(end)")
        with self.output.open("a") as stream:
            stream.write("".join(self.lines))


def main(path: Path, part: str | None) -> None:
    """Prints seconds and number of tests of each file; of each function of tests in files with `part` in the name."""
    took: Counter[str] = Counter()
    tests: Counter[str] = Counter()
    for line in path.read_text().splitlines():
        seconds_text, name = line.split("\t")
        file = name.split("::")[0]
        if part is not None and part not in file:
            continue
        key = file if part is None else name.split("[")[0]
        took[key] += float(seconds_text)  # type: ignore[assignment]
        tests[key] += 1
    for key, spent in took.most_common():
        print(f"{spent:8.1f} s {tests[key]:6d}  {key}")
    print(f"{sum(took.values()):8.1f} s {sum(tests.values()):6d}  together")


def slow(path: Path, limit: float) -> list[str]:
    """Functions of tests that take at least `limit` s of processor time, all their cases together."""
    took: Counter[str] = Counter()
    for line in path.read_text().splitlines():
        seconds_text, name = line.split("\t")
        if "::" in name:
            took[name.split("[")[0]] += float(seconds_text)  # type: ignore[assignment]
    return sorted(name for name, spent in took.items() if spent >= limit)


if __name__ == "__main__":
    if "--slow" in sys.argv:
        print("\n".join(slow(Path(sys.argv[1]), float(sys.argv[3]))))
    else:
        main(Path(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else None)
