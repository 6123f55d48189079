"""Every named error of the package is a ``cmrc.Error`` with where, problem and right, and the built-in error it was."""

import importlib
import inspect
import pkgutil
from collections.abc import Callable

import cmrc
import pytest
from cmrc import _core, c40, network, plant

ENDS = c40.assemble(" .text\nstart: idle\n")
NAMED = [
    "AssemblyError",
    "BoardError",
    "CannotOpen",
    "CoffError",
    "ConfigError",
    "DebugError",
    "GridError",
    "LayoutError",
    "LinkError",
    "ListFull",
    "MemoryMapError",
    "NetworkError",
    "PageError",
    "ResultError",
    "RomError",
    "SameFile",
    "SchemaError",
    "SnapshotError",
    "SweepError",
    "WriteFailed",
]


def named_errors() -> dict[str, type]:
    modules = [
        importlib.import_module(m.name)
        for m in pkgutil.walk_packages(cmrc.__path__, "cmrc.")
        if not m.name.endswith("__main__")
    ]
    rooms = [room for room in vars(_core).values() if inspect.ismodule(room)]
    found = {
        name: value
        for module in (*modules, _core, *rooms)
        for name, value in vars(module).items()
        if isinstance(value, type)
        and issubclass(value, Exception)
        and value.__module__.startswith("cmrc")
        and value is not cmrc.Error
    }
    return found


def test_each_is_an_error_of_the_package_and_a_built_in_one() -> None:
    found = named_errors()
    assert sorted(set(found) - {"RunDied", "Stopped"}) == NAMED
    for name in NAMED:
        assert issubclass(found[name], cmrc.Error), name
        built_in = (
            OSError
            if name in ("CannotOpen", "WriteFailed")
            else RuntimeError
            if name in ("ListFull", "SweepError")
            else ValueError
        )
        assert issubclass(found[name], built_in), name


@pytest.mark.parametrize(
    ("cause", "where", "problem", "right"),
    [
        (lambda: cmrc.run(dsps=40), "machine.dsps", "40 is out of range", "an integer from 1 to 16 is expected"),
        (
            lambda: cmrc.run(config="missing.toml"),
            "missing.toml",
            "cannot be read",
            "the name of a TOML file is expected",
        ),
        (lambda: c40.assemble(" .text\n addi 1\n"), "<text>:2:2", "'addi' takes 2 operands, not 1", ""),
        (lambda: network.Network([ENDS] * 2, links=["00:1.3"]), None, None, None),
        (
            lambda: c40.Processor(ENDS, board="missing.toml"),
            "missing.toml",
            "cannot be read",
            "a board file (docs/boards.md) is expected",
        ),
        (lambda: c40.Processor(ENDS, board="flt"), None, None, None),
        (lambda: network.Network([ENDS] * 2, boards="flt"), None, None, None),
        (lambda: c40.Processor(ENDS).load_rom("no.hex", 0x300000), "no.hex", "cannot be read", None),
        (lambda: cmrc.Result.load(__file__), __file__, None, "Result.save writes one"),
        (lambda: cmrc.diff(__file__, __file__), __file__, None, None),
        (lambda: cmrc.diff({}, {}), "left", None, None),
        (lambda: plant.apply_layout(plant.default_dock(), "[[posts]]\nx_m = 1"), "layout:1:1", None, None),
    ],
)
def test_where_what_and_what_would_be_right(
    cause: Callable[[], object], where: str | None, problem: str | None, right: str | None
) -> None:
    with pytest.raises(cmrc.Error) as caught:
        cause()
    error = caught.value
    assert error.problem and error.problem in str(error)
    for part, expected in ((error.where, where), (error.problem, problem), (error.right, right)):
        assert expected is None or part == expected, str(error)


@pytest.mark.parametrize(
    ("message", "parts"),
    [
        (
            'dock.toml:3:7: run.seed: "x" is text; an integer is expected',
            ("dock.toml:3:7: run.seed", '"x" is text', "an integer is expected"),
        ),
        ("a folder/b.asm:2: no such label", ("a folder/b.asm:2", "no such label", "")),
        ("nothing to say", ("", "nothing to say", "")),
        ("a: one; two; three\nb: more", ("a", "one; two", "three")),
        (
            'a: "x" is not known; "y" is expected; did you mean "y"?',
            ("a", '"x" is not known', '"y" is expected; did you mean "y"?'),
        ),
        ('a: no such key; did you mean "y"?', ("a", "no such key", 'did you mean "y"?')),
    ],
)
def test_parts_of_a_message(message: str, parts: tuple[str, str, str]) -> None:
    error = cmrc.Error(message)
    assert (error.where, error.problem, error.right) == parts
