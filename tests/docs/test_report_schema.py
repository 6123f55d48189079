"""docs/report.schema.json says what a report is: real reports obey it, changed ones do not; report.md has its keys."""

import json
import re
from typing import Any

import cmrc
import jsonschema
import pytest
from locations import ROOT

SCHEMA = json.loads((ROOT / "docs" / "report.schema.json").read_text(encoding="utf-8"))
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)


def report(**run: Any) -> dict[str, Any]:
    return json.loads(json.dumps(cmrc.run(**run).report))


@pytest.mark.parametrize(
    "run",
    [
        {"dsps": 2, "duration_s": 0.05},
        {"preset": "heavy", "dsps": 3, "duration_s": 0.08, "events": [{"at_s": 0.04, "action": "hang", "dsp": 1}]},
        {
            "preset": "tight",
            "dsps": 1,
            "duration_s": 0.08,
            "settings": {"report.reference": "none", "machine.cycle_time_factor": 12},
        },
        {
            "dsps": 16,
            "duration_s": 0.05,
            "settings": {"dock.agvs": 8, "bus.topology": "single", "dock.crane": "gantry"},
        },
        {"dsps": 2, "duration_s": 0.06, "events": [{"at_s": 0.03, "action": "fail", "dsp": n} for n in (0, 1)]},
        {"dsps": 2, "duration_s": 0.06, "settings": {"machine.cycle_time_factor": 100}},
        {"dsps": 4, "duration_s": 0.09, "settings": {"scheduling.servo_loss_share": 1, "dock.crane": "gantry"}},
    ],
    ids=["default", "heavy", "tight", "single bus", "no DSP left", "no refresh", "no servoing"],
)
def test_reports_obey_the_schema(run: dict[str, Any]) -> None:
    errors = [f"{'.'.join(map(str, e.absolute_path))}: {e.message[:200]}" for e in VALIDATOR.iter_errors(report(**run))]
    assert not errors


def test_what_a_report_has_not_is_refused() -> None:
    whole = report(dsps=1, duration_s=0.03)
    for key in ("hash", "tasks", "dsps", "audit"):
        assert not VALIDATOR.is_valid({k: v for k, v in whole.items() if k != key})
    assert not VALIDATOR.is_valid({**whole, "unheard_of": 1})
    assert not VALIDATOR.is_valid({**whole, "simulated_ps": "30 ms"})
    assert not VALIDATOR.is_valid({**whole, "stop_reason": "bored"})
    assert not VALIDATOR.is_valid({**whole, "schema_version": whole["schema_version"] + 1})


def test_the_schema_has_the_keys_and_the_words_of_the_page() -> None:
    page = (ROOT / "docs" / "report.md").read_text(encoding="utf-8")
    table = page.partition("| key | meaning |")[2].partition("\n\n")[0]
    meanings = {}
    for line in table.splitlines()[2:]:
        keys, meaning = (cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:3])
        meanings |= {key: meaning.replace("\\|", "|") for key in re.findall(r"`([^`]+)`", keys)}
    assert len(meanings) > 30
    assert set(meanings) | {"boot_words"} == set(SCHEMA["properties"])
    other = [key for key, meaning in meanings.items() if SCHEMA["properties"][key]["description"] != meaning]
    assert not other, (
        "scripts/documents/report_schema.py docs/report.schema.json writes the page's words into the schema"
    )


def test_the_schema_is_a_schema() -> None:
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
