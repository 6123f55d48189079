"""States of chips and networks that a run can go back to, or go on from in another process."""

from __future__ import annotations

from cmrc import _core, arguments

SnapshotError = _core.SnapshotError
"""Raised, with what is wrong, for bytes that are no snapshot, are another version's, were cut short or changed, and for a snapshot of something else."""


class ChipSnapshot:
    """The whole state of a Processor or a Network at an instant, as ``snapshot()`` gives it. It can be pickled, and never changes."""

    __slots__ = ("_sealed",)

    def __init__(self, sealed: bytes) -> None:
        self._sealed = bytes(arguments.instance("sealed", sealed, bytes, "bytes that to_bytes() gave"))
        _core.kind_of_snapshot(self._sealed)

    @classmethod
    def from_bytes(cls, sealed: bytes) -> ChipSnapshot:
        """What ``to_bytes`` gave. Raises SnapshotError."""
        return cls(sealed)

    def to_bytes(self) -> bytes:
        """For a file; with what it is a state of, and a checksum."""
        return self._sealed

    @property
    def kind(self) -> str:
        """``processor`` or ``network``."""
        return str(_core.kind_of_snapshot(self._sealed))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ChipSnapshot) and self._sealed == other._sealed

    def __hash__(self) -> int:
        return hash(self._sealed)

    def __reduce__(self) -> tuple[type[ChipSnapshot], tuple[bytes]]:
        return ChipSnapshot, (self._sealed,)


def sealed(snapshot: object) -> bytes:
    """The bytes of what ``restore`` was given."""
    return arguments.instance("snapshot", snapshot, ChipSnapshot, "a ChipSnapshot, as snapshot() gives it,").to_bytes()


__all__ = ["ChipSnapshot", "SnapshotError"]
