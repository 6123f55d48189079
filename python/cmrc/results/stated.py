"""What a section says of its runs' settings: each that differs from its default, read from the runs themselves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from cmrc import _core
from cmrc.floats import shortest
from cmrc.results.claim import Claim
from cmrc.results.judgement import markdown
from cmrc.results.runs import Run
from cmrc.simulation import Setting

PRESET, LAYOUT, EVENTS = "preset", "dock.layout", "events"
Stated = Mapping[str, str]
"""By key what is printed of it."""


@dataclass(frozen=True)
class Row:
    """What holds for the runs with these labels: in one part of the section, and with one value of another label.
    ``items`` are as they are printed."""

    parts: tuple[str, ...]
    label: str
    items: tuple[str, ...]

    def cells(self) -> dict[str, str]:
        """As a row of the table."""
        return {"runs": ": ".join(filter(None, ["; ".join(self.parts), self.label])), "settings": ", ".join(self.items)}


def text(claim: Claim, runs: Sequence[Run]) -> str:
    """The table at the end of a section; nothing of no runs."""
    if not runs:
        return ""
    table = markdown({"runs": "runs", "settings": "settings"}, [row.cells() for row in rows(claim, runs)])
    return (
        "\n**Settings.** These differ from their defaults ([configuration.md](configuration.md)), and no others. All "
        "rows that fit a run hold for it.\n\n" + table
    )


def rows(claim: Claim, runs: Sequence[Run]) -> list[Row]:
    """First what all runs share, then what those of a part share, then what goes with each label."""
    by_part: dict[str, list[Run]] = {}
    for run in runs:
        by_part.setdefault(claim.part(run), []).append(run)
    stated = {part: _printed(own) for part, own in by_part.items()}
    every = [one for part in stated.values() for one in part]
    shared = {key: value for key, value in every[0].items() if all(one.get(key) == value for one in every)}
    table = [Row((), "all", tuple(shared.values()))] if shared and len(by_part) > 1 else []
    known = shared if table else {}
    for part, own in by_part.items():
        left = [{key: value for key, value in one.items() if key not in known} for one in stated[part]]
        table += _of_part(claim, part or "", own, left)
    return _merged(table)


def _of_part(claim: Claim, part: str, runs: Sequence[Run], stated: Sequence[Stated]) -> list[Row]:
    first = stated[0]
    constant = [key for key in first if all(one[key] == first[key] for one in stated)]
    parts = (part,) if part else ()
    table = [Row(parts, "" if part else "all", tuple(first[key] for key in constant))] if constant else []
    of_label: dict[str, list[str]] = {}
    drawn = []
    for key in (key for key in first if key not in constant):
        label = _owner(claim, runs, [one[key] for one in stated])
        of_label.setdefault(label, []).append(key) if label else drawn.append(key)
    for label, keys in of_label.items():
        values = {run.label[label]: one for run, one in zip(runs, stated, strict=True)}
        if len(keys) == 1 and all(_is_number(v) and one[keys[0]] == _item(keys[0], v) for v, one in values.items()):
            table.append(Row(parts, claim.named(label, "n"), (f"`{keys[0]} = n`",)))
        else:
            table += [
                Row(parts, claim.named(label, value), tuple(one[key] for key in keys)) for value, one in values.items()
            ]
    if drawn:
        table.append(Row(parts, "each trial", ("drawn: " + ", ".join(f"`{key}`" for key in drawn),)))
    return table


def _owner(claim: Claim, runs: Sequence[Run], values: Sequence[str]) -> str | None:
    """The label with the fewest values that these values are a function of; None if each run drew its own."""
    found = []
    for label in (label for label in runs[0].label if label not in claim.DRAWN and label != claim.PART):
        pairs = {(run.label[label], value) for run, value in zip(runs, values, strict=True)}
        own = {run.label[label] for run in runs}
        if len(pairs) == len(own):
            found.append((len(own), label))
    return min(found, key=lambda one: one[0])[1] if found else None


def _merged(table: Sequence[Row]) -> list[Row]:
    """Parts that say the same in a row share it."""
    known: dict[tuple[str, tuple[str, ...]], Row] = {}
    for row in table:
        key = row.label, row.items
        known[key] = Row((*known[key].parts, *row.parts), *key) if key in known else row
    return list(known.values())


def _printed(runs: Sequence[Run]) -> list[Stated]:
    """Of each run of a part all keys that differ from the default in any of them."""
    all_values = [_values(run) for run in runs]
    differing = {
        key
        for run, values in zip(runs, all_values, strict=True)
        for key, value in values.items()
        if value != _usual(run.preset).get(key, "")
    }
    return [{key: _item(key, value) for key, value in values.items() if key in differing} for values in all_values]


def _values(run: Run) -> dict[str, Setting]:
    """Its whole configuration by key; preset, layout and events as text."""
    config = _core.cmrc.config(preset=run.preset, settings=run.all_settings())
    preset = "" if run.preset in (None, "base") else str(run.preset)
    return {PRESET: preset, **config.to_dict(), LAYOUT: run.layout, EVENTS: _events(run.events)}


@cache
def _usual(preset: str | None) -> dict[str, Setting]:
    return dict(_core.cmrc.config(preset=preset).to_dict())


def _item(key: str, value: Setting) -> str:
    if key == PRESET:
        return f"preset `{value or 'base'}`"
    if key == EVENTS:
        return str(value) or "no events"
    if key == LAYOUT:
        return f"`{key}` with " + " ".join(f"`{line}`" for line in str(value).splitlines()) if value else "no layout"
    return f"`{key} = {_toml(value)}`"


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _toml(value: Setting) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else shortest(value)


def _events(events: Sequence[Mapping[str, Setting]]) -> str:
    """``[[events]]`` of a run: those that come again and again by the first one and their distance."""
    if not events:
        return ""
    rest = [{key: value for key, value in event.items() if key != "at_s"} for event in events]
    at = [float(event["at_s"]) for event in events]
    every = round((at[-1] - at[0]) / (len(at) - 1), 9) if len(at) > 1 else 0.0
    if len(at) > 2 and rest == rest[:1] * len(at) and at == [round(at[0] + n * every, 9) for n in range(len(at))]:
        return f"event {_inline(events[0])} and again every {shortest(every)} s, {len(at)} in all"
    return ", ".join(f"event {_inline(event)}" for event in events)


def _inline(event: Mapping[str, Setting]) -> str:
    return "`{" + ", ".join(f"{key} = {_toml(value)}" for key, value in event.items()) + "}`"
