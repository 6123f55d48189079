"""Claim 2: a DSP can be pulled out or fail in mid-task and nothing is lost."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cmrc.results.dsps import rates
from cmrc.results.judgement import SERVO, Row, Verdict, counted, markdown, share_interval, with_interval
from cmrc.results.runs import Reports, Run
from cmrc.simulation import Setting

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NUMBER, NAME = 2, "failures"
TITLE = "A DSP can be pulled out or fail in mid-task and nothing is lost"


@dataclass(frozen=True)
class Parameters:
    """What a user may change."""

    dsps: tuple[int, ...] = (1, 2, 3)
    actions: tuple[str, ...] = ("fail", "hang", "unplug")
    servo_hz: float = 4000.0
    refreshes_per_servo: int = 4
    trials: int = 25
    seed: int = 1
    duration_s: float = 0.12
    alone_s: float = 0.22
    """Duration with one DSP, so that the drives' time-out of 0.1 s falls into it."""
    earliest_s: float = 0.05
    latest_s: float = 0.08


QUICK = Parameters(dsps=(1, 2), actions=("fail",), trials=2, duration_s=0.09, alone_s=0.09)


def settings(p: Parameters, dsps: int) -> dict[str, Setting]:
    return {"machine.dsps": dsps, **rates(p.servo_hz, p.refreshes_per_servo)}


def runs(p: Parameters) -> list[Run]:
    """Random instants and victims."""
    draw = random.Random(p.seed)
    table = []
    for n in p.dsps:
        for action in p.actions:
            for _ in range(p.trials):
                at = round(draw.uniform(p.earliest_s, p.latest_s), 9)
                event: dict[str, Setting] = {"at_s": at, "action": action, "dsp": draw.randrange(n)}
                table.append(Run({"dsps": n, "action": action, "at_s": at}, settings(p, n), p.alone_s if n == 1 else p.duration_s, events=[event], stops_s=(p.earliest_s,)))
    return table


def rows(p: Parameters, done: Sequence[tuple[Run, Reports]]) -> list[Row]:
    """One row per trial. ``detected_ms``: from the event to the watchdog's first action; ``samples``: nominal ticks of the servo without a
    result in time."""
    table = []
    for run, reports in done:
        report = reports[-1]
        at = float(run.label["at_s"])
        watchdog = [f["time_s"] for f in report["failures"] if f["kind"] == "watchdog" and f["time_s"] >= at]
        table.append(
            {
                **run.label,
                "samples": max(counted(report, [kind]) - counted(reports[0], [kind]) for kind in SERVO),
                "lost": counted(report, of="lost"),
                "recomputed": report["host"]["recomputed"],
                "violations": len(report["audit"]["violations"]),
                "detected_ms": (min(watchdog) - at) * 1e3 if watchdog else None,
                "stopped": report["stop_reason"] == "no_dsp_left" or all(d["state"] not in ("running", "idle") for d in report["dsps"]),
                "braked": bool(report["braked"]),
            }
        )
    return table


def group(p: Parameters, all_rows: Sequence[Row], dsps: int, action: str) -> Row:
    own = [row for row in all_rows if row["dsps"] == dsps and row["action"] == action]
    hit = [row for row in own if row["recomputed"]]
    whole = sum(1 for row in own if not row["lost"] and not row["violations"] and not row["stopped"])
    low, high = share_interval(whole, len(own))
    return {
        "dsps": dsps,
        "action": action,
        "trials": len(own),
        "in mid-task": len(hit),
        "whole": whole,
        "interval": f"{100 * low:.0f} to {100 * high:.0f}",
        "detected": with_interval([row["detected_ms"] for row in own if row["detected_ms"] is not None]),
        "samples": with_interval([float(row["samples"]) for row in hit]),
        "worst": max((row["samples"] for row in own), default=0),
        "stopped": sum(row["stopped"] for row in own),
    }


def verdict(p: Parameters, all_rows: Sequence[Row]) -> Verdict:
    survivable = [row for row in all_rows if row["dsps"] > 1]
    in_task = [row for row in survivable if row["recomputed"]]
    if not in_task:
        return Verdict("not tested", "No failure hit a DSP in mid-task and left another.", "")
    broken = [row for row in survivable if row["lost"] or row["violations"]]
    detected = [row["detected_ms"] for row in in_task if row["detected_ms"] is not None]
    samples = [float(row["samples"]) for row in in_task]
    why = (
        f"Of {len(survivable)} failures with a DSP left, {len(in_task)} came in mid-task; in {len(survivable) - len(broken)} every block was finished exactly once."
        f" The watchdog noticed after {with_interval(detected)} ms; {with_interval(samples)} samples of the servo came late or never"
        f" (means, 95 % intervals), at most {max(samples):.0f}: {1e3 * max(samples) / p.servo_hz:.3g} ms."
    )
    last = [row for row in all_rows if row["dsps"] == 1]
    limit = ""
    if last:
        dead = [row for row in last if row["stopped"]]
        limit = f"It ends with the last DSP: of {len(last)} failures of the only one, {len(dead)} ended the work, and {sum(row['braked'] for row in dead)} of these left the crane braked."
        if len(dead) < len(last):
            between = [row["samples"] for row in last if not row["stopped"] and not row["recomputed"]]
            limit += " One that only hangs is reset and goes on"
            limit += f"; hung between two blocks it costs up to {max(between)} samples, for it holds nothing that the watchdog could miss." if between else "."
    return Verdict("fails" if broken else "holds", why, limit)


def section(p: Parameters, all_rows: Sequence[Row]) -> str:
    columns = {
        "dsps": "DSPs",
        "action": "what happens to one",
        "trials": "trials",
        "in mid-task": "in mid-task",
        "whole": "nothing lost, work goes on",
        "interval": "share, % (95 %)",
        "detected": "noticed after, ms",
        "samples": "servo samples missed",
        "worst": "worst",
        "stopped": "work ended",
    }
    table = [group(p, all_rows, n, action) for n in p.dsps for action in p.actions]
    return (
        f"f_p {p.servo_hz:g} Hz, f_s {p.servo_hz * p.refreshes_per_servo:g} Hz, {p.duration_s:g} s (with one DSP {p.alone_s:g} s); a random DSP at a random instant between {p.earliest_s:g} and {p.latest_s:g} s, seed {p.seed}. Means with 95 % intervals (bootstrap; shares:"
        f" Wilson). A block of a kind's usual length is given up after 16 refreshes at least ({16e3 / (p.servo_hz * p.refreshes_per_servo):.2g} ms).\n\n" + markdown(columns, table)
    )


def draw(p: Parameters, all_rows: Sequence[Row], figure: Figure) -> None:
    left, right = figure.subplots(1, 2)
    in_task = [row for row in all_rows if row["recomputed"] and row["dsps"] > 1]
    left.hist([row["detected_ms"] for row in in_task if row["detected_ms"] is not None], bins=20)
    left.set(xlabel="from failure to the watchdog's action, ms", ylabel="trials")
    right.hist([row["samples"] for row in in_task], bins=[i - 0.5 for i in range(int(max((row["samples"] for row in in_task), default=3)) + 2)])
    right.set(xlabel="servo samples late or never", ylabel="trials")
