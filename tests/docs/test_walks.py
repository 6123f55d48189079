"""Pages that are walked through: the commands of docs/paths/ and docs/how-to/ run, and print what the pages show.

The blocks ```sh, ```python, ```asm and ```toml of a page are done in their order, in one empty folder that has `build`,
`c40_programs` and `examples` of the tree. `sh` and `python` are run. `asm` and `toml` are written to the file that
their first line names in a comment. A block ```text right after a run is what the run prints: its lines are in the
output in this order, `...` for any lines between.
A block ```cpp is, without its first line, in the file of the tree that its first line names.
A page with `<!-- campaign -->` takes long and is left out of the suite.
"""

import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from locations import BUILD, ROOT

PAGES = [page for folder in ("paths", "how-to") for page in sorted((ROOT / "docs" / folder).glob("*.md"))]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```\n", re.MULTILINE | re.DOTALL)
QUOTED = re.compile(r"// (\S+\.[ch]pp)\n")
FILE = re.compile(r"[;#] (\S+\.(?:asm|toml|txt))\b")


@dataclass(frozen=True)
class Block:
    language: str
    text: str
    line: int
    follows: bool
    """nothing but blank lines is between the block before and this one"""


def blocks(text: str) -> list[Block]:
    found, end = [], 0
    for match in BLOCK.finditer(text):
        found.append(
            Block(match[1], match[2], text.count("\n", 0, match.start()) + 1, not text[end : match.start()].strip())
        )
        end = match.end()
    return found


def environment(folder: Path) -> dict[str, str]:
    for name, target in (("build", BUILD), ("c40_programs", ROOT / "c40_programs"), ("examples", ROOT / "examples")):
        (folder / name).symlink_to(target)
    programs = folder / ".programs"
    programs.mkdir()
    (programs / "python").symlink_to(sys.executable)
    return {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}", "PYTHONPATH": str(BUILD / "python")}


def run(block: Block, folder: Path, env: dict[str, str]) -> str:
    command = (
        ["bash", "-euo", "pipefail", "-c", block.text] if block.language == "sh" else [sys.executable, "-c", block.text]
    )
    done = subprocess.run(command, cwd=folder, env=env, capture_output=True, text=True, check=False, timeout=900)
    assert done.returncode == 0, (
        f"line {block.line}: status {done.returncode}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}"
    )
    return done.stdout


def not_printed(expected: str, output: str) -> str | None:
    """The first line that the output has not at its place."""
    lines = [line.rstrip() for line in output.splitlines()]
    at, gap = 0, True
    for line in (line.rstrip() for line in expected.splitlines()):
        if line.strip() == "...":
            gap = True
            continue
        try:
            found = lines.index(line, at)
        except ValueError:
            return line
        if not gap and found != at:
            return line
        at, gap = found + 1, False
    return None


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(
            page,
            id=page.stem,
            marks=[pytest.mark.campaign] if "<!-- campaign -->" in page.read_text(encoding="utf-8") else [],
        )
        for page in PAGES
    ],
)
def test_a_page_can_be_walked_through(page: Path, tmp_path: Path) -> None:
    env = environment(tmp_path)
    output = None
    for block in blocks(page.read_text(encoding="utf-8")):
        if block.language in ("sh", "python"):
            output = run(block, tmp_path, env)
        elif block.language == "text" and output is not None and block.follows:
            line = not_printed(block.text, output)
            assert line is None, (
                f"{page.name}:{block.line}: the commands above do not print, at its place: {line!r}\n{output}"
            )
        elif block.language == "cpp":
            quoted = QUOTED.match(block.text)
            assert quoted, f"{page.name}:{block.line}: a block of C++ whose first line names no file"
            assert block.text[quoted.end() :] in (ROOT / quoted[1]).read_text(encoding="utf-8"), (
                f"{page.name}:{block.line}: {quoted[1]} reads otherwise"
            )
        else:
            named = FILE.match(block.text)
            assert named, f"{page.name}:{block.line}: a block of {block.language} whose first line names no file"
            (tmp_path / named[1]).write_text(block.text, encoding="utf-8")


@pytest.mark.parametrize(
    ("expected", "missing"),
    [("a\nb\n", None), ("a\n...\nd\n", None), ("b\nc\n", None), ("a\nc\n", "c"), ("d\na\n", "a"), ("...\nx\n", "x")],
)
def test_lines_are_looked_for_in_their_order(expected: str, missing: str | None) -> None:
    assert not_printed(expected, "a\nb\nc\nd\n") == missing


def test_there_are_pages_that_print_something() -> None:
    assert sum(block.language == "text" for page in PAGES for block in blocks(page.read_text(encoding="utf-8"))) >= 10
