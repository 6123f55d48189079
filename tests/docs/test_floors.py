"""What the C++ includes and the Python imports is what docs/architecture.md allows: the file's own room, or rooms on
floors below; modules of the own row, or of rows above."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from cpp_sources import cpp_sources
from locations import ROOT


def floors() -> dict[str, int]:
    """The floor of each room, by its path from the tree's root."""
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    table = page.partition("| floor | rooms |")[2].partition("\n\n")[0]
    rows = re.findall(r"^\| (\d+) \| (.+) \|$", table, re.MULTILINE)
    return {room.rstrip("/"): int(floor) for floor, rooms in rows for room in re.findall(r"`([\w./]+)`", rooms)}


def room_of(path: str) -> str:
    """`emulator/c40` of `emulator/c40/chip/chip.hpp`; outside of `emulator/` the first folder is a room."""
    parts = path.split("/")
    return "/".join(parts[:2]) if parts[0] == "emulator" else parts[0]


def upwards(texts: dict[str, str], floor: dict[str, int]) -> list[str]:
    """Each include that is of another room, and not of a floor below."""
    rooms = {room.rpartition("/")[2]: room for room in floor}  # paths of includes begin at the root or in emulator/
    found = []
    for path, text in texts.items():
        own = room_of(path)
        for include in re.findall(r'^#include "([^"]+)"', text, re.MULTILINE):
            needed = rooms.get(include.split("/")[0], own)  # own: a library, or a file beside this one
            if needed != own and floor[needed] >= floor[own]:
                found.append(f"{path} includes {include}")
    return found


def test_files_include_from_floors_below() -> None:
    texts = cpp_sources("emulator", "bus_model", "plant", "python/bindings")
    assert {room_of(path) for path in texts} | {"c40_programs"} == set(floors())
    assert not upwards(texts, floors())


def test_an_include_of_the_same_floor_is_found() -> None:
    floor = {"plant": 2, "bus_model": 2, "emulator/io": 1, "python": 3}
    own = '#include "plant/dock.hpp"\n#include "io/file.hpp"\n'
    assert upwards({"plant/a.cpp": own}, floor) == []
    assert upwards({"plant/a.cpp": own + '#include "bus_model/bus.hpp"\n'}, floor) == [
        "plant/a.cpp includes bus_model/bus.hpp"
    ]
    assert upwards({"emulator/io/a.cpp": own}, floor) == ["emulator/io/a.cpp includes plant/dock.hpp"]


PACKAGE = ROOT / "python" / "cmrc"


def rows() -> dict[str, int]:
    """The row of each module and folder of the package: `debug`, `network`; `__init__` are the public names."""
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    table = page.partition("| in `python/cmrc/` | holds |\n|---|---|\n")[2].partition("\n\n")[0]
    return {
        name.removesuffix("/").removesuffix(".py"): row
        for row, line in enumerate(table.split("\n"))
        for name in re.findall(r"`([\w/.]+)`", line.split(" | ")[0])
    }


def imported(tree: ast.AST) -> Iterator[str]:
    """What of the package is imported as the module is loaded, `cmrc.sweeps.grid` or `cmrc.Simulation`: not in
    functions, and not for types."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == "cmrc":
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.split(".")[0] == "cmrc")
        elif not isinstance(node, ast.FunctionDef) and not (isinstance(node, ast.If) and "TYPE" in ast.dump(node.test)):
            yield from imported(node)


def imports_upwards(name: str, text: str, row: dict[str, int]) -> list[str]:
    """Of a module, or of a folder's module."""
    own, known = row[name], {**row, "_core": -1}
    return [
        f"{name} imports {one}"
        for one in imported(ast.parse(text))
        if known.get(f"{one}.__init__".split(".")[1], row["__init__"]) > own
    ]


def test_modules_import_from_rows_above() -> None:
    files = {path.relative_to(PACKAGE): path for path in PACKAGE.rglob("*.py")}
    names = {path: path.parts[0].removesuffix(".py") for path in files}
    assert set(names.values()) == set(rows()) and len(files) > 80
    assert not [
        found
        for path, file in files.items()
        if path != Path("__init__.py")  # it imports for everybody
        for found in imports_upwards(names[path], file.read_text(encoding="utf-8"), rows())
    ]


def test_an_import_from_a_row_below_is_found() -> None:
    row = {"errors": 0, "run": 1, "__init__": 2, "page": 3}
    lazy = (
        "from cmrc import _core, errors\ndef f():\n    import cmrc.page\nif TYPE_CHECKING:\n    from cmrc import page\n"
    )
    assert imports_upwards("run", lazy, row) == []
    assert imports_upwards("run", "try:\n    from cmrc.page import show\nfinally:\n    pass\n", row) == [
        "run imports cmrc.page.show"
    ]
    assert imports_upwards("run", "from cmrc import Result\n", row) == ["run imports cmrc.Result"]
    assert imports_upwards("page", "import cmrc\n", row) == []
