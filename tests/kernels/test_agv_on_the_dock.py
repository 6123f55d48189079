"""The kernels before the plant itself: both legs driven by the DSP on the dock's own vehicle and lane, and the dock's
own bay identified."""

import math

import pytest
from agv_words import agv_dsp, measure, pushed, set_leg
from cmrc import _core
from harness_agv import Dsp
from reference_agv import Segment, wrap
from test_identify import Bay

MS = 10**9  # ps


def sense(dsp: Dsp, dock: _core.plant.Dock, t: int) -> None:
    readings = (dock.agv_x(0, t), dock.agv_y(0, t), dock.agv_heading(0, t), dock.agv_speed(0, t), dock.agv_status(0, t))
    measure(dsp, *readings)


@pytest.mark.parametrize("period_us", [20000])
def test_both_legs_one_after_the_other(period_us: int) -> None:
    """A whole round: each leg starts where the last one left the vehicle, and ends within 3 cm of its end."""
    dsp = agv_dsp(period_us=period_us)
    config = _core.plant.default_dock(1)
    dock = _core.plant.Dock(config)
    t = 0
    for number, lane in enumerate(config.layout.legs[:2], start=1):
        segments = [Segment(s.x, s.y, s.heading, s.length, s.curvature, s.speed) for s in lane]
        set_leg(dsp, number, segments)
        k, done, began, across = 0, False, t, 0.0
        while not done or dock.agv_status(0, t) & 0x1F != 0x10:
            if not done and dock.agv_status(0, t) & 0xF < 2:
                sense(dsp, dock, t)
                done = bool(dsp.run("trajectory_agv", k)[0])
                dsp.run("inverse_agv", k)
                point = dsp.floats("AG_POINT", 3, (k & 1) * 8)
                x, y = dock.agv_x(0, t) / 1e3 - point[0], dock.agv_y(0, t) / 1e3 - point[1]
                across = max(across, abs(math.cos(point[2]) * y - math.sin(point[2]) * x))
                period, speed, front, rear = pushed(dsp)
                dock.agv_period(0, period, t)
                dock.agv_push(0, speed, front, rear, t)
                k += 1
            t += MS
            dock.advance_to(t)
            assert t - began < 80_000 * MS
        last = segments[-1]
        assert abs(dock.agv_x(0, t) / 1e3 - last.x - last.length * math.cos(last.heading)) < 0.03
        assert abs(dock.agv_y(0, t) / 1e3 - last.y - last.length * math.sin(last.heading)) < 0.03
        assert abs(wrap(dock.agv_heading(0, t) / 1e6 - last.heading)) < 0.005
        assert (t - began) / MS / 1000 < 40 * period_us / 20000  # s
        assert across < 0.15  # bends and all
    assert not [e for e in dock.events if "dry" in str(e) or "overflow" in str(e)]


def test_the_docks_own_bay() -> None:
    config = _core.plant.default_dock(1)
    dock = _core.plant.Dock(config)
    bay = Bay()
    s = bay.symbols
    bay.put("CR_BOX_HEIGHT", 2.591)
    for name in ("ROWS", "X0", "DX", "DECK"):
        bay.device(s[f"SCAN_{name}"], getattr(dock, f"scan_{name.lower()}")())
    start = bay.start("identify")
    for row in range(dock.scan_rows()):
        assert bay.chip.run(2_000_000, s["identify_scan"] + 2)["reason"] == "breakpoint"
        assert bay.device_word(s["SCAN_ROW"]) == row
        dock.select_row(row, row * MS)
        bay.device(s["SCAN_Y"], dock.scan_y((row + 1) * MS - 1))
        for i in range(128):
            bay.device(s["SCAN_PROFILE"] + i, dock.profile(i, (row + 1) * MS - 1))
        bay.chip.step()
    assert bay.finish(start)[0] == 1
    x, y, z, yaw = bay.floats("CR_TARGET", 4)
    tops = [(c.z, c.x, c.y) for c in dock.containers]
    highest = max(top for top, _, _ in tops)
    assert z == pytest.approx(highest, abs=0.005)
    assert min(math.hypot(x - cx, y - cy) for top, cx, cy in tops if top > highest - 0.1) < 0.11
    assert yaw == 0.0
