"""Every value that a run lists is loaded, and a comparison names it: of the controller, its accounts, and what is
measured."""

from __future__ import annotations

import random
from typing import Any

import pytest
from cmrc import _core
from leaves import check_that_every_value_is_loaded
from locations import AT_ONCE

core = _core.cmrc
ROOMS = (
    "host.",
    "ledger.",
    "observer.",
    "log.",
    "course.",
    "events",
    "given events",
    "last alive",
    "last driven",
    "enabled",
    "account end",
    "after end",
    "stop",
)
TEXTS = {key["name"] for key in core.config_keys() if key["type"] not in ("boolean", "integer", "number")}
# Keys of maps, which other keys may equal; what points into a table; events, which are put in order.
KEYS = (".process", "host.changes.", "host.cycles.agvs.", "host.cycles.started.", "host.drops.", "host.longest.", "host.gaps.", "ledger.open.", "ledger.jobs.",
        "observer.refused.", "log.pending.", "course.legs.", "course.places.", "course.size")  # fmt: skip


class Run:
    """A run, with what leaves.py asks for."""

    def __init__(self) -> None:
        self.run = core.Simulation(configuration())
        self._state, self._load_state = self.run._state, self.run._load_state

    def _state_leaves(self) -> list[tuple[str, int, int]]:
        return self.run._state_leaves()

    def _state_difference(self, other: Run) -> str | None:
        return self.run._state_difference(other.run)


def configuration() -> Any:
    events = [{"at_s": 0.021, "action": "fail", "dsp": 1}, {"at_s": 0.024, "action": "set", "key": "scheduling.p", "value": 0x5000},
              {"at_s": 0.029, "action": "stick_sway", "axis": "alpha"}, {"at_s": 0.058, "action": "set", "key": "scheduling.q", "value": 0x1000}]  # fmt: skip
    return core.config(preset="heavy", settings={"dsps": 2, "duration_s": 0.06, "agvs": 2, **AT_ONCE}, events=events)


@pytest.mark.parametrize(("instant", "share"), [(0.0123456, 0.2), (0.0521, 0.2)])
def test_every_value_of_a_run_is_loaded(instant: float, share: float) -> None:
    full = Run()
    full.run.run_until(instant)
    spare, draw = Run(), random.Random(instant)

    def leave_out(path: str) -> bool:
        return (
            not path.startswith(ROOMS)
            or any(part in path for part in KEYS)
            or path.removeprefix("host.") in TEXTS
            or draw.random() > share
        )

    assert check_that_every_value_is_loaded(lambda: spare, full, leave_out) > 100
