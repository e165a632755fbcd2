"""The slew, both configurations, in nine panels as in the paper."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from flexbench import histories
from flexbench.scenarios import slew_end
from flexsat.design import Design
from flexsat.parameters import ARCSECOND, DEGREE, RPM, ConfigurationName
from lockstep import Signals

from .drawing import LOOKS, STYLE, WIDTH, Array, draw_line, draw_noisy, make_logarithmic, span_runs

BAND: dict[str, Any] = {"color": "#F0E442", "alpha": 0.25, "linewidth": 0.0}  # Okabe and Ito: yellow
MARK: dict[str, Any] = {"color": "0.45", "linewidth": 0.8, "linestyle": (0.0, (6.0, 2.0, 1.0, 2.0))}
REFERENCE: dict[str, Any] = {"color": "black", "linewidth": 1.0, "linestyle": (0.0, (1.0, 1.6)), "zorder": 3.0}
Panel = Callable[[Axes, ConfigurationName, Signals, Design], None]


def slew_comparison(
    results: Mapping[ConfigurationName, Signals], designs: Mapping[ConfigurationName, Design]
) -> Figure:
    """Draw torque, cost, wheel speed, attitude, errors and deformation of the slew, configurations overlaid.

    Parameters
    ----------
    results : signals of a slew by configuration
    designs : the variant of each configuration's design that was flown

    Raises
    ------
    ValueError
        If there are no results, or the cost cannot be summed at the rate they were recorded.
    """
    if not results:
        raise ValueError("slew_comparison: results must hold one configuration at least, got none")
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 8.2), layout="constrained")
        grid = figure.subplots(3, 3, sharex=True)
        for axes, (title, unit, draw, logarithmic) in zip(grid.flat, PANELS, strict=True):
            for name, signals in results.items():
                draw(axes, name, signals, designs[name])
            if logarithmic:
                make_logarithmic(axes)
            axes.set(title=title, ylabel=unit)
            for time in sorted({time for name in results for time in _slew_times(designs[name])}):
                axes.axvline(time, **MARK)
        for axes in grid[-1]:
            axes.set_xlabel("time [s]")
        span_runs(grid[0, 0], results.values())
        figure.align_ylabels(grid)
        figure.legend(handles=_legend(results), loc="outside upper center", ncols=6)
    return figure


def _slew_times(design: Design) -> tuple[float, float]:
    return design.config.slew.start_time, slew_end(design)


def _draw_reference(axes: Axes, time: Array, values: Array) -> None:
    draw_line(axes, time, values, "reference", REFERENCE)


def _torque(axes: Axes, name: ConfigurationName, signals: Signals, _: Design) -> None:
    draw_noisy(axes, signals.time, histories.torque_norm(signals), name, LOOKS[name].line)
    _draw_reference(axes, signals.time, histories.torque_norm(signals, histories.TORQUE_REFERENCE))


def _impulse(axes: Axes, name: ConfigurationName, signals: Signals, _: Design) -> None:
    draw_line(axes, signals.time, histories.torque_impulse(signals), name, LOOKS[name].line)
    _draw_reference(axes, signals.time, histories.torque_impulse(signals, histories.TORQUE_REFERENCE))


def _cost(axes: Axes, name: ConfigurationName, signals: Signals, design: Design) -> None:
    rows, look = histories.controller_rows(signals, design), LOOKS[name]
    total, control = (np.cumsum(part[rows]) for part in histories.lqr_cost(signals, design))
    draw_line(axes, signals.time[rows], total, f"{name}, total", look.line)
    draw_line(axes, signals.time[rows], control, f"{name}, control", look.line | {"linewidth": 0.7})


def _wheel_speed(axes: Axes, name: ConfigurationName, signals: Signals, design: Design) -> None:
    band = design.config.wheel.speed_band / RPM
    if not axes.patches:  # the same for both
        axes.axhspan(-band, band, **BAND)
    line = LOOKS[name].line | {"linewidth": 0.7 * LOOKS[name].width}  # up to eleven
    deviation = histories.wheel_speed_deviation(signals, design) / RPM
    for wheel in np.flatnonzero(np.abs(design.spacecraft.wheels.axis[:, 0]) > 0.5):
        draw_line(axes, signals.time, deviation[:, wheel], f"{name}, wheel {wheel + 1}", line)


def _rotation(axes: Axes, name: ConfigurationName, signals: Signals, _: Design) -> None:
    draw_line(axes, signals.time, histories.rotation_about_x(signals) / DEGREE, name, LOOKS[name].line)
    reference = histories.rotation_about_x(signals, histories.ATTITUDE_REFERENCE)
    _draw_reference(axes, signals.time, reference / DEGREE)


def _pointing(axes: Axes, name: ConfigurationName, signals: Signals, _: Design) -> None:
    draw_noisy(axes, signals.time, histories.pointing_error(signals) / ARCSECOND, name, LOOKS[name].line)


def _rate(axes: Axes, name: ConfigurationName, signals: Signals, _: Design) -> None:
    draw_noisy(axes, signals.time, histories.rate_error(signals) / DEGREE, name, LOOKS[name].line)


def _deformation(axes: Axes, name: ConfigurationName, signals: Signals, _: Design) -> None:
    draw_noisy(axes, signals.time, histories.deformation(signals) * 1e6, name, LOOKS[name].line)


def _bending(axes: Axes, name: ConfigurationName, signals: Signals, design: Design) -> None:
    mode = int(np.argmax(np.abs(design.spacecraft.rotation[0])))
    true, reference = "plant.modal.displacement", "controller.reference.modal.displacement"
    draw_line(axes, signals.time, signals[true][:, mode] * 1e3, name, LOOKS[name].line)
    _draw_reference(axes, signals.time, signals[reference][:, mode] * 1e3)


# title, label of the y axis, what draws one configuration, whether logarithmic
PANELS: tuple[tuple[str, str, Panel, bool], ...] = (
    ("Wheel torque", "sum of |τ| over wheels [N·m]", _torque, False),
    ("Wheel torque, over time", "integral of sum of |τ| [N·m·s]", _impulse, False),
    ("LQR cost; thin: control part", "sum over samples [1]", _cost, True),
    ("Wheels about x", "speed less nominal [rpm]", _wheel_speed, False),
    ("Rotation about x", "angle [deg]", _rotation, False),
    ("Pointing error", "to reference [arcsec]", _pointing, True),
    ("Angular rate error", "to reference [deg/s]", _rate, True),
    ("Deformation", "RMS over aperture [µm]", _deformation, True),
    ("Bending mode about x", r"displacement [$10^{-3}$ m·kg$^{1/2}$]", _bending, False),
)


def _legend(results: Mapping[ConfigurationName, Signals]) -> list[Line2D | Patch]:
    return [
        *(Line2D([], [], label=name, **LOOKS[name].line) for name in results),
        Line2D([], [], label="reference", **REFERENCE),
        Line2D([], [], label="slew starts, ends", **MARK),
        Patch(label="allowed wheel speed", **BAND),
        Patch(label="least to largest (line: RMS)", color="0.5", alpha=0.25, linewidth=0.0),
    ]
