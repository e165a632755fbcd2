"""Figures of the studies: each a function of results that returns a matplotlib figure, named for what it shows."""

from .architecture import architecture_diagram
from .campbell import campbell_diagram
from .drawing import save_figure
from .figure_lists import design_figures, result_figures, save_figures
from .fine_pointing import fine_pointing_comparison
from .modes import mode_shapes
from .slew import slew_comparison
from .structure import structure_layout
from .wheels import wheel_responses

__all__ = [
    "architecture_diagram",
    "campbell_diagram",
    "design_figures",
    "fine_pointing_comparison",
    "mode_shapes",
    "result_figures",
    "save_figure",
    "save_figures",
    "slew_comparison",
    "structure_layout",
    "wheel_responses",
]
