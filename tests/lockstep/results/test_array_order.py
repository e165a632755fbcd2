"""Recorded arrays are read by number: of vectors and matrices whose columns stand in another order in the file."""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from numpy.testing import assert_array_equal

from lockstep import read_signals
from lockstep.results.signal_patterns import matching

SHUFFLED = ["c.p[10]", "c.x", "c.p[2]", "c.a[2,10]", "c.p[1]", "c.a[1,2]", "c.a[2,2]", "c.a[1,10]"]
VECTOR, MATRIX = ["c.p[1]", "c.p[2]", "c.p[10]"], ["c.a[1,2]", "c.a[1,10]", "c.a[2,2]", "c.a[2,10]"]


@pytest.fixture
def folder(tmp_path):
    """Return a run in which each signal is a constant: its position in SHUFFLED."""
    columns = [np.full(3, float(number)) for number in range(len(SHUFFLED))]
    pq.write_table(pa.table([np.arange(3.0), *columns], names=["time", *SHUFFLED]), tmp_path / "signals.parquet")
    return tmp_path


@pytest.mark.parametrize(("array", "elements"), [("c.p", VECTOR), ("c.a", MATRIX)])
def test_array_has_its_columns_in_numeric_row_major_order(folder, array, elements):
    expected = [SHUFFLED.index(name) for name in elements]

    assert_array_equal(read_signals(folder)[array][0], expected)
    assert list(read_signals(folder, [array]).columns) == elements
    assert array in read_signals(folder)


def test_all_columns_of_an_array_follow_each_other_by_number(folder):
    names = list(read_signals(folder).columns)

    assert [name for name in names if name.startswith("c.p")] == VECTOR
    assert [name for name in names if name.startswith("c.a")] == MATRIX
    assert names.index("c.x") == SHUFFLED.index("c.x")


def test_pattern_matches_elements_in_numeric_order():
    assert matching("c.p", SHUFFLED) == VECTOR
    assert matching("?.a", SHUFFLED) == MATRIX
    assert matching("c.a[2,*]", SHUFFLED) == ["c.a[2,2]", "c.a[2,10]"]
    assert matching("c.x*", SHUFFLED) == ["c.x"]
