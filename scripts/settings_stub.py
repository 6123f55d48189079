"""python/cmrc/_settings.pyi from the configuration's schema: what an editor offers as keywords of cmrc.run.

`PYTHONPATH=build/python python scripts/settings_stub.py` writes it; tests/python/test_settings_stub.py holds it equal.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cmrc import files, keywords

PLACE = Path(__file__).resolve().parent.parent / "python" / "cmrc" / "_settings.pyi"
HEAD = """# Written by scripts/settings_stub.py from the configuration's schema (docs/configuration.md).
from typing import Literal, TypedDict

"""
OF_RUN = {"machine.dsps": "Settings", "run.duration_s": "LimitsSettings"}
"""Settings that some functions have as arguments of their own."""
CLASSES = (
    ("MoreSettings", "TypedDict, total=False", "Keywords of cmrc.run beside its own arguments."),
    ("LimitsSettings", "MoreSettings, total=False", "Keywords of cmrc.limits."),
    (
        "Settings",
        "LimitsSettings, total=False",
        "Keywords of cmrc.Simulation: settings by the last part of their names.",
    ),
)


def stub() -> str:
    """The text of the file."""
    fields: dict[str, list[str]] = {name: [] for name, _, _ in CLASSES}
    for short, key in keywords.settings().items():
        fields[OF_RUN.get(key["name"], "MoreSettings")].append(f"    {short}: {type_of(key)}  # {key['name']}")
    text = HEAD
    for name, base, meaning in CLASSES:
        text += f'class {name}({base}):\n    """{meaning}"""\n\n' + "\n".join(fields[name]) + "\n\n"
    return text.rstrip() + "\n"


def type_of(key: Mapping[str, Any]) -> str:
    if key["choices"]:
        return f"Literal[{', '.join(map(repr, key['choices']))}]".replace("'", '"')
    return keywords.TYPES[key["type"]].__name__


if __name__ == "__main__":
    files.write(PLACE, stub())
