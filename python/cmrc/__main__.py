"""``python -m cmrc`` and ``cmrc``: page, events, demo, and the experiments (experiment_commands.py)."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from cmrc import demo, events, experiment_commands, files, page
from cmrc.progress import ProgressLine
from cmrc.simulation import ConfigError, Simulation


def main(arguments: list[str] | None = None) -> int:
    """The command line; 0, or 2 for bad input, 130 for Ctrl-C, as of the emulator."""
    try:
        return _main(arguments)
    except KeyboardInterrupt:
        print("cmrc: interrupted", file=sys.stderr)
        return 130


def _main(arguments: list[str] | None) -> int:
    parser = argparse.ArgumentParser(prog="cmrc", description="What the emulator has done, to look at.")
    commands = parser.add_subparsers(dest="command", required=True)
    for name, says in (
        ("page", "a run as a page to look at in a browser: dock, DSPs, deadlines"),
        ("replay", "the old name of page"),
    ):
        command = commands.add_parser(name, help=says)
        command.add_argument("run", metavar="RUN", help="a configuration (.toml) to run, or a page (.html) to plot")
        command.add_argument(
            "--out",
            "--html",
            dest="out",
            metavar="PAGE",
            nargs="?",
            help="where the page is written (default: RUN with the ending .html)",
        )
        command.add_argument("--plots", metavar="PNG", help="write the plots of cmrc.plot")
        command.add_argument(
            "--set", metavar="KEY=VALUE", action="append", default=[], help="a setting, where RUN is a configuration"
        )
    scenes = commands.add_parser("demo", help="what the emulator tells, in five scenes, and a page of them")
    scenes.add_argument("--out", metavar="FOLDER", default="demo", help="where the page is written (default: demo)")
    events.declare(commands)
    experiment_commands.add(commands)
    given = parser.parse_args(arguments)
    if "do" in given:
        return int(given.do(given))
    if given.command == "demo":
        return _demo(Path(given.out))
    return _events(given) if given.command == "events" else _page(given)


def _demo(folder: Path) -> int:
    try:
        with ProgressLine("cmrc demo") as line, line.beating():

            def tell(text: str) -> None:
                line.clear()
                print(text, flush=True)

            demo.main(folder, tell)
    except OSError as error:
        print(f"cmrc demo: {files.printable(str(error))}", file=sys.stderr)
        return 2
    return 0


def _events(given: argparse.Namespace) -> int:
    try:
        events.main(given, dict(experiment_commands.setting(text) for text in given.set))
    except (OSError, ImportError, ConfigError, ValueError) as error:
        print(f"cmrc events: {files.printable(str(error))}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("cmrc events: interrupted; nothing is written", file=sys.stderr)
        return 130
    return 0


def _page(given: argparse.Namespace) -> int:
    if given.command == "replay":
        print("cmrc replay: it is called cmrc page now, and writes the same page", file=sys.stderr)
    run, plots = Path(given.run), Path(given.plots) if given.plots else None
    try:
        if run.suffix == ".toml":
            _write(run, Path(given.out or run.with_suffix(".html")), plots, dict(experiment_commands.setting(text) for text in given.set))
        else:
            _plot(run, plots, given)
    except (OSError, ImportError, ConfigError, ValueError) as error:
        print(f"cmrc {given.command}: {files.printable(str(error))}", file=sys.stderr)
        return 2
    return 0


def _write(run: Path, out: Path, plots: Path | None, settings: dict[str, bool | int | float | str]) -> None:
    """Runs a configuration. Each file whole or not at all."""
    _check_outputs(run, out, plots)
    simulation = Simulation(config=run, settings=settings)
    simulation.record()
    with ProgressLine("cmrc page") as line:
        simulation.run(line.of)
    simulation.write_page(out, f"{run.stem}: {simulation.title}")
    if plots is not None:
        _draw(page.Recording.read(out), plots)


def _plot(run: Path, plots: Path | None, given: argparse.Namespace) -> None:
    """Of a page that is there."""
    if run.suffix == ".json":
        raise ValueError(
            f"{run}: recordings in JSON are no longer read; run the configuration again (cmrc page CONFIG.toml)"
        )
    if plots is None or given.out or given.set:
        raise ValueError(f"{run}: of a page only --plots can be made; a configuration (.toml) is expected for all else")
    _check_outputs(run, None, plots)
    _draw(page.Recording.read(run), plots)


def _check_outputs(run: Path, out: Path | None, plots: Path | None) -> None:
    """Before a run that takes minutes. Raises ValueError, ImportError."""
    for path in (out, plots):
        if path is None:
            continue
        if not path.absolute().parent.is_dir():
            raise ValueError(f"{path}: there is no folder {path.absolute().parent}")
        if path.is_dir():
            raise ValueError(f"{path}: is a folder; the name of a file is expected")
    roles = files.FileRoles()
    roles.reads("RUN", run)
    for role, output in (("--out", out), ("--plots", plots)):
        if output is not None:
            roles.writes(role, output)
    if plots is not None:
        from matplotlib.backend_bases import FigureCanvasBase

        known = FigureCanvasBase.get_supported_filetypes()
        if plots.suffix[1:].lower() not in known:
            raise ValueError(f"{plots}: no kind of picture; its ending may be {', '.join(sorted(known))}")


def _draw(recording: page.Recording, plots: Path) -> None:
    from cmrc import plot

    figure = plot.overview(recording)
    with files.writing(plots) as out:
        figure.savefig(out, dpi=110, format=plots.suffix[1:].lower())


if __name__ == "__main__":
    sys.exit(main())
