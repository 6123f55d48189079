"""Public sources that are not in the tree (docs/assembler.md, Old sources)."""

import re
import subprocess
import sys

import pytest
from locations import ROOT

ASSEMBLED = {"helios": (151, 154), "cps": (53, 119)}


@pytest.mark.parametrize("name", sorted(ASSEMBLED))
def test_public_sources_assemble_as_the_page_says(name: str) -> None:
    if not (ROOT / "build-foreign" / name).is_dir():
        pytest.skip(f"scripts/foreign {name} has not been run here")
    done = subprocess.run([sys.executable, ROOT / "scripts" / "foreign", name], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    found = re.search(r"(\d+) of (\d+) files assemble", done.stdout)
    assert found and (int(found[1]), int(found[2])) == ASSEMBLED[name]


@pytest.mark.campaign
def test_programs_of_gcc_print_what_the_page_says() -> None:
    if not (ROOT / "build-foreign" / "gcc").exists():
        pytest.skip("scripts/foreign gcc --from FOLDER has not been run here: no GCC 2.95 for the C4x")
    done = subprocess.run([sys.executable, ROOT / "scripts" / "foreign", "gcc"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    page = (ROOT / "docs" / "from-c.md").read_text()
    counted = re.findall(r"(\d+ of \d+) ", done.stdout)
    assert len(counted) == 2 and all(count in page for count in counted), done.stdout


def test_gcc_without_a_folder_says_what_is_missing(tmp_path) -> None:  # type: ignore[no-untyped-def]
    done = subprocess.run([sys.executable, ROOT / "scripts" / "foreign", "gcc", "--from", tmp_path / "none"], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "no folder" in done.stderr
