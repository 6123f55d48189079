"""The Python of docs/python.md runs, and gives the figures that its comments say."""

import re

import pytest
from locations import ROOT


def test_the_python_of_its_page(capsys: pytest.CaptureFixture[str]) -> None:
    [program] = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "python.md").read_text(encoding="utf-8"), re.DOTALL)
    [fewest] = re.findall(r"# the fewest DSPs without a miss: (\S+)", program)
    [r1] = re.findall(r"# (\d+\.\d), and the cycles it took", program)
    exec(program, {})  # noqa: S102
    *_, dsps, last = capsys.readouterr().out.splitlines()
    assert dsps == fewest and last.split()[0] == r1 and int(last.split()[1]) >= 2
