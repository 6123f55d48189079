"""tests/slow_tests.txt names tests that exist: a renamed one would run in the fast tier unnoticed."""

import ast
from functools import cache
from pathlib import Path

import pytest
from locations import ROOT

LIST = ROOT / "tests" / "slow_tests.txt"
NAMES = LIST.read_text().split()


@cache
def functions(file: Path) -> frozenset[str]:
    return frozenset(node.name for node in ast.parse(file.read_text()).body if isinstance(node, ast.FunctionDef))


def stale(names: list[str]) -> list[str]:
    gone = []
    for name in names:
        file, _, function = name.partition("::")
        if not (ROOT / file).is_file() or function not in functions(ROOT / file):
            gone.append(name)
    return gone


def test_every_name_is_a_test() -> None:
    assert stale(NAMES) == [], "tests/spent.py FILE --slow 0.25 prints the list again"
    assert len(NAMES) == len(set(NAMES)) > 100


@pytest.mark.parametrize(
    "name", ["tests/no/test_file.py::test_it", f"{Path(__file__).relative_to(ROOT)}::test_of_yesterday"]
)
def test_a_name_that_is_gone_is_found(name: str) -> None:
    assert stale([*NAMES[:3], name]) == [name]
