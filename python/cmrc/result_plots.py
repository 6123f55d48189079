"""Plots of a result: blocks on the DSPs, response times, misses, the load's error. Needs matplotlib.

Every line has its own style, and every bar its own hatch: the plots can be read when printed in grey.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from cmrc.arguments import drawn_from, number
from cmrc.events import built_in_tasks

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.text import Text

    from cmrc.result import Result

COLOURS = ("#000000", "#0072b2", "#d55e00", "#56b4e9", "#e69f00", "#009e73", "#cc79a7", "#999999")
"""Okabe and Ito's colours, so ordered that neighbours also differ in grey."""
LINES = (
    *("-", "--", "-.", ":"),
    *((0, (5, 2) * (of - dots) + (1, 2) * dots) for of in range(3, 8) for dots in range(1, of)),
)
"""24 kinds of dashes: the usual ones, then each so many long and so many short ones in turn."""
MARKS = ("o", "s", "^", "D", "v", "P", "X", "*")
HATCHES = (
    *("", "////", "\\\\\\\\", "....", "xxxx", "||||", "++++", "oooo", "----", "**", "OO", "//.."),
    *("||..", "\\\\..", "--..", "xx..", "++..", "//--", "\\\\||", "//||", "\\\\--", "++xx", "xx", "//oo"),
)
"""More than a run has kinds of jobs: 12, and at most 8 of [[tasks]]."""
MISSED = ("late", "past the deadline at the end", "lost", "dropped")
"""Missed jobs by outcome. The second one is what still runs or waits at the end of the run."""
OUTCOMES = ("on_time", "late", "unfinished", "never_started", "lost", "dropped")
"""By the class of an event ``miss``: report::Outcome."""
_BLOCK = re.compile(
    r"(?P<time>\d+\.\d+) (?:"
    r"\[dsp (?P<taker>\d+)\] (?P<taken>claim|finish) block=(?P<block>\S+) kind=(?P<kind>\d+)"
    r"|\[dsp (?P<stopped>\d+)\] (?:fault|reset state=0)"
    # machine::Action fail, freeze, hang, unplug, reset
    r"|\[host\] scripted action=(?:0|1|2|3|5) number=(?P<broken>\d+)"
    r"|\[host\] requeue block=(?P<back>\S+) .*owner=(?P<late>\d+))"
)
_MISS = re.compile(r"(?P<time>\d+\.\d+) \[host\] miss kind=(?P<kind>\d+) tick=\d+ class=(?P<class>\d+)")


def _result() -> type:
    from cmrc.result import Result

    return Result


_of_result = drawn_from("result", _result, "a cmrc.Result")


def style(n: int) -> dict[str, Any]:
    """Colour and dashes of the n-th line."""
    return {"color": COLOURS[(n + n // len(LINES)) % len(COLOURS)], "linestyle": LINES[n % len(LINES)]}


def _bar_style(n: int) -> dict[str, Any]:
    """Colour and hatch of the n-th kind of bars; none is black, on which no hatch is seen."""
    colours = COLOURS[1:]
    return {"facecolor": colours[n % len(colours)], "edgecolor": "k", "hatch": HATCHES[n % len(HATCHES)]}


def legend(axes: Axes, **more: Any) -> None:
    """Beside the axes, where it covers nothing."""
    if "handles" in more or axes.get_legend_handles_labels()[1]:
        shown = axes.legend(
            fontsize=7, handlelength=4, loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, **more
        )
        as_they_are(*shown.get_texts())


def as_they_are(*texts: Text) -> None:
    """A dollar in a name is a dollar, and begins no formula."""
    for text in texts:
        if "$" in text.get_text():
            text.set_parse_math(False)


def name_rows(axes: Axes, names: list[str], first: float = 0.0) -> None:
    """A row of the y axis for each name."""
    axes.set_yticks(np.arange(len(names)) + first, names, fontsize=7, parse_math=False)


@_of_result
def gantt(result: Result, axes: Axes, from_s: float, to_s: float) -> None:
    """The blocks of each DSP from ``from_s`` to ``to_s``: a bar per block, a cross per miss.

    A bar begins with the claim, and ends with the block, its DSP (failed, hung, halted, in reset, unplugged), the
    watchdog's putting it back, or the run. A cross is at the instant of the event ``miss``. A job whose end or tick the
    host did not come to before the run ended has no event. If the report lists it (``report.misses_max``), its cross is
    at its release if it was dropped, else at its deadline.

    Raises ValueError for a result without events (``cmrc.run(..., keep_events=True)``), and for an empty window.
    """
    if result.events is None:
        raise ValueError("gantt: the result has no events; cmrc.run(..., keep_events=True) keeps them")
    if not number("from_s", from_s, "an instant in s") < number("to_s", to_s, "an instant in s"):
        raise ValueError(f"gantt: from {from_s} s to {to_s} s is not a window; from_s < to_s is expected")
    blocks = [block for block in runs(result) if block[3] > from_s and block[2] < to_s]
    kinds = list(dict.fromkeys(block[1] for block in sorted(blocks, key=lambda block: -(block[3] - block[2]))))
    for n, kind in enumerate(kinds):
        of = [block for block in blocks if block[1] == kind]
        bars = [(max(b, from_s) * 1e3, (min(e, to_s) - max(b, from_s)) * 1e3) for _, _, b, e in of]
        for (slot, *_), bar in zip(of, bars, strict=True):
            axes.broken_barh([bar], (slot - 0.4, 0.8), linewidth=0.4, **_bar_style(n))
        axes.broken_barh([], (0, 0), label=kind, **_bar_style(n))
    shown = [instant * 1e3 for instant in _missed_s(result) if from_s <= instant <= to_s]
    slots = len(result.report["dsps"])
    if shown:
        axes.plot(shown, [slots - 0.3] * len(shown), "kx", ms=5, label="miss", clip_on=False)
    axes.set(xlim=(from_s * 1e3, to_s * 1e3), ylim=(-0.6, slots), xlabel="time, ms", title="blocks on the DSPs")
    axes.set_yticks(range(slots), [f"DSP {slot}" for slot in range(slots)])
    legend(axes)


def runs(result: Result) -> Iterator[tuple[int, str, float, float]]:
    """DSP, kind, begin and end in s of every block in the result's events."""
    kinds = _kinds(result.report)
    running: dict[int, tuple[str, float]] = {}
    block: dict[int, str] = {}
    for found in _BLOCK.finditer(result.events or ""):
        time = float(found["time"])
        slot = int(found["taker"] or found["stopped"] or found["broken"] or found["late"])
        # A DSP that was given up may have been reset since, and run another block.
        if found["back"] is not None and found["back"] != block.get(slot):
            continue
        if (begun := running.pop(slot, None)) is not None:
            yield slot, *begun, time
        if found["taken"] == "claim":
            running[slot] = (kinds[int(found["kind"])], time)
            block[slot] = found["block"]
    for slot, begun in running.items():
        yield slot, *begun, float(result.report["simulated_s"])


def _missed_s(result: Result) -> Iterator[float]:
    """The instants of all misses that have an event, then of those that the report alone has."""
    kinds = _kinds(result.report)
    noted: Counter[tuple[str, str]] = Counter()
    for found in _MISS.finditer(result.events or ""):
        yield float(found["time"])
        noted[kinds[int(found["kind"])], OUTCOMES[int(found["class"])]] += 1
    # The host comes to ticks and ends in their order, so that those without an event are the last ones of a kind.
    for miss in sorted(result.missed, key=lambda miss: miss["release_ps" if _dropped(miss) else "end_ps"]):
        of = miss["kind"], miss["outcome"]
        noted[of] -= 1
        if noted[of] < 0:
            yield miss["release_ps"] / 1e12 if _dropped(miss) else _due_s(miss)


def _dropped(miss: Mapping[str, Any]) -> bool:
    return bool(miss["outcome"] == "dropped")


def _kinds(report: Mapping[str, Any]) -> list[str]:
    """By the number of a trace: the built-in ones, then those of [[tasks]]."""
    return [*built_in_tasks(), *(name for name in report["tasks"] if name.startswith("user."))]


def _due_s(miss: Mapping[str, Any]) -> float:
    return float(miss["release_ps"] if miss["deadline_ps"] is None else miss["deadline_ps"]) / 1e12


@_of_result
def histogram(result: Result, axes: Axes) -> None:
    """Shares of the finished jobs of each kind over their response time, in bins from one power of two to the next: one
    row per kind, a darker colour for more, the share in % as a number."""
    kinds = _finished(result)
    bins = {kind: task["response_ps"]["log2_histogram"] for kind, task in kinds.items()}
    used = [i for counts in bins.values() for i, count in enumerate(counts) if count]
    first, last = min(used, default=0), max(used, default=0)
    edges = [2.0 ** (i - 1) * 1e-6 for i in range(first, last + 2)]
    shares = np.array(
        [
            [
                100 * (counts[i] if i < len(counts) else 0) / kinds[kind]["response_ps"]["count"]
                for i in range(first, last + 1)
            ]
            for kind, counts in bins.items()
        ]
        or [[0.0]]
    )
    axes.pcolormesh(
        edges, np.arange(len(shares) + 1) - 0.5, shares, cmap="Greys", vmin=0, vmax=100, edgecolors="0.85", lw=0.4
    )
    for y, row in enumerate(shares):
        for i, share in enumerate(row):
            if share:
                axes.text(
                    np.sqrt(edges[i] * edges[i + 1]),
                    y,
                    f"{share:.0f}" if share >= 0.5 else "<1",
                    ha="center",
                    va="center",
                    fontsize=6.5,
                    color="w" if share > 50 else "k",
                )
    axes.set(
        xscale="log",
        xlabel="response time, us",
        title="response times: share of a kind's jobs, %",
        ylim=(len(shares) - 0.5, -0.5),
    )
    name_rows(axes, list(kinds))


@_of_result
def cdf(result: Result, axes: Axes) -> None:
    """Share of the finished jobs of each kind within a response time: exact at the powers of two, and at least that
    share at a percentile."""
    for n, (kind, task) in enumerate(_finished(result).items()):
        response = task["response_ps"]
        points = {float(response["best"]): 0.0}
        for of, share in (("p50", 0.5), ("p99", 0.99), ("p99_9", 0.999), ("worst", 1.0)):
            points[float(response[of])] = share  # if two have one time, the greater share counts
        below = 0
        for i, count in enumerate(response["log2_histogram"]):
            below += count
            if response["best"] < 2.0**i < response["worst"]:
                points[2.0**i] = below / response["count"]
        times = np.array(sorted(points))
        shares = np.maximum.accumulate([points[time] for time in times])
        axes.plot(times * 1e-6, 100 * shares, label=kind, marker=MARKS[n % len(MARKS)], ms=3, lw=1.2, **style(n))
    axes.set(
        xscale="log",
        xlabel="response time, us",
        ylabel="jobs done within it, %",
        ylim=(-2, 102),
        title="response times, cumulated",
    )
    legend(axes)


@_of_result
def misses(result: Result, axes: Axes) -> None:
    """Missed jobs of each kind, by outcome: a bar is as long as ``misses`` of the kind in the report."""
    tasks = {kind: task for kind, task in result.report["tasks"].items() if task["released"]}
    parts = np.array([_missed(task) for task in tasks.values()], dtype=float).reshape(-1, len(MISSED))
    left = np.zeros(len(tasks))
    for n, (outcome, counts) in enumerate(zip(MISSED, parts.T, strict=True)):
        if counts.any():
            axes.barh(range(len(tasks)), counts, left=left, label=outcome, linewidth=0.4, **_bar_style(n))
        left += counts
    for y, task in enumerate(tasks.values()):
        axes.text(left[y], y, f" {task['misses']} of {task['released']}", va="center", fontsize=7)
    axes.set(
        xlabel="missed jobs",
        title="deadlines",
        xlim=(0, max(1.0, left.max(initial=0.0) * 1.35)),
        ylim=(len(tasks) - 0.4, -0.6),
    )
    name_rows(axes, list(tasks))
    legend(axes)


def _missed(task: Mapping[str, Any]) -> list[int]:
    """Missed jobs of a kind by outcome, in the order of MISSED."""
    late, lost, dropped = task["late"], task["lost"], task["dropped"]
    return [late, task["misses"] - late - lost - dropped, lost, dropped]


@_of_result
def load_error(result: Result, axes: Axes) -> None:
    """The load's true distance from its planned place: the ideal run's load at the same instant. PID's own view of its
    joints is not used. Raises ValueError for a result without a reference."""
    signals = result.signals
    if "payload_reference_x_m" not in signals:
        raise ValueError("load_error: the run has no reference (report.reference)")
    apart = [signals[f"payload_{axis}_m"] - signals[f"payload_reference_{axis}_m"] for axis in "xyz"]
    error = np.sqrt(sum(np.square(one) for one in apart))
    axes.plot(signals["time_s"], 1e3 * error, "k-", lw=1.2, label="load")
    due = [_due_s(miss) for miss in result.missed]
    if due:
        axes.plot(
            due, np.zeros(len(due)), "|", color=COLOURS[2], ms=8, label="missed deadlines\n(those listed one by one)"
        )
    axes.set(xlabel="time, s", ylabel="distance from the plan, mm", title="true error of the load")
    legend(axes)


@_of_result
def sheet(result: Result) -> Figure:
    """Misses, response times and the load's error on one sheet."""
    from cmrc.figures import ShownFigure

    figure = ShownFigure(figsize=(13, 7.5), layout="constrained")
    grid = figure.subplots(2, 2)
    misses(result, grid[0, 0])
    histogram(result, grid[0, 1])
    cdf(result, grid[1, 1])
    if "payload_reference_x_m" in result.signals:
        load_error(result, grid[1, 0])
    else:
        grid[1, 0].text(0.5, 0.5, "no reference: no true error", ha="center", transform=grid[1, 0].transAxes)
        grid[1, 0].set_axis_off()
    figure.suptitle(repr(result)[1:-1].replace("cmrc.Result: ", ""), fontsize=10)
    return figure


def _finished(result: Result) -> dict[str, Mapping[str, Any]]:
    return {kind: task for kind, task in result.report["tasks"].items() if task["response_ps"]["count"]}
