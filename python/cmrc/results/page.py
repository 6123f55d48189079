"""docs/results.md: one section per claim, each replaced alone."""

from __future__ import annotations

import re
from pathlib import Path

INTRODUCTION = """# The six claims

The paper (section 7 of its digest) gives no measured figures. Here each of its claims is put to an experiment on the emulator; `make results` regenerates this page: every number, table, plot and verdict.
One claim, or with other parameters:

    python -m cmrc.results --claim 3 --dsps 1,2,4 --trials 20     # prints the section
    python -m cmrc.results --help                                 # all parameters

A verdict is *holds*, *holds in part*, *fails*, or *not tested* where the parameters leave nothing to decide. What is not said is as [configuration.md](configuration.md) has it by default.
"""


def _marks(number: int) -> tuple[str, str]:
    return f"<!-- claim {number} -->", f"<!-- end of claim {number} -->"


def replaced(page: str, number: int, section: str) -> str:
    """The page with the section of this claim put in, in order of the numbers."""
    first, last = _marks(number)
    body = f"{first}\n{section.rstrip()}\n{last}\n"
    sections = {int(m[1]): m[0] + "\n" for m in re.finditer(r"<!-- claim (\d+) -->.*?<!-- end of claim \1 -->", page, re.DOTALL)}
    sections[number] = body
    return INTRODUCTION + "\n" + "\n".join(sections[n] for n in sorted(sections))


def write(path: Path, number: int, section: str) -> None:
    """Puts a section into the page at ``path``, which need not exist."""
    page = path.read_text(encoding="utf-8") if path.exists() else ""
    path.write_text(replaced(page, number, section), encoding="utf-8")
