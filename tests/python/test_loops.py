"""The loops' margins: the formula against a simulation of the same loop, the gains it assumes against the
configuration, the page against the command."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import deque

import pytest
from cmrc import _core
from cmrc.loops import measured, model
from cmrc.loops.__main__ import BLOCKS, margins_table, marks, poses_table
from locations import BUILD, ROOT


def swings(bandwidth: float, delay_s: float) -> float:
    """PID tick by tick on an inertia of 1 behind the torque's lag, each torque taken ``delay_s`` after its sample: how
    much larger the motion is in the second half of 60/w than in the first."""
    h, lag, n = 1e-3, 3e-3, 20
    steps = 80  # of 12.5 us
    dt, t_d, t_i = h / steps, 2 / bandwidth, 6 / bandwidth
    k = bandwidth**2
    y, v, torque, old, integral, derivative, command = 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    waiting: deque[tuple[int, float]] = deque()
    late, sizes = round(delay_s / dt), []
    for tick in range(round(60 / bandwidth / h)):
        e = -y
        derivative = t_d / (t_d + n * h) * (derivative + k * n * (e - old))
        waiting.append((tick * steps + late, k * e + integral + derivative))
        integral += k * h / t_i * e
        old = e
        for step in range(tick * steps, (tick + 1) * steps):
            while waiting and waiting[0][0] <= step:
                command = waiting.popleft()[1]
            torque += dt / lag * (command - torque)
            v += dt * torque
            y += dt * v
        sizes.append(abs(y))
    half = len(sizes) // 2
    return max(sizes[half:]) / max(sizes[:half])


@pytest.mark.parametrize("bandwidth", [5.0, 40.0, 80.0])
def test_the_delay_margin_is_where_the_loop_becomes_unstable(bandwidth: float) -> None:
    margin = 1e-3 * model.margins(model.Loop(bandwidth)).delay_ms
    inside = model.SAMPLE_TO_LATCH_S
    assert swings(bandwidth, 0.93 * margin + inside) < 0.95 and swings(bandwidth, 1.07 * margin + inside) > 1.2


def test_margins_are_those_of_the_notes() -> None:
    """control-notes.md 1: crossover, Hz; phase margin, degrees; delay margin, ms; Ms."""
    for bandwidth, crossover, phase, delay, peak in (
        (40, 12.9, 46, 9.9, 1.62),
        (60, 18.8, 38, 5.6, 1.93),
        (80, 24.2, 30, 3.5, 2.34),
        (100, 29.3, 24, 2.25, 2.90),
    ):
        m = model.margins(model.Loop(bandwidth))
        assert m.crossover_hz == pytest.approx(crossover, rel=0.01)
        assert (
            m.phase_deg == pytest.approx(phase, abs=2)
            and m.delay_ms == pytest.approx(delay, rel=0.05)
            and m.peak == pytest.approx(peak, rel=0.05)
        )


def test_tight_has_what_it_is_for_at_every_pose_and_load() -> None:
    crane = _core.plant.CraneParameters()
    nominal = model.margins(model.Loop(model.PRESETS["tight"])).delay_ms
    assert 3 <= nominal <= 4
    for pose in model.poses((10e3, 26e3, 41e3, 50e3)):
        for assumed, moved in zip(
            model.assumed_inertias(pose, crane)[1:], model.moved_inertias(pose, crane)[1:], strict=True
        ):
            assert model.margins(model.Loop(model.PRESETS["tight"]), assumed / moved).delay_ms > 1.5


def test_the_travel_crosses_over_at_2_hz_at_most() -> None:
    assert model.margins(model.Loop(model.TRAVEL_RAD_S)).crossover_hz <= 2
    assert model.margins(model.Loop(6.0)).crossover_hz <= 2  # the most that the key takes


@pytest.mark.parametrize("preset", list(model.PRESETS))
def test_the_presets_are_the_configurations(preset: str) -> None:
    rows = {
        key: value
        for key, value in _core.cmrc.config(preset=preset).to_dict().items()
        if key.endswith("_bandwidth_rad_s")
    }
    assert rows.pop("control.travel_bandwidth_rad_s") == model.TRAVEL_RAD_S
    assert len(rows) == 5 and set(rows.values()) == {model.PRESETS[preset]}


def test_the_page_has_what_the_model_gives() -> None:
    page = (ROOT / "docs" / "control.md").read_text(encoding="utf-8")
    for block, table in zip(BLOCKS[:2], (margins_table(), poses_table()), strict=True):
        first, last = marks(block)
        assert page[page.index(first) + len(first) : page.index(last)].strip() == table


def test_the_margins_found_lie_beside_the_predicted_ones() -> None:
    """The page's own table; the campaign makes it again."""
    page = (ROOT / "docs" / "control.md").read_text(encoding="utf-8")
    first, last = marks("found")
    rows = [
        line.split("|")[1:-1]
        for line in page[page.index(first) : page.index(last)].splitlines()
        if line.startswith("| `")
    ]
    assert len(rows) == 8
    for _, _, predicted, stable, unstable in rows:
        assert float(stable) < float(unstable) and 0.9 * float(predicted) <= float(unstable) <= 1.5 * float(predicted)


@pytest.mark.parametrize("margin", [1, 2, 3, 7, 30, 61])
@pytest.mark.parametrize("predicted_ms", [0.1, 2.0, 7.0])
def test_the_margin_that_is_found_is_that_of_one_latch(
    margin: int, predicted_ms: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Wherever the search begins: ``margin`` latches of 125 us are stable, and one more is not."""
    monkeypatch.setattr(measured, "is_unstable", lambda joint, bandwidth, latches: latches > margin)
    assert measured.found_ms("slew", 8.0, predicted_ms) == (margin * 0.125, (margin + 1) * 0.125)


@pytest.mark.campaign
def test_the_page_is_what_the_command_gives() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "cmrc.loops"],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": str(BUILD / "python")},
    )
    page = (ROOT / "docs" / "control.md").read_text(encoding="utf-8")
    for table in done.stdout.strip().split("\n\n"):
        assert table in page


def test_a_page_without_marks_is_refused(tmp_path: object) -> None:
    wrong = f"{tmp_path}/page.md"
    with open(wrong, "w", encoding="utf-8") as page:
        page.write("# Nothing\n")
    done = subprocess.run(
        [sys.executable, "-m", "cmrc.loops", "--page", wrong],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(BUILD / "python")},
    )
    assert done.returncode == 2 and "has no line" in done.stderr
