"""Against text of GNU objdump that is kept, so that the comparison runs without `make oracles` (docs/oracles.md).

objdump.txt.xz: build/bin/c40_gnu_compare words 3000 1 > FILE; tic4x-objdump -D -z -b binary -m tic4x FILE
"""

import lzma
import re
import struct
import subprocess
from pathlib import Path

import pytest
import tomllib
from locations import BUILD

HERE = Path(__file__).parent
TOOL = BUILD / "bin" / "c40_gnu_compare"
LINE = re.compile(r"^ +[0-9a-f]+:\t([0-9a-f]{8}) ", re.MULTILINE)


@pytest.fixture(scope="module")
def text() -> str:
    return lzma.decompress((HERE / "objdump.txt.xz").read_bytes()).decode()


def compared(text: str, words: list[int], directory: Path) -> "subprocess.CompletedProcess[str]":
    (directory / "words").write_bytes(struct.pack(f"<{len(words)}I", *words))
    return subprocess.run(
        [TOOL, "text", directory / "words"], input=text, capture_output=True, text=True, check=False, timeout=60
    )


def test_our_text_is_objdumps_but_for_differences_that_are_explained(text: str, tmp_path: Path) -> None:
    words = [int(word, 16) for word in LINE.findall(text)]
    done = compared(text, words, tmp_path)
    assert done.returncode == 0, done.stderr
    classes = {line.split("\t")[0]: line.split("\t")[1:] for line in done.stdout.splitlines()}
    assert [classes.pop(name) for name in ("words", "equal instructions", "reserved for both")] == [
        ["3000"],
        ["1120"],
        ["1504"],
    ]
    known = [
        re.compile(entry["class"]) for entry in tomllib.loads((HERE / "gnu_differences.toml").read_text())["difference"]
    ]
    assert [name for name in classes if not any(pattern.fullmatch(name) for pattern in known)] == []
    assert sum(int(count) for count, *_ in classes.values()) == 3000 - 1120 - 1504


def test_the_words_are_those_of_the_seed(text: str) -> None:
    made = subprocess.run([TOOL, "words", "3000", "1"], capture_output=True, check=True).stdout
    assert list(struct.unpack("<3000I", made)) == [int(word, 16) for word in LINE.findall(text)]


def test_text_that_is_not_of_these_words_is_refused(text: str, tmp_path: Path) -> None:
    words = [int(word, 16) for word in LINE.findall(text)]
    for other, why in (
        (words[:-1], "more lines than words"),
        ([*words, 0], "fewer lines than words"),
        ([1, *words[1:]], "a word that differs from the file"),
    ):
        done = compared(text, other, tmp_path)
        assert done.returncode != 0 and why in done.stderr


def test_a_range_is_so_many_words_from_the_first_on() -> None:
    for first, count in ((0x08000000, 3), (5, 2), (7, 0)):
        made = subprocess.run([TOOL, "range", hex(first), str(count)], capture_output=True, check=True).stdout
        assert list(struct.unpack(f"<{count}I", made)) == list(range(first, first + count))
