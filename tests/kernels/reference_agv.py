"""Double-precision references of the AGV's kernels: the mathematics of docs/kernels_job.md, written for a reader and
not for a C40.

Lengths in m, angles in rad, speeds in m/s, times in s. Nothing here is shared with the assembly but the numbers of the
specification.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

ACCELERATE = 0.45  # m/s^2
BRAKE = 0.8  # m/s^2
WHEELBASE = 9.0  # m
STEER_LIMIT = math.radians(30.0)
ARRIVED = 0.001  # m of arc left that count as the end of the leg

STEER_LEAD = 0.4  # s by which the wheels' commands are ahead
STEER_SWEEP = 1.05  # s over which a step of curvature is spread: 0.36 rad (R 12 m) at 0.35 rad/s
SWEEP_MINIMUM = 0.2  # m

SLOW = 2.5  # m/s, above which the feedback softens
LATERAL_RATIO = 0.32
HEADING_GAIN = 0.5  # 1/m
ALONG_GAIN = 1.2  # 1/s
AT_SPOT = 0.01  # m from the end of the leg where the commanded speed is 0
SLOWEST, FASTEST = -0.2, 6.5  # m/s
STIFFNESS = 4.0e5  # N/rad and axle
MASS_EMPTY, MASS_LOADED = 25.0e3, 49.0e3  # kg: with a container of 24 t


@dataclass(frozen=True)
class Segment:
    x: float
    y: float
    heading: float
    length: float
    curvature: float
    speed: float


@dataclass(frozen=True)
class Point:
    x: float
    y: float
    heading: float
    curvature: float
    speed: float
    left: float
    curvature_ahead: float


def wrap(angle: float) -> float:
    """The angle in (-pi, pi]."""
    return math.remainder(angle, 2.0 * math.pi)


def next_speed(v: float, limit: float, constraints: list[tuple[float, float]], dt: float) -> float:
    """The fastest speed at the end of a step of dt that leaves every (distance, speed) ahead within reach of the brake.

    Between v and the result the vehicle moves (v + result) dt / 2; then result^2 <= speed^2 + 2 BRAKE (distance -
    moved).
    """
    best = min(v + ACCELERATE * dt, limit)
    h = BRAKE * dt
    for distance, speed in constraints:
        q = h * h / 4.0 - h * v + speed * speed + 2.0 * BRAKE * distance
        best = min(best, math.sqrt(max(q, 0.0)) - h / 2.0)
    return max(best, 0.0)


def mean_curvature(segments: list[Segment], low: float, high: float) -> float:
    """Mean curvature of the leg between two arc lengths, the window cut to the leg."""
    start, turn, length = 0.0, 0.0, 0.0
    for segment in segments:
        overlap = min(start + segment.length, high) - max(start, low)
        if overlap > 0.0:
            turn += overlap * segment.curvature
            length += overlap
        start += segment.length
    return turn / length if length > 0.0 else 0.0


@dataclass
class Trajectory:
    """Sub-process 1 of an AGV on one leg."""

    segments: list[Segment]
    step_time: float
    scale: float = 1.0  # held period / step_time, 1 at nominal speed
    s: float = 0.0
    v: float = 0.0

    def __post_init__(self) -> None:
        self.total = math.fsum(segment.length for segment in self.segments)

    def advance(self) -> Point:
        dt = self.step_time
        starts, start = [], 0.0
        for segment in self.segments:
            starts.append(start)
            start += segment.length
        index = max(i for i, begin in enumerate(starts) if begin <= self.s)
        ahead = [(starts[j] - self.s, self.segments[j].speed) for j in range(index + 1, len(starts))]
        ahead.append((self.total - self.s, 0.0))
        v = next_speed(self.v, self.segments[index].speed, ahead, dt)
        self.s += (self.v + v) / 2.0 * dt
        if self.total - self.s < ARRIVED:
            self.s, v = self.total, 0.0
        self.v = v
        return self.point()

    def point(self) -> Point:
        start = 0.0
        for segment in self.segments:
            if self.s <= start + segment.length or segment is self.segments[-1]:
                break
            start += segment.length
        x, y, heading = pose_at(segment, self.s - start)
        speed = self.v / self.scale
        low = self.s + speed * (STEER_LEAD - STEER_SWEEP / 2.0) - SWEEP_MINIMUM / 2.0
        high = self.s + speed * (STEER_LEAD + STEER_SWEEP / 2.0) + SWEEP_MINIMUM / 2.0
        return Point(
            x=x,
            y=y,
            heading=heading,
            curvature=segment.curvature,
            speed=self.v,
            left=self.total - self.s,
            curvature_ahead=mean_curvature(self.segments, low, high),
        )


@dataclass(frozen=True)
class Command:
    speed: float
    front: float
    along: float  # m, the reference ahead of the vehicle
    lateral: float  # m, the vehicle left of the reference


def inverse(
    point: Point,
    x: float,
    y: float,
    heading: float,
    speed: float,
    waiting: int,
    loaded: bool,
    step_time: float,
    period: float,
) -> Command:
    """Sub-process 2 of an AGV: from a point and the measured pose to the drive's set-point; the rear wheels steer the
    other way."""
    v_ref = point.speed * step_time / period
    travel = speed * (waiting + 1.5) * period
    turned = point.curvature_ahead * travel
    x += travel * math.cos(heading + turned / 2)
    y += travel * math.sin(heading + turned / 2)
    c, s = math.cos(point.heading), math.sin(point.heading)
    along = c * (point.x - x) + s * (point.y - y)
    lateral = c * (y - point.y) - s * (x - point.x)
    mass = MASS_LOADED if loaded else MASS_EMPTY
    drift = mass * v_ref * v_ref * point.curvature_ahead / (2.0 * STIFFNESS)
    stiff = HEADING_GAIN * min(1.0, SLOW / v_ref) if v_ref > 0 else HEADING_GAIN
    k = (
        point.curvature_ahead
        - LATERAL_RATIO * stiff**2 * lateral
        - stiff * math.sin(heading + turned - point.heading - drift)
    )
    front = max(-STEER_LIMIT, min(STEER_LIMIT, math.atan(WHEELBASE * k / 2.0)))
    v = max(SLOWEST, min(FASTEST, v_ref + ALONG_GAIN * along))
    if abs(along) < AT_SPOT if point.left == 0.0 else v_ref == 0.0:
        v = 0.0
    return Command(v, front, along, lateral)


# ---- process 1 -------------------------------------------------------------------------------------------------------

BOX_LENGTH, BOX_WIDTH = 12.192, 2.438
TOLERANCE = 0.25  # m in height
ENOUGH = 0.93
TIERS = 4
QUANTUM = 0.008


def identify(
    rows: list[tuple[float, np.ndarray]], x0: float, dx: float, deck: float, height: float
) -> tuple[float, float, float] | None:
    """Process 1: x, y, z of the next container's top, from each row's y and profile (m); None when there is none."""
    width = math.floor(BOX_LENGTH / dx)
    template = np.concatenate([[-0.5], np.ones(width), [-0.5]])
    best: tuple[int, float] | None = None
    found = None
    for y, profile in rows:
        h = profile - deck
        for tier in range(TIERS, 0, -1):
            fit = np.clip(1.0 - ((h - tier * height) / TOLERANCE) ** 2, 0.0, None)
            score = np.concatenate([[0.0], np.correlate(np.concatenate([[0.0], fit, [0.0]]), template, "valid"), [0.0]])
            for m in range(1, len(score) - 1):
                before, here, after = score[m - 1 : m + 2]
                if here >= ENOUGH * width and here > before and here >= after:
                    fits = np.concatenate([[False], fit > 0, [False]])
                    middle = m - 1 + width // 2 + 1
                    left = max(k for k in range(middle) if not fits[k]) - 1
                    right = min(k for k in range(middle, len(fits)) if not fits[k]) - 1
                    cells = np.concatenate([h, [0.0, 0.0]]) / (tier * height)  # index -1 is a zero too
                    edges = left + 1.5 - cells[left] - cells[left + 1], right - 1.5 + cells[right] + cells[right - 1]
                    x = x0 + dx * sum(edges) / 2
                    rank = (-tier, x * x + y * y)
                    if best is None or rank < best:
                        best = rank
                        found = (x, y, deck + float(np.mean(h[left + 2 : right - 1])) + QUANTUM / 2)
    return found


# ---- process 2 -------------------------------------------------------------------------------------------------------

MARGIN, TOUCH, RISE, RISES = 0.5, 0.05, 0.5, 8
INNER, SWEEPS, PUSHES = 5, 40, 12

Pose = tuple[float, float, float, float]
Box = tuple[float, float, float, float, float, float]


def grow(box: Box, yaw: float, hang: float) -> np.ndarray:
    """xmin, xmax, ymin, ymax, top of what the middle of the spreader's underside must stay out of."""
    c, s = abs(math.cos(yaw)), abs(math.sin(yaw))
    ex = (BOX_LENGTH * c + BOX_WIDTH * s) / 2 + MARGIN
    ey = (BOX_LENGTH * s + BOX_WIDTH * c) / 2 + MARGIN
    return np.array([box[0] - ex, box[1] + ex, box[2] - ey, box[3] + ey, box[5] + hang + MARGIN])


def faces(box: np.ndarray, p: np.ndarray) -> np.ndarray:
    """How far inside each face of a grown box a point is."""
    return np.array([p[0] - box[0], box[1] - p[0], p[1] - box[2], box[3] - p[1], box[4] - p[2]])


def inside(box: np.ndarray, p: np.ndarray, q: np.ndarray) -> tuple[float, float]:
    """The share of the way from p to q that is deeper than TOUCH in a box; (.., less) when none is."""
    low, high = 0.0, 1.0
    for a, e in zip(faces(box, p) - TOUCH, faces(box, q) - TOUCH):
        if a <= 0 and e <= 0:
            return 0.0, -1.0
        if a <= 0:
            low = max(low, a / (a - e))
        elif e <= 0:
            high = min(high, a / (a - e))
    return low, high


def blocked(boxes: list[np.ndarray], p: np.ndarray, q: np.ndarray) -> bool:
    return any(low < high for low, high in (inside(box, p, q) for box in boxes))


OUT = ((0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0), (2, 1.0))  # axis and direction of each face
OVER = 4


def choose(boxes: list[np.ndarray], p: np.ndarray, q: np.ndarray) -> list[int | None]:
    chosen: list[int | None] = []
    for box in boxes:
        low, high = inside(box, p, q)
        deepest = np.maximum(*(faces(box, p + t * (q - p)) for t in (low, high)))
        face = OVER if low <= 0.0 or high >= 1.0 else int(np.argmin(deepest))
        chosen.append(face if low < high else None)
    return chosen


def push(boxes: list[np.ndarray], chosen: list[int | None], p: np.ndarray, other: np.ndarray) -> None:
    """Moves p so that the way to `other` leaves every box in turn."""
    for box, face in zip(boxes, chosen):
        low, high = inside(box, p, other)
        if low < high:
            depth = faces(box, p + (low + high) / 2 * (other - p))
            face = int(np.argmin(depth)) if face is None else face
            axis, sign = OUT[face]
            p[axis] += sign * depth[face]


def band(boxes: list[np.ndarray], start: np.ndarray, end: np.ndarray) -> list[np.ndarray]:
    chosen = choose(boxes, start, end)
    points = [start + (end - start) * i / (INNER + 1) for i in range(INNER + 2)]
    for p in points[1:-1]:
        for box, face in zip(boxes, chosen):
            if face == OVER and box[0] < p[0] < box[1] and box[2] < p[1] < box[3]:
                p[2] = max(p[2], box[4])
    for sweep in range(SWEEPS):
        for i in range(1, INNER + 1):
            if sweep < SWEEPS - PUSHES:
                points[i][:3] = (points[i - 1][:3] + points[i + 1][:3]) / 2
            push(boxes, chosen, points[i], points[i - 1])
            push(boxes, chosen, points[i], points[i + 1])
    return points


def over(boxes: list[np.ndarray], a: np.ndarray, b: np.ndarray, start: np.ndarray, end: np.ndarray) -> list[np.ndarray]:
    """Straight up, over everything that the plan of the way crosses, straight down."""
    flat = np.array([1.0, 1.0, 0.0, 1.0])
    crossed = [box for box in boxes if np.less(*inside(np.array([*box[:4], 1e9]), a * flat, b * flat))]
    z = max([a[2], b[2], *(box[4] for box in crossed)])
    chain = [np.array([*start[:2], z, start[3]])] if z > start[2] else []
    chain.append(np.array([*end[:2], z, end[3]]))
    return [*chain, end] if z > end[2] else chain


def plan(boxes: list[np.ndarray], start: Pose, end: Pose, column_at_start: bool, least: float) -> list[np.ndarray]:
    """The via points from start (not among them) to end."""
    p, q = np.array(start), np.array(end)
    up = np.array([0.0, 0.0, 1.0, 0.0])
    for n in range(RISES + 1):
        lift = least + RISE * n
        a, b = (p + lift * up, q) if column_at_start else (p, q + lift * up)
        if not blocked(boxes, a, b):
            chain = [b]
            break
    else:
        lift = least
        a, b = (p + lift * up, q) if column_at_start else (p, q + lift * up)
        points = band(boxes, a, b)
        chain, i = [], 0
        while i < INNER + 1:
            free = [j for j in range(INNER + 1, i, -1) if not blocked(boxes, points[i], points[j])]
            if not free:
                return over(boxes, a, b, p, q)
            i = free[0]
            chain.append(points[i])
    if lift > 0:
        chain = [a, *chain] if column_at_start else [*chain, q]
    return chain


# ---- process 8 -------------------------------------------------------------------------------------------------------


def pose_at(segment: Segment, sigma: float) -> tuple[float, float, float]:
    half = segment.curvature * sigma / 2.0
    chord = sigma * (math.sin(half) / half if half else 1.0)
    return (
        segment.x + chord * math.cos(segment.heading + half),
        segment.y + chord * math.sin(segment.heading + half),
        wrap(segment.heading + 2 * half),
    )


def cut_leg(segments: list[Segment], x: float, y: float) -> list[Segment]:
    """What lies ahead of the leg's nearest point to (x, y), found by looking everywhere and refining."""
    best = (math.inf, 0, 0.0)
    for i, segment in enumerate(segments):
        sigmas = np.linspace(0.0, segment.length, 2001)
        step = segment.length / 2000
        for _ in range(6):
            distance = [math.hypot(px - x, py - y) for px, py, _ in (pose_at(segment, float(s)) for s in sigmas)]
            at = int(np.argmin(distance))
            centre = float(sigmas[at])
            if distance[at] < best[0]:
                best = (distance[at], i, centre)
            sigmas = np.clip(np.linspace(centre - step, centre + step, 21), 0.0, segment.length)
            step /= 10
    _, i, sigma = best
    first = segments[i]
    px, py, heading = pose_at(first, sigma)
    return [Segment(px, py, heading, first.length - sigma, first.curvature, first.speed), *segments[i + 1 :]]
