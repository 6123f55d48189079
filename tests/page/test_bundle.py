"""What is committed of the page is what its sources make, byte for byte."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest
from locations import ROOT

PAGE = ROOT / "page"


def modules(folder: Path) -> None:
    """The libraries of the lock file, in ``folder``. Skips the test where they cannot be installed."""
    for tool in ("node", "npm"):
        if shutil.which(tool) is None:
            pytest.skip(f"{tool} is missing: the page is not made again")
    there = PAGE / "node_modules" / ".package-lock.json"
    locked = json.loads((PAGE / "package-lock.json").read_text())["packages"]
    if there.is_file():
        installed = json.loads(there.read_text())["packages"]
        if all(
            locked[name]["integrity"] == package["integrity"] for name, package in installed.items() if name in locked
        ):
            (folder / "node_modules").symlink_to(PAGE / "node_modules")
            return
    command = ["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--silent"]
    try:
        made = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    except subprocess.TimeoutExpired:
        pytest.skip("npm ci took more than two minutes: the page is not made again")
    if made.returncode:
        pytest.skip(f"npm ci cannot install what the page is made with: {made.stderr.strip()[-200:]}")


def test_the_committed_page_is_what_its_sources_make(tmp_path: Path) -> None:
    folder = tmp_path / "page"
    shutil.copytree(PAGE, folder, ignore=shutil.ignore_patterns("node_modules", "dist"))
    modules(folder)
    subprocess.run(["node", "build.mjs"], cwd=folder, check=True, timeout=120)
    for name in ("page.html", "licences.txt"):
        assert (folder / "dist" / name).read_bytes() == (PAGE / "dist" / name).read_bytes(), (
            f"page/dist/{name}: make page makes it again"
        )


def test_the_page_names_the_licences_of_what_is_in_it() -> None:
    text = (PAGE / "dist" / "page.html").read_text(encoding="utf-8")
    licences = (PAGE / "dist" / "licences.txt").read_text(encoding="utf-8")
    for name in json.loads((PAGE / "package.json").read_text())["dependencies"]:
        assert f"{name} " in licences and licences.count("Permission is hereby granted") == 2
    assert text.count("Permission is hereby granted") == 2 and text.count("@RECORDING@") == text.count("@TITLE@") == 1
