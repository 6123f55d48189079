"""Each citation in the tree leads to an anchor of docs/reference/."""

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from citations import anchors, citations
from locations import ROOT

REFERENCE = ROOT / "docs" / "reference"
OTHER_FORMS = {".svg", ".xz", ".png", ".out", ".bin", ".gz"}
# Tests of the citations themselves; texts of others; what commands wrote.
LEFT_OUT = ("tests/docs/test_citations.py", "tests/docs/citations.py", "LICENSE", "NOTICE", "tests/golden/")


def sources() -> list[str]:
    """Files of the tree that git knows or would add; in a tree without git, all that are no build's."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    if listed.returncode == 0:
        names = listed.stdout.splitlines()
    else:
        names = [
            str(path.relative_to(ROOT))
            for path in ROOT.rglob("*")
            if path.is_file() and not re.match(r"build|\.venv|\.git", path.relative_to(ROOT).parts[0])
        ]
    return [
        n
        for n in sorted(set(names))
        if not n.startswith(LEFT_OUT) and Path(n).suffix not in OTHER_FORMS and (ROOT / n).is_file()
    ]


def broken(name: str, text: str) -> Iterator[str]:
    places = anchors(REFERENCE)
    for citation in citations(text):
        for target in citation.targets:
            if target not in places:
                line = text.count("\n", 0, citation.begin) + 1
                yield f"{name}:{line}: `{citation.words}` cites docs/reference/{target}, which does not exist"


def read(name: str) -> str:
    try:
        return (ROOT / name).read_text(encoding="utf-8")
    except UnicodeDecodeError:
        return ""


def test_every_citation_leads_somewhere() -> None:
    texts = {name: read(name) for name in sources()}
    assert not [message for name, text in texts.items() for message in broken(name, text)]
    # If a change of the patterns found nothing any more, the line above would hold for an empty list.
    assert sum(1 for text in texts.values() for _ in citations(text)) > 500


def test_every_page_that_is_named_exists() -> None:
    names = sources()
    pages = {n for n in names if n.endswith(".md")}
    known = {"/".join(Path(n).parts[i:]) for n in pages for i in range(len(Path(n).parts))}
    missing = []
    for name in names:
        text = read(name)
        for match in re.finditer(r"(?<![\w/<{*.-])(?:\.\./)*((?:[\w-]+/)*[\w-]+\.md)\b", text):
            # A test may name a page that it makes.
            if match[1] not in known and not (name.startswith("tests/") and "/" not in match[1]):
                missing.append(f"{name}:{text.count(chr(10), 0, match.start()) + 1}: {match[0]}")
    assert not missing


@pytest.mark.parametrize(
    ("text", "targets"),
    [
        (
            "(c40-isa.md 2.2, 7.1 to 7.7, 7.10)",
            ["c40-isa.md#2-2", "c40-isa.md#7-1", "c40-isa.md#7-7", "c40-isa.md#7-10"],
        ),
        ("// as c40-hardware.md\n/// 1.4 says", ["c40-hardware.md#1-4"]),
        ("plant-and-bus.md 4.4 items 13 to 16", ["plant-and-bus.md#4-4-13", "plant-and-bus.md#4-4-16"]),
        ("`plant-and-bus.md` 2.2 assumes 150 000", ["plant-and-bus.md#2-2"]),
        ("Rulings 24, 36; issue 6", ["decisions.md#ruling-24", "decisions.md#ruling-36", "decisions.md#issue-6"]),
        ("paper section 3, the paper's table 1", ["paper.md#3", "paper.md#table-1"]),
        ("equations (2) to (4)", ["paper.md#equation-2", "paper.md#equation-4"]),
        ("rulings.md 5", ["rulings.md"]),
        ("a paper of 1999, an issue of 3 words, the ruling", []),
    ],
)
def test_citations_are_read(text: str, targets: list[str]) -> None:
    assert [t for c in citations(text) for t in c.targets] == targets


def test_a_citation_that_leads_nowhere_is_named_with_its_place() -> None:
    [message] = broken("some/file.cpp", "// one\n// two (ruling 1, c40-isa.md 99.9)\n")
    assert message.startswith("some/file.cpp:2: `c40-isa.md 99.9`")


def test_sections_that_programs_name_exist() -> None:
    """The instruction table's rows and the self-checks name sections of c40-isa.md and c40-hardware.md as data."""
    from cmrc import _core

    isa = {row["section"] for row in _core.isa.rows()}
    checks = read("emulator/c40/observers/self_check.cpp")
    named = set(re.findall(r'"(\d+(?:\.\d+)?)"', checks))
    assert isa and len(named) > 5
    places = anchors(REFERENCE)
    assert {f"c40-isa.md#{s.replace('.', '-')}" for s in isa} <= places
    missing = {
        s for s in named if not {f"{page}#{s.replace('.', '-')}" for page in ("c40-isa.md", "c40-hardware.md")} & places
    }
    assert not missing


def test_anchors_are_named_once() -> None:
    for page in REFERENCE.glob("*.md"):
        found = re.findall(r'<a id="([^"]+)">', page.read_text(encoding="utf-8"))
        assert len(found) == len(set(found)), page.name


HEADING = re.compile(
    r"(?:\]\((?:\.\./)*(?P<link>[\w/-]+\.md)\)|docs/(?P<path>[\w-]+\.md)),\s+(?:(?://+|#|;)\s*)?"
    r"(?P<words>[A-Z][\w`\[\] -]*)"
)
"""A page and a part of it: `docs/report.md, Why late`, `[report.md](report.md), Why late`"""


def parts(text: str) -> set[str]:
    """What a page may be cited by: its headings, and the bold or first words of its paragraphs."""
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    bold = re.findall(r"\*\*([^*]+)\*\*", text)
    first = re.findall(r"\n\n(?:[-*] )?([A-Z][\w -]{2,40})[:.]\s", text)
    return {re.sub(r"[`*.]", "", part).strip().lower() for part in (*headings, *bold, *first)}


def test_every_part_of_a_page_that_is_named_exists() -> None:
    pages: dict[str, set[str]] = {}
    for page in (*(ROOT / "docs").rglob("*.md"), *(ROOT / "c40_programs").rglob("*.md")):
        pages.setdefault(page.name, set()).update(parts(page.read_text(encoding="utf-8")))
    missing, seen = [], 0
    for name in sources():
        if name.startswith("docs/reference/"):
            continue
        text = read(name)
        for match in HEADING.finditer(text):
            seen += 1
            page = Path(match["link"] or match["path"]).name
            words = re.sub(r"`", "", match["words"]).strip().lower()
            if not any(part.startswith(words) or words.startswith(part) for part in pages.get(page, ())):
                missing.append(
                    f"{name}:{text.count(chr(10), 0, match.start()) + 1}: {page} has no part `{match['words']}`"
                )
    assert not missing
    assert seen > 100


PATH = re.compile(
    r"`((?:emulator|bus_model|plant|python|c40_programs|tests|fuzz|scripts|examples|editors|docs)/[\w.*/-]*)(?:::\w+)?`"
)


def test_every_file_that_a_page_names_exists() -> None:
    missing, seen = [], 0
    for page in (*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "c40_programs").rglob("*.md")):
        text = page.read_text(encoding="utf-8")
        for match in PATH.finditer(text):
            seen += 1
            # NAME stands for any name.
            if not any(ROOT.glob(match[1].replace("NAME", "*").rstrip("/"))):
                missing.append(f"{page.relative_to(ROOT)}:{text.count(chr(10), 0, match.start()) + 1}: {match[1]}")
    assert not missing
    assert seen > 100
