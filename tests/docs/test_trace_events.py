"""The events that docs/trace.md lists are those that a run can write."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
UNUSED = {"start", "push"}  # their numbers are taken (emulator/report/events/event.hpp), no code writes them


def listed() -> set[str]:
    table = (ROOT / "docs/trace.md").read_text().split("| event | component | arguments |")[1].split("\n\n")[0]
    return {name for row in table.splitlines()[2:] for name in re.findall(r"`(\w+)`", row.split("|")[1])}


def written() -> set[str]:
    sources = [file for file in (ROOT / "emulator/cmrc").rglob("*.cpp") if "timelines" not in file.parts]
    return {name for file in sources for name in re.findall(r"EventKind::(\w+)", file.read_text())}


def test_the_page_lists_what_is_written() -> None:
    known = set(re.findall(r"EventKind::\w+, \"(\w+)\"", (ROOT / "emulator/report/events/event.cpp").read_text()))
    assert listed() == known & written()
    assert known - written() == UNUSED
