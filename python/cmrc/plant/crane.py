"""A single crane, driven by motor torques."""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cmrc import _core
from cmrc.arguments import flag, instance, mapping, number
from cmrc.one_state import OneState
from cmrc.plant.arguments import assign, numbers
from cmrc.plant.parts import CraneSnapshot

Array = NDArray[np.float64]

COORDINATES = ("s", "psi", "phi", "l", "alpha", "beta", "kappa")
"""Gantry m, slew, luff rad, rope m, radial and tangential sway, rotator rad."""
JOINTS = ("gantry", "slew", "luff", "hoist", "rotator")
"""The joints with a motor, in the order of torques."""
ACTUATED = (0, 1, 2, 3, 6)
"""The joints' indices in the coordinates."""
INTEGRATORS = ("erk", "adams", "bdf")
"""ARKODE's explicit Runge-Kutta, CVODES' Adams and BDF."""

_OPTIONS: dict[str, Any] = {
    "home": (0.0, 12.0, 16.0, 14.0, 0.0),
    "load_mass": 0.0,
    "load_inertia": 0.0,
    "rated_load": 40e3,
    "model": "sway",
    "tolerance": 1e-6,
    "integrator": "erk",
    "order": 4,
    "bookkeeping": False,
    "seed": 1,
    "sway_noise": None,
    "drives": {},
    "wind": {},
}


@dataclass(frozen=True)
class CraneState:
    """The moving state: coordinates and speeds in the order of COORDINATES, motor torques in the order of JOINTS."""

    time_s: float
    q: Array
    qd: Array
    torque: Array


@dataclass(frozen=True)
class Sensors:
    """The controller's sensors: 24-bit encoder counts (16384 per motor turn) and sway codes (2048 is 10 degrees), with
    the sensor's noise, without latency."""

    encoders: tuple[int, ...]
    sway: tuple[int, ...]


@dataclass(frozen=True)
class Event:
    """An event, found as a root by the integrator: ``limit``, ``stuck``, ``slipped`` (a joint's name), ``slack``,
    ``swung_out`` (None)."""

    time_s: float
    kind: str
    joint: str | None


@dataclass(frozen=True)
class Work:
    """Energy since the start, J: from the motors and the wind; lost in gears (negative if the load drives), joints,
    sway, impacts."""

    motors: float
    gears: float
    friction: float
    damping: float
    external: float
    impacts: float


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives of coordinates and speeds, per kg of payload and per m of rope at the start."""

    q_by_mass: Array
    qd_by_mass: Array
    q_by_length: Array
    qd_by_length: Array


@dataclass(frozen=True)
class Linearization:
    """dx/dt = A x + B u, y = C x + D u (``Crane.linearize``): x coordinates, speeds and motor torques, u commanded
    torques, y the values of encoders and sway sensors."""

    A: Array
    B: Array
    C: Array
    D: Array
    states: tuple[str, ...]
    state_units: tuple[str, ...]
    inputs: tuple[str, ...]
    input_units: tuple[str, ...]
    outputs: tuple[str, ...]
    output_units: tuple[str, ...]


class Crane(OneState):
    """The slewing, luffing crane with its drives, at level L1 (``model="sway"``) or L0 (``"rigid"``).

    ``machine="gantry"`` is the ship-to-shore gantry: psi stays at pi/2, phi is its trolley's place in m, the second
    torque has no effect. ``config`` has parameters with the names of docs/plant.md (``jib``, ``spreader_mass``, ...),
    and also: ``home`` (s, x, y, z, yaw of the spreader), ``load_mass`` and ``load_inertia`` of the load below the
    spreader, ``rated_load``, ``model``, ``tolerance``, ``integrator`` ("erk", "adams", "bdf"), ``order`` of "erk" (3 to
    5), ``bookkeeping`` (computes ``work``), ``seed``, ``sway_noise`` in rad, ``wind`` ({mean, gust, direction,
    side_area, end_area, spreader_area, seed}: m/s, rad, m2), ``drives`` ({joint: {parameter: value}}). Raises
    ValueError for an unknown name or an impossible crane.
    """

    _second = "restore() gives the state in snapshot() to another one"

    def __init__(self, config: Mapping[str, object] | None = None, **keywords: object) -> None:
        given: dict[str, Any] = {**mapping("config", config, "a dictionary of parameters"), **keywords}
        options = {name: given.pop(name, default) for name, default in _OPTIONS.items()}
        machine = given.pop("machine", "slewing")
        if not isinstance(machine, str) or machine not in ("slewing", "gantry"):
            raise ValueError(f'machine must be "slewing" or "gantry", not {machine!r}')
        parameters = _core.plant.gantry_crane() if machine == "gantry" else _core.plant.CraneParameters()
        assign(parameters, "a crane", given, *_OPTIONS)
        drives = parameters.drives
        if not isinstance(options["drives"], Mapping):
            raise TypeError(f"drives must be {{joint: {{parameter: value}}}}, not {options['drives']!r}")
        for joint, values in options["drives"].items():
            if joint not in JOINTS:
                raise ValueError(f"there is no joint {joint!r}; the joints are {', '.join(JOINTS)}")
            assign(drives[JOINTS.index(joint)], "a drive", values)
        parameters.drives = drives
        if options["model"] not in ("sway", "rigid"):
            raise ValueError(f'model must be "sway" (L1) or "rigid" (L0), not {options["model"]!r}')
        if not isinstance(options["integrator"], str) or options["integrator"] not in INTEGRATORS:
            raise ValueError(f"integrator must be one of {', '.join(INTEGRATORS)}, not {options['integrator']!r}")
        sensors = _core.plant.SensorParameters()
        assign(sensors, "the sensors", {"seed": options["seed"]})
        if options["sway_noise"] is not None:
            assign(sensors, "the sensors", {"sway_noise": options["sway_noise"]})
        wind = _core.plant.WindParameters()
        wind.seed = sensors.seed
        assign(wind, "the wind", options["wind"])
        load_mass, load_inertia, rated_load, tolerance = numbers(
            "load_mass, load_inertia, rated_load and tolerance",
            [options[name] for name in ("load_mass", "load_inertia", "rated_load", "tolerance")],
            4,
        )
        try:
            order = operator.index(options["order"])
        except TypeError:
            raise TypeError(f"order must be 3, 4 or 5, not {options['order']!r}") from None
        self.parameters = parameters
        """The crane's parameters, as checked at the start."""
        self._core = _core.plant.CraneAlone(
            parameters, _core.plant.CranePose(*numbers("home (s, x, y, z, yaw)", options["home"], 5)), load_mass, load_inertia, rated_load,
            options["model"] == "rigid", tolerance,
            getattr(_core.plant.Method, options["integrator"]), order, flag("bookkeeping", options["bookkeeping"]), sensors, wind,
        )  # fmt: skip
        self.maximum_torques: Array = np.array([drive.maximum_torque for drive in drives])
        """Motor torques at which the drives saturate, N m."""
        self.step = self._core.step
        """``step(torques, dt)``: advances by ``dt`` seconds, 0 to 60, with the five motor torques (N m) held.

        Torques saturate; a torque that is not finite faults its drive: its brake closes until ``reset``. Raises
        ValueError for another ``dt``.
        """
        self.run = self._core.run
        """``run(torques, dt, steps)``: this number of equal steps, without holding the GIL. Ctrl-C ends it between two
        steps. Another thread's call on this crane is a RuntimeError meanwhile."""

    @property
    def state(self) -> CraneState:
        """The present state (a copy)."""
        c = self._core
        return CraneState(c.time / 1e12, np.array(c.q), np.array(c.qd), np.array(c.torque))

    def reset(
        self,
        q: Sequence[float] | Array,
        qd: Sequence[float] | Array = (0.0,) * 7,
        torques: Sequence[float] | Array = (0.0,) * 5,
    ) -> None:
        """Time zero, at these coordinates, speeds and motor torques (N m), faults cleared. Raises ValueError beyond the
        joints' limits or a drive's largest torque."""
        self._core.reset(numbers("q", q, 7), numbers("qd", qd, 7), numbers("torques", torques, 5))

    def set_load(self, mass: float, inertia: float = 0.0) -> None:
        """Hangs another load below the spreader (kg, kg m2). Raises ValueError above ``rated_load``."""
        self._core.set_load(number("mass", mass, "a mass in kg"), number("inertia", inertia, "an inertia in kg m2"))

    def snapshot(self) -> CraneSnapshot:
        """The whole state; after ``restore`` the crane continues bit for bit."""
        return self._core.snapshot()

    def restore(self, snapshot: CraneSnapshot) -> None:
        """Goes back to a snapshot of a crane with the same config; ``home`` and the load are state, and may differ.
        Raises ValueError for a snapshot of another crane."""
        self._core.restore(instance("snapshot", snapshot, CraneSnapshot, "what Crane.snapshot() gives"))

    def mass_matrix(self) -> Array:
        """M(q), rotors included: kg, kg m or kg m2."""
        return np.asarray(self._core.model.mass_matrix(self._core.q, *self._core.payload))

    def bias(self) -> Array:
        """h(q, qd) + g(q): centrifugal, Coriolis and gravity forces, N or N m."""
        model, q = self._core.model, self._core.q
        mass, inertia = self._core.payload
        return np.add(model.bias(q, self._core.qd, mass, inertia), model.gravity(q, mass))

    def acceleration(self) -> Array:
        """qdd under the present torques, friction and damping."""
        return np.asarray(self._core.acceleration())

    def energy(self) -> float:
        """Kinetic and potential energy, rotors included, J; zero of height at z = 0."""
        return self._core.energy()

    def sensors(self) -> Sensors:
        """Encoders and sway as codes."""
        return Sensors(tuple(self._core.encoders()), tuple(self._core.sway()))

    def tip(self) -> Array:
        """The jib's tip in the world, m."""
        return np.array(self._core.model.tip(self._core.q))

    def payload(self) -> Array:
        """The load in the world, m."""
        return np.array(self._core.model.payload_position(self._core.q))

    def sensitivity(self, torques: Sequence[float], seconds: float) -> Sensitivity:
        """How the state after ``seconds`` with these torques depends on the payload's mass and the rope's length
        (CVODES, Adams). The crane's state does not change.

        Raises ``ValueError`` in wind, with a drive that is off, and when a joint reaches its end stop, sticks or breaks
        away (``stiction=True``) within this time: the derivatives do not contain that."""
        time = number("seconds", seconds, "a time in s")
        return Sensitivity(*(np.array(part) for part in self._core.sensitivity(torques, time)))

    def linearize(self, state: CraneSnapshot | None = None) -> Linearization:
        """The crane linearised around a snapshot (by default the present state), which need not be at rest: the
        deviations from its motion obey dx/dt = A x + B u, y = C x + D u.

        Dry friction is smoothed; coordinates that brakes or friction hold have rows and columns of zeros. Differences
        of fourth order: 1e-6 or better of A's entries. Raises ``ValueError`` in wind, and for a snapshot that
        ``restore`` refuses.
        """
        snapshot = (
            self.snapshot() if state is None else instance("state", state, CraneSnapshot, "a snapshot of a crane")
        )
        lags = np.array([drive.torque_lag for drive in self.parameters.drives])
        a = np.zeros((19, 19))
        a[:14] = self._core.linearize(snapshot)
        a[14:, 14:] = -np.diag(1.0 / lags)
        b = np.zeros((19, 5))
        b[14:] = np.diag(1.0 / lags)
        c = np.zeros((7, 19))
        outputs = (*ACTUATED, 4, 5)
        c[range(7), outputs] = 1.0
        metre = (0, 2, 3) if self.parameters.machine == _core.plant.Machine.gantry else (0, 3)
        units = ["m" if k in metre else "rad" for k in range(7)]
        return Linearization(
            a, b, c, np.zeros((7, 5)),
            (*COORDINATES, *(f"d{name}" for name in COORDINATES), *(f"torque_{joint}" for joint in JOINTS)),
            (*units, *(f"{unit}/s" for unit in units), *("N m",) * 5),
            tuple(f"command_{joint}" for joint in JOINTS), ("N m",) * 5,
            tuple(COORDINATES[k] for k in outputs), tuple(units[k] for k in outputs),
        )  # fmt: skip

    @property
    def faulted(self) -> tuple[str, ...]:
        """Joints whose drive got a torque that is not a number; all joints once the load swung beyond 40 degrees."""
        mask = 0b11111 if self._core.swung_out else self._core.faulted
        return tuple(joint for j, joint in enumerate(JOINTS) if mask >> j & 1)

    @property
    def events(self) -> list[Event]:
        """Events since the start or the last ``reset`` or ``restore``."""
        return [
            Event(time / 1e12, kind, JOINTS[joint] if kind in ("limit", "stuck", "slipped") else None)
            for time, kind, joint in self._core.events
        ]

    @property
    def work(self) -> Work:
        """Energy since the start or the last ``reset``; zeros unless ``bookkeeping`` is on."""
        w = self._core.work
        return Work(w.motors, w.gears, w.friction, w.damping, w.external, w.impacts)

    @property
    def stuck(self) -> tuple[str, ...]:
        """Joints that dry friction holds (with ``stiction``)."""
        return tuple(joint for j, joint in enumerate(JOINTS) if self._core.stuck >> j & 1)

    @property
    def at_limit(self) -> tuple[str, ...]:
        """Joints in their end stops."""
        return tuple(joint for j, joint in enumerate(JOINTS) if self._core.at_limit >> j & 1)
