"""What fails on the dock is said by name, wherever it is said: report, terminal, page and Python's events of the
dock."""

import re
from pathlib import Path
from typing import Any

import cmrc
import pytest
from cmrc import _core
from cmrc.page import Recording

PAUSE = {"at_s": 0.1, "action": "pause_host", "lasts_ms": 150}
STALL = {"at_s": 0.1, "action": "stall_bus", "bus": "B", "lasts_ms": 100}
# -1 as a whole word, an index alone in brackets, the number of a row without its name
NUMBER_ALONE = re.compile(r"4294967295|\(-?\d+\)|sub-process \d+(?! \()|process \d+(?! \()| kind \d")


@pytest.mark.parametrize(
    ("events", "settings", "said"),
    [
        ([PAUSE], {}, ["drive_stopped (joint phi)", "drive_resumed (joint kappa)"]),
        ([PAUSE], {"dock.crane": "gantry"}, ["drive_stopped (joint trolley)"]),
        (
            [STALL],
            {},
            [
                "of kind torque_compensation was taken 16 refreshes ago",
                "of kind pid hung 3 times and is given up",
                "stopped: sub-process 3 (torque compensation); the drives brake",
                "stopped: sub-process 4 (PID); the drives brake",
            ],
        ),
        (
            [{"at_s": 0.1, "action": "fail", "dsp": 1}],
            {},
            ["dsp 1, silent: no sign of life for 50 ms: it is reset", "it is considered dead"],
        ),
    ],
    ids=["drives of the slewing crane", "drives of the gantry", "blocks given up", "a silent DSP"],
)
def test_failures_of_a_run(
    tmp_path: Path, events: list[dict[str, Any]], settings: dict[str, Any], said: list[str]
) -> None:
    simulation = cmrc.Simulation(
        settings={"duration_s": 0.36, "dsps": 2, "report.reference": "none", **settings}, events=events
    )
    simulation.record()
    result = simulation.run()
    simulation.write_page(tmp_path / "run.html")
    failures = [f"dsp {f['dsp']}, {f['kind']}: {f['message']}" for f in result.report["failures"]]
    terminal = "\n".join(failures).replace("dsp None, ", "")
    for text in said:
        assert text in terminal
    assert not NUMBER_ALONE.search(terminal), terminal
    for _, _, thing, details in Recording.read(tmp_path / "run.html").header["dock_events"]:
        assert thing == "" or re.fullmatch(r"(joint|AGV|container|attempt) \w+", thing)
        assert not NUMBER_ALONE.search(details)


@pytest.mark.parametrize("settings", [{"host.start_ms": 110.0}, {"dock.drive_timeout_ms": 15.0}])
def test_drives_that_are_switched_on_late_have_not_failed(settings: dict[str, Any]) -> None:
    report = cmrc.run(dsps=2, duration_s=0.2, settings={"report.reference": "none", **settings}).report
    assert report["failures"] == []
    assert report["tasks"]["pid"]["on_time"] > 50


@pytest.mark.parametrize(("crane", "third"), [("default_dock", "phi"), ("gantry_dock", "trolley")])
def test_events_of_a_dock_in_python(crane: str, third: str) -> None:
    dock = _core.plant.Dock(getattr(_core.plant, crane)(1))
    dock.enable_drives(0x1F, 0)
    for joint in range(5):
        dock.set_torque_code(joint, 10, 0)
    dock.advance_to(200_000_000_000)
    stopped = [event for event in dock.events if event.kind == "drive_stopped"]
    assert [event.object for event in stopped] == ["joint s", "joint psi", f"joint {third}", "joint l", "joint kappa"]
    assert repr(stopped[2]) == f"Event(0.100125 s, drive_stopped, joint {third})"
    assert [event.index for event in stopped] == [0, 1, 2, 3, 4]
