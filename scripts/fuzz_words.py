"""Words of the formats that have grown with the program: keys, kinds, actions, options, as the sources spell them.

scripts/fuzz gives them to libFuzzer beside fuzz/TARGET.dict, which has the rest: brackets, numbers, magic bytes.
"""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

TOML_SOURCES = {
    "board": ["emulator/machine/boards/board_file*.cpp", "emulator/machine/boards/board_device_kinds.cpp"],
    "configuration": [
        "emulator/cmrc/configuration/**/*.cpp",
        "emulator/cmrc/processes/*.cpp",
        "emulator/cmrc/tasks/job_kinds.hpp",
        "emulator/machine/system/scripted_events.cpp",
        "plant/parameters/parameter_rows.cpp",
    ],
    "layout": ["plant/parameters/layout*.cpp"],
    "network": ["emulator/machine/networks/*.cpp"],
}
OTHER_SOURCES = {
    "command_line": ["emulator/cli/arguments/*.cpp", *TOML_SOURCES["configuration"]],
    "dap": ["emulator/debugger/dap_*.cpp"],
}


def words(target: str) -> set[str]:
    """The words of string literals in the sources that read the target's format; none for a format that stays."""
    found: set[str] = set()
    for pattern in TOML_SOURCES.get(target, []) + OTHER_SOURCES.get(target, []):
        files = sorted(ROOT.glob(pattern))
        if not files:
            raise FileNotFoundError(f"{pattern}: scripts/fuzz_words.py names sources that are not there")
        for file in files:
            code = re.sub(r"#include.*|//.*", "", file.read_text())
            for literal in re.findall(r'"((?:[^"\\]|\\.)*)"', code):
                parts = re.split(r"[, ]+", literal)
                plain = re.fullmatch(r"[\w.,:\- ]+", literal)
                if plain and (len(parts) <= 2 or "device_kinds" in file.name):  # not the sentences of messages
                    found |= {word for part in parts for word in (part, *part.split("."))}
    return {word for word in found if 2 <= len(word) <= 40}


def dictionary(target: str) -> str:
    """The text of libFuzzer's dictionary: fuzz/TARGET.dict, then the words; in TOML also as values."""
    own = ROOT / "fuzz" / f"{target}.dict"
    lines = [own.read_text()] if own.exists() else []
    for word in sorted(words(target)):
        lines.append(f'"{word}"\n')
        if target in TOML_SOURCES:
            lines.append(f'"\\"{word}\\""\n')
    return "".join(lines)
