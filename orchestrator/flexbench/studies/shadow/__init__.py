"""A shadow controller judged: torque residuals, and the closed loop before and after the hand-over."""

from .sections import section
from .study import Study, study

__all__ = ["Study", "section", "study"]
