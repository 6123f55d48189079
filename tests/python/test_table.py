"""Tables: columns from rows."""

import numpy as np
import pytest
from cmrc.table import Table

ROWS = [
    {"kind": "pid", "released": 10, "response_ps": {"p50": 5, "log2_histogram": [1, 2]}, "delivered_s": None},
    {"kind": "identify", "released": 2, "response_ps": {"p50": 7, "log2_histogram": []}, "delivered_s": 81.5},
]


def test_columns_are_flat_and_typed() -> None:
    table = Table.from_rows(ROWS)
    assert list(table) == ["kind", "released", "response_ps_p50", "delivered_s"]
    assert table.rows == 2
    assert table["released"].dtype.kind == "i"
    assert list(table["response_ps_p50"]) == [5, 7]
    assert np.isnan(table["delivered_s"][0])
    assert table["delivered_s"][1] == 81.5
    assert table.row(1)["kind"] == "identify"


def test_rows_are_counted_from_either_end() -> None:
    table = Table.from_rows(ROWS)
    assert [table.row(n)["kind"] for n in (0, 1, -1, -2)] == ["pid", "identify", "identify", "pid"]
    for n in (2, -3):
        with pytest.raises(IndexError, match=f"there is no row {n}; 0 to 1 is expected"):
            table.row(n)


def test_pandas() -> None:
    pytest.importorskip("pandas")
    frame = Table.from_rows(ROWS).to_pandas()
    assert frame.loc[frame.kind == "pid", "released"].item() == 10


def test_no_rows() -> None:
    empty = Table.from_rows([])
    assert empty.rows == 0
    with pytest.raises(IndexError, match="^index: there is no row 0; the table has none$"):
        empty.row(0)
    with pytest.raises(KeyError, match="there is no column 'misses'; the table has none"):
        empty["misses"]
    with pytest.raises(KeyError, match="there is no column 'misses'; one of kind, "):
        Table.from_rows(ROWS)["misses"]


BIG = 2**53 + 1


def test_a_whole_number_that_no_float_can_hold_stays_what_it_is() -> None:
    table = Table.from_rows([{"seed": BIG, "few": 3}, {"seed": None, "few": None}, {"seed": 0.5}])
    assert table["seed"].dtype == object and table["seed"][0] == BIG and np.isnan(table["seed"][1])
    assert table["few"].dtype == np.float64 and table["few"][0] == 3 and np.isnan(table["few"][2])
    assert Table.from_rows([{"seed": BIG}])["seed"].dtype == np.int64


def test_nothing_beside_a_nested_mapping_is_no_column() -> None:
    table = Table.from_rows([{"errors": {"rms": 1.5}, "first": None}, {"errors": None, "first": None}])
    assert list(table) == ["errors_rms", "first"] and np.isnan(table["errors_rms"][1])
    assert list(Table.from_rows([{"errors": {"rms": 1}}, {"errors": 2}])) == ["errors_rms", "errors"]
