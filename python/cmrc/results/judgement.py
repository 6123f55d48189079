"""What every claim is judged by: verdicts, confidence intervals, numbers read from reports."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

Row = dict[str, Any]
SERVO = ("pid", "torque_compensation")
PLANNING = (
    "trajectory_planning.crane",
    "inverse_kinematics.crane",
    "trajectory_planning.agv",
    "inverse_kinematics.agv",
)


@dataclass(frozen=True)
class Verdict:
    """``word``: holds, fails, holds in part, or not tested; then why, and where it stops being true."""

    word: str
    why: str
    limit: str

    def __str__(self) -> str:
        return f"**{self.word.capitalize()}.** {self.why} {self.limit}".strip()


def of(rows: Sequence[Row], **label: object) -> list[Row]:
    """The rows with these values."""
    return [row for row in rows if all(row.get(key) == value for key, value in label.items())]


def counted(report: Mapping[str, Any], kinds: Iterable[str] | None = None, of: str = "misses") -> int:
    """Jobs of these kinds (default: all) of a class, by default the missed ones."""
    tasks = report["tasks"]
    return sum(int(tasks[kind][of]) for kind in (tasks if kinds is None else kinds))


def share_interval(hits: int, trials: int, z: float = 1.96) -> tuple[float, float]:
    """Wilson's 95 % interval of a share."""
    if trials == 0:
        return 0.0, 1.0
    p = hits / trials
    middle = (p + z * z / (2 * trials)) / (1 + z * z / trials)
    half = z / (1 + z * z / trials) * math.sqrt(p * (1 - p) / trials + z * z / (4 * trials * trials))
    return max(0.0, middle - half), min(1.0, middle + half)


def mean_interval(values: Sequence[float], seed: int = 1, draws: int = 2000) -> tuple[float, float, float]:
    """The mean and its 95 % interval by bootstrap; NaN of nothing."""
    if not values:
        return math.nan, math.nan, math.nan
    data = np.asarray(values, dtype=float)
    means = np.random.default_rng(seed).choice(data, (draws, len(data))).mean(axis=1)
    low, high = np.percentile(means, [2.5, 97.5])
    return float(data.mean()), float(low), float(high)


def mean(rows: Sequence[Row], key: str) -> float:
    """Over the rows that have it; 0 of none."""
    known = [row[key] for row in rows if row.get(key) is not None]
    return float(np.mean(known)) if known else 0.0


def with_interval(values: Sequence[float], digits: int = 2) -> str:
    """``12.3 [11.0, 13.6]``; the number alone where the interval has no width in these digits; a dash of nothing."""
    mean, low, high = mean_interval(values)
    if math.isnan(mean):
        return "–"
    if f"{low:.{digits}f}" == f"{high:.{digits}f}":
        return f"{mean:.{digits}f}"
    return f"{mean:.{digits}f} [{low:.{digits}f}, {high:.{digits}f}]"


def missed_share(report: Mapping[str, Any], rate: str) -> float | None:
    """Missed against f_p, f_t or f_a in % of what the ideal run demands (docs/report.md, Rates); None without
    demand."""
    share = report["rates"][rate]["missed_share"]
    return None if share is None else 100.0 * float(share)


def demand_missed(report: Mapping[str, Any], kind: str) -> float | None:
    """The same of one kind of task."""
    share = report["errors"]["demand"].get(kind, {}).get("missed_share")
    return None if share is None else 100.0 * float(share)


def measured(value: float | None, unit: float = 1.0) -> float:
    """A number of a report in a unit; NaN where nothing was measured."""
    return math.nan if value is None else value / unit


def markdown(columns: Mapping[str, str], rows: Sequence[Row]) -> str:
    """A table: ``columns`` maps a row's keys to headings. Floats get three digits, None a dash."""

    def cell(value: Any) -> str:
        if value is None or (isinstance(value, float) and math.isnan(value)):
            return "–"
        if isinstance(value, bool):
            return "yes" if value else "no"
        if isinstance(value, float):
            return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"
        return str(value)

    lines = ["| " + " | ".join(columns.values()) + " |", "|" + "---|" * len(columns)]
    lines += ["| " + " | ".join(cell(row.get(key)) for key in columns) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def percent(part: float, whole: float) -> float:
    """100 part / whole; 0 of nothing."""
    return 100.0 * part / whole if whole else 0.0
