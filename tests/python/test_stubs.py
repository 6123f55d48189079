"""Whatever the committed stubs promise is in the C++ module (the plant's: tests/plant/test_plant_types.py)."""

import ast
import importlib
import re

import pytest
from locations import ROOT

PACKAGE = ROOT / "python" / "cmrc"
STUBS = PACKAGE / "_core"


@pytest.mark.parametrize("room", ["c40", "cmrc", "isa", "network", "report", "toolchain", "trace", "why_late"])
def test_stub(room: str) -> None:
    module = getattr(importlib.import_module("cmrc._core"), room)
    promised = 0
    for node in ast.parse((STUBS / f"{room}.pyi").read_text()).body:
        if isinstance(node, ast.ClassDef):
            owner = getattr(module, node.name)
            members = [m.name for m in node.body if isinstance(m, ast.FunctionDef)]
            assert [name for name in members if not hasattr(owner, name)] == []
            promised += 1 + len(members)
        elif isinstance(node, ast.FunctionDef):
            assert callable(getattr(module, node.name))
            promised += 1
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            assert hasattr(module, node.target.id)
            promised += 1
    assert promised > 0


def test_what_only_tests_use_is_not_in_the_module_of_the_package() -> None:
    """But in tests/bindings/. The names of errors, and of what a function takes or returns, are for users."""
    users = [*PACKAGE.rglob("*.py"), *(ROOT / "examples").rglob("*.py"), *(ROOT / "scripts").iterdir()]
    used = {word for file in users if file.is_file() for word in re.findall(r"\w+", file.read_text(encoding="utf-8"))}
    unused = []
    for stub in STUBS.glob("*.pyi"):
        text = stub.read_text(encoding="utf-8")
        for node in ast.parse(text).body:
            if not isinstance(node, ast.FunctionDef | ast.ClassDef) or node.name in used:
                continue
            is_type = isinstance(node, ast.ClassDef) and len(re.findall(rf"\b{node.name}\b", text)) > 1
            is_error = isinstance(node, ast.ClassDef) and any(ast.unparse(base) == "Error" for base in node.bases)
            if not is_type and not is_error:
                unused.append(f"{stub.stem}.{node.name}")
    assert not unused
