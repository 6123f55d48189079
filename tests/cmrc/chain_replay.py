"""Why jobs were late, computed a second time from the event trace alone (docs/report.md, Why late; docs/trace.md): each
wait with its cause, exact to the picosecond.

Brute force: the wait of a job is cut at every instant at which anything changed, and each piece is judged by itself.
The replay shares no code with the emulator."""

from __future__ import annotations

from bisect import bisect_right
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
ACQUIRED, TAKEN_AWAY = (
    1,
    2,
)  # states of a semaphore; 2: the host has acquired it from its holder, which does not change
MUST_CONTINUE = 1  # of TB_NOTIFY: a part is done, and the job is not
STANDS_STILL = (0, 1, 2)  # machine::Action: fail, freeze, hang
BEFORE = ("host_late", "not_due", "host_refresh", "host_lock")
CLAIM = ("claim", "claim_bus_a", "claim_bus_b")


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
        in_list: dict[int, Job] = {}
        numbers: dict[int, int] = {}
        eligible: list[Job] = []
        continues: dict[int, bool] = {}  # by block: its last run was a part
        next_part_of: Job | None = None
        for time, component, name, n in events:
            self.last = time
            slot = int(component.split()[1]) if component.startswith("dsp") else -1
            if name == "load":
                kind = n["kind"]
                if next_part_of:  # the host loads it where it takes out the part that is done
                    next_part_of.between_parts = False
                    in_list[n["block"]], next_part_of = next_part_of, None
                    continue
                number = n["tick"] // servo if kind in SERVO else numbers.get(kind, 0)
                numbers[kind] = numbers.get(kind, 0) + 1
                job = Job(kind, number, n["tick"])
                in_list[n["block"]] = self.jobs[kind, number] = job
            elif name == "refresh":
                self.refreshed = time
                for job in in_list.values():
                    if not job.waits_from:
                        job.waits_from.append(self.tick(job.due if job.kind in SERVO else n["number"]))
                    waits = len(job.claims) < len(job.waits_from) and not job.between_parts
                    if (
                        waits
                        and len(job.offered) < len(job.waits_from)
                        and (job.kind not in SERVO or n["number"] >= job.due or len(job.waits_from) > 1)
                    ):
                        eligible.append(job)
            elif name == "semaphore" and n["number"] == 0 and n["state"] != TAKEN_AWAY:
                self.list.set(time, n["owner"] if n["state"] == ACQUIRED else 0)
                if n["owner"] == HOST and n["state"] == 0:
                    for job in eligible:
                        job.offered.append(time)
                    eligible.clear()
            elif name == "finish":
                continues[n["block"]] = bool(n["notify"] & MUST_CONTINUE)
            elif name == "issue":
                issued = time - (n["delay_low"] + (n["delay_high"] << 32))
                job = in_list[n["block"]]
                if n["flag"] == 0xF:
                    job.claims.append((slot, issued))
                    job.failed.append(None)
                    self.slots[slot].set(issued, ("busy", (job, issued)))
                else:
                    length = job.ran() + issued - job.claims[-1][1]
                    if continues[n["block"]]:
                        job.parts[len(job.claims) - 1], job.between_parts = issued, True
                        job.waits_from.append(issued)
                    else:
                        job.end = issued
                        self.shortest[job.kind] = min(self.shortest.get(job.kind, length), length)
                    if self.slots[slot].values[-1][0] == "busy":
                        self.slots[slot].set(issued, ("awake", None))
            elif name == "requeue":
                self.taken_away(in_list[n["block"]], time)
                in_list[n["block"]].waits_from.append(time)
            elif name == "remove":
                gone = in_list.pop(n["block"])
                self.taken_away(gone, time)  # without an end it was given up
                next_part_of = gone if gone.between_parts else None
            elif name == "miss" and n["class"] == DROPPED:
                kind = n["kind"]
                number = (
                    n["tick"] // servo if kind in SERVO else numbers.get(kind, 0)
                )  # others count on with their blocks
                if kind not in SERVO:
                    numbers[kind] = number + 1
                self.dropped[kind, number] = time
            elif name in (
                "idle",
                "interrupt",
            ):  # one that has failed stays away, whatever was on its way from it or to it
                if self.slots[slot].values[-1][0] != "off":
                    asleep = name == "idle" and n["state"] == 1
                    self.slots[slot].set(time, ("asleep" if asleep else "awake", None))
            elif name in ("fault", "reset") or (name == "scripted" and n["action"] in STANDS_STILL):
                slot = n["number"] if name == "scripted" else slot
                if name == "reset" and n["state"] == 1:
                    self.slots[slot].set(time, ("awake", None))
                    continue
                state, what = self.slots[slot].values[-1]
                if (
                    state == "busy"
                    and what[0].end is None
                    and what[0].failed[-1] is None
                    and len(what[0].claims) == len(what[0].waits_from)
                ):
                    what[0].failed[-1] = time
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
    chains = 0
    for miss in report["misses"]:
        kind = kinds[miss["kind"]]
        where = f"{miss['kind']} {miss['number']}"
        parts, release, deadline, end = dict(miss["parts_ps"]), miss["release_ps"], miss["deadline_ps"], miss["end_ps"]
        usual = trace.shortest.get(kind, 0)
        assert (miss["usual_ps"] or 0) == usual, where
        if deadline is None:
            assert miss["lateness_ps"] is None and sum(parts.values()) == end - release - usual, where
        else:
            assert miss["lateness_ps"] == end - deadline == sum(parts.values()), where
            assert parts.pop("slack", 0) == usual - (deadline - release), where
        if kind in SERVO:
            assert (release, deadline) == (
                trace.tick(miss["number"] * trace.servo),
                trace.tick((miss["number"] + 1) * trace.servo),
            ), where
        if miss["outcome"] == "dropped" and not miss["runs"]:
            assert parts == {
                key: value
                for key, value in (
                    ("host_late" if miss["previous"] is None else "previous_out", deadline - release),
                    ("not_run", -usual),
                )
                if value
            }, where
            found = trace.dropped.get((kind, miss["number"]), report_end(report))
            if (kind, miss["number"]) not in trace.dropped:  # the host did not come back before the end
                assert trace.refreshed < deadline <= report_end(report), where
            assert miss["unavoidable_ps"] == max(release, min(found, deadline - usual + 1)), where
            continue
        chains += 1
        job = trace.jobs[kind, miss["number"]]
        if not job.waits_from:  # loaded in the refresh that the run's end has cut off
            assert end == report_end(report) and not miss["runs"], where
            continue
        assert release == job.waits_from[0], where
        assert [(run["dsp"], run["claimed_ps"]) for run in miss["runs"]] == job.claims, where
        expected: dict[str, int] = {}
        before = 0
        for i, waits_from in enumerate(job.waits_from):
            claimer, claimed = job.claims[i] if i < len(job.claims) else (None, end)
            offered = job.offered[i] if i < len(job.offered) else claimed
            before += min(offered, claimed) - waits_from
            for what, time in trace.waits(offered, claimed, claimer, kind).items():
                expected[what] = expected.get(what, 0) + time
            after = job.waits_from[i + 1] if i + 1 < len(job.waits_from) else end
            if (
                claimer is not None
                and i not in job.parts
                and (i + 1 < len(job.waits_from) or job.failed[i] is not None or miss["outcome"] == "dropped")
            ):
                stop = after if job.failed[i] is None else min(after, max(claimed, job.failed[i] or 0))
                expected["lost_run"] = expected.get("lost_run", 0) + stop - claimed
                expected["watchdog"] = expected.get("watchdog", 0) + after - stop
        reported = {
            what: parts.pop(what, 0)
            for what in ("doorbell", "lock", "blocked", "behind_list", "no_dsp", "own_dsp_out", "lost_run", "watchdog")
        }
        reported["claim"] = sum(parts.pop(what, 0) for what in CLAIM)
        assert sum(parts.pop(what, 0) for what in BEFORE) == before, where
        assert reported == {what: expected.get(what, 0) for what in reported}, (
            f"{where}: {reported}, by the trace {expected}"
        )
        ran = (
            bool(job.claims)
            and len(job.claims) == len(job.waits_from)
            and job.failed[-1] is None
            and miss["outcome"] != "dropped"
        )
        if ran:
            assert all(name.startswith("execution.") for name in parts), where
            assert sum(parts.values()) == job.ran() + end - job.claims[-1][1] - usual, where
        elif job.parts:
            assert sum(parts.values()) == job.ran() - usual, where
        else:
            assert parts == ({"not_run": -usual} if usual else {}), where
        if miss["outcome"] == "late":
            assert end == job.end, where
        in_the_way = sum(block["share_ps"] for block in miss["behind"])
        assert in_the_way == reported["blocked"] + reported["behind_list"], where
        for block in miss["behind"]:
            state, what = trace.slots[block["dsp"]].at(block["from_ps"], ("off", None))
            assert (
                state == "busy"
                and what[1] == block["claimed_ps"]
                and (trace.names[what[0].kind], what[0].number) == (block["kind"], block["number"])
            ), where
        if deadline is not None:
            check_unavoidable(miss, job, usual)
    return chains


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
