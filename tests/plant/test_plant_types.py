"""The types that users of cmrc.plant see: its stub says all that the C++ module has, and nothing of the public face is
of type Any."""

import ast
import re

from cmrc._core import plant
from locations import ROOT

STUB = ast.parse((ROOT / "python/cmrc/_core/plant.pyi").read_text(encoding="utf-8"))
PUBLIC = [
    ast.parse(path.read_text(encoding="utf-8")) for path in sorted((ROOT / "python/cmrc/plant").glob("[a-z]*.py"))
]


def public(names):
    return {name for name in names if not name.startswith("_")}


def parameters_of(function: object) -> list[str]:
    """From the signature in the first line of what pybind11 writes."""
    inside = re.search(r"\((.*)\) ->", (function.__doc__ or "").splitlines()[0])
    assert inside
    flat = re.sub(r"\[[^\[\]]*\]", "", re.sub(r"\[[^\[\]]*\]", "", re.sub(r"\[[^\[\]]*\]", "", inside[1])))
    return [part.split(":")[0].strip() for part in flat.split(",") if part.strip()]


def test_the_stub_is_whole():
    said = {}
    for node in STUB.body:
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
            said[node.name] = node
        elif isinstance(node, ast.AnnAssign):
            said[node.target.id] = node
    assert public(dir(plant)) == public(said)
    checked = 0
    for name, node in said.items():
        if isinstance(node, ast.FunctionDef):
            assert parameters_of(getattr(plant, name)) == [a.arg for a in node.args.args], name
        if not isinstance(node, ast.ClassDef) or node.bases:
            continue
        owner = getattr(plant, name)
        members = {m.name: m for m in node.body if isinstance(m, ast.FunctionDef)}
        assert public(vars(owner)) == public(members) | {
            m.target.id for m in node.body if isinstance(m, ast.AnnAssign)
        }, name
        for member, function in members.items():
            if not function.decorator_list:  # no property
                assert parameters_of(getattr(owner, member)) == [a.arg for a in function.args.args], (name, member)
                checked += 1
    assert checked > 80


def test_nothing_of_the_public_face_is_any():
    signatures = [
        node
        for module in PUBLIC
        for node in ast.walk(module)
        if isinstance(node, ast.FunctionDef) and (node.name == "__init__" or not node.name.startswith("_"))
    ]
    assert len(signatures) > 40
    for node in signatures:
        a = node.args
        hints = [node.returns, *(p.annotation for p in [*a.args, *a.kwonlyargs, *filter(None, [a.vararg, a.kwarg])])]
        assert "Any" not in {n.id for hint in hints if hint for n in ast.walk(hint) if isinstance(n, ast.Name)}, (
            node.name
        )
    assert "Any" not in {n.id for n in ast.walk(STUB) if isinstance(n, ast.Name)}
