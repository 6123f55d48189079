"""What every test shares: where the build is, and the path to the package in it."""

import os
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
BUILD = Path(os.environ.get("CMRC_BUILD_DIR", ROOT / "build"))
sys.path.insert(0, str(BUILD / "python"))


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--update-golden", action="store_true", help="rewrite the files in tests/golden and print what changed")


@pytest.fixture(scope="session")
def emulator() -> Path:
    """The command, as built."""
    return BUILD / "bin" / "emulator"
