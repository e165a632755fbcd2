"""What figures over time show of faults."""

from dataclasses import replace

from matplotlib.figure import Figure

from flexbench.figures.faults import shade_faults
from lockstep.faults.windows import FaultWindow

OUTAGE = FaultWindow(name="outage", kind="dropout", component="controller", variables=("u",), begin=2.0, end=4.0)


def spans(axes):
    return [tuple(round(x, 9) for x in patch.get_extents().transformed(axes.transData.inverted()).intervalx)
            for patch in axes.patches]  # fmt: skip


def test_windows_are_shaded_where_a_panel_shows_them_and_named_once():
    figure = Figure()
    whole, late = figure.subplots(1, 2)
    whole.set_xlim(0.0, 10.0)
    late.set_xlim(9.0, 10.0)
    seized = replace(OUTAGE, name="wheel 1 seizes", begin=3.0, end=None)
    shade_faults(figure, [OUTAGE, replace(OUTAGE, component="other"), seized])

    assert spans(whole) == [(2.0, 4.0), (3.0, 10.0)]  # one fault on two components is shaded once
    assert spans(late) == [(9.0, 10.0)]
    assert [text.get_text() for text in whole.texts] == ["outage", "wheel 1 seizes"]
    assert list(late.texts) == []
    assert (whole.get_xlim(), late.get_xlim()) == ((0.0, 10.0), (9.0, 10.0))
