"""The command, run to its end: its status, and what it printed."""

from __future__ import annotations

import subprocess
from pathlib import Path

from locations import BUILD

EMULATOR = BUILD / "bin" / "emulator"


def emulator(*arguments: object, stdin: str = "", folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    """`emulator ARGUMENTS`, in a folder, with `stdin` as its input; no test needs two minutes of it."""
    return subprocess.run(
        [EMULATOR, *map(str, arguments)],
        cwd=folder,
        input=stdin,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
