"""Every word of [[events]] with every target: what it is to the machine, and that docs/configuration.md lists it."""

import re
import subprocess
from pathlib import Path
from typing import Any

import pytest
from cmrc import _core
from locations import BUILD, ROOT

cmrc = _core.cmrc
ACTIONS = {action["name"]: action for action in cmrc.timed_actions()}
JOINTS = ["travel", "slew", "luff", "hoist", "rotate"]

# The numbers by which traces and saved runs know the actions, and the amount that goes with the word: they stay.
IN_TRACES: dict[str, tuple[int, int]] = {
    "fail": (0, 0),
    "freeze": (1, 0),
    "hang": (2, 0),
    "unplug": (3, 0),
    "plug": (4, 0),
    "reset": (5, 0),
    "break_link": (6, 1),
    "repair_link": (6, 0),
    "slow": (7, 250_000),
    "pause_host": (8, 1_500_000_000),
    "stall_bus": (9, 1_500_000_000),
    "fail_drive": (10, 1),
    "repair_drive": (10, 0),
    "stick_encoder": (11, 1),
    "repair_encoder": (11, 0),
    "stick_sway": (12, 1),
    "repair_sway": (12, 0),
    "stick_second_sway": (13, 1),
    "repair_second_sway": (13, 0),
    "stick_drive_status": (14, 1),
    "repair_drive_status": (14, 0),
    "stick_drive_speed": (15, 1),
    "repair_drive_speed": (15, 0),
    "stick_load_cell": (16, 1),
    "repair_load_cell": (16, 0),
    "stick_anemometer": (17, 1),
    "repair_anemometer": (17, 0),
}
# The values of each target's field, with the numbers that the machine counts them by, and one that nothing has.
TARGETS: dict[str, tuple[dict[Any, int], Any]] = {
    "": ({None: 0}, None),
    "dsp": ({slot: slot for slot in range(4)}, 4),
    "bus": ({"A": 0, "B": 1}, "C"),
    "joint": ({joint: number for number, joint in enumerate(JOINTS)}, "trolley"),
    "axis": ({"alpha": 0, "beta": 1}, "gamma"),
}
AMOUNTS: dict[str, dict[str, Any]] = {"": {}, "factor": {"factor": 0.25}, "lasts_ms": {"lasts_ms": 1.5}}
SETTINGS = {"dsps": 3, "slots": 4, "duration_s": 0.06, "sway_sensors": 2, "agvs": 1}


def event(name: str, target: Any, at_s: float) -> dict[str, Any]:
    action = ACTIONS[name]
    fields = {"at_s": at_s, "action": name, **AMOUNTS[action["amount"]]}
    return fields if target is None else fields | {action["target"]: target}


def test_the_words_are_those_of_the_traces_and_set() -> None:
    assert set(ACTIONS) == {*IN_TRACES, "set"}
    assert {action["target"] for action in ACTIONS.values()} == set(TARGETS)
    assert {action["amount"] for action in ACTIONS.values()} == set(AMOUNTS)


@pytest.mark.parametrize("name", IN_TRACES)
def test_a_word_takes_each_target_that_is_there_and_no_other(name: str) -> None:
    values, beyond = TARGETS[ACTIONS[name]["target"]]
    for value in values:
        # Slot 3 is empty. An action on a board needs a board; a board can be put in only where none is.
        right = ACTIONS[name]["target"] != "dsp" or name.endswith("_link") or (value == 3) == (name == "plug")
        if right:
            cmrc.config(settings=SETTINGS, events=[event(name, value, 0.01)])
        else:
            with pytest.raises(cmrc.ConfigError, match="unplug it first|plug a board in first"):
                cmrc.config(settings=SETTINGS, events=[event(name, value, 0.01)])
    if beyond is not None:
        with pytest.raises(cmrc.ConfigError, match=rf"events\.{ACTIONS[name]['target']}: "):
            cmrc.config(settings=SETTINGS, events=[event(name, beyond, 0.01)])


def test_each_word_is_its_action_number_and_amount_to_the_machine(tmp_path: Path) -> None:
    rows: list[tuple[dict[str, Any], tuple[int, int, int]]] = []
    for name, (action, amount) in IN_TRACES.items():
        for value, number in TARGETS[ACTIONS[name]["target"]][0].items():
            if ACTIONS[name]["target"] == "dsp" and (value == 3) != (name == "plug"):
                continue
            rows.append((event(name, value, 0.005 + 0.0005 * len(rows)), (action, number, amount)))
            if name == "unplug":  # so that the words behind it have a board
                rows.append((event("plug", value, 0.005 + 0.0005 * len(rows)), (4, number, 0)))
    settings = cmrc.config(settings=SETTINGS, events=[fields for fields, _ in rows])
    (tmp_path / "run.toml").write_text(settings.to_toml())
    subprocess.run(
        [BUILD / "bin" / "emulator", "--config", "run.toml", "--quiet", "--trace", "trace"], cwd=tmp_path, check=False
    )
    seen = []
    for line in (tmp_path / "trace").read_text().splitlines():
        if matched := re.match(
            r"([0-9.]+) \[host\] scripted action=(\d+) number=(\d+) amount_low=(\d+) amount_high=(\d+)", line
        ):
            at, *words = matched.groups()
            action, number, low, high = map(int, words)
            seen.append((round(float(at), 6), (action, number, low + (high << 32))))
    assert seen == [(round(fields["at_s"], 6), expected) for fields, expected in rows]
    assert len(seen) > 60


def test_a_gantrys_trolley_has_the_number_of_luff(tmp_path: Path) -> None:
    events = [event("fail_drive", "trolley", 0.01)]
    settings = cmrc.config(settings={"duration_s": 0.03, "crane": "gantry"}, events=events)
    (tmp_path / "run.toml").write_text(settings.to_toml())
    subprocess.run(
        [BUILD / "bin" / "emulator", "--config", "run.toml", "--quiet", "--trace", "trace"], cwd=tmp_path, check=False
    )
    assert " scripted action=10 number=2 amount_low=1 " in (tmp_path / "trace").read_text()


def test_the_documentation_lists_each_word_with_its_fields() -> None:
    text = (ROOT / "docs" / "configuration.md").read_text()
    listed: dict[str, set[str]] = {}
    for names, fields in re.findall(
        r"^\| (`\w+`(?:, `\w+`)?) \| (.*?) ?\| .* \|$", text.split("## `[[events]]`")[1].split("\n## ")[0], re.MULTILINE
    ):
        for name in re.findall(r"`(\w+)`", names):
            assert name not in listed
            listed[name] = set(re.findall(r"`(\w+)`", fields))
    own = {name: {action["target"], action["amount"]} - {""} for name, action in ACTIONS.items()}
    own["set"] = {"key", "value"}
    assert listed == own
