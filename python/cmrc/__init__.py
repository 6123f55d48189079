"""Emulator of TMS320C40 multiprocessors that reproduces the CMRC robot controller.

``cmrc.run(dsps=4, duration_s=10)`` simulates the dock and returns a ``Result``; ``cmrc.c40`` holds one chip, its assembler and its number formats; ``cmrc.plant`` the
dock without DSPs.
"""

from cmrc import c40, plant
from cmrc.result import Profile, Result
from cmrc.simulation import ConfigError, Simulation, run
from cmrc.table import Table

__all__ = ["ConfigError", "Profile", "Result", "Simulation", "Table", "c40", "plant", "run"]
