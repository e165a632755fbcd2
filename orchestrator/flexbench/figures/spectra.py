"""Spectra of a run: density and cumulative spectrum of pointing error, rate error, deformation and torque."""

from __future__ import annotations

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from flexbench.studies.spectra.channels import CHANNELS, Channel, RunSpectra
from flexbench.studies.spectra.welch import Spectrum
from flexsat.arrays import Array
from flexsat.design.chain import Design
from flexsat.spacecraft.campbell_crossings import modal_frequencies

from .drawing import AXES, STYLE, WIDTH
from .palette import PURPLE

POINTS = 500  # across a panel
DECADES = 10.0  # of a density axis, at most
TOTAL = "0.15"
MODE, WHEEL = "0.75", PURPLE  # marks on the frequency axis


def spectra_figure(result: RunSpectra, design: Design) -> Figure:
    """Draw one row a quantity: density with its confidence band on the left, cumulative RMS on the right.

    Ticks at the bottom are the modes of the free spacecraft, at the top the chosen wheel speeds. The band belongs to
    the sum over the components, as if it were one component, which is on the safe side.
    """
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 2.3 * len(CHANNELS)), layout="constrained")
        grid = figure.subplots(len(CHANNELS), 2, sharex="col")
        modes = modal_frequencies(design.structure, np.array([float(design.response.nominal.mean())]))[:, 0]
        wheels = np.unique(np.round(design.response.nominal / (2.0 * np.pi), 6))
        for (left, right), channel in zip(grid, CHANNELS, strict=True):
            spectrum = result.spectra[channel.name]
            _draw_density(left, channel, spectrum)
            _draw_cumulative(right, channel, spectrum)
            for axes in (left, right):
                _mark(axes, modes / (2.0 * np.pi), wheels)
        for axes in grid[-1]:
            axes.set_xlabel("frequency [Hz]")
        method = result.spectra[CHANNELS[0].name].method
        grid[0, 0].set_xlim(method.resolution, 0.5 / method.interval)
        grid[0, 1].set_xlim(1.0 / result.duration, 0.5 / method.interval)
        figure.suptitle(
            f"t = {result.start:g} s to {result.start + result.duration:g} s. {method.describe()}\n"
            "Ticks: below modes of the free spacecraft, above chosen wheel speeds.",
            fontsize=7.5, x=0.01, ha="left",
        )  # fmt: skip
        figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=5)
    return figure


def thinned(frequency: Array, values: Array, points: int = POINTS) -> tuple[Array, Array]:
    """Return fewer points on a logarithmic axis, two a bin: its minimum and maximum. No peak is lost."""
    inside = np.flatnonzero(frequency > 0.0)
    if len(inside) <= points:
        return frequency[inside], values[inside]
    logs = np.log(frequency[inside])
    bins = np.floor((logs - logs[0]) / (logs[-1] - logs[0]) * (points // 2 - 1e-9)).astype(int)
    keep: set[int] = set()
    for group in np.split(inside, np.flatnonzero(np.diff(bins)) + 1):
        keep |= {int(group[np.argmin(values[group])]), int(group[np.argmax(values[group])])}
    rows = sorted(keep)
    return frequency[rows], values[rows]


def _draw_density(axes: Axes, channel: Channel, spectrum: Spectrum) -> None:
    scale = channel.display_scale**2
    low, high = spectrum.method.bounds()
    for number, name in enumerate(channel.components):
        axes.plot(
            *thinned(spectrum.frequency, spectrum.density[:, number] / scale),
            color=AXES[name].colour, linewidth=0.7, label=name,
        )  # fmt: skip
    frequency, total = thinned(spectrum.frequency, spectrum.total / scale)
    axes.fill_between(frequency, low * total, high * total, color=TOTAL, alpha=0.18, linewidth=0.0,
                      label=f"{100.0 * spectrum.method.level:g} % bounds")  # fmt: skip
    axes.plot(frequency, total, color=TOTAL, linewidth=0.9, label="sum")
    axes.set(xscale="log", title=channel.label, ylabel=f"density [{density_unit(channel.display_unit)}]")
    peak = float(total.max())
    if peak > 0.0:
        axes.set_yscale("log")
        axes.yaxis.set_minor_locator(NullLocator())  # ten decades: minor ticks would take half the drawing time
        axes.set_ylim(max(0.3 * float(total.min()), peak * 10.0**-DECADES), 3.0 * peak)


def _draw_cumulative(axes: Axes, channel: Channel, spectrum: Spectrum) -> None:
    rms = np.sqrt(spectrum.cumulative) / channel.display_scale
    axes.plot(*thinned(spectrum.cumulative_frequency, rms), color=TOTAL, linewidth=1.1, label="cumulative")
    axes.axhline(float(rms[-1]), color=TOTAL, linewidth=0.6, linestyle=(0.0, (4.0, 1.3)))
    axes.set(xscale="log", ylabel=f"RMS up to frequency [{channel.display_unit}]")
    axes.set_title(f"cumulative: RMS {rms[-1]:.3g} {channel.display_unit}")
    axes.set_ylim(0.0, 1.1 * float(rms[-1]) if rms[-1] > 0.0 else 1.0)


def density_unit(unit: str) -> str:
    """Return the unit of a density of a quantity in `unit`."""
    return f"{unit}²/Hz" if unit.isalpha() else f"({unit})²/Hz"


def _mark(axes: Axes, modes: Array, wheels: Array) -> None:
    base = axes.get_xaxis_transform()
    axes.vlines(modes, 0.0, 0.05, colors="0.4", linewidth=0.6, transform=base)
    axes.vlines(wheels, 0.95, 1.0, colors=WHEEL, linewidth=0.9, transform=base)
