"""Tables: columns of equal length under their names."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cmrc import arguments
from cmrc.extras import needed

if TYPE_CHECKING:
    import pandas


class Table(dict[str, NDArray[Any]]):
    """A dict of NumPy arrays of equal length, one per column. Missing numbers are NaN, and whole numbers beside them
    floats; a column with a whole number that no float can hold is one of objects.

    ``len(table)`` is the number of columns, as of any dict; ``table.rows`` is the number of rows.
    """

    @classmethod
    def from_rows(cls, rows: Iterable[Mapping[str, Any]]) -> Table:
        """One row per mapping. Nested mappings give columns joined by ``_``; lists (histograms) are left out. None
        where another row has a nested mapping gives no column of its own."""
        nested: set[str] = set()
        flat = [dict(_flatten(_row(row), nested)) for row in rows]
        names = dict.fromkeys(
            name for row in flat for name, value in row.items() if value is not None or name not in nested
        )
        return cls({name: _column([row.get(name) for row in flat]) for name in names})

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self.values()), ()))

    def __missing__(self, name: object) -> NDArray[Any]:
        known = f"one of {', '.join(self)} is expected" if self else "the table has none"
        raise KeyError(f"there is no column {name!r}; {known}")

    def row(self, index: int) -> dict[str, Any]:
        """One row as a dict; -1 is the last one. Raises IndexError."""
        last = self.rows - 1
        arguments.whole("index", index, "the number of a row", -(2**63), 2**63 - 1)
        if not -self.rows <= index <= last:
            known = f"0 to {last} is expected" if self.rows else "the table has none"
            raise IndexError(f"index: there is no row {index}; {known}")
        return {name: column[index] for name, column in self.items()}

    def to_pandas(self) -> pandas.DataFrame:
        """The table as a DataFrame. Raises ImportError where pandas is not installed."""
        made: pandas.DataFrame = needed("pandas", "pandas", "to_pandas").DataFrame(dict(self))
        return made

    def __repr__(self) -> str:
        return f"Table({self.rows} rows: {', '.join(map(str, self))})"


def _row(row: object) -> Mapping[str, Any]:
    if not isinstance(row, Mapping):
        arguments.refuse("rows", row, "a dictionary for each row")
    return row


def _flatten(row: Mapping[str, Any], nested: set[str], prefix: str = "") -> Iterable[tuple[str, Any]]:
    """Columns and values of a row. The names of its nested mappings are added to ``nested``."""
    for name, value in row.items():
        if isinstance(value, Mapping):
            nested.add(prefix + name)
            yield from _flatten(value, nested, f"{prefix}{name}_")
        elif not isinstance(value, list):
            yield prefix + name, value


def _column(values: Sequence[Any]) -> NDArray[Any]:
    if any(isinstance(value, str) for value in values):
        return np.array(values)
    numbers = [math.nan if value is None else value for value in values]
    column = np.array(numbers)
    changed = column.dtype.kind == "f" and any(
        isinstance(own, int) and own != made for own, made in zip(numbers, column.tolist(), strict=True)
    )
    return np.array(numbers, dtype=object) if changed else column
