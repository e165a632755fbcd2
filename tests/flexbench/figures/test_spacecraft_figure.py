"""The figure of one spacecraft: envelopes at the limits of its wheels, an arrow a wheel, a mark a mode."""

import numpy as np
from matplotlib.colors import to_hex
from numpy.testing import assert_allclose

from flexbench.figures.drawing import write_figure
from flexbench.figures.palette import BLUE, VERMILLION
from flexbench.figures.spacecraft import spacecraft_figure
from flexbench.loop.properties import properties_of
from flexsat.description.spacecraft_file import parse_spacecraft

TEXT = """
name = "drawn"
wheels = [
  { at = "bus", axes = ["+x", "-y"] },
  { at = "top", kind = "small", axes = ["+z"] },
]
gyros = [{ at = "bus", axes = ["+x", "+y"] }]
accelerometers = [{ at = "bus", axes = ["+z"] }]
[sites]
top = { on_bus = [0, 0, 3] }
[modes]
plant = 12
design = 3
[wheel_kinds.small]
inertia = 0.5
torque_limit = 0.25
speed_band = 2.0
"""


def test_wheels_envelopes_and_modes(tmp_path):
    found = properties_of(parse_spacecraft(TEXT, "drawn.toml"), "drawn.toml")
    figure = spacecraft_figure(found)
    above, side, torque, momentum, masses, reach = figure.axes

    for axes in (above, side):
        (arrows,) = (one for one in axes.collections if hasattr(one, "U"))
        assert len(arrows.U) == 3
    assert {text.get_text() for text in side.texts} == {"1", "2", "3"}
    # wheels along body axes: the cut of a box, +-0.8 along x and y, +-0.25 along z
    for axes, limits in ((torque, [0.8, 0.8, 0.25]), (momentum, [0.84 * 2.617993877991494] * 2 + [1.0])):
        assert len(axes.lines) == 3
        for line in axes.lines:
            first, second = (("xyz".index(word[0])) for word in line.get_label().split(", "))
            most = np.abs(line.get_xydata()).max(axis=0)
            assert_allclose(most, [limits[first], limits[second]], rtol=1e-12)
    wheels = next(line for line in reach.lines if to_hex(line.get_color()) == VERMILLION.lower())
    gyros = next(line for line in reach.lines if to_hex(line.get_color()) == BLUE.lower())
    assert 0 < len(wheels.get_xdata()) == np.count_nonzero(found.modes.controllability > 1e-9)
    assert_allclose(gyros.get_xdata()[0], found.modes.free[found.modes.observability > 1e-9][0] / (2.0 * np.pi))
    drawn = sum(len(one.get_segments()) for one in masses.collections)
    assert drawn == np.count_nonzero(found.modes.effective_mass > 1e-9) + np.count_nonzero(
        found.modes.effective_inertia > 1e-9
    )
    for name, begin in (("one.png", b"\x89PNG"), ("one.svg", b"<?xml")):
        write_figure(figure, tmp_path / name)
        assert (tmp_path / name).read_bytes().startswith(begin)
