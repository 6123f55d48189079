"""``cmrc sweep``, ``search``, ``limits``, ``compare`` and ``diff``: thin over the functions of the same names."""

from __future__ import annotations

import argparse
import csv
import io
import json
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cmrc
from cmrc import files
from cmrc.progress import ProgressLine
from cmrc.simulation import ConfigError, Setting

if TYPE_CHECKING:
    from cmrc.sweeps import Status, Sweep

Commands = Any  # argparse gives it no public name


def add(commands: Commands) -> None:
    """Adds them to the command line."""
    _sweep(commands)
    _search(commands)
    _limits(commands)
    _compare(commands)
    _diff(commands)


def setting(text: str) -> tuple[str, Setting]:
    """KEY=VALUE. Raises ValueError."""
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


def numbers(text: str, option: str) -> list[float]:
    """FROM:TO:STEP (STEP is 1 where it is not given) or VALUE,VALUE,... Raises ValueError."""
    try:
        if ":" not in text:
            return [float(part) for part in text.split(",")]
        begin, end, step = (
            [*map(float, text.split(":")), 1.0][:3] if text.count(":") == 1 else map(float, text.split(":"))
        )
    except ValueError:
        raise ValueError(f"{option}: {text!r} is no grid; FROM:TO:STEP or VALUE,VALUE,... is expected") from None
    if not (step > 0 and begin <= end and (end - begin) / step <= 1000):
        raise ValueError(f"{option}: {text!r} holds no value, or more than 1000; FROM:TO:STEP is expected")
    return [round(begin + n * step, 6) for n in range(int((end - begin) / step + 1e-9) + 1)]


def _command(
    commands: Commands, name: str, help: str, do: Callable[[argparse.Namespace], int]
) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = commands.add_parser(name, help=help, description=help)
    parser.set_defaults(do=lambda given: _told(name, do, given))
    return parser


def _told(name: str, do: Callable[[argparse.Namespace], int], given: argparse.Namespace) -> int:
    """What a user can get wrong is a sentence and status 2."""
    from cmrc.sweeps.grid import GridError
    from cmrc.sweeps.store import SweepError

    try:
        return do(given)
    except (OSError, ImportError, ConfigError, GridError, SweepError, ValueError, TypeError, KeyError) as error:
        said = error.args[0] if isinstance(error, KeyError) and error.args else error
        print(f"cmrc {name}: {files.printable(str(said))}", file=sys.stderr)
        return 2


# ---- sweeps --------------------------------------------------------------------------------------------------------


def _where(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--out", metavar="FOLDER", help="where the runs are kept (default: FILE without its ending)")
    parser.add_argument(
        "--workers", type=int, metavar="N", help="processes of this machine (default: one per processor)"
    )
    parser.add_argument(
        "--cluster",
        metavar="ADDRESS",
        help="a Dask cluster instead, tcp://HOST:8786; who can reach it can run code on it",
    )
    for option, meaning in (("ca", "certificate authority"), ("cert", "certificate"), ("key", "private key")):
        parser.add_argument(f"--tls-{option}", metavar="FILE", help=f"{meaning} for a cluster at tls://")


def _place(given: argparse.Namespace) -> dict[str, Any]:
    tls = {"tls_ca_file": given.tls_ca, "tls_client_cert": given.tls_cert, "tls_client_key": given.tls_key}
    tls = {name: path for name, path in tls.items() if path is not None}
    if tls and not given.cluster:
        raise ValueError("--tls-ca, --tls-cert and --tls-key go with --cluster")
    security = {**tls, "require_encryption": True} if tls else None
    return {"address": given.cluster, "workers": given.workers, "security": security}


def _folder(given: argparse.Namespace) -> Path:
    file = Path(given.file)
    if given.out is None and not file.suffix:
        raise ValueError(f"{file}: has no ending, so that --out FOLDER is needed")
    return Path(given.out) if given.out is not None else file.with_suffix("")


def _show(line: ProgressLine) -> Callable[[Status], object]:
    def show(status: Status) -> None:
        if status.planned < status.runs:
            line.show(f"{status.planned} of {status.runs} points looked at")
            return
        fresh = status.done - status.known
        left = status.runs - status.done
        rest = f", about {status.elapsed_s / fresh * left:.0f} s left" if fresh > status.refused and left else ""
        again = f", {status.begun_again} begun again" if status.begun_again else ""
        on = f"on {status.workers} workers" if status.workers else "done, waiting for a worker"
        line.show(f"{status.done} of {status.runs} runs {on}{again}{rest}")

    return show


def _sweep(commands: Commands) -> None:
    parser = _command(commands, "sweep", "runs every point of a grid, and keeps the reports in a folder", _do_sweep)
    parser.add_argument("file", metavar="FILE.toml", help="the grid (docs/sweeps.md)")
    _where(parser)
    parser.add_argument("--metric", metavar="NAME", action="append", help="what the table shows; may be given again")
    parser.add_argument("--csv", metavar="FILE", help="write one row per run")
    parser.add_argument("--plot", metavar="PICTURE", help="draw the first metric over the grid")
    parser.add_argument("--again-failed", action="store_true", help="run again what failed")
    parser.add_argument("--show", action="store_true", help="run nothing; show what is in the folder")


def _do_sweep(given: argparse.Namespace) -> int:
    from cmrc.sweeps import Sweep, sweep

    roles = files.FileRoles()
    roles.reads("FILE.toml", given.file)
    for option, path in (("--csv", given.csv), ("--plot", given.plot)):
        if path is not None:
            roles.writes(option, path)
            if not Path(path).absolute().parent.is_dir():
                raise ValueError(f"{path}: there is no folder {Path(path).absolute().parent}")
    _drawable(given.plot)
    if given.show:
        found = Sweep(_folder(given))
    else:
        with ProgressLine("cmrc sweep") as line:
            found = sweep(
                given.file, _folder(given), again_failed=given.again_failed, on_progress=_show(line), **_place(given)
            )
    metrics = given.metric or []
    print(files.printable_lines(found.text(*metrics)), end="")
    if given.csv is not None:
        files.write(given.csv, _csv(found, metrics))
    if given.plot is not None:
        _draw(found, metrics, Path(given.plot))
    return 1 if found.counts()["failed"] else 0


def _csv(found: Sweep, metrics: Iterable[str]) -> str:
    table = found.table(*metrics)
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(table)
    writer.writerows(zip(*(column.tolist() for column in table.values()), strict=True))
    return out.getvalue()


def _drawable(path: str | None) -> None:
    """Before runs that take hours. Raises ValueError, ImportError."""
    if path is None:
        return
    from cmrc.extras import needed

    kinds = needed("matplotlib.backend_bases", "plot", "--plot").FigureCanvasBase.get_supported_filetypes()
    if Path(path).suffix[1:].lower() not in kinds:
        raise ValueError(f"{path}: no kind of picture; its ending may be {', '.join(sorted(kinds))}")


def _draw(found: Sweep, metrics: list[str], path: Path) -> None:
    from matplotlib.figure import Figure

    from cmrc import plot

    figure = Figure(figsize=(8, 5), layout="constrained")
    plot.grid(found, figure.subplots(), metric=metrics[0] if metrics else "misses")
    with files.writing(path) as out:
        figure.savefig(out, dpi=120, format=path.suffix[1:].lower())


def _search(commands: Commands) -> None:
    parser = _command(commands, "search", "looks for the best settings, or for the last that pass", _do_search)
    parser.add_argument("file", metavar="FILE.toml", help="what is looked for, [search] (docs/sweeps.md)")
    _where(parser)


def _do_search(given: argparse.Namespace) -> int:
    from cmrc.sweeps import search

    with ProgressLine("cmrc search") as line:
        found = search(given.file, _folder(given), on_progress=_show(line), **_place(given))
    print(found.text(), end="")
    return 0 if found.best is not None and found.check_passed is not False else 1


# ---- one configuration ---------------------------------------------------------------------------------------------


def _configuration(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", metavar="FILE", help="TOML file with parameters (docs/configuration.md)")
    parser.add_argument("--preset", metavar="NAME", help="base, heavy, saturated, tight")
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help="a setting; may be given again")
    parser.add_argument("--json", metavar="FILE", help="write all of it as JSON")


def _configured(given: argparse.Namespace) -> dict[str, Any]:
    roles = files.FileRoles()
    if given.config is not None:
        roles.reads("--config", given.config)
    if given.json is not None:
        roles.writes("--json", given.json)
    return {"config": given.config, "preset": given.preset, "settings": dict(setting(text) for text in given.set)}


def _limits(commands: Commands) -> None:
    parser = _command(commands, "limits", "scans for the first missed deadline", _do_limits)
    _configuration(parser)
    parser.add_argument("--cycles", metavar="GRID", help="factors on the time of an instruction cycle, 1:3:0.25")
    parser.add_argument("--dsps-grid", metavar="GRID", help="numbers of DSPs, 1:8")
    parser.add_argument("--servo", metavar="GRID", help="servo frequencies in Hz, 500,1000,2000")
    parser.add_argument("--errors", action="store_true", help="run every point to its end, and say what it cost")


def _do_limits(given: argparse.Namespace) -> int:
    grids = {
        name: None if text is None else numbers(text, option)
        for name, text, option in (
            ("cycles", given.cycles, "--cycles"),
            ("dsps", given.dsps_grid, "--dsps-grid"),
            ("servo", given.servo, "--servo"),
        )
    }
    with ProgressLine("cmrc limits") as line:
        found = cmrc.limits(
            **_configured(given),
            cycles=grids["cycles"],
            dsps=grids["dsps"],
            servo=grids["servo"],
            errors=given.errors,
            on_progress=lambda done, points: line.of(done, points, "runs"),
        )
    return _shown(given, found.text, found.report)


def _compare(commands: Commands) -> None:
    _configuration(_command(commands, "compare", "a run beside the same run with instant execution", _do_compare))


def _do_compare(given: argparse.Namespace) -> int:
    asked = _configured(given)
    with ProgressLine("cmrc compare") as line, line.beating():
        found = cmrc.compare(**asked)
    return _shown(given, found.text, found.report)


def _shown(given: argparse.Namespace, text: str, report: dict[str, Any]) -> int:
    print(text, end="")
    if given.json is not None:
        files.write(given.json, json.dumps(report, indent=2) + "\n")
    return 0


def _diff(commands: Commands) -> None:
    parser = _command(commands, "diff", "what is different between two results; status 1 if anything is", _do_diff)
    parser.add_argument("left", metavar="A", help="a saved result, or a JSON report")
    parser.add_argument("right", metavar="B", help="another one")
    parser.add_argument("--json", metavar="FILE", help="write all of it as JSON")
    parser.add_argument("--all", action="store_true", help="show every metric that differs, not the first 40")


def _do_diff(given: argparse.Namespace) -> int:
    roles = files.FileRoles()
    roles.reads("A", given.left)
    roles.reads("B", given.right)
    if given.json is not None:
        roles.writes("--json", given.json)
    found = cmrc.diff(given.left, given.right)
    print(files.printable_lines(found.text(len(found.metrics) if given.all else 40)), end="")
    if given.json is not None:
        files.write(given.json, json.dumps(found.to_dict(), indent=2) + "\n")
    return 1 if found else 0
