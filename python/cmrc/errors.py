"""What every named error of the package is: ``cmrc.Error``."""

from __future__ import annotations

import re

# FILE:line:column, then names and keys; the assembler puts "error" behind the place.
_WHERE = re.compile(r"(?P<where>(?:.*?:\d+(?::\d+)?: )?(?:(?!error: )[^\s:;]+: )*)(?:error: )?")


class Error(Exception):
    """Input that cannot be used: where it stands, what is wrong with it, and what would be right.

    Each named error of the package is one, and is the built-in class too that fits (``ValueError``, ``OSError``,
    ``RuntimeError``). ``str(error)`` is the whole message, ``WHERE: PROBLEM; RIGHT``.
    """

    def _parts(self) -> tuple[str, str, str]:
        first = str(self).split("\n", 1)[0]
        found = _WHERE.match(first)
        where, rest = (found["where"].removesuffix(": "), first[found.end() :]) if found else ("", first)
        problem, separated, right = rest.rpartition("; ")
        return (where, problem, right) if separated else (where, rest, "")

    @property
    def where(self) -> str:
        """File with line and column, key, option or name of what is wrong; empty where there is only one place."""
        return self._parts()[0]

    @property
    def problem(self) -> str:
        """What is wrong; of several errors in one message, the first."""
        return self._parts()[1]

    @property
    def right(self) -> str:
        """What would be right; empty where the problem says it all."""
        return self._parts()[2]
