"""Where things are: the project, and the build that is tested."""

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BUILD = Path(os.environ.get("CMRC_BUILD_DIR", ROOT / "build"))
