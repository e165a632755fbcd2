"""The slew, both configurations, in nine panels as in the paper, and the torque of one wheel with its limit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from flexbench.runs import histories
from flexbench.runs.flown_design import FlownDesign
from flexbench.runs.metrics import SETTLED_FROM, after_slew
from flexbench.runs.slews import slews_of
from flexbench.studies.paper.published import ROWS
from flexsat.arrays import Array
from flexsat.parameters import ARCSECOND, DEGREE, RPM, ConfigurationName
from lockstep import Signals
from lockstep.errors import InputError

from .drawing import (
    LOOKS,
    PUBLISHED,
    STYLE,
    WIDTH,
    bin_edges,
    draw_line,
    draw_noisy,
    draw_published,
    make_logarithmic,
    span_runs,
)

BAND: dict[str, Any] = {"color": "#F0E442", "alpha": 0.25, "linewidth": 0.0}  # Okabe and Ito: yellow
MARK: dict[str, Any] = {"color": "0.45", "linewidth": 0.8, "linestyle": (0.0, (6.0, 2.0, 1.0, 2.0))}
REFERENCE: dict[str, Any] = {"color": "black", "linewidth": 1.0, "linestyle": (0.0, (1.0, 1.6)), "zorder": 3.0}
LIMIT: dict[str, Any] = {"linewidth": 0.8, "linestyle": (0.0, (2.0, 2.0)), "zorder": 1.0}
SETTLING: dict[str, Any] = {"marker": "v", "linestyle": "none", "markersize": 6.0}
Panel = Callable[[Axes, ConfigurationName, Signals, FlownDesign], None]


def slew_comparison(
    results: Mapping[ConfigurationName, Signals], designs: Mapping[ConfigurationName, FlownDesign]
) -> Figure:
    """Draw torque, cost, wheel speed, attitude, errors and deformation of the slew, configurations overlaid.

    Parameters
    ----------
    results : signals of a slew by configuration
    designs : of each configuration's FMUs that flew

    Raises
    ------
    InputError
        If there are no results, or the cost cannot be summed at the rate they were recorded.
    """
    if not results:
        raise InputError("slew_comparison: results must hold one configuration at least, got none")
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 10.4), layout="constrained")
        grid = figure.add_gridspec(4, 3)
        first = figure.add_subplot(grid[0, 0])
        others = [figure.add_subplot(grid[k // 3, k % 3], sharex=first) for k in range(1, 9)]
        panels = [first, *others, figure.add_subplot(grid[3, :], sharex=first)]
        times = sorted({time for signals in results.values() for time in _slew_times(signals)})
        for axes, (title, unit, draw, logarithmic) in zip(panels, PANELS, strict=True):
            for name, signals in results.items():
                draw(axes, name, signals, designs[name])
            if logarithmic:
                make_logarithmic(axes)
            axes.set(title=title, ylabel=unit)
            for time in times:
                axes.axvline(time, **MARK)
        for axes in panels[:-4]:
            axes.tick_params(labelbottom=False)
        for axes in panels[-4:]:
            axes.set_xlabel("time [s]")
        span_runs(first, results.values())
        figure.align_ylabels(panels)
        figure.legend(handles=_legend(results), loc="outside upper center", ncols=4)
    return figure


def _slew_times(signals: Signals) -> list[float]:
    """Return begin and end of each slew [s], of those that ended."""
    return [time for slew in slews_of(signals) for time in (slew.start, slew.end) if time is not None]


def _last_end(signals: Signals) -> float | None:
    slews = slews_of(signals)
    return slews[-1].end if slews else None


def _window(signals: Signals, design: FlownDesign) -> tuple[float, float]:
    """Return the time [s] that the rows of rate and deformation refer to, in the variant simulated."""
    rows = after_slew(design.variant)
    return rows.begin, rows.end if np.isfinite(rows.end) else float(signals.time[-1])


def _draw_published(axes: Axes, key: str, name: ConfigurationName, signals: Signals, start: float, end: float) -> None:
    if end <= float(signals.time[-1]) and start < end:  # else the run is too short
        draw_published(axes, "slew", key, name, (start, end), {"color": LOOKS[name].colour})


def _draw_reference(axes: Axes, time: Array, values: Array) -> None:
    draw_line(axes, time, values, "reference", REFERENCE)


def _torque(axes: Axes, name: ConfigurationName, signals: Signals, _: FlownDesign) -> None:
    draw_noisy(axes, signals.time, histories.torque_norm(signals), name, LOOKS[name].line)
    _draw_reference(axes, signals.time, histories.torque_norm(signals, histories.TORQUE_REFERENCE))


def _impulse(axes: Axes, name: ConfigurationName, signals: Signals, _: FlownDesign) -> None:
    draw_line(axes, signals.time, histories.torque_impulse(signals), name, LOOKS[name].line)
    _draw_reference(axes, signals.time, histories.torque_impulse(signals, histories.TORQUE_REFERENCE))


def _single(axes: Axes, name: ConfigurationName, signals: Signals, design: FlownDesign) -> None:
    """Draw the torque of the first wheel about x, and its limit."""
    wheel = int(np.argmax(np.abs(design.wheel_axis[:, 0])))
    torque = signals[histories.TORQUE][:, wheel]
    bins = [torque[start:end] for start, end in pairwise(bin_edges(len(torque)))]
    largest = [part[np.argmax(np.abs(part))] for part in bins]  # of each bin, so that no peak is lost
    times = [signals.time[start] for start, _ in pairwise(bin_edges(len(torque)))]
    draw_line(axes, np.array(times), np.array(largest), f"{name}, wheel {wheel + 1}", LOOKS[name].line)
    for sign in (-1.0, 1.0):
        axes.axhline(sign * design.torque_limit[wheel], **LIMIT, color=LOOKS[name].colour)


def _cost(axes: Axes, name: ConfigurationName, signals: Signals, design: FlownDesign) -> None:
    if design.cost is None:  # a controller of others has no weights
        return
    rows, look = histories.controller_rows(signals, design), LOOKS[name]
    total, control = (np.cumsum(part[rows]) for part in histories.lqr_cost(signals, design))
    draw_line(axes, signals.time[rows], total, f"{name}, total", look.line)
    draw_line(axes, signals.time[rows], control, f"{name}, control", look.line | {"linewidth": 0.7})
    end = float(signals.time[-1])
    if end > SETTLED_FROM:  # else the run is too short to be compared
        for key, width in (("total_cost", 1.5), ("control_cost", 0.7)):
            draw_published(axes, "slew", key, name, [end], {"color": look.colour, "markeredgewidth": width})


def _wheel_speed(axes: Axes, name: ConfigurationName, signals: Signals, design: FlownDesign) -> None:
    band = design.speed_band / RPM
    if not axes.patches and np.isfinite(band):  # the same for both
        axes.axhspan(-band, band, **BAND)
    line = LOOKS[name].line | {"linewidth": 0.7 * LOOKS[name].width}  # up to eleven
    deviation = histories.wheel_speed_deviation(signals, design) / RPM
    for wheel in np.flatnonzero(np.abs(design.wheel_axis[:, 0]) > 0.5):
        draw_line(axes, signals.time, deviation[:, wheel], f"{name}, wheel {wheel + 1}", line)


def _rotation(axes: Axes, name: ConfigurationName, signals: Signals, _: FlownDesign) -> None:
    draw_line(axes, signals.time, histories.rotation_about_x(signals) / DEGREE, name, LOOKS[name].line)
    reference = histories.rotation_about_x(signals, histories.ATTITUDE_REFERENCE)
    _draw_reference(axes, signals.time, reference / DEGREE)


def _pointing(axes: Axes, name: ConfigurationName, signals: Signals, _: FlownDesign) -> None:
    draw_noisy(axes, signals.time, histories.pointing_error(signals) / ARCSECOND, name, LOOKS[name].line)
    _draw_published(axes, "pointing_error", name, signals, SETTLED_FROM, float(signals.time[-1]))
    (row,) = [row for row in ROWS if row.key == "settling_time"]
    end = _last_end(signals)
    settled = np.inf if end is None else end + row.published_for(name)
    if settled < signals.time[-1]:
        look = PUBLISHED | SETTLING | {"color": LOOKS[name].colour}
        foot = axes.get_xaxis_transform()  # so that the mark does not count for the limits of the y axis
        axes.plot([settled], [0.02], transform=foot, label=f"published settling, {name}", **look)


def _rate(axes: Axes, name: ConfigurationName, signals: Signals, design: FlownDesign) -> None:
    draw_noisy(axes, signals.time, histories.rate_error(signals) / DEGREE, name, LOOKS[name].line)
    _draw_published(axes, "rate_error", name, signals, *_window(signals, design))


def _deformation(axes: Axes, name: ConfigurationName, signals: Signals, design: FlownDesign) -> None:
    draw_noisy(axes, signals.time, histories.deformation(signals) * 1e6, name, LOOKS[name].line)
    _draw_published(axes, "deformation", name, signals, *_window(signals, design))


def _bending(axes: Axes, name: ConfigurationName, signals: Signals, design: FlownDesign) -> None:
    true, reference = "plant.modal.displacement", "controller.reference.modal.displacement"
    place = int(np.argmax(np.abs(design.rotation[0][design.known_modes])))
    bending = histories.of_known_modes(signals, design, true)[:, place]
    draw_line(axes, signals.time, bending * 1e3, name, LOOKS[name].line)
    if reference in signals and place < signals[reference].shape[1]:
        _draw_reference(axes, signals.time, signals[reference][:, place] * 1e3)


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
    ("One wheel about x; dotted: its limit", "torque, largest of each interval [N·m]", _single, False),
)


def _legend(results: Mapping[ConfigurationName, Signals]) -> list[Line2D | Patch]:
    slews = [slew for signals in results.values() for slew in slews_of(signals)]
    lengths = sorted({f"{slew.end - slew.start:.1f}" for slew in slews if slew.end is not None})
    marks = [Line2D([], [], label=f"slew of {' and '.join(lengths)} s", **MARK)] if lengths else []
    return [
        *(Line2D([], [], label=name, **LOOKS[name].line) for name in results),
        Line2D([], [], label="reference", **REFERENCE),
        *marks,
        Patch(label="allowed wheel speed", **BAND),
        Line2D([], [], label="published", **(PUBLISHED | {"color": "0.3"})),
        Line2D([], [], label="published settling", **(PUBLISHED | SETTLING | {"color": "0.3"})),
        Patch(label="min-max envelope (line: RMS)", color="0.5", alpha=0.25, linewidth=0.0),
    ]
