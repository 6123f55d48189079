"""A fleet on the plant's own dock, driven by the kernels on one emulated DSP: planning, inverse kinematics and
avoidance of every AGV.

No host and no crane: each AGV goes round the default loop again and again, to the warehouse and back to the loading
spot, and waits there for a while. No host makes it queue: only its range sensor shows what is ahead of it.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from typing import Any

from agv_words import forget_avoidance, set_leg
from cmrc import _core
from harness_agv import WINDOW_B, Dsp, signed
from reference_agv import Segment

MS = 10**9  # ps
STEP_TIME, PERIOD_US = 0.02, 20_000
HOLD_S = 2.0


def segments_of(lanes: list[Any]) -> list[Segment]:
    return [Segment(s.x, s.y, s.heading, s.length, s.curvature, s.speed) for s in lanes]


@dataclass
class Vehicle:
    """What the host would know of an AGV."""

    leg: int = 0  # 1 to the warehouse, 2 to the spot
    k: int = 0
    done: bool = True
    ready: float = 0.0  # s, when it may set off
    rounds: int = 0
    history: deque[tuple[float, float, float, float, float, int]] = field(default_factory=lambda: deque(maxlen=500))


class Fleet:
    def __init__(self, config: Any, kernel: str | None) -> None:
        self.dock = _core.plant.Dock(config)
        self.config = config
        self.kernel = kernel
        self.dsp = Dsp()
        s = self.dsp.symbols
        self.unit = [s["AGV_UNIT"] + i * s["AGV_UNIT_WORDS"] for i in range(config.agv_count)]
        self.range = [s["AGV_RANGE"] + i * s["AGV_RANGE_WORDS"] for i in range(config.agv_count)]
        self.vehicles = [Vehicle() for _ in range(config.agv_count)]
        self.t = 0
        for i in range(config.agv_count):
            self.dsp.agv(i)
            for name, value in (("AG_UNIT", self.unit[i]), ("AG_STEP_TIME", STEP_TIME), ("AG_PERIOD_US", PERIOD_US)):
                self.dsp.put(name, value)
            for name, value in (
                ("COUNT", 180),
                ("FIRST", -1_562_070),
                ("STEP", 17_453),
                ("MOUNT", self.dock.range_mount),
            ):
                self.dsp.device(self.range[i] + s[f"RANGE_{name}"], value)

    def set_leg(self, i: int) -> None:
        """From its present place: the way from its slot to the spot comes first."""
        v = self.vehicles[i]
        v.leg = v.leg % 2 + 1
        segments = segments_of(self.config.layout.legs[v.leg - 1])
        if v.leg == 1:
            start = segments[0]
            back = math.cos(start.heading) * (start.x - self.dock.agv_x(i, self.t) / 1e3) + math.sin(start.heading) * (
                start.y - self.dock.agv_y(i, self.t) / 1e3
            )
            if back > 0.5:
                segments[0] = Segment(
                    start.x - back * math.cos(start.heading), start.y - back * math.sin(start.heading), start.heading,
                    start.length + back, 0.0, start.speed)  # fmt: skip
        set_leg(self.dsp, v.leg, segments)
        forget_avoidance(self.dsp)
        v.k, v.done = 0, False

    def sense(self, i: int) -> None:
        d, t, at = self.dock, self.t, self.unit[i]
        for name, value in (
            ("X", d.agv_x(i, t)), ("Y", d.agv_y(i, t)), ("HEADING", d.agv_heading(i, t)), ("SPEED", d.agv_speed(i, t)), ("STATUS", d.agv_status(i, t)),
        ):  # fmt: skip
            self.dsp.device(at + self.dsp.symbols[f"AGV_{name}"], value)

    def scan(self, i: int) -> list[int]:
        return list(self.dock.agv_scan(i, self.t))

    def turn(self, i: int) -> None:
        """What the DSPs do for one AGV now: at most one point."""
        v, d, dsp = self.vehicles[i], self.dock, self.dsp
        status = d.agv_status(i, self.t)
        if status & 0x80:
            return
        dsp.agv(i)
        if v.done and status & 0x1F == 0x10 and self.t >= v.ready * 1e12:
            self.set_leg(i)
        if v.done or status & 0xF >= 2:
            return
        self.sense(i)
        if self.kernel and v.k % 2 == 0:  # 25 Hz
            dsp.chip.load_words(WINDOW_B + self.range[i] + dsp.symbols["RANGE_RAY"], self.scan(i))
            dsp.run(self.kernel, argument=0)
        v.done = bool(dsp.run("trajectory_agv", v.k)[0])
        dsp.run("inverse_agv", v.k)
        names = ("AGV_PERIOD", "AGV_SPEED_COMMAND", "AGV_FRONT_COMMAND", "AGV_REAR_COMMAND")
        period, *point = (dsp.device_word(self.unit[i] + dsp.symbols[name]) for name in names)
        d.agv_period(i, period, self.t)
        d.agv_push(i, *point, self.t)
        v.k += 1
        if v.done:
            v.ready = self.t * 1e-12 + HOLD_S
            v.rounds += v.leg == 2

    def run(self, seconds: float) -> None:
        end = self.t + round(seconds * 1e12)
        while self.t < end:
            for i in range(len(self.vehicles)):
                self.turn(i)
            self.t += 10 * MS
            self.dock.advance_to(self.t)

    def collisions(self) -> list[Any]:
        return [e for e in self.dock.events if e.kind == "collision"]

    def words(self, i: int) -> tuple[int, int, int]:
        self.dsp.agv(i)
        limit, shift, hold = (signed(self.dsp.word(f"AG_AVOID_{n}")) for n in ("LIMIT", "SHIFT", "HOLD"))
        return limit, shift, hold
