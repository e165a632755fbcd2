"""What the tables of margins say beside the numbers."""

import pytest

from flexbench.studies.margins.tables import explanation

NONE = {"gain_down": 0.0, "gain_up": None, "phase": None, "delay": None, "disk": None}
NOWHERE = {f"{name}_at": None for name in NONE}
FOUND = {**NONE, **NOWHERE, "gain_up": 9.0, "gain_up_at": 1.4, "phase": 39.0, "phase_at": 0.0214}
SETTINGS = {"periods": 4, "length": 20.0, "settle": 2, "quiet": False}


@pytest.mark.parametrize(
    ("lowest", "says"),
    [
        (0.05, "The design has margins from 0.0214 Hz on, below the lowest measured line, 0.05 Hz: the measured "
               "margins lack them; --length 190 measures there too."),
        (0.02, ""),
    ],
)  # fmt: skip
def test_margins_of_the_design_below_the_lowest_measured_line_are_named(lowest, says):
    content = {
        "seed": 1,
        "analysis": {"margins": {"x": FOUND, "y": {**NONE, **NOWHERE}}},
        "measured": {"frequency": [lowest, 1.0, 10.0], "settings": SETTINGS, "margins": {}},
    }
    text = explanation(content)
    assert says in text
    assert ("below the lowest" in text) == bool(says)
    assert "below the lowest" not in explanation({**content, "analysis": {}})
