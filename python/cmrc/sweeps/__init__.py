"""Sweeps: many runs over a grid of settings, on this machine or on a Dask cluster, kept in a folder
(docs/sweeps.md)."""

from cmrc.sweeps.grid import Grid
from cmrc.sweeps.ranges import GridError
from cmrc.sweeps.runner import Status
from cmrc.sweeps.search import Found, search
from cmrc.sweeps.store import SweepError
from cmrc.sweeps.study import Sweep, sweep

__all__ = ["Found", "Grid", "GridError", "Status", "Sweep", "SweepError", "search", "sweep"]
