from enum import Enum
from typing import Any

class Machine(Enum):
    slewing = ...
    gantry = ...

class Method(Enum):
    erk = ...
    adams = ...
    bdf = ...

class AgvDrive(Enum):
    steered = ...
    differential = ...

class DriveParameters:
    rated_torque: float
    rated_speed: float
    gear: float
    rotor_inertia: float
    efficiency: float
    torque_lag: float
    coulomb: float
    stribeck: float
    viscous: float
    smooth_speed: float
    stribeck_speed: float
    brake: float
    @property
    def maximum_torque(self) -> float: ...
    @property
    def rated_force(self) -> float: ...
    @property
    def rated_joint_speed(self) -> float: ...

class CraneParameters:
    def __init__(self) -> None: ...
    machine: Machine
    a0: float
    jib: float
    pivot_height: float
    gantry_mass: float
    slew_inertia: float
    jib_mass: float
    jib_centre: float
    jib_inertia: float
    counterweight: float
    counterweight_radius: float
    spreader_mass: float
    spreader_inertia: float
    sway_damping: float
    gear_losses: bool
    stiction: bool
    lower: list[float]
    upper: list[float]
    drives: list[DriveParameters]

class CranePose:
    def __init__(self, s: float, x: float, y: float, z: float, yaw: float) -> None: ...
    s: float
    x: float
    y: float
    z: float
    yaw: float

class Waypoint:
    def __init__(self, time: float, x: float, y: float) -> None: ...
    time: float
    x: float
    y: float

class ContainerPlace:
    def __init__(self, x: float, y: float, z: float, yaw: float, mass: float) -> None: ...
    x: float
    y: float
    z: float
    yaw: float
    mass: float

class LaneSegment:
    def __init__(self, x: float, y: float, heading: float, length: float, curvature: float, speed: float) -> None: ...
    x: float
    y: float
    heading: float
    length: float
    curvature: float
    speed: float

class Pose:
    def __init__(self, x: float, y: float, heading: float) -> None: ...
    x: float
    y: float
    heading: float

class Box:
    def __init__(self, x_min: float, x_max: float, y_min: float, y_max: float, z_min: float, z_max: float) -> None: ...
    x_min: float
    x_max: float
    y_min: float
    y_max: float
    z_min: float
    z_max: float

class Mover:
    def __init__(self, radius: float, height: float, path: list[Waypoint], repeats: bool = False) -> None: ...
    radius: float
    height: float
    path: list[Waypoint]
    repeats: bool

class LandingParameters:
    def __init__(self) -> None: ...
    fall_stiffness: float
    fall_damping: float
    fall_spread_x: float
    fall_spread_y: float
    yaw_stiffness: float
    yaw_damping: float
    corner_stiffness: float
    corner_damping: float
    friction: float
    near: float
    away: float
    guides: bool
    guide_window: float
    guide_height: float
    guide_stiffness: float
    guide_damping: float
    seat_error: float
    seat_gap: float
    touch_speed: float
    touch_sway: float
    strict: bool
    yaw_error: float
    lock_time: float

class AgvParameters:
    def __init__(self) -> None: ...
    drive: AgvDrive
    mass: float
    length: float
    width: float
    front: float
    rear: float
    yaw_inertia: float
    deck_height: float
    cornering: float
    adhesion: float
    rolling: float
    drag: float
    steer_limit: float
    steer_rate: float
    steer_lag: float
    drive_lag: float
    acceleration: float
    braking: float
    emergency: float
    blend_speed: float
    track: float
    wheel_slip: float
    protective_field: bool
    protective_margin: float
    speed_gain: float
    speed_integral: float

class SensorParameters:
    def __init__(self) -> None: ...
    sway_range: float
    sway_noise: float
    range_rate: float
    range_dropout: float
    seed: int

class WindParameters:
    def __init__(self) -> None: ...
    mean: float
    gust: float
    direction: float
    area: float
    seed: int

class ShipMotion:
    def __init__(self) -> None: ...
    scale: float
    draught: float
    seed: int

class Layout:
    def __init__(self) -> None: ...
    deck: float
    rows: list[float]
    scan_x0: float
    scan_dx: float
    containers: list[ContainerPlace]
    ship: Box
    no_go: list[Box]
    movers: list[Mover]
    spot: Pose
    warehouse: Pose
    warehouse_radius: float
    warehouse_take: float
    slot_spacing: float
    legs: list[list[LaneSegment]]

class DockConfig:
    def __init__(self) -> None: ...
    crane: CraneParameters
    landing: LandingParameters
    agv: AgvParameters
    sensors: SensorParameters
    wind: WindParameters
    ship: ShipMotion
    layout: Layout
    collisions: bool
    rigid: bool
    agv_count: int
    home: CranePose
    rated_load: float
    drive_timeout: float
    method: Method
    tolerance: float
    signal_decimation: int

class LinkageParameters:
    def __init__(self) -> None: ...
    jib: float
    jib_mass: float
    fly: float
    fly_mass: float
    back: float
    tie: float
    tie_mass: float
    base_x: float
    base_z: float
    load: float

class Linkage:
    def __init__(self, parameters: LinkageParameters, tolerance: float = 1e-9) -> None: ...
    def place(self, jib_angle: float, jib_rate: float = 0.0) -> None: ...
    def advance(self, torque: float, seconds: float) -> None: ...
    @property
    def angles(self) -> list[float]: ...
    @property
    def rates(self) -> list[float]: ...
    @property
    def nose(self) -> list[float]: ...
    @property
    def open(self) -> float: ...
    @property
    def energy(self) -> float: ...
    @property
    def holding_torque(self) -> float: ...
    @property
    def joint_force(self) -> list[float]: ...

class Handover:
    @property
    def phase(self) -> str: ...
    @property
    def releasing(self) -> bool: ...
    @property
    def attempts(self) -> int: ...

class Momentum:
    payload: list[float]
    spin: float
    travel: float
    slewing: float

class Switch:
    @property
    def time(self) -> int: ...
    @property
    def kind(self) -> str: ...
    container: int
    energy_before: float
    energy_after: float
    before: Momentum
    after: Momentum

class LayoutError(ValueError): ...

CraneAlone: Any
AgvAlone: Any
Dock: Any

def default_dock(agv_count: int = 1) -> DockConfig: ...
def gantry_dock(agv_count: int = 1) -> DockConfig: ...
def gantry_crane() -> CraneParameters: ...
def inverse_kinematics(crane: CraneParameters, pose: CranePose) -> list[float]: ...
def apply_layout(config: DockConfig, text: str, name: str = "layout") -> None: ...
def load_layout(config: DockConfig, path: str) -> None: ...
def mover_place(mover: Mover, seconds: float) -> list[float]: ...
def wind_speed(wind: WindParameters, seconds: float) -> float: ...
