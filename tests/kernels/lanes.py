"""Legs to drive: the default loop of the dock, and random chains of lines and arcs."""

from __future__ import annotations

import math
import random

from reference_agv import Segment, wrap


def chain(x: float, y: float, heading: float, pieces: list[tuple[float, float, float]]) -> list[Segment]:
    """Segments that follow each other, from (length, curvature, speed)."""
    out = []
    for length, curvature, speed in pieces:
        out.append(Segment(x, y, wrap(heading), length, curvature, speed))
        if curvature == 0.0:
            x, y = x + length * math.cos(heading), y + length * math.sin(heading)
        else:
            after = heading + curvature * length
            x += (math.sin(after) - math.sin(heading)) / curvature
            y -= (math.cos(after) - math.cos(heading)) / curvature
            heading = after
    return out


def loop() -> tuple[list[Segment], list[Segment]]:
    """To the warehouse and back: 12-m half turns between straights."""
    half = 12 * math.pi
    whole = chain(22, 8, 0, [(20, 0, 5), (half, -1 / 12, 3), (32, 0, 5), (18, 0, 5), (half, -1 / 12, 3), (30, 0, 5)])
    return whole[:3], whole[3:]


def random_leg(rng: random.Random) -> list[Segment]:
    pieces = []
    for _ in range(rng.randint(1, 8)):
        curvature = rng.choice([0.0, rng.choice([-1, 1]) / rng.uniform(12, 60)])
        longest = 40.0 if curvature == 0.0 else min(40.0, math.pi / abs(curvature))
        pieces.append((rng.uniform(0.5, longest), curvature, rng.uniform(1.0, 6.0)))
    return chain(rng.uniform(-50, 50), rng.uniform(-50, 50), rng.uniform(-3.1, 3.1), pieces)
