"""Running the command."""

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def run(emulator: Path, tmp_path: Path) -> Run:
    """run(*arguments, cwd=tmp_path): the finished command with its output as text."""

    def call(*arguments: object, timeout: float = 60) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [emulator, *map(str, arguments)], capture_output=True, text=True, cwd=tmp_path, timeout=timeout, check=False
        )

    return call
