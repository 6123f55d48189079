"""The dock without any DSP: a crane by itself, and the whole scene (docs/plant.md). SI units, angles in radians.

``Crane`` is driven by motor torques, ``Agv`` by speed and steering, ``Scene`` by what a controller writes to its devices; ``CraneEnv`` is a crane in the manner of
gymnasium. What a dock is made of (layouts, movers, ship, wind, sensors, landing) are the classes at the end.
"""

from __future__ import annotations

import copyreg
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from cmrc import _core

try:
    import gymnasium
except ImportError:
    gymnasium = None

Array = NDArray[np.float64]

COORDINATES = ("s", "psi", "phi", "l", "alpha", "beta", "kappa")
"""Gantry m, slew, luff rad, rope m, radial and tangential sway, rotator rad."""
JOINTS = ("gantry", "slew", "luff", "hoist", "rotator")
"""What has a motor, in the order of torques."""
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
    """What moves: coordinates and speeds in the order of COORDINATES, motor torques in that of JOINTS."""

    time_s: float
    q: Array
    qd: Array
    torque: Array


@dataclass(frozen=True)
class Sensors:
    """What a controller sees: 24-bit encoder counts (16384 per motor turn) and sway codes (2048 is 10 degrees), with the sensor's noise, without latency."""

    encoders: tuple[int, ...]
    sway: tuple[int, ...]


@dataclass(frozen=True)
class Event:
    """What happened, found as a root by the integrator: ``limit``, ``stuck``, ``slipped`` (a joint's name), ``slack``, ``swung_out`` (None)."""

    time_s: float
    kind: str
    joint: str | None


@dataclass(frozen=True)
class Work:
    """Where energy went since the start, J: put in by the motors and by the wind; lost in gears (negative where the load drives), joints, sway, impacts."""

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
    """dx/dt = A x + B u, y = C x + D u (``Crane.linearize``): x coordinates, speeds and motor torques, u commanded torques, y what encoders and sway sensors see."""

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


def _assign(target: object, what: str, values: object, *others: str) -> None:
    """Sets attributes by name; ``others`` are names taken elsewhere."""
    if not isinstance(values, Mapping):
        raise TypeError(f"the parameters of {what} must be given by name, not {values!r}")
    known = sorted({name for name in dir(target) if not name.startswith("_")}.union(others))
    for name, value in values.items():
        if name not in known:
            raise ValueError(f"{what} has no parameter {name!r}; it has {', '.join(known)}")
        try:
            setattr(target, name, value)
        except (TypeError, AttributeError):
            raise ValueError(f"the {name} of {what} cannot be {value!r}") from None


def _numbers(what: str, values: object, count: int) -> list[float]:
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (count,):
        raise ValueError(f"{what} must be {count} numbers, not {values!r}")
    return [float(value) for value in array]


def _whole(what: str, value: float, scale: float, least: int, most: int) -> int:
    """A device's integer, of a value in SI units."""
    if not least <= value * scale <= most:
        raise ValueError(f"{what} must be {least / scale:g} to {most / scale:g} (got {value})")
    return round(value * scale)


class _PlainBox:
    """What is needed of gymnasium's Box where that package is missing."""

    def __init__(self, low: float | Array, high: float | Array, shape: tuple[int, ...], dtype: DTypeLike) -> None:
        self.shape = shape
        self.dtype = np.dtype(dtype)
        self.low: Array = np.full(shape, low, dtype)
        self.high: Array = np.full(shape, high, dtype)
        self._random = np.random.default_rng(0)

    def seed(self, seed: int | None = None) -> None:
        self._random = np.random.default_rng(seed)

    def contains(self, x: Array) -> bool:
        return x.shape == self.shape and bool(np.all(x >= self.low) and np.all(x <= self.high))

    def sample(self) -> Array:
        """Uniform where bounded, normal where not."""
        bounded = np.isfinite(self.low) & np.isfinite(self.high)
        uniform = self._random.uniform(np.where(bounded, self.low, 0.0), np.where(bounded, self.high, 1.0))
        return np.where(bounded, uniform, self._random.normal(size=self.shape))


_Environment: Any = object if gymnasium is None else gymnasium.Env
_Box: Any = _PlainBox if gymnasium is None else gymnasium.spaces.Box


class Crane:
    """The slewing, luffing crane with its drives, at level L1 (``model="sway"``) or L0 (``"rigid"``).

    ``machine="gantry"`` is the ship-to-shore gantry: psi stays at pi/2, phi is its trolley's place in m, the second torque does nothing.
    ``config`` holds parameters under the names of docs/plant.md (``jib``, ``spreader_mass``, ...), and besides: ``home`` (s, x, y, z, yaw of the spreader),
    ``load_mass`` and ``load_inertia`` of what hangs below the spreader, ``rated_load``, ``model``, ``tolerance``, ``integrator`` ("erk", "adams", "bdf"), ``order`` of "erk" (3 to 5),
    ``bookkeeping`` (keeps ``work``), ``seed``,
    ``sway_noise`` in rad, ``wind`` ({mean, gust, direction, side_area, end_area, spreader_area, seed}: m/s, rad, m2), ``drives`` ({joint: {parameter: value}}). Raises ValueError for an unknown name or a crane that cannot be.
    """

    def __init__(self, config: Mapping[str, object] | None = None, **keywords: object) -> None:
        given: dict[str, Any] = {**(config or {}), **keywords}
        options = {name: given.pop(name, default) for name, default in _OPTIONS.items()}
        machine = given.pop("machine", "slewing")
        if machine not in ("slewing", "gantry"):
            raise ValueError(f'machine must be "slewing" or "gantry", not {machine!r}')
        parameters = _core.plant.gantry_crane() if machine == "gantry" else _core.plant.CraneParameters()
        _assign(parameters, "a crane", given, *_OPTIONS)
        drives = parameters.drives
        if not isinstance(options["drives"], Mapping):
            raise TypeError(f"drives must be {{joint: {{parameter: value}}}}, not {options['drives']!r}")
        for joint, values in options["drives"].items():
            if joint not in JOINTS:
                raise ValueError(f"there is no joint {joint!r}; the joints are {', '.join(JOINTS)}")
            _assign(drives[JOINTS.index(joint)], "a drive", values)
        parameters.drives = drives
        if options["model"] not in ("sway", "rigid"):
            raise ValueError(f'model must be "sway" (L1) or "rigid" (L0), not {options["model"]!r}')
        if options["integrator"] not in INTEGRATORS:
            raise ValueError(f'integrator must be one of {", ".join(INTEGRATORS)}, not {options["integrator"]!r}')
        sensors = _core.plant.SensorParameters()
        _assign(sensors, "the sensors", {"seed": options["seed"]})
        if options["sway_noise"] is not None:
            _assign(sensors, "the sensors", {"sway_noise": options["sway_noise"]})
        wind = _core.plant.WindParameters()
        wind.seed = sensors.seed
        _assign(wind, "the wind", options["wind"])
        load_mass, load_inertia, rated_load, tolerance = _numbers(
            "load_mass, load_inertia, rated_load and tolerance", [options[name] for name in ("load_mass", "load_inertia", "rated_load", "tolerance")], 4
        )
        if not isinstance(options["order"], int):
            raise TypeError(f"order must be 3, 4 or 5, not {options['order']!r}")
        self.parameters = parameters
        """The crane's parameters, as checked at the start."""
        self._core = _core.plant.CraneAlone(
            parameters, _core.plant.CranePose(*_numbers("home (s, x, y, z, yaw)", options["home"], 5)), load_mass, load_inertia, rated_load,
            options["model"] == "rigid", tolerance,
            getattr(_core.plant.Method, options["integrator"]), options["order"], bool(options["bookkeeping"]), sensors, wind,
        )  # fmt: skip
        self.maximum_torques: Array = np.array([drive.maximum_torque for drive in drives])
        """Motor torques at which the drives saturate, N m."""
        self.step = self._core.step
        """``step(torques, dt)``: goes on by ``dt`` seconds, 0 to 60, with the five motor torques (N m) held.

        Torques saturate; one that is no finite number faults its drive: its brake closes until ``reset``. Raises ValueError for another ``dt``.
        """
        self.run = self._core.run
        """``run(torques, dt, steps)``: so many equal steps, without holding the GIL."""

    @property
    def state(self) -> CraneState:
        """The present state (a copy)."""
        c = self._core
        return CraneState(c.time * 1e-12, np.array(c.q), np.array(c.qd), np.array(c.torque))

    def reset(self, q: Sequence[float] | Array, qd: Sequence[float] | Array = (0.0,) * 7, torques: Sequence[float] | Array = (0.0,) * 5) -> None:
        """Time zero, at these coordinates, speeds and motor torques (N m), faults cleared. Raises ValueError beyond the joints' limits or a drive's largest torque."""
        self._core.reset(_numbers("q", q, 7), _numbers("qd", qd, 7), _numbers("torques", torques, 5))

    def set_load(self, mass: float, inertia: float = 0.0) -> None:
        """Hangs another load below the spreader (kg, kg m2). Raises ValueError above ``rated_load``."""
        self._core.set_load(mass, inertia)

    def snapshot(self) -> CraneSnapshot:
        """The whole state; ``restore`` it and go on, bit for bit."""
        return self._core.snapshot()

    def restore(self, snapshot: CraneSnapshot) -> None:
        """Back to a snapshot of a crane of the same config."""
        self._core.restore(snapshot)

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
        """How the state after ``seconds`` with these torques held depends on the payload's mass and the rope's length (CVODES, Adams). The crane stays."""
        return Sensitivity(*(np.array(part) for part in self._core.sensitivity(torques, seconds)))

    def linearize(self, state: CraneSnapshot | None = None) -> Linearization:
        """The crane about a snapshot (by default the present state), which need not be one of rest: the deviations from its motion obey dx/dt = A x + B u, y = C x + D u.

        Dry friction is taken as it is smoothed; what brakes or friction hold has rows and columns of zeros. Differences of fourth order: 1e-6 or better of A's entries.
        """
        snapshot = self.snapshot() if state is None else state
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
        """Joints whose drive was given a torque that is no number; all of them once the load swung beyond 40 degrees."""
        mask = 0b11111 if self._core.swung_out else self._core.faulted
        return tuple(joint for j, joint in enumerate(JOINTS) if mask >> j & 1)

    @property
    def events(self) -> list[Event]:
        """What happened since the start or the last ``reset`` or ``restore``."""
        return [
            Event(time * 1e-12, kind, JOINTS[joint] if kind in ("limit", "stuck", "slipped") else None)
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


class CraneEnv(_Environment):  # type: ignore[misc]
    """A crane as an environment of gymnasium (a ``gymnasium.Env`` where that package is installed; it works the same without).

    Action: five shares of the maximum torque, -1 to 1. Observation: q, qd and the load's way to ``target`` (17 numbers). Reward: minus that way in m and
    minus the sway in rad, times ``dt``. An episode terminates when the load is within 0.1 m of the target and slower than 0.05 m/s, or a drive faults; it is
    truncated after ``duration`` seconds. The same actions after ``reset`` with the same seed give the same numbers, bit for bit.
    """

    metadata: dict[str, list[str]] = {"render_modes": []}  # noqa: RUF012 (gymnasium's own form)
    render_mode: str | None = None

    def __init__(self, target: Sequence[float], dt: float = 0.01, duration: float = 60.0, **config: object) -> None:
        if not 0.0 < dt <= 60.0:
            raise ValueError(f"dt must be above 0, at most 60 s (got {dt})")
        if not duration > 0.0:
            raise ValueError(f"duration must be positive (got {duration})")
        self.crane = Crane(config)
        self.target: Array = np.array(_numbers("target (x, y, z)", target, 3))
        self.dt = dt
        self.duration = duration
        self._start = self.crane.snapshot()
        p = self.crane.parameters
        most = np.full(17, np.inf)
        least = -most
        for k, low, high in zip(ACTUATED, p.lower, p.upper, strict=True):
            least[k], most[k] = low, high
        self.action_space = _Box(-1.0, 1.0, shape=(5,), dtype=np.float64)
        """Five shares of ``crane.maximum_torques``: a Box of gymnasium, or one with low, high, shape, dtype, contains and sample."""
        self.observation_space = _Box(least, most, shape=(17,), dtype=np.float64)

    def reset(self, *, seed: int | None = None, options: Mapping[str, float] | None = None) -> tuple[Array, dict[str, float]]:
        """Back to the start, the sway angles within ``options["sway"]`` rad of plumb, drawn from ``seed``; without one the draws go on, at first those of seed 0."""
        if unknown := sorted(set(options or {}) - {"sway"}):
            raise ValueError(f'reset has the option "sway", not {unknown}')
        if seed is not None or getattr(self, "_random", None) is None:
            self._random = np.random.default_rng(seed or 0)
        if gymnasium is not None:
            super().reset(seed=seed)
        self.crane.restore(self._start)
        most = float((options or {}).get("sway", 0.0))
        if not 0.0 <= most < np.radians(40.0):
            raise ValueError(f"the sway at the start must be 0 to 40 degrees (got {most} rad)")
        if most > 0.0:
            q = self.crane.state.q
            q[4:6] = self._random.uniform(-most, most, 2)
            self.crane.reset(q)
        return self._observe(), {}

    def step(self, action: Sequence[float] | Array) -> tuple[Array, float, bool, bool, dict[str, float]]:
        """Observation, reward, terminated, truncated, info (``way_m`` to the target, ``speed_m_s``)."""
        self.crane.step(np.array(_numbers("an action", action, 5)) * self.crane.maximum_torques, self.dt)
        state = self.crane.state
        way = float(np.linalg.norm(self.crane.payload() - self.target))
        model = self.crane._core.model
        speed = float(np.linalg.norm(model.payload_velocity(state.q, state.qd)))
        there = way < 0.1 and speed < 0.05
        reward = -(way + float(np.abs(state.q[4:6]).sum())) * self.dt
        return (
            self._observe(),
            reward,
            there or bool(self.crane.faulted),
            self.crane._core.time >= self.duration * 1e12,
            {"way_m": way, "speed_m_s": speed},
        )

    def _observe(self) -> Array:
        state = self.crane.state
        observation: Array = np.concatenate([state.q, state.qd, self.target - self.crane.payload()])
        return observation


class Scene:
    """The whole dock: crane, 0 to 16 AGVs, containers, landing. A controller's devices are its inputs; time goes on by ``step``.

    ``config`` is a ``DockConfig`` (``cmrc.plant.default_dock``), by default that of docs/plant.md with ``agvs`` vehicles.
    """

    def __init__(self, config: DockConfig | None = None, agvs: int = 1) -> None:
        self._dock = _core.plant.Dock(_core.plant.default_dock(agvs) if config is None else config)
        self._time = 0

    @property
    def time_s(self) -> float:
        """Virtual time."""
        return self._time * 1e-12

    def step(self, torques: Sequence[float] | None, dt: float) -> None:
        """Goes on by ``dt`` seconds, 0 to 60. ``torques`` (motor, N m) become the drives' 12-bit codes; None leaves the drives off, brakes holding.

        A torque that is no finite number faults its drive: the brake holds from then on.
        """
        if not 0.0 <= dt <= 60.0:
            raise ValueError(f"a step must be 0 to 60 s (got {dt})")
        if torques is not None:
            torques = _numbers(f"torques ({', '.join(JOINTS)})", torques, 5)
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
        """A set-point into that AGV's FIFO: m/s, steering angles in rad. ``hold`` says how long each is held."""
        most = 2**31 - 1
        angles = [_whole(f"{name}, rad,", angle, 1e6, -most, most) for name, angle in (("front", front), ("rear", rear))]
        self._dock.agv_push(agv, _whole("speed, m/s,", speed, 1e3, -most, most), angles[0], angles[1], self._time)

    def hold(self, agv: int, seconds: float) -> None:
        """Each set-point of that AGV is held for so long, at least 1 ms."""
        self._dock.agv_period(agv, _whole("a set-point's time, s,", seconds, 1e6, 0, 2**32 - 1), self._time)

    def lock(self, closed: bool) -> None:
        """Commands the twist locks; they turn while all four corners are seated."""
        self._dock.spreader_command(int(closed), self._time)

    def agv(self, index: int) -> AgvSignal:
        """True pose, speed and steering of an AGV at the last latch."""
        return self._dock.agv(index)

    def ranges(self, index: int) -> Array:
        """The range sensor's 180 rays in m, from the right to the left."""
        return np.array(self._dock.agv_scan(index, self._time)) * 1e-3

    @property
    def signal(self) -> Signal:
        """The crane at the last latch: joints, sway, tip, payload, tension."""
        return self._dock.signal

    @property
    def containers(self) -> list[ContainerStatus]:
        """Every container: where it is and who has it."""
        return self._dock.containers

    @property
    def handover(self) -> Handover:
        """Where a container's change of hands stands."""
        return self._dock.handover

    @property
    def switches(self) -> list[Switch]:
        """The books of every change between levels, attach and detach so far."""
        return self._dock.switches

    @property
    def events(self) -> list[DockEvent]:
        """What has happened, in order of time."""
        return self._dock.events

    def energy(self) -> float:
        """Crane and payload, J."""
        return self._dock.energy

    def snapshot(self) -> DockState:
        """The whole state at the last latch."""
        return self._dock.snapshot()

    def restore(self, snapshot: DockState) -> None:
        """Back to a snapshot of a scene of the same config. One taken off the 125-us grid goes back to the latch before it."""
        self._dock.restore(snapshot)
        self._time = int(self._dock.time)


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
        start = Pose(*_numbers("start (x, y, heading)", given.pop("start", (0.0, 0.0, 0.0)), 3))
        numbers = [given.pop("load_mass", 0.0), given.pop("load_inertia", 0.0), given.pop("tolerance", 1e-8)]
        load_mass, load_inertia, tolerance = _numbers("load_mass, load_inertia and tolerance", numbers, 3)
        parameters = AgvParameters()
        drive = given.pop("drive", "steered")
        if drive not in ("steered", "differential"):
            raise ValueError(f'drive must be "steered" or "differential", not {drive!r}')
        parameters.drive = getattr(AgvDrive, drive)
        _assign(parameters, "an AGV", given, "start", "load_mass", "load_inertia", "tolerance")
        self.parameters = parameters
        """The vehicle's parameters, as checked at the start."""
        self._core = _core.plant.AgvAlone(parameters, start, tolerance)
        self.set_load(load_mass, load_inertia)

    @property
    def state(self) -> AgvStatus:
        """The present state (a copy)."""
        x, y, heading, speed, side, yaw_rate, front, rear, force = self._core.y
        return AgvStatus(self._core.time * 1e-12, x, y, heading, speed, side, yaw_rate, front, rear, force, self._core.standing)

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


# ---- the dock's parts, as they stand in C++ (plant/parameters/config.hpp gives each value's unit and source)

default_dock = _core.plant.default_dock
"""``default_dock(agv_count)``: the configuration of docs/plant.md, every value of which may be changed."""
gantry_dock = _core.plant.gantry_dock
"""``gantry_dock(agv_count)``: the same dock with a ship-to-shore gantry for a crane."""
gantry_crane = _core.plant.gantry_crane
"""Parameters of a ship-to-shore gantry (plant-and-bus.md 1.4)."""
apply_layout = _core.plant.apply_layout
"""``apply_layout(config, text, name)``: a layout in TOML into a DockConfig. Raises LayoutError with line and column."""
load_layout = _core.plant.load_layout
"""``load_layout(config, path)``: the same from a file. Raises LayoutError, OSError."""
LayoutError = _core.plant.LayoutError
"""A layout file that is wrong: where, and what would be right. A ValueError."""
inverse_kinematics = _core.plant.inverse_kinematics
"""``inverse_kinematics(crane_parameters, crane_pose)``: the coordinates (7) at which the load hangs plumb there. Raises ValueError out of reach."""
mover_place = _core.plant.mover_place
"""``mover_place(mover, seconds)``: x, y in m and their rates in m/s."""
wind_speed = _core.plant.wind_speed
"""``wind_speed(wind_parameters, seconds)``: m/s, the mean and the seeded gusts, at an instant or an array of them."""
Dock = _core.plant.Dock
"""The dock with the devices that a controller sees: integer codes, times in picoseconds. ``Scene`` is the same in SI units."""
DockConfig = _core.plant.DockConfig
"""A dock's configuration."""
CraneParameters = _core.plant.CraneParameters
DriveParameters = _core.plant.DriveParameters
Portal = _core.plant.Portal
"""Where a crane's legs stand (``CraneParameters.portal``)."""
CranePose = _core.plant.CranePose
LandingParameters = _core.plant.LandingParameters
AgvParameters = _core.plant.AgvParameters
AgvDrive = _core.plant.AgvDrive
SensorParameters = _core.plant.SensorParameters
WindParameters = _core.plant.WindParameters
ShipMotion = _core.plant.ShipMotion
Layout = _core.plant.Layout
Box = _core.plant.Box
Mover = _core.plant.Mover
Waypoint = _core.plant.Waypoint
ContainerPlace = _core.plant.ContainerPlace
LaneSegment = _core.plant.LaneSegment
Pose = _core.plant.Pose
Signal = _core.plant.Signal
"""The crane at a latch: joints (their names in JOINTS), motor torques N m, codes, sway rad, tip and payload m, tension N (``Scene.signal``)."""
AgvSignal = _core.plant.AgvSignal
"""An AGV at a latch: m, rad, m/s (``Scene.agv``)."""
ContainerStatus = _core.plant.ContainerStatus
"""A container: state, AGV or -1, centre of its top in m, yaw in rad, mass in kg (``Scene.containers``)."""
DockEvent = _core.plant.Event
"""What happened on the dock: time in ps, kind, index, two values (``EventKind`` of plant/dock/dock.hpp says which)."""
DockState = _core.plant.DockState
"""A dock's complete state at a latch; opaque (``Scene.snapshot``)."""
CraneSnapshot = _core.plant.CraneAloneState
AgvSnapshot = _core.plant.AgvAloneState
Handover = _core.plant.Handover
"""Phase of a container's change of hands, whether it is released, attempts (``Scene.handover``)."""
Switch = _core.plant.Switch
"""Energy (J) and momentum (kg m/s, kg m2/s) before and after a change between levels, an attach or a detach (``Scene.switches``)."""
Momentum = _core.plant.Momentum
Linkage = _core.plant.Linkage
"""The level-luffing double-link jib as a differential-algebraic system (IDA): place, advance, angles, nose, energy, holding_torque."""
LinkageParameters = _core.plant.LinkageParameters


def _parameters(cls: type, values: dict[str, object]) -> object:
    made = cls()
    for name, value in values.items():
        setattr(made, name, value)
    return made


def _reduce(value: object) -> tuple[Any, ...]:
    """For ``copy`` and ``pickle``: a class of parameters that is made empty, and what of it can be set."""
    names = [name for name, member in vars(type(value)).items() if isinstance(member, property) and member.fset is not None]
    return _parameters, (type(value), {name: getattr(value, name) for name in names})


def _reduce_made(value: object) -> tuple[Any, ...]:
    """The same of one that is made of its values."""
    return type(value), tuple(getattr(value, name) for name in _MADE_OF[type(value)])


_MADE_OF: dict[type, tuple[str, ...]] = {
    Pose: ("x", "y", "heading"),
    CranePose: ("s", "x", "y", "z", "yaw"),
    Box: ("x_min", "x_max", "y_min", "y_max", "z_min", "z_max"),
    ContainerPlace: ("x", "y", "z", "yaw", "mass"),
    LaneSegment: ("x", "y", "heading", "length", "curvature", "speed"),
    Waypoint: ("time", "x", "y"),
    Mover: ("radius", "height", "path", "repeats"),
}
_MADE_EMPTY: tuple[type, ...] = (
    CraneParameters, DriveParameters, Portal, LandingParameters, AgvParameters, SensorParameters, WindParameters, ShipMotion, Layout, DockConfig,
    LinkageParameters,
)  # fmt: skip
for _class in _MADE_EMPTY:
    copyreg.pickle(_class, _reduce)
for _class in _MADE_OF:
    copyreg.pickle(_class, _reduce_made)
