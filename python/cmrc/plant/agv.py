"""A single AGV."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cmrc import _core
from cmrc.arguments import instance, mapping, number
from cmrc.one_state import OneState
from cmrc.plant.arguments import assign, numbers
from cmrc.plant.parts import AgvDrive, AgvParameters, AgvSnapshot, Pose


@dataclass(frozen=True)
class AgvStatus:
    """An AGV at an instant: pose (m, rad), speeds along and across itself (m/s), yaw rate (rad/s), steering angles
    (rad), drive force (N)."""

    time_s: float
    x: float
    y: float
    heading: float
    speed: float
    side: float
    yaw_rate: float
    front: float
    rear: float
    force: float
    standing: bool


class Agv(OneState):
    """A single AGV: single track with both axles steered, or ``drive="differential"`` (plant-and-bus.md 1.5), with its
    drive's speed loop.

    ``config`` has parameters with the names of ``AgvParameters`` (``mass``, ``adhesion``, ...), and also ``start`` (x,
    y in m, heading in rad), ``load_mass`` kg, ``load_inertia`` kg m2, ``tolerance``. Raises ValueError for an unknown
    name or an impossible vehicle. With differential drive the state's front and rear are the speeds of the left and the
    right wheel, m/s.
    """

    _second = "restore() gives the state in snapshot() to another one"

    def __init__(self, config: Mapping[str, object] | None = None, **keywords: object) -> None:
        given: dict[str, Any] = {**mapping("config", config, "a dictionary of parameters"), **keywords}
        start = Pose(*numbers("start (x, y, heading)", given.pop("start", (0.0, 0.0, 0.0)), 3))
        loads = [given.pop("load_mass", 0.0), given.pop("load_inertia", 0.0), given.pop("tolerance", 1e-8)]
        load_mass, load_inertia, tolerance = numbers("load_mass, load_inertia and tolerance", loads, 3)
        parameters = AgvParameters()
        drive = given.pop("drive", "steered")
        if not isinstance(drive, str) or drive not in ("steered", "differential"):
            raise ValueError(f'drive must be "steered" or "differential", not {drive!r}')
        parameters.drive = getattr(AgvDrive, drive)
        assign(parameters, "an AGV", given, "start", "load_mass", "load_inertia", "tolerance")
        self.parameters = parameters
        """The vehicle's parameters, as checked at the start."""
        self._core = _core.plant.AgvAlone(parameters, start, tolerance)
        self.set_load(load_mass, load_inertia)

    @property
    def state(self) -> AgvStatus:
        """The present state (a copy)."""
        x, y, heading, speed, side, yaw_rate, front, rear, force = self._core.y
        return AgvStatus(
            self._core.time / 1e12, x, y, heading, speed, side, yaw_rate, front, rear, force, self._core.standing
        )

    def step(self, speed: float, front: float, rear: float, dt: float, turn: float = 0.0) -> None:
        """Advances by ``dt`` seconds, 0 to 60, with this set-point: m/s, steering angles in rad; ``turn`` in rad/s for
        differential drive.

        The drive's ramp and loop (100 Hz), and the steering's rate and lag, act on the set-point. Raises ValueError for
        another ``dt`` and for a value that is not finite.
        """
        self._core.step(speed, front, rear, turn, dt)

    def set_load(self, mass: float, inertia: float = 0.0) -> None:
        """Sets the load, kg and kg m2. An added load was at rest: momentum is conserved, unless brakes hold the
        vehicle. A removed load has the vehicle's speed, which does not change.

        Raises ValueError below zero.
        """
        self._core.set_load(number("mass", mass, "a mass in kg"), number("inertia", inertia, "an inertia in kg m2"))

    def reset(self, x: float, y: float, heading: float) -> None:
        """At rest at this pose, at time zero; the load stays."""
        self._core.reset(Pose(x, y, heading))

    def snapshot(self) -> AgvSnapshot:
        """The whole state; after ``restore`` the vehicle continues bit for bit."""
        return self._core.snapshot()

    def restore(self, snapshot: AgvSnapshot) -> None:
        """Goes back to a snapshot of an AGV with the same config; ``start`` and the load are state, and may differ.
        Raises ValueError for a snapshot of another vehicle."""
        self._core.restore(instance("snapshot", snapshot, AgvSnapshot, "what Agv.snapshot() gives"))

    def energy(self) -> float:
        """Kinetic energy, J."""
        return self._core.energy()
