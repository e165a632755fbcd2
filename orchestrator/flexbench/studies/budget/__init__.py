"""The pointing budget after ECSS-E-ST-60-10C: indices, requirements, and the split by source."""

from .evaluate import Budget, ErrorHistory, Windows, compute_budget, steady_error
from .requirements import Assessment, Requirement, judge, read_requirements
from .split import Split, split_budget

__all__ = [
    "Assessment",
    "Budget",
    "ErrorHistory",
    "Requirement",
    "Split",
    "Windows",
    "compute_budget",
    "judge",
    "read_requirements",
    "split_budget",
    "steady_error",
]
