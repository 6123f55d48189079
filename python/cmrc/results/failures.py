"""Claim 2: a DSP can be pulled out or fail in mid-task and nothing is lost."""

from __future__ import annotations

import functools
import random
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from cmrc.events import built_in_tasks
from cmrc.results.dsps import rates
from cmrc.results.judgement import SERVO, Row, Verdict, counted, markdown, parameter, share_interval, with_interval
from cmrc.results.runs import Reports, Run
from cmrc.simulation import Setting, Simulation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NUMBER, NAME = 2, "failures"
TITLE = "A DSP can be pulled out or fail in mid-task and nothing is lost"
# What a DSP does at an instant, by where its program counter is (executive.asm); the last needs a block that it owns.
PHASES = ("sleeps", "asks for the list", "holds the list", "fetches its block", "reports", "runs")


@dataclass(frozen=True)
class Parameters:
    """What a user may change."""

    dsps: tuple[int, ...] = parameter((1, 2, 3), "numbers of DSPs of which one fails")
    actions: tuple[str, ...] = parameter(("fail", "hang", "unplug"), "what happens to it: actions of [[events]]")
    servo_hz: float = parameter(1000.0, "f_p, Hz")
    refreshes_per_servo: int = parameter(8, "f_s / f_p")
    agvs: int = parameter(4, "AGVs, which drive from the start")
    avoidance: str = parameter("vfh", "kernels.avoidance: their obstacle avoidance")
    trials: int = parameter(2, "failures of each action at each phase, and in each kind of task")
    alone_trials: int = parameter(6, "failures of the only DSP, of each action")
    seed: int = parameter(1, "draws instants and victims")
    looks: int = parameter(6000, "random instants at which it is looked what each DSP does, to choose from")
    earliest_s: float = parameter(0.0201, "first instant of a failure, s: identify has just begun")
    latest_s: float = parameter(0.06, "last instant of a failure, s")
    after_s: float = parameter(
        0.15,
        "how long a run continues after the failure, s: beyond the limit of silence, the drives' time-out and a boot",
    )


QUICK = Parameters(dsps=(1, 2), actions=("fail",), trials=1, alone_trials=1, looks=150, latest_s=0.03, after_s=0.01)


def settings(p: Parameters, dsps: int) -> dict[str, Setting]:
    return {
        "machine.dsps": dsps,
        **rates(p.servo_hz, p.refreshes_per_servo),
        "dock.agvs": p.agvs,
        "load.driving": True,
        "kernels.avoidance": p.avoidance,
    }


@functools.cache
def looked(p: Parameters, dsps: int) -> tuple[tuple[float, int, str, str], ...]:
    """At random instants of a run in which nothing fails, what each DSP does: (instant, slot, phase, kind of its block
    or "")."""
    draw = random.Random(p.seed)
    simulation = Simulation(
        settings={**settings(p, dsps), "report.reference": "none", "duration_s": p.latest_s + 0.001}
    )
    core: Any = simulation._core
    kinds = built_in_tasks()
    place = {
        name: core.symbol(name)
        for name in ("exec_claim", "exec_acquired", "exec_idle", "exec_run", "exec_done", "exec_unknown", "exec_next")
    }
    pool, words, count, taken = (
        core.symbol(name) for name in ("BLOCK_POOL", "BLOCK_WORDS", "BLOCK_COUNT", "FLAG_TAKEN")
    )
    flag, owner, kind = (core.symbol(name) for name in ("TB_FLAG", "TB_OWNER", "TB_KIND"))
    seen = []
    for at in sorted(round(draw.uniform(p.earliest_s, p.latest_s), 9) for _ in range(p.looks)):
        simulation.run_until(at)
        blocks = [pool + n * words for n in range(count)]
        owned = {
            core.peek(block + owner) - 1: core.peek(block + kind)
            for block in blocks
            if core.peek(block + flag) == taken
        }
        for slot in range(dsps):
            pc = core.dsp(slot).pc
            number = owned.get(slot)
            name = kinds[number] if number is not None and number < len(kinds) else ""
            if place["exec_acquired"] <= pc < place["exec_idle"]:
                phase = "holds the list"
            elif place["exec_claim"] <= pc < place["exec_acquired"] or place["exec_next"] <= pc < place["exec_run"]:
                phase = "asks for the list"
            elif place["exec_done"] <= pc < place["exec_unknown"]:
                phase = "reports"
            elif place["exec_run"] <= pc < place["exec_done"]:
                phase = "fetches its block"
            else:
                phase = "runs" if name else "sleeps"
            seen.append((at, slot, phase, name))
    return tuple(seen)


def runs(p: Parameters) -> list[Run]:
    """Random instants and victims, as many in each phase and in each kind of task."""
    draw = random.Random(p.seed)
    table = []
    for n in p.dsps:
        for action in p.actions:
            if n == 1:
                chosen = draw.sample(looked(p, n), min(p.alone_trials, p.looks))
            else:
                by_class: dict[tuple[str, str], list[tuple[float, int, str, str]]] = {}
                for look in looked(p, n):
                    by_class.setdefault((look[2], look[3] if look[2] == "runs" else ""), []).append(look)
                chosen = [
                    look
                    for key in sorted(by_class)
                    for look in draw.sample(by_class[key], min(p.trials, len(by_class[key])))
                ]
            for at, slot, phase, kind in chosen:
                event: dict[str, Setting] = {"at_s": at, "action": action, "dsp": slot}
                label: dict[str, Setting] = {"dsps": n, "action": action, "at_s": at, "phase": phase, "kind": kind}
                table.append(Run(label, settings(p, n), round(p.latest_s + p.after_s, 9), events=[event]))
    return table


def rows(p: Parameters, done: Sequence[tuple[Run, Reports]]) -> list[Row]:
    """One row per trial. ``detected_ms``: from the event to the watchdog's first action; ``samples``: most samples of
    the servo in a row without a result
    in time."""
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


def group(own: Sequence[Row], **label: object) -> Row:
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


def verdict(p: Parameters, all_rows: Sequence[Row]) -> Verdict:
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
        f"Of {len(survivable)} failures with a DSP left, spread over all phases of a claim and {len(kinds)} kinds of "
        f"tasks, {len(in_task)} took a block with them; in {len(survivable) - len(broken)} of"
        f" {len(survivable)} every block was finished exactly once."
    )
    if servo:
        why += f" The host noticed a lost servo block after {with_interval(servo, 1)} ms"
        why += f", any other after {with_interval(long, 1)} ms, at worst {max(long):.1f} ms." if long else "."
    why += (
        f" At most {worst['samples']} samples of the servo in a row came late or never (with {worst['dsps']} "
        f"DSPs, of which the one that failed was at this: "
        f"{worst['phase']}{', ' + worst['kind'] if worst['kind'] else ''})."
    )
    last = [row for row in all_rows if row["dsps"] == 1]
    limit = ""
    if last:
        dead = [row for row in last if row["stopped"]]
        limit = (
            f"It ends with the last DSP: of {len(last)} failures of the only one, {len(dead)} ended the work, and "
            f"{sum(row['braked'] for row in dead)} of these left the crane braked."
        )
        if len(dead) < len(last):
            limit += (
                f" One that only hangs is reset and continues; that costs up to "
                f"{max(row['samples'] for row in last if not row['stopped'])} samples in a row: a DSP that holds "
                f"no block is missed only by its silence."
            )
    return Verdict("fails" if broken else "holds", why, limit)


def section(p: Parameters, all_rows: Sequence[Row]) -> str:
    columns = {
        "trials": "trials", "recomputed": "block put back", "whole": "nothing lost, work continues",
        "interval": "share, % (95 %)", "detected": "noticed after, ms",
        "samples": "servo samples missed in a row", "worst": "worst",
    }  # fmt: skip
    survivable = [row for row in all_rows if row["dsps"] > 1]
    kinds = [
        group([row for row in survivable if row["kind"] == kind and row["phase"] == "runs"], kind=kind)
        for kind in built_in_tasks()
        if any(row["kind"] == kind and row["phase"] == "runs" for row in survivable)
    ]
    phases = [group([row for row in survivable if row["phase"] == phase], phase=phase) for phase in PHASES]
    actions = [
        group([row for row in all_rows if row["dsps"] == n and row["action"] == action], dsps=n, action=action)
        for n in p.dsps
        for action in p.actions
    ]
    return (
        f"f_p {p.servo_hz:g} Hz, f_s {p.servo_hz * p.refreshes_per_servo:g} Hz, {p.agvs} AGVs that drive from the "
        f"start with obstacle avoidance ({p.avoidance}); each run ends at {p.latest_s + p.after_s:g} s. Of {p.looks} "
        f"random instants between {p.earliest_s:g} and {p.latest_s:g} s"
        f" (seed {p.seed}) it was noted what each DSP did; {p.trials} of each phase and of each kind of task were "
        "chosen for each action and number of DSPs. Identify is in all runs; with one DSP it alone costs 2 samples. "
        "Means with"
        " 95 % intervals (bootstrap; shares: Wilson) over instants, victims, actions.\n\n**By what ran when the DSP "
        "failed** (one or more DSPs left):\n\n"
        + markdown({"kind": "kind", **columns}, kinds)
        + "\n**By what the DSP was doing:**\n\n"
        + markdown({"phase": "phase", **columns}, [row for row in phases if row["trials"]])
        + "\n**By action and DSPs:**\n\n"
        + markdown({"dsps": "DSPs", "action": "what happens to one", **columns, "stopped": "work ended"}, actions)
    )


def draw(p: Parameters, all_rows: Sequence[Row], figure: Figure) -> None:
    left, right = figure.subplots(1, 2, sharey=True)
    survivable = [row for row in all_rows if row["dsps"] > 1]
    names = [
        *(k for k in built_in_tasks() if any(row["kind"] == k and row["phase"] == "runs" for row in survivable)),
        *PHASES[:-1],
    ]
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
