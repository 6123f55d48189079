from typing import Any

class CraneParameters:
    drives: list[Any]
    def __getattr__(self, name: str) -> Any: ...

class CranePose:
    def __init__(self, s: float, x: float, y: float, z: float, yaw: float) -> None: ...

class SensorParameters:
    sway_range: float
    sway_noise: float
    seed: int

class WindParameters:
    mean: float
    gust: float
    direction: float
    area: float
    seed: int

class DockConfig:
    def __getattr__(self, name: str) -> Any: ...

def default_dock(agv_count: int = 1) -> DockConfig: ...
def gantry_dock(agv_count: int = 1) -> DockConfig: ...
def drive_channels(machine: Any) -> list[int]: ...

CraneAlone: Any
Dock: Any
def gantry_crane() -> CraneParameters: ...
def apply_layout(config: DockConfig, text: str, name: str = "layout") -> None: ...
def load_layout(config: DockConfig, path: str) -> None: ...
def mover_place(mover: Any, seconds: float) -> list[float]: ...

Method: Any
Machine: Any
AgvDrive: Any
Linkage: Any
LinkageParameters: Any
