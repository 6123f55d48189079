"""The run's hash depends on the events in their order of time, and on nothing else."""

import hashlib
import random
import struct
import time

import pytest
from cmrc_test import report

CLAIM, LATCH = 3, 10
DSP0 = 16

Event = tuple[int, int, int, list[int]]


def encoded(event: Event) -> bytes:
    """docs/trace.md: time, component, kind, five arguments, little-endian."""
    at, component, kind, arguments = event
    return struct.pack("<qHH5I", at, component, kind, *(arguments + [0] * (5 - len(arguments))))


def logged(events: list[Event]) -> report.EventLog:
    log = report.EventLog()
    for event in events:
        log.add(*event)
    return log


def some_events(count: int, seed: int) -> list[Event]:
    rng = random.Random(seed)
    return [
        (rng.randrange(1000) * 500, DSP0 + rng.randrange(4), CLAIM, [rng.randrange(1 << 32) for _ in range(5)])
        for _ in range(count)
    ]


def test_hash_is_sha256_of_the_documented_encoding() -> None:
    events = sorted(some_events(10_000, seed=1), key=lambda event: event[:2])
    log = logged(events)
    log.flush()
    assert log.hash() == hashlib.sha256(b"".join(map(encoded, events))).hexdigest()
    assert log.count == 10_000


def test_an_empty_run_has_the_hash_of_nothing() -> None:
    assert report.EventLog().hash() == hashlib.sha256(b"").hexdigest()


def test_order_of_arrival_of_different_components_does_not_matter() -> None:
    events = some_events(9_000, seed=2)
    by_component: dict[int, list[Event]] = {}
    for event in sorted(events, key=lambda event: event[0]):
        by_component.setdefault(event[1], []).append(event)
    hashes = set()
    for turn_order in ([16, 17, 18, 19], [19, 17, 16, 18]):
        log = logged([event for component in turn_order for event in by_component[component]])
        log.flush()
        hashes.add(log.hash())
    assert len(hashes) == 1


def test_settling_in_pieces_gives_the_same_hash() -> None:
    events = sorted(some_events(50_000, seed=3), key=lambda event: event[0])
    whole = logged(events)
    whole.flush()
    pieces = report.EventLog()
    for event in events:
        pieces.add(*event)
        pieces.settle(event[0])
    pieces.flush()
    assert pieces.hash() == whole.hash()


def test_one_changed_argument_changes_the_hash() -> None:
    events = some_events(100, seed=4)
    first = logged(events)
    first.flush()
    events[50][3][2] ^= 1
    second = logged(events)
    second.flush()
    assert first.hash() != second.hash()


def test_an_event_before_what_was_settled_is_refused() -> None:
    log = report.EventLog()
    log.settle(1000)
    log.add(1000, 0, CLAIM)
    with pytest.raises(RuntimeError, match="settled at 1000 ps"):
        log.add(999, 0, CLAIM)


def test_listeners_hear_the_final_order_and_change_nothing() -> None:
    events = some_events(5_000, seed=5)
    silent = logged(events)
    silent.flush()
    log, recorder = report.EventLog(), report.Recorder()
    log.listen(recorder)
    for event in events:
        log.add(*event)
    log.flush()
    assert recorder.lines == [report.event_text(*event) for event in sorted(events, key=lambda event: event[:2])]
    assert log.hash() == silent.hash()


def test_text_of_events() -> None:
    assert (
        report.event_text(125_000_000, DSP0 + 3, CLAIM, [0x50, 6, 0x1000, 8, 2])
        == "0.000125000000 [dsp 3] claim block=0x50 kind=6 area=0x1000 tick=8 generation=2"
    )
    assert (
        report.event_text(3_000_000_000_001, 0xFFFF, LATCH, [0xFFFFFFFF, 2047, 0xFFFFF801, 0, 7])
        == "3.000000000001 [plant] latch s=-1 psi=2047 phi=-2047 l=0 kappa=7"
    )
    assert (
        report.event_text(0, 7, 99, [1]) == "0.000000000000 [component 7] event 99 a0=0x1 a1=0x0 a2=0x0 a3=0x0 a4=0x0"
    )


@pytest.mark.unsanitized
def test_hashing_keeps_up_with_a_run() -> None:
    """300 000 events per simulated second cost less than 1.5 s of the 30 s that 60 simulated seconds may take."""
    events = 1_800_000
    start = time.process_time()
    report.time_hashing(events)
    assert time.process_time() - start < 1.5 * events / 18_000_000 * 3  # three times slower at most on a loaded machine
