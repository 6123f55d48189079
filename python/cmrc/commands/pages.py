"""``cmrc page``, ``events`` and ``demo``: show one run."""

from __future__ import annotations

import argparse
from pathlib import Path

from cmrc import demo, events, files, page, streams
from cmrc.commands.common import (
    Commands,
    check_files,
    command,
    folder,
    output_file,
    output_name,
    picture,
    settings,
    write_each,
)
from cmrc.progress import ProgressLine
from cmrc.simulation import Setting, Simulation, configured


def add(commands: Commands) -> None:
    parser = command(commands, "page", "a run as a page to look at in a browser: dock, DSPs, deadlines", _page)
    parser.add_argument("run", metavar="RUN", help="a configuration (.toml) to run, or a page (.html) to plot")
    parser.add_argument(
        "--out",
        type=output_file,
        metavar="PAGE",
        help="where the page is written (default: RUN with the ending .html)",
    )
    parser.add_argument("--plots", type=output_file, metavar="PNG", help="write the plots of cmrc.plot")
    _settings(parser)
    parser = command(commands, "events", "the events of a run as a Parquet table (docs/timelines.md)", _events)
    parser.add_argument("run", metavar="RUN", help="an event trace, or a configuration (.toml) to run")
    parser.add_argument("-o", "--output", type=output_file, metavar="FILE.parquet", required=True, help="the table")
    _settings(parser)
    parser = command(commands, "demo", "what the emulator shows, in five scenes, and a page of them", _demo)
    parser.add_argument(
        "--out", type=output_name, metavar="FOLDER", default="demo", help="where the page is written (default: demo)"
    )


def _settings(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--set", metavar="KEY=VALUE", action="append", default=[], help="a setting, if RUN is a configuration"
    )


def _demo(given: argparse.Namespace) -> int:
    folder("--out", given.out)
    with ProgressLine("cmrc demo") as line, line.beating():

        def tell(text: str) -> None:
            line.clear()
            streams.show(f"{text}\n")

        demo.main(Path(given.out), tell)
    return 0


def _events(given: argparse.Namespace) -> int:
    run, table = Path(given.run), Path(given.output)
    events.needed()
    named = [configured(run, None, settings(given), (), {}).to_dict()] if run.suffix == ".toml" else []
    check_files({"RUN": run}, {"--output": table}, named)
    with ProgressLine("cmrc events") as line:
        if run.suffix == ".toml":
            batches = events.of_configuration(run, settings(given), line.of)
        elif given.set:
            raise ValueError("--set: RUN is a trace; only a configuration takes settings")
        else:
            batches = events.of_trace(run)
        with line.beating("writing the table" if run.suffix != ".toml" else "running"):
            count = events.write(batches, table)
    streams.show(f"{files.printable(str(table))}: {count} events\n")
    return 0


def _page(given: argparse.Namespace) -> int:
    run, plots = Path(given.run), Path(given.plots) if given.plots else None
    if run.suffix == ".toml":
        _write(run, Path(given.out or run.with_suffix(".html")), plots, settings(given))
    else:
        _plot(run, plots, given)
    return 0


def _write(run: Path, out: Path, plots: Path | None, given: dict[str, Setting]) -> None:
    """Runs a configuration. Writes each file whole or not at all."""
    simulation = Simulation(config=run, settings=given)
    check_files({"RUN": run}, {"--out": out, "--plots": plots}, [simulation.config.to_dict()])
    picture("--plots", plots)
    simulation.record()
    with ProgressLine("cmrc page") as line, line.beating():
        simulation.run(line.of)
        line.reported = "writing the page"
        made = simulation.page(f"{run.stem}: {simulation.title}")
        writes = [lambda: files.write(out, made)]
        if plots is not None:
            writes.append(lambda: _draw(page.Recording.of(made, str(out)), plots))
        write_each("page", *writes)


def _plot(run: Path, plots: Path | None, given: argparse.Namespace) -> None:
    """Plots an existing page."""
    if plots is None or given.out or given.set:
        raise ValueError(
            f"{run}: only --plots is possible for a page; a configuration (.toml) is expected for all else"
        )
    check_files({"RUN": run}, {"--plots": plots})
    picture("--plots", plots)
    with ProgressLine("cmrc page") as line, line.beating("drawing the plots"):
        _draw(page.Recording.read(run), plots)


def _draw(recording: page.Recording, plots: Path) -> None:
    from cmrc import plot

    figure = plot.overview(recording)
    with files.writing(plots) as out:
        figure.savefig(out, dpi=110, format=plots.suffix[1:].lower())
