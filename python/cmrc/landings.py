"""Landings in wind: ``python -m cmrc.landings`` prints the table of docs/wind.md.

Each run is the dock's first container, taken from the ship and set down on a vehicle by the DSPs: two landings. What
counts is what the plant says of them (`Dock::handover`), not what the controller thinks.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cmrc import _core, files
from cmrc.floats import shortest

BLOCK = ("<!-- landings: python -m cmrc.landings --page docs/wind.md -->", "<!-- end of landings -->")
GUST = 0.13
"""Standard deviation of the gusts over their mean (control-notes.md 3)."""
ACROSS_DEG = 90.0
MASSES_KG = (10_000, 24_000, 40_000)
WINDS: dict[float, int] = {0.0: 2, 8.0: 2, 12.0: 24, 15.0: 30, 20.0: 3, 22.0: 2}
"""Runs by mean wind, m/s."""
# Half the default rates: the loops are the same, and a run takes half as long.
RATES: dict[str, Any] = {
    "machine.dsps": 1,
    "machine.boot": "preloaded",
    "rates.refresh_frequency_hz": 4000,
    "rates.servo_frequency_hz": 500,
    "rates.crane_point_frequency_hz": 62.5,
    "scheduling.alpha_refreshes": 12,
    "scheduling.beta_refreshes": 6,
    "report.reference": "none",
    "report.signal_decimation": 400,
    "report.misses_max": 0,
}


LAST_COLUMNS = ("later or never", "within three tries", "3-s mean above 20 m/s", "waited, s per container")


@dataclass(frozen=True)
class Run:
    """The outcome for one container."""

    mean_m_s: float
    mass_kg: float
    tries: tuple[int, ...]
    """Number of touches until the corner switches had closed, for each completed landing: on the ship, on the
    vehicle."""
    missed: int
    """Number of touches of a landing that was never completed; 0: there is none."""
    above_share: float
    waited_s: float


def land(
    mean_m_s: float, mass_kg: float, direction_deg: float, seed: int, limit_s: float = 300.0, **settings: Any
) -> Run:
    """One container from the ship to the vehicle, in at most ``limit_s`` of simulated time. Wind in m/s, towards a
    direction in degrees.

    Raises ConfigError for settings that cannot be.
    """
    given = {
        **RATES,
        "run.duration_s": limit_s,
        "run.seed": seed,
        "dock.container_mass_kg": mass_kg,
        "dock.wind_mean_m_s": mean_m_s,
        "dock.wind_gust_m_s": GUST * mean_m_s,
        "dock.wind_direction_deg": direction_deg,
        **settings,
    }
    simulation = _core.cmrc.Simulation(_core.cmrc.config(settings=given))
    time = 0.0
    while time < limit_s and not simulation.ended:
        time = min(limit_s, time + 2.0)
        simulation.run_until(time)
        if any(kind == "opened" for _, kind, *_ in simulation.dock_events()):
            break
    tries, touches = [], 0
    for _, kind, *_ in simulation.dock_events():
        if kind == "missed":
            touches += 1
        elif kind in ("locked", "opened"):
            tries.append(touches + 1)
            touches = 0
    wind = _report(simulation)["wind"]
    return Run(mean_m_s, mass_kg, tuple(tries), touches, wind["above_share"], wind["waited_s"])


def _report(simulation: Any) -> dict[str, Any]:
    report: dict[str, Any] = json.loads(simulation.report_json())
    return report


def campaign() -> list[Run]:
    """All runs of the page: loads in turn, every second one with wind across the containers, the others from any
    direction."""
    done = []
    for mean, count in WINDS.items():
        for n in range(count):
            direction = ACROSS_DEG if n % 2 == 0 else (n * 137.508) % 360.0
            done.append(land(mean, MASSES_KG[n % len(MASSES_KG)], direction, seed=n + 1))
            print(done[-1], file=sys.stderr, flush=True)
    return done


def table(runs: list[Run]) -> str:
    """One row per mean wind."""
    lines = [
        f"| mean wind, m/s | containers | landings | 1st try | 2nd | 3rd | {' | '.join(LAST_COLUMNS)} |",
        "|---" * (6 + len(LAST_COLUMNS)) + "|",
    ]
    for mean in sorted({run.mean_m_s for run in runs}):
        those = [run for run in runs if run.mean_m_s == mean]
        tries = [n for run in those for n in run.tries]
        never = sum(run.missed > 0 for run in those)
        by_try = [tries.count(n) for n in (1, 2, 3)]
        landings = len(tries) + never
        share = f"{100 * sum(by_try) / landings:.1f} %" if landings else "-"
        above = sum(run.above_share for run in those) / len(those)
        waited = sum(run.waited_s for run in those) / len(those)
        cells: list[object] = [shortest(mean), len(those), landings, *by_try, landings - sum(by_try), share]
        cells += [f"{100 * above:.1f} %", f"{waited:.0f}"]
        lines.append("| " + " | ".join(str(cell) for cell in cells) + " |")
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> int:
    """The command. Returns the exit status."""
    parser = argparse.ArgumentParser(prog="python -m cmrc.landings", description="The table of docs/wind.md.")
    parser.add_argument("--page", type=Path, help="put the table into this page, between its marks")
    given = parser.parse_args(arguments)
    first, last = BLOCK
    if given.page is None:
        print(table(campaign()))
        return 0
    try:
        page = given.page.read_text(encoding="utf-8")
    except OSError as error:
        print(f"{given.page}: {error.strerror}", file=sys.stderr)
        return 2
    if first not in page or last not in page:
        print(f"{given.page} has no lines {first} and {last}", file=sys.stderr)
        return 2
    block = f"{first}\n\n{table(campaign())}\n\n{last}"
    files.write(given.page, re.sub(f"{re.escape(first)}.*{re.escape(last)}", lambda _: block, page, flags=re.DOTALL))
    return 0


if __name__ == "__main__":
    sys.exit(main())
