"""A model of the DMA's channels, made from c40-hardware.md 3 and docs/fidelity.md alone: unified mode, on-chip memory,
timers as events. One call of `cycle` for each cycle, in the order that fidelity.md gives: what the DMA begins in the
cycle before, the timers' events, the processor's write."""

from __future__ import annotations

from dataclasses import dataclass, field

WORD = 0xFFFFFFFF
READ, WRITE = 0, 1
ENDLESS, TO_THE_COUNT, LISTS, LISTS_ON_RESTART = range(4)
"""TRANSFER MODE"""
RESET, HALT_AT_ONCE, HALT_AT_END, RUN = 0, 1, 2, 3
"""START"""
TCC, TCINT, FIXED_ORDER = 1 << 18, 1 << 20, 1 << 30
BIT_REVERSED = 0x3000
WRITABLE = 0x43FFFFFF
CONTROL, SOURCE, SOURCE_INDEX, COUNTER, DESTINATION, DESTINATION_INDEX, LINK = range(7)
REGISTERS = ("control", "source", "source_index", "counter", "destination", "destination_index", "link")
CHANNELS = 6


def backwards(word: int) -> int:
    """Also in tests/spec/addressing.py: what is compared with one oracle asks no other one."""
    return int(f"{word:032b}"[::-1], 2)


def stepped(address: int, index: int, bit_reversed: bool) -> int:
    if bit_reversed:
        return backwards((backwards(address) + backwards(index)) & WORD)
    return (address + index) & WORD


@dataclass
class Timer:
    """Started once, at cycle `start`: every 2 `period` cycles an event, in clock mode every second time, from the first
    on (c40-hardware.md 4)."""

    start: int
    period: int
    clock_mode: bool

    def event(self, cycle: int) -> bool:
        halves, rest = divmod(cycle - self.start, 2 * self.period)
        return rest == 0 and halves > 0 and (not self.clock_mode or halves % 2 == 1)


@dataclass
class Channel:
    number: int
    registers: list[int] = field(default_factory=lambda: [0] * 7)
    word: int | None = None
    """read, and not yet written"""
    list_at: int | None = None
    """where the next word of a list is read; None: no list is read"""
    list_words: list[int] = field(default_factory=list)
    latched: list[bool] = field(default_factory=lambda: [False, False])
    started: int = -1
    """the cycle of the write that let it go; the first access comes a cycle later"""

    def bits(self, low: int, width: int = 1) -> int:
        return self.registers[CONTROL] >> low & (1 << width) - 1

    @property
    def start(self) -> int:
        return self.bits(22, 2)

    @property
    def mode(self) -> int:
        return self.bits(2, 2)

    def stop(self) -> None:
        self.registers[CONTROL] = self.registers[CONTROL] & ~(3 << 22) | HALT_AT_END << 22

    def begin_list(self) -> None:
        self.list_at, self.list_words = self.registers[LINK], []

    def wants(self) -> str | None:
        """The access that the channel could begin now."""
        if self.list_at is not None:
            return "list" if self.start == RUN else None
        if self.word is not None:
            ready = self.start in (RUN, HALT_AT_END) and (not self.bits(7) or self.latched[WRITE])
            return "write" if ready else None
        return "read" if self.start == RUN and (not self.bits(6) or self.latched[READ]) else None

    def status(self) -> int:
        if self.start == RUN:
            return 3
        if self.start == RESET or self.word is None:
            return 0
        return 3 if self.start == HALT_AT_END else 1


class Dma:
    def __init__(self, memory: dict[int, int]) -> None:
        self.memory = memory
        self.channels = [Channel(n) for n in range(CHANNELS)]
        self.timers: dict[int, Timer] = {}
        self.die = self.iif = 0
        self.last = CHANNELS - 1
        self._transfer: Channel | None = None  # between a read and its write
        self._free = 0  # the first cycle without an access that is under way

    def selects_timer(self, channel: int, access: int, timer: int) -> bool:
        """Codes of DIE: two bits for channels 0 and 1, three for the others."""
        if channel < 2:
            return self.die >> (4 * channel + 2 * access) & 3 == 3 and timer == 0
        return self.die >> (8 + 6 * (channel - 2) + 3 * access) & 7 == 6 + timer

    def cycle(self, cycle: int, register: int | None = None, value: int = 0, channel: int | None = None) -> None:
        """`register`: what the processor writes in this cycle, of a channel or (None) DIE."""
        self.begin(cycle - 1)
        for number, timer in self.timers.items():
            if timer.event(cycle):
                self._event(number)
        if channel is not None:
            assert register is not None
            self._write_register(cycle, self.channels[channel], register, value)
        elif register is not None:
            self.die = value

    def _event(self, timer: int) -> None:
        taken = False
        for channel in self.channels:
            for access in (READ, WRITE):
                if channel.start != RESET and self.selects_timer(channel.number, access, timer):
                    channel.latched[access] = taken = True
        if not taken:
            self.iif |= (1 << 24, 1 << 31)[timer]

    def _write_register(self, cycle: int, channel: Channel, register: int, value: int) -> None:
        if register != CONTROL:
            channel.registers[register] = value
            return
        before, could = channel.start, channel.wants()
        channel.registers[CONTROL] = value & WRITABLE
        if channel.start == RESET:
            self._reset(channel)
        if channel.start == RUN and before != RUN:
            channel.started = cycle
            waits = channel.list_at is None and channel.word is None
            if waits and channel.registers[COUNTER] == 0 and channel.mode >= LISTS:
                channel.begin_list()
        if could is None and channel.wants() is not None:
            channel.started = cycle

    @staticmethod
    def _reset(channel: Channel) -> None:
        channel.word = channel.list_at = None
        channel.latched = [False, False]
        channel.registers[COUNTER] = 0

    def begin(self, cycle: int) -> None:
        """At most one access."""
        if cycle < self._free:
            return
        within, self._transfer = self._transfer, None
        if within is not None and within.wants() == "write":
            self._write(within)
            return
        fixed = self.channels[0].registers[CONTROL] & FIXED_ORDER
        first = 0 if fixed else self.last + 1
        for channel in (self.channels[(first + n) % CHANNELS] for n in range(CHANNELS)):
            access = channel.wants() if cycle > channel.started else None
            if access is None:
                continue
            if access == "write":
                self._write(channel)
            elif access == "read":
                self._read(channel)
            else:
                self._free = cycle + 2
                self._read_list(channel)
            return

    def _read(self, channel: Channel) -> None:
        registers = channel.registers
        if channel.bits(6):
            channel.latched[READ] = False
        channel.word = self.memory[registers[SOURCE]]
        registers[SOURCE] = stepped(registers[SOURCE], registers[SOURCE_INDEX], bool(channel.bits(12)))
        registers[COUNTER] = (registers[COUNTER] - 1) & WORD
        self.last, self._transfer = channel.number, channel

    def _write(self, channel: Channel) -> None:
        registers = channel.registers
        if channel.bits(7):
            channel.latched[WRITE] = False
        assert channel.word is not None
        self.memory[registers[DESTINATION]] = channel.word
        channel.word = None
        registers[DESTINATION] = stepped(registers[DESTINATION], registers[DESTINATION_INDEX], bool(channel.bits(13)))
        self.last = channel.number
        if registers[COUNTER] == 0:
            self._end_block(channel)

    def _end_block(self, channel: Channel) -> None:
        channel.registers[CONTROL] |= TCINT
        if channel.registers[CONTROL] & TCC:
            self.iif |= 1 << (25 + channel.number)
        if channel.mode == LISTS:
            channel.begin_list()
        elif channel.mode != ENDLESS:
            channel.stop()

    def _read_list(self, channel: Channel) -> None:
        assert channel.list_at is not None
        channel.list_words.append(self.memory[channel.list_at])
        channel.list_at += 1
        self.last = channel.number
        if len(channel.list_words) < 7:
            return
        channel.list_at = None
        channel.registers = [channel.list_words[0] & WRITABLE, *channel.list_words[1:]]
        if channel.start == RESET:
            self._reset(channel)
        elif channel.start == RUN and channel.registers[COUNTER] == 0 and channel.mode >= LISTS:
            channel.begin_list()
