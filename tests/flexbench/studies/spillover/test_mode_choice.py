"""The lowest modes, or those most coupled to rigid motion: both designs on the real structure."""

import pytest

from flexbench.studies.spillover.mode_choice import GAINS, HEADER, compare_mode_choices
from flexsat.parameters import ARCSECOND


def test_both_choices_hold_and_point_alike_centralised():
    """The filter hardly trusts its modes; the strongest coupled 25 reach up to mode 162, at 60 Hz (PHYSICS 9)."""
    lowest, coupled = compare_mode_choices(["centralised"], ["robust"], modes=60)
    assert (lowest.modes_by, coupled.modes_by) == ("frequency", "coupling")
    assert lowest.highest == pytest.approx(6.69, abs=0.01)
    assert coupled.highest == pytest.approx(60.2, abs=0.1)
    for choice in (lowest, coupled):
        assert choice.stable_gains == GAINS
        assert len(choice.row) == len(HEADER)
        assert choice.settled.pointing / ARCSECOND == pytest.approx(0.0189, abs=0.0003)
        assert 1e6 * choice.settled.deformation == pytest.approx(0.123, abs=0.001)
