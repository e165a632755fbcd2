"""What the tests of figures share: finding words that overlap, or that the edge of the picture cuts."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

import pytest
from matplotlib.axis import Tick
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

TOUCH = 1.0  # pixel by which boxes of words may overlap: a box is a little larger than its ink


def _words(figure: Figure) -> list[tuple[str, Bbox]]:
    """Return every visible text of a drawn figure and where it stands, in pixels."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    found = []
    undrawn = _ticks(figure, drawn=False) - _ticks(figure, drawn=True)  # ticks beyond the limits keep their words
    for text in figure.findobj(lambda artist: isinstance(artist, Text) and artist not in undrawn):
        shown = text.get_visible() and (text.axes is None or text.axes.get_visible())
        if shown and text.get_text().strip() and text.get_alpha() != 0.0:
            found.append((text.get_text(), text.get_window_extent(renderer)))
    return found


def _ticks(figure: Figure, *, drawn: bool) -> set[object]:
    axis = [one for axes in figure.axes if axes.axison or not drawn for one in (axes.xaxis, axes.yaxis)]
    ticks = [tick for one in axis for tick in (one._update_ticks() if drawn else one.findobj(Tick))]
    return {label for tick in ticks for label in (tick.label1, tick.label2)}


@pytest.fixture(scope="session")
def crowded() -> Callable[[Figure], list[str]]:
    """Return a function that lists overlapping pairs of words in a figure, and words that its edge cuts."""

    def look(figure: Figure) -> list[str]:
        words, complaints = _words(figure), []
        width, height = figure.get_size_inches() * figure.dpi
        for text, box in words:
            if box.x0 < -TOUCH or box.y0 < -TOUCH or box.x1 > width + TOUCH or box.y1 > height + TOUCH:
                complaints.append(f"cut: {text!r}")
        for (one, first), (other, second) in combinations(words, 2):
            shared = Bbox.intersection(first, second)
            if shared is not None and min(shared.width, shared.height) > TOUCH:
                complaints.append(f"overlap: {one!r} and {other!r}")
        return complaints

    return look
