"""Obstacles in the plane and what a range sensor of 180 rays sees of them: closed forms of a ray with a circle and with a segment."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

RAYS, FIRST, STEP, MOST, MOUNT = 180, -1_562_070, 17_453, 30_000, 7_400  # microradians, mm: as the registers show them


@dataclass
class Disc:
    x: float
    y: float
    radius: float
    vx: float = 0.0
    vy: float = 0.0


@dataclass
class Wall:
    ax: float
    ay: float
    bx: float
    by: float


@dataclass
class Scene:
    discs: list[Disc] = field(default_factory=list)
    walls: list[Wall] = field(default_factory=list)

    def box(self, x: float, y: float, heading: float, length: float, width: float) -> None:
        c, s = math.cos(heading), math.sin(heading)
        corners = [(x + c * u - s * v, y + s * u + c * v) for u, v in
                   ((length / 2, width / 2), (-length / 2, width / 2), (-length / 2, -width / 2), (length / 2, -width / 2))]  # fmt: skip
        self.walls += [Wall(*corners[i], *corners[(i + 1) % 4]) for i in range(4)]

    def move(self, seconds: float) -> None:
        for d in self.discs:
            d.x, d.y = d.x + d.vx * seconds, d.y + d.vy * seconds

    def distance(self, x: float, y: float, direction: float) -> float:
        dx, dy = math.cos(direction), math.sin(direction)
        best = math.inf
        for d in self.discs:
            along = (d.x - x) * dx + (d.y - y) * dy
            across2 = (d.x - x) ** 2 + (d.y - y) ** 2 - along**2
            if across2 <= d.radius**2:
                t = along - math.sqrt(d.radius**2 - across2)
                if t >= 0:
                    best = min(best, t)
        for w in self.walls:
            ex, ey = w.bx - w.ax, w.by - w.ay
            det = ex * dy - ey * dx
            if abs(det) < 1e-12:
                continue
            t = (ex * (w.ay - y) - ey * (w.ax - x)) / det
            u = (dx * (w.ay - y) - dy * (w.ax - x)) / det
            if t >= 0 and 0 <= u <= 1:
                best = min(best, t)
        return best

    def scan(self, x: float, y: float, heading: float) -> list[int]:
        """The registers RANGE_RAY of a vehicle whose middle is at (x, y)."""
        c, s = math.cos(heading), math.sin(heading)
        px, py = x + MOUNT / 1e3 * c, y + MOUNT / 1e3 * s
        out = []
        for ray in range(RAYS):
            mm = 1e3 * self.distance(px, py, heading + 1e-6 * (FIRST + ray * STEP))
            out.append(MOST if mm >= MOST else max(8 * math.floor(mm / 8), 48))
        return out

    def clearance(self, x: float, y: float, heading: float, length: float = 14.8, width: float = 3.0) -> float:
        """Distance of the vehicle's rectangle from the nearest disc or wall's end; negative inside."""
        c, s = math.cos(heading), math.sin(heading)
        best = math.inf
        points = [(d.x, d.y, d.radius) for d in self.discs]
        for w in self.walls:
            n = max(2, int(math.hypot(w.bx - w.ax, w.by - w.ay) / 0.1))
            points += [(w.ax + (w.bx - w.ax) * i / n, w.ay + (w.by - w.ay) * i / n, 0.0) for i in range(n + 1)]
        for px, py, r in points:
            u, v = c * (px - x) + s * (py - y), c * (py - y) - s * (px - x)
            ox, oy = abs(u) - length / 2, abs(v) - width / 2
            outside = math.hypot(max(ox, 0), max(oy, 0))
            best = min(best, (outside if outside > 0 else max(ox, oy)) - r)
        return best
