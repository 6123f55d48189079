"""A model of the processor's time, made from c40-hardware.md 1.1, 1.4, 6, 7 and 8.2 and docs/fidelity.md (Time) alone.

`TimingModel.execute` is called once for each executed instruction, in program order. The caller says which registers
and addresses the instruction uses and where the program went: the model computes no values.

Left out: DMA, communication ports, windows and devices, IDLE, interface control registers that the program writes, and
the boot ROM.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

Place = str
BLOCK_0, BLOCK_1, PERIPHERALS, LOCAL, GLOBAL = "block 0", "block 1", "peripherals", "local", "global"
ON_CHIP = (BLOCK_0, BLOCK_1)
EXTERNAL = (LOCAL, GLOBAL)
PORTS = 2
"""accesses to a block of RAM in a cycle (7.4)"""
LONG_AGO = -(10**9)
NO_REGISTERS: frozenset[str] = frozenset()


class Flow(Enum):
    """What an instruction does to the fetches behind it (7.2)."""

    STRAIGHT = 0
    """Nothing. A delayed branch is one of these: when the instruction behind its third slot can be fetched at all,
    the branch has been executed."""
    EMPTIES = 1
    """A branch that is not delayed: the next fetch begins a cycle after its E."""
    EMPTIES_AND_PUSHES = 2
    """CALLcond and TRAPcond: a cycle later still, taken or not."""
    INTERRUPT = 3
    """No instruction: the entry of an interrupt."""


@dataclass(frozen=True)
class CacheControl:
    """CC, CE and CF as an instruction leaves them in ST (6)."""

    clear: bool
    enabled: bool
    frozen: bool


@dataclass(frozen=True)
class Region:
    """Memory of the board, and for how many wait states its RDY asks."""

    base: int
    words: int
    bus: Place
    read_waits: int = 0
    write_waits: int = 0
    page_waits: int = 0


@dataclass(frozen=True)
class Executed:
    """An executed instruction. An annulled one has no accesses and no registers, except an LDA in the first slot.

    The registers are those that can make an address: AR0 to AR7, IR0, IR1, BK, DP and SP."""

    address: int
    flow: Flow = Flow.STRAIGHT
    fetched: bool = True
    """False: a repetition of RPTS"""
    addressing: frozenset[str] = NO_REGISTERS
    """of which it makes addresses"""
    operands: frozenset[str] = NO_REGISTERS
    """which it reads as operands"""
    results: frozenset[str] = NO_REGISTERS
    """which it writes in E"""
    early_results: frozenset[str] = NO_REGISTERS
    """which it writes in R: LDA"""
    reads: tuple[int, ...] = ()
    """addresses; of two operands, the one in bits 15 to 8 of the word first. Of an interrupt: its vector"""
    writes: tuple[int, ...] = ()
    """in the same order. Of an interrupt: the place of the return address"""
    cache: CacheControl | None = None
    """if it changes ST so"""


class Stages(NamedTuple):
    """As they are drawn: the first cycle of F (its fetch), D, R (the first of its reads) and E. The cycle that a bus
    needs before an access is not part of it here."""

    fetch: int
    decode: int
    read: int
    execute: int


def place_of(address: int) -> Place:
    """1.1"""
    if 0x100000 <= address < 0x200000:
        return PERIPHERALS
    if 0x2FF800 <= address < 0x300000:
        return BLOCK_0 if address < 0x2FFC00 else BLOCK_1
    return GLOBAL if address >> 31 else LOCAL


class Memory:
    """How many cycles of its bus an access takes (1.4, 8.2)."""

    def __init__(self, regions: Sequence[Region], interfaces: dict[Place, int]) -> None:
        self._regions, self._interfaces = regions, interfaces  # LMICR and GMICR
        self._open_pages: dict[tuple[Place, bool], int] = {}

    def second_strobe(self, address: int) -> bool:
        active = self._interfaces[place_of(address)] >> 24 & 31
        return active < 30 and (address & 0x7FFFFFFF) >= 2 << active

    def inserts_at_switch(self, bus: Place) -> bool:
        """STRB SWITCH"""
        return bool(self._interfaces[bus] >> 29 & 1)

    def cycles(self, address: int, write: bool) -> int:
        """Without the cycle that may lie between two accesses. To be asked once for each access, in program order: the
        access opens its page."""
        place = place_of(address)
        if place not in EXTERNAL:
            return 1
        interface, strobe = self._interfaces[place], self.second_strobe(address)
        region = next(one for one in self._regions if one.base <= address < one.base + one.words)
        ready = region.write_waits if write else region.read_waits
        if self._opens_page(place, strobe, address, interface):
            ready += region.page_waits
        counter = interface >> (11 if strobe else 8) & 7
        sww = interface >> (6 if strobe else 4) & 3
        return (2 if write else 1) + (ready, counter, min(ready, counter), max(ready, counter))[sww]

    def _opens_page(self, bus: Place, strobe: bool, address: int, interface: int) -> bool:
        """A strobe's first access opens one (docs/fidelity.md)."""
        size = interface >> (19 if strobe else 14) & 31
        page = (address & 0x7FFFFFFF) >> size + 1
        before, self._open_pages[bus, strobe] = self._open_pages.get((bus, strobe)), page
        return page != before


class Cache:
    """6: four segments of 32 words; the first in `_order` is the least recently used one."""

    def __init__(self, enabled: bool) -> None:
        self._enabled, self._frozen = enabled, False
        self._start: list[int | None] = [None] * 4
        self._present: list[set[int]] = [set() for _ in range(4)]
        self._order = [0, 1, 2, 3]
        self._controls: list[tuple[int, CacheControl]] = []

    def control(self, cycle: int, control: CacheControl) -> None:
        """Of an instruction whose E is `cycle`: for fetches that can begin in later cycles (docs/fidelity.md)."""
        self._controls.append((cycle, control))

    def hit(self, address: int, cycle: int) -> bool:
        """The fetch of an external word that can begin in `cycle`; a word that is missing is loaded."""
        self._settle(cycle)
        if not self._enabled:
            return False
        start, word = address >> 5, address & 31
        segment = self._start.index(start) if start in self._start else None
        hit = segment is not None and word in self._present[segment]
        if not self._frozen:
            self._load(segment if segment is not None else self._replaced(start), word)
        return hit

    def _settle(self, cycle: int) -> None:
        while self._controls and self._controls[0][0] < cycle:
            control = self._controls.pop(0)[1]
            self._enabled, self._frozen = control.enabled, control.frozen
            if control.clear:
                self._present = [set() for _ in range(4)]

    def _replaced(self, start: int) -> int:
        segment = self._order[0]
        self._present[segment], self._start[segment] = set(), start
        return segment

    def _load(self, segment: int, word: int) -> None:
        self._present[segment].add(word)
        self._order.remove(segment)
        self._order.append(segment)


class Bus:
    """The cycles in which a bus is taken (7.4)."""

    def __init__(self) -> None:
        self._taken: dict[int, bool] = {}  # by cycle: is it a write?
        self._last_read = (LONG_AGO, False)  # of data: its end, its strobe

    def is_free(self, first: int, cycles: int = 1) -> bool:
        return not any(cycle in self._taken for cycle in range(first, first + cycles))

    def take(self, first: int, cycles: int, write: bool) -> int:
        """The end, the first cycle behind it."""
        self._taken.update((cycle, write) for cycle in range(first, first + cycles))
        return first + cycles

    def turn(self, cycle: int) -> int:
        """The cycles by which a read that begins in `cycle` is longer because of a write before it (8.2)."""
        return int(self._taken.get(cycle - 1, False))

    def switch(self, cycle: int, strobe: bool) -> int:
        """The same because the read of data before it was one by the other strobe (8.2: STRB SWITCH)."""
        end, before = self._last_read
        return int(end == cycle and before != strobe)

    def take_read(self, first: int, cycles: int, strobe: bool) -> int:
        end = self.take(first, cycles, write=False)
        self._last_read = end, strobe
        return end


class TimingModel:
    """7.5. Reservations are made in program order, so an access finds those of older instructions and none of younger
    ones. At R and E nothing is reserved behind the first free cycle of a bus; only a fetch has to fit between two
    accesses."""

    def __init__(self, regions: Sequence[Region], interfaces: dict[Place, int], cache_enabled: bool = False) -> None:
        self._memory, self._cache = Memory(regions, interfaces), Cache(cache_enabled)
        self._ports: Counter[tuple[Place, int]] = Counter()
        self._buses = {place: Bus() for place in (PERIPHERALS, *EXTERNAL)}
        self._ready: dict[str, int] = {}
        self._last = Stages(LONG_AGO, LONG_AGO, LONG_AGO, LONG_AGO)  # of these, R is when it was entered
        self._fetch_from = -3
        self.end = 0
        """the cycle in which the next instruction can be executed at the earliest: what the chip has counted"""
        self.stages: list[Stages] = []

    def execute(self, instruction: Executed) -> int:
        """What the chip has counted after the instruction."""
        if instruction.flow is Flow.INTERRUPT:
            return self._enter_interrupt(instruction)
        earliest = max(self._last.fetch + 1, self._last.decode, self._fetch_from)
        fetch, length, turn = self._fetch(instruction, earliest)
        decode = max(fetch + length, self._last.read, *(self._ready.get(x, LONG_AGO) for x in instruction.addressing))
        entered = max(decode + 1, self._last.execute)
        read, done, execute = self._access(instruction, entered)
        if instruction.cache is not None:
            self._cache.control(execute, instruction.cache)
        self._refill(instruction.flow, execute)
        self._last = Stages(fetch, decode, entered, execute)
        self.stages.append(Stages(fetch + turn, decode, read, execute))
        self._make_ready(instruction, decode, done, execute)
        return self.end

    def _enter_interrupt(self, entry: Executed) -> int:
        """5.5, 7.2: 8 cycles and the wait states of its accesses, the push first. The pipeline is empty behind it."""
        push, vector = self._cycles(entry.writes, True), self._cycles(entry.reads, False)
        waits = sum(cycles - 2 for a, cycles in zip(entry.writes, push, strict=True) if place_of(a) in EXTERNAL)
        waits += sum(cycles - 1 for cycles in vector)
        if entry.cache is not None:
            self._cache.control(self.end - 1, entry.cache)
        self.end += 8 + waits
        self._last = Stages(LONG_AGO, LONG_AGO, LONG_AGO, self.end - 1)
        self._fetch_from = self.end - 3
        self.stages.append(self._last)
        return self.end

    def _refill(self, flow: Flow, execute: int) -> None:
        """7.5: f_min is e + 1 behind a branch, e + 2 behind CALLcond and TRAPcond, and three stages follow F."""
        self.end = execute + 1
        if flow is not Flow.STRAIGHT:
            self._fetch_from = execute + flow.value
            self.end = self._fetch_from + 3

    def _make_ready(self, instruction: Executed, decode: int, done: int, execute: int) -> None:
        """7.3, 7.5: from when on registers make addresses. LDA's does when the word has come (docs/fidelity.md)."""
        for registers, cycle in (
            (instruction.operands, decode + 2),
            (instruction.early_results, done),
            (instruction.results, execute + 1),
        ):
            for register in registers:
                self._ready[register] = max(self._ready.get(register, LONG_AGO), cycle)

    # Accesses

    def _cycles(self, addresses: Sequence[int], write: bool) -> list[int]:
        return [self._memory.cycles(address, write) for address in addresses]

    def _fetch(self, instruction: Executed, earliest: int) -> tuple[int, int, int]:
        """The first cycle, how many, and how many of them before the read itself. It fits between the accesses of older
        instructions (7.1: lowest priority)."""
        address, cycle = instruction.address, earliest
        place = place_of(address)
        if not instruction.fetched:
            return cycle, 1, 0
        if place in ON_CHIP:
            while self._ports[place, cycle] >= PORTS:
                cycle += 1
            self._ports[place, cycle] += 1
            return cycle, 1, 0
        if self._cache.hit(address, cycle):
            return cycle, 1, 0
        cycles, bus = self._memory.cycles(address, False), self._buses[place]
        while not bus.is_free(cycle, cycles + bus.turn(cycle)):
            cycle += 1
        turn = bus.turn(cycle)
        bus.take(cycle, cycles + turn, write=False)
        return cycle, cycles + turn, turn

    def _access(self, instruction: Executed, entered: int) -> tuple[int, int, int]:
        """The first cycle of the reads, as drawn, the one in which they are done, and E. Pages are opened in program
        order: those of reads before those of writes, but the push of a TRAPcond before its vector (c40-isa.md 8.6)."""
        writes = instruction.writes
        pushes_first = instruction.flow is Flow.EMPTIES_AND_PUSHES
        pushed = self._cycles(writes, True) if pushes_first else []
        read, done = self._place_reads(instruction.reads, entered)
        written = pushed if pushes_first else self._cycles(writes, True)
        return read, done, self._place_writes(writes, written, done)

    def _place_reads(self, addresses: Sequence[int], entered: int) -> tuple[int, int]:
        """7.5: all begin in the first cycle in which all can; reads of one bus follow each other. Returned are: the
        first cycle of the first one, as drawn, and the cycle in which all are done."""
        cycles = self._cycles(addresses, False)
        on_chip = Counter(place for place in map(place_of, addresses) if place in ON_CHIP)
        buses = [self._buses[place] for place in map(place_of, addresses) if place not in ON_CHIP]
        first = entered
        while not self._have_ports(on_chip, first) or not all(bus.is_free(first) for bus in buses):
            first += 1
        self._ports.update({(place, first): count for place, count in on_chip.items()})
        ends, begun = dict.fromkeys(map(place_of, addresses), first), []
        for address, length in zip(addresses, cycles, strict=True):
            place = place_of(address)
            if place in ON_CHIP:
                ends[place] = first + 1
            else:
                ends[place] = self._read(address, ends[place], length)
            begun.append(ends[place] - length)
        return min(begun, default=first), max([first + 1, *ends.values()])

    def _read(self, address: int, cycle: int, length: int) -> int:
        """A read of data by a bus: its end. The cycle after a write, or between two strobes, makes it longer."""
        place = place_of(address)
        bus = self._buses[place]
        if place == PERIPHERALS:
            return bus.take(cycle, length, write=False)
        strobe = self._memory.second_strobe(address)
        between = bus.turn(cycle) or (self._memory.inserts_at_switch(place) and bus.switch(cycle, strobe))
        return bus.take_read(cycle, length + int(between), strobe)

    def _place_writes(self, addresses: Sequence[int], cycles: Sequence[int], done: int) -> int:
        """E (7.5). A write on a bus begins when its bus is free, the second of two not before the first one; writes on
        the chip begin with the last of them (docs/fidelity.md), when nothing older uses their ports."""
        execute = done
        for address, length in zip(addresses, cycles, strict=True):
            if place_of(address) not in ON_CHIP:
                bus = self._buses[place_of(address)]
                while not bus.is_free(execute):
                    execute += 1
                bus.take(execute, length, write=True)
        self._ports.update((place, execute) for place in map(place_of, addresses) if place in ON_CHIP)
        return execute

    def _have_ports(self, wanted: Counter[Place], cycle: int) -> bool:
        return all(self._ports[place, cycle] + count <= PORTS for place, count in wanted.items())
