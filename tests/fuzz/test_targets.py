"""Every fuzz target (docs/fuzzing.md) over its seeds, and over mutations of them that are the same in every run.

A target ends with a message when a promise is broken; inputs that once broke one are among the seeds."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from cmrc import _core
from locations import BUILD, ROOT

cmrc = _core.cmrc
EMULATOR = BUILD / "bin" / "emulator"

MUTATIONS = 300
TARGETS = sorted(path.stem for path in (ROOT / "fuzz" / "targets").glob("*.cpp"))
# Seeds that end with an error, as they should; a script is no list of words, and the other way round. Any other seed
# gets behind its reader: a target whose seeds are all refused tests nothing but errors.
REFUSED = {
    "coff": {"table_of_copies"},
    "dap": {"stream"},
    "host_script": {"answers", "loaded_without_words", "steps", "text", "timer", "words", "wrong"},
    "link": {"member_name_of_zeros"},
    "network": {"name_too_long"},
    "rom": {"cut_short", "program_c3x"},
}


@pytest.mark.parametrize("target", TARGETS)
def test_no_seed_and_no_mutation_breaks_a_promise(target: str, tmp_path: Path) -> None:
    last = tmp_path / "last-input"
    seeds = ROOT / "fuzz" / "corpus" / target
    command = [BUILD / "fuzzers" / target, "--mutations", str(MUTATIONS), "--keep", last, seeds]
    done = subprocess.run(command, capture_output=True, errors="replace", text=True, check=False, timeout=300)
    failure = f"{done.stderr[-2000:]}\nthe input is {last}: {last.read_bytes()[:200]!r}"
    assert done.returncode == 0, failure
    assert f"{len(list(seeds.iterdir()))} files and {MUTATIONS} mutations" in done.stderr
    assert set(re.findall(r"^(\S+) is refused: ", done.stderr, re.MULTILINE)) == REFUSED.get(target, set())


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


def test_every_source_is_one_for_debians_clang() -> None:
    """clang 14, which builds the fuzz targets, cannot compile the views of GCC 12's library; gcc does not notice."""
    files = subprocess.run(["git", "ls-files", "*.cpp", "*.hpp"], cwd=ROOT, capture_output=True, text=True, check=True)
    assert [name for name in files.stdout.split() if "views::" in (ROOT / name).read_text()] == []


def words_of(target: str) -> set[str]:
    sys.path.insert(0, str(ROOT / "scripts"))
    import fuzz_words

    return set(re.findall(r'^"(.*)"$', fuzz_words.dictionary(target), re.MULTILINE))


def test_the_dictionaries_know_what_the_program_knows() -> None:
    """Without a format's words a fuzzer rarely gets behind its reader. Those of the sources are found by a pattern."""
    keys = {part for key in cmrc.config_keys() for part in key["name"].split(".")}
    actions = {action["name"] for action in cmrc.timed_actions()}
    assert (keys | actions) - words_of("configuration") == set()
    commands = subprocess.run([EMULATOR, "nothing"], capture_output=True, text=True, check=False).stderr
    names = commands.split('"nothing";')[1].split(" are known")[0].replace(",", " ").split()
    assert len(names) > 10
    for name in names:
        told = subprocess.run([EMULATOR, name, "--help"], capture_output=True, text=True, check=True).stdout
        assert {name, *re.findall(r"(?<![\w-])--[a-z][a-z0-9-]*", told)} - words_of("command_line") == set()
    board = (ROOT / "docs" / "boards.md").read_text().split("## Kinds of devices")[1].split("\n## ")[0]
    kinds = re.findall(r"^\| `(\w+)` \|", board, re.MULTILINE)
    assert len(kinds) == 8 and words_of("board") >= {*kinds, "device", "region", "pins", "file", "width", "stride"}
    assert words_of("network") >= {"net", "drivers", "receivers", "open_drain", "pulse", "width_us", "place", "until"}
