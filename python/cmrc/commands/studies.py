"""``cmrc limits``, ``compare`` and ``diff`` (docs/report.md, docs/experiments.md)."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from typing import Any

import cmrc
from cmrc import _core, files, signals, streams, studies
from cmrc.commands.common import (
    Commands,
    check_files,
    command,
    numbers,
    output_file,
    setting_value,
    settings,
    write_each,
)
from cmrc.progress import ProgressLine
from cmrc.simulation import Setting, layered

SETTINGS: tuple[tuple[str, str, Callable[[str], Setting], str, str], ...] = (
    ("--dsps", "machine.dsps", setting_value, "N", "number of DSPs, 1 to 16 (default 4)"),
    ("--duration", "run.duration_s", setting_value, "S", "simulated time in s (default 180)"),
    ("--seed", "run.seed", setting_value, "N", "seed of everything random (default 1)"),
    ("--turn-order", "run.turn_order", setting_value, "SEED", "shuffle which chip is advanced first; changes nothing"),
    ("--programs", "machine.programs", str, "DIR", "assemble the DSP programs from this directory"),
    ("--board", "machine.board", str, "default|FILE.toml", "memories and clock of the boards (docs/boards.md)"),
    ("--topology", "bus.topology", str, "NAME", "which device is on which bus (docs/buses.md)"),
    ("--idle-policy", "machine.idle_policy", str, "NAME", "how a DSP without work waits"),
    ("--eq7", "scheduling.equation", str, "NAME", "reading of equation (7)"),
)
"""Settings with an option of their own, the same as for ``emulator``; they win over ``--set``."""


def add(commands: Commands) -> None:
    _limits(commands)
    _compare(commands)
    _diff(commands)


def _configuration(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", metavar="FILE", help="TOML file with parameters (docs/configuration.md)")
    parser.add_argument("--preset", metavar="NAME", help=", ".join(_core.cmrc.presets()))
    choices = {key["name"]: ", ".join(key["choices"]) for key in _core.cmrc.config_keys()}
    for option, key, kind, metavar, meaning in SETTINGS:
        words = f"{meaning}: {choices[key]}" if choices[key] else meaning
        parser.add_argument(option, dest=key, type=kind, metavar=metavar, help=words)
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help="a setting; may be given again")
    parser.add_argument("--json", type=output_file, metavar="FILE", help="write all of it as JSON")


def _layered(given: argparse.Namespace) -> _core.cmrc.ConfigLayers:
    """The configuration of the options; checks that ``--json`` can be written and is not an input file."""
    asked = vars(given)
    own = {key: asked[key] for _, key, _, _, _ in SETTINGS if asked[key] is not None}
    layers = layered(given.config, given.preset, {**settings(given), **own}, (), {})
    made = layers.config()
    _core.cmrc.Simulation(made)  # a missing board or layout is reported before the first run
    check_files({"--config": given.config}, {"--json": given.json}, [made.to_dict()])
    return layers


def _limits(commands: Commands) -> None:
    parser = command(commands, "limits", "scans for the first missed deadline", _do_limits)
    _configuration(parser)
    parser.add_argument("--cycles", metavar="GRID", help="factors on the time of an instruction cycle, 1:3:0.25")
    parser.add_argument("--dsps-grid", metavar="GRID", help="numbers of DSPs, 1:8")
    parser.add_argument("--servo", metavar="GRID", help="servo frequencies in Hz, 500,1000,2000")
    parser.add_argument("--errors", action="store_true", help="run every point to its end, and report its errors")


def _do_limits(given: argparse.Namespace) -> int:
    cycles, dsps, servo = (
        None if text is None else numbers(text, option)
        for text, option in ((given.cycles, "--cycles"), (given.dsps_grid, "--dsps-grid"), (given.servo, "--servo"))
    )
    dsps_of_all = vars(given)["machine.dsps"]
    if isinstance(dsps_of_all, str) and set(dsps_of_all) & set(":,"):
        raise ValueError(
            f"--dsps: {dsps_of_all!r} is a grid, and --dsps is the number of DSPs of every point; --dsps-grid "
            f"{dsps_of_all} is expected"
        )
    scans = studies.scans_of(_layered(given), cycles, dsps, servo, given.errors)
    status = 0
    with ProgressLine("cmrc limits") as line, line.beating("no run has ended yet"):
        try:
            scans.run(lambda done, points: line.of(done, points, "runs", now=True))
        except KeyboardInterrupt as stop:
            status = signals.status(stop)
    try:
        _show(given, scans.text(), scans.report())
    except (OSError, RuntimeError) as error:
        if not status:
            raise
        streams.say(f"cmrc limits: {error}")  # the status is the signal's: its terminal may be what has gone
    return status


def _compare(commands: Commands) -> None:
    _configuration(command(commands, "compare", "a run and the same run with instant execution", _do_compare))


def _do_compare(given: argparse.Namespace) -> int:
    made = _layered(given).config()
    with ProgressLine("cmrc compare") as line, line.beating():
        found = studies.compared(made, line.of)
    _show(given, found.text, found.report)
    return 0


def _show(given: argparse.Namespace, text: str, report: dict[str, Any]) -> None:
    shows = lambda: streams.show(files.printable_lines(text))
    saves = lambda: files.write(given.json, json.dumps(report, indent=2) + "\n")
    write_each(given.command, *([] if given.json is None else [saves]), shows)


def _diff(commands: Commands) -> None:
    parser = command(commands, "diff", "the differences between two results; status 1 if there are any", _do_diff)
    parser.add_argument("left", metavar="A", help="a saved result, or a JSON report")
    parser.add_argument("right", metavar="B", help="another one")
    parser.add_argument("--json", type=output_file, metavar="FILE", help="write all of it as JSON")
    parser.add_argument("--all", action="store_true", help="show every metric that differs, not the first 40")


def _do_diff(given: argparse.Namespace) -> int:
    check_files({"A": given.left, "B": given.right}, {"--json": given.json})
    with ProgressLine("cmrc diff") as line, line.beating("reading"):
        found = cmrc.diff(given.left, given.right)
    _show(given, found.text(len(found.metrics) if given.all else 40), found.to_dict())
    return 1 if found else 0
