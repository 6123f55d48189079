"""Saved results, pages and caches that somebody has changed: each is refused by the name of its file."""

import base64
import json
import os
import re
import struct
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cmrc
import pytest
from cmrc.page import PageError, Recording
from cmrc.results import __main__ as command
from cmrc.saved_result import ResultError
from locations import BUILD

Report = dict[str, Any]


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("saved") / "whole.cmrc"
    cmrc.run(dsps=1, duration_s=0.03, profile=True).save(path)
    return path


def changed(path: Path, to: Path, member: str, change: Callable[[Any], Any]) -> Path:
    with zipfile.ZipFile(path) as archive, zipfile.ZipFile(to, "w") as out:
        for name in archive.namelist():
            content = archive.read(name)
            out.writestr(name, json.dumps(change(json.loads(content))) if name == member else content)
    return to


CHANGES: dict[str, tuple[str, Callable[[Any], Any]]] = {
    "no dsps": ("report", lambda r: {key: value for key, value in r.items() if key != "dsps"}),
    "buses": ("report", lambda r: {**r, "buses": []}),
    "a bus": ("report", lambda r: {**r, "buses": {"A": 1}}),
    "cycles": ("report", lambda r: {**r, "cycles": 1.5}),
    "a miss": ("report", lambda r: {**r, "misses": [None]}),
    "a task": ("report", lambda r: {**r, "tasks": {"pid": None}}),
    "a task's misses": ("report", lambda r: {**r, "tasks": {"pid": {"misses": "1"}}}),
    "rates": ("report", lambda r: {**r, "rates": 3}),
    "a list": ("report", lambda r: [r]),
    "profile": ("profile", lambda p: []),
    "groups": ("profile", lambda p: {**p, "groups": {}}),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_changed_result_is_refused_by_name(name: str, saved: Path, tmp_path: Path) -> None:
    member, change = CHANGES[name]
    path = changed(saved, tmp_path / "r.cmrc", f"{member}.json", change)
    with pytest.raises(ResultError, match=f"{re.escape(str(path))}: no saved result"):
        cmrc.Result.load(path)


@pytest.fixture(scope="module")
def page() -> bytes:
    simulation = cmrc.Simulation(dsps=1, duration_s=0.03, settings={"report.reference": "none"})
    simulation.record()
    simulation.run()
    return simulation.page()


def with_header(page: bytes, change: Callable[[Any], Any]) -> bytes:
    """The page with another header of its recording."""
    found = re.search(rb'id="recording">([^<]*)<', page)
    assert found
    data = base64.b64decode(found[1])
    (size,) = struct.unpack("<I", data[8:12])
    header = json.dumps(change(json.loads(data[12 : 12 + size]))).encode()
    data = data[:8] + struct.pack("<I", len(header)) + header + data[12 + size :]
    return page.replace(found[1], base64.b64encode(data))


HEADERS: dict[str, tuple[Callable[[Any], Any], str]] = {
    "to_s": (lambda h: {**h, "to_s": -1}, "from_s 0.0 and to_s -1; from_s <= to_s is expected"),
    "from_s": (lambda h: {**h, "from_s": 1}, "from_s 1 and to_s 0.03; from_s <= to_s is expected"),
    "mover": (lambda h: {**h, "layout": {**h["layout"], "movers": [[1, 1]]}}, "there is no column mover0_x_m, which"),
    "vehicle": (
        lambda h: {**h, "layout": {**h["layout"], "agv": {**h["layout"]["agv"], "count": 2}}},
        "there is no column agv1_x_m, which its header promises",
    ),
    "order": (
        lambda h: {**h, "columns": [{**c, "order": 2**62} for c in h["columns"]]},
        "a column has the order 4611686018427387904; 0, 1 or 2 is expected",
    ),
    "contact": (
        lambda h: {**h, "columns": [c for c in h["columns"] if c["name"] != "contact"]},
        "there is no column contact, which its header promises",
    ),
}


@pytest.mark.parametrize("name", HEADERS)
def test_a_page_without_what_its_plots_draw_is_refused_by_name(name: str, page: bytes) -> None:
    pytest.importorskip("matplotlib")
    from cmrc import plot

    plot.overview(Recording.of(with_header(page, lambda header: header), "a.html"))
    change, says = HEADERS[name]
    with pytest.raises(PageError, match=f"^a.html: the recording is damaged: .*{re.escape(says)}"):
        plot.overview(Recording.of(with_header(page, change), "a.html"))


def test_what_is_refused_is_what_was_changed(saved: Path, tmp_path: Path) -> None:
    assert repr(cmrc.Result.load(changed(saved, tmp_path / "r.cmrc", "report.json", lambda r: r)))


def quick(*options: str) -> list[str]:
    return ["--claim", "1", "--quick", "--jobs", "1", *options]


@pytest.mark.parametrize("content", ['{"a', "\xff\xfe", "[]", "{}", "[{}]", "[" * 100_000, None])
def test_a_cache_that_cannot_be_used_is_named_and_stays(
    content: str | None, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """None: a folder in its place."""
    from cmrc.results import runs

    monkeypatch.setattr(runs.Run, "key", lambda self: "run")
    (tmp_path / "cache").mkdir()
    file = tmp_path / "cache" / "run.json"
    if content is None:
        file.mkdir()
    else:
        file.write_text(content, encoding="latin-1")
    assert command.main(quick("--cache", str(tmp_path / "cache"))) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"cmrc.results: {file}: cannot be used (") and said.count("\n") == 1
    assert file.is_dir() if content is None else file.read_text(encoding="latin-1") == content


@pytest.mark.parametrize(
    "options, message",
    [
        (["--cache", "file"], "--cache: file: is a file; the name of a folder is expected"),
        (["--cache", "nowhere"], "--cache: nowhere: is a link to nothing; the name of a folder is expected"),
        (["--plots", "file"], "--plots: file: is a file; the name of a folder is expected"),
        (["--page", "."], "--page: .: is a folder; the name of a file is expected"),
        (["--page", "page.md"], "page.md: no page"),
        (["--page", "file.md"], "--page: file: is a file; the name of a folder is expected"),
        (["--page", "none/page"], "--page: none/page: there is no folder"),
    ],
)
def test_outputs_are_checked_before_the_runs(
    options: list[str],
    message: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(command, "examine", None)
    for name in ("file", "page.md"):
        Path(name).write_bytes(b"mine \xff")
    Path("nowhere").symlink_to("nothing")
    assert command.main(quick(*options)) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"cmrc.results: {message}") and said.count("\n") == 1
    assert Path("file").read_bytes() == b"mine \xff" == Path("page.md").read_bytes()


def test_full_standard_output_is_a_failure() -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "cmrc.results", "--help"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
            env={**os.environ, "PYTHONPATH": str(BUILD / "python")},
        )
    assert (done.returncode, done.stderr) == (1, "cmrc.results: standard output: No space left on device\n")
