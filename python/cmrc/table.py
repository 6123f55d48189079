"""Tables: columns of equal length under their names."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cmrc import arguments
from cmrc.extras import needed

if TYPE_CHECKING:
    import pandas


class Table(dict[str, NDArray[Any]]):
    """A dict of NumPy arrays of equal length, one per column. Missing numbers are NaN.

    ``len(table)`` is the number of columns, as of any dict; ``table.rows`` is the number of rows.
    """

    @classmethod
    def from_rows(cls, rows: Iterable[Mapping[str, Any]]) -> Table:
        """One row per mapping. Nested mappings give columns joined by ``_``; lists (histograms) are left out."""
        flat = [dict(_flatten(_row(row))) for row in rows]
        names = list(dict.fromkeys(name for row in flat for name in row))
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


def _flatten(row: Mapping[str, Any], prefix: str = "") -> Iterable[tuple[str, Any]]:
    for name, value in row.items():
        if isinstance(value, Mapping):
            yield from _flatten(value, f"{prefix}{name}_")
        elif not isinstance(value, list):
            yield prefix + name, value


def _column(values: Sequence[Any]) -> NDArray[Any]:
    if any(value is None for value in values) and not any(isinstance(value, str) for value in values):
        return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
    return np.array(values)
