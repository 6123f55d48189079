"""The AGV's three sub-processes on one emulated DSP, in closed loop with the reference vehicle among obstacles."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from agv_words import forget_avoidance, measure, pushed, set_leg
from harness_agv import WINDOW_B, Dsp
from range_scene import FIRST, MOUNT, STEP, Scene
from reference_agv import Segment, wrap
from vehicle import Vehicle

RANGE = 0x800  # of AGV 0, as AGV_UNIT is 400h


def show(dsp: Dsp, rays: list[int]) -> None:
    s = dsp.symbols
    assert s["AGV_RANGE"] == RANGE
    for name, value in (
        ("RANGE_COUNT", len(rays)),
        ("RANGE_FIRST", FIRST),
        ("RANGE_STEP", STEP),
        ("RANGE_MOUNT", MOUNT),
    ):
        dsp.device(RANGE + s[name], value)
    dsp.chip.load_words(WINDOW_B + RANGE + s["RANGE_RAY"], rays)


def observe(dsp: Dsp, vehicle: Vehicle) -> None:
    status = len(vehicle.queue) | 0x10 * vehicle.standing | 0x20 * vehicle.loaded
    measure(
        dsp,
        *(math.floor(v) for v in (vehicle.x * 1e3, vehicle.y * 1e3, wrap(vehicle.heading) * 1e6, vehicle.v * 1e3)),
        status,
    )


@dataclass
class Drive:
    """What came of it: closest approach, whether and when the leg ended, traces of (t, x, y, v, shift wanted)."""

    clearance: float = math.inf
    seconds: float = 0.0
    arrived: bool = False
    end: tuple[float, float, float] = (0.0, 0.0, 0.0)
    trace: list[tuple[float, float, float, float, float]] = field(default_factory=list)
    cycles: list[int] = field(default_factory=list)
    stood: float = 0.0


def drive(
    dsp: Dsp, kernel: str | None, segments: list[Segment], scene: Scene, limit: float = 90.0, load: float = 0.0
) -> Drive:
    set_leg(dsp, 1, segments)
    forget_avoidance(dsp)
    dsp.put("AG_PERIOD_US", 20_000)  # other tests of the same DSP change it
    vehicle = Vehicle(segments[0].x, segments[0].y, segments[0].heading, load)
    out, k, done = Drive(), 0, False
    while vehicle.time < limit and not (done and not vehicle.queue and vehicle.standing):
        if len(vehicle.queue) < 2 and not done:
            observe(dsp, vehicle)
            if kernel and k % 2 == 0:  # a scan at 25 Hz, the slowest that plant-and-bus.md 1.5 has being 10
                show(dsp, scene.scan(vehicle.x, vehicle.y, vehicle.heading))
                out.cycles.append(dsp.run(kernel, argument=0)[2])
            done = bool(dsp.run("trajectory_agv", k)[0])
            dsp.run("inverse_agv", k)
            _, speed, front, rear = pushed(dsp)
            vehicle.queue.append((speed / 1e3, front / 1e6, rear / 1e6))
            k += 1
        vehicle.step(0.02)
        scene.move(Vehicle.STEP)
        if vehicle.n % 20 == 0:
            out.clearance = min(out.clearance, scene.clearance(vehicle.x, vehicle.y, vehicle.heading))
            out.stood += 0.02 * (abs(vehicle.v) < 0.02)
            shift = dsp.word("AG_AVOID_SHIFT")
            out.trace.append((vehicle.time, vehicle.x, vehicle.y, vehicle.v, (shift - (shift >> 31 << 32)) / 1e3))
    out.seconds, out.arrived = vehicle.time, done
    out.end = (vehicle.x, vehicle.y, vehicle.heading)
    return out
