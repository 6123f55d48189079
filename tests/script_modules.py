"""A program in scripts/ as a module: they have no suffix, so that `import` does not find them."""

from __future__ import annotations

import importlib.machinery
import importlib.util
import sys
from types import ModuleType

from locations import ROOT


def script(name: str) -> ModuleType:
    sys.path.append(str(ROOT / "scripts"))  # it may import what stands beside it
    loader = importlib.machinery.SourceFileLoader(name, str(ROOT / "scripts" / name))
    spec = importlib.util.spec_from_loader(name, loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up
    loader.exec_module(module)
    return module
