"""The figure of the wheels' responses against the design."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.testing import assert_allclose

from flexbench.figures.drawing import AXES, axis_name
from flexbench.figures.figure_lists import design_figures
from flexbench.figures.wheels import equal_wheels
from flexsat.description.built_in import CONFIGURATIONS
from flexsat.parameters import RPM, ConfigurationName

HERTZ = 2.0 * np.pi


@pytest.fixture(scope="module")
def responses(built: Any) -> dict[ConfigurationName, Figure]:
    drawn = design_figures(built)
    return {name: drawn[f"wheel-responses-{name}"]() for name in CONFIGURATIONS}


@pytest.mark.parametrize(("name", "panels"), [("centralised", 2), ("distributed", 13)])
def test_wheel_responses_show_every_wheel_once(responses: Any, designs: Any, name: ConfigurationName, panels: int):
    groups = equal_wheels(designs[name])
    assert len(groups) == panels
    assert sorted(wheel for group in groups for wheel in group) == list(range(designs[name].spacecraft.wheel_count))
    shown = [axes for axes in responses[name].axes if axes.get_visible()]
    numbers = ", ".join(axes.get_title("left").split("\n")[1].split(" ", 1)[1] for axes in shown)
    assert sorted(map(int, numbers.split(", "))) == list(range(1, designs[name].spacecraft.wheel_count + 1))


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_wheel_responses_draw_response_maximum_choice_and_band(
    responses: Any, designs: Any, name: ConfigurationName, points: Any, legend: Any
):
    result, craft = designs[name].response, designs[name].spacecraft
    shown = [axes for axes in responses[name].axes if axes.get_visible()]
    for axes, group in zip(shown, equal_wheels(designs[name]), strict=True):
        wheel, nominal = group[0], result.nominal[group[0]] / RPM
        drawn, worst = points(axes, "response"), points(axes, "worst")
        assert_allclose(drawn[:, 0], result.speed / RPM, rtol=1e-12)
        assert_allclose(drawn[:, 1], result.response[wheel] * HERTZ**2, rtol=1e-12)
        assert_allclose(worst[:, 1], result.worst[wheel] * HERTZ**2, rtol=1e-12)
        (band,) = [patch for patch in axes.patches if isinstance(patch, Rectangle)]
        assert_allclose((band.get_x(), band.get_width()), (nominal - 25.0, 50.0), rtol=1e-9)
        upright = [line for line in axes.get_lines() if len(np.asarray(line.get_xdata())) == 2]
        assert [float(np.asarray(line.get_xdata())[0]) for line in upright] == [nominal]
        # the choice is the least of the maximum, where the band lies inside the range
        inside = (worst[:, 0] >= worst[0, 0] + 22.0) & (worst[:, 0] <= worst[-1, 0] - 22.0)
        at = np.argmin(np.abs(worst[:, 0] - nominal))
        assert worst[at, 1] == worst[inside, 1].min()
        assert f"{nominal:.0f} rpm" in axes.get_title("left")
        assert axes.get_xscale() == axes.get_yscale() == "log"
        line = next(line for line in axes.get_lines() if line.get_label() == "worst")
        assert line.get_color() == AXES[axis_name(craft.wheels.axis[wheel])].colour
    assert responses[name].get_supxlabel() == "wheel speed [rpm]"
    assert "[m·kg$^{1/2}$/s]" in responses[name].get_supylabel()
    assert legend(responses[name])[1:] == [
        "its maximum over 50 rpm",
        "chosen speed: minimum of that maximum",
        "allowed: ±25 rpm",
    ]


def test_wheel_responses_are_legible_and_saved(responses: Any, crowded: Any, check_saved: Any):
    assert crowded(responses["centralised"]) == []
    check_saved(responses["distributed"], "wheel-responses-distributed")
