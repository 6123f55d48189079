"""Writes docs/report.schema.json, the JSON schema of a report, from reports of real runs and the table of
docs/report.md.

    PYTHONPATH=build/python .venv/bin/python scripts/documents/report_schema.py docs/report.schema.json

A key is required if each run has it. What a run may name as it likes (buses, masters, settings, parts of a chain) is an
object whose values have one form. Descriptions are the rows of docs/report.md.
"""

from __future__ import annotations

import fnmatch
import json
import re
import sys
from pathlib import Path
from typing import Any

import cmrc
from cmrc import files

ROOT = Path(__file__).resolve().parent.parent.parent
Schema = dict[str, Any]

RUNS: tuple[dict[str, Any], ...] = (
    {"dsps": 4, "duration_s": 0.15},
    {"preset": "saturated", "dsps": 4, "duration_s": 0.2, "settings": {"scheduling.agv_phase": "together"}},
    {
        "dsps": 3,
        "duration_s": 0.3,
        "settings": {
            "report.reference": "none",
            "machine.links": "0.0:1.4",
            "machine.nets": "0.TCLK0>1.IIOF1",
            "machine.slots": 4,
        },
        "events": [
            {"at_s": 0.1, "action": "unplug", "dsp": 2},
            {"at_s": 0.12, "action": "plug", "dsp": 3},
            {"at_s": 0.15, "action": "fail", "dsp": 1},
            {"at_s": 0.9, "action": "hang", "dsp": 0},
        ],
    },
    {"dsps": 2, "duration_s": 0.2, "settings": {"dock.crane": "gantry", "dock.agvs": 2, "dock.wind_mean_m_s": 12}},
    {"dsps": 1, "duration_s": 0.2, "events": [{"at_s": 0.1, "action": "fail", "dsp": 0}]},
    {"dsps": 2, "duration_s": 1.5, "events": [{"at_s": 0.2, "action": "fail_drive", "joint": "slew"}]},
    {"dsps": 1, "duration_s": 0.06, "settings": {"machine.cycle_time_factor": 100}},
    {"dsps": 2, "duration_s": 0.1, "settings": {"scheduling.servo_loss_share": 1}},
)
"""What the schema is made from: presets, cranes, failures, an error that is handled, a run that stops, one without a
reference, one that ends before the first refresh, and one in which PID never servoes."""

MAPS = (
    "tasks",
    "tasks.*.execution_causes_ps",
    "tasks.*.execution_cycles",
    "tasks.*.why_late.parts_ps",
    "tasks.*.why_late.behind_ps",
    "misses.parts_ps",
    "configuration",
    "dsps.causes",
    "dsps.tasks_ps",
    "buses",
    "buses.*.masters",
    "buses.*.targets",
    "starved_intervals",
    "pid_error",
    "sway",
    "agvs",
    "drives",
    "errors.joints",
    "errors.path",
    "errors.sway",
    "errors.lag",
    "errors.agvs",
    "errors.demand",
    "errors.residual_sway",
    "errors.path_joints",
)
"""Objects whose keys a run names; `*` is one such name. Lists have no step of their own."""

ENUMERATIONS = {
    "stop_reason": [
        "completed",
        "interrupted",
        "under_way",
        "job_done",
        "no_dsp_left",
        "drives_stopped",
        "plant_fault",
    ],
    "reference": ["ideal", "none"],
    "misses.outcome": ["late", "unfinished", "never_started", "lost", "dropped"],
}
NEVER_SEEN: dict[str, Schema] = {
    "after_stop": {"type": ["object", "null"]},
    "agvs.*.peak": {"type": ["number", "null"]},
    "agvs.*.rms": {"type": ["number", "null"]},
    "audit.violations": {"type": "array", "items": {"type": "string"}},
    "cycles.agv": {"type": ["integer", "null"]},
    "cycles.agv_interval_refreshes": {"type": ["integer", "null"]},
    "reference_problem": {"type": ["string", "null"]},
}
"""What none of the runs has but as null or empty, from docs/report.md"""
INSTANTS = re.compile(r"(_s|_ps|_hz|_m|_rad|_share|_m2s)$")
"""Units of keys that may be null in a run that has not come so far"""
MEASURED = re.compile(r"\.(best|mean|p50|p99|p99_9|worst|rms|peak|utilisation|load_of_doing_nothing)$")
"""Values that are null where nothing has been measured: of summaries, of errors and of loads"""


def descriptions() -> dict[str, str]:
    """By top-level key, the second column of the first table of docs/report.md."""
    text = (ROOT / "docs" / "report.md").read_text(encoding="utf-8")
    table = text.partition("| key | meaning |")[2].partition("\n\n")[0]
    found = {}
    for line in table.splitlines()[2:]:
        keys, meaning = (cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:3])
        meaning = meaning.replace("\\|", "|")
        for key in re.findall(r"`([^`]+)`", keys):
            found[key] = meaning
    return found


def may_be_missing(path: str) -> bool:
    return MEASURED.search(path) is not None or (INSTANTS.search(path) is not None and "." in path)


def merged(values: list[Any], path: str) -> Schema:
    """The schema of all these values, which are all found at one place."""
    if path in NEVER_SEEN:
        return dict(NEVER_SEEN[path])
    parts: dict[str, list[Any]] = {}
    for value in values:
        name = (
            "null"
            if value is None
            else {bool: "boolean", int: "number", float: "number", str: "string", dict: "object", list: "array"}[
                type(value)
            ]
        )
        parts.setdefault(name, []).append(value)
    types: list[str] = []
    schema: Schema = {}
    if "boolean" in parts:
        types.append("boolean")
    if "number" in parts:
        types.append(
            "integer"
            if all(isinstance(v, int) for v in parts["number"]) and not path.endswith(("_s", "_hz", "_share"))
            else "number"
        )
    if "string" in parts:
        types.append("string")
    if "object" in parts:
        types.append("object")
        schema |= _object(parts["object"], path)
    if "array" in parts:
        types.append("array")
        items = [item for value in parts["array"] for item in value]
        assert items, f"{path}: the list is empty in each run"
        schema["items"] = merged(items, path)
    if not types:
        assert INSTANTS.search(path), f"{path}: no run has a value for it; a row of NEVER_SEEN says its type"
        types = ["number"]
    if "null" in parts or (types in (["integer"], ["number"]) and may_be_missing(path)):
        types.append("null")
    schema["type"] = types[0] if len(types) == 1 else types
    if path in ENUMERATIONS:
        schema["enum"] = ENUMERATIONS[path]
    return schema


def _object(values: list[dict[str, Any]], path: str) -> Schema:
    if any(fnmatch.fnmatchcase(path, pattern) and path.count(".") == pattern.count(".") for pattern in MAPS):
        inner = [item for value in values for item in value.values()]
        return {"additionalProperties": merged(inner, f"{path}.*") if inner else {}}
    keys = sorted({key for value in values for key in value})
    return {
        "properties": {
            key: merged([value[key] for value in values if key in value], f"{path}.{key}" if path else key)
            for key in keys
        },
        "required": [key for key in keys if all(key in value for value in values)],
        "additionalProperties": False,
    }


def schema_of(reports: list[dict[str, Any]]) -> Schema:
    schema = merged(reports, "")
    texts = descriptions()
    for key, part in schema["properties"].items():
        if key in texts:
            part["description"] = texts[key]
    schema["properties"]["hash"]["pattern"] = "^[0-9a-f]{64}$"
    schema["properties"]["schema_version"] = {
        "const": reports[0]["schema_version"],
        "description": texts["schema_version"],
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Report of a run of the CMRC emulator",
        **schema,
    }


def main(arguments: list[str]) -> int:
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    # JSON as it is written, so that a number is what a reader sees.
    reports = [json.loads(json.dumps(cmrc.run(**run).report)) for run in RUNS]
    files.write(Path(arguments[0]), json.dumps(schema_of(reports), indent=1, ensure_ascii=False, sort_keys=True) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
