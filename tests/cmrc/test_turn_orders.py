"""Turn orders, cuts and failure scripts: whichever chip the emulator advances first, and however a run is cut, it is the same run."""

import json
import random
from pathlib import Path
from typing import Any

import pytest
from cmrc import _core

cmrc = _core.cmrc
ORDERS = 3
JOINTS = ("travel", "slew", "luff", "hoist", "rotate")
TURN_ORDER_TOML = """
[machine]
dsps = 1
boot = "preloaded"
[run]
duration_s = 0.1
[[events]]
at_s = 0.03
action = "slow"
dsp = 0
factor = 0.001
[[events]]
at_s = 0.0724291
action = "hang"
dsp = 0
"""


class Script:
    """Failures of every kind at random instants, as far as they make sense."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        draw = self.random
        self.dsps = draw.randint(1, 4)
        self.slots = self.dsps + draw.randint(0, 1)
        self.duration_s = 0.15
        self.settings: dict[str, Any] = {
            "dsps": self.dsps, "machine.slots": self.slots, "duration_s": self.duration_s, "report.reference": "none", "seed": seed,
            "boot": draw.choice(["preloaded", "link"]), "host.start_ms": draw.choice([0, 5]), "idle_policy": draw.choice(["doorbell", "doorbell", "pause", "spin"]),
            "phase_jitter": draw.random() < 0.3, "watchdog.silence_ms": draw.choice([5, 20, 50]),
        }  # fmt: skip
        times: list[float] = []
        for _ in range(draw.randint(2, 10)):
            times.append(self.instant(times))
        plugged = [slot < self.dsps for slot in range(self.slots)]
        self.events = [{"at_s": at_s, **self.failure(plugged)} for at_s in sorted(times)]

    def instant(self, others: list[float]) -> float:
        """Some on a tick of the host or a latch, where others act too; some at the instant of another event."""
        at_s, draw = self.random.uniform(0.0, self.duration_s * 0.95), self.random.random()
        if draw < 0.2:
            return round(at_s, 3)
        if draw < 0.3:
            return round(at_s / 125e-6) * 125e-6
        return self.random.choice(others) if draw < 0.4 and others else at_s

    def failure(self, plugged: list[bool]) -> dict[str, Any]:
        draw = self.random
        slot = draw.randrange(len(plugged))
        chip = {"dsp": slot}
        kind = draw.choice(["chip"] * 6 + ["host", "bus", "joint"])
        if kind == "host":
            return {"action": "pause_host", "lasts_ms": draw.choice([0.01, 0.7, 20])}
        if kind == "bus":
            return {"action": "stall_bus", "bus": draw.choice("AB"), "lasts_ms": draw.choice([0.001, 0.2, 3])}
        if kind == "joint":
            return {"action": draw.choice(["fail_drive", "repair_drive", "stick_encoder", "repair_encoder"]), "joint": draw.choice(JOINTS)}
        action = draw.choice(["fail", "hang", "freeze", "reset", "slow", "slow", "unplug", "break_link", "repair_link"])
        if action in ("break_link", "repair_link"):
            return {"action": action, **chip}
        if not plugged[slot]:
            plugged[slot] = True
            return {"action": "plug", **chip}
        if action == "unplug":
            plugged[slot] = False
        if action == "slow":
            return {"action": "slow", **chip, "factor": draw.choice([0.001, 0.02, 0.3, 0.999, 1])}
        return {"action": action, **chip}

    def report(self, turn_order: int, cuts: list[float]) -> dict[str, Any]:
        simulation = cmrc.Simulation(cmrc.config(settings={**self.settings, "turn_order": turn_order}, events=self.events))
        for cut in cuts:
            simulation.run_until(cut)
        simulation.run()
        report: dict[str, Any] = json.loads(simulation.report_json())
        for key in ("elapsed_s", "configuration"):
            del report[key]
        return report


def is_one_run(seed: int) -> None:
    script = Script(seed)
    plain = script.report(0, [])
    assert plain["audit"]["violations"] == []
    draw = random.Random(seed)
    for _ in range(ORDERS):
        order = draw.randint(1, 2**63)
        cuts = sorted(draw.uniform(0, script.duration_s) for _ in range(draw.choice([0, 3, 40])))
        other = script.report(order, cuts)
        assert other["hash"] == plain["hash"], (order, cuts, script.settings, script.events)
        assert other == plain


def test_a_chip_that_is_slow_and_then_hangs(tmp_path: Path) -> None:
    """The chip had been run ahead past the last event before the slice's end, and the event behind it was taken out of turn."""
    file = tmp_path / "turn_order.toml"
    file.write_text(TURN_ORDER_TOML)
    reports = set()
    for order in range(10):
        simulation = cmrc.Simulation(cmrc.config(file=str(file), settings={"turn_order": order}))
        simulation.run()
        report = json.loads(simulation.report_json())
        reports.add((report["hash"], json.dumps(report["tasks"])))
    assert len(reports) == 1


@pytest.mark.parametrize("seed", range(6))
def test_turn_orders_and_cuts_change_nothing_whatever_fails(seed: int) -> None:
    is_one_run(seed)


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(100, 600))
def test_turn_orders_and_cuts_by_the_hundred(seed: int) -> None:
    is_one_run(seed)
