"""Golden instruction traces: every kernel once, alone on a chip, with fixed inputs and windows that cost no time."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from agv_words import UNIT, agv_dsp, put_segments
from avoidance_loop import show
from cmrc import _core
from harness import gantry_constants
from harness_agv import Dsp
from lanes import loop
from range_scene import Disc, Scene
from traces import condensed

FULL_TEXT_CYCLES = 150
CYCLES_PER_HASH = 1000
TICK = 1000


def crane() -> Dsp:
    """At home, at rest, with a route to the first container and every input of process 3 in place."""
    dsp = Dsp()
    scalars = {
        "CR_POINT_PERIOD": 0.008, "CR_SERVO_PERIOD": 0.001, "CR_POINT_TICKS": 64, "CR_SERVO_TICKS": 8, "CR_LEG": 1,
        "CR_CLEARANCE": 0.6, "CR_AGV_DECK": 1.6, "CR_BOX_HEIGHT": 2.591, "CR_LOAD": 10_000.0, "CR_BOX_COUNT": 1,
    }  # fmt: skip
    for name, value in scalars.items():
        dsp.put(name, value)
    vectors = {
        "CR_HOME": (12.0, 16.0, 14.0, 0.0),
        "CR_TARGET": (0.0, 24.0, 9.092, 0.0),
        "CR_SPOT": (22.0, 8.0, 0.0),
        "CR_BOX": (-34.0, -24.0, 20.0, 34.0, 0.0, 25.0),
    }
    for name, values in vectors.items():
        for i, value in enumerate(values):
            dsp.put(name, value, i)
    dsp.put("CR_ROUTE_COUNT", 2, 1)
    for i, value in enumerate((6.0, 20.0, 16.0, 0.0, 0.0, 24.0, 10.0, 0.0)):
        dsp.put("CR_ROUTE", value, i)
    for j, total in enumerate((0, 400_000, 250_000, 300_000, 10_000)):
        dsp.put("CR_ENCODER_TOTAL", total, j)
        dsp.put("CR_ENCODER_LAST", total, j)
        dsp.device(dsp.symbols["ENCODER"] + j, total + 3 * j)
    dsp.device(dsp.symbols["LOAD_CELL"], 10_000)
    return dsp


def crane_moving() -> Dsp:
    """The same after three points and three servo ticks."""
    dsp = crane()
    for k in range(3):
        dsp.run("trajectory_crane", argument=k)
        dsp.run("inverse_crane", argument=k)
        dsp.run("torque", tick=TICK + 8 * k)
        dsp.run("pid", tick=TICK + 8 * k)
    dsp.run("trajectory_crane", argument=3)
    return dsp


def gantry() -> Dsp:
    """A ship-to-shore gantry at home, with a route out over the water and 2 m along the quay."""
    dsp = crane()
    gantry_constants(dsp.chip, dsp.symbols)
    for i, value in enumerate((0.0, -8.0, 14.0, 0.0)):
        dsp.put("CR_HOME", value, i)
    for i, value in enumerate((0.0, -8.0, 16.0, 0.0, 2.0, 10.0, 9.0, 0.0)):
        dsp.put("CR_ROUTE", value, i)
    return dsp


def gantry_moving() -> Dsp:
    """The same after three points and three servo ticks."""
    dsp = gantry()
    for k in range(3):
        dsp.run("trajectory_gantry", argument=k)
        dsp.run("inverse_gantry", argument=k)
        dsp.run("torque_gantry", tick=TICK + 8 * k)
        dsp.run("pid_gantry", tick=TICK + 8 * k)
    dsp.run("trajectory_gantry", argument=3)
    return dsp


def ship() -> Dsp:
    """One row of the bay with two containers."""
    dsp = crane()
    s = dsp.symbols
    for name, value in (
        ("SCAN_ROWS", 1),
        ("SCAN_Y", 24_000),
        ("SCAN_X0", -25_600),
        ("SCAN_DX", 400),
        ("SCAN_DECK", 3_909),
    ):
        dsp.device(s[name], value)
    for i in range(128):
        x = -25.6 + 0.4 * i
        height = 3.909 + 2.591 * ((abs(x) <= 6.096) + (abs(x - 12.7) <= 6.096))
        dsp.device(s["SCAN_PROFILE"] + i, math.floor(height * 1e3 / 8) * 8)
    return dsp


def agv() -> Dsp:
    """In the loading spot, before its way to the warehouse and home."""
    dsp = agv_dsp()
    dsp.put("AG_POINT_TICKS", 160)
    dsp.put("AG_LEG", 1)
    for leg, segments in enumerate((*loop(), loop()[1]), start=1):
        put_segments(dsp, leg, segments)
    for name, value in (
        ("AGV_X", 22_010),
        ("AGV_Y", 7_995),
        ("AGV_HEADING", 900),
        ("AGV_SPEED", 0),
        ("AGV_STATUS", 0x30),
    ):
        dsp.device(UNIT + dsp.symbols[name], value)
    return dsp


def agv_planned() -> Dsp:
    dsp = agv()
    dsp.run("trajectory_agv", argument=0)
    return dsp


def agv_facing_a_person() -> Dsp:
    dsp = agv()
    show(dsp, Scene([Disc(45.0, 8.7, 0.3)]).scan(22.01, 7.995, 0.0009))
    return dsp


# kernel, its inputs, TB_ARGUMENT, TB_TICK
CASES: list[tuple[str, Callable[[], Dsp], int, int]] = [
    ("trajectory_crane", crane, 0, 0),
    ("trajectory_crane_shaper", crane, 0, 0),
    ("inverse_crane", crane_moving, 3, 0),
    ("torque", crane_moving, 0, TICK + 24),
    ("torque_newton_euler", crane_moving, 0, TICK + 24),
    ("pid", crane_moving, 0, TICK + 24),
    ("trajectory_gantry", gantry, 0, 0),
    ("inverse_gantry", gantry_moving, 3, 0),
    ("torque_gantry", gantry_moving, 0, TICK + 24),
    ("pid_gantry", gantry_moving, 0, TICK + 24),
    ("identify", ship, 0, 0),
    ("grab_path", crane, 0, 0),
    ("home_crane", crane, 0, 0),
    ("trajectory_agv", agv, 0, 0),
    ("inverse_agv", agv_planned, 0, 0),
    ("home_agv", agv, 0, 0),
    ("avoidance", agv, 400, 0),
    ("avoidance_potential", agv_facing_a_person, 0, 0),
    ("avoidance_vfh", agv_facing_a_person, 0, 0),
    ("avoidance_dwa", agv_facing_a_person, 0, 0),
    ("error", Dsp, 0x20042, TICK),  # the luff's drive is at fault while the load is lowered
]


def kernel_trace(kernel: str, prepare: Callable[[], Dsp], argument: int, tick: int) -> str:
    *_, cycles = prepare().run(kernel, argument, tick)
    dsp = prepare()
    start = dsp.start(kernel, argument, tick)
    labels = _core.trace.Labels.of_dock(dsp.image)
    lines = []
    while dsp.chip.cycle < start + cycles:  # in parts: a list of all records would cost Python as much again
        for record in dsp.chip.trace(min(5000, start + cycles - dsp.chip.cycle)):
            record["cycle"] -= start
            lines.append(_core.trace.line(record, labels=labels))
    assert dsp.chip.cycle - start == cycles
    text = condensed(lines, 0, lambda cycle: cycle < FULL_TEXT_CYCLES, CYCLES_PER_HASH)
    return "\n".join(["# cmrc labelled instruction trace 1", f"# kernel_{kernel}: {cycles} cycles", *text]) + "\n"


@pytest.mark.golden
@pytest.mark.parametrize(("kernel", "prepare", "argument", "tick"), CASES)
def test_kernel(
    golden: Callable[[str, str], None], kernel: str, prepare: Callable[[], Dsp], argument: int, tick: int
) -> None:
    golden(f"kernels/{kernel}.trace", kernel_trace(kernel, prepare, argument, tick))
