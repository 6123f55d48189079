"""Where things are: the project, and the build that is tested."""

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# The controller works from time zero on, without a boot before it.
AT_ONCE: dict[str, str | int] = {"machine.boot": "preloaded", "host.start_ms": 0}
AT_ONCE_OPTIONS = [word for key, value in AT_ONCE.items() for word in ("--set", f"{key}={value}")]
# A layout whose spreader hangs above its container: the crane lowers it after some five seconds, not after twenty.
OVER_A_CONTAINER = "[home]\nx_m = 0.0\ny_m = 23.9\nz_m = 7.2\n[[containers]]\nx_m = 0.0\ny_m = 24.0\n"
BUILD = Path(os.environ.get("CMRC_BUILD_DIR", ROOT / "build"))
