"""Deformation over wheel speed, from a sweep of co-simulations, and the crossings of the linear Campbell diagram."""

from .crossings import Crossing, find_crossings
from .sweep import Waterfall, sweep

__all__ = ["Crossing", "Waterfall", "find_crossings", "sweep"]
