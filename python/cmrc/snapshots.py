"""States of chips and networks, to go back to, or to continue from in another process."""

from __future__ import annotations

from cmrc import _core, arguments

SnapshotError = _core.SnapshotError
SnapshotError.__doc__ = """Raised for bytes that are not a snapshot, are of another version, were cut short or changed, and for a snapshot of
another object. The message says which."""


class ChipSnapshot:
    """The whole state of a Processor or a Network at an instant, from ``snapshot()``. It can be pickled, and never
    changes."""

    __slots__ = ("_sealed",)

    def __init__(self, sealed: bytes) -> None:
        self._sealed = bytes(arguments.instance("sealed", sealed, bytes, "bytes that to_bytes() gave"))
        _core.kind_of_snapshot(self._sealed)

    @classmethod
    def from_bytes(cls, sealed: bytes) -> ChipSnapshot:
        """A snapshot from the bytes of ``to_bytes``. Raises SnapshotError."""
        return cls(sealed)

    def to_bytes(self) -> bytes:
        """Bytes for a file, with a description of the object and a checksum."""
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
    """The bytes of the argument of ``restore``."""
    return arguments.instance("snapshot", snapshot, ChipSnapshot, "a ChipSnapshot, as snapshot() gives it,").to_bytes()


__all__ = ["ChipSnapshot", "SnapshotError"]
