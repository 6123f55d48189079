"""Every fuzz target (docs/fuzzing.md) over its seeds, and over mutations of them that are the same in every run.

A target ends with a message when a promise is broken; inputs that once broke one are among the seeds."""

import subprocess
from pathlib import Path

import pytest
from locations import BUILD, ROOT

MUTATIONS = 300
TARGETS = sorted(path.stem for path in (ROOT / "fuzz" / "targets").glob("*.cpp"))


@pytest.mark.parametrize("target", TARGETS)
def test_no_seed_and_no_mutation_breaks_a_promise(target: str, tmp_path: Path) -> None:
    last = tmp_path / "last-input"
    seeds = ROOT / "fuzz" / "corpus" / target
    command = [BUILD / "fuzzers" / target, "--mutations", str(MUTATIONS), "--keep", last, seeds]
    done = subprocess.run(command, capture_output=True, errors="replace", text=True, check=False, timeout=300)
    failure = f"{done.stderr[-2000:]}\nthe input is {last}: {last.read_bytes()[:200]!r}"
    assert done.returncode == 0, failure
    assert f"{len(list(seeds.iterdir()))} files and {MUTATIONS} mutations" in done.stderr


def test_a_missing_input_is_an_error(tmp_path: Path) -> None:
    done = subprocess.run(
        [BUILD / "fuzzers" / "traces", tmp_path / "none"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2 and "cannot be read" in done.stderr


def test_every_target_has_seeds_and_a_row() -> None:
    rows = (ROOT / "fuzz" / "CMakeLists.txt").read_text()
    for target in TARGETS:
        assert f'"{target} ' in rows
        assert any((ROOT / "fuzz" / "corpus" / target).iterdir())
    assert {path.name for path in (ROOT / "fuzz" / "corpus").iterdir()} == set(TARGETS)
    assert {path.stem for path in (ROOT / "fuzz").glob("*.dict")} <= set(TARGETS)
