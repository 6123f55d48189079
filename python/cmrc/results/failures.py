"""Claim 2: a DSP can be pulled out or fail in mid-task and nothing is lost."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from cmrc.events import built_in_tasks
from cmrc.results.claim import Claim, parameter
from cmrc.results.dsps import rates
from cmrc.results.judgement import SERVO, Row, Verdict, counted, markdown, of, share_interval, with_interval
from cmrc.results.runs import Reports, Run
from cmrc.simulation import Setting, Simulation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PHASES = ("sleeps", "asks for the list", "holds the list", "fetches its block", "reports", "runs")
# What a DSP does while its program counter is between two labels (executive.asm). Elsewhere it runs a block, if it owns
# one, or sleeps.
PLACES = (
    ("exec_claim", "exec_acquired", "asks for the list"),
    ("exec_acquired", "exec_idle", "holds the list"),
    ("exec_next", "exec_run", "asks for the list"),
    ("exec_run", "exec_done", "fetches its block"),
    ("exec_done", "exec_unknown", "reports"),
)


class Look(NamedTuple):
    """What a DSP did at an instant; ``kind`` is that of its block, or empty."""

    at_s: float
    slot: int
    phase: str
    kind: str


@dataclass(frozen=True)
class Failures(Claim):
    """Failures of one DSP at random instants, as many in each phase of its work and in each kind of task."""

    NUMBER, NAME = 2, "failures"
    TITLE = "A DSP can be pulled out or fail in mid-task and nothing is lost"
    DRAWN = ("at_s", "phase", "kind")
    LABELS: ClassVar = {"dsps": "{} DSPs"}

    dsps: tuple[int, ...] = parameter((1, 2, 3), "numbers of DSPs of which one fails", quick=(1, 2))
    actions: tuple[str, ...] = parameter(
        ("fail", "hang", "unplug"), "what happens to it: actions of [[events]]", quick=("fail",)
    )
    servo_hz: float = parameter(1000.0, "f_p, Hz")
    refreshes_per_servo: int = parameter(8, "f_s / f_p", least=1)
    agvs: int = parameter(4, "AGVs, which drive from the start")
    avoidance: str = parameter("vfh", "kernels.avoidance: their obstacle avoidance")
    trials: int = parameter(2, "failures of each action at each phase, and in each kind of task", quick=1)
    alone_trials: int = parameter(6, "failures of the only DSP, of each action", quick=1)
    seed: int = parameter(1, "draws instants and victims")
    looks: int = parameter(6000, "random instants at which it is looked what each DSP does, to choose from", quick=150)
    earliest_s: float = parameter(0.0201, "first instant of a failure, s: identify has just begun", least=0)
    latest_s: float = parameter(0.06, "last instant of a failure, s", quick=0.03)
    after_s: float = parameter(
        0.15,
        "how long a run continues after the failure, s: beyond the limit of silence, the drives' time-out and a boot",
        quick=0.01,
    )

    def settings(self, dsps: int) -> dict[str, Setting]:
        return {
            "machine.dsps": dsps,
            **rates(self.servo_hz, self.refreshes_per_servo),
            "dock.agvs": self.agvs,
            "load.driving": True,
            "kernels.avoidance": self.avoidance,
        }

    def looked(self, dsps: int) -> list[Look]:
        """What each DSP does at random instants of a run in which nothing fails."""
        draw = random.Random(self.seed)
        simulation = Simulation(
            settings={**self.settings(dsps), "report.reference": "none", "duration_s": self.latest_s + 0.001}
        )
        core: Any = simulation._core
        kinds = built_in_tasks()
        places = [(core.symbol(begin), core.symbol(end), phase) for begin, end, phase in PLACES]
        pool, words, count = (core.symbol(name) for name in ("BLOCK_POOL", "BLOCK_WORDS", "BLOCK_COUNT"))
        flag, owner, kind, taken = (core.symbol(name) for name in ("TB_FLAG", "TB_OWNER", "TB_KIND", "FLAG_TAKEN"))
        seen = []
        for at in sorted(round(draw.uniform(self.earliest_s, self.latest_s), 9) for _ in range(self.looks)):
            simulation.run_until(at)
            owned = {
                core.peek(block + owner) - 1: core.peek(block + kind)
                for block in range(pool, pool + count * words, words)
                if core.peek(block + flag) == taken
            }
            for slot in range(dsps):
                pc = core.dsp(slot).pc
                number = owned.get(slot)
                name = kinds[number] if number is not None and number < len(kinds) else ""
                phases = (phase for begin, end, phase in places if begin <= pc < end)
                seen.append(Look(at, slot, next(phases, "runs" if name else "sleeps"), name))
        return seen

    def runs(self) -> list[Run]:
        """Random instants and victims, as many in each phase and in each kind of task."""
        draw = random.Random(self.seed)
        table = []
        for n in self.dsps:
            looks = self.looked(n)
            for action in self.actions:
                for at, slot, phase, kind in self.chosen(looks, draw) if n > 1 else self.chosen_alone(looks, draw):
                    event: dict[str, Setting] = {"at_s": at, "action": action, "dsp": slot}
                    label: dict[str, Setting] = {"dsps": n, "action": action, "at_s": at, "phase": phase, "kind": kind}
                    table.append(Run(label, self.settings(n), round(self.latest_s + self.after_s, 9), events=[event]))
        return table

    def chosen(self, looks: Sequence[Look], draw: random.Random) -> list[Look]:
        by_class: dict[tuple[str, str], list[Look]] = {}
        for look in looks:
            by_class.setdefault((look.phase, look.kind if look.phase == "runs" else ""), []).append(look)
        return [look for _, own in sorted(by_class.items()) for look in draw.sample(own, min(self.trials, len(own)))]

    def chosen_alone(self, looks: Sequence[Look], draw: random.Random) -> list[Look]:
        return draw.sample(looks, min(self.alone_trials, len(looks)))

    def rows(self, done: Sequence[tuple[Run, Reports]]) -> list[Row]:
        """One row per trial. ``detected_ms``: from the event to the watchdog's first action; ``samples``: most samples
        of the servo in a row without a result in time."""
        table = []
        for run, reports in done:
            report = reports[-1]
            at = float(run.label["at_s"])
            watchdog = [f["time_s"] for f in report["failures"] if f["kind"] != "scripted" and f["time_s"] > at]
            table.append(
                {
                    **run.label,
                    "samples": max(int(report["tasks"][kind]["longest_miss_streak"]) for kind in SERVO),
                    "lost": counted(report, of="lost"),
                    "recomputed": report["host"]["recomputed"],
                    "violations": len(report["audit"]["violations"]),
                    "detected_ms": (min(watchdog) - at) * 1e3 if watchdog else None,
                    "stopped": report["stop_reason"] == "no_dsp_left"
                    or all(d["state"] not in ("running", "idle") for d in report["dsps"]),
                    "braked": bool(report["braked"]),
                }
            )
        return table

    def verdict(self, all_rows: Sequence[Row]) -> Verdict:
        survivable = [row for row in all_rows if row["dsps"] > 1]
        in_task = [row for row in survivable if row["recomputed"]]
        if not in_task:
            return Verdict("not tested", "No failure hit a DSP in mid-task and left another.", "")
        broken = [row for row in survivable if row["lost"] or row["violations"]]
        kinds = {row["kind"] for row in survivable if row["kind"]}
        servo = [row["detected_ms"] for row in in_task if row["kind"] in SERVO and row["detected_ms"] is not None]
        long = [row["detected_ms"] for row in in_task if row["kind"] not in SERVO and row["detected_ms"] is not None]
        worst = max(survivable, key=lambda row: int(row["samples"]))
        why = (
            f"Of {len(survivable)} failures with a DSP left, spread over all phases of a claim and {len(kinds)} kinds "
            f"of tasks, {len(in_task)} took a block with them; in {len(survivable) - len(broken)} of {len(survivable)} "
            "every block was finished exactly once."
        )
        if servo:
            why += f" The host noticed a lost servo block after {with_interval(servo, 1)} ms"
            why += f", any other after {with_interval(long, 1)} ms, at worst {max(long):.1f} ms." if long else "."
        why += (
            f" At most {worst['samples']} samples of the servo in a row came late or never (with {worst['dsps']} DSPs, "
            f"of which the one that failed was at this: "
            f"{worst['phase']}{', ' + worst['kind'] if worst['kind'] else ''})."
        )
        return Verdict("fails" if broken else "holds", why, last_one(of(all_rows, dsps=1)))

    def section(self, all_rows: Sequence[Row]) -> str:
        columns = {
            "trials": "trials", "recomputed": "block put back", "whole": "nothing lost, work continues",
            "interval": "share, % (95 %)", "detected": "noticed after, ms",
            "samples": "servo samples missed in a row", "worst": "worst",
        }  # fmt: skip
        survivable = [row for row in all_rows if row["dsps"] > 1]
        running = of(survivable, phase="runs")
        kinds = [group(running, kind=kind) for kind in kinds_of(running)]
        phases = [group(survivable, phase=phase) for phase in PHASES if of(survivable, phase=phase)]
        actions = [group(all_rows, dsps=n, action=action) for n in self.dsps for action in self.actions]
        return (
            f"f_p {self.servo_hz:g} Hz, f_s {self.servo_hz * self.refreshes_per_servo:g} Hz, {self.agvs} AGVs that "
            f"drive from the start with obstacle avoidance ({self.avoidance}); each run ends at "
            f"{self.latest_s + self.after_s:g} s. Of {self.looks} random instants between {self.earliest_s:g} and "
            f"{self.latest_s:g} s (seed {self.seed}) it was noted what each DSP did; {self.trials} of each phase and "
            "of each kind of task were chosen for each action and number of DSPs above 1, and for the only DSP "
            f"{self.alone_trials} of all instants for each action. Identify is in all runs. The only DSP misses "
            "samples of the servo without any failure, too. Means with 95 % intervals (bootstrap; shares: Wilson) over instants, "
            "victims, actions.\n\n**By what ran when the DSP failed** (one or more DSPs left):\n\n"
            + markdown({"kind": "kind", **columns}, kinds)
            + "\n**By what the DSP was doing:**\n\n"
            + markdown({"phase": "phase", **columns}, phases)
            + "\n**By action and DSPs:**\n\n"
            + markdown({"dsps": "DSPs", "action": "what happens to one", **columns, "stopped": "work ended"}, actions)
        )

    def draw(self, all_rows: Sequence[Row], figure: Figure) -> None:
        left, right = figure.subplots(1, 2, sharey=True)
        survivable = [row for row in all_rows if row["dsps"] > 1]
        names = [*kinds_of(of(survivable, phase="runs")), *PHASES[:-1]]
        for row in survivable:
            place = names.index(row["kind"] if row["phase"] == "runs" else row["phase"])
            if row["detected_ms"] is not None:
                left.plot(row["detected_ms"], place, "o", color="C0", alpha=0.4, markersize=5)
            right.plot(row["samples"], place, "o", color="C1", alpha=0.4, markersize=5)
        left.set_yticks(range(len(names)), names, fontsize=7)
        left.set(xlabel="noticed after, ms", xscale="log", xlim=(0.4, 130))
        left.set_xticks([0.5, 1, 2, 5, 10, 20, 50, 100], ["0.5", "1", "2", "5", "10", "20", "50", "100"])
        left.minorticks_off()
        left.invert_yaxis()
        right.set(xlabel="servo samples missed in a row")


def last_one(last: Sequence[Row]) -> str:
    if not last:
        return ""
    dead = [row for row in last if row["stopped"]]
    text = (
        f"It ends with the last DSP: of {len(last)} failures of the only one, {len(dead)} ended the work, and "
        f"{sum(row['braked'] for row in dead)} of these left the crane braked."
    )
    if len(dead) < len(last):
        text += (
            " One that only hangs is reset and continues; that costs up to "
            f"{max(row['samples'] for row in last if not row['stopped'])} samples in a row: a DSP that holds no block "
            "is missed only by its silence."
        )
    return text


def kinds_of(running: Sequence[Row]) -> list[str]:
    return [kind for kind in built_in_tasks() if of(running, kind=kind)]


def group(all_rows: Sequence[Row], **label: object) -> Row:
    own = of(all_rows, **label)
    whole = sum(1 for row in own if not row["lost"] and not row["violations"] and not row["stopped"])
    low, high = share_interval(whole, len(own))
    return {
        **label,
        "trials": len(own),
        "recomputed": sum(1 for row in own if row["recomputed"]),
        "whole": whole,
        "interval": f"{100 * low:.0f} to {100 * high:.0f}",
        "detected": with_interval([row["detected_ms"] for row in own if row["detected_ms"] is not None], 1),
        "samples": with_interval([float(row["samples"]) for row in own], 1),
        "worst": max((row["samples"] for row in own), default=0),
        "stopped": sum(row["stopped"] for row in own),
    }
