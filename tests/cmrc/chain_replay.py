"""Why jobs were late, computed a second time from the event trace alone (docs/report.md, Why late; docs/trace.md): each
wait with its cause, exact to the picosecond.

Brute force: the wait of a job is cut at every instant at which anything changed, and each piece is judged by itself.
The replay shares no code with the emulator."""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

from scheduling_replay import SERVO, Event

NAMES = {
    0: "error", 1: "trajectory_planning.crane", 2: "trajectory_planning.agv", 3: "inverse_kinematics.crane", 4: "inverse_kinematics.agv", 5: "torque_compensation",
    6: "pid", 7: "identify", 8: "grab_path", 9: "home.crane", 10: "home.agv", 11: "obstacle_avoidance",
}  # fmt: skip
HOST, DROPPED = 0xFF, 5
# States of a semaphore. TAKEN_AWAY: the host has acquired it from its holder, which does not change.
ACQUIRED, TAKEN_AWAY = 1, 2
MUST_CONTINUE = 1  # of TB_NOTIFY: a part is done, and the job is not
STANDS_STILL = (0, 1, 2)  # machine::Action: fail, freeze, hang
BEFORE = ("host_late", "not_due", "host_refresh", "host_lock")
CLAIM = ("claim", "claim_bus_a", "claim_bus_b")
WAITS = ("doorbell", "lock", "blocked", "behind_list", "no_dsp", "own_dsp_out", "lost_run", "watchdog")


@dataclass
class Steps:
    """A quantity that changes at instants."""

    times: list[int] = field(default_factory=list)
    values: list[Any] = field(default_factory=list)

    def set(self, time: int, value: Any) -> None:
        time = max(time, self.times[-1]) if self.times else time
        self.times.append(time)
        self.values.append(value)

    def at(self, time: int, default: Any) -> Any:
        place = bisect_right(self.times, time)
        return self.values[place - 1] if place else default

    def between(self, start: int, end: int) -> list[int]:
        return self.times[bisect_right(self.times, start) : bisect_right(self.times, end)]


@dataclass
class Job:
    kind: int
    number: int
    due: int
    waits_from: list[int] = field(default_factory=list)
    offered: list[int] = field(default_factory=list)  # when the list was free, J > 0, once per wait
    claims: list[tuple[int, int]] = field(default_factory=list)
    failed: list[int | None] = field(default_factory=list)
    end: int | None = None
    parts: dict[int, int] = field(default_factory=dict)  # claims that ran a part: when it was done
    between_parts: bool = False  # a part is done, and the host has not put up the next one

    def ran(self) -> int:
        return sum(done - self.claims[i][1] for i, done in self.parts.items())


Numbers = dict[str, int]
"""Of an event, by their names in docs/trace.md"""


class Trace:
    """Everything that the chains are checked against."""

    def __init__(
        self,
        events: Iterable[Event],
        dsps: int,
        servo: int,
        refresh_hz: float,
        tasks: dict[int, tuple[str, int | None]] | None = None,
        empty: int = 0,
        preloaded: bool = False,
    ) -> None:
        """`tasks`: by kind the user's tasks, their names in the report and the slot that alone may claim them; `empty`:
        slots without a DSP at the start; `preloaded`: the DSPs do not have to boot."""
        self.servo, self.refresh_mhz = servo, round(refresh_hz * 1000)  # the timer's clock is in whole millihertz
        self.names = NAMES | {kind: name for kind, (name, _) in (tasks or {}).items()}
        self.own = {kind: dsp for kind, (_, dsp) in (tasks or {}).items() if dsp is not None}
        self.jobs: dict[tuple[int, int], Job] = {}
        at_start = "awake" if preloaded else "off"  # a DSP that has not booted is off, forever if its link is broken
        self.slots = [Steps([0], [(at_start, None)]) for _ in range(dsps)] + [
            Steps([0], [("off", None)]) for _ in range(empty)
        ]
        self.list = Steps()
        self.dropped: dict[tuple[int, int], int] = {}  # kind, tick: when the host found it
        self.shortest: dict[int, int] = {}
        self.last = self.refreshed = 0
        self.in_list: dict[int, Job] = {}
        self.numbers: dict[int, int] = {}
        self.eligible: list[Job] = []
        self.continues: dict[int, bool] = {}  # by block: its last run was a part
        self.next_part_of: Job | None = None
        followed = {
            "load": self.load, "refresh": self.refresh, "semaphore": self.semaphore, "finish": self.finish, "issue": self.issue, "requeue": self.requeue,
            "remove": self.remove, "miss": self.miss, "idle": self.idle, "interrupt": self.interrupt, "fault": self.fault, "reset": self.reset,
            "scripted": self.scripted,
        }  # fmt: skip
        for time, component, name, n in events:
            self.last = time
            if name in followed:
                followed[name](time, int(component.split()[1]) if component.startswith("dsp") else -1, n)

    # ---- one event each: when, of which DSP (-1: of none), its numbers ----

    def load(self, _: int, slot: int, n: Numbers) -> None:
        if self.next_part_of:  # the host loads it where it takes out the part that is done
            self.next_part_of.between_parts = False
            self.in_list[n["block"]], self.next_part_of = self.next_part_of, None
            return
        job = Job(n["kind"], self.number(n), n["tick"])
        self.numbers[job.kind] = self.numbers.get(job.kind, 0) + 1
        self.in_list[n["block"]] = self.jobs[job.kind, job.number] = job

    def refresh(self, time: int, slot: int, n: Numbers) -> None:
        self.refreshed = time
        for job in self.in_list.values():
            if not job.waits_from:
                job.waits_from.append(self.tick(job.due if job.kind in SERVO else n["number"]))
            waits = len(job.claims) < len(job.waits_from) and not job.between_parts
            not_offered = len(job.offered) < len(job.waits_from)
            is_due = job.kind not in SERVO or n["number"] >= job.due or len(job.waits_from) > 1
            if waits and not_offered and is_due:
                self.eligible.append(job)

    def semaphore(self, time: int, slot: int, n: Numbers) -> None:
        if n["number"] != 0 or n["state"] == TAKEN_AWAY:
            return
        self.list.set(time, n["owner"] if n["state"] == ACQUIRED else 0)
        if n["owner"] == HOST and n["state"] == 0:
            for job in self.eligible:
                job.offered.append(time)
            self.eligible.clear()

    def finish(self, _: int, slot: int, n: Numbers) -> None:
        self.continues[n["block"]] = bool(n["notify"] & MUST_CONTINUE)

    def issue(self, time: int, slot: int, n: Numbers) -> None:
        """A flag that a DSP wrote: 0Fh claims the block, the others end its run."""
        issued = time - (n["delay_low"] + (n["delay_high"] << 32))
        job = self.in_list[n["block"]]
        if n["flag"] == 0xF:
            job.claims.append((slot, issued))
            job.failed.append(None)
            self.slots[slot].set(issued, ("busy", (job, issued)))
            return
        length = job.ran() + issued - job.claims[-1][1]
        if self.continues[n["block"]]:
            job.parts[len(job.claims) - 1], job.between_parts = issued, True
            job.waits_from.append(issued)
        else:
            job.end = issued
            self.shortest[job.kind] = min(self.shortest.get(job.kind, length), length)
        if self.slots[slot].values[-1][0] == "busy":
            self.slots[slot].set(issued, ("awake", None))

    def requeue(self, time: int, slot: int, n: Numbers) -> None:
        self.taken_away(self.in_list[n["block"]], time)
        self.in_list[n["block"]].waits_from.append(time)

    def remove(self, time: int, slot: int, n: Numbers) -> None:
        gone = self.in_list.pop(n["block"])
        self.taken_away(gone, time)  # without an end it was given up
        self.next_part_of = gone if gone.between_parts else None

    def miss(self, time: int, slot: int, n: Numbers) -> None:
        if n["class"] != DROPPED:
            return
        kind, number = n["kind"], self.number(n)
        if kind not in SERVO:  # others count on with their blocks
            self.numbers[kind] = number + 1
        self.dropped[kind, number] = time

    def idle(self, time: int, slot: int, n: Numbers) -> None:
        self.now(slot, time, "asleep" if n["state"] == 1 else "awake")

    def interrupt(self, time: int, slot: int, n: Numbers) -> None:
        self.now(slot, time, "awake")

    def fault(self, time: int, slot: int, n: Numbers) -> None:
        self.stands_still(slot, time)

    def reset(self, time: int, slot: int, n: Numbers) -> None:
        if n["state"] == 1:
            self.slots[slot].set(time, ("awake", None))
        else:
            self.stands_still(slot, time)

    def scripted(self, time: int, slot: int, n: Numbers) -> None:
        if n["action"] in STANDS_STILL:
            self.stands_still(n["number"], time)

    # ---- what events have in common ----

    def number(self, n: Numbers) -> int:
        """The job's number: the servo's by its tick, all others in the order in which they come."""
        return n["tick"] // self.servo if n["kind"] in SERVO else self.numbers.get(n["kind"], 0)

    def now(self, slot: int, time: int, state: str) -> None:
        """One that has failed stays away, whatever was on its way from it or to it."""
        if self.slots[slot].values[-1][0] != "off":
            self.slots[slot].set(time, (state, None))

    def stands_still(self, slot: int, time: int) -> None:
        state, what = self.slots[slot].values[-1]
        if state == "busy":
            job = what[0]
            if job.end is None and job.failed[-1] is None and len(job.claims) == len(job.waits_from):
                job.failed[-1] = time
        self.slots[slot].set(time, ("off", None))

    def taken_away(self, job: Job, time: int) -> None:
        holder, _ = job.claims[-1]
        state, what = self.slots[holder].values[-1]
        if state == "busy" and what[0] is job:
            self.slots[holder].set(time, ("awake", None))

    def tick(self, number: int) -> int:
        return number * 10**15 // self.refresh_mhz

    def waits(self, start: int, end: int, claimer: int | None, kind: int) -> dict[str, int]:
        """What a block waited for that could be claimed from `start` on."""
        own = self.own.get(kind)
        cuts = sorted({start, end}.union(*(steps.between(start, end) for steps in [*self.slots, self.list])))
        cuts = [cut for cut in cuts if start <= cut <= end]
        sums: dict[str, int] = {}
        for at, until in pairwise(cuts):
            states = [
                steps.at(at, ("off", None)) if own in (None, slot) else ("off", None)
                for slot, steps in enumerate(self.slots)
            ]
            awake = [slot for slot, (state, _) in enumerate(states) if state == "awake"]
            busy = [what[1] for state, what in states if state == "busy"]
            if awake:
                free = claimer if claimer in awake else awake[0]
                what = "lock" if self.list.at(at, 0) not in (0, free + 1) else "claim"
            elif any(state == "asleep" for state, _ in states):
                what = "doorbell"
            elif not busy:
                what = "no_dsp" if own is None else "own_dsp_out"
            else:
                what = "behind_list" if any(claimed >= start for claimed in busy) else "blocked"
            sums[what] = sums.get(what, 0) + until - at
        return sums


def check(trace: Trace, report: dict[str, Any]) -> int:
    """Compares every miss of the report with the trace; returns how many jobs with a chain there were."""
    kinds = {name: kind for kind, name in trace.names.items()}
    chains, ended = 0, report_end(report)
    for miss in report["misses"]:
        kind = kinds[miss["kind"]]
        where = f"{miss['kind']} {miss['number']}"
        usual = trace.shortest.get(kind, 0)
        parts = parts_but_slack(trace, miss, kind, usual, where)
        if miss["outcome"] == "dropped" and not miss["runs"]:
            check_dropped(trace, miss, parts, kind, usual, ended, where)
            continue
        chains += 1
        job = trace.jobs[kind, miss["number"]]
        if not job.waits_from:  # loaded in the refresh that the run's end has cut off
            assert miss["end_ps"] == ended and not miss["runs"], where
            continue
        check_waits(trace, miss, parts, job, where)
        check_runs(miss, parts, job, usual, where)
        check_behind(trace, miss, where)
        if miss["deadline_ps"] is not None:
            check_unavoidable(miss, job, usual)
    return chains


def parts_but_slack(trace: Trace, miss: dict[str, Any], kind: int, usual: int, where: str) -> dict[str, int]:
    """The parts of a job's time by cause, after a check of their sum and of the job's release and deadline."""
    parts, release, deadline, end = dict(miss["parts_ps"]), miss["release_ps"], miss["deadline_ps"], miss["end_ps"]
    assert (miss["usual_ps"] or 0) == usual, where
    if deadline is None:
        assert miss["lateness_ps"] is None and sum(parts.values()) == end - release - usual, where
    else:
        assert miss["lateness_ps"] == end - deadline == sum(parts.values()), where
        assert parts.pop("slack", 0) == usual - (deadline - release), where
    if kind in SERVO:
        due = [trace.tick((miss["number"] + later) * trace.servo) for later in (0, 1)]
        assert [release, deadline] == due, where
    return parts


def check_dropped(
    trace: Trace, miss: dict[str, Any], parts: dict[str, int], kind: int, usual: int, ended: int, where: str
) -> None:
    """A tick for which no block was loaded."""
    release, deadline = miss["release_ps"], miss["deadline_ps"]
    waited = "host_late" if miss["previous"] is None else "previous_out"
    expected = {waited: deadline - release, "not_run": -usual}
    assert parts == {what: time for what, time in expected.items() if time}, where
    if (kind, miss["number"]) not in trace.dropped:  # the host did not come back before the end
        assert trace.refreshed < deadline <= ended, where
    found = trace.dropped.get((kind, miss["number"]), ended)
    assert miss["unavoidable_ps"] == max(release, min(found, deadline - usual + 1)), where


def check_waits(trace: Trace, miss: dict[str, Any], parts: dict[str, int], job: Job, where: str) -> None:
    """All causes but those of the last run, which stay in ``parts``."""
    assert miss["release_ps"] == job.waits_from[0], where
    assert [(run["dsp"], run["claimed_ps"]) for run in miss["runs"]] == job.claims, where
    end, before = miss["end_ps"], 0
    expected: Counter[str] = Counter()
    for i, waits_from in enumerate(job.waits_from):
        claimer, claimed = job.claims[i] if i < len(job.claims) else (None, end)
        offered = job.offered[i] if i < len(job.offered) else claimed
        before += min(offered, claimed) - waits_from
        expected.update(trace.waits(offered, claimed, claimer, job.kind))
        is_last = i + 1 == len(job.waits_from)
        after = end if is_last else job.waits_from[i + 1]
        failed = job.failed[i] if claimer is not None else None
        was_lost = not is_last or failed is not None or miss["outcome"] == "dropped"
        if claimer is not None and i not in job.parts and was_lost:
            stop = after if failed is None else min(after, max(claimed, failed))
            expected["lost_run"] += stop - claimed
            expected["watchdog"] += after - stop
    reported = {what: parts.pop(what, 0) for what in WAITS}
    reported["claim"] = sum(parts.pop(what, 0) for what in CLAIM)
    assert sum(parts.pop(what, 0) for what in BEFORE) == before, where
    assert reported == {what: expected[what] for what in reported}, f"{where}: {reported}, by the trace {expected}"
    in_the_way = sum(block["share_ps"] for block in miss["behind"])
    assert in_the_way == reported["blocked"] + reported["behind_list"], where


def check_runs(miss: dict[str, Any], parts: dict[str, int], job: Job, usual: int, where: str) -> None:
    """What is left: the last run's causes, or that there was none."""
    has_run = len(job.claims) == len(job.waits_from) and job.failed[-1] is None
    if has_run and miss["outcome"] != "dropped":
        assert all(name.startswith("execution.") for name in parts), where
        assert sum(parts.values()) == job.ran() + miss["end_ps"] - job.claims[-1][1] - usual, where
    elif job.parts:
        assert sum(parts.values()) == job.ran() - usual, where
    else:
        assert parts == ({"not_run": -usual} if usual else {}), where
    if miss["outcome"] == "late":
        assert miss["end_ps"] == job.end, where


def check_behind(trace: Trace, miss: dict[str, Any], where: str) -> None:
    """The blocks in its way were on their DSPs at that time."""
    for block in miss["behind"]:
        state, what = trace.slots[block["dsp"]].at(block["from_ps"], ("off", None))
        assert state == "busy" and what[1] == block["claimed_ps"], where
        assert (trace.names[what[0].kind], what[0].number) == (block["kind"], block["number"]), where


def report_end(report: dict[str, Any]) -> int:
    return round(report["simulated_s"] * 10**12)


def check_unavoidable(miss: dict[str, Any], job: Job, usual: int) -> None:
    """By the definition: the first instant at which now + the shortest remaining time is past the deadline."""

    def remaining(now: int) -> int:
        left = usual
        for i, (_, claimed) in enumerate(job.claims):
            ends = min(
                [
                    time
                    for time in (job.failed[i], job.waits_from[i + 1] if i + 1 < len(job.waits_from) else None)
                    if time is not None
                ],
                default=None,
            )
            if claimed <= now and (ends is None or now < ends):
                return max(0, claimed + left - now)
            if i in job.parts and job.parts[i] <= now:
                left = max(0, left - (job.parts[i] - claimed))
        return left

    said, deadline = miss["unavoidable_ps"], miss["deadline_ps"]
    given_up = miss["outcome"] == "dropped"
    instants = {miss["release_ps"], deadline - usual, deadline - usual + 1, deadline, deadline + 1}
    for start, (_, claimed), failed in zip(job.waits_from, job.claims, job.failed, strict=False):
        instants |= {start, claimed, *(() if failed is None else (failed,))}
    instants |= set(job.waits_from)
    instants |= {deadline - remaining(done) + 1 for done in job.parts.values()}
    instants |= {instant + step for instant in set(instants) for step in (-1, 1)}
    past = [at for at in sorted(instants) if at >= miss["release_ps"] and at + remaining(at) > deadline]
    if given_up:
        past.append(miss["end_ps"])
    assert said == min(past), f"{miss['kind']} {miss['number']}: {said}, by the definition {min(past)}"
