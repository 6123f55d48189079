"""AGVs among obstacles that stand and move: which of their collisions could have been prevented (dock_traffic.py).

PYTHONPATH=build/python python tests/kernels/traffic_campaign.py --seeds 0:20 --agvs 8            # kernels on one
emulated DSP, the AGVs going round PYTHONPATH=build/python python tests/kernels/traffic_campaign.py --seeds 0:5 --agvs 8
--emulator --seconds 170  # the whole emulator: crane, host, buses, DSPs; AGVs set off as they are loaded, and the
traffic with them
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path[:0] = [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parents[1])]

import numpy as np
from cmrc import Simulation, _core
from dock_traffic import Course, Mover, Waypoint, preventable, random_movers
from fleet_loop import Fleet

LOADED = 75.0  # s: about when the crane has loaded the first AGV
KERNELS = {"potential_field": "avoidance_potential", "vfh": "avoidance_vfh", "dynamic_window": "avoidance_dwa"}


@dataclass
class Outcome:
    collisions: list[tuple[float, int, int]]
    preventable: list[tuple[float, int, int]]
    driven_m: float


def judge(collisions: list[tuple[float, int, int]], courses: list[Course], movers: list[Any]) -> Outcome:
    """A vehicle that was hit is cut off by its bumper: what follows from a collision is no new one."""
    hit: set[int] = set()
    first = []
    for time, agv, other in collisions:
        if not {agv, other} & hit:
            first.append((time, agv, other))
        hit |= {agv, other} - {-1}
    driven = sum(float(np.sum(np.abs(c.rows[1:, 3]) * np.diff(c.time))) for c in courses)
    return Outcome(collisions, preventable(first, courses, movers), driven)


def by_kernels(
    method: str, seed: int, agvs: int, seconds: float, moving: bool = True, field: bool = False, rate: float = 0.0
) -> Outcome:
    config = _core.plant.default_dock(agvs)
    config.layout.movers = random_movers(seed, agvs, moving)
    config.agv.protective_field, config.sensors.range_rate, config.signal_decimation = field, rate, 160
    fleet = Fleet(config, KERNELS.get(method))
    fleet.run(seconds)
    time = np.array([s.time * 1e-12 for s in fleet.dock.signals])
    courses = [
        Course(time, np.array([(a.x, a.y, a.heading, a.speed) for a in rows])) for rows in fleet.dock.agv_signals
    ]
    return judge(
        [(e.time * 1e-12, e.index, int(e.values[1])) for e in fleet.collisions()], courses, config.layout.movers
    )


def layout(movers: list[Any]) -> str:
    return "".join(
        f"[[movers]]\nradius_m = {m.radius!r}\nheight_m = {m.height!r}\npath = {[[w.time, w.x, w.y] for w in m.path]}\n"
        for m in movers
    )


def by_emulator(method: str, seed: int, agvs: int, seconds: float, field: bool = False) -> Outcome:
    movers = [
        Mover(m.radius, m.height, [Waypoint(w.time + LOADED, w.x, w.y) for w in m.path])
        for m in random_movers(seed, agvs)
    ]
    with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
        file.write(layout(movers))
        file.flush()
        simulation = Simulation(
            settings={"dock.layout": file.name, "dock.agvs": agvs, "kernels.avoidance": method, "dock.protective_field": field, "run.duration_s": seconds, "machine.dsps": 4 if method != "dynamic_window" else 8,
                      "rates.servo_frequency_hz": 500, "rates.refresh_frequency_hz": 4000, "scheduling.agv_interval_max_refreshes": 160})  # fmt: skip
        signals = simulation.run().signals
    time = np.array(signals["time_s"])
    courses = []
    for i in range(agvs):
        x, y, heading = (np.array(signals[f"agv{i}_{name}"]) for name in ("x_m", "y_m", "heading_rad"))
        speed = np.cos(heading) * np.gradient(x, time) + np.sin(heading) * np.gradient(y, time)
        courses.append(Course(time, np.stack([x, y, heading, speed], axis=1)))
    collisions = [
        (time, index, int(second))
        for time, kind, index, _, second in simulation._core.dock_events()
        if kind == "collision"
    ]
    return judge(collisions, courses, movers)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--methods", default="potential_field,vfh,dynamic_window", help="or none")
    parser.add_argument("--seeds", default="0:10", help="A:B")
    parser.add_argument("--agvs", type=int, default=8)
    parser.add_argument("--seconds", type=float, default=80.0)
    parser.add_argument("--static", action="store_true", help="only what stands")
    parser.add_argument("--field", action="store_true", help="with the vehicles' own protective field")
    parser.add_argument("--rate", type=float, default=0.0, help="Hz of the range sensors (0: each ms)")
    parser.add_argument("--emulator", action="store_true", help="the whole emulator drives")
    o = parser.parse_args()
    first, last = map(int, o.seeds.split(":"))
    for method in o.methods.split(","):
        total = [0, 0, 0.0]
        for seed in range(first, last):
            out = (
                by_emulator(method, seed, o.agvs, o.seconds, o.field)
                if o.emulator
                else by_kernels(method, seed, o.agvs, o.seconds, not o.static, o.field, o.rate)
            )
            total = [total[0] + len(out.collisions), total[1] + len(out.preventable), total[2] + out.driven_m]
            shown = "; ".join(f"{t:.2f} s AGV {i}" + (f" and {j}" if j >= 0 else "") for t, i, j in out.preventable)
            print(
                f"{method} seed {seed}: {out.driven_m:.0f} m driven, {len(out.collisions)} collisions, {len(out.preventable)} preventable {shown}",
                flush=True,
            )
        print(f"{method}: {total[2]:.0f} m driven, {total[0]} collisions, of these preventable {total[1]}", flush=True)


if __name__ == "__main__":
    main()
