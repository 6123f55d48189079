"""The whole dock, driven like a controller drives it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cmrc import _core
from cmrc.arguments import flag, instance, number, shown, whole
from cmrc.one_state import OneState
from cmrc.plant.arguments import device_code, numbers
from cmrc.plant.crane import JOINTS, Array
from cmrc.plant.parts import (
    AgvSignal,
    ContainerStatus,
    DockConfig,
    DockEvent,
    DockState,
    Handover,
    Signal,
    Switch,
    default_dock,
)


class Scene(OneState):
    """The whole dock: crane, 0 to 16 AGVs, containers, landing. A controller's devices are its inputs; ``step``
    advances time.

    ``config`` is a ``DockConfig`` (``cmrc.plant.default_dock``), by default that of docs/plant.md with ``agvs``
    vehicles.
    """

    _second = "restore() gives the state in snapshot() to another one"

    def __init__(self, config: DockConfig | None = None, agvs: int = 1) -> None:
        if config is None:
            config = default_dock(whole("agvs", agvs, "a number of AGVs, 0 to 16,", 0, 16))
        self._dock = _core.plant.Dock(
            instance("config", config, DockConfig, "a DockConfig, as default_dock() gives it,")
        )
        self._time = 0

    @property
    def time_s(self) -> float:
        """Virtual time."""
        return self._time / 1e12

    def step(self, torques: Sequence[float] | None, dt: float) -> None:
        """Advances by ``dt`` seconds, 0 to 60. ``torques`` (motor, N m) become the drives' 12-bit codes; None leaves
        the drives off, with brakes holding.

        A torque that is not finite faults its drive: the brake holds from then on.
        """
        if not 0.0 <= number("dt", dt, "a step of 0 to 60 s") <= 60.0:
            raise ValueError(f"a step must be 0 to 60 s (got {dt})")
        if torques is not None:
            torques = numbers(f"torques ({', '.join(JOINTS)})", torques, 5)
            self._dock.enable_drives(0b11111, self._time)
            for j, (torque, drive) in enumerate(zip(torques, self._dock.config.crane.drives, strict=True)):
                if not np.isfinite(torque):
                    self._dock.fail_drive(j, True, self._time)
                else:
                    share = np.clip(torque / drive.maximum_torque, -1.0, 1.0)
                    self._dock.set_torque_code(j, round(float(share) * 2047), self._time)
        else:
            self._dock.enable_drives(0, self._time)
        self._time += round(dt * 1e12)
        try:
            self._dock.advance_to(self._time)
        finally:
            self._time = self._dock.time  # less after Ctrl-C

    def drive(self, agv: int, speed: float, front: float, rear: float) -> None:
        """Writes a set-point into that AGV's FIFO: m/s, steering angles in rad. ``hold`` sets how long each is held."""
        most = 2**31 - 1
        angles = [
            device_code(f"{name} (rad)", angle, 1e6, -most, most) for name, angle in (("front", front), ("rear", rear))
        ]
        self._dock.agv_push(agv, device_code("speed (m/s)", speed, 1e3, -most, most), angles[0], angles[1], self._time)

    def hold(self, agv: int, seconds: float) -> None:
        """Sets how long each set-point of that AGV is held, at least 1 ms."""
        self._dock.agv_period(agv, device_code("seconds", seconds, 1e6, 0, 2**32 - 1), self._time)

    def lock(self, closed: bool) -> None:
        """Commands the twist locks; they turn while all four corners are seated."""
        self._dock.spreader_command(int(flag("closed", closed)), self._time)

    def agv(self, index: int) -> AgvSignal:
        """True pose, speed and steering of an AGV at the last latch."""
        return self._dock.agv(self._agv(index))

    def ranges(self, index: int) -> Array:
        """The range sensor's 180 rays in m, from right to left."""
        return np.array(self._dock.agv_scan(self._agv(index), self._time)) * 1e-3

    def _agv(self, index: object) -> int:
        count = self._dock.config.agv_count
        if count == 0:
            raise ValueError(f"index: {shown(index)} is out of range; a scene with AGVs is expected, this one has none")
        return whole("index", index, f"the number of an AGV, 0 to {count - 1},", 0, count - 1)

    @property
    def signal(self) -> Signal:
        """The crane at the last latch: joints, sway, tip, payload, tension."""
        return self._dock.signal

    @property
    def containers(self) -> list[ContainerStatus]:
        """Every container: its place and its carrier."""
        return self._dock.containers

    @property
    def handover(self) -> Handover:
        """The phase of a container's hand-over."""
        return self._dock.handover

    @property
    def switches(self) -> list[Switch]:
        """Energy and momentum of every change between levels, attach and detach so far."""
        return self._dock.switches

    @property
    def events(self) -> list[DockEvent]:
        """The events so far, in the order of time."""
        return self._dock.events

    def energy(self) -> float:
        """Crane and payload, J."""
        return self._dock.energy

    def snapshot(self) -> DockState:
        """The whole state at the last latch."""
        return self._dock.snapshot()

    def restore(self, snapshot: DockState) -> None:
        """Goes back to a snapshot of a scene with the same config. A snapshot between two points of the 125-us grid
        goes back to the latch before it."""
        self._dock.restore(instance("snapshot", snapshot, DockState, "what Scene.snapshot() gives"))
        self._time = int(self._dock.time)
