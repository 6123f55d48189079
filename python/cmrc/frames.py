"""Results as tidy frames, and as HTML for a notebook."""

from __future__ import annotations

import html
import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas

COLUMNS = ("kind", "metric", "unit", "value")
RUN = "run"
"""The kind of metrics for the whole run."""
SUMMARY = ("count", "best", "mean", "p50", "p99", "p99_9", "worst")
COUNTS = (
    "released",
    "on_time",
    "late",
    "unfinished",
    "never_started",
    "lost",
    "dropped",
    "misses",
    "longest_miss_streak",
)
SUMMARIES = ("response_ps", "waiting_ps", "execution_ps", "lateness_ps")
JITTER = ("count", "peak_to_peak", "worst", "rms")
DEMAND = (("demanded", "jobs"), ("missed_share", "1"), ("realised_hz", "Hz"), ("realised_worst_hz", "Hz"))


def to_frame(report: Mapping[str, Any]) -> pandas.DataFrame:
    """One row per kind and metric: columns ``COLUMNS``. Raises ImportError that says what to install."""
    from cmrc.extras import needed

    made = needed("pandas", "pandas", "to_frame").DataFrame(list(rows(report)), columns=list(COLUMNS))
    frame: pandas.DataFrame = made
    return frame


def rows(report: Mapping[str, Any]) -> Iterator[tuple[str, str, str, float]]:
    """Kind, metric, unit, value; NaN if nothing was measured."""
    for kind, task in report["tasks"].items():
        for name in COUNTS:
            yield kind, name, "jobs", _value(task[name])
        for name in SUMMARIES:
            for of in SUMMARY:
                yield kind, f"{name}_{of}", "jobs" if of == "count" else "ps", _value(task[name][of])
        for of in JITTER:
            yield kind, f"start_jitter_ps_{of}", "jobs" if of == "count" else "ps", _value(task["start_jitter_ps"][of])
        for name, unit in DEMAND:
            yield kind, name, unit, _value(((report["errors"] or {}).get("demand", {}).get(kind) or {}).get(name))
    yield from _of_run(report)


def _of_run(report: Mapping[str, Any]) -> Iterator[tuple[str, str, str, float]]:
    yield RUN, "simulated_s", "s", _value(report["simulated_s"])
    yield RUN, "misses", "jobs", float(sum(task["misses"] for task in report["tasks"].values()))
    for name, unit in (("cycles_completed", "cycles"), ("containers_delivered", "containers"), ("makespan_s", "s")):
        yield RUN, name, unit, _value(report[name])
    for rate in ("f_p", "f_t", "f_a"):
        for name, unit in DEMAND:
            yield RUN, f"{rate}_{name}", unit, _value(((report["rates"] or {}).get(rate) or {}).get(name))
    errors = report["errors"] or {}
    for name in ("rms", "peak", "end"):
        yield RUN, f"load_m_{name}", "m", _value((errors.get("load_m") or {}).get(name))
    for name in ("end_s", "peak_s"):
        yield RUN, f"lag_crane_{name}", "s", _value((errors.get("lag", {}).get("crane") or {}).get(name))
    yield RUN, "cost_m2s", "m2 s", _value(report["control_cost"]["cost_m2s"])


def to_html(report: Mapping[str, Any], headline: str) -> str:
    """A headline, and a table of the kinds with jobs."""
    heads = ("jobs", "released", "missed", "response, mean, us", "p99, us", "worst, us")
    lines = []
    for kind, task in report["tasks"].items():
        if task["released"] == 0:
            continue
        response = task["response_ps"]
        times = ["–" if response[of] is None else f"{response[of] / 1e6:.2f}" for of in ("mean", "p99", "worst")]
        cells = [kind, str(task["released"]), str(task["misses"]), *times]
        lines.append("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in cells) + "</tr>")
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in heads)
    return f"<p>{html.escape(headline)}</p><table><tr>{head}</tr>{''.join(lines)}</table>"


def _value(value: Any) -> float:
    return math.nan if value is None else float(value)
