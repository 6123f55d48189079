"""One joint's loop as a linear system: PID of a sampled servo, a held torque code, delay, torque lag, an inertia.

    L(s) = r w^2 C(z) H(s) exp(-s T) / (1 + T_c s) / s^2        z = exp(s h)
    C(z) = 1 + (h / T_i) / (z - 1) + a N (z - 1) / (z - a)      a = T_d / (T_d + N h)
    H(s) = (1 - exp(-s h)) / (s h)

w is the bandwidth, r what the gain assumes of the inertia over what the drive really moves. C is PID's law written as a
transfer function of its difference equations (plant-and-bus.md 2.1); H holds the code for a period h.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cmrc import _core

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

SAMPLE_TO_LATCH_S = 1e-4
"""s from the instant at which PID reads the encoders to the latch at which the drives take its codes: the tick's block
is claimed and has read them some 25 us after the tick, and the drives' next latch is 125 us after it."""
FREQUENCIES: Array = 2 * math.pi * np.logspace(-1, 2.65, 8000)
"""rad/s, up to 450 Hz: below half the servo's rate."""


@dataclass(frozen=True)
class Loop:
    """One joint's settings, in the units of its keys (docs/configuration.md, [control])."""

    bandwidth_rad_s: float
    damping: float = 1.0
    integral_time_s: float = 0.0
    derivative_filter: float = 20.0
    period_s: float = 1e-3
    torque_lag_s: float = 3e-3

    def open(self, w: Array, inertia_ratio: float = 1.0, delay_s: float = SAMPLE_TO_LATCH_S) -> ComplexArray:
        """L(j w), w in rad/s. ``inertia_ratio`` is r, ``delay_s`` all of T."""
        h, b = self.period_s, self.bandwidth_rad_s
        t_d = 2 * self.damping / b
        t_i = self.integral_time_s or 6 / b
        a = t_d / (t_d + self.derivative_filter * h)
        s = 1j * w
        z = np.exp(s * h)
        law = 1 + h / t_i / (z - 1) + a * self.derivative_filter * (z - 1) / (z - a)
        hold = (1 - np.exp(-s * h)) / (s * h)
        result: ComplexArray = (
            inertia_ratio * b**2 * law * hold * np.exp(-s * delay_s) / (1 + self.torque_lag_s * s) / s**2
        )
        return result


@dataclass(frozen=True)
class Margins:
    """The margins of a loop before it becomes unstable."""

    crossover_hz: float
    phase_deg: float
    delay_ms: float
    """Additional delay in ms that makes it unstable: phase margin over crossover frequency, the least of all
    crossovers."""
    peak: float
    """Ms, the largest of |1 / (1 + L)|."""


def margins(loop: Loop, inertia_ratio: float = 1.0) -> Margins:
    """Margins of a stable loop, delay from sample to latch included."""
    w = FREQUENCIES
    response = loop.open(w, inertia_ratio)
    size = np.abs(response)
    found = []
    for k in np.flatnonzero((size[:-1] > 1) != (size[1:] > 1)):
        share = math.log(size[k]) / math.log(size[k] / size[k + 1])
        crossover = float(w[k] * (w[k + 1] / w[k]) ** share)
        angle = float(np.angle(loop.open(np.array([crossover]), inertia_ratio))[0])
        # L turns by pi beyond -180 degrees: what is left to it.
        phase = (math.pi + angle) % (2 * math.pi)
        found.append((phase / crossover, crossover, phase))
    delay, crossover, phase = min(found)
    return Margins(crossover / (2 * math.pi), math.degrees(phase), 1e3 * delay, float(np.max(1 / np.abs(1 + response))))


# ---- the inertia that a drive moves: the plant's own mass matrix against what the gains assume


@dataclass(frozen=True)
class Pose:
    """Luff angle, rad; rope, m; mass on it, kg, spreader included."""

    luff_rad: float
    rope_m: float
    mass_kg: float


PRESETS = {"base": 40.0, "tight": 80.0}
"""rad/s: bandwidth of slew, luff, hoist, rotator and trolley in each preset."""
TRAVEL_RAD_S = 5.0
JOINTS = ("travel", "slew", "luff", "hoist", "rotator")
PLACE = (0, 1, 2, 3, 6)
"""of the joints among the plant's seven coordinates"""
YAW_PER_KG = 3.85e5 / 30480
"""kg m2 of yaw inertia per kg of load (plant-and-bus.md 1.4)"""


def assumed_inertias(pose: Pose, crane: _core.plant.CraneParameters) -> list[float]:
    """The inertias that the gains assume, kg or kg m2, by joint (docs/control.md, Inertias)."""
    c = math.cos(pose.luff_rad)
    rotors = [d.rotor_inertia * d.gear**2 for d in crane.drives]
    jib = crane.jib_inertia + crane.jib_mass * crane.jib_centre**2
    slewing = crane.slew_inertia + crane.counterweight * crane.counterweight_radius**2 + crane.jib_inertia * c**2
    return [
        rotors[0] + crane.gantry_mass + crane.jib_mass + crane.counterweight,
        rotors[1] + slewing + crane.jib_mass * (crane.a0 + crane.jib_centre * c) ** 2,
        rotors[2] + jib + pose.mass_kg * (crane.jib * c) ** 2,
        rotors[3] + pose.mass_kg,
        rotors[4] + crane.spreader_inertia,
    ]


def moved_inertias(pose: Pose, crane: _core.plant.CraneParameters) -> list[float]:
    """The inertia that each drive moves if the load can swing and the other joints can give way, kg or kg m2: 1 /
    (M^-1)_jj of the plant's mass matrix at rest, rotors included. A torque acts on this inertia well above every loop's
    crossover."""
    q = [0.0, 0.9, pose.luff_rad, pose.rope_m, 0.0, 0.0, 0.0]
    yaw = crane.spreader_inertia + YAW_PER_KG * (pose.mass_kg - crane.spreader_mass)
    inverse = np.linalg.inv(np.array(_core.plant.Crane(crane).mass_matrix(q, pose.mass_kg, yaw)))
    return [float(1 / inverse[k, k]) for k in PLACE]


def poses(masses_kg: Sequence[float] = (10e3, 34e3, 50e3)) -> Iterator[Pose]:
    """The corners of the crane's reach, and some poses between them."""
    for luff_deg in (20, 35, 50, 65, 80):
        for rope_m in (6.0, 20.0, 45.0):
            for mass in masses_kg:
                yield Pose(math.radians(luff_deg), rope_m, mass)
