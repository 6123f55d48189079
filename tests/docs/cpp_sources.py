"""The project's C++ as text, for the tests that need no compiler."""

import re

from locations import ROOT

NO_CODE = re.compile(
    r'R"(\w*)\(.*?\)\1"' r'|"(?:\\.|[^"\\\n])*"' r"|(?<!\w)'(?:\\.|[^'\\\n])'" r"|//[^\n]*|/\*.*?\*/|^#include[^\n]*",
    re.DOTALL | re.MULTILINE,
)


def code_of(text: str) -> str:
    """The text without literals, comments and includes."""
    return NO_CODE.sub(" ", text)


def cpp_sources(*rooms: str) -> dict[str, str]:
    """The texts of the C++ files in these folders, by path from the tree's root."""
    files = [path for room in rooms for path in (ROOT / room).rglob("*.[ch]pp")]
    return {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in files}
