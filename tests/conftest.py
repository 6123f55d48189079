"""What every test shares: where the build is, the path to the package in it, and the comparison with golden files."""

import gc
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any

import pytest
from dealt import dealt
from locations import BUILD, ROOT
from spent import Spent

# Some hundred tests start a Python: it keeps what it has compiled, and numpy in it starts no thread beside the first.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

GOLDEN = ROOT / "tests" / "golden"
sys.path.insert(0, str(BUILD / "python"))

changes = pytest.StashKey[list[str]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update-golden", action="store_true", help="rewrite the files in tests/golden and print what changed"
    )
    parser.addoption("--spent", type=Path, help="append the processor time of each test to this file (tests/spent.py)")
    parser.addoption(
        "--way", help="run every program in two ways of timing, and compare them at many points (tests/lockstep.py)"
    )


@pytest.fixture(scope="session", autouse=True)
def _in_two_ways(request: pytest.FixtureRequest) -> Iterator[None]:
    way = request.config.getoption("--way")
    if way is None:
        yield
        return
    import lockstep

    with lockstep.processors(way, keep=False):
        yield


def pytest_collection_finish() -> None:
    # Ten thousand tests stay to the end: the garbage collector need not look through them again and again.
    gc.collect()
    gc.freeze()


def pytest_configure(config: pytest.Config) -> None:
    # Under nohup, or in the background of a script, signals are ignored, and what the tests start would inherit that.
    for number, usual in (
        (signal.SIGINT, signal.default_int_handler),
        (signal.SIGTERM, signal.SIG_DFL),
        (signal.SIGHUP, signal.SIG_DFL),
    ):
        if signal.getsignal(number) == signal.SIG_IGN:
            signal.signal(number, usual)
    config.stash[changes] = []
    # With workers each measures itself; the process that started them would count them once more.
    if (output := config.getoption("--spent")) and (
        hasattr(config, "workerinput") or not config.getoption("numprocesses", None)
    ):
        config.pluginmanager.register(Spent(output))


SLOW = frozenset((ROOT / "tests" / "slow_tests.txt").read_text().split())


@pytest.hookimpl(tryfirst=True)
def pytest_pycollect_makeitem(collector: pytest.Collector, name: str, obj: object) -> list[pytest.Item] | None:
    """Campaigns have 16,000 cases: where `-m` leaves them out, they are not made only to be left out; slow tests
    too."""
    only = collector.config.option.markexpr
    marks = getattr(obj, "pytestmark", [])
    campaign = isinstance(marks, list) and any(mark.name == "campaign" for mark in marks)
    left_out = campaign and only in ("not campaign", "fast") or only == "fast" and f"{collector.nodeid}::{name}" in SLOW
    return [] if left_out else None


@pytest.hookimpl(tryfirst=True)
def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Leaves out the cases that are campaigns, too, before 8,000 of them are made."""
    if metafunc.config.option.markexpr not in ("not campaign", "fast"):
        return
    markers = metafunc.definition.own_markers
    for place, mark in enumerate(markers):
        if mark.name == "parametrize" and len(mark.args) == 2 and not isinstance(mark.kwargs.get("ids"), Sequence):
            names, cases = mark.args[0], list(mark.args[1])
            kept = [case for case in cases if not any(each.name == "campaign" for each in getattr(case, "marks", ()))]
            markers[place] = pytest.mark.parametrize(names, kept or cases, **mark.kwargs).mark


def is_slow(item: pytest.Item) -> bool:
    return item.nodeid.split("[")[0] in SLOW


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Marks as fast what is neither in tests/slow_tests.txt nor a campaign: `pytest -m fast`. Skips what the sanitizers
    cannot run."""
    sanitized = "libasan" in os.environ.get("LD_PRELOAD", "")
    for item in items:
        if sanitized and item.get_closest_marker("unsanitized") is not None:
            item.add_marker(pytest.mark.skip(reason="says nothing under the sanitizers (scripts/trust)"))
        if not is_slow(item) and item.get_closest_marker("campaign") is None:
            item.add_marker(pytest.mark.fast)
    workers = getattr(config, "workerinput", {"workercount": 1})["workercount"]
    if workers > 1:
        items[:] = dealt(items, workers, file_of=lambda item: item.path, is_slow=is_slow)


def pytest_sessionfinish(session: pytest.Session) -> None:
    if hasattr(session.config, "workeroutput"):  # a worker of pytest-xdist: the process that reports is another one
        session.config.workeroutput["golden_changes"] = session.config.stash[changes]


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any) -> None:
    node.config.stash[changes] += getattr(node, "workeroutput", {}).get("golden_changes", [])


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    if not config.getoption("--update-golden"):
        return
    terminalreporter.section("golden files")
    for line in sorted(config.stash[changes]) or ["nothing changed"]:
        terminalreporter.write_line(line)


@pytest.fixture(scope="session")
def emulator() -> Path:
    """The command, as built."""
    return BUILD / "bin" / "emulator"


@pytest.fixture
def golden(request: pytest.FixtureRequest, emulator: Path, tmp_path: Path) -> Callable[[str, str], None]:
    """golden(name, trace): the trace is the one in tests/golden/name, else the first difference is named.

    With --update-golden the file is rewritten instead, and the summary says what changed.
    """

    def check(name: str, trace: str) -> None:
        path = GOLDEN / name
        if path.exists() and path.read_text() == trace:
            return
        fresh = tmp_path / path.name
        fresh.write_text(trace)
        difference = f"{name}: new"
        if path.exists() and not trace.startswith("# cmrc"):  # of links and peripherals: no kind that trace-diff reads
            lines = zip_longest(path.read_text().splitlines(), trace.splitlines(), fillvalue="(the end)")
            number, (before, now) = next((n, pair) for n, pair in enumerate(lines, start=1) if pair[0] != pair[1])
            difference = f"{name}:{number}: {before} -> {now}"
        elif path.exists():
            compared = subprocess.run(
                [emulator, "trace-diff", path, fresh], capture_output=True, text=True, check=False
            )
            difference = f"{name} (<: golden, >: now): {compared.stdout}{compared.stderr}".rstrip()
        if request.config.getoption("--update-golden"):
            path.parent.mkdir(exist_ok=True)
            path.write_text(trace)
            request.config.stash[changes].append(difference)
        elif not path.exists():
            pytest.fail(f"tests/golden/{name} does not exist; `make golden` writes it")
        else:
            pytest.fail(f"{difference}\nIf this change is wanted: make golden")

    return check
