"""``python -m cmrc.results``: the experiments behind docs/results.md."""

from __future__ import annotations

import argparse
import dataclasses
import math
import os
import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from cmrc import early_signals

if __name__ == "__main__":
    early_signals.handle()

from cmrc import arguments, files, signals, streams
from cmrc.extras import needed
from cmrc.results import page, stated
from cmrc.results.claim import Claim
from cmrc.results.cost import Cost
from cmrc.results.dsps import Dsps
from cmrc.results.failures import Failures
from cmrc.results.fleet import Fleet
from cmrc.results.hotplug import Hotplug
from cmrc.results.importance import Importance
from cmrc.results.learning import Learning
from cmrc.results.runs import Laboratory

MOST = 2**63
"""Every number of a claim is below it, and above its negative."""
CLAIMS: tuple[type[Claim], ...] = (Dsps, Failures, Hotplug, Importance, Learning, Fleet, Cost)


def parser() -> argparse.ArgumentParser:
    """The command line; every parameter of every claim is an option."""
    from cmrc.commands.common import Parser

    result = Parser(
        prog="cmrc.results",
        description="The paper's six claims and what missed deadlines cost, each put to its experiment.",
    )
    result.add_argument(
        "--claim",
        type=arguments.whole_option,
        action="append",
        choices=[c.NUMBER for c in CLAIMS],
        help="only this one; may be given again",
    )
    result.add_argument(
        "--page",
        type=Path,
        help="put the sections into this page, and the plots beside it in a folder of its name; "
        "otherwise they are printed",
    )
    result.add_argument(
        "--jobs",
        type=arguments.whole_option,
        default=os.cpu_count() or 1,
        help="runs at a time (default: one per core)",
    )
    result.add_argument(
        "--cache", type=Path, help="keep the runs' reports in this folder, and use those that are there"
    )
    result.add_argument(
        "--quick", action="store_true", help="shrunken experiments, which show nothing but that they run"
    )
    result.add_argument("--plots", type=Path, help="folder for the plots, where no page is written")
    for name, owners in _fields().items():
        default = next(iter(owners.values())).default
        word = _kind(default).__name__.upper()
        shape = f"{word},..." if isinstance(default, tuple) else word
        result.add_argument(_option(name), metavar=shape, help="; ".join(_explained(owners)).replace("%", "%%"))
    return result


def _fields() -> dict[str, dict[type[Claim], dataclasses.Field[Any]]]:
    """The parameters by name, each with the claims that have it."""
    fields: dict[str, dict[type[Claim], dataclasses.Field[Any]]] = {}
    for claim in CLAIMS:
        for one in dataclasses.fields(claim):
            fields.setdefault(one.name, {})[claim] = one
    return fields


def _explained(owners: Mapping[type[Claim], dataclasses.Field[Any]]) -> list[str]:
    """What the parameter is: claims for which it has the same meaning and default are listed together."""
    numbers: dict[tuple[str, str], list[int]] = {}
    for claim, one in owners.items():
        numbers.setdefault((one.metadata["help"], _text(one.default)), []).append(claim.NUMBER)
    return [
        f"claim {', '.join(map(str, claims))}: {meaning} (default {default})"
        for (meaning, default), claims in numbers.items()
    ]


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _text(value: object) -> str:
    """A parameter's value as it is given on the command line."""
    return ",".join(str(v) for v in value) if isinstance(value, tuple) else str(value)


def _kind(default: object) -> type:
    return type(default[0]) if isinstance(default, tuple) else type(default)


def _read(kind: type, word: str, least: float | None) -> Any:
    """A parameter of the command line. Raises ValueError, OverflowError."""
    if kind is str:
        return word
    number = arguments.read_whole(word) if kind is int else float(arguments.read_number(word))
    fits = number > 0 if kind is float and least is None else number >= (least or 0)
    if not fits or not -MOST < number < MOST:
        raise ValueError(f"{word} is out of range")
    return number


def _right(kind: type, least: float | None) -> str:
    """What a parameter can be."""
    name = {int: "a whole number", float: "a number"}.get(kind, "a name")
    if kind is str or least == -math.inf:
        return name
    return f"{name} above 0" if kind is float and least is None else f"{name} from {least or 0:g} on"


def chosen(claim: type[Claim], given: argparse.Namespace) -> Claim:
    """The claim with what the command line changes. Raises ValueError naming the option."""
    changes: dict[str, Any] = {}
    for one in dataclasses.fields(claim):
        text, several, kind = getattr(given, one.name, None), isinstance(one.default, tuple), _kind(one.default)
        if text is None:
            continue
        try:
            values = tuple(_read(kind, word, one.metadata["least"]) for word in text.split(",") if word)
        except (ValueError, OverflowError):
            right = _right(kind, one.metadata["least"]) + (" or a list of them" if several else "")
            raise ValueError(f"{_option(one.name)}: {text!r}; {right} is expected") from None
        empty = several and one.metadata["quick"] == ()  # a part of the experiment that may be left out
        if (not values and not empty) or (len(values) > 1 and not several):
            raise ValueError(
                f"{_option(one.name)}: {text!r}; claim {claim.NUMBER} expects "
                f"{'one value or several' if several else 'one value'}"
            )
        if len(set(values)) < len(values):
            raise ValueError(f"{_option(one.name)}: {text!r} has a value twice; each is run once")
        changes[one.name] = values if several else values[0]
    return dataclasses.replace(claim.quick() if given.quick else claim(), **changes)


def examine(claim: Claim, laboratory: Laboratory, plots: Path | None, link: str = "") -> str:
    """Runs the experiment; the section, and the plot as a file in ``plots``."""
    runs = claim.runs()
    rows = claim.rows(list(zip(runs, laboratory.all(runs, f"claim {claim.NUMBER}"), strict=True)))
    text = f"## {claim.NUMBER}. {claim.TITLE}\n\n{claim.verdict(rows)}\n\n"
    if plots is not None and rows:
        from matplotlib import rcParams
        from matplotlib.figure import Figure

        rcParams.update({"svg.hashsalt": "cmrc", "svg.fonttype": "none"})
        figure = Figure(figsize=(8, 3.2), layout="constrained")
        claim.draw(rows, figure)
        plots.mkdir(parents=True, exist_ok=True)
        name = f"claim-{claim.NUMBER}-{claim.NAME}.svg"
        with files.writing(plots / name) as out:
            figure.savefig(out, format="svg", metadata={"Date": None})
        if link:
            text += f"![{claim.TITLE}]({link}/{name})\n\n"
    again = f"\nAgain: `python -m cmrc.results --claim {claim.NUMBER}{options(claim)}`.\n"
    return page.wrapped(text + claim.section(rows) + stated.text(claim, runs)) + again


def options(claim: Claim) -> str:
    """What on the command line gives these parameters."""
    changed = [one for one in dataclasses.fields(claim) if getattr(claim, one.name) != one.default]
    return "".join(f" {_option(one.name)}{_argument(_text(getattr(claim, one.name)))}" for one in changed)


def _argument(text: str) -> str:
    """A value behind its option. argparse takes a word that begins with - for another option."""
    return ("=" if text.startswith("-") else " ") + shlex.quote(text)


def main(arguments: Sequence[str] | None = None) -> int:
    """0; 1 where a write or a run failed; 2 for bad input; 130, 143 or 129 after a signal."""
    from cmrc.commands.common import status_of

    streams.prepare()
    try:
        with signals.raised():
            return status_of("cmrc.results", _do, parser().parse_args(arguments))
    except RuntimeError as error:  # --help could not be shown
        streams.say(f"cmrc.results: {error}")
        return 1
    except KeyboardInterrupt as stop:
        streams.say("cmrc.results: interrupted")
        return signals.status(stop)


def _do(given: argparse.Namespace) -> int:
    asked = [claim for claim in CLAIMS if given.claim is None or claim.NUMBER in given.claim]
    unused = [
        name for name, owners in _fields().items() if getattr(given, name) is not None and not set(owners) & set(asked)
    ]
    if unused:
        numbers = ", ".join(str(claim.NUMBER) for claim in asked)
        raise ValueError(f"{_option(unused[0])}: claim {numbers} has no such parameter")
    if given.jobs < 1:
        raise ValueError("--jobs: at least 1 is expected")
    claims = [chosen(claim, given) for claim in asked]
    plots = _checked_plots(given)
    laboratory = Laboratory(given.jobs, given.cache)
    for claim in claims:
        section = examine(claim, laboratory, plots, given.page.stem if given.page else "")
        if given.page:
            page.write(given.page, claim.NUMBER, section)
        else:
            streams.show(section + "\n")
    return 0


def _checked_plots(given: argparse.Namespace) -> Path | None:
    """The folder for the plots. All outputs are checked, before runs that take minutes. Raises ValueError,
    ImportError, OSError."""
    from cmrc.commands import common

    common.folder("--cache", given.cache)
    if given.page:
        common.output("--page", given.page)
        page.read(given.page)
    option = "--page" if given.page else "--plots"
    plots: Path | None = given.page.with_suffix("") if given.page else given.plots
    common.folder(option, plots)
    if plots is not None:
        needed("matplotlib", "plot", option)
    return plots


if __name__ == "__main__":
    sys.exit(main())
