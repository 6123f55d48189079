"""What scripts/mutants may change in a source, of C++ and of Python: the lines that hold code, and each in all ways in
which it can be changed."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

Changes = dict[int, list[str]]
"""By the number of a line, that line in each way in which it can be changed"""


@dataclass(frozen=True)
class Language:
    """The sources that mutants are drawn from."""

    name: str
    aimed: dict[str, list[str]]
    """The folders of tests/ that aim at a room or at a folder of it, those that notice most first"""
    suffixes: tuple[str, ...]
    changes: Callable[[str], Changes] = field(repr=False)
    """Of a file's text"""
    folders_of_rooms: tuple[str, ...] = ()
    """Those in `aimed` that are no rooms"""

    @property
    def rooms(self) -> list[str]:
        return [room for room in self.aimed if room not in self.folders_of_rooms]

    def aimed_at(self, file: str) -> list[str]:
        return next(folders for place, folders in self.aimed.items() if file.startswith(place))

    def room_of(self, file: str) -> str:
        return next(room for room in self.rooms if file.startswith(room))

    @cached_property
    def places(self) -> dict[str, list[tuple[str, int, str, list[str]]]]:
        """By room, the lines that can be changed: file, number, text, changes."""
        found: dict[str, list[tuple[str, int, str, list[str]]]] = {room: [] for room in self.rooms}
        for room in self.rooms:
            for file in sorted(path for suffix in self.suffixes for path in (ROOT / room).glob(f"**/*.{suffix}")):
                name, text = str(file.relative_to(ROOT)), file.read_text(encoding="utf-8")
                lines = text.splitlines()
                if self.room_of(name) == room:
                    found[room] += [(name, n, lines[n - 1], ways) for n, ways in self.changes(text).items()]
        return found


# ---- C++


# Replacements. Templates, references and pointers look like operators: an operator has blanks on both sides.
CPP_OPERATORS = {
    " < ": [" <= ", " >= "], " <= ": [" < ", " > "], " > ": [" >= ", " <= "], " >= ": [" > ", " < "], " == ": [" != "], " != ": [" == "],
    " && ": [" || "], " || ": [" && "], " + ": [" - "], " - ": [" + "], " * ": [" / "], " / ": [" * "], " % ": [" / "],
    " += ": [" -= ", " = "], " -= ": [" += ", " = "], " << ": [" >> "], " >> ": [" << "], " & ": [" | "], " | ": [" & "], " ^ ": [" | "],
    " |= ": [" &= "], " &= ": [" |= "], "++": ["--"], "--": ["++"], "true": ["false"], "false": ["true"], "std::min": ["std::max"], "std::max": ["std::min"],
    "if (!": ["if ("], " ? ": [" ? !"],
}  # fmt: skip
OPERATOR = re.compile(
    "|".join(
        r"\b" + re.escape(o) + r"\b" if o.isalpha() else re.escape(o)
        for o in sorted(CPP_OPERATORS, key=len, reverse=True)
    )
)
CONSTANT = re.compile(r"(?<![\w.'\"])(0[xX][0-9a-fA-F']+|\d[\d']*(?:\.\d+)?(?:e-?\d+)?)(?![\w.'\"])")
STATEMENT = re.compile(
    r"^\s+(?!return|throw|break|continue|case|default|using|const|auto|static|delete)[\w.:>\-\[\]*]+(?:\(.*\)| [+\-|&]?= .*);\s*$"
)
STRING = re.compile(r"\"(?:[^\"\\]|\\.)*\"|'(?:[^'\\]|\\.)+'")


def code_of(line: str) -> str:
    """The line with strings and comments blanked, so that nothing is found in them."""
    blanked = STRING.sub(lambda found: '"' + " " * (len(found[0]) - 2) + '"', line)
    return blanked.split("//")[0]


def neighbours(constant: str) -> list[str]:
    """A whole number has one on either side; a fraction is a hundredth larger, or has the other sign."""
    if re.fullmatch(r"0[xX].*|\d+", constant):
        if re.fullmatch(r"0\d+", constant):
            return []  # octal: rights of files
        value = int(constant, 0)
        return [str(value + 1), *([str(value - 1)] if value else [])]
    return [repr(float(constant) * 1.01), repr(-float(constant))]


def changes_of_line(line: str) -> list[str]:
    """The line in each way in which it can be changed."""
    code = code_of(line)
    if code.lstrip().startswith(("#", "static_assert", "namespace", "using", "template", "require(", "///")):
        return []
    made = [
        line[: f.start()] + other + line[f.end() :] for f in OPERATOR.finditer(code) for other in CPP_OPERATORS[f[0]]
    ]
    for found in CONSTANT.finditer(code):
        made += [line[: found.start()] + other + line[found.end() :] for other in neighbours(found[0].replace("'", ""))]
    if STATEMENT.match(code):
        made.append(line[: len(line) - len(line.lstrip())] + ";")
    return made


def changes_of_cpp(text: str) -> Changes:
    made = {number: changes_of_line(line) for number, line in enumerate(text.splitlines(), start=1)}
    return {number: ways for number, ways in made.items() if ways}


CPP = Language(
    "C++",
    {
        "emulator/cmrc/timelines": ["cli", "cmrc"],
        "emulator/isa": ["isa", "spec", "toolchain", "c40"],
        "emulator/io": ["cli", "toolchain", "python", "plant"],
        "emulator/report": ["report", "cmrc", "machine"],
        "emulator/c40": ["c40", "peripherals", "spec", "programs", "debugger"],
        "emulator/toolchain": ["toolchain", "boards", "cli"],
        "emulator/machine": ["machine", "peripherals", "boards", "debugger", "cmrc"],
        "emulator/cmrc": ["cmrc", "kernels", "python", "report", "cli"],
        "emulator/state": ["cmrc", "machine", "debugger", "python"],
        "emulator/page": ["page", "cmrc"],
        "emulator/debugger": ["debugger"],
        "emulator/cli": ["cli", "debugger", "machine", "toolchain"],
        "bus_model": ["bus_model", "machine", "cmrc"],
        "plant": ["plant", "cmrc", "kernels"],
        "python/bindings": ["python", "c40", "machine", "debugger", "plant", "cmrc"],
    },
    ("cpp", "hpp"),
    changes_of_cpp,
    ("emulator/cmrc/timelines",),
)


# ---- Python

PYTHON_OPERATORS = {
    "<": ["<=", ">="], "<=": ["<", ">"], ">": [">=", "<="], ">=": [">", "<"], "==": ["!="], "!=": ["=="], "+": ["-"],
    "-": ["+"], "*": ["/"], "/": ["*"], "//": ["/"], "%": ["*"], "+=": ["-=", "="], "-=": ["+=", "="], "&": ["|"],
    "<<": [">>"], ">>": ["<<"],
}  # fmt: skip
PYTHON_WORDS = {
    "and": ["or"], "or": ["and"], "not": [""], "is": ["is not"], "True": ["False"], "False": ["True"], "min": ["max"],
    "max": ["min"], "any": ["all"], "all": ["any"], "break": ["continue"], "continue": ["break"], "sorted": ["list"],
}  # fmt: skip


def changes_of_python(text: str) -> Changes:
    """Some of the changed texts may be no Python, or the same program (is_other_python)."""
    lines = text.splitlines()
    made: dict[int, list[str]] = defaultdict(list)
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.OP:
            others = PYTHON_OPERATORS.get(token.string, [])
        elif token.type == tokenize.NAME:
            others = PYTHON_WORDS.get(token.string, [])
        else:
            number_text = token.string.replace("_", "") if token.type == tokenize.NUMBER else ""
            others = neighbours(number_text) if CONSTANT.fullmatch(number_text) else []
        (number, begin), (_, end) = token.start, token.end
        made[number] += [lines[number - 1][:begin] + other + lines[number - 1][end:] for other in others]
    for node in ast.walk(ast.parse(text)):
        leaves_no_trace = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if (
            isinstance(node, (ast.Expr, ast.AugAssign, ast.Raise))
            and not leaves_no_trace
            and node.lineno == node.end_lineno
        ):
            line = lines[node.lineno - 1]
            made[node.lineno].append(line[: node.col_offset] + "pass" + line[node.end_col_offset :])
    return {number: ways for number, ways in sorted(made.items()) if ways}


def is_other_python(before: str, after: str) -> bool:
    """Whether a changed text is still Python, and another program."""
    try:
        return ast.dump(ast.parse(after)) != ast.dump(ast.parse(before))
    except SyntaxError:
        return False


PYTHON = Language(
    "Python",
    {
        "python/cmrc/commands": ["cli", "python", "sweeps", "page"],
        "python/cmrc/loops": ["python", "cmrc"],
        "python/cmrc/network": ["machine", "peripherals", "python"],
        "python/cmrc/plant": ["plant", "python"],
        "python/cmrc/results": ["cmrc", "docs", "python"],
        "python/cmrc/sweeps": ["sweeps", "python"],
        "python/cmrc": ["python", "cli", "cmrc", "sweeps", "report", "debugger", "page"],
    },
    ("py",),
    changes_of_python,
)
LANGUAGES = {"c++": CPP, "python": PYTHON}
