"""Packages that only a part of cmrc needs."""

from __future__ import annotations

import importlib
import importlib.util
from typing import Any


def installed(module: str, extra: str, what: str) -> None:
    """Checks that a module is installed, without importing it. Raises ImportError that says what to install."""
    if importlib.util.find_spec(module) is None:
        raise ImportError(f"{what} needs {module}, which is not installed: pip install 'cmrc[{extra}]'", name=module)


def needed(module: str, extra: str, what: str) -> Any:
    """The module. Raises ImportError that says what to install."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ImportError(
            f"{what} needs {error.name or module}, which is not installed: pip install 'cmrc[{extra}]'", name=error.name
        ) from error
