"""Let a monitor look at the recorded rows of a run, block by block, and note what it finds as events of the run."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from lockstep.results.column_values import column_values
from lockstep.system.component import Value
from lockstep.system.system import System


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """What a monitor found in the rows: an event, and the simulated time [s] at which it happened, not was noticed."""

    time: float
    event: str
    details: Mapping[str, object] = field(default_factory=dict)


class Monitor(Protocol):
    """Looks at the rows of one run in their order. How they are divided into blocks must not matter."""

    def rows(self, time: NDArray[np.float64], columns: Mapping[str, NDArray[Any]]) -> Iterable[Found]:
        """Return what these rows show; columns are by the names of the recorded signals."""

    def end(self) -> Iterable[Found]:
        """Return what is known when no more rows come."""

    def summary(self) -> Sequence[Mapping[str, object]]:
        """Return tables for run.toml: what was found, of each kind how often and when first."""


# Called with the system as it is simulated, the parameters that are set by component and name, and the names of the
# recorded signals; None: there is nothing to look at
Watch = Callable[[System, Mapping[str, Mapping[str, Value]], Sequence[str]], Monitor | None]


class Observed:
    """Give the blocks of a recorder to a monitor, and its findings to the events of the run."""

    def __init__(self, monitor: Monitor, add: Callable[..., None]) -> None:
        self._monitor, self._add = monitor, add

    def block(self, batch: pa.RecordBatch) -> None:
        """Look at a block of a run in memory."""
        self.note(self.look(column_values(batch.column(0)).copy(), _Columns(batch)))

    def look(self, time: NDArray[np.float64], columns: Mapping[str, NDArray[Any]]) -> list[Found]:
        """Return what rows show; it may be called in another thread, for some rows after others."""
        return list(self._monitor.rows(time, columns))

    def end(self) -> list[dict[str, object]]:
        """Note what is known at the end, and return the tables for run.toml."""
        self.note(self._monitor.end())
        return [dict(table) for table in self._monitor.summary()]

    def note(self, found: Iterable[Found]) -> None:
        """Add findings to the events of the run."""
        for one in found:
            self._add(one.event, time=one.time, **one.details)


class _Columns(Mapping[str, NDArray[Any]]):
    """The columns of a block by name, each copied when it is read: the memory of the block is used again."""

    def __init__(self, batch: pa.RecordBatch) -> None:
        self._batch = batch

    def __getitem__(self, name: str) -> NDArray[Any]:
        column = self._batch.column(self._batch.schema.get_field_index(name))
        return column_values(column).copy()

    def __iter__(self) -> Iterator[str]:
        return iter(self._batch.schema.names[1:])

    def __len__(self) -> int:
        return len(self._batch.schema.names) - 1
