"""A shadow controller judged: torque residuals, and the closed loop before and after the switchover."""

from .study import Study, study

__all__ = ["Study", "study"]
