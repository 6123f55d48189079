"""A new operation, kind of job, cause, idle policy, event or rule without its row is a compiler error."""

import shutil
import subprocess
from pathlib import Path

import pytest
from locations import ROOT

EMULATOR = ROOT / "emulator"
COMPILER = ["c++", "-std=c++20", "-fsyntax-only", "-DFMT_SHARED"]


def of_tree(name: str) -> Path:
    return EMULATOR / name if (EMULATOR / name).exists() else ROOT / name


def compiled(unit: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """The unit with the headers and sources of `folder` in front of those of the tree."""
    source = folder / unit if (folder / unit).exists() else of_tree(unit)
    command = [*COMPILER, f"-I{folder}", f"-I{EMULATOR}", f"-I{ROOT}", str(source)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def changed(folder: Path, name: str, old: str, new: str) -> None:
    source = folder / name if (folder / name).exists() else of_tree(name)
    text = source.read_text(encoding="utf-8")
    assert text.count(old) == 1, f"{name}: {old!r} is there {text.count(old)} times"
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).write_text(text.replace(old, new), encoding="utf-8")


@pytest.mark.skipif(shutil.which("c++") is None, reason="no C++ compiler")
@pytest.mark.parametrize(
    ("header", "entry", "unit", "row", "says"),
    [
        ("isa/operations.hpp", ("  lopower, ", "  halve, lopower, "), "isa/operations.cpp",
         ('    {Operation::lopower, "lopower"', '    {Operation::halve, "halve", OperationKind::integer},\n    {Operation::lopower, "lopower"'),
         "each operation has one row"),
        ("c40/values/types.hpp", ("  idle,\n", "  idle,\n  thrown,\n"), "c40/observers/profile.cpp",
         ('    {Cause::halted, "halted"', '    {Cause::thrown, "thrown", "", "the chip was thrown"},\n    {Cause::halted, "halted"'), "each cause has one row"),
        ("cmrc/tasks/job_kinds.hpp", ("  user  ///<", "  rewind,\n  user  ///<"), "cmrc/tasks/job_kinds.cpp",
         ('"", 2, none, {0xFFFD, 0xFFFC}, S::none, R::long_run, 0},\n',
          '"", 2, none, {0xFFFD, 0xFFFC}, S::none, R::long_run, 0},\n'
          + '      {K::rewind, "rewind", "KIND_REWIND", 24, none, {0xE000, 0xE000}, S::crane, R::long_run, 0},\n'), "each built-in kind has one row"),
        ("c40/observers/self_check.hpp", ("  reserved,        ///<", "  late,\n  reserved,        ///<"), "c40/observers/self_check.cpp", None, "one name each, in order"),
        ("cmrc/configuration/config.hpp", ("pause, spin };", "pause, spin, nap };"), "cmrc/configuration/config_keys_controller.cpp",
         ('{"doorbell", "pause", "spin"}', '{"doorbell", "pause", "spin", "nap"}'), "each value of the enumeration has one word"),
        ("report/events/event.hpp", ("  issue = 28,", "  vanished = 32,\n  issue = 28,"), "report/events/event.cpp", None, "each kind of event has one row"),
        ("plant/dock/dock_event.hpp", ("  missed,  //", "  rang,\n  missed,  //"), "plant/dock/dock_event.cpp", None, "each kind of event has one row"),
    ],
    ids=["operation", "cause", "kind", "rule", "idle policy", "event of the trace", "event of the dock"],
)  # fmt: skip
def test_a_new_entry_without_its_row_does_not_compile(
    tmp_path: Path, header: str, entry: tuple[str, str], unit: str, row: tuple[str, str] | None, says: str
) -> None:
    changed(tmp_path, header, *entry)
    refused = compiled(unit, tmp_path)
    assert refused.returncode != 0 and says in refused.stderr
    if row is not None:  # in the unit, or in the header whose entry it belongs to
        changed(tmp_path, unit if row[0] in of_tree(unit).read_text(encoding="utf-8") else header, *row)
        taken = compiled(unit, tmp_path)
        assert taken.returncode == 0, taken.stderr
