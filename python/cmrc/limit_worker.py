"""``python -m cmrc.limit_worker PARENT``: runs points of a scan (limit_scans.py). A line of standard input is a
request, ``{"toml": ..., "to_its_end": ...}``; a line of standard output is the point's outcome."""

from __future__ import annotations

import json
import os
import sys
from typing import Any

from cmrc import _core
from cmrc.explanations import due_ps
from cmrc.processes import die_with_parent, leave_signals_to_parent

_references: dict[str, _core.cmrc.Reference] = {}
"""The last ideal run: points that may share one come one after the other."""


def run(toml: str, to_its_end: bool) -> dict[str, Any]:
    """Runs a configuration to its first miss; with ``to_its_end`` to its end, against its ideal run."""
    wanted = {
        "run.strict": False,
        "report.misses_max": 10_000,  # a job that was due earlier may be booked later
        "report.reference": "ideal" if to_its_end else "none",
    }
    config = _core.cmrc.config(toml=toml, name="point", settings=wanted)
    group = _core.cmrc.reference_key(config)
    if group in _references:
        simulation = _core.cmrc.Simulation(config, _references[group])
    else:
        simulation = _core.cmrc.Simulation(config)
    if to_its_end:
        simulation.run()
        _references.clear()
        reference = simulation.reference()
        if reference is not None:
            _references[group] = reference
    else:
        simulation.run(lambda simulated_s, duration_s: simulation.misses == 0)
    return outcome(json.loads(simulation.report_json()), to_its_end)


def outcome(report: dict[str, Any], to_its_end: bool) -> dict[str, Any]:
    """The outcome of a point. Raises RuntimeError if there was no ideal run to measure against."""
    misses = sum(task["misses"] for task in report["tasks"].values())
    starved = sum(report["starved_intervals"].values())
    whole = report["stop_reason"] in ("completed", "job_done")
    judged = misses > 0 or any(task["on_time"] for task in report["tasks"].values())
    first = min(report["misses"], key=due_ps, default=None)  # by deadline, not in the order in which they were booked
    found: dict[str, Any] = {
        "ran": True,
        "passed": whole and judged and misses == 0 and starved == 0,
        "refused": None,
        "judged": judged,
        "stop_reason": report["stop_reason"],
        "first_miss": None if first is None else first["kind"],
        "first_miss_s": None if first is None else due_ps(first) / 1e12,
        "starved_intervals": starved,
        "errors": None,
    }
    if to_its_end:
        errors, rates = report["errors"], report["rates"]
        if errors is None:
            raise RuntimeError(f"limits: there is no ideal run: {report['reference_problem']}")
        found["errors"] = {
            "f_p_realised_hz": rates["f_p"]["realised_hz"],
            "f_p_missed_share": rates["f_p"]["missed_share"],
            "f_t_realised_hz": rates["f_t"]["realised_hz"],
            "f_t_missed_share": rates["f_t"]["missed_share"],
            "load_rms_m": errors["load_m"]["rms"],
            "lag_s": errors["lag"].get("crane", {}).get("end_s"),
        }
    return found


def main() -> None:
    leave_signals_to_parent()
    die_with_parent(int(sys.argv[1]))
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # a run's own output is not part of the answer
    for line in sys.stdin:
        asked = json.loads(line)
        try:
            answer = run(asked["toml"], asked["to_its_end"])
        except Exception as error:  # noqa: BLE001 (the caller raises it)
            answer = {"failed": f"{error}"}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
