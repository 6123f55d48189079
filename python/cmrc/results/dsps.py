"""Claim 1: adding DSPs meets a given f_p and f_t, until bus or list becomes the limit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cmrc.results.judgement import SERVO, Row, Verdict, counted, markdown, percent
from cmrc.results.runs import Reports, Run
from cmrc.simulation import Setting

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NUMBER, NAME = 1, "dsps"
TITLE = "Adding DSPs meets a given f_p and f_t, until bus or list becomes the limit"
AGV_POINT_HZ = 50.0
P_PLUS_B_LIMIT = 0x7FFE - 0x2100


@dataclass(frozen=True)
class Parameters:
    """What a user may change."""

    preset: str = "saturated"
    dsps: tuple[int, ...] = (1, 2, 3, 4, 5, 6, 8, 12, 16)
    load_duration_s: float = 1.2
    servo_hz: tuple[float, ...] = tuple(1000.0 * k for k in range(1, 13))
    rate_dsps: tuple[int, ...] = (1, 2, 4, 8, 16)
    refreshes_per_servo: int = 4
    rate_duration_s: float = 0.14
    warm_up_s: float = 0.04
    """Of the runs that look for the highest rate; what is missed before is not counted (the identify block of 2 ms)."""
    idle_policies: tuple[str, ...] = ("doorbell", "pause", "spin")
    policy_dsps: tuple[int, ...] = (2, 4, 8, 16)
    policy_duration_s: float = 0.22
    refresh_hz: tuple[float, ...] = (8e3, 16e3, 32e3, 64e3, 96e3, 128e3, 160e3, 192e3)
    refresh_dsps: int = 4
    refresh_duration_s: float = 0.1


QUICK = Parameters(
    dsps=(1, 2), load_duration_s=0.04, servo_hz=(1000.0, 16000.0), rate_dsps=(1, 2), rate_duration_s=0.05, idle_policies=("doorbell", "spin"), policy_dsps=(2, 4), policy_duration_s=0.04, refresh_hz=(8000.0,), refresh_duration_s=0.04
)


def rates(servo_hz: float, refreshes: int) -> dict[str, Setting]:
    """f_p with f_s = ``refreshes`` times as much; N̂_a,max and a so that the invariants of equation (7) hold."""
    refresh_hz = servo_hz * refreshes
    longest = int(2 * refresh_hz / AGV_POINT_HZ)
    return {
        "servo_frequency_hz": float(servo_hz),
        "refresh_frequency_hz": float(refresh_hz),
        "scheduling.agv_interval_max_refreshes": longest,
        "scheduling.a": max(1, min(0x40, P_PLUS_B_LIMIT // longest)),
    }


def runs(p: Parameters) -> list[Run]:
    load = [Run({"part": "load", "dsps": n}, {"machine.dsps": n}, p.load_duration_s, preset=p.preset) for n in p.dsps]
    rate = [
        Run({"part": "rate", "dsps": n, "servo_hz": f}, {"machine.dsps": n, **rates(f, p.refreshes_per_servo)}, p.rate_duration_s, stops_s=(p.warm_up_s,))
        for n in p.rate_dsps
        for f in p.servo_hz
    ]
    policy = [
        Run({"part": "policy", "policy": policy, "dsps": n}, {"machine.dsps": n, "machine.idle_policy": policy}, p.policy_duration_s)
        for policy in p.idle_policies
        for n in p.policy_dsps
    ]
    refresh = [
        Run({"part": "refresh", "dsps": p.refresh_dsps, "refresh_hz": f}, {"machine.dsps": p.refresh_dsps, **rates(f / 8, 8), "servo_frequency_hz": 1000.0}, p.refresh_duration_s)
        for f in p.refresh_hz
    ]
    return load + rate + policy + refresh


def rows(p: Parameters, done: Sequence[tuple[Run, Reports]]) -> list[Row]:
    table = []
    for run, reports in done:
        report = reports[-1]
        tasks, host = report["tasks"], report["host"]
        refresh_us = host["refresh_duration_ps"]["mean"] / 1e6
        refresh_hz = report["configuration"]["rates.refresh_frequency_hz"]
        begin = reports[0] if len(reports) > 1 else None
        count = {of: counted(report, of=of) - (counted(begin, of=of) if begin else 0) for of in ("released", "misses")}
        table.append(
            {
                **run.label,
                **count,
                "missed": percent(count["misses"], count["released"]),
                "servo_missed": percent(counted(report, SERVO), counted(report, SERVO, "released")),
                "bus_a": 100 * report["buses"]["A"]["utilisation"],
                "refresh_us": refresh_us,
                "host": 100 * refresh_us * 1e-6 * refresh_hz,
                "skipped": percent(host["skipped_refreshes"], host["skipped_refreshes"] + host["refreshes"]),
                "pid_us": tasks["pid"]["response_ps"]["mean"] / 1e6,
                "pid_p99_us": tasks["pid"]["response_ps"]["p99"] / 1e6,
                "pid_run_us": tasks["pid"]["execution_ps"]["mean"] / 1e6,
            }
        )
    return table


def of(all_rows: Sequence[Row], part: str, **label: object) -> list[Row]:
    return [row for row in all_rows if row["part"] == part and all(row[key] == value for key, value in label.items())]


def highest_rate(all_rows: Sequence[Row], dsps: int) -> float | None:
    """The largest f_p of the grid up to which every point passes without a miss."""
    best = None
    for row in sorted(of(all_rows, "rate", dsps=dsps), key=lambda row: float(row["servo_hz"])):
        if row["misses"]:
            break
        best = float(row["servo_hz"])
    return best


def first_failure(all_rows: Sequence[Row], dsps: int) -> Row | None:
    failing = [row for row in of(all_rows, "rate", dsps=dsps) if row["misses"]]
    return min(failing, key=lambda row: float(row["servo_hz"])) if failing else None


def cause(row: Row) -> str:
    """What a row with misses has run out of."""
    if row["bus_a"] > 80:
        return f"bus A ({row['bus_a']:.0f} % in use)"
    if row["skipped"] > 5 or row["host"] > 90:
        return f"the host's refresh of the list ({row['refresh_us']:.1f} µs, {row['host']:.0f} % of a refresh interval; {row['skipped']:.0f} % of the refreshes are left out)"
    period = 1e6 / row["servo_hz"]
    if row["pid_run_us"] > 0.7 * period:
        return f"the PID block itself, which no other DSP can share ({row['pid_run_us']:.0f} µs of a period of {period:.0f} µs)"
    return f"DSPs: bus A is {row['bus_a']:.0f} % in use, the refresh takes {row['host']:.0f} % of its interval"


def verdict(p: Parameters, all_rows: Sequence[Row]) -> Verdict:
    load = sorted(of(all_rows, "load"), key=lambda row: int(row["dsps"]))
    if not load or not load[0]["misses"]:
        return Verdict("not tested", "Nothing is missed with the fewest DSPs.", "")
    enough = next((row["dsps"] for i, row in enumerate(load) if not any(r["misses"] for r in load[i:])), None)
    why = f"Under the load of preset {p.preset}, {load[0]['missed']:.0f} % of all jobs are missed with {load[0]['dsps']} DSP"
    if enough is None:
        fell = load[-1]["missed"] < 0.1 * load[0]["missed"]
        return Verdict("holds in part" if fell else "fails", f"{why}, still {load[-1]['missed']:.2g} % with {load[-1]['dsps']}.", "")
    why += f", none with {enough} or more."
    best = {n: highest_rate(all_rows, n) for n in p.rate_dsps}
    known = {n: f for n, f in best.items() if f is not None}
    if not known:
        return Verdict("holds", why, "At the rates tried, no number of DSPs is without a miss.")
    top = max(known.values())
    least = min(n for n, f in known.items() if f == top)
    limit = "At base load the highest f_p without a miss is " + ", ".join(f"{f / 1000:g} kHz with {n}" for n, f in known.items() if n <= least) + " DSPs"
    failing = first_failure(all_rows, max(p.rate_dsps))
    if failing is None:
        return Verdict("holds", why, limit + ": the grid ends there." + shared_limits(all_rows))
    return Verdict("holds", why, f"{limit}; more DSPs do not help from there on. The limit is {cause(failing)}." + shared_limits(all_rows))


def shared_limits(all_rows: Sequence[Row]) -> str:
    """From where on bus A and the list are the limit."""
    text = ""
    for policy in dict.fromkeys(row["policy"] for row in of(all_rows, "policy")):
        full = [row for row in of(all_rows, "policy", policy=policy) if row["bus_a"] > 95]
        if full:
            worst = max(full, key=lambda row: int(row["dsps"]))
            text += (
                f" With idle policy {policy} bus A is full from {min(row['dsps'] for row in full)} DSPs on; with {worst['dsps']} a refresh takes {worst['refresh_us']:.0f} µs and"
                f" the PID's answer {worst['pid_us']:.0f} µs: there more DSPs make it worse."
            )
    late = [row for row in of(all_rows, "refresh") if row["skipped"] > 1]
    if late:
        first = min(late, key=lambda row: float(row["refresh_hz"]))
        text += f" The list is the limit from f_s = {first['refresh_hz'] / 1000:g} kHz on: {first['skipped']:.0f} % of the refreshes find the one before still under way."
    elif of(all_rows, "refresh"):
        most = max(of(all_rows, "refresh"), key=lambda row: float(row["refresh_hz"]))
        text += f" The list is no limit up to f_s = {most['refresh_hz'] / 1000:g} kHz, where a refresh takes {most['host']:.0f} % of its interval."
    return text


def policies(all_rows: Sequence[Row]) -> str:
    """What the idle policies cost."""
    found = of(all_rows, "policy")
    if not found:
        return ""
    most = max(row["dsps"] for row in found)
    sentences = [
        f"{row['policy']}: bus A {row['bus_a']:.0f} %, a refresh {row['refresh_us']:.1f} µs, {row['misses']} missed" for row in found if row["dsps"] == most
    ]
    return f"With {most} DSPs that have almost nothing to do: " + "; ".join(sentences) + ".\n\n"


def section(p: Parameters, all_rows: Sequence[Row]) -> str:
    text = f"**Load.** Preset {p.preset}, {p.load_duration_s:g} s.\n\n"
    text += markdown({"dsps": "DSPs", "released": "jobs", "misses": "missed", "missed": "missed, %", "servo_missed": "of the servo, %", "bus_a": "bus A, %"}, of(all_rows, "load"))
    text += f"\n**Rate.** Base load, f_s = {p.refreshes_per_servo} f_p, {p.rate_duration_s:g} s each. Missed jobs, %:\n\n"
    grid = [
        {"servo": f / 1000, **{str(n): next((row["missed"] for row in of(all_rows, "rate", dsps=n, servo_hz=f)), None) for n in p.rate_dsps}}
        for f in p.servo_hz
    ]
    text += markdown({"servo": "f_p, kHz", **{str(n): f"{n} DSPs" if n > 1 else "1 DSP" for n in p.rate_dsps}}, grid)
    text += "\n**Idle policy.** Base load and rates. " + policies(all_rows)
    columns = {"policy": "policy", "dsps": "DSPs", "bus_a": "bus A, %", "refresh_us": "refresh, µs", "skipped": "refreshes left out, %", "pid_us": "PID response, µs", "pid_p99_us": "p99, µs", "misses": "missed"}
    text += markdown(columns, of(all_rows, "policy"))
    text += f"\n**f_s.** {p.refresh_dsps} DSPs, f_p 1 kHz, base load.\n\n"
    columns = {"refresh_hz": "f_s, Hz", "refresh_us": "refresh, µs", "host": "of its interval, %", "skipped": "left out, %", "bus_a": "bus A, %", "pid_us": "PID response, µs", "misses": "missed"}
    return text + markdown(columns, of(all_rows, "refresh"))


def draw(p: Parameters, all_rows: Sequence[Row], figure: Figure) -> None:
    left, right = figure.subplots(1, 2)
    load = of(all_rows, "load")
    left.plot([row["dsps"] for row in load], [row["missed"] for row in load], "o-")
    left.set(xlabel="DSPs", ylabel="missed jobs, %", title=f"preset {p.preset}", ylim=(0, None))
    for policy in p.idle_policies:
        own = of(all_rows, "policy", policy=policy)
        right.plot([row["dsps"] for row in own], [row["bus_a"] for row in own], "o-", label=policy)
    right.set(xlabel="DSPs", ylabel="bus A in use, %", title="idle policies at base load", ylim=(0, 100))
    right.legend(fontsize=8)
