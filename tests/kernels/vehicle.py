"""A container AGV to drive against: the single-track model and the drive unit of plant-and-bus.md 1.5, by Euler steps
of 1 ms.

Coarser than the plant and written apart from it; the kernels' closed loop must hold with either.
"""

from __future__ import annotations

import math
from collections import deque


def clamp(x: float, low: float, high: float) -> float:
    return max(low, min(high, x))


class Vehicle:
    STEP = 0.001  # s

    def __init__(self, x: float, y: float, heading: float, load: float) -> None:
        self.x, self.y, self.heading = x, y, heading
        self.v = self.side = self.r = self.front = self.rear = self.force = 0.0
        self.mass, self.inertia = 25e3 + load, 4.8e5 * (1 + load / 25e3)
        self.loaded = load > 0
        self.queue: deque[tuple[float, float, float]] = deque()
        self.current = (0.0, 0.0, 0.0)
        self.command = self.integral = self.reference = self.due = 0.0
        self.running = self.dry = False
        self.standing = True
        self.ran_dry = 0
        self.n = 0

    @property
    def time(self) -> float:
        return self.n * self.STEP

    def step(self, period: float) -> None:
        self.take(period)
        if self.n % 10 == 0:
            self.drive()
        self.n += 1
        h = self.STEP
        self.front += h * clamp((self.current[1] - self.front) / 0.2, -0.35, 0.35)
        self.rear += h * clamp((self.current[2] - self.rear) / 0.2, -0.35, 0.35)
        self.force += h * (self.command - self.force) / 0.3
        if not self.standing:
            self.roll(h)

    def take(self, period: float) -> None:
        if self.running and self.time < self.due - 1e-9:
            return
        if not self.queue:
            driving = self.running and self.current[0] != 0.0
            self.ran_dry += driving
            self.running, self.dry = False, self.dry or driving
            return
        self.current = self.queue.popleft()
        self.due = (self.due if self.running else self.time) + period
        self.running, self.dry = True, False

    def drive(self) -> None:
        target = 0.0 if self.dry else self.current[0]
        if target == 0.0 and (self.standing or (abs(self.reference) < 1e-9 and abs(self.v) < 0.02)):
            self.standing = True
            self.reference = self.integral = self.command = self.v = self.side = self.r = self.force = 0.0
            return
        self.standing = False
        before = self.reference
        slower = abs(target) < abs(before) or target * before < 0.0
        change = (1.0 if slower else 0.5) * 0.01
        self.reference += clamp(target - before, -change, change)
        error, m = self.reference - self.v, self.mass
        ahead = m * (self.reference - before) / 0.01 + self.resistance(self.reference)
        wanted = ahead + 2.0 * m * error + self.integral
        self.command = clamp(wanted, -2.0 * m, 2.0 * m)
        if self.command == wanted:
            self.integral += 0.5 * 2.0 * m * error * 0.01

    def resistance(self, v: float) -> float:
        return 0.01 * self.mass * 9.81 * math.tanh(v / 0.02) + 5.0 * v * abs(v)

    def roll(self, h: float) -> None:
        v, m, arm = self.v, self.mass, 4.5
        tf, tr = math.tan(self.front), math.tan(self.rear)
        along = self.force - self.resistance(v)
        side, turn = (v * (tf + tr) / 2 - self.side) / 0.05, (v * (tf - tr) / (2 * arm) - self.r) / 0.05
        u = clamp((abs(v) - 0.25) / 0.25, 0.0, 1.0)
        weight = u * u * (3 - 2 * u)
        if weight > 0:
            limit = 0.7 * m * 9.81 / 2
            ff = -clamp(4e5 * (math.atan2(self.side + arm * self.r, v) - self.front), -limit, limit)
            fr = -clamp(4e5 * (math.atan2(self.side - arm * self.r, v) - self.rear), -limit, limit)
            along -= weight * (ff * math.sin(self.front) + fr * math.sin(self.rear))
            cf, cr = math.cos(self.front), math.cos(self.rear)
            side = weight * ((ff * cf + fr * cr) / m - v * self.r) + (1 - weight) * side
            turn = weight * arm * (ff * cf - fr * cr) / self.inertia + (1 - weight) * turn
        self.x += h * (v * math.cos(self.heading) - self.side * math.sin(self.heading))
        self.y += h * (v * math.sin(self.heading) + self.side * math.cos(self.heading))
        self.heading += h * self.r
        self.v += h * (along / m + weight * self.side * self.r)
        self.side += h * side
        self.r += h * turn
