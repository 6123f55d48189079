"""``cmrc.Error``, the base of all named errors of the package."""

from __future__ import annotations

import re

# FILE:line:column, then names and keys; the assembler puts "error" behind the place.
_WHERE = re.compile(r"(?P<where>(?:.*?:\d+(?::\d+)?: )?(?:(?!error: )[^\s:;]+: )*)(?:error: )?")


class Error(Exception):
    """Input that cannot be used: where it is, what is wrong with it, and what would be right.

    Every named error of the package is a ``cmrc.Error``, and also the fitting built-in class (``ValueError``,
    ``OSError``, ``RuntimeError``). ``str(error)`` is the whole message, ``WHERE: PROBLEM; RIGHT``.
    """

    def _parts(self) -> tuple[str, str, str]:
        first = str(self).split("\n", 1)[0]
        found = _WHERE.match(first)
        where, rest = (found["where"].removesuffix(": "), first[found.end() :]) if found else ("", first)
        said, suggests, suggestion = rest.partition("; did you mean ")
        problem, separated, right = said.rpartition("; ")
        if not separated:
            problem, right, suggests = said, "", suggests.removeprefix("; ")
        return where, problem, right + suggests + suggestion

    @property
    def where(self) -> str:
        """File with line and column, key, option or name of what is wrong; empty if there is only one place."""
        return self._parts()[0]

    @property
    def problem(self) -> str:
        """What is wrong; if the message has several errors, the first one."""
        return self._parts()[1]

    @property
    def right(self) -> str:
        """What would be right; empty if the problem says everything."""
        return self._parts()[2]
