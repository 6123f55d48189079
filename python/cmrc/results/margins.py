"""Delay margins of the servo's loops: what a gap in the samples is compared with (claim 7)."""

from __future__ import annotations

import math

import numpy as np

# PID's gains (docs/kernels.md): a pole at w rad/s on each joint, T_d = 2 / w, T_i = 6 / w, N = 20; the drives' lag
# of docs/plant.md.
BANDWIDTHS = {"travel": 3.0, "slew, luff, rotator": 5.0, "hoist": 8.0}
DERIVATIVE_N, DRIVE_LAG_S = 20.0, 3e-3


def delay_margin_s(bandwidth: float, lag_s: float = DRIVE_LAG_S) -> float:
    """By how much the loop of one joint may be late before it is unstable: phase margin / crossover frequency of
    L(s) = w²/s² (1 + w/(6 s) + (2 s/w)/(1 + s/(10 w))) / (1 + lag s), an inertia under PID without friction."""

    def loop(w: float) -> complex:
        s, b = 1j * w, bandwidth
        return (b / s) ** 2 * (1 + b / (6 * s) + (2 * s / b) / (1 + 2 * s / (DERIVATIVE_N * b))) / (1 + lag_s * s)

    low, high = bandwidth / 10, bandwidth * 100
    for _ in range(100):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if abs(loop(middle)) > 1 else (low, middle)
    return (math.pi + float(np.angle(loop(low)))) / low


def margins_ms() -> dict[str, float]:
    return {joint: 1e3 * delay_margin_s(w) for joint, w in BANDWIDTHS.items()}
