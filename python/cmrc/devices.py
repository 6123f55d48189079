"""Devices behind windows of a board: classes of your own, and the inputs and outputs of a board file's devices
(docs/boards.md)."""

from __future__ import annotations

import copy
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import pairwise
from typing import Any, Protocol

from cmrc import arguments

PINS = ("IIOF0", "IIOF1", "IIOF2", "IIOF3", "NMI")
"""Pins that a device may pull low."""


class Device(Protocol):
    """A device behind a window of a board: a class of your own.

    Optional members: ``waits``, the wait cycles of each access. ``pin``, one of ``PINS``, with ``interrupts() ->
    bool``, called after each access: whether the device pulls the pin low. ``next_event() -> int | None``, the next
    cycle in which the pin could change by itself, and ``advance_to(cycle)``, which executes this change. ``save() ->
    bytes`` and ``load(bytes)``: the device's state, for snapshots, forks and debuggers. ``acts_on_others = True``: the
    device is at several chips, or calls its network (``reset``, ``drive`` and the like); its accesses then take place
    in the order of the whole network. ``join(network)`` gives it the network, and in a fork its copy the fork. A
    device's behaviour must depend only on its calls: then every run is the same.
    """

    words: int
    """Number of its words."""

    def read(self, offset: int, cycle: int) -> int:
        """The word for a read. An exception ends the run; the access then still waits."""

    def write(self, offset: int, value: int, cycle: int) -> None:
        """Takes a word."""


_calls = threading.local()  # .device: the device whose method is running


class Attached:
    """A device at its place, as the core calls it: its results are checked, and its exceptions name it."""

    def __init__(self, base: int, device: Device) -> None:
        arguments.whole("devices", base, "a word address", 0, 2**32 - 1)
        self.base, self.device, self.name = base, device, type(device).__name__
        self.where = f"the device {self.name} at {base:X}h"
        for method in ("read", "write"):
            if not callable(getattr(device, method, None)):
                raise TypeError(
                    f"devices: the one at {base:X}h has no {method}(); a device has words, read(offset, cycle) and write(offset, value, cycle)"
                )
        self.words = arguments.whole(
            f"devices: words of the one at {base:X}h",
            getattr(device, "words", None),
            "a number of words",
            1,
            2**32 - base,
        )
        self.waits = arguments.whole(
            f"devices: waits of the one at {base:X}h", getattr(device, "waits", 0), "a number of cycles", 0, 1_000_000
        )
        self.pin = self._pin(getattr(device, "pin", None))
        self.acts_on_others = arguments.flag(
            f"devices: acts_on_others of the one at {base:X}h", getattr(device, "acts_on_others", False)
        )
        self.has_state = all(callable(getattr(device, method, None)) for method in ("save", "load"))

    def _pin(self, pin: object) -> str | None:
        if pin is None:
            return None
        if pin not in PINS:
            raise ValueError(f"devices: pin of the one at {self.base:X}h: {', '.join(PINS)} is expected, not {pin!r}")
        if not callable(getattr(self.device, "interrupts", None)):
            raise TypeError(
                f"devices: the one at {self.base:X}h has a pin, and no interrupts() to say whether it pulls the pin low"
            )
        return str(pin)

    @contextmanager
    def _named(self, what: str) -> Iterator[None]:
        outer, _calls.device = getattr(_calls, "device", None), self
        try:
            yield
        except BaseException as error:
            if callable(note := getattr(error, "add_note", None)):  # Python 3.11
                note(f"in {what} of {self.where}")
            raise
        finally:
            _calls.device = outer

    def join(self, network: object) -> None:
        if callable(join := getattr(self.device, "join", None)):
            with self._named("join()"):
                join(network)

    def read(self, offset: int, cycle: int) -> int:
        with self._named(f"read({offset}, cycle {cycle})"):
            return (
                arguments.whole(
                    "what read() gives", self.device.read(offset, cycle), "a 32-bit word", -(1 << 31), (1 << 32) - 1
                )
                & 0xFFFF_FFFF
            )

    def write(self, offset: int, value: int, cycle: int) -> None:
        with self._named(f"write({offset}, {value:X}h, cycle {cycle})"):
            self.device.write(offset, value, cycle)

    def advance_to(self, cycle: int) -> None:
        if callable(advance := getattr(self.device, "advance_to", None)):
            with self._named(f"advance_to({cycle})"):
                advance(cycle)

    def next_event(self) -> int | None:
        if not callable(ask := getattr(self.device, "next_event", None)):
            return None
        with self._named("next_event()"):
            found = ask()
            return (
                None
                if found is None
                else arguments.whole("what next_event() gives", found, "a cycle, or None,", 0, 2**62)
            )

    def interrupts(self) -> bool:
        if self.pin is None:
            return False
        with self._named("interrupts()"):
            return bool(self.device.interrupts())  # type: ignore[attr-defined]

    def save(self) -> bytes:
        with self._named("save()"):
            return arguments.instance("what save() gives", self.device.save(), bytes, "the device's state as bytes")  # type: ignore[attr-defined]

    def load(self, state: bytes) -> None:
        with self._named("load()"):
            self.device.load(state)  # type: ignore[attr-defined]


def attached(devices: Mapping[int, Device] | None) -> list[Attached]:
    """Devices at their places. Raises TypeError and ValueError for an object that is not a device, and for two at one
    address."""
    if not isinstance(devices, Mapping | None):
        arguments.refuse("devices", devices, "a dictionary of addresses and devices")
    places = sorted((Attached(base, device) for base, device in (devices or {}).items()), key=lambda place: place.base)
    for one, other in pairwise(places):
        if one.base + one.words > other.base:
            raise ValueError(f"devices: those at {one.base:X}h and {other.base:X}h overlap")
    return places


def copied(places: Sequence[Attached], made: dict[int, Any] | None = None) -> dict[int, Device]:
    """Copies of devices for a fork. ``made``: the memo of copies for other chips' devices, so that shared objects are
    copied once."""
    made = {} if made is None else made
    return {place.base: copy.deepcopy(place.device, made) for place in places}


def refuse_call_that_acts(call: str) -> None:
    """Raises RuntimeError for a call from inside a device that does not declare that it acts on others."""
    device = getattr(_calls, "device", None)
    if device is not None and not device.acts_on_others:
        raise RuntimeError(
            f"{call}() from inside {device.where}: that is possible for a device with acts_on_others = True (docs/boards.md)"
        )


class OneRun:
    """An object that runs devices: while it runs, a device may not run, save or load it."""

    _runs = False

    def _refuse_inside(self, call: str) -> None:
        if self._runs:
            raise RuntimeError(f"{call}() from inside a device; it is possible when the run is over")

    @contextmanager
    def _run(self, call: str) -> Iterator[None]:
        self._refuse_inside(call)
        self._runs = True
        try:
            yield
        finally:
            self._runs = False


class Front:
    """The inputs and outputs of a chip's devices."""

    _core: Any

    def type(self, text: str | bytes) -> None:
        """Characters for the console of the board file, after those that wait."""
        if isinstance(text, str):
            try:
                text = text.encode("latin-1")
            except UnicodeEncodeError:
                raise ValueError(
                    f"text: {arguments.shown(text)} cannot be used; text of one-byte characters (Latin-1), or bytes, is expected"
                ) from None
        self._core.type(bytes(arguments.instance("text", text, bytes, "text or bytes")))

    @property
    def console(self) -> bytes:
        """The output of the board file's consoles."""
        return bytes(self._core.console)

    @property
    def led_changes(self) -> list[tuple[str, int, int]]:
        """(name, cycle, value) of the first thousand changes of the board file's LEDs."""
        return list(self._core.led_changes)

    @property
    def led_change_count(self) -> int:
        """How many changes of LEDs there were."""
        return int(self._core.led_change_count)

    @property
    def not_modelled(self) -> list[tuple[str, int, str]]:
        """Functions of the board file's devices that the program has requested and that are not modelled: name of the
        device, cycle of the first request, function."""
        return list(self._core.not_modelled)

    def send(self, name: str, words: Sequence[int]) -> None:
        """Words from a FIFO or mailbox of the board file to the program, after those that wait. Raises ValueError for
        an unknown name, with the known ones."""
        given = [
            arguments.whole(f"words[{n}]", word, "a 32-bit word")
            for n, word in enumerate(arguments.items("words", words, "a list of words"))
        ]
        self._core.send(arguments.text("name", name, "the name of a device"), given)

    def send_script(self, name: str, script: str) -> None:
        """The same by a host script (docs/boards.md, Host scripts). Raises ValueError, with the line, for a text that
        is not a script."""
        self._core.send_script(
            arguments.text("name", name, "the name of a device"), arguments.text("script", script, "a host script")
        )

    def sent(self, name: str) -> list[int]:
        """Words that a FIFO, mailbox or console has sent. Raises ValueError for an unknown name, with the known
        ones."""
        return list(self._core.sent(arguments.text("name", name, "the name of a device")))


__all__ = ["PINS", "Device", "Front"]
