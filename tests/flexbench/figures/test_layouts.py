"""The figure of the layouts: ratios of pairs, their mean and interval, and who has the lower value."""

import numpy as np
from numpy.testing import assert_allclose

from flexbench.figures.drawing import LOOKS
from flexbench.figures.layouts import OPEN, layouts_figure
from flexbench.studies.layouts.tables import compare

VALUES = (1.0, 2.0, 4.0, 3.0)


def drawn(comparison):
    """Return axes, and the lines of its first quantity: pairs, interval, mean."""
    (axes,) = layouts_figure(comparison, compare(comparison)).axes
    _, pairs, interval, mean, *_ = axes.get_lines()
    return axes, pairs, interval, mean


def test_pairs_means_and_intervals_are_drawn_in_the_colour_of_the_better_layout(compare_made):
    factors = np.array([0.4, 0.5, 0.6, 0.45])
    given = dict(enumerate((factors * VALUES).tolist(), start=1))
    comparison = compare_made(VALUES, distributed=given)
    axes, pairs, interval, mean = drawn(comparison)
    row = compare(comparison)[0]

    assert_allclose(pairs.get_xdata(), factors, rtol=1e-12)
    assert_allclose(interval.get_xdata(), [row.contrast.low, row.contrast.high])
    assert mean.get_xdata()[0] == row.contrast.value
    assert interval.get_color() == LOOKS["distributed"].colour
    assert axes.get_xscale() == "log"
    names = [text.get_text() for text in axes.get_yticklabels()]
    assert names[0] == "pointing error in fine pointing"
    assert len(names) == 8  # settling is a difference

    assert drawn(compare_made(VALUES, 2.0))[2].get_color() == LOOKS["centralised"].colour
    assert drawn(compare_made(VALUES, distributed={1: 2.0, 2: 1.0}))[2].get_color() == OPEN


def test_words_do_not_overlap(compare_made, crowded):
    wide = compare_made(VALUES, distributed={1: 1e-4, 2: 50.0})  # an interval far beyond what is shown
    for comparison in (compare_made(VALUES, 0.6), wide):
        figure = layouts_figure(comparison, compare(comparison))
        assert crowded(figure) == []
    assert wide is not None
    assert figure.axes[0].get_xlim()[1] <= 30.0


def test_lost_runs_have_no_mark(compare_made):
    comparison = compare_made(VALUES, lost={("centralised", 3): "diverged"})
    assert len(drawn(comparison)[1].get_xdata()) == 3
    none = compare_made(VALUES, lost={("centralised", seed): "diverged" for seed in range(1, 5)})
    (axes,) = layouts_figure(none, compare(none)).axes
    assert [text.get_text() for text in axes.get_yticklabels()] == []
