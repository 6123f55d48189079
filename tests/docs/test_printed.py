"""Figures printed in README.md and docs/ are those that the command beside them prints.

A block of output stands under a comment that names its command:

    <!-- printed by: emulator --dsps 4 --duration 2 | from "Deadlines" to "grab_path" -->

``from ... to ...`` takes the lines from the first one that begins so to the next one that begins so; several, separated by a comma, stand
with a blank line between. In prose, ``says "..."`` names what the output and the paragraph below both say. ``campaign`` at the end keeps
long runs out of the suite. ``pytest tests/docs --update-golden`` (with ``-m campaign`` for the long ones) writes the blocks anew.
"""

import re
import shlex
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest
from locations import BUILD, ROOT

MARK = re.compile(r"<!-- printed by: (?P<command>[^|]+?)(?P<parts>(?: \| .+?)?)(?P<campaign> \| campaign)? -->\n\n?")
PARTS = re.compile(r'from "([^"]*)" to "([^"]*)"')
SAYS = re.compile(r'"([^"]*)"')


@dataclass(frozen=True)
class Printed:
    """A place in a document that shows what a command prints."""

    page: str
    line: int
    command: str
    parts: str
    campaign: bool
    begin: int
    end: int

    def text(self) -> str:
        return (ROOT / self.page).read_text(encoding="utf-8")[self.begin : self.end]


def places(page: Path) -> list[Printed]:
    text = page.read_text(encoding="utf-8")
    found = []
    for mark in MARK.finditer(text):
        rest = text[mark.end() :]
        if "says" in mark["parts"]:
            length = len(rest.split("\n\n", 1)[0])
        else:
            length = len(re.match(r"(?:    .*\n|\n(?=\n?    ))*", rest)[0])  # type: ignore[index]
        line = text[: mark.start()].count("\n") + 1
        found.append(Printed(str(page.relative_to(ROOT)), line, mark["command"], mark["parts"], bool(mark["campaign"]), mark.end(), mark.end() + length))
    return found


ALL = [place for page in (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))) for place in places(page)]


def output_of(command: str) -> str:
    words = shlex.split(command)
    assert words[0] == "emulator", f"{command}: only the emulator's commands are run"
    done = subprocess.run([BUILD / "bin" / "emulator", *words[1:]], capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.stdout, done.stderr
    return done.stdout


def excerpt(output: str, parts: str) -> str:
    """The lines that the parts name, indented as the documents show them."""
    lines = output.splitlines()
    chunks = []
    for first, last in PARTS.findall(parts):
        begin = next(i for i, line in enumerate(lines) if line.strip().startswith(first))
        end = next(i for i in range(begin, len(lines)) if lines[i].strip().startswith(last))
        chunks.append("\n".join(f"    {line}".rstrip() for line in lines[begin : end + 1]))
    return "\n\n".join(chunks) + "\n"


@pytest.mark.parametrize(
    "place",
    [pytest.param(place, id=f"{place.page}:{place.line}", marks=[pytest.mark.campaign] if place.campaign else []) for place in ALL],
)
def test_what_a_document_prints_is_what_its_command_prints(place: Printed, request: pytest.FixtureRequest) -> None:
    output = output_of(place.command)
    if "says" in place.parts:
        for phrase in SAYS.findall(place.parts):
            assert phrase in output, f"{place.page}:{place.line}: `{place.command}` does not say {phrase!r} any more"
            assert phrase in place.text(), f"{place.page}:{place.line}: the paragraph does not say {phrase!r}"
        return
    now = excerpt(output, place.parts)
    if request.config.getoption("--update-golden"):
        page = ROOT / place.page
        [same] = [other for other in places(page) if (other.command, other.parts) == (place.command, place.parts)]  # an earlier block may have grown
        text = page.read_text(encoding="utf-8")
        page.write_text(text[: same.begin] + now + text[same.end :], encoding="utf-8")
        return
    assert place.text() == now, f"{place.page}:{place.line}: `{place.command}` prints something else; pytest tests/docs --update-golden writes it"


def test_documents_show_something() -> None:
    assert len(ALL) >= 3
