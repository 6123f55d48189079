"""Shared by all commands: messages for bad input, settings and grids on the command line, checks of output files."""

from __future__ import annotations

import argparse
import difflib
import math
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

from cmrc import files
from cmrc.commands import signals
from cmrc.extras import needed
from cmrc.simulation import ConfigError, Setting

Commands = Any  # argparse gives it no public name
MOST_POINTS = 1000


class Parser(argparse.ArgumentParser):
    """Wrong arguments become one line with the command's name, what would be right, and status 2."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        found, left = super().parse_known_args(args, namespace)
        if left:
            option = left[0].partition("=")[0]
            known = [name for action in self._actions for name in action.option_strings]
            near = difflib.get_close_matches(option, known, 1) if option.startswith("-") else []
            self.error(f"{left[0]} was not expected{f'; did you mean {near[0]}?' if near else ''}")
        return found, left

    def error(self, message: str) -> NoReturn:
        print(f"{self.prog}: {files.printable(message)} ({self.prog} --help lists options)", file=sys.stderr)
        raise SystemExit(2)


def command(
    commands: Commands, name: str, help: str, do: Callable[[argparse.Namespace], int]
) -> argparse.ArgumentParser:
    """A new command; the caller adds its options."""
    parser: argparse.ArgumentParser = commands.add_parser(name, help=help, description=help)
    parser.set_defaults(do=lambda given: status_of(name, do, given))
    return parser


def status_of(name: str, do: Callable[[argparse.Namespace], int], given: argparse.Namespace) -> int:
    """Bad input becomes a message and status 2, a failure of the work a message and status 1."""
    from cmrc.sweeps.grid import GridError
    from cmrc.sweeps.store import SweepError

    try:
        return do(given)
    except (OSError, ImportError, ConfigError, GridError, SweepError, ValueError, TypeError, KeyError) as error:
        print(f"cmrc {name}: {files.printable(_words(error))}", file=sys.stderr)
        return 2
    except RuntimeError as error:
        print(f"cmrc {name}: {files.printable(str(error))}", file=sys.stderr)
        return 1
    except KeyboardInterrupt as stop:
        print(f"cmrc {name}: interrupted", file=sys.stderr)
        return signals.status(stop)


def _words(error: Exception) -> str:
    if isinstance(error, KeyError) and error.args:
        return str(error.args[0])
    if isinstance(error, OSError) and error.filename is not None and error.strerror:
        return f"{os.fspath(error.filename)}: {error.strerror}"
    return str(error)


def setting(text: str) -> tuple[str, Setting]:
    """KEY=VALUE. Raises ValueError."""
    key, equals, value = text.partition("=")
    if not equals or not key:
        raise ValueError(f"--set needs KEY=VALUE, not {text!r}")
    if value in ("true", "false"):
        return key, value == "true"
    for kind in (lambda text: int(text, 16 if text.startswith("0x") else 10), float):
        try:
            return key, kind(value)
        except ValueError:
            continue
    return key, value


def settings(given: argparse.Namespace) -> dict[str, Setting]:
    """The settings of ``--set``. Raises ValueError."""
    return dict(setting(text) for text in given.set)


def numbers(text: str, option: str) -> list[float]:
    """FROM:TO:STEP (default STEP: 1) or VALUE,VALUE,... Raises ValueError."""
    try:
        parts = [float(part) for part in text.split(":" if ":" in text else ",")]
    except ValueError:
        parts = []
    if ":" in text and len(parts) == 2:
        parts.append(1.0)
    if not parts or (":" in text and len(parts) != 3) or not all(abs(part) < 1e9 for part in parts):
        raise ValueError(f"{option}: {text!r} is not a grid; FROM:TO:STEP or VALUE,VALUE,... is expected")
    if ":" not in text:
        return parts
    begin, end, step = parts
    if not (step > 0 and begin <= end and (end - begin) / step < MOST_POINTS):
        raise ValueError(f"{option}: {text!r} holds no value, or more than {MOST_POINTS}; FROM:TO:STEP is expected")
    return [round(begin + n * step, 6) for n in range(math.floor((end - begin) / step + 1e-9) + 1)]


def output(option: str, path: str | Path | None) -> None:
    """Checks an output file before work that takes hours. Raises ValueError for a path that cannot become a file."""
    if path is None:
        return
    folder = Path(path).absolute().parent
    if not folder.is_dir():
        raise ValueError(f"{option}: {path}: there is no folder {folder}")
    if Path(path).is_dir():
        raise ValueError(f"{option}: {path}: is a folder; the name of a file is expected")


def folder(option: str, path: str | Path) -> None:
    """The same for a folder of outputs. Raises ValueError for a path that cannot become a folder."""
    if Path(path).exists() and not Path(path).is_dir():
        raise ValueError(f"{option}: {path}: is a file; the name of a folder is expected")


def picture(option: str, path: str | Path | None) -> None:
    """The same for a picture. Raises ValueError, ImportError."""
    if path is None:
        return
    output(option, path)
    kinds = needed("matplotlib.backend_bases", "plot", option).FigureCanvasBase.get_supported_filetypes()
    if Path(path).suffix[1:].lower() not in kinds:
        raise ValueError(f"{option}: {path}: not a picture file; its ending may be {', '.join(sorted(kinds))}")
