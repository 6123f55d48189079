"""Shared by all commands: messages for bad input, settings and grids on the command line, checks of output files."""

from __future__ import annotations

import argparse
import math
import os
import stat
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NoReturn

from cmrc import _core, arguments, files, signals, streams
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
            meant = _core.io.did_you_mean(option, known) if option.startswith("-") else ""
            self.error(f"{left[0]} was not expected{meant}")
        return found, left

    def error(self, message: str) -> NoReturn:
        streams.say(f"{self.prog}: {files.printable(message)} ({self.prog} --help lists options)")
        raise SystemExit(2)

    def _print_message(self, message: str, file: Any = None) -> None:
        """Of ``--help`` and ``--version``. argparse itself ignores that standard output is full."""
        streams.show(message)


def command(
    commands: Commands, name: str, help: str, do: Callable[[argparse.Namespace], int]
) -> argparse.ArgumentParser:
    """A new command; the caller adds its options."""
    parser: argparse.ArgumentParser = commands.add_parser(name, help=help, description=help)
    parser.set_defaults(do=lambda given: status_of(f"cmrc {name}", do, given))
    return parser


def status_of(name: str, do: Callable[[argparse.Namespace], int], given: argparse.Namespace) -> int:
    """Bad input becomes a message and status 2, a failure of the work or of a write a message and status 1."""
    from cmrc.sweeps.ranges import GridError
    from cmrc.sweeps.store import SweepError

    try:
        return do(given)
    except (OSError, ImportError, ConfigError, GridError, SweepError, ValueError, TypeError, KeyError) as error:
        streams.say(f"{name}: {files.printable(_words(error))}")
        return 1 if files.writing_failed(error) else 2
    except RuntimeError as error:
        streams.say(f"{name}: {files.printable(str(error))}")
        return 1
    except KeyboardInterrupt as stop:
        streams.say(f"{name}: interrupted")
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
    return key, setting_value(value)


def setting_value(text: str) -> Setting:
    """A value on the command line; the configuration checks it."""
    if text in ("true", "false"):
        return text == "true"
    try:
        return arguments.read_number(text)
    except ValueError:
        return text


def settings(given: argparse.Namespace) -> dict[str, Setting]:
    """The settings of ``--set``. Raises ValueError."""
    return dict(setting(text) for text in given.set)


def numbers(text: str, option: str) -> list[float]:
    """FROM:TO:STEP (default STEP: 1) or VALUE,VALUE,... Raises ValueError."""
    try:
        parts = [float(arguments.read_number(part)) for part in text.split(":" if ":" in text else ",")]
    except (ValueError, OverflowError):
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


def output_name(text: str) -> str:
    """The type of an option that names an output. An empty name would be the working folder, or none."""
    if not text:
        raise argparse.ArgumentTypeError("the name is empty; the name of an output is expected")
    return text


def output_file(text: str) -> str:
    """The same of an option that names a file. What ends with a slash can only be a folder."""
    if output_name(text).endswith("/"):
        raise argparse.ArgumentTypeError(f"{text!r} is the name of a folder; the name of a file is expected")
    return text


def write_each(name: str, *writes: Callable[[], None]) -> None:
    """Writes all outputs of a command. One that fails does not lose the others; its error is raised at the end."""
    failed: list[Exception] = []
    for write in writes:
        try:
            write()
        except Exception as error:  # noqa: BLE001 (raised at the end)
            failed.append(error)
    for other in failed[1:]:
        streams.say(f"cmrc {name}: {files.printable(_words(other))}")
    if failed:
        raise failed[0]


OptionalPath = str | Path | None
FILES_OF_SETTINGS = ("machine.board", "dock.layout", "fixed.config")
"""The last one is the base configuration of a sweep."""
FOLDER_OF_SETTINGS = "machine.programs"


def check_files(
    read: Mapping[str, OptionalPath],
    written: Mapping[str, OptionalPath],
    configurations: Iterable[Mapping[str, Setting]] = (),
) -> None:
    """Checks the output files of a command before its work: each can become a file, and none is an input, a file that
    one of the ``configurations`` names, or another output. Files are given by option. Raises ValueError."""
    roles = files.FileRoles()
    for option, path in read.items():
        if path is not None:
            roles.reads(option, path)
    for option, path in written.items():
        output(option, path)
        if path is not None:
            roles.writes(option, path)
    for values in configurations:
        for key in FILES_OF_SETTINGS:
            if values.get(key, "default") not in ("", "default"):
                roles.reads(key, str(values[key]))
        if values.get(FOLDER_OF_SETTINGS):
            check_outside(FOLDER_OF_SETTINGS, str(values[FOLDER_OF_SETTINGS]), written)


def check_outside(role: str, folder: str | Path, written: Mapping[str, OptionalPath]) -> None:
    """Checks that no output lies in a folder that is read, or is a file of it, links followed. Raises ValueError."""
    there = {_identity(path): (option, path) for option, path in written.items() if path is not None}
    there.pop(None, None)
    for place, _, names in os.walk(folder) if there else []:
        for name in names:
            found = there.get(_identity(os.path.join(place, name)))
            if found is not None:
                option, path = found
                raise ValueError(
                    f"{option}: {path} is the same file as {role} ({os.path.join(place, name)}); another name is "
                    "expected"
                )
    for option, new in written.items():
        if new is not None and Path(folder).resolve() in Path(new).resolve().parents:
            raise ValueError(f"{option}: {new}: is in {role} {folder}; a place outside is expected")


def _identity(path: str | Path) -> tuple[int, int] | None:
    """None for what is no file, or not there."""
    try:
        found = os.stat(path)
    except OSError:
        return None
    return (found.st_dev, found.st_ino) if stat.S_ISREG(found.st_mode) else None


def output(option: str, path: OptionalPath) -> None:
    """Checks an output file before work that takes hours. Raises ValueError for a path that cannot become a file."""
    if path is None:
        return
    folder = Path(path).absolute().parent
    if not folder.is_dir():
        raise ValueError(f"{option}: {path}: there is no folder {folder}")
    try:
        os.stat(path)
    except FileNotFoundError:
        pass
    except OSError as error:
        raise ValueError(f"{option}: {path}: cannot be written: {error.strerror}") from None
    if Path(path).is_dir():
        raise ValueError(f"{option}: {path}: is a folder; the name of a file is expected")


def folder(option: str, path: OptionalPath) -> None:
    """The same for a folder of outputs. Raises ValueError for a path that cannot become a folder."""
    if path is None or Path(path).is_dir():
        return
    if os.path.lexists(path):
        kind = "is a link to nothing" if os.path.islink(path) and not os.path.exists(path) else "is a file"
        raise ValueError(f"{option}: {path}: {kind}; the name of a folder is expected")


def picture(option: str, path: OptionalPath) -> None:
    """The same for a picture. Raises ValueError, ImportError."""
    if path is None:
        return
    output(option, path)
    kinds = needed("matplotlib.backend_bases", "plot", option).FigureCanvasBase.get_supported_filetypes()
    if Path(path).suffix[1:].lower() not in kinds:
        raise ValueError(f"{option}: {path}: not a picture file; its ending may be {', '.join(sorted(kinds))}")
