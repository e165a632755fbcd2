"""Fine pointing, both configurations, with the control loop closed and open."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from flexbench import histories
from flexsat.parameters import ARCSECOND, ConfigurationName
from lockstep import Signals

from .drawing import DASHED, LOOKS, SOLID, STYLE, WIDTH, Look, draw_line, draw_noisy, make_logarithmic, span_runs

ZOOM = 2.0  # s, at the end of the run: some turns of the slowest wheel
# lighter than with the loop closed, after Okabe and Ito (2008): sky blue, orange
OPEN_LOOKS: dict[ConfigurationName, Look] = {
    "centralised": Look(colour="#56B4E9", dashes=DASHED, width=1.3),
    "distributed": Look(colour="#E69F00", dashes=DASHED, width=1.3),
}
CLOSED_LOOKS: dict[ConfigurationName, Look] = {
    name: Look(colour=look.colour, dashes=SOLID, width=1.3) for name, look in LOOKS.items()
}


def fine_pointing_comparison(
    closed: Mapping[ConfigurationName, Signals], open_loop: Mapping[ConfigurationName, Signals]
) -> Figure:
    """Draw the pointing error of the whole run and the deformation of its last seconds.

    Parameters
    ----------
    closed, open_loop : signals of the two fine pointing scenarios by configuration

    Raises
    ------
    ValueError
        If there are no results.
    """
    if not closed and not open_loop:
        raise ValueError("fine_pointing_comparison: results must hold one run at least, got none")
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 3.9), layout="constrained")
        pointing, deformation = figure.subplots(1, 2)
        for results, looks, loop in ((open_loop, OPEN_LOOKS, "open loop"), (closed, CLOSED_LOOKS, "closed loop")):
            for name, signals in results.items():
                label, line, time = f"{name}, {loop}", looks[name].line, signals.time
                draw_noisy(pointing, time, histories.pointing_error(signals) / ARCSECOND, label, line)
                late = time >= time[-1] - ZOOM
                draw_line(deformation, time[late], histories.deformation(signals)[late] * 1e6, label, line)
        make_logarithmic(pointing)
        pointing.set(title="Pointing error", ylabel="to reference [arcsec]")
        deformation.set(title=f"Deformation, last {ZOOM:g} s", ylabel="RMS over aperture [µm]")
        span_runs(pointing, (*closed.values(), *open_loop.values()))
        deformation.set_ylim(bottom=0.0)
        deformation.margins(x=0.0)
        deformation.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 5, 10]))
        for axes in (pointing, deformation):
            axes.set_xlabel("time [s]")
        figure.legend(*pointing.get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return figure
