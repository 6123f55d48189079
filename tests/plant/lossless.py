"""A crane that keeps its energy."""

from __future__ import annotations

from cmrc._core import plant


def without_losses(crane: plant.CraneParameters, *, rotors: bool = True) -> plant.CraneParameters:
    """The crane without sway damping and friction; with ``rotors=False`` without rotor inertia, too."""
    crane.sway_damping = 0.0
    drives = crane.drives
    for drive in drives:
        drive.coulomb = drive.viscous = 0.0
        if not rotors:
            drive.rotor_inertia = 0.0
    crane.drives = drives
    return crane
