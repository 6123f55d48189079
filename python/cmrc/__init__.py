"""Emulator of TMS320C40 multiprocessors that reproduces the CMRC robot controller.

<<<<<<< HEAD
``cmrc.run(dsps=4, duration_s=10)`` simulates the dock and returns a ``Result``; ``cmrc.c40`` holds one chip, its assembler and its number formats; ``cmrc.plant`` the
dock without DSPs. ``cmrc.limits`` and ``cmrc.compare`` run a configuration several times: how far it is from its first missed deadline, and what time costs it.
=======
``cmrc.run(dsps=4, duration_s=10)`` simulates the dock and returns a ``Result``; ``cmrc.c40`` holds one chip, its assembler and its number formats; ``cmrc.network``
several chips joined by their communication ports; ``cmrc.plant`` the dock without DSPs.
>>>>>>> 13864cf (Networks of chips: exact order, links, shared memories, deadlocks named; exec with several programs, topologies and a network file; cmrc.network)
"""

from cmrc import c40, network, plant
from cmrc.result import Profile, Result
from cmrc.simulation import ConfigError, Simulation, run
from cmrc.studies import Comparison, Limits, compare, limits
from cmrc.table import Table

<<<<<<< HEAD
__all__ = ["Comparison", "ConfigError", "Limits", "Profile", "Result", "Simulation", "Table", "c40", "compare", "limits", "plant", "run"]
=======
__all__ = ["ConfigError", "Profile", "Result", "Simulation", "Table", "c40", "network", "plant", "run"]
>>>>>>> 13864cf (Networks of chips: exact order, links, shared memories, deadlocks named; exec with several programs, topologies and a network file; cmrc.network)
