"""Every scripted action: its numbers, and the effect of the dock's actions on the dock."""

import re
from collections.abc import Callable

import pytest
from cmrc._core import plant
from cmrc_test import machine
from programs import MS, US, assemble, config

Action = machine.Action
DSPS, SLOTS = 2, 3

# What an action's number counts, and how many of them this machine and its dock have.
TARGETS: dict[str, tuple[str, int]] = {
    **dict.fromkeys(("fail", "freeze", "hang", "unplug", "plug", "reset", "link", "pace"), ("slot", SLOTS)),
    "pause_host": ("host", 1),
    "stall_bus": ("bus", 2),
    **dict.fromkeys(("drive", "encoder", "drive_status", "drive_speed"), ("joint", 5)),
    **dict.fromkeys(("sway", "second_sway"), ("axis", 2)),
    "load_cell": ("load cell", 1),
    "anemometer": ("anemometer", 1),
}
AMOUNTS = {"pace": 500_000, "pause_host": 7 * US, "stall_bus": 7 * US, "link": 1}


def at_work(dock: plant.Dock | None = None) -> machine.Machine:
    setup = config(dsps=DSPS, slots=SLOTS)
    host = [(US, 0, [1, 2, 3], 0)]
    m = machine.Machine(assemble("again: sti r0, *ar0\n        b again\n"), setup, dock=dock, host=host, record=True)
    m.run_until(100 * US)
    return m


def dock_at_work() -> plant.Dock:
    """Its drives turn, its sensors show something else each time."""
    layout = plant.default_dock()
    sensors = layout.sensors
    sensors.second_sway = True
    layout.sensors = sensors
    wind = layout.wind
    wind.mean = 8.0
    layout.wind = wind
    return plant.Dock(layout)


def test_the_table_has_every_action_and_no_word_twice() -> None:
    rows = machine.scripted_actions()
    assert {action for action, _, _ in rows} == set(Action.__members__.values()) and len(rows) == len(TARGETS) == 18
    words = [word for _, *both in rows for word in both if word]
    assert len(words) == len(set(words)) == 27
    assert set(TARGETS) == set(Action.__members__)


@pytest.mark.parametrize("name", TARGETS)
def test_an_action_takes_each_of_its_numbers_and_none_beyond(name: str) -> None:
    what, count = TARGETS[name]
    amounts = {AMOUNTS[name]} if name in ("pace", "pause_host", "stall_bus") else {0, 1}
    for number in range(count):
        for amount in amounts:
            m = at_work(dock_at_work())
            m.act(Action.__members__[name], number, amount)
            m.run_until(MS)
            assert m.audit() == []
    m = at_work()
    said = f"for {what} {count}; the time is 100000000 ps, and the last {what} is {count - 1}"
    with pytest.raises(ValueError, match=re.escape(said)):
        m.act(Action.__members__[name], count, AMOUNTS.get(name, 0))
    with pytest.raises(ValueError, match="a scripted event with amount -1; it is not negative, and a clock runs"):
        m.act(Action.__members__[name], 0, -1)
    setup = config(dsps=DSPS, slots=SLOTS)
    setup.script(50 * US, Action.__members__[name], count, AMOUNTS.get(name, 0))
    with pytest.raises(ValueError, match=re.escape(f"at 50000000 ps for {what} {count}; the time is 0 ps")):
        machine.Machine(assemble(""), setup)


def test_a_clock_has_to_run() -> None:
    with pytest.raises(ValueError, match="amount 0; it is not negative, and a clock runs"):
        at_work().act(Action.pace, 0, 0)


def wrote(m: machine.Machine, slot: int, since: int) -> bool:
    return any(what == "write" and values[0] == slot and time > since for time, what, values in m.events)


def test_a_script_may_begin_with_the_run() -> None:
    setup = config(dsps=DSPS, slots=SLOTS)
    setup.script(0, Action.fail, 1, 1)
    m = machine.Machine(
        assemble("again: sti r0, *ar0\n        b again\n"), setup, host=[(US, 0, [1, 2], 0)], record=True
    )
    m.run_until(100 * US)
    assert wrote(m, 0, 50 * US) and not wrote(m, 1, 50 * US)


@pytest.mark.parametrize("action", [Action.reset, Action.unplug])
def test_a_dsp_that_is_reset_or_taken_out_is_not_idle_any_more(action: machine.Action) -> None:
    setup = config(dsps=DSPS, slots=SLOTS)
    setup.script(50 * US, action, 1)
    idles = assemble("        ldi DOORBELL_IDLE - SEMAPHORE, ir0\n        sti r7, *+ar1(ir0)\n")
    m = machine.Machine(idles, setup, host=[(time * US, 0x10101, [], 1) for time in (49, 51)], record=True)
    m.run_until(60 * US)
    assert [words for _, _, words in m.reads] == [[0b11], [0b01]]


# The state of a DSP's board 50 us later; the other boards continue.
SEEN: dict[str, Callable[[machine.Machine, int], bool]] = {
    "fail": lambda m, n: m.standing(n),
    "freeze": lambda m, n: m.standing(n),
    "hang": lambda m, n: m.time > 110 * US and not wrote(m, n, 110 * US),
    "unplug": lambda m, n: not m.plugged(n),
    "reset": lambda m, n: ("slot", [n, 2]) in [(what, values) for _, what, values in m.events],
}


@pytest.mark.parametrize("name", SEEN)
@pytest.mark.parametrize("slot", range(DSPS))
def test_an_action_on_a_dsp_acts_on_that_one(name: str, slot: int) -> None:
    m = at_work()
    assert not SEEN[name](m, slot)
    m.act(Action.__members__[name], slot)
    m.run_until(150 * US)
    assert [SEEN[name](m, n) for n in range(DSPS)] == [n == slot for n in range(DSPS)]


def test_a_board_is_plugged_into_the_empty_slot_and_a_clock_slows() -> None:
    m = at_work()
    m.act(Action.plug, 2)
    m.act(Action.pace, 1, 250_000)
    before = m.cycle(0), m.cycle(1)
    m.run_until(200 * US)
    assert [m.plugged(n) for n in range(SLOTS)] == [True] * 3
    assert (m.cycle(0) - before[0], m.cycle(1) - before[1]) == (pytest.approx(2500, abs=20), pytest.approx(625, abs=20))


@pytest.mark.parametrize("slot", [1, 2])
@pytest.mark.parametrize("when_out", [False, True])
def test_a_board_that_is_plugged_in_has_its_own_clock(slot: int, when_out: bool) -> None:
    """It is not as slow as the board before it; an empty slot has no clock."""
    m = at_work()
    if when_out:
        m.act(Action.unplug, slot)
    m.act(Action.pace, slot, 250_000)
    m.act(Action.unplug, slot)
    m.run_until(120 * US)
    m.act(Action.plug, slot)
    m.run_until(150 * US)  # behind its reset
    before = m.cycle(slot)
    m.run_until(200 * US)
    assert m.cycle(slot) - before == pytest.approx(1250, abs=20)


def test_the_bus_that_stalls_is_the_one_that_was_named() -> None:
    """The DSPs write to bus A without end."""
    for bus, rests in ((0, True), (1, False)):
        m = at_work()
        m.act(Action.stall_bus, bus, 50 * US)
        m.run_until(200 * US)
        framed = [v[7] * 30_000 for _, what, v in m.events if what == "transaction" and v[0] == 0]
        within = [t for t in framed if 105 * US < t < 149 * US]
        assert (len(within) == 0) == rests and any(t > 151 * US for t in framed)


def test_the_host_pauses() -> None:
    for pause, writes in ((0, 20), (500, 0)):
        steps = [((110 + 2 * n) * US, 0x100, [n], 0) for n in range(20)]
        m = machine.Machine(assemble(""), config(dsps=1), host=steps, record=True)
        m.run_until(100 * US)
        m.act(Action.pause_host, 0, pause * US)
        m.run_until(200 * US)
        assert sum(what == "transaction" and v[0] == 0 and v[4] for _, what, v in m.events) == writes


def test_a_host_that_pauses_hears_no_answer_before_the_end() -> None:
    m = machine.Machine(assemble(""), config(dsps=1), host=[(110 * US, 0x100, [], 1)], record=True)
    m.run_until(110 * US + US // 10)  # the read is under way
    m.act(Action.pause_host, 0, 20 * US)
    m.run_until(200 * US)
    assert [answered for _, answered, _ in m.reads] == [130 * US + US // 10]


# Actions on the dock, by its own functions.
FAILS: dict[str, Callable[[plant.Dock, int, bool, int], None]] = {
    "drive": plant.Dock.fail_drive,
    "encoder": plant.Dock.fail_encoder,
    "sway": plant.Dock.fail_sway,
    "second_sway": plant.Dock.fail_second_sway,
    "drive_status": plant.Dock.fail_drive_status,
    "drive_speed": plant.Dock.fail_drive_speed,
    "load_cell": lambda dock, _, failed, t: dock.fail_load_cell(failed, t),
    "anemometer": lambda dock, _, failed, t: dock.fail_anemometer(failed, t),
}


@pytest.mark.parametrize(("name", "number"), [(name, n) for name in FAILS for n in range(TARGETS[name][1])])
def test_an_action_on_the_dock_does_what_its_function_does(name: str, number: int) -> None:
    dock, twin, whole = dock_at_work(), dock_at_work(), dock_at_work()
    m = machine.Machine(assemble(""), config(dsps=1), dock=dock)
    for until, failed in ((10 * MS, True), (20 * MS, False)):
        m.run_until(until)
        m.act(Action.__members__[name], number, int(failed))
        FAILS[name](twin, number, failed, until)
        m.run_until(until + 5 * MS)
        for other in (twin, whole):
            other.advance_to(dock.time)
        assert dock.state_hash() == twin.state_hash()
        assert (dock.state_hash() != whole.state_hash()) or not failed


def test_every_dock_action_was_compared() -> None:
    assert set(FAILS) | {"pause_host", "stall_bus"} == {name for name, (what, _) in TARGETS.items() if what != "slot"}
