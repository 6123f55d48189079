"""The plant against motions with a known answer."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from closed_forms import BENCHMARKS


@pytest.mark.parametrize("benchmark", BENCHMARKS, ids=lambda b: b.__name__)
def test_closed_form(benchmark):
    reached, allowed = benchmark()
    assert reached <= allowed
