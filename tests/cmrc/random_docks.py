"""Random docks: whole configurations, with everything that may go wrong in them, drawn by a seed (docs/trust.md).

What can be set comes from the schema itself: a new key or a new failure is drawn without a change here. A choice
that the configuration refuses is left out; the refusal must name a key, or the field of an event.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from cmrc import _core
from files_of_docks import BOARDS, LAYOUTS, USER_PROGRAMS

cmrc = _core.cmrc
KEYS = {key["name"]: key for key in cmrc.config_keys()}
ACTIONS = cmrc.timed_actions()
TARGETS: dict[str, list[Any]] = {
    "bus": ["A", "B", "C"],
    "joint": ["travel", "slew", "luff", "trolley", "hoist", "rotate"],
    "axis": ["alpha", "beta"],
}

# Drawn apart, below: what a run is, what it is measured against, and what needs a file or a text of its own.
APART = (
    "run.",
    "machine.dsps",
    "machine.slots",
    "machine.programs",
    "machine.board",
    "dock.layout",
    "topology.",
    "report.reference",
)
# Beyond these a run costs minutes: clocks and rates that are fast beside real time, memory by the gigabyte.
AT_LEAST = {"machine.cycle_time_factor": 0.25, "machine.pause_nops": 20}
AT_MOST = {
    "rates.refresh_frequency_hz": 40_000,
    "rates.servo_frequency_hz": 20_000,
    "rates.agv_point_frequency_hz": 2000,
}
TOPOLOGIES: list[dict[str, str]] = [
    {"boards": "A", "bridges": "A-B"},
    {"boards": "B", "bridges": "A-B"},
    {"buses": "A B C", "boards": "B", "drives": "C", "sensors": "C", "comm_port": "B", "bridges": "A-B, B-C"},
    {"buses": "A B C", "boards": "C", "drives": "C", "bridges": "A-B, B-C"},
]

# The AGVs' avoidance, released in other ways; a process with a hold; what is not the paper's job.
TABLES = [
    """
[[subprocesses]]
number = 5
name = "avoidance"
agv = "obstacle_avoidance"
release = "interval"
on_legs = false
""",
    """
[[subprocesses]]
number = 5
name = "avoidance"
agv = "obstacle_avoidance"
release = "interval_and_event"
on_legs = true
""",
    """
[[processes]]
number = 8
name = "home at once"
robot = "agv"
subprocesses = [1, 2, 5]
steps = ["task home.agv", "leg 1"]
initial = [1, 4, 5]
final = true
""",
    """
[[processes]]
number = 2
name = "identify late"
robot = "none"
steps = ["hold 0.03", "task identify"]
may = [3]
loaded = true
""",
]


@dataclass(frozen=True)
class Dock:
    """A configuration: each field can be made smaller by itself."""

    preset: str | None
    settings: dict[str, Any]
    tables: tuple[str, ...] = ()
    events: tuple[dict[str, Any], ...] = ()

    def config(self, **settings: Any) -> Any:
        """Raises ConfigError."""
        return cmrc.config(
            toml="\n".join(self.tables),
            preset=self.preset,
            settings={**self.settings, **settings},
            events=[dict(event) for event in self.events],
        )

    @property
    def duration_s(self) -> float:
        return float(self.settings["run.duration_s"])


class Refused(AssertionError):
    """A refusal that does not say what is wrong."""


def holds(dock: Dock, started: bool = True) -> bool:
    """Whether the emulator takes it: the configuration, and the start, which costs ten times as much. A refusal is a
    ConfigError that names a key, or the event and its field."""
    try:
        config = dock.config(**{"report.reference": "none"})
        if started:
            cmrc.Simulation(config)
    except cmrc.ConfigError as error:
        named = any(name in str(error) for name in (*KEYS, "processes.", "tasks.", "event"))
        if not named or len(str(error)) < 20:
            raise Refused(f"a refusal that names no key: {error}") from error
        return False
    return True


def value(draw: random.Random, key: dict[str, Any]) -> Any:
    """Anything that the schema allows, the ends of its range and the neighbourhood of the default above all."""
    if key["type"] == "boolean":
        return not key["default"]
    if key["type"] == "choice":
        return draw.choice(key["choices"])
    low = max(key["minimum"], AT_LEAST.get(key["name"], -math.inf))
    high = min(key["maximum"], AT_MOST.get(key["name"], math.inf))
    kind, default = draw.random(), key["default"]
    if kind < 0.15:
        found = draw.choice([low, high])
    elif kind < 0.8:
        found = default * 2 ** draw.uniform(-1.5, 1.5) if default else draw.choice([1, high / 1000])
    else:
        found = draw.uniform(low, high)
    found = min(max(found, low), high)
    return round(found) if key["type"] == "integer" else found


class Generator:
    """Draws a dock piece by piece, and keeps the pieces that the emulator takes."""

    def __init__(self, seed: int, programs: Path, longest_s: float = 1.0) -> None:
        self.draw = random.Random(seed)
        self.programs, self.longest_s = programs, longest_s

    def dock(self) -> Dock:
        """Mostly the configuration refuses what is refused. Where a start does, each piece is started."""
        before = self.draw.getstate()
        dock = self.drawn(started=False)
        if not holds(dock):
            self.draw.setstate(before)
            dock = self.drawn(started=True)
        return dock

    def drawn(self, started: bool) -> Dock:
        draw = self.draw
        dsps = draw.choice([1, 2, 3, 4, 4, 6, 8, 16])
        preset = draw.choice([None, None, None, "heavy", "saturated", "tight"])
        # Mostly short: what goes wrong in 0.1 s is found ten times as often as what needs 1 s.
        duration_s = min(
            0.1 * 10 ** (draw.random() ** 8), 0.2 if preset in ("heavy", "saturated") else 1.0, self.longest_s
        )
        settings: dict[str, Any] = {
            "machine.dsps": dsps,
            "machine.slots": min(16, dsps + draw.choice([0, 0, 1, 3])),
            "run.seed": draw.randrange(2**31),
            "run.duration_s": round(duration_s, 4),
            "report.reference": "none",
        }
        dock = Dock(preset, settings)
        assert holds(dock, started)
        for change in [*self.shape(), *(self.setting for _ in range(draw.choice([0, 1, 3, 10])))]:
            candidate = change(dock)
            if holds(candidate, started):
                dock = candidate
        for _ in range(draw.choice([0, 1, 3, 8])):
            candidate = replace(dock, events=(*dock.events, self.event(dock)))
            if holds(candidate, started):
                dock = candidate
        return dock

    def shape(self) -> list[Callable[[Dock], Dock]]:
        """What a dock is made of, before single keys."""
        draw = self.draw
        changes: list[Callable[[Dock], Dock]] = []

        def setting(name: str, chosen: Any) -> None:
            changes.append(lambda dock: replace(dock, settings={**dock.settings, name: chosen}))

        for name, chosen, share in [
            ("dock.agvs", draw.randint(1, 8), 0.5),
            ("dock.crane", "gantry", 0.25),
            ("machine.boot", "preloaded", 0.6),
            ("host.start_ms", draw.choice([0, 0, 5]), 0.6),
            ("load.driving", True, 0.3),
            ("kernels.avoidance", draw.choice(KEYS["kernels.avoidance"]["choices"]), 0.4),
            ("load.avoidance_cycles", draw.choice([1000, 30_000, 200_000]), 0.3),
            ("machine.idle_policy", draw.choice(["pause", "spin"]), 0.15),
            ("run.phase_jitter", True, 0.3),
            ("bus.topology", draw.choice(KEYS["bus.topology"]["choices"]), 0.3),
            ("dock.wind_mean_m_s", draw.choice([3, 12, 25, -8]), 0.3),
            ("scheduling.slice_cycles", draw.choice([5000, 30_000]), 0.2),
            ("run.until", "job_done", 0.1),
        ]:
            if draw.random() < share:
                setting(name, chosen)
        for name, files in [("machine.board", BOARDS), ("dock.layout", LAYOUTS)]:
            if draw.random() < 0.15:
                setting(name, str(self.programs / draw.choice(sorted(files))))
        if draw.random() < 0.15:
            for name, chosen in draw.choice(TOPOLOGIES).items():
                setting(f"topology.{name}", chosen)
        for table in TABLES:
            if draw.random() < 0.15:
                changes.append(lambda dock, table=table: replace(dock, tables=(*dock.tables, table)))  # type: ignore[misc]
        if draw.random() < 0.2:
            setting("machine.programs", str(self.programs))
            changes += [self.task] * draw.randint(1, 3)
            slots = draw.sample(range(16), 2)
            setting("machine.links", draw.choice(["", "0.0:1.4", "0.0:1.4, 1.0:0.4", f"{slots[0]}.0:{slots[1]}.4"]))
            a, b = slots
            setting(
                "machine.nets",
                draw.choice(
                    [
                        "",
                        "0.TCLK0>1.TCLK1+0.TCLK1, 1.IIOF1>0.IIOF2",
                        "0.IIOF1&1.IIOF1>0.IIOF3+1.NMI",
                        f"{a}.TCLK0>{b}.IIOF2, {a}.IIOF1>{b}.RESET",
                    ]
                ),
            )
        return changes

    def task(self, dock: Dock) -> Dock:
        draw = self.draw
        if "machine.programs" not in dock.settings:
            return dock
        period = draw.choice([1, 5, 20])
        kind, importance = draw.choice([3, 4, 9, 10, 14, 17, 20]), draw.choice([0xFFFA, 0xF3FF, 0xDFFF, 0x0100])
        row = f'[[tasks]]\nname = "t{len(dock.tables)}"\nprogram = "kernel_user_{draw.choice(USER_PROGRAMS)}"\nkind = {kind}\nimportance = {importance}\n'
        row += f"period_ms = {period}\ndeadline_ms = {draw.choice([0, period])}\n" + draw.choice(
            ["", "heartbeat_ms = 1\n", "parameter_0 = 0.5\nparameter_3 = 7\n"]
        )
        if draw.random() < 0.5:
            row += f"dsp = {draw.randrange(dock.settings['machine.slots'])}\n"
        return replace(dock, tables=(*dock.tables, row))

    def setting(self, dock: Dock) -> Dock:
        name = self.draw.choice(
            [name for name, key in KEYS.items() if key["type"] != "string" and not name.startswith(APART)]
        )
        return replace(dock, settings={**dock.settings, name: value(self.draw, KEYS[name])})

    def instant(self, dock: Dock) -> float:
        """Some on a tick of the host or a latch, where others act too; some at the instant of another event."""
        at_s, kind = self.draw.uniform(0.0, dock.duration_s), self.draw.random()
        if kind < 0.2:
            return round(at_s, 3)
        if kind < 0.3:
            return round(at_s / 125e-6) * 125e-6
        return float(self.draw.choice(dock.events)["at_s"]) if kind < 0.4 and dock.events else at_s

    def event(self, dock: Dock) -> dict[str, Any]:
        """Failures of chips more often than each of the many of sensors."""
        draw = self.draw
        chips = [action for action in ACTIONS if action["target"] == "dsp"]
        action = draw.choice(chips if draw.random() < 0.5 else ACTIONS)
        event: dict[str, Any] = {"at_s": self.instant(dock), "action": action["name"]}
        if action["target"]:
            event[action["target"]] = (
                draw.randrange(dock.settings["machine.slots"])
                if action["target"] == "dsp"
                else draw.choice(TARGETS[action["target"]])
            )
        if action["amount"] == "factor":
            event["factor"] = draw.choice([0.001, 0.02, 0.3, 0.999, 1])
        if action["amount"] == "lasts_ms":
            event["lasts_ms"] = draw.choice([0.001, 0.2, 3, 20])
        if action["name"] == "set":
            name = draw.choice([name for name, key in KEYS.items() if key["live"]])
            event |= {"key": name, "value": value(draw, KEYS[name])}
        return event


def smaller(dock: Dock) -> list[Dock]:
    """Docks with one thing less, the largest steps first."""
    events, tables, settings = dock.events, dock.tables, dock.settings
    made = [replace(dock, events=())] if events else []
    made += [replace(dock, events=events[:n] + events[n + 1 :]) for n in range(len(events))]
    made += [replace(dock, tables=tables[:n] + tables[n + 1 :]) for n in range(len(tables))]
    made += [replace(dock, preset=None)] if dock.preset else []
    made += [
        replace(dock, settings={key: kept for key, kept in settings.items() if key != name})
        for name in settings
        if name not in ("run.duration_s", "machine.dsps", "report.reference")
    ]
    if settings["machine.dsps"] > 1:
        made.append(replace(dock, settings={**settings, "machine.dsps": settings["machine.dsps"] // 2}))
    if dock.duration_s > 0.02:
        made.append(replace(dock, settings={**settings, "run.duration_s": dock.duration_s / 2}))
    return made


def shrink(dock: Dock, fails: Callable[[Dock], bool]) -> Dock:
    """A smaller dock that still fails, found by leaving out one thing after the other."""
    while True:
        for candidate in smaller(dock):
            if holds(candidate) and fails(candidate):
                dock = candidate
                break
        else:
            return dock
