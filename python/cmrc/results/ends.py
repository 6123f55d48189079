"""What ends the gain of more DSPs (claim 1): identify, the PID block itself, bus A, the host's refresh of the list."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from cmrc.results.judgement import SERVO, Row, of
from cmrc.results.runs import Report


def behind_identify(report: Report) -> int:
    """Missed jobs of the servo that waited for the identify block, or for one that did (their chains of causes say
    so)."""
    missed = {(m["kind"], m["number"]): m for m in report["misses"] if m["kind"] in SERVO}

    def waited(miss: Mapping[str, Any] | None) -> bool:
        if miss is None:
            return False
        if miss["previous"] is not None:
            return waited(missed.get((miss["kind"], miss["previous"])))
        return any(block["kind"] == "identify" for block in miss["behind"])

    return sum(waited(miss) for miss in missed.values())


def highest_rate(all_rows: Sequence[Row], dsps: int, but_identify: bool = False) -> float | None:
    """The largest f_p of the grid up to which every point passes without a miss; ``but_identify``: leaving out what
    waited for identify."""
    best = None
    for row in sorted(of(all_rows, part="rate", dsps=dsps), key=lambda row: float(row["servo_hz"])):
        if row["misses"] - (row["behind_identify"] if but_identify else 0):
            break
        best = float(row["servo_hz"])
    return best


def first_failure(all_rows: Sequence[Row], dsps: int) -> Row | None:
    failing = [row for row in of(all_rows, part="rate", dsps=dsps) if row["misses"]]
    return min(failing, key=lambda row: float(row["servo_hz"])) if failing else None


def cause(row: Row) -> str:
    """What a row with misses has run out of."""
    if row["bus_a"] > 80:
        return f"bus A ({row['bus_a']:.0f} % in use)"
    if row["skipped"] > 5 or row["host"] > 90:
        return (
            f"the host's refresh of the list ({row['refresh_us']:.1f} µs, {row['host']:.0f} % of a refresh "
            f"interval; {row['skipped']:.0f} % of the refreshes are left out)"
        )
    period = 1e6 / row["servo_hz"]
    if row["pid_run_us"] > 0.7 * period:
        return (
            f"the PID block itself, which no other DSP can share ({row['pid_run_us']:.0f} µs of a period of "
            f"{period:.0f} µs)"
        )
    return f"DSPs: bus A is {row['bus_a']:.0f} % in use, the refresh takes {row['host']:.0f} % of its interval"


def rate_limits(dsps: Sequence[int], all_rows: Sequence[Row]) -> str:
    """The highest f_p that these numbers of DSPs serve without a miss, and what ends it."""
    if not of(all_rows, part="rate"):
        return ""
    best = {n: highest_rate(all_rows, n) for n in dsps}
    known = {n: f for n, f in best.items() if f is not None}
    text = ""
    for n in (n for n, f in best.items() if f is None):
        but = highest_rate(all_rows, n, but_identify=True)
        text += (
            f"At base load {n} DSP{'s' if n > 1 else ''} miss{'es' if n == 1 else ''} some jobs at every f_p of "
            f"the grid"
        )
        text += f": up to {but / 1000:g} kHz those that wait for identify, and no other. " if but else ". "
    if not known:
        return text.strip()
    top = max(known.values())
    least = min(n for n, f in known.items() if f == top)
    text += (
        "The highest f_p without any miss is "
        + ", ".join(f"{f / 1000:g} kHz with {n}" for n, f in known.items() if n <= least)
        + " DSPs"
    )
    failing = first_failure(all_rows, max(dsps))
    return text + (
        ": the grid ends there."
        if failing is None
        else f"; more DSPs do not help from there on. The limit is {cause(failing)}."
    )


def shared_limits(all_rows: Sequence[Row]) -> str:
    """From where on bus A and the list are the limit."""
    text = ""
    for policy in dict.fromkeys(row["policy"] for row in of(all_rows, part="policy")):
        full = [row for row in of(all_rows, part="policy", policy=policy) if row["bus_a"] > 95]
        if full:
            worst = max(full, key=lambda row: int(row["dsps"]))
            text += (
                f" With idle policy {policy} bus A is full from {min(row['dsps'] for row in full)} DSPs on; with "
                f"{worst['dsps']} a refresh takes {worst['refresh_us']:.0f} µs and"
                f" the PID's answer {worst['pid_us']:.0f} µs: there more DSPs make it worse."
            )
    late = [row for row in of(all_rows, part="refresh") if row["skipped"] > 1]
    if late:
        first = min(late, key=lambda row: float(row["refresh_hz"]))
        text += (
            f" The list is the limit from f_s = {first['refresh_hz'] / 1000:g} kHz on: {first['skipped']:.0f} % "
            f"of the refreshes find the one before still under way."
        )
    elif of(all_rows, part="refresh"):
        most = max(of(all_rows, part="refresh"), key=lambda row: float(row["refresh_hz"]))
        text += (
            f" The list is no limit up to f_s = {most['refresh_hz'] / 1000:g} kHz, where a refresh takes "
            f"{most['host']:.0f} % of its interval."
        )
    return text.strip()
