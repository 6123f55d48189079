"""The Python of docs/python.md runs, and gives the figures that its comments say."""

import importlib
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from locations import BUILD, ROOT


def blocks(page: str = "docs/python.md") -> list[str]:
    return re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.parametrize("name", ["cmrc", "cmrc.sweeps"])
def test_the_page_of_the_api_has_each_public_name(name: str) -> None:
    """Of modules whose members it lists by hand; of the others it takes all."""
    page = (ROOT / "docs" / "api" / "python.md").read_text(encoding="utf-8")
    module = importlib.import_module(name)
    by_hand = re.search(rf"automodule:: {re.escape(name)}\n   :members: (.+)", page)
    assert by_hand is not None
    listed = set(by_hand[1].split(", ")) | set(
        re.findall(rf"(?:autoclass|automodule):: {re.escape(name)}\.(\w+)", page)
    )
    aside = {"SnapshotError"} if name == "cmrc" else set()  # that of cmrc.c40
    if name == "cmrc":
        listed |= {"sweep", "search"}  # those of cmrc.sweeps
    assert set(module.__all__) - listed == aside


def in_the_readmes_python(arguments: str, program: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """As the README's command starts it after `make demo`, by a user who has set nothing."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    [command] = re.findall(r"^    (\S.*\bpython)\s+# ", text, re.MULTILINE)
    (folder / "build").symlink_to(BUILD)
    (folder / "scripts").symlink_to(ROOT / "scripts")
    (folder / ".venv" / "bin").mkdir(parents=True)
    (folder / ".venv" / "bin" / "python").write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    (folder / ".venv" / "bin" / "python").chmod(0o755)
    return subprocess.run(
        ["sh", "-c", f"{command} {arguments}"],
        env={name: value for name, value in os.environ.items() if name != "PYTHONPATH"},
        cwd=folder,
        input=program,
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_python_of_the_readme(tmp_path: Path) -> None:
    [program] = blocks("README.md")
    done = in_the_readmes_python("-", program, tmp_path)
    assert done.returncode == 0, done.stderr
    misses, explained = done.stdout.splitlines()
    [missed] = re.findall(r"deadlines missed\"\)\s+# (\d+)", program)
    assert misses == f"{missed} deadlines missed" and int(missed) > 0
    assert "It was blocked" in explained and "this helps" in explained


def test_the_python_of_its_page(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = blocks()[0]
    [fewest] = re.findall(r"# the fewest DSPs without a miss: (\S+)", program)
    [r1] = re.findall(r"# (\d+\.\d), and the cycles it took", program)
    [missed] = re.findall(r"# (\d+) deadlines missed", program)
    monkeypatch.chdir(tmp_path)
    exec(program, {})  # noqa: S102
    misses, explained, *_, dsps, last = capsys.readouterr().out.splitlines()
    assert misses == missed and int(missed) > 0 and "It was blocked" in explained and "Without" in explained
    assert os.listdir(tmp_path) == ["one_dsp.cmrc"]
    assert dsps == fewest and last.split()[0] == r1 and int(last.split()[1]) >= 2


def test_the_python_of_the_page_on_pages_needs_one_import(tmp_path: Path) -> None:
    """In a process of its own, in which nobody has imported cmrc.page before."""
    [shown] = blocks("docs/page.md")
    program = "import cmrc\n" + shown.replace("duration_s=3", "duration_s=0.03") + "print(len(recording.jobs))\n"
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": str(BUILD / "python")},
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
    )
    assert done.returncode == 0 and int(done.stdout) > 0, done.stderr


def test_the_error_of_its_page(capsys: pytest.CaptureFixture[str]) -> None:
    refused = blocks()[1]
    exec("import cmrc\n" + refused, {})  # noqa: S102
    said = re.findall(r"# (.*)$", refused, re.MULTILINE)
    assert capsys.readouterr().out.splitlines() == said and len(said) == 3


def test_pages_and_examples_name_nothing_private() -> None:
    """The extension module `_core` may change without a word; its build target of the same name may be named."""
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md"), *(ROOT / "editors").rglob("*.md")]
    examples = [path for path in (ROOT / "examples").rglob("*") if path.suffix in (".py", ".md", ".toml")]
    found = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
        for path in (*pages, *examples)
        if "_site" not in path.parts
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1)
        if re.search(r"cmrc\._core|import _core|\b_core\.\w", line)
    ]
    assert len(pages) > 50 and len(examples) > 10 and found == []


def test_the_script_of_the_pictures_finds_what_it_draws_with(tmp_path: Path) -> None:
    """As the caption of the README's picture calls it."""
    caption = "`PYTHONPATH=build/python .venv/bin/python scripts/documents/pictures.py dock docs/pictures/dock.png`"
    assert caption in (ROOT / "README.md").read_text(encoding="utf-8")
    done = in_the_readmes_python("scripts/documents/pictures.py", "", tmp_path)
    assert done.returncode == 2 and "Pictures: dock" in done.stderr
