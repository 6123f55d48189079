"""python/cmrc/_settings.pyi from the configuration's schema: what an editor offers as keywords of cmrc.run; and the
numbers in the classes of parameters of python/cmrc/_core/plant.pyi from the C++ module.

`PYTHONPATH=build/python python scripts/documents/settings_stub.py` writes both; tests/python/test_settings_stub.py
holds them.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cmrc import _core, files, keywords

PLACE = Path(__file__).resolve().parent.parent.parent / "python" / "cmrc" / "_settings.pyi"
PLANT = PLACE.parent / "_core" / "plant.pyi"
PARAMETERS = ("DriveParameters", "Portal", "CraneParameters", "LandingParameters", "AgvParameters")
HEAD = """# Written by scripts/documents/settings_stub.py from the configuration's schema (docs/configuration.md).
from os import PathLike
from typing import Literal, TypedDict

from numpy import bool_

"""
STUBS = {"string": "str | PathLike[str]", "boolean": "bool | bool_"}
"""Types that take more than Python's own class."""
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
    return STUBS.get(key["type"], keywords.TYPES[key["type"]].__name__)


def plant_stub(text: str) -> str:
    """The text of plant.pyi with a line for each number of the classes of parameters, in the module's order."""
    for name in PARAMETERS:
        head, begin, rest = text.partition(f"class {name}:\n    def __init__(self) -> None: ...\n")
        body, end, rest = rest.partition("\nclass ")
        others = [line for line in body.splitlines() if not line.endswith(": float")]
        members = vars(getattr(_core.plant, name)).items()
        numbers = [
            f"    {member}: float"
            for member, value in members
            if isinstance(value, property) and value.fset and (value.fget.__doc__ or "").strip().endswith("-> float")
        ]
        text = head + begin + "\n".join([*numbers, *others]) + "\n" + end + rest
    return text


if __name__ == "__main__":
    files.write(PLACE, stub())
    files.write(PLANT, plant_stub(PLANT.read_text(encoding="utf-8")))
