"""The dock's parts as in C++ (plant/parameters/config.hpp gives each value's unit and source); they can be copied and
pickled."""

from __future__ import annotations

import copyreg
import os
from collections.abc import Sequence
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from cmrc import _core, arguments
from cmrc.core_errors import class_in_our_words, in_our_words, reworded
from cmrc.plant.arguments import array

default_dock = in_our_words("default_dock", _core.plant.default_dock)
"""``default_dock(agv_count)``: the configuration of docs/plant.md; every value may be changed. Its lists (the layout's
containers, the crane's drives, ...) are given back as tuples of copies: a list is changed by assigning the whole of
it."""
gantry_dock = in_our_words("gantry_dock", _core.plant.gantry_dock)
"""``gantry_dock(agv_count)``: the same dock with a ship-to-shore gantry as its crane."""
gantry_crane = in_our_words("gantry_crane", _core.plant.gantry_crane)
"""Parameters of a ship-to-shore gantry (plant-and-bus.md 1.4)."""
apply_layout = in_our_words("apply_layout", _core.plant.apply_layout)
"""``apply_layout(config, text, name)``: a layout in TOML into a DockConfig. Raises LayoutError with line and column."""
_load_layout = in_our_words("load_layout", _core.plant.load_layout)


def load_layout(config: DockConfig, path: str | os.PathLike[str]) -> None:
    """The same from a file. Raises LayoutError, OSError."""
    _load_layout(config, arguments.path("path", path, "the path of a layout"))


LayoutError = _core.plant.LayoutError
LayoutError.__doc__ = """A layout file that is wrong: where, and what would be right. A ValueError."""
inverse_kinematics = in_our_words("inverse_kinematics", _core.plant.inverse_kinematics)
"""``inverse_kinematics(crane_parameters, crane_pose)``: the coordinates (7) at which the load hangs vertically there.
Raises ValueError out of reach."""
mover_place = in_our_words("mover_place", _core.plant.mover_place)
"""``mover_place(mover, seconds)``: x, y in m and their rates in m/s."""
_wind_speed = in_our_words("wind_speed", _core.plant.wind_speed)


@overload
def wind_speed(wind: WindParameters, seconds: float) -> float: ...
@overload
def wind_speed(wind: WindParameters, seconds: Sequence[float] | NDArray[np.float64]) -> NDArray[np.float64]: ...
def wind_speed(
    wind: WindParameters, seconds: float | Sequence[float] | NDArray[np.float64]
) -> float | NDArray[np.float64]:
    """m/s, the mean and the seeded gusts, at an instant or an array of them."""
    times = array(seconds)
    if times is None:
        arguments.refuse("seconds", seconds, "a number of seconds, or an array of them,")
    return _wind_speed(wind, times)


Dock = _core.plant.Dock
"""The dock with the devices that a controller sees: integer codes, times in picoseconds. ``Scene`` is the same in SI
units."""
DockConfig = _core.plant.DockConfig
"""A dock's configuration. A list in it, and in its parts, is given back as a tuple of copies, and assigned whole:
``places = list(config.layout.containers)``, then ``places[0].mass = 20e3``, then ``config.layout.containers =
places``."""
CraneParameters = _core.plant.CraneParameters
DriveParameters = _core.plant.DriveParameters
Portal = _core.plant.Portal
"""The legs of a crane (``CraneParameters.portal``)."""
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
"""The crane at a latch: joints (their names in JOINTS), motor torques N m, codes, sway rad, tip and payload m, tension
N (``Scene.signal``)."""
AgvSignal = _core.plant.AgvSignal
"""An AGV at a latch: m, rad, m/s (``Scene.agv``)."""
ContainerStatus = _core.plant.ContainerStatus
"""A container: state, AGV or -1, centre of its top in m, yaw in rad, mass in kg (``Scene.containers``)."""
DockEvent = _core.plant.Event
"""An event of the dock: time in ps, kind, object ("joint phi", "AGV 0", "container 3" or ""), the object's index, two
values (``EventKind`` of plant/dock/dock_event.hpp says which)."""
DockState = _core.plant.DockState
"""A dock's complete state at a latch; opaque (``Scene.snapshot``)."""
CraneSnapshot = _core.plant.CraneAloneState
AgvSnapshot = _core.plant.AgvAloneState
Handover = _core.plant.Handover
"""Phase of a container's hand-over, whether it is released, attempts (``Scene.handover``)."""
Switch = _core.plant.Switch
"""Energy (J) and momentum (kg m/s, kg m2/s) before and after a change between levels, an attach or a detach
(``Scene.switches``)."""
Momentum = _core.plant.Momentum
Linkage = _core.plant.Linkage
"""The level-luffing double-link jib as a differential-algebraic system (IDA): place, advance, angles, nose, energy,
holding_torque."""
LinkageParameters = _core.plant.LinkageParameters


def _parameters(cls: type, values: dict[str, object]) -> object:
    made = cls()
    for name, value in values.items():
        setattr(made, name, value)
    return made


def _reduce(value: object) -> tuple[Any, ...]:
    """For ``copy`` and ``pickle``: a class of parameters that is constructed empty, and its settable members."""
    names = [
        name for name, member in vars(type(value)).items() if isinstance(member, property) and member.fset is not None
    ]
    return _parameters, (type(value), {name: getattr(value, name) for name in names})


def _reduce_made(value: object) -> tuple[Any, ...]:
    """The same for a class that is constructed from its values."""
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
for _name, _class in list(vars().items()):
    if isinstance(_class, type) and _class.__module__ == _core.plant.__name__:
        if issubclass(_class, Exception) or "__members__" in vars(_class):
            continue
        class_in_our_words(_class, _name)
_step_crane = _core.plant.CraneAlone.step


# A million steps are a usual number: a wrapper for any arguments would take an eighth of their time.
def _step(self: Any, torques: Any, dt: Any) -> None:
    try:
        _step_crane(self, torques, dt)
    except TypeError as error:
        raise reworded("Crane.step", error, (self, torques, dt), {}) from None


class_in_our_words(_core.plant.CraneAlone, "Crane")
_step.__doc__ = _step_crane.__doc__
_core.plant.CraneAlone.step = _step  # type: ignore[method-assign]
class_in_our_words(_core.plant.AgvAlone, "Agv")
for _class in _MADE_EMPTY:
    copyreg.pickle(_class, _reduce)
for _class in _MADE_OF:
    copyreg.pickle(_class, _reduce_made)
