"""Fine pointing, both configurations, with the control loop closed and open."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from flexbench.loop.scenarios import ScenarioName
from flexbench.runs import histories
from flexbench.runs.metrics import SETTLED_FROM
from flexsat.parameters import ARCSECOND, ConfigurationName
from lockstep import Signals
from lockstep.errors import InputError

from .drawing import (  # fmt: skip
    DASHED,
    LOOKS,
    MICROMETRE,
    PUBLISHED,
    SOLID,
    STYLE,
    WIDTH,
    Look,
    draw_line,
    draw_noisy,
    draw_published,
    make_logarithmic,
    span_runs,
)
from .palette import BLUE, ORANGE, SKY_BLUE

MILLI = "to reference [$10^{-3}$ arcsec]"
ERROR, DEFORMATION = "Pointing error", "Deformation"  # titles of panels
ZOOM = 2.0  # s, at the end of the run: some turns of the slowest wheel
# lighter than with the loop closed
OPEN_LOOKS: dict[ConfigurationName, Look] = defaultdict(
    lambda: Look(colour=SKY_BLUE, dashes=DASHED, width=1.3),
    {
        "centralised": Look(colour=SKY_BLUE, dashes=DASHED, width=1.3),
        "distributed": Look(colour=ORANGE, dashes=DASHED, width=1.3),
    },
)
CLOSED_LOOKS: dict[ConfigurationName, Look] = defaultdict(
    lambda: Look(colour=BLUE, dashes=SOLID, width=1.3),
    {name: Look(colour=look.colour, dashes=SOLID, width=1.3) for name, look in LOOKS.items()},
)
SCENARIO_LOOKS: tuple[tuple[ScenarioName, str, Mapping[ConfigurationName, Look]], ...] = (
    ("fine_pointing_open_loop", "open loop", OPEN_LOOKS),
    ("fine_pointing", "closed loop", CLOSED_LOOKS),
)


def fine_pointing_comparison(
    closed: Mapping[ConfigurationName, Signals], open_loop: Mapping[ConfigurationName, Signals]
) -> Figure:
    """Draw pointing error and deformation, of the whole run and of its last seconds; there the error less its mean.

    The published RMS values stand over the time that they refer to; the paper gives none for the pointing error with
    the loop open.

    Parameters
    ----------
    closed, open_loop : signals of the two fine pointing scenarios by configuration

    Raises
    ------
    InputError
        If there are no results.
    """
    if not closed and not open_loop:
        raise InputError("fine_pointing_comparison: results must hold one run at least, got none")
    results: dict[ScenarioName, Mapping[ConfigurationName, Signals]] = {
        "fine_pointing": closed,
        "fine_pointing_open_loop": open_loop,
    }
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 6.4), layout="constrained")
        grid = figure.subplots(2, 2)
        for scenario, loop, looks in SCENARIO_LOOKS:
            for name, signals in results[scenario].items():
                _draw_run(grid, signals, f"{name}, {loop}", looks[name])
                _draw_published(grid[:, 0], scenario, name, float(signals.time[-1]), looks[name].colour)
        make_logarithmic(grid[0, 0])
        grid[0, 0].set(title=ERROR, ylabel="to reference [arcsec]")
        grid[0, 1].set(title=f"{ERROR}, last {ZOOM:g} s, less its mean", ylabel=MILLI)
        grid[1, 0].set(title=DEFORMATION, ylabel="RMS over aperture [µm]")
        grid[1, 1].set(title=f"{DEFORMATION}, last {ZOOM:g} s", ylabel="RMS over aperture [µm]")
        for axes in grid[1]:
            axes.set_ylim(bottom=0.0)
            axes.set_xlabel("time [s]")
        for axes in grid[:, 0]:
            span_runs(axes, (*closed.values(), *open_loop.values()))
        for axes in grid[:, 1]:
            axes.margins(x=0.0)
            axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 5, 10]))
        figure.legend(handles=_legend(results), loc="outside upper center", ncols=4)
    return figure


def _draw_run(grid: NDArray[np.object_], signals: Signals, label: str, look: Look) -> None:
    time, late = signals.time, signals.time >= signals.time[-1] - ZOOM
    error, deformation = histories.pointing_error(signals) / ARCSECOND, histories.deformation(signals) / MICROMETRE
    draw_noisy(grid[0, 0], time, error, label, look.line)
    draw_line(grid[0, 1], time[late], 1e3 * (error[late] - error[late].mean()), label, look.line)
    draw_noisy(grid[1, 0], time, deformation, label, look.line)
    draw_line(grid[1, 1], time[late], deformation[late], label, look.line)


def _draw_published(
    panels: NDArray[np.object_], scenario: ScenarioName, name: ConfigurationName, end: float, colour: str
) -> None:
    if end <= SETTLED_FROM:
        return
    pointing, deformation = panels
    marker = "D" if scenario == "fine_pointing" else "s"
    look = {"color": colour, "marker": marker, "markersize": 4.2 if marker == "D" else 6.5}
    if scenario == "fine_pointing":
        draw_published(pointing, scenario, "pointing_error", name, (SETTLED_FROM, end), look)
    draw_published(deformation, scenario, "deformation", name, (SETTLED_FROM, end), look)


def _legend(results: Mapping[ScenarioName, Mapping[ConfigurationName, Signals]]) -> list[Line2D | Patch]:
    lines = [
        Line2D([], [], label=f"{name}, {loop}", **looks[name].line)
        for scenario, loop, looks in SCENARIO_LOOKS
        for name in results[scenario]
    ]
    return [
        *lines,
        Line2D([], [], label="published RMS, closed loop", **(PUBLISHED | {"color": "0.3"})),
        Line2D([], [], label="open loop", **(PUBLISHED | {"color": "0.3", "marker": "s", "markersize": 6.5})),
        Patch(label="min-max envelope (line: RMS)", color="0.5", alpha=0.25, linewidth=0.0),
    ]
