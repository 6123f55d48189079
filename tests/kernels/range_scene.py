"""Obstacles in the plane and what a range sensor of 180 rays sees of them: closed forms of a ray with a circle and with
a segment."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

RAYS, FIRST, STEP, MOST, MOUNT = 180, -1_562_070, 17_453, 30_000, 7_400  # microradians, mm: as the registers show them


@dataclass
class Disc:
    x: float
    y: float
    radius: float
    vx: float = 0.0
    vy: float = 0.0


@dataclass(frozen=True)
class Wall:
    ax: float
    ay: float
    bx: float
    by: float

    @cached_property
    def points(self) -> np.ndarray:
        """Points of the wall, at most 0.1 m apart, as discs without a radius."""
        n = max(2, int(math.hypot(self.bx - self.ax, self.by - self.ay) / 0.1))
        return np.linspace((self.ax, self.ay, 0.0), (self.bx, self.by, 0.0), n + 1)


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

    def distances(self, x: float, y: float, directions: np.ndarray) -> np.ndarray:
        """To the nearest disc or wall in each direction, m; infinity where there is none."""
        dx, dy = np.cos(directions), np.sin(directions)
        best = np.full(len(directions), math.inf)
        for d in self.discs:
            along = (d.x - x) * dx + (d.y - y) * dy
            inside = d.radius**2 - ((d.x - x) ** 2 + (d.y - y) ** 2 - along**2)
            t = along - np.sqrt(np.maximum(inside, 0.0))
            np.minimum(best, t, out=best, where=(inside >= 0) & (t >= 0))
        for w in self.walls:
            ex, ey = w.bx - w.ax, w.by - w.ay
            det = ex * dy - ey * dx
            det[np.abs(det) < 1e-12] = math.nan  # along the wall
            t = (ex * (w.ay - y) - ey * (w.ax - x)) / det
            u = (dx * (w.ay - y) - dy * (w.ax - x)) / det
            np.minimum(best, t, out=best, where=(t >= 0) & (u >= 0) & (u <= 1))
        return best

    def scan(self, x: float, y: float, heading: float) -> list[int]:
        """The registers RANGE_RAY of a vehicle whose middle is at (x, y)."""
        c, s = math.cos(heading), math.sin(heading)
        mm = 1e3 * self.distances(
            x + MOUNT / 1e3 * c, y + MOUNT / 1e3 * s, heading + 1e-6 * (FIRST + STEP * np.arange(RAYS))
        )
        return [MOST if m >= MOST else max(8 * math.floor(m / 8), 48) for m in mm.tolist()]

    def clearance(self, x: float, y: float, heading: float, length: float = 14.8, width: float = 3.0) -> float:
        """Distance of the vehicle's rectangle from the nearest disc or wall's end; negative inside."""
        c, s = math.cos(heading), math.sin(heading)
        discs = np.array([[d.x, d.y, d.radius] for d in self.discs]).reshape(-1, 3)
        px, py, r = np.concatenate([discs, *(wall.points for wall in self.walls)]).T
        u, v = c * (px - x) + s * (py - y), c * (py - y) - s * (px - x)
        ox, oy = np.abs(u) - length / 2, np.abs(v) - width / 2
        outside = np.hypot(np.maximum(ox, 0), np.maximum(oy, 0))
        return float(np.min(np.where(outside > 0, outside, np.maximum(ox, oy)) - r, initial=math.inf))
