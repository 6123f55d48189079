"""Event logs and accounts that are saved under way and loaded into new ones continue as if they had never stopped."""

import random

import pytest
from cmrc_test import report
from leaves import check_that_every_value_is_loaded, check_that_other_bytes_are_refused

CLAIM, DSP0 = 3, 16
KINDS, CAUSES = ["pid", "identify"], ["instructions", "bus_a"]


def events(count: int, rng: random.Random) -> list[tuple[int, int, int, list[int]]]:
    """Events of two chips that run ahead of each other: in order of time for each chip alone."""
    at = [0, 0]
    made_events = []
    for _ in range(count):
        chip = rng.randrange(2)
        at[chip] = max(at[chip], at[1 - chip] - 40_000) + rng.randrange(1000)
        made_events.append((at[chip], DSP0 + chip, CLAIM, [rng.randrange(1 << 32) for _ in range(5)]))
    return made_events


@pytest.mark.parametrize("seed", range(4))
def test_a_log_continues_in_another_one(seed: int) -> None:
    rng = random.Random(seed)
    made_events = events(20_000, rng)
    cuts = set(rng.sample(range(len(made_events)), 12))
    whole, part = report.EventLog(), report.EventLog()
    heard, parts = report.Recorder(), [report.Recorder()]
    whole.listen(heard), part.listen(parts[0])
    newest = 0
    for number, event in enumerate(made_events):
        newest = max(newest, event[0])
        for log in (whole, part):
            log.add(*event)
            if number % 50 == 0:
                log.settle(newest - 50_000)
        if number in cuts:
            state = part._state()
            part = report.EventLog()
            part._load_state(state)
            assert part._state() == state
            parts.append(report.Recorder())
            part.listen(parts[-1])
    whole.flush(), part.flush()
    assert part.hash() == whole.hash() and part.count == whole.count == len(made_events)
    assert [line for one in parts for line in one.lines] == heard.lines  # joined, what the parts heard is the whole
    assert sum(bool(one.lines) for one in parts) > 6


def test_a_logs_state_does_not_depend_on_when_it_settled_or_whose_turn_came_first() -> None:
    made_events = events(9_000, random.Random(7))
    states = set()
    for every, order in (
        (1, made_events),
        (700, made_events),
        (9_000, sorted(made_events, key=lambda event: event[1])),
    ):
        log = report.EventLog()
        for number, event in enumerate(order):
            log.add(*event)
            if number % every == every - 1 and order is made_events:
                log.settle(max(e[0] for e in made_events[: number + 1]) - 50_000 if every > 1 else 0)
        log.settle(max(event[0] for event in made_events) - 50_000)
        states.add(log._state())
    assert len(states) == 1


def test_an_event_before_what_was_settled_is_refused_after_loading_too() -> None:
    log, other = report.EventLog(), report.EventLog()
    log.settle(1000)
    other._load_state(log._state())
    with pytest.raises(RuntimeError, match="after its time was settled"):
        other.add(999, DSP0, CLAIM, [])


def some_log() -> report.EventLog:
    log = report.EventLog()
    for event in events(9, random.Random(1)):
        log.add(*event)
    log.settle(300)
    return log


def test_every_value_of_a_log_is_loaded() -> None:
    # What stands in the block under way is a text: its bytes are no numbers.
    assert check_that_every_value_is_loaded(report.EventLog, some_log()) > 50
    check_that_other_bytes_are_refused(report.EventLog, some_log()._state())


def account() -> report.TaskAccount:
    return report.TaskAccount(KINDS, CAUSES, [1000, 0], samples_max=20)


def job(rng: random.Random, tick: int) -> dict[str, object]:
    released = tick * 1000
    claimed = released + rng.randrange(300)
    finished = claimed + rng.randrange(1, 900)
    on = finished - claimed
    return {
        "kind": rng.randrange(2),
        "progress": rng.choice(["finished", "finished", "running", "waiting", "lost", "dropped"]),
        "released": released,
        "deadline": released + 700,
        "claimed": claimed,
        "finished": finished,
        "now": finished,
        "tick": tick,
        "causes": [on // 3, on - on // 3],
    }


def booked(one: report.TaskAccount, jobs: list[dict[str, object]]) -> report.TaskAccount:
    for each in jobs:
        kind, progress = each["kind"], each["progress"]
        one.add(kind, progress, **{name: value for name, value in each.items() if name not in ("kind", "progress")})
    return one


def figures(one: report.TaskAccount) -> str:
    run = report.RunReport()
    run.set_tasks(one)
    return run.to_json()


@pytest.mark.parametrize("seed", range(6))
def test_an_account_continues_in_another_one(seed: int) -> None:
    rng = random.Random(seed)
    jobs = [job(rng, tick) for tick in range(120)]
    whole, part = booked(account(), jobs), account()
    for number, each in enumerate(jobs):
        booked(part, [each])
        if rng.random() < 0.2:
            state = part._state()
            part = account()
            part._load_state(state)
            assert part._state() == state, number
    assert figures(part) == figures(whole) and part._state_difference(whole) is None


@pytest.mark.parametrize("jobs", [12, 60])  # samples as they are, and in bins
def test_every_value_of_an_account_is_loaded(jobs: int) -> None:
    rng = random.Random(jobs)
    full = booked(account(), [job(rng, tick) for tick in range(jobs)])
    # A map's key of another value may be one that is there.
    assert check_that_every_value_is_loaded(account, full, lambda path: ".newest." in path or ".bins." in path) > 500
    check_that_other_bytes_are_refused(account, full._state())


def test_an_account_of_other_kinds_is_refused() -> None:
    with pytest.raises(ValueError, match="a list of 2 parts instead of 1"):
        report.TaskAccount(["pid"], CAUSES, [1000])._load_state(account()._state())
