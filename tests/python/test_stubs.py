"""Whatever the committed stubs promise is in the C++ module (the plant's: tests/plant/test_plant_types.py)."""

import ast
import importlib
from pathlib import Path

import pytest

STUBS = Path(__file__).parents[2] / "python" / "cmrc" / "_core"


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
