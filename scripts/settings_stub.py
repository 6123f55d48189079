"""python/cmrc/_settings.pyi from the configuration's schema: what an editor offers as keywords of cmrc.run.

`PYTHONPATH=build/python python scripts/settings_stub.py` writes it; tests/python/test_settings_stub.py holds it equal.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

from cmrc import _core, files

PLACE = Path(__file__).resolve().parent.parent / "python" / "cmrc" / "_settings.pyi"
HEAD = """# Written by scripts/settings_stub.py from the configuration's schema (docs/configuration.md).
from typing import Literal, TypedDict

"""
OF_RUN = {"machine.dsps": "Settings", "run.duration_s": "LimitsSettings"}
"""Settings that some functions have as arguments of their own."""
ARGUMENTS = ("reference",)
"""Arguments of cmrc.Simulation that are called as a setting is; that one goes by its full name."""
CLASSES = (
    ("MoreSettings", "TypedDict, total=False", "Keywords of cmrc.run beside its own arguments."),
    ("LimitsSettings", "MoreSettings, total=False", "Keywords of cmrc.limits."),
    (
        "Settings",
        "LimitsSettings, total=False",
        "Keywords of cmrc.Simulation: settings by the last part of their names.",
    ),
)
TYPES = {"integer": "int", "number": "float", "boolean": "bool", "string": "str"}


def stub() -> str:
    """The text of the file."""
    keys = _core.cmrc.config_keys()
    shorts = Counter(key["name"].rpartition(".")[2] for key in keys)
    fields: dict[str, list[str]] = {name: [] for name, _, _ in CLASSES}
    for key in keys:
        short = key["name"].rpartition(".")[2]
        if shorts[short] == 1 and short not in ARGUMENTS:
            fields[OF_RUN.get(key["name"], "MoreSettings")].append(f"    {short}: {type_of(key)}  # {key['name']}")
    text = HEAD
    for name, base, meaning in CLASSES:
        text += f'class {name}({base}):\n    """{meaning}"""\n\n' + "\n".join(fields[name]) + "\n\n"
    return text.rstrip() + "\n"


def type_of(key: dict[str, Any]) -> str:
    if key["choices"]:
        return f"Literal[{', '.join(map(repr, key['choices']))}]".replace("'", '"')
    return TYPES[key["type"]]


if __name__ == "__main__":
    files.write(PLACE, stub())
