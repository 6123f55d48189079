"""Scenes of the plant, each to its bits: ``python tests/plant/bits.py SCENE`` prints a hash (test_same_bits.py)."""

import hashlib
import math
import random
import struct
import sys

from cmrc import plant as public
from cmrc._core import plant
from controller import Crane
from test_handover import land

SECOND = 10**12


def crane(integrator: str) -> str:
    """A crane by itself, with torques that change every 50 ms."""
    alone, draw = public.Crane(integrator=integrator, tolerance=1e-10), random.Random(1)
    middle, swing = (0, 0, 900, -1000, 0), (400, 600, 300, 200, 20)
    bits = hashlib.sha256()
    for _ in range(80):
        alone.run([m + draw.uniform(-s, s) for m, s in zip(middle, swing, strict=True)], 0.05, 1)
        bits.update(struct.pack("<14d", *alone.state.q, *alone.state.qd))
    return bits.hexdigest()


def landing() -> str:
    """A crooked container slides into the guides: ODE's boxes, and its joints for the crane."""
    dock, _ = land(yaw=0.02, dy=0.1, guides=True)
    return str(dock.state_hash())


def leg() -> str:
    """The spreader is slewed against the crane's own leg: ODE's boxes on edges."""
    config = plant.default_dock(0)
    config.home = plant.CranePose(0.0, 9.0, 9.0, 2.6, math.pi / 2)
    dock = plant.Dock(config)
    driver = Crane(dock)
    driver.hold(0.2)
    driver.move(driver.pose(6.0, 9.0, 2.6, math.pi / 2), 8.0)
    return str(dock.state_hash())


def bumps() -> str:
    """A vehicle runs into posts, one by one: ODE's box against its cylinder."""
    bits = []
    for k in range(0, 6, 2):
        config = plant.default_dock(1)
        config.layout.movers = [plant.Mover(0.2 + 0.05 * k, 2.0, [plant.Waypoint(0, 33.0, 8.8 + 0.03 * k)])]
        dock = plant.Dock(config)
        dock.agv_period(0, 50000, 0)
        while not (hits := [event for event in dock.events if event.kind == "collision"]):
            dock.agv_push(0, 1500, 0, 0, dock.time)
            dock.advance_to(dock.time + SECOND // 20)
        bits += [repr(hits[0].values), str(dock.state_hash())]
    return " ".join(bits)


SCENES = {
    "erk": lambda: crane("erk"), "adams": lambda: crane("adams"), "bdf": lambda: crane("bdf"),
    "landing": landing, "leg": leg, "bumps": bumps,
}  # fmt: skip

if __name__ == "__main__":
    print(SCENES[sys.argv[1]]())
