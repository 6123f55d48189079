"""The tools behind docs/trust.md: what counts as a mutant, what a line's coverage is made of, what clang-tidy reads."""

from __future__ import annotations

import itertools
import json
import sys
from pathlib import Path
from typing import Any

import pytest
from locations import ROOT
from script_modules import script

mutants, coverage, tidy = script("mutants"), script("coverage"), script("tidy")
languages = sys.modules["mutant_languages"]


@pytest.mark.parametrize(("line", "expected"), [
    ("  if (a < limit) return;", {"  if (a <= limit) return;", "  if (a >= limit) return;"}),
    ("  if (!ready && late) stop();", {"  if (ready && late) stop();", "  if (!ready || late) stop();"}),
    ("  beat = next(beat);", {"  ;"}),
    ("  const int n = 8;", {"  const int n = 9;", "  const int n = 7;"}),
    ("  return x * 0.5;", {"  return x / 0.5;", "  return x * 0.505;", "  return x * -0.5;"}),
    ('  throw Error("a < b, 3 of 4");  // 5 > 4', set()),
    ("  std::vector<int>& all = kept(0x10);", {"  std::vector<int>& all = kept(17);", "  std::vector<int>& all = kept(15);"}),
    ("#define WIDTH 3", set()),
    ("  static_assert(3 < 4);", set()),
    ("  create(path, 0666);", {"  ;"}),
])  # fmt: skip
def test_a_line_is_changed_where_it_is_code(line: str, expected: set[str]) -> None:
    assert set(languages.changes_of_line(line)) == expected


@pytest.mark.parametrize(("text", "expected"), [
    ("if a < limit and not late:\n    stop()\n", {
        1: {"if a <= limit and not late:", "if a >= limit and not late:", "if a < limit or not late:", "if a < limit and  late:"},
        2: {"    pass"},
    }),
    ("def f(*rest, key=8):\n    return min(rest) * 0.5  # 3 < 4\n", {
        1: {"def f(*rest, key=9):", "def f(*rest, key=7):"},
        2: {"    return max(rest) * 0.5  # 3 < 4", "    return min(rest) / 0.5  # 3 < 4", "    return min(rest) * 0.505  # 3 < 4",
            "    return min(rest) * -0.5  # 3 < 4"},
    }),
    ('"""Text, 3 < 4."""\nx: int | None = None\n', {}),
])  # fmt: skip
def test_a_line_of_python_is_changed_where_it_stays_python(text: str, expected: dict[int, set[str]]) -> None:
    found = {}
    for number, ways in languages.changes_of_python(text).items():
        lines = text.split("\n")
        others = {way: "\n".join([*lines[: number - 1], way, *lines[number:]]) for way in ways}
        if python := {way for way, other in others.items() if languages.is_other_python(text, other)}:
            found[number] = python
    assert found == expected


@pytest.mark.parametrize("language", languages.LANGUAGES.values(), ids=languages.LANGUAGES)
def test_mutants_are_those_of_the_seed_and_of_every_room(language: Any) -> None:
    one = [next(mutants.drawn(language, 7, number)) for number in range(400)]
    assert one == [next(mutants.drawn(language, 7, number)) for number in range(400)]
    assert one != [next(mutants.drawn(language, 8, number)) for number in range(400)]
    first, second = itertools.islice(mutants.drawn(language, 7, 0), 2)
    assert first == one[0] and second != one[1]  # another in the place of one that is no mutant moves no other number
    assert {language.room_of(file) for file, *_ in one} == set(language.rooms)


@pytest.mark.parametrize("language", languages.LANGUAGES.values(), ids=languages.LANGUAGES)
def test_every_room_has_tests_that_are_put_first(language: Any) -> None:
    for place, aimed in language.aimed.items():  # a folder of a room stands before the room
        assert language.aimed_at(f"{place}/some.file") == aimed and any((ROOT / place).glob("*"))
        assert all((ROOT / "tests" / folder).is_dir() for folder in [*aimed, *mutants.LAST])


def test_every_folder_of_cpp_and_python_is_a_room() -> None:
    cpp, python = languages.LANGUAGES["c++"], languages.LANGUAGES["python"]
    rooms = {str(path.relative_to(ROOT)) for path in (ROOT / "emulator").iterdir() if path.is_dir()}
    assert {*rooms, "bus_model", "plant", "python/bindings"} == set(cpp.rooms)
    packages = {str(path.parent.relative_to(ROOT)) for path in (ROOT / "python/cmrc").glob("**/__init__.py")}
    assert packages == set(python.rooms)


def line(number: int, count: int, *branches: tuple[int, bool]) -> dict[str, Any]:
    return {
        "line_number": number,
        "count": count,
        "branches": [{"count": times, "throw": throw} for times, throw in branches],
    }


def test_a_line_of_a_template_counts_when_any_instance_is_reached() -> None:
    record: dict[str, Any] = {"lines": {}, "branches": {}}
    coverage.add(
        record,
        [line(3, 0, (0, False), (2, False)), line(3, 4, (1, False), (0, False)), line(5, 0), line(6, 2, (0, True))],
    )
    assert record == {"lines": {"3": 4, "5": 0, "6": 2}, "branches": {"3": [1, 2]}}
    table = coverage.table({"emulator/isa/decode.cpp": record})
    assert "| `emulator/isa/` | 1 | 3 | 66.7 % | 2 | 100.0 % |" in table


def test_clang_tidy_reads_groups_of_sources_and_no_source_that_the_build_generates(tmp_path: Path) -> None:
    generated = ROOT / "build" / "c40_programs"
    files = [ROOT / "plant" / "crane.cpp", generated / "image.cpp", generated / "Unity" / "unity_0_cxx.cxx"]
    (tmp_path / "compile_commands.json").write_text(json.dumps([{"file": str(file)} for file in [*files, *files]]))
    assert tidy.compiled(tmp_path) == ["build/c40_programs/Unity/unity_0_cxx.cxx", "plant/crane.cpp"]


def test_a_path_without_a_source_is_an_error(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["tidy", "no/such/room"])
    assert tidy.main() == 1
    assert capsys.readouterr().err == "tidy: no source that build/ compiles has no/such/room in its path\n"
