"""Whatever needs a package that is not installed says which extra brings it, before any work is done."""

import functools
import sys
from collections.abc import Callable
from pathlib import Path

import cmrc
import pytest
from cmrc import events, table
from cmrc.loops import __main__ as loops
from cmrc.results import __main__ as results
from locations import ROOT

SWEEP = {"axes": {"dsps": [1]}, "fixed": {"duration_s": 0.03}}
OPTIMISE = {
    "fixed": SWEEP["fixed"],
    "search": {"metric": "misses", "goal": "minimise", "space": {"servo_frequency_hz": [500, 1000]}},
}


@functools.cache
def result() -> cmrc.Result:
    return cmrc.run(1, 0.03, settings={"report.reference": "none"})


@pytest.fixture
def without(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    def block(package: str) -> None:
        for name in [package, *(known for known in sys.modules if known.startswith(package + "."))]:
            monkeypatch.setitem(sys.modules, name, None)  # import then fails as for a package that is not installed

    return block


@pytest.mark.parametrize(
    ("package", "extra", "call"),
    [
        ("pandas", "pandas", lambda _: result().to_frame()),
        ("pandas", "pandas", lambda _: table.Table({"a": []}).to_pandas()),
        ("matplotlib", "plot", lambda _: result().plot()),
        ("pyarrow", "events", lambda _: events.needed()),
        ("pyarrow", "events", lambda folder: next(events.of_trace(folder / "no.trace"))),
        ("pyarrow", "sweep", lambda folder: cmrc.sweep(SWEEP, folder / "s")),
        ("dask", "sweep", lambda folder: cmrc.sweep(SWEEP, folder / "s")),
        ("distributed", "sweep", lambda folder: cmrc.sweep(SWEEP, folder / "s")),
        ("optuna", "search", lambda folder: cmrc.search(OPTIMISE, folder / "s")),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_the_error_names_package_and_extra(
    without: Callable[[str], None], tmp_path: Path, package: str, extra: str, call: Callable[[Path], object]
) -> None:
    without(package)
    with pytest.raises(ImportError, match=rf"{package}.*pip install 'cmrc\[{extra}\]'"):
        call(tmp_path)
    assert not (tmp_path / "s").exists()


@pytest.mark.parametrize("command", [loops, results], ids=["loops", "results"])
def test_a_command_that_draws_says_so_before_it_runs_anything(
    without: Callable[[str], None],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    command: object,
) -> None:
    without("matplotlib")
    page = tmp_path / "page.md"
    page.write_text((ROOT / "docs" / "control.md").read_text(encoding="utf-8"), encoding="utf-8")
    monkeypatch.setattr(sys, "argv", ["command", "--page", str(page)])
    assert command.main() == 2  # type: ignore[attr-defined]
    assert "--page needs matplotlib" in (said := capsys.readouterr().err) and "pip install 'cmrc[plot]'" in said
    assert not page.with_suffix("").exists()
