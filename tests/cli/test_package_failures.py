"""``cmrc``: writes that fail, names that cannot be written, and what is left over. Status 1 is a write that failed, 2 a
name or an input that cannot be used, as of ``emulator``."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import cmrc
import pytest
from locations import BUILD

BASE = '[run]\nduration_s = 0.021\n[report]\nreference = "none"\n'
GRID = '[fixed]\nconfig = "base.toml"\n[axes]\ndsps = [1]\n'
OUTPUTS = {
    "compare": ["compare", "--duration", "0.021", "--json"],
    "limits": ["limits", "--duration", "0.021", "--dsps-grid", "1:1", "--json"],
    "diff": ["diff", "one.json", "one.json", "--json"],
    "page": ["page", "base.toml", "--out"],
    "events": ["events", "base.toml", "-o"],
    "sweep": ["sweep", "grid.toml", "--workers", "1", "--metric", "misses", "--csv"],
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    pytest.importorskip("distributed")
    (tmp_path / "base.toml").write_text(BASE)
    (tmp_path / "grid.toml").write_text(GRID)
    (tmp_path / "tmp").mkdir()
    cmrc.run(dsps=1, duration_s=0.021).save(tmp_path / "one.json")
    return tmp_path


def ended(folder: Path, arguments: list[str], **more: object) -> tuple[int, str]:
    environment = {**os.environ, "PYTHONPATH": str(BUILD / "python"), "TMPDIR": str(folder / "tmp")}
    done = subprocess.run(
        [sys.executable, "-m", "cmrc", *arguments],
        cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=100, **more,
    )  # type: ignore[call-overload]  # fmt: skip
    lines = done.stderr.splitlines()
    return done.returncode, lines[-1] if lines else ""


@pytest.mark.unsanitized
def test_a_small_file_needs_little_memory(folder: Path) -> None:
    """A snapshot may have 4 GiB; one of 40 kB is read where there is less."""
    program = "import cmrc; s = cmrc.Simulation(dsps=1, duration_s=0.021); s.run_until(0.01); "
    program += "cmrc.write_snapshot('s.snap', s.snapshot()); import resource; "
    program += "resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30)); cmrc.read_snapshot('s.snap')"
    environment = {**os.environ, "PYTHONPATH": str(BUILD / "python"), "OPENBLAS_NUM_THREADS": "1"}
    subprocess.run([sys.executable, "-c", program], cwd=folder, env=environment, check=True, timeout=60)


@pytest.mark.parametrize("lost", [0, 1, 2])
@pytest.mark.parametrize("command", ["page base.toml --out --plots", "sweep grid.toml --workers 1 --csv --plot"])
def test_an_output_that_is_lost_costs_no_other_one(command: str, lost: int, folder: Path) -> None:
    """The last case loses both, and names both."""
    pytest.importorskip("matplotlib")
    names = ["first.html", "second.png"] if command.startswith("page") else ["first.csv", "second.png"]
    *words, first, second = command.split()
    full = [name for n, name in enumerate(names) if lost in (n, 2)]
    for name in full:
        (folder / name).symlink_to("/dev/full")
    status, says = ended(folder, [*words, first, names[0], second, names[1]])
    assert status == 1 and says == f"cmrc {words[0]}: {full[0]}: writing failed: No space left on device"
    assert all((folder / name).is_file() for name in set(names) - set(full))


def test_plots_are_drawn_beside_a_page_that_goes_into_a_pipe(folder: Path) -> None:
    pytest.importorskip("matplotlib")
    os.mkfifo(folder / "pipe")
    with subprocess.Popen(["cat", folder / "pipe"], stdout=subprocess.DEVNULL):
        assert ended(folder, ["page", "base.toml", "--out", "pipe", "--plots", "p.png"])[0] == 0
    assert (folder / "p.png").stat().st_size > 1000


@pytest.mark.parametrize("command", ["page base.toml --out", "page base.toml --plots", "events base.toml -o"])
def test_the_name_of_a_folder_is_no_name_of_a_file(command: str, folder: Path) -> None:
    status, says = ended(folder, [*command.split(), "x/"])
    assert status == 2 and "'x/' is the name of a folder; the name of a file is expected" in says
    assert not (folder / "x").exists()


@pytest.mark.parametrize("name", OUTPUTS)
def test_a_full_disk_is_a_failed_write_and_a_bad_name_a_bad_input(name: str, folder: Path) -> None:
    full = "/dev/full: writing failed: No space left on device"
    assert ended(folder, [*OUTPUTS[name], "/dev/full"]) == (1, f"cmrc {name}: {full}")
    (folder / "loop").symlink_to("loop")
    status, says = ended(folder, [*OUTPUTS[name], "loop"])
    assert status == 2 and says.endswith("loop: cannot be written: Too many levels of symbolic links")
    status, says = ended(folder, [*OUTPUTS[name], ""])
    assert status == 2 and "the name is empty; the name of an output is expected" in says
    assert not list((folder / "tmp").iterdir())


def test_a_sweep_that_finds_no_room_for_its_lock_names_it(folder: Path) -> None:
    def no_room() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))

    found = ended(folder, ["sweep", "grid.toml", "--out", "runs"], preexec_fn=no_room)
    assert found == (1, f"cmrc sweep: {folder}/runs/lock: cannot be written: File too large")
    assert not list((folder / "runs").iterdir())


def test_damaged_files_are_refused_in_our_words(folder: Path) -> None:
    (folder / "text.json").write_bytes(b'{"a": "\xbd"}')
    said = "neither a saved result nor a JSON report (byte 7 is no UTF-8); what Result.save or emulator --report writes"
    assert ended(folder, ["diff", "text.json", "one.json"]) == (2, f"cmrc diff: text.json: {said} is expected")
    (folder / "runs").mkdir()
    (folder / "runs/sweep.json").write_bytes(json.dumps({"format": 1}).encode() + b"\xc9")
    assert ended(folder, ["sweep", "grid.toml", "--out", "runs", "--show"]) == (
        2, f"cmrc sweep: {folder}/runs/sweep.json: cannot be read: byte 13 is no UTF-8",
    )  # fmt: skip


def test_an_interrupted_demo_leaves_no_empty_folder(folder: Path) -> None:
    script = "import sys\nfrom cmrc import demo\ndef stop(): raise KeyboardInterrupt\ndemo.one_long_block = stop\n"
    script += "from cmrc.commands import main\nsys.exit(main(['demo', '--out', 'shown']))\n"
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(BUILD / "python")},
        capture_output=True,
        check=False,
    )
    assert done.returncode == 130 and not (folder / "shown").exists()
