"""The directives that occur in public sources, each with the first line that has it: a table of docs/assembler.md (Old
sources)."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import foreign_ti

PLACE = Path(__file__).resolve().parent.parent / "build-foreign"
COLLECTIONS = ("helios", "cps", "cruisin")
SUFFIXES = {".asm", ".inc", ".equ", ".hasm"}
DIRECTIVE = re.compile(r"(?:[A-Za-z_$][\w$?]*:?)?[ \t]+(\.[A-Za-z_]\w*)(?=[\s;]|$)")


def texts() -> Iterator[tuple[str, str]]:
    """Raises FileNotFoundError for a collection that has not been fetched."""
    for name in COLLECTIONS:
        for path in sorted((PLACE / name).glob("**/*")):
            if path.suffix.lower() in SUFFIXES:
                yield f"{name}: {path.name}", path.read_text(encoding="latin-1")
    for archive in foreign_ti.SOURCES:
        for member, text in foreign_ti.members((PLACE / "ti" / "Release" / "lib" / archive).read_bytes()):
            if member.endswith(".asm"):
                yield f"ti: {member}", text.decode("latin-1")


def table() -> str:
    """Markdown, by the directives' names. A macro's parameter is none."""
    first: dict[str, tuple[str, str]] = {}
    lines: dict[str, int] = {}
    for where, text in texts():
        for number, line in enumerate(text.splitlines(), start=1):
            found = None if line.startswith(("*", ";")) else DIRECTIVE.match(line)
            if found is None:
                continue
            name = found[1].lower()
            lines[name] = lines.get(name, 0) + 1
            first.setdefault(name, (f"{where}:{number}", " ".join(line.split(";")[0].split())))
    rows = [f"| `{name}` | `{first[name][1][:60]}` | {first[name][0]} | {lines[name]} |" for name in sorted(first)]
    return "\n".join(["| directive | first line that has it | where | lines |", "|---|---|---|--:|", *rows])


def report() -> int:
    try:
        print(table())
    except FileNotFoundError as error:
        print(f"directives: {error.filename} is not there: scripts/foreign {', '.join((*COLLECTIONS, 'ti'))}")
        return 2
    return 0
