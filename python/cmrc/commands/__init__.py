"""``cmrc`` and ``python -m cmrc``: commands that show runs, and studies of many runs. Each command is a thin layer over
functions of the package."""

from __future__ import annotations

import cmrc
from cmrc import signals, streams
from cmrc.commands import pages, studies, sweeps
from cmrc.commands.common import Parser


def main(arguments: list[str] | None = None) -> int:
    """The command line. Returns 0; 1 as each command says; 2 for bad input; 130, 143 or 129 after a signal."""
    streams.prepare()
    try:
        with signals.raised():
            parser = Parser(prog="cmrc", description="Shows runs of the emulator, and makes studies of many runs.")
            parser.add_argument("--version", action="version", version=f"cmrc {cmrc.__version__}")
            commands = parser.add_subparsers(dest="command")
            for part in (pages, sweeps, studies):
                part.add(commands)
            given = parser.parse_args(arguments)
            if given.command is None:
                parser.error(f"a command is expected: {', '.join(commands.choices)}")
            return int(given.do(given))
    except RuntimeError as error:  # --help or --version could not be shown
        streams.say(f"cmrc: {error}")
        return 1
    except KeyboardInterrupt as stop:
        streams.say("cmrc: interrupted")
        return signals.status(stop)
