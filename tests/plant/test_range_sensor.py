"""The AGVs' range sensor against the edges of the scene's boxes, met by segments in the plane."""

import math

from cmrc import _core

MS = 10**9
QUANTUM, MOST = 8, 30_000  # mm


def edges(x: float, y: float, heading: float, half_x: float, half_y: float) -> list[tuple[float, float, float, float]]:
    c, s = math.cos(heading), math.sin(heading)
    corners = [
        (x + c * u - s * v, y + s * u + c * v)
        for u, v in ((half_x, half_y), (-half_x, half_y), (-half_x, -half_y), (half_x, -half_y))
    ]
    return [(*corners[i], *corners[(i + 1) % 4]) for i in range(4)]


def met(px: float, py: float, direction: float, walls: list[tuple[float, float, float, float]]) -> float:
    """The least positive t with p + t d on a wall, by Cramer's rule."""
    dx, dy = math.cos(direction), math.sin(direction)
    best = math.inf
    for ax, ay, bx, by in walls:
        ex, ey = bx - ax, by - ay
        det = ex * dy - ey * dx
        if abs(det) < 1e-12:
            continue
        t = (ex * (ay - py) - ey * (ax - px)) / det
        u = (dx * (ay - py) - dy * (ax - px)) / det
        if t >= 0 and 0 <= u <= 1:
            best = min(best, t)
    return best


def test_rays_meet_the_other_agvs_the_ship_and_the_cranes_legs() -> None:
    config = _core.plant.default_dock(3)
    dock = _core.plant.Dock(config)
    dock.advance_to(10 * MS)
    agvs = [dock.agv(i) for i in range(3)]
    ship = edges(0, 28, 0, 40, 8)  # and the deck-house, which is within it
    ship += [edge for x in (5, -5) for y in (5, -5) for edge in edges(x, y, 0, 0.5, 0.5)]  # the crane's legs
    seen = set()
    for i, agv in enumerate(agvs):
        walls = ship + [
            e for j, other in enumerate(agvs) if j != i for e in edges(other.x, other.y, other.heading, 7.4, 1.5)
        ]
        x, y = agv.x + 7.4 * math.cos(agv.heading), agv.y + 7.4 * math.sin(agv.heading)
        for ray in range(180):
            want = 1e3 * met(x, y, agv.heading + math.radians(ray - 89.5), walls)
            got = dock.agv_range(i, ray, 10 * MS)
            if want >= MOST + 10:
                assert got == MOST
            elif want < MOST - 10:
                # floored to 8 mm; the spacing is rounded to a microradian, 0.1 mm of a slanting wall at 30 m
                assert -QUANTUM - 5 <= got - want <= 5
                seen.add((i, got < 4000))
    assert (1, True) in seen and (0, False) in seen  # the queue ahead, the ship beside
    assert dock.range_mount == 7400
