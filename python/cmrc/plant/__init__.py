"""The dock without any DSP: a single crane, and the whole scene (docs/plant-python.md). SI units, angles in radians.

``Crane`` is driven by motor torques, ``Agv`` by speed and steering, ``Scene`` by the values that a controller writes to
its devices. ``CraneEnv`` is a crane as a gymnasium environment. The classes of ``parts`` describe a dock: layouts,
movers, ship, wind, sensors, landing.
"""

from typing import TYPE_CHECKING, Any

from cmrc.plant.agv import Agv, AgvStatus
from cmrc.plant.crane import (
    ACTUATED,
    COORDINATES,
    INTEGRATORS,
    JOINTS,
    Array,
    Crane,
    CraneState,
    Event,
    Linearization,
    Sensitivity,
    Sensors,
    Work,
)
from cmrc.plant.parts import (
    AgvDrive,
    AgvParameters,
    AgvSignal,
    AgvSnapshot,
    Box,
    ContainerPlace,
    ContainerStatus,
    CraneParameters,
    CranePose,
    CraneSnapshot,
    Dock,
    DockConfig,
    DockEvent,
    DockState,
    DriveParameters,
    Handover,
    LandingParameters,
    LaneSegment,
    Layout,
    LayoutError,
    Linkage,
    LinkageParameters,
    Momentum,
    Mover,
    Portal,
    Pose,
    SensorParameters,
    ShipMotion,
    Signal,
    Switch,
    Waypoint,
    WindParameters,
    apply_layout,
    default_dock,
    gantry_crane,
    gantry_dock,
    inverse_kinematics,
    load_layout,
    mover_place,
    wind_speed,
)
from cmrc.plant.scene import Scene

if TYPE_CHECKING:
    from cmrc.plant.environment import CraneEnv

__all__ = [
    "ACTUATED",
    "COORDINATES",
    "INTEGRATORS",
    "JOINTS",
    "Agv",
    "AgvDrive",
    "AgvParameters",
    "AgvSignal",
    "AgvSnapshot",
    "AgvStatus",
    "Array",
    "Box",
    "ContainerPlace",
    "ContainerStatus",
    "Crane",
    "CraneEnv",
    "CraneParameters",
    "CranePose",
    "CraneSnapshot",
    "CraneState",
    "Dock",
    "DockConfig",
    "DockEvent",
    "DockState",
    "DriveParameters",
    "Event",
    "Handover",
    "LandingParameters",
    "LaneSegment",
    "Layout",
    "LayoutError",
    "Linearization",
    "Linkage",
    "LinkageParameters",
    "Momentum",
    "Mover",
    "Portal",
    "Pose",
    "Scene",
    "Sensitivity",
    "SensorParameters",
    "Sensors",
    "ShipMotion",
    "Signal",
    "Switch",
    "Waypoint",
    "WindParameters",
    "Work",
    "apply_layout",
    "default_dock",
    "gantry_crane",
    "gantry_dock",
    "inverse_kinematics",
    "load_layout",
    "mover_place",
    "wind_speed",
]


def __getattr__(name: str) -> Any:
    """``CraneEnv`` is imported on first use, together with gymnasium."""
    if name != "CraneEnv":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from cmrc.plant.environment import CraneEnv

    return CraneEnv


def __dir__() -> list[str]:
    return __all__
