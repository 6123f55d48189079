"""What changes and cannot be copied, since a copy would have the same state."""

from __future__ import annotations

from typing import ClassVar, NoReturn


class OneState:
    """Base of objects with a state in C++, which ``copy`` and ``pickle`` would share or lose."""

    _second: ClassVar[str] = "fork() makes a second one"
    """What makes another one with this state."""

    def _not_copied(self) -> NoReturn:
        name = type(self).__name__
        article = "an" if name[0] in "AEIOU" else "a"
        raise TypeError(f"{article} {name} is not copied or pickled, since both would change one state; {self._second}")

    def __copy__(self) -> NoReturn:
        self._not_copied()

    def __deepcopy__(self, _: object) -> NoReturn:
        self._not_copied()

    def __reduce__(self) -> NoReturn:
        self._not_copied()
