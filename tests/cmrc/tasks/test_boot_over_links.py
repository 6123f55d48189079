"""The dock's DSPs boot over their links: at power-on, plugged in while others work, after a reset, and over wires that
break."""

import json
from typing import Any

import pytest
from audited_run import misses
from cmrc import _core

cmrc = _core.cmrc
Report = dict[str, Any]
START = 0.02  # s, host.start_ms
FAILED = {"reset_at_s": 0, "boot_s": None}  # the boot at power-on that came to nothing


def run(events: list[tuple[float, str, int]] | None = None, **settings: Any) -> Report:
    simulation = cmrc.Simulation(cmrc.config(settings={"duration_s": 0.1, "report.reference": "none", **settings}))
    for at_s, action, slot in events or []:
        simulation.at({"at_s": at_s, "action": action, "dsp": slot})
    simulation.run()
    report: Report = json.loads(simulation.report_json())
    assert report["audit"]["violations"] == []
    for dsp in report["dsps"]:
        assert sum(dsp["causes"].values()) == dsp["cycles"]
    return report


def failures(report: Report) -> list[tuple[str, int | None]]:
    return [(failure["kind"], failure["dsp"]) for failure in report["failures"]]


@pytest.mark.parametrize("dsps", [1, 4, 16])
def test_at_power_on_every_dsp_takes_each_word_once_and_answers_once(dsps: int) -> None:
    report = run(dsps=dsps, duration_s=0.03)
    words = report["boot_words"]
    assert words > 5000
    for dsp in report["dsps"]:
        assert dsp["link_words"] == {"in": words, "out": 1, "lost": 0}
        (boot,) = dsp["boots"]
        # A word takes 5 cycles of the link at least, and 20 of the loader would be slow; one host feeds all.
        assert boot["reset_at_s"] == 0
        assert words * 5 / 33.4e6 < boot["boot_s"] < words * 20 / 25e6 * max(1, dsps / 4)
        assert boot["boot_s"] < START
    assert failures(report) == []


def test_the_host_begins_at_its_time_or_when_all_have_booted() -> None:
    def first_tick(**settings: Any) -> int:
        report = run(**settings)
        assert misses(report) == 0
        refreshes: int = report["host"]["refreshes"]
        return round(0.1 * 8000) - refreshes

    assert first_tick() == 160  # 20 ms
    assert first_tick(start_ms=50) == 400
    assert first_tick(start_ms=0) == 4 * 8  # all have booted after 3.3 ms; the next whole ms
    assert first_tick(start_ms=0, boot="preloaded") == 1


def test_a_board_plugged_in_boots_while_the_others_work() -> None:
    report = run([(0.0501, "plug", 2)], dsps=2, slots=3)
    boots = report["dsps"][2]["boots"]
    assert len(boots) == 1 and boots[0]["reset_at_s"] == 0.0501
    alone = run(dsps=1, duration_s=0.03)["dsps"][0]["boots"][0]["boot_s"]
    assert alone < boots[0]["boot_s"] < 1.5 * alone  # the host has its refreshes to do as well
    assert report["dsps"][2]["link_words"]["in"] == report["boot_words"]
    assert misses(report) == 0 and failures(report) == []


def test_a_plugged_in_board_takes_blocks() -> None:
    report = run([(0.05, "unplug", 0), (0.05, "plug", 1)], dsps=1, slots=2, duration_s=0.15)
    assert report["dsps"][1]["claims"] > 50 and report["dsps"][1]["boots"][0]["boot_s"] is not None


def test_a_dsp_that_is_reset_boots_again() -> None:
    report = run([(0.05, "reset", 1)])
    assert [boot["reset_at_s"] for boot in report["dsps"][1]["boots"]] == [0, 0.05]
    assert report["dsps"][1]["link_words"] == {"in": 2 * report["boot_words"], "out": 2, "lost": 0}


@pytest.mark.parametrize(
    "events",
    [[(0.001, "reset", 1)], [(0.001, "unplug", 1), (0.0015, "plug", 1)], [(0.05, "reset", 1), (0.051, "reset", 1)]],
)
def test_a_reset_in_the_middle_of_a_boot_begins_a_new_one(events: list[tuple[float, str, int]]) -> None:
    report = run(events)
    assert failures(report) == [] and misses(report) == 0
    assert report["dsps"][1]["boots"][-1]["boot_s"] < 0.005


def test_with_a_broken_wire_at_power_on_the_others_begin_without_it() -> None:
    report = run([(0.001, "break_link", 1)], duration_s=0.06)
    assert failures(report)[0] == ("boot", 1)
    assert "words of its program" in report["failures"][0]["message"]
    assert report["dsps"][1]["boots"] == [FAILED] and report["dsps"][1]["state"] == "waiting for its program"
    assert report["dsps"][1]["claims"] == 0 and misses(report) == 0
    assert report["dsps"][1]["link_words"]["in"] < report["boot_words"]


def test_a_repaired_wire_lets_the_next_reset_boot() -> None:
    report = run([(0.001, "break_link", 1), (0.04, "repair_link", 1), (0.05, "reset", 1)])
    boot = report["dsps"][1]["boots"][-1]
    assert boot["reset_at_s"] == 0.05 and 0 < boot["boot_s"] < 0.005


def test_a_hung_dsp_with_a_broken_wire_does_not_come_back() -> None:
    report = run([(0.05, "break_link", 1), (0.06, "hang", 1)], duration_s=0.3)
    assert [failure for failure in failures(report) if failure[1] == 1][-1][0] in ("silent", "boot")
    assert ("boot", 1) in failures(report)
    assert report["dsps"][1]["boots"][-1]["boot_s"] is None
    assert all(dsp["boots"] for dsp in report["dsps"])


def test_without_any_wire_no_dsp_is_left() -> None:
    report = run([(0.0001, "break_link", slot) for slot in range(2)], dsps=2, duration_s=2)
    assert report["stop_reason"] == "no_dsp_left" and report["account_end_s"] < 1
    assert sorted(failures(report)[:2]) == [("boot", 0), ("boot", 1)]


@pytest.mark.parametrize("boot", ["link", "preloaded"])
def test_each_board_at_power_on_and_each_reset_is_a_boot_that_ended_or_not(boot: str) -> None:
    """Slot 0 works; slot 1 is reset; slot 2 is pulled at once, and slot 3 is empty until a board is plugged in. A
    preloaded program is there at power-on."""
    events = [(0.05, "reset", 1), (0.0, "unplug", 2), (0.06, "plug", 3)]
    boots = [dsp["boots"] for dsp in run(events, dsps=3, slots=4, boot=boot)["dsps"]]
    ended = {0: [True], 1: [True, True], 2: [False], 3: [True]}
    at_power_on = [0] if boot == "link" else []
    assert [[one["reset_at_s"] for one in of] for of in boots] == [
        at_power_on,
        [*at_power_on, 0.05],
        at_power_on,
        [0.06],
    ]
    for slot, of in enumerate(boots):
        assert [one["boot_s"] is not None for one in of] == ended[slot][len(ended[slot]) - len(of) :]


@pytest.mark.parametrize("action", ["unplug", "fail", "break_link"])
def test_a_dsp_lost_while_it_boots_has_the_boot_at_power_on_all_the_same(action: str) -> None:
    boots = run([(0.001, action, 0)], dsps=2)["dsps"][0]["boots"]
    assert boots[0] == FAILED and all(one["boot_s"] is None and one["reset_at_s"] > START for one in boots[1:])


def test_resets_are_those_of_the_watchdog() -> None:
    """Two by events count as none. A DSP that has failed is reset without effect, one that has hung boots again."""
    asked = run([(0.05, "reset", 1), (0.06, "reset", 1)], dsps=3)["dsps"]
    assert [dsp["resets"] for dsp in asked] == [0, 0, 0] and len(asked[1]["boots"]) == 3
    for action, boots in {"fail": 1, "hang": 2}.items():
        report = run([(0.05004, action, 1)], dsps=2, duration_s=0.3)
        said = [failure["message"] for failure in report["failures"] if failure["dsp"] == 1]
        dsp = report["dsps"][1]
        assert dsp["resets"] >= 1 and len(dsp["boots"]) == boots and report["dsps"][0]["resets"] == 0, (action, said)


def test_dsps_that_boot_do_not_stand_still() -> None:
    """The host begins to boot them only after a pause of 0.6 s."""
    simulation = cmrc.Simulation(cmrc.config(settings={"dsps": 2, "duration_s": 1, "report.reference": "none"}))
    simulation.at({"at_s": 0, "action": "pause_host", "lasts_ms": 600})
    simulation.run()
    report = json.loads(simulation.report_json())
    assert (report["stop_reason"], simulation.exit_status) == ("completed", 0) and misses(report) == 0
    assert all(0.6 < boot["boot_s"] < 0.61 for dsp in report["dsps"] for boot in dsp["boots"])


@pytest.mark.parametrize(("plugged_s", "reason"), [(0.6985, "completed"), (0.72, "no_dsp_left")])
def test_a_board_plugged_in_at_the_last_moment_is_waited_for(plugged_s: float, reason: str) -> None:
    """The only DSP fails at 0.2 s; at 0.7 s none would be left. The new board has booted 2.3 ms after it is in."""
    report = run([(0.2, "fail", 0), (plugged_s, "plug", 1)], dsps=1, slots=2, duration_s=1)
    assert report["stop_reason"] == reason
    assert (report["dsps"][1]["claims"] > 50) == (reason == "completed")


def test_a_board_whose_boot_is_given_up_is_not_waited_for() -> None:
    """Its wires are broken: the host gives it up after 10 ms, and the 0.5 s begin."""
    events = [(0.1, "break_link", 1), (0.2, "fail", 0), (0.4, "plug", 1)]
    report = run(events, dsps=1, slots=2, duration_s=2, **{"run.after_stop_s": 1})
    assert report["stop_reason"] == "no_dsp_left" and 0.9 < report["account_end_s"] < 1.1


@pytest.mark.parametrize("cycle", range(0, 40, 3))
def test_a_wire_cut_anywhere_in_a_word_loses_no_word_unsaid(cycle: int) -> None:
    report = run([(0.0015 + cycle * 30e-9, "break_link", 0), (0.0016, "repair_link", 0)], dsps=1, duration_s=0.04)
    link = report["dsps"][0]["link_words"]
    assert link["lost"] <= 1
    if link["lost"] == 0:
        assert link["in"] == report["boot_words"] and report["dsps"][0]["boots"][0]["boot_s"] is not None
    else:
        assert ("boot", 0) in failures(report)


@pytest.mark.parametrize("action", ["hang", "freeze"])
@pytest.mark.parametrize("at_s", [0.05, 0.050005])
@pytest.mark.parametrize("boot", ["link", "preloaded"])
def test_a_failure_during_a_reset_holds_until_the_next_reset(action: str, at_s: float, boot: str) -> None:
    events = [{"at_s": 0.05, "action": "reset", "dsp": 0}, {"at_s": at_s, "action": action, "dsp": 0}]
    settings = {"report.reference": "none", "duration_s": 0.12, "machine.dsps": 2, "machine.boot": boot}
    simulation = _core.cmrc.Simulation(_core.cmrc.config(settings=settings, events=events))
    simulation.run()
    report = json.loads(simulation.report_json())
    assert report["audit"]["violations"] == []
    assert [failure["dsp"] for failure in report["failures"] if failure["kind"] == "silent"] == [0]
    assert report["dsps"][0]["resets"] == 1 and report["dsps"][0]["state"] == "idle"


def test_a_board_that_is_pulled_while_it_boots_takes_no_further_word() -> None:
    """The host notices it like a broken wire, and says how many words have left the adapter."""
    messages = []
    for action in ("unplug", "break_link"):
        events = [{"at_s": 0.001, "action": action, "dsp": 0}]
        settings = {"report.reference": "none", "duration_s": 0.03, "machine.dsps": 2}
        simulation = _core.cmrc.Simulation(_core.cmrc.config(settings=settings, events=events))
        simulation.run()
        report = json.loads(simulation.report_json())
        assert report["audit"]["violations"] == []
        [failure] = [failure for failure in report["failures"] if failure["kind"] == "boot"]
        messages.append((failure["time_s"], int(failure["message"].split("; ")[1].split()[0])))
        assert 0 <= messages[-1][1] - report["dsps"][0]["link_words"]["in"] <= 2  # under way, or in its FIFO
    assert messages[0][0] == messages[1][0]
