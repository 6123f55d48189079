"""What must hold in every run of a dock, with any failures (docs/report.md, docs/trust.md).

It is judged from the report and the trace alone.
"""

from __future__ import annotations

import json
import random
import subprocess
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import chain_replay
import numpy as np
import scheduling_replay
import tomllib
from cmrc import _core
from locations import BUILD
from random_docks import KEYS, Dock

cmrc = _core.cmrc
Report = dict[str, Any]
OUTCOMES = ("on_time", "late", "unfinished", "never_started", "lost", "dropped")
STOPS = (
    "completed",
    "job_done",
    "no_dsp_left",
    "drives_stopped",
    "plant_fault",
)  # docs/report.md, When a run ends early
PS = 10**12


def finite(text: str) -> Report:
    """A report without NaN and infinities."""

    def refuse(constant: str) -> None:
        raise AssertionError(f"the report holds {constant}")

    report: Report = json.loads(text, parse_constant=refuse)
    return report


def summaries(node: Any, path: str = "") -> Iterator[tuple[str, dict[str, Any]]]:
    """Every summary of the report with its place."""
    if isinstance(node, dict):
        if "log2_histogram" in node:
            yield path, node
        for key, below in node.items():
            yield from summaries(below, f"{path}.{key}")
    elif isinstance(node, list):
        for n, below in enumerate(node):
            yield from summaries(below, f"{path}[{n}]")


def of_summary(path: str, s: dict[str, Any]) -> Iterator[str]:
    ordered = [s["best"], s["p50"], s["p99"], s["p99_9"], s["worst"]]
    if s["count"] == 0:
        if any(value is not None for value in [*ordered, s["mean"]]):
            yield f"{path}: something measured of nothing: {s}"
        return
    if ordered != sorted(ordered) or not s["best"] <= s["mean"] <= s["worst"]:
        yield f"{path}: not in order: {s}"
    if sum(s["log2_histogram"]) != s["count"]:
        yield f"{path}: its histogram counts {sum(s['log2_histogram'])} of {s['count']}"
    if s["count"] and s["worst"] > 0 and len(s["log2_histogram"]) != int(s["worst"]).bit_length() + 1:
        yield f"{path}: {s['worst']} is not in the last bin of {len(s['log2_histogram'])}"


def of_task(kind: str, task: Report, missed: int | None) -> Iterator[str]:
    if task["released"] != sum(task[name] for name in OUTCOMES):
        yield f"{kind}: {task['released']} released, {[task[name] for name in OUTCOMES]}"
    finished = task["on_time"] + task["late"]
    for name in ("response_ps", "execution_ps"):
        if task[name]["count"] != finished:
            yield f"{kind}: {name} of {task[name]['count']} jobs, {finished} finished"
    if not finished <= task["waiting_ps"]["count"] <= task["released"] - task["never_started"]:
        yield f"{kind}: {task['waiting_ps']['count']} jobs have waited, of {task['released']}, {finished} of them finished"
    if task["lateness_ps"]["count"] != task["late"]:
        yield f"{kind}: lateness of {task['lateness_ps']['count']} jobs, {task['late']} were late"
    certain, possible = task["late"] + task["lost"] + task["dropped"], task["unfinished"] + task["never_started"]
    if not certain <= task["misses"] <= certain + possible or not task["longest_miss_streak"] <= task["misses"]:
        yield f"{kind}: {task['misses']} misses of {certain} to {certain + possible}, {task['longest_miss_streak']} in a row"
    if missed is not None and missed != task["misses"]:
        yield f"{kind}: {missed} misses listed of {task['misses']}"
    why = task["why_late"]
    if sum(why["parts_ps"].values()) != why["lateness_ps"]:
        yield f"{kind}: parts of {sum(why['parts_ps'].values())} ps, {why['lateness_ps']} ps late"


def of_chips(report: Report, events: int, disturbed: bool) -> Iterator[str]:
    resets = {f"DSP {dsp['slot']}": sum(boot["reset_at_s"] > 0 for boot in dsp["boots"]) for dsp in report["dsps"]}
    for dsp in report["dsps"]:
        if sum(dsp["causes"].values()) != dsp["cycles"]:
            yield f"DSP {dsp['slot']}: causes of {sum(dsp['causes'].values())} cycles, {dsp['cycles']} are counted"
        through = report["simulated_ps"] * dsp["clock_hz"] * (1 + dsp["clock_ppm"] * 1e-6) / PS
        # A chip stops between two instructions: one may reach beyond the end, one is not over.
        if not disturbed and not -100 < dsp["cycles"] - through < 100:
            yield f"DSP {dsp['slot']}: {dsp['cycles']} cycles in a time of {through}"
    for name, bus in report["buses"].items():
        if sum(bus["clocks_by_use"].values()) != bus["clocks"]:
            yield f"bus {name}: uses of {sum(bus['clocks_by_use'].values())} clocks, {bus['clocks']} are counted"
        for word in ("words_read", "words_written"):
            asked, given = (sum(part[word] for part in bus[side].values()) for side in ("masters", "targets"))
            if asked != given:
                yield f"bus {name}: {word}: {asked} by masters, {given} by targets"
        for master, counts in bus["masters"].items():
            # A wait is counted where its transaction begins. A processor's read and its bridge's posted write may be
            # under way at the end, and where an event or a reset breaks them off.
            broken_off = 2 * (1 + events + resets.get(master, 0))
            if counts["wait_clocks"]["count"] > counts["transactions"] + counts["retries"] + broken_off:
                yield f"bus {name}: {master} waited {counts['wait_clocks']['count']} times for {counts['transactions']} transactions"


def broken(report: Report, dock: Dock, config: Any) -> list[str]:
    """Sentences on what does not hold; empty unless the emulator is wrong."""
    wrong = list(report["audit"]["violations"])
    if report["stop_reason"] not in STOPS:
        wrong.append(f"it ended for {report['stop_reason']}")
    times = (report["account_end_s"], report["simulated_s"], config.to_dict()["run.duration_s"])
    if not times[0] <= times[1] <= times[2] * (1 + 1e-12) or (
        report["stop_reason"] == "completed" and abs(times[1] - times[2]) > 1e-9
    ):
        wrong.append(f"account, simulated time and duration are {times}, {report['stop_reason']}")
    if len(report["timed_events"]) + report["timed_events_to_come"] < len(dock.events):
        wrong.append(
            f"{len(report['timed_events'])} events and {report['timed_events_to_come']} to come, of {len(dock.events)}"
        )
    reported = (
        {kind: sum(miss["kind"] == kind for miss in report["misses"]) for kind in report["tasks"]}
        if report["misses_left_out"] == 0
        else {}
    )
    for kind, task in report["tasks"].items():
        wrong += of_task(kind, task, reported.get(kind))
    if sum(task["misses"] for task in report["tasks"].values()) != len(report["misses"]) + report["misses_left_out"]:
        wrong.append("misses listed and left out are not all")
    wrong += of_chips(report, len(dock.events), disturbed=bool(dock.events))
    for path, summary in summaries({key: part for key, part in report.items() if key != "configuration"}):
        wrong += of_summary(path, summary)
    return wrong


def differences(one: Any, other: Any, path: str = "") -> list[str]:
    """Where two reports part."""
    if one == other:
        return []
    if isinstance(one, dict) and isinstance(other, dict) and one.keys() == other.keys():
        return [line for key in one for line in differences(one[key], other[key], f"{path}.{key}")]
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        return [
            line for n, pair in enumerate(zip(one, other, strict=True)) for line in differences(*pair, f"{path}[{n}]")
        ]
    return [f"{path}: {one!r}, {other!r}"]


def without_the_clock(report: Report) -> Report:
    apart = ("elapsed_s", "reference_elapsed_s", "configuration", "configuration_toml")
    return {key: part for key, part in report.items() if key not in apart}


def in_pieces(config: Any, draw: random.Random, duration_s: float) -> Report:
    """The same run cut at random instants, and looked at between them in every way that must change nothing. One that
    has no profile may continue from a snapshot there."""
    simulation = cmrc.Simulation(config)
    profiled = draw.random() < 0.5
    if profiled:
        simulation.profile()
    for cut in sorted(draw.uniform(0, duration_s) for _ in range(draw.choice([1, 3, 30]))):
        if simulation.ended:
            break
        simulation.run_until(cut)
        look = draw.random()
        if look < 0.2:
            finite(simulation.report_json())
        elif look < 0.4:
            _ = simulation.dsp(0).causes
            simulation.peek(draw.randrange(1024))
        elif look < 0.5:
            simulation.signals()
        elif look < 0.6 and not profiled:
            snapshot = simulation.snapshot().to_bytes()
            simulation = cmrc.Simulation(config)
            simulation.restore(cmrc.Snapshot.from_bytes(snapshot))
    simulation.run(None, draw.choice([0.02, 0.001, 0.5]))
    return finite(simulation.report_json())


def from_the_command_line(dock: Dock, config: Any, scratch: Path) -> tuple[Report, Path, str]:
    """The same run by the command, with a trace: its report, the trace, and what it says."""
    file, trace, report = (scratch / name for name in ("dock.toml", "trace", "report.json"))
    events = "" if "[[events]]" in config.to_toml() else "".join(event_toml(event) for event in dock.events)
    file.write_text(config.to_toml() + events)
    command = [BUILD / "bin" / "emulator", "--quiet", "--config", file, "--trace", trace, "--report", report]
    finished = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    if finished.returncode not in (0, 1) or not report.exists():
        raise AssertionError(f"the command ended with {finished.returncode}: {finished.stderr.strip()[-400:]}")
    return finite(report.read_text()), trace, finished.stderr


def event_toml(event: dict[str, Any]) -> str:
    return "[[events]]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in event.items())


KIND_USER = 12  # task_block.inc


def user_tasks(dock: Dock) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = tomllib.loads("\n".join(dock.tables)).get("tasks", [])
    return rows


def rule_of(config: Any, tasks: list[dict[str, Any]]) -> scheduling_replay.Rule:
    values, n = config.to_dict(), config.intervals()
    names = {
        "gamma": "gamma_refreshes",
        "alpha": "alpha_refreshes",
        "beta": "beta_refreshes",
        "p": "p",
        "q": "q",
        "b": "b",
        "a": "a",
    }
    agv = values["scheduling.agv_interval_refreshes"] or n["N_a"]
    users = {
        KIND_USER + place: scheduling_replay.UserTask(row["importance"], row["importance"], 0, row.get("dsp"))
        for place, row in enumerate(tasks)
    }
    return scheduling_replay.Rule(
        servo=n["N_p"],
        crane=n["N_t"],
        agv=agv,
        tasks=users,
        **{name: values[f"scheduling.{key}"] for name, key in names.items()},
    )


def can_be_replayed(dock: Dock, config: Any) -> bool:
    """The replays know equation (7) as restored, with N_a that does not change, the built-in tasks and a user's."""
    values = config.to_dict()
    as_they_are = (
        "equation",
        "work_mode",
        "learning",
        "time_after_delay",
        "servo_reload",
        "pid_after_torque",
        "long_blocks_max",
        "agv_interval_refreshes",
    )
    return (
        all(values[f"scheduling.{name}"] == KEYS[f"scheduling.{name}"]["default"] for name in as_they_are)
        and all(table.startswith("[[tasks]]") for table in dock.tables)
        and not any(event["action"] in ("set", "plug", "unplug") for event in dock.events)
    )


def replayed(trace: Path, report: Report, dock: Dock, config: Any) -> list[str]:
    """Differences between the run and two replays of its trace: of the scheduling rule, and of the chains of causes."""
    values = config.to_dict()
    with trace.open() as lines:
        events = list(scheduling_replay.events(lines))
    tasks = user_tasks(dock)
    replay = scheduling_replay.Replay(rule_of(config, tasks), doorbells=values["machine.idle_policy"] == "doorbell")
    replay.follow(events)
    wrong = list(replay.faults)
    if (
        not wrong and report["misses_left_out"] == 0 and not values["run.phase_jitter"]
    ):  # the chains' replay counts ticks of an exact clock
        try:
            chain_replay.check(
                chain_replay.Trace(
                    events,
                    values["machine.dsps"],
                    replay.rule.servo,
                    values["rates.refresh_frequency_hz"],
                    {KIND_USER + n: (f"user.{row['name']}", row.get("dsp")) for n, row in enumerate(tasks)},
                    empty=max(0, values["machine.slots"] - values["machine.dsps"]),
                    preloaded=values["machine.boot"] == "preloaded",
                ),
                report,
            )
        except AssertionError as error:
            wrong.append(f"chains: {error}")
    return wrong


def of_signals(simulation: Any) -> Iterator[str]:
    for name, column in simulation.signals().items():
        if not np.all(np.isfinite(column)):
            yield f"signal {name} is not finite from row {int(np.argmin(np.isfinite(column)))} on"


def of_refusal(message: str, cut: Future[Report]) -> list[str]:
    """The one error that a run may end with, and in both ways: a plant that cannot be integrated (docs/plant.md)."""
    other = cut.exception()
    if "values nearer to the defaults are expected" not in message:
        return [f"it raises: {message}"]
    return [] if str(other) == message else [f"{message}, but in pieces: {other}"]


def uncut(config: Any) -> Any:
    simulation = cmrc.Simulation(config)
    simulation.run()
    return simulation


def faults_of(dock: Dock, seed: int, scratch: Path, by_command: bool | None = None) -> list[str]:
    """Runs a dock in several ways, two of them at once.

    by_command: also by the command, with a trace, which costs as much as all the rest; None: one dock in four.
    Sentences on what does not hold, or what differs between two ways; empty when all is well.
    """
    draw = random.Random(seed)
    config, shuffled = dock.config(), dock.config(**{"run.turn_order": draw.randint(1, 2**62)})
    with ThreadPoolExecutor(1) as beside:
        cut = beside.submit(in_pieces, shuffled, draw, dock.duration_s)
        try:
            simulation = uncut(config)
        except RuntimeError as error:
            return of_refusal(str(error), cut)
        pieces = cut.result()
    plain = finite(simulation.report_json())
    wrong = [*broken(plain, dock, config), *of_signals(simulation)]
    wrong += [
        f"in pieces, in another turn order: {line}"
        for line in differences(without_the_clock(plain), without_the_clock(pieces))[:5]
    ]
    if seed % 4 == 0 if by_command is None else by_command:
        other, trace, _ = from_the_command_line(dock, config, scratch)
        wrong += [
            f"by the command, traced: {line}"
            for line in differences(without_the_clock(plain), without_the_clock(other))[:5]
        ]
        if can_be_replayed(dock, config):
            wrong += [f"replayed: {line}" for line in replayed(trace, plain, dock, config)[:5]]
    return wrong
