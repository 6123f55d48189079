"""Chips connected by their communication ports, as one machine: ``Network``."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Mapping, Sequence
from typing import Any, overload

from cmrc import _core, arguments, snapshots
from cmrc.chip_state import AccessesToNothing, ChipState
from cmrc.debug import Debugger
from cmrc.devices import Attached, Device, Front, OneRun, attached, copied, refuse_call_that_acts
from cmrc.network import description
from cmrc.network.records import Event, Link, Net, NetworkStop, PeripheralEvent, SharedMemory, Traffic
from cmrc.one_state import OneState
from cmrc.programs import Path, Program
from cmrc.snapshots import ChipSnapshot

MOST_CYCLES = 10**13
"""The longest run: a network's time is counted in 64 bits of picoseconds."""


class Chip(ChipState, AccessesToNothing, Front):
    """One chip of a network: its visible state, its status, and its board's devices."""

    def __init__(self, core: Any, program: Program, number: int) -> None:
        super().__init__(core, program)
        self.number = number

    @property
    def name(self) -> str:
        """Its name, or its number as text."""
        return str(self._core.name)

    @property
    def status(self) -> str:
        """``running``, ``waiting`` (for a port or a shared memory), ``looping`` (it repeats a loop that nothing ends),
        ``sleeping`` (a port can wake it), ``halt``, ``idle``, ``until``, ``fault``, ``external_access``, ``held`` or
        ``pulled_out``."""
        return str(self._core.status)

    @property
    def message(self) -> str:
        """The status as a sentence: where the chip is, and for what it waits since when."""
        return str(self._core.message)

    @property
    def waits_for(self) -> int | None:
        """The chip at the other end of the link for which this one waits."""
        number = self._core.waits_for
        return None if number is None else int(number)


class Network(OneRun, OneState):
    """Up to 64 chips. ``programs`` is one for all chips of a ``topology``, or one for each; sources, COFF files or
    assembled programs.

    ``topology`` is ``ring:4``, ``line:4``, ``grid:4x4``, ``torus:4x4``, ``hypercube:16``; ``links`` are further ones,
    ``"0.3:1.0"`` for port 3 of chip 0 and port 0 of chip 1, or (that, {"word_cycles": 5, ...}). ``nets`` connect pins,
    ``"0.TCLK0>1.IIOF1"`` or ``"index: >1.IIOF2"`` (docs/networks.md, Pins). ``boards``, ``clocks_mhz`` (CLKIN) and
    ``names`` are one for all chips or one for each. ``until`` is the address at which a chip has ended. Chips in
    ``boots`` start in the boot ROM and take their program from the first port that gives one; their ``programs`` only
    describe the expected program. ``devices`` are classes of your own behind windows: for a chip's number a dictionary
    of addresses and devices (``cmrc.devices.Device``). Every other chip starts with its number in R0 and the number of
    chips in R1. ``turn_order`` shuffles which chip the emulator advances first, and changes nothing. ``record_words``
    keeps every word and token, and every edge of a net, in ``events``; ``record_peripherals`` keeps the events of the
    chips' ports, DMA, timers and interrupts. Raises NetworkError.
    """

    chips: list[Chip]

    def __init__(
        self,
        programs: Program | Path | Sequence[Program | Path],
        *,
        links: Sequence[str | tuple[str, Mapping[str, int]]] = (),
        topology: str | None = None,
        boards: str | Sequence[str] = "default",
        clocks_mhz: float | Sequence[float] | None = None,
        names: Sequence[str] = (),
        until: int | str | None = None,
        boots: Sequence[int] = (),
        memories: Sequence[SharedMemory] = (),
        nets: Sequence[str] = (),
        devices: Mapping[int, Mapping[int, Device]] | None = None,
        turn_order: int = 0,
        record_words: bool = False,
        record_peripherals: bool = False,
    ) -> None:
        images = description.programs(programs, topology)
        chips = description.chips(images, boards, clocks_mhz, names, until, boots)
        wires = description.each("links", links, "a list of links", description.link)
        shared = description.each("memories", memories, "a list of SharedMemory", description.shared_memory)
        joined = description.each("nets", nets, "a list of nets", description.net)
        order = arguments.whole("turn_order", turn_order, "a seed", 0, 2**64 - 1)
        own = description.devices(devices, len(images))

        def make() -> tuple[Any, list[list[Attached]]]:
            nonlocal own
            for n, chip in enumerate(chips):
                chip["devices"] = own[n]
            core = _core.network.Network(chips, wires, topology, shared, joined, order)
            its, met = own, dict[int, Any]()
            own = [
                attached(copied(places, met)) for places in own
            ]  # devices of a fork, made before they know this network
            return core, its

        self._take(make, record_words, record_peripherals)

    @classmethod
    def from_file(
        cls, path: Path, *, turn_order: int = 0, record_words: bool = False, record_peripherals: bool = False
    ) -> Network:
        """A network from a TOML file (docs/networks.md, Files), the same as for ``emulator exec --network``. Raises
        NetworkError, with file and line."""
        network = cls.__new__(cls)
        file, order = (
            arguments.path("path", path, "the path of a network file"),
            arguments.whole("turn_order", turn_order, "a seed", 0, 2**64 - 1),
        )
        network._take(
            lambda: (_core.network.Network(file, description.program, order), []), record_words, record_peripherals
        )
        return network

    def _take(
        self, make: Callable[[], tuple[Any, list[list[Attached]]]], record_words: bool, record_peripherals: bool
    ) -> None:
        self._made = make, record_words, record_peripherals  # for fork
        self._core, self._devices = make()  # the core refers to the devices weakly
        core = self._core
        core.record_words(arguments.flag("record_words", record_words))
        core.record_peripherals(arguments.flag("record_peripherals", record_peripherals))
        self.chips = [Chip(core.chip(n), core.program(n), n) for n in range(core.chip_count)]
        for places in self._devices:
            for place in places:
                place.join(weakref.proxy(self))

    def run(self, *, until_us: float | None = None, max_cycles: int = 100_000_000) -> NetworkStop:
        """Executes everything before an instant (from the start of the network, in microseconds), or before
        ``max_cycles`` of chip 0, also from the start. Holds the GIL: other threads wait, so a long run beside them is
        one of many short ones. Raises ValueError for an instant in the past."""
        if until_us is None:
            limit = (
                arguments.whole("max_cycles", max_cycles, f"a number of cycles, 0 to {MOST_CYCLES},", 0, MOST_CYCLES)
                * 10**12
                // round(self._core.chip(0).hertz)
            )
            if limit < self.now_ps:
                raise ValueError(
                    f"max_cycles: {max_cycles} cycles of chip 0 have passed, the network is at {self.now_ps / 1e6} us; a later instant is expected"
                )
        else:
            limit = description.instant("until_us", until_us)
            if limit < self.now_ps:
                raise ValueError(
                    f"until_us: {until_us} us has passed, the network is at {self.now_ps / 1e6} us; a later instant is expected"
                )
        with self._run("run"):
            reason, time = self._core.run_until(limit)
        return NetworkStop(reason, time)

    @property
    def now_ps(self) -> int:
        """The present time of the network."""
        return int(self._core.now)

    @property
    def links(self) -> list[Link]:
        """The links with their present counts, those of a topology first."""
        out = []
        for n in range(self._core.link_count):
            link = self._core.link(n)
            out.append(
                Link(
                    link["a"],
                    link["b"],
                    link["cut"],
                    link["token_lost"],
                    Traffic(**link["forth"]),
                    Traffic(**link["back"]),
                )
            )
        return out

    @property
    def nets(self) -> list[Net]:
        """The nets with their present levels."""
        return [Net(**self._core.net(n)) for n in range(self._core.net_count)]

    @property
    def events(self) -> list[Event]:
        """Losses, cuts and actions on chips; with ``record_words`` also every word and token. In the order of time."""
        return [Event(**event) for event in self._core.events()]

    @property
    def peripheral_events(self) -> list[PeripheralEvent]:
        """With ``record_peripherals``: the events of all chips' peripherals, in the order of time, then of chips."""
        return [PeripheralEvent(**event) for event in self._core.peripheral_events()]

    @property
    def event_trace(self) -> list[str]:
        """``events`` and ``peripheral_events`` as lines, in the order of time: the text that ``emulator exec --events``
        writes."""
        return list(self._core.event_trace())

    def memory(self, number: int) -> list[int]:
        """The words of a shared memory."""
        return list(self._core.memory_words(self._memory(number)))

    def write_memory(self, number: int, at: int, words: Sequence[int]) -> None:
        """Writes words of a shared memory from word ``at`` on. Raises IndexError."""
        content = [
            arguments.whole(f"words[{n}]", word, "a 32-bit word")
            for n, word in enumerate(arguments.items("words", words, "a list of words"))
        ]
        self._core.set_memory_words(self._memory(number), arguments.whole("at", at, "the number of a word"), content)

    def _memory(self, number: object) -> int:
        found = arguments.whole("number", number, "the number of a shared memory", -(2**31), 2**31 - 1)
        if not 0 <= found < self._core.memory_count:
            raise IndexError(f"number: there is no shared memory {found}; the network has {self._core.memory_count}")
        return found

    def cut(self, link: int, at_us: float) -> None:
        """Cuts a link: a word under way is lost, and no word passes until ``restore``. Raises NetworkError for a time
        in the past."""
        self._schedule("cut", link, at_us)

    @overload
    def restore(self, link: int, at_us: float) -> None: ...
    @overload
    def restore(self, link: ChipSnapshot) -> None: ...
    def restore(self, link: int | ChipSnapshot, at_us: float | None = None) -> None:
        """Connects a link again at an instant; or, given a snapshot, goes back to it.

        The snapshot must be of a network with the same chips, programs, boards, clocks, links and memories; from there
        this network continues bit for bit, whatever the order of turns. Raises SnapshotError for any other snapshot,
        before anything is changed.
        """
        if at_us is not None:
            self._schedule("restore", link, at_us)
        else:
            self._refuse_inside("restore")
            self._core.load(snapshots.sealed(link))

    def debug(self) -> Debugger:
        """A debugger over all chips, forwards and backwards from here on (docs/debugger.md)."""
        self._refuse_inside("debug")
        return Debugger(self._core.debug(), self)

    def snapshot(self) -> ChipSnapshot:
        """The whole state: chips, words on the links, shared memories, future actions, and the events so far."""
        self._refuse_inside("snapshot")
        return ChipSnapshot(self._core.save())

    def fork(self) -> Network:
        """A second network with the same past. Later changes of one do not affect the other.

        A network from a file reads the file again; SnapshotError if it or a program has changed since.
        """
        other = type(self).__new__(type(self))
        other._take(*self._made)
        other.restore(self.snapshot())
        return other

    def reset(self, chip: int, at_us: float) -> None:
        """Resets a chip: it starts at its entry, memory stays, the contents of its ports are discarded."""
        self._schedule("reset", chip, at_us)

    def hold(self, chip: int, at_us: float) -> None:
        """Freezes a chip until ``release``: processor, DMA and timers do nothing, and it keeps its locks."""
        self._schedule("hold", chip, at_us)

    def release(self, chip: int, at_us: float) -> None:
        """Lets a held chip continue."""
        self._schedule("release", chip, at_us)

    def pull_out(self, chip: int, at_us: float) -> None:
        """Holds a chip permanently and cuts its links."""
        self._schedule("pull_out", chip, at_us)

    def drive(self, net: int | str, level: bool | None, at_us: float) -> None:
        """Drives a net high (True) or low (False) from an instant on, or (None) stops driving it. Raises NetworkError
        for a net that a chip drives, unless it is open-drain."""
        refuse_call_that_acts("drive")
        kind = "open" if level is None else "high" if arguments.flag("level", level) else "low"
        self._core.schedule(kind, description.instant("at_us", at_us), self._net(net))

    def pulse(
        self, net: int | str, at_us: float, *, width_us: float, period_us: float | None = None, count: int | None = None
    ) -> None:
        """Makes a net leave its level at rest for ``width_us``; with ``period_us`` repeatedly, or ``count`` times."""
        refuse_call_that_acts("pulse")
        width = arguments.number("width_us", width_us, "a duration in us", 0.0)
        period = None if period_us is None else arguments.number("period_us", period_us, "a duration in us", 0.0)
        pulses = None if count is None else arguments.whole("count", count, "a number of pulses", 1, 2**63 - 1)
        self._core.schedule_pulses(description.instant("at_us", at_us), self._net(net), width, period, pulses)

    def _net(self, net: object) -> int:
        return (
            int(self._core.net_named(net))
            if isinstance(net, str)
            else arguments.whole("net", net, "the name or number of a net", 0, 2**31 - 1)
        )

    def _schedule(self, kind: str, target: object, at_us: float) -> None:
        refuse_call_that_acts(kind)
        what = "link" if kind in ("cut", "restore") else "chip"
        self._core.schedule(
            kind, description.instant("at_us", at_us), arguments.whole(what, target, f"the number of a {what}")
        )
