"""What a program can call, as it is kept in tests/golden: names, order, defaults, and what is by keyword only."""

import importlib
import inspect
import re
from collections.abc import Callable, Iterator
from types import ModuleType

import cmrc
import pytest
from locations import ROOT

PAGE = (ROOT / "docs" / "api" / "python.md").read_text(encoding="utf-8")
MODULES = re.findall(r"automodule:: (cmrc[\w.]*)", PAGE)


def plain(function: Callable[..., object]) -> str:
    """The signature without types, whose text depends on the version of Python."""
    signature = inspect.signature(function)
    bare = [one.replace(annotation=inspect.Parameter.empty) for one in signature.parameters.values()]
    return str(signature.replace(parameters=bare, return_annotation=inspect.Signature.empty))


def members(of: type) -> Iterator[str]:
    """Public members that are written in Python, those of its own bases, too."""
    bases = [base for base in of.__mro__ if base.__module__.startswith("cmrc") and "_core" not in base.__module__]
    for name in sorted({name for base in bases for name in vars(base) if not name.startswith("_")}):
        value = inspect.getattr_static(of, name)
        value = value.__func__ if isinstance(value, (classmethod, staticmethod)) else value
        yield f"{name}{plain(value)}" if inspect.isfunction(value) else name


def names(module: ModuleType) -> Iterator[str]:
    public: list[str] = getattr(module, "__all__", None) or [
        name
        for name, value in vars(module).items()
        if str(getattr(value, "__module__", "")).startswith(module.__name__)
    ]
    for name in sorted(name for name in public if not name.startswith("_")):
        value = getattr(module, name)
        place = f"{module.__name__}.{name}"
        if inspect.isfunction(value):
            yield place + plain(value)
        elif inspect.isclass(value) and value.__module__.startswith("cmrc") and "_core" not in value.__module__:
            yield place + (plain(value) if inspect.isfunction(value.__init__) else "")
            yield from (f"{place}.{member}" for member in members(value))
        else:
            yield place


@pytest.mark.golden
def test_the_interface_is_as_it_is_kept(golden: Callable[[str, str], None]) -> None:
    assert cmrc.__name__ in MODULES and len(MODULES) > 5
    made = [line for name in MODULES for line in names(importlib.import_module(name))]
    golden("python.signatures", "\n".join(dict.fromkeys(made)) + "\n")
