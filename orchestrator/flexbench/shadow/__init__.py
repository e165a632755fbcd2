"""A shadow controller judged: torque residuals, and the closed loop before and after the hand-over."""

from .study import Study, study
from .tell import section

__all__ = ["Study", "section", "study"]
