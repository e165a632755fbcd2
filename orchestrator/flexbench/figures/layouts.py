"""Distributed wheels against centralised ones: the ratio of every number, of each pair and with its interval."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from flexbench.studies.layouts.plan import Comparison
from flexbench.studies.layouts.tables import PERCENT, ComparisonRow, having

from .drawing import LOOKS, STYLE, WIDTH

ROOM = 0.36  # inch a quantity
OPEN = "0.45"  # colour of a quantity without a difference shown
LARGEST = 30.0  # factor: what reaches beyond it is cut


def layouts_figure(comparison: Comparison, rows: Sequence[ComparisonRow]) -> Figure:
    """Draw the ratio of the second layout to the first of each quantity; colour says which layout has the lower value.

    A quantity that is compared by its difference, or has no pair, is not drawn.
    """
    first, second = comparison.plan.layouts
    looks = {first: LOOKS["centralised"], second: LOOKS["distributed"]}
    drawn = [row for row in rows if row.is_ratio and row.contrast is not None]
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 1.3 + ROOM * max(1, len(drawn))), layout="constrained")
        axes = figure.subplots()
        axes.axvline(1.0, color="black", linewidth=0.8)
        for place, row in enumerate(drawn):
            assert row.contrast is not None
            colour = OPEN if row.better is None else looks[row.better].colour
            pairs = pair_ratios(comparison, row)
            axes.plot(pairs, np.full(len(pairs), place + 0.25), linestyle="none", marker="o", markersize=3.5,
                      markerfacecolor="none", markeredgecolor=colour, alpha=0.6)  # fmt: skip
            if not np.isnan(row.contrast.low):
                axes.plot([row.contrast.low, row.contrast.high], [place, place], color=colour, linewidth=3.0,
                          solid_capstyle="butt")  # fmt: skip
            axes.plot(row.contrast.value, place, linestyle="none", marker="|", markersize=13.0, markeredgewidth=2.0,
                      color=colour)  # fmt: skip
        axes.set_yticks(range(len(drawn)), [row.quantity.label for row in drawn])
        axes.set_ylim(len(drawn) - 0.4, -0.6)
        low, high = axes.dataLim.x0, axes.dataLim.x1
        limits = max(0.9 * low, 1.0 / LARGEST), min(1.1 * high, LARGEST)
        axes.set(xscale="log", xlabel=f"{second} / {first} [1]", xlim=limits)
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
        for name in (second, first):
            axes.plot([], [], color=looks[name].colour, linewidth=3.0, label=f"lower with {having(name)}")
        axes.plot([], [], color=OPEN, linewidth=3.0, label="no difference shown")
        axes.plot([], [], linestyle="none", marker="o", markersize=3.5, markerfacecolor="none", markeredgecolor=OPEN,
                  label="a pair")  # fmt: skip
        axes.set_title(f"Ratio over {len(comparison.plan.seeds)} pairs: geometric mean and its {PERCENT} interval")
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def pair_ratios(comparison: Comparison, row: ComparisonRow) -> list[float]:
    """Return the ratio of each pair of runs that are not lost."""
    first, second = (comparison.of(name, row.quantity.scenario) for name in comparison.plan.layouts)
    found = []
    for seed, one in first.items():
        before, after = one.numbers.get(row.quantity.key), second[seed].numbers.get(row.quantity.key)
        if before is not None and after is not None:
            found.append(after / before)
    return found
