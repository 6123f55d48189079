"""``cmrc sweep`` and ``cmrc search`` (docs/sweeps.md)."""

from __future__ import annotations

import argparse
import csv
import io
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cmrc import _core, arguments, files, streams
from cmrc.commands.common import (
    Commands,
    check_files,
    check_outside,
    command,
    output_file,
    output_name,
    picture,
    write_each,
)
from cmrc.errors import Error
from cmrc.progress import ProgressLine, shown
from cmrc.simulation import Setting, configured

if TYPE_CHECKING:
    from cmrc.sweeps import Sweep
    from cmrc.sweeps.grid import Grid


def add(commands: Commands) -> None:
    _sweep(commands)
    _search(commands)


def _where(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--out", type=output_name, metavar="FOLDER", help="folder of the runs (default: FILE without its ending)"
    )
    parser.add_argument(
        "--workers",
        type=arguments.whole_option,
        metavar="N",
        help="processes of this machine (default: one per processor)",
    )
    parser.add_argument(
        "--cluster",
        metavar="ADDRESS",
        help="a Dask cluster instead, tcp://HOST:8786; anyone who can reach it can run code on it",
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


def _sweep(commands: Commands) -> None:
    parser = command(commands, "sweep", "runs every point of a grid; keeps the reports in a folder", _do_sweep)
    parser.add_argument("file", metavar="FILE.toml", help="the grid (docs/sweeps.md)")
    _where(parser)
    parser.add_argument("--metric", metavar="NAME", action="append", help="a metric of the table; may be given again")
    parser.add_argument("--csv", type=output_file, metavar="FILE", help="write one row per run")
    parser.add_argument("--plot", type=output_file, metavar="PICTURE", help="draw the first metric over the grid")
    parser.add_argument("--again-failed", action="store_true", help="run again what failed")
    parser.add_argument("--show", action="store_true", help="run nothing; show what is in the folder")


def _do_sweep(given: argparse.Namespace) -> int:
    from cmrc.sweeps import Sweep, sweep
    from cmrc.sweeps.study import grid_of

    folder = _folder(given)
    try:
        grid = grid_of(given.file)
    except (OSError, ValueError):
        if not given.show:  # which needs the folder alone
            raise
        grid = None
    _check_outputs(given, folder, [] if grid is None else _named(grid))
    metrics = given.metric or []
    if grid is not None and not given.show:
        _check_results(given, grid, metrics)
    with ProgressLine("cmrc sweep") as line, line.beating("beginning"):
        if given.show or grid is None:
            found = Sweep(folder)
        else:
            on_progress = shown(line)
            found = sweep(grid, folder, again_failed=given.again_failed, on_progress=on_progress, **_place(given))
        line.reported = "reading the reports"
        text = found.text(*metrics)
        writes = []
        if given.csv is not None:
            writes.append(lambda: files.write(given.csv, _csv(found, metrics)))
        if given.plot is not None:
            writes.append(lambda: _draw(found, metrics, Path(given.plot)))
        write_each(given.command, *writes, line.clear, lambda: streams.show(files.printable_lines(text)))
    counts = found.counts()
    return 1 if counts["failed"] or not counts["done"] else 0


def _named(grid: Grid) -> Iterator[Mapping[str, Setting]]:
    """Everywhere that a grid may name files: its base configuration, its fixed settings, each value of an axis."""
    if grid.config is not None:
        yield {"fixed.config": grid.config}
        try:
            base = configured(grid.config, None, None, (), {})
            yield base.to_dict()
            _core.cmrc.inputs_digest(base)  # what the programs include is an input, too, since it has been read
        except (Error, OSError):
            pass  # its runs are refused
    yield grid.fixed
    for axis in grid.axes:
        yield from axis


def _check_outputs(given: argparse.Namespace, folder: Path, named: Iterable[Mapping[str, Setting]]) -> None:
    """No output may be an input of the sweep, or lie in its folder. Raises ValueError."""
    named = list(named)
    written = {"--csv": given.csv, "--plot": given.plot}
    tls = {f"--tls-{name}": vars(given)[f"tls_{name}"] for name in ("ca", "cert", "key")}
    check_files({"FILE.toml": given.file, **tls}, written, named)
    check_outside("the sweep's folder", folder, written)
    picture("--plot", given.plot)


def _check_results(given: argparse.Namespace, grid: Grid, metrics: Iterable[str]) -> None:
    """What can be said of the results before the runs. Raises ValueError."""
    from cmrc.sweeps.metrics import check_place

    for metric in metrics:
        try:
            check_place(metric)
        except ValueError as error:
            raise ValueError(f"--metric: {error}") from None
    if given.plot is not None:
        from cmrc.sweep_plots import check_grid

        try:
            check_grid(grid)
        except ValueError as error:
            raise ValueError(f"--plot: {error}") from None


def _csv(found: Sweep, metrics: Sequence[str]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(found._cells(metrics))
    return out.getvalue()


def _draw(found: Sweep, metrics: list[str], path: Path) -> None:
    from matplotlib.figure import Figure

    from cmrc import plot

    figure = Figure(figsize=(8, 5), layout="constrained")
    plot.grid(found, figure.subplots(), metric=metrics[0] if metrics else "misses")
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        with files.writing(path) as out:
            figure.savefig(out, dpi=120, format=path.suffix[1:].lower())
    if any("missing from" in str(one.message) for one in warned):
        streams.say(
            f"cmrc sweep: {files.printable(str(path))}: the font has not all characters of the names; boxes stand for them"
        )


def _search(commands: Commands) -> None:
    parser = command(commands, "search", "looks for the best settings, or for the last ones that pass", _do_search)
    parser.add_argument("file", metavar="FILE.toml", help="a grid with a table [search] (docs/sweeps.md)")
    _where(parser)


def _do_search(given: argparse.Namespace) -> int:
    from cmrc.sweeps import search

    with ProgressLine("cmrc search") as line, line.beating("beginning"):
        found = search(given.file, _folder(given), on_progress=shown(line), **_place(given))
    streams.show(found.text())
    return 0 if found.best is not None and found.check_passed is not False else 1
