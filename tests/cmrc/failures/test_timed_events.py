"""Failures, hot-plug and changes of parameters at given instants: their effects, that nothing is lost, and that bad
input is refused."""

import json
import random
from typing import Any

import pytest
from cmrc import _core

cmrc = _core.cmrc
Report = dict[str, Any]
OUTCOMES = ("on_time", "late", "unfinished", "never_started", "lost", "dropped")


def run(events: list[dict[str, Any]], **settings: Any) -> Report:
    simulation = cmrc.Simulation(cmrc.config(settings={"report.reference": "none", **settings}, events=events))
    simulation.run()
    report: Report = json.loads(simulation.report_json())
    assert report["audit"]["violations"] == []
    assert report["audit"]["checks"] > 0
    for task in report["tasks"].values():
        assert task["released"] == sum(task[name] for name in OUTCOMES)
    for dsp in report["dsps"]:
        assert sum(dsp["causes"].values()) == dsp["cycles"]
    return report


def refused(events: list[dict[str, Any]] | str, **settings: Any) -> str:
    with pytest.raises(cmrc.ConfigError) as info:
        if isinstance(events, str):
            cmrc.config(toml=events, name="dock.toml", settings=settings)
        else:
            cmrc.config(events=events, settings=settings)
    return str(info.value)


# ---- each action does what its line in docs/configuration.md says


def test_a_slowed_dsp_executes_that_much_less_and_longer() -> None:
    # One DSP works alone: half the clock, half the cycles from then on, and each run of PID takes longer.
    full = run([], duration_s=0.1, dsps=1)
    half = run([{"at_s": 0.05, "action": "slow", "dsp": 0, "factor": 0.5}], duration_s=0.1, dsps=1)
    assert full["dsps"][0]["cycles"] == 2_500_000
    assert half["dsps"][0]["cycles"] == 1_250_000 + 625_000
    assert half["tasks"]["pid"]["execution_ps"]["worst"] > 1.5 * full["tasks"]["pid"]["execution_ps"]["worst"]


SILENT = {"pause_host": {}, "stall_bus": {"bus": "A"}}


@pytest.mark.parametrize("action", SILENT)
def test_ticks_are_dropped_whether_the_host_comes_back_before_the_end_or_not(action: str) -> None:
    """No refresh from 50 ms on: block 50 is out, and each tick from 51 on that is over at 200 ms is dropped."""
    for lasts_ms in (149.9, 150, 151, 2000):
        report = run([{"at_s": 0.05, "action": action, "lasts_ms": lasts_ms, **SILENT[action]}], duration_s=0.2, dsps=2)
        for kind in ("pid", "torque_compensation"):
            task = report["tasks"][kind]
            assert (task["released"], task["dropped"]) == (180, 149), (kind, lasts_ms)
            assert task["misses"] == task["longest_miss_streak"] == 150, (kind, lasts_ms)
            assert task["why_late"]["dropped_host_late"] + task["why_late"]["dropped_previous_out"] == 149


def test_releases_by_interval_in_a_pause_to_the_end_are_dropped_too() -> None:
    """Three vehicles, each with a release every 160 refreshes. No refresh comes after number 399; those are dropped
    whose next one has come by the refresh at which the host is back, or by number 1599, the last before the end."""
    load = {"duration_s": 0.2, "dsps": 4, "agvs": 3, "load.avoidance_cycles": 1000, "load.parked": True}
    for lasts_ms, until in ((100, 1199), (150, 1599), (2000, 1599)):
        report = run([{"at_s": 0.0499, "action": "pause_host", "lasts_ms": lasts_ms}], **load)
        task = report["tasks"]["obstacle_avoidance"]
        over = sum(tick % 160 in (0, 53, 106) for tick in range(400, until - 160 + 1))
        assert task["dropped"] == task["misses"] == over, lasts_ms


def test_a_report_within_a_pause_books_no_tick_twice() -> None:
    events = [{"at_s": 0.05, "action": "pause_host", "lasts_ms": 100}]
    config = cmrc.config(settings={"report.reference": "none", "duration_s": 0.2, "dsps": 2}, events=events)
    whole, cut, again = (cmrc.Simulation(config) for _ in range(3))
    whole.run()
    cut.run_until(0.1)
    so_far = json.loads(cut.report_json())["tasks"]["pid"]
    assert (so_far["dropped"], so_far["misses"]) == (49, 50)
    again.restore(cut.snapshot())
    for simulation in (cut, again):
        simulation.run()
        assert json.loads(simulation.report_json())["tasks"] == json.loads(whole.report_json())["tasks"]


def test_full_speed_again_is_full_speed() -> None:
    events = [{"at_s": at, "action": "slow", "dsp": 0, "factor": factor} for at, factor in ((0.02, 0.25), (0.06, 1))]
    report = run(events, duration_s=0.1, dsps=1)
    assert report["dsps"][0]["cycles"] == 500_000 + 250_000 + 1_000_000


def test_a_paused_host_leaves_out_its_refreshes() -> None:
    report = run([{"at_s": 0.0500001, "action": "pause_host", "lasts_ms": 5}], duration_s=0.1)
    assert 39 <= report["host"]["skipped_refreshes"] <= 41  # 5 ms of 125 us
    assert 4 <= report["tasks"]["pid"]["dropped"] <= 6


def test_a_stalled_bus_moves_no_word_while_it_lasts() -> None:
    simulation = cmrc.Simulation(
        cmrc.config(
            settings={"duration_s": 0.1}, events=[{"at_s": 0.05, "action": "stall_bus", "bus": "A", "lasts_ms": 2}]
        )
    )
    words = []
    for at_s in (0.05001, 0.0519, 0.054):
        simulation.run_until(at_s)
        bus = json.loads(simulation.report_json())["buses"]["A"]
        words.append(sum(master["words_read"] + master["words_written"] for master in bus["masters"].values()))
    assert words[0] == words[1] < words[2]


@pytest.mark.parametrize("bus", ["A", "B"])
def test_a_wait_for_a_stalled_bus_has_its_name_before_it_is_over(bus: str) -> None:
    """The run ends while a block waits. The block has waited for most of the time, and executed a few instructions."""
    stall = {"at_s": 0.05503, "action": "stall_bus", "bus": bus, "lasts_ms": 20}
    report = run(
        [stall],
        duration_s=0.0565,
        dsps=1,
        **{"machine.boot": "preloaded", "host.start_ms": 0, "report.reference": "none"},
    )
    (dsp,) = report["dsps"]
    assert dsp["cycles"] == pytest.approx(0.0565 * 25e6, abs=10)
    (miss,) = [miss for miss in report["misses"] if miss["outcome"] == "unfinished"]
    parts = miss["parts_ps"]
    assert 1.3 * 10**9 < parts[f"execution.bus_{bus.lower()}_arbitration"] < 1.5 * 10**9
    assert (
        sum(amount for name, amount in parts.items() if name.startswith("execution.") and "_arbitration" not in name)
        < 10**8
    )


def test_every_clock_of_a_stalled_bus_is_accounted_for() -> None:
    # The host asks at its next refresh, 125 us into the stall at the latest; a millisecond is 33 333 clocks.
    shares = {}
    for name in ("A", "B"):
        report = run([{"at_s": 0.05, "action": "stall_bus", "bus": name, "lasts_ms": 1}], duration_s=0.1)
        shares[name] = {bus: report["buses"][bus]["clocks_by_use"] for bus in ("A", "B")}
        for bus in ("A", "B"):
            assert sum(shares[name][bus].values()) == report["buses"][bus]["clocks"]
    assert 33_333 * 7 / 8 < shares["A"]["A"]["idle_requested"] - shares["B"]["A"]["idle_requested"] < 33_500
    assert shares["B"]["B"]["idle_requested"] > 10_000


def test_a_failed_drive_brakes_its_joint_alone() -> None:
    simulation = cmrc.Simulation(
        cmrc.config(
            settings={"duration_s": 3, "signal_decimation": 80, "report.reference": "none"},
            events=[{"at_s": 2, "action": "fail_drive", "joint": "slew"}],
        )
    )
    simulation.run()
    signals = simulation.signals()
    last = signals["time_s"] > 2.9
    assert abs(signals["psi_rate_rad_per_s"][last]).max() < 1e-6
    assert abs(signals["l_rate_m_per_s"][last]).max() > 1e-3 or abs(signals["phi_rate_rad_per_s"][last]).max() > 1e-5


def test_a_stuck_encoder_shows_the_same_count() -> None:
    from cmrc._core import plant

    dock = plant.Dock(plant.default_dock(1))
    ms = 1_000_000_000
    dock.enable_drives(0x1F, 0)
    for joint in range(5):
        dock.set_torque_code(joint, 200, 0)
    before = dock.encoder(3, 50 * ms)
    dock.fail_encoder(3, True, 50 * ms)
    assert dock.encoder(3, 90 * ms) == before
    dock.fail_encoder(3, False, 91 * ms)
    assert dock.encoder(3, 92 * ms) != before


def test_drives_brake_when_no_torque_code_comes() -> None:
    # Both DSPs die; the drives hold the last code for 100 ms, then brake; the run ends when no DSP has been alive for
    # 500 ms.
    report = run([{"at_s": 1, "action": "fail", "dsp": dsp} for dsp in (0, 1)], duration_s=5, dsps=2)
    assert report["stop_reason"] == "no_dsp_left"
    assert report["braked"]
    stopped = [failure for failure in report["failures"] if "drive_stopped" in failure["message"]]
    assert len(stopped) == 5
    assert all(1.099 < failure["time_s"] < 1.102 for failure in stopped)
    assert not run([], duration_s=0.2)["braked"]


def test_a_board_plugged_into_an_empty_slot_works() -> None:
    report = run(
        [{"at_s": 0.05, "action": "plug", "dsp": 1}, {"at_s": 0.06, "action": "fail", "dsp": 0}],
        duration_s=0.2,
        dsps=1,
        slots=2,
    )
    assert report["dsps"][1]["claims"] > 200
    assert report["tasks"]["pid"]["on_time"] > 170
    assert [entry["what"] for entry in report["timed_events"]] == ["plug DSP 1", "fail DSP 0"]


def test_an_operator_changes_a_parameter() -> None:
    # With as_printed a waiting pid block has J = FFECh instead of FFEFh (paper table). The trace shows only the order
    # by J, so the test reads shared memory.
    simulation = cmrc.Simulation(cmrc.config(settings={"duration_s": 0.2, "dsps": 1}))
    simulation.at({"at_s": 0.1, "action": "set", "key": "scheduling.equation", "value": "as_printed"})
    symbol = simulation.symbol

    def importances(from_s: float) -> set[int]:
        seen = set()
        for k in range(400):
            simulation.run_until(from_s + k * 20e-6)
            for block in range(symbol("BLOCK_COUNT")):
                offset = symbol("BLOCK_POOL") + block * symbol("BLOCK_WORDS")
                if simulation.peek(offset + symbol("TB_KIND")) == symbol("KIND_PID"):
                    seen.add(simulation.peek(offset + symbol("TB_J")))
        return seen

    assert importances(0.05) == {0, 0xFFEF}
    assert 0xFFEC in importances(0.15)


def test_a_change_is_an_event_of_the_trace_and_of_the_hash() -> None:
    change = [{"at_s": 0.05, "action": "set", "key": "scheduling.gamma_refreshes", "value": 1}]
    assert run(change, duration_s=0.1)["hash"] != run([], duration_s=0.1)["hash"]
    assert run(change, duration_s=0.1)["hash"] == run(change, duration_s=0.1, turn_order=77)["hash"]


# ---- at one instant: in the order of the file


@pytest.mark.parametrize(
    ("factors", "cycles"), [((0.5, 0.25), 312_500), ((0.25, 0.5), 625_000), ((0.5, 1, 0.25), 312_500)]
)
def test_the_last_of_several_at_one_instant_holds(factors: tuple[float, ...], cycles: int) -> None:
    events = [{"at_s": 0.05, "action": "slow", "dsp": 0, "factor": factor} for factor in factors]
    settings = {"duration_s": 0.1, "dsps": 1, "boot": "preloaded", "report.reference": "none"}
    report = run(events, **settings)
    assert report["dsps"][0]["cycles"] == 1_250_000 + cycles
    assert [entry["what"] for entry in report["timed_events"]] == [f"slow DSP 0 to {factor}" for factor in factors]
    # What is added during the run comes after what the file has for that instant.
    simulation = cmrc.Simulation(cmrc.config(settings=settings, events=events[:1]))
    simulation.run_until(0.02)
    for event in events[1:]:
        simulation.at(event)
    simulation.run()
    assert json.loads(simulation.report_json())["dsps"][0]["cycles"] == 1_250_000 + cycles


def test_a_board_is_pulled_and_put_in_at_one_instant_in_that_order_only() -> None:
    pull, put = ({"at_s": 0.05, "action": action, "dsp": 0} for action in ("unplug", "plug"))
    report = run([pull, put], duration_s=0.06, dsps=1)
    assert [boot["reset_at_s"] for boot in report["dsps"][0]["boots"]] == [0, 0.05]
    assert "slot 0 holds a board; unplug it first" in refused([put, pull], dsps=1)


def test_the_operators_last_word_at_one_instant_counts() -> None:
    def importances(words: tuple[str, str]) -> set[int]:
        events = [{"at_s": 0.03, "action": "set", "key": "scheduling.equation", "value": word} for word in words]
        settings = {"duration_s": 0.06, "dsps": 1, "boot": "preloaded", "report.reference": "none"}
        simulation = cmrc.Simulation(cmrc.config(settings={"report.reference": "none", **settings}, events=events))
        first, words_each, count = (simulation.symbol(f"BLOCK_{name}") for name in ("POOL", "WORDS", "COUNT"))
        seen = set()
        for k in range(400):
            simulation.run_until(0.04 + k * 20e-6)
            for block in range(first, first + count * words_each, words_each):
                if simulation.peek(block + simulation.symbol("TB_KIND")) == simulation.symbol("KIND_PID"):
                    seen.add(simulation.peek(block + simulation.symbol("TB_J")))
        return seen

    assert 0xFFEC in importances(("restored", "as_printed")) and 0xFFEC not in importances(("as_printed", "restored"))


# ---- whatever fails, nothing is lost or done twice


def failures(seed: int, dsps: int, duration_s: float) -> list[dict[str, Any]]:
    """Random failures that never leave the scene without a DSP for good: slot 0 only hangs or freezes."""
    chance = random.Random(seed)
    plugged = dict.fromkeys(range(dsps), True)
    events: list[dict[str, Any]] = []
    # Within 150 us of a servo tick the DSPs are at work: half of the claims, runs and ends of the scene happen there.
    ticks = [chance.randint(10, int(duration_s * 1e3) - 50) * 1e-3 for _ in range(chance.randint(2, 8))]
    times = sorted(tick + chance.uniform(0, 150e-6) for tick in ticks)
    for at_s in times:
        dsp = chance.randrange(dsps)
        kinds = ["hang", "freeze", "reset", "slow", "pause_host", "stall_bus"]
        if dsp > 0:
            kinds += ["fail", "unplug", "break_link", "repair_link"]
        action = chance.choice(kinds) if plugged[dsp] else chance.choice(["plug", "plug", "repair_link"])
        event: dict[str, Any] = {"at_s": at_s, "action": action}
        if action == "stall_bus":
            event |= {"bus": chance.choice("AB"), "lasts_ms": chance.uniform(0.01, 3)}
        elif action == "pause_host":
            event |= {"lasts_ms": chance.uniform(0.01, 3)}
        else:
            event["dsp"] = dsp
        if action == "slow":
            event["factor"] = chance.choice([0.01, 0.1, 0.5, 1.0])
        if action in ("unplug", "plug"):
            plugged[dsp] = action == "plug"
        events.append(event)
    return events


def survives(seed: int) -> None:
    dsps = 2 + seed % 3
    report = run(failures(seed, dsps, 0.3), duration_s=0.3, dsps=dsps, agvs=1 + seed % 2)
    assert report["stop_reason"] == "completed"
    # A block is lost only with a DSP that has just failed: at the end all but the last few blocks are done.
    assert (
        sum(task["lost"] + task["unfinished"] + task["never_started"] for task in report["tasks"].values())
        <= 2 * dsps + 4
    )


@pytest.mark.parametrize("seed", range(6))
def test_random_failures_lose_nothing(seed: int) -> None:
    survives(seed)


@pytest.mark.campaign
@pytest.mark.parametrize("seed", [*range(6, 12), *range(100, 600)])
def test_random_failures_by_the_hundred_lose_nothing(seed: int) -> None:
    survives(seed)


def test_failures_are_the_same_in_any_turn_order() -> None:
    events = failures(5, 3, 0.3)
    assert run(events, duration_s=0.3, dsps=3)["hash"] == run(events, duration_s=0.3, dsps=3, turn_order=4711)["hash"]


# ---- what makes no sense is refused before the run starts


@pytest.mark.parametrize(("event", "message"), [
    ({"action": "fail", "dsp": 0}, r"events.at_s: is missing"),
    ({"at_s": -1, "action": "fail", "dsp": 0}, r"events.at_s: -1 is out of range"),
    ({"at_s": 1, "action": "explode"}, r'events.action: "explode" is not known; "fail", '),
    ({"at_s": 1, "action": "hung"}, r'"stick_anemometer", "repair_anemometer" or "set" is expected; did you mean "hang"\?'),
    ({"at_s": 1, "action": "fail"}, r"events.dsp: is missing"),
    ({"at_s": 1, "action": "fail", "dsp": 4}, r"events.dsp: there is no slot 4; the slots are 0 to 3; machine.slots makes more"),
    ({"at_s": 1, "action": "fail", "dsp": 1.5}, r"events.dsp: 1.5 is not a DSP"),
    ({"at_s": 1, "action": "fail", "dsp": 1, "bus": "A"}, r'events.bus: "fail" has no such field; its fields are "at_s", "action" or "dsp"'),
    ({"at_s": 1, "action": "plug", "dsp": 1}, r"events.action: plug at 1 s, but slot 1 holds a board; unplug it first"),
    ({"at_s": 1, "action": "slow", "dsp": 1, "factor": 0}, r"events.factor: 0 is out of range"),
    ({"at_s": 1, "action": "stall_bus", "bus": "C", "lasts_ms": 1}, r'events.bus: there is no bus C; "A" or "B" is expected'),
    ({"at_s": 1, "action": "fail_drive", "joint": "elbow"}, r'events.joint: "elbow" is not known'),
    ({"at_s": 1, "action": "fail_drive", "joint": "lufff"}, r'is expected; did you mean "luff"\?'),
    ({"at_s": 1, "action": "set", "key": "scheduling.pp", "value": 1}, r'scheduling.pp: no such key; did you mean "scheduling.p"'),
    ({"at_s": 1, "action": "set", "key": "machine.dsps", "value": 5}, r"machine.dsps: cannot be changed during a run"),
    ({"at_s": 1, "action": "set", "key": "scheduling.q", "value": 0x4000}, r"scheduling.q: q = 0x4000 is not below p = 0x4000"),
    ({"at_s": 1, "action": "set", "key": "scheduling.q", "value": "high"}, r'scheduling.q: "high" is a string'),
])  # fmt: skip
def test_an_event_without_sense_is_refused(event: dict[str, Any], message: str) -> None:
    import re

    assert re.search(message, refused([event])), refused([event])


def test_an_error_in_a_file_says_where() -> None:
    toml = '[machine]\ndsps = 2\n\n[[events]]\nat_s = 0.1\naction = "fail"\ndsp = 2\n'
    assert refused(toml).startswith("dock.toml:4:")
    assert refused('[[events]]\nat_s = 0.1\naction = "fail"\ndsp = "two"\n').startswith("dock.toml:4:7: events.dsp:")


def test_pulling_a_board_twice_is_refused() -> None:
    twice = [{"at_s": at, "action": "unplug", "dsp": 1} for at in (1, 2)]
    assert "slot 1 is empty; plug a board in first" in refused(twice)


def test_a_later_change_is_checked_with_the_earlier_ones() -> None:
    raise_p = {"at_s": 1, "action": "set", "key": "scheduling.p", "value": 0x5000}
    raise_q = {"at_s": 2, "action": "set", "key": "scheduling.q", "value": 0x2400}
    cmrc.config(events=[raise_p, raise_q])
    lower_p = {"at_s": 3, "action": "set", "key": "scheduling.p", "value": 0x2400}
    assert "q = 0x2400 is not below p = 0x2400" in refused([raise_p, raise_q, lower_p])


def test_the_past_cannot_be_changed() -> None:
    simulation = cmrc.Simulation(cmrc.config(settings={"duration_s": 0.1}))
    simulation.run_until(0.05)
    with pytest.raises(cmrc.ConfigError, match=r"0.04 s has passed; the run is at 0.05 s"):
        simulation.at({"at_s": 0.04, "action": "fail", "dsp": 0})
    with pytest.raises(cmrc.ConfigError, match=r"0.1 s is not within the run; it ends at 0.1 s"):
        simulation.at({"at_s": 0.1, "action": "fail", "dsp": 0})
    simulation.run()
    with pytest.raises(cmrc.ConfigError, match=r"not within the run"):
        simulation.at({"at_s": 0.2, "action": "fail", "dsp": 0})


def test_events_are_part_of_the_configuration_as_toml() -> None:
    events = [
        {"at_s": 0.5, "action": "slow", "dsp": 1, "factor": 0.5},
        {"at_s": 1, "action": "set", "key": "scheduling.equation", "value": "as_printed"},
    ]
    toml = cmrc.config(events=events).to_toml()
    assert cmrc.config(toml=toml).to_toml() == toml
    assert toml.count("[[events]]") == 2


@pytest.mark.parametrize(
    "event",
    [
        {"action": "unplug", "dsp": 0},
        {"action": "fail", "dsp": 1},
        {"action": "slow", "dsp": 0, "factor": 0.001},
        {"action": "pause_host", "lasts_ms": 20.0},
        {"action": "stall_bus", "bus": "A", "lasts_ms": 20.0},
        {"action": "set", "key": "host.per_block_ns", "value": 90000},
        {"action": "set", "key": "scheduling.servo_loss_share", "value": 1.0},
        {"action": "set", "key": "scheduling.p", "value": 0x3000},
    ],
    ids=lambda event: " ".join(str(value) for value in event.values()),
)
def test_in_an_ideal_run_an_event_that_is_added_is_as_one_of_the_configuration(event: dict[str, Any]) -> None:
    """Failures of the machine do not happen there (report.md, Ideal); of DSP 1 neither, which an ideal run has not."""
    settings = {"report.reference": "none", "run.ideal": True, "run.duration_s": 0.06, "machine.dsps": 2}
    event = {"at_s": 0.03, **event}
    given = cmrc.Simulation(cmrc.config(settings=settings, events=[event]))
    given.run()
    added = cmrc.Simulation(cmrc.config(settings=settings))
    added.run_until(0.02)
    added.at(event)
    added.run()
    given_report, added_report = (json.loads(simulation.report_json()) for simulation in (given, added))
    assert added_report["hash"] == given_report["hash"]
    assert added_report["timed_events"] == given_report["timed_events"]
