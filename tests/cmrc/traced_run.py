"""Runs of the dock by the command, with the event trace."""

import json
from pathlib import Path
from typing import Any

import scheduling_replay
from command_line import emulator


def trace_of(folder: Path, *options: object, toml: str = "") -> tuple[Path, dict[str, Any]]:
    """The trace and the report of a run. A crane without its servo ends with status 1."""
    config, trace, report = folder / "run.toml", folder / "trace.txt", folder / "report.json"
    config.write_text(toml)
    done = emulator("--quiet", "--config", config, "--trace", trace, "--report", report, *options)
    found: dict[str, Any] = json.loads(report.read_text())
    assert done.returncode == (1 if found["braked"] else 0), done.stderr
    return trace, found


def events_of(folder: Path, *options: object, toml: str = "") -> tuple[list[scheduling_replay.Event], dict[str, Any]]:
    """The events and the report of a run whose audit finds nothing."""
    trace, report = trace_of(folder, "--set", "report.reference=none", *options, toml=toml)
    assert report["audit"]["violations"] == []
    with trace.open() as lines:
        return list(scheduling_replay.events(lines)), report
