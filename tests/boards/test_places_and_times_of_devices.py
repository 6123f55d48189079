"""A device of one's own has to be where an access reaches it, and its next event has to be later than the last one."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from board_parts import END, assembled, board
from cmrc.c40 import Processor, assemble
from cmrc.network import Network, NetworkError

ENDLESS = assemble("   .text\nx: addi 1,r0\n   b x\n")
WINDOW = 0xC0000000


class Plain:
    words = 4

    def read(self, offset: int, cycle: int) -> int:
        return 5

    def write(self, offset: int, value: int, cycle: int) -> None:
        pass


class Timer(Plain):
    """It continues to say its last event."""

    pin = "IIOF1"

    def __init__(self, *events: int | None) -> None:
        self.events = events

    def interrupts(self) -> bool:
        return False

    def next_event(self) -> int | None:
        return self.events[0]

    def advance_to(self, cycle: int) -> None:
        self.events = self.events[1:] or self.events


class Acting(Timer):
    pin = None  # type: ignore[assignment]
    acts_on_others = True


@pytest.fixture(autouse=True)
def _in_time() -> Iterator[None]:
    def late(*_: object) -> None:
        raise TimeoutError("run() does not return")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(20)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize("kind", [Timer, Acting])
@pytest.mark.parametrize(("events", "again", "at"), [((100,), 100, 100), ((100, 50), 50, 100), ((7, 9, 9), 9, 9)])
@pytest.mark.parametrize("in_network", [False, True])
def test_an_event_that_has_passed_is_an_error(
    in_network: bool, kind: Any, events: tuple[int, ...], again: int, at: int
) -> None:
    device = kind(*events)
    message = (
        rf"device {kind.__name__} at C0000000h: what next_event\(\) gives: {again}, and advance_to\({at}\) has been "
        "called; a later cycle, or None, is expected"
    )
    if kind is Acting and not in_network:
        processor = Processor(ENDLESS, devices={WINDOW: device})
        with pytest.raises(ValueError, match=message):
            processor.run(1000)
        return
    if in_network:
        network = Network([ENDLESS, ENDLESS], devices={0: {WINDOW: device}})
        with pytest.raises(ValueError, match=message):
            network.run(max_cycles=1000)
    else:
        processor = Processor(ENDLESS, devices={WINDOW: device}, checks=True)
        with pytest.raises(ValueError, match=message):
            processor.run(1000)


def test_events_that_follow_one_another_are_taken() -> None:
    device = Timer(5, 6, 7, None)
    assert Processor(ENDLESS, devices={WINDOW: device}).run(1000).cycle >= 1000
    assert device.events == (None,)


NOWHERE = [0x80000000, 0x2FF800, 0x5, 0x300000]


@pytest.mark.parametrize("base", NOWHERE)
@pytest.mark.parametrize("in_network", [False, True])
def test_a_device_needs_a_window(base: int, in_network: bool) -> None:
    message = (
        f'device Plain at {base:08X}h: a device needs a region of kind "window", and no such region of the board '
        f"default has {base:08X}h to {base + 3:08X}h"
    )
    if in_network:
        with pytest.raises(NetworkError, match=f"chip 1: {message}"):
            Network([ENDLESS, ENDLESS], devices={1: {base: Plain()}})
    else:
        with pytest.raises(ValueError, match=message):
            Processor(devices={base: Plain()})
        with pytest.raises(ValueError, match="needs a region"):
            Processor(devices={base: Plain()}, board="flat")


def test_a_device_lies_in_its_window_with_all_its_words(tmp_path: Path) -> None:
    own = board(tmp_path)
    at = 0xA0000000
    text = Path(own).read_text()
    words = int(text.split('kind = "window"')[1].split("words = ")[1].split()[0], 0)
    Processor(assembled(END), board=own, devices={at + words - 4: Plain()})
    with pytest.raises(ValueError, match='a region of kind "window"'):
        Processor(assembled(END), board=own, devices={at + words - 3: Plain()})
