"""Where things are: the project, and the build that is tested."""

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# The controller works from time zero on, without a boot before it.
AT_ONCE: dict[str, str | int] = {"machine.boot": "preloaded", "host.start_ms": 0}
AT_ONCE_OPTIONS = [word for key, value in AT_ONCE.items() for word in ("--set", f"{key}={value}")]
BUILD = Path(os.environ.get("CMRC_BUILD_DIR", ROOT / "build"))
