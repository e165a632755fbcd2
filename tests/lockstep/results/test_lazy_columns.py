"""Columns that are read when they are used: how often, and which."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from numpy.typing import NDArray

from lockstep import InputError, Signals
from lockstep.results.lazy_columns import LazyColumns
from lockstep.results.read import PARQUET, open_signals

NAMES = ("plant.x[1]", "plant.x[2]", "plant.x[10]", "plant.y")


@pytest.fixture
def asked() -> list[list[str]]:
    """Return a list to which each read adds its names."""
    return []


@pytest.fixture
def signals(asked: list[list[str]]) -> Signals:
    """Return signals whose columns are the places of their names."""

    def read(names: Sequence[str]) -> Mapping[str, NDArray[np.float64]]:
        asked.append(list(names))
        return {name: np.full(2, float(NAMES.index(name))) for name in names}

    nothing = dict.fromkeys(NAMES, "")
    columns = LazyColumns(NAMES, read)
    return Signals(time=np.array([0.0, 1.0]), columns=columns, units=nothing, descriptions=nothing)


def test_going_through_all_columns_reads_once_what_is_missing(signals: Signals, asked: list[list[str]]):
    assert signals["plant.x[2]"].tolist() == [1.0, 1.0]
    assert [(name, values[0]) for name, values in signals.items()] == list(zip(NAMES, range(4), strict=True))
    assert [values[0] for values in signals.values()] == [0.0, 1.0, 2.0, 3.0]

    assert asked == [["plant.x[2]"], ["plant.x[1]", "plant.x[10]", "plant.y"]]


def test_an_array_and_a_choice_are_read_at_once_and_nothing_else(signals: Signals, asked: list[list[str]]):
    assert signals.side_by_side(["plant.x[10]", "plant.x[1]"]).tolist() == [[2.0, 0.0], [2.0, 0.0]]
    assert signals["plant.x"].tolist() == [[0.0, 1.0, 2.0], [0.0, 1.0, 2.0]]
    with pytest.raises(InputError, match=r"plant\.x\[3\]: not recorded"):
        signals.side_by_side(["plant.x[1]", "plant.x[3]"])

    assert asked == [["plant.x[10]", "plant.x[1]"], ["plant.x[2]"]]


def test_a_file_that_lost_a_signal_is_refused_by_name(tmp_path: Path):
    def write(*names: str) -> None:
        pq.write_table(pa.table({name: [0.0, 1.0] for name in ("time", *names)}), tmp_path / PARQUET)

    write("plant.x", "plant.y")
    opened = open_signals(tmp_path)
    write("plant.y")

    assert opened["plant.y"].tolist() == [0.0, 1.0]
    with pytest.raises(InputError, match=r"signals\.parquet: has changed, plant\.x is gone; read it again"):
        opened["plant.x"]
