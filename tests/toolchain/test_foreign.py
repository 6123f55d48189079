"""Public sources that are not in the tree (docs/assembler.md, Old sources)."""

import re
import subprocess
import sys

import pytest
from locations import ROOT

ASSEMBLED = {"helios": (151, 154), "cps": (73, 119)}


@pytest.mark.parametrize("name", sorted(ASSEMBLED))
def test_public_sources_assemble_as_the_page_says(name: str) -> None:
    if not (ROOT / "build-foreign" / name).is_dir():
        pytest.skip(f"scripts/foreign {name} has not been run here")
    done = subprocess.run([sys.executable, ROOT / "scripts" / "foreign", name], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    found = re.search(r"(\d+) of (\d+) files assemble", done.stdout)
    assert found and (int(found[1]), int(found[2])) == ASSEMBLED[name]
