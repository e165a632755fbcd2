"""The result of a run: key figures, and its signals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lockstep.results.read import Signals, open_signals
from lockstep.run.loop_time import LoopTime
from lockstep.run.real_time_pacing import Pacer


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class RunSummary(Mapping[str, NDArray[Any]]):
    """Key figures of a run that has ended, and a mapping of its signals: `summary["plant.rate"]`.

    Signals of a run with a folder are read from there when they are used first.
    """

    folder: Path | None  # None: the signals are in memory alone
    simulated_time: float  # [s]
    wall_time: float  # [s] of the loop, without start and end
    ticks: int
    rows: int  # recorded
    size: int = 0  # bytes of the recorded signals on disk
    loop_time: LoopTime | None = None  # where the wall time of the loop went
    start_time: float = 0.0  # [s] simulated: that of the system, or of the checkpoint that it was started from
    pacer: Pacer | None = None  # how well real time was kept
    warnings: tuple[str, ...] = ()  # what was amended in the system file, and inputs that keep their start values
    terminated: str | None = None  # why it ended before the stop time, if a component asked for that
    in_memory: Signals | None = field(default=None, repr=False)

    @cached_property
    def signals(self) -> Signals:
        """The recorded signals. Raises InputError if they cannot be read from the folder any more."""
        if self.in_memory is not None:
            return self.in_memory
        assert self.folder is not None
        return open_signals(self.folder)

    @property
    def time(self) -> NDArray[np.float64]:
        """The times [s] of the recorded rows."""
        return self.signals.time

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Return a signal, (n,), or an array of signals, (n, elements)."""
        return self.signals[name]

    def get(self, name: str, default: Any = None) -> Any:
        """Return a signal or an array of signals, or the default if it was not recorded."""
        return self.signals.get(name, default)

    def __contains__(self, name: object) -> bool:
        """Return whether a signal, or an array of signals, was recorded."""
        return name in self.signals

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the signals."""
        return iter(self.signals)

    def __len__(self) -> int:
        """Return the number of signals."""
        return len(self.signals)

    def __bool__(self) -> bool:
        """Return True, also where nothing was recorded."""
        return True

    def __repr__(self) -> str:
        """Describe the run in one line."""
        where = "in memory" if self.folder is None else f"in {self.folder}"
        ended = f"; terminated: {self.terminated}" if self.terminated else ""
        return f"<RunSummary: {self.simulated_time:.9g} s in {self.ticks} ticks, {self.rows} rows {where}{ended}>"

    def _ipython_key_completions_(self) -> list[str]:
        """Return what Tab offers between the brackets."""
        return self.signals._ipython_key_completions_()
