"""The public entry: simulate a system in one call, or step it."""

from lockstep.simulation.options import NamedOptions, Progress, RunOptions
from lockstep.simulation.summary import RunSummary
from lockstep.simulation.whole_run import resume, simulate

__all__ = ["NamedOptions", "Progress", "RunOptions", "RunSummary", "resume", "simulate"]
