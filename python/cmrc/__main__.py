"""``python -m cmrc`` and ``cmrc``: replay, events, demo, and the experiments (experiment_commands.py)."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from cmrc import demo, events, experiment_commands, files, replay
from cmrc.progress import ProgressLine
from cmrc.simulation import ConfigError


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
    command = commands.add_parser("replay", help="3-D replay of a run as one page that works offline")
    command.add_argument("run", metavar="RUN", help="a recording (.json), or a configuration (.toml) to run and record")
    command.add_argument("--html", metavar="PAGE", nargs="?", const="", help="write the page (default: RUN with the ending .html)")
    command.add_argument("--plots", metavar="PNG", help="write the plots of cmrc.plot")
    command.add_argument("--save", metavar="JSON", help="write the recording, for a later replay without the run")
    command.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help="a setting, where RUN is a configuration")
    scenes = commands.add_parser("demo", help="what the emulator tells, in five scenes, and a page of them")
    scenes.add_argument("--out", metavar="FOLDER", default="demo", help="where the page is written (default: demo)")
    events.declare(commands)
    experiment_commands.add(commands)
    given = parser.parse_args(arguments)
    if "do" in given:
        return int(given.do(given))
    if given.command == "demo":
        return _demo(Path(given.out))
    if given.command == "events":
        return _events(given)
    run = Path(given.run)
    page = None if given.html is None else Path(given.html or run.with_suffix(".html"))
    plots, saved = (Path(path) if path else None for path in (given.plots, given.save))
    try:
        _check_outputs(run, page, plots, saved)
        if run.suffix == ".toml":
            settings = dict(experiment_commands.setting(text) for text in given.set)
            with ProgressLine("cmrc replay") as line:
                recording = replay.record_file(run, settings, line.of)
        else:
            recording = replay.load(run)
        _write(recording, page, plots, saved)
    except (OSError, ImportError, ConfigError, ValueError) as error:
        print(f"cmrc replay: {files.printable(str(error))}", file=sys.stderr)
        return 2
    return 0


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
        events.main(given, dict(_setting(text) for text in given.set))
    except (OSError, ImportError, ConfigError, ValueError) as error:
        print(f"cmrc events: {files.printable(str(error))}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("cmrc events: interrupted; nothing is written", file=sys.stderr)
        return 130
    return 0


def _check_outputs(run: Path, page: Path | None, plots: Path | None, saved: Path | None) -> None:
    """Before a run that takes minutes. Raises ValueError, ImportError."""
    outputs = [path for path in (page, plots, saved) if path is not None]
    if not outputs:
        raise ValueError("nothing to write: --html, --plots or --save is needed")
    for path in outputs:
        if not path.absolute().parent.is_dir():
            raise ValueError(f"{path}: there is no folder {path.absolute().parent}")
        if path.is_dir():
            raise ValueError(f"{path}: is a folder; the name of a file is expected")
    roles = files.FileRoles()
    roles.reads("RUN", run)
    for role, output in (("--html", page), ("--plots", plots), ("--save", saved)):
        if output is not None:
            roles.writes(role, output)
    if plots is not None:
        from matplotlib.backend_bases import FigureCanvasBase

        known = FigureCanvasBase.get_supported_filetypes()
        if plots.suffix[1:].lower() not in known:
            raise ValueError(f"{plots}: no kind of picture; its ending may be {', '.join(sorted(known))}")


def _write(recording: replay.Recording, page: Path | None, plots: Path | None, saved: Path | None) -> None:
    """Each file whole or not at all."""
    try:
        text = replay.page(recording) if page else ""
        figure = None
        if plots:
            from cmrc import plot

            figure = plot.overview(recording)
    except (KeyError, IndexError, TypeError, AttributeError) as error:
        raise ValueError(f"the recording is not whole: {type(error).__name__} {error}") from error
    if page:
        files.write(page, text)
    if saved:
        replay.save(recording, saved)
    if plots and figure:
        with files.writing(plots) as out:
            figure.savefig(out, dpi=110, format=plots.suffix[1:].lower())


if __name__ == "__main__":
    sys.exit(main())
