"""Delay margins found in runs of the emulator: how much later the drives may take their codes before the report calls a
loop unstable."""

from __future__ import annotations

from cmrc.simulation import Setting, run

LATCH_US = 125
TESTED = ("slew", "luff", "hoist", "rotator")
"""The joints whose margins are found; the travel's margin is longer than the greatest ``dock.drive_delay_us``."""
SYMBOLS = {"slew": "psi", "luff": "phi", "hoist": "l", "rotator": "kappa"}
SLOW_RAD_S = 10.0
"""Bandwidth of the other joints, so that the tested joint's margin is the smallest."""
DURATION_S = 6.0


def settings(joint: str, bandwidth_rad_s: float, latches: int) -> dict[str, Setting]:
    """The settings of a run in which only this joint's loop is fast, and all codes are taken late by this number of
    latches."""
    made: dict[str, Setting] = {f"control.{other}_bandwidth_rad_s": SLOW_RAD_S for other in TESTED}
    made[f"control.{joint}_bandwidth_rad_s"] = bandwidth_rad_s
    made["dock.drive_delay_us"] = float(latches * LATCH_US)
    made["report.reference"] = "none"
    return made


def is_unstable(joint: str, bandwidth_rad_s: float, latches: int) -> bool:
    """Whether the report calls this joint unstable, in a run from power-on into the first leg."""
    result = run(dsps=2, duration_s=DURATION_S, settings=settings(joint, bandwidth_rad_s, latches))
    sentence = f"the loop of joint {SYMBOLS[joint]} is unstable"
    return any(f["kind"] == "unstable" and f["message"].startswith(sentence) for f in result.report["failures"])


def found_ms(joint: str, bandwidth_rad_s: float, predicted_ms: float) -> tuple[float, float]:
    """The longest added delay that is stable and the shortest that is not, ms, one latch apart. The search begins at
    the predicted margin."""
    stable, unstable = 0, max(2, round(1e3 * predicted_ms / LATCH_US))
    while not is_unstable(joint, bandwidth_rad_s, unstable):
        stable, unstable = unstable, round(unstable * 1.25) + 1
        if unstable * LATCH_US > 100_000:
            raise RuntimeError(f"{joint} with {bandwidth_rad_s:g} rad/s: stable with every delay that can be set")
    step = max(1, unstable // 10)
    while unstable - stable > 1:
        middle = unstable - step if unstable - step > stable else (stable + unstable) // 2
        if is_unstable(joint, bandwidth_rad_s, middle):
            unstable = middle
        else:
            stable = middle
        step = max(1, step // 2)
    return stable * LATCH_US / 1e3, unstable * LATCH_US / 1e3
