"""Claim 1: adding DSPs meets a given f_p and f_t, until bus or list becomes the limit."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from cmrc.results.ends import behind_identify, of, rate_limits, shared_limits
from cmrc.results.judgement import (
    SERVO,
    Row,
    Verdict,
    counted,
    demand_missed,
    markdown,
    measured,
    missed_share,
    parameter,
    percent,
    with_interval,
)
from cmrc.results.runs import Reports, Run
from cmrc.simulation import Setting

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NUMBER, NAME = 1, "dsps"
TITLE = "Adding DSPs meets a given f_p and f_t, until bus or list becomes the limit"
AGV_POINT_HZ = 50.0
P_PLUS_B_LIMIT = 0x7FFE - 0x2100
# How the AGVs' long blocks are released, and what can be done where they come together.
RELEASES: dict[str, dict[str, Setting]] = {
    "together": {"scheduling.agv_phase": "together"},
    "staggered": {"scheduling.agv_phase": "staggered"},
    "together-cap": {"scheduling.agv_phase": "together", "scheduling.long_blocks_max": 3},
    "together-slices": {"scheduling.agv_phase": "together", "scheduling.slice_cycles": 10000},
}
MEANING = {
    "together": "together",
    "staggered": "staggered",
    "together-cap": "at most 3 at a time",
    "together-slices": "in slices of 10 000 cycles",
}
SHARES = ("f_p", "f_t", "f_a", "avoidance")


@dataclass(frozen=True)
class Parameters:
    """What a user may change."""

    preset: str = parameter("saturated", "preset of the load")
    dsps: tuple[int, ...] = parameter((1, 2, 3, 4, 5, 6, 8), "numbers of DSPs that carry the load")
    releases: tuple[str, ...] = parameter(
        tuple(RELEASES), f"how the AGVs' long blocks are released: {', '.join(RELEASES)}"
    )
    load_duration_s: float = parameter(1.0, "length of a run under load, s")
    seeds: tuple[int, ...] = parameter(
        (1, 2, 3), "run.seed of the runs under load; with run.phase_jitter it draws phases and ppm of all clocks"
    )
    servo_hz: tuple[float, ...] = parameter(tuple(1000.0 * k for k in range(1, 13)), "grid of f_p at base load, Hz")
    rate_dsps: tuple[int, ...] = parameter((1, 2, 4, 8), "numbers of DSPs for that grid")
    refreshes_per_servo: int = parameter(4, "f_s / f_p of that grid")
    rate_duration_s: float = parameter(0.12, "length of a run of that grid, s")
    idle_policies: tuple[str, ...] = parameter(
        ("doorbell", "pause", "spin"), "values of machine.idle_policy, compared at base load"
    )
    policy_dsps: tuple[int, ...] = parameter((2, 4, 8, 16), "numbers of DSPs for that")
    policy_duration_s: float = parameter(0.15, "length of a run for that, s")
    refresh_hz: tuple[float, ...] = parameter(
        (8e3, 32e3, 64e3, 128e3, 192e3), "grid of f_s at base load and f_p 1 kHz, Hz"
    )
    refresh_dsps: int = parameter(4, "DSPs for that grid")
    refresh_duration_s: float = parameter(0.1, "length of a run of that grid, s")


QUICK = Parameters(
    dsps=(1, 2), releases=("together",), seeds=(1,), load_duration_s=0.04, servo_hz=(1000.0, 16000.0),
    rate_dsps=(1, 2), rate_duration_s=0.05,
    idle_policies=("doorbell", "spin"), policy_dsps=(2, 4), policy_duration_s=0.04, refresh_hz=(8000.0,),
    refresh_duration_s=0.04,
)  # fmt: skip


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
    unknown = [name for name in p.releases if name not in RELEASES]
    if unknown:
        raise ValueError(f"--releases: {unknown[0]!r} is unknown; {', '.join(RELEASES)} are possible")
    load = [
        Run(
            {"part": "load", "release": release, "dsps": n, "seed": seed},
            {"machine.dsps": n, "run.seed": seed, "run.phase_jitter": True, **RELEASES[release]},
            p.load_duration_s,
            preset=p.preset,
            group=f"load {release} {seed}",
        )
        for release in p.releases
        for seed in p.seeds
        for n in p.dsps
    ]
    every = {"report.misses_max": 1000000}
    rate = [
        Run(
            {"part": "rate", "dsps": n, "servo_hz": f},
            {"machine.dsps": n, **rates(f, p.refreshes_per_servo), **every},
            p.rate_duration_s,
            group=f"rate {f}",
        )
        for f in p.servo_hz
        for n in p.rate_dsps
    ]
    policy = [
        Run(
            {"part": "policy", "policy": policy, "dsps": n},
            {"machine.dsps": n, "machine.idle_policy": policy},
            p.policy_duration_s,
        )
        for policy in p.idle_policies
        for n in p.policy_dsps
    ]
    refresh = [
        Run(
            {"part": "refresh", "dsps": p.refresh_dsps, "refresh_hz": f},
            {"machine.dsps": p.refresh_dsps, **rates(f / 8, 8), "servo_frequency_hz": 1000.0},
            p.refresh_duration_s,
        )
        for f in p.refresh_hz
    ]
    return load + rate + policy + refresh


def rows(p: Parameters, done: Sequence[tuple[Run, Reports]]) -> list[Row]:
    table = []
    for run, reports in done:
        report = reports[-1]
        tasks, host = report["tasks"], report["host"]
        refresh_us = measured(host["refresh_duration_ps"]["mean"], 1e6)
        row: Row = {
            **run.label,
            "released": counted(report, of="released"),
            "misses": counted(report),
            "bus_a": 100 * measured(report["buses"]["A"]["utilisation"]),
            "refresh_us": refresh_us,
            "host": 100 * refresh_us * 1e-6 * report["configuration"]["rates.refresh_frequency_hz"],
            "skipped": percent(host["skipped_refreshes"], host["skipped_refreshes"] + host["refreshes"]),
            "pid_us": measured(tasks["pid"]["response_ps"]["mean"], 1e6),
            "pid_p99_us": measured(tasks["pid"]["response_ps"]["p99"], 1e6),
            "pid_run_us": measured(tasks["pid"]["execution_ps"]["mean"], 1e6),
            "streak": tasks["pid"]["longest_miss_streak"],
        }
        if run.group:
            row |= {name: missed_share(report, name) for name in ("f_p", "f_t", "f_a")}
            row |= {f"{name}_hz": report["rates"][name]["realised_hz"] for name in ("f_p", "f_t")}
            row |= {
                "avoidance": demand_missed(report, "obstacle_avoidance"),
                "block_ms": measured(tasks["obstacle_avoidance"]["execution_ps"]["mean"], 1e9),
            }
            row |= {"servo_misses": counted(report, SERVO), "behind_identify": behind_identify(report)}
        table.append(row)
    return table


def mean(rows: Sequence[Row], key: str) -> float:
    """Of the runs that have it; 0 of none."""
    known = [row[key] for row in rows if row.get(key) is not None]
    return float(np.mean(known)) if known else 0.0


def total(rows: Sequence[Row]) -> float:
    """The worst of what is missed against f_p, f_t and f_a, %."""
    return max(mean(rows, key) for key in ("f_p", "f_t", "f_a"))


def enough(p: Parameters, all_rows: Sequence[Row], release: str) -> int | None:
    """The least number of DSPs from which on no run misses anything against f_p, f_t and f_a."""
    clean = {n: not any(total([row]) for row in of(all_rows, "load", release=release, dsps=n)) for n in sorted(p.dsps)}
    return next((n for n in clean if all(good for more, good in clean.items() if more >= n)), None)


def verdict(p: Parameters, all_rows: Sequence[Row]) -> Verdict:
    found = {release: enough(p, all_rows, release) for release in p.releases if of(all_rows, "load", release=release)}
    if not found:
        return Verdict("not tested", "No load was run.", "")
    first = next(iter(found))
    fewest, most = (of(all_rows, "load", release=first, dsps=n) for n in (min(p.dsps), max(p.dsps)))
    if not total(fewest):
        return Verdict("not tested", "Nothing is missed with the fewest DSPs.", "")
    why = (
        f"Preset {p.preset}, blocks of the AGVs released {first}: with {min(p.dsps)} DSP "
        f"{mean(fewest, 'f_p'):.0f} % of f_p and {mean(fewest, 'f_t'):.0f} % of f_t are missed"
    )
    if found[first] is None:
        word = "holds in part" if total(most) < 0.1 * total(fewest) else "fails"
        why += f"; with {max(p.dsps)} still {mean(most, 'f_p'):.2g} % and {mean(most, 'f_t'):.2g} %."
    else:
        word, why = "holds", why + f", none with {found[first]} or more."
    others = [
        f"{n if n is not None else 'more than ' + str(max(p.dsps))} ({MEANING[release]}{late(p, all_rows, release, n)})"
        for release, n in found.items()
        if release != first
    ]
    if others:
        why += f" DSPs that are enough where those blocks are released otherwise: {', '.join(others)}."
    return Verdict(
        word,
        why,
        " ".join(filter(None, (plateau(p, all_rows), rate_limits(p.rate_dsps, all_rows), shared_limits(all_rows)))),
    )


def late(p: Parameters, all_rows: Sequence[Row], release: str, dsps: int | None) -> str:
    """What avoidance itself misses where f_p and f_t are met."""
    share = 0.0 if dsps is None else mean(of(all_rows, "load", release=release, dsps=dsps), "avoidance")
    return f"; {share:.0f} % of the avoidance blocks are late then" if share else ""


def plateau(p: Parameters, all_rows: Sequence[Row]) -> str:
    """Why more DSPs do not help for a while where the long blocks are released together."""
    steps = sorted(p.dsps)
    for few, more in itertools.pairwise(steps):
        a, b = (of(all_rows, "load", release="together", dsps=n) for n in (few, more))
        if a and mean(a, "f_p") > 5 and abs(mean(a, "f_p") - mean(b, "f_p")) < 3 and mean(b, "f_p") < 90:
            block, interval = mean(b, "block_ms"), 1e3 / AGV_POINT_HZ
            return (
                f"From {few} to {more} DSPs nothing is won on f_p ({mean(a, 'f_p'):.0f} % and {mean(b, 'f_p'):.0f} % "
                f"missed): this is a phase lock. The AGVs' blocks take {block:.1f} ms each and come in one refresh"
                f" every {interval:.0f} ms; with {more} DSPs all are taken at once, and the servo stands for "
                f"{100 * block / interval:.0f} % of the time."
            )
    return ""


def section(p: Parameters, all_rows: Sequence[Row]) -> str:
    table = []
    for release in p.releases:
        for n in p.dsps:
            own = of(all_rows, "load", release=release, dsps=n)
            shown = {
                key: with_interval([row[key] for row in own if row.get(key) is not None], 1)
                for key in (*SHARES, "f_p_hz", "f_t_hz")
            }
            table.append(
                {
                    "release": MEANING[release],
                    "dsps": n,
                    **shown,
                    "streak": max((row["streak"] for row in own), default=None),
                    "bus_a": mean(own, "bus_a"),
                }
            )
    columns = {
        "release": "long blocks", "dsps": "DSPs", "f_p": "f_p missed, %", "f_t": "f_t missed, %",
        "f_a": "f_a missed, %", "avoidance": "avoidance missed, %", "f_p_hz": "f_p realised, Hz",
        "f_t_hz": "f_t realised, Hz", "streak": "missed samples in a row", "bus_a": "bus A, %",
    }  # fmt: skip
    text = (
        f"**Load.** Preset {p.preset}: the AGVs drive. {p.load_duration_s:g} s from power-on; nothing is left out, "
        "identify is in it. Shares are of what the ideal run demands ([report.md](report.md), Rates). Each row has"
        f" {len(p.seeds)} run{'s' if len(p.seeds) > 1 else ''}; the seed draws phases and ppm of all clocks "
        "(`run.phase_jitter`) and the sensors' noise. Means, with 95 % intervals (bootstrap) where the runs differ.\n\n"
    )
    text += markdown(columns, table)
    text += (
        f"\n**Rate.** Base load, f_s = {p.refreshes_per_servo} f_p, {p.rate_duration_s:g} s from power-on each. Missed "
        "against f_p, %; in brackets the missed jobs of the servo, and how many of them"
        " waited for the identify block, which nothing can interrupt:\n\n"
    )
    grid = []
    for f in p.servo_hz:
        cells: Row = {"servo": f / 1000}
        for n in p.rate_dsps:
            cells |= {
                str(n): f"{row['f_p']:.3g} ({row['servo_misses']}, {row['behind_identify']})"
                if row["servo_misses"]
                else "0"
                for row in of(all_rows, "rate", dsps=n, servo_hz=f)
            }
        grid.append(cells)
    text += markdown({"servo": "f_p, kHz", **{str(n): f"{n} DSPs" if n > 1 else "1 DSP" for n in p.rate_dsps}}, grid)
    text += f"\n**Idle policy.** Base load and rates, {p.policy_duration_s:g} s.\n\n"
    columns = {
        "policy": "policy",
        "dsps": "DSPs",
        "bus_a": "bus A, %",
        "refresh_us": "refresh, µs",
        "skipped": "refreshes left out, %",
        "pid_us": "PID response, µs",
        "pid_p99_us": "p99, µs",
        "misses": "missed",
    }
    text += markdown(columns, of(all_rows, "policy"))
    text += f"\n**f_s.** {p.refresh_dsps} DSPs, f_p 1 kHz, base load, {p.refresh_duration_s:g} s.\n\n"
    columns = {
        "refresh_hz": "f_s, Hz",
        "refresh_us": "refresh, µs",
        "host": "of its interval, %",
        "skipped": "left out, %",
        "bus_a": "bus A, %",
        "pid_us": "PID response, µs",
        "misses": "missed",
    }
    return text + markdown(columns, of(all_rows, "refresh"))


def draw(p: Parameters, all_rows: Sequence[Row], figure: Figure) -> None:
    left, right = figure.subplots(1, 2)
    for release, mark in zip(p.releases, ("o-", "s-", "^--", "v:"), strict=False):
        left.plot(
            p.dsps,
            [mean(of(all_rows, "load", release=release, dsps=n), "f_p") for n in p.dsps],
            mark,
            label=MEANING[release],
            markersize=5,
        )
    left.set(xlabel="DSPs", ylabel="f_p missed, %", title=f"preset {p.preset}: long blocks", ylim=(-3, 103))
    left.legend(fontsize=7, loc="upper right")
    for policy, mark in zip(p.idle_policies, ("o-", "s-", "^--"), strict=False):
        own = of(all_rows, "policy", policy=policy)
        right.plot([row["dsps"] for row in own], [row["bus_a"] for row in own], mark, label=policy)
    right.set(xlabel="DSPs", ylabel="bus A in use, %", title="idle policies at base load", ylim=(0, 103))
    right.legend(fontsize=8)
