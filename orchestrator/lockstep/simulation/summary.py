"""Key figures of a run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from lockstep.run.real_time_pacing import Pacer


@dataclass(frozen=True, slots=True, kw_only=True)
class RunSummary:
    """Key figures of a completed run."""

    folder: Path
    simulated_time: float  # [s]
    wall_time: float  # [s] of the loop, without start and end
    ticks: int
    rows: int  # recorded
    start_time: float = 0.0  # [s] simulated: that of the system, or of the checkpoint that it was started from
    pacer: Pacer | None = None  # how well real time was kept
    warnings: tuple[str, ...] = ()  # what was amended in the system file, and inputs that keep their start values
    terminated: str | None = None  # why it ended before the stop time, if a component asked for that
