"""Where the wall time of a run went, and how late its paced ticks began: bars, of what run.toml says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockstep.run.real_time_pacing import time_text

from .drawing import STYLE, WIDTH
from .palette import BLUE, GREEN, ORANGE

_OTHERS = ("exchange", "recording", "waiting", "rest")
_ROW = 0.28  # inch of a bar


def profile_figure(record: Mapping[str, Any]) -> Figure:
    """Draw the record of a run: its parts on the left, the lateness of its ticks on the right if it was paced."""
    time, pace = record["time"], record.get("pace")
    parts = _parts(time)
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 1.2 + _ROW * max(len(parts), 10)), layout="constrained")
        axes = figure.subplots(1, 1 if pace is None else 2, squeeze=False)[0]
        _draw_parts(axes[0], parts, float(time["loop"]))
        axes[0].set_title(f"wall time of the loop: {time['loop']:.3g} s, {time['real_time_factor']:.3g} x real time")
        if pace is not None:
            _draw_lateness(axes[1], pace)
    return figure


def _parts(time: Mapping[str, Any]) -> list[tuple[str, float, str]]:
    """Return name, time [s] and colour of each part, those of components first."""
    steps = [(f"{one['name']} ({one['calls']} steps)", float(one.get("time", 0.0)), BLUE) for one in time["component"]]
    return steps + [(name, float(time[name]), ORANGE) for name in _OTHERS if name in time]


def _draw_parts(axes: Axes, parts: list[tuple[str, float, str]], wall: float) -> None:
    places = np.arange(len(parts))
    times = [time for _, time, _ in parts]
    axes.barh(places, times, color=[colour for _, _, colour in parts], height=0.7)
    axes.set_yticks(places, [name for name, _, _ in parts])
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set_xlabel("wall time [s]")
    for place, time in zip(places, times, strict=True):
        share = f" {100.0 * time / wall:.1f} %" if wall else ""
        axes.text(time, float(place), share, va="center", fontsize=7.0)
    axes.set_xlim(0.0, 1.15 * max([*times, 1e-9]))


def _draw_lateness(axes: Axes, pace: Mapping[str, Any]) -> None:
    """Draw the histogram of how late ticks began, on a logarithmic axis of their number."""
    edges, counts = list(pace["lateness_edges"]), list(pace["lateness_counts"])
    names = [f"to {time_text(edges[0])}", *map(time_text, edges[1:]), f"over {time_text(edges[-1])}"]
    places = np.arange(len(counts))
    axes.barh(places, counts, color=GREEN, height=0.7)
    axes.set_yticks(places, names)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set_xscale("symlog", linthresh=1.0)
    axes.set_xlabel("ticks")
    axes.set_ylabel("lateness, up to")
    worst = f"worst {1e3 * float(pace['worst_lateness']):.3g} ms late"
    axes.set_title(f"paced at {pace['factor']:g} x real time: {pace['overruns']} overruns, {worst}")
