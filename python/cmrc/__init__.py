"""Emulator of TMS320C40 multiprocessors that reproduces the CMRC robot controller.

``cmrc.run(dsps=4, duration_s=10)`` simulates the dock and returns a ``Result``. ``cmrc.c40`` has one chip, its
assembler and its number formats; ``cmrc.network`` several chips connected by their communication ports; ``cmrc.plant``
the dock without DSPs. ``cmrc.limits`` and ``cmrc.compare`` run a configuration several times: how far it is from its
first missed deadline, and what delays cost. ``cmrc.sweep`` runs a grid of configurations, and ``cmrc.search`` looks for
the best one.
"""

import sys as _sys
from typing import TYPE_CHECKING as _TYPE_CHECKING
from typing import Any as _Any

for _name in ("_interpreters", "_xxsubinterpreters"):  # of Python 3.13, and before
    try:
        _interpreters = __import__(_name)
    except ImportError:
        continue
    if _interpreters.get_current() != _interpreters.get_main():
        raise ImportError("cmrc: a subinterpreter cannot import it; the main interpreter of a process can")

from cmrc import early_signals as _early_signals

_before = _early_signals.handle() if _early_signals.is_command() else {}

from cmrc import _core

if getattr(_core, "__file__", None) is None:  # only the folder of its type stubs is there
    raise ImportError(
        f"cmrc: {__path__[0]} has no extension module _core for this Python ({_sys.implementation.cache_tag}); "
        "a wheel or a build (make build) for this Python is expected",
        name="cmrc._core",
    )

from cmrc import c40, network, plant
from cmrc.differences import Difference, diff
from cmrc.errors import Error
from cmrc.progress import show_progress
from cmrc.result import Profile, Result
from cmrc.simulation import ConfigError, Simulation, Snapshot, read_snapshot, run, write_snapshot
from cmrc.snapshots import SnapshotError
from cmrc.table import Table

if _TYPE_CHECKING:
    from cmrc import page as page
    from cmrc import studies as studies
    from cmrc import sweeps as sweeps
    from cmrc.studies import Comparison, Limits, compare, limits
    from cmrc.sweeps import search, sweep

__version__: str = _core.cmrc.emulator_version

__all__ = [
    "Comparison",
    "ConfigError",
    "Difference",
    "Error",
    "Limits",
    "Profile",
    "Result",
    "Simulation",
    "Snapshot",
    "SnapshotError",
    "Table",
    "c40",
    "compare",
    "diff",
    "limits",
    "network",
    "plant",
    "read_snapshot",
    "run",
    "search",
    "show_progress",
    "sweep",
    "write_snapshot",
]

_LATER: dict[str, tuple[str, ...]] = {
    "page": (),
    "studies": ("Comparison", "Limits", "compare", "limits"),
    "sweeps": ("search", "sweep"),
}
"""Pages and modules for studies of many runs are imported on first use, so that a single run does not wait for them."""


def __getattr__(name: str) -> _Any:
    from importlib import import_module

    for module, names in _LATER.items():
        if name == module or name in names:
            found = import_module(f"cmrc.{module}")
            return found if name == module else getattr(found, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, *_LATER})


_early_signals.restore(_before)
