"""Which fields of a run's state no snapshot test would miss: loads the state without each listed field, one after the
other.

For each scene of tests/cmrc/snapshots/test_snapshots.py and each instant of its tests, the state goes into a new run
with one field as that run had it before, as if its line were not in the list. A field is noticed where the run then
differs: at once, in its report at the end, or in another field at the end. Prints those that never were, with how
often they differed at all: 0 means that no scene has another value than the one to begin with.

    PYTHONPATH=build/python .venv/bin/python scripts/unnoticed_fields.py [SCENE ...]
"""

from __future__ import annotations

import os
import signal
import sys
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path[:0] = [str(Path(__file__).parents[1] / "tests" / part) for part in ("", "cmrc", "cmrc/snapshots")]

import test_snapshots as scenes
from cmrc import _core

core = _core.cmrc
TAG = 4  # bytes before each listed field
INSTANTS, TRIES, SECONDS = 12, 9, 10
KEYS = {key["name"] for key in core.config_keys()}


def parts_of(path: str) -> list[str]:
    """The names and numbers of a path; a key of the configuration is one name."""
    parts = path.split(".")
    return ["host", "/".join(parts[1:3]), *parts[3:]] if parts[0] == "host" and ".".join(parts[1:3]) in KEYS else parts


class State:
    """A saved state, and the first and last byte of each field in it, by the field's path with * for numbers."""

    def __init__(self, simulation: Any) -> None:
        self.text: bytes = simulation._state()
        self.fields: dict[str, dict[str, list[int]]] = defaultdict(dict)
        for path, offset, size in simulation._state_leaves():
            parts, tags = parts_of(path), 0
            for last in range(len(parts) - 1, -1, -1):
                # How many elements there are has no tag. In accounts `count` is a field like any other.
                if parts[last].isdigit() or (
                    parts[last] == "count" and not (last and parts[last - 1] in ("released", "finished", "log"))
                ):
                    continue
                pattern = ".".join("*" if part.isdigit() else part for part in parts[: last + 1])
                where = self.fields[pattern].setdefault(
                    ".".join(parts[: last + 1]), [offset - TAG * tags, offset + size]
                )
                where[1], tags = offset + size, tags + 1

    def replaced(self, pattern: str, by: Callable[[str, bytes], bytes]) -> bytes:
        out, at = b"", 0
        for begin, end, path in sorted(
            (begin, end, path) for path, (begin, end) in self.fields.get(pattern, {}).items()
        ):
            out, at = out + self.text[at:begin] + by(path, self.text[begin:end]), end
        return out + self.text[at:]

    def without(self, pattern: str, fresh: State) -> bytes:
        def value(path: str, own: bytes) -> bytes:
            where = fresh.fields.get(pattern, {}).get(path)
            if where is not None:
                return fresh.text[where[0] : where[1]]
            return bytes(len(own)) if len(own) in (1, 2, 4, 8, 16) else own

        return self.replaced(pattern, value)

    def blank(self, pattern: str) -> bytes:
        return self.replaced(pattern, lambda _, own: bytes(len(own)))


def in_a_child(work: Callable[[], bool]) -> bool:
    """True also where the process dies or hangs: a state that is none may do anything."""
    child = os.fork()
    if child == 0:
        signal.alarm(SECONDS)
        status = 1
        try:
            status = int(work())
        finally:
            os._exit(status)
    return os.waitpid(child, 0)[1] != 0


def look(scene: str, noticed: set[str], differed: dict[str, int]) -> None:
    whole, new = core.Simulation(scenes.configuration(scene)), core.Simulation(scenes.configuration(scene))
    fresh = State(new)
    whole.run()
    end, end_state = scenes.seen(whole), State(whole)
    for instant in scenes.instants(scene, INSTANTS):
        simulation = core.Simulation(scenes.configuration(scene))
        simulation.run_until(instant)
        now, state = scenes.seen(simulation), State(simulation)
        for pattern in state.fields:
            differed.setdefault(pattern, 0)
            text = state.without(pattern, fresh)
            if text == state.text or pattern in noticed or differed[pattern] >= TRIES:
                continue
            differed[pattern] += 1

            def differs(text: bytes = text, pattern: str = pattern, now: Any = now) -> bool:
                other = core.Simulation(scenes.configuration(scene))
                other._load_state(text)
                if scenes.seen(other) != now:
                    return True
                other.run()
                if scenes.seen(other) != end:
                    return True
                return other._state() != end_state.text and State(other).blank(pattern) != end_state.blank(pattern)

            if in_a_child(differs):
                noticed.add(pattern)
        print(f"{scene} at {instant:.9f} s: {len(noticed)} of {len(differed)} noticed", file=sys.stderr, flush=True)


def main() -> None:
    noticed: set[str] = set()
    differed: dict[str, int] = {}
    for scene in sys.argv[1:] or scenes.SCENES:
        look(scene, noticed, differed)
    for pattern in sorted(set(differed) - noticed):
        print(pattern, differed[pattern])


if __name__ == "__main__":
    main()
