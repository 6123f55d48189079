"""The figures in README.md and docs/ are those that the named command prints.

A block of output has a comment above it that names its command:

    <!-- printed by: emulator --dsps 4 --duration 2 | from "Deadlines" to "grab_path" -->

Commands are ``emulator ...``, ``python -m cmrc ...`` and ``python FILE ...`` of a script in the tree. ``from "A" to
"B"`` takes the lines from the first one that begins with A to the next one that begins with B. Several such parts,
separated by commas, are shown with a blank line between them. ``cut N`` at the end leaves out all beyond column N.
``table``: the whole output is a table, which the page has below. In prose, ``says "..."`` names what the output and the
paragraph (or table) below both say; runs of blanks count as one. ``campaign`` at the end keeps long runs out of the
suite. ``pytest tests/docs --update-golden`` (with ``-m campaign`` for the long ones) writes blocks and tables again.

Where a test holds a figure, the comment names test and phrases; each number of a phrase is in the source of that
test:

    <!-- held by: tests/kernels/test_heartbeat.py::test_a_beat_keeps_registers_and_status | says "17 cycles" -->

Figures of speed (docs/speed.md) differ from machine to machine: they have their command, date and machine beside them
instead.
"""

import ast
import functools
import os
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from locations import BUILD, ROOT

MARK = re.compile(r"<!-- printed by: (?P<command>[^|]+?)(?P<parts>(?: \| .+?)?)(?P<campaign> \| campaign)? -->\n\n?")
HELD = re.compile(r"<!-- held by: (?P<test>\S+) \| (?P<says>says .+?) -->\n\n?")
PARTS = re.compile(r'from "([^"]*)" to "([^"]*)"')
CUT = re.compile(r" cut (\d+)$")
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


def paragraph_end(text: str, at: int) -> int:
    """Where the paragraph or table ends that follows, past further comments."""
    comments = re.compile(r"(?:<!--.*?-->\s*)*").match(text, at)
    end = text.find("\n\n", comments.end() if comments else at)
    return len(text) if end < 0 else end + 1


def places(page: Path) -> list[Printed]:
    text = page.read_text(encoding="utf-8")
    found = []
    for mark in MARK.finditer(text):
        rest = text[mark.end() :]
        if "says" in mark["parts"] or mark["parts"] == " | table":
            length = paragraph_end(text, mark.end()) - mark.end()
        else:
            length = len(re.match(r"(?:    .*\n|\n(?=\n?    ))*", rest)[0])  # type: ignore[index]
        line = text[: mark.start()].count("\n") + 1
        found.append(
            Printed(
                str(page.relative_to(ROOT)),
                line,
                mark["command"],
                mark["parts"],
                bool(mark["campaign"]),
                mark.end(),
                mark.end() + length,
            )
        )
    return found


PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))
ALL = [place for page in PAGES for place in places(page)]


@functools.cache
def output_of(command: str) -> str:
    words = shlex.split(command)
    script = words[0] == "python" and (words[1:3] == ["-m", "cmrc"] or (ROOT / words[1]).is_file())
    assert script or words[0] == "emulator", f"{command}: only emulator, python -m cmrc and scripts of the tree are run"
    program = sys.executable if script else str(BUILD / "bin" / "emulator")
    environment = {**os.environ, "PYTHONPATH": str(BUILD / "python"), "CMRC_BUILD_DIR": str(BUILD)}
    done = subprocess.run([program, *words[1:]], capture_output=True, text=True, check=False, cwd=ROOT, env=environment)
    assert done.stdout, done.stderr
    return done.stdout


def excerpt(output: str, parts: str) -> str:
    """The lines that the parts name, indented as the documents show them."""
    cut = CUT.search(parts)
    lines = [line[: int(cut[1])] if cut else line for line in output.splitlines()]
    chunks = []
    for first, last in PARTS.findall(parts):
        begin = next(i for i, line in enumerate(lines) if line.strip().startswith(first))
        end = next(i for i in range(begin, len(lines)) if lines[i].strip().startswith(last))
        chunks.append("\n".join(f"    {line}".rstrip() for line in lines[begin : end + 1]))
    return "\n\n".join(chunks) + "\n"


def one_blank(text: str) -> str:
    return re.sub(r"\s+", " ", text)


@pytest.mark.parametrize(
    "place",
    [
        pytest.param(place, id=f"{place.page}:{place.line}", marks=[pytest.mark.campaign] if place.campaign else [])
        for place in ALL
    ],
)
def test_what_a_document_prints_is_what_its_command_prints(place: Printed, request: pytest.FixtureRequest) -> None:
    output = output_of(place.command)
    if "says" in place.parts:
        for phrase in SAYS.findall(place.parts):
            assert phrase in one_blank(output), (
                f"{place.page}:{place.line}: `{place.command}` does not say {phrase!r} any more"
            )
            assert phrase in one_blank(place.text()), (
                f"{place.page}:{place.line}: the paragraph does not say {phrase!r}"
            )
        return
    now = output if place.parts == " | table" else excerpt(output, place.parts)
    if request.config.getoption("--update-golden"):
        page = ROOT / place.page
        [same] = [
            other for other in places(page) if (other.command, other.parts) == (place.command, place.parts)
        ]  # an earlier block may have grown
        text = page.read_text(encoding="utf-8")
        page.write_text(text[: same.begin] + now + text[same.end :], encoding="utf-8")
        return
    assert place.text() == now, (
        f"{place.page}:{place.line}: `{place.command}` prints something else; pytest tests/docs --update-golden writes it"
    )


def source_of(test: str) -> str:
    """The text of a test function with its decorators; the underscores of its numbers left out."""
    path, name = test.split("::")
    text = (ROOT / path).read_text(encoding="utf-8")
    [found] = [one for one in ast.parse(text).body if isinstance(one, ast.FunctionDef) and one.name == name]
    first = min([found.lineno, *(one.lineno for one in found.decorator_list)])
    return re.sub(r"(?<=\d)_(?=\d)", "", "\n".join(text.splitlines()[first - 1 : found.end_lineno]))


def numbers(text: str) -> set[float]:
    return set(map(float, re.findall(r"(?<![\w.])\d+(?:\.\d+)?(?![\w.]*\d)", re.sub(r"(?<=\d) (?=\d{3}\b)", "", text))))


HOLDING = [
    pytest.param(page, mark, id=f"{page.name}:{mark['test']}")
    for page in PAGES
    for mark in HELD.finditer(page.read_text(encoding="utf-8"))
]


@pytest.mark.parametrize(("page", "mark"), HOLDING)
def test_what_a_document_says_a_test_holds_stands_in_that_test(page: Path, mark: re.Match[str]) -> None:
    paragraph = one_blank(mark.string[mark.end() : paragraph_end(mark.string, mark.end())])
    holds = numbers(source_of(mark["test"]))
    phrases = SAYS.findall(mark["says"])
    assert phrases and all(map(numbers, phrases)), f"{page.name}: {mark[0]} names no figure"
    for phrase in phrases:
        assert phrase in paragraph, f"{page.name}: the paragraph does not say {phrase!r}"
        assert numbers(phrase) <= holds, f"{page.name}: {mark['test']} does not hold {phrase!r}"


def test_documents_show_something() -> None:
    assert len(ALL) >= 20 and len(HOLDING) >= 3
