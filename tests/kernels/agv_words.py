"""The words of one AGV on an emulated DSP: its unit on bus B, its set-up, its leg, what its kernels send."""

from __future__ import annotations

from harness_agv import Dsp
from reference_agv import Segment

UNIT = 0x400  # AGV_UNIT: the first AGV's registers
DT = 0.02  # s, from one point to the next


def agv_dsp(index: int = 0, period_us: int = 20_000) -> Dsp:
    """A DSP with the area of one AGV, whose host has written its unit and its periods."""
    dsp = Dsp()
    dsp.agv(index)
    dsp.put("AG_UNIT", UNIT)
    dsp.put("AG_STEP_TIME", DT)
    dsp.put("AG_PERIOD_US", period_us)
    return dsp


def set_leg(dsp: Dsp, leg: int, segments: list[Segment]) -> None:
    """What the host writes when it sends the vehicle along a leg."""
    dsp.put("AG_LEG", leg)
    put_segments(dsp, leg, segments)


def put_segments(dsp: Dsp, leg: int, segments: list[Segment]) -> None:
    dsp.put("AG_SEGMENT_COUNT", len(segments), leg)
    for i, s in enumerate(segments):
        for j, value in enumerate((s.x, s.y, s.heading, s.length, s.curvature, s.speed)):
            dsp.put("AG_SEGMENT", float(value), (leg - 1) * 64 + i * 8 + j)


def forget_avoidance(dsp: Dsp) -> None:
    """A leg begins without what avoidance said on the one before."""
    for name in ("LIMIT", "SHIFT", "HOLD", "WAIT", "BESIDE"):
        dsp.put(f"AG_AVOID_{name}", 0)
    dsp.put("AG_PRODUCED", 0)


def measure(dsp: Dsp, x: int, y: int, heading: int, speed: int, status: int) -> None:
    """What the vehicle's unit shows: mm, microradians, mm/s."""
    for name, value in zip(
        ("AGV_X", "AGV_Y", "AGV_HEADING", "AGV_SPEED", "AGV_STATUS"), (x, y, heading, speed, status), strict=True
    ):
        dsp.device(UNIT + dsp.symbols[name], value)


def pushed(dsp: Dsp) -> list[int]:
    """The set-point that the kernel has sent: its period, speed, and steering angles at the front and at the rear."""
    names = ("AGV_PERIOD", "AGV_SPEED_COMMAND", "AGV_FRONT_COMMAND", "AGV_REAR_COMMAND")
    return [dsp.device_word(UNIT + dsp.symbols[name]) for name in names]
