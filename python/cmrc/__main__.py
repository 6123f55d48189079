"""``python -m cmrc replay RUN --html PAGE``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from cmrc import replay
from cmrc.simulation import ConfigError


def main(arguments: list[str] | None = None) -> int:
    """The command line; 0, or 2 for bad input, as of the emulator."""
    parser = argparse.ArgumentParser(prog="cmrc", description="What the emulator has done, to look at.")
    commands = parser.add_subparsers(dest="command", required=True)
    command = commands.add_parser("replay", help="3-D replay of a run as one page that works offline")
    command.add_argument("run", metavar="RUN", help="a recording (.json), or a configuration (.toml) to run and record")
    command.add_argument("--html", metavar="PAGE", nargs="?", const="", help="write the page (default: RUN with the ending .html)")
    command.add_argument("--plots", metavar="PNG", help="write the plots of cmrc.plot")
    command.add_argument("--save", metavar="JSON", help="write the recording, for a later replay without the run")
    command.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help="a setting, where RUN is a configuration")
    given = parser.parse_args(arguments)
    run = Path(given.run)
    try:
        if run.suffix == ".toml":
            recording = replay.record_file(run, dict(_setting(text) for text in given.set))
        else:
            recording = replay.load(run)
    except (OSError, ConfigError, ValueError) as error:
        print(f"cmrc replay: {error}", file=sys.stderr)
        return 2
    if given.save:
        replay.save(recording, given.save)
    if given.plots:
        from cmrc import plot

        plot.overview(recording).savefig(given.plots, dpi=110)
    if given.html is not None:
        Path(given.html or run.with_suffix(".html")).write_text(replay.page(recording), encoding="utf-8")
    return 0


def _setting(text: str) -> tuple[str, bool | int | float | str]:
    key, equals, value = text.partition("=")
    if not equals:
        raise ValueError(f"--set needs KEY=VALUE, not {text!r}")
    if value in ("true", "false"):
        return key, value == "true"
    for kind in (int, float):
        try:
            return key, kind(value)
        except ValueError:
            continue
    return key, value


if __name__ == "__main__":
    sys.exit(main())
