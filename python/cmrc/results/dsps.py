"""Claim 1: adding DSPs meets a given f_p and f_t, until bus or list becomes the limit."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from cmrc.results.claim import Claim, parameter
from cmrc.results.ends import behind_identify, rate_limits, shared_limits
from cmrc.results.judgement import (
    SERVO,
    Row,
    Verdict,
    counted,
    demand_missed,
    markdown,
    mean,
    measured,
    missed_share,
    of,
    percent,
    with_interval,
)
from cmrc.results.runs import Reports, Run
from cmrc.simulation import Setting

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
class Dsps(Claim):
    """A load that wants many DSPs, and three grids at base load: of f_p, of idle policies and of f_s."""

    NUMBER, NAME = 1, "dsps"
    TITLE = "Adding DSPs meets a given f_p and f_t, until bus or list becomes the limit"
    PART = "part"
    PARTS: ClassVar = {"load": "Load", "rate": "Rate", "policy": "Idle policy", "refresh": "f_s"}
    LABELS: ClassVar = {
        "dsps": "{} DSPs", "seed": "seed {}", "servo_hz": "f_p {} Hz", "refresh_hz": "f_s {} Hz", "policy": "{}",
    }  # fmt: skip

    preset: str = parameter("saturated", "preset of the load")
    dsps: tuple[int, ...] = parameter((1, 2, 3, 4, 5, 6, 8), "numbers of DSPs that carry the load", quick=(1, 2))
    releases: tuple[str, ...] = parameter(
        tuple(RELEASES), f"how the AGVs' long blocks are released: {', '.join(RELEASES)}", quick=("together",)
    )
    load_duration_s: float = parameter(1.0, "length of a run under load, s", quick=0.04)
    seeds: tuple[int, ...] = parameter(
        (1, 2, 3),
        "run.seed of the runs under load; with run.phase_jitter it draws phases and ppm of all clocks",
        quick=(1,),
    )
    servo_hz: tuple[float, ...] = parameter(
        tuple(1000.0 * k for k in range(1, 13)), "grid of f_p at base load, Hz", quick=(1000.0, 16000.0)
    )
    rate_dsps: tuple[int, ...] = parameter((1, 2, 4, 8), "numbers of DSPs for that grid", quick=(1, 2))
    refreshes_per_servo: int = parameter(4, "f_s / f_p of that grid", least=1)
    rate_duration_s: float = parameter(0.12, "length of a run of that grid, s", quick=0.05)
    idle_policies: tuple[str, ...] = parameter(
        ("doorbell", "pause", "spin"),
        "values of machine.idle_policy, compared at base load",
        quick=("doorbell", "spin"),
    )
    policy_dsps: tuple[int, ...] = parameter((2, 4, 8, 16), "numbers of DSPs for that", quick=(2, 4))
    policy_duration_s: float = parameter(0.15, "length of a run for that, s", quick=0.04)
    refresh_hz: tuple[float, ...] = parameter(
        (8e3, 32e3, 64e3, 128e3, 192e3), "grid of f_s at base load and f_p 1 kHz, Hz", quick=(8000.0,)
    )
    refresh_dsps: int = parameter(4, "DSPs for that grid")
    refresh_duration_s: float = parameter(0.1, "length of a run of that grid, s", quick=0.04)

    def named(self, label: str, value: Setting) -> str:
        return MEANING.get(str(value), str(value)) if label == "release" else super().named(label, value)

    def runs(self) -> list[Run]:
        return self.load_runs() + self.rate_runs() + self.policy_runs() + self.refresh_runs()

    def load_runs(self) -> list[Run]:
        unknown = [name for name in self.releases if name not in RELEASES]
        if unknown:
            raise ValueError(f"--releases: {unknown[0]!r} is unknown; {', '.join(RELEASES)} are possible")
        return [
            Run(
                {"part": "load", "release": release, "dsps": n, "seed": seed},
                {"machine.dsps": n, "run.seed": seed, "run.phase_jitter": True, **RELEASES[release]},
                self.load_duration_s,
                preset=self.preset,
                group=f"load {release} {seed}",
            )
            for release in self.releases
            for seed in self.seeds
            for n in self.dsps
        ]

    def rate_runs(self) -> list[Run]:
        return [
            Run(
                {"part": "rate", "dsps": n, "servo_hz": f},
                {"machine.dsps": n, **rates(f, self.refreshes_per_servo), "report.misses_max": 1000000},
                self.rate_duration_s,
                group=f"rate {f}",
            )
            for f in self.servo_hz
            for n in self.rate_dsps
        ]

    def policy_runs(self) -> list[Run]:
        return [
            Run(
                {"part": "policy", "policy": policy, "dsps": n},
                {"machine.dsps": n, "machine.idle_policy": policy},
                self.policy_duration_s,
            )
            for policy in self.idle_policies
            for n in self.policy_dsps
        ]

    def refresh_runs(self) -> list[Run]:
        return [
            Run(
                {"part": "refresh", "dsps": self.refresh_dsps, "refresh_hz": f},
                {"machine.dsps": self.refresh_dsps, **rates(f / 8, 8), "servo_frequency_hz": 1000.0},
                self.refresh_duration_s,
            )
            for f in self.refresh_hz
        ]

    def rows(self, done: Sequence[tuple[Run, Reports]]) -> list[Row]:
        table = []
        for run, reports in done:
            report = reports[-1]
            tasks, host = report["tasks"], report["host"]
            refresh_us = measured(host["refresh_duration_ps"]["mean"], 1e6)
            row: Row = {
                **run.label,
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
                    "servo_misses": counted(report, SERVO),
                    "behind_identify": behind_identify(report),
                }
            table.append(row)
        return table

    def enough(self, all_rows: Sequence[Row], release: str) -> int | None:
        """The least number of DSPs from which on no run misses anything against f_p, f_t and f_a."""
        missing = {row["dsps"] for row in of(all_rows, part="load", release=release) if total([row])}
        return next((n for n in sorted(self.dsps) if not missing or n > max(missing)), None)

    def verdict(self, all_rows: Sequence[Row]) -> Verdict:
        found = {
            release: self.enough(all_rows, release)
            for release in self.releases
            if of(all_rows, part="load", release=release)
        }
        if not found:
            return Verdict("not tested", "No load was run.", "")
        first = next(iter(found))
        fewest, most = (of(all_rows, part="load", release=first, dsps=n) for n in (min(self.dsps), max(self.dsps)))
        if not total(fewest):
            return Verdict("not tested", "Nothing is missed with the fewest DSPs.", "")
        why = (
            f"Preset {self.preset}, blocks of the AGVs released {first}: with {min(self.dsps)} DSP "
            f"{mean(fewest, 'f_p'):.0f} % of f_p and {mean(fewest, 'f_t'):.0f} % of f_t are missed"
        )
        if found[first] is None:
            word = "holds in part" if total(most) < 0.1 * total(fewest) else "fails"
            why += f"; with {max(self.dsps)} still {mean(most, 'f_p'):.2g} % and {mean(most, 'f_t'):.2g} %."
        else:
            word, why = "holds", why + f", none with {found[first]} or more."
        others = [
            f"{n or f'more than {max(self.dsps)}'} ({MEANING[release]}{late(all_rows, release, n)})"
            for release, n in found.items()
            if release != first
        ]
        if others:
            why += f" DSPs that are enough where those blocks are released otherwise: {', '.join(others)}."
        limits = (self.plateau(all_rows), rate_limits(self.rate_dsps, all_rows), shared_limits(all_rows))
        return Verdict(word, why, " ".join(filter(None, limits)))

    def plateau(self, all_rows: Sequence[Row]) -> str:
        """Why more DSPs do not help for a while where the long blocks are released together."""
        for few, more in itertools.pairwise(sorted(self.dsps)):
            a, b = (of(all_rows, part="load", release="together", dsps=n) for n in (few, more))
            if a and mean(a, "f_p") > 5 and abs(mean(a, "f_p") - mean(b, "f_p")) < 3 and mean(b, "f_p") < 90:
                block, interval = mean(b, "block_ms"), 1e3 / AGV_POINT_HZ
                return (
                    f"From {few} to {more} DSPs nothing is won on f_p ({mean(a, 'f_p'):.0f} % and "
                    f"{mean(b, 'f_p'):.0f} % missed): this is a phase lock. The AGVs' blocks take {block:.1f} ms each "
                    f"and come in one refresh every {interval:.0f} ms; with {more} DSPs all are taken at once, and the "
                    f"servo stands for {100 * block / interval:.0f} % of the time."
                )
        return ""

    def section(self, all_rows: Sequence[Row]) -> str:
        columns = {
            "policy": "policy", "dsps": "DSPs", "bus_a": "bus A, %", "refresh_us": "refresh, µs",
            "skipped": "refreshes left out, %", "pid_us": "PID response, µs", "pid_p99_us": "p99, µs",
            "misses": "missed",
        }  # fmt: skip
        text = self.load_section(all_rows) + self.rate_section(all_rows)
        text += f"\n**Idle policy.** Base load and rates, {self.policy_duration_s:g} s.\n\n"
        text += markdown(columns, of(all_rows, part="policy"))
        columns = {
            "refresh_hz": "f_s, Hz", "refresh_us": "refresh, µs", "host": "of its interval, %",
            "skipped": "left out, %", "bus_a": "bus A, %", "pid_us": "PID response, µs", "misses": "missed",
        }  # fmt: skip
        text += f"\n**f_s.** {self.refresh_dsps} DSPs, f_p 1 kHz, base load, {self.refresh_duration_s:g} s.\n\n"
        return text + markdown(columns, of(all_rows, part="refresh"))

    def load_section(self, all_rows: Sequence[Row]) -> str:
        table = []
        for release in self.releases:
            for n in self.dsps:
                own = of(all_rows, part="load", release=release, dsps=n)
                shown = {
                    key: with_interval([row[key] for row in own if row.get(key) is not None], 1)
                    for key in (*SHARES, "f_p_hz", "f_t_hz")
                }
                streak = max((row["streak"] for row in own), default=None)
                label = {"release": MEANING[release], "dsps": n}
                table.append({**label, **shown, "streak": streak, "bus_a": mean(own, "bus_a")})
        columns = {
            "release": "long blocks", "dsps": "DSPs", "f_p": "f_p missed, %", "f_t": "f_t missed, %",
            "f_a": "f_a missed, %", "avoidance": "avoidance missed, %", "f_p_hz": "f_p realised, Hz",
            "f_t_hz": "f_t realised, Hz", "streak": "missed samples in a row", "bus_a": "bus A, %",
        }  # fmt: skip
        return (
            f"**Load.** Preset {self.preset}: the AGVs drive. {self.load_duration_s:g} s from power-on; nothing is "
            "left out, identify is in it. Shares are of what the ideal run demands ([report.md](report.md), Rates). "
            f"Each row has {len(self.seeds)} run{'s' if len(self.seeds) > 1 else ''}; the seed draws phases and ppm of "
            "all clocks but the drives' (`run.phase_jitter`) and the sensors' noise. Means, with 95 % intervals (bootstrap) where the "
            "runs differ.\n\n" + markdown(columns, table)
        )

    def rate_section(self, all_rows: Sequence[Row]) -> str:
        grid = []
        for f in self.servo_hz:
            cells: Row = {"servo": f / 1000}
            for row in of(all_rows, part="rate", servo_hz=f):
                shown = f"{row['f_p']:.3g} ({row['servo_misses']}, {row['behind_identify']})"
                cells[str(row["dsps"])] = shown if row["servo_misses"] else "0"
            grid.append(cells)
        columns = {"servo": "f_p, kHz", **{str(n): f"{n} DSPs" if n > 1 else "1 DSP" for n in self.rate_dsps}}
        return (
            f"\n**Rate.** Base load, f_s = {self.refreshes_per_servo} f_p, {self.rate_duration_s:g} s from power-on "
            "each. Missed against f_p, %; in brackets the missed jobs of the servo, and how many of them waited for "
            "the identify block, which nothing can interrupt:\n\n" + markdown(columns, grid)
        )

    def draw(self, all_rows: Sequence[Row], figure: Figure) -> None:
        left, right = figure.subplots(1, 2)
        for release, mark in zip(self.releases, itertools.cycle(("o-", "s-", "^--", "v:"))):
            left.plot(
                self.dsps,
                [mean(of(all_rows, part="load", release=release, dsps=n), "f_p") for n in self.dsps],
                mark,
                label=MEANING[release],
                markersize=5,
            )
        left.set(xlabel="DSPs", ylabel="f_p missed, %", title=f"preset {self.preset}: long blocks", ylim=(-3, 103))
        left.legend(fontsize=7, loc="upper right")
        for policy, mark in zip(self.idle_policies, itertools.cycle(("o-", "s-", "^--"))):
            own = of(all_rows, part="policy", policy=policy)
            right.plot([row["dsps"] for row in own], [row["bus_a"] for row in own], mark, label=policy)
        right.set(xlabel="DSPs", ylabel="bus A in use, %", title="idle policies at base load", ylim=(0, 103))
        right.legend(fontsize=8)


def rates(servo_hz: float, refreshes: int) -> dict[str, Setting]:
    """f_p with f_s = ``refreshes`` times as much; N̂_a,max and a so that the invariants of equation (7) hold."""
    refresh_hz = servo_hz * refreshes
    longest = whole_refreshes(2 * refresh_hz / AGV_POINT_HZ)
    return {
        "servo_frequency_hz": float(servo_hz),
        "refresh_frequency_hz": float(refresh_hz),
        "scheduling.agv_interval_max_refreshes": longest,
        "scheduling.a": max(1, min(0x40, P_PLUS_B_LIMIT // longest)),
    }


def whole_refreshes(count: float) -> int:
    """A number of refreshes that the configuration can check."""
    return int(min(max(count, 1), 2**31 - 1))


def late(all_rows: Sequence[Row], release: str, dsps: int | None) -> str:
    """What avoidance itself misses where f_p and f_t are met."""
    share = 0.0 if dsps is None else mean(of(all_rows, part="load", release=release, dsps=dsps), "avoidance")
    return f"; {share:.0f} % of the avoidance blocks are late then" if share else ""


def total(rows: Sequence[Row]) -> float:
    """The worst of what is missed against f_p, f_t and f_a, %."""
    return max(mean(rows, key) for key in ("f_p", "f_t", "f_a"))
