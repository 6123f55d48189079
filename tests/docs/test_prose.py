"""Prose of the Markdown pages: lines of at most 120 columns, and the usual words; of sources the usual words, too.

Tables, code and output, comments, headings, and lines that are one link or one word may be longer.
"""

import ast
import io
import re
import subprocess
import tokenize
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest
from locations import ROOT

WIDTH = 120
FOLDERS = ("docs", "c40_programs", "editors", "tests", "examples")
PAGES = sorted([*ROOT.glob("*.md"), *(page for folder in FOLDERS for page in (ROOT / folder).rglob("*.md"))])

PLAIN = {
    r"\bwhither\b": "where to, towards",
    r"\bwhence\b": "from where",
    r"\bthence\b|\bthither\b|\bhither\b": "from there, there, here",
    r"\bcomes? by (?:its|their) program": "how a DSP gets its program, boot method",
    r"\bought to\b": "should",
    r"\bbefalls?\b|\bbehold\b|\bin[ -]vain\b": "happens to, see, without success",
    r"\banew\b": "again",
    r"\bmended\b|\bfor[ -]ever\b": "fixed, forever",
    r"\breckon(?:s|ed|ing)?\b": "count, compute, assume",
    r"\bnought\b": "0, nothing",
    r"\bamidst\b|\bwhilst\b|\bamongst\b": "amid, while, among",
    r"\bgo(?:es|ing)? on\b": "continue",
    r"\bseldom\b|\b(?:its|their) kin\b": "rarely, similar ones",
    r"\bheretofore\b|\bhenceforth\b|\bthereof\b|\btherein\b|\bthereby\b": "until now, from now on, of it, in it, by that",
}
"""Words of books, and what to write. Names are words, too: `_` is read as a hyphen."""


def prose(text: str) -> Iterator[tuple[int, str]]:
    """Lines with their numbers, without code blocks, tables, headings and comments."""
    fenced = comment = False
    before = ""
    in_list = in_code = False
    for number, line in enumerate(text.split("\n"), 1):
        mark = re.match(r"\s*(?:```|~~~)", line)
        if mark or fenced:
            fenced = fenced != bool(mark)
            before = line
            continue
        comment = comment or "<!--" in line
        if comment:
            comment = "-->" not in line
            before = line
            continue
        indented = re.match(r"    +\S", line)
        if not line.strip():
            before = line
            continue
        if indented and not in_list and (in_code or not before.strip()):
            in_code = True
        else:
            in_code = False
            in_list = bool(re.match(r"\s*(?:[-*+]|\d+\.) ", line)) or (in_list and line.startswith(" "))
            if not re.match(r"\s*[|#]", line):
                yield number, line
        before = line


def one_word(line: str) -> bool:
    """A link or a word cannot be broken."""
    return not re.search(r"\S\s", re.sub(r"!?\[[^\]]*\]\([^)]*\)|`[^`]*`", "x", line.strip()))


def test_lines_have_a_width() -> None:
    assert not [
        f"{page.relative_to(ROOT)}:{n}: {len(line)} columns"
        for page in PAGES
        for n, line in prose(page.read_text(encoding="utf-8"))
        if len(line) > WIDTH and not one_word(line)
    ]


def unusual(files: Iterable[Path], folder: Path = ROOT) -> list[str]:
    return [
        f"{file.relative_to(folder)}:{text.count(chr(10), 0, match.start()) + 1}: {match[0]!r}; write: {instead}"
        for file in files
        for text in [file.read_text(encoding="utf-8").replace("_", "-")]
        for pattern, instead in PLAIN.items()
        for match in re.finditer(pattern, text, re.IGNORECASE)
    ]


def test_words_are_the_usual_ones() -> None:
    assert not unusual(PAGES)


def sources(*more: str) -> list[Path]:
    """C++, Python and TypeScript, as git has them, and `more`."""
    kinds = ("*.cpp", "*.hpp", "*.py", "*.pyi", "*.ts")
    listed = subprocess.run(["git", "ls-files", *kinds, *more], cwd=ROOT, capture_output=True, text=True, check=True)
    return [ROOT / name for name in listed.stdout.splitlines() if (ROOT / name).exists()]


STUB = ROOT / "python" / "cmrc" / "_core" / "plant.pyi"
"""One module of C++ has one stub; scripts/documents/settings_stub.py writes half of it."""


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="not a clone: git lists the sources")
def test_sources_have_fewer_than_500_lines() -> None:
    lengths = {path: path.read_text(encoding="utf-8").count("\n") for path in sources()}
    assert len(lengths) > 1000
    assert not {str(path.relative_to(ROOT)): n for path, n in lengths.items() if n >= 500 and path != STUB}


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="not a clone: git lists the files")
def test_no_merge_has_left_its_marks() -> None:
    found = subprocess.run(
        ["git", "grep", "-nE", "^(<{7}|>{7}) "], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert (found.returncode, found.stdout) == (1, "")  # 1: no line


def test_folders_of_the_controller_include_upwards_in_their_table() -> None:
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    table = page.partition("| folder of `emulator/cmrc/` |")[2].partition("\n\n")[0]
    folders = re.findall(r"^\| `(\w+)/`", table, re.MULTILINE)
    room = ROOT / "emulator" / "cmrc"
    assert sorted(folders) == sorted(path.name for path in room.iterdir() if path.is_dir())
    assert not {
        f"{file.relative_to(room)} includes {needed}/"
        for file in room.glob("*/**/*.[ch]pp")
        for needed in re.findall(r'^#include "cmrc/(\w+)/', file.read_text(encoding="utf-8"), re.MULTILINE)
        if folders.index(needed) > folders.index(file.relative_to(room).parts[0])
    }


def python_files() -> list[Path]:
    """The package, tests, examples, and scripts, which have no suffix."""
    named = [path for folder in ("python", "tests", "examples") for path in (ROOT / folder).rglob("*.py*")]
    scripts = [path for path in (ROOT / "scripts").rglob("*") if path.is_file() and path.parent.name != "__pycache__"]
    begun = [path for path in scripts if re.match(r"#!.*python", path.read_text(encoding="utf-8"))]
    return sorted({*(path for path in [*named, *scripts] if path.suffix in (".py", ".pyi")), *begun})


def prose_lines(text: str) -> set[int]:
    """Numbers of the lines of a Python file that are a comment by themselves, or part of a docstring."""
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    found = {
        token.start[0]
        for token in tokens
        if token.type == tokenize.COMMENT and not token.line[: token.start[1]].strip()
    }
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            found.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return found


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="not a clone: git lists the sources")
def test_words_of_sources_are_the_usual_ones() -> None:
    files = {*sources("*.asm", "*.inc"), *python_files()} - {Path(__file__)}
    assert {".asm", ".inc", ".ts", ".cpp", ".hpp", ".py", ".pyi", ""} == {file.suffix for file in files}
    assert not unusual(sorted(files))


def test_a_word_ends_in_a_name(tmp_path: Path) -> None:
    source = tmp_path / "a.cpp"
    source.write_text("void start_anew(); bool anewest, in_vain;\n// seldom\n")
    found = [match.split("; ")[0] for match in unusual([source], tmp_path)]
    assert found == ["a.cpp:1: 'in-vain'", "a.cpp:1: 'anew'", "a.cpp:2: 'seldom'"]


def test_comments_and_docstrings_have_a_width() -> None:
    found = []
    for file in python_files():
        text = file.read_text(encoding="utf-8")
        wide = {n: len(line) for n, line in enumerate(text.split("\n"), 1) if len(line) > WIDTH}
        if wide:
            found += [f"{file.relative_to(ROOT)}:{n}: {wide[n]} columns" for n in sorted(prose_lines(text) & set(wide))]
    assert not found


def test_what_is_prose_in_python() -> None:
    text = '# a\nx = """b\nc"""  # d\ndef f():\n    """e\n    f"""\n    return 1\n'
    assert prose_lines(text) == {1, 5, 6}


def test_code_and_tables_are_no_prose() -> None:
    text = "a\n\n    code\n\n    more\n\n| t |\n# h\n- item\n\n      of the item\n```\nx\n```\n<!-- c\nd -->\nb\n"
    assert [line for _, line in prose(text)] == ["a", "- item", "      of the item", "b"]
