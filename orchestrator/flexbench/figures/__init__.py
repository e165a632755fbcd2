"""Figures of the studies: each a function of results that returns a matplotlib figure, named for what it shows."""

from .drawing import save_figure
from .fine_pointing import fine_pointing_comparison
from .modes import mode_shapes
from .slew import slew_comparison

__all__ = ["fine_pointing_comparison", "mode_shapes", "save_figure", "slew_comparison"]
