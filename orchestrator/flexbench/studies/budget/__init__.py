"""The pointing budget after ECSS-E-ST-60-10C: indices, requirements, and the split by source."""

from .evaluate import Budget, ErrorHistory, IndexWindows, compute_budget, steady_error
from .requirements import Assessment, PointingRequirement, judge, read_requirements
from .split import Split, split_budget

__all__ = [
    "Assessment",
    "Budget",
    "ErrorHistory",
    "IndexWindows",
    "PointingRequirement",
    "Split",
    "compute_budget",
    "judge",
    "read_requirements",
    "split_budget",
    "steady_error",
]
