"""A second PCI bus, written clock by clock from plant-and-bus.md 3.1: REQ#, GNT#, FRAME#, data phases, STOP#.

It has no events: at every clock each party reads the lines as they were one clock before, and takes one step.
"""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class Job:
    gap: int  # clocks after the end of the master's last transaction
    write: bool
    target: int
    words: int


@dataclass
class Timing:
    devsel: int
    read: tuple[int, int]  # wait states: first, later
    write: tuple[int, int]
    disconnect: int = 0


@dataclass
class Board:
    rule: str  # round_robin, fixed, two_level, host_fair
    parking: str  # none, last_owner, first
    grant: int
    keep: int  # multi-transaction timer
    timer: list[int]  # by master
    first_level: list[bool]
    max_burst: list[int]
    targets: list[Timing]
    off: int = 2
    host_bridge: bool = True  # master 0 is the host


@dataclass
class Master:
    jobs: list[Job]
    left: int = 0
    asks: int | None = None  # REQ# is asserted from this clock on


@dataclass
class Times:
    """One stay on the bus."""

    master: int
    frame: int
    words: int
    last: int


@dataclass
class Bus:
    board: Board
    masters: list[Master]
    log: list[Times] = field(default_factory=list)
    owner: int = 0
    tenure: int = 0
    ring: list[int] = field(default_factory=list)  # first level, least recently served first; -1: the second level
    second: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        count = len(self.masters)
        host = 0 if self.board.host_bridge else None
        level = [m == host for m in range(count)] if self.board.rule == "host_fair" else self.board.first_level
        high = [m for m in range(count) if level[m]]
        low = [m for m in range(count) if not level[m]]
        self.ring = [*high, -1]
        self.second = low
        # Both rings begin after place 0, as if master 0 had been served last.
        if self.ring[0] == 0:
            self.ring = self.ring[1:] + self.ring[:1]
        if self.second and self.second[0] == 0:
            self.second = self.second[1:] + self.second[:1]

    def asking(self, clock: int) -> list[int]:
        return [m for m, s in enumerate(self.masters) if s.asks is not None and s.asks <= clock]

    def choose(self, clock: int) -> int | None:
        asking = self.asking(clock)
        if not asking:
            return None
        if self.board.keep and self.owner in asking and clock < self.tenure + self.board.keep:
            return self.owner
        if self.board.rule == "fixed":
            return min(asking)
        if self.board.rule == "round_robin":
            return min(asking, key=lambda m: (m - self.owner - 1) % len(self.masters))
        for place in self.ring:
            if place in asking:
                return place
            if place == -1:
                for m in self.second:
                    if m in asking:
                        return m
        raise AssertionError

    def give(self, master: int, clock: int) -> None:
        if master != self.owner or clock >= self.tenure + self.board.keep:
            self.tenure = clock
        self.owner = master
        place = master if master in self.ring else -1
        index = self.ring.index(place)
        self.ring = self.ring[index + 1 :] + self.ring[: index + 1]
        if place == -1:
            index = self.second.index(master)
            self.second = self.second[index + 1 :] + self.second[: index + 1]

    def run(self, clocks: int) -> list[Times]:
        for m in self.masters:
            if m.jobs:
                m.left, m.asks = m.jobs[0].words, m.jobs[0].gap
        frame_at: tuple[int, int] | None = None  # (clock, master): GNT# given
        stay: Times | None = None
        wait = 0  # clocks until the next data phase
        done = 0
        free = 0  # the turnaround has passed
        for clock in range(clocks):
            if stay is None and frame_at is None:
                asking = self.asking(clock)
                if asking:
                    held = {
                        "none": None,
                        "last_owner": self.owner,
                        "first": 0 if self.board.host_bridge else None,
                    }[self.board.parking]
                    just = [m for m in asking if self.masters[m].asks == min(self.masters[a].asks or 0 for a in asking)]
                    if held in just:
                        frame_at = (max(clock, free), held or 0)
                    else:
                        chosen = self.choose(clock)
                        assert chosen is not None
                        frame_at = (max(clock + self.board.grant, free), chosen)
            if frame_at is not None and frame_at[0] == clock:
                number = frame_at[1]
                frame_at = None
                master = self.masters[number]
                job = master.jobs[0]
                timing = self.board.targets[job.target]
                self.give(number, clock)
                master.asks = None
                stay, done = Times(number, clock, 0, 0), 0
                first = timing.write[0] if job.write else timing.read[0]
                wait = (timing.devsel if job.write else max(timing.devsel, 2)) + first
                continue
            if stay is None:
                continue
            wait -= 1
            if wait:
                continue
            # a data phase
            master = self.masters[stay.master]
            job = master.jobs[0]
            timing = self.board.targets[job.target]
            done += 1
            master.left -= 1
            others = [m for m in self.asking(clock - 1) if m != stay.master]
            kept = self.board.keep and clock < self.tenure + self.board.keep
            expired = clock >= stay.frame + self.board.timer[stay.master] and bool(others) and not kept
            stopped = timing.disconnect and done == timing.disconnect
            full = self.board.max_burst[stay.master] and done == self.board.max_burst[stay.master]
            wait = 1 + (timing.write[1] if job.write else timing.read[1])
            if not (master.left == 0 or expired or stopped or full):
                continue
            stay.words, stay.last = done, clock
            self.log.append(stay)
            free = clock + 2
            if master.left == 0:
                master.jobs.pop(0)
                if master.jobs:
                    master.left, master.asks = master.jobs[0].words, clock + 1 + master.jobs[0].gap
            elif stopped:
                master.asks = free + self.board.off
            else:
                master.asks = (
                    clock if full else clock + 1
                )  # a master that ends its transaction itself, and has more words, keeps REQ#
            stay = None
            winner = self.choose(clock)
            if winner is not None:
                frame_at = (free, winner)
        return self.log
