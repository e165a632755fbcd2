"""Columns by name that are read when they are used first, each once."""

from collections.abc import Callable, ItemsView, Iterator, Mapping, Sequence, ValuesView
from typing import Any

import numpy as np
from numpy.typing import NDArray

ReadColumns = Callable[[Sequence[str]], Mapping[str, NDArray[np.float64]]]


class LazyColumns(Mapping[str, NDArray[np.float64]]):
    """The columns of these names; `read` returns some of them. What was read is not pickled."""

    def __init__(self, names: Sequence[str], read: ReadColumns) -> None:
        self._names, self._read = dict.fromkeys(names), read
        self._columns: dict[str, NDArray[np.float64]] = {}

    def load(self, names: Sequence[str]) -> None:
        """Read several columns at once, which is quicker than one by one."""
        missing = [name for name in names if name not in self._columns]
        if missing:
            self._columns.update(self._read(missing))

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        if name not in self._columns:
            if name not in self._names:
                raise KeyError(name)
            self.load([name])
        return self._columns[name]

    def items(self) -> ItemsView[str, NDArray[np.float64]]:
        """Return names and columns, all read at once."""
        self.load(list(self._names))
        return super().items()

    def values(self) -> ValuesView[NDArray[np.float64]]:
        """Return the columns, all read at once."""
        self.load(list(self._names))
        return super().values()

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __getstate__(self) -> dict[str, Any]:
        return {"_names": self._names, "_read": self._read, "_columns": {}}
