"""``python -m cmrc.results``: the experiments behind docs/results.md."""

from __future__ import annotations

import argparse
import dataclasses
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from cmrc import files
from cmrc.extras import needed
from cmrc.results import cost, dsps, failures, fleet, hotplug, importance, learning, page
from cmrc.results.runs import Laboratory
from cmrc.simulation import ConfigError

CLAIMS: tuple[ModuleType, ...] = (dsps, failures, hotplug, importance, learning, fleet, cost)


def parser() -> argparse.ArgumentParser:
    """The command line; every parameter of every claim is an option."""
    result = argparse.ArgumentParser(
        prog="cmrc.results",
        description="The paper's six claims and what missed deadlines cost, each put to its experiment.",
    )
    result.add_argument(
        "--claim",
        type=int,
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
    result.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="runs at a time (default: one per core)")
    result.add_argument(
        "--cache", type=Path, help="keep the runs' reports in this folder, and use those that are there"
    )
    result.add_argument(
        "--quick", action="store_true", help="shrunken experiments, which show nothing but that they run"
    )
    result.add_argument("--plots", type=Path, help="folder for the plots, where no page is written")
    for name, claims in _fields().items():
        default = getattr(claims[0].Parameters(), name)
        kind = type(default[0]) if isinstance(default, tuple) else type(default)
        shape = f"{kind.__name__.upper()},..." if isinstance(default, tuple) else kind.__name__.upper()
        result.add_argument(
            f"--{name.replace('_', '-')}", metavar=shape, help="; ".join(_explained(claims, name)).replace("%", "%%")
        )
    return result


def _explained(claims: Sequence[ModuleType], name: str) -> list[str]:
    """What the parameter is: claims for which it has the same meaning and default are listed together."""
    parameters: dict[tuple[str, str], list[int]] = {}
    for claim in claims:
        one = next(f for f in dataclasses.fields(claim.Parameters) if f.name == name)
        parameters.setdefault((one.metadata["help"], _shown(claim, name)), []).append(claim.NUMBER)
    return [
        f"claim {', '.join(map(str, numbers))}: {meaning} (default {default})"
        for (meaning, default), numbers in parameters.items()
    ]


def _fields() -> dict[str, list[ModuleType]]:
    fields: dict[str, list[ModuleType]] = {}
    for claim in CLAIMS:
        for one in dataclasses.fields(claim.Parameters):
            fields.setdefault(one.name, []).append(claim)
    return fields


def _shown(claim: ModuleType, name: str) -> str:
    value = getattr(claim.Parameters(), name)
    return ",".join(str(v) for v in value) if isinstance(value, tuple) else str(value)


def parameters(claim: ModuleType, given: argparse.Namespace) -> Any:
    """The claim's parameters with what the command line changes. Raises ValueError naming the option."""
    chosen = claim.QUICK if given.quick else claim.Parameters()
    changes: dict[str, Any] = {}
    for one in dataclasses.fields(claim.Parameters):
        text = getattr(given, one.name, None)
        if text is None:
            continue
        default = getattr(claim.Parameters(), one.name)
        kind = type(default[0]) if isinstance(default, tuple) else type(default)
        try:
            values = tuple(kind(word) for word in text.split(",") if word)
        except ValueError:
            raise ValueError(
                f"--{one.name.replace('_', '-')}: {text!r} is no {kind.__name__} or list of them"
            ) from None
        if not values or (len(values) > 1 and not isinstance(default, tuple)):
            raise ValueError(
                f"--{one.name.replace('_', '-')}: {text!r}; claim {claim.NUMBER} expects "
                f"{'one value or several' if isinstance(default, tuple) else 'one value'}"
            )
        changes[one.name] = values if isinstance(default, tuple) else values[0]
    return dataclasses.replace(chosen, **changes)


def examine(claim: ModuleType, chosen: Any, laboratory: Laboratory, plots: Path | None, link: str = "") -> str:
    """Runs the experiment; the section, and the plot as a file in ``plots``."""
    runs = claim.runs(chosen)
    rows = claim.rows(chosen, list(zip(runs, laboratory.all(runs, f"claim {claim.NUMBER}"), strict=True)))
    text = f"## {claim.NUMBER}. {claim.TITLE}\n\n{claim.verdict(chosen, rows)}\n\n"
    if plots is not None and rows:
        from matplotlib import rcParams
        from matplotlib.figure import Figure

        rcParams.update({"svg.hashsalt": "cmrc", "svg.fonttype": "none"})
        figure = Figure(figsize=(8, 3.2), layout="constrained")
        claim.draw(chosen, rows, figure)
        plots.mkdir(parents=True, exist_ok=True)
        name = f"claim-{claim.NUMBER}-{claim.NAME}.svg"
        with files.writing(plots / name) as out:
            figure.savefig(out, format="svg", metadata={"Date": None})
        if link:
            text += f"![{claim.TITLE}]({link}/{name})\n\n"
    again = f"\nAgain: `python -m cmrc.results --claim {claim.NUMBER}{_options(claim, chosen)}`.\n"
    return page.wrapped(text + str(claim.section(chosen, rows))) + again


def _options(claim: ModuleType, chosen: Any) -> str:
    """What on the command line gives these parameters."""
    text = ""
    for one in dataclasses.fields(claim.Parameters):
        value = getattr(chosen, one.name)
        if value != getattr(claim.Parameters(), one.name):
            text += f" --{one.name.replace('_', '-')} " + (
                ",".join(str(v) for v in value) if isinstance(value, tuple) else str(value)
            )
    return text


def main(arguments: Sequence[str] | None = None) -> int:
    """0, or 2 for bad input."""
    given = parser().parse_args(arguments)
    chosen = [claim for claim in CLAIMS if given.claim is None or claim.NUMBER in given.claim]
    try:
        unused = [
            name
            for name, owners in _fields().items()
            if getattr(given, name) is not None and not set(owners) & set(chosen)
        ]
        if unused:
            raise ValueError(
                f"--{unused[0].replace('_', '-')}: claim {', '.join(str(c.NUMBER) for c in chosen)} has no such "
                f"parameter"
            )
        if given.jobs < 1:
            raise ValueError("--jobs: at least 1 is expected")
        plans = [(claim, parameters(claim, given)) for claim in chosen]
        laboratory = Laboratory(given.jobs, given.cache)
        plots = given.page.with_suffix("") if given.page else given.plots
        if plots is not None:
            needed("matplotlib", "plot", "--page" if given.page else "--plots")
        for claim, values in plans:
            section = examine(claim, values, laboratory, plots, given.page.stem if given.page else "")
            if given.page:
                page.write(given.page, claim.NUMBER, section)
            else:
                print(section)
    except (ValueError, ConfigError, ImportError) as error:
        print(f"cmrc.results: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
