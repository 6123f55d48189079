"""Double-precision reference of obstacle avoidance, from docs/kernels.md: lanes by circles and their centres, sums and
minima in numpy."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from reference_agv import Segment, pose_at, wrap

AHEAD, BEHIND, BEYOND, ACROSS, STANDS = 45.0, -15.0, 40.0, 11.0, 8.0  # m
HALF, CLOSE, CLOSE_AHEAD, CLOSE_SPEED = 1.9, 2.4, 12.0, 2.0
SHIFT_MOST, HOLD_WITHIN, REAR, HOME, BLEND = 2.5, 25.0, 9.0, 25.0, 15.0
B, T, STAND, CREEP = 0.9, 0.5, 1.5, 0.125
SHIFTING, SHIFT_SPEED = 0.5, 2.5
REACH, FASTEST = 25.0, 6.0
MOVES, MOVES_MOST, BIN, BINS, PASSED = 0.25, 3.0, 1.5, 32, 16.0
COMES, CROSSES, PASSES, SOON, WAY = 0.5, 0.6, 22.0, 2.0, 3.8
NEEDS, GROUP, NEAR, BESIDE, FRONT = 2.05, 8.0, 8.0, 4.5, 4.0
NOTHING = 1000.0
HALF_LENGTH = 7.4


@dataclass
class Look:
    """What is kept of a look: the distances along the leg (m) to what blocks the way and to what is close to it; and
    for each bin of the leg the lateral place nearest to the lane, to the left and (negated) to the right."""

    count: int
    block: float
    close: float
    sides: tuple[list[float], list[float]]


@dataclass
class View:
    """What avoidance reads."""

    x: float
    y: float
    heading: float
    speed: float
    rays: list[float | None]  # m; None: nothing, or no valid echo
    first: float
    step: float
    mount: float
    segments: list[Segment]
    s: float
    curvature: float
    shift: float
    hold: float
    count: int = 8
    period: float = 0.02
    then: Look | None = None  # the look two slots of 16 points before
    older: Look | None = None  # three
    wait: int = 0
    place: float = 0.0
    flank: float = 0.0


@dataclass
class Echo:
    range: float
    x: float
    y: float
    along: float
    lateral: float
    sector: int
    swing: float


def pieces(view: View) -> list[tuple[float, Segment]]:
    out, start = [], 0.0
    for g in view.segments:
        if start - view.s <= AHEAD and start + g.length - view.s >= BEHIND:
            out.append((start, g))
        start += g.length
    x, y, h = pose_at(view.segments[-1], view.segments[-1].length)
    return [*out, (start, Segment(x, y, h, BEYOND, 0.0, 0.0))]


def swing(view: View, n: int, along: float) -> float:
    """How far the vehicle's ends swing out to the left, where piece n is `along` from the leg's start."""
    path = pieces(view)
    start, g = path[n]
    if g.curvature:
        return -(HALF_LENGTH**2) / 2 * g.curvature
    ends = [(along - start, path[n - 1][1].curvature)] if n else []
    if n + 1 < len(path):
        ends.append((start + g.length - along, path[n + 1][1].curvature))
    return sum(-(max(0.0, min(HALF_LENGTH, HALF_LENGTH - d)) ** 2) / 2 * k for d, k in ends)


def clear(e: Echo, place: float) -> float:
    """How far an echo is from what the vehicle's middle sweeps at that lateral place."""
    off = e.lateral - place
    return abs(off) - (abs(e.swing) if off * e.swing > 0 else 0.0)


def project(view: View, x: float, y: float) -> tuple[float, float, int] | None:
    best: tuple[float, float, int] | None = None
    for n, (start, g) in enumerate(pieces(view)):
        if g.curvature == 0:
            along = math.cos(g.heading) * (x - g.x) + math.sin(g.heading) * (y - g.y)
            lateral = math.cos(g.heading) * (y - g.y) - math.sin(g.heading) * (x - g.x)
        else:
            r, sign = 1 / g.curvature, math.copysign(1, g.curvature)
            cx, cy = g.x - r * math.sin(g.heading), g.y + r * math.cos(g.heading)
            lateral = r - sign * math.hypot(x - cx, y - cy)
            along = wrap(math.atan2(sign * (x - cx), -sign * (y - cy)) - g.heading) * r
        if -0.5 <= along <= g.length + 0.5 and abs(lateral) < min(ACROSS, abs(best[1]) if best else ACROSS):
            best = (start + along, lateral, n)
    return best


class Lane:
    """The view along and across the lane."""

    def __init__(self, view: View, sectors: int) -> None:
        self.view = view
        foot = project(view, view.x, view.y)
        self.s, self.lateral = foot[:2] if foot else (view.s, 0.0)
        self.left = sum(g.length for g in view.segments) - self.s
        self.last = self.left - HOME - REAR  # the last place of an obstacle beside the lane that the vehicle passes
        self.echoes: list[Echo] = []
        self.look: Look | None = None  # what decide keeps
        self.wait, self.place = view.wait, view.place
        self.flank = view.flank
        n = len(view.rays)
        c, s = math.cos(view.heading), math.sin(view.heading)
        for k in range(sectors):
            sector = [
                (r, -i)
                for i, r in enumerate(view.rays)
                if k * n // sectors <= i < (k + 1) * n // sectors and r is not None
            ]
            if not sector:
                continue
            r, i = min(sector, key=lambda e: (e[0], -e[1]))
            angle = view.first - i * view.step
            x, y = view.mount + r * math.cos(angle), r * math.sin(angle)
            at = project(view, view.x + c * x - s * y, view.y + s * x + c * y)
            if at:
                self.echoes.append(Echo(r, x, y, at[0] - self.s, at[1], k, swing(view, at[2], at[0])))

    def target(self, ahead: float) -> tuple[float, float]:
        s = self.s + ahead
        for start, g in zip(np.cumsum([0, *(g.length for g in self.view.segments)]), self.view.segments):
            if s < start + g.length or g is self.view.segments[-1]:
                x, y, h = pose_at(g, min(s - start, g.length))
                beyond = max(0.0, s - start - g.length)
                break
        dx, dy = x + beyond * math.cos(h) - self.view.x, y + beyond * math.sin(h) - self.view.y
        c, si = math.cos(self.view.heading), math.sin(self.view.heading)
        return c * dx + si * dy, c * dy - si * dx


def feasible(lane: Lane, shift: float, first: float) -> float:
    """The shift with which the group of obstacles that begins `first` ahead can be passed; 0 if there is none."""
    sides = {
        +1: [-math.inf, SHIFT_MOST],
        -1: [-math.inf, SHIFT_MOST],
    }  # needed, possible; to the right all signs are turned
    for e in lane.echoes:
        if e.along - first >= GROUP:
            continue
        for sign, (needed, possible) in sides.items():
            lateral, out = sign * e.lateral, sign * e.swing
            if clear(e, 0.0) < HALF:
                sides[sign][0] = max(needed, lateral + NEEDS + max(0.0, -out))
            elif lateral > 0:
                sides[sign][1] = min(possible, lateral - NEEDS - max(0.0, out))
    sign = 1 if shift > 0 else -1
    for s in (sign, -sign):
        needed, possible = sides[s]
        if needed <= possible:
            return s * (min(max(abs(shift), needed), possible) if s == sign else needed)
    return 0.0


def side(lane: Lane, shift: float) -> tuple[float, float]:
    """Shift, hold."""
    view = lane.view
    shift = max(-SHIFT_MOST, min(SHIFT_MOST, shift))
    inside = [e.along for e in lane.echoes if clear(e, 0.0) < HALF]
    passable = [a for a in inside if a <= lane.last and a < HOLD_WITHIN]
    late = [a for a in inside if a > lane.last]
    hold = max([view.hold, *(lane.s + a + REAR for a in passable)])
    if passable and shift:
        shift = feasible(lane, shift, min(passable))
    if view.hold > lane.s:
        if abs(shift) < abs(view.shift) or shift * view.shift < 0:
            shift = view.shift
    elif late and min(late) < min(passable, default=NOTHING):
        shift = 0.0
    lane.flank = max(
        [
            view.flank,
            *(
                lane.s + e.along + REAR
                for e in lane.echoes
                if e.x - view.mount < SOON and e.along - view.mount < BESIDE and clear(e, 0.0) < BESIDE
            ),
        ]
    )
    if lane.flank > lane.s:
        shift = max(min(shift, max(view.shift, 0.0)), min(view.shift, 0.0))
    return (0.0 if lane.left < HOME else shift), hold


def way(lane: Lane, shift: float, along: float) -> float:
    t = min(max(along - FRONT, 0.0) / BLEND, 1.0)
    return shift + (lane.lateral - shift) * (1 - t) ** 2 * (1 + 2 * t)


def block(lane: Lane, shift: float) -> tuple[float, float, float]:
    """Distances from the front, in m: to what blocks the way, to what is close to it, and to what blocks nearby and
    must stay in view."""
    free, close, seen = math.inf, math.inf, math.inf
    for e in lane.echoes:
        gap = clear(e, way(lane, shift, e.along))
        if e.along > lane.last:
            gap = min(gap, clear(e, 0.0))
        ahead = max(e.along, e.x) - lane.view.mount
        if gap >= CLOSE:
            continue
        close = min(close, ahead)
        if gap < HALF:
            free = min(free, ahead)
            if ahead < NEAR:
                seen = min(seen, e.x - lane.view.mount)
    return free, close, seen


def remember(lane: Lane, ahead: float, way: float, speed: float) -> None:
    """Keeps an obstacle that the sensor soon loses: its place, and the number of the look at which the vehicle has gone
    `way` m and passed it."""
    place = lane.s + lane.view.mount + ahead
    if lane.wait <= lane.view.count or place <= lane.place:
        lane.wait, lane.place = lane.view.count + math.floor(way / speed / lane.view.period), place


def motion(lane: Lane, shift: float, free: float, close: float) -> tuple[float, Look]:
    """The free distance, shortened by what moves into the way, along it or past the vehicle; and this look."""
    view, then = lane.view, lane.view.then
    rate = 0.0
    if then is not None and 16 <= view.count - then.count < 48:
        rate = 1 / ((view.count - then.count) * view.period)
    base = lane.s + view.mount
    now = Look(view.count, min(base + free, NOTHING), min(base + close, NOTHING), ([NOTHING] * BINS, [NOTHING] * BINS))
    if then is not None and rate:
        stopping = T + view.speed / B
        if NOTHING not in (then.block, now.block) and MOVES < (comes := (then.block - now.block) * rate) <= MOVES_MOST:
            free -= comes * stopping
        if NOTHING not in (then.close, now.close) and COMES < (comes := (then.close - now.close) * rate) <= MOVES_MOST:
            if close < SOON:
                remember(lane, close, close + PASSES, comes)
            free = min(free, close - comes * stopping)
    for e in lane.echoes:
        n, sign, k = (
            math.floor((lane.s + e.along) / BIN),
            (1 if e.lateral >= lane.lateral else -1),
            int(e.lateral < lane.lateral),
        )
        place, ahead = sign * e.lateral, max(e.along, e.x) - view.mount
        now.sides[k][n % BINS] = min(now.sides[k][n % BINS], place)
        if then is None or not rate:
            continue
        before = min(then.sides[k][(n + d) % BINS] for d in (-1, 0, 1))
        speed = min((before - place) * rate, MOVES_MOST)
        if before >= NOTHING or speed <= MOVES:
            continue
        gap = clear(e, way(lane, shift, e.along)) - HALF
        if gap / speed < (ahead + PASSED) / max(view.speed, 1.0):
            free = min(free, ahead)
            older = view.older
            if e.x - view.mount < SOON and older is not None and 32 <= view.count - older.count < 64:
                before = min(older.sides[k][(n + d) % BINS] for d in (-1, 0, 1))
                speed = (before - place) / ((view.count - older.count) * view.period)
                if before < NOTHING and speed > CROSSES:
                    remember(lane, ahead, gap + WAY, speed)
    return free, now


Said = tuple[float | None, float, float, float, float, int]  # limit (None: none), shift, hold, place, flank, wait


def decide(lane: Lane, shift: float, speed: float) -> Said:
    view = lane.view
    shift, hold = side(lane, shift)
    free, close, seen = block(lane, shift)
    if shift != view.shift and free < view.speed * T + view.speed**2 / (2 * B) + STAND:
        other = block(lane, view.shift)
        if other[0] > free + 0.5:
            shift, (free, close, seen) = view.shift, other
    free, lane.look = motion(lane, shift, free, close)
    free = min(free, seen)
    if lane.wait > view.count:
        free = min(free, lane.place - lane.s - view.mount)
    if free < math.inf:
        # v T + v^2 / (2 B) = what is left
        left = max(0.0, free - STAND)
        stoppable = float(max(np.roots([1 / (2 * B), T, -left]).real))
        speed = min(speed, stoppable if stoppable >= CREEP else 0.0)
    if close < CLOSE_AHEAD:
        speed = min(speed, CLOSE_SPEED)
    if abs(shift - lane.lateral) > SHIFTING:
        speed = min(speed, SHIFT_SPEED)
    return (None if speed == math.inf else speed), shift, hold, lane.place, lane.flank, lane.wait


def nearest(lane: Lane) -> list[Echo]:
    """The nearest echo of each four sectors."""
    groups: dict[int, Echo] = {}
    for e in lane.echoes:
        if abs(e.lateral) >= STANDS:
            continue
        if e.sector // 4 not in groups or e.range < groups[e.sector // 4].range:
            groups[e.sector // 4] = e
    return list(groups.values())


def potential(view: View) -> Said:
    lane = Lane(view, 64)
    total = np.zeros(2)
    for e in nearest(lane):
        d = max(e.range, 0.5)
        force = min((1 / d - 1 / REACH) / d**2, 1e-4)
        if force <= 0:
            continue
        turn = math.radians(60 if e.lateral - view.shift / 2 >= 0 else -60)
        away = -np.array([e.x - view.mount, e.y]) / d
        rotation = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
        total += force * rotation @ away
    speed = FASTEST / (1 - 3000 * total[0]) if total[0] < 0 else math.inf
    return decide(lane, 30000 * total[1], speed)


def vfh(view: View) -> Said:
    lane = Lane(view, 72)
    density = 72 / (len(view.rays) * view.step)
    dark = np.zeros(72)
    nearest, beside = REACH, 0.0
    for e in lane.echoes:
        if e.range >= REACH or abs(e.lateral) >= STANDS:
            continue
        if e.range < nearest:
            nearest, beside = e.range, e.lateral
        x = min(HALF / max(e.range, 0.5), 0.98)
        half = math.floor((x + x**3 / 6 + 3 * x**5 / 40) * density)
        span = slice(max(0, e.sector - half), min(71, e.sector + half) + 1)
        dark[span] = np.maximum(dark[span], (1 - max(e.range, 0.5) / REACH) ** 2)
    padded = np.concatenate([[dark[0]] * 2, dark, [dark[-1]] * 2])
    smooth = np.convolve(padded, np.array([1, 2, 3, 2, 1]) / 9, "valid")
    tx, ty = lane.target(view.mount + 10.0)
    goal = min(71, max(0, math.floor((math.atan2(ty, tx - view.mount) - view.first) * density)))
    if smooth[goal] < 0.02:
        return decide(lane, 0.0, math.inf)
    side = 1 if (view.shift or -beside) > 0 else -1
    behind = 4 if view.shift else 2
    # distance in sectors, the other side counted as `behind` farther and after this one
    ways = sorted(
        (abs(k - goal) + (0 if (k - goal) * side > 0 else behind), (k - goal) * side < 0, k)
        for k in range(72)
        if smooth[k] < 0.02
    )
    if not ways:
        return decide(lane, view.shift, 0.0)
    angle = (ways[0][2] - goal) / density
    return decide(lane, lane.lateral + max(nearest, 4.0) * math.sin(angle), FASTEST * (1 - 0.7 * smooth[goal]))


def dynamic_window(view: View) -> Said:
    lane = Lane(view, 64)
    near = nearest(lane)
    spots = np.array([[e.x, e.y] for e in near] + [[1000.0, 0.0]] * (16 - len(near)))
    slow, fast = max(0.0, view.speed - 1.5), min(FASTEST, view.speed + 0.75)
    goal = np.array(lane.target(view.mount + 12.0))
    best, met, least = (-math.inf, math.nan, math.nan), False, math.inf
    for i in range(11):
        v = slow + (fast - slow) * i / 10
        for j in range(-5, 6):
            k = view.curvature + 0.01 * j
            half = 6.0 * k
            end = 12.0 * np.array([math.cos(half), math.sin(half)]) + view.mount * np.array(
                [math.cos(2 * half), math.sin(2 * half)]
            )
            way = max(0.4 * v, 1.6)
            headings = k * way * (np.arange(10) + 0.5)
            ahead = np.stack([np.cos(headings), np.sin(headings)], axis=1)
            fronts = np.cumsum(way * ahead, axis=0) + view.mount * ahead
            far = np.min(np.linalg.norm(fronts[:, None] - spots[None], axis=2), axis=1)
            least = min(least, float(far.min()))
            if (far < HALF).any():
                met = True
                if v * T + v * v / (2 * B) > way * int(np.argmax(far < HALF)) - STAND:
                    continue
            score = 0.5 * v + min(float(far.min()) - HALF, 2.0) - 0.6 * float(np.linalg.norm(end - goal))
            if score > best[0]:
                best = (score, v, float(end[1] - goal[1]))
    if not met and least >= 2.5:
        return decide(lane, 0.0, math.inf)
    if best[0] == -math.inf:
        return decide(lane, view.shift, 0.0)
    return decide(lane, best[2], best[1])


METHODS = {"avoidance_potential": potential, "avoidance_vfh": vfh, "avoidance_dwa": dynamic_window}
