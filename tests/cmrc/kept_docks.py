"""Random docks that are kept in data/kept_docks.json, so that a new key of the schema changes none of them.

PYTHONPATH=build/python:tests .venv/bin/python tests/cmrc/kept_docks.py     # draws others
"""

from __future__ import annotations

import json
import random
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import dock_checks
import random_docks
from digests import digest
from files_of_docks import files_of_users
from random_docks import Dock, Generator

FILE = Path(__file__).parent / "data" / "kept_docks.json"
PLACES = ("machine.programs", "machine.board", "dock.layout")  # kept from the folder of files_of_users on
SHORT, LONG = range(1000, 1061), range(2000, 2013)


def drawn() -> list[Dock]:
    """Sixty of 0.1 s at the most, with every key of the schema in one of them; twelve of 0.5 s, in which the plant
    moves. In most of them something goes wrong."""
    with tempfile.TemporaryDirectory() as place:
        programs = files_of_users(Path(place))
        docks = with_every_key([dock for dock in drawn_from(SHORT, programs) if runs(dock)])
        docks += [dock for dock in map(longer, drawn_from(LONG, programs)) if runs(dock)]
        return [placed(dock, lambda name: name.removeprefix(place).removeprefix("/")) for dock in docks]


def placed(dock: Dock, place: Callable[[str], str]) -> Dock:
    """The dock with its files in another place."""
    changed = {key: place(dock.settings[key]) for key in PLACES if key in dock.settings}
    return replace(dock, settings={**dock.settings, **changed})


def drawn_from(seeds: range, programs: Path) -> Iterator[Dock]:
    return (Generator(seed, programs, longest_s=0.1).dock() for seed in seeds)


def runs(dock: Dock) -> bool:
    """Whether the emulator takes it, and can integrate its plant to the end."""
    if not random_docks.holds(dock):
        return False
    try:
        dock_checks.uncut(dock.config())
    except RuntimeError:
        return False
    return True


def has_use_for(dock: Dock, key: str) -> bool:
    """One crane's parameters are nothing to the other one."""
    gantry = dock.settings.get("dock.crane") == "gantry"
    return not key.startswith("slewing." if gantry else "gantry.")


def another_value(draw: random.Random, name: str) -> Any:
    key = random_docks.KEYS[name]
    while (chosen := random_docks.value(draw, key)) == key["default"]:
        pass
    return chosen


def with_every_key(docks: list[Dock]) -> list[Dock]:
    """Each key of the schema gets another value in one of the docks; a dock that refuses it leaves it to the next."""
    draw = random.Random(1)
    deck = [
        name
        for name, key in random_docks.KEYS.items()
        if key["type"] != "string" and not name.startswith(random_docks.APART)
    ]
    draw.shuffle(deck)
    for _ in range(20):
        refused = []
        for place, name in enumerate(deck):
            able = [n for n, dock in enumerate(docks) if has_use_for(dock, name)]
            which = able[place % len(able)]
            chosen = another_value(draw, name)
            candidate = replace(docks[which], settings={**docks[which].settings, name: chosen})
            if runs(candidate):
                docks[which] = candidate
            else:
                refused.append(name)
        deck = refused
    if deck:
        print(f"no dock takes {', '.join(deck)}", file=sys.stderr)
    return docks


def longer(dock: Dock) -> Dock:
    return replace(dock, settings={**dock.settings, "run.duration_s": 0.5})


def kept() -> list[Dock]:
    rows: list[dict[str, Any]] = json.loads(FILE.read_text())
    return [Dock(**{**row, "tables": tuple(row["tables"]), "events": tuple(row["events"])}) for row in rows]


def written(docks: list[Dock]) -> str:
    return "[\n" + ",\n".join(json.dumps(asdict(dock)) for dock in docks) + "\n]\n"


PARTS: dict[str, tuple[str, ...]] = {
    "run": ("hash", "events", "stop_reason", "simulated_ps"),
    "tasks": ("tasks", "misses", "cycles"),
    "chips": ("dsps", "buses", "links", "nets", "host"),
}
"""Parts of a report that have a digest of their own; the others share one, apart from what differs from run to run."""
LEFT_OUT = ("elapsed_s", "reference_elapsed_s", "emulator_version", "configuration", "configuration_toml")


def digests_of(dock: Dock, programs: Path) -> str:
    simulation = dock_checks.uncut(placed(dock, lambda name: str(programs / name)).config())
    report = json.loads(simulation.report_json())
    named = {name for names in PARTS.values() for name in names}
    parts = {part: {name: report[name] for name in names} for part, names in PARTS.items()}
    parts["others"] = {name: value for name, value in report.items() if name not in named and name not in LEFT_OUT}
    parts["signals"] = {name: column.tolist() for name, column in simulation.signals().items()}
    return " ".join(f"{name} {digest(part, digits=8)}" for name, part in parts.items())


if __name__ == "__main__":
    FILE.write_text(written(drawn()))
