"""Random docks that are kept in data/kept_docks.json, so that a new key of the schema changes none of them.

PYTHONPATH=build/python:tests .venv/bin/python tests/cmrc/kept_docks.py     # draws others
"""

from __future__ import annotations

import json
import tempfile
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from cmrc import _core
from digests import digest
from random_docks import Dock, Generator, programs_of_users

FILE = Path(__file__).parent / "data" / "kept_docks.json"
PROGRAMS = "machine.programs"
SHORT, LONG = range(1000, 1060), range(2000, 2012)
cmrc = _core.cmrc


def drawn() -> list[Dock]:
    """Sixty of 0.1 s at the most, in which something goes wrong mostly, and twelve of 0.5 s, in which the plant moves.
    The place of the programs is left out."""
    with tempfile.TemporaryDirectory() as place:
        programs = programs_of_users(Path(place))
        docks = [Generator(seed, programs, longest_s=0.1).dock() for seed in SHORT]
        docks += [longer(Generator(seed, programs, longest_s=0.1).dock()) for seed in LONG]
    return [
        replace(dock, settings={**dock.settings, PROGRAMS: ""}) if PROGRAMS in dock.settings else dock for dock in docks
    ]


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
LEFT_OUT = ("elapsed_s", "reference_elapsed_s", "emulator_version", "configuration")


def digests_of(dock: Dock, programs: Path) -> str:
    settings = {PROGRAMS: str(programs)} if PROGRAMS in dock.settings else {}
    simulation = cmrc.Simulation(dock.config(**settings))
    try:
        simulation.run()
    except RuntimeError as error:  # a plant that cannot be integrated
        return f"refused {digest(str(error))}"
    report = json.loads(simulation.report_json())
    named = {name for names in PARTS.values() for name in names}
    parts = {part: {name: report[name] for name in names} for part, names in PARTS.items()}
    parts["others"] = {name: value for name, value in report.items() if name not in named and name not in LEFT_OUT}
    parts["signals"] = {name: column.tolist() for name, column in simulation.signals().items()}
    return " ".join(f"{name} {digest(part, digits=8)}" for name, part in parts.items())


if __name__ == "__main__":
    FILE.write_text(written(drawn()))
