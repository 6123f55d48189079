"""docs/results.md: one section per claim, each replaced alone."""

from __future__ import annotations

import re
import textwrap
from pathlib import Path

from cmrc import files

INTRODUCTION = """# The claims

The paper makes six claims (paper section 7) and gives no measured figures. Here each claim is put to an
experiment on the emulator. A seventh section is not the paper's: what missed deadlines cost.

`make results` regenerates this page: every number, table, plot and verdict. `pytest -m campaign
tests/python/test_results.py` compares it with what the commands give now. One claim, or with other parameters:

    python -m cmrc.results --claim 3 --dsps 1,2,4 --trials 20     # prints the section
    python -m cmrc.results --help                                 # all parameters, each explained

How to read it:

- A verdict is *holds*, *holds in part*, *fails*, or *not tested* where the parameters leave nothing to decide.
- No warm-up is left out. A run is counted from power-on; where a section counts in a window only (claim 3), it says
  which.
- *Missed*: late, lost, dropped, or never asked for although the ideal run does ([report.md](report.md), Rates).
  *Realised*: finished jobs per second.
- A run is reproducible bit for bit. A seed alone changes the noise of the sway sensor, and so hardly anything here. An
  interval [low, high] is printed only over something that was varied: the phases of all clocks but the drives'
  (`run.phase_jitter`), layouts, instants of events, or work cycles. Each section says which.
- *Settings*, at the end of each section, lists every setting of its runs that differs from the default
  ([configuration.md](configuration.md)). With these settings `emulator` and `cmrc.run` give one row of a table.
- Where *Settings* says that something was drawn, the reports have it, which `--cache FOLDER` keeps: a file for each
  run, a list of its reports. `configuration_toml` of a report is the run's configuration file, and
  `cmrc.run(config=report)` is the run.
"""


def marks(number: int) -> tuple[str, str]:
    """The text before and after a claim's section."""
    return f"<!-- claim {number} -->", f"<!-- end of claim {number} -->"


def wrapped(text: str, width: int = 120) -> str:
    """The same page with its paragraphs broken at ``width`` columns; headings, tables, pictures and code stay as they
    are."""
    lines = []
    for line in text.splitlines():
        fixed = len(line) <= width or line.startswith(("#", "|", "!", "    "))
        lines += (
            [line]
            if fixed
            else textwrap.wrap(
                line,
                width,
                subsequent_indent="  " if line.startswith("- ") else "",
                break_long_words=False,
                break_on_hyphens=False,
            )
        )
    return "\n".join(lines) + "\n"


def replaced(page: str, number: int, section: str) -> str:
    """The page with the section of this claim put in, in order of the numbers."""
    first, last = marks(number)
    body = f"{first}\n{section.rstrip()}\n{last}\n"
    sections = {
        int(m[1]): m[0] + "\n" for m in re.finditer(r"<!-- claim (\d+) -->.*?<!-- end of claim \1 -->", page, re.DOTALL)
    }
    sections[number] = body
    return wrapped(INTRODUCTION) + "\n" + "\n".join(sections[n] for n in sorted(sections))


def read(path: Path) -> str:
    """The page at ``path``, which need not exist. Raises OSError, ValueError."""
    try:
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return ""
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: no page ({files.reason(error)}); text in UTF-8 is expected") from None


def write(path: Path, number: int, section: str) -> None:
    """Puts a section into the page at ``path``, which need not exist. Raises OSError, ValueError."""
    files.write(path, replaced(read(path), number, section))
