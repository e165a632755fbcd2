"""The public entry: simulate a system in one call, or step it."""

from lockstep.simulation.options import NamedOptions, Progress, RunOptions
from lockstep.simulation.snapshot import Snapshot
from lockstep.simulation.stepped_run import Run
from lockstep.simulation.stepping import open
from lockstep.simulation.summary import RunSummary
from lockstep.simulation.system_of_fmus import as_system
from lockstep.simulation.whole_run import resume, simulate

__all__ = [
    "NamedOptions",
    "Progress",
    "Run",
    "RunOptions",
    "RunSummary",
    "Snapshot",
    "as_system",
    "open",
    "resume",
    "simulate",
]
