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

CraneAlone: Any
Dock: Any
