"""Shade the times of faults in a figure over time."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from matplotlib.figure import Figure

from lockstep.faults.windows import FaultWindow

from .palette import PURPLE

SHADE: dict[str, Any] = {"color": PURPLE, "alpha": 0.18, "linewidth": 0.0, "zorder": 0.5}


def shade_faults(figure: Figure, windows: Iterable[FaultWindow]) -> Figure:
    """Shade each window in every panel that shows some of it, and name the faults in the first of these panels.

    The panels' axes must show time [s]; their limits stay as they are.
    """
    named = 0
    for window in dict.fromkeys((w.name, w.begin, w.end) for w in windows):
        name, begin, end = window
        labelled = False
        for axes in figure.axes:
            left, right = axes.get_xlim()
            start, stop = max(begin, left), right if end is None else min(end, right)
            if start >= stop:
                continue
            axes.axvspan(start, stop, **SHADE)
            axes.set_xlim(left, right)
            if not labelled:
                axes.annotate(name, (start, 1.0), xycoords=("data", "axes fraction"), xytext=(2.0, -8.0 - 9.0 * named),
                              textcoords="offset points", fontsize=6.5, color="0.3", clip_on=True)  # fmt: skip
                labelled, named = True, named + 1
    return figure
