"""Settings as keywords of ``run`` and its like: by the last part of their names, where only one table has it.

Type checkers and Pylance know them from ``_settings.pyi``; IPython, Jupyter and ``help`` ask for the signature of the
function that is there, so that it lists them, too."""

from __future__ import annotations

import inspect
from collections import Counter
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, TypeVar

from cmrc import _core

ARGUMENTS = ("reference",)
"""Arguments of cmrc.Simulation that are called as a setting is; that one goes by its full name."""
TYPES = {"integer": int, "number": float, "boolean": bool, "string": str, "choice": str}
Listed = TypeVar("Listed", bound=Callable[..., Any])


@cache
def settings() -> Mapping[str, Mapping[str, Any]]:
    """By keyword, what the configuration's schema says of it."""
    keys = _core.cmrc.config_keys()
    shorts = Counter(key["name"].rpartition(".")[2] for key in keys)
    named = {key["name"].rpartition(".")[2]: key for key in keys}
    return {short: key for short, key in named.items() if shorts[short] == 1 and short not in ARGUMENTS}


class SettingParameter(inspect.Parameter):
    """A parameter that is a setting."""


class ShortText(inspect.Signature):
    """A signature with all settings, for completion; as text, in ``help``, it has ``**keywords`` in their place."""

    def short(self) -> inspect.Signature:
        """The signature with ``**keywords`` in place of the settings."""
        own = [one for one in self.parameters.values() if not isinstance(one, SettingParameter)]
        keywords = inspect.Parameter("keywords", inspect.Parameter.VAR_KEYWORD)
        return inspect.Signature([*own, keywords], return_annotation=self.return_annotation)

    def __str__(self) -> str:
        return str(self.short())

    def format(self, **how: Any) -> str:
        """What ``help`` calls from Python 3.13 on."""
        return str(self.short().format(**how))  # type: ignore[attr-defined]


def listed(function: Listed) -> Listed:
    """The same function; its signature has each setting as a keyword, in place of ``**keywords``."""
    whole = inspect.signature(function)
    own = [parameter for parameter in whole.parameters.values() if parameter.kind is not inspect.Parameter.VAR_KEYWORD]
    there = {parameter.name for parameter in own}
    more = [
        SettingParameter(
            short, inspect.Parameter.KEYWORD_ONLY, default=key["default"], annotation=TYPES[key["type"]].__name__
        )
        for short, key in settings().items()
        if short not in there
    ]
    signature = ShortText([*own, *more], return_annotation=whole.return_annotation)
    function.__signature__ = signature  # type: ignore[attr-defined]
    return function
