"""The pointing budget after ECSS-E-ST-60-10C: indices, requirements, and the split by source."""

from .evaluate import Budget, ErrorHistory, Windows, compute_budget, steady_error
from .requirements import Requirement, Verdict, judge, read_requirements
from .sections import section
from .split import Split, split_budget

__all__ = [
    "Budget",
    "ErrorHistory",
    "Requirement",
    "Split",
    "Verdict",
    "Windows",
    "compute_budget",
    "judge",
    "read_requirements",
    "section",
    "split_budget",
    "steady_error",
]
