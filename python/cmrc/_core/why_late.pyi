from collections.abc import Callable, Sequence

from cmrc._core.cmrc import Config

def limits(
    config: Config,
    cycles: Sequence[float] | None,
    dsps: Sequence[float] | None,
    servo: Sequence[float] | None,
    errors: bool,
    on_progress: Callable[[int, int], object] | None,
) -> tuple[str, str]: ...
def compare(config: Config) -> tuple[str, str]: ...
