"""A second implementation of the scheduling rule, from the event trace alone: equation (7) as plant-and-bus.md 4.3
restores it, the order of the list (ruling 19), refreshes (ruling 20) and claims (ruling 21). It shares no code with the
emulator, and reads only the trace and the parameters of the rule."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

Event = tuple[int, str, str, dict[str, int]]

# kind (KIND_* of task_block.inc) -> x, y of the paper's table 1
KINDS = {
    0: (1, 0),
    1: (5, 1),
    2: (5, 2),
    3: (6, 1),
    4: (6, 2),
    5: (7, 1),
    6: (8, 1),
    7: (11, 0),
    8: (12, 0),
    9: (13, 1),
    10: (22, 2),
    11: (21, 2),
}
RESET = 5  # machine::Action
TRAJECTORY, INVERSE, SERVO = (1, 2), (3, 4), (5, 6)


def events(text: Iterable[str], without: tuple[str, ...] = ("bus_transaction", "latch", "push")) -> Iterable[Event]:
    """Lines of docs/trace.md: time in ps, component, event, arguments."""
    for line in text:
        if line.startswith("#"):
            continue
        stamp, rest = line.split(" [", 1)
        component, rest = rest.split("] ", 1)
        name, *arguments = rest.split()
        if name in without:
            continue
        seconds, fraction = stamp.split(".")
        yield (
            int(seconds) * 10**12 + int(fraction),
            component,
            name,
            {key: int(value, 0) for key, value in (a.split("=") for a in arguments)},
        )


@dataclass
class UserTask:
    """A row of [[tasks]] (docs/add-a-task.md): its J, and the slot that alone may claim it."""

    importance: int
    waiting: int
    due: int = 0
    dsp: int | None = None


@dataclass
class Rule:
    """Parameters of the rule, defaults of ruling 15 at base rates."""

    servo: int = 8
    crane: int = 64
    agv: int = 160
    gamma: int = 0
    alpha: int = 24
    beta: int = 12
    p: int = 0x4000
    q: int = 0x2000
    b: int = 0x100
    a: int = 0x40
    tasks: dict[int, UserTask] = field(default_factory=dict)  # by kind

    def may_claim(self, kind: int, slot: int) -> bool:
        return kind not in self.tasks or self.tasks[kind].dsp in (None, slot)

    def importance(self, kind: int, t: int, recomputed: bool) -> int:
        t = min(t, 0xFFFF)
        if recomputed:
            return 0xFFFD
        if kind in self.tasks:
            row = self.tasks[kind]
            return row.importance if t >= row.due else row.waiting
        x, y = KINDS[kind]
        fixed = {1: 0xFFFE, 21: 0xFFFB, 11: 0xFDFF, 12: 0xFBFF, 13: 0xF7FF, 22: 0xEFFF}
        if x in fixed:
            return fixed[x]
        if x in (7, 8):
            return 0 if t < self.servo - self.gamma else {7: 0xFFF7, 8: 0xFFEF}[x]
        due = {
            (5, 1): (self.crane - self.alpha, 0xFFDF, self.p),
            (6, 1): (self.crane - self.beta, 0xFFBF, self.p + self.b),
        }
        due |= {
            (5, 2): (self.agv - self.alpha, 0xFF7F, self.q + self.a * t),
            (6, 2): (self.agv - self.beta, 0xFEFF, self.q + self.b + self.a * t),
        }
        since, importance, early = due[x, y]
        return importance if t >= since else min(early, 0xFFFF)


@dataclass
class Block:
    kind: int
    area: int
    tick: int
    t: int
    inserted: int
    taken: bool = False
    recomputed: bool = False
    new: bool = True
    importance: int = -1
    loaded: int = 0  # number of the refresh that loaded it


@dataclass
class Replay:
    """Follows a trace from any instant on. `faults` are sentences on what the rule does not allow. Checks begin when
    every block of the list is known."""

    rule: Rule
    doorbells: bool = (
        True  # idle policy "doorbell": one DSP that has announced itself idle is rung for each block with J > 0
    )
    faults: list[str] = field(default_factory=list)
    refreshes: int = 0
    claims: int = 0
    longest: int = 0
    kinds: set[int] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.blocks: dict[int, Block] = {}
        self.order: list[int] = []
        self.inserted = 0
        self.planned_at: dict[int, int] = {}  # by area: the refresh that loaded the last trajectory block that is done
        self.loaded_since_refresh: list[tuple[int, Block]] = []
        self.known = False
        self.power_on = False  # a DSP booted before the first refresh
        self.seen = 0
        self.idle: set[int] = set()
        self.to_ring: tuple[int, int] | None = None  # at least, at most, after the last refresh
        self.offered: list[int] = []  # kinds that may be run, by falling J, at the last refresh
        self.rung: list[int] = []

    def fault(self, time: int, what: str) -> None:
        if self.known:
            self.faults.append(f"{time} ps: {what}")

    def follow(self, trace: Iterable[Event]) -> None:
        for time, component, name, n in trace:
            slot = int(component.split()[1]) if component.startswith("dsp") else -1
            self.power_on = self.power_on or (name == "reset" and n["state"] == 1 and self.seen == 0)
            if name == "idle" and n["state"]:
                self.idle.add(slot)
            elif name in ("idle", "reset"):
                self.idle.discard(slot)
            elif name == "scripted" and n["action"] == RESET:  # of a dead chip too
                self.idle.discard(n["number"])
            elif name == "doorbell":
                self.rung.append(n["slot"])
                self.idle.discard(n["slot"])
            elif name == "load":
                self.inserted += 1
                self.blocks[n["block"]] = Block(n["kind"], n["area"], n["tick"], 0, self.inserted)
                self.loaded_since_refresh.append((n["block"], self.blocks[n["block"]]))
            elif name == "remove":
                gone = self.blocks.pop(n["block"], None)
                if gone and gone.kind in TRAJECTORY:
                    self.planned_at[gone.area] = gone.loaded
            elif name == "requeue" and n["block"] in self.blocks:
                self.inserted += 1
                block = self.blocks[n["block"]]
                block.taken, block.recomputed, block.t, block.inserted, block.new = False, True, 0, self.inserted, True
            elif name == "claim":
                self.claim(time, slot, n["block"])
            elif name == "refresh":
                self.refresh(time, n)

    def claim(self, time: int, slot: int, offset: int) -> None:
        if offset not in self.blocks:
            return self.fault(time, f"a claim of {offset:#x}, which is not in the list")
        block = self.blocks[offset]
        if self.known:
            self.claims += 1
            if offset != next(
                (other for other in self.order if self.rule.may_claim(self.blocks[other].kind, slot)), None
            ):
                self.fault(time, f"DSP {slot} claimed {offset:#x}, but {[hex(o) for o in self.order[:3]]} is the order")
            if block.importance == 0:
                self.fault(time, f"claimed {offset:#x}, whose J is 0")
        block.taken = True
        if offset in self.order:
            self.order.remove(offset)

    def rings(self, idle: set[int]) -> int:
        """How many DSPs the host rings for these waiting blocks, if these DSPs are idle (docs/controller.md, A
        refresh)."""
        own = {self.rule.tasks[kind].dsp for kind in self.offered if kind in self.rule.tasks}
        left = set(idle)
        for kind in self.offered:
            may = {slot for slot in left if self.rule.may_claim(kind, slot)}
            if may:
                left.discard(min(may - own or may) if len(may) > 1 else may.pop())
        return len(idle) - len(left)

    def check_doorbells(self, time: int) -> None:
        if self.doorbells and self.to_ring and not self.to_ring[0] <= len(self.rung) <= self.to_ring[1]:
            self.fault(
                time,
                f"before this refresh {len(self.rung)} DSPs were rung, {self.to_ring[0]} to {self.to_ring[1]} by the rule",
            )
        for slot in self.rung:
            if not any(self.rule.may_claim(kind, slot) for kind in self.offered):
                self.fault(time, f"before this refresh DSP {slot} was rung, and nothing was there for it")
        self.rung = []

    def refresh(self, time: int, n: dict[str, int]) -> None:
        self.check_doorbells(time)
        number, elapsed = n["number"], n["skipped"] + 1
        for _, block in self.loaded_since_refresh:  # t at the load, to which this refresh adds what has elapsed
            block.loaded = number
            if block.kind in SERVO:
                block.t = number - (block.tick - self.rule.servo) - elapsed
            # docs/controller.md, Sub-processes: inverse kinematics of a point is loaded when its trajectory planning is
            # done, and inherits that one's t.
            if block.kind in INVERSE:
                block.t = number - self.planned_at.get(block.area, number)
        self.loaded_since_refresh.clear()
        waiting = []
        for offset, block in self.blocks.items():
            block.t += elapsed
            if not block.taken:
                block.importance = self.rule.importance(block.kind, block.t, block.recomputed)
                waiting.append((-block.importance, block.inserted, offset))
                self.kinds.add(block.kind)
        self.order = [offset for _, _, offset in sorted(waiting)]
        first = self.seen == 0 and (number == 1 or self.power_on)
        self.seen += 1
        self.known = (
            self.known
            or (
                len(self.blocks) == n["blocks"]
                and all(block.area in self.planned_at for block in self.blocks.values() if block.kind in INVERSE)
            )
            or first
        )
        self.refreshes += self.known
        self.offered = [self.blocks[offset].kind for offset in self.order if self.blocks[offset].importance > 0]
        self.to_ring = (self.rings(self.idle), self.rings(set(range(32))))
        self.longest = max(self.longest, len(self.order))
        head = self.order[0] if self.order else 0
        if head != n["pointer"]:
            self.fault(time, f"refresh {number}: the work pointer is {n['pointer']:#x}, {head:#x} by the rule")
        if len(self.order) != n["waiting"] or len(self.blocks) != n["blocks"]:
            self.fault(
                time,
                f"refresh {number}: {n['waiting']} of {n['blocks']} wait, {len(self.order)} of {len(self.blocks)} by the replay",
            )
