from collections.abc import Callable

from cmrc._core.cmrc import Config

def compare(config: Config, on_progress: Callable[[float, float], bool | None] | None = None) -> tuple[str, str]: ...
