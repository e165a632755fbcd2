"""Figures of the study of margins: Nichols and Nyquist charts, singular values of S and T, coherence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexsat.arrays import Array
from lockstep.errors import InputError

from ..studies.margins.stability_table import gains_of
from ..studies.margins.study import Curve, curves
from .drawing import STYLE, WIDTH
from .palette import PALETTE

GAIN_SHOWN = 40.0  # dB either side of one


def nichols_chart(loops: Sequence[Curve], disk: float | None = None) -> Figure:
    """Draw open loops, gain over phase, with the critical point; measured ones as points with their uncertainty.

    Parameters
    ----------
    loops : computed and measured
    disk : disk margin whose boundary is drawn; None for none

    Raises
    ------
    InputError
        If there are no loops.
    """
    if not loops:
        raise InputError("nichols_chart: there must be one loop at least, got none")
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 4.8), layout="constrained")
        left, right = figure.subplots(1, 2)
        for loop, colour in zip(loops, _colours(loops), strict=True):
            decibel = 20.0 * np.log10(np.abs(loop.values) + 1e-300)
            phase = np.degrees(np.angle(loop.values))
            phase = np.where(phase > 0.0, phase - 360.0, phase)  # from -360 to 0: the critical point in the middle
            if loop.uncertainty is None:
                gap = np.abs(np.diff(phase, append=phase[-1])) > 180.0
                left.plot(np.where(gap, np.nan, phase), decibel, color=colour, linewidth=1.0, label=loop.name)
                right.plot(loop.values.real, loop.values.imag, color=colour, linewidth=1.0)
            else:
                share = np.minimum(loop.uncertainty / np.abs(loop.values), 0.99)
                left.errorbar(phase, decibel, xerr=np.degrees(np.arcsin(share)), yerr=20.0 * np.log10(1.0 + share),
                              fmt="o", markersize=3.0, elinewidth=0.8, color=colour, label=loop.name)  # fmt: skip
                right.plot(loop.values.real, loop.values.imag, "o", markersize=3.0, color=colour)
        left.plot(-180.0, 0.0, "P", color="black", markersize=7.0, label="critical point")
        right.plot(-1.0, 0.0, "P", color="black", markersize=7.0)
        if disk is not None and 0.0 < disk < 2.0:
            _draw_disk(left, right, disk)
        left.set(title="Nichols chart of the open loop", xlabel="phase [deg]", ylabel="gain [dB]")
        left.set_xlim(-360.0, 0.0)
        left.set_xticks(range(-360, 1, 45))
        left.set_ylim(-GAIN_SHOWN, GAIN_SHOWN)
        right.set(title="Nyquist diagram near -1", xlabel="real part [1]", ylabel="imaginary part [1]")
        right.set_xlim(-3.0, 2.0)
        right.set_ylim(-2.5, 2.5)
        right.set_aspect("equal")
        figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def sensitivity_singular_values(frequency: Array, largest_s: Array, largest_t: Array) -> Figure:
    """Draw the largest singular values of S and T over frequency, with their peaks.

    Parameters
    ----------
    frequency : (f,) [Hz]
    largest_s, largest_t : (f,)
    """
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 3.6), layout="constrained")
        axes = figure.subplots()
        for values, colour, name in ((largest_s, PALETTE[0], "S"), (largest_t, PALETTE[1], "T")):
            decibel = 20.0 * np.log10(values)
            peak = int(np.argmax(values))
            label = f"largest singular value of {name}, peak {decibel[peak]:.1f} dB at {frequency[peak]:.2f} Hz"
            axes.semilogx(frequency, decibel, color=colour, linewidth=1.3, label=label)
            axes.plot(frequency[peak], decibel[peak], "o", color=colour, markersize=4.0)
        axes.set(title="Sensitivity at the plant input", xlabel="frequency [Hz]", ylabel="gain [dB]")
        axes.set_ylim(bottom=-40.0)
        axes.margins(x=0.0)
        axes.legend(loc="lower left")
    return figure


def measurement_coherence(frequency: Array, coherence: Mapping[str, Array], least: float) -> Figure:
    """Draw, for each direction, 1 - coherence: the share that does not repeat; lines of coherence `least` count."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 3.0), layout="constrained")
        axes = figure.subplots()
        for (name, values), colour in zip(coherence.items(), PALETTE * len(coherence), strict=False):
            axes.loglog(frequency, np.maximum(1.0 - np.asarray(values), 1e-12), "o-", color=colour, markersize=2.5,
                        linewidth=0.8, label=name)  # fmt: skip
        axes.axhline(1.0 - least, color="black", linewidth=0.8, label="lines below count")
        axes.set(title="Coherence of the measurement", xlabel="frequency [Hz]", ylabel="1 - coherence [1]")
        axes.legend(loc="best", ncols=4)
    return figure


def stability_map(rows: Sequence[Mapping[str, Any]]) -> Figure:
    """Draw where a design is stable over the modes of the plant and the gain, with the growth rate where it is not."""
    return stability_maps({"Stability over the plant's modes and gain": rows})


def stability_maps(designs: Mapping[str, Sequence[Mapping[str, Any]]]) -> Figure:
    """Draw the maps of some designs below each other, by title."""
    heights = [1.0 + 0.3 * len({row["modes"] for row in rows}) for rows in designs.values()]
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 0.2 + sum(heights)), layout="constrained")
        panels = figure.subplots(len(designs), 1, squeeze=False, gridspec_kw={"height_ratios": heights})
        for axes, (title, rows) in zip(panels[:, 0], designs.items(), strict=True):
            _draw_map(axes, title, rows)
    return figure


def _draw_map(axes: Axes, title: str, rows: Sequence[Mapping[str, Any]]) -> None:
    modes, gains = sorted({row["modes"] for row in rows}), gains_of(rows)
    growth = {(row["modes"], row["gain"]): row["growth"] for row in rows}
    unstable = np.array([[growth[count, gain] >= 0.0 for gain in gains] for count in modes], dtype=float)
    axes.pcolormesh(np.arange(len(gains) + 1), np.arange(len(modes) + 1), unstable, cmap="Reds", vmin=0.0, vmax=2.0,
                    edgecolors="0.8", linewidth=0.5)  # fmt: skip
    for row, count in enumerate(modes):
        for column, gain in enumerate(gains):
            rate = growth[count, gain]
            text = "stable" if rate < 0.0 else f"{rate:+.{0 if rate >= 10.0 else 2}{'f' if rate >= 10.0 else 'g'}}/s"
            axes.text(column + 0.5, row + 0.5, text, ha="center", va="center")
    axes.set_xticks(np.arange(len(gains)) + 0.5, [f"{20.0 * np.log10(gain):+.3g}" for gain in gains])
    axes.set_yticks(np.arange(len(modes)) + 0.5, [f"{count:g}" for count in modes])
    axes.set(title=title, xlabel="gain [dB]", ylabel="modes of the plant [1]")
    axes.grid(visible=False)


def margin_figures(content: Mapping[str, Any], least: float) -> dict[str, Figure]:
    """Return every figure that a study has data for, by file name."""
    drawn = {}
    loops = curves(content)
    design = content.get("analysis")
    if "stability" in content and content["stability"]["grid"]:
        drawn["stability"] = stability_map(content["stability"]["grid"])
    if loops:
        disk = design["margins"]["all wheels"]["disk"] if design else None
        drawn["nichols"] = nichols_chart(loops, disk)
    if design:
        values = (np.array(design[name]) for name in ("frequency", "largest_s", "largest_t"))
        drawn["sensitivity"] = sensitivity_singular_values(*values)
    if "measured" in content:
        measured = content["measured"]
        frequency = np.array(measured["frequency"])
        drawn["coherence"] = measurement_coherence(frequency, measured["coherence"], least)
    return drawn


def _colours(loops: Sequence[Curve]) -> list[str]:
    """Return a colour for each loop, the same for the computed and the measured loop of a name."""
    names = [loop.name.partition(": ")[2].removeprefix("axis ") for loop in loops]
    known = {name: PALETTE[k % len(PALETTE)] for k, name in enumerate(dict.fromkeys(names))}
    return [known[name] for name in names]


def _draw_disk(left: Axes, right: Axes, disk: float) -> None:
    """Draw the loops for which some factor of the disk closes on -1: -1 over the disk's boundary."""
    turn = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 361))
    boundary = -(1.0 - 0.5 * disk * turn) / (1.0 + 0.5 * disk * turn)
    phase = np.degrees(np.angle(boundary)) % 360.0 - 360.0
    label = f"disk margin {disk:.2f}, all wheels"
    left.plot(phase, 20.0 * np.log10(np.abs(boundary)), color="0.4", linestyle="--", linewidth=0.9, label=label)
    right.plot(boundary.real, boundary.imag, color="0.4", linestyle="--", linewidth=0.9)
