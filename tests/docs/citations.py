"""Citations in the tree, and the anchors of docs/reference/ that they name (docs/reference/README.md has the forms).

    c40-isa.md 2.2, 7.1 to 7.7      sections of a page: c40-isa.md#2-2, #7-1, #7-7
    plant-and-bus.md 4.6 item 1     a row of the section's table: plant-and-bus.md#4-6-1
    paper section 6, paper 6        paper.md#6; also `equation (7)`, `paper table 1`
    ruling 33, rulings 16 to 18     decisions.md#ruling-33; also `issue 6`

A list or a range cites each number that it names. The number may be on the next line of a comment.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

PAGES = ("paper", "measures", "control-notes", "c40-isa", "c40-hardware", "plant-and-bus")

_GAP = r"(?:[ \t]+|[ \t]*\r?\n[ \t]*(?://[/!]*|#|;|\*)?[ \t]*)"
_SECTION = r"\d+(?:\.\d+)*"
_JOIN = rf"(?:,?{_GAP}(?:and|to|or){_GAP}|,{_GAP}|–)"
_LIST = rf"{_SECTION}(?:{_JOIN}{_SECTION})*"
_NUMBERS = rf"\d+(?:{_JOIN}\d+)*\b(?!\.\d)"

_PAGE = re.compile(
    rf"\b(?P<page>{'|'.join(PAGES)})\.md`?(?:,?{_GAP}(?:sections?{_GAP})?(?P<sections>{_LIST})"
    rf"(?:,?{_GAP}items?{_GAP}(?P<items>{_NUMBERS}))?)?"
)
_DECISION = re.compile(rf"\b(?P<kind>[Rr]uling|[Ii]ssue)s?{_GAP}(?P<numbers>{_NUMBERS})")
_PAPER = re.compile(rf"\bpaper(?:'s)?{_GAP}(?P<table>table{_GAP})?(?:sections?{_GAP})?(?P<numbers>{_NUMBERS})")
_EQUATION = re.compile(rf"\b(?:[Ee]quations?|paper's){_GAP}\((?P<first>\d+)\)(?:{_JOIN}\((?P<last>\d+)\))?")
_UNKNOWN = re.compile(r"(?<![\w/.-])(?:rulings|design)\.md\b")
# A pattern, and words of which each of its citations has one: most files have none, and are done at once.
_FORMS = (
    (_PAGE, (".md",)),
    (_DECISION, ("uling", "ssue")),
    (_PAPER, ("paper",)),
    (_EQUATION, ("quation", "paper's")),
    (_UNKNOWN, (".md",)),
)
_ANCHOR = re.compile(r'<a id="([^"]+)">')


@dataclass(frozen=True)
class Citation:
    """One citation: the place of its words in the text, and the places `page#anchor` that it names."""

    begin: int
    end: int
    words: str
    targets: tuple[str, ...]


def _each(numbers: str) -> list[str]:
    return re.findall(_SECTION, numbers)


def _targets(match: re.Match[str]) -> tuple[str, ...]:
    if match.re is _UNKNOWN:
        return (match[0],)
    if match.re is _DECISION:
        return tuple(f"decisions.md#{match['kind'].lower()}-{n}" for n in _each(match["numbers"]))
    if match.re is _PAPER:
        kind = "table-" if match["table"] else ""
        return tuple(f"paper.md#{kind}{n}" for n in _each(match["numbers"]))
    if match.re is _EQUATION:
        return tuple(f"paper.md#equation-{n}" for n in (match["first"], match["last"]) if n)
    page = f"{match['page']}.md"
    if match["sections"] is None:
        return (page,)
    sections = [n.replace(".", "-") for n in _each(match["sections"])]
    if match["items"] is None:
        return tuple(f"{page}#{n}" for n in sections)
    return tuple(f"{page}#{sections[-1]}-{n}" for n in _each(match["items"]))


def citations(text: str) -> Iterator[Citation]:
    """The citations of a text, in their order."""
    found = [m for form, words in _FORMS if any(w in text for w in words) for m in form.finditer(text)]
    for match in sorted(found, key=lambda m: m.start()):
        yield Citation(match.start(), match.end(), match[0], _targets(match))


@cache
def anchors(reference: Path) -> frozenset[str]:
    """What can be cited: the pages of the folder, and `page#anchor` for each of their anchors."""
    places = set()
    for page in reference.glob("*.md"):
        places.add(page.name)
        places |= {f"{page.name}#{a}" for a in _ANCHOR.findall(page.read_text(encoding="utf-8"))}
    return frozenset(places)
