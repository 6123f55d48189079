"""An AGV by itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cmrc import _core
from cmrc.plant.arguments import assign, numbers
from cmrc.plant.parts import AgvDrive, AgvParameters, AgvSnapshot, Pose


@dataclass(frozen=True)
class AgvStatus:
    """An AGV at an instant: pose (m, rad), speeds along and across itself (m/s), yaw rate (rad/s), steering angles (rad), drive force (N)."""

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


class Agv:
    """An AGV by itself: single track with both axles steered, or ``drive="differential"`` (plant-and-bus.md 1.5), with its drive's speed loop.

    ``config`` holds parameters under the names of ``AgvParameters`` (``mass``, ``adhesion``, ...), and besides ``start`` (x, y in m, heading in rad), ``load_mass`` kg,
    ``load_inertia`` kg m2, ``tolerance``. Raises ValueError for an unknown name or a vehicle that cannot be. With differential drive front and rear
    of the state are the speeds of the left and the right wheel, m/s.
    """

    def __init__(self, config: Mapping[str, object] | None = None, **keywords: object) -> None:
        given: dict[str, Any] = {**(config or {}), **keywords}
        start = Pose(*numbers("start (x, y, heading)", given.pop("start", (0.0, 0.0, 0.0)), 3))
        loads = [given.pop("load_mass", 0.0), given.pop("load_inertia", 0.0), given.pop("tolerance", 1e-8)]
        load_mass, load_inertia, tolerance = numbers("load_mass, load_inertia and tolerance", loads, 3)
        parameters = AgvParameters()
        drive = given.pop("drive", "steered")
        if drive not in ("steered", "differential"):
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
            self._core.time * 1e-12, x, y, heading, speed, side, yaw_rate, front, rear, force, self._core.standing
        )

    def step(self, speed: float, front: float, rear: float, dt: float, turn: float = 0.0) -> None:
        """Goes on by ``dt`` seconds, 0 to 60, with this set-point held: m/s, steering angles in rad; ``turn`` in rad/s for differential drive.

        The drive's ramp and loop (100 Hz), the steering's rate and lag stand between. Raises ValueError for another ``dt`` and for what is no finite number.
        """
        self._core.step(speed, front, rear, turn, dt)

    def set_load(self, mass: float, inertia: float = 0.0) -> None:
        """What it carries, kg and kg m2. What is added was at rest: the momentum is kept, unless brakes hold the vehicle; what is taken off has its speed, which is kept.

        Raises ValueError below zero.
        """
        self._core.set_load(mass, inertia)

    def reset(self, x: float, y: float, heading: float) -> None:
        """At rest there, at time zero; what it carries stays."""
        self._core.reset(Pose(x, y, heading))

    def snapshot(self) -> AgvSnapshot:
        """The whole state; ``restore`` it and go on, bit for bit."""
        return self._core.snapshot()

    def restore(self, snapshot: AgvSnapshot) -> None:
        """Back to a snapshot of an AGV of the same config."""
        self._core.restore(snapshot)

    def energy(self) -> float:
        """Kinetic energy, J."""
        return self._core.energy()
