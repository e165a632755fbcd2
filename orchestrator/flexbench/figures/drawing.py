"""Colours, sizes, envelopes of long histories, logarithmic axes and saving, common to all figures."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from io import BytesIO, StringIO
from itertools import pairwise
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogFormatterSciNotation, LogLocator, NullFormatter

from flexbench.studies.paper.published import ROWS
from flexsat.arrays import Array
from flexsat.parameters import ConfigurationName
from lockstep import InputError, Signals
from lockstep.whole_file import write_whole

from .palette import BLUE, GREEN, VERMILLION

Dashes = tuple[float, Sequence[float]]

WIDTH = 9.6  # inch: as wide as a page of a README, so that a point of type is about a point on the screen
MICROMETRE = 1e-6  # m
RESOLUTION = 150  # pixels an inch
BINS = 300  # of the rows of a long history, across a panel
DECADES = 5.0  # of a logarithmic axis, at most
RARE = 0.02  # share of the time that a line may lie below a logarithmic axis
SOLID: Dashes = (0.0, ())
DASHED: Dashes = (0.0, (4.0, 1.3))
STYLE: dict[Any, Any] = {  # any: the type of a key is the list of all of them
    "font.size": 8.5,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.labelsize": 8.5,
    "axes.grid": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "grid.color": "0.9",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.handlelength": 2.6,
    "mathtext.fontset": "dejavusans",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """Look of a configuration, distinguished by colour, lightness, width and dashes."""

    colour: str
    dashes: Dashes
    width: float  # the one drawn first is the wider, and shows under the other

    @property
    def line(self) -> dict[str, Any]:
        """The options of a line."""
        return {"color": self.colour, "linestyle": self.dashes, "linewidth": self.width}


LOOKS: dict[ConfigurationName, Look] = defaultdict(  # of the paper's layouts, and of any other spacecraft
    lambda: Look(colour=BLUE, dashes=SOLID, width=1.9),
    {
        "centralised": Look(colour=BLUE, dashes=SOLID, width=1.9),
        "distributed": Look(colour=VERMILLION, dashes=DASHED, width=1.1),
    },
)
PUBLISHED: dict[str, Any] = {
    "linestyle": (0.0, (1.0, 1.2)), "linewidth": 1.3, "marker": "D", "markersize": 4.2, "markerfacecolor": "white",
    "clip_on": False, "zorder": 4.0,
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisLook:
    """Look of what points along one body axis, distinguished by colour and marker."""

    colour: str
    marker: str


AXES: dict[str, AxisLook] = {
    "x": AxisLook(colour=VERMILLION, marker=">"),
    "y": AxisLook(colour=GREEN, marker="^"),
    "z": AxisLook(colour=BLUE, marker="o"),
}


def axis_name(axis: Array) -> str:
    """Return x, y or z: the body axis nearest to a unit vector."""
    return "xyz"[int(np.argmax(np.abs(axis)))]


def bin_edges(rows: int, bins: int = BINS) -> list[int]:
    """Return where to cut rows into bins of nearly the same size, none empty."""
    bins = min(bins, rows)
    return [rows * k // bins for k in range(bins + 1)]


def envelope(time: Array, values: Array, bins: int = BINS) -> tuple[Array, Array]:
    """Return fewer points, whose line covers the same area: the minimum and the maximum of each bin of rows.

    A series of no more than two points a bin comes back as it is. No peak is lost, and each point is one of the series.
    """
    if len(values) <= 2 * bins:
        return time, values
    keep = {0, len(values) - 1}
    for start, end in pairwise(bin_edges(len(values), bins)):
        part = values[start:end]
        keep |= {start + int(np.argmin(part)), start + int(np.argmax(part))}
    rows = sorted(keep)
    return time[rows], values[rows]


def draw_line(axes: Axes, time: Array, values: Array, label: str, line: dict[str, Any]) -> Line2D:
    """Draw a history as an envelope."""
    (drawn,) = axes.plot(*envelope(time, values), label=label, **line)
    return drawn


def draw_noisy(axes: Axes, time: Array, values: Array, label: str, line: dict[str, Any]) -> Line2D:
    """Draw a noisy norm: its RMS over each bin as a line, in a band from its minimum to its maximum there."""
    bins = [values[start:end] for start, end in pairwise(bin_edges(len(values)))]
    middle = np.array([0.5 * (time[start] + time[end - 1]) for start, end in pairwise(bin_edges(len(values)))])
    low, high = np.array([part.min() for part in bins]), np.array([part.max() for part in bins])
    axes.fill_between(middle, low, high, color=line["color"], alpha=0.2, linewidth=0.0)
    (drawn,) = axes.plot(middle, [np.sqrt(np.mean(part**2)) for part in bins], label=label, **line)
    return drawn


def draw_published(
    axes: Axes, scenario: str, key: str, name: ConfigurationName, times: Sequence[float], look: dict[str, Any]
) -> None:
    """Draw the paper's value of one metric, if it has one, in the unit of its table, at the times [s] it refers to.

    Parameters
    ----------
    axes : whose y axis is in that unit
    scenario, key, name : of the run, of the metric, of the configuration
    times : first and last, for a line between them; or one, for a mark
    look : options of the line, in addition to PUBLISHED
    """
    (row,) = [row for row in ROWS if (row.scenario, row.key) == (scenario, key)]
    if not np.isfinite(row.published_for(name)):
        return
    values = [row.published_for(name)] * len(times)
    axes.plot(times, values, label=f"published, {name}", **(PUBLISHED | look))


def span_runs(axes: Axes, results: Iterable[Signals]) -> None:
    """Set the time axis from 0 to the last row of the longest run."""
    end = max(run.time[-1] for run in results)
    if end > 0.0:  # not of a single row at the start
        axes.set_xlim(0.0, end)


def make_logarithmic(axes: Axes) -> None:
    """Make the y axis logarithmic, up to the peak, and down to what its lines exceed for all but 2 % of the time.

    A norm that is zero at the start, or dips to zero, must not stretch the axis. Lines that are zero throughout stay on
    a linear axis.
    """
    peak = axes.dataLim.y1
    if not peak > 0.0:
        return
    in_data = [drawn for drawn in axes.get_lines() if drawn.get_transform() == axes.transData]  # not marks on an axis
    lines = [np.asarray(drawn.get_ydata(), dtype=float) for drawn in in_data]
    least = min(float(np.quantile(values, RARE)) for values in lines)
    low = max(0.5 * least, peak * 10.0**-DECADES)
    axes.set_ylim(low, 1.3 * peak)  # before the scale: with it, limits are sought that a single point has not
    axes.set_yscale("log")
    few = np.log10(peak / low) < 2.0
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if few else (1.0,)))
    if few and low > 1e-3:
        axes.yaxis.set_major_formatter("{x:g}")
    elif few:
        axes.yaxis.set_major_formatter(LogFormatterSciNotation(minor_thresholds=(np.inf, np.inf)))  # label every tick
    axes.yaxis.set_minor_formatter(NullFormatter())


def write_figure(figure: Figure, path: Path) -> None:
    """Write a figure to one file, in the format of its name: .png or .svg; raise InputError if that cannot be."""
    _lay_out(figure)
    try:
        write_whole(path, _svg(figure, path.stem).encode() if path.suffix == ".svg" else _png(figure))
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); choose another folder") from None


def save_figure(figure: Figure, folder: Path, name: str) -> list[Path]:
    """Write `folder`/`name`.png and .svg, the same bytes for the same figure; return their paths."""
    _lay_out(figure)
    png, svg = folder / f"{name}.png", folder / f"{name}.svg"
    write_whole(png, _png(figure))
    write_whole(svg, _svg(figure, name).encode())
    return [png, svg]


def svg_text(figure: Figure, name: str) -> str:
    """Return a figure as SVG from its root element on, as a page takes it; the same text for the same figure."""
    _lay_out(figure)
    text = _svg(figure, name)
    return text[text.index("<svg") :]


def png_bytes(figure: Figure) -> bytes:
    """Return a figure as PNG, the same bytes for the same figure."""
    _lay_out(figure)
    return _png(figure)


def _lay_out(figure: Figure) -> None:
    """Place the parts of a figure, once for all its files: where an engine is left, each file is drawn twice."""
    engine = figure.get_layout_engine()
    if engine is None:
        return
    usual = figure.dpi
    figure.set_dpi(RESOLUTION)  # whole pixels of the text's height and width are those of the PNG
    engine.execute(figure)
    figure.set_dpi(usual)
    figure.set_layout_engine(None)


def _png(figure: Figure) -> bytes:
    drawn = BytesIO()
    figure.savefig(drawn, format="png", dpi=RESOLUTION, metadata={"Software": None})
    return drawn.getvalue()


def _svg(figure: Figure, name: str) -> str:
    drawn = StringIO()
    with matplotlib.rc_context({"svg.hashsalt": name}):  # else the ids inside are random
        figure.savefig(drawn, format="svg", metadata={"Date": None, "Creator": None})
    return drawn.getvalue()
